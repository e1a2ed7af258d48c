//! From accepted orbits to rows and special points: observables, multipliers, errors.

use super::super::equilibria::error;
use super::super::outcome::labels;
use super::super::study::Prepared;
use super::super::wave;
use super::Cycles;
use super::quantities::{self, measure};
use super::refinement::Refinement;
use super::special::Special;
use crate::branch::{Array, Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use crate::continuation::{Counts, Point};
use crate::orbit::{Collocation, Frame, Orbit, OrbitFactors, Stability};
use crate::problem::{Problem, Reflection};
use crate::scene;
use std::collections::BTreeMap;
use std::sync::Arc;

/// An accepted point with what its row is made from.
pub struct Pending {
    pub lambda: f64,
    pub tangent_lambda: f64,
    pub orbit: Orbit,
    pub tangent: Orbit,
    pub frame: Frame,
    /// For multipliers, where they are asked for; gone once the row is made.
    factors: Option<Arc<OrbitFactors>>,
    pub kind: Option<Kind>,
    pub special: Special,
}

impl Pending {
    pub fn new(
        system: &Collocation,
        point: &Point,
        factors: Option<Arc<OrbitFactors>>,
        kind: Option<Kind>,
        special: Special,
    ) -> Self {
        Self {
            lambda: point.lambda,
            tangent_lambda: point.tangent_lambda,
            orbit: system.orbit(&point.x),
            tangent: system.orbit(&point.tangent),
            frame: system.frame.clone(),
            factors,
            kind,
            special,
        }
    }
}

/// A branch without rows: its columns are what the task asks for.
pub fn empty(prepared: &Prepared, name: &str, task: &scene::Cycles) -> Branch {
    let mut columns = vec![(prepared.free_name.clone(), prepared.free_unit.clone())];
    columns.extend(quantities::columns(prepared, drifts(prepared, task)));
    let measured = columns.len();
    if task.multipliers > 0 {
        for k in 1..=task.multipliers.min(prepared.problem.dim().saturating_sub(1 + drifts(prepared, task))) {
            columns.push((format!("mu_{k}_re"), String::new()));
            columns.push((format!("mu_{k}_im"), String::new()));
        }
        columns.push(("trivial_error".to_owned(), String::new()));
    }
    if task.along.errors {
        for k in 1..measured {
            columns.push((format!("error {}", columns[k].0), columns[k].1.clone()));
        }
    }
    columns.extend(task.along.logarithmic.iter().map(|name| (format!("log10 {name}"), String::new())));
    Branch::new(
        name,
        BranchKind::Cycles,
        vec![prepared.free_name.clone()],
        columns.into_iter().map(|(name, unit)| Column { name, unit }).collect(),
    )
}

/// The last entry of a row, where the parameter is logarithmic.
pub fn logarithm(task: &scene::Cycles, lambda: f64) -> Option<Option<f64>> {
    (!task.along.logarithmic.is_empty()).then(|| Some(lambda.log10()))
}

/// Drift velocities of the task's orbits.
fn drifts(prepared: &Prepared, task: &scene::Cycles) -> usize {
    if task.relative { prepared.problem.rotations().len() } else { 0 }
}

/// Makes rows of accepted points; it can do so beside the walk's next step.
pub struct Maker<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Cycles,
    columns: Vec<Column>,
    pub refinement: Refinement,
}

impl<'a> Maker<'a> {
    pub fn new(prepared: &'a Prepared, task: &'a scene::Cycles, columns: Vec<Column>) -> Self {
        Self { prepared, task, columns, refinement: Refinement::default() }
    }

    /// Rows in the order of the branch, and what they took.
    pub fn rows(&mut self, pending: &mut [Pending]) -> (Vec<Row>, Counts) {
        let mut counts = Counts::default();
        (pending.iter_mut().map(|point| self.row(point, &mut counts)).collect(), counts)
    }

    fn row(&mut self, point: &mut Pending, counts: &mut Counts) -> Row {
        let found = point.factors.take().and_then(|factors| factors.multipliers(Some(self.task.multipliers)).ok());
        let Pending { lambda, orbit, frame, .. } = &*point;
        let mut p = frame.p.clone();
        p[frame.free] = *lambda;
        let measured = measure(self.prepared, &*self.prepared.problem, orbit, &frame.symmetry, &p);
        let mut values: Vec<Option<f64>> = vec![Some(*lambda)];
        values.extend(measured.iter().copied().map(Some));
        if self.task.multipliers > 0 {
            for k in 0..self.task.multipliers.min(orbit.dim.saturating_sub(1 + orbit.drift.len())) {
                let mu = found.as_ref().and_then(|m| m.values.get(k));
                values.extend([mu.map(|mu| mu.re), mu.map(|mu| mu.im)]);
            }
            values.push(found.as_ref().map(|m| m.trivial_error));
        }
        if self.task.along.errors {
            let at = (frame, orbit, *lambda);
            let fine = self.refinement.refine(self.prepared, at, &measured, counts);
            let known = |k: usize| {
                let name = &self.columns[k + 1].name;
                point.special.errors.iter().find(|(known, _)| known == name).map(|(_, error)| *error)
            };
            let errors = measured
                .iter()
                .enumerate()
                .map(|(k, &value)| known(k).or(fine.as_ref().and_then(|fine| error(value, fine[k]))));
            values.extend(errors);
        }
        values.extend(logarithm(self.task, *lambda));
        values.iter_mut().for_each(|value| *value = value.filter(|value| value.is_finite()));
        let stable = found.and_then(|found| match found.verdict() {
            Stability::Stable => Some(true),
            Stability::Unstable => Some(false),
            Stability::Undecided => None,
        });
        Row { label: None, stable, values }
    }
}

