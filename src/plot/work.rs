//! Work-precision diagrams: error against seconds and against unknowns, both on logarithmic scales.

use super::axis::{Direction, Tick, range};
use super::canvas::{Canvas, paint};
use super::decades;
use super::geometry::{Point, Rect};
use super::legend::{Legend, Sample};
use super::panel::{EDGE, FOOT, Panel, Title, left_margin};
use super::style::{CURVE_WIDTH, DASHED, THIN_WIDTH, ZERO, eigenvalue};
use super::{PlotError, stroke};

const WIDTH: f64 = 330.0;
const HEIGHT: f64 = 330.0;
const BETWEEN: f64 = 26.0;
const DISC: f64 = 3.0;
/// Smaller errors than rounding are drawn there.
const LEAST: f64 = f64::EPSILON;

/// A family of settings.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkPrecision {
    pub name: String,
    /// The observed order, which the legend shows.
    pub order: Option<f64>,
    /// From coarse to fine.
    pub points: Vec<Worked>,
}

/// An error and what it cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worked {
    pub error: f64,
    pub seconds: f64,
    /// The least and the most seconds.
    pub spread: (f64, f64),
    pub unknowns: Option<f64>,
}

/// Draws the families; below the error `known` of what they are compared with they say nothing.
pub fn draw(title: &str, label: &str, known: f64, families: &[WorkPrecision]) -> Result<String, PlotError> {
    let logarithm = |x: f64| x.max(LEAST).log10();
    let points = || families.iter().flat_map(|family| &family.points);
    let (low, high) = range(points().map(|point| logarithm(point.error)), 0.06);
    let y = decades::axis(low, high, HEIGHT, Direction::Up);
    let heading = Title::new(title, 2.0 * WIDTH);
    let mut left = left_margin(y.widest_tick());
    let mut panels: Vec<(Panel, &str)> = Vec::new();
    let works: [(&str, Vec<f64>); 2] = [
        ("seconds", points().flat_map(|point| [point.spread.0, point.spread.1]).collect()),
        ("unknowns", points().filter_map(|point| point.unknowns).collect()),
    ];
    for (name, works) in works.iter().filter(|(_, works)| !works.is_empty()) {
        let (from, to) = range(works.iter().map(|work| work.log10()), 0.05);
        let mut y = y.clone();
        if !panels.is_empty() {
            y.ticks = y.ticks.into_iter().map(|tick| Tick { text: String::new(), ..tick }).collect();
        }
        let area = Rect::new(left, heading.height(), WIDTH, HEIGHT);
        panels.push((Panel { area, x: decades::axis(from, to, WIDTH, Direction::Across), y }, name));
        left += WIDTH + BETWEEN;
    }
    let mut legend = Legend::default();
    for (k, family) in families.iter().enumerate() {
        let (colour, pattern) = eigenvalue(k);
        let order = family.order.map_or(String::new(), |order| format!(" (order {order:.1})"));
        legend.add(Sample::Line { colour, width: CURVE_WIDTH, pattern }, &format!("{}{order}", family.name));
    }
    let floor = (known > 10f64.powf(low)).then(|| known.log10());
    if floor.is_some() {
        let sample = Sample::Line { colour: ZERO, width: THIN_WIDTH, pattern: Some(DASHED) };
        legend.add(sample, "error of the reference");
    }
    let beside = panels.last().map_or(Rect::new(0.0, 0.0, 0.0, 0.0), |(panel, _)| legend.beside(panel.area));
    let bottom = (heading.height() + HEIGHT + FOOT).max(beside.bottom + EDGE);
    paint(title, (beside.right + EDGE, bottom), |canvas| {
        for (k, (panel, name)) in panels.iter().enumerate() {
            if k == 0 {
                heading.draw(canvas, panel.area.left)?;
                panel.draw_y_label(canvas, label, "")?;
            }
            panel.draw_grid(canvas)?;
            if let Some(floor) = floor {
                let line = [panel.at(panel.x.low, floor), panel.at(panel.x.high, floor)];
                pieces(canvas, &line, Some(DASHED), (THIN_WIDTH, ZERO))?;
            }
            let seconds = *name == "seconds";
            for (k, family) in families.iter().enumerate() {
                let work = |point: &Worked| if seconds { Some(point.seconds) } else { point.unknowns };
                let place = |point: &Worked| Some(panel.at(work(point)?.log10(), logarithm(point.error)));
                let path: Vec<Point> = family.points.iter().filter_map(place).collect();
                let (colour, pattern) = eigenvalue(k);
                pieces(canvas, &path, pattern, (CURVE_WIDTH, colour))?;
                for point in family.points.iter().filter(|_| seconds) {
                    let end = |seconds: f64| panel.at(seconds.log10(), logarithm(point.error));
                    canvas.line(&[end(point.spread.0), end(point.spread.1)], THIN_WIDTH, colour)?;
                }
                for at in path {
                    canvas.disc(at, DISC, colour)?;
                }
            }
            panel.draw_frame(canvas, true)?;
            panel.draw_x_label(canvas, name, "")?;
        }
        legend.draw(canvas, beside)
    })
}

fn pieces(
    canvas: &mut Canvas,
    path: &[Point],
    pattern: Option<stroke::Pattern>,
    (width, colour): (f64, plotters::style::RGBColor),
) -> Result<(), PlotError> {
    let pieces = match pattern {
        Some(pattern) => stroke::dashes(path, pattern),
        None => vec![path.to_vec()],
    };
    pieces.iter().try_for_each(|piece| canvas.line(piece, width, colour))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_errors_single_points_and_missing_unknowns_are_drawn() {
        let at = |error: f64, seconds: f64, unknowns| Worked {
            error,
            seconds,
            spread: (0.9 * seconds, 2.0 * seconds),
            unknowns,
        };
        let family = |name: &str, points| WorkPrecision { name: name.to_owned(), order: Some(4.0), points };
        let families = [
            family("two", vec![at(1e-3, 0.1, Some(10.0)), at(0.0, 0.4, Some(20.0))]),
            family("none", Vec::new()),
            family("motion", vec![at(1e-5, 0.2, None)]),
        ];
        for count in 1..=3 {
            let svg = draw("Errors", "error of x", 1e-9, &families[..count]).unwrap();
            assert!(
                svg.contains("unknowns") && svg.contains("two (order 4.0)") && svg.contains("error of the reference")
            );
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
        let svg = draw("Errors", "error of x", 0.0, &families[2..]).unwrap();
        assert!(!svg.contains("unknowns") && !svg.contains("reference"), "{svg}");
    }
}
