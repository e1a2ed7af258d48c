//! Random smooth systems with known cycles and multipliers: every degree, both kinds of points, every kind of mass.
//!
//! ```text
//! x' = -omega y + beta (1 - r²) x,   y' = omega x + beta (1 - r²) y,           the unit circle, multiplier exp(-2 beta T)
//! z_i' = d/dt q_i(x, y) - rate_i (z_i - q_i(x, y)),                         z_i = q_i(x, y), multiplier exp(-rate_i T)
//! 0 = w - q(x, y)                                                           an algebraic unknown
//! ```
//!
//! with random cubic polynomials q; both sides multiplied by a random matrix that may depend on the state.

mod common;

use common::{close, parameter};
use hopfline::continuation::{Border, Corrected, Counts, correct};
use hopfline::orbit::{Collocation, Frame, Orbit, OrbitFactors, Points, Scheme};
use hopfline::problem::{Automatic, Formula, Parameter, Problem, Reflection, Scalar, check_derivatives};
use proptest::prelude::*;
use std::f64::consts::TAU;
use std::sync::Arc;

#[derive(Clone, Debug)]
struct Manufactured {
    beta: f64,
    rates: Vec<f64>,
    /// Cubic polynomials of (x, y), ten coefficients each, for the followers and then the algebraic unknowns.
    cubics: Vec<[f64; 10]>,
    /// Entries of the matrix on both sides, off the diagonal; empty: none.
    mixing: Vec<f64>,
    /// Whether those depend on the state.
    moving: bool,
    parameters: Vec<Parameter>,
}

fn cubic<S: Scalar>(c: &[f64; 10], x: S, y: S) -> S {
    let terms = [x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y];
    terms.into_iter().zip(&c[1..]).fold(S::from(c[0]), |sum, (term, &c)| sum + term * c)
}

/// `q_x` and `q_y`.
fn gradient<S: Scalar>(c: &[f64; 10], x: S, y: S) -> (S, S) {
    let by_x = S::from(c[1]) + x * (2.0 * c[3]) + y * c[4] + x * x * (3.0 * c[6]) + x * y * (2.0 * c[7]) + y * y * c[8];
    let by_y = S::from(c[2]) + x * c[4] + y * (2.0 * c[5]) + x * x * c[7] + x * y * (2.0 * c[8]) + y * y * (3.0 * c[9]);
    (by_x, by_y)
}

impl Formula for Manufactured {
    fn dim(&self) -> usize {
        2 + self.cubics.len()
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let (x, y, omega) = (u[0], u[1], p[0]);
        let pull = (S::from(1.0) - x * x - y * y) * self.beta;
        let rate = [pull * x - omega * y, pull * y + omega * x];
        let mut rows: Vec<S> = vec![v[0] - rate[0], v[1] - rate[1]];
        for (i, c) in self.cubics.iter().enumerate() {
            let gap = u[2 + i] - cubic(c, x, y);
            rows.push(match self.rates.get(i) {
                Some(&decay) => {
                    let (by_x, by_y) = gradient(c, x, y);
                    v[2 + i] - by_x * rate[0] - by_y * rate[1] + gap * decay
                }
                None => gap,
            });
        }
        let n = rows.len();
        for i in 0..n {
            g[i] = rows[i];
            for j in (0..n).filter(|&j| j != i) {
                let Some(&entry) = self.mixing.get((i * n + j) % self.mixing.len().max(1)) else { continue };
                let factor = if self.moving { (u[j] * u[i]).sin() + 1.0 } else { S::from(1.0) };
                g[i] += rows[j] * factor * (entry / n as f64);
            }
        }
    }
}

impl Manufactured {
    /// The cycle at a phase, disturbed a little.
    fn state(&self, theta: f64) -> Vec<f64> {
        let (x, y) = (theta.cos(), theta.sin());
        let mut u = vec![x * (1.0 + 1e-3 * (2.0 * theta).cos()), y];
        u.extend(self.cubics.iter().map(|c| cubic(c, x, y)));
        u
    }
}

fn models() -> impl Strategy<Value = Manufactured> {
    let coefficients = || prop::array::uniform10(-1.0..1.0);
    let followers = prop::collection::vec((0.2..3.0, coefficients()), 0..3);
    let algebraic = prop::collection::vec(coefficients(), 0..2);
    let mixing = prop::collection::vec(-0.4..0.4, 0..5);
    (0.2..1.5, followers, algebraic, mixing, any::<bool>()).prop_map(|(beta, followers, algebraic, mixing, moving)| {
        let rates = followers.iter().map(|(rate, _)| *rate).collect();
        let cubics = followers.into_iter().map(|(_, c)| c).chain(algebraic).collect();
        Manufactured { beta, rates, cubics, mixing, moving, parameters: vec![parameter("omega", 1.0)] }
    })
}

