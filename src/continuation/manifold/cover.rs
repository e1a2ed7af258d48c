//! The covering: charts, and where the next ones go.

use super::polygon::{Polygon, Side};
use super::{Bound, Chart, Surface};
use crate::continuation::{Counts, Failure};
use crate::linalg::Singular;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// How fine the covering is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoverControl {
    /// Distance of surface and tangent plane at a chart's circle, in the metric.
    pub tolerance: f64,
    /// Largest radius.
    pub largest: f64,
}

/// Charts solved for at once; fixed, so that results do not depend on the number of threads.
const BATCH: usize = 8;
/// A chart that would be nearer to a bound than this part of a radius is placed on it.
const SNAP: f64 = 0.6;
/// From chart to chart radii change by no more than this part of the distance.
const SLOPE: f64 = 0.2;
/// A chart shrinks when the surface leaves its plane by so many tolerances, or when another's slope to it exceeds so many
/// slopes.
const SLACK: f64 = 1.5;
/// Radii aim at this part of the tolerance.
const AIM: f64 = 0.8;
/// Tangent planes turned by more (as a cosine) belong to other parts of the surface.
const TURNED: f64 = 0.3;
/// So do points this far off the plane, in parts of their distance.
const OFF: f64 = 0.5;
/// A new chart this near to another, in parts of its radius, brings nothing.
const SAME: f64 = 0.05;
/// Radii below this part of the largest are given up.
const LEAST: f64 = 1e-3;

/// Charts that cover a surface in a box, as far as they have got.
pub struct Cover<S> {
    pub charts: Vec<Chart<S>>,
    pub bounds: Vec<Bound>,
    pub counts: Counts,
    /// Why places were left uncovered; empty if none was.
    pub failures: Vec<Failure>,
    control: CoverControl,
    open: BTreeSet<usize>,
}

/// Where a chart is to be placed: at s in the tangent plane of another, on some bounds.
#[derive(Clone)]
struct Target {
    from: usize,
    s: [f64; 2],
    on: Vec<usize>,
}

impl<S: Surface> Cover<S> {
    /// From a point of the surface inside the box, near which two of `coordinates` determine the others.
    pub fn start(
        surface: &S,
        x: &[f64],
        coordinates: &[usize],
        bounds: Vec<Bound>,
        control: CoverControl,
    ) -> Result<Self, Failure> {
        let weights = surface.weights();
        let close = |b: &Bound| b.room(x).abs() * weights[b.coordinate].sqrt() < 1e-12;
        let on: Vec<usize> = (0..bounds.len()).filter(|&k| close(&bounds[k])).take(2).collect();
        let mut x = x.to_vec();
        on.iter().for_each(|&k| x[bounds[k].coordinate] = bounds[k].value);
        let surface = surface.prepared(&x);
        let mut counts = Counts::default();
        let mut best: Option<(Chart<S>, f64)> = None;
        for (k, &a) in coordinates.iter().enumerate() {
            for &b in &coordinates[k + 1..] {
                if !on.iter().all(|&k| [a, b].contains(&bounds[k].coordinate)) {
                    continue;
                }
                let row = |c: usize| {
                    let mut row = vec![0.0; x.len()];
                    row[c] = weights[c].sqrt();
                    row
                };
                let Ok(chart) = Chart::solve(&surface, x.clone(), [row(a), row(b)], &mut counts) else { continue };
                // The more of the plane these two coordinates see, the better.
                let entry = |k: usize, c: usize| chart.basis[k][c] * weights[c].sqrt();
                let seen = (entry(0, a) * entry(1, b) - entry(0, b) * entry(1, a)).abs();
                if best.as_ref().is_none_or(|(_, most)| seen > *most) {
                    best = Some((chart, seen));
                }
            }
        }
        let (mut chart, _) = best.ok_or(Singular)?;
        on.iter().for_each(|&k| chart.x[bounds[k].coordinate] = bounds[k].value);
        (chart.on, chart.radius) = (on, control.largest);
        let (charts, failures) = (vec![chart], Vec::new());
        let mut cover = Self { charts, bounds, counts, failures, control, open: BTreeSet::from([0]) };
        cover.rebuild(0);
        Ok(cover)
    }

