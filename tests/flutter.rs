//! The classical flutter models: linearisations, conservation laws, critical loads by other methods, convergence.

mod common;

use common::{close, hopf_of_pair, near, refused, spectrum};
use hopfline::bifurcation::{Coordinate, Equilibria};
use hopfline::continuation::{Border, Counts, correct};
use hopfline::linalg::{Lu, c64};
use hopfline::models::{Base, Column, Filament, Load, Panel, Pipe};
use hopfline::problem::{At, Automatic, Default, Direction, Problem, check_derivatives};
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;
use std::sync::Arc;

/// A model with its parameters by name; ties are set by hand.
#[derive(Clone)]
struct Rod {
    problem: Arc<dyn Problem>,
    p: Vec<f64>,
}

impl Rod {
    fn new(problem: Arc<dyn Problem>) -> Self {
        let value = |default: &Default| if let Default::Value(x) = default { *x } else { f64::NAN };
        let p = problem.parameters().iter().map(|parameter| value(&parameter.default)).collect();
        Self { problem, p }
    }

    fn column(functions: usize) -> Self {
        Self::new(Arc::new(Automatic(Column::new(functions))))
    }

    fn filament(functions: usize, load: Load, base: Base) -> Self {
        Self::new(Arc::new(Automatic(Filament::new(functions, load, base)))).with("c_T", 0.5).with("tau", 1.0)
    }

    fn pipe(functions: usize) -> Self {
        Self::new(Arc::new(Automatic(Pipe::new(functions))))
    }

    fn index(&self, name: &str) -> usize {
        self.problem.parameters().iter().position(|p| p.name == name).expect("a parameter of the model")
    }

    fn with(mut self, name: &str, value: f64) -> Self {
        let i = self.index(name);
        self.p[i] = value;
        self
    }

    fn observe(&self, name: &str, u: &[f64]) -> f64 {
        let i = self.problem.observables().iter().position(|o| o.name == name).expect("an observable");
        self.problem.observe(i, At { u, v: &vec![0.0; u.len()], p: &self.p })
    }

    /// Some state or rate, smooth along the rod: coefficients fall off.
    fn some(&self, phase: f64, size: f64) -> Vec<f64> {
        let part = if self.problem.dim().is_multiple_of(2) { self.problem.dim() / 2 } else { self.problem.dim() };
        (0..self.problem.dim()).map(|k| size * (phase + 1.7 * k as f64).sin() / (1 + k % part).pow(2) as f64).collect()
    }

    fn straight(&self) -> Vec<f64> {
        vec![0.0; self.problem.dim()]
    }

    /// v with G(u, v, p) = 0: G is affine in v for models with inertia.
    fn rates(&self, u: &[f64]) -> Vec<f64> {
        let rest = self.straight();
        let mut g = rest.clone();
        let at = At { u, v: &rest, p: &self.p };
        self.problem.residual(at, &mut g);
        let (_, gv) = self.problem.linearised(at);
        Lu::new(gv).unwrap().solve(&mut g);
        g.iter().map(|g| -g).collect()
    }
}

#[test]
fn linearisations_are_exact() {
    let column = Rod::column(7).with("m", 0.3).with("c", 0.7).with("eta", 0.1).with("P", 9.0).with("p", 4.0);
    let cases = [
        ("filament", Rod::filament(9, Load::Uniform, Base::Clamped).with("P", 30.0).with("p", 12.0)),
        ("pinned filament", Rod::filament(8, Load::Distal, Base::Pinned).with("P", 8.0).with("p", 5.0)),
        ("column", column.clone().with("n", 1.5).with("chi", 0.7)),
        ("dead loads", column.with("chi", 0.0)),
        ("pipe", Rod::pipe(7).with("u", 4.0).with("gamma", 3.0).with("alpha", 0.01).with("c", 0.2)),
        ("panel", Rod::new(Arc::new(Automatic(Panel::new(6)))).with("lambda", 200.0).with("g", 0.5).with("R", -8.0)),
    ];
    for (name, rod) in cases {
        let (u, v) = (rod.some(0.3, 0.8), rod.some(1.1, 2.0));
        for (u, v) in [(&u, &v), (&u, &rod.straight()), (&rod.straight(), &rod.straight())] {
            let error = check_derivatives(&*rod.problem, At { u, v, p: &rod.p });
            assert!(error < 1e-13, "{name}: {error}");
        }
        // The reflection maps motions to motions.
        let (mut here, mut there) = (rod.straight(), rod.straight());
        rod.problem.residual(At { u: &u, v: &v, p: &rod.p }, &mut here);
        let minus = |x: &[f64]| -> Vec<f64> { x.iter().map(|x| -x).collect() };
        rod.problem.residual(At { u: &minus(&u), v: &minus(&v), p: &rod.p }, &mut there);
        here.iter().zip(&there).for_each(|(a, b)| near(name, *a, -b, 1e-13 * a.abs().max(1.0)));
    }
}

