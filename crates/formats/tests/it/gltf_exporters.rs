//! What exporters write by default: transformed textures, quantised meshes, extensions that mean
//! nothing here, cameras in nodes of their own.

use crate::support::{Folder, changed, glb, triangle_bytes};
use glam::{Vec2, Vec3};
use serde_json::{Value, json};
use std::sync::Arc;
use unrender_formats::{assign_materials, gltf, load_scene, place};
use unrender_scene::{
    Camera, Group, Image, Light, LightKind, Material, Mesh, Object, Rgb, Scene, Texture, Wrap,
};

const UVS: [Vec2; 3] = [Vec2::new(0.1, 0.2), Vec2::new(0.9, 0.3), Vec2::new(0.4, 0.8)];

fn texture(texel: impl Fn(usize, usize) -> Rgb) -> Texture {
    let image = Image::from_fn(8, 8, texel);
    Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat }
}

/// A `.glb` of one textured triangle, taken apart into JSON and buffer.
fn textured() -> (Value, Vec<u8>) {
    let mut material = Material::diffuse(Rgb::ONE);
    let codes = |x: usize, y: usize| Rgb::new(x as f32 / 7.0, y as f32 / 7.0, 0.0);
    material.texture = Some(Arc::new(texture(codes)));
    let mesh = Mesh::flat(&[Vec3::ZERO, Vec3::X, Vec3::Y], &UVS, &[[0, 1, 2]]);
    let kind = LightKind::Point { position: Vec3::Z, intensity: Rgb::ONE };
    let scene = Scene {
        lights: vec![Light { name: "l".into(), kind }],
        objects: vec![Object { name: "o".into(), group: 0, mesh }],
        groups: vec![Group { name: "g".into(), material, emission: Rgb::ZERO }],
        ..Scene::default()
    };
    parts(&gltf::to_glb(&scene).unwrap())
}

fn parts(glb: &[u8]) -> (Value, Vec<u8>) {
    let end = 20 + u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&glb[20..end]).unwrap(), glb[end + 8..].to_vec())
}

/// The lines that Blender's exporter writes for a Mapping node of type Point, and where that node puts
/// a point of the texture coordinates; both as io_scene_gltf2 has them (`com/conversion.py`).
fn mapping(location: Vec2, rotation: f32, scale: Vec2) -> (Value, impl Fn(Vec2) -> Vec2) {
    let (sin, cos) = rotation.sin_cos();
    let offset = [location.x - scale.y * sin, 1.0 - location.y - scale.y * cos];
    let json = json!({ "offset": offset, "rotation": rotation, "scale": scale.to_array() });
    let mapped = move |uv: Vec2| {
        // Blender's v grows upwards.
        let scaled = Vec2::new(uv.x, 1.0 - uv.y) * scale;
        let point = location + Vec2::from_angle(rotation).rotate(scaled);
        Vec2::new(point.x, 1.0 - point.y)
    };
    (json, mapped)
}

fn at_centre(mesh: &Mesh) -> Vec2 {
    mesh.uvs.iter().sum::<Vec2>() / 3.0
}

#[test]
fn a_mapping_node_puts_the_texture_where_blender_does() {
    let folder = Folder::new();
    let (mut json, bin) = textured();
    for (location, rotation, scale) in [
        (Vec2::new(0.25, 0.5), 0.0, Vec2::splat(3.0)),
        (Vec2::ZERO, 0.7, Vec2::new(2.0, 0.5)),
        (Vec2::new(-0.3, 0.1), -2.0, Vec2::new(-1.0, 1.5)),
    ] {
        let (transform, mapped) = mapping(location, rotation, scale);
        let info = &mut json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
        info["extensions"] = json!({ "KHR_texture_transform": transform });
        json["extensionsUsed"] = json!(["KHR_texture_transform"]);
        json["extensionsRequired"] = json!(["KHR_texture_transform"]);
        let path = folder.file("a.glb", glb(&json, &bin));
        let (mut scene, warnings) = load_scene(&path).unwrap();
        assert_eq!(warnings.0, [""; 0]);
        let mesh = &scene.objects[0].mesh;
        for (uv, raw) in mesh.uvs.iter().zip(UVS) {
            assert!((*uv - mapped(raw)).length() < 1e-5, "{uv} against {}", mapped(raw));
        }
        // Anisotropy directions count from the growing u of the file.
        let [s, t, w] = UVS;
        let along = (Vec3::X * (w - s).y - Vec3::Y * (t - s).y).normalize();
        let is_plain = rotation == 0.0;
        assert_eq!(mesh.tangents.is_empty(), is_plain);
        assert!(is_plain || (mesh.tangents[0].truncate() - along).length() < 1e-5);

        // A recovered texture, one texel of it marked, is found where the surface has that texel.
        let centre = at_centre(mesh);
        let marked = centre.map(|c| (c.rem_euclid(1.0) * 8.0).floor()).as_uvec2();
        let red = |x: usize, y: usize| {
            if marked == glam::UVec2::new(x as u32, y as u32) { Rgb::X } else { Rgb::ZERO }
        };
        scene.groups[0].material.texture = Some(Arc::new(texture(red)));
        let assigned = assign_materials(&path, &scene, &[]).unwrap();
        let (written, _) = parts(&assigned);
        let used = written["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"].clone();
        assert_eq!(used["extensions"]["KHR_texture_transform"], transform);
        assert_eq!(written["extensionsRequired"], json!(["KHR_texture_transform"]));
        let (back, _) = load_scene(&folder.file("b.glb", assigned)).unwrap();
        let found = back.groups[0].material.texture.as_ref().unwrap();
        let uv = mapped(UVS.iter().sum::<Vec2>() / 3.0);
        let texel = uv.map(|c| (c.rem_euclid(1.0) * 8.0).floor()).as_uvec2();
        assert_eq!(*found.image.at(texel.x as usize, texel.y as usize), Rgb::X);
    }
}

