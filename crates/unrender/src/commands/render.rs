//! `unrender render`: a picture of a scene, with its own materials or those of a file.

use crate::cli::{Global, warn};
use crate::fingerprint::fingerprint;
use crate::part::{self, Head, Identity};
use crate::passes::{self, Goal, Job, Rendered};
use crate::progress::Progress;
use crate::{Error, interrupt, job, output};
use std::ops::Range;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use unrender_formats::{materials, picture};
use unrender_render::Settings;
use unrender_render::path::MAX_BOUNCES;
use unrender_scene::{Camera, Scene, Warnings};

const DEFAULT_HEIGHT: usize = 512;
const MAX_SIDE: usize = 65_536;
const DEFAULT_SPP: u32 = 64;

/// Renders a scene.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender render room.glb --out room.exr\n  \
    unrender render room.glb --materials result/materials.json --spp 256 --out room.png\n  \
    unrender render room.glb --camera door --height 1080 --seed 7 --out door.exr\n  \
    unrender render vase.glb --environment sky.hdr --environment-rotation 90 --out vase.png\n  \
    unrender render room.glb --noise 0.01 --adaptive --checkpoint room.part.exr --out room.exr\n  \
    unrender render room.glb --samples 64..128 --out part2.exr    (see unrender merge)")]
