//! Diagonal scalings of the sections, so that unknowns in units of very different size do not spoil each other:
//! `A_j <- D_{j+1}^-1 A_j D_j`, powers of two, until row i of the factor before a section and column i of the one
//! behind it have sums of one size (Parlett and Reinsch 1969, doi:10.1007/BF02165404, for one factor).

use super::dense::Dense;

/// A change must make row and column together smaller by this factor.
const WORTH: f64 = 0.95;
const SWEEPS: usize = 20;

/// Scales square factors of one size; their product's eigenvalues stay exactly as they are.
pub(super) fn balance(t: &mut [Dense]) {
    let (count, n) = (t.len(), t[0].rows);
    for _ in 0..SWEEPS {
        let mut changed = false;
        for section in 0..count {
            let before = (section + count - 1) % count;
            for i in 0..n {
                // Of a single factor the diagonal is scaled by nothing.
                let counts = |l: &usize| count > 1 || *l != i;
                let row: f64 = (0..n).filter(counts).map(|l| t[before].at(i, l).abs()).sum();
                let column: f64 = (0..n).filter(counts).map(|l| t[section].at(l, i).abs()).sum();
                if row == 0.0 || column == 0.0 || !(row + column).is_finite() {
                    continue;
                }
                let factor = ((row / column).log2() / 2.0).round().exp2();
                if column * factor + row / factor < WORTH * (column + row) {
                    changed = true;
                    t[section].col_mut(i).iter_mut().for_each(|x| *x *= factor);
                    (0..n).for_each(|l| t[before].a[l * n + i] /= factor);
                }
            }
        }
        if !changed {
            return;
        }
    }
}