/// Dead loads have a potential: the energy with it is conserved, or falls by what the dampings take, c int |r_t|² and
/// eta int psi_st².
#[test]
fn dead_loads_conserve_energy_and_damping_takes_it() {
    for (c, eta) in [(0.0, 0.0), (0.7, 0.0), (0.0, 0.3)] {
        let rod = Rod::column(8).with("chi", 0.0).with("P", 5.0).with("m", 0.4).with("c", c).with("eta", eta);
        let u: Vec<f64> =
            (0..16).map(|k| 0.9 * (0.3 + 1.7 * f64::from(k)).sin() / f64::from(1 + k % 8).powi(5)).collect();
        let v = rod.rates(&u);
        let total = |u: &[f64]| rod.observe("energy", u) + 5.0 * rod.observe("tip_position", u);
        // Sixth-order differences along the motion's direction.
        let along = |h: f64| total(&u.iter().zip(&v).map(|(u, v)| u + h * v).collect::<Vec<_>>());
        let h = 0.1 / v.iter().fold(1.0_f64, |a, b| a.max(b.abs()));
        let odd = |k: f64| along(k * h) - along(-k * h);
        let slope = (45.0 * odd(1.0) - 9.0 * odd(2.0) + odd(3.0)) / (60.0 * h);
        let (psi, rate) = u.split_at(8);
        let still = |psi: &[f64]| [psi, &[0.0; 8]].concat();
        let bare = rod.clone().with("m", 0.0);
        let kinetic = bare.observe("energy", &u) - bare.observe("energy", &still(psi));
        let power = 2.0 * c * kinetic + 2.0 * eta * rod.observe("energy", &still(rate));
        near("power", slope, -power, 1e-9);
        assert!((c == 0.0 && eta == 0.0) || power > 1e-3, "{power}");
    }
}

/// Euler's column beyond buckling is the elastica: with k = sin(theta/2), theta the tip's angle, P = K(k)^2,
/// x_tip = 2 E/K - 1, y_tip = 2 k/K (lengths in L, loads in EI/L^2).
#[test]
fn the_buckled_column_is_the_elastica() {
    let angle: f64 = 2.0;
    let k = (0.5 * angle).sin();
    // The arithmetic-geometric mean.
    let (mut a, mut g, mut sum, mut power) = (1.0_f64, (1.0 - k * k).sqrt(), 1.0 - 0.5 * k * k, 0.25);
    for _ in 0..6 {
        let half = 0.5 * (a - g);
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
        power *= 2.0;
        sum -= power * 2.0 * half * half;
    }
    let complete = FRAC_PI_2 / a;
    let second = complete * sum;
    let rod = Rod::column(24).with("chi", 0.0).with("P", complete * complete);
    let mut start = rod.straight();
    (start[0], start[1]) = (angle, -0.3);
    let coordinate = Coordinate { index: rod.index("P"), logarithmic: false, width: 1.0 };
    let system = Equilibria {
        problem: rod.problem.clone(),
        p: rod.p.clone(),
        coordinate,
        scale_state: 1.0,
        all_eigenvalues: None,
    };
    let border = Border { row: rod.straight(), lambda: 1.0 };
    let load = rod.p[rod.index("P")];
    // To the corrector's tolerance, 1e-11 of the state.
    let point = correct(&system, (start, load), &border, &mut Counts::default()).unwrap().point;
    close("tip angle", rod.observe("tip_angle", &point.x), angle, 1e-10);
    close("x", rod.observe("tip_position", &point.x), 2.0 * second / complete - 1.0, 1e-10);
    close("y", rod.observe("tip_deflection", &point.x), 2.0 * k / complete, 1e-10);
}

