//! A colour bar: one ramp of colours or several side by side, with a common scale.

use super::PlotError;
use super::canvas::{Align, Canvas, Font};
use super::geometry::Rect;
use super::style::{FRAME_WIDTH, INK, LABEL_SIZE, SMALL_SIZE, TICK_SIZE};
use super::text;
use plotters::style::RGBColor;

/// Colours from 0 (below) to 1 (above).
pub type Ramp = fn(f64) -> RGBColor;

const BAR: f64 = 16.0;
const GAP: f64 = 5.0;
const TICK: f64 = 4.0;
const STEPS: usize = 64;

pub struct ColourBar {
    /// What the colours stand for, with its unit; read from bottom to top.
    pub title: String,
    /// Where a number is between 0 and 1, and how it is written.
    pub ticks: Vec<(f64, String)>,
    /// Each with the name above it.
    pub ramps: Vec<(String, Ramp)>,
}

impl ColourBar {
    /// Room for the bar of a height with all its texts.
    pub fn width(&self) -> f64 {
        let widest = self.ticks.iter().map(|(_, label)| text::width(label, TICK_SIZE)).fold(0.0, f64::max);
        self.bars() + TICK + 4.0 + widest + 8.0 + LABEL_SIZE
    }

    fn bars(&self) -> f64 {
        (BAR + GAP) * self.ramps.len() as f64 - GAP
    }

    /// Room above the bars for their names, which are written upright.
    pub fn head(&self) -> f64 {
        self.ramps.iter().map(|(name, _)| text::width(name, SMALL_SIZE) + 6.0).fold(0.0, f64::max)
    }

    /// Draws it with the bars from `top` to `bottom`; names stand above.
    pub fn draw(&self, canvas: &mut Canvas, left: f64, top: f64, bottom: f64) -> Result<(), PlotError> {
        let height = bottom - top;
        for (i, (name, ramp)) in self.ramps.iter().enumerate() {
            let bar = Rect::new(left + (BAR + GAP) * i as f64, top, BAR, height);
            let step = height / STEPS as f64;
            for k in 0..STEPS {
                // A little overlap: seams between equal edges would show.
                let piece =
                    Rect::new(bar.left, bottom - step * (k + 1) as f64, BAR, if k > 0 { step + 0.4 } else { step });
                canvas.fill(&piece.outline(), ramp((k as f64 + 0.5) / STEPS as f64))?;
            }
            for (place, _) in &self.ticks {
                let y = bottom - place * height;
                canvas.line(&[(bar.left, y), (bar.right, y)], 0.6, INK)?;
            }
            canvas.line(&bar.outline(), FRAME_WIDTH, INK)?;
            let mut font = Font::new(SMALL_SIZE, Align::Left, INK);
            font.upright = true;
            canvas.text(name, (bar.centre().0, top - 6.0), font)?;
        }
        let right = left + self.bars();
        for (place, label) in &self.ticks {
            let y = bottom - place * height;
            canvas.line(&[(right, y), (right + TICK, y)], FRAME_WIDTH, INK)?;
            canvas.text(label, (right + TICK + 4.0, y), Font::new(TICK_SIZE, Align::Left, INK))?;
        }
        let mut font = Font::new(LABEL_SIZE, Align::Centre, INK);
        font.upright = true;
        let title = text::fitted(&self.title, LABEL_SIZE, height);
        canvas.text(&title, (left + self.width() - LABEL_SIZE / 2.0, (top + bottom) / 2.0), font)
    }
}
