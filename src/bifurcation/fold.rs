//! Folds on their defining system, and what happens there.
//!
//! With the bordered scalar g of G_u (see [`super::FoldCurve`]) the equations `G(u, 0, p) = 0, g = 0` in (u, p) are
//! regular at a fold. On the centre manifold, `u = u_0 + x q + ...` and m the deviation of the parameter,
//!
//! ```text
//! x' = b m + a x²,      b = -w^T G_p,      a = -w^T D²G[q, q] / 2,      |q| = 1, w^T M q = 1
//! ```
//!
//! (Kuznetsov 2004, doi:10.1007/978-1-4757-3978-7, section 5.4; written for the implicit form). The sign of q, and with
//! it that of both coefficients, is such that its largest entry is positive.

use super::steady::{Steady, adjoint, positive};
use crate::continuation::Failure;
use crate::linalg::{Lu, Matrix, any, dot, finite, norm, unit};
use crate::problem::{At, Direction, Problem};
use faer::Mat;

/// A fold with its null vectors and normal form.
#[derive(Clone, Debug)]
pub struct Fold {
    pub u: Vec<f64>,
    pub p: Vec<f64>,
    pub q: Vec<f64>,
    pub w: Vec<f64>,
    /// The quadratic coefficient.
    pub a: f64,
    /// The coefficient of the parameter.
    pub b: f64,
    /// The last Newton step in the parameter: what rounding leaves open.
    pub rounding: f64,
}

const MOST_STEPS: usize = 25;

impl Fold {
    /// Solves for a fold near (u, p) with `p[free]` unknown, of which `width` counts as much; `near` is a vector close to
    /// the kernel, such as the tangent.
    pub fn locate(
        problem: &dyn Problem,
        (u, p): (&[f64], &[f64]),
        (free, width): (usize, f64),
        near: &[f64],
    ) -> Result<Self, Failure> {
        let n = u.len();
        let rest = vec![0.0; n];
        let (mut u, mut p) = (u.to_vec(), p.to_vec());
        let (mut gamma, mut beta) = (unit(near), unit(&any(n)));
        let mut e = vec![0.0; p.len()];
        e[free] = 1.0;
        let (mut largest, mut last) = (width, f64::INFINITY);
        for step in 0..MOST_STEPS {
            let at = At { u: &u, v: &rest, p: &p };
            let (gu, gv) = problem.matrices(at);
            let mut steady = Steady::structured(&gu, &beta, &gamma)?;
            if step == 0 {
                // The left vector is not known; two inverse iterations make one.
                for _ in 0..2 {
                    beta = unit(&steady.left(n)[..n]);
                    steady = Steady::structured(&gu, &beta, &gamma)?;
                }
            }
            let (mut q, mut w) = (steady.solve(&vec![0.0; n], 1.0), steady.left(n));
            let g = q[n];
            q.truncate(n);
            w.truncate(n);
            let (mut residual, mut by_parameter) = (vec![0.0; n], vec![0.0; n]);
            problem.residual(at, &mut residual);
            problem.derivative(at, &[Direction { u: &[], v: &[], p: &e }], &mut by_parameter);
            // du = -d0 - dp d1 + t q, whose scalar must vanish as g + dg does.
            let (d0, d1) = (steady.solve(&residual, 0.0), steady.solve(&by_parameter, 0.0));
            let bend = |du: &[f64], dp: &[f64]| {
                let mut out = vec![0.0; n];
                let kernel = Direction { u: &q, v: &[], p: &[] };
                problem.derivative(at, &[kernel, Direction { u: du, v: &[], p: dp }], &mut out);
                -dot(&w, &out)
            };
            let back: Vec<f64> = d1[..n].iter().map(|x| -x).collect();
            let small = Mat::from_fn(2, 2, |i, j| match (i, j) {
                (0, 0) => g,
                (0, 1) => -d1[n],
                (1, 0) => bend(&q, &[]),
                _ => bend(&back, &e),
            });
            let sizes = [0, 1].map(|i| small[(i, 0)].abs().max(small[(i, 1)].abs()).max(f64::MIN_POSITIVE));
            let scaled = Mat::from_fn(2, 2, |i, j| small[(i, j)] / sizes[i]);
            let mut y = [d0[n] / sizes[0], (bend(&d0[..n], &[]) - g) / sizes[1]];
            Lu::new(scaled)?.solve(&mut y);
            let [t, dp] = y;
            let du: Vec<f64> = (0..n).map(|i| -d0[i] - dp * d1[i] + t * q[i]).collect();
            if !finite(&du) || !dp.is_finite() {
                return Err(Failure::NotFinite);
            }
            u.iter_mut().zip(&du).for_each(|(u, d)| *u += d);
            p[free] += dp;
            largest = largest.max(p[free].abs());
            // In the state's own size: next to a degenerate point, where steps shrink by halves, no larger one would do.
            let size = (dp / largest).abs().max(norm(&du) / (norm(&u) + 1e-3));
            (gamma, beta) = (unit(&q), unit(&w));
            if size < 1e-15 || (size < 1e-8 && step > 1 && size > 0.3 * last) {
                return Ok(Self::formed(problem, (u, p), (&q, &w), (&gv, &e), dp.abs()));
            }
            last = size;
        }
        Err(Failure::Diverged(last))
    }

    fn formed(
        problem: &dyn Problem,
        (u, p): (Vec<f64>, Vec<f64>),
        (q, w): (&[f64], &[f64]),
        (gv, e): (&Matrix, &[f64]),
        rounding: f64,
    ) -> Self {
        let n = u.len();
        let q = positive(&unit(q));
        let w = adjoint(gv, &q, w);
        let rest = vec![0.0; n];
        let at = At { u: &u, v: &rest, p: &p };
        let kernel = Direction { u: &q, v: &[], p: &[] };
        let along = |directions: &[Direction]| {
            let mut out = vec![0.0; n];
            problem.derivative(at, directions, &mut out);
            -dot(&w, &out)
        };
        let (a, b) = (0.5 * along(&[kernel, kernel]), along(&[Direction { u: &[], v: &[], p: e }]));
        Self { u, p, q, w, a, b, rounding }
    }
}
