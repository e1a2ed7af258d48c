//! LU factors with partial pivoting, of real and complex matrices, plain and bordered.

use faer::linalg::solvers::{PartialPivLu, SolveCore};
use faer::traits::ComplexField;
use faer::{Conj, Mat, MatMut, MatRef, c64};
use thiserror::Error;

/// The matrix has no inverse in floating point.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("the linear system is singular")]
pub struct Singular;

/// `P A = L U`, ready to solve with A and its (conjugate) transpose.
pub struct Lu<T> {
    factors: PartialPivLu<T>,
    n: usize,
}

impl<T: ComplexField + Finite> Lu<T> {
    /// Factors a square matrix; a zero or non-finite pivot is an error (faer itself would go on).
    pub fn new(a: MatRef<'_, T>) -> Result<Self, Singular> {
        let factors = a.partial_piv_lu();
        let n = a.nrows();
        let sound = (0..n).all(|i| factors.U()[(i, i)].is_sound());
        if sound { Ok(Self { factors, n }) } else { Err(Singular) }
    }

    /// `A^-1 b` in place.
    pub fn solve(&self, b: &mut [T]) {
        let rhs = MatMut::from_column_major_slice_mut(b, self.n, 1);
        self.factors.solve_in_place_with_conj(Conj::No, rhs);
    }

    /// `A^-1 B` in place.
    pub fn solve_many(&self, b: MatMut<'_, T>) {
        self.factors.solve_in_place_with_conj(Conj::No, b);
    }

    /// `A^-H b` in place.
    pub fn solve_adjoint(&self, b: &mut [T]) {
        let rhs = MatMut::from_column_major_slice_mut(b, self.n, 1);
        self.factors.solve_transpose_in_place_with_conj(Conj::Yes, rhs);
    }
}

impl Lu<f64> {
    /// Sign of the determinant.
    pub fn sign(&self) -> f64 {
        let sign = super::sparse::parity(self.factors.P().arrays().0);
        (0..self.n).fold(sign, |sign, i| sign * self.factors.U()[(i, i)].signum())
    }
}

/// Pivots that can be divided by.
pub trait Finite {
    fn is_sound(&self) -> bool;
}

impl Finite for f64 {
    fn is_sound(&self) -> bool {
        self.is_finite() && *self != 0.0
    }
}

impl Finite for c64 {
    fn is_sound(&self) -> bool {
        self.re.is_finite() && self.im.is_finite() && (self.re != 0.0 || self.im != 0.0)
    }
}

/// The bordered system
///
/// ```text
/// [ A    b ] [x]   [f]
/// [ c^H  d ] [y] = [g]
/// ```
///
/// factored as one matrix, so that it may be solved where A itself is singular.
pub struct Bordered<T> {
    lu: Lu<T>,
}

impl<T: ComplexField + Finite> Bordered<T> {
    pub fn new(a: MatRef<'_, T>, b: &[T], c: &[T], d: T) -> Result<Self, Singular> {
        let n = a.nrows();
        let full = Mat::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
            (true, true) => a[(i, j)].clone(),
            (true, false) => b[i].clone(),
            (false, true) => faer::traits::math_utils::conj(&c[j]),
            (false, false) => d.clone(),
        });
        Ok(Self { lu: Lu::new(full.as_ref())? })
    }

    /// `[f; g]` in, `[x; y]` out.
    pub fn solve(&self, fg: &mut [T]) {
        self.lu.solve(fg);
    }

    /// The same with the conjugate transpose.
    pub fn solve_adjoint(&self, fg: &mut [T]) {
        self.lu.solve_adjoint(fg);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_and_signs() {
        let a = Mat::from_fn(4, 4, |i, j| 1.0 / (1.0 + i as f64 + 2.0 * j as f64) + if i == 3 - j { 1.0 } else { 0.0 });
        let lu = Lu::new(a.as_ref()).unwrap();
        assert_eq!(lu.sign(), a.determinant().signum());
        let x = [1.0, -2.0, 3.0, 0.5];
        let mut b: Vec<f64> = (0..4).map(|i| (0..4).map(|j| a[(i, j)] * x[j]).sum()).collect();
        lu.solve(&mut b);
        let mut bt: Vec<f64> = (0..4).map(|i| (0..4).map(|j| a[(j, i)] * x[j]).sum()).collect();
        lu.solve_adjoint(&mut bt);
        for i in 0..4 {
            assert!((b[i] - x[i]).abs() < 1e-13 && (bt[i] - x[i]).abs() < 1e-13);
        }
        assert!(Lu::new(Mat::<f64>::zeros(3, 3).as_ref()).is_err());
    }
}
