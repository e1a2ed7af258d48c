//! A scene resolved against its model: the problem, its parameters, and what each task needs.

mod wanted;

use super::{cycles, written};
use crate::linalg::Structure;
use crate::models::text::Text;
use crate::models::{self, Choice, Options};
use crate::problem::{Automatic, Default, Observable, Problem, Tie, Tied};
use crate::scene::{
    self, Expression, Fault, OptionValue, Place, Scene, SceneError, Start, Task, TaskKind, Value, owner, units,
};
use num_dual::{Dual64, HyperDual64};
use std::collections::BTreeSet;
use std::sync::Arc;

/// What is computed on.
pub struct Study {
    model: Arc<dyn Problem>,
    /// The same model, if the scene wrote it.
    text: Option<Arc<Text>>,
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
    /// The positions of the free parameters before it, where several are.
    pub others: Vec<usize>,
    /// Observables wanted as columns, in the model's order.
    pub observables: Vec<usize>,
    /// Means and norms wanted of cycles.
    pub averages: Vec<cycles::Average>,
    /// Labels ("beat/UZ1") of the task's points whose waveform a figure draws.
    pub waves: BTreeSet<String>,
}

impl Prepared {
    /// The position of the first free parameter.
    pub fn first(&self) -> usize {
        self.others.first().copied().unwrap_or(self.free)
    }
}

