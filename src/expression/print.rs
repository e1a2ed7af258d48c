//! Printing with as few parentheses as reading back the same tree allows.

use std::fmt::{self, Display, Formatter};

use super::{Expression, Indices, Node, Operator};

/// How tightly a node binds, loosest first; mirrors the levels of the parser.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    Sum,
    Product,
    Unary,
    Atom,
}

impl Display for Expression {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.root.print(f)
    }
}

impl Display for Node {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.print(f)
    }
}

impl Display for Indices {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}..{}", self.name, self.from, self.to)
    }
}

impl Node {
    fn level(&self) -> Level {
        match self {
            Node::Binary(Operator::Add | Operator::Subtract, ..) => Level::Sum,
            Node::Binary(Operator::Multiply | Operator::Divide, ..) => Level::Product,
            Node::Binary(Operator::Power, ..) | Node::Negate(_) => Level::Unary,
            Node::Number(_) | Node::Pi | Node::Name(..) | Node::Element(..) | Node::Rate(_) => Level::Atom,
            Node::Call(..) | Node::Apply(..) | Node::Sum(..) => Level::Atom,
        }
    }

    fn print(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Node::Number(value) => print_number(*value, f),
            Node::Pi => f.write_str("pi"),
            Node::Name(name, _) => f.write_str(name),
            Node::Element(name, indices, _) => print_list(name, ('[', ']'), indices, f),
            Node::Apply(name, arguments, _) => print_list(name, ('(', ')'), arguments, f),
            Node::Rate(inner) => write!(f, "{inner}'"),
            Node::Sum(body, indices) => write!(f, "sum({body}, {indices})"),
            Node::Negate(inner) => {
                f.write_str("-")?;
                inner.print_within(Level::Unary, f)
            }
            Node::Call(function, inner, _) => {
                write!(f, "{}(", function.name())?;
                inner.print(f)?;
                f.write_str(")")
            }
            Node::Binary(operator, left, right, _) => {
                let (symbol, leftmost, rightmost) = match operator {
                    Operator::Add => (" + ", Level::Sum, Level::Product),
                    Operator::Subtract => (" - ", Level::Sum, Level::Product),
                    Operator::Multiply => (" * ", Level::Product, Level::Unary),
                    Operator::Divide => (" / ", Level::Product, Level::Unary),
                    Operator::Power => ("^", Level::Atom, Level::Unary),
                };
                left.print_within(leftmost, f)?;
                f.write_str(symbol)?;
                right.print_within(rightmost, f)
            }
        }
    }

    /// In parentheses if the node binds more loosely than its surroundings ask for.
    fn print_within(&self, loosest: Level, f: &mut Formatter<'_>) -> fmt::Result {
        if self.level() >= loosest {
            return self.print(f);
        }
        f.write_str("(")?;
        self.print(f)?;
        f.write_str(")")
    }
}

fn print_list(name: &str, (open, close): (char, char), parts: &[Node], f: &mut Formatter<'_>) -> fmt::Result {
    write!(f, "{name}{open}")?;
    for (i, part) in parts.iter().enumerate() {
        write!(f, "{}{part}", if i == 0 { "" } else { ", " })?;
    }
    write!(f, "{close}")
}

/// The shortest digits that read back as the same number, with an exponent where zeros would pile up.
fn print_number(value: f64, f: &mut Formatter<'_>) -> fmt::Result {
    if value == 0.0 || (1e-5..1e16).contains(&value) { write!(f, "{value}") } else { write!(f, "{value:e}") }
}
