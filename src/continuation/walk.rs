//! The walk along a curve: an iterator of accepted steps.

use super::chord::settle;
use super::corrector::{SETTLED, polish, refactor};
use super::{Border, Corrected, Counts, Failure, Point, StepControl, System, at_lambda, correct, inner};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use thiserror::Error;

/// Why a walk ended.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
pub enum Stop {
    #[error("end of the range")]
    RangeEnd,
    #[error("end of the box")]
    BoxEnd,
    #[error("the branch closed on itself")]
    Closed,
    #[error("max_points reached")]
    MaxPoints,
    #[error("no step of at least {least:.1e} converges at {lambda}: {reason}")]
    Stagnation { least: f64, lambda: f64, reason: String },
    #[error("interrupted")]
    Interrupted,
}

/// What a walk must remember to go on later exactly as if it had not stopped.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct WalkState {
    pub point: Point,
    pub control: StepControl,
    bend: Option<Bend>,
    first: Option<Point>,
    steps: usize,
    /// The border of the factors at the point, if they are at hand for the next step.
    border: Option<Border>,
}

/// The cubic through the last two points along their tangents, `x(s) = x + s t + s² a + s³ b`, with s the arclength beyond
/// the last one: the predictor. Entries are those of x, and that of lambda.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
struct Bend {
    a: Vec<f64>,
    b: Vec<f64>,
}

impl Bend {
    /// With D the difference of the points over the arclength l between them,
    ///
    /// ```text
    /// a = (t_0 + 2 t_1 - 3 D) / l,      b = (t_0 + t_1 - 2 D) / l²;
    /// ```
    ///
    /// l is that of the circle on the chord on which tangents turn by the angle between them.
    fn new(from: &Point, to: &Point, chord: f64, angle: f64) -> Self {
        let half = 0.5 * angle.max(1e-6);
        let l = chord * half / half.sin();
        let entries = |point: &Point| {
            let x = point.x.iter().copied().chain([point.lambda]);
            let t = point.tangent.iter().copied().chain([point.tangent_lambda]);
            x.zip(t).collect::<Vec<_>>()
        };
        let (a, b) = entries(from)
            .into_iter()
            .zip(entries(to))
            .map(|((x, t), (x_1, t_1))| {
                let d = (x_1 - x) / l;
                ((t + 2.0 * t_1 - 3.0 * d) / l, (t + t_1 - 2.0 * d) / (l * l))
            })
            .unzip();
        Self { a, b }
    }
}

/// A step from one solution to the next, both on the same mesh.
pub struct Step<F> {
    pub from: Point,
    pub to: Point,
    /// Factors at `to`.
    pub factors: Arc<F>,
    /// Set on the last step.
    pub stop: Option<Stop>,
}

/// Follows `H(x, lambda) = 0` while lambda stays in a range.
pub struct Walk<'a, S: System> {
    pub system: &'a mut S,
    pub state: WalkState,
    pub counts: Counts,
    range: (f64, f64),
    /// Factors at the point, with which the next step is corrected as long as they serve.
    held: Option<Arc<S::Factors>>,
}

impl<'a, S: System> Walk<'a, S> {
    /// From a solution with its tangent; `range` has the lower end first.
    pub fn new(system: &'a mut S, point: Point, control: StepControl, range: (f64, f64)) -> Self {
        let state = WalkState { point, control, bend: None, first: None, steps: 0, border: None };
        Self::resume(system, state, range)
    }

    pub fn resume(system: &'a mut S, state: WalkState, range: (f64, f64)) -> Self {
        let WalkState { point, border, .. } = &state;
        let held = border.as_ref().and_then(|border| system.factor(&point.x, point.lambda, border).ok()).map(Arc::new);
        Self { system, state, counts: Counts::default(), range, held }
    }

    /// The next accepted step, or the reason why there is none.
    pub fn step(&mut self) -> Result<Step<S::Factors>, Stop> {
        let mut from = self.state.point.clone();
        if self.system.prepare(&mut from) {
            self.state.bend = None;
            self.held = None;
            self.settle(&mut from);
        }
        loop {
            let h = self.state.control.step;
            let failure = match self.attempt(&from, h) {
                Ok(corrected) => match self.beyond(corrected.point.lambda) {
                    None => return Ok(self.accept(from, corrected, h)),
                    // Next to a fold just beyond the end, shorter steps come closer.
                    Some(end) => match self.finish(&from, &corrected.point, end) {
                        Ok(step) => return Ok(step),
                        Err(failure) => failure,
                    },
                },
                Err(failure) => failure,
            };
            if !self.state.control.fail() {
                let least = self.state.control.least;
                return Err(Stop::Stagnation { least, lambda: from.lambda, reason: failure.to_string() });
            }
        }
    }

