//! The paths that explain a picture's noise are those of the picture.

use crate::common::{Stage, camera, settings};
use glam::Vec3;
use unrender_render::BrightPath;
use unrender_scene::{Camera, Environment, Material, Rgb, RgbImage};

/// A diffuse wall above a mirror floor, under a lamp, in dim light from everywhere.
fn stage() -> Stage {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(Rgb::new(0.2, 0.5, 0.8)), Rgb::ZERO);
    stage.plate(wall, Vec3::Y, Vec3::X, Vec3::Y);
    let floor = stage.group(Material::mirror(Rgb::splat(0.8)), Rgb::ZERO);
    stage.plate(floor, 2.0 * Vec3::Z, 2.0 * Vec3::Z, 2.0 * Vec3::X);
    let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::splat(30.0));
    stage.plate(lamp, Vec3::new(0.2, 1.7, 1.4), 0.15 * Vec3::Z, -0.2 * Vec3::X);
    let around = RgbImage::new(1, 1, vec![Rgb::splat(0.1)]);
    stage.scene.environment = Some(Environment::new(around, 0.0).unwrap());
    stage
}

/// The wall's lower part and some of the floor, but not the lamp.
fn view() -> Camera {
    camera(Vec3::new(-0.3, 0.9, 2.5), Vec3::new(0.0, 0.3, 0.0), 0.5)
}

#[test]
fn all_paths_together_are_the_picture() {
    let (side, spp) = (12, 16);
    let (tracer, materials) = (stage().tracer(), stage().scene.materials());
    // Of the groups, of which the third is the lamp, and of the environment.
    let lights = [Rgb::ONE, Rgb::ONE, Rgb::new(1.0, 2.0, 3.0), Rgb::splat(0.5)];
    let appearance = unrender_render::Appearance { materials: &materials, lights: &lights };
    let size = (side, side);
    let film = tracer.render(appearance, &view(), size, &settings(spp), &|_| ());
    let paths = tracer.bright_paths(appearance, &view(), size, &settings(spp), 0.0);
    let mut picture = vec![Rgb::ZERO; side * side];
    for path in &paths {
        assert!(path.sample < spp);
        picture[path.pixel as usize] += path.radiance / spp as f32;
    }
    for (found, expected) in picture.iter().zip(film.mean.pixels()) {
        assert!((*found - *expected).length() < 1e-4 * (1.0 + expected.length()));
    }
    let is_ordered = paths.is_sorted_by_key(|path| (path.pixel, path.sample));
    assert!(is_ordered);
}

#[test]
fn the_kinds_of_paths_are_those_of_the_scene() {
    let (tracer, materials) = (stage().tracer(), stage().scene.materials());
    let paths = tracer.bright_paths(&materials, &view(), (12, 12), &settings(64), 0.0);
    let count = |kind: &str| paths.iter().filter(|path| path.kind == kind).count();
    for kind in ["l", "e", "v", "DL", "DE", "DML", "Ml", "Me"] {
        assert!(count(kind) > 0, "{kind}");
    }
    // A mirror takes no light samples, and nothing is glossy.
    assert!(paths.iter().all(|path| !path.kind.contains('G')));
    let brightness = |path: &BrightPath| path.radiance.element_sum() / 3.0;
    let mut all: Vec<f32> = paths.iter().map(brightness).collect();
    all.sort_by(f32::total_cmp);
    let threshold = all[all.len() * 49 / 50];
    let bright = tracer.bright_paths(&materials, &view(), (12, 12), &settings(64), threshold);
    assert!(!bright.is_empty() && bright.len() < paths.len() / 20);
    let is_bright = |path: &&BrightPath| brightness(path) > threshold;
    assert_eq!(bright, paths.iter().filter(is_bright).cloned().collect::<Vec<_>>());
}

#[test]
fn light_samples_that_a_lobe_reflects_are_told_from_the_others() {
    let mut stage = stage();
    stage.scene.groups[1].material = Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.5), 0.05);
    let materials = stage.scene.materials();
    let paths = stage.tracer().bright_paths(&materials, &view(), (12, 12), &settings(64), 0.0);
    for kind in ["l", "Dl", "Dgl", "DGL"] {
        assert!(paths.iter().any(|path| path.kind == kind), "{kind}");
    }
    // The wall has no lobe: what the floor's lobe sends there is not reflected by another one.
    assert!(paths.iter().all(|path| path.kind != "Ggl"));
}
