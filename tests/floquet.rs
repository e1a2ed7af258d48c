//! Multipliers of stiff orbits by Liouville's formula, of symmetric ones, and what they say of stability.

mod common;

use common::{close, near, parameter};
use faer::{Mat, MatRef};
use hopfline::continuation::{Border, Counts, System, correct};
use hopfline::linalg::Singular;
use hopfline::linalg::periodic::{PeriodicError, Product};
use hopfline::orbit::{
    Collocation, FloquetError, Frame, Multipliers, Orbit, Points, Rows, Scheme, Stability, Transitions, multipliers,
};
use hopfline::problem::{Automatic, Formula, Parameter, Problem, Reflection, Scalar};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Van der Pol's period at mu = 1 and the integral of its divergence, from an eighth-order Runge-Kutta method with
/// tolerance 3e-14.
const PERIOD: f64 = 6.66328685932313;
const DIVERGENCE: f64 = -7.058932808798922;

/// Van der Pol's oscillator and what follows it, `z_i' = -rate_i (z_i - x)`: multipliers `exp(-rate_i T)`.
struct Followed {
    rates: Vec<f64>,
    parameters: [Parameter; 1],
}

impl Formula for Followed {
    fn dim(&self) -> usize {
        2 + self.rates.len()
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        g[0] = v[0] - u[1];
        g[1] = v[1] - (p[0] * (S::from(1.0) - u[0] * u[0]) * u[1] - u[0]);
        for (i, &rate) in self.rates.iter().enumerate() {
            g[2 + i] = v[2 + i] + (u[2 + i] - u[0]) * rate;
        }
    }
}

/// The cycle at mu = 1 on an even mesh; its period and multipliers.
fn followed(rates: &[f64], parts: usize, intervals: usize, wanted: Option<usize>) -> (f64, Multipliers) {
    let problem = Automatic(Followed { rates: rates.to_vec(), parameters: [parameter("mu", 1.0)] });
    let (n, degree) = (problem.dim(), 7);
    let scheme = Scheme::new(Points::Gauss, degree);
    let node = |i: usize| {
        let tau = ((i / degree) as f64 + scheme.nodes[i % degree]) / intervals as f64;
        let angle = TAU * tau / parts as f64;
        let (x, y) = (2.0 * angle.cos(), -2.0 * angle.sin());
        let behind = rates.iter().map(move |rate| (rate * rate * x - rate * y) / (1.0 + rate * rate));
        [x, y].into_iter().chain(behind)
    };
    let mesh = (0..=intervals).map(|j| j as f64 / intervals as f64).collect();
    let nodes = (0..=intervals * degree).flat_map(node).collect();
    let symmetry = if parts == 2 { Reflection::negation(n) } else { Reflection::identity(n) };
    let part = TAU / parts as f64;
    let mut orbit = Orbit { mesh, points: Points::Gauss, degree, nodes, dim: n, part, parts, drift: Vec::new() };
    let problem: Arc<dyn Problem> = Arc::new(problem);
    let (p, scale_state, scale_part, scale_lambda) = (vec![1.0], 1.0, 1.0, 1.0);
    let frame = Frame { problem, p, free: 0, symmetry, parts, scale_state, scale_part, scale_lambda };
    let mut found = None;
    for mu in [0.1, 0.4, 0.7, 1.0] {
        let system = Collocation::new(frame.clone(), &orbit);
        let x = Collocation::unknowns(&orbit);
        let border = Border { row: vec![0.0; x.len()], lambda: 1.0 };
        let corrected = correct(&system, (x, mu), &border, &mut Counts::default()).expect("an orbit");
        orbit = system.orbit(&corrected.point.x);
        // At the orbit itself, not at Newton's last iterate but one.
        found = system.factor(&corrected.point.x, mu, &border).ok();
    }
    (orbit.period(), found.expect("factors").multipliers(wanted).expect("multipliers"))
}

