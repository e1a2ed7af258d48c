//! Coefficients on a centre manifold with several simple critical eigenvalues.
//!
//! With eigenvalues s_i, right vectors q_i and left vectors w_i (`w_i^H M q_i = 1`), on
//! `u = u_0 + sum q_i z_i + sum h_jk z_j z_k / 2 + ...` the amplitudes obey
//! `z_i' = s_i z_i + sum g^i_jk z_j z_k / 2 + sum g^i_jkl z_j z_k z_l / 6 + ...`, where only resonant g are kept (those
//! with `s_j + s_k = s_i`, `s_j + s_k + s_l = s_i`). From `G(u, u', p) = 0`, with directions `Q_i = (q_i, s_i q_i)` and
//! `Q_jk = (h_jk, (s_j + s_k) h_jk + sum_i g^i_jk q_i)` of (u, v),
//!
//! ```text
//! A(s_j + s_k) h_jk + M sum_i g^i_jk q_i = -D²G[Q_j, Q_k],
//! g^i_jkl = -w_i^H ( D³G[Q_j, Q_k, Q_l] + sum over the three pairs ( D²G[Q_jk, Q_l] + M sum_m g^m_jk h_ml ) ).
//! ```
//!
//! (Kuznetsov 1999, doi:10.1137/S0036142998335005, for `u' = F(u)`; written here for the implicit form.)

use super::hopf::HopfError;
use super::multilinear::{Complex, second, third};
use crate::linalg::{Bordered, Lu, c64};
use crate::problem::{At, Problem};
use faer::{Mat, MatRef};

/// A critical eigenvalue with its vectors, `q^H q = 1`, `w^H M q = 1`.
#[derive(Clone, Debug)]
pub struct Mode {
    pub sigma: c64,
    pub q: Vec<c64>,
    pub w: Vec<c64>,
}

/// Inverse iterations with the bordered pencil: one makes a vector, the others square its error.
const ITERATIONS: usize = 3;
/// Sums of eigenvalues that differ by less than this part of the largest are resonant.
const RESONANT: f64 = 1e-6;

impl Mode {
    /// The vectors of an eigenvalue that is known.
    pub fn of(gu: MatRef<'_, f64>, gv: MatRef<'_, f64>, sigma: c64) -> Result<Self, HopfError> {
        let n = gu.nrows();
        let a = Mat::from_fn(n, n, |i, j| gu[(i, j)] + sigma * gv[(i, j)]);
        let size = a.norm_max();
        let unit = |x: &[c64]| -> Vec<c64> {
            let norm = x.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
            x.iter().map(|z| z / norm).collect()
        };
        let any: Vec<c64> = (0..n).map(|i| c64::new(1.0 + (7 * i % 5) as f64, (3 * i % 7) as f64)).collect();
        let (mut q, mut w) = (unit(&any), unit(&any));
        for _ in 0..ITERATIONS {
            let scaled = |x: &[c64]| -> Vec<c64> { x.iter().map(|z| size * z).collect() };
            let bordered = Bordered::new(a.as_ref(), &scaled(&w), &scaled(&q), c64::new(0.0, 0.0))?;
            let mut right = vec![c64::new(0.0, 0.0); n + 1];
            right[n] = c64::new(size, 0.0);
            let mut left = right.clone();
            bordered.solve(&mut right);
            bordered.solve_adjoint(&mut left);
            (q, w) = (unit(&right[..n]), unit(&left[..n]));
        }
        let product: c64 = (0..n).map(|i| w[i].conj() * (0..n).map(|j| q[j] * gv[(i, j)]).sum::<c64>()).sum();
        w.iter_mut().for_each(|z| *z /= product.conj());
        Ok(Self { sigma, q, w })
    }

    pub fn conjugate(&self) -> Self {
        let conj = |x: &[c64]| x.iter().map(|z| z.conj()).collect();
        Self { sigma: self.sigma.conj(), q: conj(&self.q), w: conj(&self.w) }
    }
}

/// h_jk and g^i_jk of one pair.
struct Pair {
    h: Vec<c64>,
    g: Vec<c64>,
    direction: Complex,
}

/// The manifold at an equilibrium `at` (v = 0).
pub struct Centre<'a> {
    problem: &'a dyn Problem,
    at: At<'a>,
    gv: Mat<f64>,
    modes: Vec<Mode>,
    directions: Vec<Complex>,
    /// Pairs (j, k), j >= k, at j (j + 1) / 2 + k.
    pairs: Vec<Pair>,
}

