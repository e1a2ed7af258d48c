//! Orbits by collocation: known periods and multipliers, orders of convergence, and every way to write one oscillator.
//!
//! Van der Pol's oscillator `x'' - mu (1 - x²) x' + x = 0` has no closed form; its periods and the integrals of its
//! divergence below were computed apart from this code by an eighth-order Runge-Kutta method with tolerance 3e-14.

mod common;

use common::{close, hopf_of_pair, near, parameter};
use hopfline::bifurcation::HopfNormalForm;
use hopfline::continuation::{Border, Corrected, Counts, Factored, Point, StepControl, Stop, System, Walk, correct};
use hopfline::linalg::c64;
use hopfline::orbit::{Collocation, Frame, Multipliers, Orbit, Points, Scheme, from_hopf, half_period};
use hopfline::problem::{At, Automatic, Formula, Observable, Parameter, Problem, Reflection, Scalar};
use std::f64::consts::TAU;
use std::sync::Arc;

/// mu = 1.
const PERIOD: f64 = 6.66328685932313;
/// int_0^T mu (1 - x²) dt at mu = 1: the logarithm of the non-trivial multiplier, by Liouville's formula.
const DIVERGENCE: f64 = -7.058932808798922;
/// Largest x at mu = 1.
const AMPLITUDE: f64 = 2.008619860874841;

/// How the oscillator is written.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// `x' = y, y' = mu (1 - x²) y - x`.
    Plain,
    /// With an algebraic unknown: `y' = mu (1 - w) y - x, 0 = w - x²`.
    Algebraic,
    /// Both sides multiplied by a matrix that depends on (x, y).
    Mass,
    /// With a follower `z' = -rate (z - x)`, whose multiplier is `exp(-rate T)`.
    Follower(f64),
}

struct VanDerPol {
    form: Form,
    parameters: Vec<Parameter>,
    observables: Vec<Observable>,
}

impl Formula for VanDerPol {
    fn dim(&self) -> usize {
        if matches!(self.form, Form::Plain | Form::Mass) { 2 } else { 3 }
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let (x, y) = (u[0], u[1]);
        let square = if self.form == Form::Algebraic { u[2] } else { x * x };
        let force = p[0] * (S::from(1.0) - square) * y - x;
        let (first, second) = (v[0] - y, v[1] - force);
        (g[0], g[1]) = (first, second);
        match self.form {
            Form::Plain => {}
            Form::Algebraic => g[2] = u[2] - x * x,
            Form::Mass => {
                g[0] = first * (x * x + 2.0) + second * x.sin();
                g[1] = second * (x * y * 0.2).exp() - first * y * 0.3;
            }
            Form::Follower(rate) => g[2] = v[2] + (u[2] - x) * rate,
        }
    }

    fn observables(&self) -> &[Observable] {
        &self.observables
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        if i == 0 { at.u[0] } else { at.p[0] * (1.0 - at.u[0] * at.u[0]) }
    }
}

fn frame(form: Form, half: bool) -> Frame {
    let observables = ["x", "divergence"].map(|name| Observable { name, unit: "", meaning: "" }).to_vec();
    let problem = Automatic(VanDerPol { form, parameters: vec![parameter("mu", 1.0)], observables });
    let n = problem.dim();
    // w = x² is even under u -> -u.
    let mut reflection = Reflection::negation(n);
    if form == Form::Algebraic {
        reflection.sign[2] = 1.0;
    }
    let (symmetry, parts) = if half { (reflection, 2) } else { (Reflection::identity(n), 1) };
    let problem: Arc<dyn Problem> = Arc::new(problem);
    Frame { problem, p: vec![1.0], free: 0, symmetry, parts, scale_state: 1.0, scale_part: 1.0, scale_lambda: 1.0 }
}

type Solved = (Collocation, Corrected<<Collocation as System>::Factors>);

/// Newton's method with lambda fixed, from an orbit.
fn fixed(frame: &Frame, orbit: &Orbit, lambda: f64) -> Solved {
    let system = Collocation::new(frame.clone(), orbit);
    let x = Collocation::unknowns(orbit);
    let border = Border { row: vec![0.0; x.len()], lambda: 1.0 };
    let corrected = correct(&system, (x, lambda), &border, &mut Counts::default()).expect("an orbit");
    (system, corrected)
}

