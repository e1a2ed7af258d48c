//! A number over two parameters where the state is unstable: filled contours, a bar of colours, Hopf curves on top.
//!
//! Bands lie on one another: each is drawn as all that is at least its lower level, so that no seams show.

mod grid;
mod pieces;
mod region;
mod scale;

use super::axis::{Axis, Direction};
use super::canvas::{Align, Canvas, Font, paint};
use super::geometry::{Point, Rect};
use super::panel::{EDGE, FOOT, Panel, Title, left_margin};
use super::style::{CURVE_WIDTH, FRAME_WIDTH, INK, LABEL_SIZE, SMALL_SIZE, TICK_SIZE, WHITE, ZERO};
use super::{PlotError, Spec, decades, no_column, stroke, text, value};
use crate::branch::{Branch, BranchKind};
use grid::Grid;
use pieces::{Piece, clipped, pieces};
use region::Region;
use scale::Scale;

const WIDTH: f64 = 440.0;
const HEIGHT: f64 = 350.0;
/// Room above the panel for the key.
const KEY: f64 = 18.0;
const BAR_GAP: f64 = 16.0;
const BAR_WIDTH: f64 = 14.0;

/// A parameter along an axis: a column of the map and of the curves, as it is or by its logarithm.
struct Side {
    logarithmic: bool,
}

impl Side {
    fn new(name: &str, map: &Branch) -> Side {
        Side { logarithmic: map.column(&format!("log10 {name}")).is_some() }
    }

    fn place(&self, value: f64) -> f64 {
        if self.logarithmic { value.log10() } else { value }
    }

    fn axis(&self, lines: &[f64], pixels: f64, direction: Direction) -> Axis {
        let (low, high) = match lines {
            [first, .., last] => (self.place(*first), self.place(*last)),
            _ => (0.0, 1.0),
        };
        if self.logarithmic {
            decades::axis(low, high, pixels, direction)
        } else {
            Axis::new(low, high, pixels, direction)
        }
    }
}

pub fn draw(spec: &Spec, x: &str, y: &str, column: &str, branches: &[&Branch]) -> Result<String, PlotError> {
    let missing = || no_column(spec, &[x, y, column, "growth"], branches);
    let map = branches.iter().find(|branch| branch.kind == BranchKind::Map).ok_or_else(missing)?;
    let index = |name: &str| map.column(name).ok_or_else(missing);
    let (of_x, of_y, shown) = (index(x)?, index(y)?, index(column)?);
    let grid = Grid::new(map, [of_x, of_y], shown).ok_or_else(missing)?;
    let (across, up) = (Side::new(x, map), Side::new(y, map));

    let title = Title::new(&spec.title, WIDTH);
    let y_axis = up.axis(&grid.y, HEIGHT, Direction::Up);
    let panel = Panel {
        area: Rect::new(left_margin(y_axis.widest_tick()), title.height() + KEY, WIDTH, HEIGHT),
        x: across.axis(&grid.x, WIDTH, Direction::Across),
        y: y_axis,
    };
    let at = |(a, b): Point| panel.at(across.place(a), up.place(b));
    // At the edge, where the state turns unstable, the growth is zero.
    let edge = (column == "growth").then_some(0.0);
    let scale = Scale::new(grid.unstable().map(|node| node.value).chain(edge), HEIGHT);
    let empty = grid.unstable().next().is_none();
    let grid = grid.changed(at, |value| scale.place(value));
    let curves: Vec<Vec<Point>> = (branches.iter())
        .filter(|branch| branch.kind == BranchKind::HopfCurve)
        .filter_map(|branch| {
            let (x, y) = (branch.column(x)?, branch.column(y)?);
            let points = branch.rows.iter().filter_map(|row| Some(at((value(row, x)?, value(row, y)?))));
            Some(points.filter(|(x, y)| x.is_finite() && y.is_finite()).collect())
        })
        .collect();

    let unit = |column: usize| map.columns.get(column).map_or("", |column| column.unit.as_str());
    let bar_label = text::with_unit(&text::readable(column), unit(shown), scale.power);
    let right = if empty { panel.right_edge() } else { bar(&panel).right + bar_room(&scale) + EDGE };
    let name = if spec.title.is_empty() { &spec.name } else { &spec.title };
    paint(name, (right, panel.area.bottom + FOOT), |canvas| {
        title.draw(canvas, panel.area.left)?;
        draw_key(canvas, panel.area, !curves.is_empty())?;
        panel.draw_grid(canvas)?;
        draw_bands(canvas, &pieces(&grid), &scale)?;
        for curve in &curves {
            draw_curve(canvas, panel.area, curve)?;
        }
        panel.draw_frame(canvas, true)?;
        panel.draw_x_label(canvas, &text::readable(x), unit(of_x))?;
        panel.draw_y_label(canvas, &text::readable(y), unit(of_y))?;
        if empty { Ok(()) } else { draw_bar(canvas, &panel, &scale, &bar_label) }
    })
}

