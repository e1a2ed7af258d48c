//! Round numbers of a logarithmic scale, and axes that carry the logarithm to base 10.

use super::axis::{Axis, Direction, Tick, need};
use super::text;

/// Digits at which marks stand within a decade, the densest first.
const DIGITS: [&[i32]; 4] = [&[1, 2, 3, 4, 5, 6, 7, 8, 9], &[1, 2, 5], &[1, 3], &[1]];
/// Whole decades from one mark to the next, where one for each would be too many.
const STRIDES: [i32; 8] = [1, 2, 3, 5, 10, 20, 50, 100];

/// The marks between two logarithms, at most `most` of them; the places are logarithms, too.
pub fn marks(low: f64, high: f64, most: usize) -> Vec<Tick> {
    let slack = 1e-9 * (high - low);
    let between = |tick: &Tick| tick.value >= low - slack && tick.value <= high + slack;
    let (first, last) = (low.floor() as i32, high.ceil() as i32);
    let plain = first >= -3 && last <= 5;
    let all = |digits: &[i32], stride: i32| -> Vec<Tick> {
        let decades = (first..=last).filter(|decade| decade.rem_euclid(stride) == 0);
        let marks = decades.flat_map(|decade| digits.iter().map(move |&digit| (decade, digit)));
        let tick = |(decade, digit): (i32, i32)| Tick {
            value: f64::from(decade) + f64::from(digit).log10(),
            text: written(digit, decade, plain),
        };
        marks.map(tick).filter(between).collect()
    };
    let dense = DIGITS.iter().map(|digits| (*digits, 1));
    let sparse = STRIDES.iter().map(|&stride| (&[1][..], stride));
    let mut choices = dense.chain(sparse).map(|(digits, stride)| all(digits, stride));
    choices.find(|marks| marks.len() <= most).unwrap_or_default()
}

/// An axis whose numbers are logarithms and whose ticks are labelled with what they stand for.
pub fn axis(low: f64, high: f64, pixels: f64, direction: Direction) -> Axis {
    let mut most = 8;
    loop {
        let ticks = marks(low, high, most);
        let closest = ticks.windows(2).map(|pair| pair[1].value - pair[0].value).fold(f64::INFINITY, f64::min);
        if ticks.len() < 3 || closest / (high - low) * pixels >= need(&ticks, direction) {
            return Axis { low, high, ticks, power: 0 };
        }
        most = ticks.len() - 1;
    }
}

/// "0.02", or "2×10⁷" where plain numbers would be long.
fn written(digit: i32, decade: i32, plain: bool) -> String {
    if plain {
        let decimals = usize::try_from(-decade).unwrap_or(0);
        return format!("{:.decimals$}", f64::from(digit) * 10f64.powi(decade));
    }
    match digit {
        1 => format!("10{}", text::superscript(decade)),
        _ => format!("{digit}×10{}", text::superscript(decade)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, most: usize) -> Vec<String> {
        marks(low, high, most).into_iter().map(|tick| tick.text).collect()
    }

    #[test]
    fn marks_are_as_dense_as_there_is_room() {
        assert_eq!(labels(0.0, 1.0, 8), ["1", "2", "5", "10"]);
        assert_eq!(labels(-1.0, 2.0, 7), ["0.1", "0.3", "1", "3", "10", "30", "100"]);
        assert_eq!(labels(-6.0, 0.0, 8), ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "10⁰"]);
        assert_eq!(labels(-6.0, 6.0, 8), ["10⁻⁶", "10⁻⁴", "10⁻²", "10⁰", "10²", "10⁴", "10⁶"]);
        assert!(labels(-250.0, 300.0, 8).len() <= 8);
    }

    #[test]
    fn ticks_do_not_touch() {
        for (low, high) in [(0.0, 1.0), (-6.0, -1.0), (0.3, 0.5), (-2.2, 3.9), (0.0, 250.0)] {
            for pixels in [100.0, 470.0] {
                let axis = axis(low, high, pixels, Direction::Across);
                let places: Vec<f64> = axis.ticks.iter().map(|t| axis.place(t.value) * pixels).collect();
                let apart = places.windows(2).all(|pair| pair[1] - pair[0] > axis.widest_tick());
                assert!(apart || places.len() < 3, "{axis:?}");
            }
        }
    }
}