/// Van der Pol's cycle at mu, on a uniform mesh, from the circle of radius 2 at small mu.
fn van_der_pol(form: Form, half: bool, mu: f64, (intervals, points, degree): (usize, Points, usize)) -> Solved {
    let frame = frame(form, half);
    let scheme = Scheme::new(points, degree);
    let angle = |i: usize| {
        let tau = ((i / degree) as f64 + scheme.nodes[i % degree]) / intervals as f64;
        TAU * tau / frame.parts as f64
    };
    let state = |theta: f64| -> Vec<f64> {
        let (x, y) = (2.0 * theta.cos(), -2.0 * theta.sin());
        match form {
            Form::Plain | Form::Mass => vec![x, y],
            Form::Algebraic => vec![x, y, x * x],
            // z lags behind x.
            Form::Follower(rate) => vec![x, y, (rate * rate * x - rate * y) / (1.0 + rate * rate)],
        }
    };
    let mut nodes: Vec<f64> = (0..intervals * degree).flat_map(|i| state(angle(i))).collect();
    let dim = frame.problem.dim();
    let mut last = vec![0.0; dim];
    frame.symmetry.apply(&nodes[..dim], &mut last);
    nodes.extend(last);
    let mesh = (0..=intervals).map(|j| j as f64 / intervals as f64).collect();
    let part = TAU / frame.parts as f64;
    let mut orbit = Orbit { mesh, points, degree, nodes, dim, part, parts: frame.parts, drift: Vec::new() };
    for mu in [0.1 * mu, 0.4 * mu, 0.7 * mu] {
        let (system, corrected) = fixed(&frame, &orbit, mu);
        orbit = system.orbit(&corrected.point.x);
    }
    fixed(&frame, &orbit, mu)
}

fn orbit((system, corrected): &Solved) -> Orbit {
    system.orbit(&corrected.point.x)
}

fn multipliers((_, corrected): &Solved) -> Multipliers {
    corrected.factors.multipliers(None).expect("multipliers")
}

/// The integral of an observable over the period, by the orbit's own quadrature.
fn integral(orbit: &Orbit, frame: &Frame, observable: usize, lambda: f64) -> f64 {
    let scheme = orbit.scheme();
    let one: f64 = orbit
        .mesh
        .windows(2)
        .map(|w| {
            let point = |(c, weight): (&f64, &f64)| {
                let (u, v) = orbit.at(w[0] + c * (w[1] - w[0]), &scheme);
                weight * frame.problem.observe(observable, At { u: &u, v: &v, p: &[lambda] })
            };
            (w[1] - w[0]) * scheme.points.iter().zip(&scheme.weights).map(point).sum::<f64>()
        })
        .sum();
    one * orbit.period()
}

/// A mesh fine enough for 11 digits at mu = 1, so that what is left is Newton's tolerance of 1e-11.
const FINE: (usize, Points, usize) = (40, Points::Gauss, 6);
const FINE_RADAU: (usize, Points, usize) = (40, Points::Radau, 6);
const TIGHT: f64 = 1e-10;

#[test]
fn van_der_pol_has_the_known_period_amplitude_and_multiplier() {
    for mesh in [FINE, FINE_RADAU] {
        let solved = van_der_pol(Form::Plain, false, 1.0, mesh);
        let orbit = orbit(&solved);
        close("T", orbit.period(), PERIOD, TIGHT);
        let frame = &solved.0.frame;
        let extremes = orbit.extremes(&*frame.problem, 0, &[1.0], &frame.symmetry);
        // Brent's method stops at 1e-9 in time, quadratically small in the value; between mesh points the polynomial
        // itself has order m + 1 = 7: (1/40)^7 = 6e-12 times the seventh derivative.
        close("max x", extremes.max, AMPLITUDE, 1e-8);
        close("min x", extremes.min, -AMPLITUDE, 1e-8);
        let found = multipliers(&solved);
        assert!(found.trivial_error < TIGHT, "{:.1e}", found.trivial_error);
        assert_eq!((found.values.len(), found.unstable()), (1, 0));
        // exp magnifies by |DIVERGENCE|.
        close("multiplier", found.values[0].re, DIVERGENCE.exp(), 1e-8);
    }
    close("T at mu = 2", orbit(&van_der_pol(Form::Plain, false, 2.0, FINE)).period(), 7.629874479674818, 1e-9);
}

