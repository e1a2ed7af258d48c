//! `summary.json`, and the table that a run prints.

use super::RunError;
use super::outcome::{Outcome, Status};
use crate::branch::{BranchKind, Kind};
use crate::continuation::Counts;
use crate::plot::Spec;
use crate::scene::{Scene, owner};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Summary {
    pub scene: String,
    pub title: String,
    pub version: String,
    pub seconds: f64,
    pub tasks: Vec<TaskLine>,
    pub points: Vec<PointLine>,
    pub branches: Vec<BranchLine>,
    pub figures: Vec<Spec>,
    pub expect: Vec<Expected>,
}

#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct TaskLine {
    pub name: String,
    pub kind: BranchKind,
    pub status: Status,
    pub reason: String,
    /// Whether the task ended as the scene expects: done, or for the reason that it names.
    pub as_expected: bool,
    pub seconds: f64,
    pub points: usize,
    pub counts: Counts,
}

#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct PointLine {
    pub label: String,
    pub kind: Kind,
    /// Row of the branch that holds this point.
    pub row: usize,
    pub parameters: BTreeMap<String, f64>,
    pub values: BTreeMap<String, f64>,
    pub errors: BTreeMap<String, f64>,
}

#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct BranchLine {
    pub name: String,
    pub kind: BranchKind,
    pub file: String,
    pub rows: usize,
    pub free: Vec<String>,
    pub columns: Vec<String>,
}

/// An expectation and whether it was met; `value` is None where the point or quantity was not found.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Expected {
    pub key: String,
    pub value: Option<f64>,
    pub expected: f64,
    pub tolerance: f64,
    pub met: bool,
    /// What was printed as the number's error.
    pub error: Option<f64>,
}

impl Expected {
    /// What errors are relative to.
    pub fn scale(&self) -> f64 {
        if self.expected == 0.0 { 1.0 } else { self.expected.abs() }
    }

    /// How far the number is off, relatively unless zero is expected.
    pub fn distance(&self) -> Option<f64> {
        self.value.map(|value| (value - self.expected).abs() / self.scale())
    }

    /// Whether the number is within its printed error, or off by no more than the rounding of a few operations.
    pub fn right(&self) -> bool {
        let rounding = 4.0 * f64::EPSILON * self.expected.abs();
        let allowed = self.error.unwrap_or(0.0).max(rounding);
        self.value.is_some_and(|value| (value - self.expected).abs() <= allowed)
    }
}

impl Summary {
    pub fn new(scene: &Scene, outcomes: &[Outcome], figures: Vec<Spec>, seconds: f64) -> Self {
        let task = |outcome: &Outcome| TaskLine {
            name: outcome.branch.name.clone(),
            kind: outcome.branch.kind,
            status: outcome.status,
            reason: outcome.reason.clone(),
            as_expected: match scene.ends.get(&outcome.branch.name).filter(|_| !scene.overridden) {
                Some(reason) => outcome.reason.contains(reason.as_str()),
                None => outcome.status == Status::Done,
            },
            seconds: outcome.seconds,
            points: outcome.branch.rows.len(),
            counts: outcome.counts,
        };
        let branch = |outcome: &Outcome| BranchLine {
            name: outcome.branch.name.clone(),
            kind: outcome.branch.kind,
            file: format!("branches/{}.csv", outcome.branch.name),
            rows: outcome.branch.rows.len(),
            free: outcome.branch.free.clone(),
            columns: outcome.branch.columns.iter().map(|c| c.name.clone()).collect(),
        };
        let points: Vec<PointLine> = outcomes
            .iter()
            .flat_map(|outcome| &outcome.branch.points)
            .map(|point| PointLine {
                label: point.label.clone(),
                kind: point.kind,
                row: point.row,
                parameters: point.parameters.clone(),
                values: point.values.clone(),
                errors: point.errors.clone(),
            })
            .collect();
        // A branch that a diagram did not find belongs to a task that was run.
        let name = |label: &str| owner(&scene.tasks, label).map(|task| &task.name);
        let run: Vec<_> = outcomes.iter().filter_map(|outcome| name(&outcome.branch.name)).collect();
        let ran = |label: &str| name(label).is_some_and(|name| run.contains(&name));
        // Expectations hold for the scene as written.
        let checked = scene.expect.iter().filter(|e| !scene.overridden && ran(&e.label));
        let expect = checked
            .map(|e| {
                let point = points.iter().find(|p| p.label == e.label);
                let value = point.and_then(|p| p.parameters.get(&e.quantity).or(p.values.get(&e.quantity)).copied());
                let scale = if e.value == 0.0 { 1.0 } else { e.value.abs() };
                let met = value.is_some_and(|v| (v - e.value).abs() <= e.tolerance * scale);
                let key = format!("{}.{}", e.label, e.quantity);
                let error = point.and_then(|p| p.errors.get(&e.quantity).copied());
                Expected { key, value, expected: e.value, tolerance: e.tolerance, met, error }
            })
            .collect();
        Self {
            scene: scene.name.clone(),
            title: scene.title.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            seconds,
            tasks: outcomes.iter().map(task).collect(),
            points,
            branches: outcomes.iter().filter(|o| !o.branch.rows.is_empty()).map(branch).collect(),
            figures,
            expect,
        }
    }

