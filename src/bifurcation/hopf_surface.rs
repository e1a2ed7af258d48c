//! Surfaces of Hopf points in three parameters.
//!
//! Unknowns are x = (u, kappa, z1, z2, z3), with kappa = omega² and z the parameters or their logarithms; equations are
//! those of a Hopf curve, `G(u, 0, p) = 0` and `a = b = 0` (see [`HopfCurve`](super::HopfCurve)), two fewer than there
//! are unknowns. The surface is regular through zero-Hopf and Bogdanov-Takens points; it ends where kappa = 0.

use super::hopf_curve::{Borders, HopfFactors, Place, Scalar};
use super::{Coordinate, Hopf, HopfError};
use crate::continuation::{Bound, Chart, Surface};
use crate::linalg::{Singular, dot};
use crate::problem::{At, Problem};
use faer::Mat;
use std::sync::Arc;

/// Relative changes of kappa and u count as so much length: the parameters tell points of the surface apart, and it is in
/// their space that it is to be triangulated. A little is left so that the metric is one everywhere.
const WEIGHT: f64 = 1e-4;
/// The first parameter is solved for with the others held, unless the surface runs along it this much more.
const STEEP: f64 = 1e3;

/// The system of a Hopf surface.
#[derive(Clone)]
pub struct HopfSurface {
    pub problem: Arc<dyn Problem>,
    /// All parameters; those of the coordinates are overwritten.
    p: Vec<f64>,
    pub coordinates: [Coordinate; 3],
    borders: Borders,
    weights: Arc<Vec<f64>>,
    scales: Vec<f64>,
}

impl HopfSurface {
    /// The system at a Hopf point, and that point.
    pub fn start(problem: Arc<dyn Problem>, hopf: &Hopf, coordinates: [Coordinate; 3]) -> (Self, Vec<f64>) {
        let n = problem.dim();
        let rms = (dot(&hopf.u, &hopf.u) / n as f64).sqrt();
        let scale = if rms > 0.0 { rms } else { 1.0 };
        let mut scales = vec![scale.powi(-2) / n as f64; n];
        scales.push(hopf.omega.powi(-4));
        scales.extend(coordinates.map(|c| c.width.powi(-2)));
        let light = |(k, scale): (usize, &f64)| if k <= n { WEIGHT * WEIGHT * scale } else { *scale };
        let weights = Arc::new(scales.iter().enumerate().map(light).collect());
        let mut x = hopf.u.clone();
        x.push(hopf.omega.powi(2));
        x.extend(coordinates.map(|c| c.of(hopf.p[c.index])));
        let (p, borders) = (hopf.p.clone(), Borders::start(hopf));
        let surface = Self { problem, p, coordinates, borders, weights, scales };
        // Twice, since at first the borders of G_u are arbitrary.
        (surface.prepared(&x).prepared(&x), x)
    }

    /// Where the three coordinates stand among the unknowns.
    pub fn places(&self) -> [usize; 3] {
        [1, 2, 3].map(|k| self.problem.dim() + k)
    }

    /// kappa >= 0: the surface ends at Bogdanov-Takens points.
    pub fn end(&self) -> Bound {
        Bound { coordinate: self.problem.dim(), upper: false, value: 0.0 }
    }

    pub fn kappa(&self, x: &[f64]) -> f64 {
        x[self.problem.dim()]
    }

    /// All parameters at a point.
    pub fn parameters(&self, x: &[f64]) -> Vec<f64> {
        let mut p = self.p.clone();
        for (coordinate, place) in self.coordinates.iter().zip(self.places()) {
            p[coordinate.index] = coordinate.value(x[place]);
        }
        p
    }

    /// G_u, G_v and all parameters.
    fn linearised(&self, x: &[f64]) -> (Mat<f64>, Mat<f64>, Vec<f64>) {
        let n = self.problem.dim();
        let (rest, p) = (vec![0.0; n], self.parameters(x));
        let (gu, gv) = self.problem.linearised(At { u: &x[..n], v: &rest, p: &p });
        (gu, gv, p)
    }

    /// Which of the coordinates is best solved for at a chart with the others held: not one that `held` names.
    pub fn solvable(&self, chart: &Chart<Self>, held: &[usize]) -> usize {
        let normal = |k: usize| {
            let entry =
                |basis: usize, k: usize| chart.basis[basis][self.places()[k % 3]] / self.coordinates[k % 3].width;
            (entry(0, k + 1) * entry(1, k + 2) - entry(0, k + 2) * entry(1, k + 1)).abs()
        };
        let allowed = || (0..3).filter(|k| !held.contains(k));
        let most = allowed().map(normal).fold(0.0, f64::max);
        allowed().find(|&k| normal(k) * STEEP >= most).unwrap_or(0)
    }

    /// The Hopf point at a point of the surface, solved to rounding in one coordinate with `p` giving the others.
    pub fn hopf(&self, x: &[f64], p: &[f64], solved: usize) -> Result<Hopf, HopfError> {
        let n = self.problem.dim();
        let (gu, gv, _) = self.linearised(x);
        let kappa = self.kappa(x);
        let q = Scalar::new(gu.as_ref(), gv.as_ref(), kappa, &self.borders)?.vector();
        let free = self.coordinates[solved].index;
        Hopf::locate(&*self.problem, (&x[..n], p), free, kappa.max(0.0).sqrt(), &q)
    }
}

impl Surface for HopfSurface {
    type Factors = HopfFactors;

    fn residual(&self, x: &[f64], r: &mut [f64]) {
        let n = self.problem.dim();
        let (gu, gv, p) = self.linearised(x);
        let rest = vec![0.0; n];
        self.problem.residual(At { u: &x[..n], v: &rest, p: &p }, &mut r[..n]);
        // A singular bordered matrix has no scalar: the residual then is not a number, and the step fails.
        let scalar = Scalar::new(gu.as_ref(), gv.as_ref(), self.kappa(x), &self.borders);
        (r[n], r[n + 1]) = scalar.map_or((f64::NAN, f64::NAN), |g| (g.a, g.b));
    }

    fn factor(&self, x: &[f64], rows: [&[f64]; 2]) -> Result<HopfFactors, Singular> {
        let n = self.problem.dim();
        let (gu, gv, p) = self.linearised(x);
        let place = Place { u: &x[..n], kappa: self.kappa(x), p, linear: (gu.as_ref(), gv.as_ref()) };
        let coordinates: Vec<(Coordinate, f64)> =
            self.coordinates.iter().zip(self.places()).map(|(c, k)| (*c, x[k])).collect();
        HopfFactors::new(self.problem.clone(), place, &coordinates, &self.borders, &rows)
    }

    fn weights(&self) -> &[f64] {
        &self.weights
    }

    fn scales(&self) -> &[f64] {
        &self.scales
    }

    /// Borders and unit are taken from the point.
    fn prepared(&self, x: &[f64]) -> Self {
        let (gu, gv, _) = self.linearised(x);
        let mut surface = self.clone();
        surface.borders.follow(gu.as_ref(), gv.as_ref(), self.kappa(x));
        surface.scales[self.problem.dim()] = surface.borders.unit.powi(-4);
        surface
    }
}
