//! Models as text: equations, definitions, functions and arrays, turned into a [`Problem`](crate::problem::Problem).
//!
//! ```text
//! x' = sigma*(y - x)                                  an equation: M(u, p) u' = F(u, p), rates enter linearly
//! a*x' + b*y' = f,   0 = g                            a row of the mass matrix, an algebraic equation
//! R = s*a/(1 + s),   f(x) = x^2                       a definition, a function
//! u[i]' = u[i-1] - 2*u[i] + u[i+1]  for i = 1..N      an array
//! u[0] = A                                            a value beyond its end
//! ```
//!
//! The text becomes a graph without repetitions (`graph`), the graph a tape (`tape`), and the tape is a
//! [`Formula`](crate::problem::Formula): derivatives of all orders are exact.

mod build;
mod conserved;
mod diagnosis;
mod formula;
mod graph;
mod index;
mod intern;
mod linearisation;
mod rows;
mod scope;
mod symmetry;
mod tape;
#[cfg(test)]
mod tests;
mod unknowns;

pub use build::build;
pub use formula::Text;

use thiserror::Error;

/// Most operations of a model.
const MAX_VERTICES: usize = 4_000_000;
/// Most elements of a range, and most equations that one statement stands for.
const MAX_ELEMENTS: usize = 400_000;
/// Most visits to find out which equation depends on what.
const MAX_PATTERN: usize = 100_000_000;

/// What a scene says of its model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Written {
    pub equations: String,
    /// Whole numbers by name.
    pub constants: Vec<(String, i64)>,
    pub parameters: Vec<WrittenParameter>,
    /// What an unknown starts at, by name: `x`, `u`, `u[i]`.
    pub start: Vec<(String, String)>,
    pub observables: Vec<WrittenObservable>,
    /// Quantities that the flow keeps, by the name of the parameter that is their value.
    pub conserved: Vec<(String, String)>,
    /// `x -> -x, y -> -y`
    pub symmetry: Option<String>,
    /// `x -> -y, y -> x`: quarter turns of continuous symmetries.
    pub rotations: Vec<String>,
    pub time_unit: String,
    /// Names that mean something else in results: no unknown is an observable by such a name.
    pub reserved: Vec<String>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct WrittenParameter {
    pub name: String,
    pub default: WrittenDefault,
    pub unit: String,
    pub meaning: String,
    pub least: f64,
    pub most: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub enum WrittenDefault {
    Number(f64),
    /// An expression in other parameters.
    Tie(String),
}

#[derive(Clone, Debug, PartialEq)]
pub struct WrittenObservable {
    pub name: String,
    pub expression: String,
    pub unit: String,
    pub meaning: String,
}

/// The part of [`Written`] that an error is in.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    Equations,
    Constant(String),
    Parameter(String),
    Start(String),
    Observable(String),
    Conserved(String),
    Symmetry,
    Rotation(usize),
}

/// What is wrong in one text, and the byte at which it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Wrong {
    pub offset: Option<usize>,
    pub message: String,
}

impl Wrong {
    fn new(offset: usize, message: String) -> Self {
        Self { offset: Some(offset), message }
    }
}

impl From<crate::expression::Misplaced> for Wrong {
    fn from(wrong: crate::expression::Misplaced) -> Self {
        Wrong::new(wrong.offset, wrong.fault.to_string())
    }
}

#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}", wrong.message)]
pub struct TextError {
    pub part: Part,
    pub wrong: Wrong,
}

impl TextError {
    fn in_equations(wrong: Wrong) -> Self {
        Self { part: Part::Equations, wrong }
    }
}
