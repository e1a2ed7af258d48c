//! A square matrix in the form that its problem's structure allows.

use faer::{Mat, MatMut, MatRef};

/// What is known of a Jacobian's pattern. Banded and sparse forms take their place here and in [`Matrix`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Structure {
    #[default]
    Dense,
}

/// A square matrix of that structure.
#[derive(Clone, Debug)]
pub enum Matrix {
    Dense(Mat<f64>),
}

impl Matrix {
    pub fn zeros(structure: Structure, n: usize) -> Self {
        match structure {
            Structure::Dense => Matrix::Dense(Mat::zeros(n, n)),
        }
    }

    /// All entries, row by column.
    pub fn dense(&self) -> MatRef<'_, f64> {
        match self {
            Matrix::Dense(a) => a.as_ref(),
        }
    }

    /// All entries, to be filled in.
    pub fn dense_mut(&mut self) -> MatMut<'_, f64> {
        match self {
            Matrix::Dense(a) => a.as_mut(),
        }
    }
}
