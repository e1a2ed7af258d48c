//! The covering: charts, and where the next ones go.

use super::polygon::{Polygon, Side};
use super::target::Target;
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
        // What the new point tells its neighbours about how far it bends there.
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
