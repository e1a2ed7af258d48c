//! One loop that follows any curve of solutions: n equations in n unknowns and one parameter lambda.
//!
//! ```text
//! predict along the tangent (and its change) -> correct by bordered Newton -> measure the new tangent -> set the step
//! ```
//!
//! (Keller 1977; Allgower and Georg 2003, doi:10.1137/1.9780898719154.) It knows nothing of what the curve is made of.

mod between;
mod chord;
mod corrector;
mod manifold;
mod step;
mod walk;

pub use between::{at_fraction, at_lambda, crossing};
pub use chord::Chord;
pub use corrector::{Corrected, Failure, correct};
pub use manifold::{Bound, Chart, Cover, CoverControl, Surface};
pub use step::StepControl;
pub use walk::{Step, Stop, Walk, WalkState};

use crate::linalg::Singular;
use serde::{Deserialize, Serialize};

/// A solution with its unit tangent.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Point {
    pub x: Vec<f64>,
    pub lambda: f64,
    pub tangent: Vec<f64>,
    pub tangent_lambda: f64,
}

/// The last row of a bordered system: `row . x + lambda_entry * lambda`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Border {
    pub row: Vec<f64>,
    pub lambda: f64,
}

/// How often the expensive things were done.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, PartialEq, Eq)]
pub struct Counts {
    pub newton: usize,
    pub factorisations: usize,
    pub residuals: usize,
    pub spectra: usize,
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.newton += other.newton;
        self.factorisations += other.factorisations;
        self.residuals += other.residuals;
        self.spectra += other.spectra;
    }
}

/// A curve: `H(x, lambda) = 0` with as many equations as there are entries in x.
pub trait System {
    type Factors: Factored;

    /// `r = H(x, lambda)`.
    fn residual(&self, x: &[f64], lambda: f64, r: &mut [f64]);

    /// Factors the matrix `[H_x, H_lambda; border]`.
    fn factor(&self, x: &[f64], lambda: f64, border: &Border) -> Result<Self::Factors, Singular>;

    /// `W t`, with W the metric that arclength is measured in: the scene's scales, not the dimension, set it.
    fn dual(&self, t: &[f64]) -> Vec<f64>;

    /// The metric's entry for lambda.
    fn dual_lambda(&self) -> f64;

    /// Called with the current point before a step is taken from it: a chance to move the mesh. Returns whether it did.
    fn prepare(&mut self, _point: &mut Point) -> bool {
        false
    }

    /// Where `prepare` changes which of many equivalent solutions is the one: the same of an earlier point.
    fn align(&self, _past: &mut Point) {}
}

/// A factored bordered matrix.
pub trait Factored {
    /// Solves for (x, lambda) in place, `right` holding the right-hand side of H and then the border's.
    fn solve(&self, right: &mut [f64]);
}

/// The inner product of the metric.
pub fn inner<S: System>(system: &S, (a, a_lambda): (&[f64], f64), (b, b_lambda): (&[f64], f64)) -> f64 {
    crate::linalg::dot(a, &system.dual(b)) + system.dual_lambda() * a_lambda * b_lambda
}

/// Gives a point's tangent length one.
pub fn normalise<S: System>(system: &S, point: &mut Point) {
    let along = (&point.tangent[..], point.tangent_lambda);
    let length = inner(system, along, along).sqrt();
    if length > 0.0 {
        point.tangent.iter_mut().for_each(|t| *t /= length);
        point.tangent_lambda /= length;
    }
}
