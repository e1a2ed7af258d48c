//! Tasks of kind `lpc-curve`, `pd-curve`, `bpc-curve` and `ns-curve`: critical cycles in two parameters, with their normal
//! forms, points of codimension two and errors.

use super::cycles::{angle, columns as measured, measure};
use super::equilibria::error;
use super::locus::{Described, Followed, Following, LocusError, Mark, empty as branch, parameters, special};
use super::outcome::Outcome;
use super::start::coordinates;
use super::stored_cycle::StoredCycle;
use super::study::Prepared;
use super::watch::Watch;
use crate::bifurcation::Locus;
use crate::branch::{Array, Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use crate::continuation::{Counts, Point};
use crate::orbit::bifurcations::{Critical, CriticalCycle, CycleCurve, CycleNormalForm, CycleSegment, CycleTest};
use crate::orbit::{Collocation, Orbit};
use crate::problem::Problem;
use crate::scene::{self, CycleKind};
use std::collections::BTreeMap;

struct Cycles<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Curve,
    kind: CycleKind,
}

/// Which multiplier is on the unit circle, over the computed part of the period.
fn critical(kind: CycleKind) -> Critical {
    match kind {
        CycleKind::Lpc => Critical::Fold,
        CycleKind::Pd | CycleKind::Bpc => Critical::Flip,
        CycleKind::Ns => Critical::Torus,
    }
}

pub fn run(
    prepared: &Prepared,
    name: &str,
    (task, kind): (&scene::Curve, CycleKind),
    from: &SpecialPoint,
    watch: &Watch,
) -> Outcome {
    let what = Cycles { prepared, task, kind };
    Following { prepared, task, watch, what }.run(empty(prepared, name, (task, kind)), from)
}

/// Numbers of points besides the parameters and observables.
pub fn values(kind: CycleKind) -> &'static [&'static str] {
    match kind {
        CycleKind::Lpc => &["period", "frequency", "lpc_b"],
        CycleKind::Pd => &["period", "frequency", "pd_c"],
        CycleKind::Bpc => &["period", "frequency", "bpc_c"],
        CycleKind::Ns => &["period", "frequency", "ns_d", "theta"],
    }
}

pub fn empty(prepared: &Prepared, name: &str, (task, kind): (&scene::Curve, CycleKind)) -> Branch {
    let of = match kind {
        CycleKind::Lpc => BranchKind::LpcCurve,
        CycleKind::Pd => BranchKind::PdCurve,
        CycleKind::Bpc => BranchKind::BpcCurve,
        CycleKind::Ns => BranchKind::NsCurve,
    };
    let mut own = measured(prepared, 0);
    let unit = |name: &str| if name == "theta" { "rad" } else { "" };
    own.extend(values(kind)[2..].iter().map(|name| ((*name).to_owned(), unit(name).to_owned())));
    let mut branch = branch(prepared, name, (of, task), own);
    if task.along.errors {
        let named = branch.columns.iter().filter(|column| !column.name.starts_with("log10 "));
        let errors: Vec<_> = named.map(Column::error).collect();
        branch.columns.extend(errors);
    }
    branch
}

