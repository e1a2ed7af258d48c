//! Every shipped scene gives the numbers that it promises, with errors that are what they say.

use hopfline::branch::{Branch, BranchKind, read_branch};
use hopfline::run::{self, RunOptions, Summary};
use hopfline::scene::Scene;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use tempfile::TempDir;

/// A scene's results.
struct Results {
    folder: TempDir,
    name: String,
    scene: Scene,
    summary: Summary,
}

impl Results {
    fn new(path: &Path, sets: &[&str], only: &[&str]) -> Self {
        let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
        let scene = Scene::load(path, &sets).unwrap_or_else(|e| panic!("{e}"));
        let folder = tempfile::tempdir().unwrap();
        let options = RunOptions {
            out: folder.path().to_owned(),
            only: only.iter().map(|s| s.to_string()).collect(),
            resume: false,
            quiet: true,
        };
        let summary = run::run(&scene, &options).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        Self { folder, name: scene.name.clone(), scene, summary }
    }

    fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(&self.name).join(file)
    }

    /// A value at a special point, and its error where there is one.
    fn value(&self, label: &str, name: &str) -> (f64, Option<f64>) {
        let point = self.summary.points.iter().find(|point| point.label == label);
        let point = point.unwrap_or_else(|| panic!("{} finds no {label}", self.name));
        let value = point.parameters.get(name).or(point.values.get(name));
        (*value.unwrap_or_else(|| panic!("{label} has no {name}")), point.errors.get(name).copied())
    }

    fn branch(&self, name: &str, kind: BranchKind) -> Branch {
        read_branch(&self.path(&format!("branches/{name}.csv")), name, kind, &["p".to_owned()]).unwrap()
    }
}

fn problems() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("problems")
}

/// Two scenes are looked at by several tests; each is run once.
fn uniform() -> &'static Results {
    static RESULTS: OnceLock<Results> = OnceLock::new();
    RESULTS.get_or_init(|| Results::new(&problems().join("two-doublet.toml"), &[], &[]))
}

fn distal() -> &'static Results {
    static RESULTS: OnceLock<Results> = OnceLock::new();
    RESULTS.get_or_init(|| Results::new(&problems().join("two-doublet-distal.toml"), &[], &[]))
}

fn assert_succeeds(results: &Results) {
    let table = results.summary.table("");
    assert!(results.summary.success(), "{table}");
    assert!(!results.summary.expect.is_empty(), "{} promises no number", results.name);
    for figure in &results.summary.figures {
        let svg = fs::read_to_string(results.path(&format!("figures/{}.svg", figure.name))).unwrap();
        assert!(svg.contains("<polyline") || svg.contains("<path"), "{} shows no curve", figure.name);
        assert!(!svg.contains("NaN") && !svg.contains("\"inf"), "{} has a point nowhere", figure.name);
    }
    assert_on_page(results);
}

/// The page of scenes says what this run found: the same words, and numbers that agree up to their errors, whose sizes
/// are those of rounding or alike.
fn assert_on_page(results: &Results) {
    let page = fs::read_to_string(problems().join("README.md")).unwrap();
    let section = run::section(&results.scene, &results.summary, Path::new("../output/gallery")).unwrap();
    let stale = "problems/README.md is stale: run `hopfline run problems/*.toml && hopfline gallery problems`";
    let head = format!("\n## {}\n", results.name);
    let start = page.find(&head).unwrap_or_else(|| panic!("{stale}; it has no {}", results.name));
    let ends = ["\n## ", "\n# "].map(|head| page[start + 1..].find(head).map_or(page.len(), |end| start + 1 + end));
    let end = ends[0].min(ends[1]);
    let (old, new) = (page[start..end].trim(), section.trim());
    assert_eq!(old.lines().count(), new.lines().count(), "{stale}; {}", results.name);
    for (old, new) in old.lines().zip(new.lines()) {
        let mut small = false;
        let same = old.split_whitespace().count() == new.split_whitespace().count()
            && old.split_whitespace().zip(new.split_whitespace()).all(|(old, new)| {
                let agree = match (old.parse::<f64>(), new.parse::<f64>()) {
                    // Errors and distances: of like size, or both next to nothing.
                    (Ok(a), Ok(b)) if small || a.abs().max(b.abs()) < 1e-3 => {
                        a.max(b) < 1e-8 || a.max(b) < 30.0 * a.min(b)
                    }
                    (Ok(a), Ok(b)) => (a - b).abs() <= 1e-6 * a.abs().max(b.abs()),
                    _ => old == new,
                };
                small = old == "±";
                agree
            });
        assert!(same, "{stale}; {}:\n{old}\n{new}", results.name);
    }
}

