//! Where a branch of cycles ends in an orbit of infinite period.
//!
//! Near it the cycle spends most of its time beside an equilibrium, and what passes there decides how the time P of a
//! passage (half the period, where symmetry gives the other half) grows:
//!
//! ```text
//! saddle          P = -ln |lambda - lambda_h| / rate + ...,     so that  dlambda/dP = -rate (lambda - lambda_h),
//! saddle-focus    lambda = lambda_h + exp(-rate P) (a cos(omega P) + b sin(omega P)) + ...,
//! saddle-node     P = c |lambda - lambda_s|^(-1/2) + ...,       so that  lambda_s = lambda + (P/2) dlambda/dP,
//! ```
//!
//! rate and omega being those of the eigenvalue nearest to the imaginary axis (Shilnikov; Glendinning and Sparrow 1984,
//! doi:10.1007/BF01010828; Kuznetsov 2004, doi:10.1007/978-1-4757-3978-7, sections 6.2 and 7.1). Two witnesses must agree:
//! what the periods say, and the equilibrium itself with its eigenvalues, or as a fold of equilibria (SNIC).
//!
//! Where the cycle passes several saddles (a heteroclinic cycle), that behind the connection which breaks is entered at a distance
//! of |lambda - lambda_h|, and each of them, with nearest eigenvalues -nu and mu, turns a distance d into d^(nu/mu) while -ln d / mu
//! goes by: `1/rate = 1/mu_1 + (nu_1/mu_1)/mu_2 + ...`, or the same backwards in time if the product of all nu/mu is below 1.

use crate::bifurcation::Fold;
use crate::continuation::Point;
use crate::linalg::{Lu, c64, finite, norm, pencil};
use crate::orbit::{Collocation, Orbit};
use crate::problem::{At, Problem};
use faer::Mat;
use faer::linalg::solvers::SolveLstsq;
use serde::{Deserialize, Serialize};

/// What a point of the branch says.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Passage {
    pub lambda: f64,
    /// P.
    pub time: f64,
    /// dlambda/dP along the branch.
    pub slope: f64,
}

/// What the orbit passes.
#[derive(Clone, Debug)]
pub enum Passed {
    /// With the rate as the periods have it, as the equilibria have it beside which the orbit slows down, if there are such, and
    /// how many of them the computed part of the orbit passes.
    Saddle { rate: f64, own: Option<f64>, saddles: usize },
    /// With the equilibrium's rate and frequency.
    Focus { rate: f64, omega: f64 },
    /// A fold of equilibria on the invariant circle.
    SaddleNode(Box<Fold>),
}

/// The end of the branch.
#[derive(Clone, Debug)]
pub struct Homoclinic {
    /// Where the period is infinite, and how far the last two estimates differ, or estimates by the two rates; of a fold
    /// what rounding leaves open.
    pub lambda: f64,
    pub error: f64,
    pub passed: Passed,
}

/// The branch has ended beside a saddle when it is this near, in parts of its own extent, or as near as the tolerance of
/// its meshes can tell,
const NEAR: f64 = 1e-8;
/// and the two rates agree so well; without a rate to compare with, when lambda does not change any more while P grows.
const AGREEMENT: f64 = 0.05;
const STANDSTILL: f64 = 1e-11;
/// Beside a saddle-focus, where lambda comes and goes, when it is this near,
const NEAR_FOCUS: f64 = 5e-5;
/// all of the last so many points lie so well on the spiral, in parts of the largest distance among them, and that
/// distance has shrunk so much.
pub const KEPT: usize = 7;
const ON_SPIRAL: f64 = 0.02;
const SHRUNK: f64 = 0.2;
/// Beside a saddle-node, when it is within this part of its distance from where the periods have it: that is also the part
/// of the period that the way outside the passage takes.
const SAME: f64 = 0.02;
/// An orbit comes near to an equilibrium within this part of its own size.
const BESIDE: f64 = 1e-2;
/// Steps of Newton's method to the equilibrium.
const MOST_STEPS: usize = 20;

impl Passage {
    pub fn new(system: &Collocation, point: &Point) -> Self {
        let (time, rate) = (system.part(&point.x), system.part(&point.tangent));
        Self { lambda: point.lambda, time, slope: point.tangent_lambda / rate }
    }
}

impl Homoclinic {
    /// Whether the branch ends after these points, of which the last [`KEPT`] are looked at, and the last is `point`;
    /// `extent` is the size of lambda's range.
    pub fn recognise(passages: &[Passage], (system, point): (&Collocation, &Point), extent: f64) -> Option<Self> {
        // Relative orbits end at relative equilibria, which are not looked for.
        if !system.reference().drift.is_empty() {
            return None;
        }
        let last = |count: usize| {
            let last = &passages[passages.len().checked_sub(count)?..];
            last.windows(2).all(|pair| pair[0].time < pair[1].time).then_some(last)
        };
        let at = (system, point);
        let focus = || focus(last(KEPT)?, at, extent);
        let last = last(3)?;
        saddle(last, at, extent).or_else(|| saddle_node(last, at)).or_else(focus)
    }
}

