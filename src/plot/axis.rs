//! A range of numbers along one edge of a panel, with ticks at round numbers.

use super::style::TICK_SIZE;
use super::text;

/// Which way an axis runs on the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    Across,
    Up,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    pub value: f64,
    pub text: String,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    pub low: f64,
    pub high: f64,
    pub ticks: Vec<Tick>,
    /// The tick labels are to be multiplied by this power of ten, which the axis label shows.
    pub power: i32,
}

impl Axis {
    /// An axis from `low` to `high`, which must be an increasing and drawable pair (see [`range`]), of some pixels.
    pub fn new(low: f64, high: f64, pixels: f64, direction: Direction) -> Axis {
        let (wanted, most) = match direction {
            Direction::Across => (7.0, pixels / 34.0),
            Direction::Up => (7.0, pixels / 24.0),
        };
        let span = high - low;
        let mut step = Step::at_least(span / f64::min(wanted, most.max(1.0)));
        let (mut ticks, mut power) = step.ticks(low, high);
        while need(&ticks, direction) > step.size() / span * pixels {
            step = step.next();
            let (fewer, their_power) = step.ticks(low, high);
            if fewer.len() < 2 {
                // Long labels on a short axis: the outermost will do.
                let inner = 1..ticks.len().max(2) - 1;
                ticks.drain(inner);
                break;
            }
            (ticks, power) = (fewer, their_power);
        }
        Axis { low, high, ticks, power }
    }

    /// Where a number is between the ends: 0 at `low`, 1 at `high`.
    pub fn place(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    pub fn widest_tick(&self) -> f64 {
        (self.ticks.iter()).map(|t| text::width(&t.text, TICK_SIZE)).fold(0.0, f64::max)
    }
}

/// The least distance of tick labels, in pixels.
pub fn need(ticks: &[Tick], direction: Direction) -> f64 {
    match direction {
        Direction::Across => (ticks.iter()).map(|t| text::width(&t.text, TICK_SIZE) + 12.0).fold(0.0, f64::max),
        Direction::Up => TICK_SIZE * 1.6,
    }
}

/// Distance of ticks: 1, 2 or 5 times a power of ten.
#[derive(Clone, Copy)]
struct Step {
    digit: i32,
    power: i32,
}

impl Step {
    fn at_least(size: f64) -> Step {
        let power = size.log10().floor() as i32;
        let mut step = Step { digit: 1, power };
        while step.size() < size * (1.0 - 1e-9) {
            step = step.next();
        }
        step
    }

    fn next(self) -> Step {
        let (digit, power) = match self.digit {
            1 => (2, self.power),
            2 => (5, self.power),
            _ => (1, self.power + 1),
        };
        Step { digit, power }
    }

    fn size(self) -> f64 {
        f64::from(self.digit) * 10f64.powi(self.power)
    }

    /// Ticks from `low` to `high`, and the power of ten that their labels leave out.
    fn ticks(self, low: f64, high: f64) -> (Vec<Tick>, i32) {
        let size = self.size();
        let slack = 1e-6 * (high - low);
        let (first, last) = (((low - slack) / size).ceil(), ((high + slack) / size).floor());
        let largest = size * first.abs().max(last.abs());
        let exponent = (largest.log10() + 1e-9).floor();
        let power = if largest > 0.0 && !(-3.0..5.0).contains(&exponent) { exponent as i32 } else { 0 };
        let shift = self.power - power;
        let decimals = usize::try_from(-shift).unwrap_or(0);
        let label = |k: f64| {
            let text = format!("{:.*}", decimals, k * f64::from(self.digit) * 10f64.powi(shift));
            match text.strip_prefix('-') {
                Some(rest) => format!("−{rest}"),
                None => text,
            }
        };
        let count = (last - first).clamp(-1.0, 100.0) as i32;
        let ticks = (0..=count)
            .map(|i| first + f64::from(i) + 0.0)
            .map(|k| Tick { value: k * size, text: label(if k == 0.0 { 0.0 } else { k }) })
            .collect();
        (ticks, power)
    }
}

/// The range of some drawable numbers, `margin` of its length wider on both sides. Equal numbers, up to rounding, get a
/// range about them.
pub fn range(values: impl IntoIterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values {
        low = low.min(value);
        high = high.max(value);
    }
    if low > high {
        return (-1.0, 1.0);
    }
    let size = low.abs().max(high.abs());
    if size < 1e-290 {
        return (-1.0, 1.0);
    }
    if high - low < 1e-9 * size {
        let middle = low + (high - low) / 2.0;
        return (middle - 0.1 * size, middle + 0.1 * size);
    }
    let extra = margin * (high - low);
    (low - extra, high + extra)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|t| t.text.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_numbers() {
        let axis = Axis::new(-10.0, 510.0, 500.0, Direction::Across);
        assert_eq!(labels(&axis), ["0", "100", "200", "300", "400", "500"]);
        let axis = Axis::new(-0.25, 0.25, 300.0, Direction::Up);
        assert_eq!(labels(&axis), ["−0.2", "−0.1", "0.0", "0.1", "0.2"]);
        assert_eq!(axis.power, 0);
    }

    #[test]
    fn large_and_small_numbers_share_a_power_of_ten() {
        let axis = Axis::new(0.0, 3e9, 300.0, Direction::Up);
        assert_eq!((axis.power, labels(&axis)[1]), (9, "0.5"));
        let axis = Axis::new(-1e-12, 1.05e-12, 300.0, Direction::Up);
        assert_eq!((axis.power, labels(&axis)[0]), (-12, "−1.0"));
    }

    #[test]
    fn every_range_has_ticks_that_do_not_touch() {
        for power in [-280, -12, -3, 0, 4, 9, 280] {
            for (low, high) in [(0.0, 1.0), (-3.3, 7.1), (1.0, 1.0 + 1e-8), (-0.013, 0.0)] {
                for pixels in [60.0, 150.0, 500.0] {
                    let size = 10f64.powi(power);
                    let axis = Axis::new(low * size, high * size, pixels, Direction::Across);
                    let places: Vec<f64> = axis.ticks.iter().map(|t| axis.place(t.value)).collect();
                    assert!(!places.is_empty() && places.len() < 12, "{axis:?}");
                    assert!(places.iter().all(|p| (-1e-3..=1.001).contains(p)), "{axis:?}");
                    if places.len() > 2 {
                        let gap = (places[1] - places[0]) * pixels;
                        assert!(gap > axis.widest_tick(), "{axis:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn equal_numbers_have_a_range() {
        for value in [0.0, 1.0, -3e9, 1e-12, 1e-299] {
            let (low, high) = range([value, value], 0.05);
            assert!(low < value && value < high, "{value}");
        }
        assert_eq!(range([], 0.05), (-1.0, 1.0));
        assert_eq!(range([0.0, 10.0], 0.05), (-0.5, 10.5));
    }
}
