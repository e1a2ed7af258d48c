//! The program as its users meet it: arguments in, exit code, streams and files out.

mod bench;
mod commands;
mod input;
mod results;
mod resume;

use assert_cmd::Command;
use hopfline::branch::{Array, read_arrays};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_hopfline");

/// No command of these tests needs nearly as long; one that hangs is to fail, not to hang the tests.
const PATIENCE: Duration = Duration::from_secs(120);

/// Small enough to run in a fraction of a second, and complete: a Hopf point, cycles, wanted points, figures.
const SMALL: &str = r#"
title = "Small"

[model]
name = "two-doublet"
functions = 10

[parameters]
k_N = 1e4

[[task]]
name = "straight"
kind = "equilibria"
free = "p"
range = [340, 400]
spectrum = 4
detect = ["HB"]
max_step = 20

[[task]]
name = "beat"
kind = "cycles"
from = "straight/HB1"
free = "p"
range = [340, 354]
intervals = 6
degree = 3
multipliers = 2
values = { p = [352] }

[[figure]]
name = "diagram"
x = "p"
y = ["max tip_deflection", "min tip_deflection"]
tasks = ["straight", "beat"]

[[figure]]
name = "eigenvalues"
kind = "eigenvalues"
tasks = ["straight"]

[[figure]]
name = "shape"
kind = "waveform"
point = "beat/UZ1"
"#;

/// A folder of its own to work in.
struct Desk(TempDir);

/// How a command ended.
struct Finished {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// With the small scene in it, after some replacements; each must find its text.
    fn with_small(changes: &[(&str, &str)]) -> Self {
        let desk = Self::new();
        desk.write("small.toml", &changed(SMALL, changes));
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Runs the program here. It must not panic, whatever it is given.
    fn hopfline(&self, arguments: &[&str]) -> Finished {
        let output =
            Command::new(PROGRAM).args(arguments).current_dir(self.0.path()).timeout(PATIENCE).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
        assert!(!stderr.contains("panicked"), "{arguments:?}: {stderr}");
        Finished { code: output.status.code(), stdout, stderr }
    }

    /// The same for commands that must succeed; what they print.
    fn succeed(&self, arguments: &[&str]) -> String {
        let Finished { code, stdout, stderr } = self.hopfline(arguments);
        assert_eq!(code, Some(0), "{arguments:?}: {stdout}{stderr}");
        stdout
    }

    fn summary(&self, folder: &str) -> Value {
        json(&self.path(folder).join("summary.json"))
    }

    /// All files below a folder, relative to it, but for those that differ from run to run.
    fn files(&self, folder: &str) -> Vec<String> {
        let mut found = Vec::new();
        collect(&self.path(folder), "", &mut found);
        found.sort();
        found
    }
}

fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from:?} is not in the scene");
        text.replace(from, to)
    })
}

fn collect(folder: &Path, above: &str, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = format!("{above}{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() {
            collect(&entry.path(), &format!("{name}/"), found);
        } else {
            found.push(name);
        }
    }
}

fn json(path: &Path) -> Value {
    let text = fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_slice(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// One task's entry of a summary.
fn task<'a>(summary: &'a Value, name: &str) -> &'a Value {
    summary["tasks"].as_array().unwrap().iter().find(|task| task["name"] == name).unwrap()
}

fn point<'a>(summary: &'a Value, label: &str) -> Option<&'a Value> {
    summary["points"].as_array().unwrap().iter().find(|point| point["label"] == label)
}

fn count(summary: &Value, name: &str, what: &str) -> u64 {
    task(summary, name)["counts"][what].as_u64().unwrap()
}

fn is_left_over(name: &str) -> bool {
    name.contains(".hopfline-") || name.ends_with(".tmp")
}

/// Every file of a results folder can be read to its end.
fn assert_whole(desk: &Desk, folder: &str) {
    for name in desk.files(folder) {
        let path = desk.path(folder).join(&name);
        match path.extension().and_then(|e| e.to_str()) {
            // What a kill leaves of a file in the making does not count: it does not have the file's name.
            _ if is_left_over(&name) => {}
            Some("csv") => {
                let text = fs::read_to_string(&path).unwrap();
                let cells: Vec<usize> = text.lines().map(|line| line.split(',').count()).collect();
                assert!(text.ends_with('\n') && cells.len() > 1, "{name}");
                assert!(cells.iter().all(|n| *n == cells[0]), "{name}: {cells:?}");
            }
            Some("json") => drop(json(&path)),
            Some("npz") => drop(arrays(&path)),
            Some("svg") => assert!(fs::read_to_string(&path).unwrap().trim_end().ends_with("</svg>"), "{name}"),
            _ => {}
        }
    }
}

fn arrays(path: &Path) -> BTreeMap<String, Array> {
    read_arrays(path).unwrap()
}

/// Two folders hold the same branches, points and figures, bit for bit.
fn assert_same_results(desk: &Desk, one: &str, other: &str) {
    let names = |folder: &str| -> Vec<String> {
        let kept = |name: &String| ["branches/", "points/", "figures/"].iter().any(|start| name.starts_with(start));
        desk.files(folder).into_iter().filter(kept).collect()
    };
    assert_eq!(names(one), names(other));
    for name in names(one) {
        let (a, b) = (desk.path(one).join(&name), desk.path(other).join(&name));
        if name.ends_with(".npz") {
            let bits = |path: &Path| -> Vec<(String, Vec<u64>)> {
                arrays(path).into_iter().map(|(k, v)| (k, v.data.iter().map(|x| x.to_bits()).collect())).collect()
            };
            assert!(bits(&a) == bits(&b), "{name} differs");
        } else {
            assert!(fs::read(&a).unwrap() == fs::read(&b).unwrap(), "{name} differs");
        }
    }
    let (one, other) = (desk.summary(one), desk.summary(other));
    assert_eq!(one["points"], other["points"]);
    assert_eq!(one["branches"], other["branches"]);
}
