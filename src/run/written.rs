//! A scene's model as text: from the words of the scene to the model, and from the model's errors to their places.

use super::{branch_curve, cycles, equilibria, fold_curve, hopf_curve, simulate};
use crate::models::text::{self, Part, Text, TextError, Written, WrittenDefault, WrittenObservable, WrittenParameter};
use crate::scene::{Fault, ModelText, Place, Scene, SceneError, TextValue, Words};
use std::sync::Arc;

/// Columns of results that are in no list of numbers of special points.
const COLUMNS: [&str; 5] = ["trivial_error", "gap", "stable", "norm", "chi2"];

/// Names of results that parameters and observables must not have.
fn columns() -> Vec<&'static str> {
    let lists = [
        &COLUMNS[..],
        &equilibria::VALUES,
        &hopf_curve::VALUES,
        &fold_curve::VALUES,
        &branch_curve::VALUES,
        &simulate::VALUES,
    ];
    lists.concat()
}

/// These and what only parameters could be mistaken for: of observables cycles have extremes and means.
pub fn reserved() -> Vec<&'static str> {
    [&columns()[..], &cycles::VALUES].concat()
}

pub fn build(scene: &Scene, model: &ModelText) -> Result<Arc<Text>, SceneError> {
    if let Some(parameter) = model.parameters.iter().find(|known| cycles::VALUES.contains(&known.name.as_str())) {
        let message = format!("{:?} is the name of a number of the results; choose another name", parameter.name);
        return Err(scene.refuse(&parameter.at, message));
    }
    let written = Written {
        equations: model.equations.text.clone(),
        constants: model.constants.iter().map(|(name, value, _)| (name.clone(), *value)).collect(),
        parameters: (model.parameters.iter())
            .map(|parameter| WrittenParameter {
                name: parameter.name.clone(),
                default: match &parameter.value {
                    TextValue::Number(value) => WrittenDefault::Number(*value),
                    TextValue::Tie(words) => WrittenDefault::Tie(words.text.clone()),
                },
                unit: parameter.unit.clone(),
                meaning: parameter.meaning.clone(),
                least: parameter.least,
                most: parameter.most,
            })
            .collect(),
        start: model.start.iter().map(|(name, words)| (name.clone(), words.text.clone())).collect(),
        observables: (model.observables.iter())
            .map(|observable| WrittenObservable {
                name: observable.name.clone(),
                expression: observable.expression.text.clone(),
                unit: observable.unit.clone(),
                meaning: observable.meaning.clone(),
            })
            .collect(),
        conserved: model.conserved.iter().map(|(name, words)| (name.clone(), words.text.clone())).collect(),
        symmetry: model.symmetry.as_ref().map(|words| words.text.clone()),
        rotations: model.rotations.iter().map(|words| words.text.clone()).collect(),
        time_unit: model.time_unit.clone(),
        reserved: columns().into_iter().map(str::to_owned).collect(),
    };
    text::build(&written).map_err(|error| refuse(scene, model, error))
}

/// An error of the model at its place in the scene.
pub fn refuse(scene: &Scene, model: &ModelText, error: TextError) -> SceneError {
    let nowhere = (scene.model.at.clone(), None);
    let in_words = |words: &Words| (words.at.clone(), error.wrong.offset.and_then(|offset| words.position(offset)));
    let (at, position): (Place, Option<(usize, usize)>) = match &error.part {
        Part::Equations => in_words(&model.equations),
        Part::Constant(name) => {
            model.constants.iter().find(|(known, ..)| known == name).map_or(nowhere, |(.., at)| (at.clone(), None))
        }
        Part::Parameter(name) => match model.parameters.iter().find(|parameter| parameter.name == *name) {
            Some(parameter) => match &parameter.value {
                TextValue::Tie(words) => in_words(words),
                TextValue::Number(_) => (parameter.at.clone(), None),
            },
            None => (model.conserved.iter().find(|(known, _)| known == name))
                .map_or(nowhere, |(_, words)| (words.at.clone(), None)),
        },
        Part::Start(name) => {
            model.start.iter().find(|(known, _)| known == name).map_or(nowhere, |(_, words)| in_words(words))
        }
        Part::Observable(name) => (model.observables.iter().find(|observable| observable.name == *name))
            .map_or(nowhere, |observable| in_words(&observable.expression)),
        Part::Conserved(name) => {
            model.conserved.iter().find(|(known, _)| known == name).map_or(nowhere, |(_, words)| in_words(words))
        }
        Part::Rotation(k) => model.rotations.get(*k).map_or(nowhere, in_words),
        Part::Symmetry => model.symmetry.as_ref().map_or(nowhere, in_words),
    };
    scene.fault(&at, Fault::Text { position, message: error.wrong.message })
}
