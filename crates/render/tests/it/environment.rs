//! Proves light from all around against closed forms: furnaces, a sky whose irradiance is known, a
//! sun that is a directional light, mirrors that show the panorama, and that sampling follows its
//! density.

use crate::common::{Estimate, Random, Stage, assert_agree, camera, settings};
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_1_PI, PI, TAU};
use unrender_render::environment::EnvironmentSampler;
use unrender_render::{Appearance, Parameter, ProbeSettings, Query};
use unrender_scene::{Environment, LightKind, Material, Rgb, RgbImage, UpAxis, WardModel};

const RHO: Rgb = Rgb::new(0.2, 0.5, 0.8);
const BLACK: Rgb = Rgb::ZERO;

fn environment(panorama: RgbImage, rotation_deg: f32) -> Environment {
    Environment::new(panorama, rotation_deg.to_radians()).unwrap()
}

fn constant(radiance: Rgb) -> Environment {
    environment(RgbImage::from_fn(8, 4, |_, _| radiance), 0.0)
}

/// Radiance `y` times `zenith` above the horizon and none below: a floor has the irradiance
/// `2 pi / 3` times `zenith`.
fn sky(zenith: Rgb) -> Environment {
    let height = 512;
    let y = |row: usize| Environment::cos_polar((row as f32 + 0.5) / height as f32).max(0.0);
    environment(RgbImage::from_fn(4, height, |_, row| zenith * y(row)), 30.0)
}

/// A panorama of `8 x 4` pixels of many brightnesses, some of them black.
fn motley() -> Environment {
    let mut random = Random::new(5);
    let panorama = RgbImage::from_fn(8, 4, |x, y| match (x, y) {
        (0..3, 1..3) => BLACK,
        (5, 1) => random.rgb(20.0, 30.0),
        _ => random.rgb(0.0, 1.0),
    });
    environment(panorama, 77.0)
}

fn floor(material: Material, environment: Environment) -> Stage {
    let mut stage = Stage::default();
    let floor = stage.group(material, BLACK);
    stage.plate(floor, Vec3::ZERO, 5.0 * Vec3::Z, 5.0 * Vec3::X);
    stage.scene.environment = Some(environment);
    stage
}

/// The middle of the floor, seen by a camera so narrow that it sees one point.
fn seen(stage: &Stage, spp: u32) -> Estimate {
    let camera = camera(Vec3::new(0.8, 2.0, 1.5), Vec3::ZERO, 2e-3);
    Estimate::of_film(&stage.render(&camera, 16, settings(spp)))
}

#[test]
fn directions_are_drawn_by_their_density() {
    for up in [UpAxis::Y, UpAxis::Z] {
        directions_follow_their_density(&motley().with_up(up));
    }
}

fn directions_follow_their_density(environment: &Environment) {
    let sampler = EnvironmentSampler::new(environment).unwrap();
    // Each of these cells lies within one of the sampler's.
    let (columns, rows) = (32, 16);
    let centre = |cell: usize| {
        let (column, row) = (cell % columns, cell / columns);
        let edges = [row, row + 1].map(|r| Environment::cos_polar(r as f32 / rows as f32));
        let solid_angle = TAU / columns as f32 * (edges[0] - edges[1]);
        let u = (column as f32 + 0.5) / columns as f32;
        (environment.direction(u, 0.5 * (edges[0] + edges[1])), solid_angle)
    };
    let expected: Vec<f64> = (0..columns * rows)
        .map(|cell| {
            let (direction, solid_angle) = centre(cell);
            f64::from(sampler.pdf(direction) * solid_angle)
        })
        .collect();
    assert!((expected.iter().sum::<f64>() - 1.0).abs() < 1e-5);
    let mut counts = vec![0u32; columns * rows];
    let mut random = Random::new(3);
    let samples = 1_000_000;
    for _ in 0..samples {
        let [u, v, _] = random.next3();
        let (wi, pdf) = sampler.sample([u, v]);
        assert!((wi.length() - 1.0).abs() < 1e-5 && pdf > 0.0);
        let (u, v) = environment.place(wi);
        let column = ((u * columns as f32) as usize).min(columns - 1);
        let row = ((v * rows as f32) as usize).min(rows - 1);
        counts[row * columns + column] += 1;
    }
    let (mut chi_squared, mut cells) = (0.0, 0.0);
    for (count, expected) in counts.into_iter().zip(expected) {
        let expected = expected * f64::from(samples);
        if expected < 1e-3 {
            assert_eq!(count, 0, "directions without light are not drawn");
            continue;
        }
        chi_squared += (f64::from(count) - expected).powi(2) / expected;
        cells += 1.0;
    }
    let z = (chi_squared - (cells - 1.0)) / f64::sqrt(2.0 * (cells - 1.0));
    assert!(cells > 300.0 && z < 4.0, "chi-squared {chi_squared} in {cells} cells");
}

