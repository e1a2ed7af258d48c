//! The two-doublet model's equations at any shape: derivatives, symmetry, and the strong form they come from.

mod common;

use common::{Flagellum, matrices};
use hopfline::linalg::Lu;
use hopfline::models::{Law, Load};
use hopfline::problem::{At, check_derivatives};
use proptest::prelude::*;
use std::f64::consts::PI;

/// Coefficients of a smooth shape: random, decaying as 0.5^k, of a size that bends the doublets by about a radian.
fn shape(seeds: &[f64], functions: usize) -> Vec<f64> {
    (0..2 * functions).map(|i| seeds[i % seeds.len()] * 0.5_f64.powi((i % functions) as i32)).collect()
}

fn seeds() -> impl Strategy<Value = Vec<f64>> {
    // A prime number of seeds, so that the doublets differ.
    prop::collection::vec(-1.0..1.0_f64, 11)
}

fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases) }
}

const VARIANTS: [(Load, Law); 4] = [
    (Load::Uniform, Law::Printed),
    (Load::Uniform, Law::Separation),
    (Load::Distal, Law::Printed),
    (Load::Distal, Law::Separation),
];

proptest! {
    #![proptest_config(cases(6))]

    #[test]
    fn handwritten_derivatives_are_the_derivatives(u in seeds(), v in seeds(), variant in 0..4_usize, zero in 0..4_usize) {
        let (load, law) = VARIANTS[variant];
        let mut model = Flagellum::new(9, load, law);
        // Terms with these coefficients are not assembled.
        let optional: [&[&str]; 4] = [&[], &["b_N"], &["k_T", "b_T", "k_3T"], &["k_3N", "b_N", "b_T"]];
        for name in optional[zero] {
            model = model.with(name, 0.0);
        }
        let (u, v) = (shape(&u, 9), shape(&v, 9).iter().map(|v| 100.0 * v).collect::<Vec<_>>());
        for v in [&v, &model.straight()] {
            let worst = check_derivatives(&*model.problem, At { u: &u, v, p: &model.p });
            // Sums of some twenty products in two orders, relative to the largest entry.
            prop_assert!(worst < 1e-12, "{load:?} {law:?} without {:?}: {worst:.1e}", optional[zero]);
        }
    }

    #[test]
    fn the_residual_is_odd(u in seeds(), v in seeds(), variant in 0..4_usize) {
        let (load, law) = VARIANTS[variant];
        let model = Flagellum::new(9, load, law);
        let n = model.problem.dim();
        let reflection = model.problem.reflection().expect("a reflection");
        let (u, v) = (shape(&u, 9), shape(&v, 9));
        let residual = |u: &[f64], v: &[f64]| {
            let mut g = vec![0.0; n];
            model.problem.residual(At { u, v, p: &model.p }, &mut g);
            g
        };
        let image = |x: &[f64]| {
            let mut out = vec![0.0; n];
            reflection.apply(x, &mut out);
            out
        };
        let (there, here) = (residual(&image(&u), &image(&v)), image(&residual(&u, &v)));
        let size = here.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        prop_assert!(there.iter().zip(&here).all(|(a, b)| (a - b).abs() <= 1e-14 * size));
    }
}

/// Functions on [0, L] by their values at Chebyshev points: no code of the model is used from here on.
struct Line {
    s: Vec<f64>,
    length: f64,
    /// `integral[i][j]`: from values at s_j to the integral from 0 to s_i, of the interpolant by Chebyshev polynomials.
    integral: Vec<Vec<f64>>,
}

