//! What both forms of the two-doublet model share: laws, parameters, and the groups that they make.

use crate::models::rod::Load;
use crate::problem::{Bounds, Default, Parameter, Scalar};

/// The cubic part of the inter-doublet normal force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// f_N,s = -k_3N (psi_1 - psi_2)^3, as (2.2) prints.
    Printed,
    /// f_N = -k_3N h^3 with the separation h.
    Separation,
}

/// Positions in the parameter vector; `S0` only with a distal load.
pub(super) mod index {
    pub const L: usize = 0;
    pub const EI: usize = 1;
    pub const A: usize = 2;
    pub const C_N: usize = 3;
    pub const C_T: usize = 4;
    pub const K_N: usize = 5;
    pub const B_N: usize = 6;
    pub const K_T: usize = 7;
    pub const B_T: usize = 8;
    pub const K_3N: usize = 9;
    pub const K_3T: usize = 10;
    pub const P: usize = 11;
    pub const EI_2: usize = 14;
    pub const S0: usize = 15;
}

pub(super) fn parameters(load: Load) -> Vec<Parameter> {
    use Bounds::{Any, NonNegative, Positive};
    use Default::{Derived, Tie, Value};
    let make = |name, default, unit, bounds, meaning| Parameter { name, default, unit, meaning, bounds };
    let mut list = vec![
        make("L", Value(12.0), "µm", Positive, "length"),
        make(
            "EI",
            Value(400.0),
            "pN µm²",
            Positive,
            "flexural rigidity of one doublet, of the first where they differ",
        ),
        make("a", Value(0.2), "µm", NonNegative, "diameter of the flagellum"),
        make("c_N", Value(0.003), "pN s µm⁻²", Positive, "normal drag per length"),
        make("c_T", Tie("c_N / 2"), "pN s µm⁻²", Positive, "tangential drag per length"),
        make("k_N", Value(1e4), "pN µm⁻²", NonNegative, "inter-doublet normal stiffness"),
        make("b_N", Tie("tau_c * k_N"), "pN s µm⁻²", NonNegative, "inter-doublet normal viscosity"),
        make("k_T", Value(1e3), "pN µm⁻²", NonNegative, "inter-doublet shear stiffness"),
        make("b_T", Tie("tau_c * k_T"), "pN s µm⁻²", NonNegative, "inter-doublet shear viscosity"),
        make("k_3N", Value(1e5), "pN µm⁻⁴", Any, "cubic normal stiffness"),
        make("k_3T", Value(2500.0), "pN µm⁻⁴", Any, "cubic shear stiffness"),
        make("p", Value(400.0), "pN µm⁻¹", Any, "dynein force per length"),
        make("tau_c", Value(7.776e-4), "s", NonNegative, "inter-doublet time constant"),
        make("tau", Derived("c_N * L^4 / EI"), "s", Positive, "visco-elastic time of the flagellum"),
        make("EI_2", Tie("EI"), "pN µm²", Positive, "flexural rigidity of doublet 2, where it differs"),
    ];
    if load == Load::Distal {
        list.push(make("s0", Value(4.0), "µm", Positive, "decay length of the load's deficit at the base"));
    }
    list
}

/// The groups that multiply the terms of the weak form.
pub(super) struct Groups<S> {
    /// Of each doublet, in parts of the first one's.
    pub bending: [S; 2],
    pub tau_n: S,
    pub tau_t: S,
    pub load: S,
    pub kappa_n: S,
    pub beta_n: S,
    pub kappa_3n: S,
    pub kappa_t: S,
    pub beta_t: S,
    pub kappa_3t: S,
}

impl<S: Scalar> Groups<S> {
    /// Whether no moment couples the doublets.
    pub fn shearless(&self) -> bool {
        self.kappa_t.vanishes() && self.beta_t.vanishes() && self.kappa_3t.vanishes()
    }

    /// From all parameters; the cubic stiffness has the unit that the law gives it.
    pub fn new(p: &[S], law: Law) -> Self {
        use index::{A, B_N, B_T, C_N, C_T, EI, EI_2, K_3N, K_3T, K_N, K_T, L, P};
        let length = p[L];
        let (l2, a2) = (length * length, p[A] * p[A]);
        let per_bending = p[EI].recip();
        let (fourth, second) = (l2 * l2 * per_bending, l2 * per_bending);
        Groups {
            bending: [S::one(), p[EI_2] * per_bending],
            tau_n: p[C_N] * fourth,
            tau_t: p[C_T] * fourth,
            load: p[P] * l2 * length * per_bending,
            kappa_n: p[K_N] * fourth,
            beta_n: p[B_N] * fourth,
            kappa_3n: match law {
                Law::Printed => p[K_3N] * fourth,
                Law::Separation => p[K_3N] * fourth * l2,
            },
            kappa_t: p[K_T] * a2 * second,
            beta_t: p[B_T] * a2 * second,
            kappa_3t: p[K_3T] * a2 * a2 * second,
        }
    }
}

/// Doublet 1 is pulled toward the tip, doublet 2 toward the base.
pub(super) const EPS: [f64; 2] = [1.0, -1.0];
