//! `unrender farm`: writes a rendering as a job for many machines.

mod job;
mod openjd;
mod slurm;

use super::render;
use crate::global::Global;
use crate::shell_word::quoted;
use crate::{Error, interrupt, output};
use clap::ValueEnum;
use job::Job;
use std::path::PathBuf;
use std::process::ExitCode;
use unrender_formats::{FileError, atomic};

/// Writes a job that renders a picture of `unrender render` on many machines.
///
/// Take a command line of `render`, replace `render` by `farm --to slurm` or `farm --to openjd`,
/// and state the samples by --spp. The samples are cut into parts; the last task merges the parts
/// to the same bits as on one machine. Every machine needs this command, in the same build, and
/// sees the files under the same paths.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender farm room.glb --spp 4096 --out room.exr --to slurm\n  \
    bash room_job/job.sh --cpus-per-task=16\n  \
    unrender farm --project room.toml --materials out --spp 4096 --out room.exr \\\n      \
    --to openjd --parts 64 --job room_job\n  \
    openjd run room_job/template.json -p file://room_job/parameters.json")]
// The flags of `render` are a group of the same name.
#[group(id = "farm")]
pub struct Args {
    /// The rendering.
    #[command(flatten)]
    pub render: render::Args,
    /// The program that distributes the work.
    #[arg(long, value_enum)]
    pub to: Target,
    /// The number of parts into which the samples are cut.
    // With eight machines, the others wait for the last one for at most half of their time; with half
    // as many parts, for all of it; with double, the scene is read twice as often.
    #[arg(long, value_name = "N", default_value_t = 16)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_PARTS)))]
    pub parts: u32,
    /// The folder for the job and its parts [default: the picture's name followed by _job].
    #[arg(long, value_name = "DIR")]
    pub job: Option<PathBuf>,
}

/// Slurm numbers the tasks of an array up to 1000 unless `MaxArraySize` was changed; Open Job
/// Description takes 1024 values. Half of it would limit farms of that size; double would be refused.
const MOST_PARTS: u16 = 1000;

/// Programs that distribute work over machines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// A job template of Open Job Description, 2023-09: template.json, and parameters.json with its
    /// input files.
    Openjd,
    /// A script that submits an array of jobs and a job that waits for it: job.sh.
    Slurm,
}

/// Runs the command.
///
/// # Errors
/// If the input cannot be rendered, or the job cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    if args.render.denoise {
        return Err(Error::Request(
            "the merged parts of a farm cannot be denoised; leave out --denoise".into(),
        ));
    }
    if args.render.layers || args.render.aov {
        let flag = if args.render.aov { "--aov" } else { "--layers" };
        return Err(Error::Request(format!(
            "the merged parts of a farm have no light layers; leave out {flag}"
        )));
    }
    if let Some(flag) = args.render.encoding.given() {
        return Err(Error::Request(format!(
            "the merged parts of a farm are written as they are; leave out {flag}"
        )));
    }
    render::check(&args.render, global)?;
    let folder = folder(args);
    let job = Job::new(&args.render, global, args.parts, &folder)?;
    let file = |name: &str| folder.join(name);
    let (files, start) = match args.to {
        Target::Openjd => {
            let (template, parameters) = openjd::template(&job)?;
            let (named, given) = (file("template.json"), file("parameters.json"));
            let values = quoted(&format!("file://{}", given.display()));
            let start = format!("openjd run {} -p {values}", quoted(&named.to_string_lossy()));
            (vec![(named, template), (given, parameters)], start)
        }
        Target::Slurm => {
            let script = file("job.sh");
            let start = format!("bash {}", quoted(&script.to_string_lossy()));
            (vec![(script, slurm::script(&job))], start)
        }
    };
    let _until_written = interrupt::writing();
    std::fs::create_dir_all(&folder)
        .map_err(|error| FileError::because(&folder, "cannot be made", error))?;
    for (path, text) in files {
        atomic::write(&path, text.as_bytes())?;
    }
    if !global.quiet {
        global.console.tell(&format!("{} parts; start them by: {start}", job.samples.len()));
    }
    Ok(ExitCode::SUCCESS)
}

/// The folder of the job.
fn folder(args: &Args) -> PathBuf {
    args.job.clone().unwrap_or_else(|| {
        let stem = args.render.out.file_stem().unwrap_or_default().to_string_lossy();
        output::folder(&args.render.out).join(format!("{stem}_job"))
    })
}
