//! A task of kind `map`: the rightmost eigenvalue over a grid in two parameters, lines of the grid in parallel.
//!
//! The frequency jumps where another mode takes the lead: between neighbours whose eigenvectors are not alike. Columns
//! `jump NAME` say so of a point and the next one along each parameter, and `gap` tells by how much a mode leads.

use super::equilibria::{error, frequency, rates};
use super::outcome::{Outcome, Status};
use super::study::Prepared;
use super::watch::Watch;
use crate::bifurcation::{Leading, Line};
use crate::branch::{Branch, BranchKind, Column, Row};
use crate::continuation::{Counts, Stop};
use crate::linalg::Rightmost;
use crate::problem::{Problem, Refinement};
use crate::scene;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::time::Instant;

/// Error estimates are made at so many by so many points.
const SAMPLES: usize = 5;
/// Lines per thread between two looks at the progress.
const BATCH: usize = 2;
/// From this [`Rightmost::likeness`] on two neighbours share a mode.
const ALIKE: f64 = 0.5;

/// Estimated relative error from which on the discretisation counts as too coarse.
const COARSE: f64 = 0.01;

/// What is kept of a grid point.
#[derive(Clone, Copy)]
struct Cell {
    growth: f64,
    omega: f64,
    gap: Option<f64>,
    /// Of growth and omega.
    errors: Option<[f64; 2]>,
    /// Whether another mode leads at the next point along either parameter; None where there is none.
    jumps: [Option<bool>; 2],
}

/// The points of one line; None where there is no equilibrium or no eigenvalue.
struct Points {
    cells: Vec<Option<Cell>>,
    modes: Vec<Option<Rightmost>>,
    counts: Counts,
}

pub fn run(prepared: &Prepared, name: &str, task: &scene::Map, watch: &Watch) -> Outcome {
    let start = Instant::now();
    let refined = if task.along.errors { prepared.problem.refined() } else { None };
    let tool = Map { prepared, task, refined, axes: axes(prepared, task) };
    let mut outcome = tool.follow(empty(prepared, name, task), watch, start);
    outcome.seconds = start.elapsed().as_secs_f64();
    outcome
}

/// The values of both parameters, ends exact.
fn axes(prepared: &Prepared, task: &scene::Map) -> [Vec<f64>; 2] {
    let list = prepared.problem.parameters();
    let first = task.along.others.first().and_then(|axis| axis.range.as_ref()).unwrap_or(&task.along.range);
    let axis = |index: usize, range: &scene::Range, count: usize| -> Vec<f64> {
        let logarithmic = task.along.logarithmic.iter().any(|name| name == list[index].name);
        let value = |k: usize| match k {
            0 => range.from,
            k if k + 1 == count => range.to,
            k => {
                let part = k as f64 / (count - 1) as f64;
                if logarithmic {
                    range.from * (range.to / range.from).powf(part)
                } else {
                    range.from + part * (range.to - range.from)
                }
            }
        };
        (0..count).map(value).collect()
    };
    [axis(prepared.first(), first, task.grid[0]), axis(prepared.free, &task.along.range, task.grid[1])]
}

fn empty(prepared: &Prepared, name: &str, task: &scene::Map) -> Branch {
    let list = prepared.problem.parameters();
    let free = [prepared.first(), prepared.free].map(|i| &list[i]);
    let time = prepared.problem.time_unit();
    let (rate, turn) = rates(time);
    let frequency = frequency(time);
    let column = |name: &str, unit: &str| Column { name: name.to_owned(), unit: unit.to_owned() };
    let mut columns: Vec<Column> = free.iter().map(|q| column(q.name, q.unit)).collect();
    columns.extend(task.along.logarithmic.iter().map(|name| column(&format!("log10 {name}"), "")));
    columns.extend([column("growth", &rate), column("omega", &turn), column("frequency", &frequency)]);
    columns.push(column("gap", &rate));
    columns.extend(free.iter().map(|q| column(&format!("jump {}", q.name), "")));
    if task.along.errors {
        columns.extend([column("error growth", &rate), column("error frequency", &frequency)]);
    }
    Branch::new(name, BranchKind::Map, free.iter().map(|q| q.name.to_owned()).collect(), columns)
}

