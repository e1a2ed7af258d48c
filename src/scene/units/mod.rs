//! Units of measurement: `pN s µm⁻²`, `pN/um^2`, `1/s`. Only what conversion between them needs.

#[cfg(test)]
mod tests;

use std::fmt::Write;

use thiserror::Error;

/// Largest exponent read; keeps the arithmetic of exponents far from overflow.
const MAX_EXPONENT: i32 = 99;
/// Most factors and operators read, for the same reason.
const MAX_TOKENS: usize = 100;

const PREFIXES: [(&str, i32); 11] = [
    ("f", -15),
    ("p", -12),
    ("n", -9),
    ("µ", -6),
    ("μ", -6), // Greek mu: looks the same, is another character
    ("u", -6),
    ("m", -3),
    ("c", -2),
    ("k", 3),
    ("M", 6),
    ("G", 9),
];

/// Symbol, power of ten, exponents of metre, gram and second.
const SYMBOLS: [(&str, i32, [i32; 3]); 8] = [
    ("m", 0, [1, 0, 0]),
    ("s", 0, [0, 0, 1]),
    ("g", 0, [0, 1, 0]),
    ("N", 3, [1, 1, -2]),
    ("Pa", 3, [-1, 1, -2]),
    ("J", 3, [2, 1, -2]),
    ("Hz", 0, [0, 0, -1]),
    ("rad", 0, [0, 0, 0]),
];

#[derive(Clone, Debug, PartialEq, Error)]
pub enum UnitError {
    #[error(
        "unknown symbol {symbol:?} in the unit {unit:?}; known are m, s, g, N, Pa, J, Hz, rad with the prefixes f, p, n, µ (or u), m, c, k, M, G"
    )]
    Symbol { symbol: String, unit: String },
    #[error("the unit {unit:?} cannot be read near {near:?}; write factors such as pN s µm^-2 or pN/µm^2")]
    Syntax { unit: String, near: String },
    #[error("the units {from:?} and {to:?} do not fit: their dimensions are {from_dimension} and {to_dimension}")]
    Dimension { from: String, to: String, from_dimension: String, to_dimension: String },
    #[error(
        "the units {from:?} and {to:?} do not fit: one counts cycles, the other radians (2 pi per cycle); multiply or divide by 2 pi yourself"
    )]
    Cycles { from: String, to: String },
    #[error("between the units {from:?} and {to:?} lies a factor of 1e{power}, beyond double-precision numbers")]
    Factor { from: String, to: String, power: i32 },
}

/// The factor that turns a value in `from` into one in `to`: value_to = factor * value_from.
pub fn conversion(from: &str, to: &str) -> Result<f64, UnitError> {
    let (source, target) = (Unit::parse(from)?, Unit::parse(to)?);
    if source.dimension != target.dimension {
        return Err(UnitError::Dimension {
            from: from.to_owned(),
            to: to.to_owned(),
            from_dimension: source.describe(),
            to_dimension: target.describe(),
        });
    }
    if (source.hertz && target.radian) || (source.radian && target.hertz) {
        return Err(UnitError::Cycles { from: from.to_owned(), to: to.to_owned() });
    }
    let power = source.power - target.power;
    // By way of text: the nearest double to the power of ten, which repeated multiplication misses beyond 1e22.
    let factor = format!("1e{power}").parse().unwrap_or(f64::NAN);
    if factor.is_normal() {
        Ok(factor)
    } else {
        Err(UnitError::Factor { from: from.to_owned(), to: to.to_owned(), power })
    }
}

/// Whether `unit` is a unit at all.
pub fn check(unit: &str) -> Result<(), UnitError> {
    Unit::parse(unit).map(|_| ())
}

/// A product of powers of symbols.
#[derive(Clone, Debug, Default, PartialEq)]
struct Unit {
    /// Power of ten.
    power: i32,
    /// Exponents of metre, gram and second.
    dimension: [i32; 3],
    /// Whether hertz, and whether radians, occur: they are pure numbers of different things.
    hertz: bool,
    radian: bool,
}

