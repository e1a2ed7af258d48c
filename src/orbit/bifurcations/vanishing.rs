//! Where a branch of cycles ends in an equilibrium, at a Hopf point.
//!
//! Amplitudes go through zero there, and the branch comes back as itself half a period later: with the mean taken off, the
//! orbit after the step is opposite to the one before. As lambda is even in the amplitude, `lambda - lambda_H` goes as its
//! square.

use crate::continuation::Point;
use crate::orbit::{Collocation, Orbit};

/// The Hopf point's lambda, if the amplitude changes sign between two points on one mesh.
pub fn vanishing(system: &Collocation, from: &Point, to: &Point) -> Option<f64> {
    let (a, b) = (swing(&system.orbit(&from.x)), swing(&system.orbit(&to.x)));
    let along: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
    let square = |x: &[f64]| -> f64 { x.iter().map(|x| x * x).sum() };
    let (a, b) = (square(&a), square(&b));
    let opposite = along < 0.0 && along * along > 0.25 * a * b;
    // With r² = a and b at lambda and lambda', lambda_H = (lambda b - lambda' a)/(b - a); at equal amplitudes the curve of
    // lambda over r is flat between them.
    let (a, b) = (a.sqrt(), b.sqrt());
    let weight = b / (a + b);
    let at_middle = from.lambda * weight + to.lambda * (1.0 - weight);
    opposite.then(|| if (b - a).abs() > 0.1 * (a + b) { (from.lambda * b * b - to.lambda * a * a) / (b * b - a * a) } else { at_middle })
}

/// Nodes less their mean.
fn swing(orbit: &Orbit) -> Vec<f64> {
    let n = orbit.dim;
    let count = (orbit.nodes.len() / n) as f64;
    let mut mean = vec![0.0; n];
    for node in orbit.nodes.chunks(n) {
        mean.iter_mut().zip(node).for_each(|(m, x)| *m += x / count);
    }
    orbit.nodes.iter().enumerate().map(|(i, x)| x - mean[i % n]).collect()
}
