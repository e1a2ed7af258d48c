//! Where a branch of cycles starts: at a Hopf point, or where other cycles double their period or branch.

use super::{Cycles, CyclesError};
use crate::bifurcation::{Coordinate, Hopf, HopfNormalForm};
use crate::branch::{Row, SpecialPoint};
use crate::continuation::{Border, Corrected, Counts, Point, StepControl, System, Walk, WalkState, correct, inner};
use crate::orbit::bifurcations::{BranchPoint, Critical, CriticalCycle, Departure};
use crate::orbit::{Collocation, Frame, Modulation, OrbitFactors, Points, from_hopf, half_period};
use crate::problem::{Problem, Reflection};
use crate::run::start::Stored;
use crate::run::stored_cycle::StoredCycle;
use crate::scene::Label;

/// Radius of the first cycle and step sizes, in parts of the range: amplitudes go as the square root of it.
const FIRST_RADIUS: f64 = 0.02;
/// Distance of the first cycle of a branch that leaves another, in parts of the orbit.
pub(super) const FIRST_DISTANCE: f64 = 0.02;
const FIRST_STEP: f64 = 0.02;
const LARGEST_STEP: f64 = 0.05;
const LEAST_STEP: f64 = 1e-7;
/// Intervals where neither the scene nor the start says how many.
const INTERVALS: usize = 20;

/// What a branch starts from.
pub enum Origin {
    /// With the amplitude that the range leads to.
    Hopf { hopf: Box<Hopf>, form: Box<HopfNormalForm>, reference: f64, span: f64 },
    /// nu = -1 (flip) or +1, at a cycle on the mesh of the new task.
    Cycle { stored: StoredCycle, flip: bool },
    /// At a cycle that drifts, or a rotating wave's modulation.
    Relative { stored: StoredCycle, frame: Frame, modulation: Option<Modulation> },
}

impl Origin {
    /// The free parameter's value there.
    pub fn onset(&self, free: usize) -> f64 {
        match self {
            Origin::Hopf { hopf, .. } => hopf.p[free],
            Origin::Cycle { stored, .. } | Origin::Relative { stored, .. } => stored.p[free],
        }
    }
}

