//! A folder of scenes as a suite: what came out of each, in a table.
//!
//! A number is right where it lies within its printed error of the expected one. That error is an estimate: where a number
//! is further off, but still within the tolerance of its expectation, the verdict says so.

use super::RunError;
use super::outcome::Status;
use super::summary::{Expected, Summary};
use crate::branch::write_atomically;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Where the results of a scene or a folder of scenes go: each folder has one of its own in `out`.
pub fn folder(path: &Path, out: &Path) -> PathBuf {
    match path.file_name().filter(|_| path.is_dir()) {
        Some(name) => out.join(name),
        None => out.to_owned(),
    }
}

/// What came out of a scene.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Case {
    pub scene: String,
    pub title: String,
    pub verdict: String,
    /// Why tasks stopped that were not done.
    pub reason: String,
    /// Expected numbers with a printed error, and how many are within it.
    pub expected: usize,
    pub right: usize,
    /// The number that is furthest off, relatively (absolutely where zero is expected): true and printed error.
    pub worst: Option<String>,
    pub error: Option<f64>,
    pub printed: Option<f64>,
    pub seconds: f64,
    /// What limits the accuracy or the reach, in the scene's words.
    pub limit: String,
}

impl Case {
    pub fn new(scene: &Scene, summary: &Summary) -> Self {
        let expect = &summary.expect;
        let printed: Vec<&Expected> = expect.iter().filter(|e| e.error.is_some()).collect();
        let right = printed.iter().filter(|e| e.right()).count();
        let missed = expect.iter().filter(|e| !e.met).count();
        let stopped: Vec<String> = (summary.tasks.iter().filter(|task| task.status != Status::Done))
            .map(|task| format!("{}: {}", task.name, task.reason))
            .collect();
        let verdict = if missed > 0 {
            format!("MISSED {missed} of {}", expect.len())
        } else if !stopped.is_empty() {
            if summary.success() { "stops as expected" } else { "STOPPED" }.to_owned()
        } else if right < printed.len() {
            "within tolerance".to_owned()
        } else {
            "right".to_owned()
        };
        let off = |e: &&Expected| e.distance().unwrap_or(f64::INFINITY);
        let worst = expect.iter().max_by(|a, b| off(a).total_cmp(&off(b)));
        Self {
            scene: summary.scene.clone(),
            title: summary.title.clone(),
            verdict,
            reason: stopped.join("; "),
            expected: printed.len(),
            right,
            worst: worst.map(|e| e.key.clone()),
            error: worst.and_then(Expected::distance),
            printed: worst.and_then(|e| Some(e.error? / e.scale())),
            seconds: summary.seconds,
            limit: scene.limit.clone(),
        }
    }
}

/// The table, in Markdown.
pub fn table(cases: &[Case]) -> String {
    const HEAD: [&str; 7] = ["case", "verdict", "numbers", "error", "printed", "s", "what limits it"];
    let number =
        |x: Option<f64>| x.map_or("-".to_owned(), |x| if x == 0.0 { "0".to_owned() } else { format!("{x:.0e}") });
    let rows: Vec<[String; 7]> = cases
        .iter()
        .map(|case| {
            let seconds = format!("{:.1}", case.seconds);
            let numbers = format!("{} of {}", case.right, case.expected);
            let (error, printed) = (number(case.error), number(case.printed));
            [case.title.clone(), case.verdict.clone(), numbers, error, printed, seconds, case.limit.clone()]
        })
        .collect();
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).chain([HEAD[k].len(), 3]).max().unwrap_or(3);
    let mut out = String::new();
    let mut line = |cells: &[String]| {
        let padded = cells.iter().enumerate().map(|(k, cell)| {
            // The last column is free text and ends the line.
            if k + 1 == cells.len() { cell.clone() } else { format!("{cell:0$}", width(k)) }
        });
        let _ = writeln!(out, "| {} |", padded.collect::<Vec<_>>().join(" | "));
    };
    line(&HEAD.map(str::to_owned));
    line(&std::array::from_fn::<String, 7, _>(|k| "-".repeat(if k == 6 { 3 } else { width(k) })));
    rows.iter().for_each(|row| line(row));
    let sum = |of: fn(&Case) -> usize| cases.iter().map(of).sum::<usize>();
    let (expected, right) = (sum(|case| case.expected), sum(|case| case.right));
    let seconds: f64 = cases.iter().map(|case| case.seconds).sum();
    let _ = writeln!(out, "\n{right} of {expected} numbers lie within their printed errors; {seconds:.0} s");
    out
}

/// The cases that the last run of a suite left in its folder.
pub fn load(folder: &Path) -> Result<Vec<Case>, RunError> {
    let path = folder.join("cases.json");
    let text = std::fs::read(&path).map_err(|e| {
        RunError::Input(format!("cannot read {}: {e}; run the folder of scenes first, as a whole", path.display()))
    })?;
    serde_json::from_slice(&text)
        .map_err(|e| RunError::Input(format!("{} holds no cases of a suite: {e}", path.display())))
}

/// Stores the cases as `cases.json` and the table as `cases.md` in the suite's folder.
pub fn store(folder: &Path, cases: &[Case]) -> Result<(), RunError> {
    write_atomically(&folder.join("cases.json"), |file| {
        serde_json::to_writer_pretty(file, cases).map_err(std::io::Error::from)
    })?;
    write_atomically(&folder.join("cases.md"), |file| file.write_all(table(cases).as_bytes()))?;
    Ok(())
}
