//! What is wrong is said; whatever is read ends; tape and tree agree.

use super::*;
use crate::linalg::Structure;
use crate::problem::{At, Automatic, Formula, Problem, check_derivatives};
use proptest::prelude::*;
use std::sync::Arc;

fn parameter(name: &str, value: f64) -> WrittenParameter {
    WrittenParameter {
        name: name.to_owned(),
        default: WrittenDefault::Number(value),
        unit: String::new(),
        meaning: String::new(),
        least: f64::NEG_INFINITY,
        most: f64::INFINITY,
    }
}

/// With parameters a = 2 and b = 3, and N = 4.
fn written(equations: &str) -> Written {
    Written {
        equations: equations.to_owned(),
        constants: vec![("N".to_owned(), 4)],
        parameters: vec![parameter("a", 2.0), parameter("b", 3.0)],
        ..Written::default()
    }
}

fn with_start(equations: &str, start: &[(&str, &str)]) -> Written {
    let start = start.iter().map(|&(name, value)| (name.to_owned(), value.to_owned())).collect();
    Written { start, ..written(equations) }
}

#[track_caller]
fn text(written: &Written) -> Arc<Text> {
    build(written).unwrap_or_else(|error| panic!("{error}"))
}

/// -G at v = 0: the right-hand sides.
fn right(text: &Arc<Text>, u: &[f64]) -> Vec<f64> {
    let rest = vec![0.0; u.len()];
    let mut g = rest.clone();
    text.residual(u, &rest, &[2.0, 3.0], &mut g);
    g.iter().map(|g| -g).collect()
}

#[test]
fn definitions_and_functions_are_used_in_any_order() {
    let text = text(&written("x' = R - f(x, y)  # growth\ny' = R\nf(p, q) = p*q^2\nR = a*S\nS = b + x\n"));
    assert_eq!(text.names, ["x", "y"]);
    assert_eq!(right(&text, &[1.0, 3.0]), [2.0 * 4.0 - 9.0, 8.0]);
}

#[test]
fn precedence_is_that_of_print() {
    for (expression, expected) in
        [("-x^2", -9.0), ("2^3^2", 512.0), ("1e-3*x", 0.003), ("6/2*x", 9.0), ("x - 1 - 1", 1.0)]
    {
        assert_eq!(right(&text(&written(&format!("x' = {expression}"))), &[3.0]), [expected], "{expression}");
    }
}

