//! Equilibria `G(u, 0, p) = 0` as a curve in one parameter, or in its logarithm.

use super::Coordinate;
use crate::continuation::{Border, Factored, Point, System, normalise};
use crate::linalg::{BorderedMatrix, Eigenpair, Leading, Singular, Structure, dot, leading, pencil, shifted};
use crate::problem::{At, Direction, Problem};
use std::sync::Arc;

/// The system, with the coordinate of the free parameter as lambda; arclength counts the root mean square of u over
/// `scale_state`, and lambda over the coordinate's width.
#[derive(Clone)]
pub struct Equilibria {
    pub problem: Arc<dyn Problem>,
    pub p: Vec<f64>,
    pub coordinate: Coordinate,
    pub scale_state: f64,
    /// Whether [`Equilibria::leading`] computes all eigenvalues; None: those of small problems, and of any without structure.
    pub all_eigenvalues: Option<bool>,
}

impl Equilibria {
    pub fn parameters(&self, lambda: f64) -> Vec<f64> {
        let mut p = self.p.clone();
        p[self.coordinate.index] = self.coordinate.value(lambda);
        p
    }

    /// Eigenvalues at an equilibrium, rightmost first; vectors with the first `vectors`. `shift` must be no eigenvalue: it is
    /// best to the right of all that matter, at a distance of their size.
    pub fn spectrum(&self, u: &[f64], lambda: f64, shift: f64, vectors: usize) -> Result<Vec<Eigenpair>, Singular> {
        let n = u.len();
        let (rest, p) = (vec![0.0; n], self.parameters(lambda));
        let (gu, gv) = self.problem.linearised(At { u, v: &rest, p: &p });
        pencil(gu.as_ref(), gv.as_ref(), shift, vectors)
    }
}

/// More unknowns than this, and a problem with structure has only its leading eigenvalues computed.
pub const ALL_EIGENVALUES: usize = 256;

impl Equilibria {
    /// The eigenvalues that matter for stability: all of them, or of large problems with structure at least `count` of
    /// the leading ones (see [`crate::linalg::leading`]).
    pub fn leading(
        &self,
        u: &[f64],
        lambda: f64,
        shift: f64,
        count: usize,
        vectors: usize,
    ) -> Result<Leading, Singular> {
        let all = self.all_eigenvalues.unwrap_or(u.len() <= ALL_EIGENVALUES);
        if all || self.problem.structure() == Structure::Dense {
            let pairs = shifted(shift, |shift| self.spectrum(u, lambda, shift, vectors))?;
            return Ok(Leading { pairs, covered: f64::INFINITY, bound: None });
        }
        let (rest, p) = (vec![0.0; u.len()], self.parameters(lambda));
        let (gu, gv) = self.problem.matrices(At { u, v: &rest, p: &p });
        shifted(shift, |shift| leading(&gu, &gv, shift, count)).map_err(|_| Singular)
    }
}

/// A state larger than this many scales makes a new scale.
const OUTGROWN: f64 = 2.0;

impl System for Equilibria {
    type Factors = BorderedMatrix;

    fn residual(&self, x: &[f64], lambda: f64, r: &mut [f64]) {
        let rest = vec![0.0; x.len()];
        self.problem.residual(At { u: x, v: &rest, p: &self.parameters(lambda) }, r);
    }

    fn factor(&self, x: &[f64], lambda: f64, border: &Border) -> Result<BorderedMatrix, Singular> {
        let n = x.len();
        let (rest, p) = (vec![0.0; n], self.parameters(lambda));
        let at = At { u: x, v: &rest, p: &p };
        let (gu, _) = self.problem.matrices(at);
        let mut unit = vec![0.0; p.len()];
        unit[self.coordinate.index] = self.coordinate.rate(lambda);
        let mut by_lambda = vec![0.0; n];
        self.problem.derivative(at, &[Direction { u: &[], v: &[], p: &unit }], &mut by_lambda);
        BorderedMatrix::new(&gu, &[&by_lambda], &[&border.row], &[&[border.lambda]])
    }

    fn dual(&self, t: &[f64]) -> Vec<f64> {
        let weight = 1.0 / (t.len() as f64 * self.scale_state.powi(2));
        t.iter().map(|t| weight * t).collect()
    }

    fn dual_lambda(&self) -> f64 {
        self.coordinate.width.powi(-2)
    }

    /// A state that has outgrown its scale, as on a branch from zero, becomes the scale.
    fn prepare(&mut self, point: &mut Point) -> bool {
        let rms = (dot(&point.x, &point.x) / point.x.len() as f64).sqrt();
        let grown = rms > OUTGROWN * self.scale_state && rms.is_finite();
        if grown {
            self.scale_state = rms;
            normalise(self, point);
        }
        grown
    }
}

impl Factored for BorderedMatrix {
    fn solve(&self, right: &mut [f64]) {
        BorderedMatrix::solve(self, right);
    }
}
