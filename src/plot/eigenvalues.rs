//! Eigenvalue branches: their real parts above their imaginary parts, against the free parameter.

mod spectrum;

use super::axis::{Axis, Direction};
use super::canvas::{Align, Canvas, Font, paint};
use super::geometry::{Point, Rect, distance};
use super::panel::{FOOT, Panel, Title, left_margin};
use super::placement::{Placement, size};
use super::style::{CURVE_WIDTH, DOTTED, INK, SMALL_SIZE, THIN_WIDTH, WHITE, ZERO, eigenvalue};
use super::{PlotError, Spec, no_column, stroke, text};
use crate::branch::Branch;
use spectrum::Spectrum;

const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 215.0;
const BETWEEN: f64 = 16.0;
/// With more Hopf points than this, lines are drawn thin instead of dotted.
const MOST_DOTTED: usize = 12;
/// Half a diagonal of the diamond at an exceptional point.
const DIAMOND: f64 = 3.4;

#[derive(Clone, Copy)]
enum Part {
    Real,
    Imaginary,
}

pub fn draw(spec: &Spec, x: &str, branches: &[&Branch]) -> Result<String, PlotError> {
    let spectrum = Spectrum::new(x, branches);
    if spectrum.is_empty() {
        return Err(no_column(spec, &[x, "re_1", "im_1"], branches));
    }
    let title = Title::new(&spec.title, WIDTH);
    let key = !spectrum.exceptional.is_empty();
    let top = title.height() + if key { 18.0 } else { 0.0 };
    let [real, imaginary] = panels(&spectrum, top);
    let page = (imaginary.right_edge(), imaginary.area.bottom + FOOT);
    let name = if spec.title.is_empty() { &spec.name } else { &spec.title };
    paint(name, page, |canvas| {
        title.draw(canvas, real.area.left)?;
        if key {
            draw_key(canvas, &real)?;
        }
        draw_panel(canvas, &spectrum, &real, Part::Real)?;
        draw_panel(canvas, &spectrum, &imaginary, Part::Imaginary)?;
        real.draw_frame(canvas, false)?;
        imaginary.draw_frame(canvas, true)?;
        imaginary.draw_x_label(canvas, &text::readable(x), &spectrum.x_unit)?;
        real.draw_y_label(canvas, "Re λ", &spectrum.re_unit)?;
        imaginary.draw_y_label(canvas, "Im λ", &spectrum.im_unit)
    })
}

fn panels(spectrum: &Spectrum, top: f64) -> [Panel; 2] {
    let (left, right) = spectrum.x_range();
    let x = Axis::new(left, right, WIDTH, Direction::Across);
    let (low, high) = spectrum.real_range();
    let real = Axis::new(low, high, HEIGHT, Direction::Up);
    let (below, above) = spectrum.imaginary_range(low);
    let imaginary = Axis::new(below, above, HEIGHT, Direction::Up);
    let margin = left_margin(real.widest_tick().max(imaginary.widest_tick()));
    let area = |top: f64| Rect::new(margin, top, WIDTH, HEIGHT);
    [Panel { area: area(top), x: x.clone(), y: real }, Panel { area: area(top + HEIGHT + BETWEEN), x, y: imaginary }]
}

