//! A framed rectangle with axes, and the page around it.

use super::PlotError;
use super::axis::{Axis, Tick};
use super::canvas::{Align, Canvas, Font};
use super::geometry::{Point, Rect};
use super::style::{FRAME_WIDTH, GRID, GRID_WIDTH, INK, LABEL_SIZE, SMALL_SIZE, TICK_SIZE, TITLE_SIZE, ZERO};
use super::text;

/// Free room at the edges of a page.
pub const EDGE: f64 = 10.0;
/// Room below a panel for tick labels and an axis label.
pub const FOOT: f64 = 50.0;
const TICK_LENGTH: f64 = 4.0;
const LINE_HEIGHT: f64 = 18.0;

pub struct Panel {
    pub area: Rect,
    pub x: Axis,
    pub y: Axis,
}

impl Panel {
    pub fn at(&self, x: f64, y: f64) -> Point {
        (self.area.left + self.x.place(x) * self.area.width(), self.area.bottom - self.y.place(y) * self.area.height())
    }

    /// Where the page may end: to the right of the panel and of the labels of x, which may reach beyond it.
    pub fn right_edge(&self) -> f64 {
        let end = |tick: &Tick| {
            let (x, _) = self.at(tick.value, self.y.low);
            x + text::width(&tick.text, TICK_SIZE) / 2.0
        };
        let labels = self.x.ticks.iter().map(end);
        labels.fold(self.area.right + 4.0, f64::max) + EDGE
    }

    /// The grid, below everything else.
    pub fn draw_grid(&self, canvas: &mut Canvas) -> Result<(), PlotError> {
        let Rect { left, top, right, bottom } = self.area;
        for tick in &self.x.ticks {
            let (x, _) = self.at(tick.value, self.y.low);
            canvas.line(&[(x, bottom), (x, top)], GRID_WIDTH, GRID)?;
        }
        for tick in &self.y.ticks {
            let (_, y) = self.at(self.x.low, tick.value);
            canvas.line(&[(left, y), (right, y)], GRID_WIDTH, GRID)?;
        }
        Ok(())
    }

    pub fn draw_zero_line(&self, canvas: &mut Canvas) -> Result<(), PlotError> {
        let (_, y) = self.at(self.x.low, 0.0);
        if y < self.area.top || y > self.area.bottom {
            return Ok(());
        }
        let line = [(self.area.left, y), (self.area.right, y)];
        canvas.line(&line, FRAME_WIDTH, ZERO)
    }

    /// The frame with ticks and their labels; below another panel's x axis the labels of x are left out there.
    pub fn draw_frame(&self, canvas: &mut Canvas, label_x: bool) -> Result<(), PlotError> {
        canvas.line(&self.area.outline(), FRAME_WIDTH, INK)?;
        let Rect { left, bottom, .. } = self.area;
        for tick in &self.x.ticks {
            let (x, _) = self.at(tick.value, self.y.low);
            canvas.line(&[(x, bottom), (x, bottom + TICK_LENGTH)], FRAME_WIDTH, INK)?;
            if label_x {
                let font = Font::new(TICK_SIZE, Align::Centre, INK);
                canvas.text(&tick.text, (x, bottom + TICK_LENGTH + 9.0), font)?;
            }
        }
        for tick in &self.y.ticks {
            let (_, y) = self.at(self.x.low, tick.value);
            canvas.line(&[(left - TICK_LENGTH, y), (left, y)], FRAME_WIDTH, INK)?;
            let font = Font::new(TICK_SIZE, Align::Right, INK);
            canvas.text(&tick.text, (left - TICK_LENGTH - 3.0, y), font)?;
        }
        Ok(())
    }

    pub fn draw_x_label(&self, canvas: &mut Canvas, name: &str, unit: &str) -> Result<(), PlotError> {
        let label = text::with_unit(name, unit, self.x.power);
        let label = text::fitted(&label, LABEL_SIZE, self.area.width());
        let point = (self.area.centre().0, self.area.bottom + FOOT - 14.0);
        canvas.text(&label, point, Font::new(LABEL_SIZE, Align::Centre, INK))
    }

    pub fn draw_y_label(&self, canvas: &mut Canvas, name: &str, unit: &str) -> Result<(), PlotError> {
        let label = text::with_unit(name, unit, self.y.power);
        let label = text::fitted(&label, LABEL_SIZE, self.area.height());
        let point = (EDGE + LABEL_SIZE / 2.0, self.area.centre().1);
        let mut font = Font::new(LABEL_SIZE, Align::Centre, INK);
        font.upright = true;
        canvas.text(&label, point, font)
    }

    /// The label of a special point in a place that was found for it.
    pub fn draw_label(canvas: &mut Canvas, label: &str, place: Rect) -> Result<(), PlotError> {
        let font = Font::new(SMALL_SIZE, Align::Centre, INK);
        canvas.text(label, place.centre(), font)
    }
}

/// Room left of a panel for the labels of y.
pub fn left_margin(widest_tick: f64) -> f64 {
    EDGE + LABEL_SIZE + 8.0 + widest_tick + 3.0 + TICK_LENGTH
}

/// A title of one or several lines above the panels.
pub struct Title {
    lines: Vec<String>,
}

impl Title {
    pub fn new(title: &str, room: f64) -> Title {
        // Bold letters are a tenth wider.
        let lines = text::wrapped(title, 1.1 * TITLE_SIZE, room);
        Title { lines }
    }

    /// Room above the panels.
    pub fn height(&self) -> f64 {
        match self.lines.len() {
            0 => EDGE,
            n => EDGE + 6.0 + n as f64 * LINE_HEIGHT,
        }
    }

    pub fn draw(&self, canvas: &mut Canvas, left: f64) -> Result<(), PlotError> {
        let mut font = Font::new(TITLE_SIZE, Align::Left, INK);
        font.bold = true;
        for (i, line) in self.lines.iter().enumerate() {
            let y = EDGE + (i as f64 + 0.5) * LINE_HEIGHT;
            canvas.text(line, (left, y), font)?;
        }
        Ok(())
    }
}
