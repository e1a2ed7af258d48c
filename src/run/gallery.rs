//! `hopfline gallery`: the page of a folder of scenes, from stored results: what each shows, a figure, its numbers with
//! their errors, and its time; then suites and studies in folders of it.

use super::bench::Report;
use super::summary::{Expected, Summary, with_error};
use super::{RunError, ready, suite};
use crate::branch::write_atomically;
use crate::scene::Scene;
use std::fmt::Write;
use std::io::Write as _;
use std::path::{Component, Path, PathBuf};

/// A file to write and what it holds.
type Figure = (PathBuf, Vec<u8>);

/// Writes `README.md` into the folder of scenes, and one figure of each scene into `gallery` beside the results, from
/// what runs left in `results`. Returns the page's path. Fails, and writes nothing, where a scene has no results or some
/// of other expectations.
pub fn gallery(folder: &Path, results: &Path) -> Result<PathBuf, RunError> {
    let mut entries = Vec::new();
    for path in scenes(folder)? {
        let scene = Scene::load(&path, &[])?;
        let stored = results.join(&scene.name);
        let summary = Summary::load(&stored).map_err(|error| {
            let advice = format!("run the scenes one by one, as `hopfline run {}/*.toml` does", folder.display());
            RunError::Input(format!("{error}; {advice}"))
        })?;
        let promised: Vec<String> = scene.expect.iter().map(|e| format!("{}.{}", e.label, e.quantity)).collect();
        let found: Vec<&String> = summary.expect.iter().map(|e| &e.key).collect();
        if !found.iter().copied().eq(&promised) {
            return Err(RunError::Input(format!(
                "{} holds results of another version of {}, or of a part of it: run it again",
                stored.display(),
                path.display()
            )));
        }
        entries.push((scene, summary));
    }
    // Read before anything is written.
    let mut figures: Vec<Figure> = Vec::new();
    for (scene, summary) in &entries {
        if let Some(figure) = summary.figures.first() {
            let path = results.join(&scene.name).join("figures").join(format!("{}.svg", figure.name));
            let svg = std::fs::read(&path)
                .map_err(|e| RunError::Input(format!("cannot read {}: {e}; run the scene again", path.display())))?;
            figures.push((results.join("gallery").join(format!("{}.svg", scene.name)), svg));
        }
    }
    let pictures = between(folder, results)?.join("gallery");
    let mut text = page(&entries, &pictures)?;
    let (suite, studies) = (folder.join("extreme"), folder.join("bench"));
    if suite.is_dir() {
        text += &cases(&suite, results)?;
    }
    if studies.is_dir() {
        text += "\n# Work and precision\n\nStudies that `hopfline bench` runs: what an error of a number costs in families of settings.\n";
        for path in scenes(&studies)? {
            let (section, figure) = study(&path, results, &pictures)?;
            text += &section;
            figures.extend(figure);
        }
    }
    for (path, svg) in figures {
        write_atomically(&path, |file| file.write_all(&svg))?;
    }
    let path = folder.join("README.md");
    write_atomically(&path, |file| file.write_all(text.as_bytes()))?;
    Ok(path)
}

/// A suite's table.
fn cases(folder: &Path, results: &Path) -> Result<String, RunError> {
    let stored = suite::folder(folder, results);
    let cases = suite::load(&stored)?;
    let scenes = Scene::load_all(folder, &[])?;
    if !cases.iter().map(|case| &case.scene).eq(scenes.iter().map(|scene| &scene.name)) {
        let (stored, folder) = (stored.display(), folder.display());
        return Err(RunError::Input(format!(
            "{stored} holds results of other scenes than {folder}: run that folder again"
        )));
    }
    Ok(format!(
        "\n# Extreme cases\n\nWhat `hopfline run {}` prints at its end: the number that is furthest off in each scene, its true and its \
         printed error\n(relative), and how many numbers lie within their printed errors.\n\n{}",
        folder.display(),
        suite::table(&cases)
    ))
}

