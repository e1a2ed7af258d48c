//! What is measured on a two-doublet motion.

use super::parameters::{EPS, Law, index};
use super::two_doublet::TwoDoublet;
use crate::models::rod::{line, times};
use crate::problem::{At, Observable};

pub(super) const LIST: &[Observable] = &[
    Observable { name: "tip_deflection", unit: "µm", meaning: "y of the mean line's tip" },
    Observable { name: "tip_deflection_1", unit: "µm", meaning: "y of doublet 1's tip" },
    Observable { name: "tip_deflection_2", unit: "µm", meaning: "y of doublet 2's tip" },
    Observable { name: "tip_angle", unit: "rad", meaning: "mean angle at the tip" },
    Observable { name: "tip_angle_1", unit: "rad", meaning: "angle of doublet 1 at the tip" },
    Observable { name: "tip_angle_2", unit: "rad", meaning: "angle of doublet 2 at the tip" },
    Observable { name: "largest_angle", unit: "rad", meaning: "largest |psi| along both doublets" },
    Observable { name: "largest_difference", unit: "rad", meaning: "largest |psi_1 - psi_2| along the doublets" },
    Observable {
        name: "energy",
        unit: "pN µm",
        meaning: "elastic energy: bending, shear and normal springs (their cubic part only in law = \"separation\", \
                  where it has a potential; exact to second order in the angles, for h is measured along the lines)",
    },
    Observable { name: "base_tension_1", unit: "pN", meaning: "tension of doublet 1 at the base" },
    Observable { name: "base_tension_2", unit: "pN", meaning: "tension of doublet 2 at the base" },
];

pub(super) fn evaluate(model: &TwoDoublet, i: usize, at: At) -> f64 {
    let k = model.basis.functions;
    let (u, length) = (at.u, at.p[index::L]);
    // Only q_0 is not zero at the tip, where it is one.
    match i {
        0 => 0.5 * length * (tip(model, &u[..k]) + tip(model, &u[k..])),
        1 => length * tip(model, &u[..k]),
        2 => length * tip(model, &u[k..]),
        3 => 0.5 * (u[0] + u[k]),
        4 => u[0],
        5 => u[k],
        6 => model.basis.largest(&u[..k]).max(model.basis.largest(&u[k..])),
        7 => model.basis.largest(&u[..k].iter().zip(&u[k..]).map(|(a, b)| a - b).collect::<Vec<_>>()),
        8 => energy(model, at),
        9 => base_tension(model, 0, at),
        10 => base_tension(model, 1, at),
        _ => f64::NAN,
    }
}

/// int_0^1 sin psi dx.
fn tip(model: &TwoDoublet, c: &[f64]) -> f64 {
    times(&model.basis.value, c).iter().zip(&model.basis.w).map(|(psi, w)| w * psi.sin()).sum()
}

/// Per EI/L: e_n |c_n|²/2 for bending, then the springs.
fn energy(model: &TwoDoublet, at: At) -> f64 {
    let groups = model.groups(at.p);
    let basis = &model.basis;
    let psi = model.on_points(at.u);
    let delta: Vec<f64> = psi[0].iter().zip(&psi[1]).map(|(a, b)| a - b).collect();
    let h = times(&basis.integral, &delta);
    let bent = at.u.chunks(basis.functions).zip(groups.bending);
    let bending = bent.map(|(c, e)| 0.5 * e * c.iter().map(|c| c * c).sum::<f64>()).sum::<f64>();
    let springs: f64 = (0..basis.points)
        .map(|i| {
            let (mean, h2) = (0.5 * (psi[0][i] + psi[1][i]), h[i] * h[i]);
            let m2 = mean * mean;
            let cubic = if model.law == Law::Separation { 0.25 * groups.kappa_3n * h2 * h2 } else { 0.0 };
            let normal = 0.5 * groups.kappa_n * h2 + cubic;
            let shear = groups.kappa_t * m2 + 0.5 * groups.kappa_3t * m2 * m2;
            basis.w[i] * (normal + shear)
        })
        .sum();
    (bending + springs) * at.p[index::EI] / at.p[index::L]
}

/// The force at the base balances everything beyond it: T(0) = -t(0) . int g ds with t(0) along x.
fn base_tension(model: &TwoDoublet, n: usize, at: At) -> f64 {
    let groups = model.groups(at.p);
    let distribution = model.distribution(at.p);
    let (psi, psi_t) = (model.on_points(at.u), model.on_points(at.v));
    let difference = |a: &[Vec<f64>; 2]| -> Vec<f64> { a[0].iter().zip(&a[1]).map(|(a, b)| a - b).collect() };
    let f_n = model.normal_force(&groups, &difference(&psi), &difference(&psi_t));
    let traction = model.traction(EPS[n], &groups, (&psi[n], &psi_t[n]), (&distribution, &f_n));
    let total: f64 = traction.g_x.iter().zip(&model.basis.w).map(|(g, w)| g * w).sum();
    -total * at.p[index::EI] / at.p[index::L].powi(2)
}

/// The mean of the two doublets' shapes at 101 points along them, in µm.
pub(super) fn mean_line(model: &TwoDoublet, u: &[f64], p: &[f64]) -> Vec<[f64; 2]> {
    let k = model.basis.functions;
    line(p[index::L], |x| {
        let (a, b) = (model.basis.psi(&u[..k], x), model.basis.psi(&u[k..], x));
        [0.5 * (a.cos() + b.cos()), 0.5 * (a.sin() + b.sin())]
    })
}
