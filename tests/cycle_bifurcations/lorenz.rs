//! Lorenz' equations: the symmetric cycle at large rho, what it loses its symmetry to, and the homoclinic end.

use super::common::lorenz::Lorenz;
use super::common::{close, near};
use super::{Branch, fixed};
use hopfline::continuation::Counts;
use hopfline::orbit::bifurcations::{CycleNormalForm, Departure, Event, Passed};
use hopfline::orbit::{Frame, Orbit, Points, Scheme};
use hopfline::problem::Reflection;

/// A step of the classical Runge-Kutta method.
fn runge_kutta(f: &dyn Fn(&[f64]) -> Vec<f64>, u: &[f64], h: f64) -> Vec<f64> {
    let ahead = |k: &[f64], c: f64| -> Vec<f64> { u.iter().zip(k).map(|(u, k)| u + c * h * k).collect() };
    let a = f(u);
    let b = f(&ahead(&a, 0.5));
    let c = f(&ahead(&b, 0.5));
    let d = f(&ahead(&c, 1.0));
    (0..u.len()).map(|i| u[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i])).collect()
}

/// Lorenz' symmetric cycle at a large rho, over half its period, from a simulation.
pub fn symmetric_cycle(rho: f64, intervals: usize) -> (Frame, Orbit) {
    let f = |u: &[f64]| vec![10.0 * (u[1] - u[0]), rho * u[0] - u[1] - u[0] * u[2], u[0] * u[1] - 8.0 / 3.0 * u[2]];
    let h = 2e-5;
    let mut u = vec![1.0, 2.0, rho];
    for _ in 0..3_000_000 {
        u = runge_kutta(&f, &u, h);
    }
    // From one passage of x = 0 to the next one, the other way.
    while !(u[0] < 0.0 && runge_kutta(&f, &u, h)[0] >= 0.0) {
        u = runge_kutta(&f, &u, h);
    }
    let mut samples = vec![u.clone()];
    while !(u[0] >= 0.0 && runge_kutta(&f, &u, h)[0] < 0.0) {
        u = runge_kutta(&f, &u, h);
        samples.push(u.clone());
    }
    let degree = 4;
    let scheme = Scheme::new(Points::Gauss, degree);
    let part = (samples.len() - 1) as f64 * h;
    let mut nodes = Vec::new();
    for j in 0..intervals {
        for x in &scheme.nodes[..degree] {
            let t = (j as f64 + x) / intervals as f64;
            nodes.extend_from_slice(&samples[(t * (samples.len() - 1) as f64) as usize]);
        }
    }
    nodes.extend([-nodes[0], -nodes[1], nodes[2]]);
    let mesh = (0..=intervals).map(|j| j as f64 / intervals as f64).collect();
    let orbit = Orbit { mesh, points: Points::Gauss, degree, nodes, dim: 3, part, parts: 2, drift: Vec::new() };
    let problem = Lorenz::problem();
    let frame = Frame {
        symmetry: problem.reflection().expect("a reflection"),
        problem,
        p: vec![rho, 10.0, 8.0 / 3.0],
        free: 0,
        parts: 2,
        scale_state: 50.0,
        scale_part: part,
        scale_lambda: 100.0,
    };
    (frame, orbit)
}

/// The whole period of a half-period orbit.
fn whole(frame: &Frame, orbit: &Orbit) -> (Frame, Orbit) {
    let (n, count) = (orbit.dim, orbit.nodes.len() / orbit.dim);
    let mut nodes = orbit.nodes.clone();
    let mut image = vec![0.0; n];
    for k in 1..count {
        frame.symmetry.apply(orbit.node(k), &mut image);
        nodes.extend_from_slice(&image);
    }
    let half: Vec<f64> = orbit.mesh.iter().map(|t| 0.5 * t).collect();
    let mesh = half.iter().copied().chain(half[1..].iter().map(|t| 0.5 + t)).collect();
    let orbit = Orbit { mesh, nodes, part: 2.0 * orbit.part, parts: 1, ..orbit.clone() };
    let scale_part = 2.0 * frame.scale_part;
    (Frame { symmetry: Reflection::identity(n), parts: 1, scale_part, ..frame.clone() }, orbit)
}

