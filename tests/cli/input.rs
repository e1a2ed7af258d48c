//! Wrong input: exit code 2, one message that names the place and what would be right, and nothing written.

use super::{Desk, SMALL, changed};
use std::fs;

/// Runs and checks a scene that is wrong; stderr must hold all the words.
#[track_caller]
fn refused(desk: &Desk, arguments: &[&str], words: &[&str]) {
    let before = desk.files("");
    for command in [&["run", "--quiet"][..], &["check"]] {
        // `check` has no results to put anywhere.
        if command[0] == "check" && arguments.iter().any(|a| ["--out", "--only"].contains(a)) {
            continue;
        }
        let finished = desk.hopfline(&[command, arguments].concat());
        let what = format!("{command:?} {arguments:?}: {}", finished.stderr);
        assert_eq!(finished.code, Some(2), "{what}");
        assert_eq!(finished.stdout, "", "{what}");
        for word in words {
            assert!(finished.stderr.contains(word), "no {word:?} in {what}");
        }
    }
    assert_eq!(desk.files(""), before, "something was written");
}

/// The small scene with one thing wrong in it.
#[track_caller]
fn refused_with(from: &str, to: &str, words: &[&str]) {
    let desk = Desk::with_small(&[(from, to)]);
    refused(&desk, &["small.toml"], &[&["small.toml:"], words].concat());
}

#[test]
fn unknown_words_are_named_with_those_allowed() {
    let model = ["model.name", "\"two-dublet\"", "did you mean \"two-doublet\""];
    refused_with("\"two-doublet\"", "\"two-dublet\"", &model);
    refused_with("k_N = 1e4", "k_M = 1e4", &["parameters.k_M", "unknown parameter", "k_N", "tau_c"]);
    refused_with("free = \"p\"\nrange = [340, 400]", "free = \"q\"\nrange = [340, 400]", &["free", "\"q\"", "tau_c"]);
    refused_with("kind = \"cycles\"", "kind = \"circles\"", &["kind", "\"circles\"", "equilibria, diagram, cycles"]);
    refused_with("max_step = 20", "maxstep = 20", &["straight", "maxstep", "did you mean \"max_step\""]);
    refused_with("functions = 10", "function = 10", &["model.function", "did you mean \"functions\"", "load"]);
    refused_with("functions = 10", "load = \"distel\"", &["model.load", "\"uniform\" or \"distal\"", "distel"]);
    refused_with("functions = 10", "functions = 1", &["functions", "a whole number from 2 to 400"]);
    refused_with("functions = 10", "form = \"foo\"", &["model.form", "\"minimal\" or \"mixed\"", "foo"]);
    refused_with("functions = 10", "form = \"mixed\"\ndegree = 9", &["degree", "a whole number from 2 to 8", "9"]);
    refused_with("functions = 10", "form = \"mixed\"\nelements = 0", &["elements", "a whole number from 1 to 1000"]);
    refused_with("functions = 10", "form = \"mixed\"\ngrading = 0.5", &["grading", "a number from 1 to 10", "0.5"]);
    refused_with("functions = 10", "form = \"mixed\"\ngrading = \"fine\"", &["grading", "\"fine\""]);
    refused_with("functions = 10", "functions = 10\nform = \"mixed\"", &["model.functions", "form = \"minimal\""]);
    refused_with("functions = 10", "elements = 4", &["model.elements", "left out without form = \"mixed\""]);
    refused_with("max_step = 20", "detects = [\"HB\"]", &["detects", "did you mean \"detect\""]);
    refused_with("[\"HB\"]", "[\"HP\"]", &["detect[1]", "\"HP\"", "HB, LP"]);
    refused_with("point = \"beat/UZ1\"", "pont = \"beat/UZ1\"", &["pont", "did you mean \"point\""]);
    refused_with("\"max tip_deflection\"", "\"max tip_reflection\"", &["tip_reflection", "tip_deflection"]);
    refused_with("multipliers = 2", "observables = [\"tip\"]", &["observables", "\"tip\"", "tip_deflection"]);
}

#[test]
fn units_must_be_known_and_fit() {
    refused_with("k_N = 1e4", "L = { value = 12, unit = \"mum\" }", &["parameters.L", "\"mum\""]);
    refused_with("k_N = 1e4", "L = { value = 12, unit = \"s\" }", &["parameters.L", "µm"]);
    refused_with("k_N = 1e4", "L = \"12 µm\"", &["parameters.L", "{ value = 12, unit = \"µm\" }"]);
}