/// The determinant of Beck's column with tip mass, from its characteristic equation: y'''' + P y'' = w² y, clamped;
/// y'' = 0 and y''' = -m w² y at the tip. The load's line stays along the tangent, so that no load enters there.
fn beck_determinant(load: f64, omega: f64, mass: f64) -> f64 {
    let root = (0.25 * load * load + omega * omega).sqrt();
    let (a, b) = ((root - 0.5 * load).sqrt(), (root + 0.5 * load).sqrt());
    // y = A (cosh ax - cos bx) + B (sinh ax / a - sin bx / b)
    let (ch, sh, co, si) = (a.cosh(), a.sinh(), b.cos(), b.sin());
    let second = [a * a * ch + b * b * co, a * sh + b * si];
    let third = [a * a * a * sh - b * b * b * si, a * a * ch + b * b * co];
    let value = [ch - co, sh / a - si / b];
    let w2 = mass * omega * omega;
    second[0] * (third[1] + w2 * value[1]) - second[1] * (third[0] + w2 * value[0])
}

/// Where two roots in omega of f(P, omega) merge: f = f_omega = 0, by Newton's method with a numerical Jacobian.
fn merging(f: impl Fn(f64, f64) -> f64, start: (f64, f64)) -> (f64, f64) {
    let (mut load, mut omega) = start;
    let h = 0.02;
    // Sixth-order differences.
    let slope = |g: &dyn Fn(f64) -> f64, h: f64| {
        (45.0 * (g(h) - g(-h)) - 9.0 * (g(2.0 * h) - g(-2.0 * h)) + g(3.0 * h) - g(-3.0 * h)) / (60.0 * h)
    };
    let by_omega = |load: f64, omega: f64| slope(&|d| f(load, omega + d), h);
    for _ in 0..30 {
        let (f0, g0) = (f(load, omega), by_omega(load, omega));
        let f_load = slope(&|d| f(load + d, omega), h);
        let g_load = slope(&|d| by_omega(load + d, omega), h);
        let g_omega = slope(&|d| by_omega(load, omega + d), h);
        let determinant = f_load * g_omega - g0 * g_load;
        let step = ((f0 * g_omega - g0 * g0) / determinant, (f_load * g0 - g_load * f0) / determinant);
        (load, omega) = (load - step.0, omega - step.1);
        if step.0.abs() < 1e-13 * load && step.1.abs() < 1e-11 * omega {
            break;
        }
    }
    (load, omega)
}

/// The pair of eigenvalues of smallest frequencies: (frequencies' half difference)², negative beyond their meeting.
fn discriminant(rod: &Rod, name: &str, load: f64) -> (f64, f64) {
    let at = rod.clone().with(name, load);
    let upper = spectrum(&at.problem, (&at.straight(), &at.p), 40.0, 0).into_iter().map(|(z, _)| z);
    let mut upper: Vec<c64> = upper.filter(|z| z.im > 0.0).collect();
    upper.sort_by(|a, b| a.im.total_cmp(&b.im));
    let half = 0.5 * (upper[0] - upper[1]);
    (-(half * half).re, 0.5 * (upper[0] + upper[1]).im)
}

/// The load at which the two lowest frequencies meet, by secants on the smooth discriminant.
fn collision(rod: &Rod, name: &str, near: f64) -> (f64, f64) {
    let (mut a, mut b) = (near * 0.99, near * 1.01);
    let (mut at_a, mut at_b) = (discriminant(rod, name, a), discriminant(rod, name, b));
    for _ in 0..20 {
        let next = b - at_b.0 * (b - a) / (at_b.0 - at_a.0);
        (a, at_a) = (b, at_b);
        (b, at_b) = (next, discriminant(rod, name, next));
        if (b - a).abs() < 1e-13 * b || at_b.0 == at_a.0 {
            break;
        }
    }
    (b, at_b.1)
}

#[test]
fn beck_and_pflueger_agree_with_the_characteristic_equation() {
    for (mass, start) in [(0.0, (20.0, 11.0)), (1.0, (16.2, 6.3))] {
        let (load, omega) = merging(|p, w| beck_determinant(p, w, mass), start);
        let found = collision(&Rod::column(14).with("m", mass), "P", start.0);
        close("P", found.0, load, 1e-10);
        close("omega", found.1, omega, 1e-9);
    }
}

