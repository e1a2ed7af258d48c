//! A few eigenvalues of a large pencil `(A + sigma M) q = 0`: those nearest to a point of the complex plane.
//!
//! Krylov-Schur iteration (Stewart 2001, doi:10.1137/S0895479800371529; faer's) on `B = -(A + s M)^-1 M`, whose eigenvalues
//! `1/(sigma - s)` are large for sigma near s. Several points along the imaginary axis make sure that no eigenvalue near
//! the axis is missed: each finds all eigenvalues in a disc, as far as the iteration finds the nearest ones first, and
//! with a symmetric positive definite M no eigenvalue is higher than a bound that A alone gives
//! (Bendixson 1902, doi:10.1007/BF02419030): with K the skew part of A,
//!
//! ```text
//! |Im sigma| <= |K| / lambda_min(M).
//! ```

use super::factors::{Base, Factors, PencilFactors};
use super::{EigenFailure, Eigenpair, Matrix, c64};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::matrix_free::LinOp;
use faer::matrix_free::eigen::{PartialEigenParams, partial_eigen, partial_eigen_scratch};
use faer::traits::ComplexField;
use faer::{Col, Mat, MatMut, MatRef, Par};

/// Eigenvalues near the imaginary axis.
pub struct Leading {
    /// Rightmost first.
    pub pairs: Vec<Eigenpair>,
    /// All eigenvalues on the axis with an imaginary part of at most this size are among them,
    pub covered: f64,
    /// and none can be higher than this, where it is known.
    pub bound: Option<f64>,
}

impl Leading {
    /// Whether no eigenvalue on the axis can be missing.
    pub fn complete(&self) -> bool {
        self.covered >= self.bound.unwrap_or(f64::INFINITY)
    }
}

/// Relative residual at which an eigenvalue counts as found.
const TOLERANCE: f64 = 1e-12;
const MOST_RESTARTS: usize = 100;
/// Points of the axis that are looked at, besides the shift.
const MOST_POINTS: usize = 12;
/// The next disc's middle, in parts of the last disc's half chord beyond the last end.
const ADVANCE: f64 = 0.8;
/// Closer than this, relatively, two findings are one.
const SAME: f64 = 1e-7;

/// The `count` eigenvalues nearest to a positive shift, and those nearest to points of the imaginary axis until no other
/// can be near it, rightmost first.
pub fn leading(a: &Matrix, m: &Matrix, shift: f64, count: usize) -> Result<Leading, EigenFailure> {
    let mut pairs = nearest(a, m, c64::new(shift, 0.0), count)?;
    let reach = |pairs: &[Eigenpair], s: c64| pairs.iter().map(|pair| (pair.value - s).norm()).fold(0.0, f64::max);
    let radius = reach(&pairs, c64::new(shift, 0.0));
    let mut covered = (radius * radius - shift * shift).max(0.0).sqrt();
    let bound = height(a, m);
    let mut step = radius.max(shift);
    for _ in 0..MOST_POINTS {
        let Some(bound) = bound.filter(|&bound| covered < bound) else { break };
        let middle = c64::new(0.0, covered + (ADVANCE * step).min(0.5 * (bound - covered).max(0.1 * step)));
        let found = nearest(a, m, middle, count)?;
        let radius = reach(&found, middle);
        if middle.im - radius <= covered {
            covered = middle.im + radius;
        }
        step = radius;
        for pair in found {
            for pair in [conjugate(&pair), pair] {
                let known = |other: &Eigenpair| (other.value - pair.value).norm() <= SAME * (pair.value.norm() + shift);
                if !pairs.iter().any(known) {
                    pairs.push(pair);
                }
            }
        }
    }
    pairs.sort_by(|x, y| {
        let (x, y) = (x.value, y.value);
        y.re.total_cmp(&x.re).then(x.im.abs().total_cmp(&y.im.abs())).then(y.im.total_cmp(&x.im))
    });
    Ok(Leading { pairs, covered, bound })
}

fn conjugate(pair: &Eigenpair) -> Eigenpair {
    Eigenpair { value: pair.value.conj(), vector: pair.vector.iter().map(|z| z.conj()).collect() }
}

/// The eigenvalues nearest to s, at least one and at most `count`, but pairs whole where s is real; vectors have length one.
pub fn nearest(a: &Matrix, m: &Matrix, s: c64, count: usize) -> Result<Vec<Eigenpair>, EigenFailure> {
    let found = if s.im == 0.0 {
        let factors = Factors::new(&a.plus(s.re, m))?;
        let mass = |x: &[f64]| {
            let mut image = vec![0.0; x.len()];
            m.times(x, &mut image);
            image.iter().map(|x| -x).collect()
        };
        iterate(&Inverse { base: &factors, mass: &mass, n: a.n() }, count)
    } else {
        let factors = PencilFactors::new(a, m, s)?;
        let mass = |x: &[c64]| m.times_complex(x).iter().map(|z| -z).collect();
        iterate(&Inverse { base: &factors, mass: &mass, n: a.n() }, count)
    };
    let found = found.into_iter().filter(|(mu, _)| mu.norm() > 0.0 && mu.re.is_finite() && mu.im.is_finite());
    // B = -(A + s M)^-1 M has the eigenvalues 1/(sigma - s).
    let mut pairs: Vec<Eigenpair> = found.map(|(mu, vector)| Eigenpair { value: s + mu.inv(), vector }).collect();
    for pair in pairs.iter_mut().filter(|_| s.im == 0.0) {
        // The real iteration leaves rounding in the imaginary part of a real eigenvalue.
        if pair.value.im.abs() <= f64::EPSILON * 10.0 * (pair.value - s).norm() {
            pair.value.im = 0.0;
        }
    }
    // Of a real pencil's last pair the iteration may have one half only.
    let halves: f64 = pairs.iter().map(|pair| if pair.value.im == 0.0 { 0.0 } else { pair.value.im.signum() }).sum();
    if s.im == 0.0
        && halves != 0.0
        && let Some(half) = pairs.iter().rfind(|pair| pair.value.im * halves > 0.0).map(conjugate)
    {
        pairs.push(half);
    }
    if pairs.is_empty() { Err(EigenFailure::None) } else { Ok(pairs) }
}

