//! Maps of the rightmost eigenvalue: a system with known eigenvalues, the two-doublet flagellum, figures, bad input.

use hopfline::bifurcation::{LeadingFailure, Line};
use hopfline::branch::{Branch, BranchKind, Column, Row, read_branch};
use hopfline::linalg::c64;
use hopfline::plot::{Spec, SpecKind, draw};
use hopfline::problem::{Automatic, Bounds, Default, Formula, Parameter, Scalar};
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::Path;

/// z + z³ = a moves with a; two oscillators of growth b + z and b - z / 2, frequencies 1 + b² and 3, in units that make
/// M differ from the identity. For `fold` z² = a instead, which has no solution at a < 0.
struct Moving {
    parameters: [Parameter; 2],
    fold: bool,
}

fn moving(fold: bool) -> Automatic<Moving> {
    let make = |name| Parameter { name, default: Default::Value(0.0), unit: "", meaning: "", bounds: Bounds::Any };
    Automatic(Moving { parameters: [make("a"), make("b")], fold })
}

impl Formula for Moving {
    fn dim(&self) -> usize {
        5
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let z = u[0];
        let level = if self.fold { z * z } else { z + z * z * z };
        g[0] = v[0] * 2.0 - (p[0] - level) * 200.0;
        let mut turn = |k: usize, growth: S, omega: S, mass: f64| {
            g[k] = (v[k] - (u[k] * growth - u[k + 1] * omega)) * mass;
            g[k + 1] = v[k + 1] - (u[k] * omega + u[k + 1] * growth);
        };
        turn(1, p[1] + z, p[1] * p[1] + 1.0, 3.0);
        turn(3, p[1] - z * 0.5, S::from(3.0), 0.2);
    }
}

/// The real root of z + z³ = a (Cardano).
fn root(a: f64) -> f64 {
    let d = (a * a / 4.0 + 1.0 / 27.0).sqrt();
    (a / 2.0 + d).cbrt() + (a / 2.0 - d).cbrt()
}

#[test]
fn a_moving_state_has_its_exact_eigenvalues_and_jumps() {
    let problem = moving(false);
    for b in [-0.7, 0.0, 0.4] {
        let mut line = Line::new(&problem, vec![0.0; 5], vec![-3.0, b]);
        let mut before = None;
        for k in 0..=40 {
            let a = -3.0 + 0.15 * f64::from(k) + 0.01;
            let here = line.leading(&[a, b]).unwrap();
            let z = root(a);
            assert!((here.u[0] - z).abs() < 1e-14 * z.abs().max(1.0) + 1e-15, "{} is not {z}", here.u[0]);
            let first = z > 0.0;
            let exact = if first { c64::new(b + z, 1.0 + b * b) } else { c64::new(b - 0.5 * z, 3.0) };
            assert!((here.mode.value - exact).norm() < 1e-13 * exact.norm(), "{} is not {exact}", here.mode.value);
            let gap = here.mode.value.re - here.mode.next.unwrap().re;
            assert!((gap - 1.5 * z.abs()).abs() < 1e-12, "{gap}");
            if let Some((mode, was)) = before.replace((here.mode.clone(), first)) {
                let likeness = here.mode.likeness(&mode);
                assert!(if was == first { likeness > 0.9 } else { likeness < 0.1 }, "{likeness} at {a}");
            }
        }
    }
}

#[test]
fn where_there_is_no_state_there_is_nothing_and_the_line_goes_on() {
    let problem = moving(true);
    let mut line = Line::new(&problem, vec![1.0, 0.0, 0.0, 0.0, 0.0], vec![1.0, 0.0]);
    assert!((line.leading(&[0.81, 0.0]).unwrap().u[0] - 0.9).abs() < 1e-14);
    for a in [-0.1, -1.0] {
        let failure = line.leading(&[a, 0.0]).unwrap_err();
        assert!(matches!(failure, LeadingFailure::Newton(_)), "{failure}");
    }
    assert!((line.leading(&[0.25, 0.0]).unwrap().u[0] - 0.5).abs() < 1e-14);
}

const HEAD: &str = "
    [model]
    name = \"two-doublet\"
    functions = 28
";

struct Results {
    folder: tempfile::TempDir,
    summary: Summary,
}

