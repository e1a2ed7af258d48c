//! Periodic normal forms at folds, flips and torus bifurcations of cycles.
//!
//! Near a critical cycle u_0 solutions of `G(u, u', p) = 0` are `u = u_0(tau) + xi v(tau) + xi² h(tau)/2 + ...` with
//!
//! ```text
//! fold    dtau/dt = 1 + sigma xi + ...,   dxi/dt = b xi² + ...,
//! flip    dtau/dt = 1 + a xi² + ...,      dxi/dt = c xi³ + ...,
//! torus   dtau/dt = 1 + a |z|² + ...,     dz/dt = d z |z|² + ...,     u = u_0 + z w + conj + ...
//! ```
//!
//! (Iooss 1988, doi:10.1016/0022-0396(88)90039-3; Kuznetsov, Govaerts, Doedel and Dhooge 2005, doi:10.1137/040611306).
//! Order by order the equations are linear and singular; what makes them solvable is read off the scalars of bordered
//! systems, `g(r) = 0`:
//!
//! ```text
//! fold    b = -g(D²G[V, V]/2) / g(G_v v),
//! flip    L h = -D²G[V, V] - 2 a G_v u_0',         c = -g(D³G[V, V, V]/6 + D²G[V, H]/2) / g(G_v v),
//! torus   L k = -D²G[W, W*] - a G_v u_0',  L j = -D²G[W, W],  j(P) = kappa² S j(0),
//!         d = -g(D³G[W, W, W*]/2 + D²G[W, K] + D²G[W*, J]/2) / g(G_v w),
//! ```
//!
//! H and K with the change of speed `a` in their derivatives, as in [`Linear::second`]. Functions v, w have mean square 1
//! over the period, so that b, c and d are rates per amplitude of the state; v at a fold points to longer periods, or
//! where the period stands still to a larger unknown. For
//! w without a factor `e^{i omega tau}` the imaginary part of d is that of the literature less a omega.

use super::borders::weights;
use super::closing::{Closed, Closing, Right, Solution};
use super::linear::Field;
use super::place::negated;
use super::{Critical, CriticalCycle, Place};
use crate::linalg::{Singular, c64, dot};
use crate::problem::Direction;

/// At a fold the period stands still if it changes by no more than this for changes of the orbit, relatively.
const STILL: f64 = 1e-8;

/// The leading coefficient with its two factors, `-top / bottom`: each vanishes at points of codimension two.
#[derive(Clone, Copy, Debug)]
pub struct CycleNormalForm {
    /// b, c or d.
    pub coefficient: c64,
    /// Vanishes with the coefficient, and is regular where `bottom` vanishes. Real but for tori; continuous as long as
    /// borders stay.
    pub top: c64,
    /// `g(G_v v)`: zero where the critical multiplier is double.
    pub bottom: c64,
}

impl CycleNormalForm {
    /// At a critical cycle.
    pub fn new(cycle: &CriticalCycle, x: &[f64]) -> Result<Self, Singular> {
        let place = cycle.place(x)?;
        match cycle.kind {
            Critical::Fold => fold(&place),
            Critical::Flip => flip(&place),
            Critical::Torus => torus(&place),
        }
    }
}

fn real(top: f64, bottom: f64) -> CycleNormalForm {
    let number = |x: f64| c64::new(x, 0.0);
    CycleNormalForm { coefficient: number(-top / bottom), top: number(top), bottom: number(bottom) }
}

/// The root of the mean of |v|² over the period.
fn root_mean_square(place: &Place, parts: &[&[f64]]) -> f64 {
    let (n, orbit) = (place.linear.n(), &place.linear.orbit);
    let weights = weights(orbit, &place.linear.system.scheme);
    let sum = |v: &[f64]| -> f64 { v.chunks(n).zip(&weights).map(|(v, w)| w * dot(v, v)).sum() };
    parts.iter().map(|v| sum(v)).sum::<f64>().sqrt()
}

fn scaled(x: &[f64], factor: f64) -> Vec<f64> {
    x.iter().map(|x| factor * x).collect()
}

fn fold(place: &Place) -> Result<CycleNormalForm, Singular> {
    let kernel = place.kernel();
    let size = root_mean_square(place, &[&kernel.nodes[0]]);
    let v = place.linear.field(&scaled(&kernel.nodes[0], 1.0 / size), kernel.z[0] / size, Vec::new());
    let top = scaled(&place.linear.second(&v, &v), 0.5);
    let bottom = place.linear.mass(&v.u);
    let g = |r: &[f64]| place.singular(&[r]).g[0];
    let mut form = real(g(&top), g(&bottom));
    form.coefficient *= 1.0_f64.copysign(towards(place, kernel));
    Ok(form)
}

/// What v points to more of: the period, or where that stands still an unknown.
fn towards(place: &Place, kernel: &Solution) -> f64 {
    let largest = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| if x.abs() > most.abs() { *x } else { most });
    let (orbit, way) = (&place.linear.orbit, largest(&kernel.nodes[0]));
    let still = (kernel.z[0] / orbit.part).abs() <= STILL * (way / largest(&orbit.nodes)).abs();
    if still { way } else { kernel.z[0] }
}