pub struct Args {
    /// The scene file: glTF (.glb, .gltf) or OBJ.
    pub scene: PathBuf,
    /// Materials to put onto the scene's groups.
    #[arg(long, value_name = "FILE.json")]
    pub materials: Option<PathBuf>,
    /// A panorama that lights the scene from all around and is seen behind it (.hdr, .exr); its
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
    /// The camera's name [default: the scene's first].
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Pixels in a row [default: by the height and the camera's aspect].
    #[arg(long, value_name = "N")]
    pub width: Option<usize>,
    /// Rows [default: by the width and the camera's aspect, else 512].
    #[arg(long, value_name = "N")]
    pub height: Option<usize>,
    /// Samples a pixel, on average; with --time or --noise the most [default: 64 without those].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Stop after so many seconds of rendering; how far that is depends on the machine.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time: Option<Duration>,
    /// Stop when the picture's relative standard error is at most this: the root mean square of
    /// the standard errors of all pixels and channels over their mean. 0.01 is one percent.
    #[arg(long, value_name = "TARGET", value_parser = target)]
    pub noise: Option<f64>,
    /// Take more samples where the picture is noisy, fewer where it is not.
    #[arg(long)]
    pub adaptive: bool,
    /// Render the samples A up to B alone, B not included, as a part for `unrender merge`: the same
    /// picture in pieces, on as many machines as you like. The part is an EXR file.
    #[arg(long, value_name = "A..B", value_parser = samples)]
    #[arg(conflicts_with_all = ["spp", "time", "noise", "adaptive"])]
    pub samples: Option<Range<u32>>,
    /// Keep the samples in this EXR file, every minute and on Ctrl-C, and go on from there if it is
    /// there already. The picture is the same to the bit.
    #[arg(long, value_name = "FILE.exr")]
    pub checkpoint: Option<PathBuf>,
    /// Chooses the noise; the same seed gives the same bits.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// The most reflections of a path [default: until it carries nothing more].
    #[arg(long, value_name = "N")]
    pub bounces: Option<u32>,
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
    let (scene, camera, warnings) = load(args)?;
    let size = size(args.width, args.height, &camera)?;
    warn(&warnings);
    let max_bounces = args.bounces.unwrap_or(MAX_BOUNCES);
    let settings = Settings { seed: args.seed, max_bounces, ..Settings::default() };
    let identity = identity(args, &scene, &camera, size, max_bounces);
    let job = Job { scene: &scene, camera: &camera, settings, identity };
    let goal = goal(args);
    let progress = Progress::new("render", global.quiet);
    let rendered = passes::run(&job, &goal, &progress)?;
    drop(progress);
    let Rendered { tally, samples, interrupted } = rendered;
    if interrupted {
        eprintln!("stopped after sample {}; the same command goes on from there", samples.end);
        return Ok(interrupt::code());
    }
    let _until_written = interrupt::writing();
    if args.samples.is_some() {
        part::write(&args.out, &Head { identity: job.identity, samples }, &tally)?;
        return Ok(ExitCode::SUCCESS);
    }
    if (goal.time.is_some() || goal.noise.is_some()) && !global.quiet {
        eprintln!("{}", passes::in_words(samples.end, &tally));
    }
    output::write_picture(&args.out, &tally)?;
    Ok(ExitCode::SUCCESS)
}

/// Asks, before the work, whether its results can be written.
fn check_outputs(args: &Args) -> Result<(), Error> {
    let parts = args.samples.as_ref().map(|_| &args.out).into_iter().chain(&args.checkpoint);
    for part in parts {
        output::check_file(part, &["exr"], "the samples of a picture are kept in .exr files")?;
    }
    if args.checkpoint.as_ref() == Some(&args.out) {
        return Err(Error::Request("--checkpoint and --out need files of their own".into()));
    }
    Ok(output::check_picture(&args.out)?)
}

/// The scene with the materials and the environment asked for, and the camera.
fn load(args: &Args) -> Result<(Scene, Camera, Warnings), Error> {
    let (mut scene, mut warnings) = unrender_formats::load_scene(&args.scene)?;
    if let Some(path) = &args.materials {
        warnings.extend(materials::apply_from(path, &mut scene)?);
    }
    if let Some(path) = &args.environment {
        let rotation_rad = args.environment_rotation.to_radians();
        let (environment, told) =
            picture::read_environment(path, rotation_rad, args.environment_scale)?;
        scene.environment = Some(environment);
        warnings.extend(told);
    }
    warnings.extend(job::validate(&mut scene, &args.scene)?);
    let (camera, told) = job::named_camera(&scene, args.camera.as_deref(), &args.scene)?;
    warnings.extend(told);
    Ok((scene, camera, warnings))
}

/// What the rendering is of; without fingerprints where nobody will compare them.
fn identity(
    args: &Args,
    scene: &Scene,
    camera: &Camera,
    (width, height): (usize, usize),
    bounces: u32,
) -> Identity {
    let is_kept = args.samples.is_some() || args.checkpoint.is_some();
    let (scene, camera) = if is_kept {
        (fingerprint(scene), fingerprint(camera))
    } else {
        (String::new(), String::new())
    };
    let version = env!("CARGO_PKG_VERSION").to_owned();
    let (seed, adaptive) = (args.seed, args.adaptive);
    Identity { version, scene, camera, width, height, seed, bounces, adaptive }
}

fn goal(args: &Args) -> Goal {
    let is_open = args.time.is_some() || args.noise.is_some();
    let spp = args.spp.unwrap_or(if is_open { u32::MAX } else { DEFAULT_SPP });
    Goal {
        samples: args.samples.clone().unwrap_or(0..spp),
        time: args.time,
        noise: args.noise,
        checkpoint: args.checkpoint.clone(),
    }
}

/// A range of samples, as in `64..128`.
fn samples(text: &str) -> Result<Range<u32>, String> {
    let (start, end) = text.split_once("..").ok_or("write two numbers, as in 64..128")?;
    let number = |text: &str| text.parse::<u32>().map_err(|error| format!("{text:?}: {error}"));
    let (start, end) = (number(start)?, number(end)?);
    if start < end { Ok(start..end) } else { Err(format!("{start}..{end} has no samples")) }
}

fn seconds(text: &str) -> Result<Duration, String> {
    Duration::try_from_secs_f64(positive(text)?).map_err(|error| error.to_string())
}

fn target(text: &str) -> Result<f64, String> {
    positive(text)
}

fn factor(text: &str) -> Result<f32, String> {
    positive(text).map(|factor| factor as f32)
}

fn angle(text: &str) -> Result<f32, String> {
    let angle: f32 = text.parse().map_err(|_| "is no number")?;
    if angle.is_finite() { Ok(angle) } else { Err("must be a finite number".into()) }
}

fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "is no number")?;
    let fits = number > 0.0 && number.is_finite();
    if fits { Ok(number) } else { Err("must be a number above zero".into()) }
}

/// The picture's width and height; what is not asked for follows from the camera's aspect.
pub(crate) fn size(
    width: Option<usize>,
    height: Option<usize>,
    camera: &Camera,
) -> Result<(usize, usize), Error> {
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
        assert!(size(Some(0), None, &camera).is_err());
        assert!(size(Some(1 << 40), None, &camera).is_err());
    }

    #[test]
    fn ranges_of_samples_have_two_ends_and_something_between() {
        assert_eq!(samples("64..128"), Ok(64..128));
        for bad in ["64", "64..64", "9..8", "a..b", "-1..3", "0..5000000000", ".."] {
            assert!(samples(bad).is_err(), "{bad}");
        }
    }
}
