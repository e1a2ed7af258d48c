//! Figures of synthetic branches: valid SVG, with what must be seen in it, whatever the numbers.
//!
//! Each figure is also written to `target/tmp/figures`, to be looked at.

use hopfline::branch::{Array, Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use hopfline::plot::{PlotError, Spec, SpecKind, draw};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

const HOPF: f64 = 338.889485397848;

fn branch(name: &str, kind: BranchKind, columns: &[(&str, &str)]) -> Branch {
    let column = |&(name, unit): &(&str, &str)| Column { name: name.into(), unit: unit.into() };
    Branch {
        name: name.into(),
        kind,
        free: vec!["p".into()],
        columns: columns.iter().map(column).collect(),
        rows: vec![],
        points: vec![],
        triangles: Vec::new(),
    }
}

fn add(branch: &mut Branch, label: Option<&str>, stable: Option<bool>, values: &[f64]) {
    branch.rows.push(Row {
        label: label.map(str::to_owned),
        stable,
        values: values.iter().copied().map(Some).collect(),
    });
}

/// The label of a row at which the parameter has one of some values.
fn label_at<'a>(p: f64, labels: &[(f64, &'a str)]) -> Option<&'a str> {
    labels.iter().find(|(at, _)| *at == p).map(|(_, label)| *label)
}

fn sorted(mut parameters: Vec<f64>) -> Vec<f64> {
    parameters.sort_by(f64::total_cmp);
    parameters
}

/// Eigenvalues of one of five pairs: real until `meet`, complex after it.
fn pair(n: usize, p: f64) -> ([f64; 2], [f64; 2]) {
    let size = (n as f64 + 1.0).powi(3);
    let meet = 120.0 + 75.0 * n as f64;
    let middle = -70.0 * size + 0.3 * p * (n as f64 + 0.5).powi(2) + 0.1 * p;
    let square = 60.0 * 60.0 * size * (1.0 - p / meet);
    let root = square.abs().sqrt();
    if square > 0.0 { ([middle + root, middle - root], [0.0, 0.0]) } else { ([middle, middle], [root, -root]) }
}

fn straight() -> Branch {
    let mut columns = vec![("p", "pN µm⁻¹"), ("tip_deflection", "µm")];
    let names: Vec<String> = (1..=10).flat_map(|i| [format!("re_{i}"), format!("im_{i}")]).collect();
    for name in &names {
        let unit = if name.starts_with("re") { "1/s" } else { "rad/s" };
        columns.push((name, unit));
    }
    let mut straight = branch("straight", BranchKind::Equilibria, &columns);
    let special = [
        (0.0, "EP1"),
        (120.0, "XP1"),
        (195.0, "XP2"),
        (270.0, "XP3"),
        (HOPF, "HB1"),
        (345.0, "XP4"),
        (420.0, "XP5"),
        (500.0, "EP2"),
    ];
    let mut parameters: Vec<f64> = (0..=500).map(f64::from).collect();
    parameters.push(HOPF);
    for p in sorted(parameters) {
        let mut values = vec![p, 0.0];
        for n in 0..5 {
            let (re, im) = pair(n, p);
            // A shift that brings the first pair to the imaginary axis at the Hopf point.
            let shift = if n == 0 { -pair(0, HOPF).0[0] * p / HOPF } else { 0.0 };
            values.extend([re[0] + shift, im[0], re[1] + shift, im[1]]);
        }
        add(&mut straight, label_at(p, &special), Some(p <= HOPF), &values);
    }
    straight
}

/// A travelling bend at 16 phases.
fn wave(amplitude: f64) -> BTreeMap<String, Array> {
    let (phases, positions) = (16, 60);
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for phase in 0..phases {
        let (mut at_x, mut at_y) = (0.0, 0.0);
        for i in 0..positions {
            x.push(at_x);
            y.push(at_y);
            let s = f64::from(i) / f64::from(positions);
            let angle = amplitude * s * (TAU * (f64::from(phase) / f64::from(phases) - s)).sin();
            at_x += 12.0 / f64::from(positions) * angle.cos();
            at_y += 12.0 / f64::from(positions) * angle.sin();
        }
    }
    let shape = vec![phases as usize, positions as usize];
    let array = |data| Array { shape: shape.clone(), data };
    BTreeMap::from([("wave_x".into(), array(x)), ("wave_y".into(), array(y))])
}