impl Line {
    fn new(points: usize, length: f64) -> Self {
        let n = points - 1;
        let theta = |i: usize| PI * (n - i) as f64 / n as f64;
        let half = |j: usize| if j == 0 || j == n { 0.5 } else { 1.0 };
        // int T_k = T_{k+1}/(2(k+1)) - T_{k-1}/(2(k-1)), and z²/2 for k = 1, from z = -1.
        let primitive = |k: usize, theta: f64| -> f64 {
            let t = |k: usize| (k as f64 * theta).cos();
            match k {
                0 => t(1),
                1 => 0.25 * t(2),
                _ => 0.5 * (t(k + 1) / (k + 1) as f64 - t(k - 1) / (k - 1) as f64),
            }
        };
        let integral = (0..=n)
            .map(|i| {
                let gain: Vec<f64> = (0..=n).map(|k| half(k) * (primitive(k, theta(i)) - primitive(k, PI))).collect();
                (0..=n)
                    .map(|j| {
                        let sum: f64 = (0..=n).map(|k| gain[k] * (k as f64 * theta(j)).cos()).sum();
                        length * half(j) / n as f64 * sum
                    })
                    .collect()
            })
            .collect();
        Self { s: (0..=n).map(|i| 0.5 * length * (1.0 + theta(i).cos())).collect(), length, integral }
    }

    /// The integral from 0 to every point.
    fn up(&self, f: &[f64]) -> Vec<f64> {
        self.integral.iter().map(|row| row.iter().zip(f).map(|(a, b)| a * b).sum()).collect()
    }

    /// The integral over all.
    fn over(&self, f: &[f64]) -> f64 {
        self.up(f)[f.len() - 1]
    }

    fn map(&self, f: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.s.len()).map(f).collect()
    }

    /// An integrated Legendre polynomial and its derivative in s, from Bonnet's recursion for P_k and
    /// q_k = sqrt(2k + 1) int P_k.
    fn angle(&self, k: usize) -> (Vec<f64>, Vec<f64>) {
        let slope = self.map(|i| {
            let z = 2.0 * self.s[i] / self.length - 1.0;
            let (mut p, mut below) = (1.0, 0.0);
            for j in 0..k {
                (p, below) = (((2 * j + 1) as f64 * z * p - j as f64 * below) / (j + 1) as f64, p);
            }
            ((2 * k + 1) as f64).sqrt() * p / self.length
        });
        (self.up(&slope), slope)
    }
}

/// One doublet at every point: angle, its rate and slope, velocity along t and n.
struct Doublet {
    psi: Vec<f64>,
    rate: Vec<f64>,
    slope: Vec<f64>,
    v_t: Vec<f64>,
    v_n: Vec<f64>,
}

/// A motion in physical units, written down from the strong form (2.1)-(2.3) with the corrections of the model.
struct Motion {
    line: Line,
    doublets: [Doublet; 2],
    /// eps f_T is tangent, eps f_N normal to each doublet; m is the shear moment.
    f_t: Vec<f64>,
    f_n: Vec<f64>,
    m: Vec<f64>,
    h: Vec<f64>,
    h_rate: Vec<f64>,
}

const EPS: [f64; 2] = [1.0, -1.0];

