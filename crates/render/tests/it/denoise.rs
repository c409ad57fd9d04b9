//! Denoising: how much noise is left of what is known, and what of the picture stays.

use glam::Vec3;
use unrender_render::adaptive::SampleAllocation;
use unrender_render::denoise::{self, Denoised, Halves};
use unrender_render::sampler::mix;
use unrender_render::{Accumulator, FeatureBuffers, PixelFeatures, Settings, Tracer};
use unrender_scene::{
    Camera, Environment, Group, Image, Material, Mesh, Object, Rgb, RgbImage, Scene,
};

const SIDE: usize = 40;
/// Samples a pixel and half.
const SAMPLES: u32 = 16;

/// A number in -1..1 for every sample.
fn noise(half: usize, pixel: usize, sample: u32) -> f32 {
    let bits = mix(((half as u64) << 60) ^ ((pixel as u64) << 20) ^ u64::from(sample) ^ 0x5eed);
    (bits >> 40) as f32 / (1u64 << 23) as f32 - 1.0
}

fn wall(_: usize) -> PixelFeatures {
    let (emission, reflectance) = (Rgb::ZERO, Rgb::splat(0.5));
    PixelFeatures { emission, reflectance, normal: Vec3::Z, nearness: 0.25, is_mixed: false }
}

/// Halves whose samples are those of `sample`(half, pixel, number).
fn samples(sample: impl Fn(usize, usize, u32) -> f32) -> [Accumulator; 2] {
    [0, 1].map(|half| {
        let mut accumulator = Accumulator::new(SIDE, SIDE);
        for (pixel, sums) in accumulator.image_mut().pixels_mut().iter_mut().enumerate() {
            (0..SAMPLES).for_each(|n| sums.push(Rgb::splat(sample(half, pixel, n))));
        }
        accumulator
    })
}

fn denoised(samples: &[Accumulator; 2], features: impl Fn(usize) -> PixelFeatures) -> Denoised {
    let features: FeatureBuffers = Image::new(SIDE, SIDE, (0..SIDE * SIDE).map(features).collect());
    denoise::denoise(&Halves {
        samples: [&samples[0], &samples[1]],
        features: [&features; 2],
        finer: &features,
    })
}

/// The mean over the picture.
fn mean(picture: &RgbImage) -> f64 {
    let sum: f64 = picture.pixels().iter().map(|p| f64::from(p.x)).sum();
    sum / picture.pixels().len() as f64
}

/// The root mean square difference from `truth`(pixel).
fn rmse(picture: &RgbImage, truth: impl Fn(usize) -> f32) -> f64 {
    let squares = picture.pixels().iter().enumerate();
    let sum: f64 = squares.map(|(pixel, p)| f64::from(p.x - truth(pixel)).powi(2)).sum();
    (sum / picture.pixels().len() as f64).sqrt()
}

fn whole(halves: &[Accumulator; 2]) -> RgbImage {
    let mut whole = halves[0].clone();
    whole.add(&halves[1]);
    whole.mean()
}

#[test]
fn flat_noise_is_reduced_as_by_a_regression_over_the_window() {
    let halves = samples(|half, pixel, n| 1.0 + noise(half, pixel, n));
    let found = denoised(&halves, wall);
    let (before, after) = (rmse(&whole(&halves), |_| 1.0), rmse(&found.radiance, |_| 1.0));
    // Uniform noise of variance 1/3, 32 samples a pixel.
    assert!((before - f64::sqrt(1.0 / 96.0)).abs() < 0.03 * before, "{before}");
    // Three numbers (mean and two slopes) from 19 x 19 pixels leave sqrt(3 / 361) = 0.09 of the noise, models of
    // several pixels less; no filter of that width less than 1 / 19.
    assert!((0.05..0.12).contains(&(after / before)), "{}", after / before);
    assert!((mean(&found.radiance) - mean(&whole(&halves))).abs() < 1.5e-3);
    assert!(found.untouched < 0.01);
    // The estimated error of a picture of this size is a rough one.
    assert!(found.error < 0.3 * before, "{} {before}", found.error);
}

