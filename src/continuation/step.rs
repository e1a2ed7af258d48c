//! How far to go next.

use serde::{Deserialize, Serialize};

/// Step control: the step grows where correction was quick, short, and the curve straight; it shrinks otherwise.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq)]
pub struct StepControl {
    pub step: f64,
    pub least: f64,
    pub most: f64,
}

/// Wanted: few Newton steps, tangents that turn by no more than this (radians) in one step,
const WANTED_STEPS: f64 = 4.0;
const WANTED_ANGLE: f64 = 0.3;
/// and a prediction that misses by no more than this part of the step.
const WANTED_MISS: f64 = 0.1;

impl StepControl {
    /// After a success: `steps` of Newton, the angle between old and new tangent, and prediction error over step.
    pub fn succeed(&mut self, steps: usize, angle: f64, miss: f64) {
        let by_steps = (WANTED_STEPS / steps as f64).sqrt();
        let by_angle = WANTED_ANGLE / angle.max(1e-12);
        // The predictor is of third order at least: relative to the step its error goes as the step cubed.
        let by_miss = (WANTED_MISS / miss.max(1e-12)).cbrt();
        let factor = by_steps.min(by_angle).min(by_miss).clamp(0.4, 1.6);
        self.step = (self.step * factor).min(self.most);
    }

    /// After a failure; `false` when the step cannot shrink any more.
    pub fn fail(&mut self) -> bool {
        self.step *= 0.35;
        self.step >= self.least
    }
}
