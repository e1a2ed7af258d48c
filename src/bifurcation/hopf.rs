//! Hopf points on their exact defining system.
//!
//! With `A(sigma) = G_u + sigma G_v` at an equilibrium, the complex scalar g of the bordered system
//!
//! ```text
//! [ A(i omega)  b ] [q]   [0]        [ A^H  c ] [w]   [0]
//! [ c^H         0 ] [g] = [1],       [ b^H  0 ] [h] = [1]
//! ```
//!
//! vanishes exactly where i omega is an eigenvalue, and `dg = -w^H dA q` (Griewank and Reddien 1983,
//! doi:10.1093/imanum/3.3.295; Govaerts 2000, doi:10.1137/1.9780898719543). Newton's method on `G = 0, g = 0` in (u, p, omega) is done by
//! block elimination with factors of G_u and of the bordered matrix alone, so it stays n by n and converges
//! quadratically to rounding. Second derivatives are exact.

use super::multilinear::Complex;
use crate::linalg::{BorderedPencil, Factors, Matrix, Singular, c64, norm};
use crate::problem::{At, Direction, Problem};
use thiserror::Error;

/// A Hopf point with its eigenvectors, `q^H q = 1`, `w^H M q = 1`.
#[derive(Clone, Debug)]
pub struct Hopf {
    pub u: Vec<f64>,
    pub p: Vec<f64>,
    pub omega: f64,
    pub q: Vec<c64>,
    pub w: Vec<c64>,
    /// d sigma / dp along the branch of equilibria, p being the free parameter.
    pub slope: c64,
    /// The last Newton steps in p and omega: what rounding leaves open (residual times condition).
    pub rounding: (f64, f64),
    /// Relative perturbations delta of all entries of G_u and G_v move the eigenvalue i omega by at most
    /// `condition delta omega` to first order,
    /// `condition = |w|^T (|G_u| + omega |G_v|) |q| / (omega |w^H M q|)` (Higham and Higham 1998,
    /// doi:10.1137/S0895479896313188): large where the eigenvectors are far from orthogonal. Entries that are sums of larger
    /// terms are perturbed by more than a part of themselves: for these it is a lower bound.
    pub condition: f64,
}

#[derive(Debug, Error, PartialEq)]
pub enum HopfError {
    #[error(transparent)]
    Singular(#[from] Singular),
    #[error("Newton's method on the Hopf point did not converge (last relative step {0:.1e})")]
    Diverged(f64),
    #[error("a quantity of the Hopf point is not finite")]
    NotFinite,
}

const MOST_STEPS: usize = 25;
/// Relative steps below this that shrink no more are rounding: short waves in stiff springs leave eight digits.
const NOISE: f64 = 1e-6;

impl Hopf {
    /// Solves for a Hopf point near (u, p, omega, q) with `p[free]` unknown.
    pub fn locate(
        problem: &dyn Problem,
        (u, p): (&[f64], &[f64]),
        free: usize,
        omega: f64,
        q: &[c64],
    ) -> Result<Self, HopfError> {
        let n = problem.dim();
        let mut hopf = Self {
            u: u.to_vec(),
            p: p.to_vec(),
            omega,
            q: q.to_vec(),
            w: q.to_vec(),
            slope: c64::new(0.0, 0.0),
            rounding: (f64::INFINITY, f64::INFINITY),
            condition: f64::NAN,
        };
        let mut size_p = p[free].abs();
        let mut size_u = norm(u);
        let (mut last, mut last_moved) = (f64::INFINITY, f64::INFINITY);
        for step in 0..MOST_STEPS {
            let frame = Frame::new(problem, &hopf, free)?;
            hopf.q = frame.q.clone();
            hopf.w = frame.w.clone();
            // [g_p g_omega] [dp; domega] = -(g + g_u du0), du0 = -G_u^-1 G
            let shifted = frame.g + frame.along(&frame.correction, 0.0, problem, &hopf, free);
            let g_p = frame.along(&frame.du_dp, 1.0, problem, &hopf, free);
            let g_omega = c64::new(0.0, 1.0) * frame.mass;
            let determinant = g_p.re * g_omega.im - g_p.im * g_omega.re;
            let dp = (-shifted.re * g_omega.im + shifted.im * g_omega.re) / determinant;
            let domega = (-shifted.im * g_p.re + shifted.re * g_p.im) / determinant;
            let du: Vec<f64> = (0..n).map(|i| frame.correction[i] + dp * frame.du_dp[i]).collect();
            hopf.u.iter_mut().zip(&du).for_each(|(u, d)| *u += d);
            hopf.p[free] += dp;
            hopf.omega += domega;
            let before = hopf.rounding;
            hopf.rounding = (dp.abs(), domega.abs());
            // Next to p = 0 what dp does to the eigenvalue counts, in parts of omega.
            size_p = size_p.max(hopf.p[free].abs()).max((hopf.omega * frame.mass.norm() / g_p.norm()).abs());
            let size = (dp / size_p).abs().max((domega / hopf.omega).abs());
            // The state may lag behind, and may be zero but for rounding, which shrinks no more.
            let moved = norm(&du);
            size_u = size_u.max(norm(&hopf.u));
            let settled = moved <= 1e-15 * size_u || moved > 0.3 * last_moved;
            // Rounding is reached when steps stop shrinking; both are samples of it then.
            let noise = size < NOISE && step > 1 && size > 0.3 * last;
            if noise {
                hopf.rounding = (hopf.rounding.0.max(before.0), hopf.rounding.1.max(before.1));
            }
            if settled && (size < 1e-15 || noise) {
                return hopf.normalised(problem, free);
            }
            if !size.is_finite() {
                return Err(HopfError::Diverged(size));
            }
            (last, last_moved) = (size, moved);
        }
        if last < NOISE { hopf.normalised(problem, free) } else { Err(HopfError::Diverged(last)) }
    }

