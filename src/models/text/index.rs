//! Whole numbers: indices and the ends of their ranges.

use super::{MAX_ELEMENTS, Wrong};
use crate::expression::{Indices, Node, Operator};

/// Indices with their values, innermost last.
pub type Indexed = Vec<(String, i64)>;

/// Evaluates whole numbers in constants and indices.
pub struct Whole<'a> {
    pub constants: &'a [(String, i64)],
}

impl Whole<'_> {
    pub fn value(&self, node: &Node, indices: &[(String, i64)]) -> Result<i64, Wrong> {
        let here = || node.offset();
        let wrong = |message: String| Wrong { offset: here(), message };
        let beyond = || wrong(format!("{node} is not a whole number of reasonable size"));
        match node {
            Node::Number(x) if x.fract() == 0.0 && *x < 1e15 => Ok(*x as i64),
            Node::Number(x) => Err(wrong(format!("{x} is not a whole number, which an index must be"))),
            Node::Name(name, _) => {
                let mut known = indices.iter().rev().chain(self.constants);
                known.find(|(known, _)| known == name).map(|(_, value)| *value).ok_or_else(|| {
                    let names: Vec<&str> =
                        indices.iter().chain(self.constants).map(|(name, _)| name.as_str()).collect();
                    let names = if names.is_empty() { "numbers alone".to_owned() } else { names.join(", ") };
                    wrong(format!("{name:?} is not a whole number known here; known are {names}"))
                })
            }
            Node::Negate(inner) => self.value(inner, indices)?.checked_neg().ok_or_else(beyond),
            Node::Binary(operator, left, right, _) => {
                let (a, b) = (self.value(left, indices)?, self.value(right, indices)?);
                let value = match operator {
                    Operator::Add => a.checked_add(b),
                    Operator::Subtract => a.checked_sub(b),
                    Operator::Multiply => a.checked_mul(b),
                    Operator::Divide => a.checked_rem(b).filter(|rest| *rest == 0).and_then(|_| a.checked_div(b)),
                    Operator::Power => u32::try_from(b).ok().and_then(|b| a.checked_pow(b)),
                };
                value.ok_or_else(beyond)
            }
            _ => Err(wrong(format!("{node} is not a whole number in indices and constants"))),
        }
    }

    /// Both ends, included.
    pub fn range(&self, range: &Indices, indices: &[(String, i64)]) -> Result<(i64, i64), Wrong> {
        let (from, to) = (self.value(&range.from, indices)?, self.value(&range.to, indices)?);
        let at = range.at.0;
        if from > to {
            return Err(Wrong::new(at, format!("the range {range} is empty: it runs from {from} to {to}")));
        }
        match to.checked_sub(from) {
            Some(length) if length < MAX_ELEMENTS as i64 => Ok((from, to)),
            _ => Err(Wrong::new(
                at,
                format!("the range {range} is too long; at most {MAX_ELEMENTS} elements are allowed"),
            )),
        }
    }

    /// All values of the indices of a statement, the last one fastest.
    pub fn all(&self, ranges: &[Indices]) -> Result<Vec<Indexed>, Wrong> {
        let mut all: Vec<Indexed> = vec![Vec::new()];
        for range in ranges {
            let mut longer = Vec::new();
            for outer in all {
                if outer.iter().any(|(name, _)| *name == range.name) {
                    return Err(Wrong::new(range.at.0, format!("the index {} has two ranges; keep one", range.name)));
                }
                let (from, to) = self.range(range, &outer)?;
                if longer.len() as i64 + (to - from) >= MAX_ELEMENTS as i64 {
                    let message = format!("more than {MAX_ELEMENTS} elements; choose a smaller size");
                    return Err(Wrong::new(range.at.0, message));
                }
                longer.extend((from..=to).map(|i| {
                    let mut inner = outer.clone();
                    inner.push((range.name.clone(), i));
                    inner
                }));
            }
            all = longer;
        }
        Ok(all)
    }
}

/// The values of several indices.
pub fn values(whole: &Whole<'_>, nodes: &[Node], indices: &[(String, i64)]) -> Result<Vec<i64>, Wrong> {
    nodes.iter().map(|node| whole.value(node, indices)).collect()
}