#[test]
fn a_transform_goes_with_its_texture() {
    let folder = Folder::new();
    let (mut json, bin) = textured();
    let info = &mut json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    info["extensions"] = json!({ "KHR_texture_transform": { "scale": [2, 2] } });
    json["extensionsUsed"] = json!(["KHR_texture_transform"]);
    let path = folder.file("a.glb", glb(&json, &bin));
    let (mut scene, _) = load_scene(&path).unwrap();
    scene.groups[0].material = Material::diffuse(Rgb::splat(0.5));
    let (plain, _) = parts(&assign_materials(&path, &scene, &[]).unwrap());
    assert!(!plain.to_string().contains("KHR_texture_transform"), "{plain}");
}

#[test]
fn each_material_has_its_own_coordinates() {
    let folder = Folder::new();
    let (mut json, bin) = textured();
    let mut primitive = json["meshes"][0]["primitives"][0].clone();
    primitive["material"] = json!(1);
    let mut other = json["materials"][0].clone();
    other["name"] = json!("other");
    other["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
        json!({ "KHR_texture_transform": { "offset": [0.5, 0.25], "texCoord": 1 } });
    json["materials"].as_array_mut().unwrap().push(other);
    // The other set is the first one, its corners in another order.
    let uvs: Vec<u8> = [UVS[1], UVS[2], UVS[0]]
        .iter()
        .flat_map(|uv| uv.to_array())
        .flat_map(f32::to_le_bytes)
        .collect();
    let mut bin = bin;
    let start = bin.len();
    bin.extend(uvs);
    json["buffers"][0]["byteLength"] = json!(bin.len());
    let views = json["bufferViews"].as_array_mut().unwrap();
    views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": 24 }));
    let view = views.len() - 1;
    let accessors = json["accessors"].as_array_mut().unwrap();
    accessors
        .push(json!({ "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC2" }));
    primitive["attributes"]["TEXCOORD_1"] = json!(accessors.len() - 1);
    json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    let (scene, warnings) = load_scene(&folder.file("a.glb", glb(&json, &bin))).unwrap();
    assert_eq!(warnings.0, [""; 0]);
    assert_eq!(scene.objects[0].mesh.uvs, UVS);
    let moved = [UVS[1], UVS[2], UVS[0]].map(|uv| uv + Vec2::new(0.5, 0.25));
    assert_eq!(scene.objects[1].mesh.uvs, moved);
}

#[test]
fn transforms_beyond_all_numbers_are_refused() {
    let folder = Folder::new();
    let (mut json, bin) = textured();
    let info = &mut json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    info["extensions"] = json!({ "KHR_texture_transform": { "scale": [1e300, 1] } });
    let error = load_scene(&folder.file("a.glb", glb(&json, &bin))).unwrap_err().to_string();
    assert!(error.contains("KHR_texture_transform") && error.contains("a.glb"), "{error}");
}

#[test]
fn quantised_meshes_are_read() {
    let folder = Folder::new();
    // Positions are unsigned shorts, normals and texture coordinates bytes, all of them padded to 4.
    let mut bin: Vec<u8> = Vec::new();
    for corner in [[0u16, 0, 0, 0], [65535, 0, 0, 0], [0, 65535, 0, 0]] {
        bin.extend(corner.iter().flat_map(|c| c.to_le_bytes()));
    }
    bin.extend([0u8, 90, 90, 0].repeat(3));
    bin.extend([0u8, 0, 0, 0, 255, 51, 0, 0, 102, 255, 0, 0]);
    bin.extend([0u16, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
    let bytes = changed(|json, triangle| {
        json["buffers"][0]["byteLength"] = json!(bin.len());
        *triangle = bin.clone();
        let view = |start: usize, length: usize, stride: usize| json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "byteStride": stride });
        json["bufferViews"] = json!([view(0, 24, 8), view(24, 12, 4), view(36, 12, 4),
            { "buffer": 0, "byteOffset": 48, "byteLength": 6 }]);
        let numbers = |view: usize, component: u32, kind: &str| {
            json!({ "bufferView": view, "componentType": component, "normalized": true,
                "count": 3, "type": kind })
        };
        json["accessors"] = json!([
            numbers(0, 5123, "VEC3"), numbers(1, 5120, "VEC3"),
            { "bufferView": 3, "componentType": 5123, "count": 3, "type": "SCALAR" },
            numbers(2, 5121, "VEC2")
        ]);
        json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(3);
        json["nodes"][0]["scale"] = json!([2, 4, 1]);
        json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
        json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    });
    let (scene, _) = load_scene(&folder.file("a.glb", bytes)).unwrap();
    let mesh = &scene.objects[0].mesh;
    assert_eq!(mesh.positions, [Vec3::ZERO, 2.0 * Vec3::X, 4.0 * Vec3::Y]);
    assert_eq!(mesh.uvs, [Vec2::ZERO, Vec2::new(1.0, 0.2), Vec2::new(0.4, 1.0)]);
    // (0, 90, 90)/127 under the inverse transpose of the scale.
    let expected = Vec3::new(0.0, 0.25, 1.0).normalize();
    assert!((mesh.normals[0] - expected).length() < 1e-6, "{}", mesh.normals[0]);
}

#[test]
fn what_is_not_read_is_told_once_each() {
    let folder = Folder::new();
    let bytes = changed(|json, _| {
        let names =
            ["KHR_materials_diffuse_transmission", "KHR_materials_clearcoat", "VENDOR_thing"];
        json["extensionsUsed"] = json!(names);
        json["extensionsRequired"] = json!(["KHR_materials_clearcoat"]);
        let lamp = json["materials"][0].clone();
        json["materials"] = json!([lamp, lamp]);
        let primitive = json["meshes"][0]["primitives"][0].clone();
        json["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
        json["meshes"][0]["primitives"][1]["material"] = json!(1);
    });
    let (_, warnings) = load_scene(&folder.file("a.glb", bytes)).unwrap();
    let about = |name: &str| warnings.0.iter().filter(|w| w.contains(name)).collect::<Vec<_>>();
    assert_eq!(about("KHR_materials_diffuse_transmission").len(), 1, "{warnings:?}");
    assert!(about("KHR_materials_diffuse_transmission")[0].contains("opaque"));
    assert_eq!(about("KHR_materials_clearcoat").len(), 1, "{warnings:?}");
    assert!(about("VENDOR_thing")[0].contains("ignored"));
}

#[test]
fn what_cannot_be_read_says_what_to_untick() {
    let folder = Folder::new();
    for (name, words) in [
        ("KHR_draco_mesh_compression", "Compression"),
        ("EXT_meshopt_compression", "Meshopt Compression off"),
        ("KHR_texture_basisu", "PNG or JPEG"),
        ("EXT_texture_webp", "Images: Automatic"),
        ("EXT_mesh_gpu_instancing", "GPU Instances off"),
        ("VENDOR_thing", "export the scene without it"),
    ] {
        let bytes = changed(|json, _| json["extensionsRequired"] = json!([name]));
        let error = load_scene(&folder.file("a.glb", bytes)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(words), "{error}");
    }
}

/// A camera below an object, as Blender's exporter wrote it until 2021, with a child of its own.
fn with_nested_camera() -> Vec<u8> {
    let (json, _) = parts(&changed(|_, _| ()));
    let mut json = json;
    json["nodes"] = json!([
        { "name": "tri", "mesh": 0 },
        { "name": "Door", "children": [2], "translation": [0, 0, 2] },
        { "name": "Door_Orientation", "camera": 0, "children": [3] },
        { "name": "hung on the camera", "mesh": 0 },
        { "camera": 1 }
    ]);
    json["scenes"][0]["nodes"] = json!([0, 1, 4]);
    let camera = |name: &str| json!({ "name": name, "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } });
    json["cameras"] = json!([camera("Camera.001"), camera("window")]);
    glb(&json, &triangle_bytes())
}

#[test]
fn cameras_keep_their_names() {
    let folder = Folder::new();
    let path = folder.file("a.glb", with_nested_camera());
    let names = |scene: &Scene| scene.cameras.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    let (scene, _) = load_scene(&path).unwrap();
    assert_eq!(names(&scene), ["Door", "window"]);
    let (assigned, _) =
        load_scene(&folder.file("b.glb", assign_materials(&path, &scene, &[]).unwrap())).unwrap();
    assert_eq!(names(&assigned), ["Door", "window"]);
    let (own, _) = load_scene(&folder.file("c.glb", gltf::to_glb(&scene).unwrap())).unwrap();
    assert_eq!(names(&own), ["Door", "window"]);
    for name in ["Door", "window"] {
        let camera = Camera::look_at(name, Vec3::ONE, Vec3::ZERO, Vec3::Y, 0.5);
        let placed = folder.file("d.glb", place(&path, &camera, scene.origin).unwrap());
        let (back, _) = load_scene(&placed).unwrap();
        let mut wanted = names(&back);
        wanted.sort();
        assert_eq!(wanted, ["Door", "window"], "{name} is replaced, not doubled");
        let seen = back.cameras.iter().find(|c| c.name == name).unwrap();
        assert_eq!(seen.fov_y_rad, 0.5);
        assert_eq!(back.objects.len(), scene.objects.len(), "what hangs on it stays");
    }
}
