//! A scene resolved against its model: the problem, its parameters, and what each task needs.

use crate::models::{self, Choice, Options};
use crate::problem::{Default, Observable, Problem, Tie, Tied};
use crate::scene::{Expression, Fault, OptionValue, Place, Scene, SceneError, Task, TaskKind, Value, units};
use num_dual::{Dual64, HyperDual64};
use std::collections::BTreeSet;
use std::sync::Arc;

/// What is computed on.
pub struct Study {
    model: Arc<dyn Problem>,
    /// Values of all parameters; entries of ties are filled in by the tied problem.
    values: Vec<f64>,
    ties: Vec<Law>,
}

/// Parameter `target` follows from others; `place` where a scene wrote it, None for the model's own.
#[derive(Clone)]
struct Law {
    target: usize,
    expression: Expression,
    place: Option<Place>,
}

/// A law with the positions of its names.
struct Resolved {
    target: usize,
    expression: Expression,
    names: Vec<(String, usize)>,
}

impl Resolved {
    fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().find(|(n, _)| n == name).map(|(_, i)| *i)
    }
}

impl Tie for Resolved {
    fn target(&self) -> usize {
        self.target
    }

    fn value(&self, p: &[f64]) -> f64 {
        self.expression.eval(&|name| self.position(name).map(|i| p[i])).unwrap_or(f64::NAN)
    }

    fn first(&self, p: &[Dual64]) -> Dual64 {
        self.expression.eval(&|name| self.position(name).map(|i| p[i])).unwrap_or(Dual64::from_re(f64::NAN))
    }

    fn second(&self, p: &[HyperDual64]) -> HyperDual64 {
        self.expression.eval(&|name| self.position(name).map(|i| p[i])).unwrap_or(HyperDual64::from_re(f64::NAN))
    }
}

/// A task's problem with all parameters, and the position of the free one.
#[derive(Clone)]
pub struct Prepared {
    pub problem: Arc<Tied>,
    pub p: Vec<f64>,
    pub free: usize,
    pub free_name: String,
    pub free_unit: String,
    /// Observables wanted as columns, in the model's order.
    pub observables: Vec<usize>,
    /// Labels ("UZ1") whose waveform a figure draws.
    pub waves: BTreeSet<String>,
}