fn beat() -> Branch {
    let columns = [("p", "pN µm⁻¹"), ("frequency", "Hz"), ("max tip_deflection", "µm"), ("min tip_deflection", "µm")];
    let mut beat = branch("beat", BranchKind::Cycles, &columns);
    let special = [(338.9, "EP1"), (340.0, "UZ1"), (360.0, "UZ2"), (420.0, "EP2")];
    let end = (81.1f64 / 15.6).sqrt();
    let mut parameters: Vec<f64> = (0..48).map(|i| 338.9 + 15.6 * (end * f64::from(i) / 48.0).powi(2)).collect();
    parameters.extend([340.0, 360.0, 420.0]);
    for p in sorted(parameters) {
        let y = ((p - 338.9) / 15.6).sqrt();
        add(&mut beat, label_at(p, &special), Some(true), &[p, 32.3 - 0.02 * y, y, -y]);
    }
    for (row, label) in [(340.0, "UZ1"), (360.0, "UZ2")].map(|(p, label)| {
        let row = beat.rows.iter().position(|r| r.values[0] == Some(p));
        (row.unwrap(), label)
    }) {
        beat.points.push(SpecialPoint {
            label: format!("beat/{label}"),
            kind: Kind::UZ,
            row,
            parameters: BTreeMap::new(),
            values: BTreeMap::new(),
            errors: BTreeMap::new(),
            arrays: wave(if label == "UZ1" { 0.25 } else { 1.2 }),
        });
    }
    beat
}

/// A branch with two folds, unstable between them.
fn folded() -> Branch {
    let mut folded = branch("buckled", BranchKind::Cycles, &[("p", "pN µm⁻¹"), ("max tip_deflection", "µm")]);
    for i in 0..=200 {
        let y = -0.5 + f64::from(i) * 0.015;
        let p = 100.0 + 90.0 * ((y - 1.0).powi(3) - 0.8 * (y - 1.0));
        let label = [(66, "LP1"), (134, "LP2"), (90, "MX1")];
        let label = label.iter().find(|(row, _)| *row == i).map(|(_, l)| *l);
        add(&mut folded, label, Some(!(66..134).contains(&i)), &[p, y]);
    }
    folded
}

fn diagram(name: &str, y: &[&str]) -> Spec {
    Spec {
        name: name.into(),
        title: String::new(),
        kind: SpecKind::Diagram { x: "p".into(), y: y.iter().map(|y| y.to_string()).collect(), tasks: vec![] },
    }
}

fn eigenvalues(name: &str) -> Spec {
    Spec { name: name.into(), title: String::new(), kind: SpecKind::Eigenvalues { x: "p".into(), tasks: vec![] } }
}

fn waveform(name: &str, point: &str) -> Spec {
    Spec {
        name: name.into(),
        title: String::new(),
        kind: SpecKind::Waveform { point: point.into(), unit: "µm".into() },
    }
}

/// Draws twice, checks what holds for every figure, and keeps the file.
fn checked(spec: &Spec, branches: &[Branch]) -> String {
    let svg = draw(spec, branches).unwrap();
    assert_eq!(svg, draw(spec, branches).unwrap(), "not deterministic");
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("figures");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(format!("{}.svg", spec.name)), &svg).unwrap();
    assert!(svg.starts_with("<svg xmlns=") && svg.trim_end().ends_with("</svg>"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{}", spec.name);
    assert!(!svg.contains("2147483647") && !svg.contains("-2147483648"), "{}", spec.name);
    assert!(svg.len() < 150_000, "{}: {} bytes", spec.name, svg.len());
    well_formed(&svg);
    inside_the_page(&svg);
    svg
}

/// Every tag is closed, in order, and text has no bare `<` or `&`.
fn well_formed(svg: &str) {
    let mut open: Vec<&str> = Vec::new();
    for piece in svg.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').expect("a tag that does not end");
        for (at, _) in text.match_indices('&') {
            let entity = &text[at..];
            assert!(["&amp;", "&lt;", "&gt;", "&quot;", "&apos;"].iter().any(|e| entity.starts_with(e)));
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        let name = tag.split([' ', '/']).find(|part| !part.is_empty()).unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty());
}

fn inside_the_page(svg: &str) {
    let size = attribute(svg, "viewBox");
    let size: Vec<f64> = size.split(' ').map(|n| n.parse().unwrap()).collect();
    for line in svg.lines().filter(|l| l.starts_with("<poly")) {
        for pair in attribute(line, "points").split_whitespace() {
            let (x, y) = pair.split_once(',').unwrap();
            let (x, y): (f64, f64) = (x.parse().unwrap(), y.parse().unwrap());
            assert!(x >= 0.0 && x <= size[2] && y >= 0.0 && y <= size[3], "{pair}");
        }
    }
}

fn attribute<'a>(text: &'a str, name: &str) -> &'a str {
    let begin = text.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
    text[begin..].split('"').next().unwrap()
}