fn solve(
    model: &Manufactured,
    omega: f64,
    (intervals, degree, points): (usize, usize, Points),
) -> (Collocation, Corrected<OrbitFactors>) {
    let problem: Arc<dyn Problem> = Arc::new(Automatic(model.clone()));
    let n = problem.dim();
    let scheme = Scheme::new(points, degree);
    let tau = |i: usize| ((i / degree) as f64 + scheme.nodes[i % degree]) / intervals as f64;
    let nodes: Vec<f64> = (0..=intervals * degree).flat_map(|i| model.state(TAU * tau(i))).collect();
    let mesh = (0..=intervals).map(|j| j as f64 / intervals as f64).collect();
    let orbit = Orbit { mesh, points, degree, nodes, dim: n, part: TAU, parts: 1, drift: Vec::new() };
    let frame = Frame {
        problem,
        p: vec![omega],
        free: 0,
        symmetry: Reflection::identity(n),
        parts: 1,
        scale_state: 1.0,
        scale_part: 1.0,
        scale_lambda: 1.0,
    };
    let system = Collocation::new(frame, &orbit);
    let x = Collocation::unknowns(&orbit);
    let border = Border { row: vec![0.0; x.len()], lambda: 1.0 };
    let corrected = correct(&system, (x, omega), &border, &mut Counts::default()).expect("the cycle");
    (system, corrected)
}

/// Errors of the period and, at mesh points, of all invariants: `r = 1`, `z = q`, `w = q`.
fn errors(model: &Manufactured, omega: f64, mesh: (usize, usize, Points)) -> [f64; 2] {
    let (system, corrected) = solve(model, omega, mesh);
    let orbit = system.orbit(&corrected.point.x);
    let mut worst = 0.0_f64;
    for j in 0..orbit.intervals() {
        let u = orbit.node(j * orbit.degree);
        worst = worst.max((u[0].hypot(u[1]) - 1.0).abs());
        for (i, c) in model.cubics.iter().enumerate() {
            worst = worst.max((u[2 + i] - cubic(c, u[0], u[1])).abs());
        }
    }
    [(orbit.period() - TAU / omega).abs(), worst]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn periods_and_mesh_points_converge_with_the_full_order(
        model in models(), degree in 2..=7_usize, gauss: bool, omega in 0.8..1.25,
    ) {
        // Algebraic unknowns are right at mesh points only where those are collocation points.
        let algebraic = model.cubics.len() > model.rates.len();
        let points = if gauss && !algebraic { Points::Gauss } else { Points::Radau };
        let order = if points == Points::Gauss { 2 * degree } else { 2 * degree - 1 };
        let coarse = [40, 24, 14, 10, 8, 6][degree - 2];
        let at = |intervals| errors(&model, omega, (intervals, degree, points));
        let (first, second) = (at(coarse), at(2 * coarse));
        for (a, b) in first.into_iter().zip(second) {
            // Newton's tolerance is 1e-11. An order that is too high is no mistake: errors change their sign.
            let found = (a / b).log2();
            prop_assert!(b < 3e-10 || found > order as f64 - 0.8, "order {found} for {order}: {a:.1e}, {b:.1e}");
        }
    }

    #[test]
    fn multipliers_are_the_known_ones(model in models(), omega in 0.8..1.25) {
        let (system, corrected) = solve(&model, omega, (24, 6, Points::Radau));
        let period = system.orbit(&corrected.point.x).period();
        let found = corrected.factors.multipliers(None).expect("multipliers");
        prop_assert!(found.trivial_error < 1e-8);
        let mut known: Vec<f64> =
            model.rates.iter().chain([&(2.0 * model.beta)]).map(|rate| -rate * period).collect();
        known.sort_by(|a, b| b.total_cmp(a));
        for (i, log) in known.iter().enumerate() {
            let relative = (found.logs[i] - log).abs();
            // Decay within one interval is resolved to the order of the method: 11 at rates of 3 and steps of a quarter.
            prop_assert!(relative < 1e-6, "{i}: {} should be {log}", found.logs[i]);
        }
        // Algebraic unknowns have none: exact zeros, or what rounding leaves of them.
        prop_assert!(found.logs[known.len()..].iter().all(|log| *log < -30.0), "{:?}", found.logs);
    }

    #[test]
    fn derivatives_are_those_of_the_formula(model in models(), theta in 0.0..TAU) {
        let problem = Automatic(model.clone());
        let u = model.state(theta);
        let v: Vec<f64> = u.iter().map(|x| (3.0 * x).cos()).collect();
        let at = hopfline::problem::At { u: &u, v: &v, p: &[1.1] };
        prop_assert!(check_derivatives(&problem, at) < 1e-13);
    }
}

#[test]
fn a_mesh_of_one_interval_is_solved_too() {
    let model = Manufactured {
        beta: 0.5,
        rates: vec![],
        cubics: vec![],
        mixing: vec![],
        moving: false,
        parameters: vec![parameter("omega", 1.0)],
    };
    // Seven Gauss points for a whole turn: order 14 at a step of one period leaves two digits.
    let (system, corrected) = solve(&model, 1.0, (1, 7, Points::Gauss));
    close("period", system.orbit(&corrected.point.x).period(), TAU, 0.05);
}
