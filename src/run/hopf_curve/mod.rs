//! A task of kind `hopf-curve`: Hopf points in two parameters, both ways from the start, with criticality, points of
//! codimension two, wanted values and errors.

mod rows;
mod sample;
mod start;

use super::equilibria::{frequency, rates};
use super::locus;
use super::outcome::{Outcome, Status, joined};
use super::start::coordinates;
use super::study::Prepared;
use super::watch::Watch;
use crate::bifurcation::{Coordinate, HopfCurve, HopfSegment, Locus, Test, reverse};
use crate::branch::{Branch, BranchKind, Column, Kind, SpecialPoint};
use crate::continuation::{Counts, Point, StepControl, Stop, Walk};
use crate::problem::{Problem, Refinement};
use crate::scene;
pub use sample::{COARSE, moved};
use sample::{Reached, Sample};
use start::CurveError;
use std::sync::Mutex;
use std::time::Instant;

/// Numbers of points besides the parameters: columns first, then what only points of codimension two have.
pub const VALUES: [&str; 16] = [
    "omega",
    "frequency",
    "lyapunov",
    "dsigma_re",
    "dsigma_im",
    "lyapunov_2",
    "bt_a",
    "bt_b",
    "zh_s",
    "zh_theta",
    "zh_e",
    "omega_2",
    "hh_p11",
    "hh_p22",
    "hh_theta",
    "hh_delta",
];

/// Arclength is counted in parts of the ranges.
const FIRST_STEP: f64 = 0.005;
const LARGEST_STEP: f64 = 0.02;
const LEAST_STEP: f64 = 1e-7;
/// Points whose rows are made at once.
const BATCH: usize = 8;

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
    let tool = Curve { prepared, task, refined, watch, covered: Mutex::new((f64::INFINITY, f64::NEG_INFINITY)) };
    let mut outcome = match tool.follow(branch.clone(), from, &mut counts) {
        Ok(outcome) => outcome,
        Err(failure) => Outcome::failed(branch, failure.to_string()),
    };
    outcome.seconds = start.elapsed().as_secs_f64();
    outcome.counts = counts;
    outcome
}

pub fn empty(prepared: &Prepared, name: &str, task: &scene::Curve) -> Branch {
    let time = prepared.problem.time_unit();
    let own = [
        ("omega", rates(time).1),
        ("frequency", frequency(time)),
        ("lyapunov", String::new()),
        ("dsigma_re", String::new()),
        ("dsigma_im", String::new()),
    ];
    let own = own.map(|(name, unit)| (name.to_owned(), unit)).to_vec();
    let mut branch = locus::empty(prepared, name, (BranchKind::HopfCurve, task), own);
    if task.along.errors {
        let judged = |column: &&Column| !column.name.starts_with("log10 ") && !column.name.starts_with("dsigma");
        let errors: Vec<Column> = branch.columns.iter().filter(judged).map(Column::error).collect();
        branch.columns.extend(errors);
    }
    branch
}

struct Curve<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Curve,
    /// What error estimates come from.
    refined: Option<Refinement>,
    watch: &'a Watch,
    /// The part of the second parameter's range that the curve has seen.
    covered: Mutex<(f64, f64)>,
}

impl Curve<'_> {
    fn follow(&self, mut branch: Branch, from: &SpecialPoint, counts: &mut Counts) -> Result<Outcome, CurveError> {
        let hopf = self.hopf(from)?;
        let coordinates = coordinates(self.prepared, &self.task.along, &hopf.p)?;
        self.check_influence(&hopf, coordinates)?;
        let (curve, point) = HopfCurve::start(self.prepared.problem.clone(), &hopf, coordinates, counts)?;
        let mut back = point.clone();
        reverse(&mut back);
        let start = HopfSegment { curve: curve.clone(), from: point.clone(), to: point.clone() };
        let mark = locus::start_mark(self.prepared, &self.task.along, &start);
        let start = self.samples(vec![(start, point.clone(), mark)]);
        // Both ways at a time, each with half of the points.
        let most = self.task.along.max_points.saturating_sub(1).div_ceil(2);
        let go = |curve: HopfCurve, from: Point| {
            let mut counts = Counts::default();
            (self.way(curve, from, &start, most, &mut counts), counts)
        };
        let (down, up) = rayon::join(|| go(curve.clone(), back), || go(curve.clone(), point));
        *counts += down.1;
        *counts += up.1;
        let (down, mut up) = (down.0?, up.0?);
        if down.reason == Stop::Closed.to_string() {
            up = Way { samples: Vec::new(), reason: down.reason.clone(), status: down.status };
        }
        let (status, reason) = joined([(down.status, &down.reason), (up.status, &up.reason)]);
        let mut samples: Vec<Sample> = down.samples.into_iter().rev().chain(start).chain(up.samples).collect();
        let last = samples.len() - 1;
        for end in [0, last] {
            samples[end].mark.get_or_insert((Kind::EP, None));
        }
        self.store(&mut branch, &samples);
        Ok(Outcome { branch, status, reason, seconds: 0.0, counts: *counts })
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
        let mut pending: Vec<Reached> = Vec::new();
        loop {
            let end: Option<(Status, String)>;
            if self.watch.stopped() {
                end = Some((Status::Interrupted, Stop::Interrupted.to_string()));
            } else if samples.len() + pending.len() >= most {
                end = Some((Status::Done, Stop::MaxPoints.to_string()));
            } else {
                match walk.step() {
                    Ok(step) => {
                        let mut segment = HopfSegment { curve: walk.system.clone(), from: step.from, to: step.to };
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

    fn progress(&self, segment: &HopfSegment, point: &Point) {
        let (z, c) = (point.lambda, segment.curve.second);
        let (low, high) = (c.of(self.task.along.range.from), c.of(self.task.along.range.to));
        let Ok(mut covered) = self.covered.lock() else { return };
        *covered = (covered.0.min(z), covered.1.max(z));
        self.watch.at((covered.1 - covered.0) / (high - low), format!("{} = {:.6}", self.task.along.free, c.value(z)));
    }

    /// What ends the curve within a step: a Bogdanov-Takens point, a bound of the first parameter.
    fn endings(&self, segment: &HopfSegment, bounds: Option<(f64, f64)>) -> Vec<(Test, Kind, String)> {
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
}