/// Leipholz and Hauger: y'''' + p (int_x^1 D) y'' = w² y by its power series about the base, y = sum c_k x^k; the
/// determinant of y'' and y''' at the tip. Every term is exact up to rounding; the series is entire.
fn distributed_determinant(load: f64, omega: f64, hauger: bool) -> f64 {
    const TERMS: usize = 90;
    // int_x^1 D dx' as a polynomial.
    let thrust: &[f64] = if hauger { &[0.5, -1.0, 0.5] } else { &[1.0, -1.0] };
    let series = |first: usize| {
        let mut c = vec![0.0; TERMS + 4];
        c[first] = 1.0;
        for k in 0..TERMS {
            let falling = |k: usize, n: usize| (0..n).map(|i| (k - i) as f64).product::<f64>();
            let bent = |k: usize| falling(k + 2, 2) * c[k + 2];
            let pushed: f64 = thrust.iter().enumerate().filter(|(j, _)| *j <= k).map(|(j, t)| t * bent(k - j)).sum();
            c[k + 4] = (omega * omega * c[k] - load * pushed) / falling(k + 4, 4);
        }
        let derivative =
            |n: usize| -> f64 { (n..c.len()).map(|k| c[k] * (0..n).map(|i| (k - i) as f64).product::<f64>()).sum() };
        [derivative(2), derivative(3)]
    };
    let ([a2, a3], [b2, b3]) = (series(2), series(3));
    a2 * b3 - a3 * b2
}

#[test]
fn leipholz_and_hauger_agree_with_power_series() {
    for (hauger, start) in [(false, (40.0, 11.0)), (true, (150.0, 11.5))] {
        let (load, omega) = merging(|p, w| distributed_determinant(p, w, hauger), start);
        let rod = Rod::column(16).with("n", f64::from(u8::from(hauger)));
        let found = collision(&rod, "p", start.0);
        close("p", found.0, load, 1e-9);
        close("omega", found.1, omega, 1e-9);
    }
}

/// The pipe's boundary-value problem, y'''' + u² y'' + 2 i w sqrt(beta) u y' = w² y with y'' = y''' = 0 at the tip:
/// exponentials of the four roots of its quartic.
fn pipe_determinant(u: f64, omega: f64, beta: f64) -> c64 {
    let i = c64::new(0.0, 1.0);
    let (b, d) = (c64::new(u * u, 0.0), c64::new(-omega * omega, 0.0));
    let c = 2.0 * omega * beta.sqrt() * u * i;
    let quartic = |z: c64| (((z * z + b) * z) + c) * z + d;
    // Durand and Kerner, then the determinant of rows r_j^n e^{r_j}.
    let mut roots: Vec<c64> = (0..4).map(|k| c64::new(0.4, 0.9).powi(k) * omega.sqrt()).collect();
    for _ in 0..200 {
        for j in 0..4 {
            let others: c64 = (0..4).filter(|&k| k != j).map(|k| roots[j] - roots[k]).product();
            let step = quartic(roots[j]) / others;
            roots[j] -= step;
        }
    }
    let rows = |r: c64| [c64::new(1.0, 0.0), r, r * r * r.exp(), r * r * r * r.exp()];
    let m: Vec<[c64; 4]> = roots.iter().map(|&r| rows(r)).collect();
    let mut sum = c64::new(0.0, 0.0);
    for (p, sign) in permutations() {
        sum += sign * m[0][p[0]] * m[1][p[1]] * m[2][p[2]] * m[3][p[3]];
    }
    // The order of the roots only changes the sign: divide by their Vandermonde determinant.
    let vandermonde: c64 = (0..4).flat_map(|j| (0..j).map(move |k| (j, k))).map(|(j, k)| roots[j] - roots[k]).product();
    sum / vandermonde
}

fn permutations() -> Vec<([usize; 4], f64)> {
    let mut all = Vec::new();
    for code in 0..256_usize {
        let p = [code % 4, code / 4 % 4, code / 16 % 4, code / 64];
        if (0..4).all(|k| p.contains(&k)) {
            let swaps = (0..4).flat_map(|j| (0..j).map(move |k| (j, k))).filter(|&(j, k)| p[k] > p[j]).count();
            all.push((p, if swaps % 2 == 0 { 1.0 } else { -1.0 }));
        }
    }
    all
}

#[test]
fn the_pipe_agrees_with_its_characteristic_equation() {
    for (beta, near_u, rank) in [(0.2, 5.6, 0), (0.5, 9.3, 0)] {
        let rod = Rod::pipe(18).with("beta", beta).with("u", near_u);
        let hopf = hopf_of_pair(&rod.problem, (&rod.straight(), &rod.p), rod.index("u"), 60.0, rank);
        let u = hopf.p[rod.index("u")];
        // The determinant's size from a place a little off.
        let scale = pipe_determinant(1.01 * u, hopf.omega, beta).norm();
        let here = pipe_determinant(u, hopf.omega, beta).norm();
        assert!(here < 1e-9 * scale, "beta = {beta}: {here} of {scale} at u = {u}, omega = {}", hopf.omega);
    }
}

