//! Eigenvalues along a branch of equilibria: followed through exceptional points, watched for Hopf points.

mod crossing;
mod exceptional;

use super::{BranchPoint, Equilibria, Fold, Followed, Hopf, HopfNormalForm, follow, settle};
use crate::continuation::{Counts, Failure, Point, at_fraction};
use crate::linalg::{Leading, Singular, c64, growth};
use exceptional::Meeting;
use rayon::prelude::*;

/// What is special about a point of a branch of equilibria.
#[derive(Clone, Debug)]
pub enum Mark {
    End,
    /// The branch could not be followed further.
    Stuck,
    User,
    /// With its normal form, where its defining system could be solved.
    Fold(Option<Box<Fold>>),
    Branch(Box<BranchPoint>),
    Hopf(Box<(Hopf, HopfNormalForm)>),
    /// Two eigenvalues coalesce at this value: a pair is born or dies on the real axis, or two pairs meet.
    Exceptional(c64),
}

/// A point of the branch with its eigenvalues.
#[derive(Clone, Debug)]
pub struct Sample {
    pub point: Point,
    pub mark: Option<Mark>,
    /// Rightmost first.
    pub values: Vec<c64>,
    /// In the order of the branches.
    pub followed: Vec<c64>,
}

impl Sample {
    pub fn new(point: Point, mark: Option<Mark>) -> Self {
        Self { point, mark, values: Vec::new(), followed: Vec::new() }
    }
}

/// The tool that computes spectra along one branch.
pub struct Spectra<'a> {
    system: &'a Equilibria,
    wanted: usize,
    shift: f64,
    /// Once it says so, no more eigenvalues are computed than are needed for what is there.
    stopped: &'a (dyn Fn() -> bool + Sync),
    /// How far along the imaginary axis none was missed, where not all eigenvalues are computed.
    pub reach: Option<Reach>,
}

/// How far along the imaginary axis no eigenvalue was missed at any of the points of a branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// All with an imaginary part of at most this size were found,
    pub covered: f64,
    /// and none can be higher than this, where it is known.
    pub bound: Option<f64>,
    pub complete: bool,
}

impl Reach {
    /// None where all eigenvalues were computed.
    fn of(found: &Leading) -> Option<Self> {
        let partial = found.covered.is_finite();
        partial.then(|| Self { covered: found.covered, bound: found.bound, complete: found.complete() })
    }

    /// What holds of both.
    fn and(self, other: Self) -> Self {
        Self {
            covered: self.covered.min(other.covered),
            bound: self.bound.zip(other.bound).map(|(a, b)| a.max(b)),
            complete: self.complete && other.complete,
        }
    }
}

/// Halvings of a step before eigenvalues that cannot be told apart are settled by distance alone.
const MOST_HALVINGS: usize = 12;
/// As many samples may be added to one step for that.
const MOST_INSERTED: usize = 2 * MOST_HALVINGS;
/// Eigenvalues closer than this part of the visible height need not be told apart.
const BLUR: f64 = 0.002;
/// Corners larger than this part of the spectrum's visible height are smoothed, by so many rounds of halving.
const CORNER: f64 = 0.006;
const MOST_REFINEMENTS: usize = 2;
/// Where no eigenvalue grows or decays, this part of the frequencies' extent stands for the visible height.
const FLAT: f64 = 1e-3;
/// Frequencies closer than this part of the eigenvalue are the same: where two meet, half of the digits are lost.
const SAME: f64 = 1e-6;
/// Pairs that stay closer than this part of the spectrum's visible height over a whole step are not looked at.
const VISIBLE: f64 = 0.01;

/// Samples looked at before the time is.
const BATCH: usize = 16;