    /// The summary in the folder of a finished run.
    pub fn load(folder: &Path) -> Result<Self, RunError> {
        let path = folder.join("summary.json");
        let text = std::fs::read(&path).map_err(|e| {
            RunError::Input(format!(
                "cannot read {}: {e}; give the folder of a finished run, such as output/SCENE",
                path.display()
            ))
        })?;
        serde_json::from_slice(&text)
            .map_err(|e| RunError::Input(format!("{} is not the summary of a run: {e}", path.display())))
    }

    /// Whether every task ended as expected and every expectation was met.
    pub fn success(&self) -> bool {
        self.tasks.iter().all(|task| task.as_expected) && self.expect.iter().all(|e| e.met)
    }

    /// What the run found, for people.
    pub fn table(&self, folder: &str) -> String {
        let mut out = String::new();
        let _ = writeln!(out, "{}", if self.title.is_empty() { &self.scene } else { &self.title });
        for task in &self.tasks {
            let status = match task.status {
                Status::Done => "done",
                Status::Interrupted => "interrupted",
                Status::Failed if task.as_expected => "stopped as expected",
                Status::Failed => "FAILED",
            };
            let done = [(task.counts.factorisations, "factorisations"), (task.counts.spectra, "spectra")];
            let done = done.into_iter().filter(|(count, _)| *count > 0);
            let work: String = done.map(|(count, what)| format!(", {count} {what}")).collect();
            let _ = writeln!(
                out,
                "\n{}: {status} ({}), {} points, {:.2} s{work}",
                task.name, task.reason, task.points, task.seconds
            );
            let free = self.branches.iter().find(|b| b.name == task.name).map_or(Vec::new(), |b| b.free.clone());
            for point in self.points.iter().filter(|p| p.label.starts_with(&format!("{}/", task.name))) {
                self.point_lines(&mut out, point, &free);
            }
        }
        if !self.expect.is_empty() {
            let _ = writeln!(out, "\nexpected numbers");
        }
        for e in &self.expect {
            let verdict = if e.met { "met" } else { "MISSED" };
            let found = e.value.map_or("not found".to_owned(), |v| format!("{v}"));
            let _ =
                writeln!(out, "  {verdict:7} {:32} {found} (expected {} to {:.0e})", e.key, e.expected, e.tolerance);
        }
        let _ = writeln!(out, "\n{:.2} s; data and figures in {folder}", self.seconds);
        out
    }

    fn point_lines(&self, out: &mut String, point: &PointLine, free: &[String]) {
        let shown = free.iter().map(|name| {
            // Motions run in time, which is no parameter.
            let value = point.parameters.get(name).or(point.values.get(name)).copied().unwrap_or(f64::NAN);
            format!("{name} = {}", with_error(value, point.errors.get(name)))
        });
        let _ = write!(out, "  {:16} {}", point.label, shown.collect::<Vec<_>>().join(", "));
        for (name, value) in &point.values {
            let shown = free.contains(name);
            if shown || name.starts_with("mu_") || name == "growth" && point.kind == Kind::HB {
                continue;
            }
            let _ = write!(out, ", {name} = {}", with_error(*value, point.errors.get(name)));
        }
        match (point.values.get("bp_c"), point.values.get("bp_d")) {
            (Some(_), _) => out.push_str(": transcritical"),
            (_, Some(d)) => {
                out.push_str(if *d < 0.0 { ": pitchfork, supercritical" } else { ": pitchfork, subcritical" })
            }
            _ => {}
        }
        if let Some(l1) = point.values.get("lyapunov").filter(|_| point.kind != Kind::GH) {
            let _ = write!(out, ": {}", if *l1 < 0.0 { "supercritical" } else { "subcritical" });
        }
        out.push('\n');
    }
}

/// "338.88948540 ± 3e-8": as many digits as the error leaves.
pub(super) fn with_error(value: f64, error: Option<&f64>) -> String {
    match error {
        Some(&error) if error > 0.0 && error.is_finite() => {
            let decimals = (1.0 - error.log10().floor()).clamp(0.0, 15.0) as usize;
            if value != 0.0 && value.abs() < 1e-4 {
                return format!("{value:.6e} ± {error:.0e}");
            }
            format!("{value:.decimals$} ± {error:.0e}")
        }
        _ if value != 0.0 && (value.abs() < 1e-4 || value.abs() >= 1e7) => format!("{value:.6e}"),
        _ => format!("{value:.6}").trim_end_matches('0').trim_end_matches('.').to_owned(),
    }
}
