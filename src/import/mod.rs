//! Models of other programs, rewritten as scenes.

mod scene;
mod xpp;

pub use xpp::read;

use thiserror::Error;

/// A model as another program's file has it, in our expressions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Imported {
    /// Statements of the equations.
    pub equations: Vec<String>,
    /// Name and number, or expression in other parameters.
    pub parameters: Vec<(String, String)>,
    pub start: Vec<(String, String)>,
    pub observables: Vec<(String, String)>,
    /// A range for the first parameter.
    pub range: Option<(f64, f64)>,
    /// What was left out or renamed, with its line.
    pub notes: Vec<Remark>,
}

/// Something about a line, which counts from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Remark {
    pub line: usize,
    pub message: String,
}

/// What a scene cannot say.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}", lines(.0))]
pub struct ImportError(pub Vec<Remark>);

fn lines(remarks: &[Remark]) -> String {
    let lines: Vec<String> = remarks.iter().map(|remark| format!("line {}: {}", remark.line, remark.message)).collect();
    lines.join("\n")
}