#[test]
fn edges_that_a_feature_shows_are_kept() {
    let right = |pixel: usize| pixel % SIDE >= SIDE / 2;
    let truth = |pixel: usize| if right(pixel) { 1.3 } else { 1.0 };
    let halves = samples(|half, pixel, n| truth(pixel) + 0.9 * noise(half, pixel, n));
    let features = |pixel: usize| {
        let normal = if right(pixel) { Vec3::X } else { Vec3::Z };
        PixelFeatures { normal, ..wall(pixel) }
    };
    let (seen, blind) = (denoised(&halves, features), denoised(&halves, wall));
    let (with, without) = (rmse(&seen.radiance, truth), rmse(&blind.radiance, truth));
    assert!(with < 0.25 * rmse(&whole(&halves), truth), "{with}");
    assert!(with < 0.8 * without, "{with} {without}");
}

#[test]
fn what_has_no_noise_stays_as_it_is() {
    let truth =
        |pixel: usize| if (pixel / 3 + pixel / SIDE / 3).is_multiple_of(2) { 0.2 } else { 3.0 };
    let found = denoised(&samples(|_, pixel, _| truth(pixel)), wall);
    assert!(rmse(&found.radiance, truth) < 1e-3, "{}", rmse(&found.radiance, truth));
    let black = denoised(&samples(|_, _, _| 0.0), |_| PixelFeatures::default());
    assert!(black.radiance.pixels().iter().all(|p| *p == Rgb::ZERO));
    assert!(black.error.is_finite());
}

#[test]
fn outliers_and_faulty_samples_leave_finite_numbers_and_their_surroundings() {
    let halves = samples(|half, pixel, n| match (pixel, n) {
        (500, 3) if half == 0 => 1e6,
        (900, 1) => f32::NAN,
        (1000, _) => f32::INFINITY,
        (1100, 0) => 1e30,
        _ => 1.0 + noise(half, pixel, n),
    });
    let found = denoised(&halves, wall);
    let good = |p: &Rgb| p.is_finite() && p.min_element() >= 0.0;
    assert!(found.radiance.pixels().iter().all(good));
    assert!(found.error.is_finite());
    // Far from them nothing changes.
    let far: Vec<f32> = (0..8 * SIDE).map(|pixel| found.radiance.pixels()[pixel].x).collect();
    assert!(far[..2 * SIDE].iter().all(|v| (v - 1.0).abs() < 0.1));
}

#[test]
fn pixels_with_few_samples_or_none_are_no_fault() {
    for count in [0, 1, 2] {
        let halves = [0, 1].map(|half| {
            let mut accumulator = Accumulator::new(SIDE, SIDE);
            for (pixel, sums) in accumulator.image_mut().pixels_mut().iter_mut().enumerate() {
                (half..count).for_each(|n| sums.push(Rgb::splat(1.0 + noise(0, pixel, n))));
            }
            accumulator
        });
        let halves = [&halves[0], &halves[1]];
        let features: FeatureBuffers = Image::new(SIDE, SIDE, vec![wall(0); SIDE * SIDE]);
        let found = denoise::denoise(&Halves {
            samples: halves,
            features: [&features; 2],
            finer: &features,
        });
        assert!(found.radiance.pixels().iter().all(|p| p.is_finite()));
    }
}

/// Balls on a floor in a bright and a dark half of the sky, one of them a mirror; a lamp above.
fn scene() -> Scene {
    let mut scene = Scene::default();
    let materials = [
        Material::diffuse(Rgb::new(0.7, 0.5, 0.3)),
        Material::isotropic(Rgb::splat(0.4), Rgb::splat(0.1), 0.3),
        Material::mirror(Rgb::splat(0.9)),
        Material::diffuse(Rgb::ZERO),
    ];
    let floor = [-3.0, 3.0].map(|x| [Vec3::new(x, 0.0, -3.0), Vec3::new(x, 0.0, 3.0)]).concat();
    let lamp: Vec<Vec3> = floor.iter().map(|p| 0.6 * *p + 6.0 * Vec3::Y).collect();
    let meshes = [
        Mesh::flat(&floor, &[], &[[0, 1, 2], [2, 1, 3]]),
        Mesh::sphere(Vec3::new(-1.1, 1.0, 0.0), 1.0),
        Mesh::sphere(Vec3::new(1.1, 1.0, 0.0), 1.0),
        Mesh::flat(&lamp, &[], &[[0, 2, 1], [2, 3, 1]]),
    ];
    for (index, (material, mesh)) in materials.into_iter().zip(meshes).enumerate() {
        let name = format!("{index}");
        let emission = if index == 3 { Rgb::splat(5.0) } else { Rgb::ZERO };
        scene.groups.push(Group { name: name.clone(), material, emission });
        scene.objects.push(Object { name, group: index, mesh });
    }
    let sky = RgbImage::new(2, 1, vec![Rgb::splat(0.2), Rgb::splat(0.8)]);
    scene.environment = Some(Environment::new(sky, 0.0).unwrap());
    scene
}

