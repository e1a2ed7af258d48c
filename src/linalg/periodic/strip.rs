//! Zero columns and rows of the factors, each of which makes the product's null space larger by what is known exactly.
//!
//! What lies in the kernel of factor j may be dropped from section j, and with it rows of the factor before; what that
//! factor does not reach may be dropped as well. Sections may then differ in dimension: from the smallest one on, QR
//! factors of the tall blocks leave square ones, and all other eigenvalues are zero.

use super::dense::{Dense, Reflector};
use faer::Mat;

/// Square factors of the smallest size found, with the same eigenvalues but for zeros; the first need not be factor 0.
pub(super) fn stripped(factors: &[Mat<f64>]) -> Vec<Dense> {
    let count = factors.len();
    let mut kept: Vec<Vec<usize>> = factors.iter().map(|a| (0..a.ncols()).collect()).collect();
    // Sections whose neighbours have changed.
    let mut open: Vec<usize> = (0..count).rev().collect();
    while let Some(j) = open.pop() {
        let (before, after) = ((j + count - 1) % count, (j + 1) % count);
        let (left, right) = (&factors[before], &factors[j]);
        let needed = |&i: &usize| {
            kept[after].iter().any(|&row| right[(row, i)] != 0.0)
                && kept[before].iter().any(|&column| left[(i, column)] != 0.0)
        };
        let now: Vec<usize> = kept[j].iter().copied().filter(needed).collect();
        if now.len() < kept[j].len() {
            kept[j] = now;
            open.extend([j, before, after]);
        }
    }
    let first = (0..count).min_by_key(|&j| kept[j].len()).unwrap_or(0);
    let mut out: Vec<Dense> = (first..first + count)
        .map(|j| Dense::part(factors[j % count].as_ref(), &kept[(j + 1) % count], &kept[j % count]))
        .collect();
    let least = kept[first].len();
    let mut work = Vec::new();
    for j in 0..count - 1 {
        let rows = out[j].rows;
        if rows == least {
            continue;
        }
        for k in 0..least {
            let (reflector, beta) = Reflector::new(&out[j].col(k)[k..]);
            let column = &mut out[j].col_mut(k)[k..];
            column.fill(0.0);
            column[0] = beta;
            reflector.left(&mut out[j], k, k + 1, least);
            let down = out[j + 1].rows;
            reflector.right(&mut out[j + 1], k, down, &mut work);
        }
        out[j] = out[j].truncated(least, least);
        out[j + 1] = out[j + 1].truncated(out[j + 1].rows, least);
    }
    out
}
