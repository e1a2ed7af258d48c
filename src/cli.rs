//! The command line: what can be asked for. What is done about it is in `main.rs` and `run`.

use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Args, CommandFactory, Parser, Subcommand, ValueHint};
use clap_complete::Shell;

const EXAMPLES: &str = "\
Examples:
  hopfline new study --model two-doublet      write study.toml, a scene to start from
  hopfline check study.toml                   what would be computed; where the scene is wrong
  hopfline run study.toml                     compute; results go to output/study
  hopfline run study.toml --set parameters.L=14 --set 'task.beat.range=[0, 400]'
  hopfline run problems/*.toml --threads 2 --quiet
  hopfline run problems/extreme               a folder of scenes, and a table of what came out of each
  hopfline bench onset                        error against run time: the study problems/bench/onset.toml
  hopfline models two-doublet                 its parameters, units, defaults and observables

Exit codes:
  0  done
  1  a task failed, or a number that a scene expects was missed
  2  the input is wrong: a scene, an option, a file that cannot be read";

const SET_EXAMPLES: &str = "\
Examples of --set:
  --set parameters.L=14                       a number in the model's unit
  --set 'parameters.L={ value = 14000, unit = \"nm\" }'
  --set parameters.tau_c=tau/200              an expression
  --set model.functions=32                    an option of the model
  --set 'task.beat.range=[0, 400]'            tasks and figures by their names
  --set title=Longer

Numbers under [expect] hold for the scene as written: they are not checked when --set changes the
model or its parameters.

Exit codes: 0 done; 1 a task failed or an expected number was missed; 2 the input is wrong.";

/// Continuation and bifurcation of equilibria and cycles of M(u, p) u' = F(u, p)
#[derive(Clone, Debug, PartialEq, Parser)]
#[command(name = "hopfline", version, after_help = EXAMPLES, arg_required_else_help = true)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Clone, Debug, PartialEq, Subcommand)]
pub enum Command {
    /// Compute scenes: data and figures to files, a summary to stdout, progress to stderr
    #[command(after_help = SET_EXAMPLES)]
    Run(Run),
    /// Check scenes and print what would be computed and what is left out; compute nothing
    #[command(after_help = SET_EXAMPLES)]
    Check(Check),
    /// Run work-precision studies: scenes with a section [bench]; errors against seconds and unknowns
    Bench(Bench),
    /// List the models, or describe one: parameters with units, defaults and bounds, observables
    Models(Models),
    /// Draw the figures of a finished run again from its stored data
    Plot(Plot),
    /// Write the page of a folder of scenes, DIR/README.md, from the results of their last runs
    #[command(after_help = "Example:\n  hopfline run problems/*.toml && hopfline gallery problems")]
    Gallery(Gallery),
    /// Write NAME.toml, a commented scene to start from
    New(New),
    /// Rewrite a model of XPPAUT (FILE.ode) as a scene
    #[command(after_help = "Example:\n  hopfline import lorenz.ode --out lorenz.toml")]
    Import(Import),
    /// Print a completion script for a shell
    #[command(
        after_help = "Example:\n  hopfline completions bash > ~/.local/share/bash-completion/completions/hopfline"
    )]
    Completions(Completions),
}

/// Scenes, and values laid over them.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct Scenes {
    /// Scene files (TOML), or folders of them: a suite, with a table of what came out of each
    #[arg(value_name = "SCENE", required = true, value_hint = ValueHint::FilePath)]
    pub scenes: Vec<PathBuf>,
    /// Override one value of every scene given, for instance parameters.L=14; repeat for more
    #[arg(long = "set", value_name = "KEY=VALUE", value_hint = ValueHint::Other)]
    pub sets: Vec<String>,
}

#[derive(Clone, Debug, PartialEq, Args)]
pub struct Run {
    #[command(flatten)]
    pub input: Scenes,
    /// Compute only this task and those that it starts from; repeat for more
    #[arg(long, value_name = "TASK", value_hint = ValueHint::Other)]
    pub only: Vec<String>,
    /// Folder for the results; each scene gets a folder of its own in it
    #[arg(long, value_name = "DIR", default_value = "output", value_hint = ValueHint::DirPath)]
    pub out: PathBuf,
    /// Go on from what an interrupted run left in the folder for the results
    #[arg(long)]
    pub resume: bool,
    /// Threads to use; results do not depend on it [default: one per core]
    #[arg(long, value_name = "N", value_hint = ValueHint::Other)]
    pub threads: Option<NonZeroUsize>,
    /// Show no progress; errors and the summary remain
    #[arg(long)]
    pub quiet: bool,
}

#[derive(Clone, Debug, PartialEq, Args)]
pub struct Check {
    #[command(flatten)]
    pub input: Scenes,
}

#[derive(Clone, Debug, PartialEq, Args)]
pub struct Bench {
    /// Studies, by the names of their scenes in problems/bench or by paths (FILE.toml); without one, all in that folder
    #[arg(value_name = "NAME", value_hint = ValueHint::FilePath)]
    pub names: Vec<String>,
    /// Folder for the results, which go to bench/NAME in it
    #[arg(long, value_name = "DIR", default_value = "output", value_hint = ValueHint::DirPath)]
    pub out: PathBuf,
    /// Threads to use; results do not depend on it [default: one per core]
    #[arg(long, value_name = "N", value_hint = ValueHint::Other)]
    pub threads: Option<NonZeroUsize>,
    /// Show no progress; errors and tables remain
    #[arg(long)]
    pub quiet: bool,
}

#[derive(Clone, Debug, PartialEq, Args)]
pub struct Models {
    /// Model to describe; without it, all are listed
    #[arg(value_hint = ValueHint::Other)]
    pub name: Option<String>,
}

#[derive(Clone, Debug, PartialEq, Args)]
pub struct Plot {
    /// Folder of one finished scene, such as output/two-doublet
    #[arg(value_hint = ValueHint::DirPath)]
    pub dir: PathBuf,
}

#[derive(Clone, Debug, PartialEq, Args)]
pub struct Gallery {
    /// Folder of scenes
    #[arg(value_hint = ValueHint::DirPath)]
    pub dir: PathBuf,
    /// Folder that the results of runs are in; the figures of the page go to `gallery` in it
    #[arg(long, value_name = "DIR", default_value = "output", value_hint = ValueHint::DirPath)]
    pub out: PathBuf,
}

#[derive(Clone, Debug, PartialEq, Args)]
pub struct New {
    /// Name of the scene; the file is NAME.toml
    #[arg(value_hint = ValueHint::Other)]
    pub name: String,
    /// Model that the scene is about (`hopfline models` lists them)
    #[arg(long, value_name = "M", value_hint = ValueHint::Other)]
    pub model: String,
}

#[derive(Clone, Debug, PartialEq, Args)]
pub struct Import {
    /// The file to read
    #[arg(value_name = "FILE.ode", value_hint = ValueHint::FilePath)]
    pub file: PathBuf,
    /// Scene to write, which must not exist yet; without it, to stdout
    #[arg(long, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    pub out: Option<PathBuf>,
}

#[derive(Clone, Debug, PartialEq, Args)]
pub struct Completions {
    pub shell: Shell,
}

/// Writes a completion script to stdout. A reader that stops early (`| head`) is no error.
pub fn completions(shell: Shell) -> io::Result<()> {
    // To memory first: clap_complete panics where the writer fails.
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "hopfline", &mut script);
    let mut stdout = io::stdout().lock();
    match stdout.write_all(&script).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::error::ErrorKind;

    fn parse(line: &str) -> Result<Command, clap::Error> {
        Cli::try_parse_from(line.split_whitespace()).map(|cli| cli.command)
    }

    #[test]
    fn definitions_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn run_takes_scenes_and_overrides_in_any_order() {
        let line = "hopfline run a.toml --set parameters.L=14 b.toml --set task.beat.range=[-1,4] --only beat --resume --threads 2";
        let expected = Run {
            input: Scenes {
                scenes: vec!["a.toml".into(), "b.toml".into()],
                sets: vec!["parameters.L=14".into(), "task.beat.range=[-1,4]".into()],
            },
            only: vec!["beat".into()],
            out: "output".into(),
            resume: true,
            threads: NonZeroUsize::new(2),
            quiet: false,
        };
        assert_eq!(parse(line).expect("valid"), Command::Run(expected));
    }

    #[test]
    fn the_other_commands_are_read() {
        for (line, expected) in [
            (
                "hopfline bench onset --quiet",
                Command::Bench(Bench { names: vec!["onset".into()], out: "output".into(), threads: None, quiet: true }),
            ),
            ("hopfline models", Command::Models(Models { name: None })),
            ("hopfline models beck", Command::Models(Models { name: Some("beck".into()) })),
            ("hopfline plot output/a", Command::Plot(Plot { dir: "output/a".into() })),
            ("hopfline new a --model beck", Command::New(New { name: "a".into(), model: "beck".into() })),
            ("hopfline completions zsh", Command::Completions(Completions { shell: Shell::Zsh })),
        ] {
            assert_eq!(parse(line).expect(line), expected);
        }
        let Ok(Command::Check(check)) = parse("hopfline check a.toml --set title=b") else {
            panic!("check is a command");
        };
        assert_eq!(check.input.sets, ["title=b"]);
    }

    #[test]
    fn wrong_input_exits_with_2() {
        for (line, kind) in [
            ("hopfline run", ErrorKind::MissingRequiredArgument),
            ("hopfline check", ErrorKind::MissingRequiredArgument),
            ("hopfline new a", ErrorKind::MissingRequiredArgument),
            ("hopfline run a.toml --threads 0", ErrorKind::ValueValidation),
            ("hopfline run a.toml --treads 2", ErrorKind::UnknownArgument),
            ("hopfline rum a.toml", ErrorKind::InvalidSubcommand),
            ("hopfline completions cmd", ErrorKind::InvalidValue),
            ("hopfline", ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand),
        ] {
            let error = parse(line).expect_err(line);
            assert_eq!((error.kind(), error.exit_code()), (kind, 2), "{line}");
        }
    }

    #[test]
    fn help_shows_examples_and_exit_codes() {
        let help = parse("hopfline --help").expect_err("help is an early exit");
        assert_eq!(help.exit_code(), 0);
        let help = help.to_string();
        assert!(help.contains("hopfline run study.toml") && help.contains("Exit codes"), "{help}");
    }
}
