//! `unrender restage`: new pictures of a recovered scene, and the change put into the photograph.

use super::render::{check_denoise, size};
use super::sampling::{self, SamplingArgs};
use crate::Error;
use crate::check::capitalised;
use crate::edit::{Composite, EditSheet, Flag, Photograph, Restaging, View};
use crate::global::Global;
use crate::output::Encoding;
use crate::progress::Progress;
use crate::progressive::{self, Job};
use crate::progressive_render::{CompositeRender, PictureRender};
use crate::result_folder::ResultFolder;
use crate::results::restaged::{self, Beside, Restaged, Synthetic};
use crate::shard::{self, Identity};
use serde::Serialize;
use std::ops::{ControlFlow, Range};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use unrender_formats::LightUnits;
use unrender_formats::picture::ColourSpace;
use unrender_render::Accumulator;
use unrender_restage::composite::{Gain, How};
use unrender_restage::pair::Pairing;
use unrender_scene::{Camera, Warnings};

/// Renders a recovered scene with edits, or composites them into its photograph.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender restage edit.toml --out new\n  \
    unrender restage edit.toml --composite --spp 256 --out new\n  \
    unrender restage --recovered out --project room.toml --remove sofa --composite --out new\n  \
    unrender restage --scene room.glb --repaint 'floor: rho_d = [0.5, 0.1, 0.1]' \\\n      \
    --light 'lamp: scale = 0.5' --insert 'pot.glb: on = \"table\", at = [0.2, -1]' --out new\n\n\
    An edit file (docs/reference/edit.md has all of it):\n  \
    recovered = \"out\"              # the folder of a recovery\n  \
    project = \"room.toml\"          # its project, for the photograph\n  \
    [camera]                       # eye and target, or [[camera.keys]] and frames\n  \
    [[remove]]                     # name\n  \
    [[repaint]]                    # group, rho_d, rho_s, alpha, texture\n  \
    [[lights]]                     # name, scale, strength, move, direction, add, remove\n  \
    [environment]                  # file, rotation_deg, scale\n  \
    [[insert]]                     # file, name; position, or on and at, or pixel; rotation_deg, scale")]
pub struct Args {
    /// The edit file.
    pub edits: Option<PathBuf>,
    /// The folder for the pictures: a new one, or one with results of unrender.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Composite the change into the photograph, and leave the rest of it as it is.
    #[arg(long)]
    pub composite: bool,
    /// Add the noise of the photograph to the synthetic parts of the composite.
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
    /// The units of a glTF file's lights: blender-standard, unitless, blender-raw or radiometric
    /// [default: as its generator writes them].
    #[arg(long, value_name = "UNITS")]
    pub light_units: Option<LightUnits>,
    /// Materials to apply to the scene's groups: a file, or a folder with the results of `recover`.
    #[arg(long, value_name = "FILE.json|FILE.mtlx|DIR")]
    pub materials: Option<String>,
    /// Remove an object or all objects of a group.
    #[arg(long, value_name = "NAME")]
    pub remove: Vec<String>,
    /// Change the reflectance of a group: 'GROUP: rho_d = [0.5, 0.1, 0.1]'.
    #[arg(long, value_name = "EDIT")]
    pub repaint: Vec<String>,
    /// Change, switch, move, add or remove a light: 'NAME: scale = 0.5', 'NAME: off'.
    #[arg(long, value_name = "EDIT")]
    pub light: Vec<String>,
    /// Light the scene by a panorama from all directions: 'FILE.hdr: rotation_deg = 90'.
    #[arg(long, value_name = "EDIT")]
    pub environment: Option<String>,
    /// Put a model into the scene: 'FILE: on = "GROUP", at = [x, z]'.
    #[arg(long, value_name = "EDIT")]
    pub insert: Vec<String>,
    /// Remove noise from the pictures, for a small bias, as `unrender render --denoise` does.
    #[arg(long, conflicts_with_all = ["composite", "samples", "parts"])]
    pub denoise: bool,
    /// Also write passes.exr for compositing programs, as `unrender render --aov` does; of a composite with
    /// the shadows and the reflections of what was edited.
    #[arg(long, conflicts_with_all = ["denoise", "samples", "parts"])]
    pub aov: bool,
    /// The colour space of .exr files, whose headers state it: lin-rec709, acescg, lin-p3d65, lin-rec2020 or
    /// aces2065-1 [default: lin-rec709; of a composite into a photograph of floating-point values, that of
    /// its file].
    #[arg(long, value_name = "NAME", visible_alias = "color-space", alias = "colorspace")]
    #[arg(conflicts_with = "samples")]
    pub colour_space: Option<ColourSpace>,
    /// The scene's camera to look through [default: the photograph's].
    #[arg(long, value_name = "NAME", conflicts_with = "composite")]
    pub camera: Option<String>,
    /// Pixels in a row [default: the photograph's].
    #[arg(long, value_name = "N", conflicts_with = "composite")]
    pub width: Option<usize>,
    /// Rows [default: the photograph's].
    #[arg(long, value_name = "N", conflicts_with = "composite")]
    pub height: Option<usize>,
    /// Of a sequence, render only the pictures A up to B, B not included, counted from 1.
    #[arg(long, value_name = "A..B", value_parser = sampling::range)]
    #[arg(conflicts_with_all = ["composite", "samples", "checkpoint", "parts"])]
    pub frames: Option<Range<u32>>,
    /// Use the samples of these parts, which --samples made, instead of rendering.
    #[arg(long, value_name = "PART.exr", num_args = 1..)]
    #[arg(conflicts_with_all = ["spp", "time", "noise", "adaptive", "samples", "checkpoint"])]
    pub parts: Vec<PathBuf>,
    /// The number of samples.
    #[command(flatten)]
    pub sampling: SamplingArgs,
}

