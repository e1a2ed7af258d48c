//! The coloured part of each cell of a map: the unstable part, one piece for each mode that leads in it.
//!
//! Numbers vary linearly along the sides of a cell. The state is unstable where the growth, so interpolated, is
//! positive. Between neighbours at which different modes lead, each is taken to be the other's next mode, so that both
//! growths are known at both ends and the lead changes where the lines through them cross; on either side the shown
//! number goes on as it came, so that it may jump there.

use super::grid::{Grid, Node};
use crate::plot::geometry::Point;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    pub at: Point,
    pub growth: f64,
    pub value: f64,
}

/// A polygon whose sides are straight and along which all numbers vary linearly.
pub type Piece = Vec<Vertex>;

/// The corners of a cell, around it.
const CORNERS: [(usize, usize); 4] = [(0, 0), (1, 0), (1, 1), (0, 1)];

/// The unstable pieces of all cells that have four corners.
pub fn pieces(grid: &Grid) -> Vec<Piece> {
    let cells = (1..grid.x.len()).flat_map(|i| (1..grid.y.len()).map(move |j| (i - 1, j - 1)));
    let mut pieces = Vec::new();
    for (i, j) in cells {
        let corners = CORNERS.map(|(di, dj)| grid.node(i + di, j + dj));
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { continue };
        let corners = [a, b, c, d];
        if corners.iter().all(|node| node.growth <= 0.0) {
            continue;
        }
        for piece in by_mode(grid, (i, j), corners) {
            let unstable = clipped(&piece, |vertex| vertex.growth, 0.0);
            if unstable.len() > 2 {
                pieces.push(unstable);
            }
        }
    }
    pieces
}

/// The part of a piece where a number is at least `level` (Sutherland and Hodgman 1974).
pub fn clipped(piece: &[Vertex], number: impl Fn(&Vertex) -> f64, level: f64) -> Piece {
    let mut out = Vec::with_capacity(piece.len() + 2);
    for (k, a) in piece.iter().enumerate() {
        let b = &piece[(k + 1) % piece.len()];
        let (from, to) = (number(a) >= level, number(b) >= level);
        if from {
            out.push(*a);
        }
        if from != to {
            // Both cells at a side must find the same point: always from the same end.
            let (a, b) = if a.at < b.at { (a, b) } else { (b, a) };
            out.push(between(a, b, (level - number(a)) / (number(b) - number(a))));
        }
    }
    out
}

fn between(a: &Vertex, b: &Vertex, t: f64) -> Vertex {
    let mix = |a: f64, b: f64| a + t * (b - a);
    Vertex {
        at: (mix(a.at.0, b.at.0), mix(a.at.1, b.at.1)),
        growth: mix(a.growth, b.growth),
        value: mix(a.value, b.value),
    }
}

fn by_mode(grid: &Grid, (i, j): (usize, usize), corners: [&Node; 4]) -> Vec<Piece> {
    let place = |k: usize| (i + CORNERS[k % 4].0, j + CORNERS[k % 4].1);
    let whole = |node: &Node| Vertex { at: node.at, growth: node.growth, value: node.value };
    // Corners that are connected along the sides have the same mode.
    let mut modes = [0, 1, 2, 3];
    for k in (0..4).filter(|&k| grid.continuous(place(k), place(k + 1))) {
        let (old, new) = (modes[k], modes[(k + 1) % 4]);
        modes.iter_mut().filter(|mode| **mode == old).for_each(|mode| *mode = new);
    }
    let mut distinct = modes.to_vec();
    distinct.sort_unstable();
    distinct.dedup();
    if distinct.len() == 1 {
        return vec![corners.iter().map(|node| whole(node)).collect()];
    }
    let centre = |piece: &[Vertex]| Vertex {
        at: (0.5 * (corners[0].at.0 + corners[2].at.0), 0.5 * (corners[0].at.1 + corners[2].at.1)),
        growth: corners.iter().map(|node| node.growth).sum::<f64>() / 4.0,
        value: piece.iter().map(|vertex| vertex.value).sum::<f64>() / piece.len().max(1) as f64,
    };
    let mut pieces = Vec::new();
    for &mode in &distinct {
        let (mut piece, mut middle) = (Vec::new(), None);
        for k in 0..4 {
            let (here, next) = (modes[k] == mode, modes[(k + 1) % 4] == mode);
            if here {
                piece.push(whole(corners[k]));
            }
            if here && !next {
                piece.extend(border(grid, place(k), place(k + 1)));
                middle = Some(piece.len());
            }
            if next && !here {
                piece.extend(border(grid, place(k + 1), place(k)));
            }
        }
        // Where three modes meet, their pieces meet in the middle of the cell.
        if let Some(place) = middle.filter(|_| distinct.len() > 2) {
            piece.insert(place, centre(&piece));
        }
        pieces.push(piece);
    }
    pieces
}

/// Where the mode of `inside` loses the lead on the way to its neighbour `outside`, with the number extrapolated.
fn border(grid: &Grid, inside: (usize, usize), outside: (usize, usize)) -> Option<Vertex> {
    let (inner, outer) = (grid.node(inside.0, inside.1)?, grid.node(outside.0, outside.1)?);
    // The same point for both sides, to the last bit: always from the same end.
    let turned = outer.at < inner.at;
    let (a, b) = if turned { (outer, inner) } else { (inner, outer) };
    let (own, other) = (a.gap.unwrap_or(0.0), b.gap.unwrap_or(0.0));
    let t = if own + other > 0.0 { own / (own + other) } else { 0.5 };
    let mix = |a: f64, b: f64| a + t * (b - a);
    let behind = |from: usize, to: usize| (2 * from).checked_sub(to);
    let before = behind(inside.0, outside.0).zip(behind(inside.1, outside.1));
    let before = before.filter(|&before| grid.continuous(before, inside)).and_then(|(i, j)| grid.node(i, j));
    let slope = before.map_or(0.0, |before| inner.value - before.value);
    Some(Vertex {
        at: (mix(a.at.0, b.at.0), mix(a.at.1, b.at.1)),
        growth: mix(a.growth, b.growth - other),
        value: inner.value + if turned { 1.0 - t } else { t } * slope,
    })
}
