//! Statements of a model, one a line:
//!
//! ```text
//! statement = sum "=" sum ["for" indices ("," indices)*]
//! ```
//!
//! A line goes on where parentheses are open, where it ends with an operator, and where the next one begins with `for`
//! or with an operator other than a minus sign. `#` starts a comment.

use winnow::Parser;
use winnow::combinator::opt;
use winnow::stream::Stream;

use super::parser::{Failure, Input, indices, input, space, sum, symbol};
use super::{Fault, Indices, MAX_LENGTH, Misplaced, Node};

/// `left = right for ranges`
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    pub left: Node,
    pub right: Node,
    pub ranges: Vec<Indices>,
    /// The byte of the text at which it starts.
    pub start: usize,
}

/// All statements of a text.
pub fn statements(text: &str) -> Result<Vec<Statement>, Misplaced> {
    lines(&masked(text)).into_iter().map(|(start, line)| read(start, &line)).collect()
}

/// One statement.
pub fn statement(text: &str) -> Result<Statement, Misplaced> {
    read(0, text)
}

fn read(start: usize, line: &str) -> Result<Statement, Misplaced> {
    if line.len() > MAX_LENGTH {
        return Err(Misplaced { offset: start, fault: Fault::TooLong(line.len()) });
    }
    let moved = |Misplaced { offset, fault }| Misplaced { offset: start + offset, fault };
    let mut statement = parse(&mut input(line)).map_err(|failure| moved(failure.explain(line)))?;
    statement.start = start;
    statement.move_by(start);
    Ok(statement)
}

fn parse(input: &mut Input<'_>) -> Result<Statement, Failure> {
    space(input)?;
    let left = sum(input)?.node;
    if symbol(input, ['='])?.is_none() {
        return Err(Failure::expected(input, "an operator or \"=\""));
    }
    let right = sum(input)?.node;
    let mut ranges = Vec::new();
    if opt("for ").parse_next(input)?.is_some() {
        loop {
            space(input)?;
            ranges.push(indices(input)?.0);
            if symbol(input, [','])?.is_none() {
                break;
            }
        }
    }
    if input.eof_offset() > 0 {
        return Err(Failure::expected(
            input,
            if ranges.is_empty() {
                "an operator, \"for\" or the end of the line"
            } else {
                "an operator, \",\" or the end of the line"
            },
        ));
    }
    Ok(Statement { left, right, ranges, start: 0 })
}

/// The text with comments blanked out, byte by byte.
fn masked(text: &str) -> String {
    let mut comment = false;
    text.chars()
        .flat_map(|c| {
            comment = (comment || c == '#') && c != '\n';
            let (c, count) = if comment { (' ', c.len_utf8()) } else { (c, 1) };
            std::iter::repeat_n(c, count)
        })
        .collect()
}

/// Statements with the bytes at which they start; blank lines are left out.
fn lines(text: &str) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let (mut start, mut open) = (0, false);
    for line in text.split_inclusive('\n') {
        let trimmed = line.trim();
        let goes_on = trimmed.starts_with(['+', '*', '/', '^', ')', ']', ',', '=']) || trimmed.starts_with("for ");
        match found.last_mut() {
            Some((_, statement)) if (open || goes_on) || trimmed.is_empty() => statement.push_str(line),
            _ if trimmed.is_empty() => {}
            _ => {
                let indent = line.len() - line.trim_start().len();
                found.push((start + indent, line[indent..].to_owned()));
            }
        }
        start += line.len();
        if let (Some((_, statement)), false) = (found.last(), trimmed.is_empty()) {
            let depth = statement
                .chars()
                .fold(0_i64, |depth, c| depth + i64::from(matches!(c, '(' | '[')) - i64::from(matches!(c, ')' | ']')));
            open = depth > 0 || trimmed.ends_with(['+', '-', '*', '/', '^', ',', '=', '(', '[']);
        }
    }
    for (_, statement) in &mut found {
        statement.truncate(statement.trim_end().len());
    }
    found
}

impl Statement {
    /// Offsets count from the start of the text, not of the statement.
    fn move_by(&mut self, by: usize) {
        if by == 0 {
            return;
        }
        self.left.move_by(by);
        self.right.move_by(by);
        self.ranges.iter_mut().for_each(|indices| indices.move_by(by));
    }
}

impl Indices {
    fn move_by(&mut self, by: usize) {
        self.at.0 += by;
        self.from.move_by(by);
        self.to.move_by(by);
    }
}

impl Node {
    fn move_by(&mut self, by: usize) {
        match self {
            Node::Number(_) | Node::Pi => {}
            Node::Name(_, at) => at.0 += by,
            Node::Rate(inner) | Node::Negate(inner) => inner.move_by(by),
            Node::Call(_, inner, at) => {
                at.0 += by;
                inner.move_by(by);
            }
            Node::Binary(_, left, right, at) => {
                at.0 += by;
                left.move_by(by);
                right.move_by(by);
            }
            Node::Element(_, parts, at) | Node::Apply(_, parts, at) => {
                at.0 += by;
                parts.iter_mut().for_each(|part| part.move_by(by));
            }
            Node::Sum(body, indices) => {
                body.move_by(by);
                indices.move_by(by);
            }
        }
    }
}
