//! Angles on a rod: integrated Legendre polynomials on x = s/L in [0, 1], and the integrals that turn angles into
//! positions.
//!
//! ```text
//! q_k(x) = sqrt(2k + 1) int_0^x P_k(2x' - 1) dx' = (P_{k+1} - P_{k-1}) / (2 sqrt(2k + 1)),   q_0 = x,
//! ```
//!
//! so that q_k(0) = 0 (the clamp), the derivatives are orthonormal (the bending energy is |c|²/2), and q_k(1) = 0
//! for k > 0. A rod that may turn at its base has the constant 1 before them. Integrals over x use Gauss points; `integral` is the exact antiderivative of the interpolant there.

use super::halves::Halves;
use crate::problem::Scalar;
use faer::Mat;

/// `functions` angles on `points` Gauss points of [0, 1].
pub struct Basis {
    pub functions: usize,
    pub points: usize,
    /// Whether the first function is 1.
    turns: bool,
    /// `int q_k'^2`, 0 for the constant and else 1: other products vanish.
    pub stiffness: Vec<f64>,
    /// `q_k(1)`.
    pub tip: Vec<f64>,
    /// Gauss points and weights on [0, 1].
    pub x: Vec<f64>,
    pub w: Vec<f64>,
    /// `value[(i, k)] = q_k(x_i)`.
    pub value: Mat<f64>,
    /// `integral[(i, j)]`: from values at x_j to the integral from 0 to x_i.
    pub integral: Mat<f64>,
    /// The same for many functions at once.
    pub halves: Halves,
    /// `integral * value`.
    pub integrated_value: Mat<f64>,
    /// `value^T diag(w) value`.
    pub gram: Mat<f64>,
    pub value_transposed: Mat<f64>,
}

impl Basis {
    /// Products of two angles are integrated exactly by functions + 1 points; a quarter more and a margin are for the
    /// trigonometric factors. What that leaves is below what the truncation of the basis leaves.
    pub fn new(functions: usize) -> Self {
        Self::make(functions, false)
    }

    /// Of `functions` the first is constant.
    pub fn turning(functions: usize) -> Self {
        Self::make(functions, true)
    }

    fn make(functions: usize, turns: bool) -> Self {
        let points = functions + functions / 4 + 6;
        let (x, w) = gauss(points);
        let values: Vec<Vec<f64>> = x.iter().map(|&x| angles(functions, turns, x)).collect();
        let value = Mat::from_fn(points, functions, |i, k| values[i][k]);
        let integral = antiderivative(&x, &w);
        let integrated_value = &integral * &value;
        let value_transposed = value.transpose().to_owned();
        let gram = &value_transposed * Mat::from_fn(points, functions, |i, k| w[i] * value[(i, k)]);
        let halves = Halves::new(&integral, &w);
        let stiffness = (0..functions).map(|k| f64::from(u8::from(k > 0 || !turns))).collect();
        let tip = angles(functions, turns, 1.0);
        Self {
            functions,
            points,
            turns,
            stiffness,
            tip,
            x,
            w,
            value,
            integral,
            halves,
            integrated_value,
            gram,
            value_transposed,
        }
    }

    /// psi(x) from its coefficients.
    pub fn psi(&self, c: &[f64], x: f64) -> f64 {
        angles(self.functions, self.turns, x).iter().zip(c).map(|(q, c)| q * c).sum()
    }

    /// `int_x^1 g dx'` at the Gauss points, times the weights, along x and y. By parts, exact on Gauss points, w_i A_ij + w_j
    /// A_ji is w_i w_j for A = `integral`: this is A^T W g, the discrete adjoint, and the Galerkin form stays symmetric.
    pub fn beyond<S: Scalar>(&self, g: [&[S]; 2]) -> [Vec<S>; 2] {
        let mut beyond = times_both(&self.integral, g);
        for (beyond, g) in beyond.iter_mut().zip(g) {
            let total = self.total(g.iter().copied());
            beyond.iter_mut().zip(&self.w).for_each(|(b, &w)| *b = (total - *b) * w);
        }
        beyond
    }

    /// `int_0^1 g dx`.
    pub fn total<S: Scalar>(&self, g: impl Iterator<Item = S>) -> S {
        g.zip(&self.w).fold(S::from(0.0), |sum, (g, &w)| sum + g * w)
    }

