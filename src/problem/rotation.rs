//! Continuous symmetries that act linearly.

use super::Reflection;

/// A skew generator Gamma of a continuous symmetry: `exp(s Gamma)` takes solutions to solutions for every s. In each
/// plane (i, j, m) the pair (u_i, u_j) turns m times as fast as s,
///
/// ```text
/// (Gamma u)_i = -m u_j,      (Gamma u)_j = m u_i,
/// ```
///
/// such as a complex amplitude whose phase is free (m = 1), or the m-th Fourier mode of a shift in space. No
/// component is in two planes of one rotation; the rotations of one problem commute.
#[derive(Clone, Debug, PartialEq)]
pub struct Rotation {
    pub planes: Vec<(usize, usize, f64)>,
}

impl Rotation {
    /// `out += c Gamma u`.
    pub fn add(&self, c: f64, u: &[f64], out: &mut [f64]) {
        for &(i, j, m) in &self.planes {
            out[i] -= c * m * u[j];
            out[j] += c * m * u[i];
        }
    }

    /// `u = exp(s Gamma) u`.
    pub fn turn(&self, s: f64, u: &mut [f64]) {
        for &(i, j, m) in &self.planes {
            let ((sin, cos), x, y) = ((s * m).sin_cos(), u[i], u[j]);
            (u[i], u[j]) = (cos * x - sin * y, sin * x + cos * y);
        }
    }

    /// Whether `S Gamma = Gamma S`: only then can `u(t + P) = S u(t)` hold in a frame that turns.
    pub fn commutes_with(&self, s: &Reflection) -> bool {
        let n = s.source.len();
        let (mut unit, mut left, mut right) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        (0..n).all(|k| {
            unit.fill(0.0);
            unit[k] = 1.0;
            let (mut image, mut turned) = (vec![0.0; n], vec![0.0; n]);
            s.apply(&unit, &mut image);
            self.add(1.0, &unit, &mut turned);
            s.apply(&turned, &mut left);
            right.fill(0.0);
            self.add(1.0, &image, &mut right);
            left == right
        })
    }

    /// Whether two rotations commute, since each pair turns with both or with one of them alone, and do not turn the same
    /// pairs.
    pub fn commutes(&self, other: &Rotation) -> bool {
        let pairs = |rotation: &Rotation| {
            let mut pairs: Vec<_> = rotation.planes.iter().map(|&(i, j, _)| (i.min(j), i.max(j))).collect();
            pairs.sort_unstable();
            pairs
        };
        let (own, turned) = (pairs(self), pairs(other));
        let apart = |&(i, j): &(usize, usize)| {
            turned.contains(&(i, j)) || !turned.iter().any(|&(k, l)| [k, l].contains(&i) || [k, l].contains(&j))
        };
        own.iter().all(apart) && own != turned
    }
}
