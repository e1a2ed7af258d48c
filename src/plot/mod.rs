//! Branches to figures: SVG by plotters.
//!
//! plotters serves as the SVG writer; axes, legends and the placement of labels are ours. Text sizes are estimated, so
//! that a figure is the same on every machine, whatever fonts it has.

mod axis;
mod canvas;
mod colour_bar;
mod decades;
mod diagram;
mod eigenvalues;
mod geometry;
mod legend;
mod map;
mod marker;
mod panel;
mod placement;
mod stroke;
mod style;
mod surface;
mod text;
mod waveform;
mod work;

pub use work::{WorkPrecision, Worked, draw as draw_work};

use crate::branch::Branch;
use serde::{Deserialize, Serialize};

/// What a figure shows; stored in `summary.json`, so that `hopfline plot` can draw it again.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct Spec {
    pub name: String,
    pub title: String,
    pub kind: SpecKind,
}

#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum SpecKind {
    /// Columns against a column, over one or several branches.
    Diagram { x: String, y: Vec<String>, tasks: Vec<String> },
    /// Real and imaginary parts of the eigenvalue branches against the free parameter, two panels.
    Eigenvalues { x: String, tasks: Vec<String> },
    /// Surfaces in three parameters, seen from an azimuth and elevation in degrees (chosen, if None).
    Surface { tasks: Vec<String>, view: Option<[f64; 2]> },
    /// Shapes at 16 phases, of an eigenmode or a cycle.
    Waveform {
        point: String,
        /// Unit of both coordinates, "" for none.
        #[serde(default)]
        unit: String,
    },
    /// A column over two parameters where the state is unstable; of the tasks the first is the map, others are Hopf
    /// curves to be drawn on it.
    Map { x: String, y: String, column: String, tasks: Vec<String> },
}

/// Why a figure cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    #[error(
        "figure `{figure}`: there is no branch of {wanted}, only of: {available}; \
         name another task in the figure, or run the missing one"
    )]
    NoBranch { figure: String, wanted: String, available: String },
    #[error(
        "figure `{figure}`: no branch has numbers in {wanted}; columns with numbers are: {available}; \
         name some of these in the figure"
    )]
    NoColumn { figure: String, wanted: String, available: String },
    #[error(
        "figure `{figure}`: there is no special point `{point}`; there are: {available}; \
         name one of these in the figure"
    )]
    NoPoint { figure: String, point: String, available: String },
    #[error(
        "figure `{figure}`: the point `{point}` has no waveform (arrays wave_x and wave_y of one shape \
         [phases, positions]); name another point, or a model that has shapes"
    )]
    NoWaveform { figure: String, point: String },
    #[error("the figure cannot be written as SVG: {0}")]
    Svg(String),
}

/// Draws a figure; the result is the text of an SVG file.
///
/// Branches that the figure does not name are ignored, and so are those without its columns. The same input gives the
/// same text.
pub fn draw(spec: &Spec, branches: &[Branch]) -> Result<String, PlotError> {
    match &spec.kind {
        SpecKind::Diagram { x, y, tasks } => diagram::draw(spec, x, y, &chosen(spec, tasks, branches)?),
        SpecKind::Eigenvalues { x, tasks } => eigenvalues::draw(spec, x, &chosen(spec, tasks, branches)?),
        SpecKind::Map { x, y, column, tasks } => map::draw(spec, x, y, column, &chosen(spec, tasks, branches)?),
        SpecKind::Surface { tasks, view } => surface::draw(spec, *view, &chosen(spec, tasks, branches)?),
        SpecKind::Waveform { point, unit } => waveform::draw(spec, point, unit, branches),
    }
}

/// The branches of the tasks, in the order of the tasks; all branches if no task is named.
fn chosen<'a>(spec: &Spec, tasks: &[String], branches: &'a [Branch]) -> Result<Vec<&'a Branch>, PlotError> {
    let chosen: Vec<&Branch> = if tasks.is_empty() {
        branches.iter().collect()
    } else {
        (tasks.iter()).flat_map(|task| branches.iter().filter(move |b| b.name == *task)).collect()
    };
    if chosen.is_empty() {
        return Err(PlotError::NoBranch {
            figure: spec.name.clone(),
            wanted: listed(tasks.iter().map(String::as_str)),
            available: listed(branches.iter().map(|b| b.name.as_str())),
        });
    }
    Ok(chosen)
}

/// The error of a figure that would be empty: it lists the columns that have numbers.
fn no_column(spec: &Spec, wanted: &[&str], branches: &[&Branch]) -> PlotError {
    let mut available: Vec<&str> = Vec::new();
    for branch in branches {
        for (i, column) in branch.columns.iter().enumerate() {
            let filled = branch.rows.iter().any(|row| value(row, i).is_some());
            if filled && !available.contains(&column.name.as_str()) {
                available.push(&column.name);
            }
        }
    }
    PlotError::NoColumn {
        figure: spec.name.clone(),
        wanted: listed(wanted.iter().copied()),
        available: listed(available),
    }
}

fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.into_iter().map(|n| format!("`{n}`")).collect();
    if names.is_empty() { "nothing".into() } else { names.join(", ") }
}

/// A number of a row, if it exists and can be drawn. The limit leaves room for differences of two numbers.
fn value(row: &crate::branch::Row, column: usize) -> Option<f64> {
    drawable(row.values.get(column).copied().flatten()?)
}

fn drawable(value: f64) -> Option<f64> {
    (value.abs() < 1e300).then_some(value)
}
