//! Exact derivatives of the weak form of one rod, as matrix products.
//!
//! With N and T the columns of q n and q t for all functions q, P = int_0^x N the displacements, W the weights and F
//! the force beyond a point, the derivative along a change of angle, rate or acceleration is
//!
//! ```text
//! P^T W dg + P(1)^T df - B^T W (t . F) B + bending     (the third term for angles alone)
//! d r_tt = int (-psi_tt T - psi_t^2 N),  int (-2 psi_t T),  P;      d r_t = int (-psi_t T),  P,  0.
//! ```

use super::basis::{Basis, times};
use super::forces::{Bracket, Forces, State, bracket, end};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

/// Derivatives with respect to coefficients of psi, psi_t and psi_tt, the last with inertia alone.
pub struct Slopes {
    pub psi: Mat<f64>,
    pub rate: Mat<f64>,
    pub acceleration: Option<Mat<f64>>,
}

/// Both components of columns at the Gauss points.
type Planar = [Mat<f64>; 2];

pub fn slopes(basis: &Basis, forces: &Forces<f64>, state: &State<'_, f64>) -> Slopes {
    let end = end(basis, state.psi);
    let Bracket { motion, beyond, .. } = bracket(basis, forces, state, end);
    let (m, b) = (basis.points, &basis.value);
    let (s, c) = (&motion.sine, &motion.cosine);
    let (psi, rate) = (times(b, state.psi), times(b, state.rate));
    let turning = state.acceleration.map(|a| times(b, a));
    let moving = rate.iter().chain(turning.iter().flatten()).any(|&v| v != 0.0);
    // a N + b T with factors by point.
    let combine = |on_n: &dyn Fn(usize) -> f64, on_t: &dyn Fn(usize) -> f64| -> Planar {
        [scaled_rows(b, |i| on_t(i) * c[i] - on_n(i) * s[i]), scaled_rows(b, |i| on_t(i) * s[i] + on_n(i) * c[i])]
    };
    let integrate =
        |columns: &Planar| -> Planar { [0, 1].map(|d| product(basis.integral.as_ref(), columns[d].as_ref())) };
    let totals = |columns: &Planar| [0, 1].map(|d| times(&columns[d].transpose().to_owned(), &basis.w));
    let one = combine(&|_| 1.0, &|_| 0.0);
    let (displaced, reach) = (integrate(&one), totals(&one));
    let accelerated = turning.as_ref().filter(|_| moving).map(|turning| {
        let by_angle = combine(&|i| -rate[i] * rate[i], &|i| -turning[i]);
        let by_rate = combine(&|_| 0.0, &|i| -2.0 * rate[i]);
        [by_angle, by_rate]
    });
    let swept = moving.then(|| integrate(&combine(&|_| 0.0, &|i| -rate[i])));

    // The resistance to columns of velocities, and to the turning of t and n under the velocity there is.
    let [d_t, d_n] = forces.drag;
    let resist = |velocity: &Planar, g: &mut Planar| {
        for j in 0..basis.functions {
            let (x, y) = (velocity[0].col_as_slice(j), velocity[1].col_as_slice(j));
            for i in 0..m {
                let along = (d_t - d_n) * (c[i] * x[i] + s[i] * y[i]);
                g[0][(i, j)] += d_n * x[i] + along * c[i];
                g[1][(i, j)] += d_n * y[i] + along * s[i];
            }
        }
    };
    let spread = |i: usize| {
        let (sine, cosine) = (forces.spread.follows * psi[i]).sin_cos();
        let size = forces.spread.size * forces.profile[i] * forces.spread.follows;
        [-size * sine, size * cosine]
    };
    let v: Vec<[f64; 2]> = (0..m).map(|i| motion.resolved(i)).collect();
    let turned = combine(&|i| (d_t - d_n) * v[i][0], &|i| (d_t - d_n) * v[i][1] - forces.carried * rate[i]);
    let mut by_angle: Planar = [0, 1].map(|d| &turned[d] + scaled_rows(b, |i| spread(i)[d]));
    let mut by_rate = combine(&|_| forces.carried, &|_| 0.0);
    if let Some(swept) = &swept {
        resist(swept, &mut by_angle);
    }
    resist(&displaced, &mut by_rate);
    if let Some([angle, rate]) = &accelerated {
        for (g, columns) in [(&mut by_angle, angle), (&mut by_rate, rate)] {
            let acceleration = integrate(columns);
            (0..2).for_each(|d| g[d] += faer::Scale(forces.inertia) * &acceleration[d]);
        }
    }

    // Tested by P and, at the tip, by P(1).
    let weighted: Planar = [0, 1].map(|d| scaled_rows(&displaced[d], |i| basis.w[i]));
    let test = |g: &Planar| -> Mat<f64> {
        let [x, y] = [0, 1].map(|d| product(weighted[d].transpose(), g[d].as_ref()));
        x + y
    };
    let at_tip = |out: &mut Mat<f64>, force: &[Vec<f64>; 2], size: f64| {
        for d in 0..2 {
            for (j, f) in force[d].iter().enumerate() {
                out.col_as_slice_mut(j).iter_mut().zip(&reach[d]).for_each(|(o, r)| *o += size * r * f);
            }
        }
    };
    let (mut psi_slope, mut rate_slope) = (test(&by_angle), test(&by_rate));
    let bent = scaled_rows(b, |i| -c[i] * beyond[0][i] - s[i] * beyond[1][i]);
    psi_slope += product(basis.value_transposed.as_ref(), bent.as_ref());
    let (sine, cosine) = (forces.tip.follows * end).sin_cos();
    let size = forces.tip.size * forces.tip.follows;
    let push = [-sine, cosine].map(|part| basis.tip.iter().map(|q| part * q).collect());
    at_tip(&mut psi_slope, &push, size);
    if let Some([angle, rate]) = &accelerated {
        at_tip(&mut psi_slope, &totals(angle), forces.tip_inertia);
        at_tip(&mut rate_slope, &totals(rate), forces.tip_inertia);
    }
    for k in 0..basis.functions {
        let [stiff, viscous] = forces.bending(basis, k);
        psi_slope[(k, k)] += stiff;
        rate_slope[(k, k)] += viscous;
    }
    let acceleration = state.acceleration.map(|_| {
        let mut mass = faer::Scale(forces.inertia) * test(&displaced);
        at_tip(&mut mass, &reach, forces.tip_inertia);
        mass
    });
    Slopes { psi: psi_slope, rate: rate_slope, acceleration }
}

/// The rows of A times factors.
pub fn scaled_rows(a: &Mat<f64>, factor: impl Fn(usize) -> f64) -> Mat<f64> {
    let factors: Vec<f64> = (0..a.nrows()).map(factor).collect();
    let mut out = a.clone();
    for j in 0..a.ncols() {
        out.col_as_slice_mut(j).iter_mut().zip(&factors).for_each(|(o, f)| *o *= f);
    }
    out
}

/// A B on one thread.
pub fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut out = Mat::zeros(a.nrows(), b.ncols());
    matmul(out.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
    out
}
