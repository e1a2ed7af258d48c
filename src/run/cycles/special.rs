//! Bifurcations along a branch of cycles: which are wanted, where they are, what is known of them.

use super::super::equilibria::error;
use super::Cycles;
use super::quantities::measure;
use crate::branch::Kind;
use crate::continuation::{Border, Counts, Point, correct};
use crate::linalg::c64;
use crate::orbit::bifurcations::{
    BranchPoint, Critical, CriticalCycle, CycleNormalForm, Event, Homoclinic, Located, Segment, Signs,
};
use crate::orbit::{Collocation, Frame, Orbit};
use crate::problem::{Problem, Reflection};

/// Numbers of bifurcations of cycles, besides those that all cycles have.
pub const VALUES: [&str; 6] = ["lpc_b", "pd_c", "bpc_c", "ns_d", "theta", "homoclinic"];

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
            let special = self.describe(segment.system, &located, counts);
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
                special.errors = named.zip(own.iter().zip(&columns).map(|(a, b)| error(*a, *b))).collect();
                let pairs = special.values.iter().zip(values(&fine, &y));
                special.errors.extend(pairs.map(|((name, a), (_, b))| ((*name).to_owned(), error(*a, b))));
            }
        }
        if located.branch.is_some() && self.task.along.errors {
            let fine = self.finer_point(system, &located.point);
            let fine = fine.and_then(|(fine, near)| Some((BranchPoint::solve(&fine, &near, counts).ok()?.point, fine)));
            if let Some((point, system)) = fine {
                let columns = self.columns(&system, &system.orbit(&point.x), point.lambda);
                let named = names.iter().map(|column| column.name.clone());
                special.errors = named.zip(own.iter().zip(&columns).map(|(a, b)| error(*a, *b))).collect();
            }
        }
        special
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
        let refinement = self.prepared.problem.refined();
        let finer = match &refinement {
            Some(finer) => {
                let symmetry = reflection(&cycle.system.frame, &*finer.problem)?;
                Some((finer.problem.clone(), &finer.prolong, symmetry))
            }
            None => None,
        };
        let (fine, start) = cycle.refined(x, finer);
        let solution = fine.solve(start, counts).ok()?;
        Some((fine, solution))
    }

    /// A point of the branch on a finer discretisation, in space where there is one and in time by a degree more; not
    /// yet a solution there.
    fn finer_point(&self, system: &Collocation, point: &Point) -> Option<(Collocation, Point)> {
        let refinement = self.prepared.problem.refined();
        let mut frame = system.frame.clone();
        let finer = |x: &[f64]| {
            let orbit = system.orbit(x);
            let mapped = refinement.as_ref().map_or_else(|| orbit.clone(), |finer| orbit.mapped(&*finer.prolong));
            mapped.interpolated(&orbit.mesh, orbit.degree + 1)
        };
        if let Some(finer) = &refinement {
            frame.symmetry = reflection(&frame, &*finer.problem)?;
            frame.problem = finer.problem.clone();
        }
        let (orbit, tangent) = (finer(&point.x), finer(&point.tangent));
        let (x, tangent) = (Collocation::unknowns(&orbit), Collocation::unknowns(&tangent));
        Some((Collocation::new(frame, &orbit), Point { x, tangent, ..point.clone() }))
    }

    /// The end at a homoclinic orbit. Its error is that of the extrapolation, and by how much lambda at the last period
    /// differs on a finer discretisation.
    pub fn end(&self, system: &Collocation, point: &Point, end: &Homoclinic, counts: &mut Counts) -> Special {
        let finer = self.task.along.errors.then(|| self.finer_point(system, point)).flatten();
        let moved = finer.and_then(|(fine, near)| {
            let mut border = Border { row: vec![0.0; near.x.len()], lambda: 0.0 };
            *border.row.last_mut()? = 1.0 / fine.frame.scale_part;
            let found = correct(&fine, (near.x, near.lambda), &border, counts).ok()?.point;
            Some((found.lambda - point.lambda).abs())
        });
        let values = vec![("homoclinic", end.lambda)];
        let errors = moved.map(|moved| ("homoclinic".to_owned(), end.error.max(moved)));
        Special { values, errors: errors.into_iter().collect(), cosine: None }
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

fn reflection(frame: &Frame, problem: &dyn Problem) -> Option<Reflection> {
    if frame.parts == 2 { problem.reflection() } else { Some(Reflection::identity(problem.dim())) }
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
