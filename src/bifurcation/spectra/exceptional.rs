//! Exceptional points: where two eigenvalues of a branch of equilibria coalesce.
//!
//! Two real ones meet and leave the real axis, or a pair lands on it. Where the spectrum has a second line of symmetry -
//! the imaginary axis, without damping - two pairs on it do the same there: their frequencies meet, and one of them
//! grows (1:1 resonance; Krein 1950; Ziegler's and Beck's flutter, Seyranian and Mailybaev 2003, doi:10.1142/5305).
//! Eigenvalues go as the square root of the distance, but their mean and discriminant are smooth.

use super::{Mark, Sample, Spectra};
use crate::bifurcation::Equilibria;
use crate::continuation::{Counts, Failure, Point, at_fraction, at_lambda};
use crate::linalg::c64;
use rayon::prelude::*;

/// Where the curves of real and imaginary parts bend like a square root, points stand at these fractions of the gap.
const GRADES: [f64; 3] = [1.0 / 100.0, 1.0 / 20.0, 1.0 / 5.0];
/// A discriminant that does not come this close to zero, in parts of its values at the ends, does not vanish.
const JUMP: f64 = 1e-6;

impl Spectra<'_> {
    /// Inserts the exceptional point between samples i - 1 and i, and points that draw near to it; how many.
    pub(super) fn exceptional(
        &self,
        samples: &mut Vec<Sample>,
        i: usize,
        ends: (Meeting, Meeting),
        counts: &mut Counts,
    ) -> Result<usize, Failure> {
        let (a, b) = (samples[i - 1].point.clone(), samples[i].point.clone());
        let Some((theta, mean)) = self.coalescence((&a, &b), ends, counts)? else { return Ok(0) };
        let left = GRADES.iter().rev().map(|g| (theta * (1.0 - g), false));
        let right = GRADES.iter().map(|g| (theta + (1.0 - theta) * g, false));
        let lambda = a.lambda + theta * (b.lambda - a.lambda);
        let known = |s: &Sample| {
            let near = (s.point.lambda - lambda).abs() <= 1e-6 * (b.lambda - a.lambda).abs();
            near && matches!(s.mark, Some(Mark::Exceptional(_)))
        };
        if samples.iter().any(known) {
            return Ok(0);
        }
        let places: Vec<(f64, bool)> = left.chain([(theta, true)]).chain(right).collect();
        let added: Result<Vec<Sample>, Failure> = places
            .par_iter()
            .map(|&(at, exact)| {
                let mut counts = Counts::default();
                let point = at_fraction(self.system, (&a, &b), at, &mut counts)?.point;
                let mut sample = Sample::new(point, exact.then_some(Mark::Exceptional(mean)));
                sample.values = self.at(&sample.point, &mut counts)?;
                Ok(sample)
            })
            .collect();
        samples.splice(i..i, added?);
        counts.spectra += places.len();
        Ok(places.len())
    }

    /// The fraction of the step from a to b at which two eigenvalues coalesce, known at both ends, and their mean there:
    /// the root of the discriminant, which is smooth (Illinois). None if it has the same sign at both ends.
    fn coalescence(
        &self,
        (a, b): (&Point, &Point),
        (start, end): (Meeting, Meeting),
        counts: &mut Counts,
    ) -> Result<Option<(f64, c64)>, Failure> {
        if start.discriminant * end.discriminant > 0.0 {
            return Ok(None);
        }
        let scale = start.discriminant.abs().max(end.discriminant.abs());
        // Where, the pair there, and the discriminant as the method weighs it.
        let (mut low, mut high) = ((0.0_f64, start, start.discriminant), (1.0_f64, end, end.discriminant));
        for _ in 0..60 {
            let theta = (low.0 * high.2 - high.0 * low.2) / (high.2 - low.2);
            let point = at_fraction(self.system, (a, b), theta, counts)?.point;
            let expected = low.1.towards(high.1, (theta - low.0) / (high.0 - low.0));
            let here = Meeting::nearest(&self.at(&point, counts)?, expected);
            if here.discriminant.abs() < 1e-10 * scale {
                return Ok(Some((theta, here.mean)));
            }
            if (high.0 - low.0).abs() < 1e-12 {
                break;
            }
            if here.discriminant * high.2 < 0.0 {
                low = high;
            } else {
                low.2 *= 0.5;
            }
            high = (theta, here, here.discriminant);
        }
        // A jump instead of a root: the two ends belong to different pairs.
        Ok((high.1.discriminant.abs() < JUMP * scale).then_some((high.0, high.1.mean)))
    }

    /// Where the exceptional point `sample` lies on another discretisation, `fine`, of the same system: secant steps
    /// on the discriminant along the step between the same neighbours' parameters, from where it lies on this one.
    pub fn exceptional_on(
        &self,
        fine: &Equilibria,
        (a, sample, b): (&Sample, &Sample, &Sample),
        settle: impl Fn(&Point) -> Option<Point>,
        mean: c64,
    ) -> Option<(f64, c64)> {
        let ends = (settle(&a.point)?, settle(&b.point)?);
        let mut counts = Counts::default();
        let mut look = |lambda: f64| {
            let point = at_lambda(fine, (&ends.0, &ends.1), lambda, None, &mut counts).ok()?.point;
            let values = self.looked_at(fine, &point.x, point.lambda).ok()?;
            Some(Meeting::nearest(&values, Meeting { mean, discriminant: 0.0 }))
        };
        let near = |s: &Sample| Meeting::nearest(&s.values, Meeting { mean, discriminant: 0.0 }).discriminant;
        let width = (b.point.lambda - a.point.lambda).abs();
        let slope = (near(b) - near(a)) / (b.point.lambda - a.point.lambda);
        let mut last = (sample.point.lambda, look(sample.point.lambda)?);
        let mut step = -last.1.discriminant / slope;
        for _ in 0..8 {
            let here = (last.0 + step, look(last.0 + step)?);
            let change = here.1.discriminant - last.1.discriminant;
            let next = -here.1.discriminant * (here.0 - last.0) / change;
            // Rounding in the eigenvalues ends the convergence, above any tolerance set in advance.
            if next.abs() >= 0.5 * step.abs() && step.abs() <= 1e-6 * width || next.abs() <= 1e-12 * width {
                return Some((here.0, here.1.mean));
            }
            (last, step) = (here, next);
        }
        None
    }
}

