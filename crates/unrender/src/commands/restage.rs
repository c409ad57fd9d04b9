//! `unrender restage`: new pictures of a recovered scene, and the change put into the photograph.

use super::render::size;
use crate::cli::{Global, warn};
use crate::edit::{Composite, Flag, Photograph, Restaging, Sheet, View};
use crate::progress::Progress;
use crate::results::restaged;
use crate::{Error, interrupt, output};
use std::path::PathBuf;
use std::process::ExitCode;
use unrender_render::Settings;
use unrender_render::path::MAX_BOUNCES;
use unrender_restage::composite::Gain;
use unrender_restage::pair;
use unrender_scene::Warnings;

/// Renders a recovered scene with edits, or puts them into its photograph.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender restage edit.toml --out new\n  \
    unrender restage edit.toml --composite --spp 256 --out new\n  \
    unrender restage --recovered out --project room.toml --remove sofa --composite --out new\n  \
    unrender restage --scene room.glb --repaint 'floor: rho_d = [0.5, 0.1, 0.1]' \\\n      \
    --light 'lamp: scale = 0.5' --insert 'pot.glb: on = \"table\", at = [0.2, -1]' --out new\n\n\
    docs/restage.md says what an edit file may have.")]
pub struct Args {
    /// The edit file.
    pub edits: Option<PathBuf>,
    /// The folder for the pictures; made where it is missing.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Put the change into the photograph, and leave the rest of it as it is.
    #[arg(long)]
    pub composite: bool,
    /// Give what is synthetic in the composite the noise of the photograph.
    #[arg(long, requires = "composite")]
    pub grain: bool,
    /// Start from the folder of a recovery.
    #[arg(long, value_name = "DIR")]
    pub recovered: Option<String>,
    /// The project that was recovered, for its photograph.
    #[arg(long, value_name = "FILE.toml")]
    pub project: Option<String>,
    /// Start from a scene file.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<String>,
    /// Materials to put onto the scene's groups.
    #[arg(long, value_name = "FILE.json")]
    pub materials: Option<String>,
    /// Take away an object or all objects of a group.
    #[arg(long, value_name = "NAME")]
    pub remove: Vec<String>,
    /// Change how a group reflects: 'GROUP: rho_d = [0.5, 0.1, 0.1]'.
    #[arg(long, value_name = "EDIT")]
    pub repaint: Vec<String>,
    /// Change, move, add or remove a light: 'NAME: scale = 0.5'.
    #[arg(long, value_name = "EDIT")]
    pub light: Vec<String>,
    /// Put a model into the scene: 'FILE: on = "GROUP", at = [x, z]'.
    #[arg(long, value_name = "EDIT")]
    pub insert: Vec<String>,
    /// The scene's camera to look through [default: the photograph's].
    #[arg(long, value_name = "NAME", conflicts_with = "composite")]
    pub camera: Option<String>,
    /// Pixels in a row [default: the photograph's].
    #[arg(long, value_name = "N", conflicts_with = "composite")]
    pub width: Option<usize>,
    /// Rows [default: the photograph's].
    #[arg(long, value_name = "N", conflicts_with = "composite")]
    pub height: Option<usize>,
    /// Samples a pixel.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// Chooses the noise; the same seed gives the same bits.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// The most reflections of a path [default: until it carries nothing more].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub bounces: Option<u32>,
}

/// Runs the command.
///
/// # Errors
/// If the input cannot be used, an edit does not fit the scene, or the pictures cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    let restaging = Restaging::load(&sheets(args)?)?;
    let photograph = photograph(args, &restaging)?;
    output::prepare_folder(&args.out)?;
    warn(&restaging.warnings);
    let max_bounces = args.bounces.unwrap_or(MAX_BOUNCES);
    let settings = Settings { spp: args.spp, seed: args.seed, max_bounces };
    let bad = match photograph {
        Some(photograph) => composite(args, global, &restaging, photograph, &settings)?,
        None => synthetic(args, global, &restaging, &settings)?,
    };
    if bad > 0 {
        let mut warnings = Warnings::default();
        warnings.push(format!("{bad} value(s) were not finite numbers and were written as zero"));
        warn(&warnings);
    }
    Ok(ExitCode::SUCCESS)
}

/// The edit file, and behind it the flags.
fn sheets(args: &Args) -> Result<Vec<Sheet>, Error> {
    let file = args.edits.iter().map(|path| Ok(Sheet::read(path)?));
    let flags = [
        (Flag::Recovered, args.recovered.as_slice()),
        (Flag::Project, args.project.as_slice()),
        (Flag::Scene, args.scene.as_slice()),
        (Flag::Materials, args.materials.as_slice()),
        (Flag::Remove, &args.remove),
        (Flag::Repaint, &args.repaint),
        (Flag::Light, &args.light),
        (Flag::Insert, &args.insert),
        (Flag::Camera, args.camera.as_slice()),
    ];
    let flags = flags
        .into_iter()
        .flat_map(|(flag, values)| values.iter().map(move |value| Sheet::of_flag(flag, value)));
    file.chain(flags).collect()
}

/// The photograph that the change goes into, if that is asked for.
fn photograph<'a>(args: &Args, restaging: &'a Restaging) -> Result<Option<&'a Photograph>, Error> {
    if !args.composite {
        return Ok(None);
    }
    if let View::Other(_, place) | View::Sequence(_, place) = &restaging.view
        && restaging.start.photograph.is_some()
    {
        return Err(Error::Request(format!(
            "{place}: a composite is seen by the photograph's camera; leave out the camera or \
             --composite"
        )));
    }
    restaging.start.photograph.as_ref().map(Some).ok_or_else(|| {
        Error::Request("--composite needs the photograph: give project = \"PROJECT.toml\"".into())
    })
}

fn composite(
    args: &Args,
    global: &Global,
    restaging: &Restaging,
    photograph: &Photograph,
    settings: &Settings,
) -> Result<usize, Error> {
    let progress = Progress::new("restage", global.quiet);
    let (camera, size) = (&photograph.camera, photograph.size());
    let told = |share: f64| progress.set(share);
    let paired = pair::render(&restaging.scenes(), camera, size, settings, &told);
    drop(progress);
    let grain = args.grain.then_some(args.seed);
    let composite = Composite::new(restaging, photograph, paired, Gain::Auto, grain);
    let _until_written = interrupt::writing();
    Ok(restaged::write_composite(&composite, photograph, &args.out)?)
}

fn synthetic(
    args: &Args,
    global: &Global,
    restaging: &Restaging,
    settings: &Settings,
) -> Result<usize, Error> {
    let photograph = restaging.start.photograph.as_ref();
    let cameras = restaging.view.cameras();
    let progress = Progress::new("restage", global.quiet);
    let tracer = unrender_render::Tracer::new(&restaging.after);
    let materials = restaging.after.materials();
    let mut bad = 0;
    for (index, camera) in cameras.iter().enumerate() {
        let size = match (args.width, args.height, photograph) {
            (None, None, Some(photograph)) => photograph.size(),
            (width, height, _) => size(width, height, camera)?,
        };
        let told = |share: f64| progress.set((index as f64 + share) / cameras.len() as f64);
        let rendered = tracer.render(&materials, camera, size, settings, &told).mean;
        let number = (cameras.len() > 1).then_some(index + 1);
        let _until_written = interrupt::writing();
        bad += restaged::write_synthetic(&rendered, photograph, &args.out, number)?;
    }
    Ok(bad)
}
