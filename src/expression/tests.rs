use num_dual::{Dual3, Dual64, first_derivative, third_derivative};
use proptest::prelude::*;

use super::*;

fn value(text: &str) -> f64 {
    let lookup = |name: &str| match name {
        "x" => Some(3.0),
        "c_N" => Some(0.003),
        "L" => Some(12.0),
        "EI" => Some(400.0),
        _ => None,
    };
    Expression::parse(text)
        .unwrap_or_else(|error| panic!("{text}: {error}"))
        .eval::<f64>(&lookup)
        .unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn complaint(text: &str) -> String {
    Expression::parse(text).expect_err("must be refused").to_string()
}

#[test]
fn precedence_is_that_of_print() {
    for (text, expected) in [
        ("1 + 2 * 3", 7.0),
        ("10 - 4 - 3", 3.0),
        ("24 / 4 / 2", 3.0),
        ("24 / 4 * 2", 12.0),
        ("-x^2", -9.0),
        ("(-x)^2", 9.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("2^-x^2", 2f64.powi(-9)),
        ("2 * -x", -6.0),
        ("x - -x", 6.0),
        ("--x", 3.0),
        (" ( 1e-3 + 2. + .5 ) * 2E+2 ", 500.2),
        ("2 * pi", 2.0 * PI),
        ("sqrt (16) + abs(-2) + log(exp(1)) + log10(1000)", 10.0),
        ("sin(0) + cos(0) + tan(0) + sinh(0) + cosh(0) + tanh(0)", 2.0),
        ("x^0 + x^1", 4.0),
        ("(-2)^(6/2)", -8.0),
        ("16^(1/2)", 4.0),
        ("2^x", 8.0),
    ] {
        assert!((value(text) - expected).abs() < 1e-12, "{text}: {}", value(text));
    }
    assert!((value("c_N * L^4 / EI / 200") - 7.776e-4).abs() < 1e-18);
}

#[test]
fn errors_name_the_column_and_what_was_expected() {
    for (text, expected) in [
        ("", "column 1: expected a number, a name, a function, \"-\" or \"(\", found the end"),
        ("1 + ", "column 5: expected a number, a name, a function, \"-\" or \"(\", found the end"),
        ("1 + * 2", "column 5: expected a number, a name, a function, \"-\" or \"(\", found \"*\""),
        ("(1 + 2", "column 7: expected an operator or \")\", found the end"),
        ("2 x", "column 3: expected an operator or the end, found \"x\""),
        ("tau µ 2", "column 5: expected an operator or the end, found \"µ\""),
        ("µ)", "column 2: expected an operator or the end, found \")\""),
        ("sin", "column 4: expected \"(\" after the function sin, found the end"),
        ("1 + sine(2)", "column 5: unknown function \"sine\"; did you mean \"sin\"?"),
        (
            "L(2)",
            "column 1: unknown function \"L\"; known are sin, cos, tan, asin, acos, atan, exp, log, log10, sqrt, abs, sinh, cosh, tanh, asinh, acosh, atanh",
        ),
        ("pi(2)", "column 3: expected an operator or the end, found \"(\""),
        ("1e999", "column 1: \"1e999\" is too large for a double-precision number (about 1.8e308)"),
        (".", "column 2: expected a number, a name, a function, \"-\" or \"(\", found the end"),
    ] {
        assert_eq!(complaint(text), expected, "{text}");
    }
}

#[test]
fn endless_nesting_is_refused_not_a_crash() {
    for text in [
        "(".repeat(5000),
        "-".repeat(5000),
        "2^".repeat(5000),
        "sin(".repeat(2000),
        "1+".repeat(4000) + "1",
        "1*".repeat(4000) + "1",
    ] {
        assert!(complaint(&text).contains("nested too deeply"), "{}", complaint(&text));
    }
    assert!(complaint(&"1".repeat(20_000)).contains("at most 10000"));
    let deep = format!("{}x{}", "(".repeat(90), ")".repeat(90));
    assert_eq!(value(&deep), 3.0);
    assert_eq!(value(&("1+".repeat(250) + "1")), 251.0);
}

#[test]
fn towers_of_powers_take_no_time() {
    let tower = "x^".repeat(95) + "x";
    let expression = Expression::parse(&tower).expect("valid");
    assert_eq!(expression.eval(&|_| Some(1.0)), Ok(1.0));
    assert_eq!(value(&("1^".repeat(95) + "x")), 1.0);
}

#[test]
fn names_are_free_names_only() {
    let expression = Expression::parse("c_N * L^4 / sqrt(EI) * pi + L").expect("valid");
    let names: Vec<String> = expression.names().into_iter().collect();
    assert_eq!(names, ["EI", "L", "c_N"]);
    let error = expression.eval::<f64>(&|_| None).expect_err("no names known");
    assert_eq!(error.to_string(), "unknown name \"c_N\"");
}

type Real = fn(f64) -> f64;

const DERIVATIVES: [(&str, Real); 15] = [
    ("x^3", |x| 3.0 * x * x),
    ("x^-2", |x| -2.0 * x.powi(-3)),
    ("x^2.5", |x| 2.5 * x.powf(1.5)),
    ("2^x", |x| x.exp2() * 2f64.ln()),
    ("x^x", |x| x.powf(x) * (x.ln() + 1.0)),
    ("sin(2*x)", |x| 2.0 * (2.0 * x).cos()),
    ("cos(x)/x", |x| -x.sin() / x - x.cos() / (x * x)),
    ("tan(x)", |x| x.cos().powi(-2)),
    ("exp(-x^2)", |x| -2.0 * x * (-x * x).exp()),
    ("log(x)", |x| x.recip()),
    ("log10(x)", |x| 1.0 / (x * 10f64.ln())),
    ("sqrt(x)", |x| 0.5 / x.sqrt()),
    ("abs(-x)", |_| 1.0),
    ("sinh(x) * cosh(x)", |x| (2.0 * x).cosh()),
    ("tanh(x)", |x| x.cosh().powi(-2)),
];

#[test]
fn extreme_powers_and_tanh_stay_finite() {
    let cube = |text: &str, x: f64| {
        let expression = Expression::parse(text).expect("valid");
        third_derivative(|x: Dual3<f64>| expression.eval(&|_| Some(x)).expect("x is known"), x)
    };
    let (value, first, second, third) = cube("x^4", 0.0);
    assert_eq!((value, first, second, third), (0.0, 0.0, 0.0, 0.0));
    let (value, first, ..) = cube("x^-1", 1e-100);
    assert!((value / 1e100 - 1.0).abs() < 1e-14 && (first / -1e200 - 1.0).abs() < 1e-14);
    let (value, first, ..) = cube("x^2000000000", 1.0);
    assert_eq!((value, first), (1.0, 2e9));
    for x in [-1e4, 1e4] {
        assert_eq!(cube("tanh(x)", x), (x.signum(), 0.0, 0.0, 0.0));
    }
}

fn nodes() -> impl Strategy<Value = Node> {
    let here = Offset::default();
    let name = || {
        "[a-z_][a-z0-9_]{0,5}"
            .prop_filter("reserved", |name| Function::named(name).is_none() && !RESERVED.contains(&name.as_str()))
    };
    let leaf = prop_oneof![
        (0.0..1e300f64).prop_map(Node::Number),
        (0.0..10f64).prop_map(Node::Number),
        (0u32..1000).prop_map(|whole| Node::Number(whole.into())),
        Just(Node::Number(f64::MIN_POSITIVE)),
        Just(Node::Pi),
        name().prop_map(move |name| Node::Name(name, here)),
    ];
    leaf.prop_recursive(6, 40, 3, move |inner| {
        let several = proptest::collection::vec(inner.clone(), 1..3);
        prop_oneof![
            inner.clone().prop_map(|node| Node::Negate(Box::new(node))),
            (0..Function::ALL.len(), inner.clone()).prop_map(move |(i, node)| Node::Call(
                Function::ALL[i].1,
                Box::new(node),
                here
            )),
            (0..5usize, inner.clone(), inner.clone()).prop_map(move |(i, left, right)| {
                let operators =
                    [Operator::Add, Operator::Subtract, Operator::Multiply, Operator::Divide, Operator::Power];
                Node::Binary(operators[i], Box::new(left), Box::new(right), here)
            }),
            (name(), several.clone()).prop_map(move |(name, parts)| Node::Element(name, parts, here)),
            (name(), several.clone())
                .prop_map(move |(name, parts)| Node::Rate(Box::new(Node::Element(name, parts, here)))),
            (name(), several).prop_map(move |(name, parts)| Node::Apply(name, parts, here)),
            (inner.clone(), name(), inner.clone(), inner).prop_map(move |(body, name, from, to)| {
                Node::Sum(Box::new(body), Box::new(Indices { name, from, to, at: here }))
            }),
        ]
    })
}

#[test]
fn ties_hold_no_arrays_and_no_rates() {
    for (text, expected) in [
        ("1 + u[2]", "column 5: an element of an array has no place here"),
        ("2*x'", "column 3: a rate of change has no place here"),
        ("sum(x, i = 1..3)", "column 8: a sum over an index has no place here"),
        ("1 + f(2, 3)", "column 5: unknown function \"f\""),
        ("sin(1, 2)", "column 10: expected one argument of the function before"),
    ] {
        assert!(complaint(text).starts_with(expected), "{text}: {}", complaint(text));
    }
}

#[test]
fn offsets_point_into_the_text() {
    let all = statements("# first\nx' = a\n\ny' = (b +\n  c)  # more\n  for i = 1..N").expect("valid");
    assert_eq!(all.len(), 2);
    assert_eq!((all[0].start, all[1].start), (8, 16));
    assert_eq!(all[1].right.offset(), Some(22));
    assert_eq!(all[1].ranges.len(), 1);
    let wrong = statements("x' = a\ny' = b c").expect_err("must be refused");
    assert_eq!(
        (wrong.offset, wrong.fault.to_string().as_str()),
        (14, "expected an operator, \"for\" or the end of the line, found \"c\"")
    );
}

proptest! {
    #[test]
    fn printing_and_reading_back_gives_the_same_tree(node in nodes()) {
        let text = node.to_string();
        prop_assert_eq!(Node::parse(&text), Ok(node), "{}", text);
    }

    #[test]
    fn any_text_is_answered(text in "\\PC{0,40}") {
        let _ = Expression::parse(&text);
    }

    #[test]
    fn any_formula_like_text_is_answered(text in "[0-9.eE+*/^()x si-]{0,30}") {
        if let Ok(expression) = Expression::parse(&text) {
            let _ = expression.eval::<f64>(&|_| Some(0.5));
            let _ = expression.eval::<Dual64>(&|_| Some(Dual64::from(0.5)));
        }
    }

    #[test]
    fn derivatives_match_closed_forms(x in 0.2..1.5f64, case in 0..DERIVATIVES.len()) {
        let (text, derivative) = DERIVATIVES[case];
        let expression = Expression::parse(text).expect("valid");
        let (value, slope) = first_derivative(|x: Dual64| expression.eval(&|_| Some(x)).expect("x is known"), x);
        let plain = expression.eval(&|_| Some(x)).expect("x is known");
        let expected = derivative(x);
        prop_assert!((value - plain).abs() <= 1e-14 * (1.0 + plain.abs()), "{text} at {x}: {value} {plain}");
        prop_assert!((slope - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{text} at {x}: {slope} {expected}");
    }
}
