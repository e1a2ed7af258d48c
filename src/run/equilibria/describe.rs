//! What is stored of a special point: values, arrays, errors.

use super::super::study::Prepared;
use crate::bifurcation::{BranchPoint, Equilibria, Fold, Hopf, HopfNormalForm, Mark, Sample, Spectra, Tangent, scales};
use crate::branch::{Array, SpecialPoint};
use crate::continuation::{Border, Counts, Point, correct};
use crate::linalg::{c64, growth};
use crate::problem::{At, Problem, Refinement};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Value of observable i.
pub fn observe(system: &Equilibria, point: &Point, i: usize) -> f64 {
    let rest = vec![0.0; point.x.len()];
    let p = system.parameters(point.lambda);
    system.problem.observe(i, At { u: &point.x, v: &rest, p: &p })
}

/// Fills in what is known of a special point; the mode only where it is drawn or belongs to a Hopf point.
pub fn describe(
    prepared: &Prepared,
    system: &Equilibria,
    sample: &Sample,
    modes: Option<&Spectra>,
    special: &mut SpecialPoint,
) {
    let p = prepared.problem.resolve(&system.parameters(sample.point.lambda));
    let names = prepared.problem.parameters().iter();
    special.parameters = names.zip(&p).map(|(q, &x)| (q.name.to_owned(), x)).collect();
    special.values = measure(prepared, system, &sample.point, known(sample));
    let arrays = &mut special.arrays;
    arrays.insert("state".to_owned(), Array::vector(sample.point.x.clone()));
    arrays.insert("parameters".to_owned(), Array::vector(p));
    arrays.insert("tangent".to_owned(), Array::vector(sample.point.tangent.clone()));
    arrays.insert("scale".to_owned(), Array::vector(vec![system.scale_state]));
    let mode = match &sample.mark {
        Some(Mark::Hopf(found)) => {
            special.values.extend(of_hopf(&found.0, &found.1));
            arrays.insert("w_re".to_owned(), Array::vector(found.0.w.iter().map(|z| z.re).collect()));
            arrays.insert("w_im".to_owned(), Array::vector(found.0.w.iter().map(|z| z.im).collect()));
            Some(found.0.q.clone())
        }
        _ => modes.and_then(|tool| tool.mode(&sample.point)),
    };
    match &sample.mark {
        Some(Mark::Fold(Some(fold))) => {
            special.values.extend(of_fold(fold));
            arrays.insert("kernel".to_owned(), Array::vector(fold.q.clone()));
        }
        Some(Mark::Branch(found)) => {
            special.values.extend(of_branch_point(found));
            arrays.insert("kernel".to_owned(), Array::vector(found.form.q.clone()));
            arrays.insert("free".to_owned(), Array::vector(vec![system.coordinate.index as f64]));
            arrays.insert("other_tangent".to_owned(), Array::vector([&found.across.u[..], &[found.across.p]].concat()));
        }
        _ => {}
    }
    if let Some(q) = mode {
        arrays.insert("q_re".to_owned(), Array::vector(q.iter().map(|z| z.re).collect()));
        arrays.insert("q_im".to_owned(), Array::vector(q.iter().map(|z| z.im).collect()));
    }
}

/// The leading eigenvalue, or that of two pairs that meet, which rounding splits.
fn known(sample: &Sample) -> Option<c64> {
    match sample.mark {
        Some(Mark::Exceptional(mean)) if mean.im > 0.0 => Some(c64::new(growth(mean), mean.im)),
        _ => sample.values.first().copied(),
    }
}

/// Observables, and growth and frequency of the leading eigenvalue.
fn measure(prepared: &Prepared, system: &Equilibria, point: &Point, leading: Option<c64>) -> BTreeMap<String, f64> {
    let list = system.problem.observables();
    let mut values: BTreeMap<String, f64> =
        prepared.observables.iter().map(|&i| (list[i].name.to_owned(), observe(system, point, i))).collect();
    values.retain(|_, value| value.is_finite());
    if let Some(sigma) = leading {
        values.insert("growth".to_owned(), sigma.re);
        values.insert("omega".to_owned(), sigma.im.abs());
        values.insert("frequency".to_owned(), sigma.im.abs() / (2.0 * PI));
    }
    values
}

