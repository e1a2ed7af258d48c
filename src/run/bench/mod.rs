//! `hopfline bench`: the error of a number against the seconds and the unknowns that it takes, over families of settings.

mod figure;
mod fit;
mod page;
mod report;
mod sample;
mod table;

pub use report::Report;

use super::files::Folder;
use super::watch::{Watch, interrupted};
use super::{RunError, RunOptions, ready};
use crate::scene::{Bench, Reference, Scene, Variant};
use report::{Coverage, FamilyLine, Found, Orders, QuantityLine, Reach, SettingLine};
use sample::{Numbers, Sample, once, task};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Where studies are looked for by their names.
const FOLDER: &str = "problems/bench";

/// The scenes of the studies named, by name or path; without names all that there are.
pub fn studies(names: &[String]) -> Result<Vec<PathBuf>, RunError> {
    let here = Path::new(FOLDER);
    let known = || {
        let mut found: Vec<PathBuf> =
            std::fs::read_dir(here).into_iter().flatten().flatten().map(|e| e.path()).collect();
        found.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
        found.sort();
        found
    };
    if names.is_empty() {
        let found = known();
        if found.is_empty() {
            return Err(RunError::Input(format!(
                "there is no study in {FOLDER}; give the path of a scene with [bench]"
            )));
        }
        return Ok(found);
    }
    let path = |name: &String| {
        let named = here.join(format!("{name}.toml"));
        let given = PathBuf::from(name);
        match (given.extension().is_some_and(|extension| extension == "toml"), named.exists()) {
            (true, _) => Ok(given),
            (false, true) => Ok(named),
            (false, false) => {
                let known: Vec<PathBuf> = known();
                let known = known.iter().filter_map(|path| path.file_stem()?.to_str());
                let fault = crate::scene::Fault::unknown("study", name, known);
                Err(RunError::Input(format!("{fault} (in {FOLDER}), or the path of a scene, FILE.toml")))
            }
        }
    };
    names.iter().map(path).collect()
}

/// Whether a scene is a study, and all its settings can be run.
pub fn check_study(scene: &Scene) -> Result<(), RunError> {
    let study = study(scene)?;
    let settings = study.families.iter().flat_map(|family| &family.variants);
    for variant in references(study).chain(settings) {
        ready(&variant.scene, &[task(variant)])?;
    }
    Ok(())
}

fn study(scene: &Scene) -> Result<&Bench, RunError> {
    scene.bench.as_ref().ok_or_else(|| {
        let path = scene.path.display();
        RunError::Input(format!("{path} is no study: it has no section [bench] (README: Work and precision)"))
    })
}

/// The settings that computed references need.
fn references(study: &Bench) -> impl Iterator<Item = &Variant> {
    study.quantities.iter().flat_map(|quantity| match &quantity.reference {
        Reference::Computed { set, check } => vec![&**set, &**check],
        Reference::Known { .. } => Vec::new(),
    })
}

/// Runs a study and writes `bench.json`, a figure for each number, and the log.
pub fn bench(scene: &Scene, options: &RunOptions) -> Result<Report, RunError> {
    let start = Instant::now();
    let study = study(scene)?;
    let folder = Folder::open(&options.out.join("bench"), &scene.name)?;
    let watch = Watch::new(options.quiet, None);
    watch.task(&scene.name);
    let total = references(study).count() + study.families.iter().map(|family| family.variants.len()).sum::<usize>();
    let mut progress = Progress { watch: &watch, done: 0.0, total: total as f64 };
    let quantities = quantities(study, &mut progress);
    let mut families = Vec::new();
    for family in &study.families {
        let mut line = FamilyLine::new(family);
        for variant in &family.variants {
            if interrupted() {
                break;
            }
            progress.step(&family.name, variant);
            let sample = Sample::timed(variant);
            // What was cut short says nothing of the setting.
            if interrupted() && sample.numbers.is_err() {
                break;
            }
            line.settings.push(setting(variant, &sample, &quantities));
        }
        for quantity in &quantities {
            line.conclude(quantity);
        }
        families.push(line);
    }
    let report = Report {
        bench: scene.name.clone(),
        title: scene.title.clone(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        machine: report::Machine::here(),
        seconds: start.elapsed().as_secs_f64(),
        interrupted: interrupted(),
        reach: quantities.iter().flat_map(|quantity| Reach::of(&quantity.name, &families)).collect(),
        quantities,
        families,
    };
    for (name, svg) in report.figures()? {
        folder.write_figure(&name, &svg)?;
    }
    folder.write_json("bench.json", &report)?;
    folder.write_log(&watch.finish())?;
    Ok(report)
}

/// How far the study is.
struct Progress<'a> {
    watch: &'a Watch,
    done: f64,
    total: f64,
}

