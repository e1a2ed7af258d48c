//! A scene: one TOML file per study, typed, with the place of every entry for error messages. No numerics.

mod along;
mod bench;
mod calibration;
mod diagram;
mod entry;
mod error;
mod expect;
mod figure;
mod kinds;
mod label;
mod map;
mod model;
mod overrides;
mod parameters;
mod parse;
mod several;
mod simulate;
mod task;
#[cfg(test)]
mod tests;
mod tree;
pub mod units;

pub use crate::expression::Expression;
pub use bench::{Bench, Family, Quantity, Reference, Variant};
pub use calibration::QUANTITIES;
pub use error::{EntryError, Fault, SceneError};
pub use kinds::{
    Along, Axis, Calibration, Curve, CycleKind, Cycles, Diagram, Equilibria, Guess, Happening, Map, Range, Simulate,
    Start, Surface, Task, TaskKind, Wanted,
};
pub use label::{Label, owner};
pub use task::is_file;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Where an entry stands: its dotted key ("task.beat.range") and its line in the file (1-based; None for `--set`).
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Place {
    pub key: String,
    pub line: Option<usize>,
}

/// A whole study.
#[derive(Clone, Debug)]
pub struct Scene {
    pub path: PathBuf,
    /// The file's stem: names the output folder.
    pub name: String,
    pub title: String,
    /// Seconds that a run may take: then it stops after the current point, as if interrupted.
    pub budget: Option<f64>,
    /// What limits its accuracy or reach, in words, for the table of a suite.
    pub limit: String,
    pub model: ModelChoice,
    pub parameters: Vec<Setting>,
    pub tasks: Vec<Task>,
    pub figures: Vec<Figure>,
    pub expect: Vec<Expectation>,
    /// Tasks that are expected to end otherwise than done, and a part of the reason: `beat.ends = "no step of at least"`.
    pub ends: BTreeMap<String, String>,
    /// What `hopfline bench` does with the scene.
    pub bench: Option<Bench>,
    /// The `--set` arguments laid over the file, as given.
    pub sets: Vec<String>,
    /// Whether one of them changed `[model]` or `[parameters]`: the expectations hold for the scene as written, and
    /// need not hold then.
    pub overridden: bool,
}

impl Scene {
    /// The scene's folder, in which it may name files.
    pub fn home(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// An error about an entry, for what only the caller can check: `scene.refuse(&setting.at, "...")`.
    pub fn refuse(&self, at: &Place, message: impl Into<String>) -> SceneError {
        self.fault(at, Fault::Other(message.into()))
    }

    /// The same with one of the faults of this module, for instance `Fault::unknown("parameter", name, known)`.
    pub fn fault(&self, at: &Place, fault: Fault) -> SceneError {
        entry::Source { path: &self.path, sets: &self.sets }.error(at.clone(), fault)
    }
}

/// `[model]`: a name and the model's own options (load = "uniform", functions = 28).
#[derive(Clone, Debug)]
pub struct ModelChoice {
    /// "text" for a model that the scene itself holds.
    pub name: String,
    pub at: Place,
    pub options: Vec<ModelOption>,
    pub text: Option<ModelText>,
}

/// A model as text: `[model]` with `equations`.
#[derive(Clone, Debug)]
pub struct ModelText {
    pub equations: Words,
    /// Whole numbers by name.
    pub constants: Vec<(String, i64, Place)>,
    pub parameters: Vec<TextParameter>,
    pub start: Vec<(String, Words)>,
    pub observables: Vec<TextObservable>,
    /// Expressions that the flow keeps, by the parameter that is their value.
    pub conserved: Vec<(String, Words)>,
    pub symmetry: Option<Words>,
    /// Quarter turns of continuous symmetries.
    pub rotations: Vec<Words>,
    pub time_unit: String,
}

/// `sigma = 10` or `sigma = { value = 10, unit = "", min = 0, max = 100, meaning = "Prandtl number" }`
#[derive(Clone, Debug)]
pub struct TextParameter {
    pub name: String,
    pub value: TextValue,
    pub unit: String,
    pub meaning: String,
    pub least: f64,
    pub most: f64,
    pub at: Place,
}

#[derive(Clone, Debug)]
pub enum TextValue {
    Number(f64),
    Tie(Words),
}

/// `energy = "x^2 + y^2"` or `energy = { expression = "x^2 + y^2", unit = "J", meaning = "energy" }`
#[derive(Clone, Debug)]
pub struct TextObservable {
    pub name: String,
    pub expression: Words,
    pub unit: String,
    pub meaning: String,
}

/// A string with its place, so that errors inside it can be found.
#[derive(Clone, Debug)]
pub struct Words {
    pub text: String,
    pub at: Place,
    /// Line and column at which it begins in the file.
    pub begins: Option<(usize, usize)>,
}

impl Words {
    /// Line and column of a byte of the text.
    pub fn position(&self, offset: usize) -> Option<(usize, usize)> {
        let (line, column) = self.begins?;
        let before = self.text.get(..offset).unwrap_or(&self.text);
        Some(match before.rsplit_once('\n') {
            None => (line, column + before.chars().count()),
            Some((above, last)) => (line + above.matches('\n').count() + 1, last.chars().count() + 1),
        })
    }
}

#[derive(Clone, Debug)]
pub struct ModelOption {
    pub name: String,
    pub value: OptionValue,
    pub at: Place,
}

#[derive(Clone, Debug, PartialEq)]
pub enum OptionValue {
    Integer(i64),
    Number(f64),
    Text(String),
    Flag(bool),
}

/// One line of `[parameters]`.
#[derive(Clone, Debug)]
pub struct Setting {
    pub name: String,
    pub value: Value,
    pub at: Place,
}

/// What a parameter is set to.
#[derive(Clone, Debug)]
pub enum Value {
    /// In the model's unit.
    Number(f64),
    /// `{ value = 12, unit = "nm" }`: converted to the model's unit, or refused.
    Quantity { value: f64, unit: String },
    /// `"c_N * L^4 / EI / 200"`: tied to other parameters.
    Tie(Expression),
}

/// `[[figure]]`.
#[derive(Clone, Debug)]
pub struct Figure {
    pub name: String,
    /// "diagram" (default), "eigenvalues", "waveform", "map", "surface".
    pub kind: String,
    pub title: Option<String>,
    pub x: Option<String>,
    /// One or several columns.
    pub y: Vec<String>,
    pub tasks: Vec<String>,
    /// For waveforms: "beat/UZ1".
    pub point: Option<String>,
    /// For maps: "frequency" (default), "growth".
    pub column: Option<String>,
    /// For surfaces: the azimuth and elevation of the eye in degrees; None: where most of the surface is seen.
    pub view: Option<[f64; 2]>,
    pub at: Place,
}

/// `"straight/HB1".p = { value = ..., tolerance = ..., source = "..." }`; tolerance is relative (absolute where value = 0).
#[derive(Clone, Debug)]
pub struct Expectation {
    /// "straight/HB1"
    pub label: String,
    /// "p"
    pub quantity: String,
    pub value: f64,
    pub tolerance: f64,
    pub source: String,
    pub at: Place,
}