impl Results {
    fn new(text: &str, sets: &[&str]) -> Self {
        let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
        let scene = Scene::parse(&format!("{HEAD}{text}"), Path::new("maps.toml"), &sets).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let options = RunOptions { out: folder.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
        let summary = run(&scene, &options).unwrap();
        assert!(summary.success(), "{}", summary.table(""));
        Self { folder, summary }
    }

    fn text(&self, file: &str) -> String {
        std::fs::read_to_string(self.folder.path().join("maps").join(file)).unwrap()
    }

    fn map(&self) -> Branch {
        let line = self.summary.branches.iter().find(|line| line.kind == BranchKind::Map).unwrap();
        let path = self.folder.path().join("maps").join(&line.file);
        read_branch(&path, &line.name, line.kind, &line.free).unwrap()
    }
}

fn value(branch: &Branch, row: &Row, column: &str) -> f64 {
    row.values[branch.column(column).unwrap()].unwrap()
}

fn over(free: &str, range: [f64; 2], load: [f64; 2], grid: [usize; 2], more: &str) -> String {
    format!(
        "[[task]]\nname = \"map\"\nkind = \"map\"\nfree = [\"{free}\", \"p\"]\ngrid = {grid:?}\n\
         range = {{ {free} = {range:?}, p = {load:?} }}\n{more}"
    )
}

/// Against a branch in p at the same length, and the numbers of two independent Galerkin codes.
#[test]
fn a_map_agrees_with_equilibria() {
    let results = Results::new(&over("L", [12.0, 20.0], [350.0, 500.0], [3, 4], ""), &[]);
    let map = results.map();
    let branch = "[[task]]\nname = \"straight\"\nkind = \"equilibria\"\nfree = \"p\"\nrange = [340, 510]\nspectrum = 4\n\
                  values = { p = [350, 400, 450, 500] }";
    for (length, rows) in [("12", &map.rows[0..4]), ("16", &map.rows[4..8])] {
        let length = format!("parameters.L={length}");
        let equilibria = Results::new(branch, &[&length]).summary;
        for (k, row) in rows.iter().enumerate() {
            let label = format!("straight/UZ{}", k + 1);
            let point = equilibria.points.iter().find(|point| point.label == label).unwrap();
            for name in ["growth", "omega", "frequency"] {
                let (found, expected) = (value(&map, row, name), point.values[name]);
                assert!((found / expected - 1.0).abs() < 1e-8, "{label} {name}: {found}, {expected}");
            }
        }
    }
    for (k, growth, frequency, digit) in
        [(0, 87.776, 34.3885, 1e-3), (1, 530.0, 42.5839, 2e-3), (3, 1625.44, 58.3129, 1e-2)]
    {
        let row = &map.rows[k];
        assert!((value(&map, row, "growth") - growth).abs() < digit);
        assert!((value(&map, row, "frequency") - frequency).abs() < 1e-4);
        assert!((value(&map, row, "omega") / value(&map, row, "frequency") - 2.0 * PI).abs() < 1e-12);
        assert_eq!(row.stable, Some(false));
    }
}

/// Errors against true ones: the difference to twice as many functions.
#[test]
fn errors_of_maps_are_honest() {
    let text = over("L", [14.0, 22.0], [500.0, 800.0], [2, 2], "");
    let map = Results::new(&text, &[]).map();
    let fine = Results::new(&text, &["model.functions=56"]).map();
    for (row, exact) in map.rows.iter().zip(&fine.rows) {
        for name in ["growth", "frequency"] {
            let error = (value(&map, row, name) - value(&fine, exact, name)).abs();
            let estimate = value(&map, row, &format!("error {name}"));
            let rounding = 1e-10 * value(&map, row, name).abs();
            let honest = (0.1..=10.0).contains(&(error / estimate)) || error.max(estimate) < rounding;
            assert!(honest, "{name}: {error:.1e}, estimated {estimate:.1e}");
        }
    }
    let coarse = Results::new(&over("L", [20.0, 30.0], [500.0, 800.0], [2, 2], ""), &["model.functions=20"]).summary;
    assert!(coarse.tasks[0].reason.contains("refine"), "{}", coarse.tasks[0].reason);
}

/// Figures 4(e) and 4(f) of Bayly and Dutcher: the frequency rises with the load and falls with the stiffness; threshold
/// falls with the length and rises with the stiffness.
#[test]
fn frequency_rises_with_load_and_falls_with_stiffness() {
    let text = over("L", [6.0, 18.0], [0.0, 700.0], [7, 15], "errors = false");
    let length = Results::new(&text, &[]).map();
    let text = over("k_N", [10.0, 1e5], [0.0, 700.0], [9, 15], "errors = false\nlog = [\"k_N\"]");
    let stiffness = Results::new(&text, &[]).map();
    let frequencies = |map: &Branch| -> Vec<Option<f64>> {
        let unstable = |row: &Row| value(map, row, "growth") > 0.0;
        map.rows.iter().map(|row| unstable(row).then(|| value(map, row, "frequency"))).collect()
    };
    for (map, lines) in [(&length, 7), (&stiffness, 9)] {
        for line in frequencies(map).chunks(15) {
            let first = line.iter().position(Option::is_some).unwrap_or(line.len());
            assert!(line[first..].iter().all(Option::is_some), "unstable from the threshold on");
            assert!(line[first..].is_sorted_by(|a, b| a < b), "{line:?}");
        }
        assert_eq!(map.rows.len(), 15 * lines);
    }
    let falling = frequencies(&stiffness);
    for j in 0..15 {
        let across: Vec<f64> = (0..9).filter_map(|i| falling[15 * i + j]).collect();
        assert!(across.is_sorted_by(|a, b| a > b), "{across:?}");
    }
    let count = |map: &Branch| -> Vec<usize> {
        frequencies(map).chunks(15).map(|line| line.iter().flatten().count()).collect()
    };
    assert!(count(&length).is_sorted() && count(&length)[6] > count(&length)[0], "{:?}", count(&length));
    assert!(count(&stiffness).iter().rev().is_sorted(), "{:?}", count(&stiffness));
    let log = value(&stiffness, &stiffness.rows[0], "log10 k_N");
    assert_eq!((log, value(&stiffness, &stiffness.rows[0], "k_N")), (1.0, 10.0));
    // The middle of four decades.
    assert!((value(&stiffness, &stiffness.rows[15 * 4], "k_N") / 1e3 - 1.0).abs() < 1e-14);
}

#[test]
fn threads_do_not_change_a_bit() {
    let text = over("k_T", [0.0, 2000.0], [300.0, 500.0], [9, 5], "");
    let figure = "\n[[figure]]\nname = \"map\"\nkind = \"map\"\ntasks = [\"map\"]";
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let results = pool.install(|| Results::new(&format!("{text}{figure}"), &[]));
        [results.text("branches/map.csv"), results.text("figures/map.svg")]
    };
    assert_eq!(with(1), with(3));
}