/// Runs the command.
///
/// # Errors
/// If the input cannot be used, an edit does not fit the scene, or the pictures cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    check_denoise(args.denoise, &args.sampling)?;
    let sheets = sheets(args, global)?;
    let inputs: Vec<PathBuf> = sheets.iter().flat_map(EditSheet::inputs).collect();
    let restaging = Restaging::load(sheets)?;
    let photograph = photograph(args, &restaging)?;
    let folder = folder(args, &inputs)?;
    global.console.warn(&restaging.warnings);
    match photograph {
        Some(photograph) => composite(args, global, &restaging, photograph, &folder),
        None => synthetic(args, global, &restaging, &folder),
    }
}

/// The folder of the results, in which no other file will be replaced.
fn folder(args: &Args, inputs: &[PathBuf]) -> Result<ResultFolder, Error> {
    let part = args.sampling.samples.as_ref().map(part_name);
    let writes = |name: &str| match &part {
        Some(part) => name == part,
        None if args.composite => restaged::writes_composite(name),
        None => restaged::writes_synthetic(name, args.frames.as_ref()),
    };
    let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
    // Several processes write parts and pictures of a sequence to one folder.
    if args.frames.is_some() || part.is_some() {
        ResultFolder::open_shared(&args.out, "restage", &writes, &inputs)
    } else {
        ResultFolder::open(&args.out, "restage", &writes, &inputs)
    }
    .map(|folder| folder.denoised(args.denoise))
}

fn part_name(samples: &Range<u32>) -> String {
    format!("part_{}_{}.exr", samples.start, samples.end)
}

/// The edit file, followed by the flags.
fn sheets(args: &Args, global: &Global) -> Result<Vec<EditSheet>, Error> {
    let file = args.edits.iter().map(|path| Ok(EditSheet::read(path)?));
    let flags = [
        (Flag::Recovered, args.recovered.as_slice()),
        (Flag::Project, args.project.as_slice()),
        (Flag::Scene, args.scene.as_slice()),
        (Flag::Materials, args.materials.as_slice()),
        (Flag::Remove, &args.remove),
        (Flag::Repaint, &args.repaint),
        (Flag::Light, &args.light),
        (Flag::Environment, args.environment.as_slice()),
        (Flag::Insert, &args.insert),
        (Flag::Camera, args.camera.as_slice()),
    ];
    let flags = flags
        .into_iter()
        .flat_map(|(flag, values)| values.iter().map(move |value| EditSheet::of_flag(flag, value)));
    let within = |sheet: EditSheet| {
        let sheet = sheet.within(global.limits()).in_light_units(args.light_units);
        sheet.with_scene(global.scene.clone())
    };
    file.chain(flags).map(|sheet| sheet.map(within)).collect()
}

