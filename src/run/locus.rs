//! Curves of special points in two parameters: one walk, both ways from the start, with wanted values and points of
//! codimension two. What is followed, and what its rows hold, is a [`Followed`].

use super::outcome::{Outcome, Status, joined, labels};
use super::start::StartError;
use super::study::Prepared;
use super::watch::Watch;
use crate::bifurcation::{Locus, Segment, reverse};
use crate::branch::{Array, Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use crate::continuation::{Counts, Failure, Point, StepControl, Stop, Walk};
use crate::problem::Problem;
use crate::scene;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::time::Instant;
use thiserror::Error;

#[derive(Debug, Error)]
pub enum LocusError {
    #[error(transparent)]
    Numerics(#[from] Failure),
    #[error(transparent)]
    Place(#[from] StartError),
    #[error("{0} is not stored with all that a start needs")]
    Incomplete(String),
    #[error("the start is not {what} that moves with {first} or {second}: {failure}")]
    NoCurve { what: &'static str, first: String, second: String, failure: Failure },
    #[error(
        "{label} is not a branch point of branches in {first} or {second}; give one of the two as \"free\" where it is found"
    )]
    Elsewhere { label: String, first: String, second: String },
    #[error(
        "{0} breaks no symmetry over half a period: branch points of other cycles need both parameters, and are no curve; \
         where the model has a symmetry, compute the cycles with symmetry = \"auto\""
    )]
    Unbroken(String),
}

/// Arclength is counted in parts of the ranges, and of the orbit.
const FIRST_STEP: f64 = 0.005;
const LEAST_STEP: f64 = 1e-7;

/// What a point is, and the test that found it.
pub type Mark<L> = Option<(Kind, Option<<L as Locus>::Test>)>;

/// What is known of a point.
pub struct Described<M> {
    pub row: Row,
    /// Without a label yet.
    pub special: SpecialPoint,
    /// What the tests of the next step need.
    pub memory: M,
}

/// A kind of points that is followed.
pub trait Followed {
    type System: Locus;
    type Memory;

    const LARGEST_STEP: f64;

    /// The system and a first point.
    fn begin(&self, from: &SpecialPoint, counts: &mut Counts) -> Result<(Self::System, Point), LocusError>;

    /// What ends the curve within a step, apart from its ranges.
    fn endings(&self) -> Vec<(<Self::System as Locus>::Test, Kind, &'static str)> {
        Vec::new()
    }

    /// What is looked for in a step, besides values.
    fn tests(
        &self,
        from: &Self::Memory,
        to: &Self::Memory,
        system: &Self::System,
    ) -> Vec<(Kind, <Self::System as Locus>::Test)>;

    /// Row and special point of a point of a step.
    fn describe(
        &self,
        step: &Segment<Self::System>,
        point: &Point,
        mark: Mark<Self::System>,
        counts: &mut Counts,
    ) -> Described<Self::Memory>;
}

/// A task of following.
pub struct Following<'a, F> {
    pub prepared: &'a Prepared,
    pub task: &'a scene::Curve,
    pub watch: &'a Watch,
    pub what: F,
}

/// A branch without rows: the two parameters, their logarithms, and a kind's own columns.
pub fn empty(
    prepared: &Prepared,
    name: &str,
    (kind, task): (BranchKind, &scene::Curve),
    own: Vec<(String, String)>,
) -> Branch {
    let list = prepared.problem.parameters();
    let free = [prepared.first(), prepared.free].map(|i| &list[i]);
    let mut columns: Vec<(String, String)> = free.iter().map(|q| (q.name.to_owned(), q.unit.to_owned())).collect();
    columns.extend(task.along.logarithmic.iter().map(|name| (format!("log10 {name}"), String::new())));
    columns.extend(own);
    Branch::new(
        name,
        kind,
        free.iter().map(|q| q.name.to_owned()).collect(),
        columns.into_iter().map(|(name, unit)| Column { name, unit }).collect(),
    )
}