    /// Places a batch of charts; false when all is covered.
    pub fn step(&mut self) -> bool {
        let targets = self.targets();
        let placed: Vec<(Result<Chart<S>, Failure>, Counts)> = targets
            .par_iter()
            .map(|target| {
                let mut counts = Counts::default();
                (self.place(target, &mut counts), counts)
            })
            .collect();
        for (target, (chart, counts)) in targets.iter().zip(placed) {
            self.counts += counts;
            self.accept(target, chart);
        }
        !targets.is_empty()
    }

    /// Targets of charts so far from each other that none depends on the others'.
    fn targets(&mut self) -> Vec<Target> {
        let mut targets: Vec<(Target, Vec<f64>)> = Vec::new();
        let mut closed = Vec::new();
        for &i in &self.open {
            if targets.len() == BATCH {
                break;
            }
            let chart = &self.charts[i];
            let Some(target) = self.target(i) else {
                closed.push(i);
                continue;
            };
            let goal = chart.at(target.s);
            let apart = |(other, there): &(Target, Vec<f64>)| {
                let d: Vec<f64> = goal.iter().zip(there).map(|(a, b)| a - b).collect();
                let reach = chart.radius + self.charts[other.from].radius;
                chart.surface.inner(&d, &d).sqrt() > 2.0 * reach
            };
            if targets.iter().all(apart) {
                targets.push((target, goal));
            }
        }
        closed.iter().for_each(|i| {
            self.open.remove(i);
        });
        targets.into_iter().map(|(target, _)| target).collect()
    }

