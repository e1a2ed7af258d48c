//! The weak form of one rod under forces: with lengths in L, forces in EI/L², moments in EI/L, at every test angle q
//!
//! ```text
//! int w . [ I r_tt + d_T (r_t.t) t + d_N (r_t.n) n + C psi_t n + S(x) e(chi_S psi) ] dx
//!   + w(1) . [ m r_tt + P e(chi_P psi) ](1) + int (psi + eta psi_t)_x q_x dx + k psi(0) q(0) = 0,
//!
//! r_t = int_0^x psi_t n,   r_tt = int_0^x (psi_tt n - psi_t^2 t),   e(a) = (cos a, sin a).
//! ```
//!
//! P and S compress the rod; they keep their direction for chi = 0 and follow the tangent for chi = 1.
//! C = 2 M U for a plug flow of mass M per length at speed U, whose momentum M U^2 is a follower load at the tip:
//! the fluid's acceleration is `r_tt + 2 U psi_t n + U^2 psi_x n`, and `int w . n psi_x dx = w(1) . t(1)`.

use super::basis::{Basis, times, times_both};
use super::motion::Motion;
use crate::problem::Scalar;

/// A compressing load: its size, and which part of the angle its direction follows.
#[derive(Clone, Copy)]
pub struct Push<S> {
    pub size: S,
    pub follows: S,
}

/// The coefficients, in the letters of the weak form.
pub struct Forces<S> {
    /// I.
    pub inertia: S,
    /// m.
    pub tip_inertia: S,
    /// d_T, d_N.
    pub drag: [S; 2],
    /// eta.
    pub viscosity: S,
    /// C.
    pub carried: S,
    /// P.
    pub tip: Push<S>,
    /// S without its profile D.
    pub spread: Push<S>,
    /// D at the Gauss points.
    pub profile: Vec<S>,
    /// k.
    pub spring: S,
}

/// Coefficients of psi, psi_t and psi_tt; no accelerations where there is no inertia.
pub struct State<'a, S> {
    pub psi: &'a [S],
    pub rate: &'a [S],
    pub acceleration: Option<&'a [S]>,
}

impl<S: Scalar> Forces<S> {
    /// What bends the rod at coefficient k: `int q_k,x^2` or the base's spring, and the viscosity with the former.
    pub fn bending(&self, basis: &Basis, k: usize) -> [S; 2] {
        if basis.stiffness[k] == 0.0 { [self.spring, S::from(0.0)] } else { [S::from(1.0), self.viscosity] }
    }
}

/// The bracket at the Gauss points and at the tip.
pub struct Bracket<S> {
    pub motion: Motion<S>,
    /// `int_x^1` of the bracket and the tip's, times the weights, along x and y.
    pub beyond: [Vec<S>; 2],
    /// All of it.
    pub total: [S; 2],
}

/// Evaluates the bracket from values at the Gauss points; psi at the tip is `end`.
pub fn bracket<S: Scalar>(basis: &Basis, forces: &Forces<S>, state: &State<'_, S>, end: S) -> Bracket<S> {
    let on_points = |c: &[S]| times(&basis.value, c);
    let [psi, rate] = times_both(&basis.value, [state.psi, state.rate]);
    let motion = Motion::new(basis, &psi, &rate);
    let (s, c) = (&motion.sine, &motion.cosine);
    let m = basis.points;
    let direction = |push: Push<S>, angle: S| {
        let (sine, cosine) = (push.follows * angle).sin_cos();
        [push.size * cosine, push.size * sine]
    };
    let zeros = || vec![S::from(0.0); m];
    let (mut g, mut tip) = ([zeros(), zeros()], direction(forces.tip, end));
    if let Some(acceleration) = state.acceleration {
        let turning = on_points(acceleration);
        let x: Vec<S> = (0..m).map(|i| -turning[i] * s[i] - rate[i] * rate[i] * c[i]).collect();
        let y: Vec<S> = (0..m).map(|i| turning[i] * c[i] - rate[i] * rate[i] * s[i]).collect();
        for ((g, tip), a) in g.iter_mut().zip(&mut tip).zip([x, y]) {
            *tip += forces.tip_inertia * basis.total(a.iter().copied());
            g.iter_mut().zip(times(&basis.integral, &a)).for_each(|(g, r)| *g = forces.inertia * r);
        }
    }
    for i in 0..m {
        let [tangential, normal] = motion.resolved(i);
        let (along_t, along_n) = (forces.drag[0] * tangential, forces.drag[1] * normal + forces.carried * rate[i]);
        g[0][i] += along_t * c[i] - along_n * s[i];
        g[1][i] += along_t * s[i] + along_n * c[i];
    }
    if !forces.spread.size.vanishes() {
        for i in 0..m {
            let [x, y] = direction(forces.spread, psi[i]);
            g[0][i] += forces.profile[i] * x;
            g[1][i] += forces.profile[i] * y;
        }
    }
    let mut beyond = basis.beyond([&g[0], &g[1]]);
    for (beyond, tip) in beyond.iter_mut().zip(tip) {
        beyond.iter_mut().zip(&basis.w).for_each(|(b, &w)| *b += tip * w);
    }
    let total = [0, 1].map(|d| tip[d] + basis.total(g[d].iter().copied()));
    Bracket { motion, beyond, total }
}

/// psi at the tip.
pub fn end<S: Scalar>(basis: &Basis, psi: &[S]) -> S {
    psi.iter().zip(&basis.tip).fold(S::from(0.0), |sum, (&c, &q)| sum + c * q)
}

/// The weak form for every function of the basis.
pub fn work<S: Scalar>(basis: &Basis, forces: &Forces<S>, state: &State<'_, S>, out: &mut [S]) {
    let Bracket { motion, beyond: [x, y], .. } = bracket(basis, forces, state, end(basis, state.psi));
    let tested = motion.tested(basis, [&x, &y], None);
    for (k, (out, tested)) in out.iter_mut().zip(tested).enumerate() {
        let [stiff, viscous] = forces.bending(basis, k);
        *out = tested + stiff * state.psi[k] + viscous * state.rate[k];
    }
}
