//! Tasks of kind `lpc-curve`, `pd-curve` and `ns-curve`: folds, period doublings and torus bifurcations of cycles in two
//! parameters, both ways from the start, with their normal forms, points of codimension two and wanted values.

use super::cycles::{self, angle, measure};
use super::outcome::{Outcome, Status, joined, labels};
use super::start::{StartError, coordinates};
use super::stored_cycle::StoredCycle;
use super::study::Prepared;
use super::watch::Watch;
use crate::bifurcation::reverse;
use crate::branch::{Array, Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use crate::continuation::{Counts, Failure, Point, StepControl, Stop, Walk};
use crate::orbit::Collocation;
use crate::orbit::bifurcations::{Critical, CycleCurve, CycleSegment, CycleTest};
use crate::problem::Problem;
use crate::scene;
use std::collections::BTreeMap;
use std::time::Instant;
use thiserror::Error;

#[derive(Debug, Error)]
enum CurveError {
    #[error(transparent)]
    Numerics(#[from] Failure),
    #[error(transparent)]
    Place(#[from] StartError),
    #[error("{0} is not stored with all that a start needs")]
    Incomplete(String),
    #[error("the start does not move with {0} or {1}: {2}")]
    NoCurve(String, String, Failure),
}

/// Arclength is counted in parts of the ranges and of the orbit.
const FIRST_STEP: f64 = 0.005;
const LARGEST_STEP: f64 = 0.05;
const LEAST_STEP: f64 = 1e-7;

/// A point of the curve.
struct Sample {
    row: Row,
    mark: Option<(Kind, Option<CycleTest>)>,
    /// What is stored of it if it is marked.
    special: SpecialPoint,
    coordinates: [f64; 2],
}

/// One way along the curve and why it ended.
struct Way {
    samples: Vec<Sample>,
    reason: String,
    status: Status,
}

struct Tool<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Curve,
    kind: Critical,
    watch: &'a Watch,
}

pub fn run(
    prepared: &Prepared,
    name: &str,
    (task, kind): (&scene::Curve, Critical),
    from: &SpecialPoint,
    watch: &Watch,
) -> Outcome {
    let start = Instant::now();
    let mut counts = Counts::default();
    let branch = empty(prepared, name, (task, kind));
    let mut outcome = match (Tool { prepared, task, kind, watch }).follow(branch.clone(), from, &mut counts) {
        Ok(outcome) => outcome,
        Err(failure) => Outcome::failed(branch, failure.to_string()),
    };
    outcome.seconds = start.elapsed().as_secs_f64();
    outcome.counts = counts;
    outcome
}

/// Numbers of points besides the parameters, the period and observables.
pub fn values(kind: Critical) -> &'static [&'static str] {
    match kind {
        Critical::Fold => &["period", "frequency", "lpc_b"],
        Critical::Flip => &["period", "frequency", "pd_c"],
        Critical::Torus => &["period", "frequency", "ns_d", "theta"],
    }
}

pub fn empty(prepared: &Prepared, name: &str, (task, kind): (&scene::Curve, Critical)) -> Branch {
    let list = prepared.problem.parameters();
    let free = [prepared.first(), prepared.free].map(|i| &list[i]);
    let column = |name: &str, unit: &str| Column { name: name.to_owned(), unit: unit.to_owned() };
    let mut columns: Vec<Column> = free.iter().map(|q| column(q.name, q.unit)).collect();
    columns.extend(task.along.logarithmic.iter().map(|name| column(&format!("log10 {name}"), "")));
    columns.extend(cycles::columns(prepared, 0).iter().map(|(name, unit)| column(name, unit)));
    columns.extend(values(kind)[2..].iter().map(|name| column(name, if *name == "theta" { "rad" } else { "" })));
    Branch {
        name: name.to_owned(),
        kind: match kind {
            Critical::Fold => BranchKind::LpcCurve,
            Critical::Flip => BranchKind::PdCurve,
            Critical::Torus => BranchKind::NsCurve,
        },
        free: free.iter().map(|q| q.name.to_owned()).collect(),
        columns,
        rows: Vec::new(),
        points: Vec::new(),
        triangles: Vec::new(),
    }
}

/// What a zero of a test is called.
fn name(kind: Critical, test: CycleTest) -> Kind {
    match (test, kind) {
        (CycleTest::Value(..), _) => Kind::UZ,
        (CycleTest::Degenerate, Critical::Fold) => Kind::CPC,
        (CycleTest::Degenerate, Critical::Flip) => Kind::GPD,
        (CycleTest::Degenerate, Critical::Torus) => Kind::CH,
        (CycleTest::Double, Critical::Flip) => Kind::R2,
        (CycleTest::Double, _) => Kind::R1,
        (CycleTest::Cosine(c), _) if c > 0.5 => Kind::R1,
        (CycleTest::Cosine(c), _) if c < -0.75 => Kind::R2,
        (CycleTest::Cosine(c), _) if c < -0.25 => Kind::R3,
        (CycleTest::Cosine(_), _) => Kind::R4,
        (CycleTest::Fold, Critical::Torus) | (CycleTest::Torus, Critical::Fold) => Kind::LPNS,
        (CycleTest::Fold | CycleTest::Flip, Critical::Fold | Critical::Flip) => Kind::LPPD,
        (CycleTest::Flip | CycleTest::Torus, _) => Kind::PDNS,
    }
}

impl Tool<'_> {
    fn follow(&self, mut branch: Branch, from: &SpecialPoint, counts: &mut Counts) -> Result<Outcome, CurveError> {
        let along = &self.task.along;
        let incomplete = || CurveError::Incomplete(from.label.clone());
        let stored = StoredCycle::read(self.prepared, from).ok_or_else(incomplete)?;
        let coordinates = coordinates(self.prepared, along, &stored.p)?;
        let frame = stored.frame(self.prepared, along.range.to - along.range.from).ok_or_else(incomplete)?;
        let system = Collocation::new(frame, &stored.orbit);
        let at = (&stored.orbit, &stored.p[..]);
        let started = CycleCurve::start(&system, at, (self.kind, stored.cosine), coordinates, counts);
        let (curve, point) = started
            .map_err(|failure| CurveError::NoCurve(along.others[0].name.clone(), along.free.clone(), failure))?;
        let mut back = point.clone();
        reverse(&mut back);
        let start = self.sample(&curve, &point, None);
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
        for (row, mut sample) in samples.into_iter().enumerate() {
            if let Some((kind, _)) = sample.mark {
                let (short, label) = labels(&branch, kind);
                branch.points.push(SpecialPoint { label, kind, row, ..sample.special });
                sample.row.label = Some(short);
            }
            branch.rows.push(sample.row);
        }
        Ok(Outcome { branch, status, reason, seconds: 0.0, counts: *counts })
    }

    /// Follows the curve one way from a point, which itself is not among the samples.
    fn way(&self, mut curve: CycleCurve, start: Point, most: usize, counts: &mut Counts) -> Result<Way, CurveError> {
        let along = &self.task.along;
        let [first, second] = curve.cycle.coordinates[..] else { return Err(Failure::NotFinite.into()) };
        let (low, high) = (second.of(along.range.from), second.of(along.range.to));
        let bounds = along.others.first().and_then(|axis| axis.range.as_ref());
        let bounds = bounds.map(|range| (first.of(range.from), first.of(range.to)));
        let outward = |z: f64, direction: f64, (low, high): (f64, f64)| {
            let slack = 1e-12 * (high - low);
            (z <= low + slack && direction < 0.0) || (z >= high - slack && direction > 0.0)
        };
        let last = start.x.len() - 1;
        let leaves_first = bounds.is_some_and(|bounds| outward(start.x[last], start.tangent[last], bounds));
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
            let mut segment = CycleSegment { curve: walk.system.clone(), from: step.from, to: step.to };
            let mut mark =
                (step.stop == Some(Stop::RangeEnd)).then_some((Kind::EP, Some(CycleTest::Value(1, segment.to.lambda))));
            let mut stop = step.stop.map(|stop| stop.to_string());
            for (test, kind, reason) in self.endings(&segment, bounds) {
                if let Some(point) = segment.locate(test, counts)? {
                    (segment.to, mark, stop) = (point, Some((kind, Some(test))), Some(reason));
                }
            }
            let fraction = (segment.to.lambda - low) / (high - low);
            self.watch.at(fraction, format!("{} = {:.6}", along.free, second.value(segment.to.lambda)));
            let between = self.between(&segment, mark.and_then(|(_, test)| test), counts);
            samples.extend(between);
            samples.push(self.sample(&segment.curve, &segment.to, mark));
            if let Some(reason) = stop {
                break (Status::Done, reason);
            }
        };
        *counts += walk.counts;
        Ok(Way { samples, reason, status })
    }

    /// What ends the curve within a step: a bound of the first parameter; a torus' angle of 0 or pi.
    fn endings(&self, segment: &CycleSegment, bounds: Option<(f64, f64)>) -> Vec<(CycleTest, Kind, String)> {
        let mut endings = Vec::new();
        if self.kind == Critical::Torus {
            for (cosine, what) in [(1.0, "1:1 (R1)"), (-1.0, "1:2 (R2)")] {
                let test = CycleTest::Cosine(cosine);
                let reason = format!("the torus bifurcation ends at a resonance {what}");
                endings.push((test, name(self.kind, test), reason));
            }
        }
        if let Some((low, high)) = bounds {
            let z = segment.curve.coordinates(&segment.to)[0];
            for bound in [low, high] {
                if (bound == low && z <= low) || (bound == high && z >= high) {
                    endings.push((CycleTest::Value(0, bound), Kind::EP, Stop::RangeEnd.to_string()));
                }
            }
        }
        endings
    }

    /// Wanted values and points of codimension two within a step, in the order of the curve.
    fn between(&self, segment: &CycleSegment, ended: Option<CycleTest>, counts: &mut Counts) -> Vec<Sample> {
        let curve = &segment.curve;
        let mut tests = CycleSegment::tests(self.kind).to_vec();
        for (k, coordinate) in curve.cycle.coordinates.iter().enumerate() {
            let name = self.prepared.problem.parameters()[coordinate.index].name;
            let wanted = self.task.along.values.get(name).into_iter().flatten();
            tests.extend(wanted.map(|&value| CycleTest::Value(k, coordinate.of(value))));
        }
        let found = tests.into_iter().filter(|test| ended != Some(*test)).filter_map(|test| {
            let point = segment.locate(test, counts).ok()??;
            Some(self.sample(curve, &point, Some((name(self.kind, test), Some(test)))))
        });
        let mut samples: Vec<Sample> = found.collect();
        let (a, b) = (curve.coordinates(&segment.from), curve.coordinates(&segment.to));
        let along = |sample: &Sample| -> f64 {
            let part = |k: usize| (sample.coordinates[k] - a[k]) * (b[k] - a[k]);
            (0..2).map(|k| part(k) / curve.cycle.coordinates[k].width.powi(2)).sum()
        };
        samples.sort_by(|x, y| along(x).total_cmp(&along(y)));
        samples
    }

    fn sample(&self, curve: &CycleCurve, point: &Point, mark: Option<(Kind, Option<CycleTest>)>) -> Sample {
        let problem = &*self.prepared.problem;
        let (orbit, frame) = (curve.orbit(point), &curve.cycle.system.frame);
        let p = problem.resolve(&curve.parameters(point));
        let list = problem.parameters();
        let value = |name: &str| list.iter().position(|q| q.name == name).map(|i| p[i]);
        let mut values = vec![Some(p[self.prepared.first()]), Some(p[self.prepared.free])];
        values.extend(self.task.along.logarithmic.iter().map(|name| value(name).map(f64::log10)));
        values.extend(measure(self.prepared, problem, &orbit, &frame.symmetry, &p).into_iter().map(Some));
        let form = curve.normal_form(point).ok().map(|form| form.coefficient.re).filter(|b| b.is_finite());
        values.push(form);
        let cosine = curve.cosine(point);
        values.extend(cosine.map(|c| Some(angle(c, frame.parts))));
        let empty = empty(self.prepared, "", (self.task, self.kind));
        let mut special = SpecialPoint::new(String::new(), Kind::EP, 0);
        let named = empty.columns.iter().zip(&values).skip(2).filter(|(column, _)| !column.name.starts_with("log10 "));
        special.values = named.filter_map(|(column, value)| Some((column.name.clone(), (*value)?))).collect();
        special.parameters = list.iter().map(|q| q.name.to_owned()).zip(p.iter().copied()).collect();
        if mark.is_some() {
            let vector = |data: Vec<f64>| Array { shape: vec![data.len()], data };
            let shape = vec![orbit.nodes.len() / orbit.dim, orbit.dim];
            special.arrays = BTreeMap::from([
                ("state".to_owned(), Array { shape, data: orbit.nodes.clone() }),
                ("mesh".to_owned(), vector(orbit.mesh.clone())),
                ("degree_parts".to_owned(), vector(vec![orbit.degree as f64, orbit.parts as f64])),
                ("part".to_owned(), vector(vec![orbit.part])),
                ("parameters".to_owned(), vector(p)),
            ]);
        }
        // Of folds neither side is stable; of the others those count as stable that give birth to stable solutions.
        let stable = if self.kind == Critical::Fold { None } else { form.map(|c| c < 0.0) };
        let row = Row { label: None, stable, values };
        Sample { row, mark, special, coordinates: curve.coordinates(point) }
    }
}
