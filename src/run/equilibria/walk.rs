//! The branch of equilibria with its step control alone.

use crate::bifurcation::{Equilibria, reverse};
use crate::continuation::{Counts, Point, StepControl, Stop, Walk, normalise};
use crate::run::watch::Watch;
use crate::scene;

/// Points in the order of the branch.
pub struct Walked {
    pub points: Vec<Point>,
    /// Signs of the determinants bordered by the tangents, where asked for and known.
    pub signs: Vec<Option<f64>>,
    /// Why the way down from the start ended, where there was one.
    pub back: Option<Stop>,
    /// Why the way up ended, or the only way.
    pub stop: Stop,
}

/// What of a branch is wanted.
pub struct Wanted<'a> {
    pub along: &'a scene::Along,
    /// The determinants' signs.
    pub signed: bool,
    /// Only points for which this holds are gone on from.
    pub inside: &'a dyn Fn(&Point) -> bool,
}

/// Largest step in parts of the range.
const LARGEST_STEP: f64 = 0.02;

/// From the start both ways, as far as they do not leave the range at once.
pub fn walk(
    system: &mut Equilibria,
    (first, sign): (Point, Option<f64>),
    Wanted { along, signed, inside }: Wanted,
    watch: &Watch,
    counts: &mut Counts,
) -> Walked {
    let coordinate = system.coordinate;
    let (from, to) = (coordinate.of(along.range.from), coordinate.of(along.range.to));
    let most = along.max_step.map_or(LARGEST_STEP, |step| step / (to - from).abs());
    let scale = system.scale_state;
    let mut largest = scale;
    let mut way = |start: Point, room: usize| {
        system.scale_state = scale;
        let control = StepControl { step: 0.25 * most, least: 1e-9 * most, most };
        let mut found = Vec::new();
        let mut walk = Walk::new(&mut *system, start, control, (from, to));
        let stop = loop {
            if watch.stopped() {
                break Stop::Interrupted;
            }
            if found.len() >= room {
                break Stop::MaxPoints;
            }
            match walk.step() {
                Ok(step) => {
                    let lambda = step.to.lambda;
                    let message = format!("{} = {:.6}", along.free, coordinate.value(lambda));
                    watch.at((lambda - from) / (to - from), message);
                    found.push((step.to, if signed { step.factors.sign() } else { None }));
                    if let Some(stop) = step.stop {
                        break stop;
                    }
                    if found.last().is_some_and(|(point, _)| !inside(point)) {
                        break Stop::BoxEnd;
                    }
                }
                Err(stop) => break stop,
            }
        };
        *counts += walk.counts;
        largest = largest.max(system.scale_state);
        (found, stop)
    };
    let slack = 1e-12 * (to - from);
    let outward =
        |tangent: f64| (first.lambda <= from + slack && tangent < 0.0) || (first.lambda >= to - slack && tangent > 0.0);
    let (down, up) = (!outward(-first.tangent_lambda), !outward(first.tangent_lambda));
    let room = along.max_points.saturating_sub(1);
    let (mut all, mut back) = (Vec::new(), None);
    if down {
        let mut turned = first.clone();
        reverse(&mut turned);
        let (mut found, stop) = way(turned, if up { room.div_ceil(2) } else { room });
        // One orientation for the whole branch: with the tangent the determinant changes its sign.
        for (point, sign) in &mut found {
            reverse(point);
            *sign = sign.map(|sign| -sign);
        }
        found.reverse();
        (all, back) = (found, Some(stop));
    }
    let left = room - all.len();
    all.push((first.clone(), sign.filter(|_| signed)));
    let closed = matches!(back, Some(Stop::Closed | Stop::Interrupted));
    let stop = if up && !closed {
        let (found, stop) = way(first, left);
        all.extend(found);
        stop
    } else {
        back.take().unwrap_or(Stop::RangeEnd)
    };
    let (mut points, signs): (Vec<Point>, Vec<Option<f64>>) = all.into_iter().unzip();
    // The scale may have grown on the way.
    system.scale_state = largest;
    points.iter_mut().for_each(|point| normalise(&*system, point));
    Walked { points, signs, back, stop }
}
