//! The units of lights in glTF files: what Blender's exporter writes is read as Cycles means it, and
//! written back as Blender reads it.

use crate::support::{Folder, changed};
use glam::Vec3;
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::path::Path;
use unrender_formats::export::{self, SceneView, Target};
use unrender_formats::{Input, LightUnits, Limits, assign_materials, gltf, load_scene};
use unrender_scene::{Camera, LightKind, Rgb, Scene, Warnings};

const STANDARD: &str = "Khronos glTF Blender I/O v4.5.47";
const COLOR: [f64; 3] = [1.0, 0.5, 0.25];

/// A point light and a spot of 35 W and a sun of 3 W/m^2, with these intensities in the file.
fn file(generator: Option<&str>, [point, sun]: [f64; 2]) -> Vec<u8> {
    changed(|json, _| {
        json["asset"] = json!({ "version": "2.0", "generator": generator });
        if generator.is_none() {
            json["asset"].as_object_mut().unwrap().remove("generator");
        }
        let light = |kind: &str, intensity: f64| json!({ "type": kind, "color": COLOR, "intensity": intensity });
        let lights = [light("point", point), light("spot", point), light("directional", sun)];
        json["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
        let node = |name: &str, light: usize| json!({ "name": name, "extensions": { "KHR_lights_punctual": { "light": light } } });
        let tri = json["nodes"][0].clone();
        json["nodes"] = json!([tri, node("Point", 0), node("Spot", 1), node("Sun", 2)]);
        json["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
        json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_emissive_strength"]);
    })
}

/// What the exporter writes in each mode (`__gather_intensity` of `exp/lights.py`).
fn standard() -> [f64; 2] {
    [35.0 * 683.0 / (4.0 * PI), 3.0 * 683.0]
}

fn unitless() -> [f64; 2] {
    [35.0 / (4.0 * PI), 3.0]
}

fn load(path: &Path, units: Option<LightUnits>) -> (Scene, Warnings) {
    load_scene(Input::new(path, Limits::default()).in_light_units(units)).unwrap()
}

/// Whether the lights are as bright as those of Cycles.
fn is_as_in_cycles(scene: &Scene) -> bool {
    let color = Rgb::from_array(COLOR.map(|c| c as f32));
    let wanted = [35.0 / (4.0 * PI), 35.0 / (4.0 * PI), 3.0].map(|s| color * s as f32);
    scene.lights.len() == 3
        && scene.lights.iter().zip(wanted).all(|(light, wanted)| {
            (light.kind.strength() - wanted).length() < 1e-6 * wanted.length()
        })
}

fn json_of(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

fn intensities(glb: &[u8]) -> [f64; 3] {
    let lights = &json_of(glb)["extensions"]["KHR_lights_punctual"]["lights"];
    [0, 1, 2].map(|i| lights[i]["intensity"].as_f64().unwrap())
}

#[test]
fn blenders_files_are_read_as_cycles_means_them() {
    let folder = Folder::new();
    let older = "Khronos glTF Blender I/O v3.3.36";
    for (generator, numbers, words) in [
        (STANDARD, standard(), "Standard units"),
        ("Khronos glTF Blender I/O v3.4.50", standard(), "Standard units"),
        (older, [35.0, 3.0], "Raw units"),
    ] {
        let path = folder.file("a.glb", file(Some(generator), numbers));
        let (scene, warnings) = load(&path, None);
        assert!(is_as_in_cycles(&scene), "{generator}: {:?}", scene.lights);
        let told: Vec<_> = warnings.0.iter().filter(|w| w.contains("lights read as")).collect();
        assert!(told.len() == 1 && told[0].contains(words), "{warnings:?}");
        // Emission is radiance in all of them.
        assert_eq!(scene.groups[0].emission, Rgb::new(8.0, 4.0, 2.0));
    }
}

#[test]
fn other_files_are_read_as_they_stand_to_the_bit() {
    let folder = Folder::new();
    let [point, sun] = [0.1, 1.0 / 3.0];
    for generator in [None, Some("unrender"), Some("Blender by hand"), Some("VRED")] {
        let path = folder.file("a.glb", file(generator, [point, sun]));
        let (scene, warnings) = load(&path, None);
        assert_eq!(warnings, Warnings::default());
        let strength = |s: f64| Rgb::from_array(COLOR.map(|c| (c * s) as f32));
        assert_eq!(scene.lights[0].kind.strength(), strength(point));
        assert_eq!(scene.lights[2].kind.strength(), strength(sun));
        let same = assign_materials(&path, &scene, &[]).unwrap();
        assert!(!same.windows(11).any(|w| w == b"light_units"));
    }
}

#[test]
fn what_is_stated_counts_more_than_the_generator() {
    let folder = Folder::new();
    for (units, numbers) in [
        (LightUnits::BlenderStandard, standard()),
        (LightUnits::Unitless, unitless()),
        (LightUnits::BlenderRaw, [35.0, 3.0]),
        (LightUnits::Radiometric, unitless()),
    ] {
        for generator in [Some(STANDARD), None] {
            let path = folder.file("a.glb", file(generator, numbers));
            let (scene, warnings) = load(&path, Some(units));
            assert!(is_as_in_cycles(&scene), "{units}");
            assert!(!warnings.0.iter().any(|w| w.contains("lights read as")), "{warnings:?}");
            // The file that is written back states its units.
            let input = Input::new(&path, Limits::default()).in_light_units(Some(units));
            let assigned = assign_materials(input, &scene, &[]).unwrap();
            assert_eq!(intensities(&assigned), [numbers[0], numbers[0], numbers[1]]);
            let (back, _) = load(&folder.file("b.glb", assigned), None);
            assert_eq!(back.lights, scene.lights, "{units}");
        }
        assert_eq!(units.name().parse(), Ok(units));
    }
    assert!("lumen".parse::<LightUnits>().unwrap_err().contains("blender-standard"));
}

#[test]
fn lights_are_written_back_in_the_files_own_units() {
    let folder = Folder::new();
    let path = folder.file("a.glb", file(Some(STANDARD), standard()));
    let (mut scene, _) = load(&path, None);
    // Untouched lights keep their numbers to the bit.
    let [point, sun] = standard();
    assert_eq!(intensities(&assign_materials(&path, &scene, &[]).unwrap()), [point, point, sun]);
    // Lights that are found to be twice as bright are 70 W and 6 W/m^2 in Blender.
    for light in 0..3 {
        *scene.strength_mut(scene.groups.len() + light).unwrap() *= 2.0;
    }
    let assigned = assign_materials(&path, &scene, &[]).unwrap();
    let blender = |i: usize| {
        let light = &json_of(&assigned)["extensions"]["KHR_lights_punctual"]["lights"][i];
        assert_eq!(light["color"][0], 1.0, "its watts are those of the intensity");
        light["intensity"].as_f64().unwrap() / 683.0 * if i == 2 { 1.0 } else { 4.0 * PI }
    };
    for (light, wanted) in [(0, 70.0), (1, 70.0), (2, 6.0)] {
        assert!((blender(light) / wanted - 1.0).abs() < 1e-6, "{}", blender(light));
    }
    let (back, _) = load(&folder.file("b.glb", assigned), None);
    for (a, b) in back.lights.iter().zip(&scene.lights) {
        let (a, b) = (a.kind.strength(), b.kind.strength());
        assert!((a - b).length() < 1e-6 * b.length(), "{a} against {b}");
    }
}

#[test]
fn an_export_to_gltf_keeps_the_units() {
    let folder = Folder::new();
    let path = folder.file("a.glb", file(Some(STANDARD), standard()));
    let (scene, _) = load(&path, None);
    let camera = Camera::look_at("eye", Vec3::Z, Vec3::ZERO, Vec3::Y, 0.5);
    let materials = scene.materials();
    let light_units = gltf::light_units(&path).unwrap();
    assert_eq!(light_units, LightUnits::BlenderStandard);
    let shot = SceneView {
        scene: &scene,
        materials: &materials,
        camera: &camera,
        size: (4, 3),
        light_units,
    };
    let (files, _) = export::export(&shot, Target::Gltf, Path::new("scene.glb")).unwrap();
    let [point, spot, sun] = intensities(&files[0].1);
    for (written, wanted) in [(point, standard()[0]), (spot, standard()[0]), (sun, standard()[1])] {
        assert!((written / wanted - 1.0).abs() < 1e-6, "{written} against {wanted}");
    }
    let (back, _) = load(&folder.file("b.glb", &files[0].1), None);
    assert!(is_as_in_cycles(&back), "{:?}", back.lights);
    let LightKind::Point { .. } = back.lights[0].kind else { panic!() };
}
