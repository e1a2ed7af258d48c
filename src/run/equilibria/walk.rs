//! The branch of equilibria with its step control alone.

use crate::bifurcation::{Coordinate, Equilibria, reverse};
use crate::continuation::{Border, Counts, Failure, Point, StepControl, Stop, Walk, correct};
use crate::problem::Problem;
use crate::run::study::Prepared;
use crate::run::watch::{Watch, interrupted};
use crate::scene;

/// Points in the order of the branch.
pub struct Walked {
    pub points: Vec<Point>,
    /// Why the way down from the start ended, where there was one.
    pub back: Option<Stop>,
    /// Why the way up ended, or the only way.
    pub stop: Stop,
}

pub fn system(prepared: &Prepared, along: &scene::Along) -> Equilibria {
    let logarithmic = along.logarithmic.contains(&along.free);
    let mut coordinate = Coordinate { index: prepared.free, logarithmic, width: 1.0 };
    coordinate.width = coordinate.of(along.range.to) - coordinate.of(along.range.from);
    Equilibria { problem: prepared.problem.clone(), p: prepared.p.clone(), coordinate, scale_state: 1.0 }
}

/// From the start, which is the lower end of the range unless the scene says otherwise, both ways as far as there are.
pub fn walk(
    prepared: &Prepared,
    system: &mut Equilibria,
    task: &scene::Equilibria,
    watch: &Watch,
    counts: &mut Counts,
) -> Result<Walked, Failure> {
    let along = &task.along;
    let coordinate = system.coordinate;
    let (from, to) = (coordinate.of(along.range.from), coordinate.of(along.range.to));
    let begin = task.start.map_or(from, |start| coordinate.of(start));
    let u = prepared.problem.start(&system.parameters(begin));
    let rms = (u.iter().map(|u| u * u).sum::<f64>() / u.len() as f64).sqrt();
    if rms > 0.0 {
        system.scale_state = rms;
    }
    let border = Border { row: vec![0.0; u.len()], lambda: 1.0 };
    let first = correct(&*system, (u, begin), &border, counts)?.point;
    let most = along.max_step.map_or(0.02, |step| step / (to - from).abs());
    let mut way = |start: Point, room: usize| {
        let control = StepControl { step: 0.25 * most, least: 1e-9 * most, most };
        let mut points = Vec::new();
        let mut walk = Walk::new(&mut *system, start, control, (from, to));
        let stop = loop {
            if interrupted() {
                break Stop::Interrupted;
            }
            if points.len() >= room {
                break Stop::MaxPoints;
            }
            match walk.step() {
                Ok(step) => {
                    let lambda = step.to.lambda;
                    let message = format!("{} = {:.6}", along.free, coordinate.value(lambda));
                    watch.at((lambda - from) / (to - from), message);
                    points.push(step.to);
                    if let Some(stop) = step.stop {
                        break stop;
                    }
                }
                Err(stop) => break stop,
            }
        };
        *counts += walk.counts;
        (points, stop)
    };
    let room = along.max_points.saturating_sub(1);
    let (mut points, mut back) = (Vec::new(), None);
    if begin > from {
        let mut down = first.clone();
        reverse(&mut down);
        let (mut found, stop) = way(down, if begin < to { room.div_ceil(2) } else { room });
        // One orientation for the whole branch.
        found.iter_mut().for_each(reverse);
        found.reverse();
        (points, back) = (found, Some(stop));
    }
    let left = room - points.len();
    points.push(first.clone());
    let closed = matches!(back, Some(Stop::Closed | Stop::Interrupted));
    let stop = if begin < to && !closed {
        let (found, stop) = way(first, left);
        points.extend(found);
        stop
    } else {
        back.take().unwrap_or(Stop::RangeEnd)
    };
    Ok(Walked { points, back, stop })
}