fn draw_panel(canvas: &mut Canvas, spectrum: &Spectrum, panel: &Panel, part: Part) -> Result<(), PlotError> {
    panel.draw_grid(canvas)?;
    panel.draw_zero_line(canvas)?;
    let area = panel.area;
    let hopf: Vec<(f64, &str)> =
        (spectrum.hopf.iter()).map(|(x, label)| (panel.at(*x, panel.y.low).0, label.as_str())).collect();
    for &(x, _) in &hopf {
        draw_vertical(canvas, area, x, hopf.len() <= MOST_DOTTED)?;
    }
    let (_, zero) = panel.at(panel.x.low, 0.0);
    let mut drawn: Vec<Vec<Point>> = vec![vec![(area.left, zero), (area.right, zero)]];
    // The first eigenvalues on top.
    for (n, curve) in spectrum.curves.iter().enumerate().rev() {
        let (colour, pattern) = eigenvalue(n);
        for piece in curve.pieces() {
            let points: Vec<Point> = (piece.iter()).map(|&(x, re, im)| panel.at(x, chosen(part, re, im))).collect();
            let points = stroke::thinned(&points);
            for visible in stroke::clipped(&points, &area) {
                match pattern {
                    Some(pattern) => {
                        for dash in stroke::dashes(&visible, pattern) {
                            canvas.line(&dash, CURVE_WIDTH, colour)?;
                        }
                    }
                    None => canvas.line(&visible, CURVE_WIDTH, colour)?,
                }
                drawn.push(visible);
            }
            if let [only] = points[..]
                && area.contains(only)
            {
                canvas.disc(only, 2.2, colour)?;
            }
        }
    }
    let mut last: Option<Point> = None;
    for &(x, re, im) in &spectrum.exceptional {
        let at = panel.at(x, chosen(part, re, im));
        let apart = last.is_none_or(|p| distance(p, at) > 1.0);
        if apart && area.contains(at) {
            draw_diamond(canvas, at)?;
            last = Some(at);
        }
    }
    draw_labels(canvas, area, &drawn, &hopf)
}

fn chosen(part: Part, re: f64, im: f64) -> f64 {
    match part {
        Part::Real => re,
        Part::Imaginary => im,
    }
}

fn draw_vertical(canvas: &mut Canvas, area: Rect, x: f64, dotted: bool) -> Result<(), PlotError> {
    let line = [(x, area.bottom), (x, area.top)];
    if !dotted {
        return canvas.line(&line, THIN_WIDTH / 2.0, ZERO);
    }
    for dot in stroke::dashes(&line, DOTTED) {
        canvas.line(&dot, THIN_WIDTH, INK)?;
    }
    Ok(())
}

fn draw_diamond(canvas: &mut Canvas, (x, y): Point) -> Result<(), PlotError> {
    let corners = [(0.0, -DIAMOND), (DIAMOND, 0.0), (0.0, DIAMOND), (-DIAMOND, 0.0), (0.0, -DIAMOND)];
    let outline = corners.map(|(dx, dy)| (x + dx, y + dy));
    canvas.fill(&outline, WHITE)?;
    canvas.line(&outline, THIN_WIDTH, INK)
}

/// Labels beside the vertical lines, where they meet the least of the curves, high up rather than low.
fn draw_labels(canvas: &mut Canvas, area: Rect, curves: &[Vec<Point>], hopf: &[(f64, &str)]) -> Result<(), PlotError> {
    let mut placement = Placement::new(area.grown(-2.0), curves);
    for &(x, _) in hopf {
        placement.take(Rect::new(x - 0.5, area.top, 1.0, area.height()));
    }
    for &(x, label) in hopf {
        let (width, height) = size(label);
        let beside = width / 2.0 + 4.0;
        let levels = (0..8).map(|i| area.top + 10.0 + f64::from(i) * (area.height() - 20.0) / 7.0);
        let places = levels.flat_map(|y| [x + beside, x - beside].map(|x| Rect::centred((x, y), width, height)));
        if let Some(place) = placement.place((x, area.top), places) {
            Panel::draw_label(canvas, label, place)?;
        }
    }
    Ok(())
}

/// What a diamond means, above the panels at the right.
fn draw_key(canvas: &mut Canvas, panel: &Panel) -> Result<(), PlotError> {
    let meaning = "exceptional point (XP)";
    let y = panel.area.top - 11.0;
    let left = panel.area.right - text::width(meaning, SMALL_SIZE);
    draw_diamond(canvas, (left - 9.0, y))?;
    canvas.text(meaning, (left, y), Font::new(SMALL_SIZE, Align::Left, INK))
}
