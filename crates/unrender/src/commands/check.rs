//! `unrender check`: what of a project would spoil its recovery.

use crate::check::{check, edge_picture, json, table};
use crate::global::Global;
use crate::{Error, Job, Project, interrupt, output};
use std::path::PathBuf;
use std::process::ExitCode;
use unrender_formats::picture;

/// Looks at a project before it is recovered, and says what to mend.
///
/// Prints a line a group: the pixels that show it, those that count and why others do not, the share
/// of it that gets light straight from a lamp, whether a highlight or a mirror image is there to tell
/// its roughness by, and whether it could have a texture. Then what looks wrong, with what to do:
/// the photo's response and exposure, the camera, units, lights, normals, edges that do not fit.
///
/// The picture shows the model's edges over the photo: green where the photo has them too, red where
/// it has them elsewhere and yellow there, blue where it shows none.
///
/// Ends with exit code 0 whatever it warns of, and with 1 only if the input cannot be used at all.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender check room/project.toml\n  \
    unrender check room/project.toml --out room/check.png --json")]
pub struct Args {
    /// The project file.
    pub project: PathBuf,
    /// The picture of the model's edges.
    #[arg(long, value_name = "FILE.png", default_value = "check.png")]
    pub out: PathBuf,
    /// Print JSON instead of a table.
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
/// If the input cannot be used or the picture cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    let (mut project, warnings) = Project::read(&args.project)?;
    project.limits = global.limits();
    output::check_inputs(&args.out, project.inputs())?;
    output::check_file(&args.out, &["png"], "end the name of the picture in .png")?;
    let mut job = Job::load(project, warnings)?;
    job.reduce();
    let checkup = check(&job);
    let drawn = edge_picture(&job.photo.radiance, &checkup.edges.points);
    let until_written = interrupt::writing();
    picture::write(&args.out, &drawn)?;
    drop(until_written);
    let text = if args.json {
        json(&checkup, &args.out)
            .map_err(|error| Error::Request(format!("the check cannot be written: {error}")))?
            + "\n"
    } else {
        table(&checkup, &args.out)
    };
    global.console.print(&text);
    Ok(ExitCode::SUCCESS)
}
