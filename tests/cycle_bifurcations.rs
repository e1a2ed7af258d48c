//! Bifurcations of cycles against published and exact values.

mod common;

use common::{close, near, parameter};
use hopfline::continuation::{Border, Corrected, Counts, Point, StepControl, Stop, System, Walk, correct};
use hopfline::bifurcation::Coordinate;
use hopfline::orbit::bifurcations::{Critical, CriticalCycle, CycleNormalForm, Departure, Event, Located, Segment, Signs};
use hopfline::orbit::{Collocation, Frame, Orbit, OrbitFactors, Points, Scheme};
use hopfline::problem::{Automatic, Formula, Parameter, Problem, Reflection, Scalar};
use std::f64::consts::TAU;
use std::sync::Arc;

/// `x' = sigma (y - x), y' = rho x - y - x z, z' = x y - beta z`; free: rho.
struct Lorenz(Vec<Parameter>);

impl Formula for Lorenz {
    fn dim(&self) -> usize {
        3
    }

    fn parameters(&self) -> &[Parameter] {
        &self.0
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        g[0] = v[0] - (u[1] - u[0]) * p[1];
        g[1] = v[1] - (p[0] * u[0] - u[1] - u[0] * u[2]);
        g[2] = v[2] - (u[0] * u[1] - u[2] * p[2]);
    }

    fn reflection(&self) -> Option<Reflection> {
        Some(Reflection { source: vec![0, 1, 2], sign: vec![-1.0, -1.0, 1.0] })
    }
}

