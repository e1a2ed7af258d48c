//! Bordered systems with a real matrix of any structure and any number of borders:
//!
//! ```text
//! [ A    B ] [x]   [f]
//! [ C^T  D ] [y] = [g]        A n by n, B and C n by m, D m by m.
//! ```

use super::{Lu, Matrix, Singular};
use faer::Mat;

/// The factored bordered matrix; it may be regular where A itself is singular.
pub struct BorderedMatrix {
    whole: Lu<f64>,
}

impl BorderedMatrix {
    /// `b` and `c` are the columns of B and C, `d` the rows of D.
    pub fn new(a: &Matrix, b: &[&[f64]], c: &[&[f64]], d: &[&[f64]]) -> Result<Self, Singular> {
        let Matrix::Dense(a) = a else { return Self::new(&Matrix::Dense(a.clone().into_dense()), b, c, d) };
        let n = a.nrows();
        let full = Mat::from_fn(n + b.len(), n + c.len(), |i, j| match (i < n, j < n) {
            (true, true) => a[(i, j)],
            (true, false) => b[j - n][i],
            (false, true) => c[i - n][j],
            (false, false) => d[i - n][j - n],
        });
        Ok(Self { whole: Lu::new(full.as_ref())? })
    }

    /// `[f; g]` in, `[x; y]` out.
    pub fn solve(&self, fg: &mut [f64]) {
        self.whole.solve(fg);
    }

    /// The same with the transpose.
    pub fn solve_transposed(&self, fg: &mut [f64]) {
        self.whole.solve_adjoint(fg);
    }

    /// Sign of the determinant.
    pub fn sign(&self) -> f64 {
        self.whole.sign()
    }
}
