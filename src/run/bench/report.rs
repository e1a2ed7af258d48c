//! `bench.json`: what a study found.

use super::super::RunError;
use super::fit::Power;
use super::sample::Taken;
use crate::continuation::Counts;
use crate::scene::Family;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Report {
    pub bench: String,
    pub title: String,
    pub version: String,
    pub machine: Machine,
    pub seconds: f64,
    pub interrupted: bool,
    pub quantities: Vec<QuantityLine>,
    pub families: Vec<FamilyLine>,
    pub reach: Vec<Reach>,
}

/// What the times were measured on.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Machine {
    pub processor: String,
    pub cores: usize,
    pub threads: usize,
}

/// A number and what it should be.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct QuantityLine {
    pub name: String,
    /// None if it could not be computed; `source` says why.
    pub value: Option<f64>,
    /// By how much that may be wrong.
    pub error: f64,
    pub source: String,
}

#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct FamilyLine {
    pub name: String,
    pub point: String,
    pub settings: Vec<SettingLine>,
    /// By quantity.
    pub orders: BTreeMap<String, Orders>,
    pub coverage: BTreeMap<String, Coverage>,
}

/// How errors fall with the unknowns and with the seconds.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq)]
pub struct Orders {
    pub unknowns: Option<Power>,
    pub seconds: Option<Power>,
}

#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct SettingLine {
    pub setting: Vec<(String, String)>,
    /// Why there are no numbers, if there are none.
    pub reason: Option<String>,
    pub unknowns: Option<usize>,
    pub seconds: Seconds,
    pub counts: Counts,
    /// By quantity.
    pub found: BTreeMap<String, Found>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq)]
pub struct Seconds {
    pub median: f64,
    pub least: f64,
    pub most: f64,
    /// Median of the processor's seconds, on all threads: what other programs take does not count.
    pub processor: Option<f64>,
    pub runs: usize,
}

/// A number, its true error and the printed one: relative to what it should be, absolute where that is zero.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq)]
pub struct Found {
    pub value: f64,
    pub error: f64,
    pub printed: Option<f64>,
    /// Printed over true error.
    pub ratio: Option<f64>,
    /// Whether the printed error is at least the true one; None where the reference's own error leaves that open.
    pub covered: Option<bool>,
}

/// How many printed errors are at least as large as the true ones.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, PartialEq)]
pub struct Coverage {
    pub covered: usize,
    /// Numbers with a printed error of which it can be said.
    pub cases: usize,
    pub undecided: usize,
}

/// The fewest seconds in which each family has an error no larger than this, in that setting and all finer ones.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Reach {
    pub quantity: String,
    pub error: f64,
    pub seconds: BTreeMap<String, f64>,
}

impl Machine {
    pub fn here() -> Self {
        use sysinfo::{CpuRefreshKind, RefreshKind, System};
        let system = System::new_with_specifics(RefreshKind::nothing().with_cpu(CpuRefreshKind::nothing()));
        let brand = system.cpus().first().map_or("", |cpu| cpu.brand()).trim();
        let processor = if brand.is_empty() { format!("unnamed {}", std::env::consts::ARCH) } else { brand.to_owned() };
        Self { processor, cores: system.cpus().len(), threads: rayon::current_num_threads() }
    }
}

impl QuantityLine {
    pub fn new(name: String, result: Result<(f64, f64), String>, source: String) -> Self {
        match result {
            // No number is known better than to rounding.
            Ok((value, error)) => {
                Self { name, value: Some(value), error: error.max(f64::EPSILON * value.abs()), source }
            }
            Err(reason) => Self { name, value: None, error: 0.0, source: format!("{source}: {reason}") },
        }
    }

    pub fn relative_error(&self) -> f64 {
        self.error / scale(self.value.unwrap_or(0.0))
    }
}

impl FamilyLine {
    pub fn new(family: &Family) -> Self {
        let point = family.variants.first().map_or(String::new(), |variant| variant.point.clone());
        let (settings, orders, coverage) = Default::default();
        Self { name: family.name.clone(), point, settings, orders, coverage }
    }
}

impl Seconds {
    pub fn of(runs: &[Taken]) -> Self {
        let walls: Vec<f64> = runs.iter().map(|run| run.wall).collect();
        let processor: Option<Vec<f64>> = runs.iter().map(|run| run.processor).collect();
        let extreme = |pick: fn(f64, f64) -> f64| walls.iter().copied().reduce(pick).unwrap_or(f64::NAN);
        let (least, most) = (extreme(f64::min), extreme(f64::max));
        Self { median: median(&walls), least, most, processor: processor.as_deref().map(median), runs: runs.len() }
    }
}

impl Found {
    pub fn new(value: f64, printed: Option<f64>, (reference, uncertain): (f64, f64)) -> Self {
        let scale = scale(reference);
        let (error, uncertain, printed) =
            ((value - reference).abs() / scale, uncertain / scale, printed.map(|p| p / scale));
        let covered = printed.and_then(|printed| {
            let (surely, surely_not) = (printed >= error + uncertain, printed < error - uncertain);
            (surely || surely_not).then_some(surely)
        });
        let ratio = printed.filter(|_| error > 0.0).map(|printed| printed / error);
        Self { value, error, printed, ratio, covered }
    }
}

