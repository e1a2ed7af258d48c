//! `symmetry = "x -> -x, y -> -y"` and `rotations = ["x -> -y, y -> x"]`, a rotation being written as its quarter turn:
//! read, and tried on the equations.

use super::Wrong;
use super::build::shorten;
use super::formula::Text;
use super::index::{Whole, values};
use super::scope::show;
use crate::expression::{Node, suggest};
use crate::problem::{Reflection, Rotation};
use std::collections::HashMap;

/// Relative to the equation's own value; far above rounding, far below any true difference.
const TOLERANCE: f64 = 1e-9;

/// A map that is its own inverse.
pub(super) fn read(text: &Text, written: &str, constants: &[(String, i64)]) -> Result<Reflection, Wrong> {
    let reflection = exchange(text, written, constants)?;
    let twice = (0..text.names.len()).find(|&i| {
        let j = reflection.source[i];
        reflection.source[j] != i || reflection.sign[i] * reflection.sign[j] != 1.0
    });
    if let Some(i) = twice {
        let message = format!(
            "the symmetry, done twice, does not take {} to itself; list what it is exchanged with",
            text.names[i]
        );
        return Err(Wrong { offset: None, message });
    }
    check(text, &reflection)?;
    Ok(reflection)
}

/// A rotation from its quarter turn: what is not listed does not turn.
pub(super) fn rotation(text: &Text, written: &str, constants: &[(String, i64)]) -> Result<Rotation, Wrong> {
    let quarter = exchange(text, written, constants)?;
    let mut planes = Vec::new();
    for (i, (&j, &sign)) in quarter.source.iter().zip(&quarter.sign).enumerate() {
        if i == j && sign == 1.0 {
            continue;
        }
        if i == j || quarter.source[j] != i || quarter.sign[j] != -sign {
            let message = format!(
                "a rotation is written as its quarter turn, pairs such as x -> -y, y -> x; {} has no such partner",
                text.names[i]
            );
            return Err(Wrong { offset: None, message });
        }
        // x -> -y: the state's x becomes -y.
        if sign < 0.0 {
            planes.push((i, j, 1.0));
        }
    }
    let rotation = Rotation { planes };
    check_turn(text, &rotation)?;
    Ok(rotation)
}

/// A signed permutation; unknowns that are not listed stay as they are.
fn exchange(text: &Text, written: &str, constants: &[(String, i64)]) -> Result<Reflection, Wrong> {
    let n = text.names.len();
    let positions: HashMap<&str, usize> = text.names.iter().enumerate().map(|(i, name)| (name.as_str(), i)).collect();
    let whole = Whole { constants };
    let mut reflection = Reflection::identity(n);
    let mut at = 0;
    for part in split(written) {
        let wrong = |message: String| Wrong::new(at, message);
        let Some((left, right)) = part.split_once("->") else {
            return Err(wrong(format!("{:?} is not of the form x -> -x", part.trim())));
        };
        let parse = |text: &str| Node::parse(text).map_err(|error| wrong(error.fault.to_string()));
        let (left, right) = (parse(left)?, parse(right)?);
        let (sign, right) = match &right {
            Node::Negate(inner) => (-1.0, &**inner),
            other => (1.0, other),
        };
        let (from, to) = (symbol(&left), symbol(right));
        let (Some((from, from_indices)), Some((to, to_indices))) = (from, to) else {
            return Err(wrong("a symmetry takes an unknown to an unknown or its negative, as in x -> -x".to_owned()));
        };
        let mut any = false;
        for i in 0..n {
            let Some(element) = element(&text.names[i], from) else { continue };
            // Indices that are names stand for all elements; an array without any for all as they are.
            let mut local = Vec::new();
            let mut matches = true;
            for (index, &value) in from_indices.iter().zip(&element) {
                match index {
                    Node::Name(name, _) if !constants.iter().any(|(known, _)| known == name) => {
                        local.push((name.clone(), value));
                    }
                    other => matches &= whole.value(other, &[])? == value,
                }
            }
            if !matches || (!from_indices.is_empty() && from_indices.len() != element.len()) {
                continue;
            }
            any = true;
            let target = if from_indices.is_empty() { element } else { values(&whole, to_indices, &local)? };
            let target = show(to, &target);
            let Some(&source) = positions.get(target.as_str()) else {
                return Err(wrong(unknown(text, &target)));
            };
            reflection.source[i] = source;
            reflection.sign[i] = sign;
        }
        if !any {
            return Err(wrong(unknown(text, from)));
        }
        at += part.len() + 1;
    }
    Ok(reflection)
}