/// Finite numbers with their names.
fn named<const N: usize>(list: [(&str, f64); N]) -> BTreeMap<String, f64> {
    list.into_iter().filter(|(_, value)| value.is_finite()).map(|(name, value)| (name.to_owned(), value)).collect()
}

fn of_fold(fold: &Fold) -> BTreeMap<String, f64> {
    named([("lp_a", fold.a), ("lp_b", fold.b)])
}

fn of_branch_point(point: &BranchPoint) -> BTreeMap<String, f64> {
    let form = &point.form;
    named([("bp_b", form.b), if form.pitchfork() { ("bp_d", form.d) } else { ("bp_c", form.c) }])
}

fn of_hopf(hopf: &Hopf, form: &HopfNormalForm) -> BTreeMap<String, f64> {
    named([
        ("growth", 0.0),
        ("omega", hopf.omega),
        ("frequency", hopf.omega / (2.0 * PI)),
        ("lyapunov", form.l1),
        ("dsigma_re", hopf.slope.re),
        ("dsigma_im", hopf.slope.im),
        ("condition", hopf.condition),
    ])
}

/// Errors: the same point on the refined discretisation; twice the difference is taken for the error of the present one.
/// Without a refinement the equations are what they are, and rounding is what is left. Where the refined discretisation has
/// no such point, nothing is known of it: its error is as large as the number, and the answer is false.
pub fn estimate(
    prepared: &Prepared,
    system: &Equilibria,
    sample: &Sample,
    neighbours: (Option<&Sample>, Option<&Sample>),
    spectra: Option<&Spectra>,
    point: &mut SpecialPoint,
) -> bool {
    let free = &prepared.free_name;
    for (name, step) in rounding(sample, free) {
        let value = point.parameters.get(&name).or(point.values.get(&name)).copied().unwrap_or(0.0);
        point.errors.extend(error(value, value).map(|least| (name, least.max(SCATTER * step))));
    }
    let Some(refined) = prepared.problem.refined() else { return true };
    let Some((lambda, fine)) = finer(prepared, system, &refined, (sample, neighbours), spectra) else {
        point.errors.extend(point.values.iter().map(|(name, value)| (name.clone(), value.abs())));
        let here = system.coordinate.value(sample.point.lambda);
        let located =
            matches!(sample.mark, Some(Mark::Hopf(_) | Mark::Fold(_) | Mark::Branch(_) | Mark::Exceptional(_)));
        if located {
            point.errors.insert(free.clone(), here.abs());
        }
        return !located;
    };
    let here = system.coordinate.value(sample.point.lambda);
    let moved = lambda.and_then(|lambda| Some((free.clone(), error(here, lambda)?)));
    let compared = point.values.iter().filter_map(|(name, &value)| {
        let fine = fine.get(name).filter(|fine| **fine != 0.0 || value != 0.0)?;
        Some((name.clone(), error(value, *fine)?))
    });
    let compared: Vec<(String, f64)> = compared.chain(moved).collect();
    for (name, error) in compared {
        // Where refinement moves a number by less than rounding does, rounding is its error.
        let known = point.errors.entry(name).or_insert(0.0);
        *known = known.max(error);
    }
    // Rounding moves an eigenvalue in any direction, not along one axis.
    if let (None, Some(&growth), Some(&omega)) = (lambda, point.errors.get("growth"), point.errors.get("omega")) {
        let moved = growth.max(omega);
        let all = [("growth", moved), ("omega", moved), ("frequency", moved / (2.0 * PI))];
        point.errors.extend(all.map(|(name, error)| (name.to_owned(), error)));
    }
    true
}

/// The last Newton steps of what was solved for, by the numbers' names.
fn rounding(sample: &Sample, free: &str) -> Vec<(String, f64)> {
    let parameter = |step: f64| vec![(free.to_owned(), step)];
    match &sample.mark {
        Some(Mark::Hopf(found)) => {
            let (p, omega) = found.0.rounding;
            let turns =
                [("omega", omega), ("frequency", omega / (2.0 * PI))].map(|(name, step)| (name.to_owned(), step));
            [parameter(p), turns.to_vec()].concat()
        }
        Some(Mark::Fold(Some(fold))) => parameter(fold.rounding),
        Some(Mark::Branch(found)) => parameter(found.rounding),
        _ => Vec::new(),
    }
}