#[test]
fn multipliers_obey_liouvilles_formula() {
    // Products and an integral of the same computed orbit: the formula holds for the orbit to the order of the method.
    let solved = van_der_pol(Form::Plain, false, 1.5, FINE);
    let whole = integral(&orbit(&solved), &solved.0.frame, 1, 1.5);
    close("exp of the integral", multipliers(&solved).values[0].re, whole.exp(), 1e-8);
    // With a slow follower of its own, known multiplier.
    let rate = 0.3;
    let solved = van_der_pol(Form::Follower(rate), false, 1.0, FINE);
    let values = multipliers(&solved).values;
    close("follower", values[0].re, (-rate * PERIOD).exp(), 1e-9);
    close("all", values.iter().product::<c64>().re, (DIVERGENCE - rate * PERIOD).exp(), 1e-8);
}

#[test]
fn the_period_converges_with_order_2m_at_gauss_and_2m_minus_1_at_radau_points() {
    // Between a mesh and the twice finer one, both fine enough to be near the asymptotic order and coarse enough for
    // errors above rounding. Orders within 0.6 tell 2m from 2m - 1 and 2m + 1.
    for (points, meshes) in [(Points::Gauss, [64, 48, 32, 24]), (Points::Radau, [64, 48, 32, 32])] {
        for (degree, intervals) in (2..=5).zip(meshes) {
            let error = |intervals: usize| {
                let solved = van_der_pol(Form::Plain, false, 1.0, (intervals, points, degree));
                (orbit(&solved).period() - PERIOD).abs()
            };
            let order = (error(intervals) / error(2 * intervals)).log2();
            let expected = if points == Points::Gauss { 2 * degree } else { 2 * degree - 1 } as f64;
            near(&format!("order at {points:?} points, degree {degree}"), order, expected, 0.6);
        }
    }
}

#[test]
fn the_trivial_multiplier_does_not_see_the_discretisation_on_an_even_mesh() {
    // Steps of one length make a map with an invariant curve: its shift along itself is a multiplier 1 up to terms that
    // are exponentially small in the step, whatever the period's error. It measures Newton's error, not the method's.
    let solved = van_der_pol(Form::Plain, false, 1.0, (96, Points::Gauss, 2));
    let error = (orbit(&solved).period() - PERIOD).abs() / PERIOD;
    assert!(error > 1e-7 && multipliers(&solved).trivial_error < 1e-4 * error);
    // On an uneven mesh, as adaptation makes it, the two errors are of one size.
    for intervals in [24, 48] {
        let even = (0..=intervals).map(|j| j as f64 / intervals as f64);
        let mesh: Vec<f64> = even.map(|t| t + 0.1 * (TAU * t).sin()).collect();
        let uneven = fixed(&frame(Form::Plain, false), &orbit(&solved).interpolated(&mesh, 2), 1.0);
        let error = (orbit(&uneven).period() - PERIOD).abs() / PERIOD;
        let seen = multipliers(&uneven).trivial_error;
        assert!(seen > 0.1 * error && seen < 10.0 * error, "{intervals}: {seen:.1e} {error:.1e}");
    }
}

