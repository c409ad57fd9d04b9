//! Written files read back the same: numbers to the bit, geometry, textures, and, in files that
//! only get other materials, everything else as well.

use crate::support::{Folder, Numbers, changed, damaged, glb, triangle_bytes, triangle_json};
use glam::{Affine3A, Quat, Vec2, Vec3};
use serde_json::{Value, json};
use std::sync::Arc;
use unrender_formats::{assign_materials, gltf, load_scene};
use unrender_scene::color::linear_from_srgb;
use unrender_scene::{
    Camera, Group, Image, Light, LightKind, Material, Mesh, Object, Rgb, Scene, Texture, WardModel,
    Wrap,
};

fn checker() -> Texture {
    let level = |code: usize| linear_from_srgb(code as f32 / 255.0);
    let image = Image::from_fn(5, 3, |x, y| Rgb::new(level(17 * x), level(60 * y), level(200)));
    Texture { image, wrap_u: Wrap::MirroredRepeat, wrap_v: Wrap::ClampToEdge }
}

fn materials() -> Vec<Material> {
    let mut brushed = Material::isotropic(Rgb::new(0.1, 0.12, 0.13), Rgb::new(0.9, 0.7, 0.1), 0.07);
    brushed.alpha_y = 0.11;
    brushed.theta_rad = 1.234_567_9;
    let mut along = Material::isotropic(Rgb::ZERO, Rgb::splat(0.3), 1.3);
    along.alpha_y = 0.2;
    along.theta_rad = -0.3;
    let mut textured = Material::isotropic(Rgb::splat(1.0 / 3.0), Rgb::splat(0.05), 0.25);
    textured.texture = Some(Arc::new(checker()));
    vec![
        Material::diffuse(Rgb::new(0.123_456_79, 1.0 / 3.0, 0.9)),
        Material::mirror(Rgb::splat(0.8)),
        Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.000_1), 0.3),
        brushed,
        along,
        textured,
        Material::diffuse(Rgb::ZERO),
    ]
}

fn scene() -> Scene {
    let mut scene = Scene { brdf: WardModel::Ward1992.into(), ..Scene::default() };
    for (index, material) in materials().into_iter().enumerate() {
        let far = index as f32 / 3.0;
        let positions = [Vec3::new(far, 0.0, 0.1), Vec3::new(far, 0.7, 0.0), Vec3::splat(far)];
        let uvs = [Vec2::new(0.1, 0.2), Vec2::ONE, Vec2::new(-3.3, 0.0)];
        let mut mesh =
            Mesh::flat(&positions, &uvs[..if index % 2 == 1 { 3 } else { 0 }], &[[0, 1, 2]]);
        if index % 2 == 1 {
            mesh.tangents = vec![(positions[1] - positions[0]).normalize().extend(-1.0); 3];
        }
        scene.objects.push(Object { name: format!("object of {index}"), group: index, mesh });
        let emission = Rgb::new(12.34, 0.1, 7.0) * if index == 6 { 1.0 } else { 0.0 };
        scene.groups.push(Group { name: format!("group {index}"), material, emission });
    }
    let mut camera =
        Camera::look_at("eye", Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, Vec3::Y, 0.558_505_36);
    camera.aspect = Some(4.0 / 3.0);
    scene.cameras.push(camera);
    let direction = Vec3::new(0.3, -0.8, 0.1).normalize();
    let (position, intensity) = (Vec3::new(0.1, 0.2, 0.3), Rgb::new(33.3, 0.1, 0.0));
    for kind in [
        LightKind::Point { position, intensity },
        LightKind::Spot { position, direction, intensity, inner_rad: 0.1, outer_rad: 0.7 },
        LightKind::Directional { direction, irradiance: intensity },
    ] {
        scene.lights.push(Light { name: format!("light {}", scene.lights.len()), kind });
    }
    scene
}

