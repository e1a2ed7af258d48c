//! Hopf points between neighbours of a branch of equilibria: by eigenvalues that are followed, and by how many grow.

use super::{MOST_HALVINGS, Mark, Sample, Spectra, middle};
use crate::bifurcation::{Hopf, HopfNormalForm, settle};
use crate::continuation::{Counts, Point, at_fraction, at_lambda};
use crate::linalg::{c64, growth};

impl Spectra<'_> {
    /// Inserts every Hopf point: a followed pair whose real part changes sign between two samples, solved for on its
    /// defining system. Pairs that stay on the axis, or meet there and leave it, cross nothing. Returns where pairs cross the
    /// axis without a Hopf point that can be solved for, in a sentence each.
    pub fn hopf_points(&self, samples: &mut Vec<Sample>, counts: &mut Counts) -> Vec<String> {
        let mut doubts = Vec::new();
        let side = |s: &Sample, k: usize| {
            let met = matches!(s.mark, Some(Mark::Exceptional(_)));
            if met || s.followed[k].im <= 0.0 { 0.0 } else { growth(s.followed[k]) }
        };
        let mut from: Vec<f64> = (0..samples.first().map_or(0, |s| s.followed.len())).map(|_| 0.0).collect();
        let mut i = 1;
        while i < samples.len() {
            let (a, b) = (&samples[i - 1], &samples[i]);
            // The side from which each branch comes: a point may lie on the axis by chance.
            for (k, from) in from.iter_mut().enumerate() {
                let here = side(a, k);
                let lost = a.followed[k].im <= 0.0 || matches!(a.mark, Some(Mark::Exceptional(_)));
                *from = if here != 0.0 || lost { here } else { *from };
            }
            let crossing = (0..a.followed.len()).filter(|&k| from[k] * side(b, k) < 0.0);
            let mut found: Vec<Sample> = crossing.filter_map(|k| self.hopf_between(a, b, k, counts)).collect();
            let met = [a, b].into_iter().any(|s| matches!(s.mark, Some(Mark::Exceptional(_))));
            if !met && self.unexplained((a, b), &found) {
                let mut counted = Vec::new();
                self.hopf_by_count((a, b), MOST_HALVINGS, &mut counted, counts);
                let near = 1e-9 * (b.point.lambda - a.point.lambda).abs();
                counted.retain(|s| found.iter().all(|t| (s.point.lambda - t.point.lambda).abs() > near));
                found.append(&mut counted);
                let pairs = |s: &Sample| s.values.iter().filter(|z| z.im > 0.0 && growth(**z) > 0.0).count();
                if self.unexplained((a, b), &found) && pairs(a) != pairs(b) && !(self.stopped)() {
                    let [from, to] = [a, b].map(|s| self.system.coordinate.value(s.point.lambda));
                    doubts.push(format!(
                        "the number of growing eigenvalues goes from {} to {} between {from:?} and {to:?}, but no Hopf point can \
                         be solved for that explains it",
                        growing(a),
                        growing(b)
                    ));
                }
            }
            found.sort_by(|x, y| {
                let along = |s: &Sample| (s.point.lambda - a.point.lambda) / (b.point.lambda - a.point.lambda);
                along(x).total_cmp(&along(y))
            });
            let count = found.len();
            for sample in found.into_iter().rev() {
                samples.insert(i, sample);
            }
            // Their eigenvalues in order, between neighbours that already are.
            for j in i..i + count {
                samples[j].followed = settle(&middle(&samples[j - 1], &samples[i + count]), &samples[j].values);
            }
            i += count + 1;
        }
        doubts
    }

    /// Whether the number of growing eigenvalues changes otherwise than by these Hopf points: a pair may come from so deep
    /// in the spectrum, or so fast, that it is not among those followed.
    fn unexplained(&self, (a, b): (&Sample, &Sample), found: &[Sample]) -> bool {
        let ways = found.iter().map(|s| match &s.mark {
            Some(Mark::Hopf(found)) => 2 * (found.0.slope.re * (b.point.lambda - a.point.lambda)).signum() as isize,
            _ => 0,
        });
        (growing(b) - growing(a) - ways.sum::<isize>()).abs() > 1
    }

    /// Hopf points by the number of growing eigenvalues: steps are halved until it changes by two, and the pair next to the
    /// axis is then the one that crosses.
    fn hopf_by_count(&self, (a, b): (&Sample, &Sample), halvings: usize, found: &mut Vec<Sample>, counts: &mut Counts) {
        let change = (growing(b) - growing(a)).abs();
        if change < 2 || (self.stopped)() {
            return;
        }
        if change == 2 {
            let nearest = |s: &Sample| {
                let pairs = s.values.iter().filter(|z| z.im > 0.0 && growth(**z) != 0.0);
                pairs.copied().min_by(|x, y| x.re.abs().total_cmp(&y.re.abs()))
            };
            let tried = [a, b].into_iter().find_map(|s| self.hopf_near(&s.point, nearest(s)?, (a, b), counts));
            if let Some(sample) = tried {
                found.push(sample);
                return;
            }
        }
        if halvings == 0 {
            return;
        }
        let Ok(middle) = at_fraction(self.system, (&a.point, &b.point), 0.5, counts) else { return };
        let mut middle = Sample::new(middle.point, None);
        let Ok(values) = self.at(&middle.point, counts) else { return };
        middle.values = values;
        self.hopf_by_count((a, &middle), halvings - 1, found, counts);
        self.hopf_by_count((&middle, b), halvings - 1, found, counts);
    }

    fn hopf_between(&self, a: &Sample, b: &Sample, k: usize, counts: &mut Counts) -> Option<Sample> {
        let (x, y) = (a.followed[k], b.followed[k]);
        let theta = x.re / (x.re - y.re);
        let near = at_fraction(self.system, (&a.point, &b.point), theta, counts).ok()?.point;
        self.hopf_near(&near, x + (y - x) * theta, (a, b), counts)
    }

    /// The Hopf point between two samples whose eigenvalue is near the expected one at a point near it.
    fn hopf_near(
        &self,
        near: &Point,
        expected: c64,
        (a, b): (&Sample, &Sample),
        counts: &mut Counts,
    ) -> Option<Sample> {
        let pairs = self.system.leading(&near.x, near.lambda, self.shift, self.count(), self.count()).ok()?.pairs;
        counts.spectra += 1;
        let pair = pairs
            .iter()
            .filter(|pair| pair.value.im > 0.0 && !pair.vector.is_empty())
            .min_by(|p, q| (p.value - expected).norm().total_cmp(&(q.value - expected).norm()))?;
        let p = self.system.parameters(near.lambda);
        let problem = &*self.system.problem;
        let coordinate = self.system.coordinate;
        let hopf = Hopf::locate(problem, (&near.x, &p), coordinate.index, pair.value.im, &pair.vector).ok()?;
        let form = HopfNormalForm::new(problem, &hopf).ok()?;
        let lambda = coordinate.of(hopf.p[coordinate.index]);
        let (low, high) = (a.point.lambda.min(b.point.lambda), a.point.lambda.max(b.point.lambda));
        let slack = 1e-9 * (high - low);
        if lambda < low - slack || lambda > high + slack {
            return None;
        }
        let mut point = at_lambda(self.system, (&a.point, &b.point), lambda, None, counts).ok()?.point;
        point.x.copy_from_slice(&hopf.u);
        let mut sample = Sample::new(point, Some(Mark::Hopf(Box::new((hopf, form)))));
        sample.values = self.at(&sample.point, counts).ok()?;
        Some(sample)
    }
}

/// How many of the eigenvalues that are known grow.
fn growing(sample: &Sample) -> isize {
    sample.values.iter().filter(|z| growth(**z) > 0.0).count() as isize
}
