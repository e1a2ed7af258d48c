//! Curves of folds in two parameters.
//!
//! Unknowns are x = (u, z1) and lambda = z2, z being the parameters or their logarithms; equations are
//! `G(u, 0, p) = 0` and `g = 0`, the bordered scalar of
//!
//! ```text
//! [ G_u      beta ] [q]   [0]
//! [ gamma^T   0   ] [g] = [1],          dg = -w^T D²G[(q, 0), d],
//! ```
//!
//! w being the solution with the transpose. The system is regular through cusps, Bogdanov-Takens and zero-Hopf points
//! (Govaerts 2000, doi:10.1137/1.9780898719543, section 4.1). Borders follow the curve from step to step.

mod blocks;
mod segment;

pub use blocks::FoldFactors;
pub use segment::{FoldSegment, FoldTest};

use super::Coordinate;
use super::steady::Steady;
use crate::continuation::{Border, Counts, Failure, Point, System, correct, normalise};
use crate::linalg::{Singular, any, c64, dot, pencil, unit};
use crate::problem::{At, Direction, Problem};
use faer::Mat;
use std::sync::Arc;

/// The kernel's vectors q and w, and G_v.
type Kernel = (Vec<f64>, Vec<f64>, Mat<f64>);

/// The system of a fold curve.
#[derive(Clone)]
pub struct FoldCurve {
    pub problem: Arc<dyn Problem>,
    /// All parameters; those of `first` and `second` are overwritten.
    p: Vec<f64>,
    pub first: Coordinate,
    pub second: Coordinate,
    scale_state: f64,
    beta: Vec<f64>,
    gamma: Vec<f64>,
}

impl FoldCurve {
    /// The system near a fold (u, p), and the point of the curve there, with a tangent along which z2 does not fall.
    pub fn start(
        problem: Arc<dyn Problem>,
        (u, p): (&[f64], &[f64]),
        (first, second): (Coordinate, Coordinate),
        counts: &mut Counts,
    ) -> Result<(Self, Point), Failure> {
        let n = problem.dim();
        let rms = (dot(u, u) / n as f64).sqrt();
        let scale_state = if rms > 0.0 { rms } else { 1.0 };
        let (p, beta, gamma) = (p.to_vec(), unit(&any(n)), unit(&any(n)));
        let mut curve = Self { problem, p, first, second, scale_state, beta, gamma };
        let mut x = u.to_vec();
        x.push(first.of(curve.p[first.index]));
        let lambda = second.of(curve.p[second.index]);
        let mut point = Point { tangent: vec![0.0; n + 1], x, lambda, tangent_lambda: 0.0 };
        // No vector is known to be near the kernel; a few inverse iterations from any make one.
        for _ in 0..3 {
            curve.prepare(&mut point);
        }
        // A border across the curve is not known: the unknown that may be held is the one along which the curve runs.
        let along = |k: usize| {
            let mut border = Border { row: vec![0.0; n + 1], lambda: 0.0 };
            match k {
                0 => border.lambda = 1.0 / second.width,
                1 => border.row[n] = 1.0 / first.width,
                _ => border.row[..n].copy_from_slice(&curve.gamma),
            }
            border
        };
        let found = (0..3).find_map(|k| correct(&curve, (point.x.clone(), lambda), &along(k), counts).ok());
        let mut point = found.ok_or(Failure::Singular(Singular))?.point;
        if point.tangent_lambda < 0.0 || point.tangent_lambda == 0.0 && point.tangent[n] < 0.0 {
            super::reverse(&mut point);
        }
        Ok((curve, point))
    }

    /// All parameters at a point.
    pub fn parameters(&self, point: &Point) -> Vec<f64> {
        self.values([point.x[self.problem.dim()], point.lambda])
    }

    fn values(&self, z: [f64; 2]) -> Vec<f64> {
        let mut p = self.p.clone();
        for (coordinate, z) in [self.first, self.second].into_iter().zip(z) {
            p[coordinate.index] = coordinate.value(z);
        }
        p
    }

