//! What is integrated: the terms of the weak form at a point, as functions of the fields there.

use super::super::parameters::{EPS, Groups, Law};
use crate::problem::Scalar;

/// A field's or a test function's value, its slope in x, or a field's rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Value,
    Slope,
    Rate,
}
use Part::{Rate, Slope, Value};

/// Positions of the fields.
pub mod field {
    pub const PSI: usize = 0;
    pub const T: usize = 2;
    pub const N: usize = 4;
    pub const F: usize = 6;
    pub const H: usize = 7;
}
use field::{F, H, N, PSI, T};

/// Forces of 1000 EI/L² are as common in beats as angles of one: these units of T, N and f give all unknowns one size, as
/// arclength and the errors of orbits, which weigh all unknowns alike, expect.
pub const FORCE: f64 = 1000.0;

/// The unit of each field's unknowns; equations are divided by that of the field at whose places they are.
pub const UNITS: [f64; 8] = [1.0, 1.0, FORCE, FORCE, FORCE, FORCE, FORCE, 1.0];

/// What of the fields enters, those of h at the end.
pub const INPUTS: [(usize, Part); 16] = [
    (PSI, Value),
    (PSI + 1, Value),
    (PSI, Slope),
    (PSI + 1, Slope),
    (PSI, Rate),
    (PSI + 1, Rate),
    (T, Value),
    (T + 1, Value),
    (T, Slope),
    (T + 1, Slope),
    (N, Value),
    (N + 1, Value),
    (N, Slope),
    (N + 1, Slope),
    (F, Value),
    (H, Value),
];

/// What multiplies the test functions, which are numbered like the fields at whose places their equations are.
pub const OUTPUTS: [(usize, Part); 16] = [
    (PSI, Value),
    (PSI + 1, Value),
    (PSI, Slope),
    (PSI + 1, Slope),
    (T, Value),
    (T + 1, Value),
    (T, Slope),
    (T + 1, Slope),
    (N, Value),
    (N + 1, Value),
    (N, Slope),
    (N + 1, Slope),
    (F, Value),
    (F, Slope),
    (H, Value),
    (H, Slope),
];

/// Inputs and outputs that a law has.
pub fn counts(law: Law) -> (usize, usize) {
    match law {
        Law::Printed => (15, 14),
        Law::Separation => (16, 16),
    }
}

/// The outputs from the inputs, in the order of both tables; `straight` is `P int_x^1 D`, the straight state's tension in
/// doublet 1. The letters are those of the module's weak form.
pub fn density<S: Scalar>(law: Law, g: &Groups<S>, straight: S, z: &[S; 16]) -> [S; 16] {
    let zero = S::from(0.0);
    let mut y = [zero; 16];
    let mean = (z[0] + z[1]) * 0.5;
    let mean_rate = (z[4] + z[5]) * 0.5;
    let moment = -(g.kappa_t * mean + g.beta_t * mean_rate + g.kappa_3t * mean * mean * mean);
    let f = match law {
        Law::Printed => z[14],
        Law::Separation => z[14] - g.kappa_3n * z[15] * z[15] * z[15],
    };
    for n in 0..2 {
        let (bend, rate, excess, excess_x, normal, normal_x) =
            (z[2 + n], z[4 + n], z[6 + n], z[8 + n], z[10 + n], z[12 + n]);
        // Forces per length against the drag: tau_N v along t and n.
        let along_t = (excess_x - bend * normal) * g.tau_n / g.tau_t;
        let along_n = normal_x + bend * (straight * EPS[n] + excess) + f * EPS[n];
        y[n] = -moment - normal;
        y[2 + n] = g.bending[n] * bend;
        y[4 + n] = bend * along_n;
        y[6 + n] = along_t;
        y[8 + n] = g.tau_n * rate - bend * along_t;
        y[10 + n] = along_n;
    }
    let difference = z[0] - z[1];
    y[12] = -(g.kappa_n * difference + g.beta_n * (z[4] - z[5]));
    y[13] = z[14];
    match law {
        Law::Printed => y[12] -= g.kappa_3n * difference * difference * difference,
        Law::Separation => (y[14], y[15]) = (difference, z[15]),
    }
    y
}