/// `|K|` over a lower bound of M's eigenvalues (Gershgorin's), if M is symmetric and these are positive.
fn height(a: &Matrix, m: &Matrix) -> Option<f64> {
    let n = a.n();
    let (mut least, mut asymmetry) = (vec![0.0; n], 0.0_f64);
    let (mut column, mut row) = (vec![0.0; n], vec![0.0; n]);
    for (i, j, x) in m.entries() {
        least[i] += if i == j { x } else { -x.abs() };
    }
    // A symmetric matrix and its transpose do the same to any vector.
    let probe: Vec<f64> = (0..n).map(|i| (1.3 * i as f64).sin() + 1.5).collect();
    m.times(&probe, &mut column);
    m.times_transposed(&probe, &mut row);
    column.iter().zip(&row).for_each(|(c, r)| asymmetry = asymmetry.max((c - r).abs()));
    let least = least.into_iter().fold(f64::INFINITY, f64::min);
    if least.is_nan() || least <= 0.0 || asymmetry > 1e-12 * m.norm_max() {
        return None;
    }
    let mut entries: std::collections::HashMap<(usize, usize), f64> = std::collections::HashMap::new();
    for (i, j, x) in a.entries().into_iter().filter(|(i, j, x)| i != j && *x != 0.0) {
        let (key, sign) = if i < j { ((i, j), 0.5) } else { ((j, i), -0.5) };
        *entries.entry(key).or_default() += sign * x;
    }
    let mut sums = vec![0.0; n];
    for ((i, j), x) in entries {
        sums[i] += x.abs();
        sums[j] += x.abs();
    }
    Some(sums.into_iter().fold(0.0, f64::max) / least)
}

/// `x -> solve(mass(x))`.
struct Inverse<'a, T> {
    base: &'a (dyn Base<T> + Sync),
    mass: &'a (dyn Fn(&[T]) -> Vec<T> + Sync),
    n: usize,
}

impl<T> std::fmt::Debug for Inverse<'_, T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Inverse({})", self.n)
    }
}

impl<T: ComplexField> LinOp<T> for Inverse<'_, T> {
    fn apply_scratch(&self, _: usize, _: Par) -> StackReq {
        StackReq::EMPTY
    }

    fn nrows(&self) -> usize {
        self.n
    }

    fn ncols(&self) -> usize {
        self.n
    }

    fn apply(&self, mut out: MatMut<'_, T>, right: MatRef<'_, T>, _: Par, _: &mut MemStack) {
        for j in 0..right.ncols() {
            let x: Vec<T> = (0..self.n).map(|i| right[(i, j)].clone()).collect();
            let mut y = (self.mass)(&x);
            self.base.solve(&mut y);
            y.into_iter().enumerate().for_each(|(i, y)| out[(i, j)] = y);
        }
    }

    fn conj_apply(&self, out: MatMut<'_, T>, right: MatRef<'_, T>, par: Par, stack: &mut MemStack) {
        self.apply(out, right, par, stack);
    }
}

/// Eigenvalues of largest size with their vectors.
fn iterate<T: ComplexField<Real = f64>>(operator: &Inverse<'_, T>, count: usize) -> Vec<(c64, Vec<c64>)> {
    let n = operator.n;
    let count = count.min(n);
    let parameters = PartialEigenParams {
        max_dim: (2 * count + 20).min(n),
        max_restarts: MOST_RESTARTS,
        ..PartialEigenParams::default()
    };
    let (mut vectors, mut values) = (Mat::<c64>::zeros(n, count), vec![c64::new(0.0, 0.0); count]);
    let start = Col::from_fn(n, |i| T::from_f64_impl(1.0 + 0.5 * (1.7 * i as f64).sin()));
    let norm = start.norm_l2();
    let start = Col::from_fn(n, |i| T::mul_real_impl(&start[i], &(1.0 / norm)));
    let mut memory = MemBuffer::new(partial_eigen_scratch(operator, count, Par::Seq, parameters));
    let stack = MemStack::new(&mut memory);
    let info =
        partial_eigen(vectors.as_mut(), &mut values, operator, start.as_ref(), TOLERANCE, Par::Seq, stack, parameters);
    (0..info.n_converged_eigen.min(count)).map(|k| (values[k], (0..n).map(|i| vectors[(i, k)]).collect())).collect()
}