impl Study {
    /// Resolves model, options, parameters and ties, and checks everything that tasks name.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        let model = build(scene)?;
        let list = model.parameters();
        let names: Vec<&str> = list.iter().map(|q| q.name).collect();
        let mut values: Vec<f64> = list
            .iter()
            .map(|q| match q.default {
                Default::Value(x) => x,
                Default::Tie(_) | Default::Derived(_) => f64::NAN,
            })
            .collect();
        let mut ties = Vec::new();
        for (target, q) in list.iter().enumerate() {
            let (Default::Tie(text) | Default::Derived(text)) = q.default else { continue };
            let expression = Expression::parse(text).map_err(|e| {
                scene.refuse(&scene.model.at, format!("the model's own tie of {} is wrong: {e}", q.name))
            })?;
            ties.push(Law { target, expression, place: None });
        }
        for setting in &scene.parameters {
            let Some(target) = names.iter().position(|n| *n == setting.name) else {
                return Err(scene.fault(&setting.at, Fault::unknown("parameter", &setting.name, names.iter().copied())));
            };
            let q = &list[target];
            if let Default::Derived(text) = q.default {
                return Err(scene.refuse(&setting.at, format!("{} is always {text}; it cannot be set", q.name)));
            }
            ties.retain(|tie| tie.target != target);
            let value = match &setting.value {
                Value::Number(x) => *x,
                Value::Quantity { value, unit } => {
                    value * units::conversion(unit, q.unit).map_err(|e| scene.fault(&setting.at, Fault::Unit(e)))?
                }
                Value::Tie(expression) => {
                    for name in expression.names() {
                        if !names.contains(&name.as_str()) {
                            let fault = Fault::unknown("parameter", &name, names.iter().copied());
                            return Err(scene.fault(&setting.at, fault));
                        }
                    }
                    let (expression, place) = (expression.clone(), Some(setting.at.clone()));
                    ties.push(Law { target, expression, place });
                    continue;
                }
            };
            if !q.bounds.contain(value) {
                return Err(scene.refuse(&setting.at, format!("{} = {value} {}: must be {}", q.name, q.unit, q.bounds)));
            }
            values[target] = value;
        }
        let mut study = Self { model, values, ties };
        study.sort(scene)?;
        study.check_values(scene)?;
        Ok(study)
    }

    /// Ties in an order in which each uses only what is known before it.
    fn sort(&mut self, scene: &Scene) -> Result<(), SceneError> {
        let names: Vec<&str> = self.model.parameters().iter().map(|q| q.name).collect();
        let (mut open, mut sorted) = (std::mem::take(&mut self.ties), Vec::new());
        while !open.is_empty() {
            let waiting: BTreeSet<&str> = open.iter().map(|tie| names[tie.target]).collect();
            let ready =
                open.iter().position(|tie| tie.expression.names().iter().all(|n| !waiting.contains(n.as_str())));
            let Some(ready) = ready else {
                let circle: Vec<String> =
                    open.iter().map(|tie| format!("{} = {}", names[tie.target], tie.expression)).collect();
                let at = open.iter().find_map(|tie| tie.place.clone()).unwrap_or_default();
                return Err(scene.refuse(
                    &at,
                    format!("parameters are tied in a circle: {}; give one of them a number", circle.join(", ")),
                ));
            };
            sorted.push(open.remove(ready));
        }
        self.ties = sorted;
        Ok(())
    }

    fn check_values(&self, scene: &Scene) -> Result<(), SceneError> {
        let tied = self.problem(usize::MAX);
        let p = tied.resolve(&self.values);
        for tie in &self.ties {
            let q = &self.model.parameters()[tie.target];
            if !q.bounds.contain(p[tie.target]) {
                let at = tie.place.clone().unwrap_or_else(|| scene.model.at.clone());
                let message =
                    format!("{} = {} gives {} {}: must be {}", q.name, tie.expression, p[tie.target], q.unit, q.bounds);
                return Err(scene.refuse(&at, message));
            }
        }
        Ok(())
    }

    /// The problem with all ties but that of the free parameter.
    fn problem(&self, free: usize) -> Tied {
        let list = self.model.parameters();
        let ties = self.ties.iter().filter(|tie| tie.target != free).map(|tie| {
            let find = |name: String| list.iter().position(|q| q.name == name).map(|i| (name, i));
            let names = tie.expression.names().into_iter().filter_map(find).collect();
            Box::new(Resolved { target: tie.target, expression: tie.expression.clone(), names }) as Box<dyn Tie>
        });
        Tied { inner: self.model.clone(), ties: Arc::new(ties.collect()) }
    }

    pub fn observables(&self) -> &[Observable] {
        self.model.observables()
    }

    pub fn picture_unit(&self) -> &'static str {
        self.model.picture_unit()
    }

    pub fn dim(&self) -> usize {
        self.model.dim()
    }

    /// Names, values, units and ties, for the plan.
    pub fn parameters(&self) -> Vec<(String, f64, String, Option<String>)> {
        let p = self.problem(usize::MAX).resolve(&self.values);
        let list = self.model.parameters().iter().enumerate();
        list.map(|(i, q)| {
            let tie = self.ties.iter().find(|tie| tie.target == i).map(|tie| tie.expression.to_string());
            (q.name.to_owned(), p[i], q.unit.to_owned(), tie)
        })
        .collect()
    }

    /// What a task works on; every name in it is checked here.
    pub fn prepare(&self, scene: &Scene, task: &Task) -> Result<Prepared, SceneError> {
        let along = task.kind.along();
        let list = self.model.parameters();
        let names = || list.iter().map(|q| q.name);
        let Some(free) = names().position(|n| n == along.free) else {
            return Err(scene.fault(&along.free_at, Fault::unknown("parameter", &along.free, names())));
        };
        let q = &list[free];
        if let Default::Derived(text) = q.default {
            return Err(scene.refuse(&along.free_at, format!("{} is always {text}; it cannot be free", q.name)));
        }
        if let Some(tie) = self.ties.iter().find(|tie| tie.target == free && tie.place.is_some()) {
            let message =
                format!("{} is tied to {} in [parameters]; remove the tie to free it", q.name, tie.expression);
            return Err(scene.refuse(&along.free_at, message));
        }
        let problem = self.problem(free);
        let mut p = self.values.clone();
        for end in [along.range.from, along.range.to] {
            p[free] = end;
            if !q.bounds.contain(end) {
                return Err(
                    scene.refuse(&along.range.at, format!("{} = {end} {}: must be {}", q.name, q.unit, q.bounds))
                );
            }
            let resolved = problem.resolve(&p);
            if let Some((q, x)) = list.iter().zip(&resolved).find(|(q, x)| !q.bounds.contain(**x)) {
                let message = format!("at this end {} = {x} {}: must be {}", q.name, q.unit, q.bounds);
                return Err(scene.refuse(&along.range.at, message));
            }
        }
        let observables = self.wanted(scene, task)?;
        let waves = scene
            .figures
            .iter()
            .filter_map(|figure| figure.point.as_deref()?.strip_prefix(&format!("{}/", task.name)).map(str::to_owned))
            .collect();
        Ok(Prepared {
            problem: Arc::new(problem),
            p,
            free,
            free_name: q.name.to_owned(),
            free_unit: q.unit.to_owned(),
            observables,
            waves,
        })
    }

    /// Observables that the task, its figures or expectations name; an unknown name is an error.
    fn wanted(&self, scene: &Scene, task: &Task) -> Result<Vec<usize>, SceneError> {
        let along = task.kind.along();
        let cycles = matches!(task.kind, TaskKind::Cycles(_));
        let own: &[&str] = if cycles {
            &["period", "frequency", "trivial_error"]
        } else {
            &["omega", "frequency", "lyapunov", "growth"]
        };
        let list = self.model.observables();
        let mut wanted = BTreeSet::new();
        let mut note = |name: &str, at: &Place| -> Result<(), SceneError> {
            let base = name.strip_prefix("max ").or(name.strip_prefix("min ")).unwrap_or(name);
            let column = own.contains(&name) || name == along.free || is_spectral(name);
            let parameter = self.model.parameters().iter().any(|q| q.name == name);
            match list.iter().position(|o| o.name == base) {
                Some(i) => {
                    wanted.insert(i);
                    Ok(())
                }
                None if column || parameter => Ok(()),
                None => {
                    let known = list.iter().map(|o| o.name).chain(own.iter().copied()).chain([along.free.as_str()]);
                    Err(scene.fault(at, Fault::unknown("observable or column", name, known)))
                }
            }
        };
        let nowhere = task.at.clone();
        let place = |key: &str| along.places.get(key).cloned().unwrap_or_else(|| nowhere.clone());
        for name in &along.observables {
            note(name, &place("observables"))?;
        }
        // Points are located on a column, so that here the name must be one: "max tip_angle" on cycles.
        let columns: Vec<String> = if cycles {
            let extremes = list.iter().flat_map(|o| [format!("max {}", o.name), format!("min {}", o.name)]);
            ["period".to_owned(), "frequency".to_owned()].into_iter().chain(extremes).collect()
        } else {
            list.iter().map(|o| o.name.to_owned()).collect()
        };
        for name in along.values.keys().filter(|name| **name != along.free) {
            if !columns.contains(name) {
                let known = std::iter::once(along.free.as_str()).chain(columns.iter().map(String::as_str));
                return Err(scene.fault(&place("values"), Fault::unknown("column to find values on", name, known)));
            }
            note(name, &place("values"))?;
        }
        for figure in scene.figures.iter().filter(|f| f.kind == "diagram" && f.tasks.contains(&task.name)) {
            for name in figure.x.iter().chain(&figure.y) {
                note(name, &figure.at)?;
            }
        }
        for expect in scene.expect.iter().filter(|e| e.label.starts_with(&format!("{}/", task.name))) {
            note(&expect.quantity, &expect.at)?;
        }
        Ok(wanted.into_iter().collect())
    }
}

