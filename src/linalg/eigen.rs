//! Eigenvalues of the pencil `(A + sigma M) q = 0`, M possibly singular, by shift and invert.
//!
//! With `B = (A + s M)^-1 M`, `B q = mu q` and `mu = 1/(s - sigma)`: eigenvalues near the shift are the large ones of
//! B and come out to full relative accuracy, however stiff the rest; infinite ones (singular M) are mu = 0.
//! Where M has columns of zeros, as for algebraic unknowns, only the block of B in the other unknowns is taken,
//! `B_11 q_1 = mu q_1`, and `q_2 = B_21 q_1 / mu`: this leaves out zeros that rounding would turn into eigenvalues of any size.
//! B is balanced (Parlett and Reinsch 1969, doi:10.1007/BF02165404) because faer's routine does not.

use super::{Lu, Singular};
use faer::{Mat, MatRef, c64};

/// An eigenvalue with its right eigenvector, |q| = 1.
#[derive(Clone, Debug)]
pub struct Eigenpair {
    pub value: c64,
    pub vector: Vec<c64>,
}

/// The real part of an eigenvalue, zero where rounding hides its sign: undamped motions have all theirs on the axis.
pub fn growth(sigma: c64) -> f64 {
    if sigma.re.abs() <= ON_AXIS * sigma.norm() { 0.0 } else { sigma.re }
}

/// In parts of the eigenvalue; a few digits above what rounding leaves of real parts.
const ON_AXIS: f64 = 1e-10;

/// What is computed with a shift; with one beside it where it happens to be an eigenvalue, so that A + shift M is singular.
pub fn shifted<T, E>(shift: f64, compute: impl Fn(f64) -> Result<T, E>) -> Result<T, E> {
    compute(shift).or_else(|_| compute(BESIDE * shift))
}

/// The other shift, in parts of the first.
const BESIDE: f64 = 1.37;

/// All finite eigenvalues of `A + sigma M`, rightmost first; of a conjugate pair, the one with im > 0 comes first.
/// Of those with one real part, which rounding would shuffle, the slowest come first. `shift` is real, positive, and of the size of the eigenvalues of interest. Vectors belong to the first `vectors`.
pub fn pencil(a: MatRef<'_, f64>, m: MatRef<'_, f64>, shift: f64, vectors: usize) -> Result<Vec<Eigenpair>, Singular> {
    let size = a.nrows();
    let shifted = Mat::from_fn(size, size, |i, j| a[(i, j)] + shift * m[(i, j)]);
    let moving: Vec<usize> = (0..size).filter(|&j| (0..size).any(|i| m[(i, j)] != 0.0)).collect();
    let n = moving.len();
    let mut images = Mat::from_fn(size, n, |i, j| m[(i, moving[j])]);
    Lu::new(shifted)?.solve_many(images.as_mut());
    if !images.is_all_finite() {
        return Err(Singular);
    }
    let mut b = Mat::from_fn(n, n, |i, j| images[(moving[i], j)]);
    let scale = balance(&mut b);
    let (values, columns) = if vectors == 0 {
        (b.eigenvalues().map_err(|_| Singular)?, None)
    } else {
        let eigen = b.eigen().map_err(|_| Singular)?;
        ((0..n).map(|j| eigen.S()[j]).collect(), Some(eigen.U().to_owned()))
    };
    // Below this, 1/mu is the rounding error of B: an infinite eigenvalue.
    let floor = b.norm_max() * f64::EPSILON * 10.0;
    let mut found: Vec<(c64, usize)> = (0..n)
        .map(|j| (values[j], j))
        .filter(|(mu, _)| mu.norm() > floor)
        .map(|(mu, j)| (c64::new(shift, 0.0) - mu.inv(), j))
        .collect();
    found.sort_by(|(x, _), (y, _)| y.re.total_cmp(&x.re));
    let slower =
        |(x, _): &(c64, usize), (y, _): &(c64, usize)| x.im.abs().total_cmp(&y.im.abs()).then(y.im.total_cmp(&x.im));
    found
        .chunk_by_mut(|(x, _), (y, _)| x.re - y.re <= ON_AXIS * x.norm().max(y.norm()))
        .for_each(|equal| equal.sort_by(slower));
    Ok(found
        .into_iter()
        .enumerate()
        .map(|(rank, (value, j))| {
            let raw = |columns: &Mat<c64>| {
                let moved: Vec<c64> = (0..n).map(|i| columns[(i, j)] * scale[i]).collect();
                // B q = mu q, entry by entry.
                let mut vector = vec![c64::new(0.0, 0.0); size];
                for (k, &z) in moved.iter().enumerate() {
                    let image = images.col_as_slice(k);
                    vector.iter_mut().zip(image).for_each(|(v, image)| *v += z * *image / values[j]);
                }
                vector
            };
            let mut vector = columns.as_ref().filter(|_| rank < vectors).map_or(Vec::new(), raw);
            let norm = vector.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|z| *z /= norm);
            Eigenpair { value, vector }
        })
        .collect())
}

/// `B <- D^-1 B D` with powers of two in D, so that rows and columns have norms of one size; returns D.
fn balance(b: &mut Mat<f64>) -> Vec<f64> {
    let n = b.nrows();
    let mut scale = vec![1.0; n];
    loop {
        let mut changed = false;
        for i in 0..n {
            let (mut row, mut column) = (0.0, 0.0);
            for j in (0..n).filter(|&j| j != i) {
                row += b[(i, j)].abs();
                column += b[(j, i)].abs();
            }
            if row == 0.0 || column == 0.0 || !(row + column).is_finite() {
                continue;
            }
            let factor = ((row / column).log2() / 2.0).round().exp2();
            if (column * factor + row / factor) < 0.95 * (column + row) {
                changed = true;
                scale[i] *= factor;
                for j in 0..n {
                    b[(i, j)] /= factor;
                    b[(j, i)] *= factor;
                }
            }
        }
        if !changed {
            return scale;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_pairs_and_leaves_out_infinite_eigenvalues() {
        // u' = u - 2 w, w' = 2 u + w, 0 = z - u: eigenvalues 1 ± 2i, and one at infinity.
        let a = faer::mat![[-1.0, 2.0, 0.0], [-2.0, -1.0, 0.0], [1.0, 0.0, -1.0]];
        let m = faer::mat![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]];
        let pairs = pencil(a.as_ref(), m.as_ref(), 3.0, 2).unwrap();
        assert_eq!(pairs.len(), 2);
        assert!((pairs[0].value - c64::new(1.0, 2.0)).norm() < 1e-13);
        let q = &pairs[0].vector;
        assert!((q[2] - q[0]).norm() < 1e-13);
    }
}
