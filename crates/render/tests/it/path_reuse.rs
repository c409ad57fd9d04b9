//! Path reuse: the estimate is unbiased, its variance is lower, and its bits do not depend on
//! threads or shards.

use crate::common::{Estimate, Stage, assert_agree, camera, plate_corners, quad_mesh, settings};
use glam::{DVec3, Vec3};
use unrender_render::adaptive::SampleAllocation;
use unrender_render::{Accumulator, Integrator, Settings};
use unrender_scene::{Camera, LightKind, Material, Rgb};

const SIDE: usize = 20;

fn view() -> Camera {
    camera(Vec3::new(0.0, 0.0, 0.95), Vec3::new(0.0, -0.2, 0.0), 1.2)
}

/// A room with a lamp, a spot light, an anisotropic floor, a glossy ball, a mirror, and a plate
/// with a mirror and a diffuse term.
fn room() -> Stage {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(Rgb::new(0.7, 0.5, 0.3)), Rgb::ZERO);
    stage.room(wall, Vec3::ONE);
    let brushed = Material {
        alpha_y: 0.3,
        theta_rad: 0.5,
        ..Material::isotropic(Rgb::splat(0.1), Rgb::new(0.5, 0.6, 0.4), 0.1)
    };
    let floor = stage.group(brushed, Rgb::ZERO);
    stage.plate(floor, Vec3::new(0.0, -0.98, 0.0), Vec3::Z, Vec3::X);
    let ball = stage.group(Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.5), 0.2), Rgb::ZERO);
    stage.sphere(ball, Vec3::new(0.2, -0.5, 0.0), 0.4, 12);
    let mirror = stage.group(Material::mirror(Rgb::splat(0.9)), Rgb::ZERO);
    stage.plate(mirror, Vec3::new(-0.6, 0.0, -0.95), 0.3 * Vec3::X, 0.5 * Vec3::Y);
    let both = Material { rho_d: Rgb::splat(0.3), ..Material::mirror(Rgb::splat(0.5)) };
    let glazed = stage.group(both, Rgb::ZERO);
    stage.plate(glazed, Vec3::new(0.6, 0.0, -0.95), 0.3 * Vec3::X, 0.5 * Vec3::Y);
    // Shaded smooth over an edge: its shading normals face away from the camera and from much of the room.
    let mut edge =
        quad_mesh(plate_corners(Vec3::new(-0.95, 0.3, 0.0), 0.5 * Vec3::Y, 0.4 * Vec3::Z), &[]);
    edge.normals.fill(Vec3::new(0.3, 0.3, -0.9).normalize());
    stage.mesh(wall, edge);
    let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::splat(5.0));
    stage.plate(lamp, Vec3::new(0.0, 0.98, 0.0), 0.3 * Vec3::X, 0.3 * Vec3::Z);
    stage.light(LightKind::Spot {
        position: Vec3::new(-0.8, 0.8, 0.5),
        direction: Vec3::new(1.0, -1.0, -0.5).normalize(),
        intensity: Rgb::splat(1.0),
        inner_rad: 0.2,
        outer_rad: 0.4,
    });
    stage
}

/// The mean over the pixels, with its standard deviation estimated from several pictures, since the
/// pixels of one picture are correlated; and the sum of the estimated variances.
fn mean(stage: &Stage, pictures: u64, settings: Settings) -> (Estimate, DVec3) {
    let (tracer, materials) = (stage.tracer(), stage.scene.materials());
    let film = |seed| {
        let settings = Settings { seed, ..settings };
        tracer.render(&materials, &view(), (SIDE, SIDE), &settings, &|_| ())
    };
    let films: Vec<_> = (0..pictures).map(film).collect();
    let means: Vec<DVec3> = films.iter().map(|film| Estimate::of_film(film).mean).collect();
    let variance = films.iter().flat_map(|film| film.variance.pixels());
    (Estimate::of_samples(&means), variance.map(|v| v.as_dvec3()).sum())
}

#[test]
fn path_reuse_is_unbiased_and_reduces_the_variance() {
    path_reuse_is_unbiased(&[2, 20], 12, 8e-3);
}

#[test]
#[ignore = "slow: eight times as many pictures"]
fn path_reuse_is_unbiased_to_three_thousandths() {
    path_reuse_is_unbiased(&[2, 3, 20], 100, 3e-3);
}

/// Compares means of so many `pictures` of paths of each length, whose noise is below `noise_max` of them.
fn path_reuse_is_unbiased(lengths: &[u32], pictures: u64, noise_max: f64) {
    let stage = room();
    for &max_bounces in lengths {
        let alone = Settings { max_bounces, ..settings(32) };
        let reused = Settings { integrator: Integrator::PathReuse, ..alone };
        let (expected, before) = mean(&stage, pictures, alone);
        let (found, after) = mean(&stage, pictures, reused);
        assert_agree(&format!("{max_bounces} bounces"), found, expected, noise_max);
        let share = (after / before).max_element();
        assert!(share < 0.5, "{max_bounces} bounces: {share} of the variance");
    }
}

