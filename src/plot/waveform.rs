//! Shapes at equally spaced phases of a period, coloured from blue to red.

use super::axis::{Axis, Direction, range};
use super::canvas::{Align, Canvas, Font, paint};
use super::geometry::{Point, Rect};
use super::panel::{EDGE, FOOT, Panel, Title, left_margin};
use super::style::{CURVE_WIDTH, FRAME_WIDTH, INK, LABEL_SIZE, TICK_SIZE, phase};
use super::{PlotError, Spec, drawable, listed, stroke};
use crate::branch::{Branch, SpecialPoint};
use plotters::style::RGBColor;

/// The larger side of the panel stays within these, and the smaller one above [`LEAST`].
const WIDTH: f64 = 440.0;
const HEIGHT: f64 = 400.0;
const LEAST: f64 = 165.0;
const MARGIN: f64 = 0.05;

const BAR_GAP: f64 = 18.0;
const BAR_WIDTH: f64 = 12.0;
const BAR_ROOM: f64 = 64.0;

/// One shape; `None` where a coordinate does not exist.
type Shape = Vec<Option<(f64, f64)>>;

pub fn draw(spec: &Spec, label: &str, unit: &str, branches: &[Branch]) -> Result<String, PlotError> {
    let point = find(label, branches).ok_or_else(|| PlotError::NoPoint {
        figure: spec.name.clone(),
        point: label.to_owned(),
        available: listed(branches.iter().flat_map(|b| b.points.iter().map(|p| p.label.as_str()))),
    })?;
    let no_waveform = || PlotError::NoWaveform { figure: spec.name.clone(), point: label.to_owned() };
    let shapes = shapes(point).ok_or_else(no_waveform)?;
    let points = || shapes.iter().flatten().flatten();
    if points().next().is_none() {
        return Err(no_waveform());
    }
    let x_range = range(points().map(|p| p.0), MARGIN);
    let y_range = range(points().map(|p| p.1), MARGIN);
    let title_room = WIDTH + BAR_GAP + BAR_ROOM;
    let title = Title::new(&spec.title, title_room);
    let panel = panel(x_range, y_range, title.height());
    let title = Title::new(&spec.title, panel.area.width() + BAR_GAP + BAR_ROOM);
    let panel =
        Panel { area: Rect::new(panel.area.left, title.height(), panel.area.width(), panel.area.height()), ..panel };
    let page = (panel.area.right + BAR_GAP + BAR_ROOM + EDGE, panel.area.bottom + FOOT);
    let name = if spec.title.is_empty() { &spec.name } else { &spec.title };
    paint(name, page, |canvas| {
        title.draw(canvas, panel.area.left)?;
        panel.draw_grid(canvas)?;
        for (i, shape) in shapes.iter().enumerate() {
            draw_shape(canvas, &panel, shape, phase(place(i, shapes.len())))?;
        }
        panel.draw_frame(canvas, true)?;
        panel.draw_x_label(canvas, "x", unit)?;
        panel.draw_y_label(canvas, "y", unit)?;
        draw_bar(canvas, panel.area, shapes.len())
    })
}

/// "beat/UZ1" of the branch "beat", or the first "UZ1" of any.
fn find<'a>(label: &str, branches: &'a [Branch]) -> Option<&'a SpecialPoint> {
    match label.split_once('/') {
        Some((name, _)) => (branches.iter().filter(|b| b.name == name)).find_map(|b| b.point(label)),
        None => branches.iter().find_map(|b| b.point(label)),
    }
}

/// The shapes of a point, if it has arrays `wave_x` and `wave_y` of one shape [phases, positions].
fn shapes(point: &SpecialPoint) -> Option<Vec<Shape>> {
    let (x, y) = (point.arrays.get("wave_x")?, point.arrays.get("wave_y")?);
    let &[phases, positions] = &x.shape[..] else {
        return None;
    };
    let size = phases.checked_mul(positions).filter(|&size| size > 0)?;
    if y.shape != x.shape || x.data.len() != size || y.data.len() != size {
        return None;
    }
    let shape = |(x, y): (&[f64], &[f64])| -> Shape {
        let pairs = x.iter().zip(y);
        pairs.map(|(&x, &y)| Some((drawable(x)?, drawable(y)?))).collect()
    };
    let rows = x.data.chunks(positions).zip(y.data.chunks(positions));
    Some(rows.map(shape).collect())
}

/// A panel of equal scales in both directions, as large as there is room; a side that would be too short shows more
/// than the shapes need.
fn panel(x: (f64, f64), y: (f64, f64), top: f64) -> Panel {
    let (width, height) = (x.1 - x.0, y.1 - y.0);
    let scale = f64::min(WIDTH / width, HEIGHT / height);
    let sides = ((width * scale).max(LEAST), (height * scale).max(LEAST));
    let stretched = |(low, high): (f64, f64), side: f64| {
        let (middle, half) = (low / 2.0 + high / 2.0, side / scale / 2.0);
        (middle - half, middle + half)
    };
    let (x, y) = (stretched(x, sides.0), stretched(y, sides.1));
    let up = Axis::new(y.0, y.1, sides.1, Direction::Up);
    Panel {
        area: Rect::new(left_margin(up.widest_tick()), top, sides.0, sides.1),
        x: Axis::new(x.0, x.1, sides.0, Direction::Across),
        y: up,
    }
}

/// Place of a shape in the order of colours: 0 for the first, 1 for the last.
fn place(index: usize, count: usize) -> f64 {
    index as f64 / (count.max(2) - 1) as f64
}

fn draw_shape(canvas: &mut Canvas, panel: &Panel, shape: &Shape, colour: RGBColor) -> Result<(), PlotError> {
    for piece in shape.split(Option::is_none).filter(|p| !p.is_empty()) {
        let points: Vec<Point> = piece.iter().flatten().map(|&(x, y)| panel.at(x, y)).collect();
        match stroke::thinned(&points)[..] {
            [only] => canvas.disc(only, 1.8, colour)?,
            ref line => canvas.line(line, CURVE_WIDTH, colour)?,
        }
    }
    Ok(())
}

/// The colours beside the panel: one block for each phase, the first phase at the bottom.
fn draw_bar(canvas: &mut Canvas, area: Rect, count: usize) -> Result<(), PlotError> {
    let bar = Rect::new(area.right + BAR_GAP, area.top, BAR_WIDTH, area.height());
    let block = bar.height() / count as f64;
    for i in 0..count {
        // Each block reaches under all that follow, so that no gap shows.
        let bottom = bar.bottom - i as f64 * block;
        let rect = Rect { bottom, ..bar };
        canvas.fill(&rect.outline(), phase(place(i, count)))?;
    }
    canvas.line(&bar.outline(), FRAME_WIDTH, INK)?;
    for (share, label) in [(0.0, "0"), (0.5, "0.5"), (1.0, "1")] {
        let y = bar.bottom - share * bar.height();
        canvas.line(&[(bar.right, y), (bar.right + 4.0, y)], FRAME_WIDTH, INK)?;
        let font = Font::new(TICK_SIZE, Align::Left, INK);
        canvas.text(label, (bar.right + 7.0, y), font)?;
    }
    let mut font = Font::new(LABEL_SIZE, Align::Centre, INK);
    font.upright = true;
    let point = (area.right + BAR_GAP + BAR_ROOM - LABEL_SIZE / 2.0, bar.centre().1);
    canvas.text("phase of the period", point, font)
}
