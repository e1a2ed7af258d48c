//! The commands beside `run`, and its options.

use super::{Desk, point, task};
use std::fs;

#[test]
fn check_tells_the_plan_and_computes_nothing() {
    let desk = Desk::with_small(&[]);
    let plan = desk.succeed(&["check", "small.toml"]);
    for word in [
        "model two-doublet with 20 unknowns",
        "b_N",
        "= tau_c * k_N",
        "(free)",
        "task straight: equilibria in p from 340 to 400",
        "computed: Hopf points",
        "left out: folds",
        "task beat: cycles in p",
        "6 intervals of degree 3",
        "left out: the second half of each period",
    ] {
        assert!(plan.contains(word), "no {word:?} in {plan}");
    }
    let plan = desk.succeed(&["check", "small.toml", "--set", "parameters.k_3N=0"]);
    assert!(plan.contains("terms left out, their coefficient being zero: k_3N"), "{plan}");
    assert_eq!(desk.files(""), ["small.toml"]);
}

#[test]
fn models_are_listed_and_described() {
    let desk = Desk::new();
    assert!(desk.succeed(&["models"]).starts_with("two-doublet "));
    let text = desk.succeed(&["models", "two-doublet"]);
    for word in [
        "functions",
        "\"minimal\" | \"mixed\"",
        "elements",
        "\"uniform\" | \"distal\"",
        "k_N",
        "10000",
        "pN µm⁻²",
        ">= 0",
        "s0",
        "tip_deflection",
    ] {
        assert!(text.contains(word), "no {word:?} in {text}");
    }
}

#[test]
fn a_new_scene_passes_and_runs() {
    let desk = Desk::new();
    assert_eq!(desk.succeed(&["new", "study", "--model", "two-doublet"]), "study.toml\n");
    desk.succeed(&["check", "study.toml"]);
    // Coarser and shorter than it is written, to be quick.
    let table = desk.succeed(&[
        "run",
        "study.toml",
        "--quiet",
        "--set",
        "model.functions=10",
        "--set",
        "task.straight.range=[340, 400]",
        "--set",
        "task.beat.range=[340, 352]",
        "--set",
        "task.beat.intervals=6",
        "--set",
        "task.beat.degree=3",
    ]);
    assert!(table.contains("straight/HB1") && table.contains("beat/EP1"), "{table}");
    let again = desk.hopfline(&["new", "study", "--model", "two-doublet"]);
    assert!(again.code == Some(2) && again.stderr.contains("study.toml"), "it was overwritten: {}", again.stderr);
}

#[test]
fn a_new_scene_has_a_title_of_any_name() {
    let desk = Desk::new();
    fs::create_dir(desk.path("sub")).unwrap();
    for (name, title) in [("say \"x\"", "title = 'say \"x\"'"), ("sub/study", "title = \"study\"")] {
        desk.succeed(&["new", name, "--model", "lorenz-84"]);
        let text = fs::read_to_string(desk.path(&format!("{name}.toml"))).unwrap();
        assert!(text.starts_with(title), "{text}");
        desk.succeed(&["check", &format!("{name}.toml"), "--set", "task.straight.range=[0, 1]"]);
    }
}

#[test]
fn completions_are_a_script() {
    let script = Desk::new().succeed(&["completions", "bash"]);
    assert!(script.contains("complete -F _hopfline"), "{script}");
    for word in ["run", "check", "--resume", "--threads"] {
        assert!(script.contains(word), "{word}");
    }
}

#[test]
fn plot_draws_the_same_figures_again() {
    let desk = Desk::with_small(&[]);
    desk.succeed(&["run", "small.toml", "--quiet"]);
    let figures = ["diagram", "eigenvalues", "shape"].map(|name| format!("output/small/figures/{name}.svg"));
    let read = || figures.clone().map(|path| fs::read_to_string(desk.path(&path)).unwrap());
    let first = read();
    figures.iter().for_each(|path| fs::remove_file(desk.path(path)).unwrap());
    let printed = desk.succeed(&["plot", "output/small"]);
    assert_eq!(printed.lines().count(), 3, "{printed}");
    for (name, (first, again)) in figures.iter().zip(first.iter().zip(read())) {
        assert!(*first == again, "{name} is drawn differently from stored data");
    }
}

#[test]
fn set_changes_one_value() {
    let desk = Desk::with_small(&[]);
    let run = ["run", "small.toml", "--quiet", "--only", "straight"];
    desk.succeed(&run);
    let threshold = || {
        let summary = desk.summary("output/small");
        point(&summary, "straight/HB1").unwrap()["parameters"]["p"].as_f64().unwrap()
    };
    let before = threshold();
    desk.succeed(&[&run[..], &["--set", "parameters.k_N=11000", "--set", "title=\"Stiffer\""]].concat());
    let summary = desk.summary("output/small");
    assert_eq!(summary["title"], "Stiffer");
    assert_eq!(point(&summary, "straight/HB1").unwrap()["parameters"]["k_N"], 11000.0);
    assert!((threshold() - before).abs() > 1e-3);
    desk.succeed(&[&run[..], &["--set", "parameters.k_N=2 * k_T + 8000"]].concat());
    assert_eq!(threshold(), before, "the tie gives the same stiffness");
}

