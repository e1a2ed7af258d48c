//! LU factors of a matrix, or of a pencil at a complex point, in the form that its structure allows.

use super::sparse::{self, SparseLu};
use super::{BandedLu, LANES, Lu, Matrix, Pattern, Singular, c64};
use faer::Mat;

/// What can be solved with.
pub(super) trait Base<T> {
    /// `A^-1 x` in place.
    fn solve(&self, x: &mut [T]);
    /// `A^-H x` in place.
    fn solve_adjoint(&self, x: &mut [T]);
}

/// Factors of a real matrix.
pub enum Factors {
    Dense(Lu<f64>),
    Banded(BandedLu),
    /// The sparse factors know nothing of the determinant.
    Sparse(Box<(SparseLu<f64>, sparse::Sparse)>),
}

impl Factors {
    pub fn new(a: &Matrix) -> Result<Self, Singular> {
        Ok(match a {
            Matrix::Dense(a) => Factors::Dense(Lu::new(a.clone())?),
            Matrix::Banded(a) => Factors::Banded(BandedLu::new(a)?),
            Matrix::Sparse(a) => Factors::Sparse(Box::new((SparseLu::new(&a.pattern, &a.values)?, a.clone()))),
        })
    }

    /// `A^-1 b` in place.
    pub fn solve(&self, b: &mut [f64]) {
        match self {
            Factors::Dense(lu) => lu.solve(b),
            Factors::Banded(lu) => lu.solve(b),
            Factors::Sparse(made) => made.0.solve(b),
        }
    }

    /// `A^-1 B` in place.
    pub fn solve_many(&self, b: &mut Mat<f64>) {
        match self {
            Factors::Dense(lu) => lu.solve_many(b.as_mut()),
            Factors::Banded(lu) => {
                let mut strip = vec![[0.0; LANES]; b.nrows()];
                for start in (0..b.ncols()).step_by(LANES) {
                    let columns = start..(start + LANES).min(b.ncols());
                    for (i, row) in strip.iter_mut().enumerate() {
                        columns.clone().zip(row).for_each(|(j, x)| *x = b[(i, j)]);
                    }
                    lu.solve_strip(&mut strip);
                    for (i, row) in strip.iter().enumerate() {
                        columns.clone().zip(row).for_each(|(j, x)| b[(i, j)] = *x);
                    }
                }
            }
            Factors::Sparse(made) => (0..b.ncols()).for_each(|j| made.0.solve(b.col_as_slice_mut(j))),
        }
    }

    /// `A^-T b` in place.
    pub fn solve_transposed(&self, b: &mut [f64]) {
        match self {
            Factors::Dense(lu) => lu.solve_adjoint(b),
            Factors::Banded(lu) => lu.solve_transposed(b),
            Factors::Sparse(made) => made.0.solve_adjoint(b),
        }
    }

    /// Sign of the determinant, if it is known.
    pub fn sign(&self) -> Option<f64> {
        match self {
            Factors::Dense(lu) => Some(lu.sign()),
            Factors::Banded(lu) => Some(lu.sign()),
            Factors::Sparse(made) => sparse::sign(&made.1).ok(),
        }
    }
}

impl Base<f64> for Factors {
    fn solve(&self, x: &mut [f64]) {
        Factors::solve(self, x);
    }

    fn solve_adjoint(&self, x: &mut [f64]) {
        self.solve_transposed(x);
    }
}

/// Factors of `A + s M`, s complex.
pub enum PencilFactors {
    Dense(Lu<c64>),
    Sparse(Box<SparseLu<c64>>),
}

impl PencilFactors {
    /// A and M have the same structure.
    pub fn new(a: &Matrix, m: &Matrix, s: c64) -> Result<Self, Singular> {
        match (a, m) {
            (Matrix::Dense(a), Matrix::Dense(m)) => {
                let shifted = Mat::from_fn(a.nrows(), a.ncols(), |i, j| s * m[(i, j)] + a[(i, j)]);
                Ok(PencilFactors::Dense(Lu::new(shifted)?))
            }
            (Matrix::Sparse(a), Matrix::Sparse(m)) if a.pattern == m.pattern => {
                let values: Vec<c64> = a.values.iter().zip(&m.values).map(|(&a, &m)| s * m + a).collect();
                Ok(PencilFactors::Sparse(Box::new(SparseLu::new(&a.pattern, &values)?)))
            }
            _ => {
                let n = a.n();
                let entries = |x: &Matrix| x.entries().into_iter().map(|(i, j, _)| (i, j)).collect::<Vec<_>>();
                let pattern = Pattern::new(n, entries(a).into_iter().chain(entries(m)));
                let mut values = vec![c64::new(0.0, 0.0); pattern.entries()];
                for (matrix, factor) in [(a, c64::new(1.0, 0.0)), (m, s)] {
                    for (i, j, x) in matrix.entries() {
                        let (range, rows) = pattern.column(j);
                        if let Ok(k) = rows.binary_search(&i) {
                            values[range.start + k] += factor * x;
                        }
                    }
                }
                Ok(PencilFactors::Sparse(Box::new(SparseLu::new(&pattern, &values)?)))
            }
        }
    }

    /// `(A + s M)^-1 b` in place.
    pub fn solve(&self, b: &mut [c64]) {
        match self {
            PencilFactors::Dense(lu) => lu.solve(b),
            PencilFactors::Sparse(lu) => lu.solve(b),
        }
    }

    /// `(A + s M)^-H b` in place.
    pub fn solve_adjoint(&self, b: &mut [c64]) {
        match self {
            PencilFactors::Dense(lu) => lu.solve_adjoint(b),
            PencilFactors::Sparse(lu) => lu.solve_adjoint(b),
        }
    }
}

impl Base<c64> for PencilFactors {
    fn solve(&self, x: &mut [c64]) {
        PencilFactors::solve(self, x);
    }

    fn solve_adjoint(&self, x: &mut [c64]) {
        PencilFactors::solve_adjoint(self, x);
    }
}
