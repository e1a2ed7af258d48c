//! What is measured on a two-doublet motion, from the mixed form's unknowns.

use super::super::parameters::{EPS, Groups, Law, index};
use super::MixedTwoDoublet;
use super::density::FORCE;
use super::density::field::{PSI, T};
use crate::models::rod::{line, peak, times};
use crate::problem::At;

/// Points a function of an element on which the largest value is looked for.
const FINE: usize = 6;

/// In the order of the minimal form's list.
pub(super) fn evaluate(model: &MixedTwoDoublet, i: usize, at: At) -> f64 {
    let (u, length) = (at.u, at.p[index::L]);
    let angle = |n: usize, x: f64| model.elements.at(PSI + n, u, x);
    let largest = |value: &dyn Fn(f64) -> f64| {
        let mesh = model.elements.mesh;
        peak(value, FINE * mesh.degree * mesh.elements)
    };
    match i {
        0 => 0.5 * length * (tip(model, u, 0) + tip(model, u, 1)),
        1 => length * tip(model, u, 0),
        2 => length * tip(model, u, 1),
        3 => 0.5 * (angle(0, 1.0) + angle(1, 1.0)),
        4 => angle(0, 1.0),
        5 => angle(1, 1.0),
        6 => largest(&|x| angle(0, x).abs()).max(largest(&|x| angle(1, x).abs())),
        7 => largest(&|x| (angle(0, x) - angle(1, x)).abs()),
        8 => energy(model, at),
        9 => base_tension(model, 0, at),
        10 => base_tension(model, 1, at),
        _ => f64::NAN,
    }
}

/// psi of both doublets and their slopes in x at the points of each element.
fn angles<'a>(
    model: &'a MixedTwoDoublet,
    u: &'a [f64],
) -> impl Iterator<Item = (f64, [Vec<f64>; 2], [Vec<f64>; 2])> + 'a {
    model.elements.cells.iter().map(|cell| {
        let at = |n: usize, slopes: bool| model.elements.on_points(cell, PSI + n, u, slopes);
        (cell.width, [0, 1].map(|n| at(n, false)), [0, 1].map(|n| at(n, true)))
    })
}

/// int_0^1 sin psi dx.
fn tip(model: &MixedTwoDoublet, u: &[f64], n: usize) -> f64 {
    let weights = &model.elements.weights;
    angles(model, u)
        .map(|(width, psi, _)| width * psi[n].iter().zip(weights).map(|(psi, w)| w * psi.sin()).sum::<f64>())
        .sum()
}

/// Bending, then the springs, as in the minimal form.
fn energy(model: &MixedTwoDoublet, at: At) -> f64 {
    let groups = Groups::new(at.p, model.law);
    let elements = &model.elements;
    let (mut sum, mut begin) = (0.0, 0.0);
    for (width, psi, bend) in angles(model, at.u) {
        let delta: Vec<f64> = psi[0].iter().zip(&psi[1]).map(|(a, b)| width * (a - b)).collect();
        let inside = times(&elements.integral, &delta);
        for (i, weight) in elements.weights.iter().enumerate() {
            let (h, mean) = (begin + inside[i], 0.5 * (psi[0][i] + psi[1][i]));
            let (h2, m2) = (h * h, mean * mean);
            let bending: f64 = (0..2).map(|n| 0.5 * groups.bending[n] * bend[n][i] * bend[n][i]).sum();
            let cubic = if model.law == Law::Separation { 0.25 * groups.kappa_3n * h2 * h2 } else { 0.0 };
            let shear = groups.kappa_t * m2 + 0.5 * groups.kappa_3t * m2 * m2;
            sum += width * weight * (bending + 0.5 * groups.kappa_n * h2 + cubic + shear);
        }
        begin += delta.iter().zip(&elements.weights).map(|(d, w)| w * d).sum::<f64>();
    }
    sum * at.p[index::EI] / at.p[index::L]
}

/// The straight state's and the excess.
fn base_tension(model: &MixedTwoDoublet, n: usize, at: At) -> f64 {
    let groups = Groups::new(at.p, model.law);
    let straight = model.straight_tension(&groups, &[0.0], at.p)[0];
    let excess = FORCE * model.elements.at(T + n, at.u, 0.0);
    (EPS[n] * straight + excess) * at.p[index::EI] / at.p[index::L].powi(2)
}

/// The mean of the two doublets' shapes at 101 points along them, in µm.
pub(super) fn mean_line(model: &MixedTwoDoublet, u: &[f64], p: &[f64]) -> Vec<[f64; 2]> {
    line(p[index::L], |x| {
        let [a, b] = [0, 1].map(|n| model.elements.at(PSI + n, u, x));
        [0.5 * (a.cos() + b.cos()), 0.5 * (a.sin() + b.sin())]
    })
}
