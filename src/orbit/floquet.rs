//! Floquet multipliers from the intervals' own transition maps, whose product is never formed.
//!
//! What the condensed rows of interval j say of perturbations, `C_j x_j + D_j x_{j+1} = 0`, is
//! `x_{j+1} = A_j x_j` with `A_j = -D_j^-1 C_j`. With `u(t + P) = S u(t)` the multipliers over P are the eigenvalues nu
//! of `S^-1 A_N .. A_2 A_1`. Where P is half the period, those over the period are `mu = nu²`: a perturbation of an
//! orbit with `u(t + T/2) = S u(t)` keeps that symmetry where nu is near +1 (a fold) and breaks it where nu is near -1,
//! though mu = 1 in both. A period doubling, mu = -1, would need nu = ±i, which one parameter does not bring about (Swift and
//! Wiesenfeld 1984, doi:10.1103/PhysRevLett.52.705).
//!
//! One multiplier over P is +1, the shift in time, and one more for each continuous symmetry along which the orbit may drift;
//! the largest distance of these from 1 bounds from below how wrong the others are (on
//! an even mesh it can be far smaller than the orbit's own error, which refinement tells).

use super::Rows;
use crate::linalg::periodic::{self, Eigenvalue, PeriodicError, Product};
use crate::linalg::{Lu, Singular, c64};
use crate::problem::Reflection;
use faer::linalg::matmul::matmul;
use faer::reborrow::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;
use thiserror::Error;

/// Why an orbit has no multipliers.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum FloquetError {
    #[error("an interval of the mesh does not determine its right end: {0}")]
    Interval(#[from] Singular),
    #[error(transparent)]
    Product(#[from] PeriodicError),
    #[error("the orbit has no multiplier, not even the trivial one")]
    None,
}

/// Multipliers over the period, largest first, the trivial ones left out.
#[derive(Clone, Debug)]
pub struct Multipliers {
    pub values: Vec<c64>,
    /// `ln |mu|` of each, also where mu itself is too small or too large for a number; -inf is an exact zero.
    pub logs: Vec<f64>,
    /// The multipliers nu over half the period, `mu = nu²`, in the same order; none where the whole one was computed.
    pub halves: Vec<c64>,
    /// |trivial multiplier - 1|, the largest if there are several.
    pub trivial_error: f64,
}

/// What multipliers say of an orbit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    Stable,
    Unstable,
    /// No multiplier lies outside the unit circle for certain, but one is nearer to it than the trivial one's error.
    Undecided,
}

impl Multipliers {
    /// How far from the unit circle a multiplier must be for a verdict: the trivial one's error limits it.
    fn slack(&self) -> f64 {
        10.0 * self.trivial_error + 1e-12
    }

    /// Multipliers outside the unit circle for certain.
    pub fn unstable(&self) -> usize {
        self.logs.iter().filter(|&&ln| ln > self.slack().ln_1p()).count()
    }

    pub fn verdict(&self) -> Stability {
        match self.logs.first() {
            Some(_) if self.unstable() > 0 => Stability::Unstable,
            Some(&ln) if ln >= (-self.slack()).max(-1.0).ln_1p() => Stability::Undecided,
            _ => Stability::Stable,
        }
    }
}

/// The maps `x_{j+1} = -D_j^-1 C_j x_j` of the intervals in order.
pub struct Transitions<'a> {
    maps: Vec<Transition<'a>>,
    /// Their product.
    formed: Option<MatRef<'a, f64>>,
}

/// Operations of a thread on transitions, below which there is nothing to gain.
const WORTH_SHARING: usize = 200_000;

struct Transition<'a> {
    c: MatRef<'a, f64>,
    /// None where D = -1: then C is the map.
    d: Option<Lu<f64>>,
}

impl<'a> Transitions<'a> {
    /// From each interval's condensed rows.
    pub fn new(intervals: &[Rows<'a>]) -> Result<Self, Singular> {
        let one =
            |&Rows { c, d, .. }: &Rows<'a>| Ok(Transition { c, d: d.map(|d| Lu::new(d.to_owned())).transpose()? });
        let least = WORTH_SHARING / intervals.first().map_or(1, |rows| rows.c.nrows().pow(3));
        let maps = intervals.par_iter().with_min_len(least.max(1)).map(one);
        Ok(Self { maps: maps.collect::<Result<_, _>>()?, formed: None })
    }

    /// With what was found for all of them together: their product, if condensation formed it.
    pub fn with(self, whole: Rows<'a>) -> Self {
        Self { formed: whole.d.is_none().then_some(whole.c), ..self }
    }
}

impl Product for Transitions<'_> {
    fn dim(&self) -> usize {
        self.maps.first().map_or(0, |transition| transition.c.nrows())
    }

    fn factors(&self) -> usize {
        self.maps.len()
    }

