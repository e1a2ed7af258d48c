//! Test functions along a branch of cycles: what changes sign where something bifurcates.
//!
//! ```text
//! fold     the tangent's entry for lambda,
//! branch   det [H_x, H_lambda; tangent], which a fold does not change,
//! flip     prod (nu_i + 1),
//! torus    prod over pairs (1 - nu_i nu_j): at a torus bifurcation a complex pair, at a neutral saddle a real one.
//! ```
//!
//! nu are the multipliers over the computed part of the period without the trivial one. Products are formed by their
//! signs and their smallest factor, if that is below one, so that nothing over- or underflows. What lies well inside
//! the unit circle, also times the largest of them, changes no sign: of many unknowns only the others are computed.

use crate::continuation::Point;
use crate::linalg::{Lu, Singular, c64};
use crate::orbit::{FloquetError, OrbitFactors, Rows};
use crate::problem::Reflection;
use serde::{Deserialize, Serialize};

/// What happens to a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    Fold,
    Branch,
    Flip,
    Torus,
}

/// The test functions at one point of a branch; zero where none is wanted that needs multipliers.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Signs {
    pub fold: f64,
    pub branch: f64,
    pub flip: f64,
    pub torus: f64,
    /// Real and imaginary part of a complex pair, if that is what comes nearest to a product of one.
    pub pair: Option<(f64, f64)>,
}

impl Event {
    pub const ALL: [Event; 4] = [Event::Fold, Event::Branch, Event::Flip, Event::Torus];
}

impl Signs {
    /// Factors are those at the point, bordered by a tangent that it does not turn from by more than a right angle.
    /// Folds alone need no multipliers.
    pub fn new(point: &Point, factors: &OrbitFactors, wanted: &[Event]) -> Result<Self, FloquetError> {
        if wanted.iter().all(|event| *event == Event::Fold) {
            return Ok(Self { fold: point.tangent_lambda, ..Self::default() });
        }
        let nu = factors.part_multipliers()?.values;
        let (torus, nearest) = torus(&nu);
        let pair = nearest.filter(|&(i, j)| nu[i].im != 0.0 && nu[i] == nu[j].conj());
        let pair = pair.map(|(i, _)| (nu[i].re, nu[i].im.abs()));
        Ok(Self { fold: point.tangent_lambda, branch: branch(factors, &nu)?, flip: flip(&nu), torus, pair })
    }

    pub fn value(&self, event: Event) -> f64 {
        match event {
            Event::Fold => self.fold,
            Event::Branch => self.branch,
            Event::Flip => self.flip,
            Event::Torus => self.torus,
        }
    }

    /// The same, with the signs of the point before where a test happens to vanish.
    pub fn after(mut self, before: &Self) -> Self {
        for (value, before) in [
            (&mut self.fold, before.fold),
            (&mut self.branch, before.branch),
            (&mut self.flip, before.flip),
            (&mut self.torus, before.torus),
        ] {
            if *value == 0.0 {
                *value = before;
            }
        }
        self
    }

    /// Which of the wanted events lie between two points; of the last, some may turn out to be neutral saddles.
    pub fn events(&self, to: &Self, wanted: &[Event]) -> Vec<Event> {
        wanted.iter().copied().filter(|&event| self.value(event) * to.value(event) < 0.0).collect()
    }
}

/// The sign of det [H_x, H_lambda; tangent].
fn branch(factors: &OrbitFactors, nu: &[c64]) -> Result<f64, Singular> {
    Ok(factors.sign() * pivots(factors.transition(), factors.symmetry(), nu)?)
}

/// Elimination changes the sign of a determinant by that of its pivots, and that of `det(C + kappa D S)` likewise: the
/// latter, for kappa < 0 beyond all multipliers, is otherwise constant along a branch.
pub(super) fn pivots(rows: Rows, symmetry: &Reflection, nu: &[c64]) -> Result<f64, Singular> {
    let kappa = -4.0 * nu.iter().fold(1.0, |most: f64, nu| most.max(nu.norm()));
    let mut far = rows.c.to_owned();
    rows.add_end(symmetry, kappa, far.as_mut());
    Ok(Lu::new(far)?.sign())
}

pub(super) fn flip(nu: &[c64]) -> f64 {
    let one = c64::new(1.0, 0.0);
    let least = nu.iter().map(|nu| (nu + one).norm()).fold(1.0, f64::min);
    let below = nu.iter().filter(|nu| nu.im == 0.0 && nu.re < -1.0).count();
    if below % 2 == 0 { least } else { -least }
}

/// The product's sign times its smallest factor, and the pair that this belongs to.
pub(super) fn torus(nu: &[c64]) -> (f64, Option<(usize, usize)>) {
    let (mut sign, mut least, mut pair) = (1.0, 1.0, None);
    for i in 0..nu.len() {
        for j in i + 1..nu.len() {
            let factor = nu[i] * nu[j] - 1.0;
            let conjugate = nu[i].im != 0.0 && nu[i] == nu[j].conj();
            if (conjugate || (nu[i].im == 0.0 && nu[j].im == 0.0)) && factor.re > 0.0 {
                sign = -sign;
            }
            if factor.norm() < least {
                (least, pair) = (factor.norm(), Some((i, j)));
            }
        }
    }
    (sign * least, pair)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_that_turns_real_changes_no_sign() {
        let z = |re: f64, im: f64| c64::new(re, im);
        let inside = torus(&[z(0.8, 0.5), z(0.8, -0.5), z(0.1, 0.0)]).0;
        let real = torus(&[z(0.9, 0.0), z(0.95, 0.0), z(0.1, 0.0)]).0;
        let outside = torus(&[z(0.8, 0.7), z(0.8, -0.7), z(0.1, 0.0)]).0;
        assert!(inside * real > 0.0 && inside * outside < 0.0);
        assert!(flip(&[z(-0.9, 0.0), z(0.3, 0.2)]) * flip(&[z(-1.1, 0.0), z(0.3, 0.2)]) < 0.0);
        assert!(flip(&[z(-1.2, 0.1), z(-1.2, -0.1)]) * flip(&[z(-1.3, 0.0), z(-1.1, 0.0)]) > 0.0);
    }

    #[test]
    fn a_test_that_vanishes_at_a_point_changes_its_sign_there() {
        let [before, at, after] = [0.1, 0.0, -0.1].map(|fold| Signs { fold, ..Signs::default() });
        let at = at.after(&before);
        assert!(before.events(&at, &Event::ALL).is_empty());
        assert_eq!(at.events(&after, &Event::ALL), [Event::Fold]);
    }

    #[test]
    fn what_lies_well_inside_changes_no_sign() {
        let z = |re: f64, im: f64| c64::new(re, im);
        let inside = [z(0.25, 0.2), z(0.25, -0.2), z(-0.3, 0.0), z(0.2, 0.0), z(-0.1, 0.0), z(0.0, 0.0)];
        let leading = [
            vec![z(2.0, 0.0), z(0.9, 0.3), z(0.9, -0.3)],
            vec![z(1.0, 0.3), z(1.0, -0.3), z(-0.8, 0.0)],
            vec![z(-2.5, 0.0), z(-0.5, 0.0), z(0.35, 0.0)],
            vec![z(-1.5, 0.0), z(1.2, 0.0), z(0.9, 0.0)],
        ];
        for few in leading {
            let all = [&few[..], &inside].concat();
            assert!(flip(&few) * flip(&all) > 0.0 && torus(&few).0 * torus(&all).0 > 0.0, "{few:?}");
        }
    }
}
