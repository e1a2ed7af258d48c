//! The observed order: the exponent of a power law through errors, by least squares of logarithms.

use super::report::{Found, SettingLine};
use serde::{Deserialize, Serialize};

/// `error ~ work^-exponent`.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq)]
pub struct Power {
    pub exponent: f64,
    /// Its standard deviation from the scatter about the law; None with two points, which lie on one.
    pub deviation: Option<f64>,
}

/// Below this relative error a law may hold; above, the number is not there yet.
const ASYMPTOTIC: f64 = 0.1;
/// An error that exceeds the one before it by this factor has risen.
const RISEN: f64 = 1.1;
/// Errors that exceed the reference's own by this factor are known.
const KNOWN: f64 = 10.0;

/// The settings, coarse to fine, that a law can be read from: their errors are known and small, and fall. Where they rise for
/// the first time rounding, or what the family does not refine, has taken over; settings that change nothing are passed over.
pub fn falling<'a>(rows: Vec<(&'a SettingLine, &'a Found)>, floor: f64) -> Vec<(&'a SettingLine, &'a Found)> {
    let mut kept: Vec<(&SettingLine, &Found)> = Vec::new();
    for (line, found) in rows.into_iter().filter(|(_, found)| found.error <= ASYMPTOTIC) {
        let before = kept.last().map_or(f64::INFINITY, |(_, before)| before.error);
        if found.error > RISEN * before || found.error <= KNOWN * floor {
            break;
        }
        if found.error < before {
            kept.push((line, found));
        }
    }
    kept
}

/// The power law through (work, error); None with fewer than two different works.
pub fn power(points: &[(f64, f64)]) -> Option<Power> {
    let logs: Vec<(f64, f64)> = points.iter().map(|(work, error)| (work.ln(), error.ln())).collect();
    let n = logs.len() as f64;
    let mean = |pick: fn(&(f64, f64)) -> f64| logs.iter().map(pick).sum::<f64>() / n;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let sxx: f64 = logs.iter().map(|point| (point.0 - x).powi(2)).sum();
    let sxy: f64 = logs.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    let slope = sxy / sxx;
    let scatter: f64 = logs.iter().map(|point| (point.1 - y - slope * (point.0 - x)).powi(2)).sum();
    let deviation = (logs.len() > 2).then(|| (scatter / (n - 2.0) / sxx).sqrt());
    slope.is_finite().then_some(Power { exponent: -slope, deviation })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_powers_are_found() {
        for exponent in [0.5, 2.0, 7.0, 13.0] {
            let points: Vec<(f64, f64)> =
                [4.0, 8.0, 17.0, 40.0].iter().map(|n: &f64| (*n, 3.0 * n.powf(-exponent))).collect();
            let found = power(&points).unwrap();
            assert!((found.exponent - exponent).abs() < 1e-12 * exponent, "{found:?}");
            assert!(found.deviation.unwrap() < 1e-12 * exponent, "{found:?}");
        }
        let found = power(&[(10.0, 1e-2), (100.0, 1e-6)]).unwrap();
        assert!((found.exponent - 4.0).abs() < 1e-12 && found.deviation.is_none());
    }

    #[test]
    fn scatter_is_the_deviation() {
        // About y = -2 x: residuals ±d, ∓d at x = 0, 1, 2, 3 make a slope of -2 - 0.4 d and leave a known scatter.
        let d = 0.1_f64;
        let points: Vec<(f64, f64)> =
            [d, -d, d, -d].iter().enumerate().map(|(k, r)| ((k as f64).exp(), (r - 2.0 * k as f64).exp())).collect();
        let found = power(&points).unwrap();
        assert!((found.exponent - (2.0 + 0.4 * d)).abs() < 1e-12, "{found:?}");
        let scatter = 4.0 * d * d - (0.4 * d).powi(2) * 5.0;
        assert!((found.deviation.unwrap() - (scatter / 2.0 / 5.0).sqrt()).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn no_law_without_different_works() {
        assert_eq!(power(&[]), None);
        assert_eq!(power(&[(3.0, 1e-2)]), None);
        assert_eq!(power(&[(3.0, 1e-2), (3.0, 1e-3)]), None);
    }
}
