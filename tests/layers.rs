//! Who may know whom: the layers of the code, read from its text.
//!
//! Paths that start with `crate::` say what a module uses. Only the models may speak of what is modelled.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Module and what it may use beside itself and its own parts. `main.rs` and `lib.rs` are the roots.
const ALLOWED: &[(&str, &[&str])] = &[
    ("linalg", &[]),
    ("branch", &[]),
    ("expression", &[]),
    ("import", &["expression"]),
    ("scene", &["expression"]),
    ("error", &[]),
    ("problem", &["linalg"]),
    ("models", &["problem", "linalg", "expression"]),
    ("continuation", &["problem", "linalg"]),
    ("bifurcation", &["continuation", "problem", "linalg"]),
    ("orbit", &["continuation", "problem", "linalg", "bifurcation"]),
    ("simulate", &["continuation", "problem", "linalg"]),
    ("plot", &["branch"]),
];
/// May use everything.
const FREE: &[&str] = &["run", "cli", "lib", "main"];
/// Words of the models, of which the rest of the toolkit knows nothing, comments included.
const WORDS: &[&str] = &["dynein", "curvature", "flagell", "drag", "waveform", "doublet"];
/// Where such a word is part of the job: scenes have a kind of figure called `waveform`, which `plot` draws; the
/// program's help, the map in lib.rs and the scene reader's tests show a model's name.
const EXCEPTIONS: &[(&str, &str)] = &[
    ("scene", "waveform"),
    ("plot", "waveform"),
    ("run", "waveform"),
    ("cli", "doublet"),
    ("lib", "doublet"),
    ("scene", "doublet"),
];

fn sources() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut open: Vec<PathBuf> = vec![root.clone()];
    let mut found = Vec::new();
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(fs::read_dir(&path).expect("a readable folder").map(|entry| entry.expect("an entry").path()));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let name = path.strip_prefix(&root).expect("a file under src").to_string_lossy().replace('\\', "/");
            found.push((name, fs::read_to_string(&path).expect("a readable file")));
        }
    }
    found.sort();
    found
}

/// `orbit/mesh.rs` and `orbit.rs` belong to `orbit`.
fn module(file: &str) -> &str {
    file.split('/').next().unwrap_or(file).trim_end_matches(".rs")
}

/// The heads of all paths `crate::x`, of the parts of `crate::{x, y::z}`, and of `super::x` that climbs to the root.
fn uses(file: &str, text: &str) -> Vec<String> {
    let name =
        |text: &str| -> String { text.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect() };
    let mut heads = Vec::new();
    for (at, found) in text.match_indices("crate::") {
        let rest = &text[at + found.len()..];
        match rest.strip_prefix('{') {
            Some(list) => {
                let mut depth = 0;
                let end = list.find(|c| {
                    depth += i32::from(c == '{') - i32::from(c == '}');
                    depth < 0
                });
                let list = &list[..end.expect("a closed list")];
                let mut depth = 0;
                let parts = list.split(|c| {
                    depth += i32::from(c == '{') - i32::from(c == '}');
                    depth == 0 && c == ','
                });
                heads.extend(parts.map(name));
            }
            None => heads.push(name(rest)),
        }
    }
    // `a/b.rs` is crate::a::b: two steps up is the root.
    let depth = file.split('/').count() - usize::from(file.ends_with("mod.rs"));
    let root = "super::".repeat(depth);
    for (at, _) in text.match_indices(&root) {
        let head = name(&text[at + root.len()..]);
        if ALLOWED.iter().any(|(module, _)| *module == head) {
            heads.push(head);
        }
    }
    heads.retain(|head| !head.is_empty());
    heads
}

#[test]
fn paths_are_read_right() {
    let text = "use crate::linalg::{Lu, c64};\nlet x = crate::problem::f(1);\nuse crate::{orbit, plot::Spec};";
    assert_eq!(uses("a/b.rs", text), ["linalg", "problem", "orbit", "plot"]);
    let text = "use crate::{\n    linalg::{Lu, c64},\n    scene,\n};\nuse super::super::models::f;\nuse super::plot;";
    assert_eq!(uses("a/b.rs", text), ["linalg", "scene", "models"]);
    assert_eq!((module("orbit/mesh.rs"), module("cli.rs")), ("orbit", "cli"));
}

#[test]
fn every_module_uses_only_the_layers_below_it() {
    let allowed: BTreeMap<&str, &[&str]> = ALLOWED.iter().copied().collect();
    let mut wrong = Vec::new();
    let mut seen = 0;
    for (file, text) in sources() {
        let home = module(&file);
        if FREE.contains(&home) {
            continue;
        }
        let Some(allowed) = allowed.get(home) else {
            wrong.push(format!("{file}: no layer is set for `{home}`"));
            continue;
        };
        for head in uses(&file, &text) {
            seen += 1;
            if head != home && !allowed.contains(&head.as_str()) {
                wrong.push(format!("{file}: `{home}` must not use `{head}`"));
            }
        }
    }
    assert!(seen > 20, "the code has many such paths; only {seen} were found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn only_models_speak_of_what_is_modelled() {
    let mut wrong = Vec::new();
    let mut in_models = 0;
    for (file, text) in sources() {
        for (number, line) in text.lines().enumerate() {
            let lower = line.to_lowercase();
            for word in WORDS.iter().filter(|word| lower.contains(*word)) {
                if module(&file) == "models" {
                    in_models += 1;
                } else if !EXCEPTIONS.contains(&(module(&file), word)) {
                    wrong.push(format!("{file}:{}: {word}: {}", number + 1, line.trim()));
                }
            }
        }
    }
    assert!(in_models > 0, "the models speak of nothing: are the files still where they were?");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