/// The same point on a finer discretisation: the free parameter where it is solved for, and its numbers.
fn finer(
    prepared: &Prepared,
    system: &Equilibria,
    refined: &Refinement,
    (sample, neighbours): (&Sample, (Option<&Sample>, Option<&Sample>)),
    spectra: Option<&Spectra>,
) -> Option<(Option<f64>, BTreeMap<String, f64>)> {
    let fine = Equilibria { problem: refined.problem.clone(), ..system.clone() };
    let settle = |point: &Point| -> Option<Point> {
        let u = (refined.prolong)(&point.x);
        let border = Border { row: vec![0.0; u.len()], lambda: 1.0 };
        correct(&fine, (u, point.lambda), &border, &mut Counts::default()).ok().map(|c| c.point)
    };
    let coordinate = system.coordinate;
    Some(match &sample.mark {
        Some(Mark::Hopf(found)) => {
            let hopf = &found.0;
            let part = |f: fn(&c64) -> f64| (refined.prolong)(&hopf.q.iter().map(f).collect::<Vec<_>>());
            let q: Vec<c64> = part(|z| z.re).iter().zip(part(|z| z.im)).map(|(&re, im)| c64::new(re, im)).collect();
            let start = ((refined.prolong)(&hopf.u), hopf.p.clone());
            let problem = &*refined.problem;
            let located = Hopf::locate(problem, (&start.0, &start.1), system.coordinate.index, hopf.omega, &q);
            let located = located.ok()?;
            let form = HopfNormalForm::new(problem, &located).ok()?;
            (Some(located.p[coordinate.index]), of_hopf(&located, &form))
        }
        Some(Mark::Exceptional(mean)) => {
            let (a, b, tool) = (neighbours.0?, neighbours.1?, spectra?);
            let (lambda, mean) = tool.exceptional_on(&fine, (a, sample, b), settle, *mean)?;
            let met = (mean.im > 0.0).then(|| measure(prepared, system, &sample.point, Some(mean)));
            (Some(coordinate.value(lambda)), met.unwrap_or_default())
        }
        Some(Mark::Fold(Some(fold))) => {
            let start = (&(refined.prolong)(&fold.u)[..], &fold.p[..]);
            let q = (refined.prolong)(&fold.q);
            let place = (coordinate.index, scales(&fine, sample.point.lambda).parameter);
            let located = Fold::locate(&*refined.problem, start, place, &q).ok()?;
            (Some(located.p[coordinate.index]), of_fold(&located))
        }
        Some(Mark::Branch(found)) => {
            let start = (&(refined.prolong)(&found.u)[..], &found.p[..]);
            let along = Tangent { u: (refined.prolong)(&found.along.u), p: found.along.p };
            let place = (coordinate.index, scales(&fine, sample.point.lambda));
            let located = BranchPoint::locate(&*refined.problem, start, place, &along).ok()?;
            (Some(located.p[coordinate.index]), of_branch_point(&located))
        }
        _ => {
            let settled = settle(&sample.point)?;
            let leading = spectra.and_then(|tool| tool.leading(&fine, &settled));
            (None, measure(prepared, &fine, &settled, leading))
        }
    })
}

/// What is missing beyond the refined discretisation is covered by this factor (spectral methods lack a sixth of the
/// difference, measured).
const SAFETY: f64 = 2.0;
/// A last Newton step is one sample of what rounding does, the error another: of two samples of one normal distribution
/// one exceeds ten times the other in 6 of 100 cases; less often where the larger of two steps is known.
pub const SCATTER: f64 = 10.0;

/// Twice the difference, but not less than rounding; None where one of the two does not exist.
pub fn error(value: f64, fine: f64) -> Option<f64> {
    let moved = SAFETY * (value - fine).abs();
    moved.is_finite().then(|| moved.max(4.0 * f64::EPSILON * value.abs()))
}

#[cfg(test)]
mod tests {
    use super::error;

    #[test]
    fn what_does_not_exist_has_no_error() {
        assert_eq!(error(1.0, 1.5), Some(1.0));
        assert_eq!(error(3.0, 3.0), Some(12.0 * f64::EPSILON));
        for (value, fine) in [(1.0, f64::NAN), (f64::NAN, 1.0), (1.0, f64::INFINITY)] {
            assert_eq!(error(value, fine), None);
        }
    }
}
