//! A scene of the corpus with all its files, made once.

use super::family::{Family, Renderer, Style};
use super::generate::{self, Plan};
use super::photograph::{self, Photograph, SampleBudget};
use super::spoil::{self, Dial};
use super::store::{self, Folder, Format, META_VERSION, Meta};
use super::verify;
use crate::Failure;
use std::time::Instant;
use unrender::formats::{atomic, picture};
use unrender::render::Tracer;
use unrender::scene::color::srgb_from_linear;
use unrender::scene::{Rgb, RgbImage};

/// The relative noise per pixel to which photographs are rendered. A camera has 0.5 to 2 %.
const NOISE: f64 = 0.02;
/// The most samples of a pixel, so that no scene takes longer than half a minute.
const SPP_MAX: u32 = 320;
/// The noise of the cameras at middle grey; the seed chooses one.
const CAMERA_NOISE: [f32; 4] = [0.0, 0.0, 0.01, 0.02];
/// The share of the pixels without lamps that is clipped in PNG and JPEG.
const CLIPPED_SHARE: f64 = 0.01;
/// The linear value of the pixel at that share.
const BRIGHT: f32 = 0.9;
const JPEG_QUALITY: u8 = 90;

/// The plan of a seed.
pub(crate) fn plan(
    seed: u64,
    family: Family,
    asked: Option<Renderer>,
    size: (usize, usize),
) -> Plan {
    generate::plan(seed, Style::new(seed, family, asked), size, spoil::segments(size.1))
}

/// Makes the photographs and the projects, unless they are there.
///
/// # Errors
/// If the renderer fails or a file cannot be written.
pub(crate) fn photographs(plan: &Plan, folder: &Folder, quick: bool) -> Result<Meta, Failure> {
    let fingerprint = store::fingerprint(plan)?;
    if let Some(meta) = folder.meta().filter(|meta| meta.fingerprint == fingerprint) {
        return Ok(meta);
    }
    if folder.0.exists() {
        // From an interrupted run, or from another scene.
        std::fs::remove_dir_all(&folder.0)?;
    }
    std::fs::create_dir_all(&folder.0)?;
    let started = Instant::now();
    let budget = SampleBudget { noise: NOISE, spp_max: if quick { 128 } else { SPP_MAX } };
    let (scene, work) = (plan.scene(), folder.path("work"));
    let renderer = plan.style.renderer;
    let taken = photograph::take(plan, &scene, &plan.cameras[0], renderer, budget, &work)?;
    for (half, image) in taken.halves.iter().enumerate() {
        picture::write_exr(&folder.path(&format!("radiance_{half}.exr")), image)?;
    }
    let meta = Meta {
        version: META_VERSION,
        seed: plan.seed,
        family: plan.style.family,
        renderer,
        brdf: plan.style.brdf.name().to_owned(),
        size: plan.size,
        fingerprint,
        exposure: exposure(plan, &taken.mean()),
        rendering_noise: taken.noise(),
        camera_noise: CAMERA_NOISE[plan.seed as usize % CAMERA_NOISE.len()],
        spp: taken.spp,
        seconds: started.elapsed().as_secs_f64(),
    };
    write_pictures(folder, &meta, &taken.mean())?;
    write_models(plan, folder, &meta)?;
    let _ = std::fs::remove_dir_all(&work);
    folder.write_meta(&meta)?;
    eprintln!(
        "seed {}: {} groups by {} ({}), {:.2} % noise, {} spp, {:.1} s",
        plan.seed,
        plan.groups.len(),
        renderer.name(),
        meta.brdf,
        100.0 * meta.rendering_noise,
        meta.spp,
        meta.seconds
    );
    Ok(meta)
}

/// The rendering in a folder.
///
/// # Errors
/// If it cannot be read.
pub(crate) fn kept(folder: &Folder, meta: &Meta) -> Result<Photograph, Failure> {
    let half = |half: usize| -> Result<RgbImage, Failure> {
        Ok(picture::read(&folder.path(&format!("radiance_{half}.exr")))?.0.values)
    };
    Ok(Photograph { halves: [half(0)?, half(1)?], spp: meta.spp })
}

