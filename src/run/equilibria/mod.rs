//! A task of kind `equilibria`: the branch, user values, folds, eigenvalue branches, Hopf points, their errors.

mod walk;

use super::outcome::{Outcome, Status, labels};
use super::study::Prepared;
use super::watch::Watch;
use super::wave;
use crate::bifurcation::{Equilibria, Hopf, HopfNormalForm, Mark, Sample, Spectra, leading};
use crate::branch::{Array, Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use crate::continuation::{Border, Counts, Failure, Point, Stop, at_lambda, correct, crossing};
use crate::linalg::{c64, growth};
use crate::problem::{At, Problem};
use crate::scene;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::time::Instant;
use walk::{Walked, system, walk};

/// Runs the task; numerical trouble ends up in the outcome's status and reason.
pub fn run(prepared: &Prepared, name: &str, task: &scene::Equilibria, watch: &Watch) -> Outcome {
    let start = Instant::now();
    let along = &task.along;
    let branch = Branch {
        name: name.to_owned(),
        kind: BranchKind::Equilibria,
        free: vec![along.free.clone()],
        columns: Vec::new(),
        rows: Vec::new(),
        points: Vec::new(),
        triangles: Vec::new(),
    };
    let mut counts = Counts::default();
    let mut outcome = match follow(prepared, branch.clone(), task, watch, &mut counts) {
        Ok(outcome) => outcome,
        Err(failure) => Outcome::failed(branch, failure.to_string()),
    };
    outcome.seconds = start.elapsed().as_secs_f64();
    outcome.counts = counts;
    outcome
}

fn follow(
    prepared: &Prepared,
    mut branch: Branch,
    task: &scene::Equilibria,
    watch: &Watch,
    counts: &mut Counts,
) -> Result<Outcome, Failure> {
    let along = &task.along;
    let mut system = system(prepared, along);
    let Walked { points, back, stop } = walk(prepared, &mut system, task, watch, counts)?;
    let mut samples: Vec<Sample> = points.into_iter().map(|point| Sample::new(point, None)).collect();
    let mark = |stop: &Stop| Some(if matches!(stop, Stop::Stagnation { .. }) { Mark::Stuck } else { Mark::End });
    if let Some(last) = samples.last_mut() {
        last.mark = mark(&stop);
    }
    if let Some(first) = samples.first_mut() {
        first.mark = back.as_ref().map_or(Some(Mark::End), mark);
    }
    let stop = back.filter(|back| *back != Stop::RangeEnd).unwrap_or(stop);
    user_values(&system, &along.values, &mut samples, counts)?;
    if task.detect.iter().any(|kind| kind == "LP") {
        folds(&system, &mut samples, counts)?;
    }
    let hopf = task.detect.iter().any(|kind| kind == "HB");
    // Detection alone needs the eigenvalues that may cross, not columns for them.
    let wanted = if hopf { task.spectrum.max(4) } else { task.spectrum };
    let spectra = if wanted > 0 {
        let tool = Spectra::new(&system, wanted, &mut samples, counts)?;
        tool.follow(&mut samples, counts)?;
        if hopf {
            tool.hopf_points(&mut samples, counts)?;
        }
        if task.spectrum > 0 {
            tool.smooth(&mut samples, counts)?;
        }
        Some(tool)
    } else {
        None
    };
    rows(prepared, &system, task, &samples, &mut branch);
    let marked: Vec<(usize, &Sample, Kind)> = (samples.iter().enumerate())
        .filter_map(|(row, sample)| Some((row, sample, kind(sample.mark.as_ref()?))))
        .collect();
    for &(row, _, kind) in &marked {
        let (short, label) = labels(&branch, kind);
        branch.rows[row].label = Some(short);
        branch.points.push(SpecialPoint::new(label, kind, row));
    }
    branch.points.par_iter_mut().zip(&marked).for_each(|(point, &(row, sample, _))| {
        let drawn = branch.rows[row].label.as_ref().is_some_and(|short| prepared.waves.contains(short));
        describe(prepared, &system, sample, spectra.as_ref().filter(|_| drawn), point);
        if along.errors {
            let neighbours = (samples.get(row.wrapping_sub(1)), samples.get(row + 1));
            estimate(prepared, &system, sample, neighbours, spectra.as_ref(), point);
        }
        if drawn {
            wave::of_mode(prepared, point);
        }
    });
    let status = match stop {
        Stop::Interrupted => Status::Interrupted,
        Stop::Stagnation { .. } => Status::Failed,
        Stop::RangeEnd | Stop::Closed | Stop::MaxPoints => Status::Done,
    };
    Ok(Outcome { branch, status, reason: stop.to_string(), seconds: 0.0, counts: *counts })
}

/// Points where the free parameter or an observable takes a wanted value.
fn user_values(
    system: &Equilibria,
    values: &BTreeMap<String, Vec<f64>>,
    samples: &mut Vec<Sample>,
    counts: &mut Counts,
) -> Result<(), Failure> {
    for (name, wanted) in values {
        let observable = system.problem.observables().iter().position(|o| o.name == name);
        for &goal in wanted {
            let value = |point: &Point| match observable {
                None => point.lambda - system.coordinate.of(goal),
                Some(i) => observe(system, point, i) - goal,
            };
            let mut i = 0;
            while i < samples.len() {
                if value(&samples[i].point) == 0.0 {
                    samples[i].mark = Some(Mark::User);
                } else if i > 0 && value(&samples[i - 1].point) * value(&samples[i].point) < 0.0 {
                    let ends = (&samples[i - 1].point, &samples[i].point);
                    let point = match observable {
                        None => at_lambda(system, ends, system.coordinate.of(goal), counts)?.point,
                        Some(_) => crossing(system, ends, &value, counts)?,
                    };
                    samples.insert(i, Sample::new(point, Some(Mark::User)));
                    i += 1;
                }
                i += 1;
            }
        }
    }
    Ok(())
}

/// Folds: the tangent's parameter component changes sign.
fn folds(system: &Equilibria, samples: &mut Vec<Sample>, counts: &mut Counts) -> Result<(), Failure> {
    let mut i = 1;
    while i < samples.len() {
        let (a, b) = (&samples[i - 1].point, &samples[i].point);
        if a.tangent_lambda * b.tangent_lambda < 0.0 {
            let fold = crossing(system, (a, b), &|point: &Point| point.tangent_lambda, counts)?;
            samples.insert(i, Sample::new(fold, Some(Mark::Fold)));
            i += 1;
        }
        i += 1;
    }
    Ok(())
}

/// The name under which a mark is stored.
fn kind(mark: &Mark) -> Kind {
    match mark {
        Mark::End => Kind::EP,
        Mark::Stuck => Kind::MX,
        Mark::User => Kind::UZ,
        Mark::Fold => Kind::LP,
        Mark::Hopf(_) => Kind::HB,
        Mark::Exceptional(mean) if mean.im > 0.0 && growth(*mean) == 0.0 => Kind::KC,
        Mark::Exceptional(_) => Kind::XP,
    }
}

fn observe(system: &Equilibria, point: &Point, i: usize) -> f64 {
    let rest = vec![0.0; point.x.len()];
    let p = system.parameters(point.lambda);
    system.problem.observe(i, At { u: &point.x, v: &rest, p: &p })
}

fn rows(prepared: &Prepared, system: &Equilibria, task: &scene::Equilibria, samples: &[Sample], branch: &mut Branch) {
    let column = |name: &str, unit: &str| Column { name: name.to_owned(), unit: unit.to_owned() };
    let observables = prepared.problem.observables();
    branch.columns.push(column(&prepared.free_name, &prepared.free_unit));
    if system.coordinate.logarithmic {
        branch.columns.push(column(&format!("log10 {}", prepared.free_name), ""));
    }
    for &i in &prepared.observables {
        branch.columns.push(column(observables[i].name, observables[i].unit));
    }
    let shown = if task.spectrum > 0 { leading(samples, task.spectrum) } else { Vec::new() };
    let (rate, turn) = rates(prepared.problem.time_unit());
    for k in 1..=shown.len() {
        branch.columns.push(column(&format!("re_{k}"), &rate));
        branch.columns.push(column(&format!("im_{k}"), &turn));
    }
    for sample in samples {
        let lambda = sample.point.lambda;
        let mut values = vec![Some(system.coordinate.value(lambda))];
        values.extend(system.coordinate.logarithmic.then_some(Some(lambda)));
        values.extend(prepared.observables.iter().map(|&i| Some(observe(system, &sample.point, i))));
        for &k in &shown {
            values.extend([Some(sample.followed[k].re), Some(sample.followed[k].im)]);
        }
        let on_axis = matches!(sample.mark.as_ref().map(kind), Some(Kind::HB | Kind::KC));
        // Undamped oscillations do not grow.
        let bounded = |sigma: &c64| growth(*sigma) < 0.0 || growth(*sigma) == 0.0 && sigma.im != 0.0;
        let stable = sample.values.first().filter(|_| !on_axis).map(bounded);
        branch.rows.push(Row { label: None, stable, values });
    }
}

/// Units of growth rates and angular frequencies.
pub fn rates(time: &str) -> (String, String) {
    if time.is_empty() { (String::new(), "rad".to_owned()) } else { (format!("1/{time}"), format!("rad/{time}")) }
}

/// Fills in what is known of a special point; the mode only where it is drawn or belongs to a Hopf point.
fn describe(
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
    let vector = |data: Vec<f64>| Array { shape: vec![data.len()], data };
    arrays.insert("state".to_owned(), vector(sample.point.x.clone()));
    arrays.insert("parameters".to_owned(), vector(p));
    arrays.insert("tangent".to_owned(), vector(sample.point.tangent.clone()));
    let mode = match &sample.mark {
        Some(Mark::Hopf(found)) => {
            special.values.extend(of_hopf(&found.0, &found.1));
            arrays.insert("w_re".to_owned(), vector(found.0.w.iter().map(|z| z.re).collect()));
            arrays.insert("w_im".to_owned(), vector(found.0.w.iter().map(|z| z.im).collect()));
            Some(found.0.q.clone())
        }
        _ => modes.and_then(|tool| tool.mode(&sample.point)),
    };
    if let Some(q) = mode {
        arrays.insert("q_re".to_owned(), vector(q.iter().map(|z| z.re).collect()));
        arrays.insert("q_im".to_owned(), vector(q.iter().map(|z| z.im).collect()));
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
    if let Some(sigma) = leading {
        values.insert("growth".to_owned(), sigma.re);
        values.insert("omega".to_owned(), sigma.im.abs());
        values.insert("frequency".to_owned(), sigma.im.abs() / (2.0 * PI));
    }
    values
}

fn of_hopf(hopf: &Hopf, form: &HopfNormalForm) -> BTreeMap<String, f64> {
    [
        ("growth", 0.0),
        ("omega", hopf.omega),
        ("frequency", hopf.omega / (2.0 * PI)),
        ("lyapunov", form.l1),
        ("dsigma_re", hopf.slope.re),
        ("dsigma_im", hopf.slope.im),
    ]
    .into_iter()
    .map(|(name, value)| (name.to_owned(), value))
    .collect()
}

/// Errors: the same point on the refined discretisation; the difference is taken for the error of the present one.
fn estimate(
    prepared: &Prepared,
    system: &Equilibria,
    sample: &Sample,
    neighbours: (Option<&Sample>, Option<&Sample>),
    spectra: Option<&Spectra>,
    point: &mut SpecialPoint,
) {
    let Some(refined) = prepared.problem.refined() else { return };
    let fine = Equilibria { problem: refined.problem.clone(), ..system.clone() };
    let settle = |point: &Point| -> Option<Point> {
        let u = (refined.prolong)(&point.x);
        let border = Border { row: vec![0.0; u.len()], lambda: 1.0 };
        correct(&fine, (u, point.lambda), &border, &mut Counts::default()).ok().map(|c| c.point)
    };
    let coordinate = system.coordinate;
    let (free, values) = match &sample.mark {
        Some(Mark::Hopf(found)) => {
            let hopf = &found.0;
            let part = |f: fn(&c64) -> f64| (refined.prolong)(&hopf.q.iter().map(f).collect::<Vec<_>>());
            let q: Vec<c64> = part(|z| z.re).iter().zip(part(|z| z.im)).map(|(&re, im)| c64::new(re, im)).collect();
            let start = ((refined.prolong)(&hopf.u), hopf.p.clone());
            let problem = &*refined.problem;
            let located = Hopf::locate(problem, (&start.0, &start.1), system.coordinate.index, hopf.omega, &q);
            let Ok(located) = located else { return };
            let Ok(form) = HopfNormalForm::new(problem, &located) else { return };
            (Some(located.p[coordinate.index]), of_hopf(&located, &form))
        }
        Some(Mark::Exceptional(mean)) => {
            let (Some(a), Some(b), Some(tool)) = (neighbours.0, neighbours.1, spectra) else { return };
            let Some((lambda, mean)) = tool.exceptional_on(&fine, (a, sample, b), settle, *mean) else { return };
            let met = (mean.im > 0.0).then(|| measure(prepared, system, &sample.point, Some(mean)));
            (Some(coordinate.value(lambda)), met.unwrap_or_default())
        }
        _ => {
            let Some(settled) = settle(&sample.point) else { return };
            let leading = spectra.and_then(|tool| tool.leading(&fine, &settled));
            (None, measure(prepared, &fine, &settled, leading))
        }
    };
    // Where refinement moves a number by less than rounding does, rounding is its error.
    let rounding = match &sample.mark {
        Some(Mark::Hopf(found)) => found.0.rounding,
        _ => (0.0, 0.0),
    };
    if let Some(free) = free {
        let here = coordinate.value(sample.point.lambda);
        point.errors.insert(prepared.free_name.clone(), error(here, free).max(rounding.0));
    }
    for (name, &value) in &point.values {
        if let Some(&fine) = values.get(name).filter(|fine| **fine != 0.0 || value != 0.0) {
            let floor = match name.as_str() {
                "omega" => rounding.1,
                "frequency" => rounding.1 / (2.0 * PI),
                _ => 0.0,
            };
            point.errors.insert(name.clone(), error(value, fine).max(floor));
        }
    }
}

/// The difference, but not less than rounding.
pub fn error(value: f64, fine: f64) -> f64 {
    (value - fine).abs().max(4.0 * f64::EPSILON * value.abs())
}