#[test]
fn every_scene_meets_its_expectations() {
    let mut seen = 0;
    for entry in fs::read_dir(problems()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        seen += 1;
        match path.file_stem().and_then(|stem| stem.to_str()) {
            Some("two-doublet") => assert_succeeds(uniform()),
            Some("two-doublet-distal") => assert_succeeds(distal()),
            _ => assert_succeeds(&Results::new(&path, &[], &[])),
        }
    }
    let page = fs::read_to_string(problems().join("README.md")).unwrap();
    assert_eq!(page.matches("\n## ").count(), seen, "problems/README.md shows scenes that are gone");
    // The suite and the studies take minutes: here it is only seen that the page has them all.
    let files = |folder: &str| -> Vec<String> {
        let entries = fs::read_dir(problems().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        entries.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect()
    };
    for study in files("bench") {
        assert!(page.contains(&format!("\n### {study}\n")), "problems/README.md lacks the study {study}");
    }
    let cases = &page[page.find("\n# Extreme cases").unwrap()..page.find("\n# Work and precision").unwrap()];
    assert_eq!(cases.matches("\n| ").count(), files("extreme").len() + 2, "problems/README.md has other extreme cases");
}

#[test]
fn branches_are_resolved_and_figures_drawn() {
    for (results, figures) in [(uniform(), 7), (distal(), 5)] {
        let equilibria = results.branch("straight", BranchKind::Equilibria).rows.len();
        let cycles = results.branch("beat", BranchKind::Cycles).rows.len();
        assert!(equilibria >= 60 && cycles >= 40, "{}: {equilibria} and {cycles} rows", results.name);
        assert_eq!(results.summary.figures.len(), figures, "{}", results.name);
    }
}

#[test]
fn the_trivial_multiplier_is_one() {
    for results in [uniform(), distal()] {
        for label in ["beat/UZ1", "beat/UZ2"] {
            let (error, _) = results.value(label, "trivial_error");
            assert!(error < 1e-8, "{} {label}: {error}", results.name);
        }
    }
}

/// Supercritical: `p - p_H = 15.6 y²` with the tip deflection y in µm (Bayly and Dutcher's model, uniform load).
#[test]
fn amplitudes_grow_as_a_square_root() {
    let results = uniform();
    let onset = results.value("straight/HB1", "p").0;
    let beat = results.branch("beat", BranchKind::Cycles);
    let deflection = beat.column("max tip_deflection").unwrap();
    for row in &beat.rows[1..3] {
        let (p, y) = (row.values[0].unwrap(), row.values[deflection].unwrap());
        let slope = (p - onset) / (y * y);
        assert!((slope / 15.6 - 1.0).abs() < 0.01, "{slope} at {p}");
        assert_eq!(row.stable, Some(true), "at {p}");
    }
    assert!(results.value("straight/HB1", "lyapunov").0 < 0.0);
}

/// Estimated errors against true ones: the difference to a much finer discretisation, in space and time.
fn assert_honest(results: &Results, scene: &str, range: &str) {
    let range = format!("task.beat.range={range}");
    let fine = [
        "model.functions=56",
        "task.beat.intervals=14",
        "task.beat.degree=5",
        "task.beat.errors=false",
        "task.beat.multipliers=0",
        "task.straight.range=[300, 450]",
        "task.straight.errors=false",
        // A tenth of the shorter range.
        "task.beat.max_step=2",
        &range,
    ];
    let values = if scene == "two-doublet" { &["task.straight.values={ p = [330] }"][..] } else { &[] };
    let reference = Results::new(&problems().join(format!("{scene}.toml")), &[&fine, values].concat(), &["beat"]);
    let (mut honest, mut compared) = (0, String::new());
    let mut count = 0;
    for label in ["beat/UZ1", "beat/UZ2"] {
        for name in ["period", "frequency", "max tip_deflection", "max tip_angle"] {
            let ((value, estimate), (exact, _)) = (results.value(label, name), reference.value(label, name));
            let (estimate, error) = (estimate.unwrap(), (value - exact).abs());
            // Below that, rounding in both is all there is.
            if error < 1e-11 * exact.abs() {
                assert!(estimate < 1e-9 * exact.abs(), "{label} {name}: {estimate}");
                continue;
            }
            let ratio = error / estimate;
            compared +=
                &format!("{label} {name}: {value} - {exact} = {error:.1e}, estimated {estimate:.1e}, {ratio:.2}\n");
            count += 1;
            honest += usize::from((0.1..=10.0).contains(&ratio));
        }
    }
    println!("{compared}");
    assert!(count >= 4 && 4 * honest >= 3 * count, "{honest} of {count} honest:\n{compared}");
    // What the onset needs is there with far fewer functions: its error is rounding, and is said to be.
    for name in ["p", "omega", "lyapunov"] {
        let ((value, estimate), (exact, _)) =
            (results.value("straight/HB1", name), reference.value("straight/HB1", name));
        let size = exact.abs();
        assert!((value - exact).abs() < 1e-10 * size && estimate.unwrap() < 1e-10 * size, "{name}: {value}, {exact}");
    }
}

#[test]
fn errors_are_honest_under_uniform_load() {
    assert_honest(uniform(), "two-doublet", "[0, 361]");
}

#[test]
fn errors_are_honest_under_distal_load() {
    assert_honest(distal(), "two-doublet-distal", "[0, 441]");
}
