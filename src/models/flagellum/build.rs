//! From a scene's options to one of the two forms.

use super::mixed::{LARGEST_DEGREE, Mesh, MixedTwoDoublet, SMALLEST_DEGREE};
use super::{Law, TwoDoublet};
use crate::models::rod::Load;
use crate::models::{ModelError, Options};
use crate::problem::{Automatic, Problem};
use std::sync::Arc;

/// In which unknowns the equations are written.
#[derive(Clone, Copy)]
enum Form {
    Minimal,
    Mixed,
}

/// The two-doublet model from `form`, `load`, `law`, and the resolution of that form: `functions`, or `elements`,
/// `degree` and `grading`.
pub fn build(options: &Options) -> Result<Arc<dyn Problem>, ModelError> {
    let form = options.choice("form", &[("minimal", Form::Minimal), ("mixed", Form::Mixed)])?;
    let load = options.choice("load", &[("uniform", Load::Uniform), ("distal", Load::Distal)])?;
    let law = options.choice("law", &[("printed", Law::Printed), ("separation", Law::Separation)])?;
    match form {
        Form::Minimal => {
            options.absent(&["elements", "degree", "grading"], "form = \"mixed\"")?;
            let functions = options.integer("functions", 28, 2, 400)?;
            Ok(Arc::new(Automatic(TwoDoublet::new(functions, load, law))))
        }
        Form::Mixed => {
            options.absent(&["functions"], "form = \"minimal\"")?;
            let standard = Mesh::default();
            let mesh = Mesh {
                elements: options.integer("elements", standard.elements, 1, 1000)?,
                degree: options.integer("degree", standard.degree, SMALLEST_DEGREE, LARGEST_DEGREE)?,
                grading: options.number("grading", standard.grading, 1.0, 10.0)?,
            };
            Ok(Arc::new(Automatic(MixedTwoDoublet::new(mesh, load, law))))
        }
    }
}
