//! The factored Jacobian of Hopf points in m parameters (two: a curve, three: a surface), by block elimination.
//!
//! Never is g_u formed. With G_u itself bordered, so that it may be singular (at zero-Hopf points),
//!
//! ```text
//! [ G_u     beta ] [du]   [r - G_1 dz1 - ... - G_m dzm]
//! [ gamma^T   0  ] [mu] = [             t             ],      mu = 0,
//! ```
//!
//! du is a combination of m + 2 solutions with known vectors; derivatives of (a, b) along them and `mu = 0` leave a system
//! of m + 2 equations for t, d kappa, dz1, ..., dzm, whose last m - 1 rows are the borders (Govaerts 2000,
//! doi:10.1137/1.9780898719543, chapters 3 and 4, has both ideas).

use super::Borders;
use super::scalar::Scalar;
use crate::bifurcation::Coordinate;
use crate::bifurcation::steady::Steady;
use crate::continuation::Factored;
use crate::linalg::{Lu, Singular, dot};
use crate::problem::{At, Direction, Problem};
use faer::{Mat, MatRef};
use std::sync::Arc;

/// A point (u, kappa, p) with G_u and G_v there.
pub struct Place<'a> {
    pub u: &'a [f64],
    pub kappa: f64,
    pub p: Vec<f64>,
    pub linear: (MatRef<'a, f64>, MatRef<'a, f64>),
}

/// Factors at one point.
pub struct HopfFactors {
    problem: Arc<dyn Problem>,
    u: Vec<f64>,
    p: Vec<f64>,
    scalar: Scalar,
    steady: Steady,
    /// (u, mu) for right-hand sides G_1, ..., G_m, and for t = 1.
    by_parameters: Vec<Vec<f64>>,
    by_t: Vec<f64>,
    /// The borders' rows for u.
    rows: Vec<Vec<f64>>,
    small: Lu<f64>,
    /// What the small system's rows were divided by.
    sizes: Vec<f64>,
    unit_kappa: f64,
}

impl HopfFactors {
    /// At a point, with the values z of the coordinates there; each of the rows has an entry for u, kappa and every z.
    pub fn new(
        problem: Arc<dyn Problem>,
        Place { u, kappa, p, linear: (gu, gv) }: Place,
        coordinates: &[(Coordinate, f64)],
        borders: &Borders,
        rows: &[&[f64]],
    ) -> Result<Self, Singular> {
        let n = problem.dim();
        let m = coordinates.len() + 2;
        let rest = vec![0.0; n];
        let at = At { u, v: &rest, p: &p };
        let scalar = Scalar::new(gu, gv, kappa, borders)?;
        let steady = Steady::new(gu, &borders.beta, &borders.gamma)?;
        let by_t = steady.solve(&rest, 1.0);
        let unit_kappa = borders.unit.powi(2);

        let mut small = Mat::zeros(m, m);
        let g_kappa = scalar.by_kappa(gv);
        let g_t = scalar.along(&*problem, at, Direction { u: &by_t[..n], v: &[], p: &[] });
        small[(0, 0)] = by_t[n];
        for i in 0..2 {
            (small[(1 + i, 0)], small[(1 + i, 1)]) = (g_t[i], g_kappa[i] * unit_kappa);
        }
        for (i, row) in rows.iter().enumerate() {
            (small[(3 + i, 0)], small[(3 + i, 1)]) = (dot(&row[..n], &by_t[..n]), row[n] * unit_kappa);
        }
        let mut by_parameters = Vec::with_capacity(coordinates.len());
        for (k, (coordinate, z)) in coordinates.iter().enumerate() {
            let mut e = vec![0.0; p.len()];
            e[coordinate.index] = coordinate.rate(*z);
            let mut g = vec![0.0; n];
            problem.derivative(at, &[Direction { u: &[], v: &[], p: &e }], &mut g);
            let solved = steady.solve(&g, 0.0);
            let back: Vec<f64> = solved[..n].iter().map(|x| -x).collect();
            let g_z = scalar.along(&*problem, at, Direction { u: &back, v: &[], p: &e });
            small[(0, 2 + k)] = -solved[n];
            (small[(1, 2 + k)], small[(2, 2 + k)]) = (g_z[0], g_z[1]);
            for (i, row) in rows.iter().enumerate() {
                small[(3 + i, 2 + k)] = row[n + 1 + k] - dot(&row[..n], &solved[..n]);
            }
            by_parameters.push(solved);
        }
        // Rows of one size: the pivots of so small a system would otherwise depend on units.
        let size = |i: usize| (0..m).map(|j| small[(i, j)].abs()).fold(f64::MIN_POSITIVE, f64::max);
        let sizes: Vec<f64> = (0..m).map(size).collect();
        let small = Mat::from_fn(m, m, |i, j| small[(i, j)] / sizes[i]);
        Ok(Self {
            u: u.to_vec(),
            scalar,
            steady,
            by_parameters,
            by_t,
            rows: rows.iter().map(|row| row[..n].to_vec()).collect(),
            small: Lu::new(small)?,
            sizes,
            unit_kappa,
            problem,
            p,
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
        let mut y = vec![-solved[n], right[n] - along[0], right[n + 1] - along[1]];
        y.extend(self.rows.iter().zip(&right[n + 2..]).map(|(row, right)| right - dot(row, &solved[..n])));
        y.iter_mut().zip(&self.sizes).for_each(|(y, size)| *y /= size);
        self.small.solve(&mut y);
        for i in 0..n {
            let moved: f64 = self.by_parameters.iter().zip(&y[2..]).map(|(by, z)| by[i] * z).sum();
            right[i] = solved[i] + y[0] * self.by_t[i] - moved;
        }
        right[n] = y[1] * self.unit_kappa;
        right[n + 1..].copy_from_slice(&y[2..]);
    }
}
