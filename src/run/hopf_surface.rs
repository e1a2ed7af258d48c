//! A task of kind `hopf-surface`: Hopf points in three parameters as triangles, with criticality and errors.

use super::equilibria::{error, frequency};
use super::hopf_curve::{COARSE, moved};
use super::outcome::{Outcome, Status};
use super::start::{StartError, Stored, coordinate};
use super::study::Prepared;
use super::watch::Watch;
use crate::bifurcation::{Coordinate, Hopf, HopfError, HopfNormalForm, HopfSurface};
use crate::branch::{Branch, BranchKind, Column, Row, SpecialPoint};
use crate::continuation::{Bound, Chart, Cover, CoverControl, Failure};
use crate::linalg::c64;
use crate::problem::{Problem, Refinement};
use crate::scene;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::time::Instant;
use thiserror::Error;

#[derive(Debug, Error)]
enum SurfaceError {
    #[error("no surface starts here: {0}")]
    Numerics(#[from] Failure),
    #[error("the start is not a Hopf point any more: {0}")]
    Start(#[from] HopfError),
    #[error("{0} is not stored with its eigenvector")]
    Incomplete(String),
    #[error(transparent)]
    Place(#[from] StartError),
    #[error("none of {0} moves the Hopf point: there is no surface in these parameters")]
    NoSurface(String),
}

/// Largest radius of a chart in parts of the ranges: lines of equal frequency are to be smooth on flat ground, too.
const LARGEST: f64 = 0.05;
/// Relative changes of sigma below this, over a whole range, are none.
const IDLE: f64 = 1e-10;
/// Points whose rows are made at once, between looks at Ctrl-C.
const BATCH: usize = 64;

/// The Hopf point of a chart and what is born there; also on the refined discretisation.
struct Sample {
    /// All parameters.
    p: Vec<f64>,
    /// The coordinate that was solved for.
    solved: usize,
    here: Option<Here>,
    fine: Option<Here>,
}

struct Here {
    hopf: Hopf,
    l1: Option<f64>,
}

pub fn run(prepared: &Prepared, name: &str, task: &scene::Surface, from: &SpecialPoint, watch: &Watch) -> Outcome {
    let start = Instant::now();
    let branch = empty(prepared, name, task);
    let refined = if task.along.errors { prepared.problem.refined() } else { None };
    let tool = Tool { prepared, task, refined, watch };
    let mut outcome = match tool.cover(branch.clone(), from) {
        Ok(outcome) => outcome,
        Err(failure) => Outcome::failed(branch, failure.to_string()),
    };
    outcome.seconds = start.elapsed().as_secs_f64();
    outcome
}

pub fn empty(prepared: &Prepared, name: &str, task: &scene::Surface) -> Branch {
    let list = prepared.problem.parameters();
    let free: Vec<_> = prepared.others.iter().chain([&prepared.free]).map(|&i| &list[i]).collect();
    let time = prepared.problem.time_unit();
    let per = |unit: &str| if time.is_empty() { unit.to_owned() } else { format!("{unit}/{time}") };
    let mut columns: Vec<(String, String)> = free.iter().map(|q| (q.name.to_owned(), q.unit.to_owned())).collect();
    columns.extend(task.along.logarithmic.iter().map(|name| (format!("log10 {name}"), String::new())));
    let own = [("omega", per("rad")), ("frequency", frequency(time)), ("lyapunov", String::new())];
    columns.extend(own.map(|(name, unit)| (name.to_owned(), unit)));
    if task.along.errors {
        let measured = columns.clone().into_iter().filter(|(name, _)| !name.starts_with("log10 "));
        columns.extend(measured.map(|(name, unit)| (format!("error {name}"), unit)));
    }
    Branch::new(
        name,
        BranchKind::HopfSurface,
        free.iter().map(|q| q.name.to_owned()).collect(),
        columns.into_iter().map(|(name, unit)| Column { name, unit }).collect(),
    )
}

struct Tool<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Surface,
    /// What error estimates come from.
    refined: Option<Refinement>,
    watch: &'a Watch,
}

impl Tool<'_> {
    fn cover(&self, mut branch: Branch, from: &SpecialPoint) -> Result<Outcome, SurfaceError> {
        let hopf = self.hopf(from)?;
        let coordinates = self.coordinates(&hopf)?;
        self.check_influence(&hopf, &coordinates)?;
        let (surface, x) = HopfSurface::start(self.prepared.problem.clone(), &hopf, coordinates);
        let mut bounds = Vec::new();
        for ((coordinate, range), place) in surface.coordinates.iter().zip(self.ranges()).zip(surface.places()) {
            for (upper, end) in [(false, range.from), (true, range.to)] {
                bounds.push(Bound { coordinate: place, upper, value: coordinate.of(end) });
            }
        }
        let ends: Vec<f64> = self.ranges().iter().flat_map(|range| [range.from, range.to]).collect();
        bounds.push(surface.end());
        let control = CoverControl { tolerance: self.task.tolerance, largest: LARGEST };
        let mut cover = Cover::start(&surface, &x, &surface.places(), bounds, control)?;
        let most = self.task.along.max_points;
        let stopped = loop {
            self.watch.at(cover.charts.len() as f64 / most as f64, format!("{} points", cover.charts.len()));
            if self.watch.stopped() {
                break Some((Status::Interrupted, "interrupted"));
            }
            if cover.charts.len() >= most {
                cover.charts.truncate(most);
                break Some((Status::Done, "max_points reached before the surface was covered"));
            }
            if !cover.step() {
                break None;
            }
        };
        let mut samples = Vec::with_capacity(cover.charts.len());
        for charts in cover.charts.chunks(BATCH) {
            // After Ctrl-C what was found is still to be stored, but without estimates of its errors.
            let refined = self.refined.as_ref().filter(|_| !self.watch.stopped());
            samples.par_extend(charts.par_iter().map(|chart| self.sample(chart, &ends, refined)));
            self.watch.at(samples.len() as f64 / cover.charts.len() as f64, format!("{} normal forms", samples.len()));
        }
        branch.rows = samples.iter().map(|sample| self.row(&branch, sample)).collect();
        branch.triangles = cover.triangles();
        let (status, reason) = stopped.unwrap_or((Status::Done, "covered as far as the ranges"));
        let mut reason = format!("{reason}; {} triangles", branch.triangles.len());
        if let Some(failure) = cover.failures.first() {
            reason += &format!("; {} places were left uncovered ({failure})", cover.failures.len());
        }
        let coarse = samples.iter().filter(|sample| self.too_coarse(&surface, sample)).count();
        if coarse > 0 {
            reason += &format!(
                "; at {coarse} points the estimated relative error exceeds {COARSE:.0e}: the discretisation does not resolve \
                 the mode there; refine it"
            );
        }
        Ok(Outcome { branch, status, reason, seconds: 0.0, counts: cover.counts })
    }

    /// All ranges, in the order of the free parameters.
    fn ranges(&self) -> Vec<&scene::Range> {
        let others = self.task.along.others.iter().filter_map(|axis| axis.range.as_ref());
        others.chain([&self.task.along.range]).collect()
    }

    fn free(&self) -> impl Iterator<Item = usize> + '_ {
        self.prepared.others.iter().copied().chain([self.prepared.free])
    }

