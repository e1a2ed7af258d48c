//! Bifurcations along a branch of cycles: which are wanted, where they are, what is known of them.

use super::super::equilibria::error;
use super::Cycles;
use super::quantities::measure;
use super::refinement::Fine;
use crate::bifurcation::Fold;
use crate::branch::Kind;
use crate::continuation::{Border, Counts, Point, System, correct, inner};
use crate::linalg::c64;
use crate::orbit::bifurcations::{
    BranchPoint, Critical, CriticalCycle, CycleNormalForm, Event, Homoclinic, Located, Passed, Segment, Signs,
};
use crate::orbit::{Collocation, Orbit};
use crate::problem::Problem;

/// Numbers of bifurcations of cycles, besides those that all cycles have.
pub const VALUES: [&str; 9] = ["lpc_b", "pd_c", "bpc_c", "ns_d", "theta", "homoclinic", "snic", "rate", "rotation"];

/// What is known of a special point apart from its orbit.
#[derive(Default)]
pub struct Special {
    pub values: Vec<(&'static str, f64)>,
    /// By column or name; those of columns replace what the orbit alone would say.
    pub errors: Vec<(String, f64)>,
    /// cos of the critical multiplier's angle over the computed part.
    pub cosine: Option<f64>,
}

/// A point between two accepted ones.
pub struct Between {
    pub fraction: f64,
    pub point: Point,
    pub factors: Option<std::sync::Arc<crate::orbit::OrbitFactors>>,
    pub kind: Kind,
    pub special: Special,
}

/// Multipliers are lost where the trivial one is off by this.
const LOST: f64 = 0.5;

impl Cycles<'_> {
    /// What to look for along the branch; on half a period a multiplier -1 breaks the symmetry.
    pub fn wanted(&self, parts: usize) -> Vec<Event> {
        let asked = |kind: &str| self.task.detect.iter().any(|known| known == kind);
        let mut wanted = Vec::new();
        wanted.extend(asked("LPC").then_some(Event::Fold));
        wanted.extend(asked("BPC").then_some(Event::Branch));
        wanted.extend(asked(if parts == 2 { "BPC" } else { "PD" }).then_some(Event::Flip));
        wanted.extend(asked("NS").then_some(Event::Torus));
        wanted
    }

    /// All that happens in a step.
    pub fn bifurcations(&self, segment: &Segment, wanted: &[Event], counts: &mut Counts) -> Vec<Between> {
        let [from, to] = segment.signs;
        let mut found = Vec::new();
        for event in from.events(to, wanted) {
            // A search that fails leaves a gap in what was found, not in the branch.
            let Ok(Some(located)) = segment.locate(event, counts) else { continue };
            // Factors are for multipliers only; at a branch point they may be singular.
            let factors = located.corrected(segment, counts).ok().map(|corrected| corrected.factors.into());
            let mut special = self.describe(segment.system, &located, counts);
            if !segment.system.reference().drift.is_empty() && self.task.along.errors {
                special.errors = self.moved(segment, &located, counts).unwrap_or_default();
            }
            let (fraction, point) = (located.fraction, located.point);
            let kind = match event {
                Event::Fold => Kind::LPC,
                Event::Torus => Kind::NS,
                Event::Flip if segment.system.frame.parts == 1 => Kind::PD,
                Event::Flip | Event::Branch => Kind::BPC,
            };
            found.push(Between { fraction, point, factors, kind, special });
        }
        found
    }

    /// Normal form, angle, and errors from a finer discretisation on which the same point is solved for.
    fn describe(&self, system: &Collocation, located: &Located, counts: &mut Counts) -> Special {
        let mut special = Special::default();
        let names = &self.branch.columns;
        let own = self.columns(system, &system.orbit(&located.point.x), located.point.lambda);
        if let Some((cycle, x)) = &located.critical {
            special.cosine = cycle.cosine(x).or((cycle.kind == Critical::Flip).then_some(-1.0));
            special.values = values(cycle, x);
            let fine = self.task.along.errors.then(|| self.finer(cycle, x, counts)).flatten();
            if let Some((fine, y)) = fine {
                let lambda = fine.parameters(&y)[system.frame.free];
                let columns = self.columns(&fine.system, &fine.orbit(&y), lambda);
                let named = names.iter().map(|column| column.name.clone());
                special.errors = errors(named, &own, &columns);
                let pairs = special.values.iter().zip(values(&fine, &y));
                special
                    .errors
                    .extend(pairs.filter_map(|((name, a), (_, b))| Some(((*name).to_owned(), error(*a, b)?))));
            }
        }
        special.values.extend(located.pair.map(|(re, im)| ("theta", angle(re / re.hypot(im), system.frame.parts))));
        if located.branch.is_some() && self.task.along.errors {
            let fine = self.finer_point(system, &located.point);
            let fine = fine.and_then(|(fine, near)| Some((BranchPoint::solve(&fine, &near, counts).ok()?.point, fine)));
            if let Some((point, system)) = fine {
                let columns = self.columns(&system, &system.orbit(&point.x), point.lambda);
                let named = names.iter().map(|column| column.name.clone());
                special.errors = errors(named, &own, &columns);
            }
        }
        special
    }

