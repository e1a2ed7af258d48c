//! What happens between two points of a Hopf curve: points of codimension two, and wanted values.

use super::HopfCurve;
use crate::bifurcation::{Coordinate, HopfNormalForm, Locus, Segment};
use crate::continuation::{Counts, Failure, Point};
use crate::linalg::c64;
use crate::problem::{Problem, Prolongation};
use std::sync::Arc;

/// A step of a Hopf curve.
pub type HopfSegment = Segment<HopfCurve>;

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

impl Locus for HopfCurve {
    type Test = Test;
    const SMALL: f64 = 1e-6;

    fn axes(&self) -> [Coordinate; 2] {
        [self.first, self.second]
    }

    fn coordinates(&self, point: &Point) -> [f64; 2] {
        [point.x[self.problem.dim() + 1], point.lambda]
    }

    fn taking(k: usize, goal: f64) -> Test {
        Test::Value(k, goal)
    }

    fn goal(test: Test) -> Option<f64> {
        if let Test::Value(1, goal) = test { Some(goal) } else { None }
    }

    fn value(step: &HopfSegment, test: Test, point: &Point) -> f64 {
        match test {
            Test::Value(k, goal) => step.curve.coordinates(point)[k] - goal,
            Test::Frequency => step.curve.kappa(point),
            Test::Criticality => {
                let hopf = step.curve.hopf(point, step.curve.solvable(point));
                let form = hopf.and_then(|hopf| HopfNormalForm::new(&*step.curve.problem, &hopf));
                form.map_or(f64::NAN, |form| form.l1)
            }
            Test::Steady => step.curve.steady(point).unwrap_or(f64::NAN),
            Test::Pair(from, to) => step.pair(from, to, point).map_or(f64::NAN, |pair| pair.re),
        }
    }
}

impl HopfSegment {
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

    /// Whether more pairs have crossed the axis than these tests are for: of two that are close, none may be known again.
    pub fn crossings_missed(from: &[c64], to: &[c64], tests: &[Test]) -> bool {
        let gain = |counted: fn(&c64) -> bool| {
            let count = |list: &[c64]| list.iter().filter(|z| z.re > 0.0 && counted(z)).count() as isize;
            count(to) - count(from)
        };
        let way = |test: &Test| match test {
            Test::Pair(from, _) if from.re < 0.0 => 1,
            Test::Pair(..) => -1,
            _ => 0,
        };
        let ways: isize = tests.iter().map(way).sum();
        // A pair that turns real does not change how many grow, and real ones that cross are no pair.
        (gain(|_| true) - 2 * ways).abs() > 1 && gain(|z| z.im > 0.0) != ways
    }

    /// The same step on a finer discretisation.
    pub fn refined(&self, problem: Arc<dyn Problem>, prolong: &Prolongation) -> Result<Self, Failure> {
        let curve = self.curve.refined(problem, prolong);
        let mut counts = Counts::default();
        let mut onto = |point: &Point| self.curve.onto(&curve, prolong, point, &mut counts);
        Ok(Self { from: onto(&self.from)?, to: onto(&self.to)?, curve: curve.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two close pairs one crosses; each is the other's neighbour at one end.
    #[test]
    fn a_pair_that_cannot_be_told_apart_is_missed_with_a_word() {
        let z = |re: f64, im: f64| c64::new(re, im);
        let pairs = |list: &[c64]| list.iter().flat_map(|z| [*z, z.conj()]).collect::<Vec<_>>();
        let missed = |from: &[c64], to: &[c64]| {
            let tests = HopfSegment::crossing_pairs(from, to);
            (tests.len(), HopfSegment::crossings_missed(from, to, &tests))
        };
        let from = pairs(&[z(-0.1, 2.0), z(-0.1, 5.0)]);
        assert_eq!(missed(&from, &pairs(&[z(0.1, 2.0), z(-0.1, 5.0)])), (1, false));
        assert!(missed(&from, &pairs(&[z(0.3, 3.4), z(-0.3, 3.3)])).1);
        // A growing pair turns real.
        let real = [pairs(&[z(-0.1, 2.0)]), vec![z(0.1, 0.0), z(0.2, 0.0)]].concat();
        assert_eq!(missed(&pairs(&[z(-0.1, 2.0), z(0.15, 0.1)]), &real), (0, false));
    }
}