fn draw_bands(canvas: &mut Canvas, pieces: &[Piece], scale: &Scale) -> Result<(), PlotError> {
    let bands = scale.levels.len().saturating_sub(1);
    for (k, &level) in scale.levels.iter().enumerate().take(bands) {
        let (mut region, level) = (Region::default(), scale.place(level));
        for piece in pieces {
            // What lies below all levels is still of the lowest band.
            if k == 0 || piece.iter().all(|vertex| vertex.value >= level) {
                region.add(piece.iter().map(|vertex| vertex.at));
            } else if piece.iter().any(|vertex| vertex.value >= level) {
                region.add(clipped(piece, |vertex| vertex.value, level).iter().map(|vertex| vertex.at));
            }
        }
        canvas.fill_region(&region.outline(), scale.colour(k))?;
    }
    Ok(())
}

/// A dark line with a light seam, to be seen on any colour.
fn draw_curve(canvas: &mut Canvas, area: Rect, curve: &[Point]) -> Result<(), PlotError> {
    for piece in stroke::clipped(&stroke::thinned(curve), &area) {
        canvas.line(&piece, CURVE_WIDTH + 1.6, WHITE)?;
        canvas.line(&piece, CURVE_WIDTH, INK)?;
    }
    Ok(())
}

/// What white and the line mean, above the panel at the right.
fn draw_key(canvas: &mut Canvas, area: Rect, curve: bool) -> Result<(), PlotError> {
    let y = area.top - 11.0;
    let mut right = area.right;
    let mut entry = |canvas: &mut Canvas, meaning: &str, sample: f64| {
        let left = right - text::width(meaning, SMALL_SIZE);
        right = left - sample - 22.0;
        canvas.text(meaning, (left, y), Font::new(SMALL_SIZE, Align::Left, INK)).map(|()| left - 6.0 - sample)
    };
    if curve {
        let left = entry(canvas, "Hopf curve", 24.0)?;
        canvas.line(&[(left, y), (left + 24.0, y)], CURVE_WIDTH, INK)?;
    }
    let left = entry(canvas, "stable", 14.0)?;
    canvas.line(&Rect::new(left, y - 5.0, 14.0, 10.0).outline(), FRAME_WIDTH, ZERO)
}

fn bar(panel: &Panel) -> Rect {
    Rect::new(panel.area.right + BAR_GAP, panel.area.top, BAR_WIDTH, panel.area.height())
}

/// Room right of the bar.
fn bar_room(scale: &Scale) -> f64 {
    let widest = scale.ticks.iter().map(|tick| text::width(&tick.text, TICK_SIZE)).fold(0.0, f64::max);
    7.0 + widest + 8.0 + LABEL_SIZE
}

fn draw_bar(canvas: &mut Canvas, panel: &Panel, scale: &Scale, label: &str) -> Result<(), PlotError> {
    let bar = bar(panel);
    let height = |level: f64| bar.bottom - scale.height(level) * bar.height();
    let bands = scale.levels.len().saturating_sub(1);
    for (k, &level) in scale.levels.iter().enumerate().take(bands) {
        // Each block reaches under all that follow, so that no gap shows.
        canvas.fill(&Rect { bottom: height(level), ..bar }.outline(), scale.colour(k))?;
    }
    canvas.line(&bar.outline(), FRAME_WIDTH, INK)?;
    for tick in &scale.ticks {
        let y = height(tick.value);
        canvas.line(&[(bar.right, y), (bar.right + 4.0, y)], FRAME_WIDTH, INK)?;
        canvas.text(&tick.text, (bar.right + 7.0, y), Font::new(TICK_SIZE, Align::Left, INK))?;
    }
    let label = text::fitted(label, LABEL_SIZE, bar.height());
    let mut font = Font::new(LABEL_SIZE, Align::Centre, INK);
    font.upright = true;
    canvas.text(&label, (bar.right + bar_room(scale) - LABEL_SIZE / 2.0, bar.centre().1), font)
}
