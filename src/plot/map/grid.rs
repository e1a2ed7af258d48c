//! The grid of a map as it lies on the page.

use crate::branch::Branch;
use crate::plot::geometry::Point;
use crate::plot::value;

/// A grid point with numbers.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    pub at: Point,
    pub growth: f64,
    pub value: f64,
    /// By how much its mode leads, if known: what the growth of the next mode lacks.
    pub gap: Option<f64>,
    /// Whether another mode leads at the next node along x, and along y.
    jumps: [bool; 2],
}

/// Where the grid lines run, and the nodes, those of one x after another; None where a number is missing.
pub struct Grid {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    nodes: Vec<Option<Node>>,
}

impl Grid {
    /// From the rows of a branch, in any order; the columns are numbers of columns.
    pub fn new(branch: &Branch, [x, y]: [usize; 2], column: usize) -> Option<Grid> {
        let (growth, gap) = (branch.column("growth")?, branch.column("gap"));
        let jumps = [x, y].map(|k| branch.column(&format!("jump {}", branch.columns.get(k)?.name)));
        let lines = |column: usize| -> Vec<f64> {
            let mut found: Vec<f64> = branch.rows.iter().filter_map(|row| value(row, column)).collect();
            found.sort_by(f64::total_cmp);
            found.dedup();
            found
        };
        let (xs, ys) = (lines(x), lines(y));
        if xs.len() < 2 || ys.len() < 2 {
            return None;
        }
        let mut nodes = vec![None; xs.len() * ys.len()];
        for row in &branch.rows {
            let (Some(a), Some(b)) = (value(row, x), value(row, y)) else { continue };
            let place = |lines: &[f64], value: f64| lines.binary_search_by(|line| line.total_cmp(&value)).ok();
            let (Some(i), Some(j)) = (place(&xs, a), place(&ys, b)) else { continue };
            let (Some(growth), Some(shown)) = (value(row, growth), value(row, column)) else { continue };
            let gap = gap.and_then(|column| value(row, column));
            let jumps = jumps.map(|column| column.and_then(|column| value(row, column)) == Some(1.0));
            nodes[i * ys.len() + j] = Some(Node { at: (a, b), growth, value: shown, gap, jumps });
        }
        Some(Grid { x: xs, y: ys, nodes })
    }

    pub fn node(&self, i: usize, j: usize) -> Option<&Node> {
        if i >= self.x.len() || j >= self.y.len() {
            return None;
        }
        self.nodes.get(i * self.y.len() + j)?.as_ref()
    }

    /// Whether the same mode leads at two neighbours.
    pub fn continuous(&self, a: (usize, usize), b: (usize, usize)) -> bool {
        let jumps = self.node(a.0.min(b.0), a.1.min(b.1)).map_or([true; 2], |node| node.jumps);
        if a.1 == b.1 { !jumps[0] } else { !jumps[1] }
    }

    /// Nodes where the state is unstable: those that are shown.
    pub fn unstable(&self) -> impl Iterator<Item = &Node> {
        self.nodes.iter().flatten().filter(|node| node.growth > 0.0)
    }

    /// Puts other places and numbers in all nodes.
    pub fn changed(mut self, place: impl Fn(Point) -> Point, number: impl Fn(f64) -> f64) -> Grid {
        for node in self.nodes.iter_mut().flatten() {
            (node.at, node.value) = (place(node.at), number(node.value));
        }
        self
    }
}
