//! Simulations as tasks of scenes, and against the collocated cycle.

mod common;

use common::{Cycle, Flagellum, close, refused};
use hopfline::branch::{BranchKind, Kind, read_branch};
use hopfline::continuation::Counts;
use hopfline::models::{Law, Load};
use hopfline::orbit::Orbit;
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use hopfline::simulate::{Attractor, Control, Course, Method, Search, settle};
use std::ops::ControlFlow;
use std::path::Path;

fn ran(sets: &[&str], out: &Path, only: &[&str]) -> Summary {
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/simulation.toml");
    let only = only.iter().map(|s| (*s).to_owned()).collect();
    let options = RunOptions { out: out.to_owned(), only, resume: false, quiet: true };
    run(&Scene::load(&path, &sets).expect("a scene"), &options).expect("a run")
}

/// The end of a motion and the cycle that it settled on share a row; they keep it when the figure is drawn again.
#[test]
fn figures_of_motions_are_drawn_again_as_they_were() {
    let text = r#"
[model]
equations = """
x' = x - y - x*(x^2 + y^2)
y' = x + y - y*(x^2 + y^2)
"""
[model.parameters]
mu = 1
[model.start]
x = 0.5
[[task]]
name = "motion"
kind = "simulate"
time = [0, 60]
amplitude = 0.01
[[figure]]
name = "motion"
x = "t"
y = "x"
tasks = ["motion"]
"#;
    let out = tempfile::tempdir().unwrap();
    let scene = |text: &str| Scene::parse(text, Path::new("scene.toml"), &[]);
    let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let summary = run(&scene(text).unwrap(), &options).unwrap();
    let labels: Vec<(&str, usize)> = summary.points.iter().map(|point| (point.label.as_str(), point.row)).collect();
    assert_eq!(labels, [("motion/EP1", 1000), ("motion/LC1", 1000)]);
    let figure = out.path().join("scene/figures/motion.svg");
    let first = std::fs::read(&figure).unwrap();
    hopfline::run::redraw(&out.path().join("scene")).unwrap();
    assert!(first == std::fs::read(&figure).unwrap());
    for (kind, wanted) in [
        ("kind = \"surface\"\ntasks = [\"motion\"]", "is no surface"),
        ("kind = \"waveform\"\npoint = \"motion/LC1\"", "waveforms are drawn of points of equilibria"),
    ] {
        let text = format!("{text}[[figure]]\nname = \"other\"\n{kind}\n");
        let refused = run(&scene(&text).unwrap(), &options).unwrap_err().to_string();
        assert!(refused.contains(wanted), "{refused}");
    }
}

/// The only eigenvalue is as large as the matrix: it must not be the shift.
#[test]
fn one_unknown_has_an_eigenmode() {
    let text = "[model]\nequations = \"x' = mu*x - x^3\"\n[model.parameters]\nmu = 1\n[[task]]\nname = \"motion\"\n\
                kind = \"simulate\"\ntime = [0, 20]\namplitude = 0.01\nobservables = [\"x\"]\n";
    let out = tempfile::tempdir().unwrap();
    let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let summary = run(&Scene::parse(text, Path::new("scene.toml"), &[]).unwrap(), &options).unwrap();
    close("x", summary.points[0].values["x"].abs(), 1.0, 1e-5);
}

