//! Exact G_u and G_v of the two-doublet model as matrix products.
//!
//! A change q of psi_n turns t into n q and n into -t q, moves the doublet by w = int q n and, at fixed psi_t, changes
//! its velocity by y = -int psi_t t q. So with P, V the columns of w and y for all basis functions, resolved along t
//! and n, W the weights, and G the load beyond a point,
//!
//! ```text
//! G_u = e_n I + B^T [-t.G + W m'] B + P_t^T W [tau_T V_t + (eps f_N - (tau_N - tau_T) v.n) B]
//!                               + P_n^T W [tau_N V_n - (eps P D + (tau_N - tau_T) v.t) B + eps eps' H]
//! G_v = P_t^T W tau_T P_t + P_n^T W [tau_N P_n + eps eps' beta_N C B] + beta_T/2 B^T W B
//! ```
//!
//! where H = -d f_N / d Delta, C integrates from 0, and eps' is the sign of the doublet that is varied.

use super::parameters::{EPS, Groups, Law};
use super::two_doublet::TwoDoublet;
use crate::models::rod::{Variation, product, scaled_rows, times};
use crate::problem::At;
use faer::reborrow::ReborrowMut;
use faer::{Mat, MatMut};

pub(super) fn fill(model: &TwoDoublet, at: At, mut gu: MatMut<'_, f64>, mut gv: MatMut<'_, f64>) {
    let basis = &model.basis;
    let (k, m) = (basis.functions, basis.points);
    let (b, w) = (&basis.value, &basis.w);
    let groups = model.groups(at.p);
    let distribution = model.distribution(at.p);
    let (psi, psi_t) = (model.on_points(at.u), model.on_points(at.v));
    let delta: Vec<f64> = (0..m).map(|i| psi[0][i] - psi[1][i]).collect();
    let delta_t: Vec<f64> = (0..m).map(|i| psi_t[0][i] - psi_t[1][i]).collect();
    let f_n = model.normal_force(&groups, &delta, &delta_t);
    let elastic = stiffness(model, &groups, &delta);
    let viscous = (groups.beta_n != 0.0).then(|| scaled_rows(&basis.integrated_value, |_| groups.beta_n));

    // The shear moment acts alike on both doublets, whichever is varied.
    let slope = |i: usize| {
        let mean = 0.5 * (psi[0][i] + psi[1][i]);
        0.5 * w[i] * (groups.kappa_t + 3.0 * groups.kappa_3t * mean * mean)
    };
    let shear = (!groups.shearless()).then(|| {
        let elastic = product(basis.value_transposed.as_ref(), scaled_rows(b, slope).as_ref());
        [elastic, Mat::from_fn(k, k, |i, j| 0.5 * groups.beta_t * basis.gram[(i, j)])]
    });

    for n in 0..2 {
        let traction = model.traction(EPS[n], &groups, (&psi[n], &psi_t[n]), (&distribution, &f_n));
        let (s, c) = (&traction.motion.sine, &traction.motion.cosine);
        let (beyond_x, beyond_y) = (basis.beyond(&traction.g_x), basis.beyond(&traction.g_y));
        let moving = at.v.iter().any(|&v| v != 0.0);
        let varied = Variation::new(basis, &traction.motion, &psi_t[n], moving);

        // Rows 0..m along t, m..2m along n: left = W P, right = [bracket of G_u, bracket of G_v].
        let spread = groups.tau_n - groups.tau_t;
        let on_t: Vec<f64> = (0..m).map(|i| EPS[n] * f_n[i] - spread * traction.v_n[i]).collect();
        let on_n: Vec<f64> =
            (0..m).map(|i| -EPS[n] * groups.load * distribution[i] - spread * traction.v_t[i]).collect();
        let (mut left, mut right) = (Mat::zeros(2 * m, k), Mat::zeros(2 * m, 2 * k));
        let scale = |out: &mut [f64], from: &[f64], factor: f64| {
            out.iter_mut().zip(from).for_each(|(x, from)| *x = factor * from);
        };
        for j in 0..k {
            let (from_t, from_n) = varied.displacement.col_as_slice(j).split_at(m);
            let (left_t, left_n) = left.col_as_slice_mut(j).split_at_mut(m);
            left_t.iter_mut().zip(w.iter().zip(from_t)).for_each(|(l, (w, p))| *l = w * p);
            left_n.iter_mut().zip(w.iter().zip(from_n)).for_each(|(l, (w, p))| *l = w * p);
            let (p_t, p_n) = right.col_as_slice_mut(k + j).split_at_mut(m);
            scale(p_t, from_t, groups.tau_t);
            scale(p_n, from_n, groups.tau_n);
            let (bracket_t, bracket_n) = right.col_as_slice_mut(j).split_at_mut(m);
            if let Some(velocity) = &varied.velocity {
                let (from_t, from_n) = velocity.col_as_slice(j).split_at(m);
                scale(bracket_t, from_t, groups.tau_t);
                scale(bracket_n, from_n, groups.tau_n);
            }
            let b = b.col_as_slice(j);
            bracket_t.iter_mut().zip(on_t.iter().zip(b)).for_each(|(x, (f, b))| *x += f * b);
            bracket_n.iter_mut().zip(on_n.iter().zip(b)).for_each(|(x, (f, b))| *x += f * b);
        }
        let own = product(left.as_ref().transpose(), right.as_ref());
        let turned = scaled_rows(b, |i| -c[i] * beyond_x[i] - s[i] * beyond_y[i]);
        let turned = product(basis.value_transposed.as_ref(), turned.as_ref());
        let tested = left.as_ref().subrows(m, m).transpose();
        let elastic = product(tested, elastic.as_ref());
        let viscous = viscous.as_ref().map(|viscous| product(tested, viscous.as_ref()));

        for (other, eps) in EPS.into_iter().enumerate() {
            let sign = EPS[n] * eps;
            for j in 0..k {
                let mut out_u = gu.rb_mut().col_mut(other * k + j).subrows_mut(n * k, k);
                let mut out_v = gv.rb_mut().col_mut(other * k + j).subrows_mut(n * k, k);
                out_u.rb_mut().iter_mut().zip(elastic.col_as_slice(j)).for_each(|(out, cross)| *out = sign * cross);
                match &viscous {
                    None => out_v.fill(0.0),
                    Some(viscous) => {
                        let viscous = viscous.col_as_slice(j).iter();
                        out_v.rb_mut().iter_mut().zip(viscous).for_each(|(out, cross)| *out = sign * cross);
                    }
                }
                for (out, shear) in [out_u, out_v].into_iter().zip(shear.iter().flatten()) {
                    out.iter_mut().zip(shear.col_as_slice(j)).for_each(|(out, shear)| *out += shear);
                }
                if other == n {
                    let mut out_u = gu.rb_mut().col_mut(n * k + j).subrows_mut(n * k, k);
                    for (out, (own, turned)) in
                        out_u.rb_mut().iter_mut().zip(own.col_as_slice(j).iter().zip(turned.col_as_slice(j)))
                    {
                        *out += own + turned;
                    }
                    out_u[j] += groups.bending[n];
                    let out_v = gv.rb_mut().col_mut(n * k + j).subrows_mut(n * k, k);
                    out_v.iter_mut().zip(own.col_as_slice(k + j)).for_each(|(out, own)| *out += own);
                }
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