#[test]
fn a_scene_with_z_upwards_is_lit_as_the_same_with_y_upwards() {
    let of = |up: UpAxis| {
        let mut stage = Stage::default();
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| up.from_y_up(axis));
        let glossy = Material::isotropic(RHO, Rgb::splat(0.1), 0.3);
        let floor = stage.group(glossy, BLACK);
        stage.plate(floor, Vec3::ZERO, 5.0 * z, 5.0 * x);
        let wall = stage.group(Material::diffuse(RHO), BLACK);
        stage.plate(wall, -0.5 * z + 0.5 * y, 0.6 * x, 0.5 * y);
        stage.scene.environment = Some(motley().with_up(up));
        let (eye, target) = (0.8 * x + 0.9 * y + 2.0 * z, 0.3 * y);
        let camera = unrender_scene::Camera::look_at("c", eye, target, y, 0.9);
        Estimate::of_film(&stage.render(&camera, 32, settings(256)))
    };
    assert_agree("y and z upwards", of(UpAxis::Y), of(UpAxis::Z), 0.01);
}

#[test]
fn white_things_vanish_in_an_even_environment() {
    let radiance = Rgb::new(2.0, 1.0, 0.5);
    let ball = |material| {
        let mut stage = Stage::default();
        let ball = stage.group(material, BLACK);
        stage.sphere(ball, Vec3::ZERO, 0.5, 24);
        stage.scene.environment = Some(constant(radiance));
        stage.scene.brdf = WardModel::WardGmd.into();
        stage
    };
    let whole = camera(Vec3::new(0.3, 0.4, 1.8), Vec3::ZERO, 1.0);
    let narrow = camera(Vec3::new(0.3, 0.4, 1.8), Vec3::new(0.03, 0.02, 0.0), 0.3);
    for (material, view) in
        [(Material::diffuse(Rgb::ONE), whole), (Material::mirror(Rgb::ONE), narrow.clone())]
    {
        let film = ball(material).render(&view, 16, settings(256));
        assert_agree("white", Estimate::of_film(&film), Estimate::exactly(radiance), 1e-3);
    }
    for alpha in [0.02, 0.1, 0.3, 0.8] {
        let material = Material::isotropic(BLACK, Rgb::ONE, alpha);
        let found = Estimate::of_film(&ball(material).render(&narrow, 16, settings(256)));
        let share = found.mean / radiance.as_dvec3();
        let noise = (found.sigma / radiance.as_dvec3()).max_element();
        assert!(share.max_element() <= 1.0 + 4.5 * noise + 3e-5, "alpha {alpha}: {share}");
        assert!(share.min_element() > 0.5, "alpha {alpha}: {share}");
    }
}

#[test]
fn a_sky_lights_the_floor_as_its_integral_says() {
    let zenith = Rgb::new(3.0, 2.0, 1.0);
    let stage = floor(Material::diffuse(RHO), sky(zenith));
    assert_agree("sky", seen(&stage, 512), Estimate::exactly(RHO * zenith * (2.0 / 3.0)), 1e-3);
    // With a lamp and a sun beside it, each is still counted once.
    let mut all = stage;
    let radiance = Rgb::splat(4.0);
    let lamp = all.group(Material::diffuse(BLACK), radiance);
    all.plate(lamp, 3.0 * Vec3::Y, Vec3::X, Vec3::Z);
    let irradiance = Rgb::splat(0.5);
    all.light(LightKind::Directional { direction: Vec3::new(0.6, -0.8, 0.0), irradiance });
    let mut apart = floor(Material::diffuse(RHO), constant(BLACK));
    let lamp = apart.group(Material::diffuse(BLACK), radiance);
    apart.plate(lamp, 3.0 * Vec3::Y, Vec3::X, Vec3::Z);
    apart.light(LightKind::Directional { direction: Vec3::new(0.6, -0.8, 0.0), irradiance });
    let mut shaded = floor(Material::diffuse(RHO), sky(zenith));
    let shade = shaded.group(Material::diffuse(BLACK), BLACK);
    shaded.plate(shade, 3.0 * Vec3::Y, Vec3::X, Vec3::Z);
    let (lit, shaded) = (seen(&apart, 256), seen(&shaded, 256));
    let sum = Estimate {
        mean: lit.mean + shaded.mean,
        sigma: (lit.sigma * lit.sigma + shaded.sigma * shaded.sigma).map(f64::sqrt),
    };
    assert_agree("sky, lamp and sun", seen(&all, 1024), sum, 3e-3);
}

