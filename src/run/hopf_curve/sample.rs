//! A point of the curve with all that its row needs, and what lies between two of them.

use super::Curve;
use crate::bifurcation::{Coordinate, Hopf, HopfNormalForm, HopfSegment, Locus, Test};
use crate::branch::Kind;
use crate::continuation::{Counts, Point};
use crate::linalg::c64;
use crate::problem::Problem;
use crate::run::locus::{undecided, wanted};
use rayon::prelude::*;

/// Estimated relative error of a parameter from which on the discretisation counts as too coarse.
pub const COARSE: f64 = 1e-3;
/// A parameter that passes zero has at least the size of this part of its range.
const SMALLEST: f64 = 0.01;

/// What kind of special point a point is, if any, and the test that found it.
pub(super) type Mark = Option<(Kind, Option<Test>)>;
/// A step, the point that it reached, and what that is.
pub(super) type Reached = (HopfSegment, Point, Mark);

/// A point of the curve with all that its row needs.
pub(super) struct Sample {
    /// The step that led here.
    pub(super) segment: HopfSegment,
    pub(super) point: Point,
    /// The parameter that is solved for, the other being held.
    pub(super) free: usize,
    pub(super) here: Option<Here>,
    /// The same Hopf point on the refined discretisation.
    pub(super) fine: Option<Here>,
    pub(super) others: Vec<c64>,
    pub(super) mark: Mark,
}

/// The Hopf point and what is born there.
pub(super) struct Here {
    pub(super) hopf: Hopf,
    pub(super) form: Option<HopfNormalForm>,
}

impl Curve<'_> {
    /// Everything that rows need, side by side.
    pub(super) fn samples(&self, points: Vec<Reached>) -> Vec<Sample> {
        points.into_par_iter().map(|(segment, point, mark)| self.sample(segment, point, mark)).collect()
    }

    fn sample(&self, segment: HopfSegment, point: Point, mark: Mark) -> Sample {
        let problem = &*self.prepared.problem;
        // Where the frequency or another eigenvalue vanishes neither the slope nor l1 exists.
        let degenerate = matches!(mark, Some((Kind::BT | Kind::ZH, _)));
        let free = match mark {
            Some((_, Some(Test::Value(0, _)))) => segment.curve.second.index,
            Some((_, Some(Test::Value(_, _)))) => segment.curve.first.index,
            _ => segment.curve.solvable(&point),
        };
        let here = segment.curve.hopf(&point, free).ok().filter(|_| !degenerate);
        let here = here.map(|hopf| Here { form: HopfNormalForm::new(problem, &hopf).ok(), hopf });
        let fine = here.as_ref().and_then(|here| self.fine(segment.curve.first.index, free, here));
        let others = segment.curve.others(&point).unwrap_or_default();
        Sample { segment, point, free, here, fine, others, mark }
    }

    /// The same Hopf point on the refined discretisation, one parameter held.
    fn fine(&self, first: usize, free: usize, here: &Here) -> Option<Here> {
        let refined = self.refined.as_ref()?;
        let hopf = &here.hopf;
        let part = |f: fn(&c64) -> f64| (refined.prolong)(&hopf.q.iter().map(f).collect::<Vec<_>>());
        let q: Vec<c64> = part(|z| z.re).iter().zip(part(|z| z.im)).map(|(&re, im)| c64::new(re, im)).collect();
        let problem = &*refined.problem;
        let found = Hopf::locate(problem, (&(refined.prolong)(&hopf.u), &hopf.p), free, hopf.omega, &q).ok()?;
        let hopf = if free == first { found } else { found.along(problem, first).ok()? };
        Some(Here { form: HopfNormalForm::new(problem, &hopf).ok(), hopf })
    }

    /// Why the discretisation does not resolve the mode here, if so.
    pub(super) fn too_coarse(&self, sample: &Sample) -> Option<String> {
        self.refined.as_ref()?;
        let (here, free) = (sample.here.as_ref()?, sample.free);
        let name = self.prepared.problem.parameters()[free].name;
        let off = match &sample.fine {
            Some(fine) => {
                let axis = sample.segment.curve.axes().into_iter().find(|axis| axis.index == free)?;
                moved(axis, here.hopf.p[free], fine.hopf.p[free])
            }
            None => f64::INFINITY,
        };
        let advice = "the discretisation does not resolve the mode any more; refine it";
        (off > COARSE).then(|| format!("the estimated relative error of {name} is {off:.0e}: {advice}"))
    }

    /// Wanted values and points of codimension two between two neighbours, in the order of the curve.
    pub(super) fn between(&self, last: &Sample, next: &Sample, counts: &mut Counts) -> Vec<Sample> {
        let segment = &next.segment;
        let ended = next.mark.and_then(|(_, test)| test);
        let mut tests: Vec<(Kind, Test)> = wanted(self.prepared, &self.task.along, &segment.curve);
        let l1 = |sample: &Sample| sample.here.as_ref().and_then(|here| Some(here.form.as_ref()?.l1));
        let changes = match (l1(last), l1(next)) {
            (Some(a), Some(b)) => a * b < 0.0,
            // At BT there is none.
            (a, b) => a.is_some() != b.is_some() && ended != Some(Test::Frequency),
        };
        tests.extend(changes.then_some((Kind::GH, Test::Criticality)));
        tests.push((Kind::ZH, Test::Steady));
        let pairs = HopfSegment::crossing_pairs(&last.others, &next.others);
        if HopfSegment::crossings_missed(&last.others, &next.others, &pairs) {
            self.watch.say(undecided(Kind::HH, segment, &"pairs are too close to be told apart"));
        }
        tests.extend(pairs.into_iter().map(|test| (Kind::HH, test)));
        let found: Vec<_> = tests
            .into_iter()
            // At the end of the curve a wanted value is that end, and at BT a real eigenvalue vanishes anyway.
            .filter(|(kind, test)| ended != Some(*test) && !(*kind == Kind::ZH && ended == Some(Test::Frequency)))
            .filter_map(|(kind, test)| match segment.locate(test, counts) {
                Ok(point) => Some((segment.clone(), point?, Some((kind, Some(test))))),
                Err(failure) => {
                    self.watch.say(undecided(kind, segment, &failure));
                    None
                }
            })
            .collect();
        let mut samples = self.samples(found);
        let along = |sample: &Sample| segment.along(segment.curve.coordinates(&sample.point));
        samples.sort_by(|x, y| along(x).total_cmp(&along(y)));
        samples
    }
}

/// By how much a parameter's value changes from one discretisation to a finer one, in parts of its size.
pub fn moved(axis: Coordinate, here: f64, fine: f64) -> f64 {
    let least = if axis.logarithmic { 0.0 } else { SMALLEST * axis.width };
    (fine - here).abs() / here.abs().max(least)
}