impl<'a> Centre<'a> {
    pub fn new(problem: &'a dyn Problem, at: At<'a>, modes: Vec<Mode>) -> Result<Self, HopfError> {
        let (gu, gv) = problem.linearised(at);
        let direction = |mode: &Mode| Complex { u: mode.q.clone(), v: mode.q.iter().map(|z| mode.sigma * z).collect() };
        let directions: Vec<Complex> = modes.iter().map(direction).collect();
        let mut centre = Self { problem, at, gv: gv.as_ref().to_owned(), modes, directions, pairs: Vec::new() };
        for j in 0..centre.modes.len() {
            for k in 0..=j {
                let pair = centre.pair(gu.as_ref(), j, k)?;
                centre.pairs.push(pair);
            }
        }
        Ok(centre)
    }

    /// `g^i_jk`, the coefficient of `z_j z_k / 2` (of `z_j z_k` where j and k differ).
    pub fn quadratic(&self, i: usize, j: usize, k: usize) -> c64 {
        self.of(j, k).g[i]
    }

    /// `g^i_jkl`.
    pub fn cubic(&self, i: usize, [j, k, l]: [usize; 3]) -> c64 {
        let q = |m: usize| &self.directions[m];
        let mut sum = third(self.problem, self.at, [q(j), q(k), q(l)]);
        for (a, b, c) in [(j, k, l), (k, l, j), (l, j, k)] {
            let pair = self.of(a, b);
            let bent = second(self.problem, self.at, &pair.direction, q(c));
            sum.iter_mut().zip(bent).for_each(|(s, b)| *s += b);
            for (m, &g) in pair.g.iter().enumerate().filter(|(_, g)| g.norm() > 0.0) {
                let moved = self.mass(&self.of(m, c).h);
                sum.iter_mut().zip(moved).for_each(|(s, x)| *s += g * x);
            }
        }
        -product(&self.modes[i].w, &sum)
    }

    fn of(&self, j: usize, k: usize) -> &Pair {
        let (j, k) = (j.max(k), j.min(k));
        &self.pairs[j * (j + 1) / 2 + k]
    }

    fn mass(&self, x: &[c64]) -> Vec<c64> {
        let n = x.len();
        (0..n).map(|i| (0..n).map(|j| x[j] * self.gv[(i, j)]).sum()).collect()
    }

    fn pair(&self, gu: MatRef<'_, f64>, j: usize, k: usize) -> Result<Pair, HopfError> {
        let n = gu.nrows();
        let largest = self.modes.iter().map(|mode| mode.sigma.norm()).fold(0.0, f64::max);
        let sigma = self.modes[j].sigma + self.modes[k].sigma;
        let a = Mat::from_fn(n, n, |i, j| gu[(i, j)] + sigma * self.gv[(i, j)]);
        let mut h = second(self.problem, self.at, &self.directions[j], &self.directions[k]);
        h.iter_mut().for_each(|z| *z = -*z);
        let mut g = vec![c64::new(0.0, 0.0); self.modes.len()];
        match self.modes.iter().position(|mode| (mode.sigma - sigma).norm() <= RESONANT * largest) {
            Some(i) => {
                let mode = &self.modes[i];
                let size = a.norm_max();
                let column: Vec<c64> = self.mass(&mode.q).iter().map(|z| size * z).collect();
                let row = |j: usize| (0..n).map(|i| mode.w[i] * self.gv[(i, j)]).sum::<c64>() * size;
                let row: Vec<c64> = (0..n).map(row).collect();
                h.push(c64::new(0.0, 0.0));
                Bordered::new(a.as_ref(), &column, &row, c64::new(0.0, 0.0))?.solve(&mut h);
                g[i] = h.pop().unwrap_or_default() * size;
            }
            None => Lu::new(a)?.solve(&mut h),
        }
        let velocity = |i: usize| sigma * h[i] + g.iter().zip(&self.modes).map(|(g, mode)| g * mode.q[i]).sum::<c64>();
        let direction = Complex { u: h.clone(), v: (0..n).map(velocity).collect() };
        Ok(Pair { h, g, direction })
    }
}

fn product(w: &[c64], x: &[c64]) -> c64 {
    w.iter().zip(x).map(|(w, x)| w.conj() * x).sum()
}
