//! The system for (u, v_d) in the words of the integrator's library.
//!
//! Time runs from 0 to 1 over the whole motion: its first step and its least one are absolute numbers.

use super::form::Form;
use crate::linalg::{Matrix, finite};
use crate::problem::At;
use diffsol::{
    ConstantOp, FaerContext, FaerSparseMat, FaerVec, LinearOp, Matrix as _, NonLinearOp, NonLinearOpJacobian,
    OdeEquations, OdeEquationsRef, Op, ParameterisedOp, UnitCallable, Vector as _, VectorCommon as _,
};
use faer::sparse::{Pair, SymbolicSparseColMat};
use std::cell::{Cell, RefCell};

pub type Parameters<'a> = &'a dyn Fn(f64) -> Vec<f64>;

pub struct Equations<'a> {
    pub form: &'a Form<'a>,
    /// All parameters at a fraction of the time.
    pub parameters: Parameters<'a>,
    pub duration: f64,
    pub start: Vec<f64>,
    pub trouble: Cell<Option<Trouble>>,
    pub evaluations: Cell<usize>,
    pub jacobians: Cell<usize>,
    pattern: SymbolicSparseColMat<usize>,
    places: Places,
    matrices: RefCell<(Matrix, Matrix)>,
    context: FaerContext,
}

/// What an evaluation could not do, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
    NotFinite,
    Rate(usize),
}

/// Where entries go in the sparse matrix.
struct Places {
    /// `T v_d` in the first equations.
    rates: Vec<usize>,
    /// Of each entry of `G_u`, in the order of [`Matrix::entries`].
    state: Vec<usize>,
    /// Of each entry of `G_v`; None at algebraic unknowns.
    rate: Vec<Option<usize>>,
}

impl<'a> Equations<'a> {
    pub fn new(form: &'a Form<'a>, parameters: Parameters<'a>, duration: f64, start: Vec<f64>) -> Option<Self> {
        let n = form.algebraic.len();
        let zeros = || Matrix::zeros(form.problem.structure(), n);
        let matrices = (zeros(), zeros());
        // Equations: u_d' = T v_d in the rows of u_d, then those of G in the rows that are left, in order.
        let free: Vec<usize> = (0..n).filter(|&i| form.algebraic[i]).chain(n..form.dim()).collect();
        let mut column = vec![None; n];
        form.differential.iter().enumerate().for_each(|(k, &j)| column[j] = Some(n + k));
        let entries: Vec<(usize, usize)> = matrices.0.entries().into_iter().map(|(i, j, _)| (i, j)).collect();
        let rates: Vec<Pair<usize, usize>> =
            form.differential.iter().enumerate().map(|(k, &i)| Pair::new(i, n + k)).collect();
        let state: Vec<Pair<usize, usize>> = entries.iter().map(|&(i, j)| Pair::new(free[i], j)).collect();
        let rate: Vec<Option<Pair<usize, usize>>> =
            entries.iter().map(|&(i, j)| column[j].map(|c| Pair::new(free[i], c))).collect();
        // The mass lies on the diagonal, which the integrator's matrix M - c J therefore needs.
        let diagonal = (0..form.dim()).map(|i| Pair::new(i, i));
        let all: Vec<Pair<usize, usize>> = rates
            .iter()
            .copied()
            .chain(state.iter().copied())
            .chain(rate.iter().flatten().copied())
            .chain(diagonal)
            .collect();
        let (pattern, _) = SymbolicSparseColMat::try_new_from_indices(form.dim(), form.dim(), &all).ok()?;
        let place = |pair: Pair<usize, usize>| {
            let range = pattern.col_range(pair.col);
            pattern.row_idx()[range.clone()].binary_search(&pair.row).ok().map(|k| range.start + k)
        };
        let places = Places {
            rates: rates.into_iter().map(place).collect::<Option<_>>()?,
            state: state.into_iter().map(place).collect::<Option<_>>()?,
            rate: rate.into_iter().map(|pair| pair.and_then(place)).collect(),
        };
        Some(Self {
            form,
            parameters,
            duration,
            start,
            trouble: Cell::new(None),
            evaluations: Cell::new(0),
            jacobians: Cell::new(0),
            pattern,
            places,
            matrices: RefCell::new(matrices),
            context: FaerContext::default(),
        })
    }

    fn evaluate(&self, y: &[f64], t: f64, out: &mut [f64]) {
        self.evaluations.set(self.evaluations.get() + 1);
        let n = self.form.algebraic.len();
        let (u, v) = self.form.split(y);
        let mut g = vec![0.0; n];
        self.form.problem.residual(At { u, v: &v, p: &(self.parameters)(t) }, &mut g);
        if !finite(&g) && finite(y) {
            self.trouble.set(Some(Trouble::NotFinite));
        }
        let mut rows = g.into_iter();
        for i in 0..out.len() {
            let rate = i < n && !self.form.algebraic[i];
            out[i] = if rate { self.duration * v[i] } else { rows.next().unwrap_or(0.0) };
        }
    }

