//! From a sign change within one step to the point itself.
//!
//! Regula falsi (Illinois) on the test function brings the point near enough for Newton's method on a regular system:
//! [`CriticalCycle`] for folds, flips and tori, [`BranchPoint`] for branch points. What converges outside the step is
//! somebody else's point, and the bracket shrinks further. On relative periodic orbits regula falsi alone goes on to the end.

use super::{BranchPoint, Critical, CriticalCycle, Event, Signs};
use crate::bifurcation::Coordinate;
use crate::continuation::{Border, Corrected, Counts, Failure, Point, System, at_fraction, inner};
use crate::linalg::Singular;
use crate::orbit::{Collocation, Orbit, OrbitFactors};

/// Steps of regula falsi or halving at most, where nothing else follows, and the value, in parts of those at the ends, at
/// which they stop.
const MOST_NARROWINGS: usize = 40;
const SHARP: f64 = 1e-11;
/// Rounds of bracketing, each followed by an attempt to converge.
const ROUNDS: usize = 8;
/// Steps of regula falsi in a round.
const STEPS: usize = 3;
/// A real pair after so many rounds is a neutral saddle.
const NEUTRAL: usize = 3;
/// Converged points may lie outside the step by this part of it.
const SLACK: f64 = 1e-6;
/// A branch point is where the branch itself turns round if there lambda stands still to this part of its rate at the
/// ends of the step.
const VERTICAL: f64 = 1e-6;
/// Branch points whose unfolding is larger, in units of the state, are where two branches pass each other.
const PERFECT: f64 = 1e-4;

/// A step of the branch, on one mesh, with the test functions at its ends.
pub struct Segment<'a> {
    pub system: &'a Collocation,
    pub from: &'a Point,
    pub to: &'a Point,
    pub signs: [&'a Signs; 2],
    /// Size of the free parameter that counts as one.
    pub width: f64,
}

/// A bifurcation within a step.
pub struct Located {
    pub event: Event,
    /// Place in the step, from 0 to 1.
    pub fraction: f64,
    /// The point with its tangent.
    pub point: Point,
    /// The extended system and its solution, for all but branch points.
    pub critical: Option<(CriticalCycle, Vec<f64>)>,
    pub branch: Option<BranchPoint>,
    /// Real and imaginary part of the critical multiplier, on relative periodic orbits at tori.
    pub pair: Option<(f64, f64)>,
}

/// The part of the step that is left: fractions, and the test's values there.
struct Bracket {
    low: (f64, f64),
    high: (f64, f64),
    /// The point with the smallest value so far.
    best: Point,
    least: f64,
    /// The multiplier that is nearest to critical, where it is a pair.
    pair: Option<(f64, f64)>,
}

