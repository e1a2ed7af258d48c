//! The grammar of expressions:
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = unary (("*" | "/") unary)*
//! unary   = "-" unary | power
//! power   = atom ["^" unary]
//! atom    = number | function "(" sum ")" | name | "(" sum ")"
//! ```

use winnow::Parser;
use winnow::ascii::{digit0, digit1, multispace0};
use winnow::combinator::{alt, opt};
use winnow::error::ParserError;
use winnow::stream::{Stateful, Stream};
use winnow::token::{any, one_of, take_while};

use super::super::suggest;
use super::{ExpressionError, Function, Node, Operator};

/// Deepest nesting that is read: bounds the recursion of the parser.
const MAX_NESTING: usize = 100;
/// Deepest tree that is built (`a + b + c + ...` nests to the left): bounds the recursion of whoever walks it.
const MAX_DEPTH: usize = 300;

/// The text left to read, and how deep the reading has gone.
type Input<'a> = Stateful<&'a str, usize>;
type Parsed = Result<Part, Failure>;

/// A tree and its depth.
struct Part {
    node: Node,
    depth: usize,
}

/// An error and how many bytes were left when it struck.
#[derive(Debug)]
struct Failure {
    left: usize,
    reason: Reason,
}

#[derive(Debug)]
enum Reason {
    Expected(&'static str),
    ExpectedCall(&'static str),
    UnknownFunction(String),
    TooLarge(String),
    TooDeep,
}

const OPERAND: &str = "a number, a name, a function, \"-\" or \"(\"";

impl<'a> ParserError<Input<'a>> for Failure {
    type Inner = Failure;

    fn from_input(input: &Input<'a>) -> Failure {
        Failure::at(input, Reason::Expected(OPERAND))
    }

    fn into_inner(self) -> Result<Failure, Failure> {
        Ok(self)
    }
}

impl Failure {
    fn at(input: &Input<'_>, reason: Reason) -> Failure {
        Failure { left: input.eof_offset(), reason }
    }

    /// Says where in `text`, counted in characters, and what stands there.
    fn explain(self, text: &str) -> ExpressionError {
        let (read, left) = text.split_at_checked(text.len().saturating_sub(self.left)).unwrap_or((text, ""));
        let column = read.chars().count() + 1;
        let syntax = |expected: String| ExpressionError::Syntax {
            column,
            expected,
            found: match left.chars().next() {
                Some(character) => format!("{:?}", character.to_string()),
                None => "the end".to_owned(),
            },
        };
        match self.reason {
            Reason::Expected(expected) => syntax(expected.to_owned()),
            Reason::ExpectedCall(name) => syntax(format!("\"(\" after the function {name}")),
            Reason::UnknownFunction(name) => {
                let known = Function::ALL.map(|(known, _)| known);
                let advice = match suggest(&name, known) {
                    Some(meant) => format!("did you mean {meant:?}?"),
                    None => format!("known are {}", known.join(", ")),
                };
                ExpressionError::UnknownFunction { column, name, advice }
            }
            Reason::TooLarge(text) => ExpressionError::TooLarge { column, text },
            Reason::TooDeep => ExpressionError::TooDeep { column },
        }
    }
}

pub(super) fn parse(text: &str) -> Result<Node, ExpressionError> {
    let mut input = Input { input: text, state: 0 };
    whole(&mut input).map(|part| part.node).map_err(|failure| failure.explain(text))
}

fn whole(input: &mut Input<'_>) -> Parsed {
    space(input)?;
    let part = sum(input)?;
    if input.eof_offset() > 0 {
        return Err(Failure::at(input, Reason::Expected("an operator or the end")));
    }
    Ok(part)
}

fn sum(input: &mut Input<'_>) -> Parsed {
    let mut left = product(input)?;
    while let Some(symbol) = symbol(input, ['+', '-'])? {
        let right = product(input)?;
        let operator = if symbol == '+' { Operator::Add } else { Operator::Subtract };
        left = join(input, operator, left, right)?;
    }
    Ok(left)
}

fn product(input: &mut Input<'_>) -> Parsed {
    let mut left = unary(input)?;
    while let Some(symbol) = symbol(input, ['*', '/'])? {
        let right = unary(input)?;
        let operator = if symbol == '*' { Operator::Multiply } else { Operator::Divide };
        left = join(input, operator, left, right)?;
    }
    Ok(left)
}

/// Every recursion of the grammar passes here, so that here is where nesting is counted.
fn unary(input: &mut Input<'_>) -> Parsed {
    if input.state >= MAX_NESTING {
        return Err(Failure::at(input, Reason::TooDeep));
    }
    input.state += 1;
    let part = if symbol(input, ['-'])?.is_some() {
        let inner = unary(input)?;
        grow(input, inner.depth, Node::Negate(Box::new(inner.node)))
    } else {
        power(input)
    };
    input.state -= 1;
    part
}

fn power(input: &mut Input<'_>) -> Parsed {
    let base = atom(input)?;
    if symbol(input, ['^'])?.is_none() {
        return Ok(base);
    }
    let exponent = unary(input)?;
    join(input, Operator::Power, base, exponent)
}

fn atom(input: &mut Input<'_>) -> Parsed {
    let next = input.input.chars().next();
    match next {
        Some('(') => parenthesis(input),
        Some('.' | '0'..='9') => number(input),
        Some(first) if first.is_alphabetic() || first == '_' => name(input),
        _ => Err(Failure::from_input(input)),
    }
}

fn parenthesis(input: &mut Input<'_>) -> Parsed {
    any(input)?;
    space(input)?;
    let inner = sum(input)?;
    match symbol(input, [')'])? {
        Some(_) => Ok(inner),
        None => Err(Failure::at(input, Reason::Expected("an operator or \")\""))),
    }
}

fn number(input: &mut Input<'_>) -> Parsed {
    let start = *input;
    let text = (
        alt(((digit1, opt(('.', digit0))).void(), ('.', digit1).void())),
        opt((one_of(['e', 'E']), opt(one_of(['+', '-'])), digit1)),
    )
        .take()
        .parse_next(input)?;
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => {
            space(input)?;
            Ok(Part { node: Node::Number(value), depth: 1 })
        }
        _ => Err(Failure::at(&start, Reason::TooLarge(text.to_owned()))),
    }
}

/// A name, the constant pi, or a function with its argument.
fn name(input: &mut Input<'_>) -> Parsed {
    let start = *input;
    let name: &str = take_while(1.., |c: char| c.is_alphanumeric() || c == '_').parse_next(input)?;
    space(input)?;
    let called = input.input.starts_with('(');
    match (Function::named(name), called) {
        (Some(function), true) => {
            let argument = parenthesis(input)?;
            grow(input, argument.depth, Node::Call(function, Box::new(argument.node)))
        }
        (Some(function), false) => Err(Failure::at(input, Reason::ExpectedCall(function.name()))),
        (None, true) if name != "pi" => Err(Failure::at(&start, Reason::UnknownFunction(name.to_owned()))),
        _ => {
            let node = match name {
                "pi" => Node::Pi,
                _ => Node::Name(name.to_owned()),
            };
            Ok(Part { node, depth: 1 })
        }
    }
}

/// One of the characters, with the space after it; None (and nothing read) where something else stands.
fn symbol<const N: usize>(input: &mut Input<'_>, symbols: [char; N]) -> Result<Option<char>, Failure> {
    let found = opt(one_of(symbols)).parse_next(input)?;
    if found.is_some() {
        space(input)?;
    }
    Ok(found)
}

fn space(input: &mut Input<'_>) -> Result<(), Failure> {
    multispace0.void().parse_next(input)
}

fn join(input: &Input<'_>, operator: Operator, left: Part, right: Part) -> Parsed {
    let depth = left.depth.max(right.depth);
    let node = Node::Binary(operator, Box::new(left.node), Box::new(right.node));
    grow(input, depth, node)
}

/// A node above a tree of the given depth.
fn grow(input: &Input<'_>, depth: usize, node: Node) -> Parsed {
    if depth >= MAX_DEPTH {
        return Err(Failure::at(input, Reason::TooDeep));
    }
    Ok(Part { node, depth: depth + 1 })
}
