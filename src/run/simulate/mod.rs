//! A simulation as a task: a motion in time, or what motions settle on over a parameter.

mod cycle;

use super::equilibria;
use super::outcome::{Outcome, Status, labels};
use super::start;
use super::study::Prepared;
use super::watch::Watch;
use crate::branch::{Array, Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use crate::continuation::Counts;
use crate::linalg::{pencil, shifted};
use crate::problem::{At, Problem};
use crate::scene::{self, Happening, Start};
use crate::simulate::{
    Attractor, Control, Course, Direction, Event, Method, Motion, Search, Settled, SimulateError, settle,
};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;
use thiserror::Error;

/// Quantities that special points have besides their columns.
pub const VALUES: [&str; 6] = ["t", "event", "period", "frequency", "rotation", "deviation"];

#[derive(Debug, Error)]
enum TaskError {
    #[error("the start of {0} has no state")]
    Stored(String),
    #[error("the perturbation's eigenmode could not be computed at the start")]
    Mode,
    #[error(transparent)]
    Simulate(#[from] SimulateError),
}

struct Simulation<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Simulate,
    watch: &'a Watch,
    control: Control,
    branch: Branch,
    counts: Counts,
}

/// A branch without rows: its columns are what the task asks for.
pub fn empty(prepared: &Prepared, name: &str, task: &scene::Simulate) -> Branch {
    let list = prepared.problem.observables();
    let time = prepared.problem.time_unit().to_owned();
    let parameter = (prepared.free_name.clone(), prepared.free_unit.clone());
    let mut columns = Vec::new();
    if task.over.is_some() {
        columns.extend([parameter, ("period".to_owned(), time)]);
        for &i in &prepared.observables {
            columns
                .extend(["max", "min"].map(|extreme| (format!("{extreme} {}", list[i].name), list[i].unit.to_owned())));
        }
        if task.along.errors {
            let errors: Vec<_> =
                columns[1..].iter().map(|(name, unit)| (format!("error {name}"), unit.clone())).collect();
            columns.extend(errors);
        }
    } else {
        columns.push(("t".to_owned(), time));
        columns.extend(task.ramp.is_some().then_some(parameter));
        columns.extend(prepared.observables.iter().map(|&i| (list[i].name.to_owned(), list[i].unit.to_owned())));
    }
    let free = vec![columns[0].0.clone()];
    let columns = columns.into_iter().map(|(name, unit)| Column { name, unit }).collect();
    Branch::new(name, BranchKind::Simulation, free, columns)
}

pub fn run(
    prepared: &Prepared,
    name: &str,
    task: &scene::Simulate,
    from: Option<&SpecialPoint>,
    watch: &Watch,
) -> Outcome {
    let begun = Instant::now();
    let method = if task.sdirk { Method::Sdirk } else { Method::Bdf };
    let control = Control { method, tolerance: task.tolerance, absolute: task.absolute };
    let branch = empty(prepared, name, task);
    let mut simulation = Simulation { prepared, task, watch, control, branch, counts: Counts::default() };
    let ended = simulation.start(from).and_then(|(u, p)| match &task.over {
        Some((_, values)) => simulation.diagram(u, p, values),
        None => simulation.series(&u, &p),
    });
    let (status, reason) = ended.unwrap_or_else(|error| (Status::Failed, error.to_string()));
    let Simulation { branch, counts, .. } = simulation;
    Outcome { branch, status, reason, seconds: begun.elapsed().as_secs_f64(), counts }
}

impl Simulation<'_> {
    /// State and parameters at the beginning.
    fn start(&self, from: Option<&SpecialPoint>) -> Result<(Vec<f64>, Vec<f64>), TaskError> {
        let problem = &*self.prepared.problem;
        let n = problem.dim();
        let stored = match from {
            Some(point) => {
                let stored = start::equilibrium(self.prepared, point).filter(|(u, _)| u.len() >= n);
                Some(stored.ok_or_else(|| TaskError::Stored(point.label.clone()))?)
            }
            None => None,
        };
        let mut p = stored.as_ref().map_or_else(|| self.prepared.p.clone(), |(_, p)| p.clone());
        let position = |name: &str| problem.parameters().iter().position(|q| q.name == name);
        let first = self.task.ramp.iter().map(|(name, ends)| (name, ends[0]));
        let over = self.task.over.iter().filter_map(|(name, values)| Some((name, *values.first()?)));
        for (name, value) in self.task.parameters.iter().map(|(name, value)| (name, *value)).chain(first).chain(over) {
            if let Some(i) = position(name) {
                p[i] = value;
            }
        }
        // A cycle's first node is one of its states.
        let mut u = match (&self.task.start, stored) {
            (Some(Start::List(start, _)), _) => start.clone(),
            (Some(Start::Named(guess)), _) => equilibria::given(self.prepared, guess, &p),
            (None, Some((u, _))) => u[..n].to_vec(),
            (None, None) => problem.start(&p),
        };
        if let Some(amplitude) = self.task.amplitude {
            let mode = match from.and_then(|point| point.arrays.get("q_re")) {
                Some(mode) if mode.data.len() == n => mode.data.clone(),
                _ => leading(problem, &u, &p).ok_or(TaskError::Mode)?,
            };
            let largest = mode.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            if largest.is_nan() || largest <= 0.0 {
                return Err(TaskError::Mode);
            }
            u.iter_mut().zip(&mode).for_each(|(u, q)| *u += amplitude * q / largest);
        }
        Ok((u, p))
    }

    fn observe(&self, i: usize, motion: &Motion, p: &[f64]) -> Option<f64> {
        let value = self.prepared.problem.observe(i, At { u: &motion.u, v: &motion.v, p });
        value.is_finite().then_some(value)
    }

    /// One motion, sampled.
    fn series(&mut self, u: &[f64], p: &[f64]) -> Result<(Status, String), TaskError> {
        let [from, to] = self.task.time;
        let mut course = Course::steady(from, to, p);
        if let Some((_, ends)) = &self.task.ramp {
            course.last[self.prepared.free] = ends[1];
        }
        let samples = self.task.samples;
        let moment = |k: usize| if k == samples { to } else { from + (to - from) * k as f64 / samples as f64 };
        let (mut rows, mut stopped) = (Vec::new(), false);
        let events: Vec<Event> = self.task.events.iter().filter_map(|event| self.event(event)).collect();
        let parameters = |t: f64| course.parameters(t);
        // Events by their row, and the one that ends the motion.
        let mut happened: Vec<(usize, usize, Motion)> = Vec::new();
        let mut ended: Option<(usize, Motion)> = None;
        let this = &*self;
        let row = |motion: &Motion| {
            let p = course.parameters(motion.t);
            let mut values = vec![Some(motion.t)];
            values.extend(this.task.ramp.is_some().then(|| Some(p[this.prepared.free])));
            values.extend(this.prepared.observables.iter().map(|&i| this.observe(i, motion, &p)));
            Row { label: None, stable: None, values }
        };
        let search = Search {
            observables: &self.prepared.observables,
            recognise: self.task.ramp.is_none(),
            stop: false,
            errors: self.task.along.errors,
        };
        let mut counts = self.counts;
        let mut sampled = 0;
        let mut see = |step: &crate::simulate::Step| {
            let within = |(k, event): (usize, &Event)| {
                let found = event.within(&*this.prepared.problem, &parameters, step);
                found.into_iter().map(move |motion| (k, motion)).collect::<Vec<_>>()
            };
            let mut found: Vec<(usize, Motion)> = events.iter().enumerate().flat_map(within).collect();
            found.sort_by(|a, b| a.1.t.total_cmp(&b.1.t));
            let last = found.iter().position(|(k, _)| this.task.events[*k].stop);
            found.truncate(last.map_or(found.len(), |last| last + 1));
            let until = if last.is_some() { found.last().map_or(step.to.t, |(_, motion)| motion.t) } else { step.to.t };
            let mut found = found.into_iter().peekable();
            loop {
                let sample = (sampled <= samples && moment(sampled) <= until).then(|| moment(sampled));
                if let Some((k, motion)) = found.next_if(|(_, motion)| sample.is_none_or(|t| motion.t < t)) {
                    happened.push((rows.len(), k, motion.clone()));
                    rows.push(row(&motion));
                } else if let Some(t) = sample {
                    rows.push(row(&step.at(t)));
                    sampled += 1;
                } else {
                    break;
                }
            }
            if last.is_some() {
                ended = happened.last().map(|(_, k, motion)| (*k, motion.clone()));
                return ControlFlow::Break(());
            }
            this.watch.at((step.to.t - from) / (to - from), format!("t = {:.6}", step.to.t));
            stopped = this.watch.stopped();
            if stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let problem = &*self.prepared.problem;
        let settled = settle(problem, u, (&course, &self.control), &search, &mut counts, &mut see);
        self.counts = counts;
        // What was seen before a failure is kept.
        self.branch.rows = rows;
        for (row, k, motion) in happened {
            let mut point = self.moment(Kind::EV, &course.parameters(motion.t), &motion);
            point.row = row;
            point.values.insert("event".to_owned(), (k + 1) as f64);
            self.store(point);
        }
        let mut settled = settled?;
        if stopped {
            return Ok((Status::Interrupted, "interrupted".to_owned()));
        }
        let mut reason = self.name(&settled);
        if let Some((k, motion)) = ended {
            let Happening { of, value, .. } = &self.task.events[k];
            reason = format!("stopped where {of} = {value}, event {}, at t = {:.9}", k + 1, motion.t);
            settled.last = motion;
        }
        let p = course.parameters(settled.last.t);
        let mut end = self.moment(Kind::EP, &p, &settled.last);
        if let Attractor::Torus(ring) = &settled.attractor {
            end.values.extend([("rotation".to_owned(), ring.rotation), ("deviation".to_owned(), ring.deviation)]);
        }
        self.store(end);
        if let Attractor::Cycle(cycle) = &settled.attractor {
            self.cycle(cycle, &p)?;
        }
        Ok((Status::Done, reason))
    }

    /// Motions at one value after another, each from where the last one ended.
    fn diagram(&mut self, mut u: Vec<f64>, mut p: Vec<f64>, values: &[f64]) -> Result<(Status, String), TaskError> {
        let [from, to] = self.task.time;
        let mut reason = String::new();
        for (k, &value) in values.iter().enumerate() {
            p[self.prepared.free] = value;
            let course = Course::steady(from, to, &p);
            let search = Search {
                observables: &self.prepared.observables,
                recognise: true,
                stop: true,
                errors: self.task.along.errors,
            };
            self.watch.at(k as f64 / values.len() as f64, format!("{} = {value:.6}", self.prepared.free_name));
            let (watch, mut stopped) = (self.watch, false);
            let mut see = |_: &crate::simulate::Step| {
                stopped = watch.stopped();
                if stopped { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let problem = &*self.prepared.problem;
            let settled = settle(problem, &u, (&course, &self.control), &search, &mut self.counts, &mut see);
            let settled = match settled {
                Ok(settled) => settled,
                Err(error) => {
                    let reason = format!("at {} = {value}: {error}", self.prepared.free_name);
                    return Ok((Status::Failed, reason));
                }
            };
            if stopped {
                return Ok((Status::Interrupted, "interrupted".to_owned()));
            }
            let finite = |x: f64| x.is_finite().then_some(x);
            let mut row = vec![Some(value)];
            let cycle = if let Attractor::Cycle(cycle) = &settled.attractor { Some(cycle) } else { None };
            row.push(cycle.map(|cycle| cycle.period));
            row.extend(settled.ranges.iter().flat_map(|range| [finite(range.max), finite(range.min)]));
            if self.task.along.errors {
                let count = 1 + 2 * settled.ranges.len();
                row.extend((0..count).map(|k| cycle.and_then(|cycle| finite(cycle.errors[k]))));
            }
            row.resize(self.branch.columns.len(), None);
            self.branch.rows.push(Row { label: None, stable: None, values: row });
            reason = self.name(&settled);
            if let Attractor::Cycle(cycle) = &settled.attractor {
                self.cycle(cycle, &p)?;
            }
            u = settled.last.u;
        }
        let end = self.point(Kind::EP, &p, &u);
        self.store(end);
        Ok((Status::Done, reason))
    }

    /// What was recognised, in a sentence.
    fn name(&self, settled: &Settled) -> String {
        let unit = self.prepared.problem.time_unit();
        match &settled.attractor {
            Attractor::Steady => "settled on a steady state".to_owned(),
            Attractor::Cycle(cycle) => {
                format!("settled on a cycle of period {:.9} {unit}", cycle.period).trim_end().to_owned()
            }
            Attractor::Torus(ring) => format!(
                "{} returns lie on a closed curve to {:.1e} of its size: the motion looks quasi-periodic, with {:.6} turns \
                 a return",
                ring.returns, ring.deviation, ring.rotation
            ),
            Attractor::Open { returns } => {
                format!("reached the end of the time without settling ({returns} returns to the last section)")
            }
            Attractor::Unknown => "reached the end of the time".to_owned(),
        }
    }

    /// What is looked for along the motion.
    fn event(&self, event: &Happening) -> Option<Event> {
        let list = self.prepared.problem.observables();
        let observable = list.iter().position(|known| known.name == event.of)?;
        let direction = match event.direction {
            "up" => Direction::Up,
            "down" => Direction::Down,
            _ => Direction::Any,
        };
        Some(Event { observable, value: event.value, direction })
    }

    /// A point of the last row, with its time and observables.
    fn moment(&self, kind: Kind, p: &[f64], motion: &Motion) -> SpecialPoint {
        let mut point = self.point(kind, p, &motion.u);
        point.values.insert("t".to_owned(), motion.t);
        for &i in &self.prepared.observables {
            let name = self.prepared.problem.observables()[i].name.to_owned();
            point.values.extend(self.observe(i, motion, p).map(|value| (name, value)));
        }
        point
    }

    /// A point of the last row.
    fn point(&self, kind: Kind, p: &[f64], u: &[f64]) -> SpecialPoint {
        let (_, label) = labels(&self.branch, kind);
        let mut point = SpecialPoint::new(label, kind, self.branch.rows.len().saturating_sub(1));
        let resolved = self.prepared.problem.resolve(p);
        let list = self.prepared.problem.parameters();
        point.parameters = list.iter().zip(&resolved).map(|(q, &x)| (q.name.to_owned(), x)).collect();
        point.arrays = BTreeMap::from([
            ("state".to_owned(), Array::vector(u.to_vec())),
            ("parameters".to_owned(), Array::vector(resolved)),
        ]);
        point
    }

    fn store(&mut self, point: SpecialPoint) {
        if let Some(row) = self.branch.rows.get_mut(point.row) {
            let short = point.label.rsplit('/').next().unwrap_or_default().to_owned();
            row.label.get_or_insert(short);
        }
        self.branch.points.push(point);
    }
}

/// The real part of the rightmost eigenvector.
fn leading(problem: &dyn Problem, u: &[f64], p: &[f64]) -> Option<Vec<f64>> {
    let rest = vec![0.0; u.len()];
    let (a, m) = problem.linearised(At { u, v: &rest, p });
    let shift = a.norm_max() / m.norm_max();
    let pairs = shifted(shift, |shift| pencil(a.as_ref(), m.as_ref(), shift, 1)).ok()?;
    let vector = &pairs.first()?.vector;
    Some(vector.iter().map(|q| q.re).collect())
}