#[test]
fn a_small_sun_is_a_directional_light() {
    let (width, height) = (1024, 512);
    let (column, row) = (700, 130);
    let place = ((column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32);
    let radiance = Rgb::new(3e4, 2e4, 1e4);
    let sun =
        RgbImage::from_fn(
            width,
            height,
            |x, y| {
                if (x, y) == (column, row) { radiance } else { BLACK }
            },
        );
    let sun = environment(sun, 40.0);
    let cos = Environment::cos_polar(place.1);
    let direction = -sun.direction(place.0, cos);
    let pixel = TAU / width as f32 * PI / height as f32 * (1.0 - cos * cos).sqrt();
    let glossy = Material { alpha_x: 0.4, alpha_y: 0.3, rho_s: RHO, ..Material::diffuse(RHO) };
    let by_panorama = floor(glossy.clone(), sun);
    let mut by_light = floor(glossy, constant(BLACK));
    by_light.light(LightKind::Directional { direction, irradiance: radiance * pixel });
    let (a, b) = (seen(&by_panorama, 2048), seen(&by_light, 16));
    // The sun is a pixel wide: over its width the lobe changes by less than this.
    let off = ((a.mean - b.mean) / b.mean).abs().max_element();
    assert!(off < 1e-3, "{a:?} is not {b:?}");
    assert!((a.sigma / a.mean).max_element() < 2e-3, "a sun is no rare event: {a:?}");
}

#[test]
fn mirrors_and_cameras_show_the_panorama() {
    let side = 12;
    let (eye, target) = (Vec3::new(0.3, 1.0, 0.4), Vec3::new(0.2, 0.0, -0.5));
    let view = camera(eye, target, 0.6);
    let tint = Rgb::new(0.9, 0.6, 0.3);
    let mut stage = floor(Material::mirror(tint), motley());
    let mirrored = stage.render(&view, side, settings(64));
    // The same rays, mirrored, without the floor.
    let mut behind = Stage::default();
    let speck = behind.group(Material::diffuse(BLACK), BLACK);
    behind.plate(speck, 90.0 * Vec3::Y, 1e-3 * Vec3::X, 1e-3 * Vec3::Z);
    behind.scene.environment = Some(motley());
    let flip = |v: Vec3| Vec3::new(v.x, -v.y, v.z);
    let direct = behind.render(&camera(flip(eye), flip(target), 0.6), side, settings(64));
    for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x, y))) {
        let there = (x, side - 1 - y);
        let (a, b) = (*mirrored.mean.at(x, y), tint * *direct.mean.at(there.0, there.1));
        let variance =
            *mirrored.variance.at(x, y) + tint * tint * *direct.variance.at(there.0, there.1);
        assert!((a - b).abs().cmple(5.0 * variance.map(f32::sqrt) + 1e-5).all(), "{a} is not {b}");
    }
    stage.scene.environment = Some(constant(Rgb::ONE));
    let even = stage.render(&view, side, settings(4));
    assert!(even.mean.pixels().iter().all(|rgb| (*rgb - tint).abs().max_element() < 1e-6));
}

