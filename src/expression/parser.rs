//! The grammar of expressions:
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = unary (("*" | "/") unary)*
//! unary   = "-" unary | power
//! power   = atom ["^" unary]
//! atom    = number | "(" sum ")" | function "(" sum ("," sum)* ")" | "sum" "(" sum "," indices ")" | symbol ["'"]
//! symbol  = name ["[" sum ("," sum)* "]"]
//! indices = name "=" sum ".." sum
//! ```

use winnow::Parser;
use winnow::ascii::{digit0, digit1, multispace0};
use winnow::combinator::{alt, not, opt};
use winnow::error::ParserError;
use winnow::stream::{Stateful, Stream};
use winnow::token::{any, one_of, take_while};

use super::{Fault, Function, Indices, Misplaced, Node, Offset, Operator, RESERVED};

/// Deepest nesting that is read: bounds the recursion of the parser.
const MAX_NESTING: usize = 100;
/// Deepest tree that is built (`a + b + c + ...` nests to the left): bounds the recursion of whoever walks it.
const MAX_DEPTH: usize = 300;

/// The text left to read, how deep the reading has gone, and how long the whole text is.
pub(super) type Input<'a> = Stateful<&'a str, State>;

#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    nesting: usize,
    length: usize,
}

pub(super) fn input(text: &str) -> Input<'_> {
    Input { input: text, state: State { nesting: 0, length: text.len() } }
}

pub(super) type Parsed = Result<Part, Failure>;

/// A tree and its depth.
pub(super) struct Part {
    pub node: Node,
    depth: usize,
}

/// An error and how many bytes were left when it struck.
#[derive(Debug)]
pub(super) struct Failure {
    left: usize,
    reason: Reason,
}

