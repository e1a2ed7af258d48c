//! What happens between two points of a Hopf curve: points of codimension two, and wanted values.

use super::HopfCurve;
use crate::bifurcation::HopfNormalForm;
use crate::continuation::{Counts, Failure, Point, at_lambda, crossing};
use crate::linalg::c64;
use crate::problem::{Problem, Prolongation};
use std::sync::Arc;

/// One step: its two ends, and the curve with the borders that were in force.
#[derive(Clone)]
pub struct Segment {
    pub curve: HopfCurve,
    pub from: Point,
    pub to: Point,
}

/// A function along the curve whose zero is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Test {
    /// The first (0) or second (1) coordinate takes a value.
    Value(usize, f64),
    /// kappa = omega²: zero at a Bogdanov-Takens point.
    Frequency,
    /// The first Lyapunov coefficient: zero at a generalised Hopf (Bautin) point.
    Criticality,
    /// The bordered scalar of G_u: zero at a zero-Hopf point.
    Steady,
    /// The real part of another pair, at both ends: zero at a double Hopf point.
    Pair(c64, c64),
}

/// A function that changes sign at a pole does not come this close to zero, in parts of its values at the ends.
const SMALL: f64 = 1e-6;

impl Segment {
    /// The test's value at a point; not a number where it does not exist.
    pub fn value(&self, test: Test, point: &Point) -> f64 {
        match test {
            Test::Value(k, goal) => self.curve.coordinates(point)[k] - goal,
            Test::Frequency => self.curve.kappa(point),
            Test::Criticality => {
                let hopf = self.curve.hopf(point, self.curve.solvable(point));
                let form = hopf.and_then(|hopf| HopfNormalForm::new(&*self.curve.problem, &hopf));
                form.map_or(f64::NAN, |form| form.l1)
            }
            Test::Steady => self.curve.steady(point).unwrap_or(f64::NAN),
            Test::Pair(from, to) => self.pair(from, to, point).map_or(f64::NAN, |pair| pair.re),
        }
    }

    /// The pair that was `from` at one end and is `to` at the other.
    pub fn pair(&self, from: c64, to: c64, point: &Point) -> Option<c64> {
        let distance = |end: &Point| {
            let (a, b) = (self.curve.coordinates(point), self.curve.coordinates(end));
            let widths = [self.curve.first.width, self.curve.second.width];
            (0..2).map(|k| ((a[k] - b[k]) / widths[k]).powi(2)).sum::<f64>().sqrt()
        };
        let (left, right) = (distance(&self.from), distance(&self.to));
        let expected = if left + right > 0.0 { (from * right + to * left) / (left + right) } else { from };
        let others = self.curve.others(point).ok()?;
        others.into_iter().filter(|z| z.im > 0.0).min_by(|x, y| (x - expected).norm().total_cmp(&(y - expected).norm()))
    }

    /// Where the test vanishes, if it changes sign; `Ok(None)` if it does not, or only through a pole.
    pub fn locate(&self, test: Test, counts: &mut Counts) -> Result<Option<Point>, Failure> {
        let ends = (&self.from, &self.to);
        let (a, b) = (self.value(test, &self.from), self.value(test, &self.to));
        if !(a * b < 0.0 || b == 0.0) {
            return Ok(None);
        }
        if let Test::Value(1, goal) = test {
            return Ok(Some(at_lambda(&self.curve, ends, goal, counts)?.point));
        }
        let found = crossing(&self.curve, ends, &|point: &Point| self.value(test, point), counts)?;
        let small = self.value(test, &found).abs() <= SMALL * a.abs().max(b.abs());
        Ok(small.then_some(found))
    }

    /// Double Hopf points to look for: pairs whose real part changes sign, by the other eigenvalues at both ends.
    pub fn crossing_pairs(from: &[c64], to: &[c64]) -> Vec<Test> {
        let nearest = |z: c64, list: &[c64]| {
            let pairs = list.iter().copied().filter(|w| w.im > 0.0);
            pairs.min_by(|x, y| (x - z).norm().total_cmp(&(y - z).norm()))
        };
        let pairs = from.iter().copied().filter(|z| z.im > 0.0);
        pairs
            .filter_map(|z| {
                let next = nearest(z, to)?;
                let mutual = nearest(next, from) == Some(z);
                (mutual && (z.re < 0.0) != (next.re < 0.0)).then_some(Test::Pair(z, next))
            })
            .collect()
    }

    /// The same step on a finer discretisation.
    pub fn refined(&self, problem: Arc<dyn Problem>, prolong: &Prolongation) -> Result<Self, Failure> {
        let curve = self.curve.refined(problem, prolong);
        let mut counts = Counts::default();
        let mut onto = |point: &Point| self.curve.onto(&curve, prolong, point, &mut counts);
        Ok(Self { from: onto(&self.from)?, to: onto(&self.to)?, curve: curve.clone() })
    }
}