/// The photograph for the composite, if one is requested.
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
        let needed = "--composite needs the photograph: name its project by --project PROJECT.toml, or project = \
                      \"PROJECT.toml\" in the edit file";
        Error::Request(needed.into())
    })
}

/// A larger share of pixels in which neither ratio nor difference holds is told of. Half of it tells of a lamp that is seen
/// and switched off, double of it not of a window.
const LOST: f32 = 0.02;

fn composite(
    args: &Args,
    global: &Global,
    restaging: &Restaging,
    photograph: &Photograph,
    folder: &ResultFolder,
) -> Result<ExitCode, Error> {
    let (camera, size) = (&photograph.camera, photograph.size());
    let scenes = restaging.scenes();
    let pairing = Pairing::new(scenes, camera, args.sampling.settings());
    let both = (scenes.before, scenes.after, &scenes.change.origin);
    let identity = identity(args, &both, camera, size);
    let render = CompositeRender::new(pairing, scenes.after, args.aov);
    let job = Job { render: &render, identity };
    let layers = match samples(args, global, &job, folder)? {
        ControlFlow::Continue(layers) => layers,
        ControlFlow::Break(code) => return Ok(code),
    };
    let grain = args.grain.then_some(args.sampling.seed);
    let after = render.pairing.denoised(&layers);
    let sums = (&layers[..], after.as_ref());
    let composite = Composite::new(restaging, photograph, sums, Gain::Auto, grain);
    let mut sentences = restaging.sentences.clone();
    sentences.push(composite.in_words());
    let lost = composite.share(How::Neither);
    if lost > LOST {
        let told = format!(
            "in {:.0} % of the photo, which are clipped or black, the light changes by more than half: what they showed is \
             not known, and they may look wrong; synthetic.png is the same rendered whole",
            100.0 * lost
        );
        global.console.warn(&Warnings(vec![told.clone()]));
        sentences.push(format!("{}.", capitalised(&told)));
    }
    let space = args.colour_space;
    let passes = render.passes(scenes.after, &layers);
    let write = |place: &Path| {
        if let Some(passes) = &passes {
            restaged::write_passes(passes, space.unwrap_or_default(), place, None)?;
        }
        restaged::write_composite(&composite, photograph, &sentences, space, place)
    };
    tell(folder.write(true, write)?, global);
    lead_to_results(args, global);
    Ok(ExitCode::SUCCESS)
}

fn synthetic(
    args: &Args,
    global: &Global,
    restaging: &Restaging,
    folder: &ResultFolder,
) -> Result<ExitCode, Error> {
    let photograph = restaging.start.photograph.as_ref();
    let cameras = restaging.view.cameras();
    let is_sequence = cameras.len() > 1;
    if is_sequence && (args.sampling.samples.is_some() || args.sampling.checkpoint.is_some()) {
        return Err(Error::Request(
            "--samples and --checkpoint are for one picture; a sequence is split by --frames"
                .into(),
        ));
    }
    let all = 1..cameras.len() as u32 + 1;
    let frames = args.frames.clone().unwrap_or(all.clone());
    if frames.start < all.start || frames.end > all.end {
        return Err(Error::Request(format!(
            "--frames {}..{}: there are the pictures {}..{}",
            frames.start, frames.end, all.start, all.end
        )));
    }
    let mut written = Vec::new();
    for frame in frames {
        let camera = &cameras[frame as usize - 1];
        let size = match (args.width, args.height, photograph) {
            (None, None, Some(photograph)) => photograph.size(),
            (width, height, _) => size(width, height, camera)?,
        };
        let render = PictureRender::new(&restaging.after, camera, args.sampling.settings());
        let render = match args.aov {
            true => render.with_passes(&restaging.after),
            false => render.halved(args.denoise),
        };
        let mut identity = identity(args, &restaging.after, camera, size);
        identity.shared &= !(args.denoise || args.aov);
        let layers = match samples(args, global, &Job { render: &render, identity }, folder)? {
            ControlFlow::Continue(layers) => layers,
            ControlFlow::Break(code) => return Ok(code),
        };
        let number = is_sequence.then_some(frame as usize);
        let denoised = render.denoised(&layers);
        let radiance = denoised.map_or_else(|| layers[0].mean(), |denoised| denoised.radiance);
        let space = args.colour_space.unwrap_or_default();
        let synthetic = Synthetic { radiance: &radiance, is_denoised: args.denoise, space };
        let passes = render.passes(&restaging.after, &layers, Encoding::default());
        let bad = folder.write(true, |place| {
            if let Some(passes) = &passes {
                restaged::write_passes(passes, space, place, number)?;
            }
            Ok(restaged::write_synthetic(&synthetic, photograph, place, number)?)
        })?;
        tell(bad, global);
        written.push(number);
    }
    if args.frames.is_some() {
        // Others may have been written before, or by other processes.
        written = (1..all.end)
            .filter(|n| restaged::is_written(&args.out, *n))
            .map(|n| Some(n as usize))
            .collect();
    }
    gallery(args, global, restaging, (folder, &written))?;
    lead_to_results(args, global);
    Ok(ExitCode::SUCCESS)
}

