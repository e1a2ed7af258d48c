//! Figures: from the scene's words to what `plot` draws, now or again from stored data.

use super::bench::Report;
use super::files::write_figure;
use super::summary::Summary;
use super::{RunError, place};
use crate::branch::{Branch, BranchKind, read_arrays, read_branch, read_triangles};
use crate::plot::{Spec, SpecKind, draw};
use crate::scene::{Figure, Scene, SceneError, Task, TaskKind, owner};
use std::collections::BTreeMap;
use std::path::Path;

/// What only the model and the tasks can tell about a scene's figures.
pub fn check(scene: &Scene) -> Result<(), SceneError> {
    for figure in scene.figures.iter().filter(|figure| figure.kind == "eigenvalues") {
        for task in scene.tasks.iter().filter(|task| figure.tasks.contains(&task.name)) {
            let spectrum = match &task.kind {
                TaskKind::Equilibria(equilibria) => equilibria.spectrum,
                _ => 0,
            };
            if spectrum == 0 {
                let message = format!("figure {:?} shows its eigenvalues; add spectrum = 8 to this task", figure.name);
                return Err(scene.refuse(&place(task, "spectrum"), message));
            }
        }
    }
    for figure in scene.figures.iter().filter(|figure| figure.kind == "diagram") {
        let map = |task: &&Task| figure.tasks.contains(&task.name) && matches!(task.kind, TaskKind::Map(_));
        if let Some(task) = scene.tasks.iter().find(map) {
            let message = format!("a diagram cannot show the map {:?}; write kind = \"map\" to draw one", task.name);
            return Err(scene.refuse(&figure.at, message));
        }
    }
    for figure in scene.figures.iter().filter(|figure| figure.kind == "surface") {
        let flat = |task: &&Task| figure.tasks.contains(&task.name) && !matches!(task.kind, TaskKind::HopfSurface(_));
        if let Some(task) = scene.tasks.iter().find(flat) {
            let message = format!("{:?} is no surface: only tasks of kind \"hopf-surface\" have one", task.name);
            return Err(scene.refuse(&figure.at, message));
        }
    }
    for figure in &scene.figures {
        let task = figure.point.as_ref().and_then(|point| owner(&scene.tasks, point));
        if let Some(
            TaskKind::Simulate(_) | TaskKind::FoldCurve(_) | TaskKind::BranchPointCurve(_) | TaskKind::CycleCurve(..),
        ) = task.map(|task| &task.kind)
        {
            let message = "waveforms are drawn of points of equilibria, cycles, hopf-curve and calibration tasks";
            return Err(scene.refuse(&figure.at, message));
        }
    }
    Ok(())
}

/// The figures whose data there are.
pub fn specs(scene: &Scene, branches: &[Branch], picture_unit: &str) -> Vec<Spec> {
    // A diagram task stands for all its branches.
    let members = |names: &[String]| -> Vec<String> {
        let of = |branch: &&Branch| owner(&scene.tasks, &branch.name).is_some_and(|task| names.contains(&task.name));
        branches.iter().filter(of).map(|branch| branch.name.clone()).collect()
    };
    let drawn = scene.figures.iter().filter_map(|figure| {
        let figure = Figure { tasks: members(&figure.tasks), ..figure.clone() };
        spec(&figure, &scene.tasks, branches, picture_unit)
    });
    // One that no figure shows is drawn by itself: its first observable.
    let alone = scene.tasks.iter().filter(|task| {
        matches!(task.kind, TaskKind::Diagram(_))
            && !scene.figures.iter().any(|figure| figure.tasks.contains(&task.name))
    });
    let own = alone.filter_map(|task| {
        let along = task.kind.along();
        let tasks = members(std::slice::from_ref(&task.name));
        let first =
            branches.iter().find(|branch| tasks.contains(&branch.name) && branch.kind == BranchKind::Equilibria)?;
        let spectral = |name: &str| ["re_", "im_", "log10 "].iter().any(|prefix| name.starts_with(prefix));
        let y = first.columns.iter().skip(1).map(|column| column.name.clone()).find(|name| !spectral(name))?;
        let logarithm = if along.logarithmic.is_empty() { "" } else { "log10 " };
        let x = format!("{logarithm}{}", along.free);
        let kind = SpecKind::Diagram { x, y: vec![y.clone(), format!("max {y}"), format!("min {y}")], tasks };
        Some(Spec { name: task.name.clone(), title: String::new(), kind })
    });
    drawn.chain(own).collect()
}

fn spec(figure: &Figure, tasks: &[Task], branches: &[Branch], picture_unit: &str) -> Option<Spec> {
    let there = |name: &String| branches.iter().any(|b| &b.name == name && !b.rows.is_empty());
    let drawn: Vec<String> = figure.tasks.iter().filter(|name| there(name)).cloned().collect();
    let kind = match figure.kind.as_str() {
        "waveform" => {
            let point = figure.point.clone()?;
            let task = owner(tasks, &point)?;
            branches.iter().find(|branch| owner(tasks, &branch.name).is_some_and(|of| of.name == task.name))?;
            SpecKind::Waveform { point, unit: picture_unit.to_owned() }
        }
        _ if drawn.is_empty() => return None,
        "surface" => SpecKind::Surface { tasks: drawn, view: figure.view },
        "eigenvalues" => SpecKind::Eigenvalues { x: figure.x.clone()?, tasks: drawn },
        "map" => {
            let map = branches.iter().find(|b| b.kind == BranchKind::Map && drawn.contains(&b.name))?;
            let [x, y] = &map.free[..] else { return None };
            let column = figure.column.clone().unwrap_or_else(|| "frequency".to_owned());
            SpecKind::Map { x: x.clone(), y: y.clone(), column, tasks: drawn }
        }
        _ => SpecKind::Diagram { x: figure.x.clone()?, y: figure.y.clone(), tasks: drawn },
    };
    Some(Spec { name: figure.name.clone(), title: figure.title.clone().unwrap_or_default(), kind })
}

/// Draws the figures of a finished run or study again from its files; returns their names.
pub fn redraw(folder: &Path) -> Result<Vec<String>, RunError> {
    if let Some(report) = Report::read(folder)? {
        let figures = report.figures()?;
        for (name, svg) in &figures {
            write_figure(folder, name, svg)?;
        }
        return Ok(figures.into_iter().map(|(name, _)| name).collect());
    }
    let summary = Summary::load(folder)?;
    let mut branches = Vec::new();
    for line in &summary.branches {
        let mut branch = read_branch(&folder.join(&line.file), &line.name, line.kind, &line.free)?;
        for point in summary.points.iter().filter(|p| p.label.starts_with(&format!("{}/", line.name))) {
            let arrays = read_arrays(&folder.join("points").join(format!("{}.npz", point.label)))?;
            branch.points.push(crate::branch::SpecialPoint {
                label: point.label.clone(),
                kind: point.kind,
                row: point.row,
                parameters: BTreeMap::new(),
                values: point.values.clone(),
                errors: BTreeMap::new(),
                arrays,
            });
        }
        if line.kind == BranchKind::HopfSurface {
            branch.triangles = read_triangles(&folder.join(super::files::mesh(&line.name)), branch.rows.len())?;
        }
        branches.push(branch);
    }
    let mut drawn = Vec::new();
    for spec in &summary.figures {
        let svg = draw(spec, &branches)?;
        write_figure(folder, &spec.name, &svg)?;
        drawn.push(spec.name.clone());
    }
    Ok(drawn)
}
