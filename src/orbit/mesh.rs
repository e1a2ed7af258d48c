//! The mesh follows the orbit: equal shares of the error for all intervals.
//!
//! The local error of degree-m collocation goes as `h^{m+1} |u^{(m+1)}|`, so intervals are chosen to equidistribute
//! `|u^{(m+1)}|^{1/(m+1)}` (Russell and Christiansen 1978, doi:10.1137/0715004). The derivative of order m + 1 is
//! read off the jumps of the piecewise constant m-th derivative.

use super::{Orbit, Scheme};
use crate::problem::Reflection;

/// Shares of the error may differ by this factor from their mean before the mesh moves.
const TOLERATED: f64 = 1.5;
/// No interval is wider than it would be with this part of the mean monitor.
const FLOOR: f64 = 0.2;

/// The number of intervals is kept while it is between the wanted one and this multiple of it.
const ROOM: f64 = 1.4;
/// A new number of intervals is chosen with this reserve.
const RESERVE: f64 = 1.1;
const FEWEST: usize = 4;
const MOST: usize = 10_000;

/// A mesh with equal shares of the error, if the present one is too far from that; with a tolerance, relative to the
/// orbit's size, the number of intervals changes to meet it.
pub fn adapted(orbit: &Orbit, scheme: &Scheme, symmetry: &Reflection, tolerance: Option<f64>) -> Option<Vec<f64>> {
    let monitor = monitor(orbit, scheme, symmetry);
    let widths: Vec<f64> = orbit.mesh.windows(2).map(|w| w[1] - w[0]).collect();
    let total: f64 = monitor.iter().zip(&widths).map(|(e, h)| e * h).sum();
    if !(total.is_finite() && total > 0.0) {
        return None;
    }
    let present = orbit.intervals();
    let count = tolerance.map_or(present, |tolerance| number(orbit, scheme, total, tolerance));
    let uneven = monitor.iter().zip(&widths).any(|(e, h)| e * h * present as f64 > TOLERATED * total);
    if !uneven && count == present {
        return None;
    }
    // Invert the piecewise linear integral of the monitor.
    let mut mesh = vec![0.0];
    let (mut j, mut before) = (0, 0.0);
    for k in 1..count {
        let goal = total * k as f64 / count as f64;
        while before + monitor[j] * widths[j] < goal && j + 1 < widths.len() {
            before += monitor[j] * widths[j];
            j += 1;
        }
        mesh.push(orbit.mesh[j] + (goal - before) / monitor[j]);
    }
    mesh.push(1.0);
    mesh.windows(2).all(|w| w[1] > w[0]).then_some(mesh)
}

/// How many intervals with equal shares of the monitor's integral meet a tolerance: with N of them the error is
/// `c (integral / N)^{m+1}`.
fn number(orbit: &Orbit, scheme: &Scheme, integral: f64, tolerance: f64) -> usize {
    let present = orbit.intervals();
    let order = (orbit.degree + 1) as f64;
    let allowed = tolerance * size(orbit);
    let wanted = integral * (scheme.error_constant() / allowed).powf(1.0 / order);
    if !wanted.is_finite() || (wanted..=ROOM * wanted.max(FEWEST as f64)).contains(&(present as f64)) {
        return present;
    }
    ((RESERVE * wanted).ceil() as usize).clamp(FEWEST, MOST)
}

/// The largest distance of the orbit from its mean.
fn size(orbit: &Orbit) -> f64 {
    let count = (orbit.nodes.len() / orbit.dim) as f64;
    let mut mean = vec![0.0; orbit.dim];
    for node in orbit.nodes.chunks(orbit.dim) {
        mean.iter_mut().zip(node).for_each(|(m, x)| *m += x / count);
    }
    let distance = |node: &[f64]| node.iter().zip(&mean).map(|(x, m)| (x - m).powi(2)).sum::<f64>().sqrt();
    orbit.nodes.chunks(orbit.dim).map(distance).fold(0.0, f64::max)
}

/// `|u^{(m+1)}|^{1/(m+1)}` on each interval.
fn monitor(orbit: &Orbit, scheme: &Scheme, symmetry: &Reflection) -> Vec<f64> {
    let (n, m, count) = (orbit.dim, orbit.degree, orbit.intervals());
    let coefficients = scheme.highest_derivative();
    let widths: Vec<f64> = orbit.mesh.windows(2).map(|w| w[1] - w[0]).collect();
    let mut highest: Vec<Vec<f64>> = (0..count)
        .map(|j| {
            let mut d = vec![0.0; n];
            for (l, c) in coefficients.iter().enumerate() {
                let factor = c / widths[j].powi(m as i32);
                d.iter_mut().zip(orbit.node(j * m + l)).for_each(|(d, x)| *d += factor * x);
            }
            d
        })
        .collect();
    let mut beyond = vec![0.0; n];
    symmetry.apply(&highest[0], &mut beyond);
    highest.push(beyond);
    // Jump at the right end of each interval; the last one is the wrap-around, with the first interval's width.
    let jumps: Vec<f64> = (0..count)
        .map(|j| {
            let gap: f64 = highest[j + 1].iter().zip(&highest[j]).map(|(a, b)| (a - b).powi(2)).sum();
            gap.sqrt() / (0.5 * (widths[j] + widths[(j + 1) % count]))
        })
        .collect();
    let raw: Vec<f64> =
        (0..count).map(|j| (0.5 * (jumps[j] + jumps[(j + count - 1) % count])).powf(1.0 / (m + 1) as f64)).collect();
    let mean: f64 = raw.iter().zip(&widths).map(|(e, h)| e * h).sum();
    raw.iter().map(|e| e.max(FLOOR * mean)).collect()
}
