//! Exact G_u and G_v of the two-doublet model as matrix products.
//!
//! A change q of psi_n turns t into n q and n into -t q, moves the doublet by w = int_0^x q n and, at fixed psi_t,
//! changes its velocity by -int_0^x psi_t t q. With B and A the matrices of `value` and `integral`, W the weights and
//! D = tau_T t t^T + tau_N n n^T the drag, the columns of w are P = A n B and those of the velocity -A psi_t t B. The
//! latter's A is moved to the test functions, so that one integral more serves both slopes of the drag:
//!
//! ```text
//! Q = A^T W D P = W int_x^1 D P,    P^T W D P = (n.Q)^T B,    P^T W D (-A psi_t t B) = -(psi_t t.Q)^T B.
//! ```
//!
//! With F the load beyond a point, times the weights, H = -d f_N / d Delta, and eps, eps' the signs of the doublets that
//! are tested and varied, the blocks are
//!
//! ```text
//! G_u = eps eps' (W P_n)^T H            + B^T W m' B          + [e_n I + L^T B]    (brackets where both are one)
//! G_v = eps eps' beta_N (W P_n)^T A B   + beta_T/2 B^T W B    + [(n.Q)^T B]
//! L   = W [(eps f_N - tau' v.n) P_t - (eps P D(s) + tau' v.t) P_n] - (t.F) B - psi_t t.Q,    tau' = tau_N - tau_T,
//! ```
//!
//! with the load P D(s) of the weak form and -m' the slope of m. In memory functions are rows and points columns, so that
//! what has one factor at a point is contiguous.

use super::parameters::{EPS, Groups, Law};
use super::two_doublet::TwoDoublet;
use crate::models::rod::{product, scaled_rows, slice, slice_mut, times};
use crate::problem::At;
use faer::linalg::matmul::matmul;
use faer::reborrow::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// G_u and G_v, overwritten. Compiled for each kind of vector unit and chosen when the program runs.
pub(super) fn fill(model: &TwoDoublet, at: At, gu: MatMut<'_, f64>, gv: MatMut<'_, f64>) {
    pulp::Arch::new().dispatch(Fill { model, at, gu, gv });
}

/// The x and the y components of all functions at a point.
type Pair<'a> = (&'a [f64], &'a [f64]);
type PairMut<'a> = (&'a mut [f64], &'a mut [f64]);

struct Fill<'a> {
    model: &'a TwoDoublet,
    at: At<'a>,
    gu: MatMut<'a, f64>,
    gv: MatMut<'a, f64>,
}

impl pulp::NullaryFnOnce for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Fill { model, at, mut gu, mut gv } = self;
        let basis = &model.basis;
        let (k, m) = (basis.functions, basis.points);
        let (b, w) = (&basis.value_transposed, &basis.w);
        let groups = model.groups(at.p);
        let distribution = model.distribution(at.p);
        let (psi, psi_t) = (model.on_points(at.u), model.on_points(at.v));
        let delta: Vec<f64> = (0..m).map(|i| psi[0][i] - psi[1][i]).collect();
        let delta_t: Vec<f64> = (0..m).map(|i| psi_t[0][i] - psi_t[1][i]).collect();
        let f_n = model.normal_force(&groups, &delta, &delta_t);
        let spread = groups.tau_n - groups.tau_t;

        // L above n.Q of each doublet, and eps W P_n of both.
        let mut left = [Mat::zeros(2 * k, m), Mat::zeros(2 * k, m)];
        let mut tested = Mat::zeros(2 * k, m);
        // x components above y components.
        let (mut functions, mut integrals) = (Mat::zeros(2 * k, m), Mat::zeros(2 * k, m + 1));
        for (n, left) in left.iter_mut().enumerate() {
            let eps = EPS[n];
            let traction = model.traction(eps, &groups, (&psi[n], &psi_t[n]), (&distribution, &f_n));
            let [beyond_x, beyond_y] = basis.beyond([&traction.g_x, &traction.g_y]);
            let normal = |i: usize| [-traction.motion.sine[i], traction.motion.cosine[i]];
            for i in 0..m {
                let normals = functions.col_as_slice_mut(i).split_at_mut(k);
                on_normal(normal(i), b.col_as_slice(i), normals);
            }
            basis.halves.integrate(&mut functions, &mut integrals);
            for i in 0..m {
                let [n_x, n_y] = normal(i);
                let on_t = eps * f_n[i] - spread * traction.v_n[i];
                let on_n = -eps * groups.load * distribution[i] - spread * traction.v_t[i];
                let on_p = [w[i] * (on_t * n_y + on_n * n_x), w[i] * (on_n * n_y - on_t * n_x)];
                let on_b = n_x * beyond_y[i] - n_y * beyond_x[i];
                let p = integrals.col_as_slice(i)[..2 * k].split_at(k);
                combine((on_p, p), (on_b, b.col_as_slice(i)), &mut left.col_as_slice_mut(i)[..k]);
                let tested = &mut tested.col_as_slice_mut(i)[n * k..(n + 1) * k];
                let drag = functions.col_as_slice_mut(i).split_at_mut(k);
                resist([n_x, n_y], [groups.tau_t, spread], eps * w[i], p, (tested, drag));
            }
            basis.halves.integrate(&mut functions, &mut integrals);
            let (within, kappa) = integrals.as_ref().split_at_col(m);
            let kappa = slice(kappa, 0).split_at(k);
            for i in 0..m {
                let [n_x, n_y] = normal(i).map(|component| w[i] * component);
                let within = slice(within, i).split_at(k);
                turn([n_x, n_y], psi_t[n][i], (within, kappa), left.col_as_slice_mut(i).split_at_mut(k));
            }
        }

        // What a change of Delta does acts on psi_1 as it is and on psi_2 with the other sign.
        let on_delta = |out: MatMut<'_, f64>, columns: MatRef<'_, f64>, factor: f64| {
            matmul(out.subcols_mut(0, k), Accum::Replace, &tested, columns, factor, Par::Seq);
        };
        on_delta(gu.rb_mut(), stiffness(model, &groups, &delta).as_ref(), 1.0);
        if groups.beta_n == 0.0 {
            gv.rb_mut().subcols_mut(0, k).fill(0.0);
        } else {
            on_delta(gv.rb_mut(), basis.integrated_value.as_ref(), groups.beta_n);
        }
        // The shear moment acts alike on both doublets, whichever is varied.
        let slope = |i: usize| {
            let mean = 0.5 * (psi[0][i] + psi[1][i]);
            0.5 * w[i] * (groups.kappa_t + 3.0 * groups.kappa_3t * mean * mean)
        };
        let elastic = if groups.shearless() {
            Mat::zeros(k, k)
        } else {
            product(b.as_ref(), scaled_rows(&basis.value, slope).as_ref())
        };
        couple(gu.rb_mut(), &elastic, 1.0);
        couple(gv.rb_mut(), &basis.gram, 0.5 * groups.beta_t);
        for (n, left) in left.iter().enumerate() {
            for (out, first) in [(gu.rb_mut(), 0), (gv.rb_mut(), k)] {
                let own = out.submatrix_mut(n * k, n * k, k, k);
                matmul(own, Accum::Add, left.subrows(first, k), &basis.value, 1.0, Par::Seq);
            }
            for j in n * k..(n + 1) * k {
                gu[(j, j)] += groups.bending[n];
            }
        }
    }
}

