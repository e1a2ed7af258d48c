//! Where a branch of cycles starts: at a Hopf point, where other cycles double their period or branch, or at any cycle.

use super::rows::logarithm;
use super::{Cycles, CyclesError, Way};
use crate::bifurcation::{Coordinate, Hopf, HopfNormalForm, reverse};
use crate::branch::{Kind, Row, SpecialPoint};
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
pub const INTERVALS: usize = 20;

/// What a branch starts from.
pub enum Origin {
    /// With the amplitude that the range leads to.
    Hopf { hopf: Box<Hopf>, form: Box<HopfNormalForm>, reference: f64, span: f64 },
    /// nu = -1 (flip) or +1, at a cycle on the mesh of the new task.
    Cycle { stored: StoredCycle, flip: bool },
    /// Where a rotating wave becomes modulated; the frame of the orbits that leave it.
    Wave { stored: StoredCycle, frame: Frame, modulation: Box<Modulation> },
    /// A cycle of a branch that goes on on both sides.
    Amid { stored: StoredCycle },
}

impl Origin {
    /// The free parameter's value there.
    pub fn onset(&self, free: usize) -> f64 {
        match self {
            Origin::Hopf { hopf, .. } => hopf.p[free],
            Origin::Cycle { stored, .. } | Origin::Amid { stored } | Origin::Wave { stored, .. } => stored.p[free],
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
        // A start that was found at an end of the range may lie beyond it by rounding.
        let slack = f64::EPSILON * (high - low);
        let inside = |value: f64| {
            if (low - slack..=high + slack).contains(&value) {
                return Ok(value);
            }
            let (name, what) = (self.prepared.free_name.clone(), from.label.clone());
            Err(CyclesError::Outside { what, name, value, from: low, to: high })
        };
        if !self.task.relative && Label::parse(&from.label).is_some_and(|label| ["PD", "BPC"].contains(&label.kind)) {
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
        if from.arrays.contains_key("mesh") {
            let stored = StoredCycle::read(self.prepared, from);
            let stored = stored.ok_or_else(|| CyclesError::Incomplete(from.label.clone()))?;
            inside(stored.p[self.prepared.free])?;
            if !self.task.relative && !stored.orbit.drift.is_empty() {
                return Err(CyclesError::Drifts(from.label.clone()));
            }
            if stored.still() {
                return Err(CyclesError::Still(from.label.clone()));
            }
            if !(stored.orbit.part > 0.0 && stored.orbit.part.is_finite()) {
                return Err(CyclesError::Period(from.label.clone(), stored.orbit.part));
            }
            let reflection = self.prepared.problem.reflection().filter(|_| self.task.symmetry && !self.task.relative);
            let stored = reflection.and_then(|symmetry| stored.halved(&symmetry)).unwrap_or(stored);
            let intervals = self.task.intervals.unwrap_or(stored.orbit.intervals());
            let stored = stored.remeshed(intervals, self.task.degree, self.points());
            return if self.task.relative { self.relative(from, stored) } else { Ok(Origin::Amid { stored }) };
        }
        let (hopf, form) = self.hopf(from)?;
        let onset = inside(hopf.p[self.prepared.free])?;
        let span = if form.p2 > 0.0 { high - onset } else { onset - low };
        if span == 0.0 {
            return Err(CyclesError::Edge { name: self.prepared.free_name.clone(), value: onset });
        }
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
                let problem = &*self.prepared.problem;
                let reflection = if self.task.symmetry { half_period(problem, hopf, *reference) } else { None };
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
            Origin::Amid { stored } => {
                let range = &self.task.along.range;
                let frame = stored.frame(self.prepared, range.to - range.from);
                frame.ok_or_else(|| CyclesError::Incomplete(stored.label.clone()))
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
            Origin::Wave { frame, .. } => Ok(frame.clone()),
        }
    }

    /// The start as first row, the first cycle, and the walk from there.
    pub fn start(
        &mut self,
        origin: &Origin,
        way: Way,
        counts: &mut Counts,
    ) -> Result<(Collocation, WalkState), CyclesError> {
        let (mut system, still, first) = match origin {
            Origin::Amid { stored } => return self.amid(origin, stored, way, counts),
            Origin::Hopf { .. } => self.born(origin, counts)?,
            Origin::Cycle { stored, flip } => {
                let Departure { system, origin, corrected } = self.depart(stored, *flip, way, counts)?;
                (system, origin, corrected)
            }
            Origin::Wave { stored, modulation, .. } => {
                let frame = self.frame(origin)?;
                let Departure { system, origin, corrected } = self.leave_wave(stored, frame, modulation, counts)?;
                (system, origin, corrected)
            }
        };
        self.push(&system, &first.point, first.factors, None);
        // On the second of two ways the start is there already.
        if self.branch.rows.is_empty() {
            let (orbit, symmetry) = (system.orbit(&still.x), system.frame.symmetry.clone());
            let values = self.measure(&orbit, &symmetry, &system.parameters(still.lambda));
            let mut row: Vec<Option<f64>> = vec![Some(still.lambda)];
            row.extend(values.into_iter().map(|value| Some(value).filter(|value| value.is_finite())));
            let logarithm = logarithm(self.task, still.lambda);
            row.resize(self.branch.columns.len() - logarithm.iter().len(), None);
            row.extend(logarithm);
            self.branch.rows.push(Row { label: None, stable: None, values: row });
            self.make_rows(counts);
            // As stable as the first cycle; not so the wave that relative orbits leave.
            if let (false, [start, first]) = (self.task.relative, &mut self.branch.rows[..]) {
                start.stable = first.stable;
            }
        }
        let control = self.control(&system);
        let state = Walk::new(&mut system, first.point, control, (0.0, 0.0)).state;
        Ok((system, state))
    }

    fn control(&self, system: &Collocation) -> StepControl {
        let most = self.task.along.max_step.map_or(LARGEST_STEP, |step| step / system.frame.scale_lambda);
        StepControl { step: FIRST_STEP.min(most), least: LEAST_STEP, most }
    }

    /// A stored cycle, solved for on the mesh of this task; it is the first row of the branch.
    fn amid(
        &mut self,
        origin: &Origin,
        stored: &StoredCycle,
        way: Way,
        counts: &mut Counts,
    ) -> Result<(Collocation, WalkState), CyclesError> {
        let mut system = Collocation::new(self.frame(origin)?, &stored.orbit);
        let lambda = stored.p[self.prepared.free];
        // Across the branch that it was found on, for it may be a fold; on another branch at its parameters.
        let along = Collocation::unknowns(&stored.tangent);
        let size = inner(&system, (&along, stored.tangent_lambda), (&along, stored.tangent_lambda)).sqrt();
        let border = if stored.free == self.prepared.free && size > 0.0 {
            let row = system.dual(&along).iter().map(|t| t / size).collect();
            Border { row, lambda: system.dual_lambda() * stored.tangent_lambda / size }
        } else {
            Border { row: vec![0.0; along.len()], lambda: 1.0 }
        };
        let first = correct(&system, (Collocation::unknowns(&stored.orbit), lambda), &border, counts)?;
        let Corrected { mut point, factors, .. } = first;
        if StoredCycle::deviation(&system.orbit(&point.x)) < 1e-6 * system.frame.scale_state {
            return Err(CyclesError::Still(stored.label.clone()));
        }
        if (way == Way::Down) != (point.tangent_lambda < 0.0) {
            reverse(&mut point);
        }
        if self.branch.rows.is_empty() {
            let wanted = self.goals().any(|wanted| self.beyond(&system, &point, wanted) == 0.0);
            self.push(&system, &point, factors, wanted.then_some(Kind::UZ));
            self.make_rows(counts);
        }
        let control = self.control(&system);
        let state = Walk::new(&mut system, point, control, (0.0, 0.0)).state;
        Ok((system, state))
    }

    /// The first cycle near a Hopf point.
    fn born(
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
    fn depart(
        &self,
        stored: &StoredCycle,
        flip: bool,
        way: Way,
        counts: &mut Counts,
    ) -> Result<Departure, CyclesError> {
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
        let mut other = found.other.ok_or_else(|| CyclesError::Touching(stored.label.clone()))?;
        // Where the branch runs across the parameter, as at a broken symmetry, the sides are called so at will.
        if (way == Way::Down) != (other.tangent_lambda < 0.0) {
            reverse(&mut other);
        }
        Ok(Departure::along(system, &other, FIRST_DISTANCE, counts)?)
    }
}