#[test]
fn only_computes_a_task_and_what_it_starts_from() {
    let desk = Desk::with_small(&[]);
    desk.succeed(&["run", "small.toml", "--quiet", "--only", "straight"]);
    let names = |summary: &serde_json::Value| -> Vec<String> {
        summary["tasks"].as_array().unwrap().iter().map(|t| t["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names(&desk.summary("output/small")), ["straight"]);
    assert!(!desk.files("output/small").iter().any(|name| name.contains("beat")));
    desk.succeed(&["run", "small.toml", "--quiet", "--only", "beat"]);
    let summary = desk.summary("output/small");
    assert_eq!(names(&summary), ["straight", "beat"]);
    assert_eq!(task(&summary, "beat")["status"], "done");
}

#[test]
fn progress_is_silent_in_a_pipe() {
    let desk = Desk::with_small(&[]);
    let finished = desk.hopfline(&["run", "small.toml", "--only", "straight"]);
    assert_eq!((finished.code, finished.stderr.as_str()), (Some(0), ""));
}

#[test]
fn the_gallery_shows_what_was_run() {
    let desk = Desk::new();
    let scene = "# A pitchfork.\ntitle = \"Pitch\"\n[model]\nequations = \"x' = m*x - x^3\"\n[model.parameters]\nm = -1\n\
        [[task]]\nname = \"rest\"\nkind = \"equilibria\"\nfree = \"m\"\nrange = [-1, 1]\ndetect = [\"BP\"]\n\
        [[figure]]\nname = \"rest\"\nx = \"m\"\ny = \"x\"\ntasks = [\"rest\"]\n[expect]\n\
        \"rest/BP1\".m = { value = 0, tolerance = 1e-12, source = \"exact\" }\n";
    fs::create_dir(desk.path("scenes")).unwrap();
    desk.write("scenes/pitch.toml", scene);
    let refused = desk.hopfline(&["gallery", "scenes"]);
    assert_eq!(refused.code, Some(2));
    let advice = "hopfline run scenes/*.toml";
    assert!(refused.stderr.contains("summary.json") && refused.stderr.contains(advice), "{}", refused.stderr);
    desk.succeed(&["run", "scenes/pitch.toml", "--quiet"]);
    assert!(desk.succeed(&["gallery", "scenes"]).contains("README.md"));
    let page = fs::read_to_string(desk.path("scenes/README.md")).unwrap();
    for words in
        ["| 1 of 1 |", "**Pitch.** A pitchfork.", "| rest/BP1.m | ", "| 0 | ", " | exact |", "gallery/pitch.svg"]
    {
        assert!(page.contains(words), "no {words:?} in {page}");
    }
    assert!(desk.files("output/gallery").contains(&"pitch.svg".to_owned()));
    assert!(page.contains("(../output/gallery/pitch.svg)"), "{page}");
    desk.succeed(&["run", "scenes/pitch.toml", "--quiet", "--out", "kept/results"]);
    desk.succeed(&["gallery", "scenes", "--out", "kept/results"]);
    let page = fs::read_to_string(desk.path("scenes/README.md")).unwrap();
    assert!(page.contains("(../kept/results/gallery/pitch.svg)"), "{page}");
    // Results of a scene that expects something else do not count.
    desk.write("scenes/pitch.toml", &scene.replace("\"rest/BP1\".m", "\"rest/EP1\".m"));
    let refused = desk.hopfline(&["gallery", "scenes"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("another version"), "{}", refused.stderr);
    let refused = desk.hopfline(&["gallery", "nowhere"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("nowhere"), "{}", refused.stderr);
}

/// Scenes of a folder run in the order of their names; a table of what came out of them is printed and stored.
#[test]
fn a_folder_of_scenes_is_a_suite() {
    let desk = Desk::new();
    let scene = |title: &str, value: f64| {
        format!(
            "title = \"{title}\"\nlimit = \"nothing\"\n[model]\nequations = \"\"\"\nx' = m*x - y - x^3\ny' = x + m*y\n\"\"\"\n\
             [model.parameters]\nm = 0\n[[task]]\nname = \"rest\"\nkind = \"equilibria\"\nfree = \"m\"\nrange = [-1, \
             1]\ndetect = [\"HB\"]\n[expect]\n\"rest/HB1\".omega = {{ value = {value}, tolerance = 1e-9 }}\n"
        )
    };
    fs::create_dir(desk.path("set")).unwrap();
    for (name, title, value) in [("b", "second", 2.0), ("a", "first", 1.0)] {
        fs::write(desk.path(&format!("set/{name}.toml")), scene(title, value)).unwrap();
    }
    let finished = desk.hopfline(&["run", "set", "--quiet"]);
    assert_eq!(finished.code, Some(1), "{}", finished.stderr);
    let table = finished.stdout.split_once("| case").unwrap_or_else(|| panic!("{}", finished.stdout)).1;
    let rows: Vec<&str> = table.lines().filter(|line| line.starts_with('|')).skip(1).collect();
    assert!(rows[0].contains("first") && rows[0].contains("| right") && rows[0].contains("1 of 1"), "{table}");
    assert!(
        rows[1].contains("second") && rows[1].contains("MISSED 1 of 1") && rows[1].ends_with("nothing |"),
        "{table}"
    );
    assert!(table.contains("1 of 2 numbers lie within their printed errors"), "{table}");
    assert!(finished.stdout.ends_with(&fs::read_to_string(desk.path("output/set/cases.md")).unwrap()));
    let cases = fs::read_to_string(desk.path("output/set/cases.json")).unwrap();
    assert!(cases.contains("\"worst\": \"rest/HB1.omega\""), "{cases}");
    assert!(desk.path("output/set/a/summary.json").exists());
    fs::create_dir(desk.path("empty")).unwrap();
    let refused = desk.hopfline(&["run", "empty"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("a folder without scenes"), "{}", refused.stderr);
}
