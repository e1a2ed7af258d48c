//! The Hopf normal form of `G(u, u', p) = 0`, solution-dependent mass included.
//!
//! On the centre manifold `u = u_0 + z q + zbar qbar + H20 z²/2 + H11 |z|² + ...`, `z' = i omega z + c1 z |z|²`. With
//! `A(sigma) = G_u + sigma G_v`, `Q = (q, i omega q)` a direction of (u, v), and exact derivatives of G
//! (Kuznetsov 2004, doi:10.1007/978-1-4757-3978-7, section 5.4, written for the implicit form):
//!
//! ```text
//! A(2 i omega) H20 = -D²G[Q, Q],      A(0) H11 = -D²G[Q, Qbar],
//! c1 = -w^H ( D³G[Q, Q, Qbar] + 2 D²G[Q, (H11, 0)] + D²G[Qbar, (H20, 2 i omega H20)] ) / 2,
//! l1 = Re c1 / omega.
//! ```
//!
//! l1 < 0: stable cycles on the unstable side (supercritical); l1 > 0: subcritical. Its size is for `q^H q = 1`.

use super::Hopf;
use super::hopf::HopfError;
use super::multilinear::{Complex, second};
use crate::linalg::{Factors, PencilFactors, c64};
use crate::problem::{At, Problem};

/// What is born at a Hopf point.
#[derive(Clone, Debug)]
pub struct HopfNormalForm {
    pub c1: c64,
    /// First Lyapunov coefficient.
    pub l1: f64,
    pub h20: Vec<c64>,
    pub h11: Vec<f64>,
    /// Along the cycles, `p - p_H = p2 r²` and `omega - omega_H = omega2 r²` with `r = |z|`.
    pub p2: f64,
    pub omega2: f64,
}

impl HopfNormalForm {
    pub fn new(problem: &dyn Problem, hopf: &Hopf) -> Result<Self, HopfError> {
        let n = problem.dim();
        let rest = vec![0.0; n];
        let at = At { u: &hopf.u, v: &rest, p: &hopf.p };
        let (gu, gv) = problem.matrices(at);
        let q = Complex::new(&hopf.q, hopf.omega);
        let q_bar = q.conjugate();

        let twice = 2.0 * hopf.omega;
        let mut h20 = second(problem, at, &q, &q);
        h20.iter_mut().for_each(|z| *z = -*z);
        PencilFactors::new(&gu, &gv, c64::new(0.0, twice))?.solve(&mut h20);
        let mut h11: Vec<f64> = second(problem, at, &q, &q_bar).iter().map(|z| -z.re).collect();
        Factors::new(&gu)?.solve(&mut h11);

        let steady = Complex { u: h11.iter().map(|&x| c64::new(x, 0.0)).collect(), v: Vec::new() };
        let double = Complex::new(&h20, twice);
        let cubic = third(problem, at, &q);
        let (with_steady, with_double) = (second(problem, at, &q, &steady), second(problem, at, &q_bar, &double));
        let c1 =
            -0.5 * (0..n).map(|i| hopf.w[i].conj() * (cubic[i] + 2.0 * with_steady[i] + with_double[i])).sum::<c64>();
        let p2 = -c1.re / hopf.slope.re;
        let omega2 = c1.im + hopf.slope.im * p2;
        Ok(Self { c1, l1: c1.re / hopf.omega, h20, h11, p2, omega2 })
    }
}

/// `D³G[a, a, abar] = C(r, r, r) + C(r, s, s) + i (C(r, r, s) + C(s, s, s))` with a = r + i s.
fn third(problem: &dyn Problem, at: At, a: &Complex) -> Vec<c64> {
    let [r, s] = a.split();
    let (r, s) = (r.direction(), s.direction());
    let mut sum = vec![c64::new(0.0, 0.0); problem.dim()];
    let mut out = vec![0.0; problem.dim()];
    for (directions, unit) in [
        ([r, r, r], c64::new(1.0, 0.0)),
        ([r, s, s], c64::new(1.0, 0.0)),
        ([r, r, s], c64::new(0.0, 1.0)),
        ([s, s, s], c64::new(0.0, 1.0)),
    ] {
        problem.derivative(at, &directions, &mut out);
        sum.iter_mut().zip(&out).for_each(|(t, &o)| *t += unit * o);
    }
    sum
}
