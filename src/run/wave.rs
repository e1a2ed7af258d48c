//! Shapes at 16 phases, for figures of waveforms.

use super::study::Prepared;
use crate::branch::{Array, SpecialPoint};
use crate::orbit::Orbit;
use crate::problem::{Problem, Reflection};
use std::f64::consts::PI;

const PHASES: usize = 16;
/// Part of the picture's width that an eigenmode's largest displacement is drawn with.
const MODE_SIZE: f64 = 0.1;

/// The pictures of an orbit.
pub fn of_orbit(prepared: &Prepared, orbit: &Orbit, symmetry: &Reflection, p: &[f64], point: &mut SpecialPoint) {
    let scheme = orbit.scheme();
    let pictures: Option<Vec<_>> = (0..PHASES)
        .map(|k| {
            let t = orbit.parts as f64 * k as f64 / PHASES as f64;
            prepared.problem.picture(&orbit.anywhere(t, &scheme, symmetry).0, p)
        })
        .collect();
    if let Some(pictures) = pictures {
        store(&pictures, point);
    }
}

/// The pictures of the linear motion `u + a Re(q e^{i theta})` of the leading mode, a chosen for the eye.
pub fn of_mode(prepared: &Prepared, point: &mut SpecialPoint) {
    let part = |name: &str| point.arrays.get(name).map(|a| a.data.clone());
    let (Some(u), Some(re), Some(im), Some(p)) = (part("state"), part("q_re"), part("q_im"), part("parameters")) else {
        return;
    };
    let Some(rest) = prepared.problem.picture(&u, &p) else { return };
    // Small enough to be linear, then scaled up.
    let small = 1e-5;
    let mut moved = Vec::new();
    for k in 0..PHASES {
        let (sine, cosine) = (2.0 * PI * k as f64 / PHASES as f64).sin_cos();
        let state: Vec<f64> = (0..u.len()).map(|i| u[i] + small * (re[i] * cosine - im[i] * sine)).collect();
        let Some(picture) = prepared.problem.picture(&state, &p) else { return };
        moved.push(picture);
    }
    let extent = rest.iter().flatten().fold(0.0_f64, |a, b| a.max(b.abs()));
    let points = moved.iter().flat_map(|picture| picture.iter().zip(&rest));
    let largest = points.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max);
    if largest.is_nan() || largest <= 0.0 {
        return;
    }
    let scale = MODE_SIZE * extent / largest;
    for picture in &mut moved {
        for (a, b) in picture.iter_mut().zip(&rest) {
            *a = [b[0] + scale * (a[0] - b[0]), b[1] + scale * (a[1] - b[1])];
        }
    }
    store(&moved, point);
}

fn store(pictures: &[Vec<[f64; 2]>], point: &mut SpecialPoint) {
    let shape = vec![pictures.len(), pictures.first().map_or(0, Vec::len)];
    for (name, d) in [("wave_x", 0), ("wave_y", 1)] {
        let data = pictures.iter().flatten().map(|xy| xy[d]).collect();
        point.arrays.insert(name.to_owned(), Array { shape: shape.clone(), data });
    }
}
