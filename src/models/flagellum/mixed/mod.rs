//! The two-doublet model with its forces kept: hp finite elements in arclength.
//!
//! Along t and n of each doublet, with lengths in L, forces in EI/L² and the letters of the minimal form, the equations
//! are a system of first order in x,
//!
//! ```text
//! T_x - psi_x N + eps P D  = tau_T v_t        e_n psi_xx + m + N = 0       v_t,x - psi_x v_n = 0
//! N_x + psi_x T + eps f_N  = tau_N v_n        f_N,x = -(kappa_N Delta      v_n,x + psi_x v_t = psi_t
//!                                              + beta_N Delta_t + kappa_3 Delta³)
//! psi = v = f_N = 0 at x = 0,                 psi_x = T = N = 0 at x = 1;      e_1 = 1, e_2 = EI_2/EI.
//! ```
//!
//! The velocities follow from the forces, so that psi_1, psi_2, T_1, T_2, N_1, N_2 and f_N are left, and rates enter linearly
//! with constant factors: a constant singular mass, and no sines. T is counted from the straight state's,
//! `T = eps P int_x^1 D + T~`. That state is zero for every load, and only T~ is discretised. With
//! `tau_T v_t = T~_x - psi_x N` and `tau_N v_n` as above, for all tests a and b (forces along t and n, zero at the tip),
//! q (angles, zero at the base) and g (zero at the tip)
//!
//! ```text
//! int tau_N v_t a_x + psi_x tau_N v_n a                      dx = 0         no stretch
//! int tau_N v_n b_x + (tau_N psi_t - psi_x tau_N v_t) b      dx = 0         turning is psi_t
//! int e_n psi_x q_x - (m + N) q                              dx = 0         balance of moments
//! int f_N g_x - (kappa_N Delta + beta_N Delta_t + kappa_3 Delta³) g dx = 0
//! ```
//!
//! Every condition on velocities, moments and f_N is natural. In `law = "separation"` h is an unknown like f_N,
//! `int h g_x + Delta g = 0`, the last row above has no kappa_3, and what it gives is `f_N + kappa_3 h³`: h_t would make the index two.
//!
//! # Spaces
//!
//! psi and q are continuous of degree k, T~, N, a, b, g continuous of degree k + 1, and f_N, h broken of degree k, which is where
//! derivatives of the latter are. These choices make the form the minimal one of the same angles, but for
//! products that vanish in the straight state:
//!
//! - The first two rows are `K (T~, N) + ... = 0` with K the quadratic form of `int |(T t + N n)_x|²` in the tangents' frame,
//!   weighted with the drag: symmetric and positive definite whatever the shape, by Poincare's inequality, for the force
//!   vanishes at the tip. So (T~, N) is given by psi, psi_t and f_N, without an inf-sup condition of its own.
//! - At rest, b_x runs through all broken polynomials of degree k. With W = int_0^x psi and Pi the projection onto
//!   these, `v_n = Pi W_t`, and N tested with q does the virtual work of `tau_N v_n - eps f_N` along Pi int_0^x q. W has degree k + 1
//!   and `Pi W = 0` only for W = 0: on an element, W would be a multiple of one Legendre polynomial of degree k + 1, and as no
//!   two of them meet with equal values and slopes, it vanishes from the base on. So rates of angles are controlled
//!   (with N of degree k, so of v of degree k - 1, they are not: one mode at the tip has a mass as small as
//!   (2k + 2)^(-2 elements), hence nearly index 2).
//! - `f_N = -Pi int_0^x (kappa_N Delta + beta_N Delta_t)` is the adjoint of the former: after elimination of the forces
//!
//!   ```text
//!   tau_N <Pi W_t, Pi Q> + kappa_N <Pi H, Pi E> + beta_N <Pi H_t, Pi E> + <e_n psi_x, q_x> + shear + load = 0,
//!   ```
//!
//!   Q = int_0^x q, H = W_1 - W_2 and E = Q_1 - Q_2: symmetric, and positive term by term, but for the load, which is of lower
//!   order than bending. It is a Galerkin method for an operator with compact inverse: no eigenvalue is spurious
//!   (Babuska and Osborn 1991, Handbook of Numerical Analysis II, 641), the right half-plane least of all, however stiff
//!   the springs. A continuous f_N integrated from the base would spoil the symmetry by terms that kappa_N magnifies.
//!
//! Eigenvalues converge as h^(2k), functions as h^(k+1) (psi), and exponentially in k.

mod assembly;
mod density;
mod elements;
mod observables;

pub use elements::{LARGEST_DEGREE, Mesh, SMALLEST_DEGREE};

use super::Law;
use super::parameters::{Groups, index, parameters};
use crate::linalg::{Matrix, Structure};
use crate::models::rod::Load;
use crate::problem::{At, Automatic, Formula, Observable, Parameter, Refinement, Reflection, Scalar};
use elements::Elements;
use std::sync::Arc;

pub struct MixedTwoDoublet {
    elements: Elements,
    load: Load,
    law: Law,
    parameters: Vec<Parameter>,
}

impl MixedTwoDoublet {
    pub fn new(mesh: Mesh, load: Load, law: Law) -> Self {
        let elements = Elements::new(mesh, law == Law::Separation);
        Self { elements, load, law, parameters: parameters(load) }
    }

    /// `P int_x^1 D`.
    fn straight_tension<S: Scalar>(&self, groups: &Groups<S>, x: &[f64], p: &[S]) -> Vec<S> {
        let rate = p.get(index::S0).map(|&s0| p[index::L] / s0);
        self.load.beyond(x, rate).into_iter().map(|part| groups.load * part).collect()
    }
}

impl Formula for MixedTwoDoublet {
    fn dim(&self) -> usize {
        self.elements.dim
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        self.assemble((u, v), p, g);
    }

    fn structure(&self) -> Structure {
        let reach = self.elements.width - 1;
        Structure::Banded { lower: reach, upper: reach }
    }

    fn linearise(&self, at: At, gu: &mut Matrix, gv: &mut Matrix) {
        assembly::fill(self, at, gu, gv);
    }

    fn time_unit(&self) -> &'static str {
        "s"
    }

    fn observables(&self) -> &[Observable] {
        super::observables::LIST
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        observables::evaluate(self, i, at)
    }

    /// Tensions stay, angles, normal forces and separations change their sign.
    fn reflection(&self) -> Option<Reflection> {
        let mut reflection = Reflection::negation(self.dim());
        self.elements.places_of_tension().for_each(|i| reflection.sign[i] = 1.0);
        Some(reflection)
    }

    fn picture_unit(&self) -> &'static str {
        "µm"
    }

    fn picture(&self, u: &[f64], p: &[f64]) -> Option<Vec<[f64; 2]>> {
        Some(observables::mean_line(self, u, p))
    }

    /// One degree more on the same elements.
    fn refined(&self) -> Option<Refinement> {
        let mesh = self.elements.mesh;
        let make = || Self::new(Mesh { degree: mesh.degree + 1, ..mesh }, self.load, self.law);
        let separation = self.law == Law::Separation;
        let (coarse, finer) = (Elements::new(mesh, separation), make());
        let fine = Elements::new(finer.elements.mesh, separation);
        let prolong = Box::new(move |u: &[f64]| coarse.raised(&fine, u));
        Some(Refinement { problem: Arc::new(Automatic(finer)), prolong })
    }
}
