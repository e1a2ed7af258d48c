//! The models that scenes can name.

mod column;
mod filament;
mod flagellum;
mod lorenz84;
mod options;
mod panel;
mod rod;
#[cfg(feature = "program")]
pub mod text;

pub use column::{Column, Pipe};
pub use filament::{Base, Filament};
pub use flagellum::{Law, Mesh, MixedTwoDoublet, TwoDoublet};
pub use lorenz84::Lorenz84;
pub use options::{Choice, ModelError, Options};
pub use panel::Panel;
pub use rod::Load;

use crate::problem::Problem;
use std::sync::Arc;

/// An entry of the registry.
pub struct Model {
    pub name: &'static str,
    pub meaning: &'static str,
    /// Option, allowed values with the default first, meaning.
    pub options: &'static [(&'static str, &'static str, &'static str)],
    /// Parameters whose terms are not assembled where they are zero.
    pub optional: &'static [&'static str],
    pub build: fn(&Options) -> Result<Arc<dyn Problem>, ModelError>,
}

pub static REGISTRY: &[Model] = &[
    Model {
        name: "two-doublet",
        meaning: "two coupled elastic doublets in viscous fluid under steady dynein load (Bayly and Dutcher 2016)",
        options: &[
            ("load", "\"uniform\" | \"distal\"", "D(s) = 1, or 1 - exp(-s/s0)"),
            ("law", "\"printed\" | \"separation\"", "cubic normal force: -k_3N int (psi_1 - psi_2)^3 ds, or -k_3N h^3"),
            (
                "form",
                "\"minimal\" | \"mixed\"",
                "angles alone, or forces too: sparse hp elements with a constant singular mass",
            ),
            ("functions", "28, from 2 to 400", "basis functions per doublet (form = \"minimal\")"),
            ("elements", "4, from 1 to 1000", "elements along the doublets (form = \"mixed\")"),
            ("degree", "8, from 2 to 8", "degree of the angles on an element (form = \"mixed\")"),
            (
                "grading",
                "1.2, from 1 to 10",
                "an element's length over that of its neighbour nearer to an end (form = \"mixed\")",
            ),
        ],
        optional: &["b_N", "k_T", "b_T", "k_3N", "k_3T"],
        build: flagellum::build,
    },
    Model {
        name: "lorenz-84",
        meaning: "extended Lorenz-84 model of atmospheric circulation: four equations with every bifurcation of codimension two",
        options: &[],
        optional: &[],
        build: Lorenz84::build,
    },
    Model {
        name: "filament",
        meaning: "an elastic filament in viscous fluid under compressive follower loads, without inertia",
        options: &[
            ("load", "\"uniform\" | \"distal\"", "D(s) = 1, or 1 - exp(-s/s0)"),
            ("base", "\"clamped\" | \"pinned\"", "psi(0) = 0, or a pin with a spring"),
            ("functions", "16, from 2 to 400", "basis functions"),
        ],
        optional: &["p"],
        build: Filament::build,
    },
    Model {
        name: "column",
        meaning: "a cantilever with inertia under dead or follower loads (Euler, Beck, Leipholz, Hauger, Pflueger)",
        options: &[("functions", "12, from 2 to 400", "basis functions")],
        optional: &["p"],
        build: Column::build,
    },
    Model {
        name: "pipe",
        meaning: "a cantilevered pipe that discharges fluid (Gregory and Paidoussis 1966)",
        options: &[("functions", "14, from 2 to 400", "basis functions")],
        optional: &["gamma"],
        build: Pipe::build,
    },
    Model {
        name: "panel",
        meaning: "a simply supported panel in supersonic flow, by piston theory (Dowell 1966)",
        options: &[("functions", "12, from 2 to 400", "basis functions")],
        optional: &[],
        build: Panel::build,
    },
];

pub fn find(name: &str) -> Option<&'static Model> {
    REGISTRY.iter().find(|m| m.name == name)
}
