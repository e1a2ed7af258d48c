//! Parameters for which a Hopf point has wanted quantities.
//!
//! On a Hopf point `sigma(p, theta) = i omega` that is followed as the unknown parameters theta vary, `Re sigma` stays
//! zero, so that with the exact derivatives of sigma along the branch of equilibria (see [`Hopf::along`])
//!
//! ```text
//! dp_H/dtheta = -Re sigma_theta / Re sigma_p,      d omega_H/dtheta = Im sigma_theta + Im sigma_p dp_H/dtheta.
//! ```
//!
//! The unknowns are coordinates x of a box, 0 to 1 from one end of each range to the other (in the logarithm, where
//! wanted). The targets make weighted residuals, whose sum of squares [`Calibration::fit`] minimises in the box. Which
//! Hopf point is meant is settled by following the given one continuously (see [`Calibration::reach`]).

mod analysis;
mod fit;
mod reach;

pub use analysis::Analysis;
pub use fit::{Fit, FitError};
pub use reach::Lost;

use super::{Coordinate, Hopf, HopfError, HopfNormalForm};
use crate::linalg::finite;
use crate::problem::Problem;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;
use std::sync::Arc;

/// A number that belongs to a Hopf point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The parameter that is solved for.
    Parameter,
    /// Angular frequency.
    Omega,
    Frequency,
    /// First Lyapunov coefficient, for `q^H q = 1`.
    Lyapunov,
    /// d sigma / dp along the branch of equilibria.
    SlopeRe,
    SlopeIm,
}

/// A wanted value; `scale` is what a residual is measured in: the value's standard deviation, or its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    pub quantity: Quantity,
    pub value: f64,
    pub scale: f64,
}

/// A parameter to be found between two values, `low < high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknown {
    pub coordinate: Coordinate,
    pub low: f64,
    pub high: f64,
}

impl Unknown {
    fn width(&self) -> f64 {
        self.coordinate.of(self.high) - self.coordinate.of(self.low)
    }

    /// The parameter's value at x in [0, 1], exact at both ends.
    pub fn value(&self, x: f64) -> f64 {
        if x <= 0.0 {
            self.low
        } else if x >= 1.0 {
            self.high
        } else {
            self.coordinate.value(self.coordinate.of(self.low) + x * self.width())
        }
    }

    /// x of a value.
    pub fn place(&self, value: f64) -> f64 {
        ((self.coordinate.of(value) - self.coordinate.of(self.low)) / self.width()).clamp(0.0, 1.0)
    }

    /// d value / dx.
    pub fn rate(&self, x: f64) -> f64 {
        self.coordinate.rate(self.coordinate.of(self.low) + x * self.width()) * self.width()
    }
}

/// The problem of finding `unknowns` such that the Hopf point in `p[free]` meets `targets`.
#[derive(Clone)]
pub struct Calibration {
    pub problem: Arc<dyn Problem>,
    pub free: usize,
    pub unknowns: Vec<Unknown>,
    pub targets: Vec<Target>,
}

/// The Hopf point at one point of the box, and how it moves.
#[derive(Clone, Debug)]
pub struct Place {
    pub x: Vec<f64>,
    pub hopf: Hopf,
    /// (dp_H, d omega_H)/dx for each unknown, exact.
    pub rates: Vec<(f64, f64)>,
}

/// Step of the differences for quantities without exact derivatives, in parts of a range: their error is about 1e-8.
const DIFFERENCE: f64 = 1e-4;

impl Calibration {
    /// A known Hopf point of the problem as a place of the box; unknowns outside of it move to its faces.
    pub fn place(&self, hopf: Hopf) -> Result<Place, HopfError> {
        let hopf = hopf.along(&*self.problem, self.free)?;
        let x = self.unknowns.iter().map(|u| u.place(hopf.p[u.coordinate.index])).collect();
        self.place_at(hopf, x)
    }