/// A map of given growth, frequency, gap and mode over the unit square.
fn synthetic(n: usize, at: impl Fn(f64, f64) -> (f64, f64, f64, i32)) -> Branch {
    let names = ["a", "b", "growth", "frequency", "gap", "jump a", "jump b"];
    let place = |i: usize| i as f64 / (n - 1) as f64;
    let row = |i: usize, j: usize| {
        let (a, b) = (place(i), place(j));
        let (growth, frequency, gap, mode) = at(a, b);
        let jump = |a: f64, b: f64| Some(f64::from(u8::from(at(a, b).3 != mode)));
        let jumps = [(i + 1 < n).then(|| jump(place(i + 1), b)), (j + 1 < n).then(|| jump(a, place(j + 1)))];
        let numbers = [a, b, growth, frequency, gap].map(Some);
        let values = numbers.into_iter().chain(jumps.map(Option::flatten)).collect();
        Row { label: None, stable: Some(growth < 0.0), values }
    };
    Branch {
        name: "map".into(),
        kind: BranchKind::Map,
        free: vec!["a".into(), "b".into()],
        columns: names.iter().map(|name| Column { name: (*name).into(), unit: String::new() }).collect(),
        rows: (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| row(i, j)).collect(),
        points: Vec::new(),
        triangles: Vec::new(),
    }
}

fn figure(branch: &Branch) -> String {
    let kind = SpecKind::Map { x: "a".into(), y: "b".into(), column: "frequency".into(), tasks: vec!["map".into()] };
    draw(&Spec { name: "map".into(), title: "A map".into(), kind }, std::slice::from_ref(branch)).unwrap()
}

/// The corners of all polygons as wide as a band may be.
fn bands(svg: &str) -> BTreeSet<String> {
    let points = svg.split("<polygon ").skip(2).filter_map(|text| text.split("points=\"").nth(1)?.split('"').next());
    let wide = |text: &&str| {
        let x: Vec<f64> =
            text.split_whitespace().map(|pair| pair.split(',').next().unwrap().parse().unwrap()).collect();
        let (low, high) = x.iter().fold((f64::MAX, 0.0_f64), |(low, high), x| (low.min(*x), high.max(*x)));
        high - low > 1000.0
    };
    points.filter(wide).map(str::to_owned).collect()
}

#[test]
fn a_figure_of_ten_thousand_points_is_small() {
    let branch = synthetic(100, |a, b| {
        let growth = 1.3 - 3.0 * ((a - 0.5).powi(2) + (b - 0.5).powi(2)) - 0.8 * (9.0 * a).sin() * (8.0 * b).cos();
        (growth, 5.0 + 3.0 * (12.0 * a).sin() + 2.0 * (11.0 * b).cos() + a * b, 1.0, 0)
    });
    let svg = figure(&branch);
    assert!(svg.len() < 200_000, "{} bytes", svg.len());
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert!(bands(&svg).len() >= 6);
}