/// How often a text is written in a figure.
fn count(svg: &str, text: &str) -> usize {
    svg.lines().filter(|line| *line == text).count()
}

fn lines_of(svg: &str, colour: &str) -> usize {
    let stroke = format!("stroke=\"{colour}\"");
    svg.lines().filter(|l| l.starts_with("<polyline") && l.contains(&stroke)).count()
}

#[test]
fn a_bifurcation_diagram() {
    let mut spec = diagram("diagram", &["max tip_deflection", "min tip_deflection"]);
    spec.title = "Two-doublet flagellum under uniform dynein load".into();
    let svg = checked(&spec, &[straight(), beat()]);
    for text in ["HB1", "UZ1", "UZ2", "straight", "beat", "stable", "unstable", "p (pN µm⁻¹)"] {
        assert_eq!(count(&svg, text), 1, "{text}");
    }
    assert_eq!(count(&svg, "max, min tip deflection (µm)"), 1);
    assert_eq!(count(&svg, "EP1"), 0);
    assert!(lines_of(&svg, "#000000") > 10, "the unstable part is dashed");
}

#[test]
fn folds_and_several_branches() {
    let spec = diagram("folds", &["max tip_deflection"]);
    let svg = checked(&spec, &[straight(), folded(), beat()]);
    for text in ["LP1", "LP2", "MX1", "buckled", "fold (LP)"] {
        assert_eq!(count(&svg, text), 1, "{text}");
    }
}

#[test]
fn tasks_choose_branches() {
    let mut spec = diagram("frequency", &["frequency"]);
    spec.kind =
        SpecKind::Diagram { x: "max tip_deflection".into(), y: vec!["frequency".into()], tasks: vec!["beat".into()] };
    let svg = checked(&spec, &[straight(), beat()]);
    assert_eq!((count(&svg, "straight"), count(&svg, "frequency (Hz)")), (0, 1));
}

#[test]
fn eigenvalue_branches() {
    let svg = checked(&eigenvalues("eigenvalues"), &[straight()]);
    assert_eq!((count(&svg, "HB1"), count(&svg, "XP1")), (2, 0));
    assert_eq!((count(&svg, "Re λ (1/s)"), count(&svg, "Im λ (rad/s)")), (1, 1));
}

#[test]
fn waveforms() {
    for point in ["UZ1", "UZ2"] {
        let spec = waveform(&format!("waveform-{point}"), &format!("beat/{point}"));
        let svg = checked(&spec, &[straight(), beat()]);
        assert_eq!((count(&svg, "x (µm)"), count(&svg, "phase of the period")), (1, 1));
        assert_eq!(lines_of(&svg, "#004CA9"), 1);
    }
}

#[test]
fn upright_and_pointlike_waveforms() {
    let mut beat = beat();
    let arrays = &mut beat.points[0].arrays;
    let (x, y) = (arrays["wave_x"].clone(), arrays["wave_y"].clone());
    arrays.insert("wave_x".into(), y);
    arrays.insert("wave_y".into(), x);
    for array in beat.points[1].arrays.values_mut() {
        array.data.fill(3e9);
    }
    checked(&waveform("waveform-upright", "UZ1"), &[beat.clone()]);
    checked(&waveform("waveform-pointlike", "UZ2"), &[beat]);
}