#[test]
fn the_scene_meets_its_expectations_and_stores_a_cycle() {
    let out = tempfile::tempdir().unwrap();
    let summary = ran(&[], out.path(), &[]);
    assert!(summary.expect.iter().all(|expected| expected.met), "{:?}", summary.expect);
    let cycle = summary.points.iter().find(|point| point.label == "motion/LC1").expect("a cycle");
    assert_eq!(cycle.kind, Kind::LC);
    let (period, error) = (cycle.values["period"], cycle.errors["period"]);
    assert!((period - 6.663_286_859_323_13).abs() <= 2.0 * error && error < 1e-6, "{period} {error}");
    // The stored arrays are those of a cycle: a piecewise polynomial whose slope is the equations' right side.
    let arrays = hopfline::branch::read_arrays(&out.path().join("simulation/points/motion/LC1.npz")).expect("arrays");
    let array = |name: &str| arrays[name].data.clone();
    let orbit = Orbit {
        mesh: array("mesh"),
        points: hopfline::orbit::Points::Radau,
        degree: array("degree_parts")[0] as usize,
        nodes: array("state"),
        dim: 2,
        part: array("part")[0],
        parts: array("degree_parts")[1] as usize,
        drift: Vec::new(),
    };
    assert_eq!(orbit.nodes.len(), 2 * (orbit.intervals() * orbit.degree + 1));
    let scheme = orbit.scheme();
    for tau in orbit.mesh.windows(2).map(|w| 0.5 * (w[0] + w[1])) {
        let (u, v) = orbit.at(tau, &scheme);
        let rate = (1.0 - u[0] * u[0]) * u[1] - u[0];
        assert!((v[0] - u[1]).abs() < 1e-3 && (v[1] - rate).abs() < 1e-2, "at {tau}: {u:?} {v:?}");
    }
    // As many rows as were asked for, all numbers.
    let table = std::fs::read_to_string(out.path().join("simulation/branches/motion.csv")).unwrap();
    assert!(!table.to_lowercase().contains("nan") && table.lines().count() > 1001);
}

#[test]
fn a_ramp_is_seen_in_its_column() {
    let out = tempfile::tempdir().unwrap();
    let sets = ["task.motion.ramp={ mu = [0.5, 1.5] }", "task.motion.samples=10", "task.motion.tolerance=1e-6"];
    let summary = ran(&sets, out.path(), &["motion"]);
    let end = summary.points.iter().find(|point| point.label == "motion/EP1").expect("an end");
    close("mu", end.parameters["mu"], 1.5, 1e-15);
    assert!(!summary.points.iter().any(|point| point.kind == Kind::LC));
}

#[test]
fn bad_keys_and_values_are_refused() {
    for (set, wanted) in [
        ("task.motion.start=[0.1]", "start has 1 numbers, but the model has 2 unknowns"),
        ("task.motion.time=[1, 0]", "time"),
        ("task.motion.method=\"euler\"", "bdf"),
        ("task.motion.tolerance=1", "tolerance"),
        ("task.motion.ramp={ nu = [0, 1] }", "nu"),
        ("task.motion.ramp={ mu = [0] }", "two numbers"),
        ("task.settled.over={ mu = [] }", "at least one number"),
        ("task.settled.ramp={ mu = [0, 1] }", "keep one"),
        ("task.settled.start=[0, 0]", "keep one"),
        ("task.settled.from=\"motion/HB1\"", "EP1"),
        ("task.settled.parameters={ mu = 1 }", "mu"),
    ] {
        refused("simulation", &[set], wanted);
    }
}

#[test]
fn a_flagellum_from_nearly_straight_settles_on_the_collocated_cycle() {
    const LOAD: f64 = 360.0;
    let model = Flagellum::new(12, Load::Uniform, Law::Printed).with("p", LOAD);
    let cycles = model.cycles(345.0, &[LOAD], (24, 5));
    let Cycle { orbit, deflection, .. } = &cycles[0];
    let mode = model.hopf(345.0, 0).q;
    let largest = mode.iter().fold(0.0_f64, |most, q| most.max(q.re.abs()));
    let start: Vec<f64> = mode.iter().map(|q| 0.2 * q.re / largest).collect();
    let course = Course::steady(0.0, 80.0 * orbit.period(), &model.p);
    let control = Control { method: Method::Bdf, tolerance: 1e-9, absolute: 1e-9 };
    let search =
        Search { observables: &[model.observable("tip_deflection")], recognise: true, stop: true, errors: false };
    let mut counts = Counts::default();
    let see = &mut |_: &hopfline::simulate::Step| ControlFlow::Continue(());
    let settled = settle(&*model.problem, &start, (&course, &control), &search, &mut counts, see).expect("a motion");
    let Attractor::Cycle(cycle) = settled.attractor else { panic!("{:?}", settled.attractor) };
    close("frequency", 1.0 / cycle.period, 1.0 / orbit.period(), 1e-6);
    close("largest tip deflection", cycle.ranges[0].max, *deflection, 1e-6);
}

