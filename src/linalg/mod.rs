//! Linear algebra, dense and sparse on faer, and banded: factor once, solve often. Everything here runs on one thread; parallelism belongs
//! to those who have several systems to solve.

mod banded;
mod bordered;
mod direction;
mod eigen;
mod elimination;
mod equilibrated;
mod factors;
mod krylov;
mod lu;
mod matrix;
pub mod periodic;
mod rightmost;
mod sparse;

pub use banded::{Banded, BandedLu, LANES};
pub use bordered::{BorderedMatrix, BorderedPencil};
pub use direction::{any, norm, real_direction, unit};
pub use eigen::{Eigenpair, growth, pencil, shifted};
pub use equilibrated::Equilibrated;
pub use factors::{Factors, PencilFactors};
pub use krylov::{Leading, leading, nearest};
pub use lu::{Bordered, Lu, Singular, eliminate, permute};
pub use matrix::{Matrix, Structure};
pub use rightmost::{EigenFailure, Rightmost, rightmost};
pub use sparse::{Pattern, Sparse, SparseLu};

pub use faer::c64;

/// The dot product, in eight sums side by side: one alone would wait for each of its additions.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let count = a.len().min(b.len());
    let (a, b) = (&a[..count], &b[..count]);
    let mut sums = [0.0; LANES];
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Whether every entry is finite.
pub fn finite(a: &[f64]) -> bool {
    a.iter().all(|a| a.is_finite())
}