/// A study's section, and its first figure with the place it goes to.
fn study(path: &Path, results: &Path, pictures: &Path) -> Result<(String, Option<Figure>), RunError> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let stored = results.join("bench").join(&*name);
    let report = Report::read(&stored)?.ok_or_else(|| {
        RunError::Input(format!("{} holds no bench.json: run `hopfline bench {name}`", stored.display()))
    })?;
    let file = format!("bench-{name}.svg");
    let figure = report.figures()?.into_iter().next();
    let figure = figure.map(|(_, svg)| (results.join("gallery").join(&file), svg.into_bytes()));
    let link = figure.as_ref().map(|_| pictures.join(&file));
    Ok((report.section(link.as_deref()), figure))
}

/// The way from one folder to another: up to what they share, then down.
fn between(from: &Path, to: &Path) -> Result<PathBuf, RunError> {
    let absolute = |path: &Path| {
        std::path::absolute(path)
            .map_err(|e| RunError::Input(format!("cannot find the folder {}: {e}", path.display())))
    };
    let (from, to) = (absolute(from)?, absolute(to)?);
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    Ok(up.chain(to.components().skip(shared)).collect())
}

/// The scene files of a folder, by name.
fn scenes(folder: &Path) -> Result<Vec<PathBuf>, RunError> {
    let failed = |e| RunError::Input(format!("cannot read the folder {}: {e}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(failed)?;
    let mut paths: Vec<PathBuf> =
        entries.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>().map_err(failed)?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    match paths.is_empty() {
        true => Err(RunError::Input(format!("the folder {} holds no scenes (*.toml)", folder.display()))),
        false => Ok(paths),
    }
}

/// The page: a table of all scenes, then a section for each.
fn page(entries: &[(Scene, Summary)], pictures: &Path) -> Result<String, RunError> {
    let mut out = "# Scenes\n\nWritten by `hopfline gallery problems` from stored results. Times are of one run on one machine, \
                   and change; numbers\nare checked by the tests. Each scene says what it must reproduce: *off by* is the \
                   distance from that in parts of it.\n\n| scene | shows | numbers met | largest distance | seconds |\n\
                   |---|---|---|---|---|\n"
        .to_owned();
    for (scene, summary) in entries {
        let met = summary.expect.iter().filter(|e| e.met).count();
        let worst = summary.expect.iter().filter_map(Expected::distance).fold(0.0, f64::max);
        let count = summary.expect.len();
        let _ = writeln!(
            out,
            "| [{0}](#{0}) | {1} | {met} of {count} | {worst:.0e} | {2:.1} |",
            scene.name, scene.title, summary.seconds
        );
    }
    for (scene, summary) in entries {
        out += &section(scene, summary, pictures)?;
    }
    Ok(out)
}

/// One scene's part of the page; `pictures` is where its figure is.
///
/// # Errors
/// Where the scene's file cannot be read, or names what its model does not have.
pub fn section(scene: &Scene, summary: &Summary, pictures: &Path) -> Result<String, RunError> {
    let text = std::fs::read_to_string(&scene.path)
        .map_err(|e| RunError::Input(format!("cannot read {}: {e}", scene.path.display())))?;
    let about: Vec<&str> = text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim).collect();
    let mut out = format!("\n## {}\n\n**{}.** {}\n\n", scene.name, scene.title, about.join("\n"));
    let ready = ready(scene, &[])?;
    let _ = writeln!(
        out,
        "[`{0}.toml`]({0}.toml), {1} unknowns: {2}\n",
        scene.name,
        ready.study.dim(),
        scene.tasks.iter().map(|task| format!("{} (`{}`)", task.name, task.kind.name())).collect::<Vec<_>>().join(", ")
    );
    if !summary.figures.is_empty() {
        let picture = pictures.join(format!("{}.svg", scene.name));
        let _ = writeln!(out, "![{}]({})\n", scene.title, picture.display());
    }
    out += "| number | found | expected | off by | source |\n|---|---|---|---|---|\n";
    for (promised, expected) in scene.expect.iter().zip(&summary.expect) {
        let found = expected.value.map_or("not found".to_owned(), |value| match &expected.error {
            Some(error) => with_error(value, Some(error)),
            None => format!("{value}"),
        });
        let off = expected.distance().map_or(String::new(), |distance| format!("{distance:.0e}"));
        let verdict = if expected.met { "" } else { " **missed**" };
        let _ =
            writeln!(out, "| {} | {found} | {} | {off}{verdict} | {} |", expected.key, promised.value, promised.source);
    }
    Ok(out)
}