/// 10 on one side of a circle, 100 on the other: no band in between, and the circle is round.
#[test]
fn contours_do_not_cross_a_jump() {
    let lead = |a: f64, b: f64| (a - 0.5).hypot(b - 0.5) - 0.31;
    let branch = synthetic(30, |a, b| {
        let inside = lead(a, b) < 0.0;
        (1.0, if inside { 100.0 } else { 10.0 }, lead(a, b).abs(), i32::from(inside))
    });
    let svg = figure(&branch);
    let bands = bands(&svg);
    assert_eq!(bands.len(), 2, "the whole square and the disc");
    let area = |band: &String| -> f64 {
        let read = |pair: &str| {
            let (x, y) = pair.split_once(',').unwrap();
            (x.parse::<f64>().unwrap(), y.parse::<f64>().unwrap())
        };
        let points: Vec<(f64, f64)> = band.split_whitespace().map(read).collect();
        let next = points.iter().cycle().skip(1);
        points.iter().zip(next).map(|(p, q)| 0.5 * (p.0 * q.1 - q.0 * p.1)).sum::<f64>().abs()
    };
    let mut areas: Vec<f64> = bands.iter().map(area).collect();
    areas.sort_by(f64::total_cmp);
    let ratio = areas[0] / areas[1];
    assert!((ratio / (PI * 0.31 * 0.31) - 1.0).abs() < 0.01, "{ratio}");
}

#[test]
fn bad_input_is_named() {
    let base = "[[task]]\nname = \"straight\"\nkind = \"equilibria\"\nfree = \"p\"\nrange = [0, 400]\ndetect = [\"HB\"]\n\
                [[task]]\nname = \"onset\"\nkind = \"hopf-curve\"\nfrom = \"straight/HB1\"\nfree = [\"p\", \"L\"]\n\
                range = { L = [4, 30] }\n";
    let map = over("k_N", [1.0, 10.0], [0.0, 10.0], [2, 2], "log = [\"k_N\"]");
    let figure = "\n[[figure]]\nname = \"map\"\nkind = \"map\"\ntasks = [\"map\"]";
    let refused = |sets: &[&str], wanted: &str| {
        let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
        let text = format!("{HEAD}{base}{map}{figure}");
        let scene = Scene::parse(&text, Path::new("maps.toml"), &sets);
        let message = match &scene {
            Err(error) => error.to_string(),
            Ok(scene) => hopfline::run::check(scene, &[]).map_or_else(|error| error.to_string(), |()| String::new()),
        };
        assert!(message.contains(wanted), "{message:?} lacks {wanted:?}");
    };
    refused(&[], "");
    refused(&["task.map.free=[\"kN\", \"p\"]"], "unknown free parameter \"k_N\"");
    refused(
        &["task.map.free=[\"kN\", \"p\"]", "task.map.log=[]", "task.map.range={ kN = [1, 2], p = [0, 1] }"],
        "unknown parameter \"kN\" (did you mean \"k_N\"?)",
    );
    refused(&["task.map.free=[\"p\"]"], "two names");
    refused(&["task.map.free=[\"p\", \"p\"]"], "given twice");
    refused(&["task.map.range={ p = [0, 10] }"], "the range of \"k_N\" is missing");
    refused(&["task.map.range={ k_N = [0, 10], p = [0, 10] }"], "ends greater than 0 (the parameter is logarithmic)");
    refused(&["task.map.range={ k_N = [2, 2], p = [0, 10] }"], "two different ends");
    refused(&["task.map.log=[]", "task.map.range={ k_N = [-1, 2], p = [0, 10] }"], "must be >= 0");
    refused(&["task.map.grid=[1, 5]"], "is 1; allowed: whole numbers from 2 to 2000");
    refused(&["task.map.grid=50"], "two whole numbers");
    refused(&["task.map.grid=[5, 5, 5]"], "two whole numbers");
    refused(&["task.map.max_points=5"], "unknown key of a map task \"max_points\"");
    refused(&["task.onset.grid=[5, 5]"], "unknown key of a hopf-curve task \"grid\"");
    refused(&["task.onset.from=\"map/HB1\""], "comes later");
    refused(&["figure.map.column=\"gap\""], "unknown column of a map \"gap\"");
    refused(&["figure.map.tasks=[\"onset\"]"], "must be of kind \"map\", but \"onset\" is of kind \"hopf-curve\"");
    refused(&["figure.map.tasks=[\"map\", \"straight\"]"], "only tasks of kind \"hopf-curve\"");
    refused(
        &["figure.map.tasks=[\"map\", \"onset\"]"],
        "the map is over k_N and p, but the curve \"onset\" is in L and p",
    );
    refused(&["figure.map.kind=\"diagram\"", "figure.map.x=\"p\"", "figure.map.y=\"growth\""], "write kind = \"map\"");
}
