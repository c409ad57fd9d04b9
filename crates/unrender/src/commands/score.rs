//! `unrender score`: recovered materials against the truth.

use crate::global::Global;
use crate::score::{
    Certainty, GroupScore, LightScore, Limits, Worst, certainty, score, score_lights, table, worst,
};
use crate::{Error, result_folder};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use unrender_formats::{Input, materials};

/// Compares the materials of a recovery with known ones.
///
/// Diffuse reflectances are compared as lit and seen at normal incidence (albedo_d), so that plastics, whose rho_d is that of the
/// base, and matt groups can be compared.
/// Groups whose status is known or assumed are shown in brackets and not counted. A lobe and the
/// same lobe with its alphas swapped and turned by 90 degrees are one. Where the results state
/// standard deviations, a second table has the error of every parameter in their units. With a limit,
/// the exit code is 1 if it is exceeded, a hypothesis is wrong or a number is missing.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
    unrender score result truth.json --max-rho 0.005 --max-alpha-percent 2 --max-degrees 0.5")]
pub struct Args {
    /// The folder of the results, or its materials.json.
    pub results: PathBuf,
    /// The true materials, in the format of materials.json.
    pub truth: PathBuf,
    /// The largest good error of rho_d and rho_s.
    #[arg(long, value_name = "X")]
    pub max_rho: Option<f64>,
    /// The largest good error of alpha_x and alpha_y, percent.
    #[arg(long, value_name = "X")]
    pub max_alpha_percent: Option<f64>,
    /// The largest good error of the anisotropy direction, degrees.
    #[arg(long, value_name = "X")]
    pub max_degrees: Option<f64>,
    /// Print JSON instead of columns.
    #[arg(long)]
    pub json: bool,
}

#[derive(Serialize)]
struct Json<'a> {
    groups: &'a [GroupScore],
    lights: &'a [LightScore],
    worst: &'a Worst,
    certainty: Option<Certainty>,
    exceeded: &'a [String],
}

/// Runs the command.
///
/// # Errors
/// If a file cannot be read.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    let path = result_folder::materials(&args.results)?;
    let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_owned();
    let (results, truth) = (
        materials::read(Input::new(&path, global.limits()))?,
        materials::read(Input::new(&args.truth, global.limits()))?,
    );
    let scores = score(&results, &folder(&path), &truth, &folder(&args.truth))?;
    let lights = score_lights(&results, &truth);
    let (worst, certainty) = (worst(&scores), certainty(&scores, &lights));
    let limits = Limits {
        rho: args.max_rho,
        alpha_percent: args.max_alpha_percent,
        degrees: args.max_degrees,
    };
    let exceeded = if limits.any() { limits.exceeded(&scores) } else { Vec::new() };
    if args.json {
        let (groups, lights, worst, exceeded) = (&scores, &lights, &worst, &exceeded);
        let json = Json { groups, lights, worst, certainty, exceeded };
        let text = serde_json::to_string_pretty(&json)
            .map_err(|error| Error::Request(format!("the scores cannot be written: {error}")))?;
        global.console.print(&(text + "\n"));
    } else {
        let tables = [
            Some(table::table(&scores, &worst)),
            Some(table::lights(&lights)).filter(|text| !text.is_empty()),
            certainty.map(|certainty| table::parameters(&scores, &lights, &certainty)),
        ];
        global.console.print(&tables.into_iter().flatten().collect::<Vec<_>>().join("\n"));
    }
    exceeded.iter().for_each(|fault| global.console.tell(&format!("error: {fault}")));
    Ok(if exceeded.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
