//! The colours of a map: bands between round numbers, linear or logarithmic, in viridis.

use crate::plot::axis::{Axis, Direction, Tick, range};
use crate::plot::decades;
use plotters::prelude::{ColorMap, ViridisRGB};
use plotters::style::RGBColor;

/// Positive numbers over a longer range than this have a logarithmic scale.
const WIDE: f64 = 100.0;
/// Of the numbers this part may lie below a logarithmic scale.
const BELOW: f64 = 0.02;
/// Bands of a logarithmic scale.
const MOST_BANDS: usize = 15;

pub struct Scale {
    /// Ends of the bands, increasing. What lies below the first is shown with the first band.
    pub levels: Vec<f64>,
    pub ticks: Vec<Tick>,
    /// The ticks' labels are to be multiplied by this power of ten.
    pub power: i32,
    logarithmic: bool,
    /// Whether numbers are interpolated by their logarithms: where none is zero.
    relative: bool,
}

impl Scale {
    /// For some numbers, on a bar of some pixels.
    pub fn new(values: impl Iterator<Item = f64>, pixels: f64) -> Scale {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let low = values.get((BELOW * values.len() as f64) as usize).copied().unwrap_or(0.0);
        let high = values.last().copied().unwrap_or(0.0);
        let least = values.first().copied().unwrap_or(0.0);
        if least >= 0.0 && low > 0.0 && high / low > WIDE {
            Self::logarithmic(least, low, high)
        } else {
            Self::linear(&values, pixels)
        }
    }

    fn linear(values: &[f64], pixels: f64) -> Scale {
        let (low, high) = range(values.iter().copied(), 0.0);
        let ticks = Axis::new(low, high, pixels, Direction::Up).ticks;
        // Two bands between ticks.
        let step = match &ticks[..] {
            [a, b, ..] => 0.5 * (b.value - a.value),
            _ => 0.5 * (high - low),
        };
        let (first, last) = ((low / step + 1e-9).floor(), (high / step - 1e-9).ceil());
        let count = (last - first).clamp(1.0, 100.0) as i32;
        let levels: Vec<f64> = (0..=count).map(|k| (first + f64::from(k)) * step).collect();
        let axis = Axis::new(levels[0], levels[levels.len() - 1], pixels, Direction::Up);
        Scale { levels, ticks: axis.ticks, power: axis.power, logarithmic: false, relative: false }
    }

    fn logarithmic(least: f64, low: f64, high: f64) -> Scale {
        let (low, high) = (low.log10(), high.log10());
        let marks = decades::marks(low.floor(), high.ceil(), MOST_BANDS);
        // The outermost marks beyond both ends.
        let first = marks.iter().rposition(|mark| mark.value <= low).unwrap_or(0);
        let last = marks.iter().position(|mark| mark.value >= high).unwrap_or(marks.len().saturating_sub(1));
        let mut ticks = marks[first..=last.max(first)].to_vec();
        ticks.iter_mut().for_each(|tick| tick.value = 10f64.powf(tick.value));
        let levels: Vec<f64> = ticks.iter().map(|tick| tick.value).collect();
        // The lowest band has no lower end then.
        if ticks.first().is_some_and(|tick| least < tick.value) {
            ticks.remove(0);
        }
        Scale { levels, ticks, power: 0, logarithmic: true, relative: least > 0.0 }
    }

    /// What is interpolated of a number.
    pub fn place(&self, value: f64) -> f64 {
        match self.levels.first() {
            Some(lowest) if self.relative => value.max(*lowest).log10(),
            _ => value,
        }
    }

    /// How high on the bar a level lies, from 0 to 1.
    pub fn height(&self, level: f64) -> f64 {
        let place = |level: f64| if self.logarithmic { level.log10() } else { level };
        let (low, high) = match self.levels[..] {
            [low, .., high] => (place(low), place(high)),
            _ => return 0.0,
        };
        (place(level) - low) / (high - low)
    }

    /// The colour of the band that begins at level k.
    pub fn colour(&self, k: usize) -> RGBColor {
        let last = self.levels.len().saturating_sub(2).max(1);
        ViridisRGB.get_color(k.min(last) as f64 / last as f64)
    }
}