/// The variation (w, P') of the orbit itself with `L w + E_P P' = -r`, exactly: without the border.
fn response(place: &Place, r: Vec<f64>) -> Field {
    let (some, kernel) = (place.base(&negated(r), [0.0; 2]), place.kernel());
    let share = some.g[0] / kernel.g[0];
    let nodes: Vec<f64> = some.nodes[0].iter().zip(&kernel.nodes[0]).map(|(w, q)| w - share * q).collect();
    place.linear.field(&nodes, some.z[0] - share * kernel.z[0], Vec::new())
}

/// `D³G[a, b, c]` for variations that leave P alone.
fn third(place: &Place, [a, b, c]: [&Field; 3]) -> Vec<f64> {
    let (n, problem) = (place.linear.n(), &place.linear.system.frame.problem);
    place.linear.at_points(|k, at, out| {
        let points = k * n..(k + 1) * n;
        let directions = [a, b, c].map(|f| Direction { u: &f.u[points.clone()], v: &f.v[points.clone()], p: &[] });
        problem.derivative(at, &directions, out);
    })
}

fn add(x: &mut [f64], factor: f64, y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += factor * y);
}

fn flip(place: &Place) -> Result<CycleNormalForm, Singular> {
    let nodes = place.null_nodes().first().ok_or(Singular)?;
    let size = root_mean_square(place, &[nodes]);
    let linear = &place.linear;
    let v = linear.field(&scaled(nodes, 1.0 / size), 0.0, Vec::new());
    let h = response(place, linear.second(&v, &v));
    let mut top = scaled(&third(place, [&v, &v, &v]), 1.0 / 6.0);
    add(&mut top, 0.5, &linear.second(&v, &h));
    let bottom = linear.mass(&v.u);
    let g = |r: &[f64]| place.singular(&[r]).g[0];
    Ok(real(g(&top), g(&bottom)))
}

/// Real and imaginary part of `D²G[a, b]`.
fn second(place: &Place, a: &[Field; 2], b: &[Field; 2]) -> [Vec<f64>; 2] {
    let of = |i: usize, j: usize| place.linear.second(&a[i], &b[j]);
    let (mut re, mut im) = (of(0, 0), of(0, 1));
    add(&mut re, -1.0, &of(1, 1));
    add(&mut im, 1.0, &of(1, 0));
    [re, im]
}

fn conjugate([re, im]: &[Field; 2]) -> [Field; 2] {
    let turned = Field { u: negated(im.u.clone()), v: negated(im.v.clone()), ..im.clone() };
    [re.clone(), turned]
}

fn torus(place: &Place) -> Result<CycleNormalForm, Singular> {
    let linear = &place.linear;
    let (w, _) = place.critical().ok_or(Singular)?;
    let (re, im): (Vec<f64>, Vec<f64>) = w.iter().map(|z| (z.re, z.im)).unzip();
    let size = root_mean_square(place, &[&re, &im]);
    let w = [re, im].map(|part| linear.field(&scaled(&part, 1.0 / size), 0.0, Vec::new()));
    let kappa = place.kappa();

    let mut sum = linear.second(&w[0], &w[0]);
    add(&mut sum, 1.0, &linear.second(&w[1], &w[1]));
    let k = response(place, sum);
    let double = kappa * kappa;
    let closing =
        Closing { kappa: Closing::rotation(double.re, double.im), scalars: 0, column: None, rows: Vec::new() };
    let [re, im] = second(place, &w, &w).map(negated);
    let parts = [&re, &im].map(|equations| Right { equations, ..Right::default() });
    let j = Closed::new(linear, closing)?.solve(linear, &parts).nodes;
    let j = [0, 1].map(|i| linear.field(&j[i], 0.0, Vec::new()));

    // D³G[w, w, w*] = (r + i s)² (r - i s): r³ + r s², i (r² s + s³).
    let (r, s) = (&w[0], &w[1]);
    let mut top = [third(place, [r, r, r]), third(place, [r, r, s])];
    add(&mut top[0], 1.0, &third(place, [r, s, s]));
    add(&mut top[1], 1.0, &third(place, [s, s, s]));
    let crossed = second(place, &conjugate(&w), &j);
    for i in 0..2 {
        top[i].iter_mut().for_each(|x| *x *= 0.5);
        add(&mut top[i], 0.5, &crossed[i]);
        add(&mut top[i], 1.0, &linear.second(&w[i], &k));
    }
    let bottom = [0, 1].map(|i| linear.mass(&w[i].u));
    let system = place.complex()?;
    let g = |r: &[Vec<f64>; 2]| {
        let right = [0, 1].map(|i| Right { equations: &r[i], ..Right::default() });
        let g = system.solve(linear, &right).g;
        c64::new(g[0], g[1])
    };
    let (top, bottom) = (g(&top), g(&bottom));
    Ok(CycleNormalForm { coefficient: -top / bottom, top, bottom })
}
