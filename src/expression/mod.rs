//! Arithmetic as text: one grammar and one tree for ties between parameters (`tau_c = "c_N * L^4 / EI / 200"`) and for
//! models (`x' = sigma*(y - x)`), evaluated on numbers or dual numbers alike. It knows nothing of what it is used for.

mod error;
mod eval;
mod function;
mod parser;
mod print;
mod statement;
mod suggest;
#[cfg(test)]
mod tests;

pub use error::{ExpressionError, Fault, Misplaced};
pub use eval::power;
pub use function::Function;
pub use statement::{Statement, statement, statements};
pub use suggest::suggest;

use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Longest expression read: far above any sensible formula, far below what could cost time.
const MAX_LENGTH: usize = 10_000;

/// An arithmetic expression of names, numbers and functions. Powers bind tighter than a minus sign before them and
/// group to the right, as in print: `-x^2` is `-(x^2)`, `2^3^2` is `2^9`.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    root: Node,
}

/// The syntax tree; only the parser builds it, which bounds its depth, so that walking it cannot overflow the stack.
/// Numbers are finite and not negative: a minus sign is a node of its own.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    Number(f64),
    Pi,
    Name(String, Offset),
    /// `u[i - 1, j]`
    Element(String, Vec<Node>, Offset),
    /// `x'` of a name or an element.
    Rate(Box<Node>),
    Negate(Box<Node>),
    Binary(Operator, Box<Node>, Box<Node>, Offset),
    Call(Function, Box<Node>, Offset),
    /// A function of the text's own.
    Apply(String, Vec<Node>, Offset),
    /// `sum(body, i = a..b)`
    Sum(Box<Node>, Box<Indices>),
}

/// `i = a..b`, both ends included.
#[derive(Clone, Debug, PartialEq)]
pub struct Indices {
    pub name: String,
    pub from: Node,
    pub to: Node,
    pub at: Offset,
}

/// The byte of the text at which a node stands: no part of what the node says, so that all of them are equal.
#[derive(Clone, Copy, Debug, Default)]
pub struct Offset(pub usize);

impl PartialEq for Offset {
    fn eq(&self, _: &Offset) -> bool {
        true
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

/// Words that no name may be.
pub const RESERVED: [&str; 3] = ["pi", "sum", "for"];

impl Expression {
    pub fn parse(text: &str) -> Result<Expression, ExpressionError> {
        if text.len() > MAX_LENGTH {
            return Err(ExpressionError::TooLong { length: text.len() });
        }
        let explain = |fault: Misplaced| fault.in_line(text);
        let root = parser::parse(text).map_err(explain)?;
        root.plain().map_err(explain)?;
        Ok(Expression { root })
    }

    /// The names that an evaluation looks up (`pi` is a constant, not a name).
    pub fn names(&self) -> BTreeSet<String> {
        let mut names = BTreeSet::new();
        self.root.visit(&mut |node| {
            if let Node::Name(name, _) = node {
                names.insert(name.clone());
            }
        });
        names
    }
}

impl Node {
    /// An expression with all that a model may hold.
    pub fn parse(text: &str) -> Result<Node, Misplaced> {
        if text.len() > MAX_LENGTH {
            return Err(Misplaced { offset: 0, fault: Fault::TooLong(text.len()) });
        }
        parser::parse(text)
    }

    /// This node and all below it.
    pub fn visit<'a>(&'a self, see: &mut dyn FnMut(&'a Node)) {
        see(self);
        match self {
            Node::Number(_) | Node::Pi | Node::Name(..) => {}
            Node::Rate(inner) | Node::Negate(inner) | Node::Call(_, inner, _) => inner.visit(see),
            Node::Binary(_, left, right, _) => {
                left.visit(see);
                right.visit(see);
            }
            Node::Element(_, parts, _) | Node::Apply(_, parts, _) => parts.iter().for_each(|part| part.visit(see)),
            Node::Sum(body, indices) => {
                body.visit(see);
                indices.from.visit(see);
                indices.to.visit(see);
            }
        }
    }

    /// Where the node's text starts, roughly: at its first name, call or operator.
    pub fn offset(&self) -> Option<usize> {
        let mut found = None;
        self.visit(&mut |node| {
            if let Node::Name(_, at) | Node::Element(_, _, at) | Node::Call(_, _, at) | Node::Apply(_, _, at) = node {
                found = Some(found.map_or(at.0, |known: usize| known.min(at.0)));
            }
        });
        found
    }

    /// Refuses what only models may hold.
    fn plain(&self) -> Result<(), Misplaced> {
        let mut wrong = None;
        self.visit(&mut |node| {
            let (at, fault) = match node {
                Node::Element(_, _, at) => (at.0, Fault::NotHere { what: "an element of an array" }),
                Node::Rate(inner) => (inner.offset().unwrap_or(0), Fault::NotHere { what: "a rate of change" }),
                Node::Sum(_, indices) => (indices.at.0, Fault::NotHere { what: "a sum over an index" }),
                Node::Apply(name, _, at) => (at.0, Fault::unknown_function(name, &[])),
                _ => return,
            };
            if wrong.is_none() {
                wrong = Some(Misplaced { offset: at, fault });
            }
        });
        wrong.map_or(Ok(()), Err)
    }

    fn has_names(&self) -> bool {
        let mut any = false;
        self.visit(&mut |node| {
            any |= !matches!(node, Node::Number(_) | Node::Pi | Node::Negate(_) | Node::Binary(..) | Node::Call(..))
        });
        any
    }

    /// The value of a node without names. To look for names first matters: to find out by evaluation would double the
    /// work at each level of x^x^x^...
    fn constant(&self) -> Option<f64> {
        match self {
            Node::Number(value) => Some(*value),
            Node::Pi => Some(PI),
            Node::Name(..) => None,
            _ if self.has_names() => None,
            _ => self.eval::<f64>(&|_| None).ok(),
        }
    }
}
