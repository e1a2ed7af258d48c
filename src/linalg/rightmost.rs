//! The rightmost eigenvalue of `(A + sigma M) q = 0` with both its vectors.
//!
//! All eigenvalues are computed, so that none can be missed; the rightmost one is then polished by inverse iteration
//! on both sides and the two-sided Rayleigh quotient (Parlett 1974, Math. Comp. 28:679),
//!
//! ```text
//! x <- (A + s M)^-1 M x,   y <- (A + s M)^-H M^T y,   sigma = s - y^H (A + s M) x / (y^H M x),
//! ```
//!
//! whose error is the product of those of x and y. A polished value far from the first one says that the QR
//! iteration did not converge (faer keeps no flag of it).

use super::{Lu, Singular, pencil};
use faer::{Mat, MatRef, c64};
use thiserror::Error;

/// Why there is no trustworthy eigenvalue.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum EigenFailure {
    #[error(transparent)]
    Singular(#[from] Singular),
    #[error("the pencil has no finite eigenvalue")]
    None,
    #[error("the eigenvalue iteration did not converge (off by {0:.1e}, relatively)")]
    Unconverged(f64),
}

/// The rightmost eigenvalue; of a pair the member with im > 0.
#[derive(Clone, Debug)]
pub struct Rightmost {
    pub value: c64,
    /// The rightmost of all others but its conjugate.
    pub next: Option<c64>,
    /// `M q`, q the right eigenvector.
    pub image: Vec<c64>,
    /// w with `w^H (A + sigma M) = 0`.
    pub left: Vec<c64>,
    /// The size of the leading eigenvalues: a shift for pencils nearby is about 1.5 times that.
    pub size: f64,
}

/// Steps of inverse iteration; each gains the digits that the eigenvalue has.
const STEPS: usize = 2;
/// A polished value further off than this, in parts of its distance from the shift, is another eigenvalue.
const FAR: f64 = 1e-4;
/// Eigenvalues whose size counts as that of the leading ones.
const LEADING: usize = 4;

/// The rightmost eigenvalue of `A + sigma M`, both real and n by n; `shift` as for [`pencil`].
pub fn rightmost(a: MatRef<'_, f64>, m: MatRef<'_, f64>, shift: f64) -> Result<Rightmost, EigenFailure> {
    let n = a.nrows();
    let all = pencil(a, m, shift, 0)?;
    let rough = all.first().ok_or(EigenFailure::None)?.value;
    let next = all.iter().skip(1).map(|pair| pair.value).find(|z| z.im >= 0.0);
    let size = all.iter().take(LEADING).map(|pair| pair.value.norm()).fold(0.0, f64::max);

    let shifted = |s: c64| Mat::from_fn(n, n, |i, j| s * m[(i, j)] + a[(i, j)]);
    // At an eigenvalue to the last bit a pivot may vanish: half a digit beside it none does.
    let beside = rough + 10.0 * f64::EPSILON * (shift + rough.norm());
    let (s, lu) = match Lu::new(shifted(rough)) {
        Ok(lu) => (rough, lu),
        Err(Singular) => (beside, Lu::new(shifted(beside))?),
    };
    let start = |n: usize| -> Vec<c64> { (0..n).map(|i| c64::new(1.0 + 0.5 * (i as f64).sin(), 0.0)).collect() };
    let (mut x, mut y) = (start(n), start(n));
    for _ in 0..STEPS {
        x = times(m, &x, false);
        lu.solve(&mut x);
        normalise(&mut x);
        y = times(m, &y, true);
        lu.solve_adjoint(&mut y);
        normalise(&mut y);
    }
    let image = times(m, &x, false);
    let moved: Vec<c64> = times(a, &x, false).iter().zip(&image).map(|(a, m)| a + s * m).collect();
    let change = product(&y, &moved) / product(&y, &image);
    let mut value = s - change;
    if rough.im == 0.0 {
        value.im = 0.0;
    }
    let off = (value - rough).norm() / (rough - shift).norm();
    if off.is_nan() || off > FAR {
        return Err(EigenFailure::Unconverged(off));
    }
    Ok(Rightmost { value, next, image, left: y, size })
}

impl Rightmost {
    /// How much two eigenvectors of neighbouring pencils are the same, by biorthogonality:
    /// `|w_a^H z_b| |w_b^H z_a| / (|w_a^H z_a| |w_b^H z_b|)` with z = M q. Equal modes give 1, different modes of one
    /// pencil 0.
    pub fn likeness(&self, other: &Self) -> f64 {
        let across = product(&self.left, &other.image) * product(&other.left, &self.image);
        let along = product(&self.left, &self.image) * product(&other.left, &other.image);
        if along.norm() > 0.0 { across.norm() / along.norm() } else { 0.0 }
    }
}

/// `y^H z`.
fn product(y: &[c64], z: &[c64]) -> c64 {
    y.iter().zip(z).map(|(y, z)| y.conj() * z).sum()
}

/// `B x` or `B^T x`.
fn times(b: MatRef<'_, f64>, x: &[c64], transposed: bool) -> Vec<c64> {
    let b = if transposed { b.transpose() } else { b };
    let mut out = vec![c64::new(0.0, 0.0); x.len()];
    for (j, &x) in x.iter().enumerate() {
        for (i, out) in out.iter_mut().enumerate() {
            *out += x * b[(i, j)];
        }
    }
    out
}

fn normalise(x: &mut [c64]) {
    let norm = x.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
    x.iter_mut().for_each(|z| *z /= norm);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_and_a_real_one_compete() {
        // u' = g u - 2 w, w' = 2 u + g w, z' = h z + u, in units in which M is not the identity.
        let at = |g: f64, h: f64| {
            let a = faer::mat![[-2.0 * g, 4.0, 0.0], [-2.0, -g, 0.0], [-3.0, 0.0, -3.0 * h]];
            let m = faer::mat![[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 3.0]];
            rightmost(a.as_ref(), m.as_ref(), 3.0).unwrap()
        };
        let (pair, same, real) = (at(0.5, -1.0), at(0.6, -1.2), at(0.5, 0.75));
        assert!((pair.value - c64::new(0.5, 2.0)).norm() < 1e-15);
        assert!((pair.next.unwrap() - c64::new(-1.0, 0.0)).norm() < 1e-14);
        assert!((real.value - c64::new(0.75, 0.0)).norm() < 1e-15 && real.value.im == 0.0);
        assert!(pair.likeness(&same) > 0.9 && pair.likeness(&real) < 0.1);
    }
}
