//! Proves that results depend on input and seed alone, not on threads, and that textures lie on
//! surfaces as glTF says.

use crate::common::{Stage, camera, plate_corners, quad_mesh, settings};
use glam::{Vec2, Vec3};
use std::sync::Arc;
use unrender_render::adaptive::SampleAllocation;
use unrender_render::probe::ProposalLobe;
use unrender_render::{Accumulator, Film, ProbeSettings, Probes, Query, Settings};
use unrender_scene::{Camera, Image, Material, Rgb, Texture, Wrap};

/// A small room with a lamp, a glossy ball and a mirror.
fn room() -> Stage {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(Rgb::new(0.7, 0.5, 0.3)), Rgb::ZERO);
    stage.room(wall, Vec3::ONE);
    let ball = stage.group(Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.5), 0.2), Rgb::ZERO);
    stage.sphere(ball, Vec3::new(0.2, -0.5, 0.0), 0.4, 12);
    let mirror = stage.group(Material::mirror(Rgb::splat(0.9)), Rgb::ZERO);
    stage.plate(mirror, Vec3::new(0.0, 0.0, -0.95), 0.5 * Vec3::X, 0.5 * Vec3::Y);
    let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::splat(5.0));
    stage.plate(lamp, Vec3::new(0.0, 0.98, 0.0), 0.3 * Vec3::X, 0.3 * Vec3::Z);
    stage
}

fn view() -> Camera {
    camera(Vec3::new(0.0, 0.0, 0.95), Vec3::ZERO, 1.2)
}

const SIDE: usize = 48;

fn film_and_probes(threads: usize, seed: u64) -> (Film, Probes) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let stage = room();
    let pixels: Vec<u32> = (0..(SIDE * SIDE) as u32).collect();
    let probe_settings = ProbeSettings {
        probes_per_pixel: 2,
        cosine: 2,
        per_lobe: 2,
        lobes: vec![ProposalLobe { alpha_x: 0.1, alpha_y: 0.2, theta_rad: 0.4 }],
        mirror: 1,
        keep_incident: true,
        through_mirrors: true,
        seed,
        ..ProbeSettings::default()
    };
    pool.install(|| {
        let film = stage.render(&view(), SIDE, Settings { seed, ..settings(8) });
        let materials = stage.scene.materials();
        let probes = stage.tracer().probe(
            &view(),
            (SIDE, SIDE),
            &Query::new(&materials, &pixels, &probe_settings),
        );
        (film, probes)
    })
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (film, probes) = film_and_probes(1, 4);
    assert!(probes.incident.len() > SIDE * SIDE);
    for threads in [2, 7] {
        let (other_film, other_probes) = film_and_probes(threads, 4);
        assert!(film == other_film, "{threads} threads render another picture");
        assert!(probes == other_probes, "{threads} threads gather other light");
    }
}

#[test]
fn another_seed_gives_other_noise_around_the_same_mean() {
    let (film, probes) = film_and_probes(2, 4);
    let (other_film, other_probes) = film_and_probes(2, 5);
    let pairs = || film.mean.pixels().iter().zip(other_film.mean.pixels());
    let differ = pairs().filter(|(a, b)| a != b).count();
    assert!(differ > SIDE * SIDE * 9 / 10, "{differ} pixels differ");
    assert!(probes.probes != other_probes.probes);
    let [a, b] = [&film, &other_film].map(crate::common::Estimate::of_film);
    crate::common::assert_agree("two seeds", a, b, 0.03);
}

#[test]
fn chosen_pixels_are_those_of_the_whole_picture() {
    let stage = room();
    let settings = settings(4);
    let film = stage.render(&view(), SIDE, settings);
    let pixels = [7, 1000, 3, 2303];
    let materials = stage.scene.materials();
    let some = stage.tracer().render_pixels(&materials, &view(), (SIDE, SIDE), &pixels, &settings);
    for (pixel, (mean, variance)) in pixels.into_iter().zip(some) {
        assert_eq!(mean, film.mean.pixels()[pixel as usize]);
        assert_eq!(variance, film.variance.pixels()[pixel as usize]);
    }
}

#[test]
fn parts_of_the_samples_add_up_to_the_whole_picture() {
    let stage = room();
    let (tracer, materials) = (stage.tracer(), stage.scene.materials());
    let whole = stage.render(&view(), SIDE, Settings { seed: 4, ..settings(13) });
    let settings = Settings { seed: 4, ..settings(1) };
    let part = |samples: std::ops::Range<u32>, threads: usize| {
        let mut accumulator = Accumulator::new(SIDE, SIDE);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let all = SampleAllocation::Uniform(samples);
        pool.install(|| {
            tracer.accumulate(&materials, &view(), &settings, &all, &mut accumulator, &|_| ());
        });
        accumulator
    };
    let mut sum = part(9..13, 3);
    sum.add(&part(0..5, 1));
    sum.add(&part(5..9, 2));
    assert!(sum.film() == whole, "three parts are not the whole");
    assert!(sum == part(0..13, 1), "nor are their sums");
}

#[test]
fn textures_lie_as_gltf_says() {
    // Columns grow with u, rows with v; uv (0, 0) is the texture's top left corner.
    let texel = |x: usize, y: usize| Rgb::new(0.2 + 0.3 * x as f32, 0.1 + 0.2 * y as f32, 0.5);
    let image = Image::from_fn(3, 4, texel);
    let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
    let painted = Material {
        texture: Some(Arc::new(texture)),
        ..Material::diffuse(Rgb::new(0.35, 0.4, 0.5))
    };
    let mut stage = Stage::default();
    let radiance = 2.0;
    let wall = stage.group(Material::diffuse(Rgb::ZERO), Rgb::splat(radiance));
    stage.room(wall, Vec3::splat(4.0));
    let painted = stage.group(painted, Rgb::ZERO);
    // The picture's left, bottom corner first; uv (0, 0) is at its left, top corner.
    let corners = plate_corners(Vec3::ZERO, 0.75 * Vec3::X, Vec3::Y);
    let uvs = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)].map(|(u, v)| Vec2::new(u, v));
    stage.mesh(painted, quad_mesh(corners, &uvs));
    let eye = Vec3::new(0.0, 0.0, 3.0);
    for (x, y) in (0..3).flat_map(|x| (0..4).map(move |y| (x, y))) {
        let centre = Vec3::new(0.5 * x as f32 - 0.5, 0.75 - 0.5 * y as f32, 0.0);
        let film = stage.render(&camera(eye, centre, 1e-4), 16, settings(256));
        let found = crate::common::Estimate::of_film(&film);
        let expected = crate::common::Estimate::exactly(radiance * texel(x, y));
        crate::common::assert_agree(&format!("texel ({x}, {y})"), found, expected, 2e-3);
    }
}
