//! `hopfline bench`: a small study as a user runs it, and studies that are wrong.

use super::{Desk, changed, json};

/// The van der Pol cycle at mu = 1; the second family has a setting that gets nowhere.
const STUDY: &str = r#"
title = "A small study"

[model]
equations = """
x' = y
y' = (mu - x^2)*y - x
"""
symmetry = "x -> -x, y -> -y"

[model.parameters]
mu = 0

[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [-0.1, 0.1]
max_step = 0.1
detect = ["HB"]

[[task]]
name = "cycles"
kind = "cycles"
from = "rest/HB1"
free = "mu"
range = [0, 1.001]
degree = 2
values = { mu = [1] }

[bench]
point = "cycles/UZ1"

[bench.reference]
period = { value = 6.66328685932313, error = 1e-14, source = "Andersen and Geer 1982" }

[bench.reference."max x"]
set = { "task.cycles.intervals" = 40, "task.cycles.degree" = 5 }
check = { "task.cycles.degree" = 4 }

[[bench.family]]
name = "degree-2"
vary = { "task.cycles.intervals" = [10, 20, 40] }

[[bench.family]]
name = "short"
set = { "task.cycles.intervals" = 10 }
vary = { "task.cycles.max_points" = [3, 200], "task.cycles.degree" = [3, 4] }
"#;

#[test]
fn a_study_gives_table_json_and_figures() {
    let desk = Desk::new();
    desk.write("small.toml", STUDY);
    let table = desk.succeed(&["bench", "small.toml", "--out", "out"]);
    let words = [
        "A small study",
        "cores",
        "period = 6.66328685932313 ± 1e-14 (Andersen and Geer 1982)",
        "max x = 2.0086",
        "(intervals = 40, degree = 5; error: difference to intervals = 40, degree = 4)",
        "degree-2 (cycles/UZ1)",
        "intervals = 20",
        "max_points = 3, degree = 3",
        "no cycles/UZ1 (rest end of the range; cycles max_points reached)",
        "in unknowns",
        "seconds to an error",
        "out/bench/small",
    ];
    for word in words {
        assert!(table.contains(word), "no {word:?} in {table}");
    }
    let files = ["bench.json", "figures/max-x.svg", "figures/period.svg", "run.log"];
    assert_eq!(desk.files("out/bench/small"), files);

    let report = json(&desk.path("out/bench/small/bench.json"));
    assert_eq!((&report["bench"], &report["interrupted"]), (&"small".into(), &false.into()));
    assert!(report["machine"]["cores"].as_u64().unwrap() >= 1 && report["machine"]["processor"].is_string());
    assert_eq!(report["quantities"][0]["value"].as_f64(), Some(6.66328685932313));
    let reference = &report["quantities"][1];
    let (value, error) = (reference["value"].as_f64().unwrap(), reference["error"].as_f64().unwrap());
    assert!((value - 2.00861986087).abs() < 1e-7 && error > 0.0 && error < 1e-6, "{reference}");
    let family = &report["families"][0];
    assert_eq!(family["name"], "degree-2");
    let settings = family["settings"].as_array().unwrap();
    assert_eq!(settings.len(), 3);
    let mut before = f64::INFINITY;
    for (line, intervals) in settings.iter().zip([10, 20, 40]) {
        assert_eq!(line["setting"], serde_json::json!([["task.cycles.intervals", intervals.to_string()]]));
        // Half a period: two nodes in each interval, and the last one.
        assert_eq!(line["unknowns"], 2 * (2 * intervals + 1));
        let seconds = &line["seconds"];
        let [least, median, most] = ["least", "median", "most"].map(|name| seconds[name].as_f64().unwrap());
        assert!(0.0 < least && least <= median && median <= most && seconds["runs"].as_u64() >= Some(1), "{seconds}");
        assert!(line["counts"]["factorisations"].as_u64() > Some(0) && line["reason"].is_null());
        let found = &line["found"]["period"];
        let [value, error] = ["value", "error"].map(|name| found[name].as_f64().unwrap());
        assert!((error - (value / 6.66328685932313 - 1.0).abs()).abs() < 1e-14, "{found}");
        assert!(error < before && found["ratio"].as_f64().unwrap() > 0.1, "{found}");
        before = error;
    }
    // Radau points of degree 2 have order 3.
    let order = family["orders"]["period"]["unknowns"]["exponent"].as_f64().unwrap();
    assert!((2.5..4.5).contains(&order), "{order}");
    let coverage = &family["coverage"]["period"];
    assert_eq!(coverage["cases"].as_u64().unwrap() + coverage["undecided"].as_u64().unwrap(), 3);
    // The failed setting is a row, and the next one ran all the same.
    let [failed, ran] = [0, 1].map(|k| &report["families"][1]["settings"][k]);
    assert!(failed["reason"].as_str().unwrap().contains("max_points") && failed["found"] == serde_json::json!({}));
    assert!(ran["reason"].is_null() && ran["found"]["period"]["error"].as_f64().unwrap() < 1e-3);
    let reach = report["reach"].as_array().unwrap();
    let first = reach.iter().find(|line| line["quantity"] == "period").unwrap();
    assert!(first["seconds"]["degree-2"].as_f64().unwrap() > 0.0);

    // The figures are drawn again from the report.
    let (path, before) = (desk.path("out/bench/small/figures/period.svg"), "relative error of period");
    let svg = std::fs::read_to_string(&path).unwrap();
    assert!(svg.contains(before) && svg.contains("degree-2 (order") && !svg.contains("NaN"));
    std::fs::remove_file(&path).unwrap();
    desk.succeed(&["plot", "out/bench/small"]);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), svg);
    // The scene is one that runs as written, too.
    assert!(desk.succeed(&["check", "small.toml"]).contains("study: 2 numbers, 2 families with 5 settings"));
}

#[test]
fn wrong_studies_cost_no_run() {
    let desk = Desk::new();
    let refused = |change: (&str, &str), words: &[&str]| {
        desk.write("wrong.toml", &changed(STUDY, &[change]));
        let finished = desk.hopfline(&["bench", "wrong.toml"]);
        assert_eq!((finished.code, finished.stdout.as_str()), (Some(2), ""), "{change:?}: {}", finished.stderr);
        for word in words {
            assert!(finished.stderr.contains(word), "no {word:?} in {}", finished.stderr);
        }
        assert_eq!(desk.files(""), ["wrong.toml"]);
    };
    refused(("\"max x\"", "\"max z\""), &["max z", "observable or column", "allowed: x, y"]);
    refused(("[10, 20, 40]", "[10, 20, 1]"), &["wrong.toml:", "task.cycles.intervals", "from 2 to 10000"]);
    refused(("\"task.cycles.max_points\"", "\"task.cycle.max_points\""), &["unknown task \"cycle\"", "rest, cycles"]);
    // What only the model knows is found before anything is computed, too.
    refused(
        ("\"task.cycles.max_points\" = [3, 200]", "\"task.cycles.free\" = [\"mu\", \"nu\"]"),
        &["nu", "allowed: mu"],
    );
    desk.write("plain.toml", &STUDY[..STUDY.find("[bench]").unwrap()]);
    let finished = desk.hopfline(&["bench", "plain.toml"]);
    assert!(finished.code == Some(2) && finished.stderr.contains("no section [bench]"), "{}", finished.stderr);
    for arguments in [&["bench"][..], &["bench", "onset"]] {
        let finished = desk.hopfline(arguments);
        assert!(finished.code == Some(2) && finished.stderr.contains("problems/bench"), "{}", finished.stderr);
    }
}
