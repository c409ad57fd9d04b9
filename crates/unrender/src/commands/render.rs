//! `unrender render`: a picture of a scene, with its own materials or those of a file.

use super::encoding::EncodingArgs;
use super::sampling::{SamplingArgs, positive};
use crate::global::Global;
use crate::progress::Progress;
use crate::progressive::{self, Job};
use crate::progressive_render::PictureRender;
use crate::shard;
use crate::{Error, Project, interrupt, job, output, result_folder};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use unrender_formats::{Input, LightUnits, Limits, material_file, picture};
use unrender_render::Accumulator;
use unrender_render::denoise::Denoised;
use unrender_scene::{Camera, Rgb, RgbImage, Scene, Warnings};

const DEFAULT_HEIGHT: usize = 512;
const MAX_SIDE: usize = 65_536;
/// The most pixels of a picture whose size only the scene file states: it takes 3 GiB. Half of it are still eight times
/// what films of published scenes have; twice as much is more than most machines have.
const STATED_PIXELS: usize = 1 << 26;

/// Renders a scene.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender render room.glb --out room.exr\n  \
    unrender render room.glb --materials result --spp 256 --out room.png\n  \
    unrender render room.glb --denoise --out clean.png\n  \
    unrender render room.glb --layers --out layers.exr    (see unrender relight)\n  \
    unrender render room.glb --aov --colour-space acescg --out passes.exr\n  \
    unrender render room.glb --camera door --height 1080 --seed 7 --out door.exr\n  \
    unrender render vase.glb --environment sky.hdr --environment-rotation 90 --out vase.png\n  \
    unrender render --project room.toml --materials result --out again.png\n  \
    unrender render room.glb --noise 0.01 --adaptive --checkpoint room.part.exr --out room.exr\n  \
    unrender render room.glb --samples 64..128 --out part2.exr    (see unrender merge)")]
