//! A square matrix in the form that its problem's structure allows.

use super::Banded;
use faer::Mat;

/// What is known of a Jacobian's pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Structure {
    #[default]
    Dense,
    /// Entry (i, j) is zero unless `i - lower <= j <= i + upper`.
    Banded { lower: usize, upper: usize },
}

/// A square matrix of that structure.
#[derive(Clone, Debug)]
pub enum Matrix {
    Dense(Mat<f64>),
    Banded(Banded),
}

impl Matrix {
    pub fn zeros(structure: Structure, n: usize) -> Self {
        match structure {
            Structure::Dense => Matrix::Dense(Mat::zeros(n, n)),
            Structure::Banded { lower, upper } => Matrix::Banded(Banded::zeros(n, lower, upper)),
        }
    }

    /// All entries.
    pub fn into_dense(self) -> Mat<f64> {
        match self {
            Matrix::Dense(a) => a,
            Matrix::Banded(a) => Mat::from_fn(a.n(), a.n(), |i, j| a.get(i, j)),
        }
    }

    /// The largest entry's size.
    pub fn norm_max(&self) -> f64 {
        match self {
            Matrix::Dense(a) => a.norm_max(),
            Matrix::Banded(a) => (0..a.n()).flat_map(|i| a.row(i)).fold(0.0, |most, x| most.max(x.abs())),
        }
    }

    /// `y = A x`.
    pub fn times(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Matrix::Dense(a) => {
                y.fill(0.0);
                for (j, &x) in x.iter().enumerate() {
                    y.iter_mut().zip(a.col_as_slice(j)).for_each(|(y, a)| *y += a * x);
                }
            }
            Matrix::Banded(a) => a.times(x, y),
        }
    }
}
