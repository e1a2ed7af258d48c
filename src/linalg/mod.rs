//! Linear algebra, dense and sparse on faer, and banded: factor once, solve often. Everything here runs on one thread; parallelism belongs
//! to those who have several systems to solve.

mod banded;
mod bordered;
mod eigen;
mod elimination;
mod factors;
mod krylov;
mod lu;
mod matrix;
mod rightmost;
mod sparse;

pub use banded::{Banded, BandedLu};
pub use bordered::{BorderedMatrix, BorderedPencil};
pub use eigen::{Eigenpair, pencil};
pub use factors::{Factors, PencilFactors};
pub use krylov::{Leading, leading, nearest};
pub use lu::{Bordered, Lu, Singular};
pub use matrix::{Matrix, Structure};
pub use rightmost::{EigenFailure, Rightmost, rightmost};
pub use sparse::{Pattern, Sparse, SparseLu};

pub use faer::c64;

/// The dot product.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Whether every entry is finite.
pub fn finite(a: &[f64]) -> bool {
    a.iter().all(|a| a.is_finite())
}
