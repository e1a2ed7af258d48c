//! A task of kind `cycles`: a branch of periodic orbits from a Hopf point, with multipliers, user values and errors.

mod rows;

pub use rows::empty;

use super::outcome::{Outcome, Status};
use super::resume::{Checkpoint, Keeper};
use super::start::Stored;
use super::study::Prepared;
use super::watch::{Watch, interrupted};
use crate::bifurcation::{Hopf, HopfNormalForm};
use crate::branch::{Branch, Kind, Row, SpecialPoint};
use crate::continuation::{
    Border, Counts, Failure, Point, StepControl, Stop, System, Walk, at_lambda, correct, crossing, inner,
};
use crate::orbit::{Collocation, Frame, OrbitFactors, Points, from_hopf, half_period};
use crate::problem::Reflection;
use crate::scene;
use rows::Pending;
use std::time::Instant;
use thiserror::Error;

#[derive(Debug, Error)]
enum CyclesError {
    #[error(transparent)]
    Numerics(#[from] Failure),
    #[error("the start is not a Hopf point any more: {0}")]
    Start(#[from] crate::bifurcation::HopfError),
    #[error("the Hopf point at {name} = {value} does not lie inside the range {from} to {to}")]
    Outside { name: String, value: f64, from: f64, to: f64 },
    #[error("{0} is not stored with its eigenvector")]
    Incomplete(String),
    #[error("the first Lyapunov coefficient vanishes: third order does not decide where the cycles go")]
    Degenerate,
}

/// Radius of the first cycle and step sizes, in parts of the range: amplitudes go as the square root of it.
const FIRST_RADIUS: f64 = 0.02;
const FIRST_STEP: f64 = 0.02;
const LARGEST_STEP: f64 = 0.05;
const LEAST_STEP: f64 = 1e-7;

/// A branch of cycles in the making.
struct Cycles<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Cycles,
    branch: Branch,
    /// Accepted points that are not rows yet: rows are made side by side, several at a time.
    pending: Vec<Pending>,
}

/// Rows made at once.
const BATCH: usize = 8;

/// Runs the task from a Hopf point; goes on from a checkpoint if there is one.
pub fn run(
    prepared: &Prepared,
    name: &str,
    task: &scene::Cycles,
    from: &SpecialPoint,
    keeper: &Keeper,
    watch: &Watch,
) -> Outcome {
    let start = Instant::now();
    let kept = keeper.load(name);
    let before = kept.as_ref().map_or(0.0, |kept| kept.seconds);
    let mut counts = kept.as_ref().map_or_else(Counts::default, |kept| kept.counts);
    let mut cycles = Cycles { prepared, task, branch: empty(prepared, name, task), pending: Vec::new() };
    let result = cycles.follow(from, kept, keeper, watch, &mut counts, (start, before));
    let (status, reason) = match result {
        Ok(Stop::Interrupted) => (Status::Interrupted, Stop::Interrupted.to_string()),
        Ok(stop @ Stop::Stagnation { .. }) => (Status::Failed, stop.to_string()),
        Ok(stop) => (Status::Done, stop.to_string()),
        Err(failure) => (Status::Failed, failure.to_string()),
    };
    Outcome { branch: cycles.branch, status, reason, seconds: before + start.elapsed().as_secs_f64(), counts }
}

impl Cycles<'_> {
    fn follow(
        &mut self,
        from: &SpecialPoint,
        kept: Option<Checkpoint>,
        keeper: &Keeper,
        watch: &Watch,
        counts: &mut Counts,
        (start, before): (Instant, f64),
    ) -> Result<Stop, CyclesError> {
        let along = &self.task.along;
        let (low, high) = (along.range.from, along.range.to);
        let (hopf, form) = self.hopf(from)?;
        let onset = hopf.p[self.prepared.free];
        if !(low <= onset && onset <= high) {
            let name = self.prepared.free_name.clone();
            return Err(CyclesError::Outside { name, value: onset, from: low, to: high });
        }
        let span = if form.p2 > 0.0 { high - onset } else { onset - low };
        let reference = (span / form.p2.abs()).sqrt();
        if !reference.is_finite() || reference == 0.0 {
            return Err(CyclesError::Degenerate);
        }
        let (mut system, state) = match kept {
            Some(Checkpoint { branch, orbit, walk, .. }) => {
                self.branch = branch;
                (Collocation::new(self.frame(&hopf, reference, span), &orbit), walk)
            }
            None => self.start(&hopf, &form, (reference, span), counts)?,
        };
        let mut walk = Walk::resume(&mut system, state, (low, high));
        loop {
            let stopping = interrupted();
            let keeping = stopping || keeper.due();
            if self.pending.len() >= BATCH || keeping {
                self.make_rows(counts);
            }
            if keeping {
                keeper.keep(Checkpoint {
                    branch: self.branch.clone(),
                    orbit: walk.system.reference().clone(),
                    walk: walk.state.clone(),
                    counts: *counts,
                    seconds: before + start.elapsed().as_secs_f64(),
                });
            }
            if stopping {
                return Ok(Stop::Interrupted);
            }
            if self.branch.rows.len() + self.pending.len() >= along.max_points {
                self.make_rows(counts);
                return Ok(Stop::MaxPoints);
            }
            let before_step = walk.counts;
            // Taken before the step, which may move the mesh; its row may be made already.
            let here = Pending::new(&*walk.system, &walk.state.point, None, Some(Kind::MX));
            let step = match walk.step() {
                Ok(step) => step,
                Err(stop) => {
                    self.make_rows(counts);
                    if self.branch.rows.last().is_some_and(|row| row.label.is_none()) {
                        self.name_last_row(&here, Kind::MX);
                    }
                    return Ok(stop);
                }
            };
            let lambda = step.to.lambda;
            self.user_values(&*walk.system, &step.from, &step.to, counts)?;
            let kind = step.stop.as_ref().filter(|stop| **stop == Stop::RangeEnd).map(|_| Kind::EP);
            self.push(&*walk.system, &step.to, &step.factors, kind);
            counts.newton += walk.counts.newton - before_step.newton;
            counts.residuals += walk.counts.residuals - before_step.residuals;
            counts.factorisations += walk.counts.factorisations - before_step.factorisations;
            let goal = if form.p2 > 0.0 { high } else { low };
            watch.at((lambda - onset) / (goal - onset), format!("{} = {lambda:.6}", along.free));
            if let Some(stop) = step.stop {
                self.make_rows(counts);
                return Ok(stop);
            }
        }
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

    fn frame(&self, hopf: &Hopf, reference: f64, span: f64) -> Frame {
        let reflection = if self.task.symmetry { half_period(&*self.prepared.problem, hopf) } else { None };
        let parts = if reflection.is_some() { 2 } else { 1 };
        Frame {
            problem: self.prepared.problem.clone(),
            p: hopf.p.clone(),
            free: self.prepared.free,
            symmetry: reflection.unwrap_or_else(|| Reflection::identity(hopf.u.len())),
            parts,
            // Root mean square of 2 r Re(q e^{i theta}) with |q| = 1.
            scale_state: reference * 2.0_f64.sqrt(),
            scale_part: 2.0 * std::f64::consts::PI / hopf.omega / parts as f64,
            scale_lambda: span,
        }
    }

    /// The Hopf point as first row, the first cycle, and the walk from there.
    fn start(
        &mut self,
        hopf: &Hopf,
        form: &HopfNormalForm,
        (reference, span): (f64, f64),
        counts: &mut Counts,
    ) -> Result<(Collocation, crate::continuation::WalkState), CyclesError> {
        let frame = self.frame(hopf, reference, span);
        let (symmetry, parts) = (frame.symmetry.clone(), frame.parts);
        let points = if self.task.gauss { Points::Gauss } else { Points::Radau };
        let mesh = (self.task.intervals, self.task.degree, points);
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

        let onset = from_hopf((hopf, form), self.prepared.free, 0.0, (&symmetry, parts), mesh).0;
        let still =
            Point { x: Collocation::unknowns(&onset), lambda: hopf.p[self.prepared.free], ..first.point.clone() };
        let values = self.measure(&onset, &symmetry, &system.parameters(still.lambda));
        let mut row: Vec<Option<f64>> = vec![Some(still.lambda)];
        row.extend(values.into_iter().map(Some));
        row.resize(self.branch.columns.len(), None);
        self.branch.rows.push(Row { label: None, stable: None, values: row });
        self.push(&system, &first.point, &first.factors, None);

        let most = self.task.along.max_step.map_or(LARGEST_STEP, |step| step / span);
        let control = StepControl { step: FIRST_STEP.min(most), least: LEAST_STEP, most };
        let mut system = system;
        let state = Walk::new(&mut system, first.point, control, (0.0, 0.0)).state;
        Ok((system, state))
    }

    /// Notes an accepted point; rows are made later.
    fn push(&mut self, system: &Collocation, point: &Point, factors: &OrbitFactors, kind: Option<Kind>) {
        let wanted = self.task.multipliers;
        let multipliers = if wanted > 0 { factors.multipliers(Some(wanted)).ok() } else { None };
        self.pending.push(Pending::new(system, point, multipliers, kind));
    }

    /// Points between two accepted ones where the parameter, the period or an observable's extreme is as wanted.
    fn user_values(
        &mut self,
        system: &Collocation,
        from: &Point,
        to: &Point,
        counts: &mut Counts,
    ) -> Result<(), Failure> {
        let mut found: Vec<(f64, Point, OrbitFactors)> = Vec::new();
        for (name, wanted) in &self.task.along.values {
            let column = self.branch.column(name).unwrap_or(0);
            for &goal in wanted {
                let value = |point: &Point| match column {
                    0 => point.lambda - goal,
                    k => {
                        let orbit = system.orbit(&point.x);
                        self.measure(&orbit, &system.frame.symmetry, &system.parameters(point.lambda))[k - 1] - goal
                    }
                };
                let (a, b) = (value(from), value(to));
                if a * b < 0.0 || b == 0.0 {
                    let lambda = match column {
                        0 => goal,
                        _ => crossing(system, (from, to), &value, counts)?.lambda,
                    };
                    let corrected = at_lambda(system, (from, to), lambda, counts)?;
                    found.push((a / (a - b), corrected.point, corrected.factors));
                }
            }
        }
        found.sort_by(|x, y| x.0.total_cmp(&y.0));
        for (_, point, factors) in found {
            self.push(system, &point, &factors, Some(Kind::UZ));
        }
        Ok(())
    }
}