/// What a zero of a test is called. On half-period orbits a multiplier -1 breaks the symmetry.
fn name(kind: Critical, parts: usize, test: CycleTest) -> Kind {
    let breaking = parts == 2;
    match (test, kind) {
        (CycleTest::Value(..), _) => Kind::UZ,
        (CycleTest::Degenerate, Critical::Fold) => Kind::CPC,
        (CycleTest::Degenerate, Critical::Flip) if breaking => Kind::GBPC,
        (CycleTest::Degenerate, Critical::Flip) => Kind::GPD,
        (CycleTest::Degenerate, Critical::Torus) => Kind::CH,
        (CycleTest::Double, Critical::Flip) => Kind::R2,
        (CycleTest::Double, _) => Kind::R1,
        (CycleTest::Cosine(c), _) if c > 0.5 => Kind::R1,
        (CycleTest::Cosine(c), _) if c < -0.75 => Kind::R2,
        (CycleTest::Cosine(c), _) if c < -0.25 => Kind::R3,
        (CycleTest::Cosine(_), _) => Kind::R4,
        (CycleTest::Fold, Critical::Torus) | (CycleTest::Torus, Critical::Fold) => Kind::LPNS,
        (CycleTest::Fold | CycleTest::Flip, Critical::Fold | Critical::Flip) if breaking => Kind::LPBP,
        (CycleTest::Fold | CycleTest::Flip, Critical::Fold | Critical::Flip) => Kind::LPPD,
        (CycleTest::Flip | CycleTest::Torus, _) if breaking => Kind::BPNS,
        (CycleTest::Flip | CycleTest::Torus, _) => Kind::PDNS,
    }
}

impl Followed for Cycles<'_> {
    type System = CycleCurve;
    type Memory = ();
    const LARGEST_STEP: f64 = 0.05;

    fn begin(&self, from: &SpecialPoint, counts: &mut Counts) -> Result<(CycleCurve, Point), LocusError> {
        let along = &self.task.along;
        let incomplete = || LocusError::Incomplete(from.label.clone());
        let stored = StoredCycle::read(self.prepared, from).ok_or_else(incomplete)?;
        if self.kind == CycleKind::Bpc && (stored.orbit.parts != 2 || stored.cosine != -1.0) {
            return Err(LocusError::Unbroken(from.label.clone()));
        }
        let coordinates = coordinates(self.prepared, along, &stored.p)?;
        let frame = stored.frame(self.prepared, along.range.to - along.range.from).ok_or_else(incomplete)?;
        let system = Collocation::new(frame, &stored.orbit);
        let at = (&stored.orbit, &stored.p[..]);
        let started = CycleCurve::start(&system, at, (critical(self.kind), stored.cosine), coordinates, counts);
        started.map_err(|failure| {
            let (first, second) = (along.others[0].name.clone(), along.free.clone());
            LocusError::NoCurve { what: "a critical cycle", first, second, failure }
        })
    }

    /// A torus' angle of 0 or pi.
    fn endings(&self) -> Vec<(CycleTest, Kind, &'static str)> {
        match self.kind {
            CycleKind::Ns => vec![
                (CycleTest::Cosine(1.0), Kind::R1, "the torus bifurcation ends at a resonance 1:1 (R1)"),
                (CycleTest::Cosine(-1.0), Kind::R2, "the torus bifurcation ends at a resonance 1:2 (R2)"),
            ],
            _ => Vec::new(),
        }
    }

    fn tests(&self, (): &(), (): &(), system: &CycleCurve) -> Vec<(Kind, CycleTest)> {
        let (kind, parts) = (system.cycle.kind, system.cycle.system.frame.parts);
        CycleSegment::tests(kind).iter().map(|&test| (name(kind, parts, test), test)).collect()
    }

    fn describe(
        &self,
        step: &CycleSegment,
        point: &Point,
        mark: Mark<CycleCurve>,
        counts: &mut Counts,
    ) -> Described<()> {
        let (problem, curve) = (&*self.prepared.problem, &step.curve);
        let orbit = curve.orbit(point);
        let p = problem.resolve(&curve.parameters(point));
        let mut values = parameters(self.prepared, self.task, &p);
        let form = curve.normal_form(point).ok();
        let own = self.numbers(&curve.cycle, &orbit, &p, form.as_ref(), curve.cosine(point));
        values.extend(&own);
        if self.task.along.errors {
            values.extend(self.errors(step, point, mark, &own, counts));
        }
        // Of folds neither side is stable; of the others those count as stable that give birth to stable solutions.
        let coefficient = own[own.len() - usize::from(self.kind == CycleKind::Ns) - 1];
        let stable = if self.kind == CycleKind::Lpc { None } else { coefficient.map(|c| c < 0.0) };
        let row = Row { label: None, stable, values };
        let shape = vec![orbit.nodes.len() / orbit.dim, orbit.dim];
        let arrays = BTreeMap::from([
            ("mesh".to_owned(), Array::vector(orbit.mesh)),
            ("degree_parts".to_owned(), Array::vector(vec![orbit.degree as f64, orbit.parts as f64])),
            ("part".to_owned(), Array::vector(vec![orbit.part])),
            ("parameters".to_owned(), Array::vector(p.clone())),
            ("state".to_owned(), Array { shape, data: orbit.nodes }),
        ]);
        let columns = empty(self.prepared, "", (self.task, self.kind)).columns;
        let special = special(self.prepared, &columns, &row, &p, arrays);
        Described { row, special, memory: () }
    }
}

