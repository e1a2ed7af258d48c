//! Reading a whole scene.

use std::path::{Path, PathBuf};
use std::{fs, io};

use super::entry::{Section, Source};
use super::label::{Announced, is_name, owned};
use super::overrides::Override;
use super::{
    Fault, Figure, Place, Scene, SceneError, Task, TaskKind, bench, expect, figure, model, parameters, task, tree,
};

const SECTIONS: [&str; 9] = ["title", "budget", "limit", "model", "parameters", "task", "figure", "expect", "bench"];

impl Scene {
    /// Reads a scene file and lays `--set KEY=VALUE` arguments over it.
    pub fn load(path: &Path, sets: &[String]) -> Result<Scene, SceneError> {
        let text = fs::read_to_string(path).map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
        Scene::parse(&text, path, sets)
    }

    /// Reads a scene file, or all scenes (`*.toml`) of a folder in the order of their names.
    pub fn load_all(path: &Path, sets: &[String]) -> Result<Vec<Scene>, SceneError> {
        if !path.is_dir() {
            return Ok(vec![Scene::load(path, sets)?]);
        }
        let refuse = |source| SceneError::Read { path: path.to_owned(), source };
        let entries: io::Result<Vec<PathBuf>> =
            fs::read_dir(path).and_then(|entries| entries.map(|entry| entry.map(|e| e.path())).collect());
        let mut files = entries.map_err(refuse)?;
        files.retain(|file| file.extension().is_some_and(|extension| extension == "toml"));
        files.sort();
        if files.is_empty() {
            return Err(refuse(io::Error::other("a folder without scenes (*.toml)")));
        }
        files.iter().map(|file| Scene::load(file, sets)).collect()
    }

    /// Reads a scene from text; `path` names it in messages and gives it its name.
    pub fn parse(text: &str, path: &Path, sets: &[String]) -> Result<Scene, SceneError> {
        let mut table = tree::document(text, path)?;
        let overrides =
            sets.iter().map(|argument| Override::parse(argument)).collect::<Result<Vec<Override>, SceneError>>()?;
        for one in &overrides {
            one.apply(&mut table).map_err(|fault| one.refuse(fault))?;
        }
        let source = Source { path, sets };
        let root = Section { source: &source, table: &table, at: Place::default() };
        read(&root, overrides.iter().any(Override::touches_model))
    }
}

pub(super) fn read(root: &Section<'_>, overridden: bool) -> Result<Scene, SceneError> {
    root.allow("section", &SECTIONS)?;
    let path = root.source.path;
    let name = path.file_stem().map_or("scene".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let (tasks, announced) = tasks(root)?;
    Ok(Scene {
        path: path.to_owned(),
        title: match root.get("title") {
            Some(entry) => entry.text()?.to_owned(),
            None => name.clone(),
        },
        name,
        limit: root.get("limit").map(|entry| entry.text()).transpose()?.unwrap_or_default().to_owned(),
        budget: root.get("budget").map(|entry| entry.positive()).transpose()?,
        model: model::read(root)?,
        parameters: parameters::read(root)?,
        figures: figures(root, &tasks, &announced)?,
        expect: expect::read(root, &tasks, &announced)?,
        ends: expect::ends(root, &tasks)?,
        bench: bench::read(root, &tasks, &announced)?,
        tasks,
        sets: root.source.sets.to_vec(),
        overridden,
    })
}

fn tasks(root: &Section<'_>) -> Result<(Vec<Task>, Vec<Announced>), SceneError> {
    let sections = named_sections(root, "task")?;
    let announced: Vec<Announced> =
        sections.iter().map(|(name, section)| Announced { name: name.clone(), line: section.at.line }).collect();
    let mut tasks = Vec::with_capacity(sections.len());
    for (name, section) in sections {
        let task = task::read(&section, name, &tasks, &announced)?;
        let others = tasks.iter().map(|other| (other, &task)).chain(tasks.iter().map(|other| (&task, other)));
        for (diagram, other) in others {
            if matches!(diagram.kind, TaskKind::Diagram(_)) && owned(&diagram.name, &other.name) {
                let message = format!(
                    "{:?} is the name of a branch of the diagram {:?}; choose another",
                    other.name, diagram.name
                );
                return Err(section.error(Fault::Other(message)));
            }
        }
        tasks.push(task);
    }
    Ok((tasks, announced))
}

fn figures(root: &Section<'_>, tasks: &[Task], announced: &[Announced]) -> Result<Vec<Figure>, SceneError> {
    named_sections(root, "figure")?
        .into_iter()
        .map(|(name, section)| figure::read(&section, name, tasks, announced))
        .collect()
}

/// The `[[task]]`, `[[figure]]` or, in `[bench]`, `[[bench.family]]` sections with their names: valid, and none twice.
pub(super) fn named_sections<'a>(
    root: &Section<'a>,
    what: &'static str,
) -> Result<Vec<(String, Section<'a>)>, SceneError> {
    let key = what.rsplit('.').next().unwrap_or(what);
    let Some(entry) = root.get(key) else {
        return Ok(Vec::new());
    };
    let expected = format!("a list of sections, each headed [[{what}]]");
    let items = entry.list(&expected)?;
    let mut sections: Vec<(String, Section<'a>)> = Vec::with_capacity(items.len());
    for item in items {
        let mut section = item.section(&expected)?;
        let entry = section.need("name", &format!("name = \"NAME\" to the [[{what}]]"))?;
        let name = entry.text()?;
        if !is_name(name) {
            let name = name.to_owned();
            return Err(entry.error(Fault::Name { name }));
        }
        section.at.key = format!("{what}.{name}");
        if let Some((_, first)) = sections.iter().find(|(known, _)| known == name) {
            return Err(entry.error(Fault::Duplicate { what, name: name.to_owned(), first: first.at.line }));
        }
        sections.push((name.to_owned(), section));
    }
    Ok(sections)
}