#[test]
fn numbers_must_make_sense() {
    refused_with("k_N = 1e4", "k_N = -1", &["parameters.k_N", "k_N = -1", ">= 0"]);
    refused_with("k_N = 1e4", "L = 0", &["parameters.L", "L = 0 µm", "> 0"]);
    refused_with("k_N = 1e4", "L = nan", &["parameters.L", "finite", "NaN"]);
    refused_with("k_N = 1e4", "L = \"0 / 0\"", &["parameters.L", "NaN"]);
    refused_with("k_N = 1e4", "k_N = true", &["parameters.k_N", "must be a number"]);
    refused_with("[340, 400]", "[400, 340]", &["range", "from 400 to 340", "smaller end first"]);
    refused_with("[340, 400]", "[400, 400]", &["range", "from 400 to 400"]);
    refused_with("[340, 400]", "[340, nan]", &["range", "finite", "NaN"]);
    refused_with("[340, 400]", "[340, inf]", &["range", "finite"]);
    refused_with("[340, 400]", "[340]", &["range", "[from, to]"]);
    refused_with("[352]", "[355]", &["values", "355 lies outside the range 340 to 354"]);
    refused_with("degree = 3", "degree = 8", &["degree", "from 2 to 7"]);
    refused_with("max_step = 20", "max_step = 0", &["max_step", "greater than 0"]);
    refused_with("max_step = 20", "max_points = 0", &["max_points", "from 1 to"]);
    // The range of another parameter than the one that is free makes no sense at one of its ends.
    let desk = Desk::with_small(&[("free = \"p\"\nrange = [340, 400]", "free = \"L\"\nrange = [-1, 400]")]);
    refused(&desk, &["small.toml"], &["range", "L = -1 µm", "> 0"]);
}

#[test]
fn names_must_lead_somewhere() {
    refused_with("from = \"straight/HB1\"", "from = \"stright/HB1\"", &["from", "did you mean \"straight\""]);
    refused_with("from = \"straight/HB1\"", "from = \"straight\"", &["from", "TASK/KINDn"]);
    refused_with("from = \"straight/HB1\"", "from = \"straight/EP1\"", &["from", "Hopf point"]);
    refused_with("detect = [\"HB\"]", "", &["from", "finds no HB points", "detect = [\"HB\"]"]);
    refused_with("point = \"beat/UZ1\"", "point = \"beet/UZ1\"", &["point", "did you mean \"beat\""]);
    refused_with("tasks = [\"straight\"]", "tasks = [\"bent\"]", &["tasks", "\"bent\"", "straight, beat"]);
    refused_with("name = \"beat\"", "name = \"straight\"", &["straight", "already defined"]);
    refused_with("[352]", "[352]\nvalues = 1", &["not valid TOML"]);
    // A column to find values on must be one of the branch: "tip_deflection" of a cycle has a largest and a smallest.
    refused_with("p = [352]", "tip_deflection = [0.1]", &["values", "tip_deflection", "max tip_deflection"]);
    refused_with("p = [352]", "k_N = [1e4]", &["values", "k_N", "frequency"]);
}

#[test]
fn ties_must_be_free_of_circles_and_of_the_free_parameter() {
    refused_with("k_N = 1e4", "k_N = \"2 * k_T\"\nk_T = \"k_N / 2\"", &["tied in a circle", "k_N", "k_T"]);
    refused_with("k_N = 1e4", "k_N = \"k_N + 1\"", &["parameters.k_N", "circle"]);
    refused_with("k_N = 1e4", "p = \"30 * L\"", &["free", "p is tied", "[parameters]"]);
    refused_with("k_N = 1e4", "k_N = \"10 * kT\"", &["parameters.k_N", "\"kT\"", "did you mean \"k_T\""]);
    refused_with("k_N = 1e4", "k_N = \"10 * (k_T\"", &["parameters.k_N", "not an expression"]);
    refused_with("k_N = 1e4", "tau = 1", &["parameters.tau", "cannot be set"]);
}

#[test]
fn files_must_be_scenes() {
    let desk = Desk::new();
    refused(&desk, &["nothing.toml"], &["cannot read the scene nothing.toml"]);
    desk.write("broken.toml", "title = \"x\"\n[model\n");
    refused(&desk, &["broken.toml"], &["broken.toml:2:", "not valid TOML"]);
    desk.write("empty.toml", "");
    refused(&desk, &["empty.toml"], &["empty.toml", "[model]"]);
    fs::write(desk.path("binary.toml"), [0xff, 0xfe, 0x00]).unwrap();
    refused(&desk, &["binary.toml"], &["binary.toml"]);
    fs::create_dir(desk.path("folder.toml")).unwrap();
    fs::write(desk.path("folder.toml/x"), "").unwrap();
    refused(&desk, &["folder.toml"], &["cannot read the scene folder.toml"]);
}

