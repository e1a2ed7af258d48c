//! A matrix in the form that its problem's structure allows.

use faer::{Mat, MatRef};

/// What is known of a Jacobian's pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Structure {
    #[default]
    Dense,
}

/// A square or rectangular matrix. Banded and sparse forms take their place here when a problem has that structure.
#[derive(Clone, Debug)]
pub enum Matrix {
    Dense(Mat<f64>),
}

impl Matrix {
    pub fn zeros(structure: Structure, rows: usize, columns: usize) -> Self {
        match structure {
            Structure::Dense => Matrix::Dense(Mat::zeros(rows, columns)),
        }
    }

    pub fn dense(&self) -> MatRef<'_, f64> {
        match self {
            Matrix::Dense(a) => a.as_ref(),
        }
    }
}
