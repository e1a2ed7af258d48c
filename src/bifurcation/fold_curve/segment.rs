//! What happens between two points of a fold curve.

use super::FoldCurve;
use crate::bifurcation::{Coordinate, Locus, Segment};
use crate::continuation::Point;
use crate::linalg::c64;

/// A step of a fold curve.
pub type FoldSegment = Segment<FoldCurve>;

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

impl Locus for FoldCurve {
    type Test = FoldTest;
    const SMALL: f64 = 1e-5;

    fn axes(&self) -> [Coordinate; 2] {
        [self.first, self.second]
    }

    fn coordinates(&self, point: &Point) -> [f64; 2] {
        [point.x[self.problem.dim()], point.lambda]
    }

    fn taking(k: usize, goal: f64) -> FoldTest {
        FoldTest::Value(k, goal)
    }

    fn goal(test: FoldTest) -> Option<f64> {
        if let FoldTest::Value(1, goal) = test { Some(goal) } else { None }
    }

    fn value(step: &FoldSegment, test: FoldTest, point: &Point) -> f64 {
        match test {
            FoldTest::Value(k, goal) => step.curve.coordinates(point)[k] - goal,
            FoldTest::Cusp => step.curve.quadratic(point).unwrap_or(f64::NAN),
            FoldTest::Takens => step.curve.mass(point).unwrap_or(f64::NAN),
            FoldTest::Pair(from, to) => step.pair(from, to, point).map_or(f64::NAN, |pair| pair.re),
        }
    }
}

impl FoldSegment {
    /// The pair that was `from` at one end and is `to` at the other.
    pub fn pair(&self, from: c64, to: c64, point: &Point) -> Option<c64> {
        let middle = 0.5 * (from + to);
        let others = self.curve.others(point, from.norm().max(to.norm())).ok()?;
        others.into_iter().filter(|z| z.im > 0.0).min_by(|x, y| (x - middle).norm().total_cmp(&(y - middle).norm()))
    }
}