#[test]
fn arguments_must_be_known() {
    let desk = Desk::with_small(&[]);
    refused(&desk, &["small.toml", "--only", "beet"], &["small.toml: --only", "did you mean \"beat\""]);
    refused(&desk, &["small.toml", "--set", "parameters.LL=14"], &["--set parameters.LL=14", "unknown parameter"]);
    refused(&desk, &["small.toml", "--set", "parameters.L"], &["--set parameters.L", "KEY=VALUE"]);
    refused(&desk, &["small.toml", "--set", "parameters.L=-1"], &["--set parameters.L=-1", "> 0"]);
    refused(&desk, &["small.toml", "--set", "task.bent.free=L"], &["--set", "\"bent\"", "straight, beat"]);
    refused(&desk, &["small.toml", "--set", "expect.x=1"], &["--set", "cannot be overridden"]);
    for arguments in [&["run"][..], &["run", "small.toml", "--threads", "0"], &["walk"], &["completions", "tcl"]] {
        let finished = desk.hopfline(arguments);
        assert_eq!(finished.code, Some(2), "{arguments:?}: {}", finished.stderr);
    }
    for arguments in [&["models", "two-dublet"][..], &["new", "x", "--model", "two-dublet"]] {
        let finished = desk.hopfline(arguments);
        assert_eq!(finished.code, Some(2), "{arguments:?}");
        assert!(finished.stderr.contains("did you mean \"two-doublet\""), "{}", finished.stderr);
    }
    let finished = desk.hopfline(&["plot", "nowhere"]);
    assert!(finished.code == Some(2) && finished.stderr.contains("nowhere"), "{}", finished.stderr);
    assert_eq!(desk.files(""), ["small.toml"]);
}

#[test]
fn scenes_must_not_share_a_folder_of_results() {
    let desk = Desk::with_small(&[]);
    for folder in ["a", "b"] {
        fs::create_dir(desk.path(folder)).unwrap();
        fs::copy(desk.path("small.toml"), desk.path(&format!("{folder}/small.toml"))).unwrap();
    }
    let finished = desk.hopfline(&["run", "a/small.toml", "b/small.toml", "--quiet"]);
    assert!(finished.code == Some(2) && finished.stderr.contains("would both write"), "{}", finished.stderr);
    assert!(!desk.path("output").exists());
}

/// What results are called would hide parameters of that name, or be hidden by them; curves of folds have no errors.
#[test]
fn names_of_results_are_taken() {
    let desk = Desk::new();
    let scene = "[model]\nequations = \"x' = PARAMETER*x - x^3\"\n[model.parameters]\nPARAMETER = 1\n[[task]]\nname = \"rest\"\n\
        kind = \"equilibria\"\nfree = \"PARAMETER\"\nrange = [-1, 1]\n";
    for name in ["theta", "rate", "snic", "rotation", "event", "chi2", "norm"] {
        desk.write("named.toml", &scene.replace("PARAMETER", name));
        refused(&desk, &["named.toml"], &["named.toml:4", name, "choose another name"]);
    }
    let curve = "detect = [\"LP\"]\n[[task]]\nname = \"folds\"\nkind = \"fold-curve\"\nfrom = \"rest/LP1\"\nfree = [\"m\", \"n\"]\n\
        range = { n = [0, 1] }\nerrors = true\n";
    desk.write("curve.toml", &(scene.replace("PARAMETER", "m") + curve));
    refused(&desk, &["curve.toml"], &["curve.toml", "unknown key of a fold-curve task \"errors\""]);
}

#[test]
fn the_folder_for_the_results_must_be_writable() {
    let desk = Desk::with_small(&[]);
    desk.write("file", "not a folder");
    refused(&desk, &["small.toml", "--out", "file/below"], &["cannot create the folder", "file/below"]);
    refused(&desk, &["small.toml", "--out", "file"], &["cannot create the folder", "file/small"]);
}

#[test]
fn a_wrong_scene_stops_those_before_it_too() {
    let desk = Desk::with_small(&[]);
    desk.write("wrong.toml", &changed(SMALL, &[("k_N = 1e4", "k_M = 1e4")]));
    let finished = desk.hopfline(&["run", "small.toml", "wrong.toml", "--quiet"]);
    assert_eq!((finished.code, finished.stdout.as_str()), (Some(2), ""));
    assert!(finished.stderr.contains("wrong.toml:9: parameters.k_M"), "{}", finished.stderr);
    assert_eq!(desk.files(""), ["small.toml", "wrong.toml"]);
}