    /// The same point with its slope along another parameter.
    pub fn along(self, problem: &dyn Problem, free: usize) -> Result<Self, HopfError> {
        self.normalised(problem, free)
    }

    /// Eigenvectors and slope at the converged point: `q^H q = 1`, `w^H M q = 1`.
    fn normalised(mut self, problem: &dyn Problem, free: usize) -> Result<Self, HopfError> {
        let frame = Frame::new(problem, &self, free)?;
        let norm = frame.q.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
        // A defined phase: the largest entry of q is real and positive.
        let pivot = frame.q.iter().copied().fold(c64::new(0.0, 0.0), |a, b| if b.norm() > a.norm() { b } else { a });
        let turn = pivot.conj() / (pivot.norm() * norm);
        // g_sigma = -w^H M q, so `frame.mass` is minus the product to normalise.
        let product = -frame.mass * turn;
        self.slope = -frame.along(&frame.du_dp, 1.0, problem, &self, free) / frame.mass;
        self.q = frame.q.iter().map(|z| z * turn).collect();
        self.w = frame.w.iter().map(|z| z / product.conj()).collect();
        self.condition = self.sensitivity(problem);
        Ok(self)
    }

    /// The condition of the eigenvalue, for vectors with `w^H M q = 1`.
    fn sensitivity(&self, problem: &dyn Problem) -> f64 {
        let rest = vec![0.0; problem.dim()];
        let (gu, gv) = problem.matrices(At { u: &self.u, v: &rest, p: &self.p });
        let moved = |matrix: Matrix| -> f64 {
            matrix.entries().into_iter().map(|(i, j, x)| self.w[i].norm() * x.abs() * self.q[j].norm()).sum()
        };
        moved(gu) / self.omega.abs() + moved(gv)
    }
}

/// Everything that one Newton step needs at a trial point.
struct Frame {
    g: c64,
    q: Vec<c64>,
    w: Vec<c64>,
    /// `-w^H G_v q`, the derivative of g with respect to sigma.
    mass: c64,
    /// `-G_u^-1 G`.
    correction: Vec<f64>,
    /// du/dp along the branch, `-G_u^-1 G_p`.
    du_dp: Vec<f64>,
}

impl Frame {
    fn new(problem: &dyn Problem, hopf: &Hopf, free: usize) -> Result<Self, Singular> {
        let n = problem.dim();
        let rest = vec![0.0; n];
        let at = At { u: &hopf.u, v: &rest, p: &hopf.p };
        let (gu, gv) = problem.matrices(at);
        let lu = Factors::new(&gu)?;
        let mut correction = vec![0.0; n];
        problem.residual(at, &mut correction);
        lu.solve(&mut correction);
        correction.iter_mut().for_each(|c| *c = -*c);
        let mut e = vec![0.0; hopf.p.len()];
        e[free] = 1.0;
        let mut du_dp = vec![0.0; n];
        problem.derivative(at, &[Direction { u: &[], v: &[], p: &e }], &mut du_dp);
        lu.solve(&mut du_dp);
        du_dp.iter_mut().for_each(|c| *c = -*c);

        let unit = |z: &[c64]| -> Vec<c64> {
            let norm = z.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
            z.iter().map(|z| z / norm).collect()
        };
        // Borders with entries of A's own size keep the bordered matrix well conditioned.
        let size = gu.norm_max().max(hopf.omega.abs() * gv.norm_max());
        let b: Vec<c64> = unit(&hopf.w).iter().map(|z| z * size).collect();
        let c: Vec<c64> = unit(&hopf.q).iter().map(|z| z * size).collect();
        let bordered = BorderedPencil::new((&gu, &gv), c64::new(0.0, hopf.omega), &b, &c)?;
        let mut right = vec![c64::new(0.0, 0.0); n + 1];
        right[n] = c64::new(size, 0.0);
        let mut left = right.clone();
        bordered.solve(&mut right);
        bordered.solve_adjoint(&mut left);
        let g = right[n];
        right.truncate(n);
        left.truncate(n);
        let mass = -left.iter().zip(gv.times_complex(&right)).map(|(w, z)| w.conj() * z).sum::<c64>();
        // The two borders were scaled: w^H b = size, so dg = -w^H dA q / size.
        let mass = mass / size;
        Ok(Self { g, q: right, w: left.iter().map(|z| z / size).collect(), mass, correction, du_dp })
    }

    /// Derivative of g along (du, dp): `-w^H (D²G [(q, i omega q), (du, 0, dp)])`.
    fn along(&self, du: &[f64], dp: f64, problem: &dyn Problem, hopf: &Hopf, free: usize) -> c64 {
        let n = problem.dim();
        let rest = vec![0.0; n];
        let at = At { u: &hopf.u, v: &rest, p: &hopf.p };
        let mut e = vec![0.0; hopf.p.len()];
        e[free] = dp;
        let second = Direction { u: du, v: &[], p: &e };
        let [real, imaginary] = Complex::new(&self.q, hopf.omega).split();
        let mut product = c64::new(0.0, 0.0);
        let mut out = vec![0.0; n];
        for (part, unit) in [(&real, c64::new(1.0, 0.0)), (&imaginary, c64::new(0.0, 1.0))] {
            problem.derivative(at, &[part.direction(), second], &mut out);
            product -= unit * self.w.iter().zip(&out).map(|(w, &o)| w.conj() * o).sum::<c64>();
        }
        product
    }
}
