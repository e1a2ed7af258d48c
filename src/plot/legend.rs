//! The legend: in an empty corner of the panel, or else to the right of it.

use super::PlotError;
use super::canvas::{Align, Canvas, Font};
use super::geometry::{Point, Rect};
use super::marker;
use super::stroke::{Pattern, dashes};
use super::style::{CURVE_WIDTH, GRID, GRID_WIDTH, INK, SMALL_SIZE, WHITE};
use super::text;
use crate::branch::Kind;
use plotters::style::RGBColor;

const ROW: f64 = 16.0;
const PADDING: f64 = 7.0;
const SAMPLE: f64 = 26.0;
/// Distance from the frame of the panel.
const GAP: f64 = 8.0;
/// Longer names of branches are cut.
const WIDEST: f64 = 190.0;
/// More entries than this would not fit beside a panel.
const MOST: usize = 18;

pub enum Sample {
    Line {
        colour: RGBColor,
        width: f64,
        pattern: Option<Pattern>,
    },
    Marker(Kind),
    /// No sample: a remark.
    Nothing,
}

impl Sample {
    pub fn solid(colour: RGBColor) -> Sample {
        Sample::Line { colour, width: CURVE_WIDTH, pattern: None }
    }
}

#[derive(Default)]
pub struct Legend {
    entries: Vec<(Sample, String)>,
}

impl Legend {
    pub fn add(&mut self, sample: Sample, meaning: &str) {
        let meaning = text::fitted(meaning, SMALL_SIZE, WIDEST);
        self.entries.push((sample, meaning));
    }

    /// Names of branches, cut short where there are too many for one figure.
    pub fn add_all(&mut self, mut names: Vec<(Sample, String)>, others: usize) {
        let room = MOST.saturating_sub(others);
        let left_out = names.len().saturating_sub(room);
        if left_out > 0 {
            names.truncate(room.saturating_sub(1));
        }
        for (sample, name) in names {
            self.add(sample, &name);
        }
        if left_out > 0 {
            self.add(Sample::Nothing, &format!("and {} more", left_out + 1));
        }
    }

    pub fn size(&self) -> (f64, f64) {
        let widest = (self.entries.iter()).map(|(_, meaning)| text::width(meaning, SMALL_SIZE)).fold(0.0, f64::max);
        (2.0 * PADDING + SAMPLE + 7.0 + widest, 2.0 * PADDING + ROW * self.entries.len() as f64)
    }

    /// A corner of the panel where there are neither curves nor special points.
    pub fn corner(&self, area: Rect, curves: &[Vec<Point>], points: &[Point]) -> Option<Rect> {
        let (width, height) = self.size();
        let (left, top) = (area.left + GAP, area.top + GAP);
        let (right, bottom) = (area.right - GAP - width, area.bottom - GAP - height);
        let corners = [(left, top), (right, top), (left, bottom), (right, bottom)];
        (corners.into_iter()).map(|(x, y)| Rect::new(x, y, width, height)).find(|place| {
            let guarded = place.grown(GAP - 1.0);
            width < 0.6 * area.width()
                && height < 0.6 * area.height()
                && curves.iter().all(|c| guarded.length_of(c) == 0.0)
                && !points.iter().any(|p| guarded.grown(10.0).contains(*p))
        })
    }

    /// The place to the right of a panel.
    pub fn beside(&self, area: Rect) -> Rect {
        let (width, height) = self.size();
        Rect::new(area.right + GAP, area.top, width, height)
    }

    pub fn draw(&self, canvas: &mut Canvas, place: Rect) -> Result<(), PlotError> {
        if self.entries.is_empty() {
            return Ok(());
        }
        canvas.fill(&place.outline(), WHITE)?;
        canvas.line(&place.outline(), GRID_WIDTH, GRID)?;
        let left = place.left + PADDING;
        for (i, (sample, meaning)) in self.entries.iter().enumerate() {
            let y = place.top + PADDING + (i as f64 + 0.5) * ROW;
            match sample {
                Sample::Line { colour, width, pattern } => {
                    let line = vec![(left, y), (left + SAMPLE, y)];
                    let pieces = match pattern {
                        Some(pattern) => dashes(&line, *pattern),
                        None => vec![line],
                    };
                    for piece in pieces {
                        canvas.line(&piece, *width, *colour)?;
                    }
                }
                Sample::Marker(kind) => {
                    marker::draw(canvas, *kind, (left + SAMPLE / 2.0, y), (1.0, 0.0))?;
                }
                Sample::Nothing => {}
            }
            let font = Font::new(SMALL_SIZE, Align::Left, INK);
            canvas.text(meaning, (left + SAMPLE + 7.0, y), font)?;
        }
        Ok(())
    }
}
