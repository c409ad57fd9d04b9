//! Proves light layers: the picture beside them has the bits of the path tracer, they add up to it, and under
//! other brightnesses their weighted sum is the picture that is rendered so.

use crate::common::{Random, Stage, camera, settings};
use glam::Vec3;
use unrender_render::adaptive::SampleAllocation;
use unrender_render::layers::{indirect, relight};
use unrender_render::{Accumulator, Appearance, Tracer};
use unrender_scene::{Camera, Environment, Light, LightKind, Material, Rgb, RgbImage, Scene};

const SIZE: (usize, usize) = (16, 16);
const SPP: u32 = 32;
/// Single precision's rounding of some thousand additions.
const ROUNDING: f32 = 2e-5;

/// A floor and a glossy wall under a lamp, a bulb, and light from around, whole or in parts.
fn room(in_parts: bool) -> Scene {
    let mut random = Random::new(3);
    let mut stage = Stage::default();
    let floor = stage.group(Material::diffuse(Rgb::new(0.2, 0.5, 0.8)), Rgb::ZERO);
    stage.plate(floor, Vec3::ZERO, 5.0 * Vec3::Z, 5.0 * Vec3::X);
    let shiny = Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.3), 0.2);
    let wall = stage.group(shiny, Rgb::ZERO);
    stage.plate(wall, -Vec3::Z, 2.0 * Vec3::X, 2.0 * Vec3::Y);
    let lamp = stage.group(Material::diffuse(Rgb::splat(0.5)), Rgb::new(8.0, 6.0, 4.0));
    stage.plate(lamp, Vec3::new(0.5, 1.5, -0.2), 0.3 * Vec3::X, 0.3 * Vec3::Z);
    let kind = LightKind::Point { position: Vec3::new(-0.5, 1.0, 0.5), intensity: Rgb::splat(2.0) };
    stage.scene.lights.push(Light { name: "bulb".into(), kind });
    let panorama = RgbImage::from_fn(8, 4, |_, _| random.rgb(0.1, 1.0));
    let around = Environment::new(panorama, 0.3).unwrap();
    stage.scene.environment = Some(if in_parts { around.in_parts() } else { around });
    stage.scene
}

fn view() -> Camera {
    camera(Vec3::new(0.8, 2.0, 3.5), Vec3::new(0.0, 0.7, 0.0), 0.9)
}

/// The picture of the room under `lights`, its layers, and the bits of the path tracer.
fn rendered(scene: &Scene, lights: &[Rgb]) -> (Vec<RgbImage>, Vec<usize>, RgbImage) {
    let tracer = Tracer::new(scene);
    let materials = scene.materials();
    let appearance = Appearance { materials: &materials, lights };
    let sources = tracer.light_sources();
    let mut layers = vec![Accumulator::new(SIZE.0, SIZE.1); 1 + sources.len()];
    // In two calls, as an interrupted rendering would.
    for samples in [0..10, 10..SPP] {
        let samples = SampleAllocation::Uniform(samples);
        let (settings, layers) = (settings(SPP), &mut layers[..]);
        tracer.accumulate_layers(appearance, &view(), &settings, &samples, layers, &|_| ());
    }
    let film = tracer.render(appearance, &view(), SIZE, &settings(SPP), &|_| ());
    (layers.iter().map(Accumulator::mean).collect(), sources, film.mean)
}

/// The largest difference of two pictures, relative to the brightest pixel.
fn difference(a: &RgbImage, b: &RgbImage) -> f32 {
    let brightest = b.pixels().iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let pairs = a.pixels().iter().zip(b.pixels());
    pairs.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max) / brightest
}

#[test]
fn layers_add_up_to_the_picture() {
    for in_parts in [false, true] {
        let scene = room(in_parts);
        let (layers, sources, picture) = rendered(&scene, &[]);
        // The lamp is the third group, the bulb comes after all groups, what is around after that.
        let parts = if in_parts { 32 } else { 1 };
        assert_eq!(sources, (2..4 + parts).collect::<Vec<_>>());
        assert_eq!(layers[0], picture, "the bits of the path tracer");
        let sum = relight(&layers[1..], &vec![Rgb::ONE; sources.len()]).unwrap();
        assert!(difference(&sum, &picture) < ROUNDING, "{}", difference(&sum, &picture));
        let lit = |layer: &RgbImage| layer.pixels().iter().any(|v| v.max_element() > 0.0);
        assert!(layers[..4].iter().all(lit));
    }
}

#[test]
fn a_relit_picture_is_the_one_rendered_so() {
    let mut random = Random::new(4);
    for in_parts in [false, true] {
        let scene = room(in_parts);
        let (layers, sources, _) = rendered(&scene, &[]);
        let mut lights = vec![Rgb::ONE; 3 + 33];
        sources.iter().for_each(|&place| lights[place] = random.rgb(0.1, 3.0));
        // Light samples are drawn by the scene's own brightness, and no source that guides paths is dark: the
        // paths are the same ones.
        let (_, _, picture) = rendered(&scene, &lights);
        let factors: Vec<Rgb> = sources.iter().map(|&place| lights[place]).collect();
        let relit = relight(&layers[1..], &factors).unwrap();
        assert!(difference(&relit, &picture) < ROUNDING, "{}", difference(&relit, &picture));
    }
}

#[test]
fn nothing_is_relit_without_layers() {
    assert!(relight(&[], &[]).is_none());
    let dark = Scene { environment: None, lights: Vec::new(), ..room(false) };
    assert_eq!(Tracer::new(&dark).light_sources(), [2]);
}

#[test]
fn light_is_direct_or_has_been_reflected_more_than_once() {
    let scene = room(false);
    let tracer = Tracer::new(&scene);
    let materials = scene.materials();
    // The direct light is what the scene has if paths end after one reflection, by the same random numbers.
    let sums = |max_bounces: u32| {
        let settings = unrender_render::Settings { max_bounces, ..settings(SPP) };
        let mut layers = vec![Accumulator::new(SIZE.0, SIZE.1); 2 + tracer.light_sources().len()];
        let samples = SampleAllocation::Uniform(0..SPP);
        tracer.accumulate_layers(&materials, &view(), &settings, &samples, &mut layers, &|_| ());
        let direct = layers.pop().unwrap();
        (layers.swap_remove(0), direct)
    };
    let (whole, direct) = sums(unrender_render::path::MAX_BOUNCES);
    let (short, all_of_it) = sums(1);
    assert!(difference(&direct.mean(), &short.mean()) < ROUNDING);
    assert!(difference(&all_of_it.mean(), &short.mean()) < ROUNDING);
    let indirect = indirect(&whole, &direct);
    let sum = relight(&[direct.mean(), indirect.clone()], &[Rgb::ONE; 2]).unwrap();
    assert!(difference(&sum, &whole.mean()) < ROUNDING, "{}", difference(&sum, &whole.mean()));
    assert!(indirect.pixels().iter().any(|v| v.max_element() > 0.01));
}
