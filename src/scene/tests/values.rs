//! Values of wrong types and out of bounds.

use super::check;

#[test]
fn wrong_types_and_numbers_are_refused() {
    check(&[
        ("title = \"Two doublets\"", "title = 3", "1: title: must be a string, but is the whole number 3"),
        ("name = \"two-doublet\"", "name = true", "3: model.name: must be a string, but is true"),
        ("gain = 1.5", "gain = [1]", "6: model.gain: must be a number, a string, true or false, but is a list of 1"),
        ("gain = 1.5", "gain = nan", "6: model.gain: must be a finite number, but is NaN"),
        ("k_N = 1e4", "k_N = -inf", "10: parameters.k_N: must be a finite number, but is -inf"),
        ("k_N = 1e4", "k_N = 1e999", "10: parameters.k_N: must be a finite number, but is inf"),
        (
            "k_N = 1e4",
            "k_N = 2026-01-01",
            "10: parameters.k_N: must be a number, { value = NUMBER, unit = \"UNIT\" } or an expression in quotes, but is the date or time 2026-01-01",
        ),
        ("value = 12000", "value = nan", "11: parameters.L.value: must be a finite number, but is NaN"),
        (
            "unit = \"nm\"",
            "unit = \"ells\"",
            "11: parameters.L.unit: unknown symbol \"ells\" in the unit \"ells\"; known are m, s, g, N, Pa, J, Hz, rad with the prefixes f, p, n, µ (or u), m, c, k, M, G",
        ),
        ("value = 12000, ", "", "11: parameters.L: the key \"value\" is missing; add value = NUMBER"),
        (
            "\"c_N * L^4 / EI / 200\"",
            "\"c_N * (L\"",
            "12: parameters.tau_c: is not an expression: column 9: expected an operator or \")\", found the end",
        ),
        (
            "\"c_N * L^4 / EI / 200\"",
            "\"12 µm\"",
            "12: parameters.tau_c: a number with its unit is written { value = 12, unit = \"µm\" }",
        ),
        (
            "\"c_N * L^4 / EI / 200\"",
            "\"1.5e-3 pN s/µm\"",
            "12: parameters.tau_c: a number with its unit is written { value = 1.5e-3, unit = \"pN s/µm\" }",
        ),
        (
            "\"c_N * L^4 / EI / 200\"",
            "\"12µm\"",
            "12: parameters.tau_c: a number with its unit is written { value = 12, unit = \"µm\" }",
        ),
        (
            "\"c_N * L^4 / EI / 200\"",
            "\"2 c_N\"",
            "12: parameters.tau_c: is not an expression: column 3: expected an operator or the end, found \"c\"",
        ),
        ("range = [0, 500]", "range = [0, nan]", "19: task.straight.range[2]: must be a finite number, but is NaN"),
        (
            "range = [0, 500]",
            "range = [500, 0]",
            "19: task.straight.range: the range runs from 500 to 0; write the smaller end first, and two different ends",
        ),
        (
            "range = [0, 500]",
            "range = [5, 5]",
            "19: task.straight.range: the range runs from 5 to 5; write the smaller end first, and two different ends",
        ),
        (
            "range = [0, 500]",
            "range = [0, 1, 2]",
            "19: task.straight.range: must be [from, to], two numbers, but is a list of 3",
        ),
        (
            "range = [0, 500]",
            "range = 5",
            "19: task.straight.range: must be [from, to], two numbers, but is the whole number 5",
        ),
        (
            "range = [0, 500]\n",
            "",
            "15: task.straight: the key \"range\" is missing; add range = [from, to], the ends of the free parameter",
        ),
        (
            "range = { p = [0, 420] }",
            "range = { q = [0, 420] }",
            "28: task.beat.range.q: the range is for \"q\", but the free parameter is \"p\"; write range = { p = [from, to] } or range = [from, to]",
        ),
        (
            "range = { p = [0, 420] }",
            "range = { p = [0, 4], q = [0, 4] }",
            "28: task.beat.range: must be one range, { p = [from, to] }, but is a table of 2",
        ),
        ("[340, 360.5]", "[]", "29: task.beat.values.p: is empty; give at least one number, or leave the key out"),
        ("[340, 360.5]", "[340, inf]", "29: task.beat.values.p[2]: must be a finite number, but is inf"),
        ("[340, 360.5]", "[340, 340.0]", "29: task.beat.values.p[2]: 340 is given twice; keep one"),
        (
            "[340, 360.5]",
            "[340, 500]",
            "29: task.beat.values.p[2]: 500 lies outside the range 0 to 420 of the free parameter, so that the branch never gets there",
        ),
        (
            "values = { p = [340, 360.5], max_tip = [1] }",
            "values = {}",
            "29: task.beat.values: is empty; give { p = [0, 420] }",
        ),
        ("max_step = 5", "max_step = 0", "30: task.beat.max_step: is 0; allowed: numbers greater than 0"),
        (
            "max_points = 200",
            "max_points = 0",
            "31: task.beat.max_points: is 0; allowed: whole numbers from 1 to 1000000",
        ),
        ("errors = false", "errors = 0", "33: task.beat.errors: must be true or false, but is the whole number 0"),
        ("intervals = 30", "intervals = 1", "34: task.beat.intervals: is 1; allowed: whole numbers from 2 to 10000"),
        ("degree = 5", "degree = 8", "35: task.beat.degree: is 8; allowed: whole numbers from 2 to 7"),
        (
            "degree = 5",
            "degree = 4.5",
            "35: task.beat.degree: must be a whole number from 2 to 7, but is the number 4.5",
        ),
        (
            "multipliers = true",
            "multipliers = -1",
            "36: task.beat.multipliers: is -1; allowed: whole numbers from 0 to 1000",
        ),
        (
            "multipliers = true",
            "multipliers = \"all\"",
            "36: task.beat.multipliers: must be true, false or a whole number from 0 to 1000, but is the string \"all\"",
        ),
        (
            "spectrum = 8",
            "spectrum = 1001",
            "20: task.straight.spectrum: is 1001; allowed: whole numbers from 0 to 1000",
        ),
        (
            "tolerance = 1e-9",
            "tolerance = 0.0",
            "57: expect.straight/HB1.p.tolerance: is 0; allowed: numbers greater than 0",
        ),
        (
            "detect = [\"HB\"]",
            "detect = \"HB\"",
            "21: task.straight.detect: must be a list such as [\"HB\", \"LP\", \"BP\"], but is the string \"HB\"",
        ),
        (
            "observables = [\"energy\"]",
            "observables = [\"a\", \"a\"]",
            "32: task.beat.observables[2]: \"a\" is given twice; keep one",
        ),
        (
            "y = \"max tip_deflection\"",
            "y = 3",
            "42: figure.diagram.y: must be a column or a list of columns, but is the whole number 3",
        ),
        ("y = \"max tip_deflection\"", "y = []", "42: figure.diagram.y: is empty; give at least one column"),
        (
            "y = \"max tip_deflection\"\n",
            "",
            "39: figure.diagram: the key \"y\" is missing; add y = \"COLUMN\" or a list of columns",
        ),
        (
            "tasks = [\"straight\", \"beat\"]",
            "tasks = []",
            "43: figure.diagram.tasks: is empty; give at least one task",
        ),
    ]);
}
