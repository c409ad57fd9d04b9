//! `unrender recover`: from a project to the materials of its groups.

use crate::cli::{Global, warn};
use crate::engine::{self, RecoverSettings};
use crate::progress::Progress;
use crate::{Error, Job, Project, output};
use clap::ValueEnum;
use std::path::PathBuf;
use std::process::ExitCode;

/// Recovers the materials of a project's groups from its photograph.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  unrender recover room/project.toml --out room/result")]
pub struct Args {
    /// The project file.
    pub project: PathBuf,
    /// The folder for the results; made where it is missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// The ladder of hypotheses to climb.
    #[arg(long, value_enum, default_value_t = Ladder::Default)]
    pub ladder: Ladder,
    /// Chooses the noise of the renderings; the same seed gives the same bits.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Samples a pixel of the renderings [default: as many as the recovery finds useful].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
}

/// The ladders of hypotheses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Ladder {
    /// All parameters at once, by their derivatives and the noise.
    Default,
    /// The method of Boivin and Gagalowicz (2002) as written.
    Paper,
}

/// Runs the command.
///
/// # Errors
/// If the input cannot be used or the results cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    let (project, warnings) = Project::read(&args.project)?;
    output::prepare_folder(&args.out)?;
    let job = Job::load(project, warnings)?;
    warn(&job.warnings);
    let settings = RecoverSettings { ladder: args.ladder, seed: args.seed, spp: args.spp };
    let progress = Progress::new("recover", global.quiet);
    engine::recover(&job, &settings, &progress)?;
    drop(progress);
    Ok(ExitCode::SUCCESS)
}
