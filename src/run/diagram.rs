//! A task of kind `diagram`: all branches that are reached by themselves.
//!
//! The branch from the model's start comes first; then, breadth first, the other branch at every branch point and the
//! cycles from every Hopf point that lie no more than `depth` switches away; then the branches through the given states
//! and through what deflation finds at given parameter values. A point that was met on both of its branches is not
//! switched at; nor is a state that lies on a known branch the start of another.

use super::cycles;
use super::equilibria::{self, Origin};
use super::outcome::{Outcome, Status};
use super::resume::Keeper;
use super::study::Prepared;
use super::watch::Watch;
use crate::bifurcation::{SAME, deflated, distance};
use crate::branch::{Kind, SpecialPoint};
use crate::continuation::Counts;
use crate::problem::Problem;
use crate::scene;
use std::collections::VecDeque;

/// Where a branch may start.
enum Start {
    Model,
    /// A state and the free parameter.
    State(Vec<f64>, f64),
    Switch(SpecialPoint),
    Cycles(SpecialPoint),
}

/// A start with the number of switches before it and what it is.
struct Planned {
    start: Start,
    depth: usize,
    from: String,
}

/// A branch or Hopf point that was met, how often, and the parameter.
struct Met {
    kind: Kind,
    state: Vec<f64>,
    free: f64,
    times: usize,
}

struct Explorer<'a> {
    prepared: &'a Prepared,
    name: &'a str,
    task: &'a scene::Diagram,
    keeper: &'a Keeper,
    watch: &'a Watch,
    queue: VecDeque<Planned>,
    met: Vec<Met>,
    outcomes: Vec<Outcome>,
}

/// All branches, each with its own name: "all-1", "all-2", ...
pub fn run(prepared: &Prepared, name: &str, task: &scene::Diagram, keeper: &Keeper, watch: &Watch) -> Vec<Outcome> {
    let (queue, met, outcomes) = Default::default();
    let mut explorer = Explorer { prepared, name, task, keeper, watch, queue, met, outcomes };
    explorer.plan(Start::Model, 0, "the model's start".to_owned());
    explorer.explore();
    for (k, guess) in task.states.iter().enumerate() {
        let (u, free) = equilibria::guessed(prepared, guess, explorer.begin());
        if let Some(u) = explorer.new_solution(&u, free) {
            explorer.plan(Start::State(u, free), 0, format!("state {}", k + 1));
            explorer.explore();
        }
    }
    for &free in &task.deflate {
        while let Some(u) = explorer.further_solution(free) {
            explorer.plan(Start::State(u, free), 0, format!("deflation at {} = {free}", prepared.free_name));
            let before = explorer.outcomes.len();
            explorer.explore();
            if explorer.outcomes.len() == before {
                break;
            }
        }
    }
    explorer.outcomes
}

