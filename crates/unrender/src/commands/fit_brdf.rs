//! `unrender fit-brdf`: from a measured BRDF to the material of a group.

use crate::global::Global;
use crate::measured::{document, known, materials, spheres, table};
use crate::{Error, interrupt, output};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use unrender_formats::{FileError, Input, atomic, merl, picture};
use unrender_measured::{Form, chosen, fit};
use unrender_scene::BrdfModel;

/// Fits the materials of this program to a measured BRDF.
///
/// FILE.binary is a table of MERL's database. Each kind of material is fitted to it: a diffuse surface, lobes of Ward and
/// GGX over a diffuse base, plastics and metals. A star marks the simplest that fits as well as any; its lines for a project
/// file are printed below the table.
///
/// `error` is the root mean square difference of the cube roots of reflected light, sr^(-1/3), which is minimised; `light off`
/// is that of the light itself, as a share of it, where highlights decide. Directions beyond 80 degrees are left out.
///
/// A folder gets fits.json, known.toml, materials.json (for --materials) and fits.png: in the order of the table a row of
/// spheres each, measured, fitted, and their difference over grey.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender fit-brdf gold-metallic-paint.binary\n  \
    unrender fit-brdf gold-metallic-paint.binary --model ggx --group car --out car\n  \
    unrender fit-brdf gold-metallic-paint.binary --json")]
pub struct Args {
    /// The measured BRDF, in MERL's binary format.
    #[arg(value_name = "FILE.binary")]
    pub file: PathBuf,
    /// Fit this BRDF model alone [default: all]: principled, ggx, ward-gmd, ward-1992 or ward-duer.
    #[arg(long, value_name = "NAME", value_parser = model)]
    pub model: Option<BrdfModel>,
    /// The group that has the material [default: the name of the file].
    #[arg(long, value_name = "NAME")]
    pub group: Option<String>,
    /// A folder for the fits and their picture, or a file for the fits alone (.json).
    #[arg(long, value_name = "FOLDER|FILE.json")]
    pub out: Option<PathBuf>,
    /// Print JSON instead of columns.
    #[arg(long)]
    pub json: bool,
}

fn model(name: &str) -> Result<BrdfModel, String> {
    name.parse()
}

/// Runs the command.
///
/// # Errors
/// If the table cannot be read or has too few measured cells, or the results cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    let single = args.out.as_deref().filter(|out| output::extension(out) == "json");
    match (&args.out, single) {
        (Some(out), Some(_)) => {
            output::check_file(out, &["json"], "end --out in .json")?;
            output::check_inputs(out, [args.file.as_path()])?;
        }
        (Some(out), None) => output::prepare_folder(out)?,
        (None, _) => {}
    }
    let measured = merl::read(Input::new(&args.file, global.limits()))?;
    let fits = fit(&measured, &Form::of(args.model))
        .map_err(|error| FileError::because(&args.file, "cannot be fitted", error))?;
    let best = chosen(&fits).and_then(|fit| fits.iter().position(|other| other == fit));
    let best = best.unwrap_or_default();
    let group = args.group.clone().unwrap_or_else(|| stem(&args.file));
    let project = known(&fits[best], &group);
    let document =
        document(args.file.display().to_string(), &measured, (&fits, best), project.clone());
    let json = serde_json::to_string_pretty(&document)
        .map_err(|error| Error::Request(format!("the fits cannot be written: {error}")))?
        + "\n";
    let _until_written = interrupt::writing();
    match (&args.out, single) {
        (_, Some(file)) => atomic::write(file, json.as_bytes())?,
        (Some(folder), None) => {
            atomic::write(&folder.join("fits.json"), json.as_bytes())?;
            atomic::write(&folder.join("known.toml"), project.as_bytes())?;
            unrender_formats::materials::write(
                &folder.join("materials.json"),
                &materials(&fits[best], &group),
            )?;
            picture::write_png_srgb(&folder.join("fits.png"), &spheres(&measured, &fits))?;
        }
        (None, None) => {}
    }
    if args.json {
        global.console.print(&json);
    } else {
        let star =
            "* the simplest whose error is at most 2 % above the least; in a project file:\n\n";
        global.console.print(&format!("{}{star}{project}", table(&fits, best)));
    }
    Ok(ExitCode::SUCCESS)
}

/// The name of the file at `path`, without its extension.
fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
