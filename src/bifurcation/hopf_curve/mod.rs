//! Curves of Hopf points in two parameters.
//!
//! Unknowns are x = (u, kappa, z1) and lambda = z2, with kappa = omega² and z the parameters or their logarithms;
//! equations are `G(u, 0, p) = 0` and `a = b = 0` (see [`scalar`]). The system stays regular through folds of the curve,
//! zero-Hopf points and Bogdanov-Takens points, where kappa changes sign. Borders follow the curve from step to step.

mod blocks;
mod borders;
mod scalar;
mod segment;

pub use blocks::HopfFactors;
pub(super) use borders::Borders;
pub(super) use scalar::Scalar;
pub use segment::{HopfSegment, Test};

use super::steady::Steady;
use super::{Coordinate, Locus};
use super::{Hopf, HopfError};
use crate::continuation::{Border, Corrected, Counts, Failure, Point, System, correct, normalise};
use crate::linalg::{Eigenpair, Singular, c64, dot, pencil};
use crate::problem::{At, Problem, Prolongation};
pub(super) use blocks::Place;
use faer::Mat;
use std::sync::Arc;

/// A relative change of kappa counts as so much arclength: hardly anything, since the parameters already tell points of
/// the curve apart; but not nothing, so that convergence is measured in kappa, too.
const WEIGHT_KAPPA: f64 = 1e-3;
/// The parameter to be solved for with the other fixed is the first, unless the curve runs along it this much more.
const STEEP: f64 = 1e3;

/// The system of a Hopf curve.
#[derive(Clone)]
pub struct HopfCurve {
    pub problem: Arc<dyn Problem>,
    /// All parameters; those of `first` and `second` are overwritten.
    p: Vec<f64>,
    pub first: Coordinate,
    pub second: Coordinate,
    scale_state: f64,
    borders: Borders,
}

impl HopfCurve {
    /// The system at a Hopf point, and that point with a tangent along which z2 does not fall.
    pub fn start(
        problem: Arc<dyn Problem>,
        hopf: &Hopf,
        (first, second): (Coordinate, Coordinate),
        counts: &mut Counts,
    ) -> Result<(Self, Point), Failure> {
        let n = problem.dim();
        let rms = (dot(&hopf.u, &hopf.u) / n as f64).sqrt();
        let borders = Borders::start(hopf);
        let scale_state = if rms > 0.0 { rms } else { 1.0 };
        let mut curve = Self { problem, p: hopf.p.clone(), first, second, scale_state, borders };
        let mut x = hopf.u.clone();
        x.extend([hopf.omega.powi(2), first.of(hopf.p[first.index])]);
        let lambda = second.of(hopf.p[second.index]);
        let mut point = Point { tangent: vec![0.0; n + 2], x, lambda, tangent_lambda: 0.0 };
        for _ in 0..2 {
            curve.prepare(&mut point);
        }
        // The tangent is found by bordering with two directions: one of them is not across the curve.
        let mut best: Option<Corrected<HopfFactors>> = None;
        for along_first in [false, true] {
            let mut border = Border { row: vec![0.0; n + 2], lambda: 0.0 };
            if along_first {
                border.row[n + 1] = 1.0 / first.width;
            } else {
                border.lambda = 1.0 / second.width;
            }
            let Ok(found) = correct(&curve, (point.x.clone(), lambda), &border, counts) else { continue };
            let steepness = |p: &Point| {
                if along_first { p.tangent[n + 1] / first.width } else { p.tangent_lambda / second.width }.abs()
            };
            if best.is_none() || steepness(&found.point) > 0.5 {
                best = Some(found);
            }
        }
        let mut point = best.ok_or(Failure::Singular(Singular))?.point;
        if point.tangent_lambda < 0.0 || point.tangent_lambda == 0.0 && point.tangent[n + 1] < 0.0 {
            reverse(&mut point);
        }
        Ok((curve, point))
    }

    /// All parameters at a point.
    pub fn parameters(&self, point: &Point) -> Vec<f64> {
        let n = self.problem.dim();
        self.values([point.x[n + 1], point.lambda])
    }

    fn values(&self, z: [f64; 2]) -> Vec<f64> {
        let mut p = self.p.clone();
        for (coordinate, z) in [self.first, self.second].into_iter().zip(z) {
            p[coordinate.index] = coordinate.value(z);
        }
        p
    }

    /// omega² at a point: zero at a Bogdanov-Takens point.
    pub fn kappa(&self, point: &Point) -> f64 {
        point.x[self.problem.dim()]
    }

    /// The parameter that is best solved for at a point, with the other held.
    pub fn solvable(&self, point: &Point) -> usize {
        let along_first = point.tangent[self.problem.dim() + 1] / self.first.width;
        let along_second = point.tangent_lambda / self.second.width;
        if along_first.abs() > STEEP * along_second.abs() { self.second.index } else { self.first.index }
    }

    /// G_u, G_v and all parameters.
    fn linearised(&self, u: &[f64], z: [f64; 2]) -> (Mat<f64>, Mat<f64>, Vec<f64>) {
        let (rest, p) = (vec![0.0; u.len()], self.values(z));
        let (gu, gv) = self.problem.linearised(At { u, v: &rest, p: &p });
        (gu, gv, p)
    }

