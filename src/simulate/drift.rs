//! Whether returns still move on. Near the birth of a cycle motions approach it slowly: then successive returns differ by
//! little, but always in one direction, and what is left is many times that.

use super::form::norm;
use super::returns::Return;

/// How far returns moved over two stretches of so many laps, one after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Laps of `q` returns in each stretch.
    pub laps: usize,
    first: f64,
    second: f64,
}

/// Fewest laps of a stretch.
const LAPS: usize = 4;
/// Moves that only scatter, each from the same state, add up to twice one of them over both stretches.
const SCATTER: f64 = 4.0;

impl Drift {
    /// Over the later half of the returns; None where there are too few, or their moves do not add up.
    pub fn of(list: &[Return], q: usize) -> Option<Self> {
        let k = list.len().checked_sub(1)?;
        let laps = (k / q / 4).max(LAPS);
        let start = k.checked_sub(2 * laps * q)?;
        let apart = |i: usize, j: usize| {
            let apart: Vec<f64> = list[i].u.iter().zip(&list[j].u).map(|(a, b)| a - b).collect();
            norm(&apart)
        };
        let (first, second) = (apart(k - laps * q, start), apart(k, k - laps * q));
        let single: f64 = (0..2 * laps).map(|lap| apart(k - lap * q, k - (lap + 1) * q)).sum();
        let mean = single / (2 * laps) as f64;
        (first + second > SCATTER * mean).then_some(Self { laps, first, second })
    }

    /// What is left in parts of the second stretch's move, if moves go on shrinking as they did: a geometric series.
    /// Infinite where they do not shrink.
    pub fn left(&self) -> f64 {
        let ratio = self.second / self.first;
        if ratio < 1.0 { ratio / (1.0 - ratio) } else { f64::INFINITY }
    }

    /// The distance that is left.
    pub fn distance(&self) -> f64 {
        self.second * self.left()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(at: impl Fn(usize) -> [f64; 2], count: usize) -> Vec<Return> {
        (0..count).map(|k| Return { t: k as f64, u: at(k).to_vec(), extent: 1.0, ranges: Vec::new() }).collect()
    }

    #[test]
    fn a_slow_approach_is_seen_to_its_end() {
        for ratio in [0.3_f64, 0.9, 0.99, 0.999] {
            let near = list(|k| [ratio.powi(k as i32), 2.0], 60);
            let drift = Drift::of(&near, 1).unwrap();
            let left = ratio.powi(59);
            assert!((drift.distance() / left - 1.0).abs() < 1e-9, "{ratio}: {drift:?} {left}");
            // Two returns a lap.
            let sides = list(|k| [ratio.powi((k / 2) as i32), 0.0], 60);
            let drift = Drift::of(&sides, 2).unwrap();
            assert!((drift.distance() / ratio.powi(29) - 1.0).abs() < 1e-9, "{ratio}: {drift:?}");
        }
    }

    #[test]
    fn what_grows_has_no_end_and_scatter_no_drift() {
        let grows = list(|k| [1.01_f64.powi(k as i32), 0.0], 30);
        assert_eq!(Drift::of(&grows, 1).unwrap().distance(), f64::INFINITY);
        let scatter = list(|k| [(k as f64 * 1.7).sin(), (k as f64 * 2.3).cos()], 60);
        assert_eq!(Drift::of(&scatter, 1), None);
        assert_eq!(Drift::of(&grows[..8], 1), None);
    }
}
