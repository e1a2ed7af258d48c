//! Angles on a clamped filament: integrated Legendre polynomials on x = s/L in [0, 1], and the integrals that turn
//! angles into positions.
//!
//! ```text
//! q_k(x) = sqrt(2k + 1) int_0^x P_k(2x' - 1) dx' = (P_{k+1} - P_{k-1}) / (2 sqrt(2k + 1)),   q_0 = x,
//! ```
//!
//! so that q_k(0) = 0 (the clamp), the derivatives are orthonormal (the bending energy is |c|²/2), and q_k(1) = 0
//! for k > 0. Integrals over x use Gauss points; `integral` is the exact antiderivative of the interpolant there.

use faer::Mat;

/// `functions` angles on `points` Gauss points of [0, 1].
pub struct Basis {
    pub functions: usize,
    pub points: usize,
    /// Gauss points and weights on [0, 1].
    pub x: Vec<f64>,
    pub w: Vec<f64>,
    /// `value[(i, k)] = q_k(x_i)`.
    pub value: Mat<f64>,
    /// `integral[(i, j)]`: from values at x_j to the integral from 0 to x_i.
    pub integral: Mat<f64>,
    /// `integral * value`.
    pub integrated_value: Mat<f64>,
    /// `value^T diag(w) value`.
    pub gram: Mat<f64>,
    pub value_transposed: Mat<f64>,
    pub integral_transposed: Mat<f64>,
}

impl Basis {
    /// Products of two angles are integrated exactly by functions + 1 points; a quarter more and a margin are for the
    /// trigonometric factors. What that leaves is below what the truncation of the basis leaves.
    pub fn new(functions: usize) -> Self {
        let points = functions + functions / 4 + 6;
        let (x, w) = gauss(points);
        let value = Mat::from_fn(points, functions, |i, k| angle(k, x[i]));
        let legendre: Vec<Vec<f64>> = x.iter().map(|&x| legendre(points + 1, x)).collect();
        let integral = Mat::from_fn(points, points, |i, j| {
            let (at, from) = (&legendre[i], &legendre[j]);
            let sum: f64 = (1..points).map(|k| (at[k + 1] - at[k - 1]) * from[k]).sum();
            w[j] * (x[i] + 0.5 * sum)
        });
        let integrated_value = &integral * &value;
        let value_transposed = value.transpose().to_owned();
        let gram = &value_transposed * Mat::from_fn(points, functions, |i, k| w[i] * value[(i, k)]);
        let integral_transposed = integral.transpose().to_owned();
        Self { functions, points, x, w, value, integral, integrated_value, gram, value_transposed, integral_transposed }
    }
}

/// `q_k(x)`.
pub fn angle(k: usize, x: f64) -> f64 {
    if k == 0 {
        return x;
    }
    let p = legendre(k + 1, x);
    (p[k + 1] - p[k - 1]) / (2.0 * ((2 * k + 1) as f64).sqrt())
}

/// All `q_0(x) ... q_{functions - 1}(x)`.
pub fn angles(functions: usize, x: f64) -> Vec<f64> {
    let p = legendre(functions, x);
    (0..functions)
        .map(|k| if k == 0 { x } else { (p[k + 1] - p[k - 1]) / (2.0 * ((2 * k + 1) as f64).sqrt()) })
        .collect()
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
