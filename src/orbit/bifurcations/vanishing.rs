//! Where a branch of cycles ends in what it could have come from: an equilibrium, or cycles of half the period.
//!
//! The amplitude - the orbit less its mean, or less its own other half - goes through zero there, and the branch comes back
//! as itself half a period later: after the step the amplitude is opposite to that before. As lambda is even in it,
//! `lambda - lambda_0` goes as its square.

use crate::bifurcation::Hopf;
use crate::continuation::Point;
use crate::linalg::c64;
use crate::orbit::{Collocation, Orbit};
use crate::problem::Reflection;
use std::f64::consts::PI;

/// What a branch may shrink to.
#[derive(Clone, Copy, Debug)]
pub enum Amplitude<'a> {
    /// Distance from the mean: zero at a Hopf point.
    Swing,
    /// u(t) - S u(t + T/2): zero where the period doubles, or where the symmetry breaks.
    Halves(&'a Reflection),
}

impl Amplitude<'_> {
    /// lambda where the amplitude vanishes, if it changes sign between two points on one mesh.
    pub fn vanishes(self, system: &Collocation, from: &Point, to: &Point) -> Option<f64> {
        let (a, b) = (self.measure(&system.orbit(&from.x)), self.measure(&system.orbit(&to.x)));
        let product = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
        let along = product(&a, &b);
        let (a, b) = (product(&a, &a), product(&b, &b));
        let opposite = along < 0.0 && along * along > 0.25 * a * b;
        let even = (b - a).abs() > 0.1 * (a + b);
        // With nearly equal amplitudes on both sides lambda is nearly the same, too.
        let zero = || if even { (from.lambda * b - to.lambda * a) / (b - a) } else { 0.5 * (from.lambda + to.lambda) };
        opposite.then(zero)
    }

    fn measure(self, orbit: &Orbit) -> Vec<f64> {
        let n = orbit.dim;
        match self {
            Amplitude::Swing => {
                let count = (orbit.nodes.len() / n) as f64;
                let mut mean = vec![0.0; n];
                for node in orbit.nodes.chunks(n) {
                    mean.iter_mut().zip(node).for_each(|(m, x)| *m += x / count);
                }
                orbit.nodes.iter().enumerate().map(|(i, x)| x - mean[i % n]).collect()
            }
            Amplitude::Halves(symmetry) => {
                let scheme = orbit.scheme();
                let mut image = vec![0.0; n];
                let difference = |&t: &f64| {
                    let other = orbit.at((t + 0.5) % 1.0, &scheme).0;
                    symmetry.apply(&other, &mut image);
                    orbit.at(t, &scheme).0.iter().zip(&image).map(|(u, v)| u - v).collect::<Vec<_>>()
                };
                orbit.mesh.iter().flat_map(difference).collect()
            }
        }
    }
}

/// States of a small cycle from which mean and first harmonic are taken.
const SAMPLES: usize = 32;

/// lambda at the Hopf point that a small cycle is near to, solved for from its mean and its first harmonic.
pub fn hopf_beside(system: &Collocation, point: &Point) -> Option<f64> {
    let frame = &system.frame;
    let (orbit, scheme) = (system.orbit(&point.x), &system.scheme);
    let (mut u, mut q) = (vec![0.0; orbit.dim], vec![c64::new(0.0, 0.0); orbit.dim]);
    for k in 0..SAMPLES {
        let turn = k as f64 / SAMPLES as f64;
        let state = orbit.anywhere(turn * frame.parts as f64, scheme, &frame.symmetry).0;
        let weight = c64::cis(-2.0 * PI * turn) / SAMPLES as f64;
        u.iter_mut().zip(&state).for_each(|(u, x)| *u += x / SAMPLES as f64);
        q.iter_mut().zip(&state).for_each(|(q, x)| *q += weight * *x);
    }
    let p = system.parameters(point.lambda);
    let found = Hopf::locate(&*frame.problem, (&u, &p), frame.free, 2.0 * PI / orbit.period(), &q).ok()?;
    Some(found.p[frame.free])
}
