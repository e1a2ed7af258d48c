//! One chart: a point of the surface with its tangent plane, and the way from it to other points.

use super::polygon::Polygon;
use super::{Bound, Surface};
use crate::continuation::{Border, Counts, Factored, Failure, System, correct};
use crate::linalg::{Singular, dot, finite};

/// A disc of the tangent plane at a point, cut down to where no other chart is nearer.
#[derive(Clone)]
pub struct Chart<S> {
    /// The surface with its reference vectors at this point.
    pub surface: S,
    pub x: Vec<f64>,
    /// Orthonormal in the metric, and oriented as all others.
    pub basis: [Vec<f64>; 2],
    pub radius: f64,
    /// The bounds on which the point lies.
    pub on: Vec<usize>,
    /// Charts that overlap this one.
    pub(super) neighbours: Vec<usize>,
    pub(super) polygon: Polygon,
    /// Places that led nowhere.
    pub(super) given_up: Vec<[f64; 2]>,
}

impl<S: Surface> Chart<S> {
    /// The chart at x, which is solved for with two rows held: `[F_x; rows] t = (0, e_k)` gives its tangent plane.
    pub(super) fn solve(
        surface: &S,
        x: Vec<f64>,
        [first, second]: [Vec<f64>; 2],
        counts: &mut Counts,
    ) -> Result<Self, Failure> {
        let n = x.len() - 1;
        let slice = Slice { surface, value: dot(&first, &x), row: first };
        let border = Border { row: second[..n].to_vec(), lambda: second[n] };
        let corrected = correct(&slice, (x[..n].to_vec(), x[n]), &border, counts)?;
        let x = [&corrected.point.x[..], &[corrected.point.lambda]].concat();
        let mut basis = [n - 1, n].map(|k| {
            let mut t = vec![0.0; n + 1];
            t[k] = 1.0;
            corrected.factors.solve(&mut t);
            t
        });
        let inner = |a: &[f64], b: &[f64]| surface.inner(a, b);
        for k in 0..2 {
            if k == 1 {
                let along = inner(&basis[0], &basis[1]);
                let [first, second] = &mut basis;
                second.iter_mut().zip(&*first).for_each(|(b, a)| *b -= along * a);
            }
            let size = inner(&basis[k], &basis[k]).sqrt();
            basis[k].iter_mut().for_each(|t| *t /= size);
            if !finite(&basis[k]) {
                return Err(Singular.into());
            }
        }
        let surface = surface.prepared(&x);
        let (on, neighbours, given_up) = Default::default();
        Ok(Self { surface, x, basis, radius: 0.0, on, neighbours, polygon: Polygon(Vec::new()), given_up })
    }

    /// The point of the tangent plane at s.
    pub(super) fn at(&self, s: [f64; 2]) -> Vec<f64> {
        let [a, b] = &self.basis;
        (0..self.x.len()).map(|i| self.x[i] + s[0] * a[i] + s[1] * b[i]).collect()
    }

    /// Coordinates in the tangent plane of a point, and its distance from the plane.
    pub fn coordinates(&self, x: &[f64]) -> ([f64; 2], f64) {
        let d: Vec<f64> = x.iter().zip(&self.x).map(|(a, b)| a - b).collect();
        let s = [0, 1].map(|k| self.surface.inner(&self.basis[k], &d));
        let foot = self.at(s);
        let off: Vec<f64> = x.iter().zip(&foot).map(|(a, b)| a - b).collect();
        (s, self.surface.inner(&off, &off).sqrt())
    }

    /// The distance of two charts' points, if it is less than a reach.
    pub(super) fn within(&self, other: &Self, reach: f64) -> Option<f64> {
        let mut square = 0.0;
        // The last unknowns, parameters mostly, tell points apart best.
        for ((a, b), w) in self.x.iter().zip(&other.x).zip(self.surface.weights()).rev() {
            square += w * (a - b) * (a - b);
            if square >= reach * reach {
                return None;
            }
        }
        Some(square.sqrt())
    }

    /// The determinant of the map between two tangent planes: the cosine of their angle, negative if one is turned over.
    pub fn turn(&self, other: &Self) -> f64 {
        let product = |a: usize, b: usize| self.surface.inner(&self.basis[a], &other.basis[b]);
        product(0, 0) * product(1, 1) - product(0, 1) * product(1, 0)
    }

    /// The bound's line in the tangent plane: inside is `normal . s <= offset`, with a unit normal; None if no line.
    pub(super) fn line(&self, bound: &Bound) -> Option<([f64; 2], f64)> {
        let sign = if bound.upper { 1.0 } else { -1.0 };
        let slope = [0, 1].map(|k| sign * self.basis[k][bound.coordinate]);
        let room = sign * (bound.value - self.x[bound.coordinate]);
        let size = slope[0].hypot(slope[1]);
        (size > 0.0).then(|| (slope.map(|s| s / size), room / size))
    }

    /// The chart at the surface's point across s, or where the surface meets the bounds `on` near there.
    pub(super) fn project(
        &self,
        s: [f64; 2],
        on: &[usize],
        bounds: &[Bound],
        counts: &mut Counts,
    ) -> Result<Self, Failure> {
        let mut x = self.at(s);
        for &k in on {
            x[bounds[k].coordinate] = bounds[k].value;
        }
        let dual = |t: &[f64]| -> Vec<f64> { t.iter().zip(self.surface.weights()).map(|(t, w)| t * w).collect() };
        let held = |k: usize| {
            let mut row = vec![0.0; x.len()];
            let coordinate = bounds[k].coordinate;
            row[coordinate] = self.surface.weights()[coordinate].sqrt();
            row
        };
        let rows = match *on {
            [] => [dual(&self.basis[0]), dual(&self.basis[1])],
            [k] => {
                let ([a, b], _) = self.line(&bounds[k]).ok_or(Singular)?;
                let along: Vec<f64> =
                    self.basis[0].iter().zip(&self.basis[1]).map(|(first, second)| a * second - b * first).collect();
                [held(k), dual(&along)]
            }
            [k, l] => [held(k), held(l)],
            _ => return Err(Singular.into()),
        };
        let mut chart = Self::solve(&self.surface, x, rows, counts)?;
        for &k in on {
            chart.x[bounds[k].coordinate] = bounds[k].value;
        }
        if self.turn(&chart) < 0.0 {
            chart.basis.swap(0, 1);
        }
        chart.on = on.to_vec();
        Ok(chart)
    }
}

/// The curve in which a hyperplane `row . x = value` cuts the surface; the last unknown is the curve's lambda.
struct Slice<'a, S> {
    surface: &'a S,
    row: Vec<f64>,
    value: f64,
}

impl<S: Surface> System for Slice<'_, S> {
    type Factors = S::Factors;

    fn residual(&self, x: &[f64], lambda: f64, r: &mut [f64]) {
        let whole = [x, &[lambda]].concat();
        let n = r.len() - 1;
        self.surface.residual(&whole, &mut r[..n]);
        r[n] = dot(&self.row, &whole) - self.value;
    }

    fn factor(&self, x: &[f64], lambda: f64, border: &Border) -> Result<Self::Factors, Singular> {
        let last = [&border.row[..], &[border.lambda]].concat();
        self.surface.factor(&[x, &[lambda]].concat(), [&self.row, &last])
    }

    fn dual(&self, t: &[f64]) -> Vec<f64> {
        t.iter().zip(self.surface.scales()).map(|(t, w)| t * w).collect()
    }

    fn dual_lambda(&self) -> f64 {
        self.surface.scales().last().copied().unwrap_or(1.0)
    }
}
