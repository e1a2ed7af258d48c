//! The unknowns of a text: whatever has a rate of change, and what [model.start] lists beside.
//!
//! Their order interleaves arrays, u[1], v[1], u[2], v[2], ..., so that chains get narrow bands.

use super::index::values;
use super::scope::{Cell, Scope, show};
use super::{Part, TextError, Written, Wrong};
use crate::expression::{Node, Statement};
use std::collections::{BTreeMap, BTreeSet};

/// Names of the unknowns in the order of the problem.
pub struct Unknowns {
    pub names: Vec<String>,
    /// The unknowns array by array: `order[k]` is the k-th of them.
    pub order: Vec<u32>,
    /// Those without a rate of change, with the entry of [model.start] that declares them.
    pub algebraic: Vec<(usize, usize)>,
    /// How many are scalars; they come first.
    pub scalars: usize,
}

#[derive(Default)]
struct Found {
    /// Names in the order in which they appear.
    names: Vec<String>,
    /// Elements with the place where each first appears.
    elements: BTreeMap<(String, Vec<i64>), usize>,
}

impl Found {
    fn add(&mut self, name: &str, element: Vec<i64>, at: usize) {
        if !self.names.iter().any(|known| known == name) {
            self.names.push(name.to_owned());
        }
        self.elements.entry((name.to_owned(), element)).or_insert(at);
    }
}

/// Finds and orders them, and enters them into the scope; `starts` are the statements of [model.start].
pub fn find(
    scope: &mut Scope<'_>,
    statements: &[Statement],
    written: &Written,
    starts: &[Statement],
) -> Result<Unknowns, TextError> {
    let mut found = Found::default();
    for statement in statements {
        for indices in scope.whole().all(&statement.ranges).map_err(TextError::in_equations)? {
            for side in [&statement.left, &statement.right] {
                rates(scope, side, &indices, &mut found).map_err(TextError::in_equations)?;
            }
        }
    }
    let defined: BTreeSet<&str> = statements.iter().filter_map(|statement| defines(&statement.left)).collect();
    let mut declared: BTreeMap<(String, Vec<i64>), usize> = BTreeMap::new();
    for (entry, (start, (key, _))) in starts.iter().zip(&written.start).enumerate() {
        let wrong = |wrong: Wrong| TextError { part: Part::Start(key.clone()), wrong };
        let (name, indices) = match &start.left {
            Node::Name(name, _) => (name, &[][..]),
            Node::Element(name, indices, _) => (name, &indices[..]),
            _ => {
                let message = "must be the name of an unknown, such as x or \"u[i]\"".to_owned();
                return Err(wrong(Wrong { offset: None, message }));
            }
        };
        let known = found.names.contains(name);
        if defined.contains(name.as_str()) && !known {
            let message = format!("{name} is defined by the equations; only unknowns have a start");
            return Err(wrong(Wrong { offset: None, message }));
        }
        // Without ranges, an entry for a known array speaks of its elements.
        if known && start.ranges.is_empty() {
            continue;
        }
        for local in scope.whole().all(&start.ranges).map_err(wrong)? {
            let element = values(&scope.whole(), indices, &local).map_err(|mut error| {
                error.message +=
                    "; an array without rates of change needs its range here, as in \"w[i]\" = \"0 for i = 1..N\"";
                wrong(error)
            })?;
            if !found.elements.contains_key(&(name.clone(), element.clone())) {
                declared.entry((name.clone(), element.clone())).or_insert(entry);
                found.add(name, element, 0);
            }
        }
    }
    let rank = |name: &str| found.names.iter().position(|known| known == name).unwrap_or(0);
    let mut all: Vec<_> = found.elements.iter().map(|(key, &at)| (key, at, rank(&key.0))).collect();
    all.sort_by(|((_, a), _, rank_a), ((_, b), _, rank_b)| (!a.is_empty(), a, rank_a).cmp(&(!b.is_empty(), b, rank_b)));
    let mut unknowns = Unknowns { names: Vec::new(), order: Vec::new(), algebraic: Vec::new(), scalars: 0 };
    for (i, ((name, element), at, _)) in all.iter().enumerate() {
        let entered = scope.enter(name, element.clone(), Cell::Unknown(i), *at);
        let key = (name.clone(), element.clone());
        match declared.get(&key) {
            Some(&entry) => {
                let part = Part::Start(written.start[entry].0.clone());
                entered.map_err(|Wrong { message, .. }| TextError { part, wrong: Wrong { offset: None, message } })?;
                unknowns.algebraic.push((i, entry));
            }
            None => entered.map_err(TextError::in_equations)?,
        }
        unknowns.scalars += usize::from(element.is_empty());
        unknowns.names.push(show(name, element));
    }
    let mut order: Vec<u32> = (0..all.len() as u32).collect();
    order.sort_by_key(|&i| (all[i as usize].2, i));
    unknowns.order = order;
    Ok(unknowns)
}

/// The name that a statement defines, if it is a definition: `R = ...`, `u[0] = ...`, `f(x) = ...`.
pub fn defines(left: &Node) -> Option<&str> {
    match left {
        Node::Name(name, _) | Node::Element(name, ..) | Node::Apply(name, ..) => Some(name),
        _ => None,
    }
}

/// Collects what has a rate of change in an expression.
fn rates(scope: &Scope<'_>, node: &Node, indices: &[(String, i64)], found: &mut Found) -> Result<(), Wrong> {
    match node {
        Node::Number(_) | Node::Pi | Node::Name(..) => {}
        Node::Rate(inner) => match &**inner {
            Node::Name(name, at) => found.add(name, Vec::new(), at.0),
            Node::Element(name, parts, at) => found.add(name, values(&scope.whole(), parts, indices)?, at.0),
            _ => {}
        },
        Node::Negate(inner) | Node::Call(_, inner, _) => rates(scope, inner, indices, found)?,
        Node::Binary(_, left, right, _) => {
            rates(scope, left, indices, found)?;
            rates(scope, right, indices, found)?;
        }
        Node::Apply(_, parts, _) | Node::Element(_, parts, _) => {
            for part in parts {
                rates(scope, part, indices, found)?;
            }
        }
        Node::Sum(body, range) => {
            let mut any = false;
            body.visit(&mut |node| any |= matches!(node, Node::Rate(_)));
            if any {
                let (from, to) = scope.whole().range(range, indices)?;
                for i in from..=to {
                    let mut inner = indices.to_vec();
                    inner.push((range.name.clone(), i));
                    rates(scope, body, &inner, found)?;
                }
            }
        }
    }
    Ok(())
}
