//! The triangles of all branches of a figure, in a cube, and the lines on them.

use super::view::{Vector, View};
use crate::branch::Branch;
use crate::plot::axis::range;
use crate::plot::geometry::Point;
use crate::plot::value;
use std::collections::BTreeMap;

/// The vertices carry a colour's value and the first Lyapunov coefficient, where there are such.
pub struct Mesh {
    /// Parts of the extent less 1/2, in the order ground, ground, height: the second, third and first free parameter.
    pub vertices: Vec<Vector>,
    pub colour: Vec<Option<f64>>,
    pub criticality: Vec<Option<f64>>,
    pub triangles: Vec<[usize; 3]>,
    /// Names, units and ranges of the three directions.
    pub axes: [(String, String, (f64, f64)); 3],
}

/// A line on the surface from one of its points to another; equal names are equal points.
pub struct Piece {
    pub names: [(usize, usize); 2],
    pub points: [Vector; 2],
}

impl Mesh {
    /// None without a surface that has three coordinates and triangles.
    pub fn new(branches: &[&Branch], colour: &str) -> Option<Mesh> {
        let surfaces: Vec<(&Branch, [usize; 3])> = branches
            .iter()
            .filter(|branch| !branch.triangles.is_empty())
            .filter_map(|branch| match branch.coordinates()[..] {
                [height, x, y] => Some((*branch, [x, y, height])),
                _ => None,
            })
            .collect();
        let &(first, columns) = surfaces.first()?;
        let number = |k: usize| {
            range(surfaces.iter().flat_map(|(b, c)| b.rows.iter().filter_map(move |row| value(row, c[k]))), 0.0)
        };
        let ranges = [number(0), number(1), number(2)];
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        let (mut colours, mut criticality) = (Vec::new(), Vec::new());
        for (branch, columns) in &surfaces {
            let before = vertices.len();
            let column = |name: &str| branch.column(name);
            let (shade, l1) = (column(colour), column("lyapunov"));
            for row in &branch.rows {
                let place = |k: usize| {
                    let (low, high) = ranges[k];
                    value(row, columns[k]).map_or(f64::NAN, |x| (x - low) / (high - low) - 0.5)
                };
                vertices.push([place(0), place(1), place(2)]);
                colours.push(shade.and_then(|k| value(row, k)));
                criticality.push(l1.and_then(|k| value(row, k)));
            }
            let whole = |t: &&[usize; 3]| t.iter().all(|&i| branch.rows.get(i).is_some());
            triangles.extend(branch.triangles.iter().filter(whole).map(|t| t.map(|i| before + i)));
        }
        triangles.retain(|t| t.iter().all(|&i| vertices[i].iter().all(|x| x.is_finite())));
        let axis = |k: usize| {
            let column = first.columns.get(columns[k]);
            let text = |f: fn(&crate::branch::Column) -> &String| column.map(f).cloned().unwrap_or_default();
            (text(|c| &c.name), text(|c| &c.unit), ranges[k])
        };
        let axes = [axis(0), axis(1), axis(2)];
        Some(Mesh { vertices, colour: colours, criticality, triangles, axes })
    }

    /// A triangle's corners.
    pub fn corners(&self, t: [usize; 3]) -> [Vector; 3] {
        t.map(|i| self.vertices[i])
    }

    /// The line on which a quantity of the vertices takes a value.
    pub fn contour(&self, quantity: &[Option<f64>], level: f64) -> Vec<Piece> {
        let mut pieces = Vec::new();
        for t in &self.triangles {
            let [Some(a), Some(b), Some(c)] = t.map(|i| quantity[i].map(|x| x - level)) else { continue };
            let heights = [a, b, c];
            let mut ends = Vec::new();
            for k in 0..3 {
                let (i, j) = (k, (k + 1) % 3);
                if (heights[i] < 0.0) != (heights[j] < 0.0) {
                    let share = heights[i] / (heights[i] - heights[j]);
                    ends.push((
                        (t[i].min(t[j]), t[i].max(t[j])),
                        between(self.vertices[t[i]], self.vertices[t[j]], share),
                    ));
                }
            }
            if let [(from, p), (to, q)] = ends[..] {
                pieces.push(Piece { names: [from, to], points: [p, q] });
            }
        }
        pieces
    }