/// Errors at the onset fall by more than a factor of ten with every two functions, down to rounding.
#[test]
fn onsets_converge_exponentially() {
    let exact = 37.6954308403;
    let mut last = f64::INFINITY;
    for functions in [6, 8, 10, 12, 14] {
        let rod = Rod::filament(functions, Load::Uniform, Base::Clamped).with("P", 37.0);
        let hopf = hopf_of_pair(&rod.problem, (&rod.straight(), &rod.p), rod.index("P"), 300.0, 0);
        let error = (hopf.p[rod.index("P")] - exact).abs();
        assert!(error < 0.1 * last || error < 1e-9, "{functions}: {error} after {last}");
        last = error;
    }
    assert!(last < 1e-9, "{last}");
    let exact = 343.356426280;
    let mut last = f64::INFINITY;
    for functions in [4, 6, 8, 10, 12] {
        let error = (collision(&Rod::new(Arc::new(Automatic(Panel::new(functions)))), "lambda", 343.0).0 - exact).abs();
        assert!(error < 0.1 * last || error < 1e-8, "{functions}: {error} after {last}");
        last = error;
    }
    assert!(last < 1e-8, "{last}");
}

/// A pin with an ever stiffer spring is a clamp.
#[test]
fn a_stiff_spring_clamps_the_filament() {
    let clamped = Rod::filament(14, Load::Uniform, Base::Clamped).with("P", 37.0);
    let exact = hopf_of_pair(&clamped.problem, (&clamped.straight(), &clamped.p), clamped.index("P"), 300.0, 0);
    let onset = |k: f64| {
        let rod = Rod::filament(15, Load::Uniform, Base::Pinned).with("P", 37.0).with("k", k);
        hopf_of_pair(&rod.problem, (&rod.straight(), &rod.p), rod.index("P"), 300.0, 0).p[rod.index("P")]
    };
    let [soft, stiff] = [1e4, 1e6].map(|k| (onset(k) - exact.p[clamped.index("P")]).abs());
    assert!(stiff < 1e-3 && (soft / stiff / 100.0 - 1.0).abs() < 0.05, "{soft} {stiff}");
}

/// With damping eta K the leading pairs move by -eta (w^H K q)/(2 w^H M q): where that vanishes for the lower of two
/// undamped modes is the limit of the critical load. Independent of any Hopf point.
#[test]
fn vanishing_internal_damping_halves_becks_load() {
    let column = Rod::column(14);
    let eta = column.index("eta");
    let drift = |load: f64| -> f64 {
        let at = column.clone().with("P", load);
        let n = at.problem.dim();
        let rest = at.straight();
        let (gu, gv) = at.problem.linearised(At { u: &rest, v: &rest, p: &at.p });
        let (gu, gv) = (gu.as_ref(), gv.as_ref());
        // Right and left vectors of the lowest pair; the left one from the transposed pencil.
        let lowest = |a: faer::Mat<f64>, m: faer::Mat<f64>| {
            let pairs = hopfline::linalg::pencil(a.as_ref(), m.as_ref(), 30.0, n).unwrap();
            let upper = pairs.into_iter().filter(|pair| pair.value.im > 0.0);
            upper.min_by(|a, b| a.value.im.total_cmp(&b.value.im)).unwrap()
        };
        let right = lowest(gu.to_owned(), gv.to_owned());
        let left = lowest(gu.transpose().to_owned(), gv.transpose().to_owned());
        // d G_u q by eta, exact.
        let mut e = vec![0.0; at.p.len()];
        e[eta] = 1.0;
        let mut change = vec![c64::new(0.0, 0.0); n];
        let mut out = rest.clone();
        for (part, unit) in [(0, c64::new(1.0, 0.0)), (1, c64::new(0.0, 1.0))] {
            let q: Vec<f64> = right.vector.iter().map(|z| if part == 0 { z.re } else { z.im }).collect();
            let directions = [Direction { u: &q, v: &[], p: &[] }, Direction { u: &[], v: &[], p: &e }];
            at.problem.derivative(At { u: &rest, v: &rest, p: &at.p }, &directions, &mut out);
            change.iter_mut().zip(&out).for_each(|(c, o)| *c += unit * o);
        }
        let by_damping: c64 = left.vector.iter().zip(&change).map(|(w, c)| w * c).sum();
        let mut by_sigma = c64::new(0.0, 0.0);
        for i in 0..n {
            for j in 0..n {
                by_sigma += left.vector[i] * gv[(i, j)] * right.vector[j];
            }
        }
        -(by_damping / by_sigma).re
    };
    let (mut a, mut b) = (10.5, 11.5);
    let (mut at_a, mut at_b) = (drift(a), drift(b));
    for _ in 0..12 {
        let next = b - at_b * (b - a) / (at_b - at_a);
        (a, at_a, b) = (b, at_b, next);
        at_b = drift(b);
        if (b - a).abs() < 1e-12 {
            break;
        }
    }
    close("P", b, 10.9388493, 5e-9);
    // The sequence of damped columns tends to it with the square of the damping.
    let mut errors = Vec::new();
    for damping in [1e-2, 1e-3] {
        let rod = column.clone().with("eta", damping).with("P", 11.0);
        let pairs = spectrum(&rod.problem, (&rod.straight(), &rod.p), 30.0, rod.problem.dim());
        let (value, vector) = pairs.into_iter().find(|(z, _)| z.im > 0.0).unwrap();
        let hopf = hopfline::bifurcation::Hopf::locate(
            &*rod.problem,
            (&rod.straight(), &rod.p),
            rod.index("P"),
            value.im,
            &vector,
        );
        errors.push(hopf.unwrap().p[rod.index("P")] - b);
    }
    assert!((errors[0] / errors[1] / 100.0 - 1.0).abs() < 0.01, "{errors:?}");
}