impl Segment<'_> {
    fn value(&self, event: Event, corrected: &Corrected<OrbitFactors>) -> Result<(f64, Option<(f64, f64)>), Singular> {
        if event == Event::Fold {
            return Ok((corrected.point.tangent_lambda, None));
        }
        let signs = Signs::new(&corrected.point, &corrected.factors, &[event]).map_err(|_| Singular)?;
        Ok((signs.value(event), signs.pair))
    }

    /// Where an event happens; None for a neutral saddle, for a branch that turns round at a pitchfork, which is no fold,
    /// or if nothing converges within the step.
    pub fn locate(&self, event: Event, counts: &mut Counts) -> Result<Option<Located>, Failure> {
        if event == Event::Fold && self.turns_at_branch_point(counts)? {
            return Ok(None);
        }
        let [a, b] = self.signs.map(|signs| signs.value(event));
        let nearest = if a.abs() < b.abs() { (self.from, a, self.signs[0]) } else { (self.to, b, self.signs[1]) };
        let (best, least, pair) = (nearest.0.clone(), nearest.1.abs(), nearest.2.pair);
        let mut bracket = Bracket { low: (0.0, a), high: (1.0, b), best, least, pair };
        if !self.system.reference().drift.is_empty() {
            return self.sharpen(event, bracket, a.abs().max(b.abs()), counts);
        }
        for round in 0..ROUNDS {
            for _ in 0..STEPS {
                self.narrow(event, &mut bracket, counts)?;
            }
            if event == Event::Torus && bracket.pair.is_none() {
                if round + 1 >= NEUTRAL {
                    return Ok(None);
                }
                continue;
            }
            let Ok(found) = self.converge(event, &bracket, counts) else { continue };
            let inside = (-SLACK..=1.0 + SLACK).contains(&found.fraction);
            if inside && self.beside(&found.point) < 1.0 {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// Whether lambda turns back at a branch point: there the determinant changes its sign too, at a fold it does not.
    fn turns_at_branch_point(&self, counts: &mut Counts) -> Result<bool, Failure> {
        let mut signs = self.signs.map(Clone::clone);
        for (signs, point) in signs.iter_mut().zip([self.from, self.to]) {
            // Folds alone are looked for without determinants.
            if signs.branch == 0.0 {
                let dual = self.system.dual(&point.tangent);
                let border = Border { row: dual, lambda: self.system.dual_lambda() * point.tangent_lambda };
                counts.factorisations += 1;
                counts.spectra += 1;
                let factors = self.system.factor(&point.x, point.lambda, &border)?;
                *signs = Signs::new(point, &factors, &[Event::Branch]).map_err(|_| Singular)?;
            }
        }
        if signs[0].branch * signs[1].branch > 0.0 {
            return Ok(false);
        }
        let found = Segment { signs: [&signs[0], &signs[1]], ..*self }.locate(Event::Branch, counts)?;
        let rate = self.from.tangent_lambda.abs().max(self.to.tangent_lambda.abs());
        Ok(found.is_some_and(|found| found.point.tangent_lambda.abs() <= VERTICAL * rate))
    }

    /// On relative periodic orbits, for which there are no extended systems: regula falsi on the test function alone, whose
    /// multipliers are those without the trivial ones.
    fn sharpen(
        &self,
        event: Event,
        mut bracket: Bracket,
        size: f64,
        counts: &mut Counts,
    ) -> Result<Option<Located>, Failure> {
        for _ in 0..MOST_NARROWINGS {
            self.narrow(event, &mut bracket, counts)?;
            if event != Event::Branch && bracket.least <= SHARP * size {
                break;
            }
        }
        let Bracket { best: point, least, pair, .. } = bracket;
        // At a pole the function is not small; a real pair is a neutral saddle.
        let zero = event == Event::Branch || least <= SHARP.sqrt() * size;
        let found = zero && (event != Event::Torus || pair.is_some());
        let fraction = self.fraction(&point);
        Ok(found.then(|| Located { event, fraction, point, critical: None, branch: None, pair }))
    }

    /// A step of regula falsi; halving where the function is no more than a sign.
    fn narrow(&self, event: Event, bracket: &mut Bracket, counts: &mut Counts) -> Result<(), Failure> {
        let (low, high) = (bracket.low, bracket.high);
        let theta = if event == Event::Branch {
            0.5 * (low.0 + high.0)
        } else {
            (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1)
        };
        if !(theta - low.0).is_normal() || !(high.0 - theta).is_normal() {
            return Ok(());
        }
        let ends = (self.from, self.to);
        let corrected = at_fraction(self.system, ends, theta, counts)?;
        let (here, pair) = self.value(event, &corrected)?;
        if here.abs() <= bracket.least || event == Event::Branch {
            (bracket.least, bracket.best, bracket.pair) = (here.abs(), corrected.point, pair);
        }
        // `high` is the last point, on whichever side; a side that stays is halved (Illinois).
        if here * high.1 < 0.0 {
            bracket.low = high;
        } else {
            bracket.low.1 *= 0.5;
        }
        bracket.high = (theta, here);
        if event == Event::Branch && bracket.low.0 > bracket.high.0 {
            std::mem::swap(&mut bracket.low, &mut bracket.high);
        }
        Ok(())
    }

    fn converge(&self, event: Event, bracket: &Bracket, counts: &mut Counts) -> Result<Located, Failure> {
        let kind = match event {
            Event::Branch => {
                let found = BranchPoint::solve(self.system, &bracket.best, counts)?;
                if found.unfolding.abs() > PERFECT * self.system.frame.scale_state {
                    return Err(Singular.into());
                }
                let (point, fraction) = (found.point.clone(), self.fraction(&found.point));
                return Ok(Located { event, fraction, point, critical: None, branch: Some(found), pair: None });
            }
            Event::Fold => Critical::Fold,
            Event::Flip => Critical::Flip,
            Event::Torus => Critical::Torus,
        };
        let (point, system) = (&bracket.best, self.system);
        let coordinate = Coordinate { index: system.frame.free, logarithmic: false, width: self.width };
        let cosine = bracket.pair.map_or(0.0, |(re, im)| re / re.hypot(im));
        let (orbit, p): (Orbit, Vec<f64>) = (system.orbit(&point.x), system.parameters(point.lambda));
        let (cycle, x) = CriticalCycle::new(system, (&orbit, &p), (kind, cosine), &[coordinate])?;
        let x = cycle.solve(x, counts)?;
        if cycle.cosine(&x).is_some_and(|c| c.abs() >= 1.0) {
            return Err(Singular.into());
        }
        let orbit = cycle.orbit(&x);
        let lambda = cycle.parameters(&x)[coordinate.index];
        let point = Point { x: Collocation::unknowns(&orbit), lambda, ..point.clone() };
        Ok(Located {
            event,
            fraction: self.fraction(&point),
            point,
            critical: Some((cycle, x)),
            branch: None,
            pair: None,
        })
    }

    fn chord(&self, point: &Point) -> (f64, f64, f64) {
        let gap = |a: &Point| -> (Vec<f64>, f64) {
            (a.x.iter().zip(&self.from.x).map(|(a, b)| a - b).collect(), a.lambda - self.from.lambda)
        };
        let (whole, part) = (gap(self.to), gap(point));
        let product = |a: &(Vec<f64>, f64), b: &(Vec<f64>, f64)| inner(self.system, (&a.0, a.1), (&b.0, b.1));
        (product(&whole, &whole), product(&whole, &part), product(&part, &part))
    }

    /// Place along the chord, from 0 to 1.
    fn fraction(&self, point: &Point) -> f64 {
        let (square, along, _) = self.chord(point);
        along / square
    }

    /// Distance from the chord in parts of its length.
    fn beside(&self, point: &Point) -> f64 {
        let (square, along, own) = self.chord(point);
        ((own - along * along / square).max(0.0) / square).sqrt()
    }
}

impl Located {
    /// Solves for the point anew, with its tangent and factors; at a branch point factors are nearly singular.
    pub fn corrected(&self, segment: &Segment, counts: &mut Counts) -> Result<Corrected<OrbitFactors>, Failure> {
        let system = segment.system;
        counts.factorisations += 1;
        if self.branch.is_some() {
            let border = Border {
                row: system.dual(&self.point.tangent),
                lambda: system.dual_lambda() * self.point.tangent_lambda,
            };
            let factors = system.factor(&self.point.x, self.point.lambda, &border)?;
            return Ok(Corrected { point: self.point.clone(), factors, steps: 0, distance: 0.0 });
        }
        at_fraction(system, (segment.from, segment.to), self.fraction, counts)
    }
}
