//! Many polygons that cover a region, and the outline of it: sides between two of them cancel.

use crate::plot::geometry::Point;
use crate::plot::stroke;
use std::collections::BTreeMap;

/// Corners lie on a grid of so many to a pixel.
const FINE: f64 = 10.0;

type Corner = (i32, i32);

/// Counts how often each side is run through, forward less backward; polygons must all turn the same way.
#[derive(Default)]
pub struct Region {
    sides: BTreeMap<(Corner, Corner), i32>,
}

impl Region {
    pub fn add(&mut self, polygon: impl IntoIterator<Item = Point>) {
        let corner = |(x, y): Point| ((x * FINE).round() as i32, (y * FINE).round() as i32);
        let corners: Vec<Corner> = polygon.into_iter().map(corner).collect();
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            if a == b {
                continue;
            }
            let (side, turn) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
            let count = self.sides.entry(side).or_insert(0);
            *count += turn;
            if *count == 0 {
                self.sides.remove(&side);
            }
        }
    }

    /// Closed curves, first point repeated, around which the region lies (nonzero winding).
    pub fn outline(self) -> Vec<Vec<Point>> {
        let mut onward: BTreeMap<Corner, Vec<Corner>> = BTreeMap::new();
        for ((a, b), count) in self.sides {
            let (from, to) = if count > 0 { (a, b) } else { (b, a) };
            onward.entry(from).or_default().extend(std::iter::repeat_n(to, count.unsigned_abs() as usize));
        }
        let mut curves = Vec::new();
        while let Some((&start, _)) = onward.first_key_value() {
            let (mut curve, mut here) = (vec![start], start);
            // As many sides end in a corner as begin there, so that the way ends only at its start.
            while let Some(next) = onward.get_mut(&here).and_then(Vec::pop) {
                if onward.get(&here).is_some_and(Vec::is_empty) {
                    onward.remove(&here);
                }
                curve.push(next);
                here = next;
                if here == start {
                    break;
                }
            }
            let points: Vec<Point> = curve.iter().map(|&(x, y)| (f64::from(x) / FINE, f64::from(y) / FINE)).collect();
            curves.push(stroke::thinned(&points));
        }
        curves
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inner_sides_cancel_and_holes_stay() {
        let mut region = Region::default();
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (f64::from(i), f64::from(j)))) {
            if (i, j) != (1.0, 1.0) {
                region.add([(i, j), (i + 1.0, j), (i + 1.0, j + 1.0), (i, j + 1.0)]);
            }
        }
        let outline = region.outline();
        let area = |curve: &Vec<Point>| -> f64 {
            curve.windows(2).map(|pair| 0.5 * (pair[0].0 * pair[1].1 - pair[1].0 * pair[0].1)).sum()
        };
        let mut areas: Vec<f64> = outline.iter().map(area).collect();
        areas.sort_by(f64::total_cmp);
        assert_eq!(areas, [-1.0, 9.0]);
        assert!(outline.iter().all(|curve| curve.len() == 5 && curve[0] == curve[4]));
    }
}