struct Map<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Map,
    /// What error estimates come from.
    refined: Option<Refinement>,
    axes: [Vec<f64>; 2],
}

impl Map<'_> {
    fn parameters(&self, i: usize, j: usize) -> Vec<f64> {
        let mut p = self.prepared.p.clone();
        p[self.prepared.first()] = self.axes[0][i];
        p[self.prepared.free] = self.axes[1][j];
        p
    }

    fn follow(&self, mut branch: Branch, watch: &Watch, start: Instant) -> Outcome {
        let [m, n] = self.task.grid;
        let mut counts = Counts::default();
        let seeds = self.seeds(&mut counts);
        let mut cells: Vec<Option<Cell>> = Vec::with_capacity(m * n);
        let mut last: Option<Vec<Option<Rightmost>>> = None;
        let mut status = Status::Done;
        let batch = BATCH * rayon::current_num_threads();
        for (k, seeds) in seeds.chunks(batch).enumerate() {
            if watch.stopped() {
                status = Status::Interrupted;
                break;
            }
            let lines: Vec<Points> =
                seeds.par_iter().enumerate().map(|(i, seed)| self.line(k * batch + i, seed.clone())).collect();
            for line in lines {
                counts += line.counts;
                let first = cells.len();
                cells.extend(line.cells);
                for j in 0..n {
                    let here = line.modes[j].as_ref();
                    let (next, below) = (line.modes.get(j + 1), last.as_ref().map(|last| &last[j]));
                    let jump = |other: &Option<Rightmost>| Some(here?.likeness(other.as_ref()?) < ALIKE);
                    if let Some(cell) = &mut cells[first + j] {
                        cell.jumps[1] = next.and_then(jump);
                    }
                    if let Some(cell) = first.checked_sub(n).and_then(|before| cells[before + j].as_mut()) {
                        cell.jumps[0] = below.and_then(jump);
                    }
                }
                last = Some(line.modes);
            }
            let done = (cells.len() / n) as f64 / m as f64;
            let left = start.elapsed().as_secs_f64() * (1.0 - done) / done;
            watch.at(done, format!("{} of {} points, {left:.0} s left", cells.len(), m * n));
        }
        branch.rows = cells.iter().enumerate().map(|(k, cell)| self.row(&branch, k, cell.as_ref())).collect();
        let reason = match status {
            Status::Interrupted => Stop::Interrupted.to_string(),
            _ => self.reason(&branch, &cells),
        };
        Outcome { branch, status, reason, seconds: 0.0, counts }
    }

    /// Where each line starts: along the first parameter, at the lower end of the second.
    fn seeds<'a>(&'a self, counts: &mut Counts) -> Vec<Line<'a>> {
        let problem = &*self.prepared.problem;
        let p = self.parameters(0, 0);
        let mut line = Line::new(problem, problem.start(&p), p);
        let seeds = (0..self.axes[0].len())
            .map(|i| {
                let p = self.parameters(i, 0);
                // A line whose first point fails starts anew, and may find its way further on.
                let found = line.go(&p).is_ok();
                if found { line.fresh() } else { Line::new(problem, problem.start(&p), p) }
            })
            .collect();
        *counts += line.counts;
        seeds
    }

    fn line(&self, i: usize, mut line: Line<'_>) -> Points {
        let n = self.axes[1].len();
        let (mut cells, mut modes) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut fine = Counts::default();
        for j in 0..n {
            let p = self.parameters(i, j);
            let found = line.leading(&p).ok();
            cells.push(found.as_ref().map(|found| {
                let Rightmost { value, next, .. } = &found.mode;
                let wanted = self.sampled(i, j) && value.re > 0.0;
                let errors = if wanted { self.errors(found, &p, &mut fine) } else { None };
                Cell {
                    growth: value.re,
                    omega: value.im,
                    gap: next.map(|next| value.re - next.re),
                    errors,
                    jumps: [None; 2],
                }
            }));
            modes.push(found.map(|found| found.mode));
        }
        let mut counts = line.counts;
        counts += fine;
        Points { cells, modes, counts }
    }

    /// Whether errors are estimated here: a coarse grid, ends included.
    fn sampled(&self, i: usize, j: usize) -> bool {
        let one = |k: usize, count: usize| {
            (0..SAMPLES).any(|s| k == (s as f64 * (count - 1) as f64 / (SAMPLES - 1) as f64).round() as usize)
        };
        self.refined.is_some() && one(i, self.task.grid[0]) && one(j, self.task.grid[1])
    }

    /// Against the refined discretisation, where the rightmost eigenvalue is looked for anew.
    fn errors(&self, here: &Leading, p: &[f64], counts: &mut Counts) -> Option<[f64; 2]> {
        let refined = self.refined.as_ref()?;
        let mut line = Line::new(&*refined.problem, (refined.prolong)(&here.u), p.to_vec());
        let fine = line.leading(p).ok();
        *counts += line.counts;
        let (here, fine) = (here.mode.value, fine?.mode.value);
        Some([error(here.re, fine.re)?, error(here.im, fine.im)?])
    }

    fn row(&self, branch: &Branch, k: usize, cell: Option<&Cell>) -> Row {
        let n = self.axes[1].len();
        let point = [self.axes[0][k / n], self.axes[1][k % n]];
        let parameter = |name: &str| branch.free.iter().position(|free| free == name).map(|i| point[i]);
        let value = |column: &Column| -> Option<f64> {
            if let Some(name) = column.name.strip_prefix("log10 ") {
                return parameter(name).map(f64::log10);
            }
            if let Some(name) = column.name.strip_prefix("jump ") {
                let which = branch.free.iter().position(|free| free == name)?;
                return cell?.jumps[which].map(|jump| f64::from(u8::from(jump)));
            }
            match column.name.as_str() {
                "growth" => Some(cell?.growth),
                "omega" => Some(cell?.omega),
                "frequency" => Some(cell?.omega / (2.0 * PI)),
                "gap" => cell?.gap,
                "error growth" => cell?.errors.map(|[growth, _]| growth),
                "error frequency" => cell?.errors.map(|[_, omega]| omega / (2.0 * PI)),
                name => parameter(name),
            }
        };
        Row {
            label: None,
            stable: cell.map(|cell| cell.growth < 0.0),
            values: branch.columns.iter().map(value).collect(),
        }
    }

    /// What the map shows, in a sentence.
    fn reason(&self, branch: &Branch, cells: &[Option<Cell>]) -> String {
        let found = || cells.iter().flatten();
        let mut text = format!("{} points unstable", found().filter(|cell| cell.growth > 0.0).count());
        let lost = cells.len() - found().count();
        if lost > 0 {
            text += &format!(", {lost} without an equilibrium or its eigenvalues");
        }
        let worst = |column: &str, size: &dyn Fn(&Cell) -> f64| {
            let i = branch.column(column)?;
            let errors = branch.rows.iter().zip(cells).filter_map(|(row, cell)| {
                let (error, size) = (row.values[i]?, size(cell.as_ref()?));
                (size > 0.0).then_some((error / size, error))
            });
            let (part, error) = errors.max_by(|a, b| a.0.total_cmp(&b.0))?;
            let unit = &branch.columns[i].unit;
            Some((part, format!("{error:.0e} {unit}").trim_end().to_owned()))
        };
        let growth = worst("error growth", &|cell| cell.growth);
        let frequency = worst("error frequency", &|cell| cell.omega);
        for (name, (part, error)) in
            [("growth", growth), ("frequency", frequency)].into_iter().filter_map(|(name, worst)| Some((name, worst?)))
        {
            text += &format!(", error of {name} up to {error}");
            if part > COARSE {
                text += " (too coarse a discretisation; refine it)";
            }
        }
        text
    }
}