impl<'a> Spectra<'a> {
    /// Computes all samples' eigenvalues, in parallel; those that come too late, when `stopped`, are left out.
    pub fn new(
        system: &'a Equilibria,
        wanted: usize,
        stopped: &'a (dyn Fn() -> bool + Sync),
        samples: &mut Vec<Sample>,
        counts: &mut Counts,
    ) -> Result<Self, Failure> {
        let mut tool = Self { system, wanted, shift: 1.0, stopped, reach: None };
        // The shift: the size of the wanted eigenvalues, found by asking twice at both ends.
        for _ in 0..2 {
            let mut size = 0.0_f64;
            for end in [samples.first(), samples.last()].into_iter().flatten() {
                let values = tool.at(&end.point, counts)?;
                size = values.iter().take(wanted).map(|z| z.norm()).fold(size, f64::max);
            }
            tool.shift = if size > 0.0 { 1.5 * size } else { 1.0 };
        }
        let of = |sample: &Sample| -> Result<(Vec<c64>, Option<Reach>), Failure> {
            let found = system.leading(&sample.point.x, sample.point.lambda, tool.shift, tool.count(), 0)?;
            let reach = Reach::of(&found);
            Ok((tool.chosen(found), reach))
        };
        let mut spectra = Vec::with_capacity(samples.len());
        for batch in samples.chunks(BATCH) {
            if stopped() && !spectra.is_empty() {
                break;
            }
            let found: Result<Vec<_>, _> = batch.par_iter().map(of).collect();
            spectra.extend(found?);
        }
        samples.truncate(spectra.len());
        counts.spectra += samples.len();
        tool.reach = spectra.iter().filter_map(|(_, reach)| *reach).reduce(Reach::and);
        for (sample, (values, _)) in samples.iter_mut().zip(spectra) {
            sample.values = values;
            if sample.values.is_empty() {
                return Err(Singular.into());
            }
        }
        Ok(tool)
    }

    /// Eigenvalues at a point, as many as are ever looked at.
    fn at(&self, point: &Point, counts: &mut Counts) -> Result<Vec<c64>, Failure> {
        counts.spectra += 1;
        self.looked_at(self.system, &point.x, point.lambda)
    }

    /// As many eigenvalues as are ever looked at.
    fn count(&self) -> usize {
        4 * self.wanted + 8
    }

    /// Of a system's eigenvalues the leading ones, and those of the same frequency: the other halves of two pairs that met
    /// on the axis decay fastest of all.
    fn looked_at(&self, system: &Equilibria, x: &[f64], lambda: f64) -> Result<Vec<c64>, Failure> {
        Ok(self.chosen(system.leading(x, lambda, self.shift, self.count(), 0)?))
    }

    fn chosen(&self, found: Leading) -> Vec<c64> {
        let mut values: Vec<c64> = found.pairs.iter().map(|pair| pair.value).collect();
        let rest = values.split_off(values.len().min(self.count()));
        let alike = |z: &c64| z.im != 0.0 && values.iter().any(|w| (w.im - z.im).abs() <= SAME * z.norm());
        let halves: Vec<c64> = rest.into_iter().filter(alike).collect();
        values.extend(halves);
        values
    }

    /// The rightmost eigenvalue's vector.
    pub fn mode(&self, point: &Point) -> Option<Vec<c64>> {
        let found = self.system.leading(&point.x, point.lambda, self.shift, self.count(), 1).ok()?;
        found.pairs.into_iter().next().map(|pair| pair.vector)
    }

    /// The rightmost eigenvalue of another discretisation of the same system.
    pub fn leading(&self, system: &Equilibria, point: &Point) -> Option<c64> {
        let found = system.leading(&point.x, point.lambda, self.shift, self.count(), 0).ok()?;
        found.pairs.first().map(|pair| pair.value)
    }

