//! Corrections with factors that are already there, from the last point of the curve.
//!
//! Broyden's method: the inverse of the old matrix is corrected by what each step teaches,
//!
//! ```text
//! s_0 = -B^-1 H(x_0),    z = -B^-1 H(x_k) + sum_j s_{j+1} <s_j, z> / <s_j, s_j>,    s_k = z / (1 - <s, z> / <s, s>),
//! ```
//!
//! z being updated as the sum goes on and s the last step (Kelley 1995, doi:10.1137/1.9781611970944, section 7.3). It
//! converges superlinearly for the price of a residual and a solution a step; a factorisation costs as much as dozens of
//! those in large systems.

use super::corrector::TOLERANCE;
use super::{Counts, Factored, Failure, System, inner};
use crate::linalg::finite;

/// Steps that shrink less than this tell that the factors are of no use here; the first two need not shrink, for the
/// hyperplane and other rows of the factors' system may differ from those of the present one.
const SLOWEST: f64 = 0.5;
/// A rate of convergence is not relied on beyond this: superlinear steps are not as regular as linear ones.
const FASTEST: f64 = 0.1;
const MOST_STEPS: usize = 12;

/// A solution on the hyperplane of the factors' own border through the start.
pub struct Settled {
    pub x: Vec<f64>,
    pub lambda: f64,
    pub steps: usize,
    /// Distance between start and solution.
    pub distance: f64,
}

/// Solves `H = 0` from a start; an error where the factors are too far from those of the solution.
pub fn settle<S: System>(
    system: &S,
    (mut x, mut lambda): (Vec<f64>, f64),
    factors: &S::Factors,
    counts: &mut Counts,
) -> Result<Settled, Failure> {
    let n = x.len();
    let start = (x.clone(), lambda);
    let product = |a: &[f64], b: &[f64]| inner(system, (&a[..n], a[n]), (&b[..n], b[n]));
    let mut steps: Vec<Vec<f64>> = Vec::new();
    let mut sizes: Vec<f64> = Vec::new();
    for count in 1..=MOST_STEPS {
        let mut z = vec![0.0; n + 1];
        system.residual(&x, lambda, &mut z[..n]);
        counts.residuals += 1;
        if !finite(&z) {
            return Err(Failure::NotFinite);
        }
        factors.solve(&mut z);
        counts.newton += 1;
        z.iter_mut().for_each(|z| *z = -*z);
        for (pair, size) in steps.windows(2).zip(&sizes) {
            let share = product(&pair[0], &z) / size;
            z.iter_mut().zip(&pair[1]).for_each(|(z, s)| *z += share * s);
        }
        if let (Some(last), Some(size)) = (steps.last(), sizes.last()) {
            let factor = 1.0 / (1.0 - product(last, &z) / size);
            z.iter_mut().for_each(|z| *z *= factor);
        }
        if !finite(&z) {
            return Err(Failure::NotFinite);
        }
        x.iter_mut().zip(&z).for_each(|(x, z)| *x += z);
        lambda += z[n];
        let size = product(&z, &z);
        let rate = sizes.last().map_or(0.0, |last: &f64| (size / last).sqrt());
        let length = size.sqrt();
        // As in the corrector: a linear rate would leave this, and nothing is known of it after one step.
        let sure = rate.max(FASTEST);
        let left = if count > 1 { length * sure / (1.0 - sure) } else { length };
        if rate < SLOWEST && left < TOLERANCE {
            let difference: Vec<f64> = x.iter().zip(&start.0).map(|(a, b)| a - b).collect();
            let moved = (&difference[..], lambda - start.1);
            let distance = inner(system, moved, moved).sqrt();
            return Ok(Settled { x, lambda, steps: count, distance });
        }
        if count > 3 && rate > SLOWEST || rate > 5.0 {
            return Err(Failure::Diverged(length));
        }
        steps.push(z);
        sizes.push(size);
    }
    Err(Failure::Diverged(sizes.last().map_or(f64::INFINITY, |size| size.sqrt())))
}