impl Unit {
    fn parse(text: &str) -> Result<Unit, UnitError> {
        let mut unit = Unit::default();
        let syntax = |near: &str| UnitError::Syntax { unit: text.to_owned(), near: near.to_owned() };
        let trimmed = text.trim();
        if trimmed.is_empty() || trimmed == "-" {
            return Ok(unit);
        }
        // An operator waits for the factor after it; a space between factors is a product.
        let mut operator: Option<char> = None;
        let mut first = true;
        for (position, token) in tokens(trimmed).into_iter().enumerate() {
            if position >= MAX_TOKENS {
                return Err(syntax(token));
            }
            match token {
                "*" | "·" | "⋅" | "/" => {
                    if first || operator.is_some() {
                        return Err(syntax(token));
                    }
                    operator = token.chars().next();
                }
                factor => {
                    let sign = if operator.take() == Some('/') { -1 } else { 1 };
                    unit.multiply(factor, sign, text)?;
                    first = false;
                }
            }
        }
        match operator {
            Some(_) => Err(syntax("the end")),
            None => Ok(unit),
        }
    }

    fn multiply(&mut self, factor: &str, sign: i32, whole: &str) -> Result<(), UnitError> {
        let syntax = || UnitError::Syntax { unit: whole.to_owned(), near: factor.to_owned() };
        let (symbol, exponent) = split_exponent(factor).ok_or_else(syntax)?;
        if symbol == "1" {
            return Ok(());
        }
        let (power, dimension) =
            lookup(symbol).ok_or_else(|| UnitError::Symbol { symbol: symbol.to_owned(), unit: whole.to_owned() })?;
        let exponent = sign * exponent;
        self.power += exponent * power;
        for (sum, own) in self.dimension.iter_mut().zip(dimension) {
            *sum += exponent * own;
        }
        self.hertz |= symbol.ends_with("Hz");
        self.radian |= symbol.ends_with("rad");
        Ok(())
    }

    fn describe(&self) -> String {
        let mut text = String::new();
        for (symbol, exponent) in ["m", "g", "s"].iter().zip(self.dimension) {
            if exponent == 0 {
                continue;
            }
            if !text.is_empty() {
                text.push(' ');
            }
            text.push_str(symbol);
            if exponent != 1 {
                // Writing to a string cannot fail.
                let _ = write!(text, "^{exponent}");
            }
        }
        if text.is_empty() {
            text.push_str("none (a pure number)");
        }
        text
    }
}

/// Factors and operators; spaces separate.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    for word in text.split_whitespace() {
        let mut rest = word;
        while let Some(at) = rest.find(['*', '·', '⋅', '/']) {
            let (before, after) = rest.split_at(at);
            if !before.is_empty() {
                tokens.push(before);
            }
            let length = after.chars().next().map_or(0, char::len_utf8);
            let (operator, remaining) = after.split_at(length);
            tokens.push(operator);
            rest = remaining;
        }
        if !rest.is_empty() {
            tokens.push(rest);
        }
    }
    tokens
}

/// `µm^-2` or `µm⁻²` into `µm` and -2.
fn split_exponent(factor: &str) -> Option<(&str, i32)> {
    let (symbol, digits) = if let Some((symbol, digits)) = factor.split_once('^') {
        (symbol, digits.to_owned())
    } else {
        match factor.find(|c| plain_digit(c).is_some()) {
            None => return Some((factor, 1)),
            Some(at) => {
                let (symbol, raised) = factor.split_at(at);
                let digits: Option<String> = raised.chars().map(plain_digit).collect();
                (symbol, digits?)
            }
        }
    };
    let exponent: i32 = digits.parse().ok()?;
    (exponent.abs() <= MAX_EXPONENT).then_some((symbol, exponent))
}

fn plain_digit(superscript: char) -> Option<char> {
    Some(match superscript {
        '⁰' => '0',
        '¹' => '1',
        '²' => '2',
        '³' => '3',
        '⁴' => '4',
        '⁵' => '5',
        '⁶' => '6',
        '⁷' => '7',
        '⁸' => '8',
        '⁹' => '9',
        '⁻' => '-',
        '⁺' => '+',
        _ => return None,
    })
}

/// Power of ten and dimension of a symbol, with or without prefix.
fn lookup(symbol: &str) -> Option<(i32, [i32; 3])> {
    let base = |name: &str| SYMBOLS.iter().find(|(known, ..)| *known == name);
    if let Some(&(_, power, dimension)) = base(symbol) {
        return Some((power, dimension));
    }
    PREFIXES.iter().find_map(|(prefix, shift)| {
        let &(_, power, dimension) = base(symbol.strip_prefix(prefix)?)?;
        Some((power + shift, dimension))
    })
}