impl Coverage {
    pub fn of<'a>(found: impl Iterator<Item = &'a Found>) -> Self {
        let mut coverage = Self::default();
        for found in found.filter(|found| found.printed.is_some()) {
            match found.covered {
                Some(covered) => {
                    coverage.cases += 1;
                    coverage.covered += usize::from(covered);
                }
                None => coverage.undecided += 1,
            }
        }
        coverage
    }

    pub fn percent(&self) -> f64 {
        100.0 * self.covered as f64 / self.cases as f64
    }
}

impl std::ops::AddAssign for Coverage {
    fn add_assign(&mut self, other: Self) {
        self.covered += other.covered;
        self.cases += other.cases;
        self.undecided += other.undecided;
    }
}

impl Reach {
    /// For errors of 1e-1, 1e-2, ... as far as any family gets.
    pub fn of(quantity: &str, families: &[FamilyLine]) -> Vec<Self> {
        let at = |decade: i32| {
            let error = 10f64.powi(-decade);
            let seconds: BTreeMap<String, f64> = families
                .iter()
                .filter_map(|family| Some((family.name.clone(), family.reaches(quantity, error)?)))
                .collect();
            Self { quantity: quantity.to_owned(), error, seconds }
        };
        (1..=16).map(at).filter(|reach| !reach.seconds.is_empty()).collect()
    }
}

impl FamilyLine {
    fn reaches(&self, quantity: &str, error: f64) -> Option<f64> {
        let rows = self.settings.iter().rev().filter_map(|line| Some((line.seconds.median, line.found.get(quantity)?)));
        rows.take_while(|(_, found)| found.error <= error).map(|(seconds, _)| seconds).reduce(f64::min)
    }
}

impl Report {
    /// Whether all was run, and each number and each family has something to show.
    pub fn success(&self) -> bool {
        let shows = |family: &FamilyLine| family.settings.iter().any(|line| !line.found.is_empty());
        !self.interrupted && self.quantities.iter().all(|q| q.value.is_some()) && self.families.iter().all(shows)
    }

    /// Of all numbers of all settings.
    pub fn coverage(&self) -> Coverage {
        let mut all = Coverage::default();
        self.families.iter().flat_map(|family| family.coverage.values()).for_each(|coverage| all += *coverage);
        all
    }

    /// The report of a study in its folder; None if there is none.
    pub fn read(folder: &Path) -> Result<Option<Self>, RunError> {
        let path = folder.join("bench.json");
        let Ok(text) = std::fs::read(&path) else { return Ok(None) };
        let report = serde_json::from_slice(&text);
        report.map(Some).map_err(|e| RunError::Input(format!("{} is not the report of a study: {e}", path.display())))
    }

    /// Figures by their names.
    pub fn figures(&self) -> Result<Vec<(String, String)>, RunError> {
        let drawn = self.quantities.iter().filter(|quantity| quantity.value.is_some());
        drawn.map(|quantity| super::figure::draw(self, quantity)).filter_map(Result::transpose).collect()
    }
}

/// NaN without values.
fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |k: usize| sorted.get(k).copied().unwrap_or(f64::NAN);
    0.5 * (at(sorted.len().saturating_sub(1) / 2) + at(sorted.len() / 2))
}

/// What errors are relative to.
pub fn scale(value: f64) -> f64 {
    if value == 0.0 { 1.0 } else { value.abs() }
}

/// "functions = 8, degree = 4": changes by the last parts of their keys.
pub fn named(changes: &[(String, String)]) -> String {
    const MOST: usize = 40;
    let one = |(key, value): &(String, String)| {
        let short: String = value.chars().take(MOST).collect();
        let dots = if short.len() < value.len() { "..." } else { "" };
        format!("{} = {short}{dots}", key.rsplit('.').next().unwrap_or(key))
    };
    changes.iter().map(one).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_errors_are_judged_as_far_as_the_reference_allows() {
        // True error 0.1, known to 0.02.
        let judged = |printed| Found::new(2.2, Some(printed), (2.0, 0.04)).covered;
        assert_eq!([0.26, 0.23, 0.2, 0.17, 0.15].map(judged), [Some(true), None, None, None, Some(false)]);
        let exact = Found::new(2.2, Some(0.2), (2.0, 0.0));
        assert!((exact.error - 0.1).abs() < 1e-15 && (exact.ratio.unwrap() - 1.0).abs() < 1e-12);
        // Where the number should be zero, errors are absolute; without a printed one there is nothing to judge.
        let zero = Found::new(0.3, None, (0.0, 0.0));
        assert_eq!((zero.error, zero.covered, zero.ratio), (0.3, None, None));
        let all = [Found::new(1.0, Some(0.0), (1.0, 0.0)), Found::new(2.2, Some(0.2), (2.0, 0.04)), zero];
        assert_eq!(Coverage::of(all.iter()), Coverage { covered: 1, cases: 1, undecided: 1 });
    }

    #[test]
    fn medians_are_of_the_middle() {
        let taken =
            |walls: &[f64]| walls.iter().map(|&wall| Taken { wall, processor: Some(2.0 * wall) }).collect::<Vec<_>>();
        let of = |walls: &[f64]| Seconds::of(&taken(walls));
        assert_eq!(of(&[3.0, 1.0, 9.0]), Seconds { median: 3.0, least: 1.0, most: 9.0, processor: Some(6.0), runs: 3 });
        assert_eq!(of(&[4.0, 2.0]).median, 3.0);
    }
}
