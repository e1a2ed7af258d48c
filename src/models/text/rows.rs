//! The equations `left - right = 0`, one for each unknown, and the pattern of their derivatives.

use super::graph::{Graph, Id, Vertex};
use super::{MAX_PATTERN, Wrong};
use crate::linalg::{Pattern, Structure};
use std::sync::Arc;

/// Bands are worth their while from this size on, where they are this many times narrower than the matrix; wide ones only
/// where they are not nearly empty.
const LEAST_BANDED: usize = 16;
const NARROW: usize = 3;
const WIDE: usize = 40;
const EMPTY: usize = 4;
/// Sparse algebra is, from this size on, where this part of the entries at most may differ from zero.
const LEAST_SPARSE: usize = 200;
const SPARSE: usize = 8;
/// Most unknowns of dense algebra.
const MOST_DENSE: usize = 4000;

/// An equation.
#[derive(Clone, Debug)]
pub struct Row {
    pub id: Id,
    /// Where it stands.
    pub at: usize,
    /// Unknowns and rates in it.
    pub unknowns: Vec<u32>,
    pub rates: Vec<u32>,
}

/// What each of the vertices depends on.
pub fn dependencies(graph: &Graph, rows: &mut [Row]) -> Result<(), Wrong> {
    let mut seen: Vec<u32> = vec![0; graph.vertices.len()];
    let (mut stack, mut visits) = (Vec::new(), 0_usize);
    for (row, mark) in rows.iter_mut().zip(1..) {
        stack.push(row.id);
        while let Some(id) = stack.pop() {
            if std::mem::replace(&mut seen[id as usize], mark) == mark {
                continue;
            }
            visits += 1;
            match graph.vertices[id as usize].vertex {
                Vertex::Unknown(i) => row.unknowns.push(i),
                Vertex::Rate(i) => row.rates.push(i),
                Vertex::Parameter(_) | Vertex::Constant(_) => {}
                Vertex::Operation(_, a, b) => stack.extend([a, b]),
            }
        }
        if visits > MAX_PATTERN {
            let message = "the equations depend on too many unknowns each; choose a smaller size".to_owned();
            return Err(Wrong::new(row.at, message));
        }
        row.unknowns.sort_unstable();
        row.rates.sort_unstable();
    }
    Ok(())
}

/// The unknown that a row determines, of those not taken.
type Pick = fn(&Row, &[Option<Row>]) -> Option<u32>;

/// Rows in the order of the unknowns that they are taken to determine: the one whose rate of change they give; of what
/// is left, the first that occurs.
pub fn assign(rows: Vec<Row>, n: usize) -> Vec<Row> {
    let mut taken: Vec<Option<Row>> = (0..n).map(|_| None).collect();
    let mut left = rows;
    let picks: [Pick; 4] = [
        |row, taken| match row.rates[..] {
            [only] if taken[only as usize].is_none() => Some(only),
            _ => None,
        },
        |row, taken| row.rates.iter().copied().find(|&i| taken[i as usize].is_none()),
        |row, taken| row.unknowns.iter().copied().find(|&i| taken[i as usize].is_none()),
        |_, taken| taken.iter().position(Option::is_none).map(|i| i as u32),
    ];
    for pick in picks {
        let mut rest = Vec::new();
        for row in left {
            match pick(&row, &taken) {
                Some(i) => taken[i as usize] = Some(row),
                None => rest.push(row),
            }
        }
        left = rest;
    }
    taken.into_iter().flatten().collect()
}

/// Bands where they are narrow, else the pattern where it has few entries.
pub fn structure(rows: &[Row]) -> Result<Structure, Wrong> {
    let n = rows.len();
    let entries = || {
        rows.iter()
            .enumerate()
            .flat_map(|(i, row)| row.unknowns.iter().chain(&row.rates).map(move |&j| (i, j as usize)))
    };
    let (mut lower, mut upper, mut count) = (0, 0, 0);
    for (i, j) in entries() {
        lower = lower.max(i.saturating_sub(j));
        upper = upper.max(j.saturating_sub(i));
        count += 1;
    }
    let band = lower + upper + 1;
    if n >= LEAST_BANDED && NARROW * band <= n && (band <= WIDE || EMPTY * count >= n * band) {
        return Ok(Structure::Banded { lower, upper });
    }
    if n >= LEAST_SPARSE && SPARSE * count <= n * n {
        return Ok(Structure::Sparse(Arc::new(Pattern::new(n, entries()))));
    }
    if n > MOST_DENSE {
        let message = format!(
            "{n} unknowns, of which each equation couples {} on the average: at most {MOST_DENSE} are allowed where there are \
             so many; choose a smaller size",
            count / n
        );
        return Err(Wrong { offset: None, message });
    }
    Ok(Structure::Dense)
}