#[test]
fn probes_and_derivatives_know_the_environment() {
    let zenith = Rgb::new(3.0, 2.0, 1.0);
    let glossy =
        Material { alpha_x: 0.2, alpha_y: 0.3, rho_s: 0.3 * RHO, ..Material::diffuse(RHO) };
    let stage = floor(glossy, sky(zenith));
    let (tracer, materials) = (stage.tracer(), stage.scene.materials());
    let view = camera(Vec3::new(0.8, 2.0, 1.5), Vec3::ZERO, 2e-3);
    let size = (8, 8);
    let pixels: Vec<u32> = (0..64).collect();
    let asked = ProbeSettings { probes_per_pixel: 4, cosine: 64, mirror: 16, ..Default::default() };
    let probes = tracer.probe(&view, size, &Query::new(&materials, &pixels, &asked)).probes;
    let diffuse: Vec<DVec3> = probes.iter().map(|p| p.diffuse.as_dvec3()).collect();
    let irradiance = zenith * (TAU / 3.0);
    let expected = Estimate::exactly(irradiance * FRAC_1_PI);
    assert_agree("D", Estimate::of_samples(&diffuse), expected, 3e-3);
    let up = Vec3::new(0.8, 2.0, 1.5).normalize().y;
    assert!(
        probes.iter().all(|p| (p.mirror / (zenith * up) - Rgb::ONE).abs().max_element() < 2e-3)
    );
    assert!(probes.iter().all(|p| p.mirrored.is_none()));

    // All light is the environment's, so the derivative by its brightness is the radiance.
    let source = Parameter::Light(1);
    let twice = [Rgb::ONE, Rgb::splat(2.0)];
    let appearance = Appearance { materials: &materials, lights: &twice };
    let found = tracer.jacobian(
        &view,
        size,
        &Query { parameters: &[source], ..Query::new(appearance, &pixels, &settings(16)) },
    );
    for (radiance, derivative) in found.radiance.iter().zip(&found.derivatives) {
        assert!((*radiance - 2.0 * *derivative).abs().max_element() < 1e-5 * radiance.x);
    }
    let film = tracer.render(appearance, &view, size, &settings(16), &|_| ());
    for (radiance, mean) in found.radiance.iter().zip(film.mean.pixels()) {
        assert!((*radiance - *mean).abs().max_element() < 1e-5 * mean.x);
    }
    // Rays that meet nothing see it too.
    let beyond = camera(Vec3::Y, 2.0 * Vec3::Y + Vec3::X, 0.1);
    let found = tracer.jacobian(
        &beyond,
        size,
        &Query { parameters: &[source], ..Query::new(appearance, &pixels, &settings(4)) },
    );
    let film = tracer.render(appearance, &beyond, size, &settings(4), &|_| ());
    for (index, mean) in film.mean.pixels().iter().enumerate() {
        assert!(mean.min_element() > 0.0);
        assert!((*mean - found.radiance[index]).abs().max_element() < 1e-5);
        assert!((*mean - 2.0 * found.derivatives[index]).abs().max_element() < 1e-5);
    }
}

#[test]
fn parts_of_an_environment_are_sources_of_their_own() {
    let mut random = Random::new(7);
    let factors: Vec<Rgb> = (0..32).map(|_| random.rgb(0.0, 2.0)).collect();
    let mut stage = floor(Material::diffuse(RHO), constant(Rgb::ONE).in_parts());
    let wall = stage.group(Material::isotropic(0.5 * RHO, 0.3 * RHO, 0.3), BLACK);
    stage.plate(wall, -Vec3::Z, 2.0 * Vec3::X, 2.0 * Vec3::Y);
    let first = stage.scene.environment_parts().start;
    let lights: Vec<Rgb> = vec![Rgb::ONE; first].into_iter().chain(factors.clone()).collect();
    let materials = stage.scene.materials();
    let appearance = Appearance { materials: &materials, lights: &lights };
    let parameters: Vec<Parameter> =
        (0..32).map(|k| Parameter::Light((first + k) as u32)).collect();
    let (size, pixels) = ((8, 8), (0..64).collect::<Vec<u32>>());
    let camera = camera(Vec3::new(0.8, 2.0, 3.5), Vec3::ZERO, 0.7);
    let tracer = unrender_render::Tracer::new(&stage.scene);
    let found = tracer.jacobian(
        &camera,
        size,
        &Query { parameters: &parameters, ..Query::new(appearance, &pixels, &settings(256)) },
    );
    for (row, radiance) in found.derivatives.chunks(32).zip(&found.radiance) {
        let sum: Rgb = row.iter().zip(&factors).map(|(by, factor)| *by * *factor).sum();
        assert!((sum - radiance).abs().max_element() <= 2e-5 * radiance.max_element());
    }
    // The same as a panorama with these pixels, which draws other directions.
    let panorama = RgbImage::new(8, 4, factors);
    stage.scene.environment = Some(environment(panorama, 0.0));
    let other = unrender_render::Tracer::new(&stage.scene);
    let other =
        other.jacobian(&camera, size, &Query::new(&materials, &pixels, &settings(256))).radiance;
    let [a, b] = [&found.radiance, &other].map(|of| of.iter().map(|v| v.as_dvec3()).sum::<DVec3>());
    assert!((a / b - 1.0).abs().max_element() < 0.01, "{a} {b}");
}
