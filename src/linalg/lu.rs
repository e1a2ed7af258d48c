//! LU factors with partial pivoting, of real and complex matrices, plain and bordered.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place_with_conj, solve_unit_lower_triangular_in_place,
    solve_unit_upper_triangular_in_place_with_conj, solve_upper_triangular_in_place,
};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::traits::ComplexField;
use faer::{Conj, Mat, MatMut, MatRef, Par, c64};
use thiserror::Error;

/// The matrix has no inverse in floating point.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("the linear system is singular")]
pub struct Singular;

/// `P A = L U`, ready to solve with A and its (conjugate) transpose.
pub struct Lu<T> {
    /// L below the diagonal, U on and above it.
    factors: Mat<T>,
    /// Row i of P A is row `order[i]` of A.
    order: Vec<usize>,
}

impl<T: ComplexField + Finite> Lu<T> {
    /// Factors a square matrix in its own memory; a zero or non-finite pivot is an error (faer itself would go on).
    pub fn new(mut a: Mat<T>) -> Result<Self, Singular> {
        let order = eliminate(&mut a)?;
        Ok(Self { factors: a, order })
    }

    /// `A^-1 b` in place.
    pub fn solve(&self, b: &mut [T]) {
        self.solve_many(MatMut::from_column_major_slice_mut(b, self.order.len(), 1));
    }

    /// `A^-1 B` in place.
    pub fn solve_many(&self, mut b: MatMut<'_, T>) {
        permute(b.rb_mut(), &self.order);
        solve_unit_lower_triangular_in_place(self.factors.as_ref(), b.rb_mut(), Par::Seq);
        solve_upper_triangular_in_place(self.factors.as_ref(), b, Par::Seq);
    }

    /// `A^-H b` in place.
    pub fn solve_adjoint(&self, b: &mut [T]) {
        let mut x = MatMut::from_column_major_slice_mut(b, self.order.len(), 1);
        let adjoint = self.factors.transpose();
        solve_lower_triangular_in_place_with_conj(adjoint, Conj::Yes, x.rb_mut(), Par::Seq);
        solve_unit_upper_triangular_in_place_with_conj(adjoint, Conj::Yes, x, Par::Seq);
        let solved = b.to_vec();
        self.order.iter().zip(solved).for_each(|(&i, x)| b[i] = x);
    }
}

impl Lu<f64> {
    /// Sign of the determinant.
    pub fn sign(&self) -> f64 {
        let sign = super::sparse::parity(&self.order);
        (0..self.order.len()).fold(sign, |sign, i| sign * self.factors[(i, i)].signum())
    }
}

/// Elimination of a tall (or square) matrix's columns by partial pivoting, in place: L below the diagonal, U on and above it;
/// the order of its rows.
pub fn eliminate<T: ComplexField + Finite>(a: &mut Mat<T>) -> Result<Vec<usize>, Singular> {
    let (rows, columns) = (a.nrows(), a.ncols());
    let (mut order, mut inverse) = (vec![0_usize; rows], vec![0_usize; rows]);
    let mut memory = MemBuffer::new(lu_in_place_scratch::<usize, T>(rows, columns, Par::Seq, Default::default()));
    let stack = MemStack::new(&mut memory);
    lu_in_place(a.as_mut(), &mut order, &mut inverse, Par::Seq, stack, Default::default());
    if (0..columns).all(|i| a[(i, i)].is_sound()) { Ok(order) } else { Err(Singular) }
}

/// Brings rows into a new order.
pub fn permute<T: Clone>(mut a: MatMut<'_, T>, order: &[usize]) {
    let mut before = Vec::with_capacity(order.len());
    for column in a.rb_mut().col_iter_mut() {
        before.clear();
        before.extend(column.rb().iter().cloned());
        column.iter_mut().zip(order).for_each(|(x, &i)| *x = before[i].clone());
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
        Ok(Self { lu: Lu::new(full)? })
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
        let lu = Lu::new(a.clone()).unwrap();
        assert_eq!(lu.sign(), a.determinant().signum());
        let x = [1.0, -2.0, 3.0, 0.5];
        let mut b: Vec<f64> = (0..4).map(|i| (0..4).map(|j| a[(i, j)] * x[j]).sum()).collect();
        lu.solve(&mut b);
        let mut bt: Vec<f64> = (0..4).map(|i| (0..4).map(|j| a[(j, i)] * x[j]).sum()).collect();
        lu.solve_adjoint(&mut bt);
        for i in 0..4 {
            assert!((b[i] - x[i]).abs() < 1e-13 && (bt[i] - x[i]).abs() < 1e-13);
        }
        assert!(Lu::new(Mat::<f64>::zeros(3, 3)).is_err());
    }
}
