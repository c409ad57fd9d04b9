//! What is read from glTF: nodes, primitives, buffers, materials, lights, cameras.

use crate::support::{Folder, changed, triangle_bytes, triangle_json};
use glam::{DMat4, DQuat, DVec3, Vec3};
use serde_json::{Value, json};
use unrender_formats::{Input, load_scene};
use unrender_scene::{
    BrdfModel, Layering, LightKind, Material, Reflectance, Rgb, Scene, WardModel, Warnings,
};

fn load(bytes: &[u8]) -> (Scene, Warnings) {
    let folder = Folder::new();
    load_scene(&folder.file("scene.glb", bytes)).unwrap()
}

fn load_changed(change: impl FnOnce(&mut Value, &mut Vec<u8>)) -> (Scene, Warnings) {
    load(&changed(change))
}

fn front(scene: &Scene, object: usize) -> Vec3 {
    let [a, b, c] = scene.objects[object].mesh.corners(0);
    (b - a).cross(c - a).normalize()
}

fn assert_near(a: Vec3, b: Vec3) {
    assert!((a - b).length() < 1e-5, "{a} against {b}");
}

#[test]
fn the_triangle_is_read_as_it_stands() {
    let (scene, warnings) = load_changed(|_, _| ());
    assert_eq!(warnings, Warnings::default());
    assert_eq!(scene.objects.len(), 1);
    assert_eq!(scene.objects[0].name, "tri");
    assert_eq!(scene.objects[0].mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(scene.groups[0].name, "lamp");
    let rho_d = Rgb::new(0.25, 0.5, 0.75);
    assert_eq!(
        scene.groups[0].material,
        Material::plastic(rho_d, 1.5, Layering::AlbedoScaled, 1.0)
    );
    assert_eq!(scene.groups[0].emission, Rgb::new(8.0, 4.0, 2.0));
}

#[test]
fn nodes_compose_from_parent_to_child() {
    let turn = DQuat::from_rotation_y(0.7);
    let (scene, _) = load_changed(|json, _| {
        json["scenes"][0]["nodes"] = json!([1]);
        json["nodes"][0]["translation"] = json!([0, 0, 2]);
        let parent = json!({ "children": [0], "rotation": turn.to_array(), "scale": [2, 3, 1] });
        json["nodes"].as_array_mut().unwrap().push(parent);
    });
    let matrix =
        DMat4::from_scale_rotation_translation(DVec3::new(2.0, 3.0, 1.0), turn, DVec3::ZERO)
            * DMat4::from_translation(DVec3::new(0.0, 0.0, 2.0));
    for (vertex, local) in [DVec3::ZERO, DVec3::X, DVec3::Y].into_iter().enumerate() {
        let expected = matrix.transform_point3(local).as_vec3();
        assert_near(scene.objects[0].mesh.positions[vertex], expected);
    }
    assert_near(scene.objects[0].mesh.normals[0], (turn * DVec3::Z).as_vec3());
}

#[test]
fn mirrored_nodes_keep_their_front() {
    for scale in [[-1.0f32, 1.0, 1.0], [2.0, -3.0, 1.0], [-1.0, -1.0, -2.0], [-1.0, 2.0, -1.0]] {
        let (scene, warnings) = load_changed(|json, _| json["nodes"][0]["scale"] = json!(scale));
        assert_eq!(warnings, Warnings::default(), "no normal against its winding");
        let outward = Vec3::new(0.0, 0.0, scale[2].signum());
        assert_near(scene.objects[0].mesh.normals[0], outward);
        assert_near(front(&scene, 0), outward);
    }
}

#[test]
fn sheared_normals_stay_upright_on_the_surface() {
    let matrix = [1.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let (scene, _) = load_changed(|json, _| json["nodes"][0]["matrix"] = json!(matrix));
    assert_near(scene.objects[0].mesh.normals[0], front(&scene, 0));
}

#[test]
fn a_node_flattened_to_a_plane_has_normals() {
    let (scene, warnings) = load_changed(|json, _| json["nodes"][0]["scale"] = json!([1, 1, 0]));
    assert_near(scene.objects[0].mesh.normals[0], Vec3::Z);
    assert_eq!(warnings, Warnings::default());
}

#[test]
fn only_the_default_scene_counts() {
    let (scene, warnings) = load_changed(|json, _| {
        json["nodes"] = json!([{ "mesh": 0, "name": "a" }, { "mesh": 0, "name": "b" }]);
        json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [1] }]);
        json["scene"] = json!(1);
    });
    assert_eq!(scene.objects.len(), 1);
    assert_eq!(scene.objects[0].name, "b");
    assert_eq!(warnings.0, ["Of the 2 scenes of the file only the default one was read."]);
}