/// Tests for the values that a task wants of its two parameters.
pub fn wanted<L: Locus>(prepared: &Prepared, along: &scene::Along, curve: &L) -> Vec<(Kind, L::Test)> {
    let mut tests = Vec::new();
    for (k, coordinate) in curve.axes().into_iter().enumerate() {
        let name = prepared.problem.parameters()[coordinate.index].name;
        let values = along.values.get(name).into_iter().flatten();
        tests.extend(values.map(|&value| (Kind::UZ, L::taking(k, coordinate.of(value)))));
    }
    tests
}

/// What the start of a curve is: a wanted value, or nothing special. Steps look for what they come to, not where they begin.
pub fn start_mark<L: Locus>(prepared: &Prepared, along: &scene::Along, start: &Segment<L>) -> Mark<L> {
    let taken = |test: L::Test| start.value(test, &start.from) == 0.0;
    wanted(prepared, along, &start.curve)
        .into_iter()
        .find(|(_, test)| taken(*test))
        .map(|(kind, test)| (kind, Some(test)))
}

/// Observables of states as columns.
pub fn observables(prepared: &Prepared) -> impl Iterator<Item = (String, String)> {
    let list = prepared.problem.observables();
    prepared.observables.iter().map(|&i| (list[i].name.to_owned(), list[i].unit.to_owned()))
}

/// The first entries of a row: both parameters, and the logarithms that are followed.
pub fn parameters(prepared: &Prepared, task: &scene::Curve, p: &[f64]) -> Vec<Option<f64>> {
    let list = prepared.problem.parameters();
    let value = |name: &str| list.iter().position(|q| q.name == name).map(|i| p[i]);
    let mut values = vec![Some(p[prepared.first()]), Some(p[prepared.free])];
    values.extend(task.along.logarithmic.iter().map(|name| value(name).map(f64::log10)));
    values
}

/// A special point with all parameters, and those columns of its row that are no parameters or errors.
pub fn special(
    prepared: &Prepared,
    columns: &[Column],
    row: &Row,
    p: &[f64],
    arrays: BTreeMap<String, Array>,
) -> SpecialPoint {
    let mut special = SpecialPoint::new(String::new(), Kind::EP, 0);
    let named = columns.iter().zip(&row.values).filter_map(|(column, value)| Some((&column.name, (*value)?)));
    let list = prepared.problem.parameters();
    for (name, value) in named.filter(|(name, _)| !name.starts_with("log10 ")) {
        match name.strip_prefix("error ") {
            Some(name) => special.errors.insert(name.to_owned(), value),
            None if list.iter().any(|q| q.name == name) => None,
            None => special.values.insert(name.clone(), value),
        };
    }
    special.parameters = list.iter().map(|q| q.name.to_owned()).zip(p.iter().copied()).collect();
    special.arrays = arrays;
    special
}

/// State, tangent and parameters of a steady point.
pub fn steady_arrays(point: &Point, dim: usize, p: &[f64]) -> BTreeMap<String, Array> {
    BTreeMap::from([
        ("state".to_owned(), Array::vector(point.x[..dim].to_vec())),
        ("tangent".to_owned(), Array::vector([&point.tangent[..], &[point.tangent_lambda]].concat())),
        ("parameters".to_owned(), Array::vector(p.to_vec())),
    ])
}

/// A point of the curve.
struct Sample<F: Followed> {
    described: Described<F::Memory>,
    mark: Mark<F::System>,
    coordinates: [f64; 2],
}

/// One way along the curve and why it ended.
struct Way<F: Followed> {
    samples: Vec<Sample<F>>,
    reason: String,
    status: Status,
}

impl<F: Followed> Way<F> {
    fn nowhere(reason: &str, status: Status) -> Self {
        Self { samples: Vec::new(), reason: reason.to_owned(), status }
    }

    /// Adds a point; what an unmarked one before it would be stored with is needed no more.
    fn push(&mut self, sample: Sample<F>) {
        if let Some(last) = self.samples.last_mut().filter(|last| last.mark.is_none()) {
            last.described.special.arrays.clear();
        }
        self.samples.push(sample);
    }
}

