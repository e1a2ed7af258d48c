//! G_u with borders, so that it may be solved with where it is singular.

use crate::linalg::{Bordered, Singular};
use faer::MatRef;

/// G_u with its borders.
pub(super) struct Steady {
    bordered: Bordered<f64>,
    size: f64,
}

impl Steady {
    pub fn new(gu: MatRef<'_, f64>, beta: &[f64], gamma: &[f64]) -> Result<Self, Singular> {
        // The border stands for a vector of G_u's size; its unknown is measured accordingly. One equation alone has no
        // other entry to take the size from where it is singular.
        let size = if gu.nrows() > 1 { gu.norm_max() } else { 1.0 };
        let scaled = |x: &[f64]| -> Vec<f64> { x.iter().map(|x| size * x).collect() };
        Ok(Self { bordered: Bordered::new(gu, &scaled(beta), &scaled(gamma), 0.0)?, size })
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
        self.bordered.solve_adjoint(&mut x);
        x
    }
}
