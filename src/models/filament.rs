//! One inextensible elastic filament in viscous fluid under compressive follower loads, at its tip and along it, its
//! base clamped or held by a spring: the weak form of [`super::rod`] without inertia,
//!
//! ```text
//! int w . [ c_T (r_t.t) t + c_N (r_t.n) n + p D(s) t ] ds + w(L) . P t(L) + EI int psi_s q_s ds + k psi(0) q(0) = 0.
//! ```
//!
//! Planar, nonlinear, of the form M(u) u' = F(u). (De Canio, Lauga and Goldstein 2017, doi:10.1098/rsif.2017.0491, for
//! the load at the tip; Bayly and Dutcher 2016, doi:10.1098/rsif.2016.0523, figure 2.)

use super::rod::{Basis, Forces, Load, Push, State, bracket, end, finer, line, slopes, work};
use super::{ModelError, Options};
use crate::linalg::Matrix;
use crate::problem::{
    At, Automatic, Bounds, Default, Formula, Observable, Parameter, Problem, Refinement, Reflection, Scalar,
};
use std::sync::Arc;

/// What holds the filament at s = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// psi(0) = 0.
    Clamped,
    /// Free to turn against a spring, without which nothing would tell one direction from another.
    Pinned,
}

pub struct Filament {
    basis: Basis,
    load: Load,
    base: Base,
    parameters: Vec<Parameter>,
}

const OBSERVABLES: &[Observable] = &[
    Observable { name: "tip_deflection", unit: "µm", meaning: "y of the tip" },
    Observable { name: "tip_position", unit: "µm", meaning: "x of the tip" },
    Observable { name: "tip_angle", unit: "rad", meaning: "angle at the tip" },
    Observable { name: "largest_angle", unit: "rad", meaning: "largest |psi| along the filament" },
    Observable { name: "energy", unit: "pN µm", meaning: "elastic energy, of bending and of the base's spring" },
    Observable { name: "base_tension", unit: "pN", meaning: "tension at the base, along x" },
];

/// Positions in the parameter vector; after these `K` with a pinned base, then `s0` with a distal load.
mod index {
    pub const L: usize = 0;
    pub const EI: usize = 1;
    pub const C_N: usize = 2;
    pub const C_T: usize = 3;
    pub const TIP: usize = 4;
    pub const SPREAD: usize = 5;
    pub const K: usize = 7;
}

impl Filament {
    /// From the scene's options `load`, `base` and `functions`.
    pub fn build(options: &Options) -> Result<Arc<dyn Problem>, ModelError> {
        let load = options.choice("load", &[("uniform", Load::Uniform), ("distal", Load::Distal)])?;
        let base = options.choice("base", &[("clamped", Base::Clamped), ("pinned", Base::Pinned)])?;
        let functions = options.integer("functions", 16, 2, 400)?;
        Ok(Arc::new(Automatic(Self::new(functions, load, base))))
    }

    pub fn new(functions: usize, load: Load, base: Base) -> Self {
        use Bounds::{Any, Positive};
        use Default::{Derived, Tie, Value};
        let make = |name, default, unit, bounds, meaning| Parameter { name, default, unit, meaning, bounds };
        let mut parameters = vec![
            make("L", Value(1.0), "µm", Positive, "length"),
            make("EI", Value(1.0), "pN µm²", Positive, "flexural rigidity"),
            make("c_N", Value(1.0), "pN s µm⁻²", Positive, "normal drag per length"),
            make("c_T", Tie("c_N / 2"), "pN s µm⁻²", Positive, "tangential drag per length"),
            make("P", Value(0.0), "pN", Any, "follower load at the tip, compressive"),
            make("p", Value(0.0), "pN µm⁻¹", Any, "follower load per length, compressive, times D(s)"),
            make("tau", Derived("c_N * L^4 / EI"), "s", Positive, "visco-elastic time"),
        ];
        if base == Base::Pinned {
            parameters.push(make("k", Value(1.0), "pN µm", Positive, "stiffness of the spring at the base"));
        }
        if load == Load::Distal {
            parameters.push(make("s0", Value(0.5), "µm", Positive, "decay length of the load's deficit at the base"));
        }
        let basis = if base == Base::Pinned { Basis::turning(functions) } else { Basis::new(functions) };
        Self { basis, load, base, parameters }
    }

    fn forces<S: Scalar>(&self, p: &[S]) -> Forces<S> {
        use index::{C_N, C_T, EI, K, L, SPREAD, TIP};
        let zero = S::from(0.0);
        let (length, per_bending) = (p[L], p[EI].recip());
        let (second, third) = (length * length * per_bending, length * length * length * per_bending);
        let follows = S::from(1.0);
        let rate = (self.load == Load::Distal).then(|| length / p[p.len() - 1]);
        Forces {
            inertia: zero,
            tip_inertia: zero,
            drag: [p[C_T] * third * length, p[C_N] * third * length],
            viscosity: zero,
            carried: zero,
            tip: Push { size: p[TIP] * second, follows },
            spread: Push { size: p[SPREAD] * third, follows },
            profile: self.load.profile(&self.basis.x, rate),
            spring: if self.base == Base::Pinned { p[K] * length * per_bending } else { zero },
        }
    }
}

impl Formula for Filament {
    fn dim(&self) -> usize {
        self.basis.functions
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        work(&self.basis, &self.forces(p), &State { psi: u, rate: v, acceleration: None }, g);
    }

    fn linearise(&self, at: At, gu: &mut Matrix, gv: &mut Matrix) {
        let slopes = slopes(&self.basis, &self.forces(at.p), &State { psi: at.u, rate: at.v, acceleration: None });
        if let (Matrix::Dense(gu), Matrix::Dense(gv)) = (gu, gv) {
            gu.copy_from(slopes.psi);
            gv.copy_from(slopes.rate);
        }
    }

    fn time_unit(&self) -> &'static str {
        "s"
    }

    fn observables(&self) -> &[Observable] {
        OBSERVABLES
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        let (basis, length, bending) = (&self.basis, at.p[index::L], at.p[index::EI]);
        let psi = |k: usize| (0..basis.functions).map(|j| basis.value[(k, j)] * at.u[j]).sum::<f64>();
        let forces = self.forces(at.p);
        match i {
            0 => length * basis.total((0..basis.points).map(|k| psi(k).sin())),
            1 => length * basis.total((0..basis.points).map(|k| psi(k).cos())),
            2 => end(basis, at.u),
            3 => basis.largest(at.u),
            4 => {
                let energy = |(k, c): (usize, &f64)| 0.5 * forces.bending(basis, k)[0] * c * c;
                at.u.iter().enumerate().map(energy).sum::<f64>() * bending / length
            }
            5 => {
                let state = State { psi: at.u, rate: at.v, acceleration: None };
                -bracket(basis, &forces, &state, end(basis, at.u)).total[0] * bending / length.powi(2)
            }
            _ => f64::NAN,
        }
    }

    fn reflection(&self) -> Option<Reflection> {
        Some(Reflection::negation(self.dim()))
    }

    fn picture_unit(&self) -> &'static str {
        "µm"
    }

    fn picture(&self, u: &[f64], p: &[f64]) -> Option<Vec<[f64; 2]>> {
        Some(line(p[index::L], |x| {
            let (sine, cosine) = self.basis.psi(u, x).sin_cos();
            [cosine, sine]
        }))
    }

    fn refined(&self) -> Option<Refinement> {
        let build = |more| Arc::new(Automatic(Self::new(more, self.load, self.base))) as Arc<dyn Problem>;
        Some(finer(self.basis.functions, 1, build))
    }
}