#[test]
fn lines_go_on_where_they_must() {
    let text =
        text(&written("x' = a*(x +\n   # a comment\n   b)\n  + x\ny' = x -\n  y\n\nu[i]' = u[i]*x\n  for i = 1..N"));
    assert_eq!(right(&text, &[1.0, 5.0, 1.0, 2.0, 3.0, 4.0]), [9.0, -4.0, 1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn arrays_have_neighbours_and_ends() {
    let chain =
        "u[i]' = u[i-1] - 2*u[i] + u[i+1] + v[i]  for i = 1..N\nv[i]' = i*v[i]  for i = 1..N\nu[0] = a\nu[N+1] = u[N]";
    let text = text(&written(chain));
    assert_eq!(text.names, ["u[1]", "v[1]", "u[2]", "v[2]", "u[3]", "v[3]", "u[4]", "v[4]"]);
    let u = [1.0, 10.0, 4.0, 20.0, 9.0, 30.0, 16.0, 40.0];
    let expected = [2.0 - 2.0 + 4.0 + 10.0, 10.0, 2.0 + 20.0, 40.0, 2.0 + 30.0, 90.0, 9.0 - 16.0 + 40.0, 160.0];
    assert_eq!(right(&text, &u), expected);
}

#[test]
fn sums_and_arrays_of_two_indices() {
    let text =
        text(&written("w[i, j]' = sum(w[k, j], k = 1..2) + i*h[j]  for i = 1..2, j = 1..2\nh[j] = 10*j  for j = 1..2"));
    assert_eq!(text.names, ["w[1, 1]", "w[1, 2]", "w[2, 1]", "w[2, 2]"]);
    assert_eq!(right(&text, &[1.0, 2.0, 3.0, 4.0]), [14.0, 26.0, 24.0, 46.0]);
}

#[test]
fn chains_get_narrow_bands() {
    let chain = "u[i]' = u[i-1] - 2*u[i] + u[i+1] + v[i]  for i = 1..N\nv[i]' = u[i] - v[i]  for i = 1..N\nu[0] = 0\nu[N+1] = 0";
    let mut long = written(chain);
    long.constants[0].1 = 100;
    let problem = Automatic(text(&long));
    assert_eq!(Problem::structure(&problem), Structure::Banded { lower: 2, upper: 2 });
    // A ring closes far from the diagonal, a mean field couples everything.
    long.equations = chain.replace("u[0] = 0\nu[N+1] = 0", "u[0] = u[N]\nu[N+1] = u[1]");
    let structure = Problem::structure(&Automatic(text(&long)));
    assert!(matches!(&structure, Structure::Sparse(pattern) if pattern.entries() == 600), "{structure:?}");
    long.equations = chain.to_owned();
    long.equations = chain.replace("+ v[i]", "+ sum(v[k], k = 1..N)");
    assert_eq!(Problem::structure(&Automatic(text(&long))), Structure::Dense);
}

#[test]
fn rows_of_the_mass_and_algebraic_equations() {
    let coupled = with_start("a*x' + y' = -x\nx*y' - x' = y\n0 = z^2 - x", &[("x", "4"), ("z", "sqrt(4)")]);
    let text = text(&coupled);
    assert_eq!(text.names, ["x", "y", "z"]);
    let (mut g, u, v) = ([0.0; 3], [4.0, 5.0, 3.0], [10.0, 100.0, 7.0]);
    text.residual(&u, &v, &[2.0, 3.0], &mut g);
    assert_eq!(g, [20.0 + 100.0 + 4.0, 400.0 - 10.0 - 5.0, -(9.0 - 4.0)]);
    assert_eq!(Formula::start(&text, &[2.0, 3.0]), [4.0, 0.0, 2.0]);
}

#[test]
fn starts_speak_of_elements_arrays_and_indices() {
    let chain = "u[i]' = w[i] - u[i]  for i = 1..N\n0 = w[i] - a  for i = 1..N";
    let text = text(&with_start(chain, &[("u[i]", "b*i"), ("u[N]", "7"), ("w[i]", "2*i for i = 1..N")]));
    assert_eq!(Formula::start(&text, &[2.0, 3.0]), [3.0, 2.0, 6.0, 4.0, 9.0, 6.0, 7.0, 8.0]);
}

#[test]
fn derivatives_match_directions() {
    let everything = "x' = a*sin(x*y)/(1 + x^2) - exp(-y) + abs(x)^1.5 + tanh(z)^3\ny*y' + x*x' = atan(x) - x^y\n\
        cos(x)*z' = log(2 + z^2)*sqrt(b + x)";
    let problem = Automatic(text(&written(everything)));
    let at = At { u: &[0.7, 1.3, -0.4], v: &[0.2, -0.5, 0.9], p: &[2.0, 3.0] };
    assert!(check_derivatives(&problem, at) < 1e-14);
    let chain = "u[i]' = u[i-1]*u[i+1] - u[i]^3 + v[i]  for i = 1..N\nu[i]*v[i]' = u[i] - v[i]  for i = 1..N\nu[0] = 0\nu[N+1] = a";
    let mut long = written(chain);
    long.constants[0].1 = 40;
    let problem = Automatic(text(&long));
    let numbers = |shift: usize| (0..80).map(|i| (0.3 * (i + shift) as f64).sin()).collect::<Vec<f64>>();
    assert!(check_derivatives(&problem, At { u: &numbers(0), v: &numbers(7), p: &[2.0, 3.0] }) < 1e-14);
}

#[test]
fn observables_are_asked_for_or_the_unknowns_of_small_systems() {
    let observable = |name: &str, expression: &str| WrittenObservable {
        name: name.to_owned(),
        expression: expression.to_owned(),
        unit: "m".to_owned(),
        meaning: String::new(),
    };
    let mut small = written("x' = y\nomega' = -x\ny = omega");
    small.reserved = vec!["omega".to_owned()];
    small.observables = vec![observable("speed", "a*x'")];
    let text = text(&small);
    let names: Vec<&str> = text.observables.iter().map(|o| o.name).collect();
    assert_eq!(names, ["speed", "x"]);
    assert_eq!(text.observe(0, At { u: &[1.0, 2.0], v: &[5.0, 0.0], p: &[2.0, 3.0] }), 10.0);
    small.observables = vec![observable("omega", "x")];
    assert!(build(&small).err().is_some_and(|error| error.to_string().contains("column of the results")));
}

#[test]
fn symmetries_are_tried() {
    let reflection = |equations: &str, symmetry: &str| {
        let symmetry = Some(symmetry.to_owned());
        build(&Written { symmetry, ..written(equations) }).map(|text| text.reflection.clone())
    };
    let lorenz = "x' = a*(y - x)\ny' = x*(b - z) - y\nz' = x*y - z";
    let found = reflection(lorenz, "x -> -x, y -> -y").unwrap().unwrap();
    assert_eq!((found.source, found.sign), (vec![0, 1, 2], vec![-1.0, -1.0, 1.0]));
    let chain = "u[i]' = u[i-1] - 2*u[i] + u[i+1]  for i = 1..N\nu[0] = 0\nu[N+1] = 0";
    assert_eq!(reflection(chain, "u[i] -> -u[N+1-i]").unwrap().unwrap().source, [3, 2, 1, 0]);
    assert_eq!(reflection(chain, "u -> -u").unwrap().unwrap().sign, [-1.0; 4]);
    for (symmetry, expected) in [
        ("x -> -x", "does not hold: the equation of x changes"),
        ("x -> -y", "does not take x to itself"),
        ("x -> -w", "w is not an unknown"),
        ("x = -x", "not of the form x -> -x"),
        ("x -> 2*x", "takes an unknown to an unknown"),
    ] {
        let error = reflection(lorenz, symmetry).expect_err(symmetry).to_string();
        assert!(error.contains(expected), "{symmetry}: {error}");
    }
}

/// Equations, the text at which the error is, and words of it.
const WRONG: &[(&str, &str, &str)] = &[
    ("", "", "no equation"),
    ("x' = -x + pery\nprey' = x", "pery", "unknown name \"pery\"; did you mean \"prey\"?"),
    ("x' = sine(x)", "sine", "did you mean \"sin\"?"),
    ("x' = g(x)\nf(x) = x", "g(", "unknown function \"g\""),
    ("x' = f(x, x)\nf(x) = x", "f(x, x)", "takes 1 arguments, but has 2"),
    ("x' = t", "t", "time cannot enter"),
    ("x' = x +* 2", "* 2", "expected a number"),
    ("x' = x\nx = 2", "x = 2", "cannot be defined as well"),
    ("x' = R\nR = 1\nR = 2", "R = 2", "R is defined twice"),
    ("x' = R\nR = S\nS = R + x", "R + x", "R is defined by itself"),
    ("x' = f(x)\nf(x) = f(x) + 1", "f(x) + 1", "the function f is defined by itself"),
    ("x' = -x\nsin = 2*x", "= 2", "expected \"(\" after the function sin"),
    ("x' = -x\nsin(x) = 2*x", "sin(x)", "sin is built in"),
    ("x' = -x\na = 2*x", "a = 2", "\"a\" is a parameter already"),
    ("x' = -x\nN = 2", "N = 2", "\"N\" is a constant already"),
    ("a' = -a", "a' =", "\"a\" is a parameter already"),
    ("x' = pi'", "", "expected"),
    ("u[i]' = u[i-1]  for i = 1..N", "u[i-1]", "u[0] is not defined, only u[1] to u[4]"),
    ("u[i]' = u  for i = 1..N", "u  for", "u is an array; write u[i]"),
    ("u[i]' = u[i, i]  for i = 1..N", "u[i, i]", "u has 1 indices; write u[i]"),
    ("x' = x[1]", "x[1]", "x is not an array"),
    ("u[i]' = u[i]  for i = 1..M", "M", "\"M\" is not a whole number known here; known are N"),
    ("u[i]' = u[i]  for i = 3..2", "i = 3", "the range i = 3..2 is empty"),
    ("u[i]' = u[i]  for i = 1..N^20", "i = 1", "too long"),
    ("u[i]' = u[i]  for i = 1..10^9", "i = 1", "too long"),
    ("u[i,j]' = u[i,j]  for i = 1..10^4, j = 1..10^4", "j = 1", "choose a smaller size"),
    ("u[i/2]' = 1  for i = 1..N", "i/2", "not a whole number"),
    ("u[i]' = u[i]  for a = 1..N", "i]'", "\"i\" is not a whole number known here"),
    ("u[a]' = u[a]  for a = 1..N", "a = 1", "\"a\" is a parameter already"),
    ("x' = x for x = 1..2", "x = 1", "is an unknown or a definition already"),
    ("x' = -x\ny' + x' = 1\nx' = 2", "x' = 2", "3 equations for 2 unknowns (x, y)"),
    ("x' + y' = 1", "x' + y'", "1 equations for 2 unknowns (x, y)"),
    ("x' = y", "y", "needs a value in [model.start]"),
    ("x'*y' = 1\ny' = 2", "x'*y'", "rates of change must enter linearly"),
    ("x' = sin(x')", "x' =", "rates of change must enter linearly"),
    ("x' = 1\n0 = a", "0 = a", "holds no unknown: 0 = a"),
    ("x' = R'\nR = x", "R = x", "cannot be defined as well"),
    ("x' = x\nx", "", "expected an operator or \"=\""),
    ("x' = x(2)", "x(2)", "x is no function; write a product"),
    ("x' = 1e999", "1e999", "too large"),
    ("x' = (x'", "", "expected an operator or \")\""),
];

#[test]
fn errors_say_what_and_where() {
    for &(equations, at, expected) in WRONG {
        let error = build(&written(equations)).map(drop).expect_err(equations);
        assert!(error.to_string().contains(expected), "{equations}: {error}");
        assert_eq!(error.part, Part::Equations, "{equations}");
        if !at.is_empty() {
            let offset = error.wrong.offset.unwrap_or_else(|| panic!("{equations}: no place"));
            assert!(
                equations[offset..].starts_with(at),
                "{equations}: points at {:?}, not {at:?}",
                &equations[offset..]
            );
        }
    }
}

#[test]
fn errors_outside_the_equations() {
    let equations = "u[i]' = -u[i]  for i = 1..N";
    for (key, value, expected) in [
        ("u", "c", "unknown name \"c\""),
        ("u[i]", "1 +", "expected a number"),
        ("u[9]", "1", "u[9] is not an unknown"),
        ("v", "1", "v occurs in no equation"),
        ("u", "u[1]", "may depend on parameters"),
        ("w[i]", "1", "needs its range here"),
        ("a", "1", "\"a\" is a parameter already"),
        ("2", "1", "must be the name of an unknown"),
    ] {
        let error = build(&with_start(equations, &[(key, value)])).map(drop).expect_err(key);
        assert!(error.to_string().contains(expected), "{key} = {value}: {error}");
        assert_eq!(error.part, Part::Start(key.to_owned()));
    }
    let mut odd = written(equations);
    for (name, expected) in [("sin", "meaning of its own"), ("2a", "cannot be a name"), ("N", "is a parameter, too")] {
        odd.parameters = vec![parameter(name, 1.0)];
        let error = build(&odd).map(drop).expect_err(name).to_string();
        assert!(error.contains(expected), "{name}: {error}");
    }
    let mut big = written("u[i]' = m - u[i]  for i = 1..N\nm = sum(u[k], k = 1..N)");
    big.constants[0].1 = 5000;
    let error = build(&big).map(drop).expect_err("too many").to_string();
    assert!(error.contains("at most 4000 are allowed"), "{error}");
}

#[test]
fn a_start_that_is_no_number_is_explained() {
    for (equations, expected, at) in [
        ("x' = 1/x", "1 is divided by zero", "/x"),
        ("x' = a + log(x - 1)", "log is taken of -1", "log"),
        ("x' = R\nR = a*sqrt(-b)", "sqrt is taken of -3", "sqrt"),
        ("x' = x^(-a)", "0^-2 is inf", "^("),
        ("x' = exp(1e3 + x)", "exp(1000) is inf", "exp"),
    ] {
        let error = text(&written(equations)).complaint(&[2.0, 3.0]).expect(equations);
        assert!(error.to_string().contains(expected), "{equations}: {error}");
        assert!(equations[error.wrong.offset.unwrap_or(0)..].starts_with(at), "{equations}: {:?}", error.wrong.offset);
    }
    let error = text(&with_start("x' = x", &[("x", "1/(a - 2)")])).complaint(&[2.0, 3.0]).expect("infinite");
    assert!(error.to_string().contains("x starts at inf"), "{error}");
    assert!(text(&written("x' = x")).complaint(&[2.0, 3.0]).is_none());
}

#[test]
fn what_doubles_at_each_step_ends() {
    let mut doubling = "x' = d60\nd0 = x\n".to_owned();
    for k in 1..=60 {
        doubling += &format!("d{k} = d{} + d{}\n", k - 1, k - 1);
    }
    text(&written(&doubling));
    let mut calls = "x' = f40(x) + f40(x')\nf0(x) = x\n".to_owned();
    for k in 1..=40 {
        calls += &format!("f{k}(x) = f{}(x) + f{}(x)\n", k - 1, k - 1);
    }
    let error = build(&written(&calls)).map(drop).expect_err("2^40 calls").to_string();
    assert!(error.contains("operations"), "{error}");
}

/// Lines of a model in random order, cut and glued.
fn fragments() -> impl Strategy<Value = String> {
    let piece = prop_oneof![
        Just("x' = ".to_owned()),
        Just("y' = ".to_owned()),
        Just("0 = ".to_owned()),
        Just("u[i]' = ".to_owned()),
        Just("u[i-1] - 2*u[i] + u[i+1]".to_owned()),
        Just(" for i = 1..N".to_owned()),
        Just(", j = 1..3".to_owned()),
        Just("\n".to_owned()),
        Just("u[0] = ".to_owned()),
        Just("u[N+1] = ".to_owned()),
        Just("R = ".to_owned()),
        Just("f(x, y) = ".to_owned()),
        Just("f(x, R)".to_owned()),
        Just("sum(u[k], k = 1..N)".to_owned()),
        Just("a*x^2/(1 + b)".to_owned()),
        "[-+*/^()xyRNab0-9.\\[\\]' ,=#]{1,4}",
        Just("sin(x)".to_owned()),
        Just("1e-3".to_owned()),
    ];
    proptest::collection::vec(piece, 1..16).prop_map(|pieces| pieces.concat())
}

/// A small valid model, with one part of the text replaced.
fn mutated() -> impl Strategy<Value = String> {
    let model = "u[i]' = D*(u[i-1] - 2*u[i] + u[i+1]) + f(u[i], v)  for i = 1..N\nv' = a - sum(u[i], i = 1..N)/N\n\
        f(x, y) = x*y - x^3\nD = b*(N + 1)^2\nu[0] = 0\nu[N+1] = 1\n0*v' + x' = 1/x\n";
    (0..model.len(), 0..6_usize, "\\PC{0,3}|[-+*/^()\\[\\]' =,.a-z0-9\n]{0,4}").prop_map(move |(at, cut, new)| {
        let end = (at + cut).min(model.len());
        format!("{}{new}{}", &model[..at], &model[end..])
    })
}

fn is_answered(equations: &str) {
    if let Ok(text) = build(&with_start(equations, &[("v", "1"), ("u", "0.5")])) {
        let n = text.names.len();
        let _ = text.complaint(&[2.0, 3.0]);
        let (u, mut g) = (vec![0.5; n], vec![0.0; n]);
        text.residual(&u, &u, &[2.0, 3.0], &mut g);
        let _ = Automatic(text).linearised(At { u: &u, v: &u, p: &[2.0, 3.0] });
    }
}

proptest! {
    #[test]
    fn any_fragments_are_answered(equations in fragments()) {
        is_answered(&equations);
    }

    #[test]
    fn any_change_of_a_model_is_answered(equations in mutated()) {
        is_answered(&equations);
    }
}