/// q n of all functions at a point.
#[inline(always)]
fn on_normal([n_x, n_y]: [f64; 2], b: &[f64], (x, y): (&mut [f64], &mut [f64])) {
    for (b, (x, y)) in b.iter().zip(x.iter_mut().zip(y)) {
        (*x, *y) = (n_x * b, n_y * b);
    }
}

/// L without its last term: a vector along P and a factor of B.
#[inline(always)]
fn combine(([x, y], p): ([f64; 2], Pair<'_>), (factor, b): (f64, &[f64]), out: &mut [f64]) {
    for ((out, b), (p_x, p_y)) in out.iter_mut().zip(b).zip(p.0.iter().zip(p.1)) {
        *out = x * p_x + y * p_y + factor * b;
    }
}

/// `weight` P_n and D P = tau_T P + (tau_N - tau_T) P_n n at a point.
#[inline(always)]
fn resist(
    [n_x, n_y]: [f64; 2],
    [tau_t, spread]: [f64; 2],
    weight: f64,
    p: Pair<'_>,
    (tested, drag): (&mut [f64], PairMut<'_>),
) {
    let out = tested.iter_mut().zip(drag.0.iter_mut().zip(drag.1));
    for ((tested, (d_x, d_y)), (x, y)) in out.zip(p.0.iter().zip(p.1)) {
        let along = n_x * x + n_y * y;
        *tested = weight * along;
        *d_x = tau_t * x + spread * n_x * along;
        *d_y = tau_t * y + spread * n_y * along;
    }
}

/// n.Q, and the last term of L, from int_0^x D P and half its total; the normal comes times the weight.
#[inline(always)]
fn turn([n_x, n_y]: [f64; 2], rate: f64, (within, kappa): (Pair<'_>, Pair<'_>), (l, on_n): PairMut<'_>) {
    let (t_x, t_y) = (rate * n_y, -rate * n_x);
    let x = kappa.0.iter().zip(within.0).map(|(kappa, x)| 2.0 * kappa - x);
    let y = kappa.1.iter().zip(within.1).map(|(kappa, y)| 2.0 * kappa - y);
    for ((l, on_n), (x, y)) in l.iter_mut().zip(on_n).zip(x.zip(y)) {
        *l -= t_x * x + t_y * y;
        *on_n = n_x * x + n_y * y;
    }
}

/// From the effects of Delta in the left half to those of both angles, with `factor` times those of their sum.
#[inline(always)]
fn couple(out: MatMut<'_, f64>, sum: &Mat<f64>, factor: f64) {
    let k = sum.ncols();
    let (mut first, mut second) = out.split_at_col_mut(k);
    for j in 0..k {
        let (first, second) = (slice_mut(first.rb_mut(), j), slice_mut(second.rb_mut(), j));
        for (first, second) in first.chunks_exact_mut(k).zip(second.chunks_exact_mut(k)) {
            for (sum, (first, second)) in sum.col_as_slice(j).iter().zip(first.iter_mut().zip(second)) {
                (*first, *second) = (factor * sum + *first, factor * sum - *first);
            }
        }
    }
}

/// H = -d f_N / d Delta, as a matrix from coefficients to Gauss points.
fn stiffness(model: &TwoDoublet, groups: &Groups<f64>, delta: &[f64]) -> Mat<f64> {
    let basis = &model.basis;
    if groups.kappa_3n == 0.0 {
        return scaled_rows(&basis.integrated_value, |_| groups.kappa_n);
    }
    match model.law {
        Law::Printed => {
            let slope = scaled_rows(&basis.value, |i| groups.kappa_n + 3.0 * groups.kappa_3n * delta[i] * delta[i]);
            product(basis.integral.as_ref(), slope.as_ref())
        }
        Law::Separation => {
            let h = times(&basis.integral, delta);
            scaled_rows(&basis.integrated_value, |i| groups.kappa_n + 3.0 * groups.kappa_3n * h[i] * h[i])
        }
    }
}