    /// Puts every sample's eigenvalues in the order of the branches; adds samples where they cannot be told apart
    /// otherwise, and at and around exceptional points.
    pub fn follow(&self, samples: &mut Vec<Sample>, counts: &mut Counts) -> Result<(), Failure> {
        self.meetings(samples, counts)?;
        let Some(first) = samples.first_mut() else { return Ok(()) };
        first.followed = first.values.iter().take(2 * self.wanted + 4).copied().collect();
        // The step that is looked at ends at `end`; after too many samples in it, the rest is settled by distance.
        let (mut i, mut end, mut halvings, mut inserted) = (1, 1, 0, 0);
        while i < samples.len() {
            if (self.stopped)() {
                samples.truncate(i);
                break;
            }
            if i > end {
                (end, halvings, inserted) = (i, 0, 0);
            }
            let meets = |s: &Sample| matches!(s.mark, Some(Mark::Exceptional(mean)) if mean.im > 0.0);
            let near_meeting = meets(&samples[i - 1]) || meets(&samples[i]);
            let guess = extrapolate(samples, i);
            let last = &samples[i - 1].followed;
            let values = &samples[i].values;
            let height = |count: usize| {
                let turning = values.iter().take(count).map(|z| FLAT * z.im.abs()).fold(0.0, f64::max);
                turning.max(values[0].re - values.get(count).or(values.last()).map_or(values[0].re, |z| z.re))
            };
            let found = match follow(last, &guess, values, self.wanted, BLUR * height(self.wanted)) {
                // Two pairs on one spot cannot be told apart, however close one looks.
                Err(_) if halvings >= MOST_HALVINGS || inserted >= MOST_INSERTED || near_meeting => {
                    Ok(Followed { values: settle(&guess, values), coalesced: Vec::new() })
                }
                found => found,
            };
            match found {
                Err(_) => {
                    self.insert(samples, i, 0.5, counts)?;
                    (end, halvings, inserted) = (end + 1, halvings + 1, inserted + 1);
                }
                Ok(found) => {
                    let near = [&samples[i - 1], &samples[i]];
                    let located = near.iter().any(|s| matches!(s.mark, Some(Mark::Exceptional(_))));
                    let edge = values[0].re - height(self.wanted);
                    let visible = found.coalesced.iter().find(|(j, _)| found.values[*j].re >= edge);
                    let mut added = 0;
                    if let Some(&(j, k)) = visible.filter(|_| !located) {
                        let ends = (Meeting::of(last[j], last[k]), Meeting::of(found.values[j], found.values[k]));
                        let width = (found.values[j] - found.values[k]).norm().max((last[j] - last[k]).norm());
                        if width > VISIBLE * height(self.wanted) {
                            added = self.exceptional(samples, i, ends, counts)?;
                            end += added;
                        }
                    }
                    if added == 0 {
                        samples[i].followed = found.values;
                        i += 1;
                    }
                    halvings = 0;
                }
            }
        }
        // Points were put where a branch outside of the visible spectrum bends, too; those have no name.
        for sample in samples.iter_mut() {
            // Two eigenvalues that meet are known to half of their digits.
            let edge = sample.values.get(self.wanted - 1).map_or(f64::NEG_INFINITY, |z| z.re - 1e-6 * z.norm());
            if matches!(sample.mark, Some(Mark::Exceptional(mean)) if mean.re < edge) {
                sample.mark = None;
            }
        }
        Ok(())
    }

    /// Adds samples where two pairs meet, and around there.
    fn meetings(&self, samples: &mut Vec<Sample>, counts: &mut Counts) -> Result<(), Failure> {
        let mut i = 1;
        while i < samples.len() && !(self.stopped)() {
            let (a, b) = (&samples[i - 1].values, &samples[i].values);
            if let Some(ends) = Meeting::of_pairs(a, b, 2 * self.wanted + 4) {
                i += self.exceptional(samples, i, ends, counts)?;
            }
            i += 1;
        }
        Ok(())
    }

    /// Adds samples where a polyline through the followed branches would show corners.
    pub fn smooth(&self, samples: &mut Vec<Sample>, counts: &mut Counts) -> Result<(), Failure> {
        for _ in 0..MOST_REFINEMENTS {
            if (self.stopped)() {
                break;
            }
            let shown = leading(samples, self.wanted);
            let real = |k: usize| samples.iter().map(move |s| s.followed[k].re);
            let top = shown.iter().flat_map(|&k| real(k)).fold(f64::NEG_INFINITY, f64::max);
            let bottom = samples.iter().filter_map(|s| s.values.get(self.wanted - 1)).map(|z| z.re).fold(top, f64::min);
            let turning = samples.iter().flat_map(|s| shown.iter().map(move |&k| s.followed[k]));
            let wide = turning.filter(|z| z.re >= bottom).map(|z| 2.0 * z.im.abs()).fold(0.0, f64::max);
            // Each part is drawn in a panel of its own height.
            let sizes = (CORNER * (top - bottom).max(FLAT * wide), CORNER * wide);
            let bent: Vec<usize> = (1..samples.len())
                .filter(|&i| {
                    let mut inner = [i - 1, i].into_iter().filter(|j| (1..samples.len() - 1).contains(j));
                    inner.any(|j| {
                        let near = (&samples[j - 1], &samples[j], &samples[j + 1]);
                        shown.iter().any(|&k| near.1.followed[k].re >= bottom && bends(near, k, sizes))
                    })
                })
                .collect();
            let added: Result<Vec<Sample>, Failure> = bent
                .par_iter()
                .map(|&i| {
                    let mut counts = Counts::default();
                    let (a, b) = (&samples[i - 1], &samples[i]);
                    let point = at_fraction(self.system, (&a.point, &b.point), 0.5, &mut counts)?.point;
                    let mut sample = Sample::new(point, None);
                    sample.values = self.at(&sample.point, &mut counts)?;
                    sample.followed = settle(&middle(a, b), &sample.values);
                    Ok(sample)
                })
                .collect();
            let added = added?;
            if added.is_empty() {
                break;
            }
            counts.spectra += added.len();
            for (&i, sample) in bent.iter().zip(added).rev() {
                samples.insert(i, sample);
            }
        }
        Ok(())
    }