#[test]
fn where_path_reuse_does_not_pay_paths_are_independent() {
    let is_alike = |stage: &Stage| {
        let reused = Settings { integrator: Integrator::PathReuse, ..settings(4) };
        stage.render(&view(), SIDE, settings(4)) == stage.render(&view(), SIDE, reused)
    };
    assert!(is_alike(&chequers()) && !is_alike(&room()));
}

/// A wall of many small squares of two colours in the sun: all of the variance lies in which of
/// them a sample hits.
fn chequers() -> Stage {
    let mut stage = Stage::default();
    let colours = [0.1, 0.8].map(|rho| stage.group(Material::diffuse(Rgb::splat(rho)), Rgb::ZERO));
    for (x, y) in (0..1600).map(|i| (i % 40, i / 40)) {
        let centre = Vec3::new(0.05 * x as f32 - 1.0, 0.05 * y as f32 - 1.0, -0.5);
        stage.plate(colours[(x + y) % 2], centre, 0.025 * Vec3::X, 0.025 * Vec3::Y);
    }
    let direction = Vec3::new(0.3, -0.5, -1.0).normalize();
    stage.light(LightKind::Directional { direction, irradiance: Rgb::ONE });
    stage
}

#[test]
fn each_pixel_has_its_own_mean() {
    pixels_have_their_own_means(1024);
}

#[test]
#[ignore = "slow: four times as many paths"]
fn each_pixel_has_its_own_mean_by_four_thousand_paths() {
    pixels_have_their_own_means(4096);
}

/// Compares pixels of `spp` independent paths with those of a quarter of them that are reused.
fn pixels_have_their_own_means(spp: u32) {
    // A bias that moves light from one pixel to its neighbour would not show in the mean of all.
    let stage = room();
    let alone = stage.render(&view(), SIDE, settings(spp));
    let reused = stage.render(
        &view(),
        SIDE,
        Settings { integrator: Integrator::PathReuse, ..settings(spp / 4) },
    );
    let mut worst = 0.0f64;
    for (pixel, (a, b)) in alone.mean.pixels().iter().zip(reused.mean.pixels()).enumerate() {
        let variance = alone.variance.pixels()[pixel] + reused.variance.pixels()[pixel];
        let z = (*a - *b).as_dvec3() / variance.as_dvec3().map(f64::sqrt);
        worst = worst.max(z.abs().max_element());
    }
    // 1200 numbers, each of which is beyond 5.5 once in 26 million times.
    assert!(worst < 5.5, "a pixel is {worst} standard deviations off");
}

#[test]
fn a_furnace_stays_white() {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(Rgb::splat(0.5)), Rgb::ONE);
    stage.room(wall, Vec3::ONE);
    let reused = Settings { integrator: Integrator::PathReuse, ..settings(64) };
    let (found, _) = mean(&stage, 20, reused);
    assert_agree("furnace", found, Estimate::exactly(Rgb::splat(2.0)), 1.6e-3);
}

#[test]
fn threads_and_shards_change_no_bit() {
    let stage = room();
    let (tracer, materials) = (stage.tracer(), stage.scene.materials());
    let settings = Settings { integrator: Integrator::PathReuse, ..settings(7) };
    let shard = |samples: SampleAllocation<'_>, threads: usize| {
        let mut accumulator = Accumulator::new(SIDE, SIDE);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            tracer.accumulate(&materials, &view(), &settings, &samples, &mut accumulator, &|_| ());
        });
        accumulator
    };
    let whole = shard(SampleAllocation::Uniform(0..7), 1);
    let mut sum = shard(SampleAllocation::Uniform(3..7), 3);
    sum.add(&shard(SampleAllocation::Uniform(0..3), 2));
    assert!(sum == whole);
    assert!(stage.render(&view(), SIDE, settings) == whole.film());
    // The same with adaptive sampling.
    let sampling = tracer.adaptive_sampling(&materials, &view(), (SIDE, SIDE), &settings, &|_| ());
    let whole = shard(SampleAllocation::Adaptive(&sampling, 0..7), 1);
    let mut sum = shard(SampleAllocation::Adaptive(&sampling, 0..2), 2);
    sum.add(&shard(SampleAllocation::Adaptive(&sampling, 2..7), 1));
    assert!(sum == whole);
    let counts = |i: usize| whole.image().pixels()[i].count as usize;
    assert!((0..SIDE * SIDE).all(|i| counts(i) == sampling.samples(i, 0..7).len()));
}