/// The same balls, none of them a mirror, in a closed room with a lamp behind the camera: most light is indirect.
fn room() -> Scene {
    let mut scene = scene();
    scene.environment = None;
    scene.groups[2].material = Material::diffuse(Rgb::new(0.3, 0.5, 0.7));
    let corner = |i: usize| {
        let side = |bit: usize, low: f32, high: f32| if i & bit == 0 { low } else { high };
        Vec3::new(side(1, -3.0, 3.0), side(2, 0.0, 6.0), side(4, -3.0, 7.0))
    };
    let corners: Vec<Vec3> = (0..8).map(corner).collect();
    let sides =
        [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 3, 6, 7], [0, 2, 4, 6], [1, 3, 5, 7]];
    let triangles = sides.map(|[a, b, c, d]| [[a, b, c], [c, b, d]]).concat();
    scene.objects[0].mesh = Mesh::flat(&corners, &[], &triangles);
    let lamp = [(-1.0, 5.0), (-1.0, 6.0), (1.0, 5.0), (1.0, 6.0)];
    let lamp = lamp.map(|(x, z)| Vec3::new(x, 5.5, z));
    scene.objects[3].mesh = Mesh::flat(&lamp, &[], &[[0, 2, 1], [2, 3, 1]]);
    scene
}

fn camera() -> Camera {
    Camera::look_at("camera", Vec3::new(0.0, 2.5, 6.0), Vec3::new(0.0, 1.2, 0.0), Vec3::Y, 0.7)
}

/// The halves of a picture with `spp` samples a pixel.
fn halves(tracer: &Tracer, materials: &[Material], settings: &Settings) -> [Accumulator; 2] {
    [0, 1].map(|half| {
        let mut accumulator = Accumulator::new(SIDE, SIDE);
        let samples = SampleAllocation::Uniform(0..settings.spp);
        tracer.accumulate_half(
            materials,
            &camera(),
            settings,
            (&samples, half),
            &mut accumulator,
            &|_| {},
        );
        accumulator
    })
}

#[test]
fn a_rendering_has_half_of_its_error_and_the_same_bits_with_any_number_of_threads() {
    let scene = room();
    let (tracer, materials) = (Tracer::new(&scene), scene.materials());
    let truth = halves(&tracer, &materials, &Settings { spp: 512, seed: 1, ..Settings::default() });
    let truth = truth.each_ref().map(Accumulator::mean);
    let settings = Settings { spp: 64, ..Settings::default() };
    let halves = halves(&tracer, &materials, &settings);
    let denoised = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let samples = [&halves[0], &halves[1]];
        pool.install(|| tracer.denoise(&materials, &camera(), &settings, samples)).radiance
    };
    let found = denoised(1);
    assert_eq!(found, denoised(2));
    // Without bias by the noise of the truth, which has two halves as well.
    let mse = |picture: &RgbImage| -> f64 {
        let pixels = picture.pixels().iter().zip(truth[0].pixels()).zip(truth[1].pixels());
        pixels.map(|((p, a), b)| f64::from((*p - *a).dot(*p - *b))).sum()
    };
    let ratio = (mse(&found) / mse(&whole(&halves))).sqrt();
    // Much of so small a picture is edges; in larger ones a third is left (docs/validation/denoise.md).
    assert!(ratio < 0.5, "{ratio}");
}

#[test]
fn emission_seen_directly_and_in_mirrors_is_that_of_the_samples() {
    let mut scene = scene();
    scene.groups[0].material = Material::diffuse(Rgb::ZERO);
    scene.groups[1].material = Material::diffuse(Rgb::ZERO);
    let (tracer, materials) = (Tracer::new(&scene), scene.materials());
    let settings = Settings { spp: 8, ..Settings::default() };
    let halves = halves(&tracer, &materials, &settings);
    let features = tracer.features(&materials, &camera(), &settings, &halves[0]);
    let pairs = features.pixels().iter().zip(halves[0].image().pixels());
    for (feature, samples) in pairs {
        let difference = (feature.emission - samples.mean()).abs().max_element();
        assert!(difference < 1e-5, "{feature:?} {samples:?}");
    }
}