/// Parts between commas that are not inside brackets.
fn split(text: &str) -> Vec<&str> {
    let (mut depth, mut start, mut parts) = (0_i64, 0, Vec::new());
    for (i, c) in text.char_indices() {
        match c {
            '[' | '(' => depth += 1,
            ']' | ')' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&text[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}

fn symbol(node: &Node) -> Option<(&str, &[Node])> {
    match node {
        Node::Name(name, _) => Some((name, &[])),
        Node::Element(name, indices, _) => Some((name, indices)),
        _ => None,
    }
}

/// The indices of an unknown's name, if it belongs to the array.
fn element(name: &str, array: &str) -> Option<Vec<i64>> {
    let rest = name.strip_prefix(array)?;
    if rest.is_empty() {
        return Some(Vec::new());
    }
    let inner = rest.strip_prefix('[')?.strip_suffix(']')?;
    inner.split(", ").map(|index| index.parse().ok()).collect()
}

fn unknown(text: &Text, name: &str) -> String {
    let names: Vec<&str> = text.names.iter().map(String::as_str).collect();
    match suggest(name, names.iter().copied()) {
        Some(meant) => format!("{name} is not an unknown; did you mean {meant:?}?"),
        None => format!("{name} is not an unknown; unknowns are {}", shorten(&names)),
    }
}

/// Numbers in (0.2, 0.8) without pattern.
pub(super) fn scattered(seed: usize, count: usize) -> Vec<f64> {
    let wave = |k: usize| 0.5 + 0.3 * (1.0 + 2.4 * k as f64 + 0.7 * (k as f64).sqrt()).sin();
    (0..count).map(|i| wave(seed + 3 * i)).collect()
}

/// The equations at the image of a point must be, up to signs, the image of the equations at the point.
fn check(text: &Text, reflection: &Reflection) -> Result<(), Wrong> {
    let n = text.names.len();
    let [u, v, p] = anywhere(text);
    let (mut image_u, mut image_v) = (vec![0.0; n], vec![0.0; n]);
    reflection.apply(&u, &mut image_u);
    reflection.apply(&v, &mut image_v);
    let (mut g, mut image) = (vec![0.0; n], vec![0.0; n]);
    text.residual.evaluate(&u, &v, &p, &mut g);
    text.residual.evaluate(&image_u, &image_v, &p, &mut image);
    for i in 0..n {
        let (seen, expected) = (image[i].abs(), g[reflection.source[i]].abs());
        // Where the formulas have no value there, the author is trusted.
        if (seen - expected).abs() > TOLERANCE * seen.max(expected) {
            let message = format!("the symmetry does not hold: the equation of {} changes", text.names[i]);
            return Err(Wrong { offset: None, message });
        }
    }
    Ok(())
}

/// Some u, v and p.
fn anywhere(text: &Text) -> [Vec<f64>; 3] {
    let (n, m) = (text.names.len(), text.parameters.len());
    [scattered(0, n), scattered(1000, n), scattered(5000, m)]
}

/// The equations must turn with the state: those of a pair as the pair, the others not at all.
fn check_turn(text: &Text, rotation: &Rotation) -> Result<(), Wrong> {
    const ANGLE: f64 = 0.7;
    let [mut u, mut v, p] = anywhere(text);
    let n = u.len();
    let (mut expected, mut seen) = (vec![0.0; n], vec![0.0; n]);
    text.residual.evaluate(&u, &v, &p, &mut expected);
    [&mut u, &mut v, &mut expected].into_iter().for_each(|x| rotation.turn(ANGLE, x));
    text.residual.evaluate(&u, &v, &p, &mut seen);
    let mut sizes: Vec<f64> = expected.iter().zip(&seen).map(|(a, b)| a.abs().max(b.abs())).collect();
    for &(i, j, _) in &rotation.planes {
        let size = sizes[i].max(sizes[j]);
        (sizes[i], sizes[j]) = (size, size);
    }
    match (0..n).find(|&i| (seen[i] - expected[i]).abs() > TOLERANCE * sizes[i]) {
        None => Ok(()),
        Some(i) => {
            let message =
                format!("the rotation is no symmetry: the equation of {} does not turn with it", text.names[i]);
            Err(Wrong { offset: None, message })
        }
    }
}
