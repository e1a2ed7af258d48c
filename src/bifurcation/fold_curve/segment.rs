//! What happens between two points of a fold curve.

use super::FoldCurve;
use crate::continuation::{Counts, Failure, Point, at_lambda, crossing};
use crate::linalg::c64;

/// One step: its two ends, and the curve with the borders that were in force.
#[derive(Clone)]
pub struct FoldSegment {
    pub curve: FoldCurve,
    pub from: Point,
    pub to: Point,
}

/// A function along the curve whose zero is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FoldTest {
    /// The first (0) or second (1) coordinate takes a value.
    Value(usize, f64),
    /// The quadratic coefficient: zero at a cusp.
    Cusp,
    /// `w^T M q`: zero at a Bogdanov-Takens point.
    Takens,
    /// The real part of a pair, at both ends: zero at a zero-Hopf point.
    Pair(c64, c64),
}

impl FoldSegment {
    /// The test's value at a point; not a number where it does not exist.
    pub fn value(&self, test: FoldTest, point: &Point) -> f64 {
        match test {
            FoldTest::Value(k, goal) => self.curve.coordinates(point)[k] - goal,
            FoldTest::Cusp => self.curve.quadratic(point).unwrap_or(f64::NAN),
            FoldTest::Takens => self.curve.mass(point).unwrap_or(f64::NAN),
            FoldTest::Pair(from, to) => self.pair(from, to, point).map_or(f64::NAN, |pair| pair.re),
        }
    }

    /// The pair that was `from` at one end and is `to` at the other.
    pub fn pair(&self, from: c64, to: c64, point: &Point) -> Option<c64> {
        let middle = 0.5 * (from + to);
        let others = self.curve.others(point, from.norm().max(to.norm())).ok()?;
        others.into_iter().filter(|z| z.im > 0.0).min_by(|x, y| (x - middle).norm().total_cmp(&(y - middle).norm()))
    }

    /// Where the test vanishes, if it changes sign.
    pub fn locate(&self, test: FoldTest, counts: &mut Counts) -> Result<Option<Point>, Failure> {
        let ends = (&self.from, &self.to);
        let (a, b) = (self.value(test, &self.from), self.value(test, &self.to));
        if !(a * b < 0.0 || b == 0.0) {
            return Ok(None);
        }
        if let FoldTest::Value(1, goal) = test {
            return Ok(Some(at_lambda(&self.curve, ends, goal, counts)?.point));
        }
        crossing(&self.curve, ends, &|point: &Point| self.value(test, point), counts).map(Some)
    }
}
