//! The eye: parallel projection of the cube about the origin with sides of length 1.

use crate::plot::geometry::Point;

pub type Vector = [f64; 3];

pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Where the eye is, from far away.
#[derive(Clone, Copy, Debug)]
pub struct View {
    pub right: Vector,
    pub up: Vector,
    pub toward: Vector,
    scale: f64,
    origin: Point,
}

/// Heights are drawn somewhat smaller than the sides of the ground.
pub const HEIGHT: f64 = 0.85;
/// Azimuths and elevations to choose from: never along an axis.
const AZIMUTHS: [f64; 8] = [-60.0, -30.0, 30.0, 60.0, 120.0, 150.0, -150.0, -120.0];
const ELEVATIONS: [f64; 2] = [22.0, 32.0];

impl View {
    /// From angles in degrees; the cube is as wide or high as a side of `room`, whichever is less.
    pub fn new([azimuth, elevation]: [f64; 2], room: Point) -> View {
        let ((sa, ca), (se, ce)) = (azimuth.to_radians().sin_cos(), elevation.to_radians().sin_cos());
        let mut view = View {
            right: [-sa, ca, 0.0],
            up: [-se * ca, -se * sa, ce],
            toward: [ce * ca, ce * sa, se],
            scale: 1.0,
            origin: (0.0, 0.0),
        };
        let corners: Vec<Point> =
            (0..8).map(|k| view.at([k & 1, (k >> 1) & 1, k >> 2].map(|bit| f64::from(bit) - 0.5))).collect();
        let span = |f: fn(&Point) -> f64| {
            let (low, high) = (corners.iter().map(f))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            high - low
        };
        view.scale = (room.0 / span(|p| p.0)).min(room.1 / span(|p| p.1));
        view.origin = (0.5 * view.scale * span(|p| p.0), 0.5 * view.scale * span(|p| p.1));
        view
    }

    /// The angles at which the triangles, each turned as it is, show most of one side: there they hide each other least.
    pub fn best(triangles: impl Iterator<Item = [Vector; 3]>) -> [f64; 2] {
        let mut sum = [0.0; 3];
        for [a, b, c] in triangles {
            let side = |p: Vector, q: Vector| [q[0] - p[0], q[1] - p[1], (q[2] - p[2]) * HEIGHT];
            let area = cross(side(a, b), side(a, c));
            (0..3).for_each(|k| sum[k] += area[k]);
        }
        let seen = |angles: &[f64; 2]| dot(sum, View::new(*angles, (1.0, 1.0)).toward).abs();
        let all = ELEVATIONS.iter().flat_map(|&e| AZIMUTHS.iter().map(move |&a| [a, e]));
        all.max_by(|a, b| seen(a).total_cmp(&seen(b))).unwrap_or([-60.0, 22.0])
    }

    /// A point of the cube on the page.
    pub fn at(&self, v: Vector) -> Point {
        let v = [v[0], v[1], v[2] * HEIGHT];
        (self.origin.0 + self.scale * dot(v, self.right), self.origin.1 - self.scale * dot(v, self.up))
    }

    /// How near the eye it is, in sides of the cube.
    pub fn depth(&self, v: Vector) -> f64 {
        dot([v[0], v[1], v[2] * HEIGHT], self.toward)
    }

    /// How bright a plane of the cube is, from 0 to 1: lit from above the eye's left shoulder, on both sides.
    pub fn light(&self, [a, b, c]: [Vector; 3]) -> f64 {
        let side = |p: Vector, q: Vector| [q[0] - p[0], q[1] - p[1], (q[2] - p[2]) * HEIGHT];
        let normal = cross(side(a, b), side(a, c));
        let lamp = [0, 1, 2].map(|k| self.toward[k] + 0.7 * self.up[k] - 0.6 * self.right[k]);
        let size = (dot(normal, normal) * dot(lamp, lamp)).sqrt();
        if size > 0.0 { dot(normal, lamp).abs() / size } else { 1.0 }
    }
}
