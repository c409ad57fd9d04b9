//! The photograph of a run: rendered from its scene, exposed well or badly, with noise, in some format.

use super::rooms::World;
use crate::random::Random;
use std::fs;
use std::io;
use std::path::Path;
use unrender::formats::{Input, gltf, load_scene, picture};
use unrender::render::{Settings, Tracer};
use unrender::scene::{Depth, Environment, Image, Rgb, RgbImage};

/// The size of photographs, pixels: a draft takes a fraction of a second. Half and double of it were not tried.
pub(super) const SIZE: (usize, usize) = (24, 18);
/// Paths a pixel of the photograph, whose noise is a part of the case. Half and double of it were not tried.
const SPP: u32 = 32;
/// The mean of a photograph that is exposed well, where white is 1. Half and double of it are among the cases, as bad
/// exposures.
const MEAN: f32 = 0.3;

/// A photograph that was taken.
#[derive(Clone, Debug)]
pub(super) struct Taken {
    /// Its file.
    pub(super) name: &'static str,
    /// The gamma of its values; none for sRGB.
    pub(super) gamma: Option<f32>,
    /// The radiance of a linear value of one.
    pub(super) exposure: f32,
}

/// Takes a photograph of `world` into `folder`. A scene that cannot be rendered is shown as a grey picture.
///
/// # Errors
/// If a file cannot be written.
pub(super) fn take(world: &World, folder: &Path, random: &mut Random) -> io::Result<Taken> {
    let radiance = rendered(world, folder)?;
    let exposed = MEAN * *random.one(&[1.0, 1.0, 1.0, 1.0, 0.5, 2.0, 1e-3, 0.05, 10.0, 1e3]);
    let exposure = mean(&radiance) / exposed;
    let noise = *random.one(&[0.0, 0.0, 0.003, 0.05]);
    let noisy = radiance.map(|pixel| *pixel / exposure + random.vector(-noise, noise));
    let (name, gamma) = write(&noisy, folder, random)?;
    Ok(Taken { name, gamma, exposure })
}

/// The mean of all channels, or one for a black picture.
fn mean(picture: &RgbImage) -> f32 {
    let sum: f64 = picture.pixels().iter().map(|pixel| f64::from(pixel.element_sum())).sum();
    let mean = sum / (3 * picture.pixels().len()) as f64;
    if mean > 0.0 { mean as f32 } else { 1.0 }
}

/// Writes a linear picture in some format; returns its name and the gamma of its values, none for sRGB.
fn write(
    linear: &RgbImage,
    folder: &Path,
    random: &mut Random,
) -> io::Result<(&'static str, Option<f32>)> {
    let gamma = *random.one(&[None, None, Some(1.0), Some(2.2)]);
    let name = *random.one(&["photo.png", "photo.png", "photo.exr", "photo.hdr"]);
    let path = folder.join(name);
    let (written, gamma) = match gamma {
        _ if name != "photo.png" => (picture::write(&path, linear), Some(1.0)),
        None => (picture::write_png_srgb(&path, linear), None),
        Some(gamma) => {
            let codes = linear.map(|pixel| pixel.max(Rgb::ZERO).powf(1.0 / gamma));
            let depth = *random.one(&[Depth::Eight, Depth::Sixteen]);
            (picture::write_png_codes(&path, &codes, depth), Some(gamma))
        }
    };
    written.map_err(io::Error::other)?;
    Ok((name, gamma))
}

/// The radiance that the camera of `world` sees; grey if there is none.
fn rendered(world: &World, folder: &Path) -> io::Result<RgbImage> {
    let (width, height) = SIZE;
    let grey = Image::from_fn(width, height, |x, _| Rgb::splat(0.2 + 0.02 * x as f32));
    let path = folder.join("shown.glb");
    let Ok(bytes) = gltf::to_glb(&world.scene) else { return Ok(grey) };
    fs::write(&path, bytes)?;
    // Read again, as scenes far from zero are.
    let Ok((mut scene, _)) = load_scene(Input::from(path.as_path())) else { return Ok(grey) };
    let around = world.around.map(|radiance| Image::from_fn(1, 1, |_, _| radiance));
    scene.environment = around.and_then(|picture| Environment::new(picture, 0.0).ok());
    let (Ok(_), Some(camera)) = (scene.validate(), scene.cameras.first().cloned()) else {
        return Ok(grey);
    };
    let settings = Settings { spp: SPP, ..Settings::default() };
    let tracer = Tracer::new(&scene);
    Ok(tracer.render(&scene.materials(), &camera, SIZE, &settings, &|_| {}).mean)
}
