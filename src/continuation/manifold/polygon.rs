//! Convex polygons in a tangent plane, each side of which knows what lies beyond it.

/// What is beyond a side of a chart's polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Nothing yet.
    Open,
    /// Another chart.
    Neighbour(usize),
    /// A bound of the box.
    Bound(usize),
}

/// Corners counterclockwise, each with the side that leaves it.
#[derive(Clone, Debug)]
pub struct Polygon(pub Vec<([f64; 2], Side)>);

impl Polygon {
    /// The square that a circle about the origin touches from inside.
    pub fn square(radius: f64) -> Self {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        Self(corners.map(|[a, b]| ([radius * a, radius * b], Side::Open)).to_vec())
    }

    /// Keeps the part with `normal . v <= offset`; the new side is `side`.
    pub fn clip(&mut self, normal: [f64; 2], offset: f64, side: Side) {
        let height = |v: [f64; 2]| normal[0] * v[0] + normal[1] * v[1] - offset;
        if self.0.iter().all(|&(v, _)| height(v) <= 0.0) {
            return;
        }
        let mut kept = Vec::with_capacity(self.0.len() + 1);
        for (k, &(a, leaving)) in self.0.iter().enumerate() {
            let (b, _) = self.0[(k + 1) % self.0.len()];
            let (below, above) = (height(a), height(b));
            let t = below / (below - above);
            let cut = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
            match (below <= 0.0, above <= 0.0) {
                (true, true) => kept.push((a, leaving)),
                (true, false) => kept.extend([(a, leaving), (cut, side)]),
                (false, true) => kept.push((cut, leaving)),
                (false, false) => {}
            }
        }
        // A side without length is none.
        let size = kept.iter().map(|(v, _)| v[0].abs().max(v[1].abs())).fold(0.0, f64::max);
        let count = kept.len();
        let next = |k: usize| kept[(k + 1) % count].0;
        self.0 = (0..count).filter(|&k| apart(kept[k].0, next(k)) > 1e-13 * size).map(|k| kept[k]).collect();
    }

    /// Both ends of the k-th side.
    pub fn ends(&self, k: usize) -> ([f64; 2], [f64; 2]) {
        (self.0[k].0, self.0[(k + 1) % self.0.len()].0)
    }

    /// What meets in the k-th corner: the side that arrives and the one that leaves.
    pub fn meeting(&self, k: usize) -> (Side, Side) {
        (self.0[(k + self.0.len() - 1) % self.0.len()].1, self.0[k].1)
    }
}

/// The distance of two points of a plane.
pub fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_remember_what_is_beyond_them() {
        let mut polygon = Polygon::square(1.0);
        polygon.clip([1.0, 0.0], 0.25, Side::Neighbour(7));
        polygon.clip([0.0, 1.0], 0.0, Side::Bound(2));
        polygon.clip([0.0, 1.0], 0.0, Side::Bound(3));
        let sides: Vec<Side> = polygon.0.iter().map(|(_, side)| *side).collect();
        assert_eq!(sides, [Side::Open, Side::Neighbour(7), Side::Bound(2), Side::Open]);
        assert_eq!(polygon.ends(1), ([0.25, -1.0], [0.25, 0.0]));
        assert_eq!(polygon.meeting(2), (Side::Neighbour(7), Side::Bound(2)));
        polygon.clip([-1.0, 0.0], -5.0, Side::Open);
        assert!(polygon.0.is_empty());
    }
}