#[test]
fn one_orbit_has_multipliers_from_1e10_to_1e_minus_300() {
    // Rates for 1e10, 1e-15, 1e-100, 1e-200 and 1e-300 over the period. The mesh keeps rate · h at 1.1 or below, so
    // that collocation's own exp(-rate h), a rational function, is right to 1e-13.
    let decades = [10.0, -15.0, -100.0, -200.0, -300.0];
    let rates = decades.map(|decade: f64| -decade * 10_f64.ln() / PERIOD);
    let (period, found) = followed(&rates, 1, 640, None);
    close("T", period, PERIOD, 1e-12);
    assert!(found.trivial_error < 1e-9, "{:.1e}", found.trivial_error);
    let mut exact: Vec<f64> = rates.iter().map(|rate| -rate * PERIOD).collect();
    exact.insert(1, DIVERGENCE);
    for (found, exact) in found.logs.iter().zip(&exact) {
        near("ln mu", *found, *exact, 1e-8);
    }
    near("ln of the product", found.logs.iter().sum(), exact.iter().sum(), 1e-8);
    assert_eq!((found.logs.len(), found.unstable(), found.verdict()), (6, 1, Stability::Unstable));
    assert!(found.values.iter().all(|mu| mu.im == 0.0 && mu.re > 0.0));
    close("1e-300", found.values[5].re, 1e-300, 1e-8);
}

#[test]
fn halves_have_the_sign_of_their_symmetry() {
    // Over half the period S = -1 turns the follower's exp(-rate T/2) round; the oscillator's own multiplier and the
    // trivial one have a determinant of exp(int of the divergence over T/2).
    let rate = 0.3;
    let (_, half) = followed(&[rate], 2, 20, None);
    close("nu of the follower", half.halves[0].re, -(-rate * PERIOD / 2.0).exp(), 1e-9);
    close("nu of the oscillator", half.halves[1].re, (DIVERGENCE / 2.0).exp(), 1e-8);
    let (_, whole) = followed(&[rate], 1, 40, None);
    assert!(whole.halves.is_empty());
    for k in 0..2 {
        close("mu", half.values[k].re, whole.values[k].re, 1e-8);
        close("nu²", (half.halves[k] * half.halves[k]).re, half.values[k].re, 1e-14);
        close("ln mu", half.logs[k], half.values[k].re.ln(), 1e-13);
    }
    assert_eq!((half.verdict(), whole.verdict()), (Stability::Stable, Stability::Stable));
}

/// Three factors with a product of known real eigenvalues.
fn product(values: &[f64]) -> Vec<Mat<f64>> {
    let n = values.len();
    let wave = |k: f64| Mat::from_fn(n, n, |i, j| (k * ((1 + i * n + j) as f64).powi(2)).sin());
    let q: Vec<Mat<f64>> = [1.1, 2.3, 3.7].iter().map(|&k| wave(k).qr().compute_Q()).collect();
    let root = |value: f64| value.abs().cbrt();
    let t = |sign: bool| {
        Mat::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Equal if sign => root(values[i]).copysign(values[i]),
            std::cmp::Ordering::Equal => root(values[i]),
            std::cmp::Ordering::Less => 0.3 * root(values[i]).min(root(values[j])) / n as f64,
            std::cmp::Ordering::Greater => 0.0,
        })
    };
    (0..3).map(|j| &q[(j + 1) % 3] * t(j == 0) * q[j].transpose()).collect()
}

#[test]
fn all_unstable_multipliers_are_counted_however_few_are_wanted() {
    let mut values: Vec<f64> = (0..60).map(|i| 1.5 * (-0.06 * f64::from(i)).exp()).collect();
    values[3] = -values[3];
    let unstable = values.iter().filter(|mu| mu.abs() > 1.0).count();
    assert_eq!(unstable, 7);
    values.push(1.0);
    let identity = Reflection::identity(61);
    let few = multipliers(&product(&values), (&identity, 1), 1, Some(2)).expect("multipliers");
    let all = multipliers(&product(&values), (&identity, 1), 1, None).expect("multipliers");
    assert!(few.values.len() >= 7 && few.values.len() < 60 && all.values.len() == 60);
    assert_eq!((few.unstable(), all.unstable()), (7, 7));
    assert!(few.trivial_error < 1e-12 && few.values.iter().all(|mu| (mu - 1.0).norm() > 1e-3));
    few.values.iter().zip(&all.values).for_each(|(x, y)| assert!((x - y).norm() < 1e-12, "{x} {y}"));
}

