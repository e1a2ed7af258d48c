//! What can be wrong with a scene. Every message names the place, what is wrong there, and what would be right.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use super::Place;
use super::label::POINT_KINDS;
use super::units::UnitError;
use crate::expression::{ExpressionError, suggest};

/// Why a scene was refused.
#[derive(Debug, Error)]
pub enum SceneError {
    #[error("cannot read the scene {}: {source}", path.display())]
    Read {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    #[error("{}:{line}:{column}: not valid TOML: {message}", path.display())]
    Syntax { path: PathBuf, line: usize, column: usize, message: String },
    #[error("--set {argument}: {fault}")]
    Override { argument: String, fault: Fault },
    #[error(transparent)]
    Entry(Box<EntryError>),
}

/// One entry of the scene, and what is wrong with it.
#[derive(Debug, Error)]
#[error("{}{}{}: {fault}", path.display(), self.position(), self.subject())]
pub struct EntryError {
    pub path: PathBuf,
    pub at: Place,
    /// The `--set` argument that the entry comes from.
    pub argument: Option<String>,
    pub fault: Fault,
}

impl EntryError {
    fn position(&self) -> String {
        if let Fault::Text { position: Some((line, column)), .. } = self.fault {
            return format!(":{line}:{column}");
        }
        match (self.at.line, &self.argument) {
            (Some(line), _) => format!(":{line}"),
            (None, Some(argument)) => format!(": --set {argument}"),
            (None, None) => String::new(),
        }
    }

    fn subject(&self) -> String {
        if self.at.key.is_empty() { String::new() } else { format!(": {}", self.at.key) }
    }
}

/// What is wrong, without the place.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Fault {
    #[error("unknown {what} {found:?}{}; allowed: {}", meant(suggestion), list(allowed))]
    Unknown { what: &'static str, found: String, allowed: Vec<String>, suggestion: Option<String> },
    #[error("{what} is missing; add {example}")]
    Missing { what: String, example: String },
    #[error("must be {expected}, but is {found}")]
    Type { expected: String, found: String },
    #[error("must be a finite number, but is {found}")]
    NotFinite { found: String },
    #[error("is {found}; allowed: {allowed}")]
    OutOfBounds { found: String, allowed: String },
    #[error("is empty; give {expected}")]
    Empty { expected: String },
    #[error("the range runs from {from} to {to}; write the smaller end first, and two different ends")]
    Range { from: f64, to: f64 },
    #[error(
        "the range is for {found:?}, but the free parameter is {free:?}; write range = {{ {free} = [from, to] }} or range = [from, to]"
    )]
    RangeOfOther { found: String, free: String },
    #[error("{value} lies outside the range {from} to {to} of the free parameter, so that the branch never gets there")]
    OutsideRange { value: f64, from: f64, to: f64 },
    #[error("{found} is given twice; keep one")]
    Repeated { found: String },
    #[error("a {what} named {name:?} is already defined{}; choose another name", line(first))]
    Duplicate { what: &'static str, name: String, first: Option<usize> },
    #[error("{name:?} cannot be a name; use letters (a-z, A-Z), digits, \"-\" and \"_\"")]
    Name { name: String },
    #[error(
        "{found:?} is not a label; write TASK/KINDn, for example {example:?}, with KIND one of {} and n counting from 1",
        POINT_KINDS.join(", ")
    )]
    Label { found: String, example: String },
    #[error("the task {name:?} comes later{}; put it before this one", line(at))]
    Later { name: String, at: Option<usize> },
    #[error("the task {task:?} finds no {kind} points{advice}")]
    NotProduced { task: String, kind: String, advice: String },
    #[error("is not an expression: {0}")]
    Expression(#[from] ExpressionError),
    #[error("a number with its unit is written {{ value = {value}, unit = {unit:?} }}")]
    BareQuantity { value: String, unit: String },
    #[error("{0}")]
    Unit(#[from] UnitError),
    #[error("is not of the form KEY=VALUE; write for example --set parameters.L=14")]
    NotAnAssignment,
    #[error("has an empty key; write for example parameters.L or task.beat.range")]
    EmptyKey,
    #[error("gives no value; write {key}=VALUE")]
    NoValue { key: String },
    #[error("the value is not valid TOML: {message}")]
    Value { message: String },
    #[error(
        "{key} cannot be overridden; allowed: title, budget, model.KEY, parameters.NAME, task.NAME.KEY, figure.NAME.KEY (names stay as they are)"
    )]
    NotOverridable { key: String },
    /// In a text inside the scene, at that line and column of the file.
    #[error("{message}")]
    Text { position: Option<(usize, usize)>, message: String },
    /// For callers that find more wrong later: a parameter that the model lacks, a unit that does not fit.
    #[error("{0}")]
    Other(String),
}

impl Fault {
    /// An unknown word, with the known one that it most resembles.
    pub fn unknown<'a>(what: &'static str, found: &str, allowed: impl IntoIterator<Item = &'a str>) -> Fault {
        let allowed: Vec<String> = allowed.into_iter().map(str::to_owned).collect();
        Fault::Unknown {
            what,
            found: found.to_owned(),
            suggestion: suggest(found, allowed.iter().map(String::as_str)).map(str::to_owned),
            allowed,
        }
    }
}

fn meant(suggestion: &Option<String>) -> String {
    match suggestion {
        Some(word) => format!(" (did you mean {word:?}?)"),
        None => String::new(),
    }
}

fn list(words: &[String]) -> String {
    if words.is_empty() { "none".to_owned() } else { words.join(", ") }
}

fn line(at: &Option<usize>) -> String {
    match at {
        Some(line) => format!(" (line {line})"),
        None => String::new(),
    }
}
