//! Reference vectors of a Hopf curve or surface.

use super::Scalar;
use crate::bifurcation::Hopf;
use crate::bifurcation::steady::Steady;
use crate::linalg::{any, c64, real_direction, unit};
use crate::problem::Prolongation;
use faer::MatRef;

/// From one step to the next the unit of kappa shrinks no more than this, so that steps do not die before kappa = 0.
const SHRINK: f64 = 0.1;

/// Real borders of the pencil (`column`, `row`) and of G_u (`beta`, `gamma`), and the unit of sigma.
#[derive(Clone, Debug)]
pub struct Borders {
    pub column: Vec<f64>,
    pub row: Vec<f64>,
    pub beta: Vec<f64>,
    pub gamma: Vec<f64>,
    pub unit: f64,
}

impl Borders {
    /// At a Hopf point, by its eigenvectors. No vector is known to be near the kernel of G_u; two steps of inverse
    /// iteration ([`Borders::follow`]) from any make one.
    pub fn start(hopf: &Hopf) -> Self {
        let start = unit(&any(hopf.u.len()));
        Self {
            column: real_direction(&hopf.w.iter().map(|z| z.conj()).collect::<Vec<_>>()),
            row: real_direction(&hopf.q),
            beta: start.clone(),
            gamma: start,
            unit: hopf.omega,
        }
    }

    /// Takes the null vectors at a point as borders and its omega as unit.
    pub fn follow(&mut self, gu: MatRef<'_, f64>, gv: MatRef<'_, f64>, kappa: f64) {
        let n = gu.nrows();
        if let Ok(scalar) = Scalar::new(gu, gv, kappa, self) {
            let left: Vec<c64> = scalar.left_vector().iter().map(|z| z.conj()).collect();
            (self.row, self.column) = (real_direction(&scalar.vector()), real_direction(&left));
        }
        if let Ok(steady) = Steady::new(gu, &self.beta, &self.gamma) {
            let (right, left) = (steady.solve(&vec![0.0; n], 1.0), steady.left(n));
            (self.gamma, self.beta) = (unit(&right[..n]), unit(&left[..n]));
        }
        self.unit = kappa.abs().sqrt().max(SHRINK * self.unit);
    }

    /// The same on a finer discretisation.
    pub fn refined(&self, prolong: &Prolongation) -> Self {
        Self {
            column: prolong(&self.column),
            row: prolong(&self.row),
            beta: prolong(&self.beta),
            gamma: prolong(&self.gamma),
            unit: self.unit,
        }
    }
}
