//! The normal form at a generalised Hopf (Bautin) point: the second Lyapunov coefficient.
//!
//! On the centre manifold `u = u_0 + U(r, theta)`, `z = r e^{i theta}`, `z' = z (i omega + c1 r² + c2 r⁴)`, so that
//!
//! ```text
//! U = sum_m r^m U_m(theta),      U_1 = q e^{i theta} + c.c.,
//! V = d/dt U = (Re c1 r³ + Re c2 r⁵) dU/dr + (omega + Im c1 r² + Im c2 r⁴) dU/dtheta.
//! ```
//!
//! Order by order in r, `G(U, V, p) = 0` is linear in the newest term: its harmonic l solves
//! `A(i l omega) U_ml = -R_ml`, R being what the known terms leave (exact Taylor coefficients, Fourier analysis in
//! theta), and for l = 1 at odd orders the bordered system gives c1 and c2, too. This is the expansion of
//! Poincare and Lindstedt on the centre manifold; no derivative of order four or five is ever formed, and a
//! solution-dependent mass needs nothing special. With `l2 = Re c2 / omega` (Kuznetsov 2004,
//! doi:10.1007/978-1-4757-3978-7, section 8.3; there at l1 = 0, where l2 does not depend on the choice of coordinates).

use super::Hopf;
use super::hopf::HopfError;
use crate::linalg::{Bordered, Lu, c64};
use crate::problem::{At, Direction, Problem};
use faer::Mat;
use std::f64::consts::PI;

/// The Hopf normal form to fifth order.
#[derive(Clone, Copy, Debug)]
pub struct Bautin {
    pub c1: c64,
    pub c2: c64,
    /// Second Lyapunov coefficient: its sign tells whether the outer cycle of the two is stable (l2 < 0). Its size is
    /// for `q^H q = 1`.
    pub l2: f64,
}

const ORDER: usize = 5;
/// Points in theta over half a turn; the other half follows from `R_m(theta + pi) = (-1)^m R_m(theta)`. Twice as many
/// tell all harmonics up to the fifth apart.
const POINTS: usize = 6;

/// Harmonics 0 to 5 of a real periodic vector; those below zero are the conjugates.
type Harmonics = Vec<Vec<c64>>;

impl Bautin {
    pub fn new(problem: &dyn Problem, hopf: &Hopf) -> Result<Self, HopfError> {
        let n = problem.dim();
        let rest = vec![0.0; n];
        let at = At { u: &hopf.u, v: &rest, p: &hopf.p };
        let (gu, gv) = problem.linearised(at);
        let (gu, gv) = (gu.as_ref(), gv.as_ref());
        let pencil = |l: usize| Mat::from_fn(n, n, |i, j| c64::new(gu[(i, j)], l as f64 * hopf.omega * gv[(i, j)]));
        let mass = |x: &[c64]| -> Vec<c64> { (0..n).map(|i| (0..n).map(|j| x[j] * gv[(i, j)]).sum()).collect() };
        // A(i omega) bordered by M q and (w^H M): the border's unknown is the coefficient.
        let critical = pencil(1);
        let size = critical.norm_max();
        let column: Vec<c64> = mass(&hopf.q).iter().map(|z| size * z).collect();
        let row: Vec<c64> = (0..n).map(|j| (0..n).map(|i| hopf.w[i] * gv[(i, j)]).sum::<c64>() * size).collect();
        let resonant = Bordered::new(critical.as_ref(), &column, &row, c64::new(0.0, 0.0))?;

        let none = || vec![vec![c64::new(0.0, 0.0); n]; ORDER + 1];
        let (mut u, mut v): (Vec<Harmonics>, Vec<Harmonics>) = (vec![none(); 2], vec![none(); 2]);
        u[1][1] = hopf.q.clone();
        v[1][1] = hopf.q.iter().map(|z| c64::new(0.0, hopf.omega) * z).collect();
        let mut coefficients = Vec::new();
        for order in 2..=ORDER {
            // What of V is known before U of this order is.
            let mut known = none();
            for (k, &c) in coefficients.iter().enumerate() {
                let before = order - 2 * (k + 1);
                let c: c64 = c;
                for l in 0..=before {
                    let rate = c64::new(before as f64 * c.re, l as f64 * c.im);
                    known[l].iter_mut().zip(&u[before][l]).for_each(|(known, u)| *known += rate * u);
                }
            }
            u.push(none());
            v.push(known);
            let left = remainder(problem, at, &u, &v);
            for l in (order % 2..=order).step_by(2) {
                let mut x: Vec<c64> = left[l].iter().map(|z| -z).collect();
                if l == 1 {
                    x.push(c64::new(0.0, 0.0));
                    resonant.solve(&mut x);
                    let c = x.pop().unwrap_or_default() * size;
                    coefficients.push(c);
                    v[order][l].iter_mut().zip(&hopf.q).for_each(|(v, q)| *v += c * q);
                } else if order < ORDER {
                    Lu::new(pencil(l))?.solve(&mut x);
                }
                let rate = c64::new(0.0, l as f64 * hopf.omega);
                v[order][l].iter_mut().zip(&x).for_each(|(v, u)| *v += rate * u);
                u[order][l] = x;
            }
        }
        let (c1, c2) = (coefficients[0], coefficients[1]);
        Ok(Self { c1, c2, l2: c2.re / hopf.omega })
    }
}

/// Harmonics of the coefficient of r^m in `G(U, V)`, m being the number of terms after the zeroth.
fn remainder(problem: &dyn Problem, at: At, u: &[Harmonics], v: &[Harmonics]) -> Harmonics {
    let n = problem.dim();
    let order = u.len() - 1;
    let mut found = vec![vec![c64::new(0.0, 0.0); n]; ORDER + 1];
    let mut out = vec![0.0; n];
    for k in 0..POINTS {
        let theta = PI * k as f64 / POINTS as f64;
        let waves: Vec<c64> = (0..=ORDER).map(|l| c64::from_polar(1.0, l as f64 * theta)).collect();
        let real = |x: &Harmonics| -> Vec<f64> {
            (0..n).map(|i| x[0][i].re + (1..=ORDER).map(|l| 2.0 * (x[l][i] * waves[l]).re).sum::<f64>()).collect()
        };
        let terms: Vec<(Vec<f64>, Vec<f64>)> = (1..=order).map(|m| (real(&u[m]), real(&v[m]))).collect();
        let terms: Vec<Direction> = terms.iter().map(|(u, v)| Direction { u, v, p: &[] }).collect();
        problem.coefficient(at, &terms, &mut out);
        for l in (order % 2..=order).step_by(2) {
            let factor = waves[l].conj() / POINTS as f64;
            found[l].iter_mut().zip(&out).for_each(|(f, &o)| *f += factor * o);
        }
    }
    found
}
