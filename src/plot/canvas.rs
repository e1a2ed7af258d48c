//! The page: plotters' SVG backend behind coordinates in CSS pixels.

use super::PlotError;
use super::geometry::{Point, Rect};
use plotters::prelude::{DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, RGBColor, ShapeStyle, TextStyle};

/// The backend writes whole numbers only: so many of its units make a pixel.
const SCALE: f64 = 20.0;
/// The backend divides font sizes by this.
const FONT_FACTOR: f64 = 1.24;
const FONT: &str = "Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif";

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Align {
    Left,
    Centre,
    Right,
}

/// How a text is written. Its vertical middle is at the point given with it.
#[derive(Clone, Copy, Debug)]
pub struct Font {
    pub size: f64,
    pub align: Align,
    pub bold: bool,
    /// Read from bottom to top.
    pub upright: bool,
    pub colour: RGBColor,
}

impl Font {
    pub fn new(size: f64, align: Align, colour: RGBColor) -> Font {
        Font { size, align, bold: false, upright: false, colour }
    }
}

pub struct Canvas<'a> {
    backend: SVGBackend<'a>,
}

/// Draws on a white page of the given size and returns the text of the SVG file.
pub fn paint(
    title: &str,
    (width, height): (f64, f64),
    draw: impl FnOnce(&mut Canvas) -> Result<(), PlotError>,
) -> Result<String, PlotError> {
    let units = |pixels: f64| (pixels.ceil() * SCALE) as u32;
    let mut text = String::new();
    let backend = SVGBackend::with_string(&mut text, (units(width), units(height)));
    let mut canvas = Canvas { backend };
    canvas.fill(&Rect::new(0.0, 0.0, width.ceil(), height.ceil()).outline(), super::style::WHITE)?;
    draw(&mut canvas)?;
    canvas.backend.present().map_err(svg_error)?;
    drop(canvas);
    // The backend's header has the size in units; ours has it in pixels.
    let body = text.split_once('>').map_or("", |(_, body)| body);
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {} {}\" \
         stroke-linejoin=\"round\" stroke-linecap=\"butt\">\n<title>{}</title>{body}",
        width.ceil(),
        height.ceil(),
        units(width),
        units(height),
        escaped(&printable(title)),
    ))
}

impl Canvas<'_> {
    pub fn line(&mut self, points: &[Point], width: f64, colour: RGBColor) -> Result<(), PlotError> {
        if points.len() < 2 {
            return Ok(());
        }
        let mut path: Vec<(i32, i32)> = points.iter().copied().map(units).collect();
        path.dedup();
        if let [only] = path[..] {
            path.push(only);
        }
        let style = colour.stroke_width((width * SCALE).round() as u32);
        self.backend.draw_path(path, &style).map_err(svg_error)
    }

    pub fn fill(&mut self, points: &[Point], colour: RGBColor) -> Result<(), PlotError> {
        let path = points.iter().copied().map(units);
        self.backend.fill_polygon(path, &colour.filled()).map_err(svg_error)
    }

    /// A region with holes, around which closed curves run (nonzero winding): one polygon through all of them, by ways
    /// that it goes back again, which cover nothing.
    pub fn fill_region(&mut self, outline: &[Vec<Point>], colour: RGBColor) -> Result<(), PlotError> {
        let Some(&home) = outline.first().and_then(|curve| curve.first()) else { return Ok(()) };
        let mut path: Vec<Point> = Vec::new();
        for curve in outline {
            path.extend(curve);
            path.push(home);
        }
        self.fill(&path, colour)
    }

    pub fn disc(&mut self, centre: Point, radius: f64, colour: RGBColor) -> Result<(), PlotError> {
        let radius = (radius * SCALE).round() as u32;
        let style: ShapeStyle = colour.filled();
        self.backend.draw_circle(units(centre), radius, &style, true).map_err(svg_error)
    }

    pub fn text(&mut self, text: &str, (x, y): Point, font: Font) -> Result<(), PlotError> {
        let anchor = match font.align {
            Align::Left => HPos::Left,
            Align::Centre => HPos::Center,
            Align::Right => HPos::Right,
        };
        // The backend centres small letters; digits and capitals are higher.
        let lower = 0.09 * font.size;
        let point = if font.upright { (x + lower, y) } else { (x, y + lower) };
        let mut style = TextStyle::from((FONT, font.size * SCALE * FONT_FACTOR))
            .color(&font.colour)
            .pos(Pos::new(anchor, VPos::Center));
        if font.bold {
            style.font = style.font.style(FontStyle::Bold);
        }
        if font.upright {
            style.font = style.font.transform(FontTransform::Rotate270);
        }
        self.backend.draw_text(&printable(text), &style, units(point)).map_err(svg_error)
    }
}

fn units((x, y): Point) -> (i32, i32) {
    ((x * SCALE).round() as i32, (y * SCALE).round() as i32)
}

fn svg_error(cause: impl std::fmt::Display) -> PlotError {
    PlotError::Svg(cause.to_string())
}

/// XML has no way to write control characters.
fn printable(text: &str) -> String {
    let keep = |c: char| {
        if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }
    };
    text.chars().map(keep).collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
