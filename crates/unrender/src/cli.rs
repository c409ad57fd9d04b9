//! The command line: global flags, the subcommands, and what becomes of errors.

use crate::commands::{
    calibrate, check, completions, export, man, merge, recover, render, report, restage, score,
};
use crate::{Error, interrupt, output};
use clap::{CommandFactory, Parser, Subcommand};
use std::num::NonZeroUsize;
use std::process::ExitCode;
use unrender_formats::Limits;
use unrender_scene::Warnings;

/// Recovers the reflectance of every surface of a known scene from one photograph.
#[derive(Debug, Parser)]
#[command(name = "unrender", version, about)]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

/// Flags of all subcommands.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Global {
    /// Show no progress; errors and warnings are still told.
    #[arg(long, global = true)]
    pub quiet: bool,
    /// Use this many threads [default: one a core]; the results do not depend on it.
    #[arg(long, global = true, value_name = "N")]
    pub threads: Option<NonZeroUsize>,
    /// Let scenes and materials name files outside their folder, too.
    #[arg(long, global = true)]
    pub allow_outside: bool,
    /// The memory that a scene or a picture may take while it is read, GiB [default: 2].
    #[arg(long, global = true, value_name = "GIB", value_parser = gibibytes)]
    pub input_memory: Option<f64>,
}

impl Global {
    /// How far the reading of inputs may go.
    pub(crate) fn limits(&self) -> Limits {
        let memory = self.input_memory.map(|gib| (gib * f64::from(1 << 30)) as u64);
        Limits { outside: self.allow_outside, memory: memory.unwrap_or(Limits::default().memory) }
    }
}

fn gibibytes(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|gib: &f64| gib.is_finite() && *gib > 0.0);
    number.ok_or_else(|| "is no positive number".into())
}

/// So many threads a core are believed to help, and always this many in all: more only fight for
/// memory and caches. Half and double of it change nothing that was measured.
const THREADS_A_CORE: usize = 4;
const THREADS_ALWAYS: usize = 16;

#[derive(Debug, Subcommand)]
enum Command {
    Recover(recover::Args),
    Calibrate(calibrate::Args),
    Check(check::Args),
    Render(render::Args),
    Merge(merge::Args),
    Restage(restage::Args),
    Score(score::Args),
    Export(export::Args),
    Report(report::Args),
    Completions(completions::Args),
    Man(man::Args),
}

/// The definition of the command line, of which help, completions and manual pages are made.
pub fn command() -> clap::Command {
    Cli::command()
}

/// Runs the command line that the process was started with.
pub fn run() -> ExitCode {
    let cli = Cli::parse();
    match prepare(&cli.global).and_then(|()| dispatch(&cli)) {
        Ok(code) => code,
        Err(error) => {
            tell(&error);
            ExitCode::FAILURE
        }
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

/// As many threads as asked for, but no more than can help.
fn helpful(asked: usize) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    asked.min(THREADS_ALWAYS.max(THREADS_A_CORE * cores))
}

fn dispatch(cli: &Cli) -> Result<ExitCode, Error> {
    match &cli.command {
        Command::Recover(args) => recover::run(args, &cli.global),
        Command::Calibrate(args) => calibrate::run(args, &cli.global),
        Command::Check(args) => check::run(args, &cli.global),
        Command::Render(args) => render::run(args, &cli.global),
        Command::Merge(args) => merge::run(args, &cli.global),
        Command::Restage(args) => restage::run(args, &cli.global),
        Command::Score(args) => score::run(args, &cli.global),
        Command::Export(args) => export::run(args, &cli.global),
        Command::Report(args) => report::run(args, &cli.global),
        Command::Completions(args) => completions::run(args),
        Command::Man(args) => man::run(args, &cli.global),
    }
}

/// Prints `warnings` on stderr, one a line.
pub(crate) fn warn(warnings: &Warnings) {
    for warning in &warnings.0 {
        output::tell(&format!("warning: {warning}"));
    }
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
    fn the_command_line_is_consistent() {
        command().debug_assert();
    }
}
