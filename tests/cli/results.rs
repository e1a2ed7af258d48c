//! What a run leaves behind: statuses, counters, columns, and the same numbers from any number of threads.

use super::{Desk, assert_same_results, assert_whole, count, is_left_over, point, task};
use std::fs;

#[test]
fn everything_announced_is_there_and_whole() {
    let desk = Desk::with_small(&[]);
    let table = desk.succeed(&["run", "small.toml", "--quiet"]);
    for word in ["straight: done", "straight/HB1", "supercritical", "beat/UZ1", "output/small"] {
        assert!(table.contains(word), "no {word:?} in {table}");
    }
    let files = desk.files("output/small");
    for wanted in [
        "branches/beat.csv",
        "branches/straight.csv",
        "figures/diagram.svg",
        "figures/eigenvalues.svg",
        "figures/shape.svg",
        "points/beat/UZ1.npz",
        "points/straight/HB1.npz",
        "run.log",
        "summary.json",
    ] {
        assert!(files.iter().any(|name| name == wanted), "no {wanted} in {files:?}");
    }
    assert!(!files.iter().any(|name| is_left_over(name)), "{files:?}");
    assert_whole(&desk, "output/small");
    let summary = desk.summary("output/small");
    assert_eq!(summary["branches"][1]["rows"].as_u64().unwrap() as usize, {
        fs::read_to_string(desk.path("output/small/branches/beat.csv")).unwrap().lines().count() - 1
    });
    assert_eq!(point(&summary, "beat/UZ1").unwrap()["parameters"]["p"], 352.0);
}

#[test]
fn temporary_files_of_a_killed_run_are_swept() {
    let desk = Desk::with_small(&[]);
    fs::create_dir_all(desk.path("output/small/points/beat")).unwrap();
    for name in ["output/small/.hopfline-abc.tmp", "output/small/points/beat/.hopfline-xyz.tmp"] {
        desk.write(name, "half a file");
    }
    desk.succeed(&["run", "small.toml", "--quiet", "--only", "straight"]);
    assert!(!desk.files("output/small").iter().any(|name| is_left_over(name)));
}

#[test]
fn threads_do_not_change_a_bit() {
    let desk = Desk::with_small(&[]);
    desk.succeed(&["run", "small.toml", "--quiet", "--threads", "1", "--out", "one"]);
    desk.succeed(&["run", "small.toml", "--quiet", "--threads", "2", "--out", "two"]);
    assert_same_results(&desk, "one/small", "two/small");
}

#[test]
fn a_start_that_is_not_found_fails_its_task_alone() {
    let desk = Desk::with_small(&[("straight/HB1", "straight/HB9")]);
    let finished = desk.hopfline(&["run", "small.toml", "--quiet"]);
    assert_eq!(finished.code, Some(1), "{}", finished.stderr);
    assert!(finished.stdout.contains("beat: FAILED"), "{}", finished.stdout);
    let summary = desk.summary("output/small");
    assert_eq!(task(&summary, "beat")["status"], "failed");
    let reason = task(&summary, "beat")["reason"].as_str().unwrap();
    assert!(reason.contains("straight/HB9") && reason.contains("straight/HB1"), "{reason}");
    assert_eq!(task(&summary, "straight")["status"], "done");
    assert!(point(&summary, "straight/HB1").is_some());
    let files = desk.files("output/small");
    assert!(files.iter().any(|name| name == "branches/straight.csv"), "{files:?}");
    assert!(files.iter().any(|name| name == "figures/eigenvalues.svg"), "{files:?}");
}

#[test]
fn a_start_outside_the_range_fails_its_task() {
    let desk = Desk::with_small(&[("[340, 354]", "[360, 370]"), ("[352]", "[365]")]);
    let finished = desk.hopfline(&["run", "small.toml", "--quiet"]);
    assert_eq!(finished.code, Some(1), "{}", finished.stderr);
    let summary = desk.summary("output/small");
    let reason = task(&summary, "beat")["reason"].as_str().unwrap();
    assert!(reason.contains("does not lie inside the range 360 to 370"), "{reason}");
}