#[derive(Debug)]
enum Reason {
    Expected(&'static str),
    ExpectedCall(&'static str),
    NotAName(&'static str),
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

    pub(super) fn expected(input: &Input<'_>, what: &'static str) -> Failure {
        Failure::at(input, Reason::Expected(what))
    }

    /// Says where in `text`, and what stands there.
    pub(super) fn explain(self, text: &str) -> Misplaced {
        let (read, left) = text.split_at_checked(text.len().saturating_sub(self.left)).unwrap_or((text, ""));
        let expected = |expected: String| Fault::Expected {
            expected,
            found: match left.chars().next() {
                Some(character) => format!("{:?}", character.to_string()),
                None => "the end".to_owned(),
            },
        };
        let fault = match self.reason {
            Reason::Expected(what) => expected(what.to_owned()),
            Reason::ExpectedCall(name) => expected(format!("\"(\" after the function {name}")),
            Reason::NotAName(word) => expected(format!("another name, since {word} has a meaning of its own")),
            Reason::TooLarge(text) => Fault::TooLarge { text },
            Reason::TooDeep => Fault::TooDeep,
        };
        Misplaced { offset: read.len(), fault }
    }
}

/// Where the reading is.
fn here(input: &Input<'_>) -> Offset {
    Offset(input.state.length - input.eof_offset())
}

pub(super) fn parse(text: &str) -> Result<Node, Misplaced> {
    whole(&mut input(text)).map(|part| part.node).map_err(|failure| failure.explain(text))
}

fn whole(input: &mut Input<'_>) -> Parsed {
    space(input)?;
    let part = sum(input)?;
    if input.eof_offset() > 0 {
        return Err(Failure::at(input, Reason::Expected("an operator or the end")));
    }
    Ok(part)
}

pub(super) fn sum(input: &mut Input<'_>) -> Parsed {
    let mut left = product(input)?;
    loop {
        let at = here(input);
        let Some(symbol) = symbol(input, ['+', '-'])? else { return Ok(left) };
        let right = product(input)?;
        let operator = if symbol == '+' { Operator::Add } else { Operator::Subtract };
        left = join(input, (operator, at), left, right)?;
    }
}

fn product(input: &mut Input<'_>) -> Parsed {
    let mut left = unary(input)?;
    loop {
        let at = here(input);
        let Some(symbol) = symbol(input, ['*', '/'])? else { return Ok(left) };
        let right = unary(input)?;
        let operator = if symbol == '*' { Operator::Multiply } else { Operator::Divide };
        left = join(input, (operator, at), left, right)?;
    }
}

/// Every recursion of the grammar passes here, so that here is where nesting is counted.
fn unary(input: &mut Input<'_>) -> Parsed {
    if input.state.nesting >= MAX_NESTING {
        return Err(Failure::at(input, Reason::TooDeep));
    }
    input.state.nesting += 1;
    let part = if symbol(input, ['-'])?.is_some() {
        let inner = unary(input)?;
        grow(input, inner.depth, Node::Negate(Box::new(inner.node)))
    } else {
        power(input)
    };
    input.state.nesting -= 1;
    part
}

fn power(input: &mut Input<'_>) -> Parsed {
    let base = atom(input)?;
    let at = here(input);
    if symbol(input, ['^'])?.is_none() {
        return Ok(base);
    }
    let exponent = unary(input)?;
    join(input, (Operator::Power, at), base, exponent)
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
        // Two points are a range: 1..N.
        alt(((digit1, opt(('.', not('.'), digit0))).void(), ('.', digit1).void())),
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

/// A name, an element of an array, their rates, the constant pi, a function with its arguments, a sum.
fn name(input: &mut Input<'_>) -> Parsed {
    let at = here(input);
    let start = *input;
    let name = word(input)?;
    let function = Function::named(name);
    if name == "sum" && input.input.starts_with('(') {
        return total(input);
    }
    if input.input.starts_with('(') && name != "pi" {
        let (mut arguments, depth) = list(input, ')')?;
        let node = match function {
            Some(function) => match (arguments.pop(), arguments.is_empty()) {
                (Some(argument), true) => Node::Call(function, Box::new(argument), at),
                _ => return Err(Failure::at(input, Reason::Expected("one argument of the function before"))),
            },
            None => Node::Apply(name.to_owned(), arguments, at),
        };
        return grow(input, depth, node);
    }
    if let Some(function) = function {
        return Err(Failure::at(input, Reason::ExpectedCall(function.name())));
    }
    if name == "pi" {
        return Ok(Part { node: Node::Pi, depth: 1 });
    }
    if let Some(word) = RESERVED.iter().find(|word| **word == name) {
        return Err(Failure::at(&start, Reason::NotAName(word)));
    }
    let part = if input.input.starts_with('[') {
        let (indices, depth) = list(input, ']')?;
        grow(input, depth, Node::Element(name.to_owned(), indices, at))?
    } else {
        Part { node: Node::Name(name.to_owned(), at), depth: 1 }
    };
    match symbol(input, ['\''])? {
        Some(_) => grow(input, part.depth, Node::Rate(Box::new(part.node))),
        None => Ok(part),
    }
}

/// `(body, i = a..b)` after the word sum.
fn total(input: &mut Input<'_>) -> Parsed {
    any(input)?;
    space(input)?;
    let body = sum(input)?;
    if symbol(input, [','])?.is_none() {
        return Err(Failure::at(
            input,
            Reason::Expected("an operator or \",\" and an index, as in sum(u[i], i = 1..N)"),
        ));
    }
    let (indices, depth) = indices(input)?;
    if symbol(input, [')'])?.is_none() {
        return Err(Failure::at(input, Reason::Expected("an operator or \")\"")));
    }
    grow(input, depth.max(body.depth), Node::Sum(Box::new(body.node), Box::new(indices)))
}

/// A word, with the space after it.
fn word<'a>(input: &mut Input<'a>) -> Result<&'a str, Failure> {
    let word = take_while(1.., |c: char| c.is_alphanumeric() || c == '_').parse_next(input)?;
    space(input)?;
    Ok(word)
}

/// What stands in parentheses or brackets, and its depth.
fn list(input: &mut Input<'_>, close: char) -> Result<(Vec<Node>, usize), Failure> {
    any(input)?;
    space(input)?;
    let (mut parts, mut depth) = (Vec::new(), 0);
    loop {
        let part = sum(input)?;
        depth = depth.max(part.depth);
        parts.push(part.node);
        match symbol(input, [',', close])? {
            Some(',') => {}
            Some(_) => return Ok((parts, depth)),
            None => {
                let what = if input.input.starts_with('=') {
                    "an operator or \")\", since only sum(BODY, i = FROM..TO) takes an index"
                } else if close == ')' {
                    "an operator or \")\""
                } else {
                    "an operator, \",\" or \"]\""
                };
                return Err(Failure::at(input, Reason::Expected(what)));
            }
        }
    }
}

/// `i = 1..N`
pub(super) fn indices(input: &mut Input<'_>) -> Result<(Indices, usize), Failure> {
    const EXAMPLE: &str = "an index with its range, such as i = 1..N";
    let at = here(input);
    if !input.input.starts_with(|c: char| c.is_alphabetic() || c == '_') {
        return Err(Failure::at(input, Reason::Expected(EXAMPLE)));
    }
    let name = word(input)?;
    if symbol(input, ['='])?.is_none() {
        return Err(Failure::at(input, Reason::Expected("\"=\" and a range, such as i = 1..N")));
    }
    let from = sum(input)?;
    if opt("..").parse_next(input)?.is_none() {
        return Err(Failure::at(input, Reason::Expected("\"..\" and the end of the range, such as i = 1..N")));
    }
    space(input)?;
    let to = sum(input)?;
    let depth = from.depth.max(to.depth);
    Ok((Indices { name: name.to_owned(), from: from.node, to: to.node, at }, depth))
}

/// One of the characters, with the space after it; None (and nothing read) where something else stands.
pub(super) fn symbol<const N: usize>(input: &mut Input<'_>, symbols: [char; N]) -> Result<Option<char>, Failure> {
    let found = opt(one_of(symbols)).parse_next(input)?;
    if found.is_some() {
        space(input)?;
    }
    Ok(found)
}

pub(super) fn space(input: &mut Input<'_>) -> Result<(), Failure> {
    multispace0.void().parse_next(input)
}

fn join(input: &Input<'_>, (operator, at): (Operator, Offset), left: Part, right: Part) -> Parsed {
    let depth = left.depth.max(right.depth);
    let node = Node::Binary(operator, Box::new(left.node), Box::new(right.node), at);
    grow(input, depth, node)
}

/// A node above a tree of the given depth.
fn grow(input: &Input<'_>, depth: usize, node: Node) -> Parsed {
    if depth >= MAX_DEPTH {
        return Err(Failure::at(input, Reason::TooDeep));
    }
    Ok(Part { node, depth: depth + 1 })
}
