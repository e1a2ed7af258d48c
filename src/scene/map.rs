//! Reading maps over two parameters, and their figures.

use super::entry::Section;
use super::{Fault, Map, SceneError, Task, TaskKind, several};

/// What a figure can show of a map.
pub(super) const COLUMNS: [&str; 2] = ["frequency", "growth"];

const DEFAULT_GRID: [usize; 2] = [50, 50];
const MOST: usize = 2000;

/// `kind = "map"`: two parameters, both with a range, and the grid.
pub(super) fn task(section: &Section<'_>) -> Result<Map, SceneError> {
    let along = several::along(section, &["L", "p"], 2)?;
    let grid = match section.get("grid") {
        Some(entry) => {
            const EXPECTED: &str = "two whole numbers, the points in the direction of each parameter";
            let counts = entry.list(EXPECTED)?;
            let [first, second] = &counts[..] else { return entry.type_error(EXPECTED) };
            [first.count(2..=MOST)?, second.count(2..=MOST)?]
        }
        None => DEFAULT_GRID,
    };
    Ok(Map { along, grid })
}

/// A figure draws one map, and Hopf curves in the same parameters on it.
pub(super) fn figure(section: &Section<'_>, drawn: &[String], tasks: &[Task]) -> Result<(), SceneError> {
    let entry = section.need("tasks", "tasks = [\"MAP\"], the map to draw")?;
    let free = |task: &Task| {
        let along = task.kind.along();
        let others = along.others.iter().map(|axis| axis.name.clone());
        let mut names: Vec<String> = others.chain([along.free.clone()]).collect();
        names.sort();
        names
    };
    let mut plane: Option<Vec<String>> = None;
    for (item, name) in entry.list("a list of names of tasks")?.iter().zip(drawn) {
        let Some(task) = tasks.iter().find(|task| &task.name == name) else { continue };
        let kind = task.kind.name();
        let refuse = |message: String| Err(item.error(Fault::Other(message)));
        match (&task.kind, &plane) {
            (TaskKind::Map(_), None) => plane = Some(free(task)),
            (TaskKind::HopfCurve(_), Some(names)) if &free(task) == names => {}
            (TaskKind::HopfCurve(_), Some(names)) => {
                return refuse(format!(
                    "the map is over {}, but the curve {name:?} is in {}; both must be in the same two parameters",
                    names.join(" and "),
                    free(task).join(" and ")
                ));
            }
            (_, None) => {
                return refuse(format!(
                    "the first task of a map figure must be of kind \"map\", but {name:?} is of kind {kind:?}"
                ));
            }
            (_, Some(_)) => {
                return refuse(format!(
                    "only tasks of kind \"hopf-curve\" can be drawn on a map, but {name:?} is of kind {kind:?}"
                ));
            }
        }
    }
    Ok(())
}