/// Two eigenvalues s1, s2 that may coalesce, by what is smooth where they do: both real or conjugate, or the upper
/// members of two pairs with one real part or one imaginary part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    /// (s1 + s2)/2: real for the former, with a positive imaginary part for the latter.
    mean: c64,
    /// ((s1 - s2)/2)², which is real: positive for eigenvalues side by side, negative for those one above the other.
    discriminant: f64,
}

/// Imaginary parts of the discriminant below this part of the eigenvalues' square are rounding.
const SYMMETRIC: f64 = 1e-10;

impl Meeting {
    pub(super) fn of(x: c64, y: c64) -> Self {
        let half = 0.5 * (x - y);
        let height = if x.im > 0.0 && y.im > 0.0 { 0.5 * (x.im + y.im) } else { 0.0 };
        let mean = c64::new(0.5 * (x.re + y.re), height);
        Self { mean, discriminant: half.re * half.re - half.im * half.im }
    }

    /// All of the eigenvalues that may coalesce off the real axis.
    fn pairs(values: &[c64]) -> Vec<Self> {
        let upper: Vec<c64> = values.iter().copied().filter(|z| z.im > 0.0).collect();
        let all = upper.iter().enumerate().flat_map(|(j, &x)| upper[..j].iter().map(move |&y| (x, y)));
        let symmetric = all.filter(|(x, y)| (0.5 * (x - y).re * (x - y).im).abs() <= SYMMETRIC * (x + y).norm_sqr());
        symmetric.map(|(x, y)| Self::of(x, y)).collect()
    }

    /// Two pairs that have met and left their line of symmetry.
    fn has_split(&self) -> bool {
        self.discriminant > SYMMETRIC * self.mean.norm_sqr()
    }

    /// Two pairs that meet somewhere between two spectra: on their line of symmetry in one, where they must be among the
    /// `leading` eigenvalues, and off it in the other, where one of them decays fastest of all.
    pub(super) fn of_pairs(a: &[c64], b: &[c64], leading: usize) -> Option<(Self, Self)> {
        let partner = |split: Self, values: &[c64]| {
            let before = Self::nearest(values, split);
            let among = Self::pairs(&values[..values.len().min(leading)]);
            among.into_iter().find(|m| before.discriminant < 0.0 && m.off(before) == 0.0)
        };
        let split = |values: &[c64]| Self::pairs(values).into_iter().filter(Self::has_split);
        let forwards = split(b).find_map(|end| Some((partner(end, a)?, end)));
        forwards.or_else(|| split(a).find_map(|start| Some((start, partner(start, b)?))))
    }

    /// The linear interpolant.
    fn towards(self, other: Self, theta: f64) -> Self {
        Self {
            mean: self.mean + theta * (other.mean - self.mean),
            discriminant: self.discriminant + theta * (other.discriminant - self.discriminant),
        }
    }

    /// A measure of how unlike two meetings are.
    fn off(self, other: Self) -> f64 {
        (self.mean - other.mean).norm_sqr() + (self.discriminant - other.discriminant).abs()
    }

    /// The two of all eigenvalues that are most like what is expected.
    fn nearest(values: &[c64], expected: Self) -> Self {
        let on_real_axis = |(x, y): (c64, c64)| (x.im + y.im).abs() <= 1e-9 * (x + y).norm();
        let candidates = if expected.mean.im > 0.0 {
            Self::pairs(values)
        } else {
            let all = values.iter().enumerate().flat_map(|(j, &x)| values[..j].iter().map(move |&y| (x, y)));
            all.filter(|&pair| on_real_axis(pair)).map(|(x, y)| Self::of(x, y)).collect()
        };
        let nearest = candidates.into_iter().min_by(|x, y| x.off(expected).total_cmp(&y.off(expected)));
        nearest.unwrap_or(expected)
    }
}
