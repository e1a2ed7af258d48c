//! The bifurcation diagram: columns against a column, over branches, with stability and special points.

mod labels;
mod series;

use super::axis::{Axis, Direction, range};
use super::canvas::{Canvas, paint};
use super::geometry::{Point, Rect};
use super::legend::{Legend, Sample};
use super::marker::{self, Mark};
use super::panel::{EDGE, FOOT, Panel, Title, left_margin};
use super::placement::{Placement, around};
use super::style::{ANY, CURVE_WIDTH, DASHED, THIN_WIDTH, faded};
use super::{PlotError, Spec, no_column, stroke};
use crate::branch::{Branch, BranchKind, Kind};
use plotters::style::RGBColor;
use series::{Run, Series, Stability};
use std::collections::BTreeSet;

const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 350.0;

/// A run of a series on the page.
struct Curve<'a> {
    series: &'a Series<'a>,
    stability: Stability,
    points: Vec<Point>,
}

/// A special point on the page.
struct Symbol {
    mark: Mark,
    at: Point,
    along: Point,
    /// The label is written once, at the first of several columns.
    first: bool,
}

pub fn draw(spec: &Spec, x: &str, y: &[String], branches: &[&Branch]) -> Result<String, PlotError> {
    let series = series::series(x, y, branches);
    if series.is_empty() {
        let mut wanted = vec![x];
        wanted.extend(y.iter().map(String::as_str));
        return Err(no_column(spec, &wanted, branches));
    }
    let panel = panel(spec, &series);
    let title = Title::new(&spec.title, WIDTH);
    let curves = curves(&panel, &series);
    let paths: Vec<Vec<Point>> = curves.iter().map(|c| c.points.clone()).collect();
    let symbols = symbols(&panel, &series);
    let places: Vec<Point> = symbols.iter().map(|s| s.at).collect();
    let legend = legend(&series, &curves, &symbols);
    let inside = legend.corner(panel.area, &paths, &places);
    let beside = legend.beside(panel.area);
    let size = (
        inside.map_or(beside.right + EDGE, |_| panel.right_edge()),
        (panel.area.bottom + FOOT).max(inside.map_or(beside.bottom + EDGE, |_| 0.0)),
    );
    let name = if spec.title.is_empty() { &spec.name } else { &spec.title };
    paint(name, size, |canvas| {
        title.draw(canvas, panel.area.left)?;
        panel.draw_grid(canvas)?;
        for curve in &curves {
            draw_curve(canvas, curve)?;
        }
        panel.draw_frame(canvas, true)?;
        let (name, unit) = labels::x_label(x, &series);
        panel.draw_x_label(canvas, &name, &unit)?;
        let (name, unit) = labels::y_label(y, &series);
        panel.draw_y_label(canvas, &name, &unit)?;
        legend.draw(canvas, inside.unwrap_or(beside))?;
        draw_symbols(canvas, panel.area, &paths, &symbols, inside)
    })
}

fn panel(spec: &Spec, series: &[Series]) -> Panel {
    let points = || series.iter().flat_map(Series::points);
    let (left, right) = range(points().map(|(_, (x, _))| x), 0.03);
    let (low, high) = range(points().map(|(_, (_, y))| y), 0.06);
    let y = Axis::new(low, high, HEIGHT, Direction::Up);
    let top = Title::new(&spec.title, WIDTH).height();
    Panel {
        area: Rect::new(left_margin(y.widest_tick()), top, WIDTH, HEIGHT),
        x: Axis::new(left, right, WIDTH, Direction::Across),
        y,
    }
}