impl Cycles<'_> {
    /// Period, frequency, drift, extremes: the columns after the parameter.
    pub fn measure(&self, orbit: &Orbit, symmetry: &Reflection, p: &[f64]) -> Vec<f64> {
        measure(self.prepared, &*self.prepared.problem, orbit, symmetry, p)
    }

    /// Turns what is pending into rows and special points.
    pub fn make_rows(&mut self, counts: &mut Counts) {
        let mut pending = std::mem::take(&mut self.pending);
        let (rows, made) = self.maker.rows(&mut pending);
        *counts += made;
        self.append(&pending, rows);
    }

    /// Takes over rows and names those that are special points.
    pub fn append(&mut self, pending: &[Pending], rows: Vec<Row>) {
        for (point, row) in pending.iter().zip(rows) {
            self.branch.rows.push(row);
            if let Some(kind) = point.kind {
                self.name_last_row(point, kind);
            }
        }
    }

    /// Makes the last row a special point.
    pub fn name_last_row(&mut self, point: &Pending, kind: Kind) {
        let Pending { orbit, tangent, frame, .. } = point;
        let mut p = frame.p.clone();
        p[frame.free] = point.lambda;
        let resolved = self.prepared.problem.resolve(&p);
        let row = self.branch.rows.len() - 1;
        let (mut values, mut errors) = (BTreeMap::new(), BTreeMap::new());
        for (column, value) in self.branch.columns.iter().zip(&self.branch.rows[row].values).skip(1) {
            let Some(value) = value.filter(|_| !column.name.starts_with("log10 ")) else { continue };
            match column.name.strip_prefix("error ") {
                Some(name) => errors.insert(name.to_owned(), value),
                None => values.insert(column.name.clone(), value),
            };
        }
        let Special { values: own, errors: sure, cosine } = &point.special;
        values.extend(
            own.iter().filter(|(_, value)| value.is_finite()).map(|(name, value)| ((*name).to_owned(), *value)),
        );
        let sure = sure.iter().filter(|(_, error)| error.is_finite());
        errors.extend(sure.map(|(name, error)| (name.clone(), *error)));
        let nodes =
            |orbit: &Orbit| Array { shape: vec![orbit.nodes.len() / orbit.dim, orbit.dim], data: orbit.nodes.clone() };
        let mut arrays = BTreeMap::from([
            ("state".to_owned(), nodes(orbit)),
            ("tangent".to_owned(), nodes(tangent)),
            ("tangent_part_lambda".to_owned(), Array::vector(vec![tangent.part, point.tangent_lambda])),
            ("mesh".to_owned(), Array::vector(orbit.mesh.clone())),
            ("degree_parts".to_owned(), Array::vector(vec![orbit.degree as f64, orbit.parts as f64])),
            ("part".to_owned(), Array::vector(vec![orbit.part])),
            ("gauss_free".to_owned(), Array::vector(vec![f64::from(u8::from(self.task.gauss)), frame.free as f64])),
            ("parameters".to_owned(), Array::vector(resolved.clone())),
        ]);
        if !orbit.drift.is_empty() {
            arrays.insert("drift".to_owned(), Array::vector(orbit.drift.clone()));
            arrays.insert("tangent_drift".to_owned(), Array::vector(tangent.drift.clone()));
        }
        arrays.extend(cosine.map(|cosine| ("critical".to_owned(), Array::vector(vec![cosine]))));
        let (short, label) = labels(&self.branch, kind);
        let list = self.prepared.problem.parameters();
        let parameters = list.iter().zip(&resolved).map(|(q, &x)| (q.name.to_owned(), x)).collect();
        let mut special = SpecialPoint { label, kind, row, parameters, values, errors, arrays };
        if self.prepared.waves.contains(&special.label) {
            wave::of_orbit(self.prepared, orbit, &frame.symmetry, &p, &mut special);
        }
        self.branch.rows[row].label = Some(short);
        self.branch.points.push(special);
    }
}
