//! Adaptive sampling: it puts samples where the variance is high, reduces the noise, and is
//! unbiased.

use crate::common::{Estimate, Stage, assert_agree, camera};
use glam::{DVec3, Vec3};
use unrender_render::adaptive::{AdaptiveSampling, SampleAllocation};
use unrender_render::{Accumulator, Settings};
use unrender_scene::{Camera, Material, Rgb};

/// A closed room whose walls all have the same emission and reflectance. The radiance of the walls
/// is the emission over one minus the reflectance.
fn room() -> Stage {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(RHO), EMISSION);
    stage.room(wall, Vec3::ONE);
    stage
}

const RHO: Rgb = Rgb::new(0.5, 0.6, 0.7);
const EMISSION: Rgb = Rgb::new(0.4, 1.0, 0.2);

fn view() -> Camera {
    camera(Vec3::new(0.0, 0.0, 0.9), Vec3::new(0.1, 0.2, -1.0), 1.0)
}

const SIDE: usize = 20;

/// The picture with `spp` samples per pixel on average, adaptive or uniform.
fn rendered(stage: &Stage, seed: u64, spp: u32, adaptive: bool) -> Accumulator {
    let (tracer, materials) = (stage.tracer(), stage.scene.materials());
    let settings = Settings { spp, seed, ..Settings::default() };
    let mut accumulator = Accumulator::new(SIDE, SIDE);
    let sampling = adaptive
        .then(|| tracer.adaptive_sampling(&materials, &view(), (SIDE, SIDE), &settings, &|_| ()));
    let samples = match &sampling {
        Some(sampling) => SampleAllocation::Adaptive(sampling, 0..spp),
        None => SampleAllocation::Uniform(0..spp),
    };
    tracer.accumulate(&materials, &view(), &settings, &samples, &mut accumulator, &|_| ());
    accumulator
}

#[test]
fn adaptive_sampling_is_unbiased() {
    // Many pictures of few samples each: with 80 x 400 pixels a bias of one percent would show.
    let stage = room();
    let expected = Estimate::exactly(EMISSION / (Rgb::ONE - RHO));
    assert_agree("adaptive", mean_of_many(&stage, 80, 6, true), expected, 1.9e-3);
}

/// The mean over several pictures, with its standard deviation.
fn mean_of_many(stage: &Stage, pictures: u64, spp: u32, adaptive: bool) -> Estimate {
    let mean = |seed| Estimate::of_film(&rendered(stage, seed, spp, adaptive).film()).mean;
    Estimate::of_samples(&(0..pictures).map(mean).collect::<Vec<DVec3>>())
}

/// The room with a black plate before half of it, where the variance is zero.
fn half_a_room() -> Stage {
    let mut stage = room();
    let hole = stage.group(Material::diffuse(Rgb::ZERO), Rgb::ZERO);
    stage.plate(hole, Vec3::new(-0.5, 0.0, -0.5), 0.5 * Vec3::X, Vec3::Y);
    stage
}

#[test]
fn adaptive_sampling_reduces_the_noise() {
    let stage = half_a_room();
    let (uniform, adaptive) = (rendered(&stage, 1, 64, false), rendered(&stage, 1, 64, true));
    let mean = |picture: &Accumulator| {
        let counts = picture.image().pixels().iter().map(|m| f64::from(m.count));
        counts.sum::<f64>() / (SIDE * SIDE) as f64
    };
    assert_eq!(mean(&uniform), 64.0);
    assert!((mean(&adaptive) - 64.0).abs() < 1.0, "{} a pixel", mean(&adaptive));
    let calm = adaptive.image().at(1, SIDE / 2).count;
    assert_eq!(calm, 16, "a quarter of the mean where the variance is zero");
    let (before, after) = (uniform.noise(), adaptive.noise());
    assert!(after < 0.85 * before, "the noise {before} has become {after}");
}

#[test]
fn passes_are_consecutive_and_every_pixel_has_two_samples() {
    let stage = half_a_room();
    let pilot = rendered(&stage, 7, 16, false);
    let sampling = AdaptiveSampling::from_pilot(&pilot);
    for pixel in 0..SIDE * SIDE {
        assert_eq!(sampling.samples(pixel, 0..2).end.min(2), 2);
        let mut end = 0;
        for mean in 0..40 {
            let samples = sampling.samples(pixel, mean..mean + 1);
            assert_eq!(samples.start, end);
            end = samples.end;
        }
        assert_eq!(sampling.samples(pixel, 0..40), 0..end);
    }
    // Without variance the allocation is uniform.
    let calm = AdaptiveSampling::from_pilot(&Accumulator::new(9, 5));
    assert!((0..45).all(|pixel| calm.samples(pixel, 3..50) == (3..50)));
}
