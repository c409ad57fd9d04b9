//! `unrender check`: finds what would spoil the recovery of a project.

use crate::check::{Checkup, check, edge_picture, flux, json, table};
use crate::global::Global;
use crate::{Error, Job, Project, interrupt, output};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use unrender_formats::picture;
use unrender_scene::{RgbImage, Warnings};

/// Checks a project before it is recovered, and says what to mend.
///
/// Prints one line per group: the pixels that show it, those that are valid and why others are not,
/// the share of it that gets light straight from a lamp, whether a highlight or a mirror image shows
/// its roughness, and whether it could have a texture. Then what looks wrong, with what to do: the
/// photo's response and exposure, the camera, units, lights, normals, edges that do not fit.
///
/// Several photographs are checked one by one, each with a picture: NAME.png, NAME_2.png and so on.
///
/// The picture shows the model's edges over the photo: green where the photo has them too, red where
/// it has them elsewhere and yellow there, blue where it shows none.
///
/// The exit code is 0 whatever it warns of, and 1 only if the input cannot be used at all.
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
    let mut checked = Vec::with_capacity(job.photographs());
    for k in 0..job.photographs() {
        let mut alone = job.alone(k);
        if k > 0 {
            // Warnings of the whole project are given once.
            alone.to_mut().warnings = Warnings::default();
        }
        let checkup = check(&alone);
        let drawn = edge_picture(&alone.photo.radiance, &checkup.edges.points);
        checked.push((numbered(&args.out, k), checkup, drawn));
    }
    let until_written = interrupt::writing();
    for (path, _, drawn) in &checked {
        picture::write(path, drawn)?;
    }
    drop(until_written);
    global.console.print(&text(args, &job, &checked)?);
    Ok(ExitCode::SUCCESS)
}

/// The name of the picture of photograph number `k`: as given for the first, with a number for the others.
fn numbered(path: &Path, k: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    if k == 0 { path.to_owned() } else { path.with_file_name(format!("{stem}_{}.png", k + 1)) }
}

/// The printed text of all checks.
fn text(args: &Args, job: &Job, checked: &[(PathBuf, Checkup, RgbImage)]) -> Result<String, Error> {
    if !args.json {
        let one = |(k, (path, checkup, _)): (usize, &(PathBuf, Checkup, RgbImage))| {
            let name = job.called(k);
            let heading = if name.is_empty() {
                name
            } else {
                format!("{}{name}\n", if k > 0 { "\n" } else { "" })
            };
            format!("{heading}{}", table(checkup, path))
        };
        let tables: String = checked.iter().enumerate().map(one).collect();
        return Ok(tables + &flux(job));
    }
    as_json(checked)
        .map(|text| text + "\n")
        .map_err(|error| Error::Request(format!("the check cannot be written: {error}")))
}

/// The first photograph's check; those of further ones stand in it as `further`.
fn as_json(checked: &[(PathBuf, Checkup, RgbImage)]) -> Result<String, serde_json::Error> {
    let mut each = checked.iter().map(|(path, checkup, _)| json(checkup, path));
    let first = each.next().transpose()?.unwrap_or_default();
    let further =
        each.map(|text| serde_json::from_str(&text?)).collect::<Result<Vec<Value>, _>>()?;
    if further.is_empty() {
        return Ok(first);
    }
    let mut all: Value = serde_json::from_str(&first)?;
    all["further"] = further.into();
    serde_json::to_string_pretty(&all)
}