pub struct Args {
    /// The scene file: glTF (.glb, .gltf), OBJ, Mitsuba 3 (.xml) or Radiance (.rad).
    #[arg(required_unless_present = "project")]
    pub scene: Option<PathBuf>,
    /// A project, instead of a scene: its scene with its lights, environment and known groups, seen
    /// by its camera, in the size of its photo.
    #[arg(long, value_name = "FILE.toml", conflicts_with = "scene")]
    pub project: Option<PathBuf>,
    /// The number of a project's photograph: its camera and size, and the lamps that were on [default: the
    /// first].
    #[arg(long, value_name = "N", requires = "project")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    pub photo: Option<u32>,
    /// Materials to apply to the scene's groups: a file, or a folder with the results of `recover`.
    #[arg(long, value_name = "FILE.json|FILE.mtlx|DIR")]
    pub materials: Option<PathBuf>,
    /// The units of a glTF file's lights: blender-standard, unitless, blender-raw or radiometric
    /// [default: as its generator writes them].
    #[arg(long, value_name = "UNITS")]
    pub light_units: Option<LightUnits>,
    /// A panorama that lights the scene from all directions and is seen behind it (.hdr, .exr); its
    /// centre lies along -z, its upper edge along +y.
    #[arg(long, value_name = "FILE")]
    pub environment: Option<PathBuf>,
    /// Turns the panorama about +y, counter-clockwise seen from above, degrees.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_negative_numbers = true)]
    #[arg(requires = "environment", value_parser = angle)]
    pub environment_rotation: f32,
    /// Multiplies the panorama's radiance.
    #[arg(long, value_name = "S", default_value_t = 1.0, requires = "environment")]
    #[arg(value_parser = factor)]
    pub environment_scale: f32,
    /// The camera's name [default: the project's, else the scene's first].
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Pixels in a row [default: by the height and the camera's aspect, else as the scene file says].
    #[arg(long, value_name = "N")]
    pub width: Option<usize>,
    /// Rows [default: by the width and the camera's aspect, else as the scene file says, else 512].
    #[arg(long, value_name = "N")]
    pub height: Option<usize>,
    /// Remove noise from the picture, for a small bias: it is rendered as two independent halves, and
    /// pixels that are alike in both halves and in their surfaces are averaged. With --independent.
    /// Not for pictures whose noise is measured, or from which materials are recovered.
    #[arg(long, conflicts_with = "samples")]
    pub denoise: bool,
    /// Also write the contribution of each light, as layers of the .exr file: `unrender relight`
    /// changes the brightness of lights with them, and compositing programs show them. With
    /// --independent. Takes 112 bytes of memory per pixel and light.
    #[arg(long, conflicts_with_all = ["samples", "denoise"])]
    pub layers: bool,
    /// Also write what compositing programs want, as layers of the .exr file with Blender's names: the
    /// contribution of each light as --layers does, direct and indirect light, albedo, normal, position, depth,
    /// and Cryptomatte by group. With --independent.
    #[arg(long, conflicts_with_all = ["samples", "denoise"])]
    pub aov: bool,
    /// How the picture is written.
    #[command(flatten)]
    pub encoding: EncodingArgs,
    /// The number of samples.
    #[command(flatten)]
    pub sampling: SamplingArgs,
    /// The picture to write: .exr or .hdr (linear radiance), or .png (8-bit sRGB).
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// If the input cannot be used or the picture cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    check_outputs(args)?;
    let given = InMemory { scene: global.scene.as_deref().cloned(), materials: None };
    let shot = Shot::load(args, given, global.limits())?;
    global.console.warn(&shot.warnings);
    let render = shot.render(args);
    let job = shot.job(args, &render);
    let progress = Progress::new("render", global);
    let rendered = progressive::run(&job, &args.sampling.goal(), &progress)?;
    drop(progress);
    if rendered.interrupted {
        return Ok(rendered.goodbye(&global.console));
    }
    let _until_written = interrupt::writing();
    if args.sampling.samples.is_some() {
        shard::write(&args.out, &rendered.head(&job), &rendered.layers)?;
        return Ok(ExitCode::SUCCESS);
    }
    let accumulator = &rendered.layers[0];
    if args.sampling.is_open() && !global.quiet {
        global.console.tell(&progressive::in_words(rendered.samples.end, accumulator));
    }
    let denoised = render.denoised(&rendered.layers);
    if let Some(denoised) = denoised.as_ref().filter(|_| !global.quiet) {
        global.console.tell(&in_words(denoised, accumulator));
    }
    let encoding = args.encoding.encoding();
    if args.aov || args.layers {
        write_layers(args, &shot.scene, &render, &rendered.layers)?;
        global.console.warn(&output::doubts(accumulator));
        return Ok(ExitCode::SUCCESS);
    }
    let denoised = denoised.map(|denoised| denoised.radiance);
    global.console.warn(&output::write_picture(&args.out, accumulator, denoised, encoding)?);
    Ok(ExitCode::SUCCESS)
}

/// Writes the picture with its passes, or with the contribution of each light.
fn write_layers(
    args: &Args,
    scene: &Scene,
    render: &PictureRender<'_>,
    layers: &[Accumulator],
) -> Result<(), Error> {
    let encoding = args.encoding.encoding();
    if let Some(passes) = render.passes(scene, layers, encoding) {
        picture::write_passes(&args.out, &passes, encoding.space)?;
    } else if let Some(mut lights) = render.light_layers(layers) {
        for light in &mut lights {
            light.radiance = encoding.exposed(std::mem::take(&mut light.radiance));
        }
        let whole = encoding.exposed(layers[0].mean());
        picture::write_layers(&args.out, &whole, &lights, encoding.space)?;
    }
    Ok(())
}

/// Applies materials to a scene.
pub type AssignMaterials<'a> = &'a dyn Fn(&mut Scene) -> Result<Warnings, Error>;

/// Data that a caller has in memory instead of files.
#[derive(Default)]
pub struct InMemory<'a> {
    /// The scene, instead of the one that the arguments name.
    pub scene: Option<Scene>,
    /// Applies materials to the scene, after those of the file that the arguments name.
    pub materials: Option<AssignMaterials<'a>>,
}