/// A straight line in lambda whose zero is lambda_h.
fn saddle(passages: &[Passage], (system, point): (&Collocation, &Point), extent: f64) -> Option<Homoclinic> {
    let [first, second, third] = passages else { return None };
    let estimate = |a: &Passage, b: &Passage| {
        let rate = -(b.slope - a.slope) / (b.lambda - a.lambda);
        (b.lambda + b.slope / rate, rate)
    };
    let ((before, _), (lambda, rate)) = (estimate(first, second), estimate(second, third));
    let left = (third.lambda - lambda).abs();
    let near = NEAR.max(system.tolerance.unwrap_or(0.0));
    if !(rate > 0.0 && left < near * extent) {
        return None;
    }
    let (own, saddles) = match passed(system, point, rate) {
        saddles if saddles.len() > 1 => {
            let off = |own: &f64| (own / rate).ln().abs();
            (rates(&saddles).into_iter().min_by(|a, b| off(a).total_cmp(&off(b))), saddles.len())
        }
        _ => (leading(system, point, rate).map(|value| value.re), 1),
    };
    // Where the rates disagree, the discretisation has its share in what is left.
    let apart = own.map(|own| (own / rate - 1.0).abs());
    let agree = apart.is_some_and(|apart| apart < AGREEMENT);
    let error = (lambda - before).abs().max(left * apart.unwrap_or(0.0).max(f64::EPSILON.sqrt()));
    let passed = Passed::Saddle { rate, own, saddles };
    (agree || left < STANDSTILL * extent).then_some(Homoclinic { lambda, error, passed })
}

/// The fold of equilibria where the orbit is slowest, if it is where the periods have it: with P as beside a saddle-node,
/// `lambda_s = lambda + (P/2) dlambda/dP`.
fn saddle_node(passages: &[Passage], (system, point): (&Collocation, &Point)) -> Option<Homoclinic> {
    let [.., second, third] = passages else { return None };
    let limit = |a: &Passage| a.lambda + 0.5 * a.slope * a.time;
    let place = limit(third);
    let settled = (place - limit(second)).abs() < SAME * (third.lambda - place).abs();
    if !settled {
        return None;
    }
    let (u, v) = slowest(&system.orbit(&point.x));
    let (free, mut p) = (system.frame.free, system.frame.p.clone());
    p[free] = place;
    let fold = Fold::locate(&*system.frame.problem, (&u, &p), (free, system.frame.scale_lambda), &v).ok()?;
    let lambda = fold.p[free];
    let agree = (lambda - place).abs() < SAME * (third.lambda - lambda).abs();
    let error = fold.rounding.abs().max(4.0 * f64::EPSILON * lambda.abs());
    let passed = Passed::SaddleNode(Box::new(fold));
    agree.then_some(Homoclinic { lambda, error, passed })
}

/// lambda_h from the spiral with the equilibrium's own rate and frequency.
fn focus(passages: &[Passage], (system, point): (&Collocation, &Point), extent: f64) -> Option<Homoclinic> {
    let (first, last) = (passages.first()?, passages.last()?);
    let values = |f: fn(f64, f64) -> f64| passages.iter().map(|a| a.lambda).fold(last.lambda, f);
    if values(f64::max) - values(f64::min) > extent * NEAR_FOCUS / SHRUNK {
        return None;
    }
    let value = leading(system, point, 1.0 / (last.time - first.time))?;
    let (rate, omega) = (value.re, value.im);
    if omega == 0.0 || (-rate * (last.time - first.time)).exp() > SHRUNK {
        return None;
    }
    let fit = |passages: &[Passage]| {
        let a = Mat::from_fn(passages.len(), 3, |i, k| {
            let since = passages[i].time - first.time;
            [1.0, (-rate * since).exp() * (omega * since).cos(), (-rate * since).exp() * (omega * since).sin()][k]
        });
        let b = Mat::from_fn(passages.len(), 1, |i, _| passages[i].lambda - last.lambda);
        let x = a.qr().solve_lstsq(&b);
        let off = &a * x.as_ref() - &b;
        (last.lambda + x[(0, 0)], off.norm_max())
    };
    let ((before, _), (lambda, off)) = (fit(&passages[..passages.len() - 1]), fit(passages));
    let widest = passages.iter().map(|a| (a.lambda - lambda).abs()).fold(0.0, f64::max);
    let near = (last.lambda - lambda).abs() < NEAR_FOCUS * extent;
    let error = (lambda - before).abs().max(off);
    let passed = Passed::Focus { rate, omega };
    (near && off < ON_SPIRAL * widest).then_some(Homoclinic { lambda, error, passed })
}

/// Amid the intervals, where the orbit is and how it moves.
fn motions(orbit: &Orbit) -> Vec<(Vec<f64>, Vec<f64>)> {
    let scheme = orbit.scheme();
    orbit.mesh.windows(2).map(|w| orbit.at(0.5 * (w[0] + w[1]), &scheme)).collect()
}

