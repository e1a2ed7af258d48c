//! Bordered Newton with as few factorisations as convergence allows.

use super::chord::{Settled, settle};
use super::{Border, Counts, Factored, Point, System, inner};
use crate::linalg::{Singular, finite};
use thiserror::Error;

/// A solved point and how it went.
pub struct Corrected<F> {
    pub point: Point,
    /// Factors at the solution, bordered by the old tangent.
    pub factors: F,
    /// Steps until convergence.
    pub steps: usize,
    /// Distance between prediction and solution.
    pub distance: f64,
}

#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Failure {
    #[error(transparent)]
    Singular(#[from] Singular),
    #[error("Newton's method did not converge (last step {0:.1e})")]
    Diverged(f64),
    #[error("the tangent turns too far in one step")]
    Turned,
    #[error("the residual is not finite")]
    NotFinite,
}

/// Newton steps in the metric's norm, in which solutions are of order one, shrink to this.
const TOLERANCE: f64 = 1e-11;
/// with old factors to this, before a last step with new ones,
pub(super) const SETTLED: f64 = 1e-10;
/// or, in ill-conditioned systems, to rounding: below this, steps with fresh factors that shrink no more are noise.
const ROUNDING: f64 = 1e-9;
/// Steps with old factors go on while they shrink at least this fast.
const CHORD_RATE: f64 = 0.1;
const MOST_STEPS: usize = 16;
const MOST_FACTORISATIONS: usize = 7;

/// Solves `H = 0` with `border . (x - x_0) = 0`, from (x_0, lambda_0); then the tangent, on the side of `border`.
pub fn correct<S: System>(
    system: &S,
    (x, lambda): (Vec<f64>, f64),
    border: &Border,
    counts: &mut Counts,
) -> Result<Corrected<S::Factors>, Failure> {
    let n = x.len();
    let start = (x.clone(), lambda);
    let (mut x, mut lambda) = (x, lambda);
    let factor = |x: &[f64], lambda: f64, counts: &mut Counts| {
        counts.factorisations += 1;
        system.factor(x, lambda, border)
    };
    let mut factors = factor(&x, lambda, counts)?;
    let (mut fresh, mut factored, mut last) = (true, 1, f64::INFINITY);
    for step in 1..=MOST_STEPS {
        let mut right = vec![0.0; n + 1];
        system.residual(&x, lambda, &mut right[..n]);
        counts.residuals += 1;
        if !finite(&right) {
            return Err(Failure::NotFinite);
        }
        factors.solve(&mut right);
        counts.newton += 1;
        if !finite(&right) {
            return Err(Singular.into());
        }
        x.iter_mut().zip(&right).for_each(|(x, d)| *x -= d);
        lambda -= right[n];
        let size = inner(system, (&right[..n], right[n]), (&right[..n], right[n])).sqrt();
        let rate = size / last;
        // What a linearly convergent iteration still lacks; nothing is known of the rate after one step.
        let left = if step > 1 && rate < 0.5 { size * rate / (1.0 - rate) } else { size };
        let noise = fresh && step > 1 && size < ROUNDING && rate > CHORD_RATE;
        if left < TOLERANCE || noise {
            let difference: Vec<f64> = x.iter().zip(&start.0).map(|(a, b)| a - b).collect();
            let moved = (&difference[..], lambda - start.1);
            let distance = inner(system, moved, moved).sqrt();
            let factors = factor(&x, lambda, counts)?;
            let point = tangent(system, x, lambda, &factors)?;
            return Ok(Corrected { point, factors, steps: step, distance });
        }
        if size > 1e3 || (fresh && step > 2 && rate > 2.0) {
            return Err(Failure::Diverged(size));
        }
        fresh = rate > CHORD_RATE;
        if fresh {
            if factored == MOST_FACTORISATIONS {
                return Err(Failure::Diverged(size));
            }
            factors = factor(&x, lambda, counts)?;
            factored += 1;
        }
        last = size;
    }
    Err(Failure::Diverged(last))
}

/// The point that was settled with factors from elsewhere on the curve, with factors of its own, and one step with them.
pub fn refactor<S: System>(
    system: &S,
    Settled { mut x, mut lambda, steps, distance }: Settled,
    border: &Border,
    counts: &mut Counts,
) -> Result<Corrected<S::Factors>, Failure> {
    counts.factorisations += 1;
    let factors = system.factor(&x, lambda, border)?;
    let n = x.len();
    let mut right = vec![0.0; n + 1];
    system.residual(&x, lambda, &mut right[..n]);
    factors.solve(&mut right);
    counts.residuals += 1;
    counts.newton += 1;
    x.iter_mut().zip(&right).for_each(|(x, d)| *x -= d);
    lambda -= right[n];
    let point = tangent(system, x, lambda, &factors)?;
    // Three steps with old factors gain about as much as one with fresh ones.
    Ok(Corrected { point, factors, steps: steps.div_ceil(3), distance })
}

/// A point that is nearly a solution, made one, with its tangent: one factorisation, at the start.
pub fn polish<S: System>(
    system: &S,
    start: (Vec<f64>, f64),
    border: &Border,
    counts: &mut Counts,
) -> Result<Corrected<S::Factors>, Failure> {
    counts.factorisations += 1;
    let factors = system.factor(&start.0, start.1, border)?;
    let Settled { x, lambda, steps, distance } = settle(system, start, (&factors, None), TOLERANCE, counts)?;
    let point = tangent(system, x, lambda, &factors)?;
    Ok(Corrected { point, factors, steps, distance })
}

/// The unit tangent: `[H_x, H_lambda; border] t = (0, 1)`, normalised.
fn tangent<S: System>(system: &S, x: Vec<f64>, lambda: f64, factors: &S::Factors) -> Result<Point, Failure> {
    let n = x.len();
    let mut t = vec![0.0; n + 1];
    t[n] = 1.0;
    factors.solve(&mut t);
    if !finite(&t) {
        return Err(Singular.into());
    }
    let size = inner(system, (&t[..n], t[n]), (&t[..n], t[n])).sqrt();
    let tangent_lambda = t[n] / size;
    t.truncate(n);
    t.iter_mut().for_each(|t| *t /= size);
    Ok(Point { x, lambda, tangent: t, tangent_lambda })
}
