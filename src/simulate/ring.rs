//! Whether the returns to a section lie on a closed curve, as those of a quasi-periodic motion do.

use super::form::norm;
use crate::linalg::dot;
use std::f64::consts::TAU;

/// A closed curve of returns.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// How many returns it was judged by.
    pub returns: usize,
    /// Largest distance of a return from the line between its neighbours along the curve, in parts of the curve's size.
    pub deviation: f64,
    /// Mean turn about the centre from one return to the next, in turns.
    pub rotation: f64,
}

const FEWEST: usize = 24;
/// Returns lie this close to the polygon through their neighbours.
const CLOSE: f64 = 0.05;
/// The widest gap between neighbours, in turns.
const GAP: f64 = 0.25;

impl Ring {
    /// The plane of the two largest spreads shows the curve; distances are those in the whole space. `least` is the
    /// smallest size that is more than the integration's error.
    pub fn of(points: &[&[f64]], least: f64) -> Option<Self> {
        if points.len() < FEWEST {
            return None;
        }
        let n = points[0].len();
        let count = points.len() as f64;
        let mut centre = vec![0.0; n];
        points.iter().for_each(|x| centre.iter_mut().zip(*x).for_each(|(c, x)| *c += x / count));
        let offsets: Vec<Vec<f64>> =
            points.iter().map(|x| x.iter().zip(&centre).map(|(x, c)| x - c).collect()).collect();
        let first = widest(&offsets, None)?;
        let second = widest(&offsets, Some(&first))?;
        let plane: Vec<[f64; 2]> = offsets.iter().map(|x| [dot(x, &first), dot(x, &second)]).collect();
        let size = 2.0 * plane.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
        if size <= least {
            return None;
        }
        let angle = |[x, y]: [f64; 2]| y.atan2(x).rem_euclid(TAU);
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| angle(plane[a]).total_cmp(&angle(plane[b])));
        let mut deviation = 0.0_f64;
        for k in 0..order.len() {
            let [a, x, b] = [k + order.len() - 1, k, k + 1].map(|k| &offsets[order[k % order.len()]]);
            let gap = (angle(plane[order[(k + 1) % order.len()]]) - angle(plane[order[k]])).rem_euclid(TAU);
            if gap > GAP * TAU {
                return None;
            }
            deviation = deviation.max(distance(x, a, b) / size);
        }
        let turns = plane.windows(2).map(|pair| (angle(pair[1]) - angle(pair[0])).rem_euclid(TAU));
        let rotation = turns.sum::<f64>() / (TAU * (count - 1.0));
        (deviation <= CLOSE).then_some(Self { returns: points.len(), deviation, rotation })
    }
}

/// The direction of the largest spread at right angles to another, by power iteration.
fn widest(offsets: &[Vec<f64>], other: Option<&[f64]>) -> Option<Vec<f64>> {
    let clear = |mut x: Vec<f64>| {
        if let Some(other) = other {
            let part = dot(&x, other);
            x.iter_mut().zip(other).for_each(|(x, o)| *x -= part * o);
        }
        x
    };
    let longest = offsets.iter().cloned().map(clear).max_by(|a, b| norm(a).total_cmp(&norm(b)))?;
    let mut direction = longest;
    for _ in 0..100 {
        let length = norm(&direction);
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        direction.iter_mut().for_each(|x| *x /= length);
        let mut next = vec![0.0; direction.len()];
        for x in offsets {
            let part = dot(x, &direction);
            next.iter_mut().zip(x).for_each(|(n, x)| *n += part * x);
        }
        direction = clear(next);
    }
    let length = norm(&direction);
    (length > 0.0).then(|| direction.into_iter().map(|x| x / length).collect())
}

/// Of x from the straight line between a and b.
fn distance(x: &[f64], a: &[f64], b: &[f64]) -> f64 {
    let difference = |x: &[f64], a: &[f64]| x.iter().zip(a).map(|(x, a)| x - a).collect::<Vec<f64>>();
    let (line, away) = (difference(b, a), difference(x, a));
    let square = dot(&line, &line);
    let along = if square > 0.0 { (dot(&away, &line) / square).clamp(0.0, 1.0) } else { 0.0 };
    let rest: Vec<f64> = away.iter().zip(&line).map(|(x, l)| x - along * l).collect();
    norm(&rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(radius: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
        const TURN: f64 = 0.381_966;
        (0..100)
            .map(|k| (k, TAU * TURN * k as f64))
            .map(|(k, a)| vec![radius(k) * a.cos(), radius(k) * a.sin(), 1.0])
            .collect()
    }

    #[test]
    fn a_ring_is_told_from_a_spiral_and_a_cloud() {
        let of = |points: &[Vec<f64>]| Ring::of(&points.iter().map(Vec::as_slice).collect::<Vec<_>>(), 1e-6);
        let ring = of(&turned(|_| 2.0)).expect("a ring");
        let rotation = ring.rotation.min(1.0 - ring.rotation);
        assert!((rotation - 0.381_966).abs() < 1e-9 && ring.deviation < 1e-2, "{ring:?}");
        assert_eq!(of(&turned(|k| 0.97_f64.powi(k as i32))), None);
        assert_eq!(of(&turned(|k| 1.0 + 0.5 * (k as f64 * 7.3).sin())), None);
        assert_eq!(of(&turned(|_| 1e-8)), None);
    }
}
