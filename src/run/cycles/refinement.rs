//! The same cycle on a finer discretisation, in space where the problem has one and in time by a degree more: what its
//! numbers change by is their error.
//!
//! From the present orbit one Newton step suffices, which leaves the error of the error. Its matrix is the largest that
//! a branch has to factor; neighbouring rows differ little, so that the factors of one row serve for the next ones. There
//! the solution is approached by Anderson's method from the present orbit and the correction that the last row got, until all
//! numbers are sure.

use super::quantities::measure;
use crate::continuation::{Border, Chord, Counts, System};
use crate::orbit::{Collocation, Frame, Orbit, OrbitFactors};
use crate::problem::{self, Problem};
use crate::run::study::Prepared;
use serde::{Deserialize, Serialize};
use std::cell::OnceCell;

/// An error is sure once a step changes it by no more than this part,
const SURE: f64 = 0.1;
/// or its number by no more than rounding does.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// A factorisation costs as much as some ten steps: factors that take so many are not used again,
const TIRED: usize = 4;
/// and so many in vain are the most that is lost.
const MOST_STEPS: usize = 6;

/// The row that factors are from, and what the last row was corrected by.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Place {
    orbit: Orbit,
    lambda: f64,
    correction: Vec<f64>,
}

/// Factors of a refined system, and where they are from.
struct Anchor {
    place: Place,
    factors: OrbitFactors,
}

/// An orbit on the finer discretisation, not yet solved for there.
pub struct Fine {
    pub system: Collocation,
    pub x: Vec<f64>,
}

impl Fine {
    /// None if the finer problem lacks the orbit's symmetry.
    pub fn new(finer: Option<&problem::Refinement>, frame: &Frame, orbit: &Orbit) -> Option<Self> {
        let (frame, finer) = match finer {
            Some(refinement) => (frame.of(&refinement.problem)?, orbit.mapped(&*refinement.prolong)),
            None => (frame.clone(), orbit.clone()),
        };
        let finer = finer.interpolated(&orbit.mesh, orbit.degree + 1);
        Some(Self { x: Collocation::unknowns(&finer), system: Collocation::new(frame, &finer) })
    }

    fn factor(&self, lambda: f64, counts: &mut Counts) -> Option<OrbitFactors> {
        counts.factorisations += 1;
        let border = Border { row: vec![0.0; self.x.len()], lambda: 1.0 };
        self.system.factor(&self.x, lambda, &border).ok()
    }

    fn measure(&self, prepared: &Prepared, x: &[f64], lambda: f64) -> Vec<f64> {
        let Frame { problem, symmetry, .. } = &self.system.frame;
        measure(prepared, &**problem, &self.system.orbit(x), symmetry, &self.system.parameters(lambda))
    }
}

/// Finds rows' numbers on the finer discretisation, one row after the other.
#[derive(Default)]
pub struct Refinement {
    /// The problem's own, made when it is first asked for.
    finer: OnceCell<Option<problem::Refinement>>,
    anchor: Option<Anchor>,
}

impl Refinement {
    /// With the factors of a row that was refined before.
    pub fn at(prepared: &Prepared, frame: &Frame, place: Option<Place>) -> Self {
        let mut refinement = Self::default();
        refinement.anchor = place.and_then(|place| {
            let fine = Fine::new(refinement.finer(prepared), frame, &place.orbit)?;
            let factors = fine.factor(place.lambda, &mut Counts::default())?;
            Some(Anchor { place, factors })
        });
        refinement
    }

    fn finer(&self, prepared: &Prepared) -> Option<&problem::Refinement> {
        self.finer.get_or_init(|| prepared.problem.refined()).as_ref()
    }

    /// Where the present factors are from.
    pub fn place(&self) -> Option<Place> {
        self.anchor.as_ref().map(|anchor| anchor.place.clone())
    }

    /// What an orbit's numbers, `measured`, are on the finer discretisation at the same parameters.
    pub fn refine(
        &mut self,
        prepared: &Prepared,
        (frame, orbit, lambda): (&Frame, &Orbit, f64),
        measured: &[f64],
        counts: &mut Counts,
    ) -> Option<Vec<f64>> {
        let fine = Fine::new(self.finer(prepared), frame, orbit)?;
        if let Some(mut anchor) = self.anchor.take_if(|anchor| anchor.place.orbit.mesh == orbit.mesh)
            && let Some((values, steps)) = approach(prepared, &fine, (&mut anchor, lambda), measured, counts)
        {
            self.anchor = Some(anchor).filter(|_| steps < TIRED);
            return Some(values);
        }
        let factors = fine.factor(lambda, counts)?;
        let mut chord = Chord::new(&fine.system, (fine.x.clone(), lambda), &factors, None);
        chord.advance(counts).ok()?;
        let values = fine.measure(prepared, &chord.x, lambda);
        let place = Place { orbit: orbit.clone(), lambda, correction: difference(&chord.x, &fine.x) };
        self.anchor = Some(Anchor { place, factors });
        Some(values)
    }
}

/// The numbers after as many steps with another row's factors as make them sure, and how many that were.
fn approach(
    prepared: &Prepared,
    fine: &Fine,
    (Anchor { place, factors }, lambda): (&mut Anchor, f64),
    measured: &[f64],
    counts: &mut Counts,
) -> Option<(Vec<f64>, usize)> {
    let start = fine.x.iter().zip(&place.correction).map(|(x, correction)| x + correction).collect();
    let mut chord = Chord::new(&fine.system, (start, lambda), &*factors, None);
    let mut last = fine.measure(prepared, &chord.x, lambda);
    for count in 1..=MOST_STEPS {
        chord.advance(counts).ok()?;
        let values = fine.measure(prepared, &chord.x, lambda);
        let sure = |((value, last), coarse): ((&f64, &f64), &f64)| {
            (value - last).abs() <= (SURE * (value - coarse).abs()).max(ROUNDING * value.abs())
        };
        if values.iter().zip(&last).zip(measured).all(sure) {
            place.correction = difference(&chord.x, &fine.x);
            return Some((values, count));
        }
        last = values;
    }
    None
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