/// The picture that [`run`] would write. Its warnings and its progress go to the console.
///
/// # Errors
/// If the input cannot be used.
pub fn picture(args: &Args, given: InMemory<'_>, global: &Global) -> Result<Rendering, Error> {
    check_denoise(args.denoise, &args.sampling)?;
    if args.layers || args.aov {
        return Err(Error::Request(
            "light layers are written to a file, not kept in memory".into(),
        ));
    }
    let shot = Shot::load(args, given, global.limits())?;
    global.console.warn(&shot.warnings);
    let render = shot.render(args);
    let job = shot.job(args, &render);
    let progress = Progress::new("render", global);
    let rendered = progressive::run(&job, &args.sampling.goal(), &progress)?;
    let accumulator: &Accumulator = &rendered.layers[0];
    global.console.warn(&output::doubts(accumulator));
    let (samples, interrupted) = (rendered.samples.clone(), rendered.interrupted);
    let (radiance, noise) = match render.denoised(&rendered.layers) {
        Some(denoised) => (denoised.radiance, denoised.error),
        None => (accumulator.mean(), accumulator.noise()),
    };
    let radiance = args.encoding.encoding().exposed(radiance);
    Ok(Rendering { radiance, noise, samples, interrupted })
}

/// A picture, with its noise and samples.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// Radiance, W sr^-1 m^-2 per channel.
    pub radiance: RgbImage,
    /// Its relative standard error: the root mean square of the standard errors over the mean. For
    /// a denoised picture, the root mean square error including its bias, estimated from the
    /// halves; zero if it is too small to be estimated.
    pub noise: f64,
    /// The numbers of its samples; with adaptive sampling, of a pixel of mean noise.
    pub samples: Range<u32>,
    /// Whether it was ended before its goal.
    pub interrupted: bool,
}

/// The effect of denoising on the picture of `accumulator`, in words.
fn in_words(denoised: &Denoised, accumulator: &Accumulator) -> String {
    format!(
        "denoised: estimated relative error {:.3} %, {:.3} % before; {:.0} % of the picture was left as it was",
        100.0 * denoised.error,
        100.0 * accumulator.noise(),
        100.0 * denoised.untouched
    )
}

/// The rendering.
struct Shot {
    scene: Scene,
    camera: Camera,
    size: (usize, usize),
    warnings: Warnings,
}

impl Shot {
    /// The rendering that `args` describe, with the data in memory.
    fn load(args: &Args, given: InMemory<'_>, limits: Limits) -> Result<Self, Error> {
        let (scene, camera, photo, warnings) = load(args, given, limits)?;
        let size = match (args.width, args.height, photo) {
            (None, None, Some(photo)) => photo,
            (width, height, _) => size(width, height, &camera)?,
        };
        Ok(Self { scene, camera, size, warnings })
    }

    fn job<'a>(&self, args: &Args, render: &'a PictureRender<'_>) -> Job<'a> {
        let mut identity = args.sampling.identity(&self.scene, &self.camera, self.size);
        identity.shared &= !(args.denoise || args.layers || args.aov);
        Job { render, identity }
    }

    fn render(&self, args: &Args) -> PictureRender<'_> {
        let settings = args.sampling.settings();
        let render = PictureRender::new(&self.scene, &self.camera, settings);
        match (args.aov, args.layers) {
            (true, _) => render.with_passes(&self.scene),
            (false, true) => render.by_light(&self.scene),
            (false, false) => render.halved(args.denoise),
        }
    }
}

/// Checks whether the input of `args` can be rendered, by reading it.
///
/// # Errors
/// If it cannot, or the picture could not be written.
pub(crate) fn check(args: &Args, global: &Global) -> Result<(), Error> {
    check_outputs(args)?;
    let shot = Shot::load(args, InMemory::default(), global.limits())?;
    global.console.warn(&shot.warnings);
    Ok(())
}