impl Progress<'_> {
    fn step(&mut self, name: &str, variant: &Variant) {
        self.watch.at(self.done / self.total, format!("{name}: {}", report::named(&variant.changes)));
        self.done += 1.0;
    }
}

/// What the numbers should be; equal runs are done once.
fn quantities(study: &Bench, progress: &mut Progress) -> Vec<QuantityLine> {
    type Done<'a> = (&'a Variant, Result<Numbers, String>);
    let mut known: Vec<Done> = Vec::new();
    let mut lines = Vec::new();
    for quantity in &study.quantities {
        let name = quantity.name.clone();
        let mut number = |variant| -> Result<f64, String> {
            progress.step("reference", variant);
            let same = |done: &&Done<'_>| (&done.0.point, &done.0.changes) == (&variant.point, &variant.changes);
            if known.iter().find(same).is_none() {
                known.push((variant, once(variant).0));
            }
            let numbers = known.iter().find(same).map_or(Err(String::new()), |(_, numbers)| numbers.clone())?;
            numbers.values.get(&name).map(|(value, _)| *value).ok_or_else(|| format!("{} has no {name}", variant.point))
        };
        let (result, source) = match &quantity.reference {
            Reference::Known { value, error, source } => (Ok((*value, *error)), source.clone()),
            Reference::Computed { set, check } => {
                let source =
                    format!("{}; error: difference to {}", report::named(&set.changes), report::named(&check.changes));
                (number(set).and_then(|value| Ok((value, (value - number(check)?).abs()))), source)
            }
        };
        lines.push(QuantityLine::new(name, result, source));
    }
    lines
}

fn setting(variant: &Variant, sample: &Sample, quantities: &[QuantityLine]) -> SettingLine {
    let mut found = BTreeMap::new();
    if let Ok(numbers) = &sample.numbers {
        for quantity in quantities {
            if let (Some(&(value, printed)), Some(reference)) = (numbers.values.get(&quantity.name), quantity.value) {
                found.insert(quantity.name.clone(), Found::new(value, printed, (reference, quantity.error)));
            }
        }
    }
    SettingLine {
        setting: variant.changes.clone(),
        reason: sample.numbers.as_ref().err().cloned(),
        unknowns: sample.numbers.as_ref().ok().and_then(|numbers| numbers.unknowns),
        counts: sample.numbers.as_ref().map(|numbers| numbers.counts).unwrap_or_default(),
        seconds: report::Seconds::of(&sample.taken),
        found,
    }
}

impl FamilyLine {
    /// Orders and coverage of a number over all settings.
    fn conclude(&mut self, quantity: &QuantityLine) {
        let name = &quantity.name;
        let rows = self.settings.iter().filter_map(|line| Some((line, line.found.get(name)?)));
        let (mut against_unknowns, mut against_seconds) = (Vec::new(), Vec::new());
        let floor = quantity.relative_error();
        for (line, found) in fit::falling(rows.clone().collect(), floor) {
            against_seconds.push((line.seconds.median, found.error));
            against_unknowns.extend(line.unknowns.map(|unknowns| (unknowns as f64, found.error)));
        }
        let orders = Orders { unknowns: fit::power(&against_unknowns), seconds: fit::power(&against_seconds) };
        self.orders.insert(name.clone(), orders);
        self.coverage.insert(name.clone(), Coverage::of(rows.map(|(_, found)| found)));
    }
}