impl Study {
    /// Resolves model, options, parameters and ties, and checks everything that tasks name.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        let (model, text) = match &scene.model.text {
            None => (build(scene)?, None),
            Some(words) => {
                let text = written::build(scene, words)?;
                (Arc::new(Automatic(text.clone())) as Arc<dyn Problem>, Some(text))
            }
        };
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
        let mut study = Self { model, text, values, ties };
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
        let tied = self.problem(&[]);
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

    /// A model that was written in the scene must have values where a task begins.
    fn check_start(&self, scene: &Scene, p: &[f64]) -> Result<(), SceneError> {
        match (&self.text, &scene.model.text) {
            (Some(text), Some(words)) => match text.complaint(p) {
                Some(error) => Err(written::refuse(scene, words, error)),
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }

    /// The problem with all ties but those of the free parameters.
    fn problem(&self, free: &[usize]) -> Tied {
        let list = self.model.parameters();
        let ties = self.ties.iter().filter(|tie| !free.contains(&tie.target)).map(|tie| {
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

    pub fn structure(&self) -> Structure {
        self.model.structure()
    }

    pub fn dim(&self) -> usize {
        self.model.dim()
    }

    /// Names, values, units and ties, for the plan.
    pub fn parameters(&self) -> Vec<(String, f64, String, Option<String>)> {
        let p = self.problem(&[]).resolve(&self.values);
        let list = self.model.parameters().iter().enumerate();
        list.map(|(i, q)| {
            let tie = self.ties.iter().find(|tie| tie.target == i).map(|tie| tie.expression.to_string());
            (q.name.to_owned(), p[i], q.unit.to_owned(), tie)
        })
        .collect()
    }

    /// The position of a parameter that may be free.
    fn free(&self, scene: &Scene, name: &str, at: &Place) -> Result<usize, SceneError> {
        let list = self.model.parameters();
        let Some(free) = list.iter().position(|q| q.name == name) else {
            return Err(scene.fault(at, Fault::unknown("parameter", name, list.iter().map(|q| q.name))));
        };
        if let Default::Derived(text) = list[free].default {
            return Err(scene.refuse(at, format!("{name} is always {text}; it cannot be free")));
        }
        if let Some(tie) = self.ties.iter().find(|tie| tie.target == free && tie.place.is_some()) {
            let message = format!("{name} is tied to {} in [parameters]; remove the tie to free it", tie.expression);
            return Err(scene.refuse(at, message));
        }
        Ok(free)
    }

    /// What a task works on; every name in it is checked here.
    pub fn prepare(&self, scene: &Scene, task: &Task) -> Result<Prepared, SceneError> {
        let along = task.kind.along();
        let list = self.model.parameters();
        // A simulation may leave all parameters as they are.
        let varies = !along.free.is_empty();
        let free = if varies { self.free(scene, &along.free, &along.free_at)? } else { 0 };
        let q = if varies { list.get(free) } else { None };
        let mut others = Vec::new();
        for axis in &along.others {
            others.push(self.free(scene, &axis.name, &along.free_at)?);
        }
        let freed: Vec<usize> = others.iter().copied().chain(varies.then_some(free)).collect();
        let problem = self.problem(&freed);
        let mut p = self.values.clone();
        let bounded = others.iter().zip(&along.others).filter_map(|(&i, axis)| Some((i, axis.range.as_ref()?)));
        for (free, range) in bounded.chain(varies.then_some((free, &along.range))) {
            for end in [range.from, range.to] {
                p[free] = end;
                if !list[free].bounds.contain(end) {
                    let q = &list[free];
                    return Err(scene.refuse(&range.at, format!("{} = {end} {}: must be {}", q.name, q.unit, q.bounds)));
                }
                let resolved = problem.resolve(&p);
                // A free parameter without a range has no value yet.
                let known = list.iter().zip(&resolved).filter(|(_, x)| others.is_empty() || !x.is_nan());
                if let Some((q, x)) = known.into_iter().find(|(q, x)| !q.bounds.contain(**x)) {
                    let message = format!("at this end {} = {x} {}: must be {}", q.name, q.unit, q.bounds);
                    return Err(scene.refuse(&range.at, message));
                }
            }
        }
        if let TaskKind::Equilibria(equilibria) = &task.kind {
            p[free] = equilibria.start.unwrap_or(along.range.from);
            self.check_start(scene, &problem.resolve(&p))?;
        }
        if let TaskKind::Simulate(simulation) = &task.kind {
            if let Some(Start::List(start, at)) = &simulation.start
                && start.len() != self.model.dim()
            {
                let message =
                    format!("start has {} numbers, but the model has {} unknowns", start.len(), self.model.dim());
                return Err(scene.refuse(at, message));
            }
            self.check_start(scene, &problem.resolve(&p))?;
        }
        freed.iter().for_each(|&free| p[free] = self.values[free]);
        let (observables, averages) = self.wanted(scene, task)?;
        let drawn = scene.figures.iter().filter_map(|figure| figure.point.as_deref());
        let waves = drawn.filter(|point| owner(&scene.tasks, point).is_some_and(|owner| owner.name == task.name));
        let waves = waves.map(str::to_owned).collect();
        Ok(Prepared {
            problem: Arc::new(problem),
            p,
            free,
            free_name: q.map_or("", |q| q.name).to_owned(),
            free_unit: q.map_or("", |q| q.unit).to_owned(),
            others,
            observables,
            averages,
            waves,
        })
    }

    /// States are given by unknowns of the model, and in a diagram by the free parameter.
    fn check_guesses(&self, scene: &Scene, task: &Task) -> Result<(), SceneError> {
        let guesses = match &task.kind {
            TaskKind::Equilibria(task) => task.guess.as_slice(),
            TaskKind::Diagram(task) => &task.states,
            TaskKind::Simulate(scene::Simulate { start: Some(Start::Named(guess)), .. }) => std::slice::from_ref(guess),
            _ => &[],
        };
        let (along, names) = (task.kind.along(), self.model.unknowns());
        for (name, value, at) in guesses.iter().flat_map(|guess| &guess.values) {
            if *name == along.free && !matches!(task.kind, TaskKind::Simulate(_)) {
                let (from, to) = (along.range.from, along.range.to);
                if !(from..=to).contains(value) {
                    return Err(scene.fault(at, Fault::OutsideRange { value: *value, from, to }));
                }
            } else if names.is_empty() {
                return Err(scene.refuse(at, "the unknowns of this model have no names, so that no state can be given"));
            } else if !names.contains(name) {
                let free = wanted::varied(&along.free).filter(|_| !matches!(task.kind, TaskKind::Simulate(_)));
                let known = names.iter().map(String::as_str).chain(free);
                return Err(scene.fault(at, Fault::unknown("unknown of the model", name, known)));
            }
        }
        Ok(())
    }
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