/// The JSON of a `.glb`.
fn json_of(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

#[test]
fn a_scene_written_reads_back_the_same() {
    let folder = Folder::new();
    let scene = scene();
    let bytes = gltf::to_glb(&scene).unwrap();
    assert_eq!(bytes, gltf::to_glb(&scene).unwrap());
    let (back, warnings) = load_scene(&folder.file("scene.glb", &bytes)).unwrap();
    assert_eq!(warnings.0, [""; 0]);
    for (a, b) in scene.groups.iter().zip(&back.groups) {
        let texture = a.material.texture.as_ref().zip(b.material.texture.as_ref());
        if let Some((a, b)) = texture {
            assert_eq!((a.wrap_u, a.wrap_v), (b.wrap_u, b.wrap_v));
            let pairs = a.image.pixels().iter().zip(b.image.pixels());
            assert!(pairs.clone().all(|(a, b)| (*a - *b).abs().max_element() < 1e-6));
        }
        let mut b = b.clone();
        b.material.texture = a.material.texture.clone().filter(|_| b.material.texture.is_some());
        assert_eq!(*a, b);
    }
    assert_eq!(back.objects, scene.objects);
    assert_eq!(back.lights, scene.lights);
    assert_eq!(back.cameras, scene.cameras);
    assert_eq!(back.brdf, scene.brdf);
    let used = json_of(&bytes)["extensionsUsed"].clone();
    assert_eq!(used.as_array().unwrap().len(), 5, "{used}");
}

#[test]
fn gltf_says_what_it_can_of_the_lobe() {
    let json = json_of(&gltf::to_glb(&scene()).unwrap());
    let material = |i: usize| &json["materials"][i];
    assert_eq!(material(0)["extensions"]["KHR_materials_specular"]["specularFactor"], 0.0);
    assert_eq!(material(1)["pbrMetallicRoughness"]["metallicFactor"], 1.0);
    assert_eq!(material(1)["pbrMetallicRoughness"]["roughnessFactor"], 0.0);
    let brushed = &material(3)["extensions"]["KHR_materials_anisotropy"];
    let strength = brushed["anisotropyStrength"].as_f64().unwrap();
    assert!((0.07 + 0.93 * strength * strength - 0.11).abs() < 1e-6);
    let rotation = brushed["anisotropyRotation"].as_f64().unwrap();
    let expected = 1.234_567_9 + std::f64::consts::FRAC_PI_2;
    assert!((rotation - expected.rem_euclid(std::f64::consts::PI)).abs() < 1e-6);
    let along = &material(4)["extensions"]["KHR_materials_anisotropy"];
    let rotation = along["anisotropyRotation"].as_f64().unwrap();
    assert!((rotation - (std::f64::consts::PI - 0.3)).abs() < 1e-6, "alpha_x is the rougher");
    assert_eq!(material(3)["extras"]["unrender"]["alpha_x"], 0.07);
}

#[test]
fn without_the_extras_the_reader_understands_the_writer() {
    let folder = Folder::new();
    let mut json = json_of(&gltf::to_glb(&scene()).unwrap());
    let bytes = gltf::to_glb(&scene()).unwrap();
    json["materials"].as_array_mut().unwrap().iter_mut().for_each(|m| {
        m.as_object_mut().unwrap().remove("extras");
    });
    let start = 28 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let (back, _) = load_scene(&folder.file("a.glb", glb(&json, &bytes[start..]))).unwrap();
    for (group, material) in back.groups.iter().zip(materials()) {
        let near = |a: Rgb, b: Rgb| (a - b).abs().max_element() < 1e-4;
        assert!(near(group.material.rho_s, material.rho_s), "{}", group.name);
        if material.texture.is_none() {
            assert!(near(group.material.rho_d, material.rho_d), "{}", group.name);
        }
        let alphas = |m: &Material| (m.alpha_x.min(m.alpha_y), m.alpha_x.max(m.alpha_y).min(1.0));
        let (a, b) = (alphas(&group.material), alphas(&material));
        assert!((a.0 - b.0).abs() < 1e-5 && (a.1 - b.1).abs() < 1e-5, "{}", group.name);
    }
}

#[test]
fn a_dressed_file_keeps_the_rest() {
    let folder = Folder::new();
    let source = changed(|json, _| {
        json["nodes"] = json!([{ "name": "parent", "children": [1], "scale": [-2, 1, 1],
            "extras": { "keep": 0.1 } }, { "name": "tri", "mesh": 0 }]);
        let other = json!({ "attributes": { "POSITION": 0 } });
        json["meshes"][0]["primitives"].as_array_mut().unwrap().push(other);
        json["materials"][0]["extras"] = json!({ "mine": [1, 2] });
        json["materials"][0]["extensions"]["KHR_materials_clearcoat"] = json!({});
        json["materials"].as_array_mut().unwrap().push(json!({ "name": "unused" }));
        json["extensionsUsed"] = json!(["KHR_materials_clearcoat", "KHR_materials_ior"]);
        json["animations"] = json!([{ "name": "spin", "channels": [], "samplers": [] }]);
    });
    let path = folder.file("source.glb", &source);
    let (mut scene, _) = load_scene(&path).unwrap();
    scene.brdf = WardModel::Ward1992.into();
    scene.groups[0].material = materials()[3].clone();
    scene.groups[1].material = materials()[5].clone();
    let bytes = assign_materials(&path, &scene, &[]).unwrap();
    let (back, _) = load_scene(&folder.file("assigned.glb", &bytes)).unwrap();
    assert_eq!(back.objects, scene.objects);
    assert_eq!(back.brdf, scene.brdf);
    assert_eq!(back.groups[0], scene.groups[0]);
    assert_eq!(back.groups[1].name, "default");
    assert!(back.groups[1].material.texture.is_some());
    let json = json_of(&bytes);
    assert_eq!(json["nodes"], json_of(&source)["nodes"]);
    assert_eq!(json["animations"], json_of(&source)["animations"]);
    assert_eq!(json["materials"][0]["extras"]["mine"], json!([1, 2]));
    assert_eq!(json["materials"][1], json!({ "name": "unused" }));
    let used = json["extensionsUsed"].as_array().unwrap();
    for name in ["clearcoat", "ior", "specular", "anisotropy", "emissive_strength"] {
        assert!(used.contains(&json!(format!("KHR_materials_{name}"))), "{name} in {used:?}");
    }
    // With pure mirrors the extensions are no longer needed.
    scene.groups.iter_mut().for_each(|g| g.material = Material::mirror(Rgb::ONE));
    let plain = json_of(&assign_materials(&path, &scene, &[]).unwrap());
    let used = ["KHR_materials_clearcoat", "KHR_materials_emissive_strength"];
    assert_eq!(plain["extensionsUsed"], json!(used));
}

#[test]
fn a_dressed_file_shines_as_the_scene_does() {
    let folder = Folder::new();
    let source = changed(|json, _| {
        let punctual = |light: usize| json!({ "KHR_lights_punctual": { "light": light } });
        json["nodes"] = json!([
            { "name": "tri", "mesh": 0, "children": [1] },
            { "name": "left", "extensions": punctual(1) },
            { "name": "right", "extensions": punctual(1), "translation": [1, 0, 0] },
            { "extensions": punctual(0), "rotation": [0.6, 0, 0, 0.8] },
            { "name": "kept", "extensions": punctual(2) },
        ]);
        json["scenes"][0]["nodes"] = json!([0, 3, 2, 4]);
        json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
            { "name": "sun", "type": "directional", "intensity": 3 },
            { "type": "spot", "color": [1, 0.5, 0.1], "range": 9, "spot": { "outerConeAngle": 0.5 } },
            { "type": "point", "color": [0.3, 0.2, 0.1], "intensity": 0.7 },
        ] } });
        json["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
    });
    let path = folder.file("source.glb", &source);
    let (mut scene, _) = load_scene(&path).unwrap();
    let same = json_of(&assign_materials(&path, &scene, &[]).unwrap());
    assert_eq!(same["extensions"], json_of(&source)["extensions"]);
    assert_eq!(same["materials"][0]["emissiveFactor"], json!([1, 0.5, 0.25]));
    assert!(same["materials"][0].get("emissiveTexture").is_some());

    let names: Vec<&str> = scene.sources().map(|source| source.name).collect();
    assert_eq!(names, ["lamp", "left", "sun", "right", "kept"]);
    let strengths = [
        Rgb::new(0.1, 1e-3, 1.0 / 3.0),
        Rgb::new(123.456, 7.0, 0.0),
        Rgb::splat(0.9),
        Rgb::new(0.3, 40.1, 2e-7),
    ];
    for (index, strength) in strengths.into_iter().enumerate() {
        *scene.strength_mut(index).unwrap() = strength;
    }
    let bytes = assign_materials(&path, &scene, &[]).unwrap();
    let (back, _) = load_scene(&folder.file("assigned.glb", &bytes)).unwrap();
    assert_eq!((&back.lights, &back.groups), (&scene.lights, &scene.groups));
    let json = json_of(&bytes);
    let lights = &json["extensions"]["KHR_lights_punctual"]["lights"];
    assert_eq!(lights.as_array().unwrap().len(), 5, "what two nodes shared has become two");
    assert_eq!(lights[1], json_of(&source)["extensions"]["KHR_lights_punctual"]["lights"][1]);
    assert_eq!(lights[2], json!({ "type": "point", "color": [0.3, 0.2, 0.1], "intensity": 0.7 }));
    assert_eq!((&lights[3]["range"], &lights[3]["type"]), (&json!(9), &json!("spot")));
    assert!(json["materials"][0].get("emissiveTexture").is_none(), "it shines alike all over");
    let used = json["extensionsUsed"].as_array().unwrap();
    assert!(!used.contains(&json!("KHR_materials_emissive_strength")), "{used:?}");

    // Brighter than one: the colour stays within glTF's bounds, and the product is exact.
    scene.groups[0].emission = Rgb::new(41.3, 12.34, 0.1);
    let bytes = assign_materials(&path, &scene, &[]).unwrap();
    let (back, _) = load_scene(&folder.file("assigned.glb", &bytes)).unwrap();
    assert_eq!(back.groups, scene.groups);
    let factor = &json_of(&bytes)["materials"][0]["emissiveFactor"];
    assert!(factor.as_array().unwrap().iter().all(|c| c.as_f64().unwrap() <= 1.0), "{factor}");
}

