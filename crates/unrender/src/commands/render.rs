//! `unrender render`: a picture of a scene, with its own materials or those of a file.

use crate::cli::{Global, warn};
use crate::engine;
use crate::progress::Progress;
use crate::{Error, interrupt, job, output};
use std::path::PathBuf;
use std::process::ExitCode;
use unrender_formats::{materials, picture};
use unrender_render::Settings;
use unrender_render::path::MAX_BOUNCES;
use unrender_scene::{Camera, Warnings};

const DEFAULT_HEIGHT: usize = 512;
const MAX_SIDE: usize = 65_536;

/// Renders a scene.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender render room.glb --out room.exr\n  \
    unrender render room.glb --materials result/materials.json --spp 256 --out room.png\n  \
    unrender render room.glb --camera door --height 1080 --seed 7 --out door.exr")]
pub struct Args {
    /// The scene file: glTF (.glb, .gltf) or OBJ.
    pub scene: PathBuf,
    /// Materials to put onto the scene's groups.
    #[arg(long, value_name = "FILE.json")]
    pub materials: Option<PathBuf>,
    /// The camera's name [default: the scene's first].
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Pixels in a row [default: by the height and the camera's aspect].
    #[arg(long, value_name = "N")]
    pub width: Option<usize>,
    /// Rows [default: by the width and the camera's aspect, else 512].
    #[arg(long, value_name = "N")]
    pub height: Option<usize>,
    /// Samples a pixel.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
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
    output::check_picture(&args.out)?;
    let (mut scene, mut warnings) = unrender_formats::load_scene(&args.scene)?;
    if let Some(path) = &args.materials {
        warnings.extend(materials::apply_from(path, &mut scene)?);
    }
    warnings.extend(job::validate(&mut scene, &args.scene)?);
    let (camera, told) = job::named_camera(&scene, args.camera.as_deref(), &args.scene)?;
    warnings.extend(told);
    let size = size(args.width, args.height, &camera)?;
    warn(&warnings);

    let max_bounces = args.bounces.unwrap_or(MAX_BOUNCES);
    let settings = Settings { spp: args.spp, seed: args.seed, max_bounces };
    let progress = Progress::new("render", global.quiet);
    let rendered = engine::render(&scene, &camera, size, &settings, &progress);
    drop(progress);
    let _until_written = interrupt::writing();
    let bad = picture::write(&args.out, &rendered)?;
    if bad > 0 {
        let mut warnings = Warnings::default();
        warnings.push(format!("{bad} value(s) were not finite numbers and were written as zero"));
        warn(&warnings);
    }
    Ok(ExitCode::SUCCESS)
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
}