/// Columns that spectra and multipliers bring.
fn is_spectral(name: &str) -> bool {
    ["re_", "im_", "mu_"].iter().any(|prefix| name.starts_with(prefix))
}

fn build(scene: &Scene) -> Result<Arc<dyn Problem>, SceneError> {
    let choice = &scene.model;
    let Some(model) = models::find(&choice.name) else {
        let known = models::REGISTRY.iter().map(|m| m.name);
        return Err(scene.fault(&choice.at, Fault::unknown("model", &choice.name, known)));
    };
    let mut options = Options::default();
    for option in &choice.options {
        if !model.options.iter().any(|(name, ..)| *name == option.name) {
            let known = model.options.iter().map(|(name, ..)| *name);
            return Err(scene.fault(&option.at, Fault::unknown("option of the model", &option.name, known)));
        }
        let value = match &option.value {
            OptionValue::Integer(i) => Choice::Integer(*i),
            OptionValue::Text(text) => Choice::Text(text.clone()),
            OptionValue::Number(x) => Choice::Text(x.to_string()),
            OptionValue::Flag(b) => Choice::Text(b.to_string()),
        };
        options.0.insert(option.name.clone(), value);
    }
    (model.build)(&options).map_err(|e| {
        let models::ModelError::Value { key, .. } = &e;
        let at = choice.options.iter().find(|o| &o.name == key).map_or(&choice.at, |o| &o.at);
        scene.refuse(at, e.to_string())
    })
}