#[test]
fn cameras_are_added_to_the_file_and_replace_their_namesakes() {
    let folder = Folder::new();
    let scene = scene();
    let path = folder.file("a.glb", gltf::to_glb(&scene).unwrap());
    let eye = scene.bounds().unwrap()[1];
    let of = |name: &str| Camera::look_at(name, eye, glam::Vec3::ZERO, glam::Vec3::Y, 0.6);
    let added = [of("photograph"), of(&scene.cameras[0].name)];
    let bytes = assign_materials(&path, &scene, &added).unwrap();
    let (back, _) = load_scene(&folder.file("b.glb", bytes)).unwrap();
    assert_eq!(back.cameras.len(), scene.cameras.len() + 1);
    for added in added {
        let found = back.cameras.iter().find(|camera| camera.name == added.name).unwrap();
        assert!(found.origin().distance(eye) < 1e-4 && (found.fov_y_rad - 0.6).abs() < 1e-6);
    }
}

#[test]
fn buffers_and_pictures_beside_the_file_are_embedded() {
    let folder = Folder::new();
    let picture = {
        let mut scene = scene();
        scene.groups.truncate(6);
        scene.objects.truncate(6);
        let glb = gltf::to_glb(&scene).unwrap();
        let at = glb.windows(4).position(|w| w == b"\x89PNG").unwrap();
        glb[at..].to_vec()
    };
    folder.file("picture one.png", picture);
    folder.file("buffer.bin", triangle_bytes());
    let mut json = triangle_json();
    json["buffers"][0]["uri"] = json!("buffer.bin");
    json["buffers"].as_array_mut().unwrap().push(json!({ "uri": "buffer.bin", "byteLength": 78 }));
    json["bufferViews"][2]["buffer"] = json!(1);
    json["images"] = json!([{ "uri": "picture%20one.png" }]);
    json["textures"] = json!([{ "source": 0 }]);
    json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    let path = folder.file("source.gltf", json.to_string());
    let (scene, _) = load_scene(&path).unwrap();
    let texture = scene.groups[0].material.texture.as_ref().unwrap();
    let factor = Rgb::new(0.25, 0.5, 0.75);
    for (texel, original) in texture.image.pixels().iter().zip(checker().image.pixels()) {
        assert!((*texel - *original * factor).abs().max_element() < 1e-6);
    }

    let elsewhere = Folder::new();
    let mut nothing = scene.clone();
    nothing.groups[0].name = "another".into();
    let bytes = assign_materials(&path, &nothing, &[]).unwrap();
    let (back, _) = load_scene(&elsewhere.file("alone.glb", bytes)).unwrap();
    assert_eq!(back, scene);
}

#[test]
fn placed_cameras_keep_their_bits() {
    let mut scene = scene();
    let turn = Quat::from_xyzw(-0.009_053_303, -0.006_149_317, -0.002_105_296_4, 0.999_937_9);
    scene.cameras[0].world_from_camera =
        Affine3A::from_rotation_translation(turn, Vec3::splat(0.1));
    let folder = Folder::new();
    let path = folder.file("a.glb", gltf::to_glb(&scene).unwrap());
    assert_eq!(load_scene(&path).unwrap().0.cameras, scene.cameras);
}

#[test]
fn damaged_textures_and_lights_never_panic() {
    let whole = gltf::to_glb(&scene()).unwrap();
    let folder = Folder::new();
    let mut numbers = Numbers(11);
    for _ in 0..2000 {
        let path = folder.file("a.glb", damaged(&whole, &mut numbers));
        if let Ok((mut scene, _)) = load_scene(&path) {
            assign_materials(&path, &scene, &[]).unwrap();
            for index in 0..scene.groups.len() + scene.lights.len() {
                *scene.strength_mut(index).unwrap() *= 0.3;
            }
            assign_materials(&path, &scene, &[]).unwrap();
            gltf::to_glb(&scene).unwrap();
        }
    }
}
