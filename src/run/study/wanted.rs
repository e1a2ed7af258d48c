//! What of a task's numbers somebody wants: its figures, its expectations, or the task itself.

use super::Study;
use crate::run::{branch_curve, cycle_curve, cycles, equilibria, fold_curve, hopf_curve, simulate};
use crate::scene::{Fault, Place, Scene, SceneError, Task, TaskKind, owner};
use std::collections::BTreeSet;

impl Study {
    /// Observables that the task, its figures or expectations name; an unknown name is an error.
    pub(super) fn wanted(&self, scene: &Scene, task: &Task) -> Result<(Vec<usize>, Vec<cycles::Average>), SceneError> {
        let along = task.kind.along();
        let of_cycles = [&["period", "frequency", "trivial_error"][..], &cycles::VALUES].concat();
        let own: &[&str] = match task.kind {
            TaskKind::Equilibria(_) => &equilibria::VALUES,
            TaskKind::Diagram(_) => &[&equilibria::VALUES[..], &of_cycles[..]].concat(),
            TaskKind::Cycles(_) => &of_cycles,
            TaskKind::CycleCurve(kind, _) => cycle_curve::values(kind),
            TaskKind::HopfCurve(_) => &hopf_curve::VALUES,
            TaskKind::FoldCurve(_) => &fold_curve::VALUES,
            TaskKind::BranchPointCurve(_) => &branch_curve::VALUES,
            TaskKind::Calibration(_) => &["omega", "frequency", "lyapunov", "dsigma_re", "dsigma_im"],
            TaskKind::Simulate(_) => &simulate::VALUES,
            TaskKind::Map(_) => &["growth", "omega", "frequency", "gap"],
            TaskKind::HopfSurface(_) => &["omega", "frequency", "lyapunov"],
        };
        let list = self.model.observables();
        let fitted = if let TaskKind::Calibration(task) = &task.kind { task.columns() } else { Vec::new() };
        let names: Vec<&str> = list.iter().map(|o| o.name).collect();
        let periodic = matches!(task.kind, TaskKind::Cycles(_) | TaskKind::CycleCurve(..));
        let (mut wanted, mut averages) = (BTreeSet::new(), BTreeSet::new());
        let mut note = |name: &str, at: &Place| -> Result<(), SceneError> {
            let base = name.strip_prefix("max ").or(name.strip_prefix("min ")).unwrap_or(name);
            let column = own.contains(&name) || name == along.free || is_spectral(name);
            let column = column || fitted.iter().any(|own| own == name);
            let parameter = self.model.parameters().iter().any(|q| q.name == name);
            if let Some(average) = cycles::Average::named(name, &names).filter(|_| periodic) {
                averages.insert(average);
                return Ok(());
            }
            match names.iter().position(|known| *known == base) {
                Some(i) => {
                    wanted.insert(i);
                    Ok(())
                }
                None if column || parameter => Ok(()),
                None => {
                    let free = varied(&along.free);
                    let known = list.iter().map(|o| o.name).chain(own.iter().copied()).chain(free);
                    Err(scene.fault(at, Fault::unknown("observable or column", name, known)))
                }
            }
        };
        let nowhere = task.at.clone();
        let place = |key: &str| along.places.get(key).cloned().unwrap_or_else(|| nowhere.clone());
        for name in &along.observables {
            note(name, &place("observables"))?;
        }
        if let TaskKind::Simulate(motion) = &task.kind {
            for event in &motion.events {
                if !names.contains(&event.of.as_str()) {
                    let fault = Fault::unknown("observable", &event.of, names.iter().copied());
                    return Err(scene.fault(&event.at, fault));
                }
                note(&event.of, &event.at)?;
            }
        }
        // Points are located on a column, so that here the name must be one: "max tip_angle" on cycles.
        let columns: Vec<String> = match &task.kind {
            TaskKind::Equilibria(_) | TaskKind::Diagram(_) => list.iter().map(|o| o.name.to_owned()).collect(),
            TaskKind::Cycles(_) => {
                let extremes = list.iter().flat_map(|o| [format!("max {}", o.name), format!("min {}", o.name)]);
                let averages = list.iter().flat_map(|o| [format!("mean {}", o.name), format!("norm {}", o.name)]);
                let own = ["period", "frequency", "norm"].map(str::to_owned);
                own.into_iter().chain(extremes).chain(averages).collect()
            }
            TaskKind::HopfCurve(_)
            | TaskKind::FoldCurve(_)
            | TaskKind::BranchPointCurve(_)
            | TaskKind::CycleCurve(..) => along.others.iter().map(|axis| axis.name.clone()).collect(),
            TaskKind::Calibration(_) | TaskKind::Map(_) | TaskKind::HopfSurface(_) | TaskKind::Simulate(_) => {
                Vec::new()
            }
        };
        for name in along.values.keys().filter(|name| **name != along.free) {
            if !columns.contains(name) {
                let known = varied(&along.free).chain(columns.iter().map(String::as_str));
                return Err(scene.fault(&place("values"), Fault::unknown("column to find values on", name, known)));
            }
            note(name, &place("values"))?;
        }
        for figure in scene.figures.iter().filter(|f| f.kind == "diagram" && f.tasks.contains(&task.name)) {
            for name in figure.x.iter().chain(&figure.y) {
                note(name, &figure.at)?;
            }
        }
        let own = |label: &str| owner(&scene.tasks, label).is_some_and(|found| found.name == task.name);
        for expect in scene.expect.iter().filter(|e| own(&e.label)) {
            note(&expect.quantity, &expect.at)?;
        }
        if let TaskKind::Diagram(diagram) = &task.kind {
            for (name, range) in &diagram.equilibria.bounds {
                if !list.iter().any(|o| o.name == name) {
                    let known = list.iter().map(|o| o.name);
                    return Err(scene.fault(&range.at, Fault::unknown("observable", name, known)));
                }
            }
            // Something has to be drawn.
            if wanted.is_empty() && !list.is_empty() {
                wanted.insert(0);
            }
        }
        self.check_guesses(scene, task)?;
        Ok((wanted.into_iter().collect(), averages.into_iter().collect()))
    }
}

/// The free parameter, where there is one.
pub(super) fn varied(free: &str) -> impl Iterator<Item = &str> {
    Some(free).filter(|free| !free.is_empty()).into_iter()
}

/// Columns that spectra, multipliers, drift and logarithmic parameters bring.
fn is_spectral(name: &str) -> bool {
    ["re_", "im_", "mu_", "drift_", "log10 "].iter().any(|prefix| name.starts_with(prefix))
}
