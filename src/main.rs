//! The command line program: parse, run, exit code.

use clap::Parser;
use hopfline::cli::{self, Cli, Command};
use hopfline::run::{self, RunError, RunOptions};
use hopfline::scene::Scene;
use std::collections::BTreeMap;
use std::io::{ErrorKind, Write};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;

// Collocation allocates and frees blocks of a megabyte; the system allocator gives them back to the kernel each time,
// which doubles the time of a linearisation.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    match execute(Cli::parse().command) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Prints to stdout; a reader that has gone away is not an error.
fn print(text: &str) -> Result<(), RunError> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(RunError::Input(format!("cannot write to stdout: {e}"))),
        _ => Ok(()),
    }
}

/// Writes a file that does not exist yet.
fn write_new(path: &std::path::Path, text: &str) -> Result<(), RunError> {
    let file = std::fs::OpenOptions::new().write(true).create_new(true).open(path);
    file.and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|e| RunError::Input(format!("cannot write {}: {e}", path.display())))
}

fn execute(command: Command) -> Result<bool, RunError> {
    match command {
        Command::Run(run) => return execute_run(run),
        Command::Bench(bench) => return execute_bench(bench),
        Command::Check(check) => {
            for path in &check.input.scenes {
                for scene in Scene::load_all(path, &check.input.sets)? {
                    print(&run::plan(&scene)?)?;
                }
            }
        }
        Command::Models(models) => match models.name {
            None => print(&run::models())?,
            Some(name) => print(&run::one_model(&name)?)?,
        },
        Command::Plot(plot) => {
            for name in run::redraw(&plot.dir)? {
                print(&format!("{}\n", plot.dir.join("figures").join(name + ".svg").display()))?;
            }
        }
        Command::Gallery(gallery) => {
            print(&format!("{}\n", run::gallery(&gallery.dir, &gallery.out)?.display()))?;
        }
        Command::New(new) => {
            let path = std::path::PathBuf::from(format!("{}.toml", new.name));
            let text = run::template(&new.name, &new.model)?;
            write_new(&path, &text)?;
            print(&format!("{}\n", path.display()))?;
        }
        Command::Import(import) => {
            let (scene, notes) = run::import(&import.file)?;
            for note in notes {
                eprintln!("{}:{}: {}", import.file.display(), note.line, note.message);
            }
            match import.out {
                None => print(&scene)?,
                Some(path) => {
                    write_new(&path, &scene)?;
                    print(&format!("{}\n", path.display()))?;
                }
            }
        }
        Command::Completions(completions) => {
            cli::completions(completions.shell).map_err(|e| RunError::Input(format!("cannot write to stdout: {e}")))?
        }
    }
    Ok(true)
}

/// The threads that were asked for, and Ctrl-C.
fn prepare(threads: Option<NonZeroUsize>) -> Result<(), RunError> {
    if let Some(threads) = threads {
        // The pool is built once per process, here, so this cannot fail for having been built before.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build_global();
    }
    let interrupt = ctrlc::set_handler(|| {
        // A second Ctrl-C does not wait for the current point; only whole files are ever on the disk.
        if run::INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
    });
    interrupt.map_err(|e| RunError::Input(format!("cannot listen for Ctrl-C: {e}")))
}

fn execute_bench(arguments: cli::Bench) -> Result<bool, RunError> {
    prepare(arguments.threads)?;
    let paths = run::studies(&arguments.names)?;
    let scenes: Vec<Scene> = paths.iter().map(|path| Scene::load(path, &[])).collect::<Result<_, _>>()?;
    // Wrong input anywhere is to cost no run.
    scenes.iter().try_for_each(run::check_study)?;
    let options = RunOptions { out: arguments.out, only: Vec::new(), resume: false, quiet: arguments.quiet };
    let (mut success, mut separator) = (true, "");
    for scene in &scenes {
        if run::INTERRUPTED.load(Ordering::Relaxed) {
            return Ok(false);
        }
        let report = run::bench(scene, &options)?;
        let folder = options.out.join("bench").join(&scene.name).display().to_string();
        print(&format!("{separator}{}", report.table(&folder)))?;
        success &= report.success();
        separator = "\n";
    }
    Ok(success)
}

fn execute_run(arguments: cli::Run) -> Result<bool, RunError> {
    prepare(arguments.threads)?;
    // All scenes are read before the first is run: an error in the last one should not cost an hour.
    let batches: Vec<(PathBuf, Vec<Scene>)> = (arguments.input.scenes.iter())
        .map(|path| Ok((run::results_folder(path, &arguments.out), Scene::load_all(path, &arguments.input.sets)?)))
        .collect::<Result<_, RunError>>()?;
    let mut folders: BTreeMap<PathBuf, &Scene> = BTreeMap::new();
    for (out, scene) in batches.iter().flat_map(|(out, scenes)| scenes.iter().map(move |scene| (out, scene))) {
        run::check(scene, &arguments.only)?;
        let folder = out.join(&scene.name);
        if let Some(other) = folders.get(&folder) {
            let (one, two, folder) = (other.path.display(), scene.path.display(), folder.display());
            return Err(RunError::Input(format!("{one} and {two} would both write to {folder}: rename one of them")));
        }
        folders.insert(folder, scene);
    }
    let mut success = true;
    for ((out, scenes), path) in batches.iter().zip(&arguments.input.scenes) {
        let options = RunOptions {
            out: out.clone(),
            only: arguments.only.clone(),
            resume: arguments.resume,
            quiet: arguments.quiet,
        };
        let mut cases = Vec::new();
        for scene in scenes {
            // A scene that is not begun keeps what an earlier run left of it.
            if run::INTERRUPTED.load(Ordering::Relaxed) {
                return Ok(false);
            }
            let summary = run::run(scene, &options)?;
            print(&summary.table(&out.join(&scene.name).display().to_string()))?;
            success &= summary.success();
            cases.push(run::Case::new(scene, &summary));
        }
        if path.is_dir() {
            print(&format!("\n{}", run::case_table(&cases)))?;
            run::store_cases(out, &cases)?;
        }
    }
    Ok(success)
}
