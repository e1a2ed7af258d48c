//! The walk along a curve: an iterator of accepted steps.

use super::chord::{Plane, settle};
use super::corrector::{SETTLED, polish, refactor};
use super::{Border, Corrected, Counts, Failure, Point, StepControl, System, at_lambda, correct, inner, normalise};
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
    /// Points before it on the same mesh, the last one first.
    past: Vec<Point>,
    first: Option<Point>,
    steps: usize,
    /// The border of the factors at the point, if they are at hand for the next step.
    border: Option<Border>,
}

/// Points before the last one that predictions take into account.
const REMEMBERED: usize = 2;

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
        let state = WalkState { point, control, past: Vec::new(), first: None, steps: 0, border: None };
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
            self.state.past.clear();
            self.held = None;
            self.settle(&mut from);
        }
        for past in &mut self.state.past {
            self.system.align(past);
            normalise(&*self.system, past);
        }
        loop {
            let h = self.state.control.step;
            let failure = match self.attempt(&from, h) {
                Ok(corrected) => match self.beyond(corrected.point.lambda) {
                    None => return Ok(self.accept(from, corrected, h)),
                    // Next to a fold just beyond the end, shorter steps come closer.
                    Some(end) => match self.finish(&from, &corrected, end) {
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
        let plane = Some(Plane { border: &border, along: from });
        let settled = self
            .held
            .as_ref()
            .and_then(|held| settle(&*self.system, (x.clone(), lambda), (&**held, plane), SETTLED, counts).ok());
        let corrected = match settled {
            Some(settled) => {
                // The old factors are of no use any more, and large systems have no room for two.
                self.held = None;
                refactor(&*self.system, settled, &border, counts)?
            }
            None => correct(&*self.system, (x, lambda), &border, counts)?,
        };
        // A turn by more than 60 degrees means that another part of the curve was hit.
        let turned = self.cosine(from, &corrected.point) < 0.5 || corrected.distance > h;
        if turned { Err(Failure::Turned) } else { Ok(corrected) }
    }

    /// At arclength s = h on the polynomial that goes through the points so far along their tangents,
    ///
    /// ```text
    /// x(s) = sum_j l_j(s)² [ x_j + (s - s_j) (t_j - 2 l_j'(s_j) x_j) ],      l_j(s) = prod_{k != j} (s - s_k) / (s_j - s_k).
    /// ```
    fn predict(&self, from: &Point, h: f64) -> (Vec<f64>, f64) {
        let mut points = vec![(from, 0.0)];
        for point in &self.state.past {
            let (next, s) = points[points.len() - 1];
            points.push((point, s - self.arclength(point, next)));
        }
        let (mut x, mut lambda) = (vec![0.0; from.x.len()], 0.0);
        for (j, &(point, s)) in points.iter().enumerate() {
            let others = || points.iter().enumerate().filter(|(k, _)| *k != j).map(|(_, (_, other))| other);
            let square = others().map(|other| (h - other) / (s - other)).product::<f64>().powi(2);
            let slope: f64 = others().map(|other| 1.0 / (s - other)).sum();
            let (of_point, of_tangent) = (square * (1.0 - 2.0 * slope * (h - s)), square * (h - s));
            for (x, (y, t)) in x.iter_mut().zip(point.x.iter().zip(&point.tangent)) {
                *x += of_point * y + of_tangent * t;
            }
            lambda += of_point * point.lambda + of_tangent * point.tangent_lambda;
        }
        (x, lambda)
    }

    /// That of the circle on the chord on which tangents turn by the angle between them.
    fn arclength(&self, from: &Point, to: &Point) -> f64 {
        let gap: Vec<f64> = to.x.iter().zip(&from.x).map(|(a, b)| a - b).collect();
        let gap = (&gap[..], to.lambda - from.lambda);
        let chord = inner(&*self.system, gap, gap).sqrt();
        let half = 0.5 * self.cosine(from, to).acos();
        if half > 0.0 { chord * half / half.sin() } else { chord }
    }

    /// Of the angle between two points' tangents.
    fn cosine(&self, from: &Point, to: &Point) -> f64 {
        let tangents = [from, to].map(|point| (&point.tangent[..], point.tangent_lambda));
        inner(&*self.system, tangents[0], tangents[1]).min(1.0)
    }

    fn border(&self, from: &Point) -> Border {
        Border { row: self.system.dual(&from.tangent), lambda: self.system.dual_lambda() * from.tangent_lambda }
    }

    fn accept(&mut self, from: Point, corrected: Corrected<S::Factors>, h: f64) -> Step<S::Factors> {
        let to = corrected.point;
        let angle = self.cosine(&from, &to).acos();
        self.state.control.succeed(corrected.steps, angle, corrected.distance / h);
        self.state.past.insert(0, from.clone());
        self.state.past.truncate(REMEMBERED);
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
    fn finish(&mut self, from: &Point, beyond: &Corrected<S::Factors>, end: f64) -> Result<Step<S::Factors>, Failure> {
        let corrected = at_lambda(&*self.system, (from, &beyond.point), end, Some(&beyond.factors), &mut self.counts)?;
        let to = corrected.point;
        self.state.point = to.clone();
        self.state.steps += 1;
        Ok(Step { from: from.clone(), to, factors: Arc::new(corrected.factors), stop: Some(Stop::RangeEnd) })
    }
}
