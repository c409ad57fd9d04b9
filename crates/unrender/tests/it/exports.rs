//! Exports read back: the same parameters and the same picture. Their pictures in other programs
//! are in `external`.

use crate::kit::export_scene::{SIZE, camera, exported, scene};
use crate::kit::programs::{Row, compare, compare_quadrants, our_picture};
use std::sync::Arc;
use unrender::converted::converted;
use unrender::formats::LightUnits;
use unrender::formats::export::{self, SceneView, Target};
use unrender::scene::{BrdfModel, Image, Material, Scene, Texture};

/// Paths per pixel: the noise of a quarter of a group is below one and a half percent.
const SPP: u32 = 400;

#[test]
fn ggx_needs_no_conversion_where_it_is_known() {
    let scene = Scene { brdf: BrdfModel::Ggx, ..scene() };
    for target in Target::ALL.into_iter().filter(|&t| t != Target::Radiance) {
        let converted = converted(&scene, &camera(), SIZE, target.lobe(scene.brdf));
        for (conversion, group) in converted.iter().zip(&scene.groups) {
            assert_eq!((&conversion.material, conversion.difference), (&group.material, 0.0));
        }
    }
}

#[test]
fn gltf_comes_back_to_the_same_numbers() {
    let (_folder, path) = exported(&scene(), Target::Gltf);
    let (back, _) = unrender::formats::load_scene(&path).unwrap();
    for (found, group) in back.groups.iter().zip(&scene().groups) {
        let expected =
            Material { texture: found.material.texture.clone(), ..group.material.clone() };
        assert_eq!((&found.name, &found.material), (&group.name, &expected));
        assert_eq!(found.emission, group.emission);
    }
}

/// The scene that is read back from an export to `target`, whose main file is `file`.
fn back(target: Target, file: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let (scene, camera) = (scene(), camera());
    let materials = scene.materials();
    let shot = SceneView {
        scene: &scene,
        materials: &materials,
        camera: &camera,
        size: SIZE,
        light_units: LightUnits::Radiometric,
    };
    let (files, _) = export::export(&shot, target, folder.path()).unwrap();
    export::write(folder.path(), target, &files).unwrap();
    let (back, warnings) = unrender::formats::load_scene(&folder.path().join(file)).unwrap();
    assert!(warnings.0.is_empty(), "{warnings:?}");
    back
}

/// Asserts that `back` has everything of the scene: names, parameters, and the same picture.
fn assert_same(back: &Scene) {
    let (scene, camera) = (scene(), camera());
    assert_eq!(back.brdf, scene.brdf);
    assert_eq!(back.groups.len(), scene.groups.len());
    for (found, group) in back.groups.iter().zip(&scene.groups) {
        assert_eq!((&found.name, found.emission), (&group.name, group.emission));
        let numbers = |m: &Material| (m.rho_d, m.rho_s, m.alpha_x, m.alpha_y, m.texture.is_some());
        assert_eq!(numbers(&found.material), numbers(&group.material), "{}", group.name);
    }
    assert_eq!(back.triangle_count(), scene.triangle_count());
    let lights = |scene: &Scene| scene.lights.iter().map(|l| l.name.clone()).collect::<Vec<_>>();
    assert_eq!(lights(back), lights(&scene));
    let objects = |scene: &Scene| scene.objects.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
    // One without a name has got its number.
    let mut named = scene.clone();
    named.validate().unwrap();
    assert_eq!(objects(back), objects(&named));
    let theirs = our_picture(back, &back.cameras[0], SIZE, SPP);
    let ours = our_picture(&scene, &camera, SIZE, SPP);
    let alike = |rows: Vec<Row>, limit: f32| {
        for row in rows {
            let name = &scene.groups[row.group].name;
            assert!(row.difference() < limit, "{name}: {} for {}", row.theirs, row.ours);
        }
    };
    alike(compare(&scene, &camera, &ours, &theirs, 20), 0.005);
    alike(compare_quadrants(&scene, &camera, &ours, &theirs, 20), 0.03);
}

/// The groups' means stay the same; the means of their quarters do not.
#[test]
fn a_flipped_texture_is_another_picture() {
    let (scene, camera) = (scene(), camera());
    let mut flipped = scene.clone();
    let floor = flipped.groups.iter_mut().find(|group| group.material.texture.is_some()).unwrap();
    let texture = floor.material.texture.as_ref().unwrap();
    let image = &texture.image;
    let (width, height) = (image.width(), image.height());
    let image = Image::from_fn(width, height, |x, y| *image.at(x, height - 1 - y));
    floor.material.texture = Some(Arc::new(Texture { image, ..(**texture).clone() }));
    let pictures = [&scene, &flipped].map(|scene| our_picture(scene, &camera, SIZE, 16));
    let [ours, theirs] = &pictures;
    let worst = |rows: Vec<Row>| rows.iter().map(Row::difference).fold(0.0, f32::max);
    let apart = worst(compare_quadrants(&scene, &camera, ours, theirs, 20));
    assert!(apart > 0.1, "{apart}");
}

#[test]
fn mitsuba_scenes_come_back() {
    assert_same(&back(Target::Mitsuba, "scene.xml"));
}

#[test]
fn radiance_scenes_come_back() {
    assert_same(&back(Target::Radiance, "scene.rad"));
}
