//! Large problems with structure: Bratu's problem on a line and on a square, the Brusselator on a line.

mod common;

use common::brusselator::Brusselator;
use common::{close, near, parameter};
use hopfline::bifurcation::{ALL_EIGENVALUES, Coordinate, Equilibria, HopfNormalForm, Mark, Sample, Spectra, folds};
use hopfline::continuation::{Border, Counts, StepControl, Walk, correct};
use hopfline::linalg::{Matrix, Pattern, Structure, c64, leading, nearest};
use hopfline::problem::{At, Automatic, Formula, Parameter, Problem, Scalar, check_derivatives};
use std::f64::consts::PI;
use std::sync::Arc;

/// `u' = Laplace u + lambda e^u` on the unit interval (dimension 1) or square (2), u = 0 at the boundary, by second-order
/// differences at m interior points in each direction.
struct Bratu {
    points: usize,
    dimension: usize,
    structure: Structure,
    parameters: [Parameter; 1],
}

impl Bratu {
    fn problem(points: usize, dimension: usize) -> Arc<dyn Problem> {
        let structure = match dimension {
            1 => Structure::Banded { lower: 1, upper: 1 },
            _ => {
                let n = points * points;
                let entries = (0..n).flat_map(|k| {
                    let (row, column) = (k / points, k % points);
                    let beside = [(column > 0, k.wrapping_sub(1)), (column + 1 < points, k + 1)];
                    let above = [(row > 0, k.wrapping_sub(points)), (row + 1 < points, k + points)];
                    beside.into_iter().chain(above).filter(|(there, _)| *there).map(move |(_, j)| (k, j))
                });
                Structure::Sparse(Arc::new(Pattern::new(n, entries)))
            }
        };
        Arc::new(Automatic(Self { points, dimension, structure, parameters: [parameter("lambda", 0.0)] }))
    }
}