#[test]
fn half_a_period_and_the_symmetry_give_the_whole_orbit() {
    for (form, points) in [(Form::Plain, Points::Gauss), (Form::Mass, Points::Radau), (Form::Algebraic, Points::Radau)]
    {
        let whole = van_der_pol(form, false, 1.0, (40, points, 6));
        // Half as many intervals: the same mesh.
        let half = van_der_pol(form, true, 1.0, (20, points, 6));
        let (orbit_whole, orbit_half) = (orbit(&whole), orbit(&half));
        close("T", orbit_half.period(), orbit_whole.period(), TIGHT);
        close("P", 2.0 * orbit_half.part, orbit_half.period(), 1e-15);
        close("multiplier", multipliers(&half).values[0].re, multipliers(&whole).values[0].re, 1e-8);
        let largest = |solved: &Solved, orbit: &Orbit| {
            let frame = &solved.0.frame;
            let extremes = orbit.extremes(&*frame.problem, 0, &[1.0], &frame.symmetry);
            [extremes.max, extremes.min]
        };
        let (a, b) = (largest(&half, &orbit_half), largest(&whole, &orbit_whole));
        // The two orbits have different phases on the mesh, so polynomials of order 7 between its points: as above.
        close("max", a[0], b[0], 1e-8);
        close("min", a[1], b[1], 1e-8);
        // Symmetric by construction, but for the rounding of two searches.
        near("max + min", a[0] + a[1], 0.0, 1e-14);
    }
}

#[test]
fn a_state_dependent_mass_changes_nothing() {
    for points in [Points::Gauss, Points::Radau] {
        let solved = van_der_pol(Form::Mass, false, 1.0, (40, points, 6));
        close("T", orbit(&solved).period(), PERIOD, TIGHT);
        close("multiplier", multipliers(&solved).values[0].re, DIVERGENCE.exp(), 1e-8);
    }
}

#[test]
fn an_algebraic_unknown_has_multiplier_zero_and_changes_nothing_else() {
    let solved = van_der_pol(Form::Algebraic, false, 1.0, FINE_RADAU);
    let orbit = orbit(&solved);
    close("T", orbit.period(), PERIOD, TIGHT);
    let found = multipliers(&solved);
    assert!(found.trivial_error < TIGHT);
    close("multiplier", found.values[0].re, DIVERGENCE.exp(), 1e-8);
    // Each of the 40 intervals maps it to zero but for rounding, which leaves less than any number.
    assert!(found.values[1] == c64::new(0.0, 0.0) && found.logs[1] < -1000.0, "{}", found.logs[1]);
    // The constraint holds at mesh points, which are Radau points.
    for j in 0..=orbit.intervals() {
        let u = orbit.node(j * orbit.degree);
        near("w - x²", u[2], u[0] * u[0], 1e-10);
    }
}

#[test]
fn a_stiff_mode_has_multiplier_zero_at_radau_points_and_not_at_gauss_points() {
    let rate = 1e6;
    let radau = van_der_pol(Form::Follower(rate), false, 1.0, FINE_RADAU);
    close("T", orbit(&radau).period(), PERIOD, TIGHT);
    let found = multipliers(&radau);
    close("multiplier", found.values[0].re, DIVERGENCE.exp(), 1e-8);
    // Each interval maps it to a few parts of 1/(rate h), rate h = 1.7e5.
    assert!(found.logs[1] < 40.0 * 1e-4_f64.ln(), "{}", found.logs[1]);
    // Gauss: the mode's polynomial quotient tends to (-1)^m instead of 0; |R| = 1 - 2 m (m + 1)/(rate h) each time.
    let gauss = van_der_pol(Form::Follower(rate), false, 1.0, FINE);
    let (intervals, degree) = (40.0, 6.0);
    let expected = (-2.0 * degree * (degree + 1.0) * intervals * intervals / (rate * PERIOD)).exp();
    close("spurious multiplier", multipliers(&gauss).values[0].norm(), expected, 1e-2);
}

