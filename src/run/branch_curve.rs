//! A task of kind `branch-point-curve`: branch points in two parameters, both ways from the start, with wanted values, and
//! with what keeps the branches apart where they do not cross.

use super::outcome::{Outcome, Status, joined, labels};
use super::start::{StartError, coordinates, equilibrium};
use super::study::Prepared;
use super::watch::Watch;
use crate::bifurcation::{BranchCurve, reverse};
use crate::branch::{Array, Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use crate::continuation::{Counts, Failure, Point, StepControl, Stop, Walk, at_lambda, crossing};
use crate::problem::{At, Problem};
use crate::scene;
use std::collections::BTreeMap;
use std::time::Instant;
use thiserror::Error;

/// Columns besides the parameters and observables: see [`BranchCurve::imperfection`].
pub const VALUES: [&str; 1] = ["imperfection"];

#[derive(Debug, Error)]
enum CurveError {
    #[error(transparent)]
    Numerics(#[from] Failure),
    #[error(transparent)]
    Place(#[from] StartError),
    #[error("{0} is not stored with its state")]
    Incomplete(String),
    #[error("the start is not a branch point that moves with {0} or {1}: {2}")]
    NoCurve(String, String, Failure),
    #[error("{0} is not a branch point of branches in {1} or {2}; give one of the two as \"free\" where it is found")]
    Elsewhere(String, String, String),
}

/// Arclength is counted in parts of the ranges.
const FIRST_STEP: f64 = 0.005;
const LARGEST_STEP: f64 = 0.02;
const LEAST_STEP: f64 = 1e-7;

/// A point of the curve.
struct Sample {
    /// The step that led here: its ends, and the curve with the borders that were in force.
    curve: BranchCurve,
    ends: (Point, Point),
    point: Point,
    mark: Option<(Kind, Option<Value>)>,
}

/// The first (0) or second (1) coordinate takes a value.
type Value = (usize, f64);

/// One way along the curve and why it ended.
struct Way {
    samples: Vec<Sample>,
    reason: String,
    status: Status,
}

pub fn run(prepared: &Prepared, name: &str, task: &scene::Curve, from: &SpecialPoint, watch: &Watch) -> Outcome {
    let start = Instant::now();
    let mut counts = Counts::default();
    let branch = empty(prepared, name, task);
    let mut outcome = match (Tool { prepared, task, watch }).follow(branch.clone(), from, &mut counts) {
        Ok(outcome) => outcome,
        Err(failure) => Outcome::failed(branch, failure.to_string()),
    };
    outcome.seconds = start.elapsed().as_secs_f64();
    outcome.counts = counts;
    outcome
}

pub fn empty(prepared: &Prepared, name: &str, task: &scene::Curve) -> Branch {
    let list = prepared.problem.parameters();
    let free = [prepared.first(), prepared.free].map(|i| &list[i]);
    let column = |name: &str, unit: &str| Column { name: name.to_owned(), unit: unit.to_owned() };
    let mut columns: Vec<Column> = free.iter().map(|q| column(q.name, q.unit)).collect();
    columns.extend(task.along.logarithmic.iter().map(|name| column(&format!("log10 {name}"), "")));
    columns.push(column(VALUES[0], ""));
    let observables = prepared.problem.observables();
    columns.extend(prepared.observables.iter().map(|&i| column(observables[i].name, observables[i].unit)));
    Branch {
        name: name.to_owned(),
        kind: BranchKind::BranchPointCurve,
        free: free.iter().map(|q| q.name.to_owned()).collect(),
        columns,
        rows: Vec::new(),
        points: Vec::new(),
        triangles: Vec::new(),
    }
}

struct Tool<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Curve,
    watch: &'a Watch,
}

impl Tool<'_> {
    fn follow(&self, mut branch: Branch, from: &SpecialPoint, counts: &mut Counts) -> Result<Outcome, CurveError> {
        let along = &self.task.along;
        let (u, p) = equilibrium(self.prepared, from).ok_or_else(|| CurveError::Incomplete(from.label.clone()))?;
        let coordinates = coordinates(self.prepared, along, &p)?;
        let names = || (along.others[0].name.clone(), along.free.clone());
        let free = from.arrays.get("free").and_then(|free| free.data.first());
        let axes = [coordinates.0.index, coordinates.1.index];
        let Some(free) = axes.into_iter().find(|&index| free == Some(&(index as f64))) else {
            let (first, second) = names();
            return Err(CurveError::Elsewhere(from.label.clone(), first, second));
        };
        let started = BranchCurve::start(self.prepared.problem.clone(), (&u, &p), coordinates, free, counts);
        let (curve, point) = started.map_err(|failure| {
            let (first, second) = names();
            CurveError::NoCurve(first, second, failure)
        })?;
        let mut back = point.clone();
        reverse(&mut back);
        let ends = (point.clone(), point.clone());
        let start = Sample { curve: curve.clone(), ends, point: point.clone(), mark: None };
        let most = along.max_points.saturating_sub(1).div_ceil(2);
        let down = self.way(curve.clone(), back, most, counts)?;
        let up = if down.reason == Stop::Closed.to_string() || down.status == Status::Interrupted {
            Way { samples: Vec::new(), reason: down.reason.clone(), status: down.status }
        } else {
            self.way(curve, point, most, counts)?
        };
        let (status, reason) = joined([(down.status, &down.reason), (up.status, &up.reason)]);
        let mut samples: Vec<Sample> = down.samples.into_iter().rev().chain([start]).chain(up.samples).collect();
        let last = samples.len() - 1;
        for end in [0, last] {
            samples[end].mark.get_or_insert((Kind::EP, None));
        }
        self.store(&mut branch, &samples);
        Ok(Outcome { branch, status, reason, seconds: 0.0, counts: *counts })
    }

    /// Follows the curve one way from a point, which itself is not among the samples.
    fn way(&self, mut curve: BranchCurve, start: Point, most: usize, counts: &mut Counts) -> Result<Way, CurveError> {
        let along = &self.task.along;
        let (low, high) = (curve.second.of(along.range.from), curve.second.of(along.range.to));
        let bounds = along.others.first().and_then(|axis| axis.range.as_ref());
        let bounds = bounds.map(|range| (curve.first.of(range.from), curve.first.of(range.to)));
        let n = self.prepared.problem.dim();
        let outward = |z: f64, direction: f64, (low, high): (f64, f64)| {
            let slack = 1e-12 * (high - low);
            (z <= low + slack && direction < 0.0) || (z >= high - slack && direction > 0.0)
        };
        let leaves_first = bounds.is_some_and(|bounds| outward(start.x[n], start.tangent[n], bounds));
        if leaves_first || outward(start.lambda, start.tangent_lambda, (low, high)) {
            let reason = Stop::RangeEnd.to_string();
            return Ok(Way { samples: Vec::new(), reason, status: Status::Done });
        }
        let control = StepControl { step: FIRST_STEP, least: LEAST_STEP, most: LARGEST_STEP };
        let mut walk = Walk::new(&mut curve, start, control, (low, high));
        let mut samples: Vec<Sample> = Vec::new();
        let (status, reason) = loop {
            if self.watch.stopped() {
                break (Status::Interrupted, Stop::Interrupted.to_string());
            }
            if samples.len() >= most {
                break (Status::Done, Stop::MaxPoints.to_string());
            }
            let step = match walk.step() {
                Ok(step) => step,
                Err(stop) => {
                    if let Some(last) = samples.last_mut() {
                        last.mark.get_or_insert((Kind::MX, None));
                    }
                    break (Status::Failed, stop.to_string());
                }
            };
            let curve = walk.system.clone();
            let mut to = step.to.clone();
            let mut mark = (step.stop == Some(Stop::RangeEnd)).then_some((Kind::EP, Some((1, to.lambda))));
            let mut stop = step.stop.map(|stop| stop.to_string());
            let ends = (step.from, step.to);
            let z = curve.coordinates(&to)[0];
            let passed = bounds.and_then(|(low, high)| {
                [low, high].into_iter().find(|&b| (b == low && z <= low) || (b == high && z >= high))
            });
            if let Some(bound) = passed
                && let Some(point) = locate(&curve, &ends, (0, bound), counts)?
            {
                to = point;
                mark = Some((Kind::EP, Some((0, bound))));
                stop = Some(Stop::RangeEnd.to_string());
            }
            let fraction = (to.lambda - low) / (high - low);
            self.watch.at(fraction, format!("{} = {:.6}", along.free, curve.second.value(to.lambda)));
            let sample = Sample { curve, ends: (ends.0, to.clone()), point: to, mark };
            samples.extend(self.between(&sample, counts));
            samples.push(sample);
            if let Some(reason) = stop {
                break (Status::Done, reason);
            }
        };
        *counts += walk.counts;
        Ok(Way { samples, reason, status })
    }

    /// Wanted values between the ends of a step, in the order of the curve.
    fn between(&self, next: &Sample, counts: &mut Counts) -> Vec<Sample> {
        let Sample { curve, ends, .. } = next;
        let ended = next.mark.and_then(|(_, test)| test);
        let axes = [curve.first, curve.second];
        let mut samples = Vec::new();
        for (k, coordinate) in axes.into_iter().enumerate() {
            let name = self.prepared.problem.parameters()[coordinate.index].name;
            for value in self.task.along.values.get(name).into_iter().flatten() {
                let wanted = (k, coordinate.of(*value));
                if ended != Some(wanted)
                    && let Ok(Some(point)) = locate(curve, ends, wanted, counts)
                {
                    let mark = Some((Kind::UZ, Some(wanted)));
                    samples.push(Sample { curve: curve.clone(), ends: ends.clone(), point, mark });
                }
            }
        }
        let along = |sample: &Sample| {
            let (a, b) = (curve.coordinates(&ends.0), curve.coordinates(&ends.1));
            let z = curve.coordinates(&sample.point);
            (0..2).map(|k| (z[k] - a[k]) * (b[k] - a[k]) / axes[k].width.powi(2)).sum::<f64>()
        };
        samples.sort_by(|x, y| along(x).total_cmp(&along(y)));
        samples
    }

    /// Rows and special points.
    fn store(&self, branch: &mut Branch, samples: &[Sample]) {
        branch.rows = samples.iter().map(|sample| self.row(sample)).collect();
        for (row, sample) in samples.iter().enumerate() {
            let Some((kind, _)) = sample.mark else { continue };
            let (short, label) = labels(branch, kind);
            let mut point = SpecialPoint::new(label, kind, row);
            self.describe(sample, &branch.columns, &branch.rows[row], &mut point);
            branch.rows[row].label = Some(short);
            branch.points.push(point);
        }
    }

    fn row(&self, sample: &Sample) -> Row {
        let curve = &sample.curve;
        let p = curve.parameters(&sample.point);
        let u = &sample.point.x[..self.prepared.problem.dim()];
        let rest = vec![0.0; u.len()];
        let list = self.prepared.problem.parameters();
        let value = |name: &str| list.iter().position(|q| q.name == name).map(|i| p[i]);
        let mut values = vec![Some(p[curve.first.index]), Some(p[curve.second.index])];
        values.extend(self.task.along.logarithmic.iter().map(|name| value(name).map(f64::log10)));
        values.push(Some(curve.imperfection(&sample.point)));
        let observe = |&i: &usize| Some(self.prepared.problem.observe(i, At { u, v: &rest, p: &p }));
        values.extend(self.prepared.observables.iter().map(observe));
        Row { label: None, stable: None, values }
    }

    fn describe(&self, sample: &Sample, columns: &[Column], row: &Row, special: &mut SpecialPoint) {
        let problem = &*self.prepared.problem;
        let p = problem.resolve(&sample.curve.parameters(&sample.point));
        let u = &sample.point.x[..problem.dim()];
        let named = columns.iter().zip(&row.values).skip(2);
        special.values = named.filter_map(|(column, value)| Some((column.name.clone(), (*value)?))).collect();
        let vector = |data: Vec<f64>| Array { shape: vec![data.len()], data };
        special.arrays = BTreeMap::from([
            ("state".to_owned(), vector(u.to_vec())),
            ("tangent".to_owned(), vector([&sample.point.tangent[..], &[sample.point.tangent_lambda]].concat())),
            ("parameters".to_owned(), vector(p.clone())),
        ]);
        let names = problem.parameters().iter().map(|q| q.name.to_owned());
        special.parameters = names.zip(p).collect();
    }
}

/// The point between the ends of a step at which a coordinate takes a value, if there is one.
fn locate(
    curve: &BranchCurve,
    (from, to): &(Point, Point),
    (k, goal): Value,
    counts: &mut Counts,
) -> Result<Option<Point>, Failure> {
    let value = |point: &Point| curve.coordinates(point)[k] - goal;
    let (a, b) = (value(from), value(to));
    if !(a * b < 0.0 || b == 0.0) {
        return Ok(None);
    }
    match k {
        1 => at_lambda(curve, (from, to), goal, counts).map(|found| Some(found.point)),
        _ => crossing(curve, (from, to), &value, counts).map(Some),
    }
}