#[test]
fn cycles_start_from_a_simulation() {
    let home = tempfile::tempdir().unwrap();
    let scene =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/simulation.toml")).unwrap();
    let (tasks, _) = scene.split_once("[expect]").expect("expectations");
    let followed = "[[task]]\nname = \"followed\"\nkind = \"cycles\"\nfrom = \"motion/LC1\"\nfree = \"mu\"\nrange = [0.5, 1.5]\n\
                    values = { mu = [0.8] }\n";
    let path = home.path().join("followed.toml");
    let born =
        tasks.replace("range = [-0.2, 1]\n\n[[figure]]", "range = [-0.2, 1]\nvalues = { mu = [0.8] }\n\n[[figure]]");
    std::fs::write(&path, born + followed).unwrap();
    let options = RunOptions { out: home.path().join("out"), only: Vec::new(), resume: false, quiet: true };
    let summary = run(&Scene::load(&path, &[]).expect("a scene"), &options).expect("a run");
    let period = |label: &str| {
        let point = summary.points.iter().find(|point| point.label == label);
        let reasons: Vec<&str> = summary.tasks.iter().map(|task| task.reason.as_str()).collect();
        point.unwrap_or_else(|| panic!("no {label}: {reasons:?}")).values["period"]
    };
    close("period", period("followed/UZ1"), period("cycles/UZ1"), 1e-6);
}

/// x = cos t, by names; with all crossings of zero, those of y = -sin t down through 0.6, and the end where the motion has
/// come round for the second time.
const TURNING: &str = r#"
[model]
equations = """
x' = y
y' = -x
turns' = 1/(2*pi)
"""
[[task]]
name = "motion"
kind = "simulate"
start = { x = 1 }
time = [0, 20]
tolerance = 1e-10
samples = 40
events = [
    { of = "x", value = 0 },
    { of = "y", value = 0.6, direction = "down" },
    { of = "turns", value = 2, direction = "up", stop = true },
]
"#;

fn turning(text: &str, out: &Path) -> Result<Summary, String> {
    let scene = Scene::parse(text, Path::new("turning.toml"), &[]).map_err(|error| error.to_string())?;
    let options = RunOptions { out: out.to_owned(), only: Vec::new(), resume: false, quiet: true };
    run(&scene, &options).map_err(|error| error.to_string())
}

#[test]
fn events_are_where_the_motion_is_known_to_have_them() {
    use std::f64::consts::{PI, TAU};
    let out = tempfile::tempdir().unwrap();
    let summary = turning(TURNING, out.path()).unwrap();
    assert!(summary.tasks[0].reason.contains("turns = 2, event 3"), "{}", summary.tasks[0].reason);
    let down = PI + (0.6_f64).asin();
    let wanted = [0.5 * PI, 1.5 * PI, TAU - (down - PI), 2.5 * PI, 3.5 * PI, 2.0 * TAU - (down - PI), 2.0 * TAU];
    // y = -sin t falls through 0.6 behind its maximum at 3 pi/2.
    let events: Vec<_> = summary.points.iter().filter(|point| point.label.contains("/EV")).collect();
    assert_eq!(events.len(), wanted.len());
    for ((k, event), (wanted, which)) in events.iter().enumerate().zip(wanted.into_iter().zip([1, 1, 2, 1, 1, 2, 3])) {
        assert_eq!(event.label, format!("motion/EV{}", k + 1));
        close("t", event.values["t"], wanted, 1e-7);
        assert_eq!(event.values["event"], f64::from(which));
    }
    let branch = read_branch(&out.path().join("turning/branches/motion.csv"), "motion", BranchKind::Simulation, &[]);
    let rows = branch.unwrap().rows;
    let times: Vec<f64> = rows.iter().map(|row| row.values[0].unwrap()).collect();
    assert!(times.windows(2).all(|pair| pair[0] <= pair[1]), "{times:?}");
    close("end", *times.last().unwrap(), 2.0 * TAU, 1e-7);
    // 26 samples, half a unit apart, and the events.
    assert_eq!(rows.len(), 26 + wanted.len());
    assert_eq!(rows.iter().filter(|row| row.label.is_some()).count(), wanted.len());
}