#[test]
fn the_factored_matrix_is_the_derivative_of_the_residual() {
    // H' d by central differences of the residual against the right-hand side that d was solved for, on an uneven mesh.
    for (form, half, points) in [
        (Form::Plain, true, Points::Gauss),
        (Form::Mass, false, Points::Gauss),
        (Form::Mass, true, Points::Radau),
        (Form::Algebraic, false, Points::Radau),
        (Form::Follower(2.0), true, Points::Radau),
    ] {
        let even = orbit(&van_der_pol(form, half, 1.0, (7, points, 3)));
        let orbit = even.interpolated(&[0.0, 0.1, 0.25, 0.3, 0.55, 0.7, 1.0], 4);
        let system = Collocation::new(frame(form, half), &orbit);
        let x = Collocation::unknowns(&orbit);
        let wave = |i: usize, k: f64| (k * i as f64 + 0.3).sin();
        let n = x.len();
        let border = Border { row: (0..n).map(|i| wave(i, 0.7)).collect(), lambda: 0.4 };
        let right: Vec<f64> = (0..=n).map(|i| wave(i, 1.3)).collect();
        let mut d = right.clone();
        system.factor(&x, 1.2, &border).expect("factors").solve(&mut d);
        let size = d.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let step = 1e-5 / size;
        let moved = |sign: f64| -> Vec<f64> {
            let x: Vec<f64> = x.iter().zip(&d).map(|(x, d)| x + sign * step * d).collect();
            let mut r = vec![0.0; n];
            system.residual(&x, 1.2 + sign * step * d[n], &mut r);
            r
        };
        let (plus, minus) = (moved(1.0), moved(-1.0));
        for i in 0..n {
            // Differences with steps of 1e-5: truncation 1e-10 times third derivatives, rounding 1e-11, both times `size`.
            near("row", 0.5 * (plus[i] - minus[i]) / step, right[i], 1e-7 * size.max(1.0));
        }
        let row: f64 = border.row.iter().zip(&d).map(|(a, b)| a * b).sum::<f64>() + border.lambda * d[n];
        near("border", row, right[n], 1e-11 * size.max(1.0));
    }
}

/// `z' = (mu + i) z - z |z|²`: circles of radius sqrt(mu), period 2 pi, multiplier `exp(-4 pi mu)`.
struct Circle(Vec<Parameter>);

impl Formula for Circle {
    fn dim(&self) -> usize {
        2
    }

    fn parameters(&self) -> &[Parameter] {
        &self.0
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let growth = p[0] - u[0] * u[0] - u[1] * u[1];
        g[0] = v[0] - growth * u[0] + u[1];
        g[1] = v[1] - growth * u[1] - u[0];
    }

    fn reflection(&self) -> Option<Reflection> {
        Some(Reflection::negation(2))
    }
}

#[test]
fn a_past_orbit_is_brought_into_the_phase_of_the_present_one() {
    let solved = van_der_pol(Form::Plain, false, 1.0, (20, Points::Gauss, 4));
    let present = orbit(&solved);
    let (_, Corrected { mut point, .. }) = solved;
    let mut system = Collocation::new(frame(Form::Plain, false), &present);
    system.prepare(&mut point);
    let scheme = Scheme::new(Points::Gauss, 4);
    let at = |later: f64| -> Vec<(Vec<f64>, Vec<f64>)> {
        let times = present.mesh.windows(2).flat_map(|w| scheme.nodes[..4].iter().map(|x| w[0] + x * (w[1] - w[0])));
        times.map(|t| present.at((t + later) % 1.0, &scheme)).collect()
    };
    let (later, along) = (1e-4, 0.3);
    let mut past = point.clone();
    for (k, ((u, _), (_, v))) in at(later).iter().zip(at(0.0)).enumerate() {
        past.x[2 * k..][..2].copy_from_slice(u);
        (0..2).for_each(|i| past.tangent[2 * k + i] += along * v[i]);
    }
    let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(distance(&past.x, &point.x) > later && distance(&past.tangent, &point.tangent) > along);
    system.align(&mut past);
    // What is left is what the rates change by meanwhile.
    let rates = |later: f64| -> Vec<f64> { at(later).into_iter().flat_map(|(_, v)| v).collect() };
    let change = distance(&rates(later), &rates(0.0));
    near("states", distance(&past.x, &point.x), 0.0, later * PERIOD * change);
    near("tangents", distance(&past.tangent, &point.tangent), 0.0, 2.0 * along * change);
}

