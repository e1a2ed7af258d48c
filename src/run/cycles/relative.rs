//! Where a branch of relative periodic orbits starts: at a cycle, or where a rotating wave becomes modulated.

use super::origin::{FIRST_DISTANCE, Origin};
use super::{Cycles, CyclesError};
use crate::branch::SpecialPoint;
use crate::continuation::{Counts, Point};
use crate::linalg::dot;
use crate::orbit::bifurcations::Departure;
use crate::orbit::{Collocation, Frame, Modulation, Orbit};
use crate::problem::{Problem, Reflection};
use crate::run::stored_cycle::StoredCycle;
use crate::scene::Label;

/// A cycle that moves along a rotation only, up to this, is a rotating wave.
const PARALLEL: f64 = 1e-6;

impl Cycles<'_> {
    /// From a torus bifurcation, at which a rotating wave becomes modulated; or from any cycle, which drifts along the
    /// rotations at the velocities that are stored with it, or not at all.
    pub(super) fn relative(&self, from: &SpecialPoint, mut stored: StoredCycle) -> Result<Origin, CyclesError> {
        let range = &self.task.along.range;
        let incomplete = || CyclesError::Incomplete(from.label.clone());
        let rotations = self.prepared.problem.rotations();
        let frame = stored.frame(self.prepared, range.to - range.from).ok_or_else(incomplete)?;
        if Label::parse(&from.label).is_some_and(|label| label.kind == "NS") {
            let modulation = Modulation::new(&*self.prepared.problem, &stored.orbit, &stored.p);
            let modulation = modulation.ok_or_else(|| CyclesError::NoWave(from.label.clone()))?;
            let mesh = (stored.orbit.intervals(), self.task.degree, self.points());
            let r = FIRST_DISTANCE * frame.scale_state;
            stored.orbit = modulation.orbit(r, mesh);
            stored.tangent = modulation.mode(mesh);
            let symmetry = Reflection::identity(stored.orbit.dim);
            let frame = Frame { symmetry, parts: 1, scale_part: stored.orbit.part, ..frame };
            return Ok(Origin::Wave { stored, frame, modulation: Box::new(modulation) });
        }
        if stored.orbit.parts == 2 && !rotations.iter().all(|rotation| rotation.commutes_with(&frame.symmetry)) {
            return Err(CyclesError::Reflected(from.label.clone()));
        }
        stored.orbit.drift.resize(rotations.len(), 0.0);
        stored.tangent.drift.resize(rotations.len(), 0.0);
        if rotations.iter().any(|rotation| {
            let [turned, rate, product] = moments(&stored.orbit, |u, out| rotation.add(1.0, u, out));
            turned == 0.0 || product * product > (1.0 - PARALLEL) * turned * rate
        }) {
            return Err(CyclesError::Unmoved(from.label.clone()));
        }
        Ok(Origin::Amid { stored })
    }

    /// The first modulated wave.
    pub(super) fn leave_wave(
        &self,
        stored: &StoredCycle,
        frame: Frame,
        modulation: &Modulation,
        counts: &mut Counts,
    ) -> Result<Departure, CyclesError> {
        let mesh = (stored.orbit.intervals(), stored.orbit.degree, stored.orbit.points);
        let system = Collocation::new(frame, &stored.orbit);
        let point = Point {
            x: Collocation::unknowns(&modulation.orbit(0.0, mesh)),
            lambda: stored.p[self.prepared.free],
            tangent: Collocation::unknowns(&stored.tangent),
            tangent_lambda: 0.0,
        };
        Ok(Departure::along(system, &point, FIRST_DISTANCE, counts)?)
    }
}

/// `|Gamma u|²`, `|u'|²` and `<Gamma u, u'>` over the orbit.
fn moments(orbit: &Orbit, turn: impl Fn(&[f64], &mut [f64])) -> [f64; 3] {
    let scheme = orbit.scheme();
    let mut sums = [0.0; 3];
    for w in orbit.mesh.windows(2) {
        for (c, weight) in scheme.points.iter().zip(&scheme.weights) {
            let (u, v) = orbit.at(w[0] + c * (w[1] - w[0]), &scheme);
            let mut turned = vec![0.0; orbit.dim];
            turn(&u, &mut turned);
            let here = [dot(&turned, &turned), dot(&v, &v), dot(&turned, &v)];
            sums.iter_mut().zip(here).for_each(|(sum, x)| *sum += (w[1] - w[0]) * weight * x);
        }
    }
    sums
}