    /// Errors of a point of a relative branch: the same test between the same points on a finer discretisation.
    fn moved(&self, segment: &Segment, located: &Located, counts: &mut Counts) -> Option<Vec<(String, f64)>> {
        let (fine, from) = self.finer_point(segment.system, segment.from)?;
        let (_, to) = self.finer_point(segment.system, segment.to)?;
        let gap: Vec<f64> = from.x.iter().zip(&to.x).map(|(a, b)| b - a).collect();
        let ahead = to.lambda - from.lambda;
        let length = inner(&fine, (&gap, ahead), (&gap, ahead)).sqrt();
        let row = fine.dual(&gap).iter().map(|entry| entry / length).collect();
        let border = Border { row, lambda: fine.dual_lambda() * ahead / length };
        let mut end = |point: Point| {
            let found = correct(&fine, (point.x, point.lambda), &border, counts).ok()?;
            let signs = Signs::new(&found.point, &found.factors, &[located.event]).ok()?;
            Some((found.point, signs))
        };
        let ((from, a), (to, b)) = (end(from)?, end(to)?);
        let segment_there = Segment { system: &fine, from: &from, to: &to, signs: [&a, &b], width: segment.width };
        let there = segment_there.locate(located.event, counts).ok()??;
        let values = |system: &Collocation, at: &Located| {
            let mut values = self.columns(system, &system.orbit(&at.point.x), at.point.lambda);
            values.extend(at.pair.map(|(re, im)| angle(re / re.hypot(im), system.frame.parts)));
            values
        };
        let (here, there) = (values(segment.system, located), values(&fine, &there));
        let measured =
            self.columns(segment.system, &segment.system.orbit(&located.point.x), located.point.lambda).len();
        let names = self.branch.columns.iter().take(measured).map(|column| column.name.clone());
        let names = names.chain(["theta".to_owned()]);
        Some(errors(names, &here, &there))
    }

    /// The free parameter and what is measured.
    fn columns(&self, system: &Collocation, orbit: &Orbit, lambda: f64) -> Vec<f64> {
        let frame = &system.frame;
        let mut values = vec![lambda];
        let p = system.parameters(lambda);
        values.extend(measure(self.prepared, &*frame.problem, orbit, &frame.symmetry, &p));
        values
    }

    fn finer(&self, cycle: &CriticalCycle, x: &[f64], counts: &mut Counts) -> Option<(CriticalCycle, Vec<f64>)> {
        let (fine, start) = cycle.refined(x, self.prepared.problem.refined().as_ref())?;
        let solution = fine.solve(start, counts).ok()?;
        Some((fine, solution))
    }

    /// A point of the branch on the finer discretisation, not yet a solution there.
    fn finer_point(&self, system: &Collocation, point: &Point) -> Option<(Collocation, Point)> {
        let finer = self.prepared.problem.refined();
        let on_finer = |x: &[f64]| Fine::new(finer.as_ref(), &system.frame, &system.orbit(x));
        let (Fine { system: fine, x }, Fine { x: tangent, .. }) = (on_finer(&point.x)?, on_finer(&point.tangent)?);
        Some((fine, Point { x, tangent, ..point.clone() }))
    }

    /// The end at an orbit of infinite period: where that is, and the rate at which it is come to. At a saddle-node both
    /// follow from a fold of equilibria; else the error is that of the extrapolation, and by how much lambda at the last period
    /// differs on a finer discretisation.
    pub fn end(&self, system: &Collocation, point: &Point, end: &Homoclinic, counts: &mut Counts) -> Special {
        if let Passed::SaddleNode(fold) = &end.passed {
            let finer = self.task.along.errors.then(|| self.finer_fold(fold, system.frame.free));
            let errors = finer.flatten().map(|finer| ("snic".to_owned(), (finer - end.lambda).abs().max(end.error)));
            return Special { values: vec![("snic", end.lambda)], errors: errors.into_iter().collect(), cosine: None };
        }
        let finer = self.task.along.errors.then(|| self.finer_point(system, point)).flatten();
        let moved = finer.and_then(|(fine, near)| {
            let mut border = Border { row: vec![0.0; near.x.len()], lambda: 0.0 };
            *border.row.last_mut()? = 1.0 / fine.frame.scale_part;
            let found = correct(&fine, (near.x, near.lambda), &border, counts).ok()?.point;
            error(point.lambda, found.lambda)
        });
        let mut values = vec![("homoclinic", end.lambda)];
        match end.passed {
            Passed::Saddle { rate, .. } => values.push(("rate", rate)),
            Passed::Focus { rate, omega } => values.extend([("rate", rate), ("rotation", omega)]),
            Passed::SaddleNode(_) => {}
        }
        let errors = moved.map(|moved| ("homoclinic".to_owned(), end.error.max(moved)));
        Special { values, errors: errors.into_iter().collect(), cosine: None }
    }