impl Cycles<'_> {
    /// The columns after the parameters: what is measured, the normal form's coefficient, the angle.
    fn numbers(
        &self,
        cycle: &CriticalCycle,
        orbit: &Orbit,
        p: &[f64],
        form: Option<&CycleNormalForm>,
        cosine: Option<f64>,
    ) -> Vec<Option<f64>> {
        let frame = &cycle.system.frame;
        let measured = measure(self.prepared, &*frame.problem, orbit, &frame.symmetry, p);
        let mut numbers: Vec<Option<f64>> = measured.into_iter().map(Some).collect();
        numbers.push(form.map(|form| form.coefficient.re).filter(|b| b.is_finite()));
        numbers.extend(cosine.map(|c| Some(angle(c, frame.parts))));
        numbers
    }

    /// Errors of both parameters and of these numbers, from a finer discretisation, in space where the problem has one
    /// and in time by a degree more. Where a test found the point, it is the same test between the same points; elsewhere
    /// the parameter along which the curve runs is held. One Newton step from the present cycle leaves the error of the
    /// error.
    fn errors(
        &self,
        step: &CycleSegment,
        point: &Point,
        mark: Mark<CycleCurve>,
        own: &[Option<f64>],
        counts: &mut Counts,
    ) -> Vec<Option<f64>> {
        let refinement = self.prepared.problem.refined();
        let refinement = refinement.as_ref();
        let test = mark.and_then(|(_, test)| test);
        let held = match test {
            Some(CycleTest::Value(k, _)) => Some(k),
            Some(_) => None,
            None => {
                let tangent = Point { x: point.tangent.clone(), lambda: point.tangent_lambda, ..point.clone() };
                let (slopes, axes) = (step.curve.coordinates(&tangent), step.curve.axes());
                Some(usize::from((slopes[1] / axes[1].width).abs() >= (slopes[0] / axes[0].width).abs()))
            }
        };
        let found = match (held, test) {
            (None, Some(test)) => step.refined(refinement, counts).and_then(|fine| {
                let point = fine.locate(test, counts).ok()??;
                Some((fine.curve.cycle.clone(), CycleCurve::unknowns(&point)))
            }),
            (held, _) => step.curve.finer(point, held.unwrap_or(1), refinement, counts),
        };
        let Some((fine, x)) = found else { return vec![None; 2 + own.len()] };
        let p = self.prepared.problem.resolve(&fine.parameters(&x));
        let form = CycleNormalForm::new(&fine, &x).ok();
        let there = self.numbers(&fine, &fine.orbit(&x), &p, form.as_ref(), fine.cosine(&x));
        let here = self.prepared.problem.resolve(&step.curve.parameters(point));
        let axes = step.curve.axes().map(|axis| axis.index);
        let of_axis = |k: usize| error(here[axes[k]], p[axes[k]]).filter(|_| held != Some(k));
        let of_numbers = own.iter().zip(&there).map(|(a, b)| error((*a)?, (*b)?));
        [of_axis(0), of_axis(1)].into_iter().chain(of_numbers).collect()
    }
}