impl Formula for Bratu {
    fn dim(&self) -> usize {
        self.points.pow(self.dimension as u32)
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn structure(&self) -> Structure {
        self.structure.clone()
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let (m, scale) = (self.points, ((self.points + 1) as f64).powi(2));
        for (k, g) in g.iter_mut().enumerate() {
            let mut sum = S::from(0.0);
            for stride in [1, m].into_iter().take(self.dimension) {
                let place = k / stride % m;
                sum -= u[k] * 2.0;
                if place > 0 {
                    sum += u[k - stride];
                }
                if place + 1 < m {
                    sum += u[k + stride];
                }
            }
            *g = v[k] - sum * scale - p[0] * u[k].exp();
        }
    }
}

/// The fold of the branch from lambda = 0.
fn fold(points: usize, dimension: usize) -> f64 {
    let problem = Bratu::problem(points, dimension);
    let n = problem.dim();
    let range = (0.0, [4.0, 8.0][dimension - 1]);
    let coordinate = Coordinate { index: 0, logarithmic: false, width: range.1 };
    let mut system = Equilibria { problem, p: vec![0.0], coordinate, scale_state: 1.0, all_eigenvalues: None };
    let mut counts = Counts::default();
    let border = Border { row: vec![0.0; n], lambda: 1.0 };
    let first = correct(&system, (vec![0.0; n], 0.0), &border, &mut counts).unwrap().point;
    let mut samples = vec![Sample::new(first.clone(), None)];
    let still = system.clone();
    let mut walk = Walk::new(&mut system, first, StepControl { step: 0.05, least: 1e-6, most: 0.3 }, range);
    while samples[samples.len() - 1].point.tangent_lambda > -0.5 {
        samples.push(Sample::new(walk.step().unwrap().to, None));
        assert!(samples.len() < 100);
    }
    folds(&still, &mut samples, &mut counts).unwrap();
    let found: Vec<_> =
        samples.iter().filter_map(|s| if let Some(Mark::Fold(f)) = &s.mark { f.clone() } else { None }).collect();
    assert_eq!(found.len(), 1);
    found[0].p[0]
}

/// On the line: lambda* = 8 (theta / cosh theta)² at theta tanh theta = 1, 3.513830719125 (Frank-Kamenetskii).
#[test]
fn the_fold_of_bratu_on_a_line_converges_with_the_second_order() {
    let theta = (0..60).fold(1.2_f64, |t, _| t - (t * t.tanh() - 1.0) / (t.tanh() + t / t.cosh().powi(2)));
    let exact = 8.0 * (theta / theta.cosh()).powi(2);
    close("exact", exact, 3.513830719125, 1e-12);
    let errors = [250, 500, 1000].map(|n| {
        let lambda = fold(n, 1);
        ((lambda - exact), 1.0 / (n + 1) as f64)
    });
    for pair in errors.windows(2) {
        let order = (pair[0].0 / pair[1].0).ln() / (pair[0].1 / pair[1].1).ln();
        near("order", order, 2.0, 1e-3);
    }
    let [_, (a, h), (b, k)] = errors;
    near("extrapolated", (b * h * h - a * k * k) / (h * h - k * k), 0.0, 1e-9);
}

/// On the square: 6.808124423 (Mohsen 2014, doi:10.1016/j.camwa.2013.10.003, among many).
#[test]
fn the_fold_of_bratu_on_a_square_converges_with_the_second_order() {
    let found = [25, 50, 100].map(|m| {
        let lambda = fold(m, 2);
        (lambda, 1.0 / (m + 1) as f64)
    });
    let exact = 6.808124423;
    for pair in found.windows(2) {
        let order = ((pair[0].0 - exact) / (pair[1].0 - exact)).ln() / (pair[0].1 / pair[1].1).ln();
        near("order", order, 2.0, 2e-2);
    }
    let [_, (a, h), (b, k)] = found;
    near("extrapolated", (b * h * h - a * k * k) / (h * h - k * k), exact, 3e-7);
}

#[test]
fn derivatives_by_groups_of_columns_are_those_by_single_ones() {
    for dimension in [1, 2] {
        let problem = Bratu::problem(7, dimension);
        let (n, p) = (problem.dim(), [1.3]);
        let u: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        assert_eq!(check_derivatives(&*problem, At { u: &u, v: &vec![0.0; n], p: &p }), 0.0);
    }
}

/// Eigenvalues on the square: -4 (sin² + sin²)/h², of which most are double.
#[test]
fn eigenvalues_nearest_to_a_point() {
    let m = 30;
    let problem = Bratu::problem(m, 2);
    let (u, p) = (vec![0.0; m * m], [0.0]);
    let (gu, gv) = problem.matrices(At { u: &u, v: &u, p: &p });
    let found = nearest(&gu, &gv, c64::new(10.0, 0.0), 8).unwrap();
    let h = 1.0 / (m + 1) as f64;
    let wave = |k: usize| 4.0 * (PI * k as f64 * h / 2.0).sin().powi(2) / (h * h);
    let mut exact: Vec<f64> = (1..6).flat_map(|j| (1..6).map(move |k| -wave(j) - wave(k))).collect();
    exact.sort_by(|a, b| b.total_cmp(a));
    exact.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    for pair in &found {
        let off = exact.iter().map(|x| (pair.value - x).norm() / x.abs()).fold(f64::INFINITY, f64::min);
        assert!(off < 1e-11, "{} {off}", pair.value);
    }
    // Symmetric: nothing can be off the real axis.
    assert!(leading(&gu, &gv, 10.0, 8).unwrap().bound.unwrap() < 1e-9);
}

/// Waves without damping: eigenvalues 100 i cos(k h), more along the axis than a few discs hold. A row of M without an entry
/// leaves them without a bound.
#[test]
fn an_axis_that_is_not_covered_is_not_said_to_be() {
    let n = 400;
    let mut a = faer::Mat::<f64>::zeros(n, n);
    for i in 1..n {
        (a[(i, i - 1)], a[(i - 1, i)]) = (-50.0, 50.0);
    }
    let a = Matrix::Dense(a);
    let mut m = faer::Mat::<f64>::identity(n, n);
    let found = leading(&a, &Matrix::Dense(m.clone()), 1.0, 8).unwrap();
    close("bound", found.bound.unwrap(), 100.0, 1e-12);
    assert!(!found.complete() && found.covered < 100.0, "{}", found.covered);
    // What is said to be covered is found.
    let exact = (1..=n).map(|k| 100.0 * (PI * k as f64 / (n + 1) as f64).cos()).filter(|z| z.abs() < found.covered);
    let off =
        |z: f64| found.pairs.iter().map(|pair| (pair.value - c64::new(0.0, z)).norm()).fold(f64::INFINITY, f64::min);
    let all: Vec<f64> = exact.map(off).collect();
    assert!(all.len() >= 8 && all.iter().all(|off| *off < 1e-9), "{all:?}");
    m[(0, 0)] = 0.0;
    let found = leading(&a, &Matrix::Dense(m), 1.0, 8).unwrap();
    assert!(found.bound.is_none() && !found.complete());
}

/// Brusselator on a line at its Hopf points: `L² = (Dx + Dy) m / (B - 1 - A²)`, m = 4 (N + 1)² sin²(pi / (2 (N + 1))).
#[test]
fn hopf_points_of_a_long_chain() {
    let points = 600;
    let problem = Brusselator::chain(points, true);
    let n = problem.dim();
    assert!(n > ALL_EIGENVALUES);
    let range = (0.45, 0.6);
    let coordinate = Coordinate { index: 0, logarithmic: false, width: range.1 - range.0 };
    let u = problem.start(&[range.0]);
    let mut system = Equilibria { problem, p: vec![range.0], coordinate, scale_state: 2.0, all_eigenvalues: None };
    let mut counts = Counts::default();
    let border = Border { row: vec![0.0; n], lambda: 1.0 };
    let first = correct(&system, (u, range.0), &border, &mut counts).unwrap().point;
    let still = system.clone();
    let mut samples = vec![Sample::new(first.clone(), None)];
    let mut walk = Walk::new(&mut system, first, StepControl { step: 0.2, least: 1e-6, most: 0.3 }, range);
    loop {
        let step = walk.step().unwrap();
        samples.push(Sample::new(step.to, None));
        if step.stop.is_some() {
            break;
        }
    }
    let tool = Spectra::new(&still, 4, &|| false, &mut samples, &mut counts).unwrap();
    // The skew part is 5.45 + A^2 at most, and the discs reach as far.
    let reach = tool.reach.unwrap();
    assert!(reach.complete && reach.covered >= reach.bound.unwrap() && reach.bound.unwrap() > 2.1, "{reach:?}");
    tool.follow(&mut samples, &mut counts).unwrap();
    assert_eq!(tool.hopf_points(&mut samples, &mut counts), Vec::<String>::new());
    let found: Vec<_> = samples
        .iter()
        .filter_map(|s| if let Some(Mark::Hopf(hopf)) = &s.mark { Some(hopf.clone()) } else { None })
        .collect();
    assert_eq!(found.len(), 1);
    close("L", found[0].0.p[0], Brusselator::onset(points), 1e-10);
    close("omega", found[0].0.omega, 2.13950928953347, 1e-9);
}

/// The Hopf point and its normal form by band and sparse factors are those by dense ones.
#[test]
fn normal_forms_do_not_depend_on_the_structure() {
    let forms = [true, false].map(|banded| {
        let problem = Brusselator::chain(40, banded);
        let hopf = Brusselator::hopf(&problem);
        (HopfNormalForm::new(&*problem, &hopf).unwrap(), hopf)
    });
    let [(a, hopf_a), (b, hopf_b)] = forms;
    close("L", hopf_a.p[0], hopf_b.p[0], 1e-13);
    close("omega", hopf_a.omega, hopf_b.omega, 1e-12);
    close("l1", a.l1, b.l1, 1e-9);
    close("p2", a.p2, b.p2, 1e-9);
}

/// Rotations at different speeds: of an odd number of eigenvalues asked for, the last is half a pair, which comes whole.
#[test]
fn pairs_are_whole_around_a_real_point() {
    let n = 40;
    let mut a = faer::Mat::<f64>::zeros(n, n);
    for k in 0..n / 2 {
        let (i, speed) = (2 * k, 1.0 + k as f64);
        (a[(i, i)], a[(i + 1, i + 1)]) = (0.1, 0.1);
        (a[(i, i + 1)], a[(i + 1, i)]) = (speed, -speed);
    }
    let identity = Matrix::Dense(faer::Mat::<f64>::identity(n, n));
    let found = nearest(&Matrix::Dense(a), &identity, c64::new(1.0, 0.0), 3).unwrap();
    let (upper, lower): (Vec<f64>, Vec<f64>) = found.iter().map(|pair| pair.value.im).partition(|im| *im > 0.0);
    assert_eq!(upper.len(), lower.len(), "{upper:?} {lower:?}");
}
