//! One interval's polynomials: values at Chebyshev-Lobatto nodes, equations at Gauss or Radau points.
//!
//! With nodes `x_l = (1 - cos(pi l / m)) / 2` and Lagrange polynomials `L_l` of degree m on [0, 1], collocation at the
//! m Gauss points makes mesh-point values exact to order 2m (de Boor and Swartz 1973, doi:10.1137/0710052). But it
//! maps a fast decaying mode to its (-1)^m-fold in every interval, so that stiff modes get Floquet multipliers near
//! the unit circle instead of zero (0.98 has been seen for a mode that dies out at once). The right Radau points
//! damp such modes as they should, at order 2m - 1 (Hairer and Wanner 1996, doi:10.1007/978-3-642-05221-7, IV.5).

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Where the equations are collocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Points {
    Gauss,
    Radau,
}

#[derive(Clone, Debug)]
pub struct Scheme {
    pub degree: usize,
    /// m + 1 nodes, the first 0 and the last 1.
    pub nodes: Vec<f64>,
    /// m collocation points and weights.
    pub points: Vec<f64>,
    pub weights: Vec<f64>,
    /// `value[i][l] = L_l(c_i)`, `slope[i][l] = L_l'(c_i)`.
    pub value: Vec<Vec<f64>>,
    pub slope: Vec<Vec<f64>>,
    barycentric: Vec<f64>,
}

impl Scheme {
    pub fn new(points: Points, degree: usize) -> Self {
        let nodes: Vec<f64> = (0..=degree).map(|l| 0.5 * (1.0 - (PI * l as f64 / degree as f64).cos())).collect();
        let barycentric = (0..=degree)
            .map(|l| (0..=degree).filter(|&k| k != l).map(|k| 1.0 / (nodes[l] - nodes[k])).product())
            .collect();
        let (points, weights) = points_and_weights(points, degree);
        let mut scheme = Self { degree, nodes, points, weights, value: vec![], slope: vec![], barycentric };
        scheme.value = scheme.points.iter().map(|&c| scheme.values_at(c)).collect();
        scheme.slope = scheme.points.iter().map(|&c| scheme.slopes_at(c)).collect();
        scheme
    }

    /// `L_l(x)` for all l.
    pub fn values_at(&self, x: f64) -> Vec<f64> {
        if let Some(hit) = self.nodes.iter().position(|&node| node == x) {
            return (0..=self.degree).map(|l| f64::from(u8::from(l == hit))).collect();
        }
        let whole: f64 = self.nodes.iter().map(|node| x - node).product();
        self.nodes.iter().zip(&self.barycentric).map(|(node, b)| whole * b / (x - node)).collect()
    }

    /// `L_l'(x)` for all l: the sum over k of the products that leave out k and l.
    pub fn slopes_at(&self, x: f64) -> Vec<f64> {
        let m = self.degree;
        (0..=m)
            .map(|l| {
                let sum: f64 = (0..=m)
                    .filter(|&k| k != l)
                    .map(|k| (0..=m).filter(|&j| j != k && j != l).map(|j| x - self.nodes[j]).product::<f64>())
                    .sum();
                sum * self.barycentric[l]
            })
            .collect()
    }

    /// The m-th derivative of `sum_l y_l L_l`, constant on the interval: the coefficients of y.
    pub fn highest_derivative(&self) -> Vec<f64> {
        let factorial: f64 = (1..=self.degree).map(|k| k as f64).product();
        self.barycentric.iter().map(|b| factorial * b).collect()
    }
}