    /// The first place that a chart needs a neighbour at: corners of the box, then its faces, then inside.
    fn target(&self, i: usize) -> Option<Target> {
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

    /// Solves for a target; if that turns out to lie outside of the box, on the bound instead.
    fn place(&self, target: &Target, counts: &mut Counts) -> Result<Chart<S>, Failure> {
        let chart = &self.charts[target.from];
        let mut target = target.clone();
        loop {
            let placed = chart.project(target.s, &target.on, &self.bounds, counts)?;
            let weights = chart.surface.weights();
            let room = |k: usize| {
                let bound = &self.bounds[k];
                bound.room(&placed.x) * weights[bound.coordinate].sqrt()
            };
            let outside = (0..self.bounds.len()).filter(|k| !target.on.contains(k)).find(|&k| room(k) < 0.0);
            match outside {
                None => return Ok(placed),
                Some(_) if target.on.len() == 2 => return Err(Failure::Turned),
                Some(k) => target.on.push(k),
            }
        }
    }

    fn accept(&mut self, target: &Target, placed: Result<Chart<S>, Failure>) {
        let i = target.from;
        let parent = &self.charts[i];
        let fault = match &placed {
            Err(failure) => Some((*failure, 0.5)),
            Ok(chart) => {
                let (s, off) = parent.coordinates(&chart.x);
                let allowed = self.control.tolerance;
                if off > SLACK * allowed {
                    Some((Failure::Turned, (AIM * allowed / off).sqrt().max(0.3)))
                } else if parent.turn(chart) < TURNED || s[0].hypot(s[1]) > 2.0 * parent.radius {
                    Some((Failure::Turned, 0.5))
                } else {
                    None
                }
            }
        };
        match (fault, placed) {
            (None, Ok(chart)) => {
                if !self.insert(chart) {
                    self.give_up(target, None);
                }
            }
            (Some((failure, _)), _) if parent.radius < LEAST * self.control.largest => {
                self.give_up(target, Some(failure))
            }
            (Some((_, factor)), _) => self.shrink(i, factor * self.charts[i].radius),
            (None, Err(failure)) => self.give_up(target, Some(failure)),
        }
    }

    fn give_up(&mut self, target: &Target, failure: Option<Failure>) {
        self.charts[target.from].given_up.push(target.s);
        self.failures.extend(failure);
    }

    /// Adds a chart and cuts polygons; false if there is one already.
    fn insert(&mut self, mut chart: Chart<S>) -> bool {
        let tolerance = self.control.tolerance;
        let mut near = Vec::new();
        let mut radius = self.control.largest;
        for (k, other) in self.charts.iter().enumerate() {
            let Some(distance) = chart.within(other, other.radius + self.control.largest) else { continue };
            let (_, off) = chart.coordinates(&other.x);
            if off > OFF * distance || chart.turn(other) < TURNED {
                continue;
            }
            if distance < SAME * other.radius {
                return false;
            }
            radius = radius.min(other.radius + SLOPE * distance);
            if distance < 2.0 * other.radius {
                radius = radius.min(distance * (AIM * tolerance / off.max(f64::MIN_POSITIVE)).sqrt());
            }
            near.push((k, distance));
        }
        chart.radius = radius.max(LEAST * self.control.largest);
        let new = self.charts.len();
        chart.neighbours =
            near.iter().filter(|(k, d)| *d < self.charts[*k].radius + chart.radius).map(|(k, _)| *k).collect();
        let neighbours = chart.neighbours.clone();
        self.charts.push(chart);
        self.rebuild(new);
        for &k in &neighbours {
            self.charts[k].neighbours.push(new);
            self.cut(k, new);
            self.open.insert(k);
        }
        self.open.insert(new);
        // What the new point tells its neighbours about their curvature.
        for (k, distance) in near.into_iter().filter(|(k, _)| neighbours.contains(k)) {
            let (_, off) = self.charts[k].coordinates(&self.charts[new].x);
            let fitting = distance * (AIM * tolerance / off.max(f64::MIN_POSITIVE)).sqrt();
            if self.charts[k].radius > SLACK * fitting {
                self.shrink(k, fitting);
            }
        }
        true
    }

    /// Makes a chart smaller, and those about it that are too large beside it.
    fn shrink(&mut self, i: usize, radius: f64) {
        let least = 0.5 * LEAST * self.control.largest;
        let mut todo = vec![(i, radius.max(least))];
        let mut changed = BTreeSet::new();
        while let Some((i, radius)) = todo.pop() {
            if radius >= self.charts[i].radius {
                continue;
            }
            self.charts[i].radius = radius;
            changed.insert(i);
            for &k in &self.charts[i].neighbours {
                changed.insert(k);
                let (s, _) = self.charts[i].coordinates(&self.charts[k].x);
                let allowed = radius + SLACK * SLOPE * s[0].hypot(s[1]);
                if self.charts[k].radius > allowed {
                    todo.push((k, allowed));
                }
            }
        }
        for &k in &changed {
            self.rebuild(k);
        }
        self.open.extend(changed);
    }

    /// A chart's polygon from nothing.
    fn rebuild(&mut self, i: usize) {
        let chart = &mut self.charts[i];
        chart.polygon = Polygon::square(chart.radius);
        for (k, bound) in self.bounds.iter().enumerate() {
            if let Some((normal, offset)) = chart.line(bound) {
                let offset = if chart.on.contains(&k) { 0.0 } else { offset };
                chart.polygon.clip(normal, offset, Side::Bound(k));
            }
        }
        for j in self.charts[i].neighbours.clone() {
            self.cut(i, j);
        }
    }

    /// Cuts the polygon of chart i by chart j.
    fn cut(&mut self, i: usize, j: usize) {
        let (s, _) = self.charts[i].coordinates(&self.charts[j].x);
        let (here, there) = (self.charts[i].radius, self.charts[j].radius);
        let offset = 0.5 * (s[0] * s[0] + s[1] * s[1] + here * here - there * there);
        self.charts[i].polygon.clip(s, offset, Side::Neighbour(j));
    }
}
