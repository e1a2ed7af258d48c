//! A hanging cantilevered pipe that discharges fluid (Gregory and Paidoussis 1966, doi:10.1098/rspa.1966.0187), planar,
//! inextensible, of any deflection; the fluid is a plug of speed U. In units of length L, time sqrt((m + M) L^4/EI):
//!
//! ```text
//! int w . [ r_tt + 2 sqrt(beta) u psi_t n + c r_t - gamma e_x ] dx + w(1) . u^2 t(1) + int (psi + alpha psi_t)_x q_x dx = 0,
//! u = U L sqrt(M/EI),   beta = M/(m + M),   gamma = (m + M) g L^3/EI.
//! ```
//!
//! The second and the fifth term are the fluid's acceleration relative to the pipe, 2 U psi_t n + U^2 psi_x n: a pipe is
//! Beck's column with a gyroscopic term.

use super::inertial;
use crate::linalg::Matrix;
use crate::models::rod::{Basis, Forces, Push, finer};
use crate::models::{ModelError, Options};
use crate::problem::{At, Automatic, Bounds, Formula, Observable, Parameter, Problem, Refinement, Reflection, Scalar};
use std::sync::Arc;

pub struct Pipe {
    basis: Basis,
    parameters: Vec<Parameter>,
}

const OBSERVABLES: &[Observable] = &[
    Observable { name: "tip_deflection", unit: "", meaning: "y of the tip, in lengths" },
    Observable { name: "tip_position", unit: "", meaning: "x of the tip, in lengths" },
    Observable { name: "tip_angle", unit: "rad", meaning: "angle at the tip" },
];

/// Positions in the parameter vector.
mod index {
    pub const U: usize = 0;
    pub const BETA: usize = 1;
    pub const GAMMA: usize = 2;
    pub const ALPHA: usize = 3;
    pub const C: usize = 4;
}

impl Pipe {
    /// From the scene's option `functions`.
    pub fn build(options: &Options) -> Result<Arc<dyn Problem>, ModelError> {
        Ok(Arc::new(Automatic(Self::new(options.integer("functions", 14, 2, 400)?))))
    }

    pub fn new(functions: usize) -> Self {
        use Bounds::{Any, NonNegative, Positive};
        let make = |name, value, bounds, meaning| Parameter::new(name, value, "", bounds, meaning);
        let parameters = vec![
            make("u", 0.0, NonNegative, "flow speed U L sqrt(M/EI)"),
            make("beta", 0.2, Positive, "the fluid's part of the mass, M/(m + M)"),
            make("gamma", 0.0, Any, "gravity (m + M) g L^3/EI; negative for a standing pipe"),
            make("alpha", 0.0, NonNegative, "internal damping: retardation time of the material (Kelvin and Voigt)"),
            make("c", 0.0, NonNegative, "external damping per length"),
        ];
        Self { basis: Basis::new(functions), parameters }
    }

    fn forces<S: Scalar>(&self, p: &[S]) -> Forces<S> {
        use index::{ALPHA, BETA, C, GAMMA, U};
        let (zero, one) = (S::from(0.0), S::from(1.0));
        Forces {
            inertia: one,
            tip_inertia: zero,
            drag: [p[C], p[C]],
            viscosity: p[ALPHA],
            carried: p[BETA].sqrt() * p[U] * 2.0,
            tip: Push { size: p[U] * p[U], follows: one },
            spread: Push { size: -p[GAMMA], follows: zero },
            profile: vec![one; self.basis.points],
            spring: zero,
        }
    }
}

impl Formula for Pipe {
    fn dim(&self) -> usize {
        2 * self.basis.functions
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        inertial::residual(&self.basis, &self.forces(p), (u, v), g);
    }

    fn linearise(&self, at: At, gu: &mut Matrix, gv: &mut Matrix) {
        inertial::linearise(&self.basis, &self.forces(at.p), at, gu, gv);
    }

    fn observables(&self) -> &[Observable] {
        OBSERVABLES
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        inertial::tip(&self.basis, &at.u[..self.basis.functions]).get(i).copied().unwrap_or(f64::NAN)
    }

    fn reflection(&self) -> Option<Reflection> {
        Some(Reflection::negation(self.dim()))
    }

    fn picture(&self, u: &[f64], _p: &[f64]) -> Option<Vec<[f64; 2]>> {
        Some(inertial::picture(&self.basis, 1.0, u))
    }

    fn refined(&self) -> Option<Refinement> {
        Some(finer(self.basis.functions, 2, |more| Arc::new(Automatic(Self::new(more)))))
    }
}
