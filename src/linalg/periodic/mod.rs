//! Eigenvalues of a product `P = A_N .. A_2 A_1` of real square matrices that is never multiplied.
//!
//! Each eigenvalue comes as the logarithm of its modulus and its direction, so that 1e-200 beside 1 and what would
//! overflow are right: errors are those of changes of each factor by a few units of rounding of its own norm.
//! [`all`] takes `O(N n³)` operations, [`leading`] the work of applying the product a few times.

mod balance;
mod cyclic;
mod dense;
mod iteration;
mod krylov;
mod order;
mod ritz;
mod scaled;
mod strip;
mod subspace;
#[cfg(test)]
mod tests;

use cyclic::Cyclic;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par, c64};
use std::f64::consts::LN_2;
use thiserror::Error;

pub use krylov::leading;

/// `e^ln direction`, |direction| = 1; zero is `ln = -inf`, direction 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eigenvalue {
    pub ln: f64,
    pub direction: c64,
}

impl Eigenvalue {
    const ZERO: Self = Self { ln: f64::NEG_INFINITY, direction: c64::new(1.0, 0.0) };

    /// As a number: zero or infinite where it is out of reach.
    pub fn value(&self) -> c64 {
        let size = self.ln.exp();
        let part = |x: f64| if x == 0.0 { 0.0 } else { size * x };
        c64::new(part(self.direction.re), part(self.direction.im))
    }
}

/// Why there are no eigenvalues.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum PeriodicError {
    #[error("factor {factor} of the product has entries that are not finite numbers")]
    NotFinite { factor: usize },
    #[error(transparent)]
    Unconverged(#[from] Unconverged),
}

/// The iteration did not end.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("the periodic QR algorithm did not converge: {left} of {n} eigenvalues of the product are missing")]
pub struct Unconverged {
    pub left: usize,
    pub n: usize,
}

/// Factors `A_1 .. A_N`, n by n, in the order in which they are applied; index j stands for `A_{j+1}`.
pub trait Product: Sync {
    /// n.
    fn dim(&self) -> usize;

    /// N, at least 1.
    fn factors(&self) -> usize;

    /// `Y = A X`, X and Y of n rows.
    fn apply(&self, j: usize, x: MatRef<'_, f64>, y: MatMut<'_, f64>);

    /// The factor's entries.
    fn matrix(&self, j: usize) -> Mat<f64> {
        let (n, one) = (self.dim(), Mat::identity(self.dim(), self.dim()));
        let mut out = Mat::zeros(n, n);
        self.apply(j, one.as_ref(), out.as_mut());
        out
    }

    /// The product multiplied out, where that was done anyway: a guess.
    fn formed(&self) -> Option<Mat<f64>> {
        None
    }
}

impl Product for Vec<Mat<f64>> {
    fn dim(&self) -> usize {
        self.first().map_or(0, Mat::nrows)
    }

    fn factors(&self) -> usize {
        self.len()
    }

    fn apply(&self, j: usize, x: MatRef<'_, f64>, y: MatMut<'_, f64>) {
        matmul(y, Accum::Replace, self[j].as_ref(), x, 1.0, Par::Seq);
    }

    fn matrix(&self, j: usize) -> Mat<f64> {
        self[j].clone()
    }
}

/// All n eigenvalues, largest first; of a pair the one with im > 0. Zero columns and rows of the factors give exact
/// zeros.
pub fn all(product: &dyn Product) -> Result<Vec<Eigenvalue>, PeriodicError> {
    let n = product.dim();
    let factors: Vec<Mat<f64>> = (0..product.factors()).map(|j| product.matrix(j)).collect();
    if let Some(factor) = factors.iter().position(|a| !a.is_all_finite()) {
        return Err(PeriodicError::NotFinite { factor });
    }
    let mut values = Vec::with_capacity(n);
    let mut factors = if factors.is_empty() { Vec::new() } else { strip::stripped(&factors) };
    if factors.first().is_some_and(|a| a.rows > 0) {
        balance::balance(&mut factors);
        let mut cyclic = Cyclic::new(factors, false);
        for block in cyclic.iterate()? {
            values.extend(cyclic.values(block));
        }
    }
    values.resize(n, Eigenvalue::ZERO);
    sort(&mut values);
    Ok(values)
}

/// Leaves pairs together: both have the same modulus and real part, and the sort is stable.
fn sort(values: &mut [Eigenvalue]) {
    values.sort_by(|x, y| y.ln.total_cmp(&x.ln).then(y.direction.re.total_cmp(&x.direction.re)));
}

impl Cyclic {
    /// Logarithm of the modulus, and sign, of the product's determinant in a block of the Schur form.
    fn determinant(&self, (i, size): (usize, usize)) -> (f64, f64) {
        let h = self.h();
        let hessenberg = match size {
            1 => h.at(i, i),
            _ => h.at(i, i) * h.at(i + 1, i + 1) - h.at(i, i + 1) * h.at(i + 1, i),
        };
        let diagonal = self.t[..self.last()].iter().flat_map(|t| (i..i + size).map(move |k| t.at(k, k)));
        let (ln, sign) = diagonal
            .fold((hessenberg.abs().ln(), hessenberg.signum()), |(ln, sign), x| (ln + x.abs().ln(), sign * x.signum()));
        (ln + size as f64 * self.exponent(), sign)
    }

    /// Logarithm of what all factors were divided by.
    fn exponent(&self) -> f64 {
        self.exponents.iter().map(|&e| f64::from(e)).sum::<f64>() * LN_2
    }

    /// Eigenvalues of a block of the Schur form, the larger or the one with im > 0 first.
    fn values(&self, block: (usize, usize)) -> Vec<Eigenvalue> {
        let real = |ln: f64, sign: f64| {
            if ln == f64::NEG_INFINITY { Eigenvalue::ZERO } else { Eigenvalue { ln, direction: c64::new(sign, 0.0) } }
        };
        let (ln, sign) = self.determinant(block);
        let (i, 2) = block else { return vec![real(ln, sign)] };
        let corner = self.trailing(i, i + 1);
        let [first, _] = scaled::eigenvalues(&corner.m);
        if first.im > 0.0 && sign > 0.0 {
            let direction = first / first.norm();
            let pair = [direction, direction.conj()];
            return pair.map(|direction| Eigenvalue { ln: ln / 2.0, direction }).to_vec();
        }
        // The smaller from the determinant, which is right where the trace has lost it.
        let large = if first.re == 0.0 {
            ln / 2.0
        } else {
            first.re.abs().ln() + corner.exponent as f64 * LN_2 + self.exponent()
        };
        let large = large.max(ln / 2.0);
        let small = if ln == f64::NEG_INFINITY { ln } else { ln - large };
        vec![real(large, first.re.signum()), real(small, sign * first.re.signum())]
    }
}
