//! Curves of special points as problems of their own: what such systems share.
//!
//! Folds, Hopf points, branch points, critical cycles: each kind has a system of equations in which two parameters are
//! unknown, followed by the one loop that follows any curve. What is looked for along it are zeros of tests.

use super::Coordinate;
use crate::continuation::{Counts, Failure, Point, System, at_lambda, crossing};

/// A system of a curve of special points, z1 being one of its unknowns and z2 its lambda.
pub trait Locus: System + Clone {
    /// What is looked for along the curve.
    type Test: Copy + PartialEq;

    /// A function that changes sign at a pole does not come this close to zero, in parts of its values at the ends.
    const SMALL: f64;

    /// The two parameters.
    fn axes(&self) -> [Coordinate; 2];

    /// z1 and z2.
    fn coordinates(&self, point: &Point) -> [f64; 2];

    /// The test whether the first (0) or second (1) coordinate takes a value.
    fn taking(k: usize, goal: f64) -> Self::Test;

    /// The value that a test wants of the second coordinate, which is the curve's lambda.
    fn goal(test: Self::Test) -> Option<f64>;

    /// The test's value at a point of a step; not a number where it does not exist.
    fn value(step: &Segment<Self>, test: Self::Test, point: &Point) -> f64;

    /// Whether a zero is what the test is for.
    fn genuine(_step: &Segment<Self>, _test: Self::Test, _zero: &Point) -> Result<bool, Failure> {
        Ok(true)
    }
}

/// One step: its two ends, and the curve with the mesh and the borders that were in force.
#[derive(Clone)]
pub struct Segment<C> {
    pub curve: C,
    pub from: Point,
    pub to: Point,
}

impl<C: Locus> Segment<C> {
    pub fn value(&self, test: C::Test, point: &Point) -> f64 {
        C::value(self, test, point)
    }

    /// Where the test vanishes, if it changes sign; `Ok(None)` if it does not, or only through a pole, or at what is no
    /// point of its kind, or where it does not exist; an error where it exists at one end only, so that nobody knows.
    pub fn locate(&self, test: C::Test, counts: &mut Counts) -> Result<Option<Point>, Failure> {
        let ends = (&self.from, &self.to);
        let (a, b) = (self.value(test, &self.from), self.value(test, &self.to));
        if a.is_nan() != b.is_nan() {
            return Err(Failure::NotFinite);
        }
        if !(a * b < 0.0 || b == 0.0) {
            return Ok(None);
        }
        if let Some(goal) = C::goal(test) {
            return Ok(Some(at_lambda(&self.curve, ends, goal, None, counts)?.point));
        }
        let found = crossing(&self.curve, ends, &|point: &Point| self.value(test, point), counts)?;
        let small = self.value(test, &found).abs() <= C::SMALL * a.abs().max(b.abs());
        Ok((small && C::genuine(self, test, &found)?).then_some(found))
    }

    /// How far along the chord of the step a point lies, for sorting.
    pub fn along(&self, [z1, z2]: [f64; 2]) -> f64 {
        let (a, b) = (self.curve.coordinates(&self.from), self.curve.coordinates(&self.to));
        let part = |k: usize, z: f64, width: f64| (z - a[k]) * (b[k] - a[k]) / width.powi(2);
        let [first, second] = self.curve.axes();
        part(0, z1, first.width) + part(1, z2, second.width)
    }
}