#[test]
fn a_missed_expectation_is_shown_and_fails_the_run() {
    const EXPECT: &str = "\n[expect]\n\
        \"straight/HB1\".p = { value = 300, tolerance = 1e-3 }\n\
        \"straight/EP1\".p = { value = 340, tolerance = 1e-12 }\n\
        \"straight/HB2\".p = { value = 500, tolerance = 1e-3 }\n";
    let desk = Desk::with_small(&[("point = \"beat/UZ1\"\n", &format!("point = \"beat/UZ1\"\n{EXPECT}"))]);
    let finished = desk.hopfline(&["run", "small.toml", "--quiet", "--only", "straight"]);
    assert_eq!(finished.code, Some(1), "{}", finished.stderr);
    let line = |key: &str| finished.stdout.lines().find(|line| line.contains(key)).unwrap().to_owned();
    assert!(line("straight/HB1.p").contains("MISSED") && line("straight/HB1.p").contains("expected 300"));
    assert!(line("straight/HB2.p").contains("MISSED") && line("straight/HB2.p").contains("not found"));
    assert!(line("straight/EP1.p").contains("met") && !line("straight/EP1.p").contains("MISSED"));
    let summary = desk.summary("output/small");
    let met: Vec<bool> = summary["expect"].as_array().unwrap().iter().map(|e| e["met"].as_bool().unwrap()).collect();
    assert_eq!(met, [false, true, false]);
    assert_eq!(task(&summary, "straight")["status"], "done");
    // They hold for the scene as written: another length is another study.
    let length = ["run", "small.toml", "--quiet", "--only", "straight", "--set", "parameters.L=11.9"];
    let other = desk.succeed(&length);
    assert!(!other.contains("MISSED"), "{other}");
}

#[test]
fn what_is_not_asked_for_is_not_computed() {
    const PLAIN: &[(&str, &str)] = &[
        ("spectrum = 4\ndetect = [\"HB\"]\n", ""),
        ("tasks = [\"straight\"]\n", "tasks = [\"straight\"]\n#"),
        ("kind = \"eigenvalues\"\n", "x = \"p\"\ny = \"tip_deflection\"\n"),
    ];
    let desk = Desk::with_small(PLAIN);
    // Without a Hopf point there is nothing for the cycles to start from.
    let scene = fs::read_to_string(desk.path("small.toml")).unwrap();
    let cycles = scene.split("[[task]]").nth(2).unwrap().split("[[figure]]").next().unwrap();
    let scene = scene.replace(&format!("[[task]]{cycles}"), "");
    let scene = scene.split("[[figure]]").next().unwrap().to_owned();
    desk.write("small.toml", &scene);
    desk.succeed(&["run", "small.toml", "--quiet"]);
    let summary = desk.summary("output/small");
    assert_eq!(count(&summary, "straight", "spectra"), 0);
    assert!(count(&summary, "straight", "factorisations") > 0);
    let head = fs::read_to_string(desk.path("output/small/branches/straight.csv")).unwrap();
    assert_eq!(head.lines().next().unwrap(), "label,stable,p [pN µm⁻¹]");
    assert!(head.lines().nth(1).unwrap().starts_with("EP1,,340"), "{head}");
}

#[test]
fn errors_and_multipliers_cost_only_where_asked_for() {
    let desk = Desk::with_small(&[]);
    desk.succeed(&["run", "small.toml", "--quiet", "--out", "with"]);
    let bare = ["run", "small.toml", "--quiet", "--out", "without"];
    desk.succeed(&[&bare[..], &["--set", "task.beat.errors=false", "--set", "task.beat.multipliers=0"]].concat());
    let (with, without) = (desk.summary("with/small"), desk.summary("without/small"));
    let factorisations = |summary| count(summary, "beat", "factorisations");
    assert!(factorisations(&without) < factorisations(&with));
    let head = |folder: &str| {
        let text = fs::read_to_string(desk.path(folder).join("small/branches/beat.csv")).unwrap();
        text.lines().next().unwrap().to_owned()
    };
    assert!(head("with").contains("mu_1_re") && head("with").contains("error frequency"), "{}", head("with"));
    assert!(!head("without").contains("mu_") && !head("without").contains("error"), "{}", head("without"));
    let (asked, plain) = (point(&with, "beat/UZ1").unwrap(), point(&without, "beat/UZ1").unwrap());
    assert!(plain["errors"].as_object().unwrap().is_empty());
    assert_eq!(asked["values"]["frequency"], plain["values"]["frequency"]);
}