/// From peers.md of AUTO-07p: period doublings from rho = 280 down, to all digits given.
const DOUBLINGS: [(f64, f64); 3] = [(229.4067086, 5e-8), (218.2101278, 5e-8), (215.9659, 5e-5)];

#[test]
fn the_symmetry_breaks_and_the_period_doubles() {
    let (frame, orbit) = symmetric_cycle(350.0, 20);
    let (system, start) = fixed(&frame, &orbit, 350.0);
    let followed = Branch::new(system, start).follow((200.0, 400.0), 1);
    let breaking = &followed.found[0].1;
    assert_eq!(breaking.event, Event::Flip);
    // The same point as a branch point of the whole period, by another system of equations.
    let (full, whole) = whole(&frame, &orbit);
    let (system, start) = fixed(&full, &whole, 350.0);
    let followed = Branch::new(system, start).follow((200.0, 400.0), 1);
    let (full_system, crossing) = &followed.found[0];
    assert_eq!(crossing.event, Event::Branch);
    close("rho", crossing.point.lambda, breaking.point.lambda, 1e-9);
    close("T", *crossing.point.x.last().unwrap(), 2.0 * breaking.point.x.last().unwrap(), 1e-9);
    let branch = crossing.branch.as_ref().expect("a branch point");
    near("unfolding", branch.unfolding, 0.0, 1e-9);

    let (cycle, x) = breaking.critical.as_ref().expect("a critical cycle");
    let form = CycleNormalForm::new(cycle, x).expect("a normal form");
    let mut counts = Counts::default();
    let mut next = Departure::flip((cycle, x), 0.02, &mut counts).expect("the other branch");
    // The same branch from the branch point's other tangent.
    let other = branch.other.as_ref().expect("another tangent");
    let same = Departure::along(full_system.clone(), other, 0.02, &mut counts).expect("the other branch");
    close("the other branch", same.corrected.point.lambda, next.corrected.point.lambda, 1e-9);
    assert!(form.coefficient.re < 0.0 && next.corrected.point.lambda < breaking.point.lambda);
    for (rho, tolerance) in DOUBLINGS {
        let followed = Branch::new(next.system, next.corrected).follow((200.0, 400.0), 1);
        let located = &followed.found[0].1;
        assert_eq!(located.event, Event::Flip);
        near("rho", located.point.lambda, rho, tolerance);
        let (cycle, x) = located.critical.as_ref().expect("a critical cycle");
        // Supercritical: the doubled cycle is where the old one is unstable, at smaller rho.
        let form = CycleNormalForm::new(cycle, x).expect("a normal form");
        next = Departure::flip((cycle, x), 0.02, &mut counts).expect("the doubled cycle");
        assert!(form.coefficient.re < 0.0 && next.corrected.point.lambda < located.point.lambda);
    }
}

#[test]
fn the_branch_from_the_hopf_point_ends_at_a_homoclinic_orbit() {
    let problem = Lorenz::problem();
    let hopf = Lorenz::hopf(&problem);
    let mut branch = Branch::of_hopf(&problem, &hopf, 0.05, 10.0, (60, 4, Points::Gauss));
    branch.control.most = 0.2;
    let followed = branch.follow((10.0, 30.0), 10);
    let end = followed.homoclinic.expect("a homoclinic end");
    near("rho", end.lambda, 13.926557, 5e-7);
    // The state of rest, whose slow stable rate is beta.
    let Passed::Saddle { rate, own, saddles: 1 } = end.passed else { panic!("{:?}", end.passed) };
    close("its rate", own.expect("a saddle"), 8.0 / 3.0, 1e-9);
    // The stable rate beta is smaller than the unstable one.
    close("rate", rate, 8.0 / 3.0, 1e-2);
}