#[test]
fn sizes_from_tiny_to_huge() {
    for (name, size) in [("tiny", 1e-12), ("huge", 1e9), ("monstrous", 1e290)] {
        let mut branches = [straight(), beat()];
        for row in branches.iter_mut().flat_map(|b| &mut b.rows) {
            for value in row.values.iter_mut().flatten() {
                *value *= size;
            }
        }
        let spec = diagram(&format!("diagram-{name}"), &["max tip_deflection"]);
        let svg = checked(&spec, &branches);
        assert_eq!(svg.matches("×10").count(), 2, "{name}");
        checked(&eigenvalues(&format!("eigenvalues-{name}")), &branches);
    }
}

#[test]
fn a_single_row_and_equal_values() {
    let (mut one, mut flat) = (straight(), straight());
    one.rows.truncate(1);
    for row in &mut flat.rows {
        (row.label, row.stable) = (None, None);
        row.values.fill(Some(7.25));
    }
    for (name, branch) in [("single", one), ("flat", flat)] {
        let branches = [branch];
        checked(&diagram(&format!("diagram-{name}"), &["tip_deflection"]), &branches);
        checked(&eigenvalues(&format!("eigenvalues-{name}")), &branches);
    }
}

#[test]
fn gaps_and_numbers_that_are_none() {
    let mut branches = [straight(), beat()];
    for branch in &mut branches {
        for (i, row) in branch.rows.iter_mut().enumerate() {
            let column = i % row.values.len();
            row.values[column] = match i % 7 {
                0 => None,
                1 => Some(f64::NAN),
                2 => Some(f64::INFINITY),
                3 => Some(-f64::MAX),
                _ => row.values[column],
            };
            if i % 50 == 0 {
                row.values.truncate(2);
            }
        }
    }
    checked(&diagram("diagram-gaps", &["max tip_deflection"]), &branches);
    checked(&eigenvalues("eigenvalues-gaps"), &branches);
}

#[test]
fn hundreds_of_special_points_drop_labels() {
    let mut branches = [straight(), beat()];
    for (i, row) in branches[0].rows.iter_mut().enumerate() {
        let kind = ["HB", "LP", "XP", "UZ"][i % 4];
        row.label = (i % 2 == 0 || i % 5 == 0).then(|| format!("{kind}{i}"));
    }
    let svg = checked(&diagram("diagram-crowded", &["max tip_deflection"]), &branches);
    assert!(svg.matches("\nHB").count() < 60);
    checked(&eigenvalues("eigenvalues-crowded"), &branches);
}

#[test]
fn many_branches_and_awkward_names() {
    let branches: Vec<Branch> = (0..30)
        .map(|i| {
            let mut branch = beat();
            branch.name = format!("<beat> & \"{i}\" \u{7} of a rather long name that goes on and on");
            for row in &mut branch.rows {
                row.values[2] = row.values[2].map(|y| y + 0.3 * f64::from(i));
            }
            branch
        })
        .collect();
    let mut spec = diagram("diagram-many", &["max tip_deflection"]);
    spec.title = "A <long> title & more ".repeat(9);
    checked(&spec, &branches);
}

#[test]
fn unknown_stability_is_neither_solid_nor_dashed() {
    let mut branches = [straight(), beat()];
    for row in branches.iter_mut().flat_map(|b| &mut b.rows) {
        row.stable = None;
    }
    let svg = checked(&diagram("diagram-unknown", &["max tip_deflection"]), &branches);
    assert_eq!((count(&svg, "stability unknown"), count(&svg, "unstable")), (1, 0));
    assert_eq!(lines_of(&svg, "#656565"), 1);
}