    /// Where a fold of equilibria is on a finer discretisation; where there is none it is where it was.
    fn finer_fold(&self, fold: &Fold, free: usize) -> Option<f64> {
        let Some(finer) = self.prepared.problem.refined() else { return Some(fold.p[free]) };
        let start = ((finer.prolong)(&fold.u), (finer.prolong)(&fold.q));
        let range = &self.task.along.range;
        let place = (free, range.to - range.from);
        Some(Fold::locate(&*finer.problem, (&start.0, &fold.p), place, &start.1).ok()?.p[free])
    }

    /// Test functions at a point of the walk; None where they do not exist or nothing is wanted, and where multipliers are
    /// computed but lost to rounding: where an orbit expands and contracts by more than there are digits, as canards do.
    pub fn signs(
        &self,
        point: &Point,
        factors: &crate::orbit::OrbitFactors,
        wanted: &[Event],
        counts: &mut Counts,
    ) -> Option<Signs> {
        if wanted.is_empty() {
            return None;
        }
        if self.task.multipliers > 0 && !factors.multipliers(Some(1)).is_ok_and(|found| found.trivial_error < LOST) {
            return None;
        }
        counts.spectra += usize::from(wanted.iter().any(|event| *event != Event::Fold));
        Signs::new(point, factors, wanted).ok()
    }
}

/// Errors by name, where they are known, of numbers here and on a finer discretisation.
fn errors(names: impl Iterator<Item = String>, here: &[f64], there: &[f64]) -> Vec<(String, f64)> {
    let known = here.iter().zip(there).map(|(a, b)| error(*a, *b));
    names.zip(known).filter_map(|(name, error)| Some((name, error?))).collect()
}

/// How a branch ends at an orbit of infinite period.
pub fn endless(name: &str, end: &Homoclinic) -> String {
    let at = end.lambda;
    match &end.passed {
        Passed::Saddle { rate, own, saddles } => {
            let whose = if *saddles > 1 {
                format!("that of the {saddles} saddles")
            } else {
                "the equilibrium's own".to_owned()
            };
            let own = own.map_or(String::new(), |own| format!("; {whose} is {own:.6}"));
            format!(
                "the period grows without bound: there is a homoclinic or heteroclinic orbit at {name} = {at}, which it grows \
                 to as -ln|{name} - {at:.6}| over {rate:.6}{own}"
            )
        }
        Passed::Focus { rate, omega } => format!(
            "the period grows without bound: {name} turns to and fro around a homoclinic or heteroclinic orbit of a \
             saddle-focus at {name} = {at}, as its eigenvalue ±{rate:.6} ± {omega:.6} i has it"
        ),
        Passed::SaddleNode(_) => format!(
            "the period grows without bound, as |{name} - {at:.6}|^(-1/2): there is a saddle-node on the invariant circle \
             (SNIC) at {name} = {at}"
        ),
    }
}

/// The coefficient of the normal form, and the angle of a critical pair over the whole period.
fn values(cycle: &CriticalCycle, x: &[f64]) -> Vec<(&'static str, f64)> {
    let parts = cycle.system.frame.parts;
    let name = match cycle.kind {
        Critical::Fold => "lpc_b",
        Critical::Flip if parts == 1 => "pd_c",
        Critical::Flip => "bpc_c",
        Critical::Torus => "ns_d",
    };
    let form = CycleNormalForm::new(cycle, x).ok();
    let mut values: Vec<(&'static str, f64)> = Vec::new();
    values.extend(form.map(|form| (name, form.coefficient.re)).filter(|(_, value)| value.is_finite()));
    values.extend(cycle.cosine(x).map(|c| ("theta", angle(c, parts))));
    values
}

/// The angle of exp(i theta parts) in [0, pi], from cos(theta) over the computed part.
pub fn angle(cosine: f64, parts: usize) -> f64 {
    let cosine = cosine.clamp(-1.0, 1.0);
    c64::from_polar(1.0, cosine.acos() * parts as f64).arg().abs()
}
