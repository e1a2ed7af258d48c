//! A task of kind `branch-point-curve`: branch points in two parameters, with what keeps the branches apart where they do
//! not cross.

use super::locus::{Described, Followed, Following, LocusError, Mark, empty as branch, observables, parameters};
use super::locus::{special, steady_arrays};
use super::outcome::Outcome;
use super::start::{coordinates, equilibrium};
use super::study::Prepared;
use super::watch::Watch;
use crate::bifurcation::{BranchCurve, Segment};
use crate::branch::{Branch, BranchKind, Kind, Row, SpecialPoint};
use crate::continuation::{Counts, Point};
use crate::problem::{At, Problem};
use crate::scene;

/// Columns besides the parameters and observables: see [`BranchCurve::imperfection`].
pub const VALUES: [&str; 1] = ["imperfection"];

struct BranchPoints<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Curve,
}

pub fn run(prepared: &Prepared, name: &str, task: &scene::Curve, from: &SpecialPoint, watch: &Watch) -> Outcome {
    let what = BranchPoints { prepared, task };
    Following { prepared, task, watch, what }.run(empty(prepared, name, task), from)
}

pub fn empty(prepared: &Prepared, name: &str, task: &scene::Curve) -> Branch {
    let own = [(VALUES[0].to_owned(), String::new())].into_iter().chain(observables(prepared));
    branch(prepared, name, (BranchKind::BranchPointCurve, task), own.collect())
}

impl Followed for BranchPoints<'_> {
    type System = BranchCurve;
    type Memory = ();
    const LARGEST_STEP: f64 = 0.02;

    fn begin(&self, from: &SpecialPoint, counts: &mut Counts) -> Result<(BranchCurve, Point), LocusError> {
        let along = &self.task.along;
        let (u, p) = equilibrium(self.prepared, from).ok_or_else(|| LocusError::Incomplete(from.label.clone()))?;
        let coordinates = coordinates(self.prepared, along, &p)?;
        let (first, second) = (along.others[0].name.clone(), along.free.clone());
        let free = from.arrays.get("free").and_then(|free| free.data.first());
        let axes = [coordinates.0.index, coordinates.1.index];
        let Some(free) = axes.into_iter().find(|&index| free == Some(&(index as f64))) else {
            return Err(LocusError::Elsewhere { label: from.label.clone(), first, second });
        };
        let started = BranchCurve::start(self.prepared.problem.clone(), (&u, &p), coordinates, free, counts);
        started.map_err(|failure| LocusError::NoCurve { what: "a branch point", first, second, failure })
    }

    fn tests(&self, (): &(), (): &(), _: &BranchCurve) -> Vec<(Kind, (usize, f64))> {
        Vec::new()
    }

    fn describe(
        &self,
        step: &Segment<BranchCurve>,
        point: &Point,
        _: Mark<BranchCurve>,
        _: &mut Counts,
    ) -> Described<()> {
        let problem = &*self.prepared.problem;
        let p = problem.resolve(&step.curve.parameters(point));
        let u = &point.x[..problem.dim()];
        let rest = vec![0.0; u.len()];
        let mut values = parameters(self.prepared, self.task, &p);
        values.push(Some(step.curve.imperfection(point)));
        let observe =
            |&i: &usize| Some(problem.observe(i, At { u, v: &rest, p: &p })).filter(|value| value.is_finite());
        values.extend(self.prepared.observables.iter().map(observe));
        let row = Row { label: None, stable: None, values };
        let columns = empty(self.prepared, "", self.task).columns;
        let special = special(self.prepared, &columns, &row, &p, steady_arrays(point, u.len(), &p));
        Described { row, special, memory: () }
    }
}
