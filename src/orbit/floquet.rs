//! Floquet multipliers from the condensed equations.
//!
//! What the condensed rows `C x_0 + D x_N = 0` say of perturbations is `x_N = -D^-1 C x_0`; with `u(t + P) = S u(t)`
//! the multipliers over P are the eigenvalues of `-S^-1 D^-1 C`, and those over the period their squares where P is
//! half of it. One multiplier over P is +1, the shift in time; its distance from 1 bounds from below how wrong the
//! others are (on an even mesh it can be far smaller than the orbit's own error, which refinement tells).

use crate::linalg::{Lu, Singular, c64};
use crate::problem::Reflection;
use faer::{Mat, MatRef};

/// Multipliers over the period, largest first, the trivial one left out.
#[derive(Clone, Debug)]
pub struct Multipliers {
    pub values: Vec<c64>,
    /// |trivial multiplier - 1|.
    pub trivial_error: f64,
}

impl Multipliers {
    /// Multipliers outside the unit circle by more than the trivial one's error, which limits the verdict.
    pub fn unstable(&self) -> usize {
        let slack = 10.0 * self.trivial_error + 1e-12;
        self.values.iter().filter(|mu| mu.norm() > 1.0 + slack).count()
    }
}

/// From the condensed rows `[C D ...]`.
pub fn multipliers(rows: MatRef<'_, f64>, symmetry: &Reflection, parts: usize) -> Result<Multipliers, Singular> {
    let n = rows.nrows();
    let mut transition = Mat::from_fn(n, n, |i, j| -rows[(i, j)]);
    Lu::new(rows.subcols(n, n))?.solve_many(transition.as_mut());
    // S^-1 = S^T: row `source_i` of the product is sign_i times row i.
    let mut turned = Mat::zeros(n, n);
    for i in 0..n {
        for j in 0..n {
            turned[(symmetry.source[i], j)] = symmetry.sign[i] * transition[(i, j)];
        }
    }
    if !turned.is_all_finite() {
        return Err(Singular);
    }
    let mut values = turned.eigenvalues().map_err(|_| Singular)?;
    let distance = |mu: &c64| (mu - c64::new(1.0, 0.0)).norm();
    let trivial = (0..n).min_by(|&i, &j| distance(&values[i]).total_cmp(&distance(&values[j]))).ok_or(Singular)?;
    let trivial = values.swap_remove(trivial);
    let whole = |mu: c64| if parts == 2 { mu * mu } else { mu };
    let mut values: Vec<c64> = values.into_iter().map(whole).collect();
    values.sort_by(|x, y| y.norm().total_cmp(&x.norm()).then(y.im.total_cmp(&x.im)));
    Ok(Multipliers { values, trivial_error: distance(&whole(trivial)) })
}