    fn apply(&self, j: usize, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>) {
        let Transition { c, d } = &self.maps[j];
        let sign = if d.is_some() { -1.0 } else { 1.0 };
        matmul(y.rb_mut(), Accum::Replace, *c, x, sign, Par::Seq);
        if let Some(d) = d {
            d.solve_many(y);
        }
    }

    fn matrix(&self, j: usize) -> Mat<f64> {
        let Transition { c, d } = &self.maps[j];
        match d {
            Some(d) => {
                let mut a = -*c;
                d.solve_many(a.as_mut());
                a
            }
            None => c.to_owned(),
        }
    }

    fn formed(&self) -> Option<Mat<f64>> {
        self.formed.map(|c| c.to_owned())
    }
}

/// A product with S^-1 = S^T behind its last factor.
struct Turned<'a> {
    transitions: &'a dyn Product,
    symmetry: &'a Reflection,
}

impl Turned<'_> {
    fn is_last(&self, j: usize) -> bool {
        j + 1 == self.factors()
    }

    fn turned(&self, a: MatRef<'_, f64>, mut out: MatMut<'_, f64>) {
        out.fill(0.0);
        for (i, (&source, &sign)) in self.symmetry.source.iter().zip(&self.symmetry.sign).enumerate() {
            for k in 0..a.ncols() {
                out[(source, k)] += sign * a[(i, k)];
            }
        }
    }
}

impl Product for Turned<'_> {
    fn dim(&self) -> usize {
        self.transitions.dim()
    }

    fn factors(&self) -> usize {
        self.transitions.factors()
    }

    fn apply(&self, j: usize, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>) {
        self.transitions.apply(j, x, y.rb_mut());
        if self.is_last(j) {
            let image = y.to_owned();
            self.turned(image.as_ref(), y);
        }
    }

    fn matrix(&self, j: usize) -> Mat<f64> {
        let a = self.transitions.matrix(j);
        if !self.is_last(j) {
            return a;
        }
        let mut turned = Mat::zeros(a.nrows(), a.ncols());
        self.turned(a.as_ref(), turned.as_mut());
        turned
    }

    fn formed(&self) -> Option<Mat<f64>> {
        let formed = self.transitions.formed()?;
        let mut turned = Mat::zeros(formed.nrows(), formed.ncols());
        self.turned(formed.as_ref(), turned.as_mut());
        Some(turned)
    }
}

/// Where the smallest multiplier found is smaller than this, the trivial one and all unstable ones are among those
/// found; where its product with the largest is, every pair with a product of one or more is as well.
const INSIDE: f64 = 0.9;
/// At least so many are sought at first.
const FEW: usize = 4;

/// Multipliers from the transition maps along the computed part of the period, of which there are `parts` (1 or 2) in
/// the whole one: all of them, or of those largest in modulus at least `wanted` and as many more as it takes to count
/// the unstable ones and the pairs with a product beyond one right. The `trivial` ones nearest to 1 are left out: one for the shift in time and one for each
/// continuous symmetry.
pub fn multipliers(
    transitions: &dyn Product,
    (symmetry, parts): (&Reflection, usize),
    trivial: usize,
    wanted: Option<usize>,
) -> Result<Multipliers, FloquetError> {
    let turned = Turned { transitions, symmetry };
    let n = turned.dim();
    // Trivial ones are not counted.
    let mut count = wanted.map_or(n, |wanted| wanted.max(FEW) + trivial);
    let mut found: Vec<Eigenvalue>;
    loop {
        found = if count < n { periodic::leading(&turned, count)? } else { periodic::all(&turned)? };
        let most = found.first().map_or(0.0, |most| most.ln.max(0.0));
        if count >= n || found.last().is_some_and(|least| least.ln + most < INSIDE.ln()) {
            break;
        }
        count *= 2;
    }
    let distance = |nu: &Eigenvalue| (nu.value() - c64::new(1.0, 0.0)).norm();
    let mut removed = Vec::with_capacity(trivial);
    for _ in 0..trivial {
        let nearest = (0..found.len()).min_by(|&i, &j| distance(&found[i]).total_cmp(&distance(&found[j])));
        removed.push(found.remove(nearest.ok_or(FloquetError::None)?));
    }
    let whole = |nu: &Eigenvalue| match parts {
        2 => Eigenvalue { ln: 2.0 * nu.ln, direction: nu.direction * nu.direction },
        _ => *nu,
    };
    let halves = if parts == 2 { found.iter().map(Eigenvalue::value).collect() } else { Vec::new() };
    Ok(Multipliers {
        values: found.iter().map(|nu| whole(nu).value()).collect(),
        logs: found.iter().map(|nu| whole(nu).ln).collect(),
        halves,
        trivial_error: removed.iter().map(|nu| distance(&whole(nu))).fold(0.0, f64::max),
    })
}
