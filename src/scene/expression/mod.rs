//! Arithmetic in parameters (`tau_c = "c_N * L^4 / EI / 200"`), evaluated on numbers or dual numbers alike.

mod eval;
mod parser;
mod print;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::f64::consts::PI;

use thiserror::Error;

/// Longest text read: far above any sensible formula, far below what could cost time.
const MAX_LENGTH: usize = 10_000;

/// An arithmetic expression. Powers bind tighter than a minus sign before them and group to the right, as in
/// print: `-x^2` is `-(x^2)`, `2^3^2` is `2^9`.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    root: Node,
}

/// The syntax tree; only the parser builds it, which bounds its depth, so that walking it cannot overflow the stack.
/// Numbers are finite and not negative: a minus sign is a node of its own.
#[derive(Clone, Debug, PartialEq)]
enum Node {
    Number(f64),
    Pi,
    Name(String),
    Negate(Box<Node>),
    Binary(Operator, Box<Node>, Box<Node>),
    Call(Function, Box<Node>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Function {
    Sin,
    Cos,
    Tan,
    Exp,
    Log,
    Log10,
    Sqrt,
    Abs,
    Sinh,
    Cosh,
    Tanh,
}

impl Function {
    const ALL: [(&'static str, Function); 11] = [
        ("sin", Function::Sin),
        ("cos", Function::Cos),
        ("tan", Function::Tan),
        ("exp", Function::Exp),
        ("log", Function::Log),
        ("log10", Function::Log10),
        ("sqrt", Function::Sqrt),
        ("abs", Function::Abs),
        ("sinh", Function::Sinh),
        ("cosh", Function::Cosh),
        ("tanh", Function::Tanh),
    ];

    fn named(name: &str) -> Option<Function> {
        Function::ALL.iter().find(|(known, _)| *known == name).map(|&(_, function)| function)
    }

    fn name(self) -> &'static str {
        match self {
            Function::Sin => "sin",
            Function::Cos => "cos",
            Function::Tan => "tan",
            Function::Exp => "exp",
            Function::Log => "log",
            Function::Log10 => "log10",
            Function::Sqrt => "sqrt",
            Function::Abs => "abs",
            Function::Sinh => "sinh",
            Function::Cosh => "cosh",
            Function::Tanh => "tanh",
        }
    }
}

/// Why an expression could not be read or evaluated. Columns count characters from 1.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ExpressionError {
    #[error("column {column}: expected {expected}, found {found}")]
    Syntax { column: usize, expected: String, found: String },
    #[error("column {column}: unknown function {name:?}; {advice}")]
    UnknownFunction { column: usize, name: String, advice: String },
    #[error("column {column}: {text:?} is too large for a double-precision number (about 1.8e308)")]
    TooLarge { column: usize, text: String },
    #[error("column {column}: nested too deeply; write a shorter expression")]
    TooDeep { column: usize },
    #[error("is {length} bytes long; at most {MAX_LENGTH} are read")]
    TooLong { length: usize },
    #[error("unknown name {name:?}")]
    UnknownName { name: String },
}

impl Expression {
    pub fn parse(text: &str) -> Result<Expression, ExpressionError> {
        if text.len() > MAX_LENGTH {
            return Err(ExpressionError::TooLong { length: text.len() });
        }
        parser::parse(text).map(|root| Expression { root })
    }

    /// The names that an evaluation looks up (`pi` is a constant, not a name).
    pub fn names(&self) -> BTreeSet<String> {
        let mut names = BTreeSet::new();
        self.root.collect_names(&mut names);
        names
    }
}

impl Node {
    fn collect_names(&self, names: &mut BTreeSet<String>) {
        match self {
            Node::Number(_) | Node::Pi => {}
            Node::Name(name) => {
                names.insert(name.clone());
            }
            Node::Negate(inner) | Node::Call(_, inner) => inner.collect_names(names),
            Node::Binary(_, left, right) => {
                left.collect_names(names);
                right.collect_names(names);
            }
        }
    }

    fn has_names(&self) -> bool {
        match self {
            Node::Number(_) | Node::Pi => false,
            Node::Name(_) => true,
            Node::Negate(inner) | Node::Call(_, inner) => inner.has_names(),
            Node::Binary(_, left, right) => left.has_names() || right.has_names(),
        }
    }

    /// The value of a node without names. To look for names first matters: to find out by evaluation would double the
    /// work at each level of x^x^x^...
    fn constant(&self) -> Option<f64> {
        match self {
            Node::Number(value) => Some(*value),
            Node::Pi => Some(PI),
            Node::Name(_) => None,
            _ if self.has_names() => None,
            _ => self.eval::<f64>(&|_| None).ok(),
        }
    }
}
