//! `G_u` and `G_v` from the pattern of the text.
//!
//! Columns of which no two meet in a row are differentiated together (Curtis, Powell and Reid 1974,
//! doi:10.1093/imamat/13.1.117), in colours given first come, first served. A mass that is constant, as in `x' = ...`,
//! is read off once.

use super::graph::{Code, Graph, Vertex};
use super::rows::Row;
use super::tape::Tape;
use crate::linalg::Matrix;
use crate::problem::At;
use num_dual::Dual64;

/// Beyond so many comparisons of columns each gets a colour of its own.
const MOST_COMPARISONS: usize = 100_000_000;

/// Columns of one colour, and the entries (row, column) that they fill.
type Colour = (Vec<u32>, Vec<(u32, u32)>);

/// How to fill a matrix of first derivatives.
#[derive(Clone, Debug)]
enum Filling {
    Coloured(Vec<Colour>),
    Constant(Vec<(u32, u32, f64)>),
}

#[derive(Clone, Debug)]
pub struct Linearisation {
    by_state: Filling,
    by_rate: Filling,
}

impl Linearisation {
    pub fn new(graph: &Graph, rows: &[Row]) -> Self {
        let state = coloured(rows.len(), rows.iter().map(|row| &row.unknowns[..]));
        let rate = match constant_mass(graph, rows) {
            Some(entries) => Filling::Constant(entries),
            None => coloured(rows.len(), rows.iter().map(|row| &row.rates[..])),
        };
        Self { by_state: state, by_rate: rate }
    }

    pub fn fill(&self, tape: &Tape, at: At, gu: &mut Matrix, gv: &mut Matrix) {
        let lift = |x: &[f64]| -> Vec<Dual64> { x.iter().map(|&x| Dual64::from_re(x)).collect() };
        let (mut u, mut v, p) = (lift(at.u), lift(at.v), lift(at.p));
        let mut g = vec![Dual64::from_re(0.0); u.len()];
        self.by_state.fill(gu, &mut u, &mut g, |u, g| tape.evaluate(u, &v, &p, g));
        self.by_rate.fill(gv, &mut v, &mut g, |v, g| tape.evaluate(&u, v, &p, g));
    }
}

impl Filling {
    fn fill(
        &self,
        matrix: &mut Matrix,
        x: &mut [Dual64],
        g: &mut [Dual64],
        evaluate: impl Fn(&[Dual64], &mut [Dual64]),
    ) {
        clear(matrix);
        match self {
            Filling::Constant(entries) => {
                entries.iter().for_each(|&(i, j, value)| put(matrix, i as usize, j as usize, value));
            }
            Filling::Coloured(colours) => {
                for (columns, entries) in colours {
                    columns.iter().for_each(|&j| x[j as usize].eps = 1.0);
                    evaluate(x, g);
                    columns.iter().for_each(|&j| x[j as usize].eps = 0.0);
                    entries.iter().for_each(|&(i, j)| put(matrix, i as usize, j as usize, g[i as usize].eps));
                }
            }
        }
    }
}

fn clear(matrix: &mut Matrix) {
    match matrix {
        Matrix::Dense(a) => a.fill(0.0),
        Matrix::Banded(a) => a.fill(0.0),
        Matrix::Sparse(a) => a.values.fill(0.0),
    }
}

fn put(matrix: &mut Matrix, i: usize, j: usize, value: f64) {
    match matrix {
        Matrix::Dense(a) => a[(i, j)] = value,
        Matrix::Banded(a) => {
            let first = a.columns(i).start;
            a.row_mut(i)[j - first] = value;
        }
        Matrix::Sparse(a) => {
            let (range, rows) = a.pattern.column(j);
            if let Ok(k) = rows.binary_search(&i) {
                a.values[range.start + k] = value;
            }
        }
    }
}

fn coloured<'a>(n: usize, rows: impl Iterator<Item = &'a [u32]>) -> Filling {
    let rows: Vec<&[u32]> = rows.collect();
    let mut columns: Vec<Vec<u32>> = vec![Vec::new(); n];
    for (row, i) in rows.iter().zip(0..) {
        row.iter().for_each(|&j| columns[j as usize].push(i));
    }
    let comparisons: usize = rows.iter().map(|row| row.len() * row.len()).sum();
    let mut colour = vec![u32::MAX; n];
    let mut taken: Vec<usize> = Vec::new();
    for j in 0..n {
        if columns[j].is_empty() {
            continue;
        }
        if comparisons > MOST_COMPARISONS {
            colour[j] = j as u32;
            continue;
        }
        let neighbours = columns[j].iter().flat_map(|&i| rows[i as usize]);
        for &other in neighbours {
            if let Some(taken) = taken.get_mut(colour[other as usize] as usize) {
                *taken = j;
            }
        }
        let free = (0..taken.len()).find(|&c| taken[c] != j).unwrap_or(taken.len());
        if free == taken.len() {
            taken.push(usize::MAX);
        }
        colour[j] = free as u32;
    }
    let count = colour.iter().filter(|&&c| c != u32::MAX).max().map_or(0, |&c| c as usize + 1);
    let mut colours: Vec<Colour> = vec![Default::default(); count];
    for (j, column) in (0..).zip(&columns) {
        if let Some((members, entries)) = colours.get_mut(colour[j as usize] as usize) {
            members.push(j);
            entries.extend(column.iter().map(|&i| (i, j)));
        }
    }
    colours.retain(|(members, _)| !members.is_empty());
    Filling::Coloured(colours)
}

/// The mass, if it is the same everywhere.
fn constant_mass(graph: &Graph, rows: &[Row]) -> Option<Vec<(u32, u32, f64)>> {
    let (mut entries, mut visits) = (Vec::new(), 0);
    for (row, i) in rows.iter().zip(0..) {
        let mut factors: Vec<(u32, f64)> = Vec::new();
        let mut open = vec![(row.id, 1.0)];
        while let Some((id, factor)) = open.pop() {
            let placed = &graph.vertices[id as usize];
            if placed.degree == 0 {
                continue;
            }
            match placed.vertex {
                Vertex::Rate(j) => match factors.iter_mut().find(|(known, _)| *known == j) {
                    Some((_, sum)) => *sum += factor,
                    None => factors.push((j, factor)),
                },
                Vertex::Operation(Code::Add, a, b) => open.extend([(a, factor), (b, factor)]),
                Vertex::Operation(Code::Subtract, a, b) => open.extend([(a, factor), (b, -factor)]),
                Vertex::Operation(Code::Negate, a, _) => open.push((a, -factor)),
                Vertex::Operation(Code::Multiply, a, b) => match (graph.value(a), graph.value(b)) {
                    (Some(a), _) => open.push((b, factor * a)),
                    (_, Some(b)) => open.push((a, factor * b)),
                    _ => return None,
                },
                Vertex::Operation(Code::Divide, a, b) => open.push((a, factor / graph.value(b)?)),
                _ => return None,
            }
            // Shared parts are met once for each way that leads to them: there must not be many.
            visits += 1;
            if visits > 100 * rows.len() + 10_000 {
                return None;
            }
        }
        entries.extend(factors.into_iter().map(|(j, factor)| (i, j, factor)));
    }
    Some(entries)
}