    /// The Hopf point at a point of the curve, solved to rounding in the parameter `free` with the other held, and its
    /// slope along the first parameter.
    pub fn hopf(&self, point: &Point, free: usize) -> Result<Hopf, HopfError> {
        let n = self.problem.dim();
        let (gu, gv, p) = self.linearised(&point.x[..n], self.coordinates(point));
        let q = Scalar::new(gu.as_ref(), gv.as_ref(), self.kappa(point), &self.borders)?.vector();
        let omega = self.kappa(point).max(0.0).sqrt();
        let found = Hopf::locate(&*self.problem, (&point.x[..n], &p), free, omega, &q)?;
        if free == self.first.index { Ok(found) } else { found.along(&*self.problem, self.first.index) }
    }

    /// A function that vanishes where G_u is singular: the bordered scalar of G_u.
    pub fn steady(&self, point: &Point) -> Result<f64, Singular> {
        let n = self.problem.dim();
        let (gu, ..) = self.linearised(&point.x[..n], self.coordinates(point));
        Ok(Steady::new(gu.as_ref(), &self.borders.beta, &self.borders.gamma)?.solve(&vec![0.0; n], 1.0)[n])
    }

    /// Eigenvalues without the critical pair, rightmost first.
    pub fn others(&self, point: &Point) -> Result<Vec<c64>, Singular> {
        let n = self.problem.dim();
        let (gu, gv, _) = self.linearised(&point.x[..n], self.coordinates(point));
        let omega = self.kappa(point).max(0.0).sqrt();
        // Irrational in units of omega, so that it is no eigenvalue itself.
        let shift = std::f64::consts::E * omega.max(self.borders.unit);
        let mut values: Vec<c64> =
            pencil(gu.as_ref(), gv.as_ref(), shift, 0)?.iter().map(|Eigenpair { value, .. }| *value).collect();
        for critical in [c64::new(0.0, omega), c64::new(0.0, -omega)] {
            let distance = |k: &usize| (values[*k] - critical).norm();
            if let Some(k) = (0..values.len()).min_by(|j, k| distance(j).total_cmp(&distance(k))) {
                values.remove(k);
            }
        }
        Ok(values)
    }

    /// The same curve on another discretisation of the problem.
    pub fn refined(&self, problem: Arc<dyn Problem>, prolong: &Prolongation) -> Self {
        let borders = self.borders.refined(prolong);
        Self { problem, borders, ..self.clone() }
    }

    /// A point of this curve corrected onto a refined one, on the hyperplane across the tangent.
    pub fn onto(
        &self,
        fine: &Self,
        prolong: &Prolongation,
        point: &Point,
        counts: &mut Counts,
    ) -> Result<Point, Failure> {
        let n = self.problem.dim();
        let spread = |x: &[f64]| [prolong(&x[..n]), x[n..].to_vec()].concat();
        let (x, tangent) = (spread(&point.x), spread(&point.tangent));
        let border = Border { row: fine.dual(&tangent), lambda: fine.dual_lambda() * point.tangent_lambda };
        Ok(correct(fine, (x, point.lambda), &border, counts)?.point)
    }
}

impl System for HopfCurve {
    type Factors = HopfFactors;

    fn residual(&self, x: &[f64], lambda: f64, r: &mut [f64]) {
        let n = self.problem.dim();
        let (gu, gv, p) = self.linearised(&x[..n], [x[n + 1], lambda]);
        let rest = vec![0.0; n];
        self.problem.residual(At { u: &x[..n], v: &rest, p: &p }, &mut r[..n]);
        // A singular bordered matrix has no scalar: the residual then is not a number, and the step fails.
        let scalar = Scalar::new(gu.as_ref(), gv.as_ref(), x[n], &self.borders);
        (r[n], r[n + 1]) = scalar.map_or((f64::NAN, f64::NAN), |g| (g.a, g.b));
    }

    fn factor(&self, x: &[f64], lambda: f64, border: &Border) -> Result<HopfFactors, Singular> {
        let n = self.problem.dim();
        let (u, kappa, z) = (&x[..n], x[n], [x[n + 1], lambda]);
        let row = [&border.row[..], &[border.lambda]].concat();
        let (gu, gv, p) = self.linearised(u, z);
        let place = Place { u, kappa, p, linear: (gu.as_ref(), gv.as_ref()) };
        let coordinates = [(self.first, z[0]), (self.second, z[1])];
        HopfFactors::new(self.problem.clone(), place, &coordinates, &self.borders, &[&row])
    }

    fn dual(&self, t: &[f64]) -> Vec<f64> {
        let n = self.problem.dim();
        let state = 1.0 / (n as f64 * self.scale_state.powi(2));
        let kappa = (WEIGHT_KAPPA / self.borders.unit.powi(2)).powi(2);
        let mut out: Vec<f64> = t[..n].iter().map(|t| state * t).collect();
        out.extend([kappa * t[n], t[n + 1] / self.first.width.powi(2)]);
        out
    }

    fn dual_lambda(&self) -> f64 {
        self.second.width.powi(-2)
    }

    /// Takes the vectors at the point as borders and its omega as unit; the tangent is normalised anew.
    fn prepare(&mut self, point: &mut Point) -> bool {
        let n = self.problem.dim();
        let (gu, gv, _) = self.linearised(&point.x[..n], self.coordinates(point));
        let kappa = self.kappa(point);
        self.borders.follow(gu.as_ref(), gv.as_ref(), kappa);
        normalise(self, point);
        false
    }
}

/// The same point, to be left the other way.
pub fn reverse(point: &mut Point) {
    point.tangent.iter_mut().for_each(|t| *t = -*t);
    point.tangent_lambda = -point.tangent_lambda;
}
