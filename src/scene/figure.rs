//! Reading `[[figure]]`.

use super::entry::{Entry, Section};
use super::label::{self, Announced};
use super::{Fault, Figure, SceneError, Task, map};

/// Kinds of figures, as a scene names them.
const FIGURE_KINDS: [&str; 5] = ["diagram", "eigenvalues", "waveform", "map", "surface"];

const DIAGRAM: [&str; 6] = ["name", "kind", "title", "x", "y", "tasks"];
const EIGENVALUES: [&str; 5] = ["name", "kind", "title", "x", "tasks"];
const MAP: [&str; 5] = ["name", "kind", "title", "tasks", "column"];
const WAVEFORM: [&str; 4] = ["name", "kind", "title", "point"];
const SURFACE: [&str; 5] = ["name", "kind", "title", "tasks", "view"];

/// Reads one figure; every task is known by then.
pub(super) fn read(
    section: &Section<'_>,
    name: String,
    tasks: &[Task],
    announced: &[Announced],
) -> Result<Figure, SceneError> {
    section.allow("key", &["name", "kind", "title", "x", "y", "tasks", "point", "column", "view"])?;
    let kind = match section.get("kind") {
        Some(entry) => entry.choice("figure kind", &FIGURE_KINDS)?,
        None => "diagram",
    };
    let mut figure = Figure {
        name,
        kind: kind.to_owned(),
        title: match section.get("title") {
            Some(entry) => Some(entry.text()?.to_owned()),
            None => None,
        },
        x: match section.get("x") {
            Some(entry) => Some(column(&entry)?),
            None => None,
        },
        y: Vec::new(),
        tasks: Vec::new(),
        point: None,
        column: None,
        view: None,
        at: section.at.clone(),
    };
    match kind {
        "waveform" => {
            section.allow("key of a waveform figure", &WAVEFORM)?;
            let point = section.need("point", "point = \"TASK/UZ1\", the cycle to draw")?;
            label::check(point.text()?, tasks, announced).map_err(|fault| point.error(fault))?;
            figure.point = Some(point.text()?.to_owned());
        }
        "surface" => {
            section.allow("key of a surface figure", &SURFACE)?;
            figure.tasks = drawn(section, tasks)?;
            figure.view = match section.get("view") {
                Some(entry) => Some(view(&entry)?),
                None => None,
            };
        }
        "eigenvalues" => {
            section.allow("key of an eigenvalues figure", &EIGENVALUES)?;
            figure.tasks = drawn(section, tasks)?;
            if figure.x.is_none() {
                figure.x = Some(common_parameter(section, &figure.tasks, tasks)?);
            }
        }
        "map" => {
            section.allow("key of a map figure", &MAP)?;
            figure.tasks = drawn(section, tasks)?;
            map::figure(section, &figure.tasks, tasks)?;
            if let Some(entry) = section.get("column") {
                figure.column = Some(entry.choice("column of a map", &map::COLUMNS)?.to_owned());
            }
        }
        _ => {
            section.allow("key of a diagram", &DIAGRAM)?;
            section.need("x", "x = \"COLUMN\", the horizontal axis")?;
            figure.y = columns(&section.need("y", "y = \"COLUMN\" or a list of columns")?)?;
            figure.tasks = drawn(section, tasks)?;
        }
    }
    Ok(figure)
}

/// `[azimuth, elevation]` in degrees.
fn view(entry: &Entry<'_>) -> Result<[f64; 2], SceneError> {
    let expected = "[azimuth, elevation], two angles in degrees";
    let items = entry.list(expected)?;
    let [azimuth, elevation] = items.as_slice() else {
        return entry.type_error(expected);
    };
    let height = elevation.number()?;
    if !(0.0..=90.0).contains(&height) {
        let allowed = "elevations from 0 to 90 degrees".to_owned();
        return Err(elevation.error(Fault::OutOfBounds { found: height.to_string(), allowed }));
    }
    Ok([azimuth.number()?, height])
}

fn column(entry: &Entry<'_>) -> Result<String, SceneError> {
    let text = entry.text()?;
    if text.trim().is_empty() {
        return Err(entry.error(Fault::Empty { expected: "the name of a column".to_owned() }));
    }
    Ok(text.to_owned())
}

/// `"a"` or `["a", "b"]`.
fn columns(entry: &Entry<'_>) -> Result<Vec<String>, SceneError> {
    if entry.text().is_ok() {
        return Ok(vec![column(entry)?]);
    }
    let items = entry.list("a column or a list of columns")?;
    if items.is_empty() {
        return Err(entry.error(Fault::Empty { expected: "at least one column".to_owned() }));
    }
    for item in &items {
        column(item)?;
    }
    entry.texts()
}

/// The tasks that a figure draws: at least one, and all of them known.
fn drawn(section: &Section<'_>, tasks: &[Task]) -> Result<Vec<String>, SceneError> {
    let entry = section.need("tasks", "tasks = [\"TASK\"], the branches to draw")?;
    let items = entry.list("a list of names of tasks")?;
    if items.is_empty() {
        return Err(entry.error(Fault::Empty { expected: "at least one task".to_owned() }));
    }
    for item in &items {
        let name = item.text()?;
        if !tasks.iter().any(|task| task.name == name) {
            let known = tasks.iter().map(|task| task.name.as_str());
            return Err(item.error(Fault::unknown("task", name, known)));
        }
    }
    entry.texts()
}

/// The free parameter of the drawn tasks, the default horizontal axis.
fn common_parameter(section: &Section<'_>, drawn: &[String], tasks: &[Task]) -> Result<String, SceneError> {
    let mut free = tasks.iter().filter(|task| drawn.contains(&task.name)).map(|task| {
        let along = task.kind.along();
        let logarithm = if along.logarithmic.contains(&along.free) { "log10 " } else { "" };
        format!("{logarithm}{}", along.free)
    });
    match free.next() {
        Some(first) if free.all(|other| other == first) => Ok(first),
        _ => Err(section.error(Fault::Missing {
            what: "the key \"x\" (the tasks vary different parameters)".to_owned(),
            example: "x = \"COLUMN\", the horizontal axis".to_owned(),
        })),
    }
}