/// Writes the gallery of the pictures with the numbers `written`.
fn gallery(
    args: &Args,
    global: &Global,
    restaging: &Restaging,
    (folder, written): (&ResultFolder, &[Option<usize>]),
) -> Result<(), Error> {
    let photograph = restaging.start.photograph.as_ref();
    if let Some(photograph) = photograph {
        let write = |place: &Path| Ok(restaged::write_photograph(photograph, place)?);
        tell(folder.write(true, write)?, global);
    }
    let is_same_view =
        matches!(restaging.view, View::Photograph(_)) && (args.width, args.height) == (None, None);
    let beside = if is_same_view { Beside::SameView } else { Beside::OtherView };
    let restaged = Restaged {
        numbers: written,
        is_denoised: args.denoise,
        photograph: photograph.map(|_| beside),
        edits: &restaging.sentences,
    };
    folder.write(true, |place| restaged::write_gallery(&args.out, place, &restaged))
}

fn lead_to_results(args: &Args, global: &Global) {
    if !global.quiet {
        global
            .console
            .tell(&format!("open {} to see the pictures", args.out.join("gallery.html").display()));
    }
}

/// The identity of the rendering, with fingerprints if parts are compared with it.
fn identity(
    args: &Args,
    scene: &impl Serialize,
    camera: &Camera,
    size: (usize, usize),
) -> Identity {
    let identity = args.sampling.identity(scene, camera, size);
    if args.parts.is_empty() { identity } else { identity.with_fingerprints(scene, camera) }
}

/// The sums of all samples, rendered or from parts; or the exit code, if this run made a part or
/// was interrupted.
fn samples(
    args: &Args,
    global: &Global,
    job: &Job<'_>,
    folder: &ResultFolder,
) -> Result<ControlFlow<ExitCode, Vec<Accumulator>>, Error> {
    if !args.parts.is_empty() {
        let (part, warnings) = shard::join(&args.parts, false)?;
        global.console.warn(&warnings);
        progressive::check(job, &part.head).map_err(|problem| {
            Error::Request(format!(
                "{}: is a part of another picture: {problem}",
                part.path.display()
            ))
        })?;
        return Ok(ControlFlow::Continue(part.layers));
    }
    let progress = Progress::new("restage", global);
    let rendered = progressive::run(job, &args.sampling.goal(), &progress)?;
    drop(progress);
    if rendered.interrupted {
        return Ok(ControlFlow::Break(rendered.goodbye(&global.console)));
    }
    if let Some(samples) = &args.sampling.samples {
        folder.write(true, |place| {
            shard::write(&place.join(part_name(samples)), &rendered.head(job), &rendered.layers)
        })?;
        return Ok(ControlFlow::Break(ExitCode::SUCCESS));
    }
    if args.sampling.is_open() && !global.quiet {
        global.console.tell(&progressive::in_words(rendered.samples.end, &rendered.layers[0]));
    }
    Ok(ControlFlow::Continue(rendered.layers))
}

fn tell(bad: usize, global: &Global) {
    if bad > 0 {
        let mut warnings = Warnings::default();
        warnings.push(format!("{bad} value(s) were not finite numbers and were written as zero"));
        global.console.warn(&warnings);
    }
}
