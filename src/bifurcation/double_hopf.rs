//! The normal form at a double Hopf (Hopf-Hopf) point: two pairs on the axis.
//!
//! ```text
//! z1' = z1 (i omega_1 + G2100 |z1|²/2 + G1011 |z2|²),     p11 = Re G2100/2,  p12 = Re G1011,
//! z2' = z2 (i omega_2 + G1110 |z1|² + G0021 |z2|²/2),     p21 = Re G1110,    p22 = Re G0021/2,
//! ```
//!
//! and what unfolds is decided by the signs of p11 and p22, by `theta = p12/p22` and `delta = p21/p11` (Kuznetsov 2004,
//! doi:10.1007/978-1-4757-3978-7, section 8.6): "simple" where p11 p22 > 0, "difficult" where p11 p22 < 0.

use super::centre::{Centre, Mode};
use super::hopf::HopfError;
use crate::linalg::c64;
use crate::problem::{At, Problem};

/// The coefficients that decide; vectors have length one.
#[derive(Clone, Copy, Debug)]
pub struct DoubleHopf {
    /// p11, p12, p21, p22.
    pub p: [f64; 4],
    pub theta: f64,
    pub delta: f64,
}

impl DoubleHopf {
    /// At the equilibrium u with eigenvalues i omega of both frequencies.
    pub fn new(problem: &dyn Problem, u: &[f64], p: &[f64], omegas: [f64; 2]) -> Result<Self, HopfError> {
        let rest = vec![0.0; u.len()];
        let at = At { u, v: &rest, p };
        let (gu, gv) = problem.linearised(at);
        let mode = |omega: f64| Mode::of(gu.as_ref(), gv.as_ref(), c64::new(0.0, omega));
        let (first, second) = (mode(omegas[0])?, mode(omegas[1])?);
        let modes = vec![first.clone(), first.conjugate(), second.clone(), second.conjugate()];
        let centre = Centre::new(problem, at, modes)?;
        let p11 = 0.5 * centre.cubic(0, [0, 0, 1]).re;
        let p12 = centre.cubic(0, [0, 2, 3]).re;
        let p21 = centre.cubic(2, [2, 0, 1]).re;
        let p22 = 0.5 * centre.cubic(2, [2, 2, 3]).re;
        Ok(Self { p: [p11, p12, p21, p22], theta: p12 / p22, delta: p21 / p11 })
    }
}