    /// Edges with a triangle on one side only, and those where the surface turns its back to the eye.
    pub fn outline(&self, view: &View) -> Vec<Piece> {
        let mut sides: BTreeMap<(usize, usize), Vec<bool>> = BTreeMap::new();
        for &t in &self.triangles {
            let [a, b, c] = self.corners(t).map(|v| view.at(v));
            let front = (b.0 - a.0) * (c.1 - a.1) > (b.1 - a.1) * (c.0 - a.0);
            for k in 0..3 {
                let (i, j) = (t[k], t[(k + 1) % 3]);
                sides.entry((i.min(j), i.max(j))).or_default().push(front);
            }
        }
        let edge = |sides: &[bool]| sides.len() == 1 || sides.iter().any(|side| *side != sides[0]);
        let drawn = sides.into_iter().filter(|(_, sides)| edge(sides));
        drawn
            .map(|((i, j), _)| Piece { names: [(i, i), (j, j)], points: [self.vertices[i], self.vertices[j]] })
            .collect()
    }

    /// Pieces joined to curves on the page, without what the surface hides.
    pub fn visible(&self, view: &View, pieces: &[Piece]) -> Vec<Vec<Point>> {
        let flat: Vec<([Point; 3], [f64; 3])> = self
            .triangles
            .iter()
            .map(|&t| (self.corners(t).map(|v| view.at(v)), self.corners(t).map(|v| view.depth(v))))
            .collect();
        let seen: Vec<bool> = pieces
            .iter()
            .map(|piece| {
                let middle = between(piece.points[0], piece.points[1], 0.5);
                let (at, depth) = (view.at(middle), view.depth(middle));
                !flat.iter().any(|(corners, depths)| above(corners, depths, at).is_some_and(|d| d > depth + AT_ONCE))
            })
            .collect();
        let mut ends: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        for (k, piece) in pieces.iter().enumerate().filter(|(k, _)| seen[*k]) {
            piece.names.iter().for_each(|name| ends.entry(*name).or_default().push(k));
        }
        let mut used = vec![false; pieces.len()];
        let mut curves = Vec::new();
        // Open curves from their ends first, then what is left: closed ones.
        let starts: Vec<(usize, usize)> = ends.iter().filter(|(_, k)| k.len() != 2).map(|(name, _)| *name).collect();
        let closed: Vec<(usize, usize)> = ends.keys().copied().collect();
        for start in starts.into_iter().chain(closed) {
            while let Some(curve) = follow(start, pieces, &ends, &mut used) {
                curves.push(curve.into_iter().map(|v| view.at(v)).collect());
            }
        }
        curves
    }
}

/// Points nearer the eye by no more than this, in sides of the cube, are at the same place.
const AT_ONCE: f64 = 0.012;

fn follow(
    start: (usize, usize),
    pieces: &[Piece],
    ends: &BTreeMap<(usize, usize), Vec<usize>>,
    used: &mut [bool],
) -> Option<Vec<Vector>> {
    let (mut name, mut curve) = (start, Vec::new());
    while let Some(&k) = ends.get(&name).and_then(|list| list.iter().find(|k| !used[**k])) {
        used[k] = true;
        let (from, to) = if pieces[k].names[0] == name { (0, 1) } else { (1, 0) };
        if curve.is_empty() {
            curve.push(pieces[k].points[from]);
        }
        curve.push(pieces[k].points[to]);
        name = pieces[k].names[to];
        if ends.get(&name).is_some_and(|list| list.len() > 2) {
            break;
        }
    }
    (!curve.is_empty()).then_some(curve)
}

pub fn between(a: Vector, b: Vector, share: f64) -> Vector {
    [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]))
}

/// The depth of a triangle at a point of the page that lies inside of it.
fn above([a, b, c]: &[Point; 3], depths: &[f64; 3], p: Point) -> Option<f64> {
    if p.0 < a.0.min(b.0).min(c.0) || p.0 > a.0.max(b.0).max(c.0) {
        return None;
    }
    let area = |p: &Point, q: &Point, r: &Point| (q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0);
    let whole = area(a, b, c);
    let shares = [area(&p, b, c), area(&p, c, a), area(&p, a, b)].map(|part| part / whole);
    shares.iter().all(|share| *share >= 0.0).then(|| (0..3).map(|k| shares[k] * depths[k]).sum())
}
