//! Where a chart needs its next neighbour.

use super::polygon::Side;
use super::{Cover, Surface};

/// A chart that would be nearer to a bound than this part of a radius is placed on it.
const SNAP: f64 = 0.6;

/// Where a chart is to be placed: at s in the tangent plane of another, on some bounds.
#[derive(Clone)]
pub struct Target {
    pub from: usize,
    pub s: [f64; 2],
    pub on: Vec<usize>,
}

impl<S: Surface> Cover<S> {
    /// The first place that a chart needs a neighbour at: corners of the box, then its faces, then inside.
    pub(super) fn target(&self, i: usize) -> Option<Target> {
        let chart = &self.charts[i];
        let radius = chart.radius;
        let size = |v: [f64; 2]| v[0].hypot(v[1]);
        let on = |k: usize| chart.on.contains(&k);
        let is_new = |s: [f64; 2]| !chart.given_up.iter().any(|g| size([s[0] - g[0], s[1] - g[1]]) < 0.1 * radius);
        let reach = |v: [f64; 2]| v.map(|c| c * radius / size(v));
        let outside = |v: [f64; 2]| size(v) > radius * (1.0 + 1e-9);
        let corners = || (0..chart.polygon.0.len()).map(|k| (chart.polygon.0[k].0, chart.polygon.meeting(k)));
        for (v, meeting) in corners() {
            if let (Side::Bound(k), Side::Bound(l)) = meeting
                && !(on(k) && on(l))
                && !outside(v)
                && is_new(v)
            {
                return Some(Target { from: i, s: v, on: vec![k, l] });
            }
        }
        for k in 0..chart.polygon.0.len() {
            let Side::Bound(bound) = chart.polygon.0[k].1 else { continue };
            let (a, b) = chart.polygon.ends(k);
            if !on(bound) {
                let d = [b[0] - a[0], b[1] - a[1]];
                let t = (-(a[0] * d[0] + a[1] * d[1]) / (d[0] * d[0] + d[1] * d[1])).clamp(0.0, 1.0);
                let s = [a[0] + t * d[0], a[1] + t * d[1]];
                if !outside(s) && is_new(s) {
                    return Some(self.snapped(i, s, vec![bound]));
                }
                continue;
            }
            let next = (k + 1) % chart.polygon.0.len();
            for (v, beyond) in [(a, chart.polygon.meeting(k).0), (b, chart.polygon.0[next].1)] {
                let foreign = match beyond {
                    Side::Neighbour(j) => !self.charts[j].on.contains(&bound),
                    Side::Open => true,
                    Side::Bound(_) => outside(v),
                };
                if foreign || outside(v) {
                    let s = if outside(v) { reach(v) } else { v };
                    if is_new(s) {
                        return Some(self.snapped(i, s, vec![bound]));
                    }
                }
            }
        }
        for (v, (before, after)) in corners() {
            let along = [before, after].iter().any(|side| matches!(side, Side::Bound(k) if on(*k)));
            if !along && outside(v) && is_new(reach(v)) {
                return Some(self.snapped(i, reach(v), Vec::new()));
            }
        }
        None
    }

    /// A target close to a further bound is moved onto it.
    fn snapped(&self, from: usize, mut s: [f64; 2], mut on: Vec<usize>) -> Target {
        let chart = &self.charts[from];
        for _ in on.len()..2 {
            let near = (0..self.bounds.len()).filter(|k| !on.contains(k)).filter_map(|k| {
                let (normal, offset) = chart.line(&self.bounds[k])?;
                let foot = match on.first() {
                    None => {
                        let room = offset - (normal[0] * s[0] + normal[1] * s[1]);
                        [s[0] + room * normal[0], s[1] + room * normal[1]]
                    }
                    Some(&first) => {
                        let (other, limit) = chart.line(&self.bounds[first])?;
                        let det = normal[0] * other[1] - normal[1] * other[0];
                        [(offset * other[1] - limit * normal[1]) / det, (normal[0] * limit - other[0] * offset) / det]
                    }
                };
                let moved = (foot[0] - s[0]).hypot(foot[1] - s[1]);
                (moved < SNAP * chart.radius).then_some((k, foot, moved))
            });
            let Some((k, foot, _)) = near.min_by(|a, b| a.2.total_cmp(&b.2)) else { break };
            // A corner where the chart itself is needs no other.
            if on.iter().chain([&k]).all(|k| chart.on.contains(k)) && on.len() == 1 {
                break;
            }
            on.push(k);
            s = foot;
        }
        Target { from, s, on }
    }
}
