//! A surface in three parameters: triangles from back to front in a box with axes, coloured by frequency, with lines of
//! equal frequency; sub- and supercritical parts have ramps of their own, and a line where they meet.

mod frame;
mod mesh;
mod view;

use super::axis::{Axis, Direction};
use super::canvas::{Canvas, paint};
use super::colour_bar::{ColourBar, Ramp};
use super::geometry::{Point, Rect};
use super::legend::{Legend, Sample};
use super::panel::{EDGE, Title};
use super::style::{INK, WHITE, ramp_subcritical, ramp_supercritical, ramp_unknown, shaded};
use super::{PlotError, Spec, no_column, stroke, text};
use crate::branch::Branch;
use frame::Frame;
use mesh::{Mesh, between};
use plotters::style::RGBColor;
use view::{Vector, View};

/// Room for the cube.
const ROOM: Point = (560.0, 470.0);
const COLOUR: &str = "frequency";
const BAR_HEIGHT: f64 = 250.0;
/// Colours that spread more than this are on a logarithmic scale.
const DECADE: f64 = 8.0;
/// Triangles are drawn so much larger, in pixels, that no seams show.
const GROWN: f64 = 0.7;
const CONTOUR_WIDTH: f64 = 0.6;
const EDGE_WIDTH: f64 = 0.9;
const BORDER_WIDTH: f64 = 1.9;

pub fn draw(spec: &Spec, view: Option<[f64; 2]>, branches: &[&Branch]) -> Result<String, PlotError> {
    let mesh = Mesh::new(branches, COLOUR).filter(|mesh| !mesh.triangles.is_empty());
    let Some(mesh) = mesh else { return Err(no_column(spec, &["the triangles of a surface"], branches)) };
    let angles = view.unwrap_or_else(|| View::best(mesh.triangles.iter().map(|&t| mesh.corners(t))));
    let view = View::new(angles, ROOM);
    let scale = Scale::new(&mesh.colour);
    let parts = parts(&mesh);
    let shown = |part: Part| parts.iter().any(|(_, known, _)| *known == part);
    let ramps = [Part::Supercritical, Part::Subcritical, Part::Unknown].into_iter().filter(|part| shown(*part));
    let unit = branches.iter().find_map(|b| b.columns.get(b.column(COLOUR)?)).map_or("", |c| c.unit.as_str());
    let bar = ColourBar {
        title: text::with_unit(COLOUR, unit, 0),
        ticks: scale.levels.iter().map(|(level, label)| (scale.place(*level), label.clone())).collect(),
        ramps: ramps.map(|part| (part.name().to_owned(), part.ramp())).collect(),
    };
    let border = mesh.visible(&view, &mesh.contour(&mesh.criticality, 0.0));
    let mut legend = Legend::default();
    if !border.is_empty() {
        legend.add(Sample::Line { colour: INK, width: BORDER_WIDTH, pattern: None }, "generalised Hopf (GH)");
    }
    let frame = Frame::new(&mesh, &view);
    let extent = frame.extent();
    let title = Title::new(&spec.title, extent.width());
    // All is laid out about the cube's own corner; the page begins elsewhere.
    let (left, top) = (EDGE - extent.left, title.height() - extent.top);
    let middle = top + 0.5 * (extent.top + extent.bottom) + 0.5 * bar.head();
    let bars = (middle - 0.5 * BAR_HEIGHT, middle + 0.5 * BAR_HEIGHT);
    let aside = left + extent.right + 18.0;
    let legend_size = if border.is_empty() { (0.0, 0.0) } else { legend.size() };
    let width = aside + bar.width().max(legend_size.0) + EDGE;
    let height = (top + extent.bottom).max(bars.1 + 14.0 + legend_size.1) + EDGE;
    let name = if spec.title.is_empty() { &spec.name } else { &spec.title };
    paint(name, (width, height), |canvas| {
        let mut page = Page { canvas, left, top };
        title.draw(page.canvas, EDGE)?;
        frame.draw_back(&mut page)?;
        draw_parts(&mut page, &mesh, &view, &scale, &parts)?;
        for (level, _) in &scale.levels {
            page.curves(&mesh.visible(&view, &mesh.contour(&mesh.colour, *level)), CONTOUR_WIDTH, INK)?;
        }
        page.curves(&mesh.visible(&view, &mesh.outline(&view)), EDGE_WIDTH, INK)?;
        page.curves(&border, BORDER_WIDTH + 1.6, WHITE)?;
        page.curves(&border, BORDER_WIDTH, INK)?;
        frame.draw_labels(&mut page)?;
        bar.draw(page.canvas, aside, bars.0, bars.1)?;
        if !border.is_empty() {
            legend.draw(page.canvas, Rect::new(aside, bars.1 + 14.0, legend_size.0, legend_size.1))?;
        }
        Ok(())
    })
}

/// The canvas, with the cube's corner where it belongs.
struct Page<'a, 'b> {
    canvas: &'a mut Canvas<'b>,
    left: f64,
    top: f64,
}

impl Page<'_, '_> {
    fn moved(&self, (x, y): Point) -> Point {
        (x + self.left, y + self.top)
    }

