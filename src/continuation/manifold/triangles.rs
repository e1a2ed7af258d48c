//! The triangulation that is dual to the charts' polygons.
//!
//! Each chart knows its neighbours in counterclockwise order. Such an order at every point, with every edge known to
//! both its ends, is a surface (Edmonds 1960): the faces are found by turning left at each point, and every
//! side of an edge belongs to exactly one of them. Faces are triangles but where four or more charts nearly meet in a point;
//! there, sides too short to be trusted are left out, and the face is divided by its shortest diagonals.

use super::polygon::{Side, apart};
use super::{Cover, Surface};
use std::collections::{BTreeMap, BTreeSet};

/// Sides shorter than this part of the radius may look different from the chart beyond.
const SHORT: f64 = 0.1;
/// Faces with more corners are holes.
const MOST_CORNERS: usize = 8;

impl<S: Surface> Cover<S> {
    /// Triples of charts, counterclockwise; none twice, and without holes where the surface is covered.
    pub fn triangles(&self) -> Vec<[usize; 3]> {
        let around = self.rotations();
        // Where a half-edge i -> j stands in the order of its end.
        let mut place: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        for (j, order) in around.iter().enumerate() {
            place.extend(order.iter().enumerate().filter_map(|(k, i)| Some(((i.as_ref().copied()?, j), k))));
        }
        let left = |(i, j): (usize, usize)| {
            let k = place.get(&(i, j))?;
            let order = &around[j];
            order[(k + order.len() - 1) % order.len()].map(|next| (j, next))
        };
        let mut seen = BTreeSet::new();
        let mut triangles = Vec::new();
        for &start in place.keys() {
            let (mut edge, mut face, mut open) = (start, Vec::new(), false);
            while seen.insert(edge) {
                face.push(edge.0);
                match left(edge) {
                    Some(next) => edge = next,
                    None => open = true,
                }
            }
            // A face that meets a gap, or that leads into one that was seen to, is none.
            if !open && edge == start && (3..=MOST_CORNERS).contains(&face.len()) {
                self.split(face, &mut triangles);
            }
        }
        triangles
    }

    /// Neighbours of each chart in counterclockwise order, None for a gap; every edge stands in both its ends' orders.
    fn rotations(&self) -> Vec<Vec<Option<usize>>> {
        let sides: Vec<Vec<(Side, f64, bool)>> = self
            .charts
            .iter()
            .map(|chart| {
                let polygon = &chart.polygon;
                (0..polygon.0.len())
                    .map(|k| {
                        let (a, b) = polygon.ends(k);
                        let next = (k + 1) % polygon.0.len();
                        let at_bound =
                            [polygon.meeting(k).0, polygon.0[next].1].iter().any(|s| matches!(s, Side::Bound(_)));
                        (polygon.0[k].1, apart(a, b), at_bound)
                    })
                    .collect()
            })
            .collect();
        let mut lengths: BTreeMap<(usize, usize), (f64, bool)> = BTreeMap::new();
        for (i, sides) in sides.iter().enumerate() {
            for &(side, length, at_bound) in sides {
                if let Side::Neighbour(j) = side {
                    lengths.insert((i, j), (length, at_bound));
                }
            }
        }
        let trusted = |i: usize, j: usize| {
            let (Some(&(here, at)), Some(&(there, end))) = (lengths.get(&(i, j)), lengths.get(&(j, i))) else {
                return false;
            };
            let common = self.charts[i].on.iter().any(|k| self.charts[j].on.contains(k));
            (at && end && common) || here.min(there) > SHORT * self.charts[i].radius.min(self.charts[j].radius)
        };
        let entry = |i: usize, side: Side| match side {
            // A covering that was cut short has lost some.
            Side::Neighbour(j) if j >= self.charts.len() => Some(None),
            Side::Neighbour(j) => trusted(i, j).then_some(Some(j)),
            Side::Open | Side::Bound(_) => Some(None),
        };
        sides
            .iter()
            .enumerate()
            .map(|(i, sides)| sides.iter().filter_map(|&(side, ..)| entry(i, side)).collect())
            .collect()
    }

    fn split(&self, mut face: Vec<usize>, triangles: &mut Vec<[usize; 3]>) {
        while face.len() > 3 {
            let m = face.len();
            let diagonal = |k: &usize| self.distance(face[(k + m - 1) % m], face[(k + 1) % m]);
            let Some(k) = (0..m).min_by(|a, b| diagonal(a).total_cmp(&diagonal(b))) else { return };
            triangles.push([face[(k + m - 1) % m], face[k], face[(k + 1) % m]]);
            face.remove(k);
        }
        if let [a, b, c] = face[..] {
            triangles.push([a, b, c]);
        }
    }

    fn distance(&self, i: usize, j: usize) -> f64 {
        let (a, b) = (&self.charts[i], &self.charts[j]);
        let d: Vec<f64> = a.x.iter().zip(&b.x).map(|(a, b)| a - b).collect();
        a.surface.inner(&d, &d).sqrt()
    }
}