impl<F: Followed> Following<'_, F> {
    pub fn run(&self, branch: Branch, from: &SpecialPoint) -> Outcome {
        let start = Instant::now();
        let mut counts = Counts::default();
        let mut outcome = match self.follow(branch.clone(), from, &mut counts) {
            Ok(outcome) => outcome,
            Err(failure) => Outcome::failed(branch, failure.to_string()),
        };
        outcome.seconds = start.elapsed().as_secs_f64();
        outcome.counts = counts;
        outcome
    }

    fn follow(&self, mut branch: Branch, from: &SpecialPoint, counts: &mut Counts) -> Result<Outcome, LocusError> {
        let (curve, point) = self.what.begin(from, counts)?;
        let mut back = point.clone();
        reverse(&mut back);
        let here = Segment { curve: curve.clone(), from: point.clone(), to: point.clone() };
        let start = self.sample(&here, &point, start_mark(self.prepared, &self.task.along, &here), counts);
        let most = self.task.along.max_points.saturating_sub(1).div_ceil(2);
        let down = self.way((curve.clone(), back), &start, most, counts)?;
        let up = if down.reason == Stop::Closed.to_string() || down.status == Status::Interrupted {
            Way::nowhere(&down.reason, down.status)
        } else {
            self.way((curve, point), &start, most, counts)?
        };
        let (status, reason) = joined([(down.status, &down.reason), (up.status, &up.reason)]);
        let mut samples: Vec<Sample<F>> = down.samples.into_iter().rev().chain([start]).chain(up.samples).collect();
        let last = samples.len() - 1;
        for end in [0, last] {
            samples[end].mark.get_or_insert((Kind::EP, None));
        }
        for (row, sample) in samples.into_iter().enumerate() {
            let Described { row: mut values, special, .. } = sample.described;
            if let Some((kind, _)) = sample.mark {
                let (short, label) = labels(&branch, kind);
                branch.points.push(SpecialPoint { label, kind, row, ..special });
                values.label = Some(short);
            }
            branch.rows.push(values);
        }
        Ok(Outcome { branch, status, reason, seconds: 0.0, counts: *counts })
    }

    /// Follows the curve one way from a point, which itself is not among the samples.
    fn way(
        &self,
        (mut curve, start): (F::System, Point),
        first: &Sample<F>,
        most: usize,
        counts: &mut Counts,
    ) -> Result<Way<F>, LocusError> {
        let along = &self.task.along;
        let [one, two] = curve.axes();
        let (low, high) = (two.of(along.range.from), two.of(along.range.to));
        let bounds = along.others.first().and_then(|axis| axis.range.as_ref());
        let bounds = bounds.map(|range| (one.of(range.from), one.of(range.to)));
        let outward = |z: f64, direction: f64, (low, high): (f64, f64)| {
            let slack = 1e-12 * (high - low);
            (z <= low + slack && direction < 0.0) || (z >= high - slack && direction > 0.0)
        };
        let tangent = Point { x: start.tangent.clone(), lambda: start.tangent_lambda, ..start.clone() };
        let (z, direction) = (curve.coordinates(&start), curve.coordinates(&tangent));
        if bounds.is_some_and(|bounds| outward(z[0], direction[0], bounds)) || outward(z[1], direction[1], (low, high))
        {
            return Ok(Way::nowhere(&Stop::RangeEnd.to_string(), Status::Done));
        }
        let control = StepControl { step: FIRST_STEP, least: LEAST_STEP, most: F::LARGEST_STEP };
        let mut walk = Walk::new(&mut curve, start, control, (low, high));
        let mut way = Way::nowhere("", Status::Done);
        (way.status, way.reason) = loop {
            if self.watch.stopped() {
                break (Status::Interrupted, Stop::Interrupted.to_string());
            }
            if way.samples.len() >= most {
                break (Status::Done, Stop::MaxPoints.to_string());
            }
            let step = match walk.step() {
                Ok(step) => step,
                Err(stop) => {
                    if let Some(last) = way.samples.last_mut() {
                        last.mark.get_or_insert((Kind::MX, None));
                    }
                    break (Status::Failed, stop.to_string());
                }
            };
            let mut segment = Segment { curve: walk.system.clone(), from: step.from, to: step.to };
            let end_of_range = (step.stop == Some(Stop::RangeEnd)).then_some(segment.to.lambda);
            let mut mark = end_of_range.map(|z| (Kind::EP, Some(F::System::taking(1, z))));
            let mut stop = step.stop.map(|stop| stop.to_string());
            for (test, kind, reason) in self.endings(&segment, bounds) {
                if let Some(point) = segment.locate(test, counts)? {
                    (segment.to, mark, stop) = (point, Some((kind, Some(test))), Some(reason));
                }
            }
            let z = segment.to.lambda;
            self.watch.at((z - low) / (high - low), format!("{} = {:.6}", along.free, two.value(z)));
            let sample = self.sample(&segment, &segment.to, mark, counts);
            for between in self.between(&segment, way.samples.last().unwrap_or(first), &sample, counts) {
                way.push(between);
            }
            way.push(sample);
            if let Some(reason) = stop {
                break (Status::Done, reason);
            }
        };
        *counts += walk.counts;
        Ok(way)
    }

    /// What ends the curve within a step: its kind's own endings, a bound of the first parameter.
    fn endings(
        &self,
        segment: &Segment<F::System>,
        bounds: Option<(f64, f64)>,
    ) -> Vec<(<F::System as Locus>::Test, Kind, String)> {
        let own = self.what.endings().into_iter().map(|(test, kind, reason)| (test, kind, reason.to_owned()));
        let mut endings: Vec<_> = own.collect();
        if let Some((low, high)) = bounds {
            let z = segment.curve.coordinates(&segment.to)[0];
            let passed = [low, high].into_iter().filter(|&b| (b == low && z <= low) || (b == high && z >= high));
            endings.extend(passed.map(|b| (F::System::taking(0, b), Kind::EP, Stop::RangeEnd.to_string())));
        }
        endings
    }

    fn sample(
        &self,
        segment: &Segment<F::System>,
        point: &Point,
        mark: Mark<F::System>,
        counts: &mut Counts,
    ) -> Sample<F> {
        let described = self.what.describe(segment, point, mark, counts);
        Sample { described, mark, coordinates: segment.curve.coordinates(point) }
    }

    /// Wanted values and points of codimension two within a step, in the order of the curve.
    fn between(
        &self,
        segment: &Segment<F::System>,
        last: &Sample<F>,
        next: &Sample<F>,
        counts: &mut Counts,
    ) -> Vec<Sample<F>> {
        let ended = next.mark.and_then(|(_, test)| test);
        let mut tests = self.what.tests(&last.described.memory, &next.described.memory, &segment.curve);
        tests.extend(wanted(self.prepared, &self.task.along, &segment.curve));
        let found = tests.into_iter().filter(|(_, test)| ended != Some(*test)).filter_map(|(kind, test)| {
            // A search that fails leaves a gap in what was found, not in the curve.
            match segment.locate(test, counts) {
                Ok(point) => Some(self.sample(segment, &point?, Some((kind, Some(test))), counts)),
                Err(failure) => {
                    self.watch.say(undecided(kind, segment, &failure));
                    None
                }
            }
        });
        let mut samples: Vec<Sample<F>> = found.collect();
        samples.sort_by(|x, y| segment.along(x.coordinates).total_cmp(&segment.along(y.coordinates)));
        samples
    }
}

/// That nobody knows whether there is a point of a kind within a step.
pub fn undecided<C: Locus>(kind: Kind, segment: &Segment<C>, reason: &dyn Display) -> String {
    let [one, two] = segment.curve.axes();
    let [from, to] = [&segment.from, &segment.to].map(|point| {
        let [z1, z2] = segment.curve.coordinates(point);
        (one.value(z1), two.value(z2))
    });
    format!("{kind:?} between {from:?} and {to:?}: not decided: {reason}")
}
