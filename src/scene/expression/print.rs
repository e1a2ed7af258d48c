//! Printing with as few parentheses as reading back the same tree allows.

use std::fmt::{self, Display, Formatter};

use super::{Expression, Node, Operator};

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

impl Node {
    fn level(&self) -> Level {
        match self {
            Node::Binary(Operator::Add | Operator::Subtract, ..) => Level::Sum,
            Node::Binary(Operator::Multiply | Operator::Divide, ..) => Level::Product,
            Node::Binary(Operator::Power, ..) | Node::Negate(_) => Level::Unary,
            Node::Number(_) | Node::Pi | Node::Name(_) | Node::Call(..) => Level::Atom,
        }
    }

    fn print(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Node::Number(value) => print_number(*value, f),
            Node::Pi => f.write_str("pi"),
            Node::Name(name) => f.write_str(name),
            Node::Negate(inner) => {
                f.write_str("-")?;
                inner.print_within(Level::Unary, f)
            }
            Node::Call(function, inner) => {
                write!(f, "{}(", function.name())?;
                inner.print(f)?;
                f.write_str(")")
            }
            Node::Binary(operator, left, right) => {
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

/// The shortest digits that read back as the same number, with an exponent where zeros would pile up.
fn print_number(value: f64, f: &mut Formatter<'_>) -> fmt::Result {
    if value == 0.0 || (1e-5..1e16).contains(&value) { write!(f, "{value}") } else { write!(f, "{value:e}") }
}