fn curves<'a>(panel: &Panel, series: &'a [Series<'a>]) -> Vec<Curve<'a>> {
    let curve = |series: &'a Series<'a>, run: Run| {
        let points: Vec<Point> = run.points.iter().map(|&(x, y)| panel.at(x, y)).collect();
        Curve { series, stability: run.stability, points: stroke::thinned(&points) }
    };
    (series.iter()).flat_map(|s| s.runs().into_iter().map(move |run| curve(s, run))).collect()
}

fn symbols(panel: &Panel, series: &[Series]) -> Vec<Symbol> {
    let mut symbols = Vec::new();
    let mut labelled = BTreeSet::new();
    for one in series {
        // Exceptional points belong to the eigenvalues' figure; here they would only crowd the line.
        for mark in marker::marks(one.branch).into_iter().filter(|mark| mark.kind != Kind::XP) {
            let Some((x, y)) = one.point(mark.row) else {
                continue;
            };
            let at = panel.at(x, y);
            let near = |row: Option<usize>| {
                let (x, y) = one.point(row?)?;
                Some(panel.at(x, y))
            };
            let before = near(mark.row.checked_sub(1)).unwrap_or(at);
            let after = near(mark.row.checked_add(1)).unwrap_or(at);
            symbols.push(Symbol {
                at,
                along: (after.0 - before.0, after.1 - before.1),
                first: labelled.insert((one.task, mark.row, mark.label.clone())),
                mark,
            });
        }
    }
    symbols
}

fn legend(series: &[Series], curves: &[Curve], symbols: &[Symbol]) -> Legend {
    let shown = |wanted: Stability| curves.iter().any(|c| c.stability == wanted);
    let mut styles = Vec::new();
    let critical = [BranchKind::HopfCurve, BranchKind::PdCurve, BranchKind::BpcCurve, BranchKind::NsCurve];
    let meanings = match series.iter().any(|s| critical.contains(&s.branch.kind)) {
        true => ["supercritical", "subcritical", "criticality unknown"],
        false => ["stable", "unstable", "stability unknown"],
    };
    for (stability, meaning) in [Stability::Stable, Stability::Unstable, Stability::Unknown].into_iter().zip(meanings) {
        if shown(stability) {
            let (colour, width) = pen(stability, ANY);
            let pattern = (stability == Stability::Unstable).then_some(DASHED);
            let sample = Sample::Line { colour, width, pattern };
            styles.push((sample, meaning));
        }
    }
    let kinds: BTreeSet<Kind> = symbols.iter().map(|s| s.mark.kind).collect();
    let meanings = || kinds.iter().filter_map(|&k| Some((k, marker::meaning(k)?)));
    let mut legend = Legend::default();
    let names = labels::names(series);
    let names = names.into_iter().map(|(c, name)| (Sample::solid(c), name));
    legend.add_all(names.collect(), styles.len() + meanings().count());
    for (sample, meaning) in styles {
        legend.add(sample, meaning);
    }
    for (kind, meaning) in meanings() {
        legend.add(Sample::Marker(kind), meaning);
    }
    legend
}

/// Colour and width of a curve.
fn pen(stability: Stability, colour: RGBColor) -> (RGBColor, f64) {
    match stability {
        Stability::Unknown => (faded(colour), THIN_WIDTH),
        _ => (colour, CURVE_WIDTH),
    }
}

fn draw_curve(canvas: &mut Canvas, curve: &Curve) -> Result<(), PlotError> {
    let (colour, width) = pen(curve.stability, curve.series.colour);
    match &curve.points[..] {
        [only] => canvas.disc(*only, 1.8, curve.series.colour),
        points if curve.stability == Stability::Unstable => {
            for dash in stroke::dashes(points, DASHED) {
                canvas.line(&dash, width, colour)?;
            }
            Ok(())
        }
        points => canvas.line(points, width, colour),
    }
}

fn draw_symbols(
    canvas: &mut Canvas,
    area: Rect,
    curves: &[Vec<Point>],
    symbols: &[Symbol],
    legend: Option<Rect>,
) -> Result<(), PlotError> {
    let mut placement = Placement::new(area.grown(-2.0), curves);
    if let Some(legend) = legend {
        placement.take(legend);
    }
    for symbol in symbols {
        if symbol.mark.kind != Kind::EP {
            placement.take_symbol(symbol.at);
        }
    }
    // The most important symbols lie on top and get their labels first.
    let mut order: Vec<&Symbol> = symbols.iter().collect();
    order.sort_by_key(|s| marker::priority(s.mark.kind).unwrap_or(u8::MAX));
    for symbol in order.iter().rev() {
        marker::draw(canvas, symbol.mark.kind, symbol.at, symbol.along)?;
    }
    for symbol in order {
        if !symbol.first || marker::priority(symbol.mark.kind).is_none() {
            continue;
        }
        let label = &symbol.mark.label;
        if let Some(place) = placement.place(symbol.at, around(symbol.at, label)) {
            Panel::draw_label(canvas, label, place)?;
        }
    }
    Ok(())
}
