//! The normal form at a zero-Hopf (fold-Hopf) point: eigenvalues 0 and +-i omega.
//!
//! With x along the kernel and z of the pair,
//!
//! ```text
//! x' = G200 x²/2 + G011 |z|² + G300 x³/6 + G111 x |z|²,
//! z' = i omega z + G110 x z + G210 x² z/2 + G021 z |z|²/2,
//! ```
//!
//! and what unfolds is decided by (Kuznetsov 2004, doi:10.1007/978-1-4757-3978-7, section 8.5)
//!
//! ```text
//! s = sign(G200 G011),     theta = Re G110 / G200,
//! E = Re( G210 + G110 (Re G021 / G011 - G300 / G200 + G111 / G011) - G021 G200 / (2 G011) ) / 2.
//! ```

use super::centre::{Centre, Mode};
use super::hopf::HopfError;
use crate::linalg::c64;
use crate::problem::{At, Problem};

/// The coefficients that decide; vectors have length one.
#[derive(Clone, Copy, Debug)]
pub struct ZeroHopf {
    pub g200: f64,
    pub g011: f64,
    pub g110: c64,
    /// +1 or -1.
    pub s: f64,
    pub theta: f64,
    pub e: f64,
}

impl ZeroHopf {
    /// At the equilibrium u with eigenvalues 0 and i omega.
    pub fn new(problem: &dyn Problem, u: &[f64], p: &[f64], omega: f64) -> Result<Self, HopfError> {
        let rest = vec![0.0; u.len()];
        let at = At { u, v: &rest, p };
        let (gu, gv) = problem.linearised(at);
        let mut steady = Mode::of(gu.as_ref(), gv.as_ref(), c64::new(0.0, 0.0))?;
        // The kernel is real: its vectors are made so, the largest entry being positive.
        let pivot = steady.q.iter().copied().fold(c64::new(0.0, 0.0), |a, b| if b.norm() > a.norm() { b } else { a });
        let turn = pivot.conj() / pivot.norm();
        for x in [&mut steady.q, &mut steady.w] {
            x.iter_mut().for_each(|z| *z = c64::new((*z * turn).re, 0.0));
        }
        let pair = Mode::of(gu.as_ref(), gv.as_ref(), c64::new(0.0, omega))?;
        let modes = vec![steady, pair.clone(), pair.conjugate()];
        let centre = Centre::new(problem, at, modes)?;
        let (x, z, z_bar) = (0, 1, 2);
        let (g200, g011) = (centre.quadratic(x, x, x).re, centre.quadratic(x, z, z_bar).re);
        let g110 = centre.quadratic(z, x, z);
        let (g300, g111) = (centre.cubic(x, [x, x, x]).re, centre.cubic(x, [x, z, z_bar]).re);
        let (g210, g021) = (centre.cubic(z, [x, x, z]), centre.cubic(z, [z, z, z_bar]));
        let e = 0.5 * (g210 + g110 * (g021.re / g011 - g300 / g200 + g111 / g011) - g021 * (0.5 * g200 / g011)).re;
        Ok(Self { g200, g011, g110, s: (g200 * g011).signum(), theta: g110.re / g200, e })
    }
}
