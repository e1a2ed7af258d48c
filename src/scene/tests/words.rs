//! Unknown words.

use super::check;

#[test]
fn unknown_words_are_refused_with_what_was_meant() {
    check(&[
        (
            "[expect]",
            "[expected]",
            "56: expected: unknown section \"expected\" (did you mean \"expect\"?); allowed: title, budget, limit, model, parameters, task, figure, expect, bench",
        ),
        (
            "max_step = 5",
            "max-step = 5",
            "30: task.beat.max-step: unknown key \"max-step\" (did you mean \"max_step\"?); allowed: name, kind, free, range, values, max_step, ...",
        ),
        (
            "spectrum = 8",
            "degree = 4",
            "20: task.straight.degree: unknown key of an equilibria task \"degree\"; allowed: name, kind, free, range, values, max_step, max_points, observables, errors, ...",
        ),
        (
            "kind = \"cycles\"",
            "kind = \"cycle\"",
            "25: task.beat.kind: unknown task kind \"cycle\" (did you mean \"cycles\"?); allowed: equilibria, diagram, cycles, hopf-curve...",
        ),
        (
            "kind = \"waveform\"",
            "kind = \"wavefront\"",
            "52: figure.beat.kind: unknown figure kind \"wavefront\" (did you mean \"waveform\"?); allowed: diagram, eigenvalues, waveform...",
        ),
        (
            "x = \"p\"",
            "xx = \"p\"",
            "41: figure.diagram.xx: unknown key \"xx\"; allowed: name, kind, title, x, y, tasks, point...",
        ),
        (
            "point = \"beat/UZ2\"",
            "point = \"beat/UZ2\"\nx = \"p\"",
            "54: figure.beat.x: unknown key of a waveform figure \"x\"; allowed: name, kind, title, point",
        ),
        (
            "unit = \"nm\" }",
            "unit = \"nm\", factor = 2 }",
            "11: parameters.L.factor: unknown key \"factor\"; allowed: value, unit",
        ),
        (
            "tolerance = 1e-9",
            "tolerence = 1e-9",
            "57: expect.straight/HB1.p.tolerence: unknown key \"tolerence\" (did you mean \"tolerance\"?); allowed: value, tolerance, source",
        ),
        (
            "detect = [\"HB\"]",
            "detect = [\"HB\", \"PB\"]",
            "21: task.straight.detect[2]: unknown kind of point to detect \"PB\"; allowed: HB, LP, BP",
        ),
        (
            "symmetry = \"none\"",
            "symmetry = \"half\"",
            "37: task.beat.symmetry: unknown symmetry \"half\"; allowed: auto, none",
        ),
    ]);
}