    fn linearised(&self, u: &[f64], z: [f64; 2]) -> (Mat<f64>, Mat<f64>, Vec<f64>) {
        let (rest, p) = (vec![0.0; u.len()], self.values(z));
        let (gu, gv) = self.problem.linearised(At { u, v: &rest, p: &p });
        (gu, gv, p)
    }

    /// The kernel's vectors q and w (`gamma . q = beta . w = 1`), and G_v.
    fn kernel(&self, point: &Point) -> Result<Kernel, Singular> {
        let n = self.problem.dim();
        let (gu, gv, _) = self.linearised(&point.x[..n], [point.x[n], point.lambda]);
        let steady = Steady::new(gu.as_ref(), &self.beta, &self.gamma)?;
        let (mut q, mut w) = (steady.solve(&vec![0.0; n], 1.0), steady.left(n));
        q.truncate(n);
        w.truncate(n);
        Ok((q, w, gv))
    }

    /// Zero at a cusp: `w^T D²G[q, q] / 2`, the quadratic coefficient of the fold.
    pub fn quadratic(&self, point: &Point) -> Result<f64, Singular> {
        let n = self.problem.dim();
        let (q, w, _) = self.kernel(point)?;
        let (rest, p) = (vec![0.0; n], self.parameters(point));
        let mut out = vec![0.0; n];
        let along = Direction { u: &q, v: &[], p: &[] };
        self.problem.derivative(At { u: &point.x[..n], v: &rest, p: &p }, &[along, along], &mut out);
        Ok(0.5 * dot(&w, &out))
    }

    /// Zero at a Bogdanov-Takens point: `w^T M q`.
    pub fn mass(&self, point: &Point) -> Result<f64, Singular> {
        let (q, w, gv) = self.kernel(point)?;
        let gv = gv.as_ref();
        let moved: Vec<f64> = (0..q.len()).map(|i| (0..q.len()).map(|j| gv[(i, j)] * q[j]).sum()).collect();
        Ok(dot(&w, &moved))
    }

    /// Eigenvalues without the one at zero, rightmost first.
    pub fn others(&self, point: &Point, shift: f64) -> Result<Vec<c64>, Singular> {
        let n = self.problem.dim();
        let (gu, gv, _) = self.linearised(&point.x[..n], [point.x[n], point.lambda]);
        let mut values: Vec<c64> = pencil(gu.as_ref(), gv.as_ref(), shift, 0)?.iter().map(|pair| pair.value).collect();
        if let Some(k) = (0..values.len()).min_by(|&j, &k| values[j].norm().total_cmp(&values[k].norm())) {
            values.remove(k);
        }
        Ok(values)
    }
}

impl System for FoldCurve {
    type Factors = FoldFactors;

    fn residual(&self, x: &[f64], lambda: f64, r: &mut [f64]) {
        let n = self.problem.dim();
        let (gu, _, p) = self.linearised(&x[..n], [x[n], lambda]);
        let rest = vec![0.0; n];
        self.problem.residual(At { u: &x[..n], v: &rest, p: &p }, &mut r[..n]);
        // A singular bordered matrix has no scalar: the residual then is not a number, and the step fails.
        let steady = Steady::new(gu.as_ref(), &self.beta, &self.gamma);
        r[n] = steady.map_or(f64::NAN, |steady| steady.solve(&vec![0.0; n], 1.0)[n]);
    }

    fn factor(&self, x: &[f64], lambda: f64, border: &Border) -> Result<FoldFactors, Singular> {
        FoldFactors::new(self, x, lambda, border)
    }

    fn dual(&self, t: &[f64]) -> Vec<f64> {
        let n = self.problem.dim();
        let state = 1.0 / (n as f64 * self.scale_state.powi(2));
        let mut out: Vec<f64> = t[..n].iter().map(|t| state * t).collect();
        out.push(t[n] / self.first.width.powi(2));
        out
    }

    fn dual_lambda(&self) -> f64 {
        self.second.width.powi(-2)
    }

    /// Takes the kernel's vectors at the point as borders; the tangent is normalised anew.
    fn prepare(&mut self, point: &mut Point) -> bool {
        if let Ok((q, w, _)) = self.kernel(point) {
            (self.gamma, self.beta) = (unit(&q), unit(&w));
        }
        normalise(self, point);
        false
    }
}
