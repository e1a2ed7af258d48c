//! Names, references and the shape of the whole.

use super::{GOOD, check, parse, same};

#[test]
fn names_and_references_are_checked() {
    check(&[
        (
            "name = \"straight\"",
            "name = \"straight/1\"",
            "16: task[1].name: \"straight/1\" cannot be a name; use letters (a-z, A-Z), digits, \"-\" and \"_\"",
        ),
        (
            "name = \"straight\"",
            "name = \"../x\"",
            "16: task[1].name: \"../x\" cannot be a name; use letters (a-z, A-Z), digits, \"-\" and \"_\"",
        ),
        ("name = \"straight\"\n", "", "15: task[1]: the key \"name\" is missing; add name = \"NAME\" to the [[task]]"),
        (
            "name = \"spectrum\"",
            "name = \"diagram\"",
            "46: figure[2].name: a figure named \"diagram\" is already defined (line 39); choose another name",
        ),
        (
            "from = \"straight/HB1\"",
            "from = \"strait/HB1\"",
            "26: task.beat.from: unknown task \"strait\" (did you mean \"straight\"?); allowed: straight, beat",
        ),
        (
            "from = \"straight/HB1\"",
            "from = \"beat/UZ1\"",
            "26: task.beat.from: the task \"beat\" comes later (line 23); put it before this one",
        ),
        (
            "from = \"straight/HB1\"",
            "from = \"straight\"",
            "26: task.beat.from: \"straight\" is not a label; write TASK/KINDn, for example \"straight/HB1\", with KIND one of HB, LP, BP, KC, XP, UZ, EP, LC, EV, GH, BT, ZH, HH, CP, LPC, PD, NS, BPC, CPC, GPD, CH, R1, R2, R3, R4, LPPD, LPNS, PDNS, GBPC, LPBP, BPNS and n counting from 1",
        ),
        (
            "from = \"straight/HB1\"\n",
            "",
            "23: task.beat: the key \"from\" is missing; add from = \"TASK/HB1\", the point where the cycles are born",
        ),
        (
            "detect = [\"HB\"]",
            "detect = [\"LP\"]",
            "26: task.beat.from: the task \"straight\" finds no HB points; give it detect = [\"LP\", \"HB\"]",
        ),
        (
            "point = \"beat/UZ2\"",
            "point = \"straight/EV1\"",
            "53: figure.beat.point: the task \"straight\" finds no EV points (events of motions: kind = \"simulate\")",
        ),
        (
            "point = \"beat/UZ2\"",
            "point = \"straight/UZ2\"",
            "53: figure.beat.point: the task \"straight\" finds no UZ points; give it values = { p = [...] }",
        ),
        (
            "point = \"beat/UZ2\"",
            "point = \"beat/LP1\"",
            "53: figure.beat.point: the task \"beat\" finds no LP points (it follows cycles: only LPC, PD, NS, BPC, UZ and EP)",
        ),
        (
            "tasks = [\"straight\", \"beat\"]",
            "tasks = [\"straight\", \"beet\"]",
            "43: figure.diagram.tasks[2]: unknown task \"beet\" (did you mean \"beat\"?); allowed: straight, beat",
        ),
        (
            "\"beat/UZ1\".\"max",
            "\"beat/UZ0\".\"max",
            "58: expect.beat/UZ0: \"beat/UZ0\" is not a label; write TASK/KINDn, for example \"straight/HB1\", with KIND one of HB, LP, BP, KC, XP, UZ, EP, LC, EV, GH, BT, ZH, HH, CP, LPC, PD, NS, BPC, CPC, GPD, CH, R1, R2, R3, R4, LPPD, LPNS, PDNS, GBPC, LPBP, BPNS and n counting from 1",
        ),
    ]);
    // The same through a second [[task]] of the name, which takes the place of the first in no silent way.
    let twice = GOOD.replace("name = \"beat\"\nkind = \"cycles\"", "name = \"straight\"\nkind = \"cycles\"");
    let error = parse(&twice, &[]).expect_err("two tasks of one name").to_string();
    assert_eq!(
        error,
        "problems/good.toml:24: task[2].name: a task named \"straight\" is already defined (line 15); choose another name"
    );
}

#[test]
fn wrong_shapes_are_refused() {
    for (text, expected) in [
        (
            "",
            "problems/good.toml: the section [model] is missing; add [model] with name = \"MODEL\" (`hopfline models` lists them) or with equations = \"x' = ...\"",
        ),
        ("model = 3", "problems/good.toml:1: model: must be a section, [model], but is the whole number 3"),
        (
            "[model]",
            "problems/good.toml:1: model: the key \"name\" is missing; add name = \"MODEL\" (`hopfline models` lists them), or equations = \"x' = ...\"",
        ),
        (
            "[model]\nname = \"m\"\n[task]\nname = \"a\"",
            "problems/good.toml:3: task: must be a list of sections, each headed [[task]], but is a table",
        ),
        (
            "task = [1]\n[model]\nname = \"m\"",
            "problems/good.toml:1: task[1]: must be a list of sections, each headed [[task]], but is the whole number 1",
        ),
        (
            "[model]\nname = \"m\"\n[[task]]\nname = \"a\"",
            "problems/good.toml:3: task.a: the key \"kind\" is missing; add kind = \"equilibria\" or ...",
        ),
        (
            "[model]\nname = m\n",
            "problems/good.toml:2:8: not valid TOML: string values must be quoted, expected literal string",
        ),
    ] {
        same(&parse(text, &[]).expect_err(text).to_string(), expected);
    }
}
