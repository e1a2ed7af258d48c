//! Further solutions at given parameters, by Newton's method from which those that are known are deflated.
//!
//! With solutions r_i known, the deflated residual
//!
//! ```text
//! m(u) G(u, 0, p),      m(u) = prod_i ( s² / |u - r_i|² + 1 )
//! ```
//!
//! has the other zeros of G alone (Farrell, Birkisson and Funke 2015, doi:10.1137/140984798; s is the scale of the state).
//! Its Newton step is that of G in another length: `G_u d = -G`, `delta = d / (1 - d . grad ln m)`. A start from which
//! this finds nothing proves nothing.

use crate::continuation::Counts;
use crate::linalg::{Factors, dot, finite};
use crate::problem::{At, Problem};

const MOST_STEPS: usize = 60;
/// Newton steps are cut to this many scales.
const LONGEST: f64 = 10.0;
/// The state is solved for where a step of Newton's own method is smaller than this part of the scale.
const TOLERANCE: f64 = 1e-10;
/// Solutions closer than this, in scales, are one.
pub const SAME: f64 = 1e-6;

/// A solution near `start` that is not one of the known ones; `scale` is the size of a state in the Euclidean norm.
pub fn deflated(
    problem: &dyn Problem,
    p: &[f64],
    start: &[f64],
    (known, scale): (&[Vec<f64>], f64),
    counts: &mut Counts,
) -> Option<Vec<f64>> {
    let mut u = start.to_vec();
    let rest = vec![0.0; u.len()];
    for _ in 0..MOST_STEPS {
        let at = At { u: &u, v: &rest, p };
        let mut d = vec![0.0; u.len()];
        problem.residual(at, &mut d);
        counts.residuals += 1;
        let (gu, _) = problem.matrices(at);
        counts.factorisations += 1;
        Factors::new(&gu).ok()?.solve(&mut d);
        counts.newton += 1;
        d.iter_mut().for_each(|d| *d = -*d);
        if !finite(&d) {
            return None;
        }
        let size = dot(&d, &d).sqrt();
        if size < TOLERANCE * scale {
            return known.iter().all(|r| distance(&u, r) > SAME * scale).then_some(u);
        }
        // d . grad ln m, with grad eta = -2 s² (u - r) / |u - r|⁴.
        let slope: f64 = known
            .iter()
            .map(|r| {
                let gap: Vec<f64> = u.iter().zip(r).map(|(u, r)| (u - r) / scale).collect();
                let square = dot(&gap, &gap).max(f64::MIN_POSITIVE);
                -2.0 * dot(&d, &gap) / scale / (square * (1.0 + square))
            })
            .sum();
        let stretch = 1.0 / (1.0 - slope);
        let stretch = if stretch.is_finite() { stretch } else { 1.0 };
        let most = LONGEST * scale / size;
        let stretch = stretch.clamp(-most, most);
        u.iter_mut().zip(&d).for_each(|(u, d)| *u += stretch * d);
    }
    None
}

/// `|a - b|`.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