    /// The stored point, solved for again in whichever parameter moves it.
    fn hopf(&self, from: &SpecialPoint) -> Result<Hopf, SurfaceError> {
        let Stored { u, p, omega, q } =
            Stored::read(self.prepared, from).ok_or_else(|| SurfaceError::Incomplete(from.label.clone()))?;
        let mut last = None;
        for free in self.free() {
            match Hopf::locate(&*self.prepared.problem, (&u, &p), free, omega, &q) {
                Ok(hopf) => return Ok(hopf),
                // Newton's step is 0/0 where a parameter does not matter.
                Err(HopfError::Diverged(step)) if !step.is_finite() => {}
                Err(failure) => last = Some(failure),
            }
        }
        Err(last.map_or_else(|| self.no_surface(), SurfaceError::from))
    }

    fn no_surface(&self) -> SurfaceError {
        let names: Vec<&str> = self.free().map(|i| self.prepared.problem.parameters()[i].name).collect();
        SurfaceError::NoSurface(names.join(", "))
    }

    fn coordinates(&self, hopf: &Hopf) -> Result<[Coordinate; 3], SurfaceError> {
        let make = |(index, range)| coordinate(self.prepared, &self.task.along, (index, Some(range)), &hopf.p);
        let made: Vec<Coordinate> = self.free().zip(self.ranges()).map(make).collect::<Result<_, _>>()?;
        made.try_into().map_err(|_| self.no_surface())
    }

