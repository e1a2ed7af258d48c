//! A task of kind `hopf-curve`: Hopf points in two parameters, both ways from the start, with criticality, points of
//! codimension two, wanted values and errors.

use super::equilibria::error;
use super::outcome::{Outcome, Status, labels};
use super::start::Stored;
use super::study::Prepared;
use super::watch::{Watch, interrupted};
use crate::bifurcation::{Coordinate, Hopf, HopfCurve, HopfError, HopfNormalForm, Segment, Test, reverse};
use crate::branch::{Array, Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use crate::continuation::{Counts, Failure, Point, StepControl, Stop, Walk};
use crate::linalg::c64;
use crate::problem::{Problem, Refinement};
use crate::scene;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::time::Instant;
use thiserror::Error;

#[derive(Debug, Error)]
enum CurveError {
    #[error(transparent)]
    Numerics(#[from] Failure),
    #[error("the start is not a Hopf point any more: {0}")]
    Start(#[from] HopfError),
    #[error("{0} is not stored with its eigenvector")]
    Incomplete(String),
    #[error("the start has {name} = {value}, which does not lie inside the range {from} to {to}")]
    Outside { name: String, value: f64, from: f64, to: f64 },
    #[error("{0} is logarithmic, but the start has {0} = {1}")]
    NotPositive(String, f64),
    #[error("neither {0} nor {1} moves the Hopf point: there is no curve in these parameters")]
    NoCurve(String, String),
    #[error("{0} changes neither the Hopf point nor its criticality: the problem does not depend on it here")]
    Idle(String),
}

/// Arclength is counted in parts of the ranges.
const FIRST_STEP: f64 = 0.005;
const LARGEST_STEP: f64 = 0.02;
const LEAST_STEP: f64 = 1e-7;
/// A first parameter without a range counts in parts of so many times its value at the start: the second sets the pace.
const WIDE: f64 = 10.0;
/// Points whose rows are made at once.
const BATCH: usize = 8;
/// Estimated relative error of a parameter from which on the discretisation counts as too coarse.
const COARSE: f64 = 1e-3;
/// Relative changes of sigma below this, over a whole range, are none.
const IDLE: f64 = 1e-10;

/// A point of the curve with all that its row needs.
struct Sample {
    /// The step that led here.
    segment: Segment,
    point: Point,
    /// The parameter that is solved for, the other being held.
    free: usize,
    here: Option<Here>,
    /// The same Hopf point on the refined discretisation.
    fine: Option<Here>,
    others: Vec<c64>,
    mark: Option<(Kind, Option<Test>)>,
}

/// The Hopf point and what is born there.
struct Here {
    hopf: Hopf,
    form: Option<HopfNormalForm>,
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
    let refined = if task.along.errors { prepared.problem.refined() } else { None };
    let tool = Curve { prepared, task, refined, watch };
    let mut outcome = match tool.follow(branch.clone(), from, &mut counts) {
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
    let time = prepared.problem.time_unit();
    let of_time = |units: [&str; 2]| if time.is_empty() { units[0].to_owned() } else { units[1].replace("{s}", time) };
    let mut columns: Vec<(String, String)> = free.iter().map(|q| (q.name.to_owned(), q.unit.to_owned())).collect();
    columns.extend(task.along.logarithmic.iter().map(|name| (format!("log10 {name}"), String::new())));
    columns.push(("omega".to_owned(), of_time(["rad", "rad/{s}"])));
    columns.push(("frequency".to_owned(), if time == "s" { "Hz".to_owned() } else { of_time(["", "1/{s}"]) }));
    columns.push(("lyapunov".to_owned(), String::new()));
    columns.push(("dsigma_re".to_owned(), String::new()));
    columns.push(("dsigma_im".to_owned(), String::new()));
    if task.along.errors {
        for (name, unit) in
            columns.clone().into_iter().filter(|(name, _)| !name.starts_with("log10 ") && !name.starts_with("dsigma"))
        {
            columns.push((format!("error {name}"), unit));
        }
    }
    Branch {
        name: name.to_owned(),
        kind: BranchKind::HopfCurve,
        free: free.iter().map(|q| q.name.to_owned()).collect(),
        columns: columns.into_iter().map(|(name, unit)| Column { name, unit }).collect(),
        rows: Vec::new(),
        points: Vec::new(),
        triangles: Vec::new(),
    }
}

struct Curve<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Curve,
    /// What error estimates come from.
    refined: Option<Refinement>,
    watch: &'a Watch,
}

impl Curve<'_> {
    fn follow(&self, mut branch: Branch, from: &SpecialPoint, counts: &mut Counts) -> Result<Outcome, CurveError> {
        let hopf = self.hopf(from)?;
        let coordinates = self.coordinates(&hopf)?;
        self.check_influence(&hopf, coordinates)?;
        let (curve, point) = HopfCurve::start(self.prepared.problem.clone(), &hopf, coordinates, counts)?;
        let mut back = point.clone();
        reverse(&mut back);
        let most = self.task.along.max_points;
        let start = Segment { curve: curve.clone(), from: point.clone(), to: point.clone() };
        let start = self.samples(vec![(start, point.clone(), None)]);
        // The first half of the points may be used on the way back.
        let down = self.way(curve.clone(), back, &start, most.saturating_sub(1).div_ceil(2), counts)?;
        let left = most.saturating_sub(1 + down.samples.len());
        let up = if down.status == Status::Interrupted {
            Way { samples: Vec::new(), reason: down.reason.clone(), status: down.status }
        } else {
            self.way(curve, point, &start, left, counts)?
        };
        let reason = if down.reason == up.reason {
            up.reason
        } else {
            format!("one way: {}; the other: {}", down.reason, up.reason)
        };
        let status = [down.status, up.status].into_iter().find(|s| *s != Status::Done).unwrap_or(Status::Done);
        let mut samples: Vec<Sample> = down.samples.into_iter().rev().chain(start).chain(up.samples).collect();
        let last = samples.len() - 1;
        for end in [0, last] {
            samples[end].mark.get_or_insert((Kind::EP, None));
        }
        self.store(&mut branch, &samples);
        Ok(Outcome { branch, status, reason, seconds: 0.0, counts: *counts })
    }

    /// The stored point, solved for again in whichever parameter moves it.
    fn hopf(&self, from: &SpecialPoint) -> Result<Hopf, CurveError> {
        let Stored { u, p, omega, q } =
            Stored::read(self.prepared, from).ok_or_else(|| CurveError::Incomplete(from.label.clone()))?;
        let problem = &*self.prepared.problem;
        let located = |free: usize| Hopf::locate(problem, (&u, &p), free, omega, &q);
        match located(self.prepared.first()) {
            Ok(hopf) => Ok(hopf),
            _ => located(self.prepared.free).map_err(|failure| match failure {
                // Newton's step is 0/0 where a parameter does not matter.
                HopfError::Diverged(step) if !step.is_finite() => {
                    CurveError::NoCurve(self.task.along.others[0].name.clone(), self.task.along.free.clone())
                }
                failure => failure.into(),
            }),
        }
    }

    fn coordinates(&self, hopf: &Hopf) -> Result<(Coordinate, Coordinate), CurveError> {
        let make = |index: usize, range: Option<&scene::Range>| {
            let name = self.prepared.problem.parameters()[index].name.to_owned();
            let logarithmic = self.task.along.logarithmic.contains(&name);
            let value = hopf.p[index];
            if logarithmic && value <= 0.0 {
                return Err(CurveError::NotPositive(name, value));
            }
            let mut coordinate = Coordinate { index, logarithmic, width: 1.0 };
            match range {
                Some(range) => {
                    let slack = 1e-12 * (range.to - range.from);
                    if !(range.from - slack..=range.to + slack).contains(&value) {
                        return Err(CurveError::Outside { name, value, from: range.from, to: range.to });
                    }
                    coordinate.width = coordinate.of(range.to) - coordinate.of(range.from);
                }
                None if !logarithmic && value != 0.0 => coordinate.width = WIDE * value.abs(),
                None => {}
            }
            Ok(coordinate)
        };
        let first = self.prepared.first();
        Ok((
            make(first, self.task.along.others.first().and_then(|axis| axis.range.as_ref()))?,
            make(self.prepared.free, Some(&self.task.along.range))?,
        ))
    }

    /// One of the parameters must move the Hopf point, and each must change something.
    fn check_influence(&self, hopf: &Hopf, (first, second): (Coordinate, Coordinate)) -> Result<(), CurveError> {
        let problem = &*self.prepared.problem;
        let list = problem.parameters();
        let mut idle = Vec::new();
        for coordinate in [first, second] {
            let z = coordinate.of(hopf.p[coordinate.index]);
            let slope = hopf.clone().along(problem, coordinate.index)?.slope;
            if slope.norm() * coordinate.rate(z) * coordinate.width < IDLE * hopf.omega {
                idle.push(coordinate);
            }
        }
        match idle[..] {
            [a, b] => Err(CurveError::NoCurve(list[a.index].name.to_owned(), list[b.index].name.to_owned())),
            [one] => {
                let mut moved = hopf.clone();
                let z = one.of(hopf.p[one.index]);
                moved.p[one.index] = one.value(z + 0.01 * one.width);
                let form = |hopf: &Hopf| HopfNormalForm::new(problem, hopf);
                let (here, there) = (form(hopf)?.c1, form(&moved)?.c1);
                if (here - there).norm() < IDLE * here.norm() {
                    return Err(CurveError::Idle(list[one.index].name.to_owned()));
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Both ends of each range, as coordinates; the second range is the walk's own.
    fn bounds(&self, curve: &HopfCurve) -> [Option<(f64, f64)>; 2] {
        let of = |c: Coordinate, range: &scene::Range| (c.of(range.from), c.of(range.to));
        [
            self.task.along.others.first().and_then(|axis| axis.range.as_ref()).map(|range| of(curve.first, range)),
            Some(of(curve.second, &self.task.along.range)),
        ]
    }

    /// Follows the curve one way from a point, which itself is not among the samples.
    fn way(
        &self,
        mut curve: HopfCurve,
        start: Point,
        first: &[Sample],
        most: usize,
        counts: &mut Counts,
    ) -> Result<Way, CurveError> {
        let [first_bounds, second_bounds] = self.bounds(&curve);
        let (low, high) = second_bounds.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        let done = |samples, reason: &str| Way { samples, reason: reason.to_owned(), status: Status::Done };
        // From the end of a range outward there is nowhere to go.
        let n = self.prepared.problem.dim();
        let outward = |z: f64, direction: f64, (low, high): (f64, f64)| {
            let slack = 1e-12 * (high - low);
            (z <= low + slack && direction < 0.0) || (z >= high - slack && direction > 0.0)
        };
        let leaves_first = first_bounds.is_some_and(|bounds| outward(start.x[n + 1], start.tangent[n + 1], bounds));
        if leaves_first || outward(start.lambda, start.tangent_lambda, (low, high)) {
            return Ok(done(Vec::new(), &Stop::RangeEnd.to_string()));
        }
        let control = StepControl { step: FIRST_STEP, least: LEAST_STEP, most: LARGEST_STEP };
        let mut walk = Walk::new(&mut curve, start, control, (low, high));
        let mut samples: Vec<Sample> = Vec::new();
        let mut pending: Vec<(Segment, Point, Option<(Kind, Option<Test>)>)> = Vec::new();
        loop {
            let end: Option<(Status, String)>;
            if interrupted() {
                end = Some((Status::Interrupted, Stop::Interrupted.to_string()));
            } else if samples.len() + pending.len() >= most {
                end = Some((Status::Done, Stop::MaxPoints.to_string()));
            } else {
                match walk.step() {
                    Ok(step) => {
                        let mut segment = Segment { curve: walk.system.clone(), from: step.from, to: step.to };
                        // The walk ends at its range, exactly.
                        let end_of_range = (step.stop == Some(Stop::RangeEnd)).then_some(segment.to.lambda);
                        let mut mark = end_of_range.map(|z| (Kind::EP, Some(Test::Value(1, z))));
                        let mut stop = step.stop.map(|stop| stop.to_string());
                        for (test, kind, reason) in self.endings(&segment, first_bounds) {
                            let Some(point) = segment.locate(test, counts)? else { continue };
                            (segment.to, mark, stop) = (point, Some((kind, Some(test))), Some(reason));
                        }
                        end = stop.map(|reason| (Status::Done, reason));
                        let to = segment.to.clone();
                        self.progress(&segment, &to);
                        pending.push((segment, to, mark));
                    }
                    Err(stop) => {
                        if let Some((.., mark)) = pending.last_mut() {
                            mark.get_or_insert((Kind::MX, None));
                        } else if let Some(last) = samples.last_mut() {
                            last.mark.get_or_insert((Kind::MX, None));
                        }
                        end = Some((Status::Failed, stop.to_string()));
                    }
                }
            }
            if pending.len() < BATCH && end.is_none() {
                continue;
            }
            counts.spectra += pending.len();
            for sample in self.samples(std::mem::take(&mut pending)) {
                if let Some(reason) = self.too_coarse(&sample) {
                    *counts += walk.counts;
                    return Ok(Way { samples, reason, status: Status::Done });
                }
                let last = samples.last().or(first.first());
                let between = last.map_or(Vec::new(), |last| self.between(last, &sample, counts));
                samples.extend(between);
                samples.push(sample);
            }
            if let Some((status, reason)) = end {
                *counts += walk.counts;
                return Ok(Way { samples, reason, status });
            }
        }
    }

    fn progress(&self, segment: &Segment, point: &Point) {
        let (z, c) = (point.lambda, segment.curve.second);
        let (low, high) = (c.of(self.task.along.range.from), c.of(self.task.along.range.to));
        self.watch.at((z - low) / (high - low), format!("{} = {:.6}", self.task.along.free, c.value(z)));
    }

    /// What ends the curve within a step: a Bogdanov-Takens point, a bound of the first parameter.
    fn endings(&self, segment: &Segment, bounds: Option<(f64, f64)>) -> Vec<(Test, Kind, String)> {
        let mut endings =
            vec![(Test::Frequency, Kind::BT, "the frequency vanishes at a Bogdanov-Takens point (BT)".to_owned())];
        if let Some((low, high)) = bounds {
            let z = segment.curve.coordinates(&segment.to)[0];
            for bound in [low, high] {
                if (bound == low && z <= low) || (bound == high && z >= high) {
                    endings.push((Test::Value(0, bound), Kind::EP, Stop::RangeEnd.to_string()));
                }
            }
        }
        endings
    }

    /// Everything that rows need, side by side.
    fn samples(&self, points: Vec<(Segment, Point, Option<(Kind, Option<Test>)>)>) -> Vec<Sample> {
        points.into_par_iter().map(|(segment, point, mark)| self.sample(segment, point, mark)).collect()
    }

    fn sample(&self, segment: Segment, point: Point, mark: Option<(Kind, Option<Test>)>) -> Sample {
        let problem = &*self.prepared.problem;
        let vanished = matches!(mark, Some((Kind::BT, _)));
        let free = match mark {
            Some((_, Some(Test::Value(0, _)))) => segment.curve.second.index,
            Some((_, Some(Test::Value(_, _)))) => segment.curve.first.index,
            _ => segment.curve.solvable(&point),
        };
        let here = segment.curve.hopf(&point, free).ok().filter(|_| !vanished);
        let here = here.map(|hopf| Here { form: HopfNormalForm::new(problem, &hopf).ok(), hopf });
        let fine = here.as_ref().and_then(|here| self.fine(segment.curve.first.index, free, here));
        let others = segment.curve.others(&point).unwrap_or_default();
        Sample { segment, point, free, here, fine, others, mark }
    }

    /// The same Hopf point on the refined discretisation, one parameter held.
    fn fine(&self, first: usize, free: usize, here: &Here) -> Option<Here> {
        let refined = self.refined.as_ref()?;
        let hopf = &here.hopf;
        let part = |f: fn(&c64) -> f64| (refined.prolong)(&hopf.q.iter().map(f).collect::<Vec<_>>());
        let q: Vec<c64> = part(|z| z.re).iter().zip(part(|z| z.im)).map(|(&re, im)| c64::new(re, im)).collect();
        let problem = &*refined.problem;
        let found = Hopf::locate(problem, (&(refined.prolong)(&hopf.u), &hopf.p), free, hopf.omega, &q).ok()?;
        let hopf = if free == first { found } else { found.along(problem, first).ok()? };
        Some(Here { form: HopfNormalForm::new(problem, &hopf).ok(), hopf })
    }

    /// Why the discretisation does not resolve the mode here, if so.
    fn too_coarse(&self, sample: &Sample) -> Option<String> {
        self.refined.as_ref()?;
        let (here, free) = (sample.here.as_ref()?, sample.free);
        let name = self.prepared.problem.parameters()[free].name;
        let off = match &sample.fine {
            Some(fine) => (fine.hopf.p[free] / here.hopf.p[free] - 1.0).abs(),
            None => f64::INFINITY,
        };
        let advice = "the discretisation does not resolve the mode any more; refine it";
        (off > COARSE).then(|| format!("the estimated relative error of {name} is {off:.0e}: {advice}"))
    }

    /// Wanted values and points of codimension two between two neighbours, in the order of the curve.
    fn between(&self, last: &Sample, next: &Sample, counts: &mut Counts) -> Vec<Sample> {
        let segment = &next.segment;
        let ended = next.mark.and_then(|(_, test)| test);
        let mut tests: Vec<(Kind, Test)> = Vec::new();
        for (k, coordinate) in [segment.curve.first, segment.curve.second].into_iter().enumerate() {
            let name = self.prepared.problem.parameters()[coordinate.index].name;
            let wanted = self.task.along.values.get(name).into_iter().flatten();
            tests.extend(wanted.map(|&value| (Kind::UZ, Test::Value(k, coordinate.of(value)))));
        }
        let l1 = |sample: &Sample| sample.here.as_ref().and_then(|here| Some(here.form.as_ref()?.l1));
        if let (Some(a), Some(b)) = (l1(last), l1(next))
            && a * b < 0.0
        {
            tests.push((Kind::GH, Test::Criticality));
        }
        tests.push((Kind::ZH, Test::Steady));
        tests.extend(Segment::crossing_pairs(&last.others, &next.others).into_iter().map(|test| (Kind::HH, test)));
        let found: Vec<_> = tests
            .into_iter()
            // At the end of the curve a wanted value is that end, and at BT a real eigenvalue vanishes anyway.
            .filter(|(kind, test)| ended != Some(*test) && !(*kind == Kind::ZH && ended == Some(Test::Frequency)))
            .filter_map(|(kind, test)| {
                let point = segment.locate(test, counts).ok()??;
                Some((segment.clone(), point, Some((kind, Some(test)))))
            })
            .collect();
        let mut samples = self.samples(found);
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
        branch.rows = samples.iter().map(|sample| self.row(branch, sample)).collect();
        let marked: Vec<(usize, &Sample, Kind)> =
            samples.iter().enumerate().filter_map(|(row, sample)| Some((row, sample, sample.mark?.0))).collect();
        let points: Vec<SpecialPoint> =
            marked.par_iter().map(|(row, sample, kind)| self.special(branch, *row, sample, *kind)).collect();
        for ((row, _, kind), mut point) in marked.into_iter().zip(points) {
            let (short, label) = labels(branch, kind);
            point.label = label;
            if self.prepared.waves.contains(&short) {
                super::wave::of_mode(self.prepared, &mut point);
            }
            branch.rows[row].label = Some(short);
            branch.points.push(point);
        }
    }

    /// A number of a sample by the name of its column.
    fn measure(&self, curve: &HopfCurve, point: &Point, here: Option<&Here>, name: &str) -> Option<f64> {
        let list = self.prepared.problem.parameters();
        for (coordinate, z) in [curve.first, curve.second].into_iter().zip(curve.coordinates(point)) {
            let own = list[coordinate.index].name;
            let value = || here.map_or(coordinate.value(z), |here| here.hopf.p[coordinate.index]);
            if name == own {
                return Some(value());
            }
            if name.strip_prefix("log10 ") == Some(own) {
                return Some(value().log10());
            }
        }
        let omega = here.map_or(curve.kappa(point).max(0.0).sqrt(), |here| here.hopf.omega);
        let slope = here.map(|here| here.hopf.slope);
        match name {
            "omega" => Some(omega),
            "frequency" => Some(omega / (2.0 * PI)),
            "lyapunov" => here?.form.as_ref().map(|form| form.l1),
            "dsigma_re" => slope.map(|s| s.re),
            "dsigma_im" => slope.map(|s| s.im),
            _ => None,
        }
        .filter(|value| value.is_finite())
    }

    fn row(&self, branch: &Branch, sample: &Sample) -> Row {
        let curve = &sample.segment.curve;
        let value = |here: Option<&Here>, name: &str| self.measure(curve, &sample.point, here, name);
        let held = [curve.first.index, curve.second.index].into_iter().find(|i| *i != sample.free);
        let held = held.map(|i| self.prepared.problem.parameters()[i].name);
        let number = |column: &Column| match column.name.strip_prefix("error ") {
            Some(name) => {
                let (here, fine) = (sample.here.as_ref()?, sample.fine.as_ref()?);
                if Some(name) == held {
                    return None;
                }
                Some(error(value(Some(here), name)?, value(Some(fine), name)?))
            }
            None => value(sample.here.as_ref(), &column.name),
        };
        let degenerate = matches!(sample.mark, Some((Kind::GH, _)));
        let l1 = value(sample.here.as_ref(), "lyapunov").filter(|_| !degenerate);
        Row { label: None, stable: l1.map(|l1| l1 < 0.0), values: branch.columns.iter().map(number).collect() }
    }

    fn special(&self, branch: &Branch, row: usize, sample: &Sample, kind: Kind) -> SpecialPoint {
        let curve = &sample.segment.curve;
        let (mut values, mut errors) = (BTreeMap::new(), BTreeMap::new());
        for (column, value) in branch.columns.iter().zip(&branch.rows[row].values) {
            let Some(value) = *value else { continue };
            match column.name.strip_prefix("error ") {
                Some(name) => errors.insert(name.to_owned(), value),
                None if branch.free.contains(&column.name) => None,
                None => values.insert(column.name.clone(), value),
            };
        }
        if let Some((_, Some(Test::Pair(from, to)))) = sample.mark
            && let Some(pair) = sample.segment.pair(from, to, &sample.point)
        {
            values.insert("omega_2".to_owned(), pair.im);
        }
        if let Some((_, Some(test))) = sample.mark {
            errors.extend(self.located_errors(sample, test));
        }
        let p = match &sample.here {
            Some(here) => here.hopf.p.clone(),
            None => curve.parameters(&sample.point),
        };
        let resolved = self.prepared.problem.resolve(&p);
        let list = self.prepared.problem.parameters();
        let n = self.prepared.problem.dim();
        let vector = |data: Vec<f64>| Array { shape: vec![data.len()], data };
        let mut arrays = BTreeMap::from([
            ("state".to_owned(), vector(sample.point.x[..n].to_vec())),
            ("parameters".to_owned(), vector(resolved.clone())),
            ("tangent".to_owned(), vector([&sample.point.tangent[..], &[sample.point.tangent_lambda]].concat())),
        ]);
        if let Some(Here { hopf, .. }) = &sample.here {
            for (name, z) in [("q", &hopf.q), ("w", &hopf.w)] {
                arrays.insert(format!("{name}_re"), vector(z.iter().map(|z| z.re).collect()));
                arrays.insert(format!("{name}_im"), vector(z.iter().map(|z| z.im).collect()));
            }
        }
        let parameters = list.iter().zip(&resolved).map(|(q, &x)| (q.name.to_owned(), x)).collect();
        SpecialPoint { label: String::new(), kind, row, parameters, values, errors, arrays }
    }

    /// Errors of a point that a test located: the same test between the same points of the refined curve.
    fn located_errors(&self, sample: &Sample, test: Test) -> BTreeMap<String, f64> {
        let mut errors = BTreeMap::new();
        let Some(refined) = &self.refined else { return errors };
        let Ok(segment) = sample.segment.refined(refined.problem.clone(), &refined.prolong) else { return errors };
        let Ok(Some(point)) = segment.locate(test, &mut Counts::default()) else { return errors };
        let list = self.prepared.problem.parameters();
        let curve = &sample.segment.curve;
        let free = [curve.first, curve.second].map(|c| list[c.index].name);
        for (k, name) in free.into_iter().chain(["omega", "frequency"]).enumerate() {
            let value = |curve: &HopfCurve, point: &Point| self.measure(curve, point, None, name);
            let (Some(here), Some(there)) = (value(curve, &sample.point), value(&segment.curve, &point)) else {
                continue;
            };
            if !matches!(test, Test::Value(held, _) if held == k) {
                errors.insert(name.to_owned(), error(here, there));
            }
        }
        errors
    }
}
