//! The classical columns: a cantilever with inertia, compressed at its tip and along it by loads that keep their
//! direction (chi = 0) or follow the tangent (chi = 1). Planar, inextensible, of any deflection:
//!
//! ```text
//! int w . [ mu r_tt + c r_t + p D(s) e(chi psi) ] ds + w(L) . [ m r_tt + P e(chi psi) ](L)
//!   + EI int (psi + eta psi_t)_s q_s ds = 0,    e(a) = (cos a, sin a),   D = (1 - s/L)^n.
//! ```
//!
//! Euler: P, chi = 0. Beck (1952, doi:10.1007/BF02008828): P, chi = 1. Pflueger: with tip mass m. Leipholz: p, n = 0,
//! chi = 1. Hauger (1966): n = 1. Undamped, they flutter where two frequencies meet; vanishing damping eta, not c, makes
//! them flutter earlier (Ziegler 1952, doi:10.1007/BF00536796; Bolotin 1963).

use super::inertial;
use crate::linalg::Matrix;
use crate::models::rod::{Basis, Forces, Push, finer};
use crate::models::{ModelError, Options};
use crate::problem::{At, Automatic, Bounds, Formula, Observable, Parameter, Problem, Refinement, Reflection, Scalar};
use std::sync::Arc;

pub struct Column {
    basis: Basis,
    parameters: Vec<Parameter>,
}

const OBSERVABLES: &[Observable] = &[
    Observable { name: "tip_deflection", unit: "m", meaning: "y of the tip" },
    Observable { name: "tip_position", unit: "m", meaning: "x of the tip" },
    Observable { name: "tip_angle", unit: "rad", meaning: "angle at the tip" },
    Observable { name: "energy", unit: "N m", meaning: "energy of bending and of motion" },
];

/// Positions in the parameter vector.
mod index {
    pub const L: usize = 0;
    pub const EI: usize = 1;
    pub const MU: usize = 2;
    pub const M: usize = 3;
    pub const C: usize = 4;
    pub const ETA: usize = 5;
    pub const TIP: usize = 6;
    pub const SPREAD: usize = 7;
    pub const N: usize = 8;
    pub const CHI: usize = 9;
}

impl Column {
    /// From the scene's option `functions`.
    pub fn build(options: &Options) -> Result<Arc<dyn Problem>, ModelError> {
        Ok(Arc::new(Automatic(Self::new(options.integer("functions", 12, 2, 400)?))))
    }

    pub fn new(functions: usize) -> Self {
        use Bounds::{Any, NonNegative, Positive};
        let make = Parameter::new;
        let parameters = vec![
            make("L", 1.0, "m", Positive, "length"),
            make("EI", 1.0, "N m²", Positive, "flexural rigidity"),
            make("mu", 1.0, "kg m⁻¹", Positive, "mass per length"),
            make("m", 0.0, "kg", NonNegative, "mass at the tip"),
            make("c", 0.0, "N s m⁻²", NonNegative, "external damping per length"),
            make("eta", 0.0, "s", NonNegative, "internal damping: retardation time of the material (Kelvin and Voigt)"),
            make("P", 0.0, "N", Any, "load at the tip, compressive"),
            make("p", 0.0, "N m⁻¹", Any, "load per length at the base, compressive, times D(s) = (1 - s/L)^n along"),
            make("n", 0.0, "", NonNegative, "exponent of the load's profile: 0 uniform, 1 falling linearly to the tip"),
            make("chi", 1.0, "", Any, "part of the angle that loads follow: 0 dead loads, 1 follower loads"),
        ];
        Self { basis: Basis::new(functions), parameters }
    }

    fn forces<S: Scalar>(&self, p: &[S]) -> Forces<S> {
        use index::{C, CHI, EI, ETA, L, M, MU, N, SPREAD, TIP};
        let (length, per_bending) = (p[L], p[EI].recip());
        let (second, third) = (length * length * per_bending, length * length * length * per_bending);
        let drag = p[C] * third * length;
        let profile = |&x: &f64| if p[N].vanishes() { S::from(1.0) } else { (p[N] * (1.0 - x).ln()).exp() };
        Forces {
            inertia: p[MU] * third * length,
            tip_inertia: p[M] * third,
            drag: [drag, drag],
            viscosity: p[ETA],
            carried: S::from(0.0),
            tip: Push { size: p[TIP] * second, follows: p[CHI] },
            spread: Push { size: p[SPREAD] * third, follows: p[CHI] },
            profile: self.basis.x.iter().map(profile).collect(),
            spring: S::from(0.0),
        }
    }
}

impl Formula for Column {
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

    fn time_unit(&self) -> &'static str {
        "s"
    }

    fn observables(&self) -> &[Observable] {
        OBSERVABLES
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        let length = at.p[index::L];
        let tip = inertial::tip(&self.basis, &at.u[..self.basis.functions]);
        match i {
            0 | 1 => length * tip[i],
            2 => tip[2],
            3 => inertial::energy(&self.basis, &self.forces(at.p), at.u) * at.p[index::EI] / length,
            _ => f64::NAN,
        }
    }

    fn reflection(&self) -> Option<Reflection> {
        Some(Reflection::negation(self.dim()))
    }

    fn picture_unit(&self) -> &'static str {
        "m"
    }

    fn picture(&self, u: &[f64], p: &[f64]) -> Option<Vec<[f64; 2]>> {
        Some(inertial::picture(&self.basis, p[index::L], u))
    }

    fn refined(&self) -> Option<Refinement> {
        Some(finer(self.basis.functions, 2, |more| Arc::new(Automatic(Self::new(more)))))
    }
}