#[test]
fn the_trivial_multipliers_error_limits_the_verdict() {
    let verdict = |values: &[f64]| {
        let identity = Reflection::identity(values.len());
        let found = multipliers(&product(values), (&identity, 1), 1, None).expect("multipliers");
        (found.verdict(), found.unstable())
    };
    assert_eq!(verdict(&[1.0, 0.5, -0.3]), (Stability::Stable, 0));
    assert_eq!(verdict(&[1.0, -1.001, 0.5]), (Stability::Unstable, 1));
    // Off by 1e-4, the trivial one leaves open what is nearer than 1e-3 to the circle, and no more than that.
    assert_eq!(verdict(&[1.0001, 0.9995, 0.5]), (Stability::Undecided, 0));
    assert_eq!(verdict(&[1.0001, -1.0005, 0.5]), (Stability::Undecided, 0));
    assert_eq!(verdict(&[1.0001, 0.99, 0.5]), (Stability::Stable, 0));
    assert_eq!(verdict(&[1.0001, -1.0005, 2.0]), (Stability::Unstable, 1));
    assert_eq!(verdict(&[1.0]), (Stability::Stable, 0));
}

#[test]
fn half_the_product_and_the_symmetry_give_the_whole() {
    let n = 5;
    let symmetry = Reflection { source: vec![1, 0, 2, 4, 3], sign: vec![1.0, 1.0, -1.0, -1.0, -1.0] };
    // S behind B, so that S^-1 (S B) has B's eigenvalues.
    let s = Mat::from_fn(n, n, |i, j| if symmetry.source[i] == j { symmetry.sign[i] } else { 0.0 });
    let wanted = [1.4, -0.8, 0.3, 1e-9];
    let mut half = product(&[1.4, 1.0, -0.8, 0.3, 1e-9]);
    half[2] = &s * &half[2];
    // The other half: S A_j S, as S² = 1.
    let mut whole = half.clone();
    whole.extend(half.iter().map(|a| &s * a * &s));
    let half = multipliers(&half, (&symmetry, 2), 1, None).expect("multipliers");
    let whole = multipliers(&whole, (&Reflection::identity(n), 1), 1, None).expect("multipliers");
    for (k, nu) in wanted.iter().enumerate() {
        close("nu", half.halves[k].re, *nu, 1e-9);
        close("nu²", half.values[k].re, nu * nu, 1e-9);
        near("ln nu²", half.logs[k], whole.logs[k], 1e-9);
    }
    assert!(half.trivial_error < 1e-13 && whole.trivial_error < 1e-13);
}

fn split(rows: MatRef<'_, f64>) -> Rows<'_> {
    let n = rows.nrows();
    Rows { c: rows.subcols(0, n), d: Some(rows.subcols(n, n)), e: rows.subcols(2 * n, rows.ncols() - 2 * n) }
}

#[test]
fn transitions_solve_the_condensed_rows() {
    let rows = |seed: f64| Mat::from_fn(4, 10, |i, j| (seed * ((1 + i * 10 + j) as f64).powi(2)).sin());
    let intervals = [rows(1.3), rows(2.9)];
    let views = intervals.each_ref().map(|rows| split(rows.as_ref()));
    let transitions = Transitions::new(&views).expect("maps");
    assert_eq!((transitions.dim(), transitions.factors()), (4, 2));
    for (j, rows) in intervals.iter().enumerate() {
        let a = transitions.matrix(j);
        let left = rows.subcols(0, 4) + rows.subcols(4, 4) * &a;
        assert!(left.norm_max() < 1e-13, "{left:?}");
        let (x, mut y) = (Mat::from_fn(4, 2, |i, k| ((i + 3 * k) as f64).cos()), Mat::zeros(4, 2));
        transitions.apply(j, x.as_ref(), y.as_mut());
        assert!((y - a * x).norm_max() < 1e-13);
    }
    assert!(matches!(Transitions::new(&[split(Mat::zeros(3, 8).as_ref())]), Err(Singular)));
}

#[test]
fn what_has_no_multipliers_is_an_error() {
    let identity = Reflection::identity(3);
    let mut broken = product(&[1.0, 0.5, 0.2]);
    broken[1][(0, 2)] = f64::INFINITY;
    let error = multipliers(&broken, (&identity, 1), 1, None).expect_err("not finite");
    assert_eq!(error, FloquetError::Product(PeriodicError::NotFinite { factor: 1 }));
    assert!(error.to_string().contains("factor 1"), "{error}");
    let nothing: Vec<Mat<f64>> = Vec::new();
    assert!(matches!(multipliers(&nothing, (&Reflection::identity(0), 1), 1, None), Err(FloquetError::None)));
}