/// Runs a shipped scene with overrides.
fn scene(name: &str, sets: &[&str], only: &[&str]) -> Summary {
    let words = |list: &[&str]| list.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems").join(format!("{name}.toml"));
    let out = tempfile::tempdir().unwrap();
    let options = RunOptions { out: out.path().to_owned(), only: words(only), resume: false, quiet: true };
    run(&Scene::load(&path, &words(sets)).unwrap(), &options).unwrap()
}

fn kinds(summary: &Summary) -> Vec<String> {
    summary.points.iter().map(|p| p.kind.to_string()).filter(|kind| kind != "EP").collect()
}

/// Undamped, all eigenvalues are on the axis up to rounding: no Hopf point, one collision, whatever the discretisation;
/// with any damping worth the name there is a Hopf point and no collision.
#[test]
fn undamped_columns_collide_and_damped_ones_have_hopf_points() {
    for functions in ["8", "12", "20", "31"] {
        let functions = format!("model.functions={functions}");
        let summary = scene("beck", &[&functions], &["undamped"]);
        assert_eq!(kinds(&summary), ["KC"], "{functions}");
        let summary = scene("beck", &[&functions, "parameters.eta=1e-7"], &["undamped"]);
        assert_eq!(kinds(&summary), ["HB"], "{functions}");
        // External damping shifts the whole spectrum: the pairs meet left of the axis, then one crosses it.
        let summary = scene("beck", &[&functions, "parameters.c=1"], &["undamped"]);
        assert_eq!(kinds(&summary), ["XP", "HB"], "{functions}");
    }
    // Below the collision there is nothing.
    assert!(kinds(&scene("beck", &["task.undamped.range=[0, 19]"], &["undamped"])).is_empty());
}

#[test]
fn bad_options_are_refused() {
    refused("filament", &["model.base=\"glued\""], "\"clamped\" or \"pinned\"");
    refused("filament", &["model.base=\"pinned\"", "parameters.k=0"], "must be > 0");
    refused("beck", &["parameters.eta=-1"], "must be >= 0");
    refused("beck", &["model.functions=1"], "a whole number from 2 to 400");
}

/// An elastic energy of a uniformly bent filament is EI/2 L curvature².
#[test]
fn observables_have_their_units() {
    let mut rod = Rod::filament(10, Load::Uniform, Base::Clamped).with("L", 3.0).with("EI", 5.0).with("P", 0.7);
    rod = rod.with("p", 0.2);
    let mut u = rod.straight();
    u[0] = PI / 3.0;
    close("energy", rod.observe("energy", &u), 0.5 * 5.0 * (PI / 3.0).powi(2) / 3.0, 1e-14);
    // An arc of radius L/angle.
    close("y", rod.observe("tip_deflection", &u), 3.0 / (PI / 3.0) * (1.0 - (PI / 3.0).cos()), 1e-14);
    close("x", rod.observe("tip_position", &u), 3.0 / (PI / 3.0) * (PI / 3.0).sin(), 1e-14);
    // Straight, the base bears all of the loads.
    close("tension", rod.observe("base_tension", &rod.straight()), -(0.7 + 0.2 * 3.0), 1e-14);
}