/// The exposure at which, besides lamps, few pixels are clipped.
pub(crate) fn exposure(plan: &Plan, picture: &RgbImage) -> f32 {
    let scene = plan.scene();
    let geometry = Tracer::new(&scene).geometry(&plan.cameras[0], plan.size.0, plan.size.1);
    let shows_lamp = |group: u32| scene.groups.get(group as usize).is_none_or(|g| g.is_emitter());
    let mut levels: Vec<f32> = geometry
        .pixels()
        .iter()
        .zip(picture.pixels())
        .filter(|(pixel, _)| !shows_lamp(pixel.group))
        .map(|(_, value)| value.max_element())
        .collect();
    levels.sort_by(f32::total_cmp);
    let at = ((1.0 - CLIPPED_SHARE) * levels.len() as f64) as usize;
    let bright = levels.get(at).copied().unwrap_or(1.0).max(1e-6);
    // Rounded to two digits, so that the project file has the exact value.
    let scale = 10f32.powf((bright / BRIGHT).log10().floor() - 2.0);
    (bright / BRIGHT / scale).ceil() * scale
}

fn write_pictures(folder: &Folder, meta: &Meta, radiance: &RgbImage) -> Result<(), Failure> {
    let noisy = spoil::with_noise(radiance, meta.seed, meta.camera_noise, meta.exposure);
    picture::write_exr(&folder.path(Format::Exr.file()), &noisy)?;
    let linear = noisy.map(|value| *value / meta.exposure);
    picture::write_png_srgb(&folder.path(Format::Png.file()), &linear)?;
    Ok(atomic::write(&folder.path(Format::Jpeg.file()), &jpeg(&noisy, meta.exposure)?)?)
}

/// The JPEG of a picture.
///
/// # Errors
/// If it cannot be encoded.
pub(crate) fn jpeg(radiance: &RgbImage, exposure: f32) -> Result<Vec<u8>, Failure> {
    let code = |v: &Rgb| Rgb::from_array((*v / exposure).to_array().map(srgb_from_linear));
    Ok(picture::jpeg_bytes(&radiance.map(code), JPEG_QUALITY)?)
}

/// Truth, models and projects of all dials that the scene has.
fn write_models(plan: &Plan, folder: &Folder, meta: &Meta) -> Result<(), Failure> {
    let given = plan.given();
    store::write_truth(folder, plan, &given)?;
    for dial in Dial::ALL {
        let Some(spoilt) = dial.spoilt(plan) else { continue };
        store::write_neutral(&folder.path(&dial.scene_file()), &spoilt.scene())?;
        for format in Format::ALL {
            let text = store::project(plan, &given, format, dial, meta.exposure);
            atomic::write(&folder.project(format, dial), text.as_bytes())?;
        }
    }
    Ok(())
}

/// Compares the photograph with our own rendering of the truth, and prints where they differ; the
/// result is kept.
///
/// # Errors
/// If the photograph cannot be read.
pub(crate) fn verify(plan: &Plan, folder: &Folder) -> Result<bool, Failure> {
    let Some(meta) = folder.meta() else { return Err("there is no photograph".into()) };
    let rows = verify::compare(plan, &kept(folder, &meta)?);
    rows.iter().for_each(|row| println!("{:4} {}", plan.seed, row.text()));
    let is_sound = plan.style.family == Family::Foreign || !rows.iter().any(verify::Row::is_off);
    atomic::write(&folder.path(SOUND), serde_json::to_string(&is_sound)?.as_bytes())?;
    Ok(is_sound)
}

/// The file that keeps whether a photograph agrees with its truth.
const SOUND: &str = "sound.json";

/// Whether the photograph agrees with the truth, by [`mod@verify`], which runs once.
///
/// # Errors
/// If the photograph cannot be read.
pub(crate) fn is_sound(plan: &Plan, folder: &Folder) -> Result<bool, Failure> {
    match std::fs::read_to_string(folder.path(SOUND)) {
        Ok(text) => Ok(serde_json::from_str(&text)?),
        Err(_) => verify(plan, folder),
    }
}