    /// A point that was moved to another mesh is solved for there; the factors serve for the step. Where that fails, the
    /// step will show it.
    fn settle(&mut self, from: &mut Point) {
        let border = self.border(from);
        let start = (from.x.clone(), from.lambda);
        if let Ok(Corrected { point, factors, .. }) = polish(&*self.system, start, &border, &mut self.counts) {
            *from = point;
            self.held = Some(Arc::new(factors));
        }
    }

    /// Predicts at arclength h from a point and corrects on the hyperplane across the tangent.
    fn attempt(&mut self, from: &Point, h: f64) -> Result<Corrected<S::Factors>, Failure> {
        let (x, lambda) = self.predict(from, h);
        let border = self.border(from);
        let counts = &mut self.counts;
        let settled =
            self.held.as_ref().and_then(|held| settle(&*self.system, (x.clone(), lambda), held, SETTLED, counts).ok());
        let corrected = match settled {
            Some(settled) => {
                // The old factors are of no use any more, and large systems have no room for two.
                self.held = None;
                refactor(&*self.system, settled, &border, counts)?
            }
            None => correct(&*self.system, (x, lambda), &border, counts)?,
        };
        // A turn by more than 60 degrees means that another part of the curve was hit.
        let to = &corrected.point;
        let cosine = inner(&*self.system, (&from.tangent, from.tangent_lambda), (&to.tangent, to.tangent_lambda));
        if cosine < 0.5 || corrected.distance > h { Err(Failure::Turned) } else { Ok(corrected) }
    }

    fn predict(&self, from: &Point, h: f64) -> (Vec<f64>, f64) {
        let mut x: Vec<f64> = from.x.iter().zip(&from.tangent).map(|(x, t)| x + h * t).collect();
        let mut lambda = from.lambda + h * from.tangent_lambda;
        if let Some(Bend { a, b }) = &self.state.bend {
            let entries = x.iter_mut().chain([&mut lambda]);
            entries.zip(a.iter().zip(b)).for_each(|(x, (a, b))| *x += h * h * (a + h * b));
        }
        (x, lambda)
    }

    fn border(&self, from: &Point) -> Border {
        Border { row: self.system.dual(&from.tangent), lambda: self.system.dual_lambda() * from.tangent_lambda }
    }

    fn accept(&mut self, from: Point, corrected: Corrected<S::Factors>, h: f64) -> Step<S::Factors> {
        let to = corrected.point;
        let cosine =
            inner(&*self.system, (&from.tangent, from.tangent_lambda), (&to.tangent, to.tangent_lambda)).min(1.0);
        self.state.control.succeed(corrected.steps, cosine.acos(), corrected.distance / h);
        let gap: Vec<f64> = to.x.iter().zip(&from.x).map(|(a, b)| a - b).collect();
        let gap = (&gap[..], to.lambda - from.lambda);
        let chord = inner(&*self.system, gap, gap).sqrt();
        self.state.bend = Some(Bend::new(&from, &to, chord, cosine.acos()));
        self.state.steps += 1;
        let stop = self.closed(&to, h).then_some(Stop::Closed);
        if self.state.first.is_none() {
            self.state.first = Some(from.clone());
        }
        self.state.point = to.clone();
        self.state.border = Some(self.border(&from));
        let factors = Arc::new(corrected.factors);
        self.held = Some(factors.clone());
        Step { from, to, factors, stop }
    }

    /// Whether the curve is back at its first point, going the same way.
    fn closed(&self, to: &Point, h: f64) -> bool {
        let Some(first) = self.state.first.as_ref().filter(|first| first.x.len() == to.x.len()) else { return false };
        let gap: Vec<f64> = to.x.iter().zip(&first.x).map(|(a, b)| a - b).collect();
        let gap = (&gap[..], to.lambda - first.lambda);
        let near = inner(&*self.system, gap, gap).sqrt() < h;
        // The metric may have changed since the first point.
        let product =
            |a: &Point, b: &Point| inner(&*self.system, (&a.tangent, a.tangent_lambda), (&b.tangent, b.tangent_lambda));
        let along = product(to, first) / (product(to, to) * product(first, first)).sqrt();
        self.state.steps > 3 && near && along > 0.9
    }

    /// The end of the range that lambda has passed.
    fn beyond(&self, lambda: f64) -> Option<f64> {
        let (low, high) = self.range;
        if lambda >= high {
            Some(high)
        } else if lambda <= low {
            Some(low)
        } else {
            None
        }
    }

    /// The last step, exactly to the end of the range, between the last point and one beyond it.
    fn finish(&mut self, from: &Point, beyond: &Point, end: f64) -> Result<Step<S::Factors>, Failure> {
        let corrected = at_lambda(&*self.system, (from, beyond), end, &mut self.counts)?;
        let to = corrected.point;
        self.state.point = to.clone();
        self.state.steps += 1;
        Ok(Step { from: from.clone(), to, factors: Arc::new(corrected.factors), stop: Some(Stop::RangeEnd) })
    }
}
