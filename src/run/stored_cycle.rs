//! Cycles that tasks start from, as they were stored.

use super::study::Prepared;
use crate::branch::SpecialPoint;
use crate::orbit::{Frame, Orbit, Points};
use crate::problem::{Problem, Reflection};

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
            scale_state: deviation(&self.orbit),
            scale_part: self.orbit.part,
            scale_lambda: extent,
        })
    }
}

/// Root mean square of the orbit's distance from its mean.
fn deviation(orbit: &Orbit) -> f64 {
    let scheme = orbit.scheme();
    let mut sums = (vec![0.0; orbit.dim], 0.0);
    for w in orbit.mesh.windows(2) {
        for (c, weight) in scheme.points.iter().zip(&scheme.weights) {
            let width = w[1] - w[0];
            let (u, _) = orbit.at(w[0] + c * width, &scheme);
            for (sum, u) in sums.0.iter_mut().zip(u) {
                *sum += width * weight * u;
                sums.1 += width * weight * u * u;
            }
        }
    }
    let mean: f64 = sums.0.iter().map(|x| x * x).sum();
    (sums.1 - mean).max(f64::MIN_POSITIVE).sqrt()
}