    /// Values of the Jacobian in the order of the pattern.
    fn linearise(&self, y: &[f64], t: f64, values: &mut [f64]) {
        self.jacobians.set(self.jacobians.get() + 1);
        let (u, v) = self.form.split(y);
        let (gu, gv) = &mut *self.matrices.borrow_mut();
        self.form.problem.linearise(At { u, v: &v, p: &(self.parameters)(t) }, gu, gv);
        values.fill(0.0);
        self.places.rates.iter().for_each(|&k| values[k] = self.duration);
        for (&k, (.., x)) in self.places.state.iter().zip(gu.entries()) {
            values[k] = x;
        }
        for (k, (_, j, x)) in self.places.rate.iter().zip(gv.entries()) {
            match k {
                Some(k) => values[*k] = x,
                None if x != 0.0 && x.is_finite() => self.trouble.set(Some(Trouble::Rate(j))),
                None => {}
            }
        }
    }
}

type V = FaerVec<f64>;
type M = FaerSparseMat<f64>;

/// The whole as seen by the library: an operator for each of its parts.
pub struct Part<'e, 'a>(&'e Equations<'a>);

macro_rules! operator {
    ($name:ty, $this:ident => $equations:expr, $($generics:tt)*) => {
        impl<$($generics)*> Op for $name {
            type T = f64;
            type V = V;
            type M = M;
            type C = FaerContext;
            fn context(&self) -> &FaerContext {
                let $this = self;
                &$equations.context
            }
            fn nstates(&self) -> usize {
                let $this = self;
                $equations.form.dim()
            }
            fn nout(&self) -> usize {
                let $this = self;
                $equations.form.dim()
            }
            fn nparams(&self) -> usize {
                0
            }
        }
    };
}

operator!(Equations<'a>, this => this, 'a);
operator!(Part<'e, 'a>, this => this.0, 'e, 'a);

impl NonLinearOp for Part<'_, '_> {
    fn call_inplace(&self, y: &V, t: f64, out: &mut V) {
        let mut rows = vec![0.0; self.0.form.dim()];
        self.0.evaluate(y.inner().col_as_slice(0), t, &mut rows);
        out.inner_mut().col_as_slice_mut(0).copy_from_slice(&rows);
    }
}

impl NonLinearOpJacobian for Part<'_, '_> {
    fn jac_mul_inplace(&self, y: &V, t: f64, d: &V, out: &mut V) {
        let mut matrix = M::new_from_sparsity(self.nstates(), self.nstates(), self.jacobian_sparsity(), self.0.context);
        self.jacobian_inplace(y, t, &mut matrix);
        matrix.gemv(1.0, d, 0.0, out);
    }

    fn jacobian_inplace(&self, y: &V, t: f64, matrix: &mut M) {
        self.0.linearise(y.inner().col_as_slice(0), t, matrix.inner_mut()[0].val_mut());
    }

    fn jacobian_sparsity(&self) -> Option<SymbolicSparseColMat<usize>> {
        Some(self.0.pattern.clone())
    }
}

impl LinearOp for Part<'_, '_> {
    /// The mass: one for u_d, zero for the rest.
    fn gemv_inplace(&self, x: &V, _t: f64, beta: f64, out: &mut V) {
        let x = x.inner().col_as_slice(0);
        let out = out.inner_mut().col_as_slice_mut(0);
        for (i, out) in out.iter_mut().enumerate() {
            let one = i < self.0.form.algebraic.len() && !self.0.form.algebraic[i];
            let kept = if beta == 0.0 { 0.0 } else { beta * *out };
            *out = kept + if one { x[i] } else { 0.0 };
        }
    }

    fn matrix_inplace(&self, _t: f64, matrix: &mut M) {
        let values = matrix.inner_mut()[0].val_mut();
        for (i, value) in values.iter_mut().enumerate() {
            *value = f64::from(u8::from(i < self.0.form.algebraic.len() && !self.0.form.algebraic[i]));
        }
    }

    fn sparsity(&self) -> Option<SymbolicSparseColMat<usize>> {
        let diagonal: Vec<Pair<usize, usize>> = (0..self.0.form.dim()).map(|i| Pair::new(i, i)).collect();
        SymbolicSparseColMat::try_new_from_indices(diagonal.len(), diagonal.len(), &diagonal).ok().map(|found| found.0)
    }
}

impl ConstantOp for Part<'_, '_> {
    fn call_inplace(&self, _t: f64, out: &mut V) {
        out.inner_mut().col_as_slice_mut(0).copy_from_slice(&self.0.start);
    }
}

impl<'e, 'a> OdeEquationsRef<'e> for Equations<'a> {
    type Mass = Part<'e, 'a>;
    type Rhs = Part<'e, 'a>;
    type Root = ParameterisedOp<'e, UnitCallable<M>>;
    type Init = Part<'e, 'a>;
    type Out = ParameterisedOp<'e, UnitCallable<M>>;
    type Reset = ParameterisedOp<'e, UnitCallable<M>>;
}

impl<'a> OdeEquations for Equations<'a> {
    fn rhs(&self) -> Part<'_, 'a> {
        Part(self)
    }

    fn mass(&self) -> Option<Part<'_, 'a>> {
        Some(Part(self))
    }

    fn init(&self) -> Part<'_, 'a> {
        Part(self)
    }

    fn set_params(&mut self, _p: &V) {}

    fn get_params(&self, _p: &mut V) {}
}