impl Motion {
    fn new(model: &Flagellum, (load, law): (Load, Law), u: &[f64], v: &[f64]) -> Self {
        let functions = u.len() / 2;
        let get = |name: &str| model.get(name);
        let line = Line::new(90, get("L"));
        let angles: Vec<(Vec<f64>, Vec<f64>)> = (0..functions).map(|k| line.angle(k)).collect();
        let sum = |c: &[f64], slope: bool| {
            line.map(|i| c.iter().zip(&angles).map(|(c, (q, d))| c * if slope { d[i] } else { q[i] }).sum())
        };
        let doublet = |n: usize| {
            let (u, v) = (&u[n * functions..][..functions], &v[n * functions..][..functions]);
            let (psi, rate, slope) = (sum(u, false), sum(v, false), sum(u, true));
            let (v_x, v_y) =
                (line.up(&line.map(|i| -rate[i] * psi[i].sin())), line.up(&line.map(|i| rate[i] * psi[i].cos())));
            let v_t = line.map(|i| v_x[i] * psi[i].cos() + v_y[i] * psi[i].sin());
            let v_n = line.map(|i| v_y[i] * psi[i].cos() - v_x[i] * psi[i].sin());
            Doublet { psi, rate, slope, v_t, v_n }
        };
        let doublets = [doublet(0), doublet(1)];
        let delta = line.map(|i| doublets[0].psi[i] - doublets[1].psi[i]);
        let delta_rate = line.map(|i| doublets[0].rate[i] - doublets[1].rate[i]);
        let (h, h_rate) = (line.up(&delta), line.up(&delta_rate));
        let cubic = match law {
            Law::Printed => line.up(&line.map(|i| delta[i].powi(3))),
            Law::Separation => line.map(|i| h[i].powi(3)),
        };
        let f_n = line.map(|i| -get("k_N") * h[i] - get("b_N") * h_rate[i] - get("k_3N") * cubic[i]);
        let a2 = get("a").powi(2);
        let m = line.map(|i| {
            let mean = 0.5 * (doublets[0].psi[i] + doublets[1].psi[i]);
            let rate = 0.5 * (doublets[0].rate[i] + doublets[1].rate[i]);
            -a2 * (get("k_T") * mean + get("b_T") * rate) - a2 * a2 * get("k_3T") * mean.powi(3)
        });
        let f_t = line.map(|i| {
            let share = if load == Load::Distal { 1.0 - (-line.s[i] / get("s0")).exp() } else { 1.0 };
            get("p") * share
        });
        Self { line, doublets, f_t, f_n, m, h, h_rate }
    }

    /// Drag less load on doublet n per length, along t and n.
    fn bracket(&self, model: &Flagellum, n: usize) -> (Vec<f64>, Vec<f64>) {
        let (c_t, c_n) = (model.get("c_T"), model.get("c_N"));
        let d = &self.doublets[n];
        (
            self.line.map(|i| c_t * d.v_t[i] - EPS[n] * self.f_t[i]),
            self.line.map(|i| c_n * d.v_n[i] - EPS[n] * self.f_n[i]),
        )
    }
}

/// u, v for a test at random: rates that move the tip by micrometres in a millisecond.
fn motion(seeds: (&[f64], &[f64])) -> (Vec<f64>, Vec<f64>) {
    const FEW: usize = 12;
    (shape(seeds.0, FEW), shape(seeds.1, FEW).iter().map(|v| 300.0 * v).collect())
}

