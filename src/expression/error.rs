//! What can be wrong with an expression, and where.

use thiserror::Error;

use super::{Function, MAX_LENGTH, suggest};

/// Why an expression on one line could not be read or evaluated. Columns count characters from 1.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ExpressionError {
    #[error("column {column}: {fault}")]
    Syntax { column: usize, fault: Fault },
    #[error("is {length} bytes long; at most {MAX_LENGTH} are read")]
    TooLong { length: usize },
    #[error("unknown name {name:?}")]
    UnknownName { name: String },
}

/// What is wrong, and the byte of the text at which it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Misplaced {
    pub offset: usize,
    pub fault: Fault,
}

/// What is wrong, without the place.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Fault {
    #[error("expected {expected}, found {found}")]
    Expected { expected: String, found: String },
    #[error("unknown function {name:?}; {advice}")]
    UnknownFunction { name: String, advice: String },
    #[error("{text:?} is too large for a double-precision number (about 1.8e308)")]
    TooLarge { text: String },
    #[error("nested too deeply; write a shorter expression")]
    TooDeep,
    #[error("is {0} bytes long; at most {MAX_LENGTH} are read")]
    TooLong(usize),
    #[error("{what} has no place here; allowed are numbers, names, functions and operators")]
    NotHere { what: &'static str },
}

impl Fault {
    /// A function that is neither built in nor one of the text's own.
    pub fn unknown_function(name: &str, own: &[&str]) -> Fault {
        let known: Vec<&str> = own.iter().copied().chain(Function::ALL.map(|(known, _)| known)).collect();
        let advice = match suggest(name, known.iter().copied()) {
            Some(meant) => format!("did you mean {meant:?}?"),
            None => format!("known are {}", known.join(", ")),
        };
        Fault::UnknownFunction { name: name.to_owned(), advice }
    }
}

impl Misplaced {
    pub(super) fn in_line(self, text: &str) -> ExpressionError {
        let read = text.get(..self.offset).unwrap_or(text);
        ExpressionError::Syntax { column: read.chars().count() + 1, fault: self.fault }
    }
}