/// Checks before the work whether its results can be written.
fn check_outputs(args: &Args) -> Result<(), Error> {
    check_denoise(args.denoise, &args.sampling)?;
    let inputs = [&args.scene, &args.project, &args.materials, &args.environment];
    let inputs = inputs.map(Option::as_ref);
    for out in std::iter::once(&args.out).chain(&args.sampling.checkpoint) {
        output::check_inputs(out, inputs.into_iter().flatten().map(PathBuf::as_path))?;
    }
    let parts = args.sampling.samples.as_ref().map(|_| &args.out).into_iter();
    let parts = parts.chain(&args.sampling.checkpoint);
    for part in parts {
        output::check_file(part, &["exr"], "the samples of a picture are kept in .exr files")?;
    }
    if args.layers || args.aov {
        output::check_file(&args.out, &["exr"], "light layers are kept in .exr files")?;
    }
    if let (Some(_), Some(flag)) = (&args.sampling.samples, args.encoding.given()) {
        return Err(Error::Request(format!(
            "{flag} is for pictures; --samples makes a part of one, which is merged first"
        )));
    }
    args.encoding.check(&args.out)?;
    if args.sampling.checkpoint.as_ref() == Some(&args.out) {
        return Err(Error::Request("--checkpoint and --out need files of their own".into()));
    }
    Ok(output::check_picture(&args.out)?)
}

/// The least number of samples per pixel from which noise is estimated. With half of it each half has
/// two samples, with double of it drafts could not be denoised.
const DENOISE_SPP_MIN: u32 = 8;

/// Checks that there will be enough samples to denoise.
///
/// # Errors
/// If there are not.
pub(crate) fn check_denoise(denoise: bool, sampling: &SamplingArgs) -> Result<(), Error> {
    if denoise && sampling.spp.is_some_and(|spp| spp < DENOISE_SPP_MIN) {
        return Err(Error::Request(format!(
            "--denoise needs at least {DENOISE_SPP_MIN} samples per pixel to estimate the noise; \
             give --spp {DENOISE_SPP_MIN} or more"
        )));
    }
    Ok(())
}

/// A scene with the camera and the size of a project.
type Loaded = (Scene, Camera, Option<(usize, usize)>, Warnings);

/// The scene with the requested materials and environment, the camera, and the size of the
/// project's photograph.
fn load(args: &Args, given: InMemory<'_>, limits: Limits) -> Result<Loaded, Error> {
    let (mut scene, own, path, mut warnings) = match (given.scene, &args.project) {
        (Some(mut scene), _) => {
            let path = args.scene.clone().unwrap_or_default();
            let warnings = job::validate_meshes(&mut scene, &path)?;
            (scene, None, path, warnings)
        }
        (None, Some(project)) => {
            let (scene, own, warnings) = of_project(args, project, limits)?;
            let path = own.path.clone();
            (scene, Some(own), path, warnings)
        }
        (None, None) => {
            let path = args.scene.clone().unwrap_or_default();
            // Its only light may be the requested environment.
            let (scene, warnings) = unrender_formats::load_model(
                Input::new(&path, limits).in_light_units(args.light_units),
            )?;
            (scene, None, path, warnings)
        }
    };
    if let Some(path) = &args.materials {
        let path = result_folder::materials(path)?;
        warnings.extend(material_file::apply(Input::new(&path, limits), &mut scene)?);
    }
    if let Some(put) = given.materials {
        warnings.extend(put(&mut scene)?);
    }
    let off = own.as_ref().map(|own| &own.off[..]).unwrap_or_default();
    off.iter().for_each(|source| scene.scale_source(*source as usize, Rgb::ZERO));
    if let Some(path) = &args.environment {
        let rotation_rad = args.environment_rotation.to_radians();
        let path = Input::new(path, limits);
        let (environment, noted) =
            picture::read_environment(path, rotation_rad, args.environment_scale)?;
        scene.environment = Some(environment.with_up(scene.up));
        warnings.extend(noted);
    }
    warnings.extend(job::validate(&mut scene, &path)?);
    let (own, photo) = own.map(|own| (own.camera, own.size)).unzip();
    let camera = match (own, &args.camera) {
        (Some(camera), None) => camera,
        (_, name) => {
            let (camera, noted) = job::named_camera(&scene, name.as_deref(), &path)?;
            warnings.extend(noted);
            camera
        }
    };
    Ok((scene, camera, photo, warnings))
}