impl Explorer<'_> {
    /// The free parameter's value where the first branch starts, and states without one.
    fn begin(&self) -> f64 {
        self.task.equilibria.start.unwrap_or(self.task.equilibria.along.range.from)
    }

    fn plan(&mut self, start: Start, depth: usize, from: String) {
        self.queue.push_back(Planned { start, depth, from });
    }

    /// Follows what is planned, and what follows from that.
    fn explore(&mut self) {
        while let Some(planned) = self.queue.pop_front() {
            let full = self.outcomes.len() >= self.task.max_branches;
            let stopped = self.outcomes.last().is_some_and(|outcome| outcome.status == Status::Interrupted);
            if full || stopped || self.watch.stopped() {
                self.queue.clear();
                return;
            }
            if let Start::Switch(point) = &planned.start
                && self.seen(point).is_some_and(|k| self.met[k].times > 1)
            {
                continue;
            }
            self.follow(planned);
        }
    }

    fn follow(&mut self, planned: Planned) {
        let name = format!("{}-{}", self.name, self.outcomes.len() + 1);
        self.watch.task(&name);
        let mut task = self.task.equilibria.clone();
        self.ask_for_known_values(&mut task);
        let mut outcome = match &planned.start {
            Start::Model => equilibria::run(self.prepared, &name, &task, Origin::Model, self.watch),
            Start::State(u, free) => equilibria::run(self.prepared, &name, &task, Origin::State(u, *free), self.watch),
            Start::Switch(point) => equilibria::run(self.prepared, &name, &task, Origin::Point(point), self.watch),
            Start::Cycles(point) => {
                let Some(cycles) = &self.task.cycles else { return };
                let task = scene::Cycles { from: point.label.clone(), ..cycles.clone() };
                cycles::run(self.prepared, &name, &task, point, self.keeper, self.watch)
            }
        };
        // That a branch cannot be followed further is part of the diagram.
        if outcome.status == Status::Failed && !outcome.branch.rows.is_empty() {
            outcome.status = Status::Done;
        }
        outcome.reason = format!("from {}: {}", planned.from, outcome.reason);
        self.watch.say(format!("{name} {}", outcome.reason));
        if !matches!(planned.start, Start::Cycles(_)) {
            self.note(&outcome.branch.points, planned.depth);
        }
        self.outcomes.push(outcome);
    }

    /// Where further solutions will be looked for, the states of all branches have to be known.
    fn ask_for_known_values(&self, task: &mut scene::Equilibria) {
        let range = &task.along.range;
        let free = &self.task.equilibria.along.free;
        let given = self.task.states.iter().map(|guess| guess.free(free).unwrap_or(self.begin()));
        let wanted = given.chain(self.task.deflate.iter().copied());
        let list = task.along.values.entry(free.clone()).or_default();
        for value in wanted.filter(|value| range.from < *value && *value < range.to) {
            if !list.contains(&value) {
                list.push(value);
            }
        }
        if list.is_empty() {
            task.along.values.remove(free);
        }
    }

    /// Plans what starts at the special points of a branch.
    fn note(&mut self, points: &[SpecialPoint], depth: usize) {
        for point in points.iter().filter(|point| [Kind::BP, Kind::HB].contains(&point.kind)) {
            if let Some(k) = self.seen(point) {
                self.met[k].times += 1;
                continue;
            }
            let Some(state) = state(point) else { continue };
            self.met.push(Met { kind: point.kind, state, free: self.free(point), times: 1 });
            if depth < self.task.depth {
                match point.kind {
                    Kind::BP => self.plan(Start::Switch(point.clone()), depth + 1, point.label.clone()),
                    _ if self.task.cycles.is_some() => {
                        self.plan(Start::Cycles(point.clone()), depth + 1, point.label.clone());
                    }
                    _ => {}
                }
            }
        }
    }

    fn free(&self, point: &SpecialPoint) -> f64 {
        point.parameters.get(&self.prepared.free_name).copied().unwrap_or(f64::NAN)
    }

    /// The size of states in the Euclidean norm.
    fn scale(&self) -> f64 {
        let states = self.outcomes.iter().flat_map(|o| &o.branch.points).filter_map(state);
        let largest = states.map(|u| distance(&u, &vec![0.0; u.len()])).fold(0.0, f64::max);
        if largest > 0.0 { largest } else { (self.prepared.problem.dim() as f64).sqrt() }
    }

    fn seen(&self, point: &SpecialPoint) -> Option<usize> {
        let (state, free) = (state(point)?, self.free(point));
        let range = &self.task.equilibria.along.range;
        let (near, scale) = (SAME * (range.to - range.from), SAME * self.scale());
        self.met.iter().position(|met| {
            met.kind == point.kind && (met.free - free).abs() < near && distance(&met.state, &state) < scale
        })
    }

    /// States of all branches at a value of the free parameter.
    fn known(&self, free: f64) -> Vec<Vec<f64>> {
        let range = &self.task.equilibria.along.range;
        let near = 1e-10 * (range.to - range.from);
        let branches = self.outcomes.iter().filter(|o| o.branch.kind == crate::branch::BranchKind::Equilibria);
        let points = branches.flat_map(|outcome| &outcome.branch.points);
        points.filter(|point| (self.free(point) - free).abs() < near).filter_map(state).collect()
    }

    fn parameters(&self, free: f64) -> Vec<f64> {
        let mut p = self.prepared.p.clone();
        p[self.prepared.free] = free;
        p
    }

    /// The solution near a state, unless it lies on a known branch.
    fn new_solution(&self, u: &[f64], free: f64) -> Option<Vec<f64>> {
        let (p, scale) = (self.parameters(free), self.scale());
        let found = deflated(&*self.prepared.problem, &p, u, (&[], scale), &mut Counts::default())?;
        self.known(free).iter().all(|known| distance(known, &found) > SAME * scale).then_some(found)
    }

    /// A solution that is not on a known branch, from several starts.
    fn further_solution(&self, free: f64) -> Option<Vec<f64>> {
        let (p, scale, known) = (self.parameters(free), self.scale(), self.known(free));
        let n = self.prepared.problem.dim();
        let problem = &*self.prepared.problem;
        let wave = |k: usize, i: usize| (1.0 + k as f64 * (i as f64 + 1.0) * 2.399963).sin();
        let beside = |u: &[f64], k: usize, by: f64| -> Vec<f64> {
            let length = distance(&(0..n).map(|i| wave(k, i)).collect::<Vec<_>>(), &vec![0.0; n]);
            u.iter().enumerate().map(|(i, u)| u + by * scale * wave(k, i) / length).collect()
        };
        let mut starts = vec![problem.start(&p), vec![0.0; n]];
        for by in [0.1, -0.1, 1.0, -1.0] {
            for base in known.iter().chain([&vec![0.0; n]]) {
                starts.extend((0..3).map(|k| beside(base, k, by)));
            }
        }
        let others: Vec<Vec<f64>> =
            self.task.states.iter().map(|guess| equilibria::guessed(self.prepared, guess, free).0).collect();
        let mut counts = Counts::default();
        others.iter().chain(&starts).find_map(|start| deflated(problem, &p, start, (&known, scale), &mut counts))
    }
}

fn state(point: &SpecialPoint) -> Option<Vec<f64>> {
    point.arrays.get("state").map(|array| array.data.clone())
}