/// Where the orbit moves most slowly, and how.
fn slowest(orbit: &Orbit) -> (Vec<f64>, Vec<f64>) {
    motions(orbit).into_iter().min_by(|a, b| norm(&a.1).total_cmp(&norm(&b.1))).unwrap_or_default()
}

/// The size of an orbit's states.
fn extent(orbit: &Orbit) -> f64 {
    norm(&orbit.nodes) / ((orbit.nodes.len() / orbit.dim) as f64).sqrt()
}

/// The equilibrium nearest to a state, by Newton's method; `size` is that of states.
fn equilibrium(problem: &dyn Problem, (start, size): (&[f64], f64), p: &[f64]) -> Option<Vec<f64>> {
    let (mut u, rest) = (start.to_vec(), vec![0.0; start.len()]);
    for _ in 0..MOST_STEPS {
        let at = At { u: &u, v: &rest, p };
        let (gu, _) = problem.linearised(at);
        let mut r = vec![0.0; u.len()];
        problem.residual(at, &mut r);
        Lu::new(gu).ok()?.solve(&mut r);
        if !finite(&r) {
            return None;
        }
        u.iter_mut().zip(&r).for_each(|(u, d)| *u -= d);
        if norm(&r) <= 1e-12 * size.max(norm(&u)) {
            return Some(u);
        }
    }
    None
}

/// A saddle's eigenvalues nearest to the imaginary axis on both sides.
struct Saddle {
    stable: c64,
    unstable: c64,
}

/// The equilibrium near a state of an orbit, and its eigenvalues if it is a saddle. `size` is that of its rate.
fn saddle_at(system: &Collocation, lambda: f64, near: (&[f64], f64), size: f64) -> Option<(Vec<f64>, Saddle)> {
    let (problem, p) = (&*system.frame.problem, system.parameters(lambda));
    let u = equilibrium(problem, near, &p)?;
    let rest = vec![0.0; u.len()];
    let (gu, gv) = problem.linearised(At { u: &u, v: &rest, p: &p });
    // Irrational in units of the rate, so that it is no eigenvalue itself.
    let values = pencil(gu.as_ref(), gv.as_ref(), std::f64::consts::E * size, 0).ok()?;
    let nearest = |sign: f64| {
        let side = values.iter().map(|pair| pair.value).filter(|value| sign * value.re > 0.0);
        side.min_by(|a, b| a.re.abs().total_cmp(&b.re.abs()))
    };
    Some((u, Saddle { stable: nearest(-1.0)?, unstable: nearest(1.0)? }))
}

/// Minus the real part and the frequency of the eigenvalue nearest to the imaginary axis of the equilibrium beside which an
/// orbit slows down, on whichever side; None if it is no saddle.
fn leading(system: &Collocation, point: &Point, size: f64) -> Option<c64> {
    let orbit = system.orbit(&point.x);
    let (_, Saddle { stable, unstable }) = saddle_at(system, point.lambda, (&slowest(&orbit).0, extent(&orbit)), size)?;
    let value = if stable.re.abs() < unstable.re { stable } else { unstable };
    Some(c64::new(value.re.abs(), value.im.abs()))
}

/// The saddles that the computed part of an orbit comes near to, in order.
fn passed(system: &Collocation, point: &Point, size: f64) -> Vec<Saddle> {
    let orbit = system.orbit(&point.x);
    let (motions, extent) = (motions(&orbit), extent(&orbit));
    let count = motions.len();
    let speed = |j: usize| norm(&motions[j % count].1);
    let slow = (0..count).filter(|&j| speed(j) <= speed(j + count - 1) && speed(j) < speed(j + 1));
    let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let mut found: Vec<(Vec<f64>, Saddle)> = Vec::new();
    for j in slow {
        let there = &motions[j].0;
        let saddle = saddle_at(system, point.lambda, (there, extent), size);
        found.extend(saddle.filter(|(u, _)| distance(u, there) < BESIDE * extent));
    }
    // Several slow places beside one equilibrium are one passage.
    found.dedup_by(|(a, _), (b, _)| distance(a, b) < BESIDE * extent);
    if found.len() > 1 && distance(&found[0].0, &found[found.len() - 1].0) < BESIDE * extent {
        found.pop();
    }
    found.into_iter().map(|(_, saddle)| saddle).collect()
}

/// The rate at which the period grows at a heteroclinic cycle, for each of the connections that may break.
fn rates(saddles: &[Saddle]) -> Vec<f64> {
    let mut pairs: Vec<[f64; 2]> = saddles.iter().map(|saddle| [-saddle.stable.re, saddle.unstable.re]).collect();
    if pairs.iter().map(|[nu, mu]| nu / mu).product::<f64>() < 1.0 {
        pairs.reverse();
        pairs.iter_mut().for_each(|pair| pair.swap(0, 1));
    }
    let from = |first: usize| {
        let (mut time, mut power) = (0.0, 1.0);
        for [nu, mu] in pairs.iter().cycle().skip(first).take(pairs.len()) {
            time += power / mu;
            power *= nu / mu;
        }
        1.0 / time
    };
    (0..pairs.len()).map(from).collect()
}
