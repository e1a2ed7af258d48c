//! `[bench]`.

use super::super::{Reference, TaskKind};
use super::{GOOD, parse, same};

const STUDY: &str = r#"
[bench]
point = "beat/UZ1"

[bench.reference]
frequency = { value = 32.7, error = 1e-7, source = "two codes" }

[bench.reference."max tip_deflection"]
set = { "model.functions" = 40, "task.beat.degree" = 6 }
check = { "model.functions" = 36 }

[[bench.family]]
name = "degree-4"
set = { "task.beat.degree" = 4, "parameters.k_N" = 2e4 }
vary = { "task.beat.intervals" = [5, 10], "model.functions" = [8, 12] }

[[bench.family]]
name = "other"
point = "straight/HB1"
vary = { model = [{ name = "other" }] }
"#;

#[test]
fn a_study_is_read_in_full() {
    let scene = parse(&format!("{GOOD}{STUDY}"), &[]).unwrap_or_else(|error| panic!("{error}"));
    let study = scene.bench.expect("a study");
    let names: Vec<&str> = study.quantities.iter().map(|quantity| quantity.name.as_str()).collect();
    assert_eq!(names, ["frequency", "max tip_deflection"]);
    assert!(matches!(&study.quantities[0].reference, Reference::Known { value: 32.7, error: 1e-7, .. }));
    let Reference::Computed { set, check } = &study.quantities[1].reference else { panic!("a computed reference") };
    let words = |changes: &[(String, String)]| -> Vec<String> {
        changes.iter().map(|(key, value)| format!("{key}={value}")).collect()
    };
    assert_eq!(words(&set.changes), ["model.functions=40", "task.beat.degree=6"]);
    // The check is the reference with its own changes laid over it.
    assert_eq!(words(&check.changes), ["task.beat.degree=6", "model.functions=36"]);
    let [family, other] = &study.families[..] else { panic!("two families") };
    assert_eq!((family.name.as_str(), family.variants.len()), ("degree-4", 2));
    let fine = &family.variants[1];
    assert_eq!(words(&fine.changes), ["task.beat.intervals=10", "model.functions=12"]);
    let TaskKind::Cycles(beat) = &fine.scene.tasks[1].kind else { panic!("cycles") };
    assert_eq!((beat.intervals, beat.degree), (Some(10), 4));
    // Only what the numbers need is computed.
    assert!(fine.scene.figures.is_empty() && fine.scene.bench.is_none());
    let wanted: Vec<String> = fine.scene.expect.iter().map(|e| format!("{}.{}", e.label, e.quantity)).collect();
    assert_eq!(wanted, ["beat/UZ1.frequency", "beat/UZ1.max tip_deflection"]);
    assert_eq!(
        (other.variants[0].point.as_str(), other.variants[0].scene.model.name.as_str()),
        ("straight/HB1", "other")
    );
}

#[test]
fn wrong_studies_are_named() {
    let line = GOOD.lines().count();
    for (piece, replacement, expected) in [
        (
            "point = \"beat/UZ1\"",
            "",
            "2: bench: the key \"point\" is missing; add point = \"TASK/UZ1\", where the numbers are read",
        ),
        (
            "point = \"beat/UZ1\"",
            "point = \"beet/UZ1\"",
            "3: bench.point: unknown task \"beet\" (did you mean \"beat\"?); allowed: straight, beat",
        ),
        (
            "point = \"beat/UZ1\"",
            "points = \"beat/UZ1\"",
            "3: bench.points: unknown key of a study \"points\" (did you mean \"point\"?); allowed: point, reference, family",
        ),
        (
            ", error = 1e-7",
            "",
            "6: bench.reference.frequency: the key \"error\" is missing; add error = NUMBER, by how much the value may be wrong; 0 if it is exact",
        ),
        (
            "error = 1e-7",
            "error = -1",
            "6: bench.reference.frequency.error: is -1; allowed: 0 or numbers greater than 0",
        ),
        (", source = \"two codes\"", "", "6: bench.reference.frequency: the key \"source\" is missing; ..."),
        (
            "check = { \"model.functions\" = 36 }",
            "",
            "8: bench.reference.max tip_deflection: the key \"check\" is missing; ...",
        ),
        (
            "name = \"degree-4\"",
            "",
            "12: bench.family[1]: the key \"name\" is missing; add name = \"NAME\" to the [[bench.family]]",
        ),
        (
            "name = \"other\"\n",
            "name = \"degree-4\"\n",
            "18: bench.family[2].name: a bench.family named \"degree-4\" is already defined (line...",
        ),
        (
            "[5, 10]",
            "[]",
            "15: bench.family.degree-4.vary.task.beat.intervals: is empty; give at least one value, from coarse to fine",
        ),
        (
            "[8, 12]",
            "[8]",
            "15: bench.family.degree-4.vary.model.functions: is a list of 1; allowed: 2 values, as many as in the list before it",
        ),
        (
            "[8, 12]",
            "8",
            "15: bench.family.degree-4.vary.model.functions: must be a list of values, from coarse to fine, but is the whole number 8",
        ),
        (
            "\"task.beat.degree\" = 4",
            "\"task.beat.degree\" = 9",
            "14: task.beat.degree: is 9; allowed: whole numbers from 2 to 7",
        ),
        (
            "\"task.beat.degree\" = 4",
            "\"task.beet.degree\" = 4",
            "14: bench.family.degree-4.set.task.beet.degree: unknown task \"beet\" (did you mean \"beat\"?); allowed: straight, beat",
        ),
        (
            "\"parameters.k_N\"",
            "\"parameter.k_N\"",
            "14: bench.family.degree-4.set.parameter.k_N: unknown section \"parameter\" (did you mean \"parameters\"?); ...",
        ),
        (
            "{ name = \"other\" }",
            "{ functions = 8 }",
            "20: bench.family.other.vary.model[1]: a model needs name or equations; ...",
        ),
    ] {
        assert_eq!(STUDY.matches(piece).count(), 1, "{piece:?} must stand once");
        let text = format!("{GOOD}{}", STUDY.replace(piece, replacement));
        let error = parse(&text, &[]).err().unwrap_or_else(|| panic!("{replacement:?} must be refused"));
        let (number, message) = expected.split_once(':').expect("a line");
        let number: usize = number.parse().expect("a number");
        same(&error.to_string(), &format!("problems/good.toml:{}:{message}", line + number));
    }
}