    /// The largest |psi| on [0, 1], from a grid finer than the highest mode.
    pub fn largest(&self, c: &[f64]) -> f64 {
        peak(|x| self.psi(c, x).abs(), 6 * c.len())
    }
}

/// The largest of a function's values on [0, 1], not negative: best of a grid of `cells`, then Newton-like refinement by
/// the parabola through three points, whose error is far below that of the coefficients.
pub fn peak(value: impl Fn(f64) -> f64, cells: usize) -> f64 {
    let best = (0..=cells)
        .map(|i| i as f64 / cells as f64)
        .map(|x| (value(x), x))
        .fold((0.0, 0.0), |a, b| if b.0 > a.0 { b } else { a });
    let (mut top, mut x, mut h) = (best.0, best.1, 0.5 / cells as f64);
    for _ in 0..4 {
        if x - h < 0.0 || x + h > 1.0 {
            break;
        }
        let (left, right) = (value(x - h), value(x + h));
        let bend = left - 2.0 * top + right;
        if bend >= 0.0 {
            break;
        }
        let next = (x + (0.5 * h * (left - right) / bend).clamp(-h, h)).clamp(0.0, 1.0);
        let at_next = value(next);
        if at_next > top {
            (top, x) = (at_next, next);
        }
        h *= 0.1;
    }
    top
}

/// From values at Gauss points x with weights w to the integral of their interpolant from 0 to each.
pub fn antiderivative(x: &[f64], w: &[f64]) -> Mat<f64> {
    let points = x.len();
    let legendre: Vec<Vec<f64>> = x.iter().map(|&x| legendre(points + 1, x)).collect();
    Mat::from_fn(points, points, |i, j| {
        let (at, from) = (&legendre[i], &legendre[j]);
        let sum: f64 = (1..points).map(|k| (at[k + 1] - at[k - 1]) * from[k]).sum();
        w[j] * (x[i] + 0.5 * sum)
    })
}

/// All functions at x: `q_0(x), q_1(x), ...`, with 1 before them if the rod turns.
fn angles(functions: usize, turns: bool, x: f64) -> Vec<f64> {
    let bent = functions - usize::from(turns);
    let p = legendre(bent, x);
    let bent = (0..bent).map(|k| if k == 0 { x } else { (p[k + 1] - p[k - 1]) / (2.0 * ((2 * k + 1) as f64).sqrt()) });
    turns.then_some(1.0).into_iter().chain(bent).collect()
}

/// Legendre polynomials `P_0 ... P_degree` of 2x - 1.
pub fn legendre(degree: usize, x: f64) -> Vec<f64> {
    let z = 2.0 * x - 1.0;
    let mut p = vec![1.0, z];
    for k in 1..degree.max(1) {
        p.push(((2 * k + 1) as f64 * z * p[k] - k as f64 * p[k - 1]) / (k + 1) as f64);
    }
    p
}

/// Gauss-Legendre points and weights on [0, 1], by Newton's method from Chebyshev-like starts.
pub fn gauss(n: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut x, mut w) = (vec![0.0; n], vec![0.0; n]);
    for i in 0..n {
        let mut z = -((i as f64 + 0.75) / (n as f64 + 0.5) * std::f64::consts::PI).cos();
        let mut slope = 1.0;
        for _ in 0..10 {
            let p = legendre(n, 0.5 * (z + 1.0));
            let below = if n == 0 { 0.0 } else { p[n - 1] };
            slope = n as f64 * (z * p[n] - below) / (z * z - 1.0);
            let step = p[n] / slope;
            z -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        x[i] = 0.5 * (z + 1.0);
        w[i] = 1.0 / ((1.0 - z * z) * slope * slope);
    }
    (x, w)
}

/// Matrix times vector over any scalar, compiled for each kind of vector unit and chosen when the program runs.
pub fn times<S: Scalar>(a: &Mat<f64>, x: &[S]) -> Vec<S> {
    let [y] = pulp::Arch::new().dispatch(Times { a, x: [x] });
    y
}

/// The same for two vectors of one length, for which the matrix passes through memory once.
pub fn times_both<S: Scalar>(a: &Mat<f64>, x: [&[S]; 2]) -> [Vec<S>; 2] {
    pulp::Arch::new().dispatch(Times { a, x })
}

