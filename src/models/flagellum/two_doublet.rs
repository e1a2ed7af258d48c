//! Two inextensible elastic doublets in viscous fluid, pulled in opposite directions by a steady follower load
//! (Bayly and Dutcher 2016, J. R. Soc. Interface 13:20160523, doi:10.1098/rsif.2016.0523), in minimal coordinates.
//!
//! Unknowns are the tangent angles psi_1, psi_2 alone. With t = (cos psi, sin psi), n = (-sin psi, cos psi), x = s/L,
//! positions r_n = L int_0^x t, velocities v_n = L int_0^x psi_n,t n, every test angle q with q(0) = 0 and its virtual
//! displacement w = int_0^x q n, the principle of virtual work, divided by EI/L, reads for doublet n = 1, 2
//!
//! ```text
//! int w . [ tau_T (v.t) t + tau_N (v.n) n - eps_n (P D(s) t + f_N n) ] dx + int psi_n,x q_x dx - int m q dx = 0,
//!
//! eps = +1, -1;  tau_N = c_N L^4/EI,  tau_T = c_T L^4/EI,  P = p L^3/EI,  Delta = psi_1 - psi_2,
//! f_N = -int_0^x (kappa_N Delta + beta_N Delta_t + kappa_3 Delta^3)            (`printed`, kappa_3 = k_3N L^4/EI), or
//! f_N = -(kappa_N h + beta_N h_t + kappa_3 h^3),  h = int_0^x Delta            (`separation`, kappa_3 = k_3N L^6/EI),
//! m = -(kappa_T psi_m + beta_T psi_m,t + kappa_3T psi_m^3),  psi_m = (psi_1 + psi_2)/2,
//! kappa_N = k_N L^4/EI,  kappa_T = a^2 k_T L^2/EI,  kappa_3T = a^4 k_3T L^2/EI,  beta likewise.
//! ```
//!
//! It has the form M(u) u' = F(u): no tension unknowns, every force condition at base and tip natural.
//! Corrections to the printed equations: D = 1 - exp(-s/s0), not 1 - exp(s/s0) (table 2); k_3T a^4, not a^3 (2.3);
//! in the linearised (2.6) d-bar has L^4, c-bar a factor 1/2, and b sigma-bar stands for b sigma-bar / tau; as printed,
//! (2.2) makes k_3N a pN µm^-2: `separation` is the law that fits its unit.

use super::observables;
use super::parameters::{EPS, Groups, Law, index, parameters};
use crate::linalg::Matrix;
use crate::models::rod::{Basis, Load, Motion, finer, times, times_both};
use crate::problem::{At, Automatic, Formula, Observable, Parameter, Problem, Refinement, Reflection, Scalar};
use std::sync::Arc;

pub struct TwoDoublet {
    pub(super) basis: Basis,
    /// How the dynein load varies along the doublets.
    load: Load,
    pub(super) law: Law,
    parameters: Vec<Parameter>,
}

impl TwoDoublet {
    pub fn new(functions: usize, load: Load, law: Law) -> Self {
        Self { basis: Basis::new(functions), load, law, parameters: parameters(load) }
    }

    pub(super) fn groups<S: Scalar>(&self, p: &[S]) -> Groups<S> {
        Groups::new(p, self.law)
    }

    /// D(s) at the Gauss points.
    pub(super) fn distribution<S: Scalar>(&self, p: &[S]) -> Vec<S> {
        self.load.profile(&self.basis.x, p.get(index::S0).map(|&s0| p[index::L] / s0))
    }

    /// The normal force f_N at the Gauss points, from Delta and Delta_t there.
    pub(super) fn normal_force<S: Scalar>(&self, g: &Groups<S>, delta: &[S], delta_t: &[S]) -> Vec<S> {
        let mut linear: Vec<S> = delta.iter().map(|&d| -g.kappa_n * d).collect();
        if !g.beta_n.vanishes() {
            linear.iter_mut().zip(delta_t).for_each(|(f, &d)| *f -= g.beta_n * d);
        }
        if self.law == Law::Printed && !g.kappa_3n.vanishes() {
            linear.iter_mut().zip(delta).for_each(|(f, &d)| *f -= g.kappa_3n * d * d * d);
        }
        let mut force = times(&self.basis.integral, &linear);
        if self.law == Law::Separation && !g.kappa_3n.vanishes() {
            let h = times(&self.basis.integral, delta);
            force.iter_mut().zip(h).for_each(|(f, h)| *f -= g.kappa_3n * h * h * h);
        }
        force
    }