/// The data of a project's photograph beside the scene: its camera, its size, and the scene's file.
struct OfProject {
    camera: Camera,
    size: (usize, usize),
    path: PathBuf,
    /// The lamps that were off, as the scene numbers its sources.
    off: Vec<u32>,
}

fn of_project(
    args: &Args,
    path: &Path,
    limits: Limits,
) -> Result<(Scene, OfProject, Warnings), Error> {
    let (mut project, warnings) = Project::read(path)?;
    project.limits = limits;
    project.light_units = args.light_units.or(project.light_units);
    for out in std::iter::once(&args.out).chain(&args.sampling.checkpoint) {
        output::check_inputs(out, project.inputs())?;
    }
    let job = crate::Job::load(project, warnings)?;
    let (photograph, count) = (args.photo.unwrap_or(1) as usize, job.photographs());
    if photograph > count {
        let of = path.display();
        return Err(Error::Request(format!(
            "--photo {photograph}: {of} has {count} photograph(s)"
        )));
    }
    let job = job.alone(photograph - 1).into_owned();
    let size = (job.photo.radiance.width(), job.photo.radiance.height());
    let own = OfProject { camera: job.camera, size, path: job.project.scene, off: job.off };
    Ok((job.scene, own, job.warnings))
}

fn factor(text: &str) -> Result<f32, String> {
    positive(text).map(|factor| factor as f32)
}

fn angle(text: &str) -> Result<f32, String> {
    let angle: f32 = text.parse().map_err(|_| "is no number")?;
    if angle.is_finite() { Ok(angle) } else { Err("must be a finite number".into()) }
}

/// The picture's width and height; a side that is not given follows from the camera's aspect, both from the size that
/// the scene file states.
pub(crate) fn size(
    width: Option<usize>,
    height: Option<usize>,
    camera: &Camera,
) -> Result<(usize, usize), Error> {
    if let (None, None, Some(stated)) = (width, height, camera.size) {
        let [width, height] = stated.map(|side| side as usize);
        if width == 0 || height == 0 || width.saturating_mul(height) > STATED_PIXELS {
            return Err(Error::Request(format!(
                "camera \"{}\" has a picture of {width} x {height} pixels in the scene file, which is not rendered \
                 unasked; give --width or --height",
                camera.name
            )));
        }
        return Ok((width, height));
    }
    let aspect = camera.aspect.filter(|a| a.is_finite() && *a > 0.0).unwrap_or(1.0);
    let by = |side: usize, factor: f32| ((side as f32 * factor).round() as usize).max(1);
    let (width, height) = match (width, height) {
        (Some(width), Some(height)) => (width, height),
        (Some(width), None) => (width, by(width, 1.0 / aspect)),
        (None, height) => {
            let height = height.unwrap_or(DEFAULT_HEIGHT);
            (by(height, aspect), height)
        }
    };
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(Error::Request(format!(
            "a picture of {width} x {height} pixels cannot be rendered; \
             --width and --height are from 1 to {MAX_SIDE}"
        )));
    }
    Ok((width, height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn sizes_follow_the_aspect_where_nothing_is_asked_for() {
        let mut camera = Camera::look_at("c", Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0);
        assert_eq!(size(None, None, &camera).unwrap(), (512, 512));
        camera.aspect = Some(1.5);
        assert_eq!(size(None, None, &camera).unwrap(), (768, 512));
        assert_eq!(size(Some(300), None, &camera).unwrap(), (300, 200));
        assert_eq!(size(Some(10), Some(20), &camera).unwrap(), (10, 20));
        camera.size = Some([640, 480]);
        assert_eq!(size(None, None, &camera).unwrap(), (640, 480));
        assert_eq!(size(Some(300), None, &camera).unwrap(), (300, 200));
        camera.size = Some([u32::MAX; 2]);
        assert!(size(None, None, &camera).is_err());
        assert!(size(Some(0), None, &camera).is_err());
        assert!(size(Some(1 << 40), None, &camera).is_err());
    }
}
