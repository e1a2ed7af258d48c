//! `hopfline import`: a model of another program as a scene, tried before it is handed out.

use super::{RunError, check, written};
use crate::import::{self, Remark};
use crate::scene::Scene;
use std::fs;
use std::path::Path;

/// The text of the scene, and what was left out or renamed.
pub fn import(path: &Path) -> Result<(String, Vec<Remark>), RunError> {
    let cannot = |message: String| RunError::Input(format!("{}: {message}", path.display()));
    let text = fs::read_to_string(path)
        .map_err(|error| RunError::Input(format!("cannot read {}: {error}", path.display())))?;
    let imported = import::read(&text, &written::reserved()).map_err(|error| {
        let lines: Vec<String> =
            error.0.iter().map(|wrong| format!("{}:{}: {}", path.display(), wrong.line, wrong.message)).collect();
        RunError::Input(lines.join("\n"))
    })?;
    let title = path.file_stem().map_or("model".into(), |stem| stem.to_string_lossy());
    let scene = imported.scene(&title);
    let tried =
        Scene::parse(&scene, Path::new("the scene"), &[]).map_err(RunError::from).and_then(|scene| check(&scene, &[]));
    tried.map_err(|error| cannot(format!("what was read is no model: {error}")))?;
    Ok((scene, imported.notes))
}