impl Scheme {
    /// c in the local error `c h^{m+1} |u^{(m+1)}|`: the largest `|int_0^x (s - c_1) ... (s - c_m) ds| / m!`.
    pub fn error_constant(&self) -> f64 {
        // Coefficients of the integrand; its antiderivative is largest at a collocation point or at an end.
        let mut polynomial = vec![1.0];
        for c in &self.points {
            let mut next = vec![0.0; polynomial.len() + 1];
            for (k, a) in polynomial.iter().enumerate() {
                next[k] -= c * a;
                next[k + 1] += a;
            }
            polynomial = next;
        }
        let antiderivative =
            |x: f64| polynomial.iter().enumerate().rev().fold(0.0, |sum, (k, a)| (sum + a / (k + 1) as f64) * x);
        let factorial: f64 = (1..=self.degree).map(|k| k as f64).product();
        self.points.iter().chain(&[1.0]).map(|&x| f64::abs(antiderivative(x))).fold(0.0, f64::max) / factorial
    }
}

/// Points on [0, 1]: zeros of the Legendre polynomial P_m, or of P_m - P_{m-1} (the right end included), by Newton's
/// method with deflation of the zeros already found; weights by integrating the Lagrange polynomials exactly.
fn points_and_weights(points: Points, m: usize) -> (Vec<f64>, Vec<f64>) {
    let legendre = |z: f64| {
        let (mut p, mut below) = ((z, 1.0), (1.0, 0.0));
        for k in 1..m {
            let (a, b) = ((2 * k + 1) as f64 / (k + 1) as f64, k as f64 / (k + 1) as f64);
            (p, below) = ((a * z * p.0 - b * below.0, a * (p.0 + z * p.1) - b * below.1), p);
        }
        match points {
            Points::Gauss => p,
            Points::Radau => (p.0 - below.0, p.1 - below.1),
        }
    };
    let mut zeros: Vec<f64> = Vec::new();
    for i in 0..m {
        let mut z = ((i as f64 + 0.5) / m as f64 * PI).cos();
        for _ in 0..100 {
            let (value, slope) = legendre(z);
            let deflation: f64 = zeros.iter().map(|other| 1.0 / (z - other)).sum();
            let step = value / (slope - value * deflation);
            z -= step;
            if step.abs() < 4.0 * f64::EPSILON {
                break;
            }
        }
        zeros.push(z);
    }
    zeros.sort_by(f64::total_cmp);
    // Half of int_{-1}^1 of a polynomial of degree m - 1 by its coefficients: exact. About the middle they are small; on
    // [0, 1] two digits are lost at m = 7.
    let weights = (0..m)
        .map(|l| {
            let mut polynomial = vec![1.0];
            for k in (0..m).filter(|&k| k != l) {
                let scale = 1.0 / (zeros[l] - zeros[k]);
                let mut next = vec![0.0; polynomial.len() + 1];
                for (i, c) in polynomial.iter().enumerate() {
                    next[i] -= c * zeros[k] * scale;
                    next[i + 1] += c * scale;
                }
                polynomial = next;
            }
            polynomial.iter().enumerate().step_by(2).map(|(i, c)| c / (i + 1) as f64).sum()
        })
        .collect();
    (zeros.iter().map(|z| 0.5 * (z + 1.0)).collect(), weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reproduces_polynomials_and_integrates_twice_the_degree() {
        for (points, m) in [Points::Gauss, Points::Radau].into_iter().flat_map(|p| (2..=7).map(move |m| (p, m))) {
            let s = Scheme::new(points, m);
            for k in 0..=m as i32 {
                let y: Vec<f64> = s.nodes.iter().map(|x| x.powi(k)).collect();
                for i in 0..m {
                    let c = s.points[i];
                    let value: f64 = s.value[i].iter().zip(&y).map(|(a, y)| a * y).sum();
                    let slope: f64 = s.slope[i].iter().zip(&y).map(|(a, y)| a * y).sum();
                    assert!((value - c.powi(k)).abs() < 1e-14);
                    assert!((slope - if k == 0 { 0.0 } else { f64::from(k) * c.powi(k - 1) }).abs() < 1e-12);
                }
            }
            let order = if points == Points::Gauss { 2 * m } else { 2 * m - 1 };
            for k in 0..order as i32 {
                let sum: f64 = s.points.iter().zip(&s.weights).map(|(x, w)| w * x.powi(k)).sum();
                assert!((sum - 1.0 / f64::from(k + 1)).abs() < 1e-14);
            }
        }
    }
}
