//! The photograph that a candidate would take, if the materials are right.

use super::{Candidate, RecoveredJob};
use crate::project::Project;
use crate::registered::RegisteredModel;
use crate::shot::Shot;
use std::f32::consts::TAU;
use unrender_formats::picture::{Depth, Picture};
use unrender_photo::{Response, Transfer, develop};
use unrender_recover::{Observation, View};
use unrender_register::margin;
use unrender_render::sampler::mix;
use unrender_render::{Appearance, Film, Integrator, Settings, Tracer};
use unrender_scene::color::luminance;
use unrender_scene::{Rgb, RgbImage, Warnings};

/// Paths per pixel of a first rendering, which shows how many are needed until the rendering's
/// noise is no more than the camera's; the missing noise is added.
const SPP_MIN: u32 = 16;
/// The most paths: at half, photographs with hardly any noise count as noisier than they are, at double a candidate
/// takes twice as long.
const SPP_MAX: u32 = 256;
/// The photograph of `candidate` with the noise of the first one, `observed`, with an exact registration.
pub(super) fn photograph(
    of: &RecoveredJob,
    candidate: &Candidate,
    observed: &Observation,
    seed: u64,
) -> (Shot, RegisteredModel) {
    let job = &of.job;
    let size = (job.photo.radiance.width(), job.photo.radiance.height());
    let tracer = Tracer::new(&job.lit_without(&candidate.off));
    let view = View::new(&tracer, &candidate.camera, size, job.scene.brdf);
    let appearance = Appearance { materials: &of.materials, lights: &[] };
    let geometry = of.tracer.geometry(&candidate.camera, size.0, size.1);
    let noise = &observed.noise_of_photograph[0];
    let camera = |film: &Film, index: usize| {
        let group = geometry.pixels()[index].group as usize;
        let shot = noise.shot_of_group.get(group).copied().unwrap_or(Rgb::ZERO);
        let step = job.photo.quantisation_step.pixels()[index];
        let value = film.mean.pixels()[index] / of.exposure;
        noise.read + shot * value.max(Rgb::ZERO) + step * step / 12.0
    };
    let rendering =
        |film: &Film, index: usize| film.variance.pixels()[index] / (of.exposure * of.exposure);
    let render = |spp: u32| {
        // Pixels that share paths would have correlated noise, which no camera has.
        let (seed, integrator) = (mix(seed ^ 0x97A4), Integrator::Path);
        let settings = Settings { spp, seed, integrator, ..Settings::default() };
        view.render(appearance, &settings, &|_| {})
    };
    let mut film = render(SPP_MIN);
    let ratio = |index: usize| {
        luminance(rendering(&film, index)) / luminance(camera(&film, index)).max(f32::MIN_POSITIVE)
    };
    let mut ratios: Vec<f32> = (0..size.0 * size.1).map(ratio).collect();
    ratios.sort_by(f32::total_cmp);
    let spp = SPP_MIN as f32 * ratios.get(ratios.len() / 2).copied().unwrap_or(0.0);
    if spp > SPP_MIN as f32 {
        film = render((spp as u32).min(SPP_MAX));
    }
    let value = |index: usize| {
        let value = film.mean.pixels()[index] / of.exposure;
        let lacking = (camera(&film, index) - rendering(&film, index)).max(Rgb::ZERO);
        (value + lacking.map(f32::sqrt) * normal(seed, index)).max(Rgb::ZERO)
    };
    let radiance = RgbImage::new(size.0, size.1, (0..size.0 * size.1).map(value).collect());
    let (picture, transfer) =
        (Picture::new(radiance, Depth::Float), Transfer::plain(Response::Linear, Rgb::ONE));
    let mut photo = develop(&picture, &transfer);
    photo.quantisation_step.clone_from(&job.photo.quantisation_step);
    let shot = Shot {
        project: Project { further: Vec::new(), ..job.project.clone() },
        camera: candidate.camera.clone(),
        picture,
        photo,
        mask: None,
        transfer,
        off: candidate.off.clone(),
    };
    let margins = margin::margins(&geometry, None);
    let camera = candidate.camera.clone();
    let registered =
        RegisteredModel { camera, margins, registration: None, warnings: Warnings::default() };
    (shot, registered)
}

/// A normal number for each channel of a pixel [Box and Muller 1958].
fn normal(seed: u64, index: usize) -> Rgb {
    let uniform = |k: u64| {
        let bits = mix(mix(seed) ^ mix(8 * index as u64 + k));
        ((bits >> 40) as f32 + 0.5) / (1u64 << 24) as f32
    };
    let one = |channel: u64| {
        let (radius, angle) = (uniform(2 * channel), uniform(2 * channel + 1));
        (-2.0 * radius.ln()).sqrt() * (TAU * angle).cos()
    };
    Rgb::new(one(0), one(1), one(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_is_that_of_a_normal_number() {
        let numbers: Vec<f64> = (0..4000).map(|i| f64::from(normal(7, i).y)).collect();
        let mean = numbers.iter().sum::<f64>() / 4000.0;
        let variance = numbers.iter().map(|v| v * v).sum::<f64>() / 4000.0;
        let beyond = numbers.iter().filter(|v| v.abs() > 2.0).count() as f64 / 4000.0;
        // Three standard errors: 0.047, 0.067 and 0.010.
        assert!(mean.abs() < 0.047 && (variance - 1.0).abs() < 0.067, "{mean}, {variance}");
        assert!((beyond - 0.0455).abs() < 0.010, "{beyond}");
    }
}
