//! The factored Jacobian of a fold curve.

use super::FoldCurve;
use crate::bifurcation::steady::Steady;
use crate::continuation::{Border, Factored};
use crate::linalg::{Lu, Singular, dot};
use crate::problem::{At, Direction, Problem};
use faer::Mat;
use std::sync::Arc;

/// The factored Jacobian, by block elimination: G_u is only ever used bordered, and three equations for the size of du
/// along q, dz1 and dz2 are left.
pub struct FoldFactors {
    problem: Arc<dyn Problem>,
    u: Vec<f64>,
    p: Vec<f64>,
    steady: Steady,
    q: Vec<f64>,
    w: Vec<f64>,
    by_parameters: [Vec<f64>; 2],
    row: Vec<f64>,
    small: Lu<f64>,
    sizes: [f64; 3],
}

impl FoldFactors {
    pub fn new(curve: &FoldCurve, x: &[f64], lambda: f64, border: &Border) -> Result<Self, Singular> {
        let n = curve.problem.dim();
        let z = [x[n], lambda];
        let (gu, _, p) = curve.linearised(&x[..n], z);
        let steady = Steady::new(gu.as_ref(), &curve.beta, &curve.gamma)?;
        let q = steady.solve(&vec![0.0; n], 1.0);
        let w = steady.left(n)[..n].to_vec();
        let row = border.row[..n].to_vec();
        let mut factors = Self {
            problem: curve.problem.clone(),
            u: x[..n].to_vec(),
            p,
            steady,
            q,
            w,
            by_parameters: [Vec::new(), Vec::new()],
            row,
            small: Lu::new(Mat::<f64>::identity(3, 3))?,
            sizes: [1.0; 3],
        };
        let mut small = Mat::zeros(3, 3);
        small[(0, 0)] = factors.q[n];
        small[(1, 0)] = factors.along(&factors.q[..n], &[]);
        small[(2, 0)] = dot(&factors.row, &factors.q[..n]);
        for (k, coordinate) in [curve.first, curve.second].into_iter().enumerate() {
            let mut e = vec![0.0; factors.p.len()];
            e[coordinate.index] = coordinate.rate(z[k]);
            let mut g = vec![0.0; n];
            let rest = vec![0.0; n];
            let at = At { u: &factors.u, v: &rest, p: &factors.p };
            curve.problem.derivative(at, &[Direction { u: &[], v: &[], p: &e }], &mut g);
            let solved = factors.steady.solve(&g, 0.0);
            let back: Vec<f64> = solved[..n].iter().map(|x| -x).collect();
            let own = if k == 0 { border.row[n] } else { border.lambda };
            small[(0, 1 + k)] = -solved[n];
            small[(1, 1 + k)] = factors.along(&back, &e);
            small[(2, 1 + k)] = own - dot(&factors.row, &solved[..n]);
            factors.by_parameters[k] = solved;
        }
        // Rows of one size: the pivots of so small a system would otherwise depend on units.
        factors.sizes = [0, 1, 2].map(|i| (0..3).map(|j| small[(i, j)].abs()).fold(f64::MIN_POSITIVE, f64::max));
        let small = Mat::from_fn(3, 3, |i, j| small[(i, j)] / factors.sizes[i]);
        factors.small = Lu::new(small)?;
        Ok(factors)
    }

    /// dg along a direction of (u, p).
    fn along(&self, du: &[f64], dp: &[f64]) -> f64 {
        let n = self.u.len();
        let (rest, mut out) = (vec![0.0; n], vec![0.0; n]);
        let at = At { u: &self.u, v: &rest, p: &self.p };
        let kernel = Direction { u: &self.q[..n], v: &[], p: &[] };
        self.problem.derivative(at, &[kernel, Direction { u: du, v: &[], p: dp }], &mut out);
        -dot(&self.w, &out)
    }
}

impl Factored for FoldFactors {
    fn solve(&self, right: &mut [f64]) {
        let n = self.u.len();
        let solved = self.steady.solve(&right[..n], 0.0);
        let along = if solved[..n].iter().all(|&x| x == 0.0) { 0.0 } else { self.along(&solved[..n], &[]) };
        let mut y = [-solved[n], right[n] - along, right[n + 1] - dot(&self.row, &solved[..n])];
        y.iter_mut().zip(&self.sizes).for_each(|(y, size)| *y /= size);
        self.small.solve(&mut y);
        let [t, z1, z2] = y;
        for i in 0..n {
            right[i] = solved[i] + t * self.q[i] - z1 * self.by_parameters[0][i] - z2 * self.by_parameters[1][i];
        }
        (right[n], right[n + 1]) = (z1, z2);
    }
}