/// A sheet folded over itself, on which the first Lyapunov coefficient changes sign and is unknown in a corner.
fn sheet(scale: f64) -> Branch {
    let columns =
        [("p", "pN µm⁻¹"), ("L", "µm"), ("k_N", ""), ("log10 k_N", ""), ("frequency", "Hz"), ("lyapunov", "")];
    let mut sheet = branch("surface", BranchKind::HopfSurface, &columns);
    sheet.free = ["p", "L", "k_N"].map(String::from).to_vec();
    const SIDE: usize = 24;
    for i in 0..=SIDE {
        for j in 0..=SIDE {
            let (s, t) = (i as f64 / SIDE as f64 * 2.0 - 1.0, j as f64 / SIDE as f64 * 2.0 - 1.0);
            let fold = s * s * s - 0.45 * s;
            let l1 = s + 0.4 * t;
            add(
                &mut sheet,
                None,
                Some(l1 < 0.0),
                &[scale * s, fold + 0.3 * t, 10f64.powf(t), t, 20.0 + 15.0 * t * s, l1],
            );
            if i + j < 8 {
                let row = sheet.rows.last_mut().unwrap();
                (row.stable, row.values[5]) = (None, None);
            }
            if i < SIDE && j < SIDE {
                let [a, b] = [i * (SIDE + 1) + j, (i + 1) * (SIDE + 1) + j];
                sheet.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
    }
    sheet
}

fn surface(name: &str, view: Option<[f64; 2]>) -> Spec {
    let kind = SpecKind::Surface { tasks: vec!["surface".into()], view };
    Spec { name: name.into(), title: "A folded sheet".into(), kind }
}

#[test]
fn a_folded_surface_from_all_sides() {
    for (name, view) in [
        ("surface", None),
        ("surface-side", Some([20.0, 15.0])),
        ("surface-back", Some([160.0, 40.0])),
        ("surface-above", Some([-90.0, 90.0])),
        ("surface-level", Some([0.0, 0.0])),
    ] {
        let svg = checked(&surface(name, view), &[sheet(1.0)]);
        for word in ["supercritical", "subcritical", "unknown", "frequency (Hz)", "log10 k N"] {
            assert!(svg.contains(word), "{name} lacks {word}");
        }
        // From above, the fold hides where the criticality changes.
        assert_eq!(svg.contains("generalised Hopf"), name != "surface-above", "{name}");
        // The sheet's triangles are all there, some of them cut in two.
        assert!(svg.matches("<polygon").count() > sheet(1.0).triangles.len());
    }
    checked(&surface("surface-huge", None), &[sheet(1e250)]);
    checked(&surface("surface-flat", None), &[sheet(0.0)]);
    let mut bare = sheet(1.0);
    bare.triangles.clear();
    assert!(matches!(draw(&surface("none", None), &[bare]), Err(PlotError::NoColumn { .. })));
}

#[test]
fn what_is_missing_is_named() {
    let branches = [straight(), beat()];
    let message = |spec: &Spec| draw(spec, &branches).unwrap_err().to_string();
    let wrong = message(&diagram("d", &["max speed"]));
    assert!(wrong.contains("`max speed`") && wrong.contains("`max tip_deflection`"), "{wrong}");
    let wrong = message(&waveform("w", "beat/UZ7"));
    assert!(wrong.contains("`beat/UZ7`") && wrong.contains("`beat/UZ2`"), "{wrong}");
    let mut spec = eigenvalues("e");
    spec.kind = SpecKind::Eigenvalues { x: "p".into(), tasks: vec!["onset".into()] };
    let wrong = message(&spec);
    assert!(wrong.contains("`onset`") && wrong.contains("`straight`"), "{wrong}");
    assert!(matches!(draw(&eigenvalues("e"), &[beat()]), Err(PlotError::NoColumn { .. })));
    let mut beat = beat();
    beat.points[0].arrays.remove("wave_y");
    let none = draw(&waveform("w", "beat/UZ1"), &[beat]);
    assert!(matches!(none, Err(PlotError::NoWaveform { .. })));
}

#[test]
fn a_spec_survives_json() {
    let seen = [surface("s", None), surface("s", Some([30.0, 20.0]))];
    for spec in [diagram("d", &["a"]), eigenvalues("e"), waveform("w", "beat/UZ1")].into_iter().chain(seen) {
        let text = serde_json::to_string(&spec).unwrap();
        assert_eq!(serde_json::from_str::<Spec>(&text).unwrap(), spec);
    }
    let old = r#"{"name":"w","title":"","kind":{"kind":"waveform","point":"HB1"}}"#;
    assert!(serde_json::from_str::<Spec>(old).is_ok());
}
