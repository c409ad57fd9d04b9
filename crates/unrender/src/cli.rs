//! The command line: global flags, the subcommands, and the handling of errors.

use crate::commands::{
    calibrate, check, completions, export, farm, fit_brdf, init, man, merge, merge_exposures, plan,
    recover, relight, render, report, restage, score, split, view,
};
pub use crate::global::Global;
use crate::listener::{Console, Listener};
use crate::{Error, interrupt, output};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser, Subcommand};
use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::process::ExitCode;
use std::sync::Arc;
use unrender_scene::Scene;

/// Recovers the reflectance of every surface of a known scene from one photograph.
#[derive(Debug, Parser)]
#[command(name = "unrender", version, about)]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

/// At most this many threads per core are started, but always up to `THREADS_ALWAYS` in all: more
/// only compete for memory and caches. Half and double of it change nothing that was measured.
const THREADS_A_CORE: usize = 4;
const THREADS_ALWAYS: usize = 16;

#[derive(Debug, Subcommand)]
enum Command {
    Init(init::Args),
    Recover(recover::Args),
    Calibrate(calibrate::Args),
    Check(check::Args),
    Render(render::Args),
    Merge(merge::Args),
    Relight(relight::Args),
    MergeExposures(merge_exposures::Args),
    FitBrdf(fit_brdf::Args),
    Farm(farm::Args),
    Plan(plan::Args),
    Restage(restage::Args),
    Score(score::Args),
    Split(split::Args),
    Export(export::Args),
    Report(report::Args),
    View(view::Args),
    Completions(completions::Args),
    Man(man::Args),
}

/// The command line as data: subcommands, flags, defaults and help, of which completions and manual
/// pages are made.
pub fn command() -> clap::Command {
    Cli::command()
}

/// Runs the command line that the process was started with.
pub fn run() -> ExitCode {
    run_from(std::env::args_os())
}

/// Runs the command line `words`, the first of which is the program's name.
pub fn run_from(words: impl IntoIterator<Item = OsString>) -> ExitCode {
    let words: Vec<OsString> = words.into_iter().collect();
    let cli = match Cli::try_parse_from(&words) {
        Ok(cli) => cli,
        Err(usage) => {
            let usage = with_hint(usage, &words);
            // Help and usage errors; the output may be closed.
            let _ = usage.print();
            return ExitCode::from(usage.exit_code() as u8);
        }
    };
    match prepare(&cli.global).and_then(|()| dispatch(&cli)) {
        Ok(code) => code,
        Err(error) => {
            tell(&error);
            ExitCode::FAILURE
        }
    }
}

/// Runs the command line `words`, without the program's name, as a function: its messages go to `listener`,
/// and signals stay with the caller. A `scene` in memory replaces the file that the words name
/// ([`Global::scene`]).
///
/// # Errors
/// If the words are not a valid command line, and those of the command.
pub fn call(
    words: impl IntoIterator<Item = OsString>,
    scene: Option<Arc<Scene>>,
    listener: Arc<dyn Listener>,
) -> Result<ExitCode, Error> {
    let mut cli = parse(words)?;
    cli.global.console = Console::new(listener);
    cli.global.scene = scene;
    dispatch(&cli)
}

/// The global flags and the arguments of one subcommand.
fn parse(words: impl IntoIterator<Item = OsString>) -> Result<Cli, Error> {
    let words: Vec<OsString> = std::iter::once("unrender".into()).chain(words).collect();
    Cli::try_parse_from(&words).map_err(|usage| {
        let text = with_hint(usage, &words).render().to_string();
        let text = text.strip_prefix("error: ").unwrap_or(&text);
        Error::Request(text.split("\n\n").next().unwrap_or(text).trim().to_owned())
    })
}

/// The error of the command line `words` with a hint if an unknown flag is a value of another one: `--effort draft` for
/// `--draft`.
fn with_hint(mut usage: clap::Error, words: &[OsString]) -> clap::Error {
    let unknown = match usage.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(flag)) if usage.kind() == ErrorKind::UnknownArgument => {
            flag.trim_start_matches('-').to_owned()
        }
        _ => return usage,
    };
    let command = Cli::command();
    let mut named = words.iter().filter_map(|word| command.find_subcommand(word));
    let Some(subcommand) = named.next() else { return usage };
    let flag = subcommand.get_arguments().find_map(|argument| {
        let values = argument.get_possible_values();
        let takes = values.iter().any(|value| value.matches(&unknown, false));
        argument.get_long().filter(|_| takes)
    });
    if let Some(flag) = flag {
        let meant = ContextValue::String(format!("--{flag} {unknown}"));
        usage.insert(ContextKind::SuggestedArg, meant);
    }
    usage
}

