//! A text as a [`Formula`].

use super::graph::Graph;
use super::linearisation::Linearisation;
use super::rows::Row;
use super::tape::Tape;
use crate::linalg::{Matrix, Structure};
use crate::problem::{At, Formula, Observable, Parameter, Reflection, Rotation, Scalar};
use std::sync::Arc;

/// A model that was written as text.
pub struct Text {
    /// Of the unknowns.
    pub names: Vec<String>,
    pub(super) parameters: Vec<Parameter>,
    pub(super) residual: Tape,
    pub(super) start: Tape,
    pub(super) measures: Vec<Tape>,
    pub(super) observables: Vec<Observable>,
    pub(super) structure: Structure,
    pub(super) linearisation: Linearisation,
    pub(super) reflection: Option<Reflection>,
    pub(super) rotations: Vec<Rotation>,
    pub(super) time_unit: &'static str,
    pub(super) start_names: Vec<String>,
    pub(super) rows: Vec<Row>,
    pub(super) graph: Graph,
}

impl Formula for Arc<Text> {
    fn dim(&self) -> usize {
        self.rows.len()
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        self.residual.evaluate(u, v, p, g);
    }

    fn linearise(&self, at: At, gu: &mut Matrix, gv: &mut Matrix) {
        self.linearisation.fill(&self.residual, at, gu, gv);
    }

    fn structure(&self) -> Structure {
        self.structure.clone()
    }

    fn unknowns(&self) -> Vec<String> {
        self.names.clone()
    }

    fn start(&self, p: &[f64]) -> Vec<f64> {
        let rest = vec![0.0; self.rows.len()];
        let mut u = rest.clone();
        self.start.evaluate(&rest, &rest, p, &mut u);
        u
    }

    fn time_unit(&self) -> &'static str {
        self.time_unit
    }

    fn observables(&self) -> &[Observable] {
        &self.observables
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        let mut value = [f64::NAN];
        self.measures[i].evaluate(at.u, at.v, at.p, &mut value);
        value[0]
    }

    fn reflection(&self) -> Option<Reflection> {
        self.reflection.clone()
    }

    fn rotations(&self) -> &[Rotation] {
        &self.rotations
    }
}