    fn curves(&mut self, curves: &[Vec<Point>], width: f64, colour: RGBColor) -> Result<(), PlotError> {
        for curve in curves {
            let curve: Vec<Point> = stroke::thinned(curve).into_iter().map(|p| self.moved(p)).collect();
            self.canvas.line(&curve, width, colour)?;
        }
        Ok(())
    }

    fn fill(&mut self, points: &[Point], colour: RGBColor) -> Result<(), PlotError> {
        let points: Vec<Point> = points.iter().map(|p| self.moved(*p)).collect();
        self.canvas.fill(&points, colour)
    }
}

/// Which cycles are born on a part of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    Supercritical,
    Subcritical,
    Unknown,
}

impl Part {
    fn name(self) -> &'static str {
        match self {
            Part::Supercritical => "supercritical",
            Part::Subcritical => "subcritical",
            Part::Unknown => "unknown",
        }
    }

    fn ramp(self) -> Ramp {
        match self {
            Part::Supercritical => ramp_supercritical,
            Part::Subcritical => ramp_subcritical,
            Part::Unknown => ramp_unknown,
        }
    }
}

/// Polygons of one criticality, with the triangle that they are part of.
fn parts(mesh: &Mesh) -> Vec<(Vec<Vector>, Part, usize)> {
    let mut parts = Vec::with_capacity(mesh.triangles.len());
    for (index, &t) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(t);
        let [Some(a), Some(b), Some(c)] = t.map(|i| mesh.criticality[i]) else {
            parts.push((corners.to_vec(), Part::Unknown, index));
            continue;
        };
        let l1 = [a, b, c];
        for (part, sign) in [(Part::Supercritical, -1.0), (Part::Subcritical, 1.0)] {
            let mut polygon = Vec::new();
            for k in 0..3 {
                let next = (k + 1) % 3;
                let (here, there) = (sign * l1[k], sign * l1[next]);
                if here >= 0.0 {
                    polygon.push(corners[k]);
                }
                if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                    polygon.push(between(corners[k], corners[next], here / (here - there)));
                }
            }
            if polygon.len() > 2 {
                parts.push((polygon, part, index));
            }
        }
    }
    parts
}

fn draw_parts(
    page: &mut Page,
    mesh: &Mesh,
    view: &View,
    scale: &Scale,
    parts: &[(Vec<Vector>, Part, usize)],
) -> Result<(), PlotError> {
    let depth = |polygon: &[Vector]| polygon.iter().map(|v| view.depth(*v)).sum::<f64>() / polygon.len() as f64;
    let mut order: Vec<(f64, usize)> = parts.iter().enumerate().map(|(k, (polygon, ..))| (depth(polygon), k)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (_, k) in order {
        let (polygon, part, index) = &parts[k];
        let t = mesh.triangles[*index];
        let known: Vec<f64> = t.iter().filter_map(|&i| mesh.colour[i]).map(|x| scale.place(x)).collect();
        let mean = if known.is_empty() { 0.0 } else { known.iter().sum::<f64>() / known.len() as f64 };
        let colour = shaded(part.ramp()(mean), 0.80 + 0.20 * view.light(mesh.corners(t)));
        let flat: Vec<Point> = polygon.iter().map(|v| view.at(*v)).collect();
        page.fill(&grown(&flat), colour)?;
    }
    Ok(())
}

/// A polygon with its corners moved away from its middle.
fn grown(polygon: &[Point]) -> Vec<Point> {
    let count = polygon.len() as f64;
    let middle = (polygon.iter().map(|p| p.0).sum::<f64>() / count, polygon.iter().map(|p| p.1).sum::<f64>() / count);
    let away = |p: &Point| {
        let (dx, dy) = (p.0 - middle.0, p.1 - middle.1);
        let by = GROWN / dx.hypot(dy).max(GROWN);
        (p.0 + by * dx, p.1 + by * dy)
    };
    polygon.iter().map(away).collect()
}

/// From a number to its place on the colour bar.
struct Scale {
    low: f64,
    high: f64,
    logarithmic: bool,
    /// Round numbers, with how they are written.
    levels: Vec<(f64, String)>,
}

impl Scale {
    fn new(values: &[Option<f64>]) -> Scale {
        let known = || values.iter().flatten().copied();
        let (low, high) = super::axis::range(known(), 0.0);
        let logarithmic = low > 0.0 && high > DECADE * low;
        let ticks = Axis::new(low, high, BAR_HEIGHT, Direction::Up).ticks;
        let mut levels: Vec<(f64, String)> = ticks.into_iter().map(|tick| (tick.value, tick.text)).collect();
        if logarithmic {
            let powers = low.log10().floor() as i32..=high.log10().ceil() as i32;
            levels = powers
                .flat_map(|power| [1.0, 1.5, 2.0, 3.0, 5.0, 7.0].map(|digit| digit * 10f64.powi(power)))
                .filter(|level| (low..=high).contains(level))
                .map(|level| (level, format!("{level}")))
                .collect();
        }
        Scale { low, high, logarithmic, levels }
    }

    fn place(&self, value: f64) -> f64 {
        let place = if self.logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        place.clamp(0.0, 1.0)
    }
}