/// The global flags and the arguments of `render` in the command line `words`.
///
/// # Errors
/// If the words are not such a command line.
pub fn render_args(
    words: impl IntoIterator<Item = OsString>,
) -> Result<(Global, render::Args), Error> {
    match parse(words)? {
        Cli { global, command: Command::Render(args) } => Ok((global, args)),
        _ => Err(Error::Request("this is not a command line of render".into())),
    }
}

/// The global flags and the arguments of `recover` in the command line `words`.
///
/// # Errors
/// If the words are not such a command line.
pub fn recover_args(
    words: impl IntoIterator<Item = OsString>,
) -> Result<(Global, recover::Args), Error> {
    match parse(words)? {
        Cli { global, command: Command::Recover(args) } => Ok((global, args)),
        _ => Err(Error::Request("this is not a command line of recover".into())),
    }
}

fn prepare(global: &Global) -> Result<(), Error> {
    interrupt::install()?;
    if let Some(asked) = global.threads {
        let threads = helpful(asked.get());
        if threads < asked.get() {
            output::tell(&format!(
                "warning: --threads {asked} is more than can help; {threads} threads are used"
            ));
        }
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(|error| {
            Error::Request(format!("{threads} threads cannot be started: {error}"))
        })?;
    }
    Ok(())
}

/// As many threads as asked for, but no more than are useful.
fn helpful(asked: usize) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    asked.min(THREADS_ALWAYS.max(THREADS_A_CORE * cores))
}

/// The command, run by one of the threads that share its work: from outside of them each piece of work would be handed over,
/// and waited for.
fn dispatch(cli: &Cli) -> Result<ExitCode, Error> {
    rayon::scope(|_| match &cli.command {
        Command::Recover(args) => recover::run(args, &cli.global),
        Command::Init(args) => init::run(args, &cli.global),
        Command::Calibrate(args) => calibrate::run(args, &cli.global),
        Command::Check(args) => check::run(args, &cli.global),
        Command::Plan(args) => plan::run(args, &cli.global),
        Command::Render(args) => render::run(args, &cli.global),
        Command::Merge(args) => merge::run(args, &cli.global),
        Command::Relight(args) => relight::run(args, &cli.global),
        Command::MergeExposures(args) => merge_exposures::run(args, &cli.global),
        Command::FitBrdf(args) => fit_brdf::run(args, &cli.global),
        Command::Farm(args) => farm::run(args, &cli.global),
        Command::Restage(args) => restage::run(args, &cli.global),
        Command::Score(args) => score::run(args, &cli.global),
        Command::Split(args) => split::run(args, &cli.global),
        Command::Export(args) => export::run(args, &cli.global),
        Command::Report(args) => report::run(args, &cli.global),
        Command::View(args) => view::run(args, &cli.global),
        Command::Completions(args) => completions::run(args, Cli::command()),
        Command::Man(args) => man::run(args, &cli.global, Cli::command()),
    })
}

/// Prints `error` and its causes on stderr.
fn tell(error: &Error) {
    output::tell(&format!("error: {error}"));
    let mut cause = std::error::Error::source(error);
    while let Some(inner) = cause {
        output::tell(&format!("  because: {inner}"));
        cause = inner.source();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_that_cannot_help_are_not_started() {
        assert_eq!((helpful(1), helpful(7), helpful(16)), (1, 7, 16));
        assert!(helpful(100_000) < 100_000);
    }

    #[test]
    fn a_value_that_is_written_as_a_flag_is_hinted_at() {
        let said = |words: &str| {
            let words = ["unrender"].into_iter().chain(words.split(' '));
            let words: Vec<OsString> = words.map(OsString::from).collect();
            with_hint(Cli::try_parse_from(&words).unwrap_err(), &words).render().to_string()
        };
        for (flag, meant) in
            [("draft", "effort draft"), ("high", "effort high"), ("paper", "ladder paper")]
        {
            let text = said(&format!("recover room.toml --out out --{flag}"));
            assert!(text.contains(&format!("'--{meant}'")), "{text}");
        }
        assert!(!said("recover room.toml --out out --qqq").contains("similar argument"));
        // Other commands have no such option.
        assert!(!said("check room.toml --draft").contains("effort"));
    }

    #[test]
    fn the_command_line_is_consistent() {
        command().debug_assert();
    }
}
