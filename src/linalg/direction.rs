//! Lengths and directions of vectors.

use super::{c64, dot};

pub fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// The vector over its length; zero stays zero.
pub fn unit(x: &[f64]) -> Vec<f64> {
    let length = norm(x);
    if length > 0.0 { x.iter().map(|x| x / length).collect() } else { x.to_vec() }
}

/// A vector without pattern, where any will do.
pub fn any(n: usize) -> Vec<f64> {
    (0..n).map(|i| 1.0 + (7 * i % 5) as f64).collect()
}

/// A real unit vector with as large a product with z as there is: the real part of z in the phase that makes it largest.
pub fn real_direction(z: &[c64]) -> Vec<f64> {
    let square: c64 = z.iter().map(|z| z * z).sum();
    let turn = if square.norm() > 0.0 { c64::from_polar(1.0, -0.5 * square.arg()) } else { c64::new(1.0, 0.0) };
    unit(&z.iter().map(|z| (z * turn).re).collect::<Vec<_>>())
}
