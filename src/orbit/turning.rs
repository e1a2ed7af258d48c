//! The linearisation in a frame that turns with the orbit.

use crate::linalg::{Banded, Matrix};
use crate::problem::Rotation;

/// From (G_u, G_v) to `(G_u + sum_k c_k G_v Gamma_k, G_v)`. A band grows by the rotations' reach; other structures end dense.
pub fn turned((gu, gv): (Matrix, Matrix), rotations: &[Rotation], drift: &[f64]) -> (Matrix, Matrix) {
    if drift.is_empty() {
        return (gu, gv);
    }
    let planes = || {
        let weighted = rotations.iter().zip(drift);
        weighted.flat_map(|(rotation, c)| rotation.planes.iter().map(move |&(i, j, m)| (i, j, c * m)))
    };
    match (gu, gv) {
        (Matrix::Banded(gu), Matrix::Banded(gv)) => {
            let reach = planes().map(|(i, j, _)| i.abs_diff(j)).max().unwrap_or(0);
            let (mut gu, gv) = (widened(&gu, reach), widened(&gv, reach));
            for row in 0..gu.n() {
                let start = gu.columns(row).start;
                for (i, j, c) in planes() {
                    let (x, y) = (gv.get(row, i), gv.get(row, j));
                    if x != 0.0 {
                        gu.row_mut(row)[j - start] -= c * x;
                    }
                    if y != 0.0 {
                        gu.row_mut(row)[i - start] += c * y;
                    }
                }
            }
            (Matrix::Banded(gu), Matrix::Banded(gv))
        }
        (gu, gv) => {
            let (mut gu, gv) = (gu.into_dense(), gv.into_dense());
            for (i, j, c) in planes() {
                for row in 0..gu.nrows() {
                    gu[(row, j)] -= c * gv[(row, i)];
                    gu[(row, i)] += c * gv[(row, j)];
                }
            }
            (Matrix::Dense(gu), Matrix::Dense(gv))
        }
    }
}

fn widened(a: &Banded, reach: usize) -> Banded {
    let mut wide = Banded::zeros(a.n(), a.lower() + reach, a.upper() + reach);
    for i in 0..a.n() {
        let start = wide.columns(i).start;
        wide.row_mut(i)[a.columns(i).start - start..][..a.row(i).len()].copy_from_slice(a.row(i));
    }
    wide
}