#[test]
fn primitives_without_indices_or_normals_are_flat() {
    let (scene, _) = load_changed(|json, _| {
        json["meshes"][0]["primitives"][0] =
            json!({ "attributes": { "POSITION": 0 }, "material": 0 });
    });
    assert_eq!(scene.objects[0].mesh.triangles, [[0, 1, 2]]);
    assert_eq!(scene.objects[0].mesh.normals, [Vec3::Z; 3]);
}

#[test]
fn strips_and_fans_keep_their_winding() {
    for (mode, order) in [(5, [0u16, 1, 2, 3]), (6, [0, 1, 3, 2])] {
        let corners = [[0.0f32, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let (scene, warnings) = load_changed(|json, bin| {
            *bin =
                corners.iter().flat_map(|c| [c[0], c[1], 0.0]).flat_map(f32::to_le_bytes).collect();
            bin.extend(order.iter().flat_map(|i| i.to_le_bytes()));
            json["buffers"][0]["byteLength"] = json!(56);
            json["bufferViews"] = json!([
                { "buffer": 0, "byteLength": 48 },
                { "buffer": 0, "byteOffset": 48, "byteLength": 8 }
            ]);
            json["accessors"] = json!([
                { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
                { "bufferView": 1, "componentType": 5123, "count": 4, "type": "SCALAR" }
            ]);
            json["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 }, "indices": 1, "mode": mode, "material": 0 });
        });
        assert_eq!(warnings, Warnings::default());
        assert_eq!(scene.triangle_count(), 2, "mode {mode}");
        assert!(scene.objects[0].mesh.normals.iter().all(|n| *n == Vec3::Z), "mode {mode}");
        let area: f32 = (0..2)
            .map(|i| {
                let [a, b, c] = scene.objects[0].mesh.corners(i);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        assert_eq!(area, 1.0);
    }
}

#[test]
fn sparse_and_normalised_accessors() {
    let (scene, _) = load_changed(|json, bin| {
        bin.extend([2, 0]);
        bin.extend([0.0f32, 5.0, 0.0].into_iter().flat_map(f32::to_le_bytes));
        bin.extend([0u8, 0, 255, 0, 0, 255]);
        json["buffers"][0]["byteLength"] = json!(98);
        let views = json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": 78, "byteLength": 1 }));
        views.push(json!({ "buffer": 0, "byteOffset": 80, "byteLength": 12 }));
        views.push(json!({ "buffer": 0, "byteOffset": 92, "byteLength": 6 }));
        json["accessors"][0]["sparse"] = json!({
            "count": 1,
            "indices": { "bufferView": 3, "componentType": 5121 },
            "values": { "bufferView": 4 },
        });
        let uv = json!({ "bufferView": 5, "componentType": 5121, "count": 3, "type": "VEC2",
            "normalized": true });
        json["accessors"].as_array_mut().unwrap().push(uv);
        json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(3);
    });
    let mesh = &scene.objects[0].mesh;
    assert_eq!(mesh.positions[2], Vec3::new(0.0, 5.0, 0.0));
    assert_eq!(
        mesh.uvs.iter().map(|uv| uv.to_array()).collect::<Vec<_>>(),
        [[0., 0.], [1., 0.], [0., 1.]]
    );
}

#[test]
fn one_node_has_one_object_a_material() {
    let (scene, warnings) = load_changed(|json, _| {
        let primitive = json["meshes"][0]["primitives"][0].clone();
        let mut other = primitive.clone();
        other["material"] = json!(2);
        let mut none = primitive.clone();
        none.as_object_mut().unwrap().remove("material");
        json["meshes"][0]["primitives"] = json!([primitive, other, primitive, none]);
        let lamp = json["materials"][0].clone();
        json["materials"] = json!([lamp, { "name": "unused" }, lamp]);
        json["nodes"][0].as_object_mut().unwrap().remove("name");
    });
    let groups: Vec<&str> = scene.groups.iter().map(|g| g.name.as_str()).collect();
    assert_eq!(groups, ["lamp", "lamp (2)", "default"]);
    let objects: Vec<_> = scene.objects.iter().map(|o| (o.group, o.mesh.triangles.len())).collect();
    assert_eq!(objects, [(0, 2), (1, 1), (2, 1)]);
    assert_eq!(scene.objects[0].name, "object 0");
    assert_eq!(warnings.0.len(), 2, "{warnings:?}");
}

#[test]
fn nodes_without_names_that_share_a_mesh_have_names_of_their_own() {
    let (scene, _) = load_changed(|json, _| {
        json["meshes"][0]["name"] = json!("chair");
        json["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0 }, { "name": "mine", "mesh": 0 }]);
        json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    });
    let names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["chair (node 0)", "chair (node 1)", "mine"]);
}

#[test]
fn gltf_with_data_uri_and_with_a_file_are_the_same() {
    let folder = Folder::new();
    let (expected, _) = load_changed(|_, _| ());
    let mut json = triangle_json();
    json["buffers"][0]["uri"] = json!("tri%20angle.bin");
    folder.file("tri angle.bin", triangle_bytes());
    assert_eq!(load_scene(&folder.file("a.gltf", json.to_string())).unwrap().0, expected);
    let digits: String = triangle_bytes().iter().map(|b| format!("%{b:02x}")).collect();
    json["buffers"][0]["uri"] = json!(format!("data:application/octet-stream,{digits}"));
    assert_eq!(load_scene(&folder.file("b.gltf", json.to_string())).unwrap().0, expected);
    // The same bytes in base64.
    json["buffers"][0]["uri"] = json!(format!("data:;base64,{}", base64(&triangle_bytes())));
    assert_eq!(load_scene(&folder.file("c.gltf", json.to_string())).unwrap().0, expected);
}

fn base64(bytes: &[u8]) -> String {
    use base64::Engine;
    base64::engine::general_purpose::STANDARD.encode(bytes)
}

#[test]
fn lights_and_cameras_stand_where_their_nodes_are() {
    let (scene, warnings) = load_changed(|json, _| {
        let half = 0.5f64.sqrt();
        let node = |light: usize| {
            json!({ "translation": [1, 2, 3], "rotation": [half, 0, 0, half],
                "extensions": { "KHR_lights_punctual": { "light": light } } })
        };
        json["nodes"] = json!([
            { "mesh": 0 }, node(0), node(1), node(2),
            { "name": "eye", "camera": 0, "translation": [0, 0, 5], "scale": [3, 3, 3] },
            { "camera": 1 }
        ]);
        json["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4, 5]);
        json["extensions"]["KHR_lights_punctual"]["lights"] = json!([
            { "type": "point", "color": [1, 0.5, 0], "intensity": 4, "name": "bulb" },
            { "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 } },
            { "type": "directional", "intensity": 3 }
        ]);
        json["cameras"] = json!([
            { "type": "perspective", "perspective": { "yfov": 0.8, "aspectRatio": 1.5 } },
            { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1 } }
        ]);
    });
    assert_eq!(scene.lights[0].name, "bulb");
    let position = Vec3::new(1.0, 2.0, 3.0);
    let intensity = Rgb::new(4.0, 2.0, 0.0);
    assert_eq!(scene.lights[0].kind, LightKind::Point { position, intensity });
    let LightKind::Spot { direction, outer_rad, .. } = scene.lights[1].kind else { panic!() };
    assert_near(direction, Vec3::Y);
    assert_eq!(outer_rad, 0.2);
    let LightKind::Directional { irradiance, .. } = scene.lights[2].kind else { panic!() };
    assert_eq!(irradiance, Rgb::splat(3.0));
    assert_eq!(scene.cameras.len(), 1);
    let camera = &scene.cameras[0];
    assert_eq!((camera.name.as_str(), camera.fov_y_rad, camera.aspect), ("eye", 0.8, Some(1.5)));
    assert_near(camera.origin(), Vec3::new(0.0, 0.0, 5.0));
    assert_near(camera.direction(0.5, 0.5, 1, 1), Vec3::NEG_Z);
    assert_eq!(warnings.0.len(), 1, "{warnings:?}");
}

#[test]
fn metallic_roughness_becomes_plastics_and_metals() {
    let material = |pbr: Value, extensions: Value| {
        let (scene, _) = load_changed(|json, _| {
            json["materials"][0]["pbrMetallicRoughness"] = pbr;
            json["materials"][0]["extensions"] = extensions;
        });
        scene.groups[0].material.clone()
    };
    let metal = material(
        json!({ "baseColorFactor": [0.5, 0.25, 1, 1], "metallicFactor": 1, "roughnessFactor": 0.5 }),
        json!({ "KHR_materials_anisotropy": { "anisotropyStrength": 0.5 } }),
    );
    assert_eq!(metal.rho_d, Rgb::ZERO);
    assert_eq!(metal.rho_s, Rgb::new(0.5, 0.25, 1.0));
    assert_eq!((metal.alpha_x, metal.alpha_y), (0.25, 0.25 + 0.75 * 0.25));
    assert!((metal.theta_rad - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    let plastic = material(
        json!({ "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0, "roughnessFactor": 0.1 }),
        json!({}),
    );
    assert_eq!(plastic.rho_d, Rgb::splat(0.5));
    assert!((plastic.rho_s - Rgb::splat(0.04)).length() < 1e-6);
    let plain = json!({ "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0 });
    let plastic = |ior: f32, alpha: f32| {
        Material::plastic(Rgb::splat(0.5), ior, Layering::AlbedoScaled, alpha)
    };
    assert_eq!(material(plain.clone(), json!({})), plastic(1.5, 1.0));
    let matt = json!({ "KHR_materials_specular": { "specularFactor": 0 } });
    assert_eq!(material(plain.clone(), matt), Material::diffuse(Rgb::splat(0.5)));
    let dense = json!({ "KHR_materials_ior": { "ior": 2 } });
    let Reflectance::Dielectric { ior, .. } = material(plain.clone(), dense).reflectance else {
        panic!("a dielectric")
    };
    assert!((ior - 2.0).abs() < 1e-4, "{ior}");
    let half = json!({ "KHR_materials_specular": { "specularFactor": 0.5 } });
    let found = material(plain.clone(), half).rho_s;
    assert!((found - Rgb::splat(0.02)).length() < 1e-6, "{found}");
    let coat = json!({ "clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.2 });
    let varnish = json!({ "KHR_materials_clearcoat": coat });
    assert_eq!(material(plain, varnish), plastic(1.5, 0.2 * 0.2));
    let mixed = material(
        json!({ "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0.5, "roughnessFactor": 0.5 }),
        json!({}),
    );
    assert_eq!((mixed.reflectance, mixed.rho_d), (Reflectance::Free, Rgb::splat(0.25)));
}

#[test]
fn a_model_of_free_reflectances_gets_these() {
    let folder = Folder::new();
    let path = folder.file(
        "scene.glb",
        changed(|json, _| {
            json["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = json!(0.5);
        }),
    );
    let (scene, _) = load_scene(Input::from(&path).with_brdf(WardModel::WardGmd.into())).unwrap();
    let material = &scene.groups[0].material;
    assert_eq!((material.reflectance, material.alpha_x), (Reflectance::Free, 0.25));
    assert!((material.rho_s.x - 0.04).abs() < 1e-6);
}

#[test]
fn a_lobe_that_the_file_does_not_state_is_the_one_that_is_asked_for() {
    let folder = Folder::new();
    let path = folder.file("scene.glb", changed(|_, _| ()));
    for brdf in [BrdfModel::Ggx, WardModel::Ward1992.into()] {
        let (scene, _) = load_scene(Input::from(&path).with_brdf(brdf)).unwrap();
        assert_eq!(scene.brdf, brdf);
        // What it states is not changed.
        let stated = Scene { brdf: WardModel::WardGmd.into(), ..scene };
        let path = folder.file("stated.glb", unrender_formats::gltf::to_glb(&stated).unwrap());
        let (scene, _) = load_scene(Input::from(&path).with_brdf(brdf)).unwrap();
        assert_eq!(scene.brdf, stated.brdf);
    }
}
