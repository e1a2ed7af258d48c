//! A task of kind `fold-curve`: folds in two parameters, with cusps, Bogdanov-Takens and zero-Hopf points.

use super::locus::{Described, Followed, Following, LocusError, Mark, empty as branch, observables, parameters};
use super::locus::{special, steady_arrays};
use super::outcome::Outcome;
use super::start::{coordinates, equilibrium};
use super::study::Prepared;
use super::watch::Watch;
use crate::bifurcation::{BogdanovTakens, FoldCurve, FoldSegment, FoldTest, HopfSegment, Test, ZeroHopf};
use crate::branch::{Branch, BranchKind, Kind, Row, SpecialPoint};
use crate::continuation::{Counts, Point};
use crate::linalg::c64;
use crate::problem::{At, Problem};
use crate::scene;
use std::f64::consts::PI;

/// Numbers of points besides the parameters, which only points of codimension two have.
pub const VALUES: [&str; 7] = ["omega", "frequency", "bt_a", "bt_b", "zh_s", "zh_theta", "zh_e"];

struct Folds<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Curve,
    watch: &'a Watch,
}

pub fn run(prepared: &Prepared, name: &str, task: &scene::Curve, from: &SpecialPoint, watch: &Watch) -> Outcome {
    let what = Folds { prepared, task, watch };
    Following { prepared, task, watch, what }.run(empty(prepared, name, task), from)
}

pub fn empty(prepared: &Prepared, name: &str, task: &scene::Curve) -> Branch {
    branch(prepared, name, (BranchKind::FoldCurve, task), observables(prepared).collect())
}

impl Followed for Folds<'_> {
    type System = FoldCurve;
    /// The other eigenvalues.
    type Memory = Vec<c64>;
    const LARGEST_STEP: f64 = 0.02;

    fn begin(&self, from: &SpecialPoint, counts: &mut Counts) -> Result<(FoldCurve, Point), LocusError> {
        let along = &self.task.along;
        let (u, p) = equilibrium(self.prepared, from).ok_or_else(|| LocusError::Incomplete(from.label.clone()))?;
        let coordinates = coordinates(self.prepared, along, &p)?;
        let started = FoldCurve::start(self.prepared.problem.clone(), (&u, &p), coordinates, counts);
        started.map_err(|failure| {
            let (first, second) = (along.others[0].name.clone(), along.free.clone());
            LocusError::NoCurve { what: "a fold", first, second, failure }
        })
    }

    fn tests(&self, from: &Vec<c64>, to: &Vec<c64>, _: &FoldCurve) -> Vec<(Kind, FoldTest)> {
        let pairs = HopfSegment::crossing_pairs(from, to);
        if HopfSegment::crossings_missed(from, to, &pairs) {
            self.watch.say("a pair crosses the axis that is too close to others to be told apart".to_owned());
        }
        let pairs = pairs.into_iter().filter_map(|test| match test {
            Test::Pair(from, to) => Some((Kind::ZH, FoldTest::Pair(from, to))),
            _ => None,
        });
        [(Kind::CP, FoldTest::Cusp), (Kind::BT, FoldTest::Takens)].into_iter().chain(pairs).collect()
    }

    fn describe(
        &self,
        step: &FoldSegment,
        point: &Point,
        mark: Mark<FoldCurve>,
        counts: &mut Counts,
    ) -> Described<Vec<c64>> {
        counts.spectra += 1;
        let problem = &*self.prepared.problem;
        let p = problem.resolve(&step.curve.parameters(point));
        let u = &point.x[..problem.dim()];
        let rest = vec![0.0; u.len()];
        let mut values = parameters(self.prepared, self.task, &p);
        let observe =
            |&i: &usize| Some(problem.observe(i, At { u, v: &rest, p: &p })).filter(|value| value.is_finite());
        values.extend(self.prepared.observables.iter().map(observe));
        let row = Row { label: None, stable: None, values };
        let columns = empty(self.prepared, "", self.task).columns;
        let mut special = special(self.prepared, &columns, &row, &p, steady_arrays(point, u.len(), &p));
        let found = match mark.and_then(|(_, test)| test) {
            Some(FoldTest::Takens) => {
                BogdanovTakens::new(problem, u, &p).ok().map(|form| vec![("bt_a", form.a), ("bt_b", form.b)])
            }
            Some(FoldTest::Pair(from, to)) => step.pair(from, to, point).map(|pair| {
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
        Described { row, special, memory: step.curve.others(point, 1.0).unwrap_or_default() }
    }
}