    /// The same for a Hopf point with its slope along `free`, at known x.
    fn place_at(&self, hopf: Hopf, x: Vec<f64>) -> Result<Place, HopfError> {
        let problem = &*self.problem;
        let by_p = hopf.slope;
        let mut rates = Vec::with_capacity(x.len());
        for (unknown, &x) in self.unknowns.iter().zip(&x) {
            let along = hopf.clone().along(problem, unknown.coordinate.index)?.slope * unknown.rate(x);
            let rate = -along.re / by_p.re;
            rates.push((rate, along.im + by_p.im * rate));
        }
        Ok(Place { x, hopf, rates })
    }

    pub fn quantity(&self, hopf: &Hopf, quantity: Quantity) -> Result<f64, HopfError> {
        Ok(match quantity {
            Quantity::Parameter => hopf.p[self.free],
            Quantity::Omega => hopf.omega,
            Quantity::Frequency => hopf.omega / (2.0 * PI),
            Quantity::Lyapunov => HopfNormalForm::new(&*self.problem, hopf)?.l1,
            Quantity::SlopeRe => hopf.slope.re,
            Quantity::SlopeIm => hopf.slope.im,
        })
    }

    /// (quantity - value) / scale for each target; an error where one is not finite.
    pub fn residuals(&self, hopf: &Hopf) -> Result<DVector<f64>, HopfError> {
        let of = |t: &Target| Ok((self.quantity(hopf, t.quantity)? - t.value) / t.scale);
        let residuals: Vec<f64> = self.targets.iter().map(of).collect::<Result<_, HopfError>>()?;
        if finite(&residuals) { Ok(DVector::from_vec(residuals)) } else { Err(HopfError::NotFinite) }
    }

    /// d residuals / dx: exact for parameter and frequency, by differences of exact values for the others.
    pub fn jacobian(&self, place: &Place) -> Result<DMatrix<f64>, HopfError> {
        let mut jacobian = DMatrix::zeros(self.targets.len(), place.x.len());
        let exact = |quantity, (p, omega): (f64, f64)| match quantity {
            Quantity::Parameter => Some(p),
            Quantity::Omega => Some(omega),
            Quantity::Frequency => Some(omega / (2.0 * PI)),
            _ => None,
        };
        for j in 0..place.x.len() {
            let mut differences: Option<DVector<f64>> = None;
            for (k, target) in self.targets.iter().enumerate() {
                jacobian[(k, j)] = match (exact(target.quantity, place.rates[j]), &differences) {
                    (Some(rate), _) => rate / target.scale,
                    (None, Some(known)) => known[k],
                    (None, None) => differences.insert(self.differences(place, j)?)[k],
                };
            }
        }
        Ok(jacobian)
    }

    /// d residuals / dx_j by differences of second order, one-sided at the faces of the box.
    fn differences(&self, place: &Place, j: usize) -> Result<DVector<f64>, HopfError> {
        let at = |shift: f64| {
            let mut x = place.x.clone();
            x[j] += shift;
            self.residuals(&self.locate(place, &x)?)
        };
        let h = if place.x[j] > 0.5 { -DIFFERENCE } else { DIFFERENCE };
        if (DIFFERENCE..=1.0 - DIFFERENCE).contains(&place.x[j]) {
            return Ok((at(h)? - at(-h)?) / (2.0 * h));
        }
        Ok((at(h)? * 4.0 - at(2.0 * h)? - self.residuals(&place.hopf)? * 3.0) / (2.0 * h))
    }

    /// Newton's method for the Hopf point at x, from a place close by.
    fn locate(&self, from: &Place, x: &[f64]) -> Result<Hopf, HopfError> {
        let mut p = from.hopf.p.clone();
        let mut omega = from.hopf.omega;
        for (i, unknown) in self.unknowns.iter().enumerate() {
            p[unknown.coordinate.index] = unknown.value(x[i]);
            p[self.free] += from.rates[i].0 * (x[i] - from.x[i]);
            omega += from.rates[i].1 * (x[i] - from.x[i]);
        }
        Hopf::locate(&*self.problem, (&from.hopf.u, &p), self.free, omega, &from.hopf.q)
    }
}
