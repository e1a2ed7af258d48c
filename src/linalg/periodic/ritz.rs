//! What a product, projected on a subspace of every section, says of its eigenvalues.

use super::cyclic::Cyclic;
use super::dense::Dense;
use super::iteration::Blocks;
use super::{Eigenvalue, sort};

/// A converged column's residual in parts of its own diagonal entry of H, and of the largest one.
const TOLERANCE: f64 = 1e-13;
const FLOOR: f64 = 2.0 * f64::EPSILON;

/// The projected product in sorted Schur form.
pub(super) struct Ritz {
    pub cyclic: Cyclic,
    pub blocks: Blocks,
    /// By column of the Schur form, the change of the last factor that would make it exact.
    pub residuals: Vec<f64>,
    pub values: Vec<Eigenvalue>,
    /// Rows that hold all wanted eigenvalues, and whether they have converged.
    pub needed: usize,
    pub converged: bool,
}

impl Ritz {
    /// `residuals` are to be told from the Schur form's basis at the last section. None if the small problem does not
    /// converge.
    pub fn new(factors: Vec<Dense>, wanted: usize, residuals: &dyn Fn(&Dense) -> Vec<f64>) -> Option<Self> {
        let last = factors.len() - 1;
        let mut cyclic = Cyclic::new(factors, true);
        let blocks = cyclic.iterate().ok()?;
        let blocks = cyclic.sort(blocks);
        let residuals = residuals(&cyclic.q.as_ref()?[last]);
        // Sorted but for what could not be exchanged, and for rounding.
        let mut found: Vec<((usize, usize), Vec<Eigenvalue>)> =
            blocks.iter().map(|&block| (block, cyclic.values(block))).collect();
        found.sort_by(|x, y| y.1[0].ln.total_cmp(&x.1[0].ln));
        let (mut count, mut needed) = (0, 0);
        for ((i, size), _) in &found {
            if count >= wanted {
                break;
            }
            count += size;
            needed = needed.max(i + size);
        }
        let mut values: Vec<Eigenvalue> = found.into_iter().flat_map(|(_, values)| values).collect();
        sort(&mut values);
        let scale = f64::from(cyclic.exponents[last]).exp2();
        let (h, largest) = (cyclic.h(), cyclic.h().largest());
        let small = |&(i, size): &(usize, usize)| {
            let own = (i..i + size).flat_map(|r| (i..i + size).map(move |c| (r, c)));
            let own = own.fold(0.0_f64, |most, (r, c)| most.max(h.at(r, c).abs()));
            residuals[i..i + size].iter().all(|b| b.abs() <= scale * (TOLERANCE * own).max(FLOOR * largest))
        };
        let converged = blocks.iter().take_while(|(i, _)| *i < needed).all(small);
        Some(Self { blocks, residuals, values, needed, converged, cyclic })
    }
}
