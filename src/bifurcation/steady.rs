//! G_u with borders, so that it may be solved with where it is singular; the vectors of its kernel.

use crate::linalg::{BorderedMatrix, Matrix, Singular, dot};
use faer::MatRef;

/// G_u with its borders.
pub(super) struct Steady {
    bordered: BorderedMatrix,
    size: f64,
}

impl Steady {
    pub fn new(gu: MatRef<'_, f64>, beta: &[f64], gamma: &[f64]) -> Result<Self, Singular> {
        Self::structured(&Matrix::Dense(gu.to_owned()), beta, gamma)
    }

    pub fn structured(gu: &Matrix, beta: &[f64], gamma: &[f64]) -> Result<Self, Singular> {
        // The border stands for a vector of G_u's size; its unknown is measured accordingly.
        let size = size(gu);
        let scaled = |x: &[f64]| -> Vec<f64> { x.iter().map(|x| size * x).collect() };
        Ok(Self { bordered: BorderedMatrix::new(gu, &[&scaled(beta)], &[&scaled(gamma)], &[&[0.0]])?, size })
    }

    /// (du, mu) for right-hand sides f and t.
    pub fn solve(&self, f: &[f64], t: f64) -> Vec<f64> {
        let mut x = f.to_vec();
        x.push(self.size * t);
        self.bordered.solve(&mut x);
        x
    }

    /// The left vector w that tells how `(q, mu) = solve(0, 1)` varies: `dmu = -w^T dG_u q`.
    pub fn left(&self, n: usize) -> Vec<f64> {
        let mut x = vec![0.0; n];
        x.push(1.0);
        self.bordered.solve_transposed(&mut x);
        x
    }
}

/// The largest entry's size. One equation alone has no other entry to take it from where it is singular.
pub(super) fn size(gu: &Matrix) -> f64 {
    if gu.n() > 1 { gu.norm_max() } else { 1.0 }
}

/// The same or the opposite vector, so that the largest entry is positive.
pub(super) fn positive(x: &[f64]) -> Vec<f64> {
    let largest = x.iter().fold(0.0_f64, |best, x| if x.abs() > best.abs() * (1.0 + 1e-6) { *x } else { best });
    x.iter().map(|x| x * largest.signum()).collect()
}

/// The left vector in the direction of w with `w^T M q = 1`.
pub(super) fn adjoint(mass: &Matrix, q: &[f64], w: &[f64]) -> Vec<f64> {
    let mut image = vec![0.0; q.len()];
    mass.times(q, &mut image);
    let product = dot(w, &image);
    w.iter().map(|w| w / product).collect()
}
