//! `--set`.

use super::super::{OptionValue, Place, Value};
use super::{GOOD, parse, same};

/// The complaint about an override of the good scene.
fn overridden(set: &str) -> String {
    match parse(GOOD, &[set]) {
        Ok(_) => panic!("{set:?} must be refused"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn overrides_replace_single_values() {
    let sets = [
        "parameters.L=14",
        "parameters.tau_c=tau/200",
        "model.load=distal",
        "model.functions = 32",
        "title=A date: 2026",
        "task.beat.range=[0, 400]",
        "figure.diagram.y=[\"a\", \"b\"]",
        "parameters.new={ value = 1, unit = \"nm\" }",
    ];
    let scene = parse(GOOD, &sets).unwrap_or_else(|error| panic!("{error}"));
    assert!(scene.overridden);
    assert_eq!(scene.title, "A date: 2026");
    assert_eq!(scene.model.options[0].value, OptionValue::Text("distal".to_owned()));
    assert_eq!(scene.model.options[1].value, OptionValue::Integer(32));
    assert!(matches!(scene.parameters[1].value, Value::Number(14.0)));
    assert!(matches!(&scene.parameters[2].value, Value::Tie(tie) if tie.to_string() == "tau / 200"));
    assert_eq!(scene.parameters[1].at, Place { key: "parameters.L".to_owned(), line: None });
    assert!(matches!(&scene.parameters[4].value, Value::Quantity { .. }));
    assert_eq!(scene.tasks[1].kind.along().range.to, 400.0);
    assert_eq!(scene.figures[0].y, ["a", "b"]);

    let scene = parse(GOOD, &["task.beat.degree=4", "title=2026-01-01"]).expect("valid");
    assert!(!scene.overridden);
    assert_eq!(scene.title, "2026-01-01");
    let scene = parse("[model]\nname = \"m\"", &["parameters.L=1"]).expect("the section is made");
    assert_eq!(scene.parameters.len(), 1);
    // Inside a table, and the last of two wins.
    let scene = parse(GOOD, &["parameters.L.value=13", "parameters.L.value=14"]).expect("valid");
    assert!(matches!(scene.parameters[1].value, Value::Quantity { value: 14.0, .. }));
}

#[test]
fn bad_overrides_are_named() {
    for (set, expected) in [
        ("L", "--set L: is not of the form KEY=VALUE; write for example --set parameters.L=14"),
        ("=3", "--set =3: has an empty key; write for example parameters.L or task.beat.range"),
        ("parameters.=3", "--set parameters.=3: has an empty key; write for example parameters.L or task.beat.range"),
        ("parameters.L=", "--set parameters.L=: gives no value; write parameters.L=VALUE"),
        (
            "parameter.L=3",
            "--set parameter.L=3: unknown section \"parameter\" (did you mean \"parameters\"?); allowed: title, budget, model, parameters, task, figure",
        ),
        (
            "task.beet.range=[0, 1]",
            "--set task.beet.range=[0, 1]: unknown task \"beet\" (did you mean \"beat\"?); allowed: straight, beat",
        ),
        ("figure.x.y=3", "--set figure.x.y=3: unknown figure \"x\"; allowed: diagram, spectrum, beat"),
        (
            "task.beat.range=[0, 1",
            "--set task.beat.range=[0, 1: the value is not valid TOML: unclosed array, expected `]`",
        ),
        (
            "parameters.k_N.value=3",
            "--set parameters.k_N.value=3: must be a table for k_N.value, but is the number 10000.0",
        ),
        (
            "task.beat.rnage=[0, 1]",
            "problems/good.toml: --set task.beat.rnage=[0, 1]: task.beat.rnage: unknown key \"rnage\" (did you mean \"range\"?); allowed: name, kind, free, range, values, max_step, ...",
        ),
        (
            "task.beat.range=[3, 1]",
            "problems/good.toml: --set task.beat.range=[3, 1]: task.beat.range: the range runs from 3 to 1; write the smaller end first, and two different ends",
        ),
        (
            "parameters.k_N=nan",
            "problems/good.toml: --set parameters.k_N=nan: parameters.k_N: must be a finite number, but is NaN",
        ),
        (
            "parameters.k_N=1 +",
            "problems/good.toml: --set parameters.k_N=1 +: parameters.k_N: is not an expression: column 4: expected a number, a name, a function, \"-\" or \"(\", found the end",
        ),
        (
            "parameters.L.unit=ells",
            "problems/good.toml: --set parameters.L.unit=ells: parameters.L.unit: unknown symbol \"ells\" in the unit \"ells\"; known are m, s, g, N, Pa, J, Hz, rad with the prefixes f, p, n, µ (or u), m, c, k, M, G",
        ),
    ] {
        same(&overridden(set), expected);
    }
    for set in [
        "title.a=3",
        "model=3",
        "task.beat=3",
        "task=3",
        "task.beat.name=x",
        "expect.a=3",
        "parameters=3",
        &format!("parameters{}=3", ".a".repeat(9000)),
    ] {
        let complaint = overridden(set);
        assert!(
            complaint.contains("cannot be overridden; allowed: title, budget, model.KEY, parameters.NAME"),
            "{complaint}"
        );
    }
}