    /// Inserts a sample before i, at a fraction of the step that ends there.
    fn insert(&self, samples: &mut Vec<Sample>, i: usize, theta: f64, counts: &mut Counts) -> Result<(), Failure> {
        let (a, b) = (&samples[i - 1].point, &samples[i].point);
        let point = at_fraction(self.system, (a, b), theta, counts)?.point;
        let mut sample = Sample::new(point, None);
        sample.values = self.at(&sample.point, counts)?;
        samples.insert(i, sample);
        Ok(())
    }
}

/// Branches half-way between two samples.
fn middle(a: &Sample, b: &Sample) -> Vec<c64> {
    a.followed.iter().zip(&b.followed).map(|(x, y)| 0.5 * (x + y)).collect()
}

/// Whether the middle of three samples lies off the straight line between its neighbours, in branch k, by more than
/// `sizes` in its real or imaginary part.
fn bends((a, b, c): (&Sample, &Sample, &Sample), k: usize, sizes: (f64, f64)) -> bool {
    let (left, right) = ((b.point.lambda - a.point.lambda).abs(), (c.point.lambda - b.point.lambda).abs());
    let off = b.followed[k] - (a.followed[k] * right + c.followed[k] * left) / (left + right);
    off.re.abs() > sizes.0 || off.im.abs() > sizes.1
}

/// Branches by linear extrapolation from the last two samples; the last values where a pair was just born or died.
fn extrapolate(samples: &[Sample], i: usize) -> Vec<c64> {
    let last = &samples[i - 1];
    let Some(before) = i.checked_sub(2).map(|k| &samples[k]) else { return last.followed.clone() };
    let distance = |a: &Point, b: &Point| {
        let d: f64 = a.x.iter().zip(&b.x).map(|(x, y)| (x - y).powi(2)).sum();
        (d + (a.lambda - b.lambda).powi(2)).sqrt()
    };
    let behind = distance(&before.point, &last.point);
    let ratio = if behind > 0.0 { distance(&last.point, &samples[i].point) / behind } else { 0.0 };
    let same = |x: &c64, y: &c64| (x.im == 0.0) == (y.im == 0.0);
    // Far beyond a short step, or across an exceptional point, the last value is the better guess.
    let pairs = last.followed.iter().zip(&before.followed);
    pairs.map(|(x, y)| if ratio <= 4.0 && same(x, y) { x + (x - y) * ratio } else { *x }).collect()
}

/// Branches that are among the `wanted` rightmost at some sample, the slowest of those on the axis.
pub fn leading(samples: &[Sample], wanted: usize) -> Vec<usize> {
    let count = samples.first().map_or(0, |s| s.followed.len());
    let mut shown = vec![false; count];
    for sample in samples {
        let mut order: Vec<usize> = (0..count).collect();
        let (growth, speed) = (|k: usize| growth(sample.followed[k]), |k: usize| sample.followed[k].im.abs());
        order.sort_by(|&j, &k| growth(k).total_cmp(&growth(j)).then(speed(j).total_cmp(&speed(k))));
        order.iter().take(wanted).for_each(|&k| shown[k] = true);
    }
    (0..count).filter(|&k| shown[k]).collect()
}
