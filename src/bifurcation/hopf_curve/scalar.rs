//! The bordered scalar of the pencil `A(sigma) = G_u + sigma G_v` at `sigma² = -kappa`, as a pair of real numbers.
//!
//! With real borders b and c the scalar g of
//!
//! ```text
//! [ A(sigma)  b ] [q]   [0]
//! [ c^T       0 ] [g] = [1]
//! ```
//!
//! is a real function of sigma, so `g = a(kappa) + sigma b(kappa)` and `q = q_r + sigma q_s`. Numbers of this form, with
//! sigma² = -kappa, are complex for kappa > 0, dual for kappa = 0 and split for kappa < 0; written out as a real system of
//! twice the size the pair (a, b) is smooth in kappa through all of them:
//!
//! ```text
//! [ G_u  -kappa G_v  b  . ] [q_r]   [0]
//! [ G_v   G_u        .  b ] [q_s] = [0]
//! [ c^T   .          .  . ] [ a ]   [1]
//! [ .     c^T        .  . ] [ b ]   [0]
//! ```
//!
//! `a = b = 0` holds at Hopf points (kappa = omega² > 0), regularly through Bogdanov-Takens points (kappa = 0) to
//! neutral saddles (kappa < 0), where g = 0 at sigma = i omega alone has a branch point; compare the squared Jacobian
//! `J² + kappa I` of Guckenheimer, Myers and Sturmfels 1997 (doi:10.1137/S0036142993253461), which this form replaces for
//! pencils. Derivatives follow from the left solutions: `d(a, b) = -W^T dK Q`.

use super::Borders;
use crate::linalg::{Lu, Singular, c64, dot};
use crate::problem::{At, Direction, Problem};
use faer::{Mat, MatRef};

/// The pair (a, b) at one point; sigma is measured in units of `unit`, so that all blocks are of one size.
pub struct Scalar {
    pub a: f64,
    pub b: f64,
    unit: f64,
    /// kappa / unit².
    kappa: f64,
    right: [Vec<f64>; 2],
    /// For a and for b: the left solution's upper and lower halves.
    left: [[Vec<f64>; 2]; 2],
}

impl Scalar {
    pub fn new(gu: MatRef<'_, f64>, gv: MatRef<'_, f64>, kappa: f64, borders: &Borders) -> Result<Self, Singular> {
        let n = gu.nrows();
        let unit = borders.unit;
        let kappa = kappa / (unit * unit);
        // Borders with entries of the matrix's own size keep it well conditioned.
        let size = gu.norm_max().max(unit * gv.norm_max());
        let mut full = Mat::zeros(2 * n + 2, 2 * n + 2);
        for j in 0..n {
            for i in 0..n {
                full[(i, j)] = gu[(i, j)];
                full[(n + i, n + j)] = gu[(i, j)];
                full[(n + i, j)] = unit * gv[(i, j)];
                full[(i, n + j)] = -kappa * unit * gv[(i, j)];
            }
            for half in 0..2 {
                full[(half * n + j, 2 * n + half)] = size * borders.column[j];
                full[(2 * n + half, half * n + j)] = size * borders.row[j];
            }
        }
        let lu = Lu::new(full)?;
        let solution = |row: usize, transposed: bool| {
            let mut x = vec![0.0; 2 * n + 2];
            x[2 * n + row] = size;
            if transposed {
                lu.solve_adjoint(&mut x)
            } else {
                lu.solve(&mut x)
            }
            x
        };
        let halves = |x: &[f64], factor: f64| [0, n].map(|k| x[k..k + n].iter().map(|x| factor * x).collect());
        let right = solution(0, false);
        let left = [0, 1].map(|row| halves(&solution(row, true), 1.0 / size));
        Ok(Self { a: right[2 * n], b: right[2 * n + 1], unit, kappa, right: halves(&right, 1.0), left })
    }

    /// d(a, b)/d kappa: only the block `-kappa G_v` depends on it.
    pub fn by_kappa(&self, gv: MatRef<'_, f64>) -> [f64; 2] {
        let n = gv.nrows();
        let moved: Vec<f64> = (0..n).map(|i| (0..n).map(|j| gv[(i, j)] * self.right[1][j]).sum()).collect();
        [0, 1].map(|row| dot(&self.left[row][0], &moved) / self.unit)
    }

    /// d(a, b) along a direction of (u, p): `A q` is varied at fixed q, once for each half.
    pub fn along(&self, problem: &dyn Problem, at: At, direction: Direction) -> [f64; 2] {
        let [r, s] = &self.right;
        let scaled = |x: &[f64], factor: f64| -> Vec<f64> { x.iter().map(|x| factor * x).collect() };
        let halves = [(r, scaled(s, -self.kappa * self.unit)), (s, scaled(r, self.unit))];
        let mut sum = [0.0; 2];
        let mut out = vec![0.0; r.len()];
        for (half, (u, v)) in halves.iter().enumerate() {
            problem.derivative(at, &[Direction { u, v, p: &[] }, direction], &mut out);
            for (sum, left) in sum.iter_mut().zip(&self.left) {
                *sum -= dot(&left[half], &out);
            }
        }
        sum
    }

    /// The eigenvector `q_r + i omega q_s` at a point with kappa = omega².
    pub fn vector(&self) -> Vec<c64> {
        let omega = self.kappa.max(0.0).sqrt();
        self.right[0].iter().zip(&self.right[1]).map(|(&r, &s)| c64::new(r, omega * s)).collect()
    }

    /// The left eigenvector, in any normalisation.
    pub fn left_vector(&self) -> Vec<c64> {
        // (a + sigma b) varies as -w^T dA q; the upper block of the a-row is w_r, that of the b-row is w_s.
        let omega = self.kappa.max(0.0).sqrt();
        self.left[0][0].iter().zip(&self.left[1][0]).map(|(&r, &s)| c64::new(r, -omega * s)).collect()
    }
}
