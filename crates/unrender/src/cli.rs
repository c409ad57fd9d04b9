//! The command line: global flags, the subcommands, and what becomes of errors.

use crate::commands::{calibrate, check, export, merge, recover, render, report, restage, score};
use crate::{Error, interrupt};
use clap::{Parser, Subcommand};
use std::num::NonZeroUsize;
use std::process::ExitCode;
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
}

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
    if let Some(threads) = global.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build_global().map_err(
            |error| Error::Request(format!("{threads} threads cannot be started: {error}")),
        )?;
    }
    Ok(())
}

fn dispatch(cli: &Cli) -> Result<ExitCode, Error> {
    match &cli.command {
        Command::Recover(args) => recover::run(args, &cli.global),
        Command::Calibrate(args) => calibrate::run(args, &cli.global),
        Command::Check(args) => check::run(args),
        Command::Render(args) => render::run(args, &cli.global),
        Command::Merge(args) => merge::run(args, &cli.global),
        Command::Restage(args) => restage::run(args, &cli.global),
        Command::Score(args) => score::run(args),
        Command::Export(args) => export::run(args, &cli.global),
        Command::Report(args) => report::run(args, &cli.global),
    }
}

/// Prints `warnings` on stderr, one a line.
pub(crate) fn warn(warnings: &Warnings) {
    for warning in &warnings.0 {
        eprintln!("warning: {warning}");
    }
}

/// Prints `error` and its causes on stderr.
fn tell(error: &Error) {
    eprintln!("error: {error}");
    let mut cause = std::error::Error::source(error);
    while let Some(inner) = cause {
        eprintln!("  because: {inner}");
        cause = inner.source();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