struct Times<'a, S, const N: usize> {
    a: &'a Mat<f64>,
    x: [&'a [S]; N],
}

impl<S: Scalar> pulp::NullaryFnOnce for Times<'_, S, 1> {
    type Output = [Vec<S>; 1];

    #[inline(always)]
    fn call(self) -> [Vec<S>; 1] {
        multiplied(self, |[y], x, a| {
            let [x] = x;
            y.iter_mut().zip(a[0]).zip(a[1]).zip(a[2]).zip(a[3]).for_each(|((((y, &a), &b), &c), &d)| {
                *y += (x[0] * a + x[1] * b) + (x[2] * c + x[3] * d);
            });
        })
    }
}

impl<S: Scalar> pulp::NullaryFnOnce for Times<'_, S, 2> {
    type Output = [Vec<S>; 2];

    #[inline(always)]
    fn call(self) -> [Vec<S>; 2] {
        multiplied(self, |[y, z], [x, w], a| {
            let columns = a[0].iter().zip(a[1]).zip(a[2]).zip(a[3]);
            y.iter_mut().zip(z).zip(columns).for_each(|((y, z), (((&a, &b), &c), &d))| {
                *y += (x[0] * a + x[1] * b) + (x[2] * c + x[3] * d);
                *z += (w[0] * a + w[1] * b) + (w[2] * c + w[3] * d);
            });
        })
    }
}

/// Four columns at a time, so that the sums pass through memory less often. Slices as arguments of `add` are known not to
/// overlap, which spares a test before every vector loop.
#[inline(always)]
fn multiplied<S: Scalar, const N: usize>(
    Times { a, x }: Times<'_, S, N>,
    add: impl Fn([&mut [S]; N], [[S; 4]; N], [&[f64]; 4]),
) -> [Vec<S>; N] {
    let mut y = [(); N].map(|()| vec![S::from(0.0); a.nrows()]);
    let (columns, done) = (a.ncols(), a.ncols() - a.ncols() % 4);
    for j in (0..done).step_by(4) {
        add(
            y.each_mut().map(|y| &mut y[..]),
            x.map(|x| [x[j], x[j + 1], x[j + 2], x[j + 3]]),
            [j, j + 1, j + 2, j + 3].map(|j| a.col_as_slice(j)),
        );
    }
    for j in done..columns {
        y.iter_mut().zip(x).for_each(|(y, x)| y.iter_mut().zip(a.col_as_slice(j)).for_each(|(y, &a)| *y += x[j] * a));
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_integral_is_exact_for_polynomials() {
        let basis = Basis::new(8);
        for degree in 0..basis.points {
            for i in 0..basis.points {
                let value: f64 =
                    (0..basis.points).map(|j| basis.integral[(i, j)] * basis.x[j].powi(degree as i32)).sum();
                let exact = basis.x[i].powi(degree as i32 + 1) / (degree + 1) as f64;
                assert!((value - exact).abs() < 1e-14, "degree {degree}: {value} {exact}");
            }
        }
    }

    #[test]
    fn integration_by_parts_is_exact() {
        let basis = Basis::new(8);
        for i in 0..basis.points {
            for j in 0..basis.points {
                let (a, w) = (&basis.integral, &basis.w);
                assert!((w[i] * a[(i, j)] + w[j] * a[(j, i)] - w[i] * w[j]).abs() < 1e-16);
            }
        }
    }

    #[test]
    fn derivatives_are_orthonormal() {
        // int q_j' q_k' = [q_j q_k'] - int q_j q_k'' needs no derivative code if tested through differences of q at
        // Gauss points; here: the Gram matrix of the antiderivative's integrand, P_j P_k sqrt((2j+1)(2k+1)).
        let (x, w) = gauss(20);
        for j in 0..10_usize {
            for k in 0..10_usize {
                let gram: f64 = (0..20)
                    .map(|i| {
                        let p = legendre(10, x[i]);
                        w[i] * p[j] * p[k] * (((2 * j + 1) * (2 * k + 1)) as f64).sqrt()
                    })
                    .sum();
                assert!((gram - f64::from(u8::from(j == k))).abs() < 1e-14);
            }
        }
    }
}
