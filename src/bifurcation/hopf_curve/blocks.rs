//! The factored Jacobian of a Hopf curve, by block elimination.
//!
//! Never is g_u formed. With G_u itself bordered, so that it may be singular (at zero-Hopf points),
//!
//! ```text
//! [ G_u     beta ] [du]   [r - G_1 dz1 - G_2 dz2]
//! [ gamma^T   0  ] [mu] = [          t          ],      mu = 0,
//! ```
//!
//! du is a combination of four solutions with known vectors; derivatives of (a, b) along them and `mu = 0` leave a system
//! of four equations for t, d kappa, dz1 and dz2, whose last row is the border (Govaerts 2000,
//! doi:10.1137/1.9780898719543, chapters 3 and 4, has both ideas).

use super::HopfCurve;
use super::scalar::Scalar;
use crate::bifurcation::steady::Steady;
use crate::continuation::{Border, Factored};
use crate::linalg::{Lu, Singular, dot};
use crate::problem::{At, Direction, Problem};
use faer::Mat;
use std::sync::Arc;

/// Factors at one point.
pub struct HopfFactors {
    problem: Arc<dyn Problem>,
    u: Vec<f64>,
    p: Vec<f64>,
    scalar: Scalar,
    steady: Steady,
    /// (u, mu) for right-hand sides G_1 and G_2, and for t = 1.
    by_parameters: [Vec<f64>; 2],
    by_t: Vec<f64>,
    /// The border's row for u.
    row: Vec<f64>,
    small: Lu<f64>,
    /// What the four rows were divided by.
    sizes: [f64; 4],
    unit_kappa: f64,
}

impl HopfFactors {
    pub fn new(curve: &HopfCurve, x: &[f64], lambda: f64, border: &Border) -> Result<Self, Singular> {
        let n = curve.problem.dim();
        let problem = &*curve.problem;
        let (u, kappa, z) = (&x[..n], x[n], [x[n + 1], lambda]);
        let (gu, gv, p) = curve.linearised(u, z);
        let rest = vec![0.0; n];
        let at = At { u, v: &rest, p: &p };
        let scalar = Scalar::new(gu.dense(), gv.dense(), kappa, &curve.borders)?;
        let steady = Steady::new(gu.dense(), &curve.borders.beta, &curve.borders.gamma)?;
        let zero = vec![0.0; n];
        let by_t = steady.solve(&zero, 1.0);
        let unit_kappa = curve.borders.unit.powi(2);

        let mut small = Mat::zeros(4, 4);
        let g_kappa = scalar.by_kappa(gv.dense());
        let g_t = scalar.along(problem, at, Direction { u: &by_t[..n], v: &[], p: &[] });
        small[(0, 0)] = by_t[n];
        small[(3, 0)] = dot(&border.row[..n], &by_t[..n]);
        for row in 0..2 {
            (small[(1 + row, 0)], small[(1 + row, 1)]) = (g_t[row], g_kappa[row] * unit_kappa);
        }
        small[(3, 1)] = border.row[n] * unit_kappa;
        let mut by_parameters = [Vec::new(), Vec::new()];
        for (k, coordinate) in [curve.first, curve.second].into_iter().enumerate() {
            let mut e = vec![0.0; p.len()];
            e[coordinate.index] = coordinate.rate(z[k]);
            let mut g = vec![0.0; n];
            problem.derivative(at, &[Direction { u: &[], v: &[], p: &e }], &mut g);
            let solved = steady.solve(&g, 0.0);
            let back: Vec<f64> = solved[..n].iter().map(|x| -x).collect();
            let g_z = scalar.along(problem, at, Direction { u: &back, v: &[], p: &e });
            small[(0, 2 + k)] = -solved[n];
            (small[(1, 2 + k)], small[(2, 2 + k)]) = (g_z[0], g_z[1]);
            let own = if k == 0 { border.row[n + 1] } else { border.lambda };
            small[(3, 2 + k)] = own - dot(&border.row[..n], &solved[..n]);
            by_parameters[k] = solved;
        }
        // Rows of one size: the pivots of so small a system would otherwise depend on units.
        let sizes = [0, 1, 2, 3].map(|i| (0..4).map(|j| small[(i, j)].abs()).fold(f64::MIN_POSITIVE, f64::max));
        let small = Mat::from_fn(4, 4, |i, j| small[(i, j)] / sizes[i]);
        Ok(Self {
            problem: curve.problem.clone(),
            u: u.to_vec(),
            p,
            scalar,
            steady,
            by_parameters,
            by_t,
            row: border.row[..n].to_vec(),
            small: Lu::new(small.as_ref())?,
            sizes,
            unit_kappa,
        })
    }
}

impl Factored for HopfFactors {
    fn solve(&self, right: &mut [f64]) {
        let n = self.u.len();
        let solved = self.steady.solve(&right[..n], 0.0);
        let along = if solved[..n].iter().all(|&x| x == 0.0) {
            [0.0; 2]
        } else {
            let rest = vec![0.0; n];
            let at = At { u: &self.u, v: &rest, p: &self.p };
            self.scalar.along(&*self.problem, at, Direction { u: &solved[..n], v: &[], p: &[] })
        };
        let mut y =
            [-solved[n], right[n] - along[0], right[n + 1] - along[1], right[n + 2] - dot(&self.row, &solved[..n])];
        y.iter_mut().zip(&self.sizes).for_each(|(y, size)| *y /= size);
        self.small.solve(&mut y);
        let [t, kappa, z1, z2] = y;
        for i in 0..n {
            right[i] = solved[i] + t * self.by_t[i] - z1 * self.by_parameters[0][i] - z2 * self.by_parameters[1][i];
        }
        (right[n], right[n + 1], right[n + 2]) = (kappa * self.unit_kappa, z1, z2);
    }
}
