//! The collocation equations' bordered matrix, factored: the condensed intervals, and the small system that couples the orbit's
//! ends with period, velocities and lambda.

use super::condensation::{Condensed, Forwarded};
use super::rows::Reach;
use super::{FloquetError, Frame, Multipliers, Rows, Transitions, multipliers};
use crate::continuation::{Border, Factored};
use crate::linalg::{Equilibrated, Singular};
use crate::problem::Reflection;
use faer::Mat;

/// Factors of the whole bordered system.
pub struct OrbitFactors {
    condensed: Condensed,
    /// `(x_0, P, c_1, ..., c_K, lambda)`: n condensed rows, the phase rows, the border.
    ends: Equilibrated,
    symmetry: Reflection,
    parts: usize,
    drifts: usize,
}

impl OrbitFactors {
    /// From the intervals, the rows of the phase conditions (of time, of rotations) and continuation's own row.
    pub fn new(
        mut condensed: Condensed,
        (phase, turns): (&[f64], &[Vec<f64>]),
        border: &Border,
        frame: &Frame,
    ) -> Result<Self, Singular> {
        let (n, count) = (frame.symmetry.sign.len(), turns.len() + 2);
        let (nodes, rest) = border.row.split_at(border.row.len() + 1 - count);
        let rows: Vec<&[f64]> = std::iter::once(phase).chain(turns.iter().map(Vec::as_slice)).chain([nodes]).collect();
        let reaches = condensed.add_borders(&rows);
        let direct: Vec<f64> = rest.iter().copied().chain([border.lambda]).collect();
        let mut ends = Mat::zeros(n + count, n + count);
        let rows = condensed.transition();
        ends.as_mut().submatrix_mut(0, 0, n, n).copy_from(rows.c);
        rows.add_end(&frame.symmetry, 1.0, ends.as_mut().subrows_mut(0, n));
        ends.as_mut().submatrix_mut(0, n, n, count).copy_from(rows.e);
        for (k, Reach { a, b, z }) in reaches.iter().enumerate() {
            let mut row = a.clone();
            frame.symmetry.add_transposed(b, &mut row);
            for (j, &entry) in row.iter().enumerate() {
                ends[(n + k, j)] = entry;
            }
            for (s, z) in z.iter().enumerate() {
                ends[(n + k, n + s)] = z + if k + 1 == count { direct[s] } else { 0.0 };
            }
        }
        let ends = Equilibrated::new(ends)?;
        Ok(Self { condensed, ends, symmetry: frame.symmetry.clone(), parts: frame.parts, drifts: turns.len() })
    }

    /// Floquet multipliers over the whole period: all, or the leading ones.
    pub fn multipliers(&self, wanted: Option<usize>) -> Result<Multipliers, FloquetError> {
        multipliers(&self.transitions()?, (&self.symmetry, self.parts), 1 + self.drifts, wanted)
    }

    /// Sign of the determinant of what is left after elimination, `[C + D S, E; phase; border]`.
    pub fn sign(&self) -> f64 {
        self.ends.sign()
    }

    /// u(t + P) = S u(t).
    pub fn symmetry(&self) -> &Reflection {
        &self.symmetry
    }

    /// Floquet multipliers over the computed part of the period: all that decide on bifurcations, as described at
    /// [`multipliers`].
    pub fn part_multipliers(&self) -> Result<Multipliers, FloquetError> {
        multipliers(&self.transitions()?, (&self.symmetry, 1), 1 + self.drifts, Some(0))
    }

    /// The condensed rows that couple the orbit's ends.
    pub fn transition(&self) -> Rows<'_> {
        self.condensed.transition()
    }

    /// The intervals' transition maps along the computed part of the period.
    pub fn transitions(&self) -> Result<Transitions<'_>, Singular> {
        Ok(Transitions::new(&self.condensed.intervals())?.with(self.condensed.transition()))
    }
}

impl Factored for OrbitFactors {
    /// `right`: the intervals' equations, the phases, the border; out: nodes, P, c_1 ... c_K, lambda.
    fn solve(&self, right: &mut [f64]) {
        let n = self.symmetry.sign.len();
        let equations = right.len() - 2 - self.drifts;
        let mut border = right[equations..].to_vec();
        let (forwarded, rows): (Forwarded, Vec<f64>) = self.condensed.forward(&right[..equations], &mut border);
        let mut ends = rows;
        ends.extend(border);
        self.ends.solve(&mut ends);
        let z = &ends[n..];
        let mut last = vec![0.0; n];
        self.symmetry.apply(&ends[..n], &mut last);
        self.condensed.back(forwarded, (&ends[..n], &last), z, &mut right[..equations]);
        right[equations..].copy_from_slice(z);
    }
}