impl Cycles<'_> {
    pub(super) fn points(&self) -> Points {
        if self.task.gauss { Points::Gauss } else { Points::Radau }
    }

    /// Reads the start, which must lie inside the range.
    pub fn origin(&self, from: &SpecialPoint) -> Result<Origin, CyclesError> {
        let (low, high) = (self.task.along.range.from, self.task.along.range.to);
        let inside = |value: f64| {
            if (low..=high).contains(&value) {
                return Ok(value);
            }
            let (name, what) = (self.prepared.free_name.clone(), from.label.clone());
            Err(CyclesError::Outside { what, name, value, from: low, to: high })
        };
        if self.task.relative {
            let stored = StoredCycle::read(self.prepared, from);
            let stored = stored.ok_or_else(|| CyclesError::Incomplete(from.label.clone()))?;
            inside(stored.p[self.prepared.free])?;
            let intervals = self.task.intervals.unwrap_or(stored.orbit.intervals());
            return self.relative(from, stored.remeshed(intervals, self.task.degree, self.points()));
        }
        if Label::parse(&from.label).is_some_and(|label| ["PD", "BPC"].contains(&label.kind)) {
            let stored = StoredCycle::read(self.prepared, from);
            let stored = stored.ok_or_else(|| CyclesError::Incomplete(from.label.clone()))?;
            inside(stored.p[self.prepared.free])?;
            let flip = stored.cosine < 0.0;
            if !flip && stored.free != self.prepared.free {
                let name = self.prepared.problem.parameters()[stored.free].name.to_owned();
                return Err(CyclesError::OtherParameter { label: from.label.clone(), name });
            }
            let share = if flip { 2 } else { 1 };
            let intervals = self.task.intervals.map_or(stored.orbit.intervals(), |count| count.div_ceil(share));
            let stored = stored.remeshed(intervals, self.task.degree, self.points());
            return Ok(Origin::Cycle { stored, flip });
        }
        let (hopf, form) = self.hopf(from)?;
        let onset = inside(hopf.p[self.prepared.free])?;
        let span = if form.p2 > 0.0 { high - onset } else { onset - low };
        let reference = (span / form.p2.abs()).sqrt();
        if !reference.is_finite() || reference == 0.0 {
            return Err(CyclesError::Degenerate);
        }
        Ok(Origin::Hopf { hopf: Box::new(hopf), form: Box::new(form), reference, span })
    }

    /// The Hopf point that was stored, solved for again with this task's free parameter.
    fn hopf(&self, from: &SpecialPoint) -> Result<(Hopf, HopfNormalForm), CyclesError> {
        let Stored { u, p, omega, q } =
            Stored::read(self.prepared, from).ok_or_else(|| CyclesError::Incomplete(from.label.clone()))?;
        let problem = &*self.prepared.problem;
        let hopf = Hopf::locate(problem, (&u, &p), self.prepared.free, omega, &q)?;
        let form = HopfNormalForm::new(problem, &hopf)?;
        Ok((hopf, form))
    }

    /// The frame of the branch that starts there.
    pub fn frame(&self, origin: &Origin) -> Result<Frame, CyclesError> {
        match origin {
            Origin::Hopf { hopf, reference, span, .. } => {
                let reflection = if self.task.symmetry { half_period(&*self.prepared.problem, hopf) } else { None };
                let parts = if reflection.is_some() { 2 } else { 1 };
                Ok(Frame {
                    problem: self.prepared.problem.clone(),
                    p: hopf.p.clone(),
                    free: self.prepared.free,
                    symmetry: reflection.unwrap_or_else(|| Reflection::identity(hopf.u.len())),
                    parts,
                    // Root mean square of 2 r Re(q e^{i theta}) with |q| = 1.
                    scale_state: reference * 2.0_f64.sqrt(),
                    scale_part: 2.0 * std::f64::consts::PI / hopf.omega / parts as f64,
                    scale_lambda: *span,
                })
            }
            Origin::Cycle { stored, flip } => {
                let range = &self.task.along.range;
                let frame = stored.frame(self.prepared, range.to - range.from);
                let frame = frame.ok_or_else(|| CyclesError::Incomplete(stored.label.clone()))?;
                if !flip {
                    return Ok(frame);
                }
                let symmetry = Reflection::identity(stored.orbit.dim);
                Ok(Frame { symmetry, parts: 1, scale_part: 2.0 * frame.scale_part, ..frame })
            }
            Origin::Relative { frame, .. } => Ok(frame.clone()),
        }
    }

    /// The start as first row, the first cycle, and the walk from there.
    pub fn start(&mut self, origin: &Origin, counts: &mut Counts) -> Result<(Collocation, WalkState), CyclesError> {
        let (mut system, still, first) = match origin {
            Origin::Hopf { .. } => self.from_hopf(origin, counts)?,
            Origin::Cycle { stored, flip } => {
                let Departure { system, origin, corrected } = self.from_cycle(stored, *flip, counts)?;
                (system, origin, corrected)
            }
            Origin::Relative { stored, frame, modulation } => {
                let departure = self.from_relative((stored, frame), modulation.as_ref(), counts)?;
                (departure.system, departure.origin, departure.corrected)
            }
        };
        let (orbit, symmetry) = (system.orbit(&still.x), system.frame.symmetry.clone());
        let values = self.measure(&orbit, &symmetry, &system.parameters(still.lambda));
        let mut row: Vec<Option<f64>> = vec![Some(still.lambda)];
        row.extend(values.into_iter().map(Some));
        row.resize(self.branch.columns.len(), None);
        // A cycle that the branch goes through is its first point itself.
        if !matches!(origin, Origin::Relative { modulation: None, .. }) {
            self.branch.rows.push(Row { label: None, stable: None, values: row });
        }
        self.push(&system, &first.point, &first.factors, None);
        let span = system.frame.scale_lambda;
        let most = self.task.along.max_step.map_or(LARGEST_STEP, |step| step / span);
        let control = StepControl { step: FIRST_STEP.min(most), least: LEAST_STEP, most };
        let state = Walk::new(&mut system, first.point, control, (0.0, 0.0)).state;
        Ok((system, state))
    }

    fn from_hopf(
        &self,
        origin: &Origin,
        counts: &mut Counts,
    ) -> Result<(Collocation, Point, Corrected<OrbitFactors>), CyclesError> {
        let Origin::Hopf { hopf, form, reference, .. } = origin else { return Err(CyclesError::Degenerate) };
        let frame = self.frame(origin)?;
        let (symmetry, parts) = (frame.symmetry.clone(), frame.parts);
        let mesh = (self.task.intervals.unwrap_or(INTERVALS), self.task.degree, self.points());
        let predict = |r: f64| from_hopf((hopf, form), self.prepared.free, r, (&symmetry, parts), mesh);
        let r = FIRST_RADIUS * reference;
        let ((orbit, lambda), (ahead, lambda_ahead)) = (predict(r), predict(1.01 * r));
        let system = Collocation::new(frame, &orbit);
        let x = Collocation::unknowns(&orbit);
        let direction: Vec<f64> = Collocation::unknowns(&ahead).iter().zip(&x).map(|(a, b)| a - b).collect();
        let along = (&direction[..], lambda_ahead - lambda);
        let length = inner(&system, along, along).sqrt();
        let border = Border {
            row: system.dual(&direction).iter().map(|t| t / length).collect(),
            lambda: system.dual_lambda() * along.1 / length,
        };
        let first = correct(&system, (x, lambda), &border, counts)?;
        let onset = predict(0.0).0;
        let lambda = hopf.p[self.prepared.free];
        let still = Point { x: Collocation::unknowns(&onset), lambda, ..first.point.clone() };
        Ok((system, still, first))
    }

    /// Solves for the bifurcation anew, on the mesh of this task, and leaves along the other branch.
    fn from_cycle(&self, stored: &StoredCycle, flip: bool, counts: &mut Counts) -> Result<Departure, CyclesError> {
        let range = &self.task.along.range;
        let extent = range.to - range.from;
        let frame = stored.frame(self.prepared, extent);
        let frame = frame.ok_or_else(|| CyclesError::Incomplete(stored.label.clone()))?;
        let free = self.prepared.free;
        let system = Collocation::new(frame, &stored.orbit);
        if flip {
            let coordinate = Coordinate { index: free, logarithmic: false, width: extent };
            let at = (&stored.orbit, &stored.p[..]);
            let critical = CriticalCycle::new(&system, at, (Critical::Flip, -1.0), &[coordinate]);
            let (cycle, x) = critical.map_err(crate::continuation::Failure::from)?;
            let x = cycle.solve(x, counts)?;
            return Ok(Departure::flip((&cycle, &x), FIRST_DISTANCE, counts)?);
        }
        let near = Point {
            x: Collocation::unknowns(&stored.orbit),
            lambda: stored.p[free],
            tangent: Collocation::unknowns(&stored.tangent),
            tangent_lambda: stored.tangent_lambda,
        };
        let found = BranchPoint::solve(&system, &near, counts)?;
        let other = found.other.ok_or_else(|| CyclesError::Touching(stored.label.clone()))?;
        Ok(Departure::along(system, &other, FIRST_DISTANCE, counts)?)
    }
}