    /// One of the parameters at least must move the Hopf point.
    fn check_influence(&self, hopf: &Hopf, coordinates: &[Coordinate; 3]) -> Result<(), SurfaceError> {
        for coordinate in coordinates {
            let z = coordinate.of(hopf.p[coordinate.index]);
            let slope = hopf.clone().along(&*self.prepared.problem, coordinate.index)?.slope;
            if slope.re.abs() * coordinate.rate(z) * coordinate.width > IDLE * hopf.omega {
                return Ok(());
            }
        }
        Err(self.no_surface())
    }

    fn sample(&self, chart: &Chart<HopfSurface>, ends: &[f64], refined: Option<&Refinement>) -> Sample {
        let surface = &chart.surface;
        let mut p = surface.parameters(&chart.x);
        // On a face the parameter is the range's end itself, not the power of its logarithm.
        let held: Vec<usize> = chart.on.iter().map(|bound| bound / 2).filter(|k| *k < 3).collect();
        for &bound in chart.on.iter().filter(|bound| **bound < ends.len()) {
            p[surface.coordinates[bound / 2].index] = ends[bound];
        }
        let solved = surface.solvable(chart, &held);
        // Where the frequency vanishes there is no Hopf point.
        let vanished = chart.on.contains(&ends.len());
        let here = if vanished { None } else { surface.hopf(&chart.x, &p, solved).ok() };
        let here = here.map(|hopf| here_of(&*self.prepared.problem, hopf));
        let free = surface.coordinates[solved].index;
        let fine = here.as_ref().zip(refined).and_then(|(here, refined)| fine(refined, free, &here.hopf));
        if let Some(here) = &here {
            p.clone_from(&here.hopf.p);
        }
        Sample { p, solved, here, fine }
    }

    fn too_coarse(&self, surface: &HopfSurface, sample: &Sample) -> bool {
        let axis = surface.coordinates[sample.solved];
        let both = sample.here.as_ref().zip(sample.fine.as_ref());
        both.is_some_and(|(here, fine)| moved(axis, here.hopf.p[axis.index], fine.hopf.p[axis.index]) > COARSE)
    }

    fn row(&self, branch: &Branch, sample: &Sample) -> Row {
        let list = self.prepared.problem.parameters();
        let places: BTreeMap<&str, usize> = self.free().map(|i| (list[i].name, i)).collect();
        let solved = self.free().nth(sample.solved).map(|i| list[i].name);
        let value = |here: Option<&Here>, name: &str| {
            let omega = here.map_or(0.0, |here| here.hopf.omega);
            let parameter = |name: &str| places.get(name).map(|&i| here.map_or(sample.p[i], |here| here.hopf.p[i]));
            match name {
                "omega" => Some(omega),
                "frequency" => Some(omega / (2.0 * PI)),
                "lyapunov" => here?.l1,
                _ => match name.strip_prefix("log10 ") {
                    Some(name) => parameter(name).map(f64::log10),
                    None => parameter(name),
                },
            }
            .filter(|value| value.is_finite())
        };
        let number = |column: &Column| match column.name.strip_prefix("error ") {
            // The parameters that were held are exact.
            Some(name) if places.contains_key(name) && Some(name) != solved => None,
            Some(name) => {
                let (here, fine) = (sample.here.as_ref()?, sample.fine.as_ref()?);
                error(value(Some(here), name)?, value(Some(fine), name)?)
            }
            None => value(sample.here.as_ref(), &column.name),
        };
        let stable = value(sample.here.as_ref(), "lyapunov").map(|l1| l1 < 0.0);
        Row { label: None, stable, values: branch.columns.iter().map(number).collect() }
    }
}

fn here_of(problem: &dyn Problem, hopf: Hopf) -> Here {
    Here { l1: HopfNormalForm::new(problem, &hopf).ok().map(|form| form.l1), hopf }
}

/// The same Hopf point on the refined discretisation, the other parameters held.
fn fine(refined: &Refinement, free: usize, hopf: &Hopf) -> Option<Here> {
    let part = |f: fn(&c64) -> f64| (refined.prolong)(&hopf.q.iter().map(f).collect::<Vec<_>>());
    let q: Vec<c64> = part(|z| z.re).iter().zip(part(|z| z.im)).map(|(&re, im)| c64::new(re, im)).collect();
    let problem = &*refined.problem;
    let found = Hopf::locate(problem, (&(refined.prolong)(&hopf.u), &hopf.p), free, hopf.omega, &q).ok()?;
    Some(here_of(problem, found))
}
