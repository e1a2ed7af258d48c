//! The point between two spans, eliminated.
//!
//! ```text
//! C_l x_a + D_l x_m + E_l z = r_l,      C_r x_m + D_r x_b + E_r z = r_r.
//! ```

use super::elimination::Elimination;
use super::rows::{GROWTH, Reach, Rows, add_product};
use crate::linalg::Singular;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

pub enum Joint {
    Direct(Direct),
    Pivoted(Elimination),
}

/// Where `D_l = -1` and no entry of C_r is large, partial pivoting would (nearly) keep the rows as they are:
///
/// ```text
/// x_m = C_l x_a + E_l z - r_l,      C_r C_l x_a + D_r x_b + (E_r + C_r E_l) z = r_r + C_r r_l.
/// ```
///
/// All that is needed besides the two spans' own rows is the product.
pub struct Direct {
    c: Mat<f64>,
    d: Option<Mat<f64>>,
    e: Mat<f64>,
    /// For each border, its entries on x_m.
    borders: Vec<Vec<f64>>,
}

impl Joint {
    pub fn new(l: Rows, r: Rows) -> Result<Self, Singular> {
        if l.d.is_some() || r.c.norm_max() > GROWTH {
            return Ok(Joint::Pivoted(pivoted(l, r)?));
        }
        let mut c = Mat::zeros(l.n(), l.n());
        matmul(c.as_mut(), Accum::Replace, r.c, l.c, 1.0, Par::Seq);
        let mut e = r.e.to_owned();
        matmul(e.as_mut(), Accum::Add, r.c, l.e, 1.0, Par::Seq);
        Ok(Joint::Direct(Direct { c, d: r.d.map(|d| d.to_owned()), e, borders: Vec::new() }))
    }

    pub fn remaining(&self) -> Rows<'_> {
        match self {
            Joint::Direct(Direct { c, d, e, .. }) => {
                Rows { c: c.as_ref(), d: d.as_ref().map(Mat::as_ref), e: e.as_ref() }
            }
            Joint::Pivoted(elimination) => elimination.remaining(),
        }
    }

    /// Forgets the remaining rows, which a pivoted joint has taken over.
    pub fn shrink(&mut self) {
        match self {
            Joint::Direct(direct) => (direct.c, direct.d, direct.e) = (Mat::new(), None, Mat::new()),
            Joint::Pivoted(elimination) => elimination.shrink(),
        }
    }
}

impl Direct {
    /// Eliminates the border rows' entries on x_m, from the left span's rows; the change of their entries elsewhere.
    pub fn add_borders(&mut self, l: Rows, rows: Vec<Vec<f64>>) -> Vec<Reach> {
        let reach = |row: &Vec<f64>| {
            let mut reach = Reach { a: vec![0.0; l.n()], b: vec![0.0; l.n()], z: vec![0.0; l.e.ncols()] };
            add_product(1.0, l.c.transpose(), row, &mut reach.a);
            add_product(1.0, l.e.transpose(), row, &mut reach.z);
            reach
        };
        let reaches = rows.iter().map(reach).collect();
        self.borders = rows;
        reaches
    }

    /// From the right span's rows and both spans' right-hand sides: r_l for [`Self::back`], and that of the remaining
    /// rows; `border` collects what the borders' right-hand sides lose.
    pub fn forward(&self, r: Rows, left: Vec<f64>, mut right: Vec<f64>, border: &mut [f64]) -> (Vec<f64>, Vec<f64>) {
        add_product(1.0, r.c, &left, &mut right);
        for (border, row) in border.iter_mut().zip(&self.borders) {
            *border += crate::linalg::dot(row, &left);
        }
        (left, right)
    }

    /// x_m from the left span's rows, r_l, x_a and z.
    pub fn back(&self, l: Rows, left: &[f64], a: &[f64], z: &[f64]) -> Vec<f64> {
        let mut middle: Vec<f64> = left.iter().map(|r| -r).collect();
        add_product(1.0, l.c, a, &mut middle);
        add_product(1.0, l.e, z, &mut middle);
        middle
    }
}

fn pivoted(l: Rows, r: Rows) -> Result<Elimination, Singular> {
    let (n, count) = (l.n(), l.e.ncols());
    let (mut inside, mut right) = (Mat::zeros(2 * n, n), Mat::zeros(2 * n, 2 * n + count));
    let fill = |mut target: faer::MatMut<'_, f64>, d: Option<MatRef<'_, f64>>| match d {
        Some(d) => target.copy_from(d),
        None => target.diagonal_mut().fill(-1.0),
    };
    fill(inside.as_mut().subrows_mut(0, n), l.d);
    inside.as_mut().subrows_mut(n, n).copy_from(r.c);
    let (mut top, mut bottom) = right.as_mut().split_at_row_mut(n);
    top.as_mut().subcols_mut(0, n).copy_from(l.c);
    top.subcols_mut(2 * n, count).copy_from(l.e);
    fill(bottom.as_mut().subcols_mut(n, n), r.d);
    bottom.subcols_mut(2 * n, count).copy_from(r.e);
    Elimination::new(inside, right, n)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solved(rows: Rows) -> Mat<f64> {
        let n = rows.n();
        let (ends, mut right) = (rows.c.ncols() + rows.e.ncols(), Mat::zeros(n, n + rows.e.ncols()));
        right.as_mut().subcols_mut(0, n).copy_from(rows.c);
        right.as_mut().subcols_mut(n, ends - n).copy_from(rows.e);
        match rows.d {
            Some(d) => crate::linalg::Lu::new(d.to_owned()).expect("regular").solve_many(right.as_mut()),
            None => right = -right,
        }
        right
    }

    #[test]
    fn direct_and_pivoted_joints_agree() {
        let n = 5;
        let matrix = |seed: f64, columns: usize| Mat::from_fn(n, columns, |i, j| (seed * (1 + i + 9 * j) as f64).sin());
        let [c, e, other, f, d] = [(1.3, n), (2.7, 3), (0.9, n), (4.1, 3), (3.3, n)].map(|(seed, k)| matrix(seed, k));
        let left = Rows { c: c.as_ref(), d: None, e: e.as_ref() };
        let large = &other * faer::Scale(1e3);
        for end in [None, Some(d.as_ref())] {
            let right = Rows { c: other.as_ref(), d: end, e: f.as_ref() };
            let joint = Joint::new(left, right).expect("a joint");
            assert!(matches!(joint, Joint::Direct(_)));
            let pivoted = pivoted(left, right).expect("an elimination");
            let (a, b) = (solved(joint.remaining()), solved(pivoted.remaining()));
            assert!((&a - &b).norm_max() < 1e-12 * a.norm_max());
            let right = Rows { c: large.as_ref(), ..right };
            assert!(matches!(Joint::new(left, right), Ok(Joint::Pivoted(_))));
        }
    }
}
