//! A parameter as an unknown of a curve: itself, or its logarithm to base 10.

use std::f64::consts::LN_10;

/// Parameter `index` is `z`, or `10^z` if logarithmic; arclength counts changes of z in parts of `width`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinate {
    pub index: usize,
    pub logarithmic: bool,
    pub width: f64,
}

impl Coordinate {
    /// z of a parameter's value.
    pub fn of(&self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }

    /// The parameter's value at z.
    pub fn value(&self, z: f64) -> f64 {
        if self.logarithmic { 10.0_f64.powf(z) } else { z }
    }

    /// d value / dz.
    pub fn rate(&self, z: f64) -> f64 {
        if self.logarithmic { LN_10 * self.value(z) } else { 1.0 }
    }
}