#[test]
fn the_branch_of_circles_from_a_hopf_point_is_exact_all_along() {
    let problem: Arc<dyn Problem> = Arc::new(Automatic(Circle(vec![parameter("mu", 0.1)])));
    let hopf = hopf_of_pair(&problem, (&[0.0, 0.0], &[0.1]), 0, 10.0, 0);
    let form = HopfNormalForm::new(&*problem, &hopf).expect("a normal form");
    let symmetry = half_period(&*problem, &hopf, 1.0).expect("an odd mode");
    let r = 0.1;
    let (start, lambda) = from_hopf((&hopf, &form), 0, r, (&symmetry, 2), (20, 5, Points::Gauss));
    // |z|² = 2 r² for q of unit length.
    close("predicted mu", lambda, 2.0 * r * r, 1e-12);
    let frame = Frame {
        problem,
        p: vec![0.0],
        free: 0,
        symmetry,
        parts: 2,
        scale_state: 1.0,
        scale_part: 1.0,
        scale_lambda: 1.0,
    };
    let (mut system, corrected) = fixed(&frame, &start, lambda);
    assert!(corrected.distance < 1e-10, "the prediction is exact here: {:.1e}", corrected.distance);
    let control = StepControl { step: 0.05, least: 1e-6, most: 0.2 };
    let mut walk = Walk::new(&mut system, corrected.point, control, (0.0, 1.0));
    loop {
        let step = walk.step().expect("a step");
        let (orbit, mu) = (walk.system.orbit(&step.to.x), step.to.lambda);
        close("T", orbit.period(), TAU, 1e-11);
        for i in 0..=orbit.intervals() {
            let u = orbit.node(i * orbit.degree);
            // Newton's tolerance of 1e-11 is an estimate, and an error of mu counts 1/(2 r) < 4 times.
            near("radius", u[0].hypot(u[1]), mu.sqrt(), 1e-10);
        }
        let found = step.factors.multipliers(None).expect("multipliers");
        // The same error of r, times |d exp(-4 pi r²)/dr| < 3.1.
        near("multiplier", found.values[0].re, (-2.0 * TAU * mu).exp(), 3.1e-10);
        if step.stop == Some(Stop::RangeEnd) {
            close("the end of the range", mu, 1.0, 1e-15);
            break;
        }
    }
}

/// Follows van der Pol's cycle to the last of `targets` on a mesh of its own choice; periods at all of them.
fn relaxation(targets: &[f64], intervals: usize) -> Vec<f64> {
    let first = orbit(&van_der_pol(Form::Plain, true, 1.0, (intervals, Points::Gauss, 5)));
    let frame = Frame { scale_part: 10.0, scale_lambda: 10.0, ..frame(Form::Plain, true) };
    // The border of `fixed` points to larger lambda, and so does the tangent.
    let (mut system, corrected) = fixed(&frame, &first, 1.0);
    let mut point: Point = corrected.point;
    let mut periods = Vec::new();
    for &target in targets {
        let control = StepControl { step: 0.05, least: 1e-6, most: 0.5 };
        let mut walk = Walk::new(&mut system, point.clone(), control, (0.0, target));
        let end = loop {
            let step = walk.step().unwrap_or_else(|stop| panic!("{stop}"));
            if step.stop == Some(Stop::RangeEnd) {
                break step.to;
            }
        };
        // Let the mesh settle at the end of the range.
        point = end;
        for _ in 0..3 {
            system.prepare(&mut point);
            let border = Border { row: vec![0.0; point.x.len()], lambda: 1.0 };
            let start = (point.x.clone(), target);
            point = correct(&system, start, &border, &mut Counts::default()).expect("an orbit").point;
        }
        periods.push(system.orbit(&point.x).period());
    }
    periods
}

#[test]
fn the_mesh_follows_relaxation_oscillations() {
    let periods = relaxation(&[10.0, 100.0], 60);
    close("T at mu = 10", periods[0], 19.07836956693899, 1e-9);
    // The reference has eleven digits.
    close("T at mu = 100", periods[1], 162.83707109, 1e-10);
    // Already at mu = 4 an even mesh with as many intervals is worse.
    let uniform = van_der_pol(Form::Plain, true, 4.0, (60, Points::Gauss, 5));
    let moved = relaxation(&[4.0], 60)[0];
    let fine = orbit(&van_der_pol(Form::Plain, true, 4.0, (400, Points::Gauss, 6))).period();
    let error = |period: f64| (period - fine).abs() / fine;
    assert!(error(moved) < 0.1 * error(orbit(&uniform).period()), "{:.1e}", error(moved));
}
