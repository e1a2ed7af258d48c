//! The normal form at a Bogdanov-Takens point: a double zero eigenvalue with one eigenvector.
//!
//! With `G_u q0 = 0`, `G_u q1 + M q0 = 0`, `p1^T G_u = 0`, `p1^T M q1 = 1`, on `u = u_0 + q0 x + q1 y + h20 x²/2 + ...`
//!
//! ```text
//! x' = y,     y' = a x² + b x y,
//! a = -p1^T D²G[Q0, Q0]/2,                     Q0 = (q0, 0), Q1 = (q1, q0) in (u, v),
//! b = -p1^T ( D²G[Q0, Q1] + M h20 ),           G_u h20 = -2 a M q1 - D²G[Q0, Q0].
//! ```
//!
//! (Kuznetsov 2004, doi:10.1007/978-1-4757-3978-7, section 8.4; written for the implicit form.) a b < 0: the cycles
//! born at the Hopf curve are stable; a b > 0: they are not.

use super::hopf::HopfError;
use crate::linalg::{Bordered, any, dot, unit};
use crate::problem::{At, Direction, Problem};
use faer::MatRef;

/// The coefficients for `|q0| = 1`, `q0 . q1 = 0`.
#[derive(Clone, Copy, Debug)]
pub struct BogdanovTakens {
    pub a: f64,
    pub b: f64,
}

/// Rounds of inverse iteration for the kernels.
const ITERATIONS: usize = 3;

impl BogdanovTakens {
    pub fn new(problem: &dyn Problem, u: &[f64], p: &[f64]) -> Result<Self, HopfError> {
        let n = u.len();
        let rest = vec![0.0; n];
        let at = At { u, v: &rest, p };
        let (gu, gv) = problem.linearised(at);
        let (gu, gv) = (gu.as_ref(), gv.as_ref());
        let size = gu.norm_max();
        let scaled = |x: &[f64]| -> Vec<f64> { x.iter().map(|x| size * x).collect() };
        let (mut right, mut left) = (unit(&any(n)), unit(&any(n)));
        let mut bordered = Bordered::new(gu, &scaled(&left), &scaled(&right), 0.0)?;
        for _ in 0..ITERATIONS {
            let mut x = vec![0.0; n + 1];
            x[n] = size;
            let mut y = x.clone();
            bordered.solve(&mut x);
            bordered.solve_adjoint(&mut y);
            (right, left) = (unit(&x[..n]), unit(&y[..n]));
            bordered = Bordered::new(gu, &scaled(&left), &scaled(&right), 0.0)?;
        }
        let solve = |right: &[f64]| -> Vec<f64> {
            let mut x = right.to_vec();
            x.push(0.0);
            bordered.solve(&mut x);
            x.truncate(n);
            x
        };
        let q0 = right;
        let q1: Vec<f64> = solve(&times(gv, &q0)).iter().map(|x| -x).collect();
        let length = dot(&left, &times(gv, &q1));
        let p1: Vec<f64> = left.iter().map(|x| x / length).collect();

        let (along_0, along_1) = (Direction { u: &q0, v: &[], p: &[] }, Direction { u: &q1, v: &q0, p: &[] });
        let (mut xx, mut xy) = (vec![0.0; n], vec![0.0; n]);
        problem.derivative(at, &[along_0, along_0], &mut xx);
        problem.derivative(at, &[along_0, along_1], &mut xy);
        let a = -0.5 * dot(&p1, &xx);
        let pull: Vec<f64> = times(gv, &q1).iter().zip(&xx).map(|(m, xx)| -2.0 * a * m - xx).collect();
        let h20 = solve(&pull);
        let b = -dot(&p1, &xy) - dot(&p1, &times(gv, &h20));
        Ok(Self { a, b })
    }
}

fn times(m: MatRef<'_, f64>, x: &[f64]) -> Vec<f64> {
    (0..x.len()).map(|i| (0..x.len()).map(|j| m[(i, j)] * x[j]).sum()).collect()
}
