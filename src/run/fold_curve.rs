//! A task of kind `fold-curve`: folds in two parameters, both ways from the start, with cusps, Bogdanov-Takens and
//! zero-Hopf points, and wanted values.

use super::outcome::{Outcome, Status, joined, labels};
use super::start::{StartError, coordinates, equilibrium};
use super::study::Prepared;
use super::watch::Watch;
use crate::bifurcation::{BogdanovTakens, FoldCurve, FoldSegment, FoldTest, Segment, Test, ZeroHopf, reverse};
use crate::branch::{Array, Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use crate::continuation::{Counts, Failure, Point, StepControl, Stop, Walk};
use crate::linalg::c64;
use crate::problem::{At, Problem};
use crate::scene;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::time::Instant;
use thiserror::Error;

/// Numbers of points besides the parameters, which only points of codimension two have.
pub const VALUES: [&str; 7] = ["omega", "frequency", "bt_a", "bt_b", "zh_s", "zh_theta", "zh_e"];

#[derive(Debug, Error)]
enum CurveError {
    #[error(transparent)]
    Numerics(#[from] Failure),
    #[error(transparent)]
    Place(#[from] StartError),
    #[error("{0} is not stored with its state")]
    Incomplete(String),
    #[error("the start is not a fold that moves with {0} or {1}: {2}")]
    NoCurve(String, String, Failure),
}

/// Arclength is counted in parts of the ranges.
const FIRST_STEP: f64 = 0.005;
const LARGEST_STEP: f64 = 0.02;
const LEAST_STEP: f64 = 1e-7;

/// A point of the curve.
struct Sample {
    /// The step that led here.
    segment: FoldSegment,
    point: Point,
    others: Vec<c64>,
    mark: Option<(Kind, Option<FoldTest>)>,
}

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
    let observables = prepared.problem.observables();
    columns.extend(prepared.observables.iter().map(|&i| column(observables[i].name, observables[i].unit)));
    Branch {
        name: name.to_owned(),
        kind: BranchKind::FoldCurve,
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
        let started = FoldCurve::start(self.prepared.problem.clone(), (&u, &p), coordinates, counts);
        let (curve, point) = started
            .map_err(|failure| CurveError::NoCurve(along.others[0].name.clone(), along.free.clone(), failure))?;
        let mut back = point.clone();
        reverse(&mut back);
        let here = FoldSegment { curve: curve.clone(), from: point.clone(), to: point.clone() };
        let start = self.sample(here, point.clone(), None);
        let most = along.max_points.saturating_sub(1).div_ceil(2);
        let down = self.way(curve.clone(), back, &start, most, counts)?;
        let up = if down.reason == Stop::Closed.to_string() || down.status == Status::Interrupted {
            Way { samples: Vec::new(), reason: down.reason.clone(), status: down.status }
        } else {
            self.way(curve, point, &start, most, counts)?
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
    fn way(
        &self,
        mut curve: FoldCurve,
        start: Point,
        first: &Sample,
        most: usize,
        counts: &mut Counts,
    ) -> Result<Way, CurveError> {
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
            let mut segment = FoldSegment { curve: walk.system.clone(), from: step.from, to: step.to };
            let mut mark =
                (step.stop == Some(Stop::RangeEnd)).then_some((Kind::EP, Some(FoldTest::Value(1, segment.to.lambda))));
            let mut stop = step.stop.map(|stop| stop.to_string());
            let z = segment.curve.coordinates(&segment.to)[0];
            let passed = bounds.and_then(|(low, high)| {
                [low, high].into_iter().find(|&b| (b == low && z <= low) || (b == high && z >= high))
            });
            if let Some(bound) = passed
                && let Some(point) = segment.locate(FoldTest::Value(0, bound), counts)?
            {
                segment.to = point;
                mark = Some((Kind::EP, Some(FoldTest::Value(0, bound))));
                stop = Some(Stop::RangeEnd.to_string());
            }
            let z = segment.to.lambda;
            let fraction = (z - low) / (high - low);
            self.watch.at(fraction, format!("{} = {:.6}", along.free, segment.curve.second.value(z)));
            let to = segment.to.clone();
            counts.spectra += 1;
            let sample = self.sample(segment, to, mark);
            let between = self.between(samples.last().unwrap_or(first), &sample, counts);
            samples.extend(between);
            samples.push(sample);
            if let Some(reason) = stop {
                break (Status::Done, reason);
            }
        };
        *counts += walk.counts;
        Ok(Way { samples, reason, status })
    }

    fn sample(&self, segment: FoldSegment, point: Point, mark: Option<(Kind, Option<FoldTest>)>) -> Sample {
        let others = segment.curve.others(&point, 1.0).unwrap_or_default();
        Sample { segment, point, others, mark }
    }

    /// Wanted values and points of codimension two between two neighbours, in the order of the curve.
    fn between(&self, last: &Sample, next: &Sample, counts: &mut Counts) -> Vec<Sample> {
        let segment = &next.segment;
        let ended = next.mark.and_then(|(_, test)| test);
        let mut tests = vec![(Kind::CP, FoldTest::Cusp), (Kind::BT, FoldTest::Takens)];
        for (k, coordinate) in [segment.curve.first, segment.curve.second].into_iter().enumerate() {
            let name = self.prepared.problem.parameters()[coordinate.index].name;
            let wanted = self.task.along.values.get(name).into_iter().flatten();
            tests.extend(wanted.map(|&value| (Kind::UZ, FoldTest::Value(k, coordinate.of(value)))));
        }
        tests.extend(Segment::crossing_pairs(&last.others, &next.others).into_iter().filter_map(|test| match test {
            Test::Pair(from, to) => Some((Kind::ZH, FoldTest::Pair(from, to))),
            _ => None,
        }));
        let found = tests.into_iter().filter(|(_, test)| ended != Some(*test)).filter_map(|(kind, test)| {
            let point = segment.locate(test, counts).ok()??;
            Some(self.sample(segment.clone(), point, Some((kind, Some(test)))))
        });
        let mut samples: Vec<Sample> = found.collect();
        let along = |sample: &Sample| {
            let (a, b) = (segment.curve.coordinates(&segment.from), segment.curve.coordinates(&segment.to));
            let z = segment.curve.coordinates(&sample.point);
            let widths = [segment.curve.first.width, segment.curve.second.width];
            (0..2).map(|k| (z[k] - a[k]) * (b[k] - a[k]) / widths[k].powi(2)).sum::<f64>()
        };
        samples.sort_by(|x, y| along(x).total_cmp(&along(y)));
        samples
    }

    /// Rows and special points.
    fn store(&self, branch: &mut Branch, samples: &[Sample]) {
        branch.rows = samples.iter().map(|sample| self.row(sample)).collect();
        for (row, sample) in samples.iter().enumerate() {
            let Some((kind, test)) = sample.mark else { continue };
            let (short, label) = labels(branch, kind);
            let mut point = SpecialPoint::new(label, kind, row);
            self.describe(sample, test, &branch.columns, &branch.rows[row], &mut point);
            branch.rows[row].label = Some(short);
            branch.points.push(point);
        }
    }

    fn row(&self, sample: &Sample) -> Row {
        let curve = &sample.segment.curve;
        let p = curve.parameters(&sample.point);
        let u = &sample.point.x[..self.prepared.problem.dim()];
        let rest = vec![0.0; u.len()];
        let list = self.prepared.problem.parameters();
        let value = |name: &str| list.iter().position(|q| q.name == name).map(|i| p[i]);
        let mut values = vec![Some(p[curve.first.index]), Some(p[curve.second.index])];
        values.extend(self.task.along.logarithmic.iter().map(|name| value(name).map(f64::log10)));
        let observe = |&i: &usize| Some(self.prepared.problem.observe(i, At { u, v: &rest, p: &p }));
        values.extend(self.prepared.observables.iter().map(observe));
        Row { label: None, stable: None, values }
    }

    fn describe(
        &self,
        sample: &Sample,
        test: Option<FoldTest>,
        columns: &[Column],
        row: &Row,
        special: &mut SpecialPoint,
    ) {
        let problem = &*self.prepared.problem;
        let p = problem.resolve(&sample.segment.curve.parameters(&sample.point));
        let u = &sample.point.x[..problem.dim()];
        let named = columns.iter().zip(&row.values).skip(2);
        special.values = named.filter_map(|(column, value)| Some((column.name.clone(), (*value)?))).collect();
        let found = match test {
            Some(FoldTest::Takens) => {
                BogdanovTakens::new(problem, u, &p).ok().map(|form| vec![("bt_a", form.a), ("bt_b", form.b)])
            }
            Some(FoldTest::Pair(from, to)) => sample.segment.pair(from, to, &sample.point).map(|pair| {
                let mut found = vec![("omega", pair.im), ("frequency", pair.im / (2.0 * PI))];
                if let Ok(form) = ZeroHopf::new(problem, u, &p, pair.im) {
                    found.extend([("zh_s", form.s), ("zh_theta", form.theta), ("zh_e", form.e)]);
                }
                found
            }),
            _ => None,
        };
        let finite = found.into_iter().flatten().filter(|(_, value)| value.is_finite());
        special.values.extend(finite.map(|(name, value)| (name.to_owned(), value)));
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
