//! Lengths and directions of vectors.

use super::dot;

pub fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// The vector over its length.
pub fn unit(x: &[f64]) -> Vec<f64> {
    let length = norm(x);
    x.iter().map(|x| x / length).collect()
}

/// A vector without pattern, where any will do.
pub fn any(n: usize) -> Vec<f64> {
    (0..n).map(|i| 1.0 + (7 * i % 5) as f64).collect()
}
