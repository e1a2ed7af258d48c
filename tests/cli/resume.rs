//! Runs that do not come to their end: killed or interrupted at some moment, and completed later to the same numbers.

use super::{Desk, PROGRAM, assert_same_results, assert_whole, is_left_over, task};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Many small steps, so that there is a middle to be killed in.
const LONG: &[(&str, &str)] = &[("degree = 3", "degree = 3\nmax_step = 0.03"), ("functions = 10", "functions = 12")];

/// Starts the long run, which puts its results into a folder.
fn start(desk: &Desk, out: &str) -> Child {
    Command::new(PROGRAM)
        .args(["run", "small.toml", "--quiet", "--out", out])
        .current_dir(desk.path(""))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

fn wait_for(path: &Path) {
    let start = Instant::now();
    while !path.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "{} never came", path.display());
        sleep(Duration::from_millis(2));
    }
}

/// Whether a branch of cycles was left in the middle.
fn is_midway(desk: &Desk, out: &str) -> bool {
    let text = fs::read_to_string(desk.path(out).join("small/resume/beat.json")).unwrap();
    text.contains("\"Midway\"")
}

#[test]
fn a_killed_run_leaves_whole_files_and_resumes_to_the_same_numbers() {
    let desk = Desk::with_small(LONG);
    desk.succeed(&["run", "small.toml", "--quiet", "--out", "whole"]);
    let mut midway = 0;
    // At the first checkpoint, a little later, and after the second (there are two in a second).
    for (i, delay) in [0, 230, 570].into_iter().enumerate() {
        let out = format!("killed-{i}");
        let mut child = start(&desk, &out);
        wait_for(&desk.path(&out).join("small/resume/beat.json"));
        sleep(Duration::from_millis(delay));
        child.kill().unwrap();
        child.wait().unwrap();
        assert_whole(&desk, &out);
        midway += usize::from(is_midway(&desk, &out));
        desk.succeed(&["run", "small.toml", "--quiet", "--out", &out, "--resume"]);
        assert_same_results(&desk, "whole/small", &format!("{out}/small"));
        assert!(!desk.files(&out).iter().any(|name| is_left_over(name)));
    }
    assert!(midway > 0, "every run was over before it was killed");
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_keeps_what_it_has_and_resumes_to_the_same_numbers() {
    let desk = Desk::with_small(LONG);
    desk.succeed(&["run", "small.toml", "--quiet", "--out", "whole"]);
    let mut child = start(&desk, "stopped");
    wait_for(&desk.path("stopped/small/resume/beat.json"));
    sleep(Duration::from_millis(100));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    assert_whole(&desk, "stopped");
    let summary = desk.summary("stopped/small");
    assert_eq!(task(&summary, "beat")["status"], "interrupted");
    assert_eq!(task(&summary, "straight")["status"], "done");
    let rows = |out: &str| fs::read_to_string(desk.path(out).join("small/branches/beat.csv")).unwrap().lines().count();
    assert!(1 < rows("stopped") && rows("stopped") < rows("whole"), "{} of {}", rows("stopped"), rows("whole"));
    desk.succeed(&["run", "small.toml", "--quiet", "--out", "stopped", "--resume"]);
    assert_same_results(&desk, "whole/small", "stopped/small");
    assert_eq!(task(&desk.summary("stopped/small"), "beat")["status"], "done");
}

#[test]
fn a_changed_scene_does_not_resume_from_another() {
    let desk = Desk::with_small(&[]);
    desk.succeed(&["run", "small.toml", "--quiet"]);
    let softer = ["--quiet", "--set", "parameters.k_N=9900"];
    desk.succeed(&[&["run", "small.toml", "--resume"][..], &softer].concat());
    desk.succeed(&[&["run", "small.toml", "--out", "fresh"][..], &softer].concat());
    assert_same_results(&desk, "output/small", "fresh/small");
}
