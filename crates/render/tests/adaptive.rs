//! Proves that samples go where the noise is, that this makes less of it, and that it biases
//! nothing.

mod common;

use common::{Estimate, Stage, assert_agree, camera};
use glam::{DVec3, Vec3};
use unrender_render::adaptive::{Samples, Shares};
use unrender_render::{Settings, Tally};
use unrender_scene::{Camera, Material, Rgb};

/// A closed room whose walls all emit and reflect alike, with a calm white lamp before one half of
/// the view. The walls' radiance is known: emission over one minus reflectance.
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

/// The picture with `spp` paths a pixel on average, by shares or evenly.
fn rendered(stage: &Stage, seed: u64, spp: u32, adaptive: bool) -> Tally {
    let (tracer, materials) = (stage.tracer(), stage.scene.materials());
    let settings = Settings { spp, seed, ..Settings::default() };
    let mut tally = Tally::new(SIDE, SIDE);
    let shares =
        adaptive.then(|| tracer.shares(&materials, &view(), (SIDE, SIDE), &settings, &|_| ()));
    let samples = match &shares {
        Some(shares) => Samples::ByNoise(shares, 0..spp),
        None => Samples::Even(0..spp),
    };
    tracer.accumulate(&materials, &view(), &settings, &samples, &mut tally, &|_| ());
    tally
}

#[test]
fn a_known_mean_is_met_without_bias() {
    // Many pictures of few paths each, whose pilots are as noisy as can be: with 200 x 400 pixels a
    // bias of half a percent would show.
    let stage = room();
    let expected = Estimate::exactly(EMISSION / (Rgb::ONE - RHO));
    assert_agree("adaptive", mean_of_many(&stage, 200, 6, true), expected, 1.2e-3);
}

/// The mean over a number of pictures, with the deviation that these show.
fn mean_of_many(stage: &Stage, pictures: u64, spp: u32, adaptive: bool) -> Estimate {
    let mean = |seed| Estimate::of_film(&rendered(stage, seed, spp, adaptive).film()).mean;
    Estimate::of_samples(&(0..pictures).map(mean).collect::<Vec<DVec3>>())
}

/// The room with a black hole before half of it, where nothing is noisy.
fn half_a_room() -> Stage {
    let mut stage = room();
    let hole = stage.group(Material::diffuse(Rgb::ZERO), Rgb::ZERO);
    stage.plate(hole, Vec3::new(-0.5, 0.0, -0.5), 0.5 * Vec3::X, Vec3::Y);
    stage
}

#[test]
fn samples_go_where_the_noise_is_and_make_less_of_it() {
    let stage = half_a_room();
    let (even, adaptive) = (rendered(&stage, 1, 64, false), rendered(&stage, 1, 64, true));
    let mean = |tally: &Tally| {
        let counts = tally.moments().pixels().iter().map(|m| f64::from(m.count));
        counts.sum::<f64>() / (SIDE * SIDE) as f64
    };
    assert_eq!(mean(&even), 64.0);
    assert!((mean(&adaptive) - 64.0).abs() < 1.0, "{} a pixel", mean(&adaptive));
    let calm = adaptive.moments().at(1, SIDE / 2).count;
    assert_eq!(calm, 16, "a quarter of the mean where nothing is noisy");
    let (before, after) = (even.noise(), adaptive.noise());
    assert!(after < 0.85 * before, "the noise {before} has become {after}");
}

#[test]
fn passes_follow_each_other_and_every_pixel_has_two_paths() {
    let stage = half_a_room();
    let pilot = rendered(&stage, 7, 16, false);
    let shares = Shares::by_noise(&pilot);
    for pixel in 0..SIDE * SIDE {
        assert_eq!(shares.samples(pixel, 0..2).end.min(2), 2);
        let mut end = 0;
        for mean in 0..40 {
            let samples = shares.samples(pixel, mean..mean + 1);
            assert_eq!(samples.start, end);
            end = samples.end;
        }
        assert_eq!(shares.samples(pixel, 0..40), 0..end);
    }
    // Without any noise all pixels are alike.
    let calm = Shares::by_noise(&Tally::new(9, 5));
    assert!((0..45).all(|pixel| calm.samples(pixel, 3..50) == (3..50)));
}
