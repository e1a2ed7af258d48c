//! The first cycle of a branch, from the normal form of a Hopf point.
//!
//! ```text
//! u(t) = u_H + 2 r Re(q e^{i omega t}) + r² (H11 + Re(H20 e^{2 i omega t})),
//! p = p_H + p2 r²,  omega = omega_H + omega2 r²:
//! ```
//!
//! exact but for terms of third order in r, so Newton's method converges at once even for sizeable r.

use super::{Orbit, Points, Scheme};
use crate::bifurcation::{Hopf, HopfNormalForm};
use crate::linalg::{c64, norm};
use crate::problem::{Problem, Reflection};
use std::f64::consts::PI;

/// The predicted orbit at radius r, and lambda; half of the period where the mode is odd under the reflection.
pub fn from_hopf(
    (hopf, form): (&Hopf, &HopfNormalForm),
    free: usize,
    r: f64,
    (symmetry, parts): (&Reflection, usize),
    (intervals, degree, points): (usize, usize, Points),
) -> (Orbit, f64) {
    let n = hopf.u.len();
    let scheme = Scheme::new(points, degree);
    let omega = hopf.omega + form.omega2 * r * r;
    let part = 2.0 * PI / omega / parts as f64;
    let mut nodes = Vec::with_capacity((intervals * degree + 1) * n);
    for i in 0..=intervals * degree {
        let tau = ((i / degree) as f64 + scheme.nodes[i % degree]) / intervals as f64;
        let theta = 2.0 * PI * tau / parts as f64;
        let (once, twice) = (c64::new(0.0, theta).exp(), c64::new(0.0, 2.0 * theta).exp());
        nodes.extend(
            (0..n).map(|k| {
                hopf.u[k] + 2.0 * r * (hopf.q[k] * once).re + r * r * (form.h11[k] + (form.h20[k] * twice).re)
            }),
        );
    }
    let mut last = vec![0.0; n];
    symmetry.apply(&nodes[..n], &mut last);
    let end = nodes.len() - n;
    nodes[end..].copy_from_slice(&last);
    let mesh = (0..=intervals).map(|j| j as f64 / intervals as f64).collect();
    (Orbit { mesh, points, degree, nodes, dim: n, part, parts, drift: Vec::new() }, hopf.p[free] + form.p2 * r * r)
}

/// The reflection that the cycle obeys over half a period, if the problem has one and the mode is odd under it; `size` is
/// that of the cycles.
pub fn half_period(problem: &dyn Problem, hopf: &Hopf, size: f64) -> Option<Reflection> {
    let reflection = problem.reflection()?;
    let (re, im): (Vec<f64>, Vec<f64>) = hopf.q.iter().map(|z| (z.re, z.im)).unzip();
    let odd = |x: &[f64], size: f64| {
        let mut image = vec![0.0; x.len()];
        reflection.apply(x, &mut image);
        image.iter().zip(x).all(|(a, b)| (a + b).abs() <= 1e-9 * size)
    };
    let mut image = vec![0.0; hopf.u.len()];
    reflection.apply(&hopf.u, &mut image);
    // Large states are reflected up to their rounding.
    let near = (1e-9 * size).max(1e-12 * norm(&hopf.u));
    let fixed = image.iter().zip(&hopf.u).all(|(a, b)| (a - b).abs() <= near);
    (fixed && odd(&re, 1.0) && odd(&im, 1.0)).then_some(reflection)
}
