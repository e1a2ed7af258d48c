//! What a fit is worth: residuals, sensitivity of the unknowns, their standard deviations.

use super::{Calibration, HopfError, Place, fit::open};
use nalgebra::{DMatrix, DVector};

/// The fit to first order around its end, J being d residuals / dx.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// Each target's quantity minus its value, in its unit.
    pub residuals: Vec<f64>,
    /// Sum of the squares of the residuals in their scales.
    pub chi2: f64,
    /// Ratio of the largest to the smallest singular value of J; None if J has not full rank.
    pub condition: Option<f64>,
    /// d unknown / d target, unknown by target, in their units: zero for unknowns that are held at an end of their range.
    pub sensitivity: Option<DMatrix<f64>>,
    /// Covariance of the unknowns if each target varies by its scale, `D (J^T J)^-1 D` with `D = d unknown / dx`.
    pub covariance: Option<DMatrix<f64>>,
    /// Unknowns at an end of their range that would go beyond.
    pub held: Vec<usize>,
    /// Unknowns on which no target depends.
    pub idle: Vec<usize>,
}

/// Ratios of singular values beyond this are rank deficiency.
const SINGULAR: f64 = 1e12;

impl Calibration {
    pub fn analysis(&self, place: &Place) -> Result<Analysis, HopfError> {
        let (r, j) = (self.residuals(&place.hopf)?, self.jacobian(place)?);
        let (m, n) = (place.x.len(), self.targets.len());
        let open = open(&place.x, &j, &r);
        let size = j.amax();
        let mut analysis = Analysis {
            residuals: r.iter().zip(&self.targets).map(|(r, t)| r * t.scale).collect(),
            chi2: r.norm_squared(),
            condition: None,
            sensitivity: None,
            covariance: None,
            held: (0..m).filter(|i| !open.contains(i)).collect(),
            idle: (0..m).filter(|&i| j.column(i).amax() <= size * f64::EPSILON).collect(),
        };
        if open.is_empty() {
            return Ok(analysis);
        }
        let svd = j.select_columns(&open).svd(true, true);
        let condition = svd.singular_values.max() / svd.singular_values.min();
        if condition.is_nan() || condition > SINGULAR {
            return Ok(analysis);
        }
        analysis.condition = Some(condition);
        let Ok(inverse) = svd.pseudo_inverse(0.0) else { return Ok(analysis) };
        let mut scaled = DMatrix::zeros(m, n);
        for (row, &i) in open.iter().enumerate() {
            scaled.set_row(i, &(inverse.row(row) * self.unknowns[i].rate(place.x[i])));
        }
        analysis.covariance = Some(&scaled * scaled.transpose());
        let weights = DVector::from_iterator(n, self.targets.iter().map(|t| 1.0 / t.scale));
        analysis.sensitivity = Some(scaled * DMatrix::from_diagonal(&weights));
        Ok(analysis)
    }
}
