//! Where a branch of cycles ends in a homoclinic orbit.
//!
//! Near it the cycle spends most of its time beside an equilibrium, and
//!
//! ```text
//! T = -ln |lambda - lambda_h| / rate + ...,      so that  dlambda/dT = -rate (lambda - lambda_h):
//! ```
//!
//! a straight line in lambda whose zero is lambda_h and whose slope is the smaller one of the equilibrium's leading
//! stable and unstable rates (Shilnikov; Kuznetsov 2004, doi:10.1007/978-1-4757-3978-7, section 6.2). dlambda/dT is
//! known at each point from its tangent, and the rate from the equilibrium itself: two independent witnesses.

use crate::continuation::Point;
use crate::linalg::{Lu, c64, dot, finite, pencil};
use crate::orbit::{Collocation, Orbit};
use crate::problem::{At, Problem};
use serde::{Deserialize, Serialize};

/// What a point of the branch says.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Passage {
    pub lambda: f64,
    pub period: f64,
    /// dlambda/dT along the branch.
    pub slope: f64,
}

/// The end of the branch.
#[derive(Clone, Debug)]
pub struct Homoclinic {
    /// lambda_h, and how far the last two estimates differ.
    pub lambda: f64,
    pub error: f64,
    /// As the periods have it, and as the equilibrium beside which the orbit slows down has it, if there is one.
    pub rates: (f64, Option<f64>),
}

/// The branch has ended when it is this near, in parts of its own extent,
const NEAR: f64 = 1e-8;
/// and the two rates agree so well; without a rate to compare with, when lambda does not change any more while T grows.
const AGREEMENT: f64 = 0.05;
const STANDSTILL: f64 = 1e-11;
/// Steps of Newton's method to the equilibrium.
const MOST_STEPS: usize = 20;

impl Passage {
    pub fn new(system: &Collocation, point: &Point) -> Self {
        let parts = system.frame.parts as f64;
        let part = |x: &[f64]| system.part(x) * parts;
        Self { lambda: point.lambda, period: part(&point.x), slope: point.tangent_lambda / part(&point.tangent) }
    }
}

impl Homoclinic {
    /// Whether the branch ends after these points, the last of which is `point`; `extent` is the size of lambda's range.
    pub fn recognise(
        [first, second, third]: [Passage; 3],
        (system, point): (&Collocation, &Point),
        extent: f64,
    ) -> Option<Self> {
        // Relative orbits end at relative equilibria, which are not looked for.
        if !system.reference().drift.is_empty() {
            return None;
        }
        let growing = first.period < second.period && second.period < third.period;
        let estimate = |a: Passage, b: Passage| {
            let rate = -(b.slope - a.slope) / (b.lambda - a.lambda);
            (b.lambda + b.slope / rate, rate)
        };
        let ((before, _), (lambda, rate)) = (estimate(first, second), estimate(second, third));
        let left = (third.lambda - lambda).abs();
        if !(growing && rate > 0.0 && left < NEAR * extent) {
            return None;
        }
        let orbit = system.orbit(&point.x);
        let p = system.parameters(point.lambda);
        let problem = &*system.frame.problem;
        let own = equilibrium(problem, &slowest(&orbit), &p).and_then(|u| leading_rate(problem, &u, &p, rate));
        let agree = own.is_some_and(|own| (own / rate - 1.0).abs() < AGREEMENT);
        let error = (lambda - before).abs().max(left * f64::EPSILON.sqrt());
        (agree || left < STANDSTILL * extent).then_some(Self { lambda, error, rates: (rate, own) })
    }
}

/// The node where the orbit moves most slowly.
fn slowest(orbit: &Orbit) -> Vec<f64> {
    let scheme = orbit.scheme();
    let middle = |w: &[f64]| orbit.at(0.5 * (w[0] + w[1]), &scheme);
    let speeds = orbit.mesh.windows(2).map(|w| {
        let (u, v) = middle(w);
        (dot(&v, &v), u)
    });
    speeds.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(Vec::new, |(_, u)| u)
}

/// The equilibrium nearest to a state, by Newton's method.
fn equilibrium(problem: &dyn Problem, start: &[f64], p: &[f64]) -> Option<Vec<f64>> {
    let (mut u, rest) = (start.to_vec(), vec![0.0; start.len()]);
    for _ in 0..MOST_STEPS {
        let at = At { u: &u, v: &rest, p };
        let (gu, _) = problem.linearised(at);
        let mut r = vec![0.0; u.len()];
        problem.residual(at, &mut r);
        Lu::new(gu.as_ref()).ok()?.solve(&mut r);
        if !finite(&r) {
            return None;
        }
        u.iter_mut().zip(&r).for_each(|(u, d)| *u -= d);
        if dot(&r, &r) <= 1e-24 * (1.0 + dot(&u, &u)) {
            return Some(u);
        }
    }
    None
}

/// The smaller one of an equilibrium's leading stable and unstable rates; None if it is no saddle.
fn leading_rate(problem: &dyn Problem, u: &[f64], p: &[f64], size: f64) -> Option<f64> {
    let rest = vec![0.0; u.len()];
    let (gu, gv) = problem.linearised(At { u, v: &rest, p });
    // Irrational in units of the rate, so that it is no eigenvalue itself.
    let values = pencil(gu.as_ref(), gv.as_ref(), std::f64::consts::E * size, 0).ok()?;
    let least = |sign: f64| {
        let real = values.iter().map(|pair: &crate::linalg::Eigenpair| sign * c64::new(pair.value.re, 0.0).re);
        real.filter(|re| *re > 0.0).fold(f64::INFINITY, f64::min)
    };
    let rate = least(1.0).min(least(-1.0));
    (least(1.0).is_finite() && least(-1.0).is_finite()).then_some(rate)
}