fn lorenz(rho: f64) -> Arc<dyn Problem> {
    let list = vec![parameter("rho", rho), parameter("sigma", 10.0), parameter("beta", 8.0 / 3.0)];
    Arc::new(Automatic(Lorenz(list)))
}

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
fn symmetric_cycle(rho: f64, intervals: usize) -> (Frame, Orbit) {
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
    let orbit = Orbit { mesh, points: Points::Gauss, degree, nodes, dim: 3, part, parts: 2 };
    let problem = lorenz(rho);
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

/// Newton's method with lambda fixed.
fn fixed(frame: &Frame, orbit: &Orbit, lambda: f64) -> (Collocation, Corrected<OrbitFactors>) {
    let system = Collocation::new(frame.clone(), orbit);
    let x = Collocation::unknowns(orbit);
    let border = Border { row: vec![0.0; x.len()], lambda: -1.0 };
    let corrected = correct(&system, (x, lambda), &border, &mut Counts::default()).expect("an orbit");
    (system, corrected)
}

/// Follows a branch until `found` says stop; what was located on the way, with the system there.
fn follow(
    mut system: Collocation,
    start: Corrected<OrbitFactors>,
    (low, high): (f64, f64),
    most: usize,
    wanted: usize,
) -> (Vec<(Collocation, Located)>, Option<Stop>) {
    let mut signs = Signs::new(&start.point, &start.factors).expect("signs");
    let control = StepControl { step: 0.02, least: 1e-8, most: 0.1 };
    let width = system.frame.scale_lambda;
    let mut walk = Walk::new(&mut system, start.point, control, (low, high));
    let mut found = Vec::new();
    for _ in 0..most {
        let step = match walk.step() {
            Ok(step) => step,
            Err(stop) => return (found, Some(stop)),
        };
        let next = Signs::new(&step.to, &step.factors).expect("signs");
        for event in signs.events(&next) {
            let segment =
                Segment { system: &*walk.system, from: &step.from, to: &step.to, signs: [&signs, &next], width };
            let mut counts = Counts::default();
            match segment.locate(event, &mut counts).expect("a search") {
                Some(located) => {
                    println!("{event:?} at {:.12} {counts:?} T {:.10}", located.point.lambda, located.point.x.last().unwrap());
                    found.push((walk.system.clone(), located));
                }
                None => println!("{event:?} is none between {} and {}", step.from.lambda, step.to.lambda),
            }
        }
        if found.len() >= wanted {
            return (found, None);
        }
        signs = next;
        if step.stop.is_some() {
            return (found, step.stop);
        }
    }
    (found, None)
}

/// A cycle of radius 1 in the plane (x, y) whose normal form is known, with everything around it in the coordinates
/// `r = 1 + rho`, s, w:
///
/// ```text
/// flip    dA/dt = mu A + c A³ + m A w,   dB/dt = -B,   (rho, s) = A e(phi/2) + B e'(phi/2),   w' = -w + q A²,
/// torus   Z = rho + i s,   dZ/dt = (mu + i omega) Z + (c + i) Z |Z|² + m Z w,   w' = -w + q |Z|²,
/// fold    drho/dt = mu + c rho²,   s' = -s,   w' = -w + q rho²,   dphi/dt = 1 - 0.4 rho,
/// ```
///
/// with `dphi/dt = 1 + k (squared amplitude)`. On the centre manifold w = q A² + ..., so that the cubic coefficients are
/// c + m q. With `mass` the equations are multiplied by a matrix that depends on the state.
struct Exact {
    kind: Critical,
    mass: bool,
    list: Vec<Parameter>,
}

const C: f64 = -0.7;
const M: f64 = 0.9;
const Q: f64 = 0.6;
const K: f64 = 0.3;
const OMEGA: f64 = 0.37;

impl Formula for Exact {
    fn dim(&self) -> usize {
        4
    }

    fn parameters(&self) -> &[Parameter] {
        &self.list
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let (x, y, s, w, mu) = (u[0], u[1], u[2], u[3], p[0]);
        let r = (x * x + y * y).sqrt();
        let (cosine, sine, rho) = (x / r, y / r, r - 1.0);
        let (turning, rho_rate, s_rate, square);
        match self.kind {
            Critical::Flip => {
                // The part of (rho, s) along e(phi/2).
                let a_rho = (rho * (cosine + 1.0) + s * sine) * 0.5;
                let a_s = (rho * sine + s * (-cosine + 1.0)) * 0.5;
                square = a_rho * a_rho + a_s * a_s;
                turning = square * K + 1.0;
                let growth = mu + square * C + w * M + 1.0;
                // e(phi/2) turns at half the rate.
                rho_rate = a_rho * growth - rho - s * turning * 0.5;
                s_rate = a_s * growth - s + rho * turning * 0.5;
            }
            Critical::Torus => {
                square = rho * rho + s * s;
                turning = square * K + 1.0;
                let growth = mu + square * C + w * M;
                rho_rate = rho * growth - s * (square + OMEGA);
                s_rate = s * growth + rho * (square + OMEGA);
            }
            Critical::Fold => {
                square = rho * rho;
                turning = -rho * 0.4 + 1.0;
                (rho_rate, s_rate) = (mu + square * C, -s);
            }
        }
        let rates = [rho_rate * cosine - y * turning, rho_rate * sine + x * turning, s_rate, square * Q - w];
        for i in 0..4 {
            g[i] = v[i] - rates[i];
        }
        if self.mass {
            let [a, b, c, d] = [g[0], g[1], g[2], g[3]];
            (g[0], g[1]) = (a * (x * x + 2.0) + b * y.sin(), b * (x * 0.3).exp() - d * s);
            (g[2], g[3]) = (c + a * x * 0.5, d + c * y * 0.4);
        }
    }
}

/// The unit circle at mu = `mu`, with the multipliers that its equations have.
fn exact(kind: Critical, mass: bool, mu: f64) -> (Frame, Orbit) {
    let problem: Arc<dyn Problem> = Arc::new(Automatic(Exact { kind, mass, list: vec![parameter("mu", mu)] }));
    let (intervals, degree, points) = (16, 6, Points::Gauss);
    let scheme = Scheme::new(points, degree);
    let mut nodes = Vec::new();
    for i in 0..=intervals * degree {
        let phi = TAU * ((i / degree) as f64 + scheme.nodes[i % degree]) / intervals as f64;
        nodes.extend([phi.cos(), phi.sin(), 0.0, 0.0]);
    }
    let mesh = (0..=intervals).map(|j| j as f64 / intervals as f64).collect();
    let orbit = Orbit { mesh, points, degree, nodes, dim: 4, part: TAU, parts: 1 };
    let symmetry = Reflection::identity(4);
    let (scale_state, scale_part, scale_lambda) = (1.0, TAU, 1.0);
    (Frame { problem, p: vec![mu], free: 0, symmetry, parts: 1, scale_state, scale_part, scale_lambda }, orbit)
}

#[test]
fn normal_forms_are_exact_whatever_the_mass() {
    for (kind, expected) in
        [(Critical::Flip, C + M * Q), (Critical::Torus, 2.0 * (C + M * Q)), (Critical::Fold, C)]
    {
        for mass in [false, true] {
            let (frame, orbit) = exact(kind, mass, 0.01);
            let system = Collocation::new(frame, &orbit);
            let coordinate = Coordinate { index: 0, logarithmic: false, width: 1.0 };
            let cosine = (TAU * OMEGA + 0.01).cos();
            let (cycle, x) =
                CriticalCycle::new(&system, (&orbit, &[0.01]), (kind, cosine), &[coordinate]).expect("borders");
            let x = cycle.solve(x, &mut Counts::default()).expect("a critical cycle");
            near("mu", cycle.parameters(&x)[0], 0.0, 1e-10);
            close("T", cycle.orbit(&x).part, TAU, 1e-10);
            if kind == Critical::Torus {
                near("cos(theta)", cycle.cosine(&x).expect("an angle"), (TAU * OMEGA).cos(), 1e-9);
            }
            let form = CycleNormalForm::new(&cycle, &x).expect("a normal form");
            println!("{kind:?} {mass} {} {expected}", form.coefficient);
            // v points to longer periods, and those are at larger rho.
            close("coefficient", form.coefficient.re, expected, 1e-8);
        }
    }
}

#[test]
fn lorenz_breaks_its_symmetry_and_doubles_its_period() {
    let (frame, orbit) = symmetric_cycle(350.0, 20);
    let (system, start) = fixed(&frame, &orbit, 350.0);
    println!("T = {}", 2.0 * system.orbit(&start.point.x).part);
    let (found, stop) = follow(system, start, (200.0, 400.0), 100, 1);
    println!("{stop:?}");
    let (_, breaking) = &found[0];
    assert_eq!(breaking.event, Event::Flip);
    let (cycle, x) = breaking.critical.as_ref().expect("a critical cycle");
    let mut counts = Counts::default();
    let mut next = Departure::flip((cycle, x), 0.02, &mut counts).expect("the other branch");
    println!("{counts:?} {} ", next.corrected.point.lambda);
    for (k, rho) in [229.4067086, 218.2101278, 215.9659].into_iter().enumerate() {
        let (found, stop) = follow(next.system, next.corrected, (200.0, 400.0), 200, 1);
        println!("{k} {rho} {stop:?}");
        let (_, located) = &found[0];
        assert_eq!(located.event, Event::Flip);
        let (cycle, x) = located.critical.as_ref().expect("a critical cycle");
        next = Departure::flip((cycle, x), 0.02, &mut counts).expect("the doubled cycle");
        println!("first at {}", next.corrected.point.lambda);
    }
}
