//! From one point of the box to another, with the Hopf point followed all the way.

use super::{Calibration, HopfError, Place};
use crate::linalg::c64;
use thiserror::Error;

/// The Hopf point could not be followed all the way.
#[derive(Debug, Error)]
#[error("the Hopf point cannot be followed further{}", .cause.as_ref().map_or(String::new(), |cause| format!(": {cause}")))]
pub struct Lost {
    /// How far it came.
    pub last: Box<Place>,
    pub cause: Option<HopfError>,
}

/// Smallest step, in parts of the box.
const LEAST: f64 = 1e-4;
/// A step must not miss its prediction by more than this part of omega, in eigenvalues,
const MISS: f64 = 0.2;
/// and the eigenvector must keep its direction: at least this cosine with the last one.
const COSINE: f64 = 0.9;

impl Calibration {
    /// Goes straight to x, in steps in which the Hopf point moves as predicted.
    pub fn reach(&self, from: &Place, x: &[f64]) -> Result<Place, Lost> {
        let way: Vec<f64> = x.iter().zip(&from.x).map(|(x, y)| x - y).collect();
        let length = way.iter().map(|d| d * d).sum::<f64>().sqrt();
        let (mut here, mut done, mut step) = (from.clone(), 0.0, 1.0);
        while done < 1.0 {
            let next = f64::min(1.0, done + step);
            let goal: Vec<f64> =
                if next == 1.0 { x.to_vec() } else { from.x.iter().zip(&way).map(|(x, d)| x + next * d).collect() };
            match self.step(&here, goal) {
                Ok(place) => (here, done, step) = (place, next, 1.5 * step),
                Err(cause) => {
                    step *= 0.5;
                    if step * length < LEAST {
                        return Err(Lost { last: Box::new(here), cause });
                    }
                }
            }
        }
        Ok(here)
    }

    /// One step, if its end is the continuation of its start.
    fn step(&self, from: &Place, x: Vec<f64>) -> Result<Place, Option<HopfError>> {
        let hopf = self.locate(from, &x).map_err(Some)?;
        let moved = |rate: fn(&(f64, f64)) -> f64| -> f64 {
            from.rates.iter().zip(x.iter().zip(&from.x)).map(|(r, (x, y))| rate(r) * (x - y)).sum()
        };
        let p = hopf.p[self.free] - from.hopf.p[self.free] - moved(|r| r.0);
        let omega = hopf.omega - from.hopf.omega - moved(|r| r.1);
        let overlap: c64 = from.hopf.q.iter().zip(&hopf.q).map(|(a, b)| a.conj() * b).sum();
        let limit = MISS * from.hopf.omega;
        let close = (p * from.hopf.slope.norm()).abs() <= limit && omega.abs() <= limit;
        if !close || hopf.omega <= 0.0 || overlap.norm() < COSINE {
            return Err(None);
        }
        self.place_at(hopf, x).map_err(Some)
    }
}
