//! Conserved quantities of text models: against the model with one unknown and one equation less.

use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;

fn study(text: &str) -> Result<Summary, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, text).unwrap();
    let scene = Scene::load(&path, &[]).map_err(|error| error.to_string())?;
    let options = RunOptions { out: folder.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    run(&scene, &options).map_err(|error| error.to_string())
}

/// CO on platinum (Bykov, Yablonskii, Kim 1978): free sites z and sites taken by oxygen, CO and a buffer.
const SITES: &str = r#"
[model]
equations = """
x' = 2*q1*z^2 - 2*q5*x^2 - q3*x*y
y' = q2*z - q6*y - q3*x*y
s' = q4*(z - K*s)
FOURTH
"""
[model.parameters]
q1 = 2.5
q2 = 1.4707
q3 = 10
q4 = 0.0675
q5 = 1
q6 = 0.1
K = 0.4
MORE
[model.start]
x = 0.0029538
y = 0.76211
s = 0.16781
START
TASKS
"#;

const TASKS: &str = r#"
[[task]]
name = "rate"
kind = "equilibria"
free = "q2"
range = [0.5, 2]
start = 1.4707
spectrum = 4
detect = ["LP", "HB", "BP"]
values = { q2 = [1.0468] }
[[task]]
name = "onset"
kind = "hopf-curve"
from = "rate/HB1"
free = ["q2", "K"]
range = { q2 = [0.5, 2], K = [0.2, 0.6] }
values = { K = [0.45] }
[[task]]
name = "sites"
kind = "equilibria"
from = "rate/UZ1"
free = "sites"
range = [0.9, 1.1]
detect = ["LP", "HB"]
"#;

fn scene(closed: bool, tasks: &str) -> String {
    let (fourth, more, start) = if closed {
        let fourth = "z' = -2*(2*q1*z^2 - 2*q5*x^2 - q3*x*y)/2 - (q2*z - q6*y - q3*x*y) - q4*(z - K*s)";
        (fourth, "[model.conserved]\nsites = \"x + y + s + z\"", "z = 0.06712")
    } else {
        ("z = sites - x - y - s", "sites = 0.9999938", "")
    };
    let all = SITES.replace("FOURTH", fourth).replace("MORE", more).replace("START", start);
    // A table of its own comes after the keys of [model.start].
    all.replace("TASKS", tasks)
}

type Numbers = Vec<(String, f64)>;

/// Every number of every fold and Hopf point.
fn special(summary: &Summary) -> Vec<(String, Numbers)> {
    let wanted = |label: &str| ["/LP", "/HB", "/UZ"].iter().any(|kind| label.contains(kind));
    (summary.points.iter().filter(|point| wanted(&point.label)))
        .map(|point| {
            let named = point.parameters.iter().chain(&point.values);
            (point.label.clone(), named.map(|(name, &value)| (name.clone(), value)).collect())
        })
        .collect()
}

/// In the rate and, which the closed network has as a parameter only through its conserved quantity, in all sites.
#[test]
fn a_closed_network_is_the_reduced_one() {
    let [closed, reduced] = [true, false].map(|closed| special(&study(&scene(closed, TASKS)).unwrap()));
    let count = |what: &str| closed.iter().filter(|(label, _)| label.starts_with(what)).count();
    assert_eq!(["rate/LP", "rate/HB", "onset/UZ", "sites/LP", "sites/HB"].map(count), [2, 2, 1, 2, 2]);
    assert_eq!(closed.len(), reduced.len());
    for ((label, closed), (other, reduced)) in closed.iter().zip(&reduced) {
        assert_eq!(label, other);
        for (name, value) in closed.iter().filter(|(name, _)| ["q2", "sites", "K", "omega"].contains(&&name[..])) {
            let expected = reduced.iter().find(|(known, _)| known == name).unwrap().1;
            assert!((value - expected).abs() < 1e-11, "{label} {name}: {value} and {expected}");
        }
    }
}

#[test]
fn what_is_not_conserved_is_refused() {
    let good = scene(true, TASKS);
    for (quantity, expected) in [
        ("sites = \"x + y + s + 2*z\"", "sites: is not conserved: at a random state it changes at a rate of"),
        ("sites = \"x + y + s + z'\"", "without rates of change"),
        ("sites = \"q1\"", "without rates of change"),
        ("sites = \"x + y + w\"", "w"),
        ("sites = \"x + y + s + z\"\nagain = \"2*(x + y + s + z)\"", "again: follows from the other"),
        ("sites = \"x + y + s + z\"\nagain = \"(x + y + s + z)^2\"", "again: is not linear in x"),
        ("sites = \"q1*(x + y + s + z)\"", "give it: [model.parameters] sites = ..."),
    ] {
        let error = study(&good.replace("sites = \"x + y + s + z\"", quantity)).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
    let massive = good.replace("z' = -2", "2*z' = -2");
    let error = study(&massive).unwrap_err();
    assert!(error.contains("its equation must then be of the form z' = ..."), "{error}");
}