    /// The moment per length m at the Gauss points; `None` without shear coupling.
    fn moment<S: Scalar>(&self, g: &Groups<S>, psi: &[Vec<S>; 2], psi_t: &[Vec<S>; 2]) -> Option<Vec<S>> {
        if g.shearless() {
            return None;
        }
        let moment = (0..self.basis.points)
            .map(|i| {
                let mean = (psi[0][i] + psi[1][i]) * 0.5;
                let mean_t = (psi_t[0][i] + psi_t[1][i]) * 0.5;
                -(g.kappa_t * mean + g.beta_t * mean_t + g.kappa_3t * mean * mean * mean)
            })
            .collect();
        Some(moment)
    }

    /// Angles (or their rates) of both doublets at the Gauss points.
    pub(super) fn on_points<S: Scalar>(&self, c: &[S]) -> [Vec<S>; 2] {
        let (first, second) = c.split_at(self.basis.functions);
        times_both(&self.basis.value, [first, second])
    }
}

/// What acts on one doublet, at the Gauss points, along t and n.
pub(super) struct Traction<S> {
    pub motion: Motion<S>,
    pub v_t: Vec<S>,
    pub v_n: Vec<S>,
    /// The bracket of the weak form along x and y.
    pub g_x: Vec<S>,
    pub g_y: Vec<S>,
}

impl TwoDoublet {
    /// The bracket [drag - eps (P D t + f_N n)] on doublet `eps`.
    pub(super) fn traction<S: Scalar>(
        &self,
        eps: f64,
        g: &Groups<S>,
        (psi, psi_t): (&[S], &[S]),
        (distribution, f_n): (&[S], &[S]),
    ) -> Traction<S> {
        let motion = Motion::new(&self.basis, psi, psi_t);
        let [mut v_t, mut v_n, mut g_x, mut g_y] = [(); 4].map(|()| Vec::with_capacity(psi.len()));
        for i in 0..psi.len() {
            let ([tangential, normal], s, c) = (motion.resolved(i), motion.sine[i], motion.cosine[i]);
            let along_t = g.tau_t * tangential - g.load * distribution[i] * eps;
            let along_n = g.tau_n * normal - f_n[i] * eps;
            v_t.push(tangential);
            v_n.push(normal);
            g_x.push(along_t * c - along_n * s);
            g_y.push(along_t * s + along_n * c);
        }
        Traction { motion, v_t, v_n, g_x, g_y }
    }
}

impl Formula for TwoDoublet {
    fn dim(&self) -> usize {
        2 * self.basis.functions
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let groups = self.groups(p);
        let distribution = self.distribution(p);
        let (psi, psi_t) = (self.on_points(u), self.on_points(v));
        let difference = |a: &[Vec<S>; 2]| -> Vec<S> { a[0].iter().zip(&a[1]).map(|(&a, &b)| a - b).collect() };
        let f_n = self.normal_force(&groups, &difference(&psi), &difference(&psi_t));
        let m = self.moment(&groups, &psi, &psi_t);
        let k = self.basis.functions;
        for (n, out) in g.chunks_mut(k).enumerate() {
            let traction = self.traction(EPS[n], &groups, (&psi[n], &psi_t[n]), (&distribution, &f_n));
            let [beyond_x, beyond_y] = self.basis.beyond([&traction.g_x, &traction.g_y]);
            let projected = traction.motion.tested(&self.basis, [&beyond_x, &beyond_y], m.as_deref());
            for i in 0..k {
                out[i] = projected[i] + groups.bending[n] * u[n * k + i];
            }
        }
    }

    fn linearise(&self, at: At, gu: &mut Matrix, gv: &mut Matrix) {
        if let (Matrix::Dense(gu), Matrix::Dense(gv)) = (gu, gv) {
            super::linearisation::fill(self, at, gu.as_mut(), gv.as_mut());
        }
    }

    fn time_unit(&self) -> &'static str {
        "s"
    }

    fn observables(&self) -> &[Observable] {
        observables::LIST
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        observables::evaluate(self, i, at)
    }

    fn reflection(&self) -> Option<Reflection> {
        Some(Reflection::negation(self.dim()))
    }

    fn picture_unit(&self) -> &'static str {
        "µm"
    }

    fn picture(&self, u: &[f64], p: &[f64]) -> Option<Vec<[f64; 2]>> {
        Some(observables::mean_line(self, u, p))
    }

    fn refined(&self) -> Option<Refinement> {
        let build = |more| Arc::new(Automatic(Self::new(more, self.load, self.law))) as Arc<dyn Problem>;
        Some(finer(self.basis.functions, 2, build))
    }
}