#[test]
fn wrong_events_and_starts_are_refused() {
    let out = tempfile::tempdir().unwrap();
    for (from, to, wanted) in [
        ("of = \"x\"", "of = \"w\"", "x, y, turns"),
        ("\"down\"", "\"left\"", "up"),
        ("value = 0.6", "level = 0.6", "level"),
        ("start = { x = 1 }", "start = { w = 1 }", "x, y, turns"),
        ("start = { x = 1 }", "start = {}", "a table of unknowns"),
    ] {
        let message = turning(&TURNING.replace(from, to), out.path()).map(drop).unwrap_err();
        assert!(message.contains(wanted), "{message:?} lacks {wanted:?}");
    }
    refused("simulation", &["task.settled.events=[{ of = \"x\", value = 0 }]"], "leave out events or over");
}

/// Langford's oscillator beyond the torus bifurcation of its cycle, and the planar system that is left where the angle is
/// divided out: on the torus the one frequency is `turning`, the other that of the planar cycle.
const TORUS: &str = r#"
[model]
equations = """
x' = (z - b)*x - turning*y
y' = turning*x + (z - b)*y
z' = 0.6 + 0.95*z - z^3/3 - x^2 - y^2
"""
[model.parameters]
b = 0.96
turning = 3.5
[[task]]
name = "motion"
kind = "simulate"
start = { x = 1, z = 0.9 }
time = [0, 1800]
tolerance = 1e-8
"#;

const PLANAR: &str = r#"
[model]
equations = """
r' = (h - 0.96)*r
h' = 0.6 + 0.95*h - h^3/3 - r^2
"""
[[task]]
name = "planar"
kind = "simulate"
start = { r = 1, h = 0.9 }
time = [0, 900]
tolerance = 1e-8
"#;

#[test]
fn a_torus_has_the_rotation_number_of_its_two_frequencies() {
    let out = tempfile::tempdir().unwrap();
    let (summary, planar) = (turning(TORUS, out.path()).unwrap(), turning(PLANAR, out.path()).unwrap());
    let reason = &summary.tasks[0].reason;
    assert!(reason.contains("quasi-periodic"), "{reason}");
    let rotation = summary.points.iter().find(|point| point.label == "motion/EP1").unwrap().values["rotation"];
    let period = planar.points.iter().find(|point| point.label == "planar/LC1").unwrap().values["period"];
    let turns = std::f64::consts::TAU / 3.5 / period;
    let gap = (rotation - turns).rem_euclid(1.0).min((rotation + turns).rem_euclid(1.0));
    assert!(gap.min(1.0 - gap) < 1e-4, "{rotation} {turns}");
}

/// x = -sin t comes to 1 - 1e-4 twice around each of its maxima, within a small part of a step.
#[test]
fn events_on_both_sides_of_an_extremum_are_found() {
    let text = r#"
[model]
equations = """
x' = -y
y' = x
"""
[[task]]
name = "motion"
kind = "simulate"
start = [0, 1]
time = [0, 20]
tolerance = 1e-8
events = [{ of = "x", value = 0.9999, direction = "any" }]
"#;
    let out = tempfile::tempdir().unwrap();
    let summary = turning(text, out.path()).unwrap();
    let times: Vec<f64> = summary.points.iter().filter_map(|point| point.values.get("t").copied()).collect();
    let half = (0.9999_f64).acos();
    let wanted = [1.5, 3.5, 5.5].map(|turns| [-half, half].map(|off| turns * std::f64::consts::PI + off)).concat();
    assert_eq!(summary.points.iter().filter(|point| point.label.contains("/EV")).count(), wanted.len(), "{times:?}");
    for wanted in wanted {
        assert!(times.iter().any(|t| (t - wanted).abs() < 1e-4), "{wanted} {times:?}");
    }
}
