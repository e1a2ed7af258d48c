//! Cycles that tasks start from, as they were stored.

use super::study::Prepared;
use crate::branch::SpecialPoint;
use crate::orbit::{Frame, Orbit, Points};
use crate::problem::{Problem, Reflection};

/// A cycle that differs from its own image by no more than this, in parts of its size, is symmetric: it comes back to
/// its image exactly once its equations are solved.
const SYMMETRIC: f64 = 1e-4;

/// A stored cycle with the tangent of its branch.
pub struct StoredCycle {
    pub label: String,
    pub orbit: Orbit,
    pub tangent: Orbit,
    pub tangent_lambda: f64,
    /// All parameters.
    pub p: Vec<f64>,
    /// The parameter that was free.
    pub free: usize,
    /// cos of the critical multiplier's angle over the computed part: 1 at folds and branch points, -1 at flips.
    pub cosine: f64,
}

impl StoredCycle {
    /// None where something is missing.
    pub fn read(prepared: &Prepared, from: &SpecialPoint) -> Option<Self> {
        let array = |name: &str| from.arrays.get(name).map(|a| &a.data);
        let (state, tangent, mesh) = (array("state")?, array("tangent")?, array("mesh")?);
        let [degree, parts] = array("degree_parts")?[..] else { return None };
        let [tangent_part, tangent_lambda] = array("tangent_part_lambda")?[..] else { return None };
        let [gauss, free] = array("gauss_free")?[..] else { return None };
        let list = prepared.problem.parameters();
        let orbit = Orbit {
            mesh: mesh.clone(),
            points: if gauss == 1.0 { Points::Gauss } else { Points::Radau },
            degree: degree as usize,
            nodes: state.clone(),
            dim: prepared.problem.dim(),
            part: *array("part")?.first()?,
            parts: parts as usize,
            drift: array("drift").cloned().unwrap_or_default(),
        };
        Some(Self {
            label: from.label.clone(),
            tangent: Orbit {
                nodes: tangent.clone(),
                part: tangent_part,
                drift: array("tangent_drift").cloned().unwrap_or_default(),
                ..orbit.clone()
            },
            orbit,
            tangent_lambda,
            p: list.iter().map(|q| from.parameters.get(q.name).copied().unwrap_or(f64::NAN)).collect(),
            free: free as usize,
            cosine: array("critical").and_then(|a| a.first()).copied().unwrap_or(1.0),
        })
    }

    /// The first half of a cycle over its whole period that obeys the symmetry `u(t + T/2) = S u(t)`; None if it does not.
    pub fn halved(&self, symmetry: &Reflection) -> Option<Self> {
        let scheme = self.orbit.scheme();
        let mut image = vec![0.0; self.orbit.dim];
        let mut defect = |tau: f64| {
            symmetry.apply(&self.orbit.at(tau, &scheme).0, &mut image);
            let there = self.orbit.at(tau + 0.5, &scheme).0;
            there.iter().zip(&image).fold(0.0_f64, |most, (u, v)| most.max((u - v).abs()))
        };
        let ends: Vec<f64> = self.orbit.mesh.iter().copied().filter(|tau| *tau < 0.5).collect();
        let size = Self::deviation(&self.orbit);
        let whole = self.orbit.parts == 1 && self.orbit.drift.is_empty();
        if !whole || ends.iter().any(|&tau| defect(tau) > SYMMETRIC * size) {
            return None;
        }
        let mesh: Vec<f64> = ends.into_iter().chain([0.5]).collect();
        let half = |orbit: &Orbit| {
            let mut half = orbit.interpolated(&mesh, orbit.degree);
            let last = half.nodes.len() - orbit.dim;
            half.nodes[last..].copy_from_slice(&orbit.at(0.5, &scheme).0);
            half.mesh.iter_mut().for_each(|tau| *tau *= 2.0);
            Orbit { part: 0.5 * orbit.part, parts: 2, ..half }
        };
        let (orbit, tangent) = (half(&self.orbit), half(&self.tangent));
        Some(Self { label: self.label.clone(), orbit, tangent, p: self.p.clone(), ..*self })
    }

    /// On another mesh, with intervals in the same proportions.
    pub fn remeshed(mut self, intervals: usize, degree: usize, points: Points) -> Self {
        let old = &self.orbit.mesh;
        let mesh: Vec<f64> = (0..=intervals)
            .map(|j| {
                let place = j as f64 * (old.len() - 1) as f64 / intervals as f64;
                let k = (place as usize).min(old.len() - 2);
                old[k] + (place - k as f64) * (old[k + 1] - old[k])
            })
            .collect();
        for orbit in [&mut self.orbit, &mut self.tangent] {
            if orbit.mesh != mesh || orbit.degree != degree {
                *orbit = orbit.interpolated(&mesh, degree);
            }
            orbit.points = points;
        }
        self
    }

    /// The orbit's frame with the task's free parameter, of which `extent` counts as one.
    pub fn frame(&self, prepared: &Prepared, extent: f64) -> Option<Frame> {
        let n = self.orbit.dim;
        let symmetry = if self.orbit.parts == 2 { prepared.problem.reflection()? } else { Reflection::identity(n) };
        Some(Frame {
            problem: prepared.problem.clone(),
            p: self.p.clone(),
            free: prepared.free,
            symmetry,
            parts: self.orbit.parts,
            scale_state: Self::deviation(&self.orbit),
            scale_part: self.orbit.part,
            scale_lambda: extent,
        })
    }

    /// Whether the orbit is a point, but for rounding.
    pub fn still(&self) -> bool {
        let largest = self.orbit.nodes.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        Self::deviation(&self.orbit) <= 1e-12 * largest
    }

    /// Root mean square of an orbit's distance from its mean, over its computed part.
    pub fn deviation(orbit: &Orbit) -> f64 {
        let scheme = orbit.scheme();
        let points = || {
            let widths = orbit.mesh.windows(2);
            let inside = |w: &[f64]| -> Vec<(f64, Vec<f64>)> {
                let place =
                    |(c, weight): (&f64, &f64)| ((w[1] - w[0]) * weight, orbit.at(w[0] + c * (w[1] - w[0]), &scheme).0);
                scheme.points.iter().zip(&scheme.weights).map(place).collect()
            };
            widths.flat_map(inside)
        };
        let mut mean = vec![0.0; orbit.dim];
        for (weight, u) in points() {
            mean.iter_mut().zip(u).for_each(|(m, u)| *m += weight * u);
        }
        let distance = |u: &[f64]| u.iter().zip(&mean).map(|(u, m)| (u - m).powi(2)).sum::<f64>();
        points().map(|(weight, u)| weight * distance(&u)).sum::<f64>().max(f64::MIN_POSITIVE).sqrt()
    }
}