proptest! {
    #![proptest_config(cases(8))]

    #[test]
    fn the_residual_is_the_virtual_work_of_the_strong_form(u in seeds(), v in seeds(), variant in 0..4_usize) {
        let (load, law) = VARIANTS[variant];
        let (u, v) = motion((&u, &v));
        let model = Flagellum::new(u.len() / 2, load, law);
        let mut g = vec![0.0; u.len()];
        model.problem.residual(At { u: &u, v: &v, p: &model.p }, &mut g);
        let motion = Motion::new(&model, (load, law), &u, &v);
        let line = &motion.line;
        let unit = model.get("EI") / model.get("L");
        let size = g.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        for n in 0..2 {
            let d = &motion.doublets[n];
            let (along_t, along_n) = motion.bracket(&model, n);
            for k in 0..u.len() / 2 {
                let (q, slope) = line.angle(k);
                let w_x = line.up(&line.map(|i| -q[i] * d.psi[i].sin()));
                let w_y = line.up(&line.map(|i| q[i] * d.psi[i].cos()));
                let work = line.over(&line.map(|i| {
                    let (s, c) = d.psi[i].sin_cos();
                    let (w_t, w_n) = (w_x[i] * c + w_y[i] * s, w_y[i] * c - w_x[i] * s);
                    w_t * along_t[i] + w_n * along_n[i] + model.get("EI") * d.slope[i] * slope[i] - motion.m[i] * q[i]
                }));
                // The model integrates with 24 Gauss points; the shapes' coefficients fall to 1e-4 of the first.
                let error = (work / unit - g[n * u.len() / 2 + k]).abs() / size;
                prop_assert!(error < 1e-8, "{load:?} {law:?}, doublet {n}, angle {k}: {error:.1e}");
            }
        }
    }

    /// Along `v = M^-1 F`: the rate of the elastic energy is the load's power less what drag and the viscous couplings
    /// dissipate, plus what the normal force does because it acts along the normals while h is an integral of angles:
    /// int f_N ((v_1.n_1 - v_2.n_2) - h_t) ds, of fourth order in the angles.
    #[test]
    fn energy_is_balanced(u in seeds(), variant in 0..2_usize) {
        let (load, law) = [(Load::Uniform, Law::Separation), (Load::Distal, Law::Separation)][variant];
        let (u, rest) = (motion((&u, &u)).0, vec![0.0; 24]);
        let model = Flagellum::new(12, load, law);
        let mut v = vec![0.0; 24];
        model.problem.residual(At { u: &u, v: &rest, p: &model.p }, &mut v);
        let (_, mass) = matrices(&*model.problem, At { u: &u, v: &rest, p: &model.p });
        Lu::new(mass).expect("an invertible mass").solve(&mut v);
        v.iter_mut().for_each(|v| *v = -*v);
        // The energy is a polynomial of degree four in u: five-point differences are exact up to rounding.
        let energy = |step: f64| -> f64 {
            let moved: Vec<f64> = u.iter().zip(&v).map(|(u, v)| u + step * v).collect();
            model.observe("energy", &moved, &rest)
        };
        let step = 0.1 / v.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let rate = (8.0 * (energy(step) - energy(-step)) - energy(2.0 * step) + energy(-2.0 * step)) / (12.0 * step);
        let motion = Motion::new(&model, (load, law), &u, &v);
        let line = &motion.line;
        let [one, two] = &motion.doublets;
        let power = line.over(&line.map(|i| motion.f_t[i] * (one.v_t[i] - two.v_t[i])));
        let drag = line.over(&line.map(|i| {
            [one, two].iter().map(|d| model.get("c_T") * d.v_t[i].powi(2) + model.get("c_N") * d.v_n[i].powi(2)).sum()
        }));
        let viscous = line.over(&line.map(|i| {
            let shear = 0.5 * (one.rate[i] + two.rate[i]);
            model.get("b_N") * motion.h_rate[i].powi(2) + 2.0 * model.get("a").powi(2) * model.get("b_T") * shear.powi(2)
        }));
        let turned = line.over(&line.map(|i| motion.f_n[i] * (one.v_n[i] - two.v_n[i] - motion.h_rate[i])));
        let terms = [power, drag, viscous, turned];
        let size = terms.iter().fold(rate.abs(), |a, b| a.max(b.abs()));
        let error = (rate - (power - drag - viscous + turned)).abs() / size;
        // As above: the model's quadrature.
        prop_assert!(error < 1e-8, "{error:.1e} of {size:.1e}: rate {rate:.6e}, {terms:?}");
        // The energy itself, by hand.
        let (k_n, k_3n) = (model.get("k_N"), model.get("k_3N"));
        let (k_t, k_3t) = (model.get("k_T") * model.get("a").powi(2), model.get("k_3T") * model.get("a").powi(4));
        let stored = line.over(&line.map(|i| {
            let (h2, m2) = (motion.h[i].powi(2), (0.5 * (one.psi[i] + two.psi[i])).powi(2));
            0.5 * model.get("EI") * (one.slope[i].powi(2) + two.slope[i].powi(2))
                + 0.5 * k_n * h2 + 0.25 * k_3n * h2 * h2
                + k_t * m2 + 0.5 * k_3t * m2 * m2
        }));
        let error = (energy(0.0) - stored).abs() / stored;
        prop_assert!(error < 1e-8, "{error:.1e}: {:.6e} {stored:.6e}", energy(0.0));
    }
}
