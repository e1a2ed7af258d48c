//! Equilibria and their rightmost eigenvalues at many parameter points, each from the one before.
//!
//! Unlike a branch, where a curve is followed through folds, the parameters are given here: Newton's method on
//! `G(u, 0, p) = 0` at fixed p, from the state at the last point; where it fails, by way of points in between.

use crate::continuation::{Counts, Failure};
use crate::linalg::{EigenFailure, Lu, Rightmost, finite, norm, rightmost};
use crate::problem::{At, Problem};
use faer::Mat;
use thiserror::Error;

/// Why there is nothing at a point.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum LeadingFailure {
    #[error(transparent)]
    Newton(#[from] Failure),
    #[error(transparent)]
    Eigenvalue(#[from] EigenFailure),
}

/// An equilibrium and its rightmost eigenvalue.
#[derive(Clone, Debug)]
pub struct Leading {
    pub u: Vec<f64>,
    pub mode: Rightmost,
}

/// The way along a line of parameter points: where it is, and what it expects next.
#[derive(Clone)]
pub struct Line<'a> {
    problem: &'a dyn Problem,
    u: Vec<f64>,
    p: Vec<f64>,
    /// The size of the largest state met.
    largest: f64,
    /// For the pencil; none before the first eigenvalue.
    shift: Option<f64>,
    pub counts: Counts,
}

/// The equilibrium with `G_u` and `G_v` there.
struct Settled {
    u: Vec<f64>,
    gu: Mat<f64>,
    gv: Mat<f64>,
}

const MOST_STEPS: usize = 16;
/// Newton steps, in parts of the largest state met, at which the state is solved for,
const TOLERANCE: f64 = 1e-11;
/// or below which steps that shrink no more are rounding.
const ROUNDING: f64 = 1e-8;
/// So many times a way that is too long is halved.
const HALVINGS: usize = 2;
/// The shift in parts of the leading eigenvalues' size: to the right of all that matter, and not far.
const BEYOND: f64 = 1.5;
/// Times the shift: a second try.
const OTHER: f64 = 1.7;

impl<'a> Line<'a> {
    /// From a state that need not be an equilibrium, at parameters p.
    pub fn new(problem: &'a dyn Problem, u: Vec<f64>, p: Vec<f64>) -> Self {
        Self { problem, u, p, largest: 0.0, shift: None, counts: Counts::default() }
    }

    /// Another line from where this one is, with nothing counted yet.
    pub fn fresh(&self) -> Self {
        Self { counts: Counts::default(), ..self.clone() }
    }

    /// Goes to other parameters without a look at the eigenvalues. On failure the line stays where it is.
    pub fn go(&mut self, p: &[f64]) -> Result<(), Failure> {
        self.reach(p).map(drop)
    }

    /// Goes to other parameters and computes the rightmost eigenvalue there.
    pub fn leading(&mut self, p: &[f64]) -> Result<Leading, LeadingFailure> {
        let Settled { u, gu, gv } = self.reach(p)?;
        let counts = &mut self.counts;
        let mut ask = |shift: f64| {
            counts.spectra += 1;
            // A shift may happen to be an eigenvalue; another one is not.
            rightmost(gu.as_ref(), gv.as_ref(), shift).or_else(|_| {
                counts.spectra += 1;
                rightmost(gu.as_ref(), gv.as_ref(), OTHER * shift)
            })
        };
        let after = |mode: &Rightmost| if mode.size > 0.0 { BEYOND * mode.size } else { 1.0 };
        // The first shift is a guess: its eigenvalues give the second one.
        let shift = match self.shift {
            Some(shift) => shift,
            None => after(&ask(1.0)?),
        };
        let mode = ask(shift)?;
        self.shift = Some(after(&mode));
        Ok(Leading { u, mode })
    }

    fn reach(&mut self, p: &[f64]) -> Result<Settled, Failure> {
        let (u, from) = (self.u.clone(), self.p.clone());
        let settled = self.between((&u, &from), p, HALVINGS)?;
        (self.u, self.p) = (settled.u.clone(), p.to_vec());
        Ok(settled)
    }

    /// From the state u at `from` to `to`, if need be by the middle.
    fn between(&mut self, (u, from): (&[f64], &[f64]), to: &[f64], halvings: usize) -> Result<Settled, Failure> {
        match self.settle(u, to) {
            Err(_) if halvings > 0 => {
                let middle: Vec<f64> = from.iter().zip(to).map(|(a, b)| 0.5 * (a + b)).collect();
                let half = self.between((u, from), &middle, halvings - 1)?;
                self.between((&half.u, &middle), to, halvings - 1)
            }
            settled => settled,
        }
    }

    /// Newton's method at fixed parameters.
    fn settle(&mut self, u: &[f64], p: &[f64]) -> Result<Settled, Failure> {
        let mut u = u.to_vec();
        let (rest, mut right) = (vec![0.0; u.len()], vec![0.0; u.len()]);
        self.largest = self.largest.max(norm(&u));
        let mut last = f64::INFINITY;
        for step in 0..MOST_STEPS {
            let at = At { u: &u, v: &rest, p };
            self.problem.residual(at, &mut right);
            self.counts.residuals += 1;
            if !finite(&right) {
                return Err(Failure::NotFinite);
            }
            let (gu, gv) = self.problem.linearised(at);
            // The straight way: states that do not move with the parameters are solutions at once.
            if right.iter().all(|r| *r == 0.0) {
                return Ok(Settled { u, gu, gv });
            }
            Lu::new(gu)?.solve(&mut right);
            self.counts.factorisations += 1;
            self.counts.newton += 1;
            if !finite(&right) {
                return Err(Failure::NotFinite);
            }
            u.iter_mut().zip(&right).for_each(|(u, d)| *u -= d);
            let size = norm(&right);
            self.largest = self.largest.max(norm(&u));
            let largest = self.largest;
            if size <= TOLERANCE * largest || (size <= ROUNDING * largest && size > 0.5 * last) {
                let (gu, gv) = self.problem.linearised(At { u: &u, v: &rest, p });
                return Ok(Settled { u, gu, gv });
            }
            if step > 2 && size > 2.0 * last {
                return Err(Failure::Diverged(size));
            }
            last = size;
        }
        Err(Failure::Diverged(last))
    }
}
