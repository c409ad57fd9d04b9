//! Warnings name everything in a glTF file that is not read, except what changes nothing.

use crate::support::{Folder, changed, glb, triangle_bytes, triangle_json};
use glam::{Vec2, Vec3};
use serde_json::{Map, Value, json};
use unrender_formats::load_scene;
use unrender_scene::{Glass, Rgb, Scene, Warnings};

fn load(json: &Value, bin: &[u8]) -> (Scene, Warnings) {
    let folder = Folder::new();
    load_scene(&folder.file("scene.glb", glb(json, bin))).unwrap()
}

fn told(change: impl FnOnce(&mut Value)) -> Vec<String> {
    let mut json = triangle_json();
    change(&mut json);
    load(&json, &triangle_bytes()).1.0
}

fn fault(json: &Value, bin: &[u8]) -> String {
    let folder = Folder::new();
    load_scene(&folder.file("scene.glb", glb(json, bin))).unwrap_err().to_string()
}

/// A white PNG of one pixel, as a URI.
const PIXEL: &str = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4DwABAQEAs\
                     Tj2FAAAAABJRU5ErkJggg==";

/// A file with one of every element that is read.
pub(crate) fn everything() -> Value {
    let mut json = triangle_json();
    json["asset"]["extras"] = json!({ "anything": {} });
    json["nodes"] = json!([
        {
            "name": "tri", "mesh": 0, "children": [1, 2], "extras": { "mine": {} },
            "extensions": { "KHR_node_visibility": { "visible": true } }
        },
        { "camera": 0 },
        { "extensions": { "KHR_lights_punctual": { "light": 0 } } }
    ]);
    json["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1, "zfar": 9 } }]);
    json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 } }
    ] }, "EXT_lights_ies": { "lights": [{ "uri": "lamp.ies" }] } });
    json["samplers"] = json!([{ "minFilter": 9987, "magFilter": 9729, "wrapS": 10497 }]);
    json["images"] = json!([{ "uri": PIXEL, "mimeType": "image/png", "name": "pixel" }]);
    json["textures"] = json!([{ "source": 0, "sampler": 0, "name": "texture" }]);
    let material = &mut json["materials"][0];
    material["alphaMode"] = json!("OPAQUE");
    material["pbrMetallicRoughness"]["baseColorTexture"] = json!({
        "index": 0, "extensions": { "KHR_texture_transform": { "scale": [2, 2] } }
    });
    material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = json!({ "index": 0 });
    for (name, value) in [
        ("KHR_materials_ior", json!({ "ior": 1.4 })),
        ("KHR_materials_specular", json!({ "specularFactor": 0.5 })),
        ("KHR_materials_anisotropy", json!({ "anisotropyStrength": 0.5 })),
        ("KHR_materials_transmission", json!({ "transmissionFactor": 0 })),
        ("KHR_materials_volume", json!({ "thicknessFactor": 0 })),
        ("KHR_materials_clearcoat", json!({ "clearcoatFactor": 0 })),
    ] {
        material["extensions"][name] = value;
    }
    let attributes = &mut json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_0"] = json!(3);
    json["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": 2, "componentType": 5123 },
        "values": { "bufferView": 0 }
    });
    json["accessors"][0]["min"] = json!([0, 0, 0]);
    let uvs = json!({ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC2" });
    json["accessors"].as_array_mut().unwrap().push(uvs);
    json["bufferViews"][0]["target"] = json!(34962);
    json
}

/// The paths of all objects in `json` that are neither extras nor lists of attributes.
fn objects(json: &Value, path: &str, found: &mut Vec<String>) {
    match json {
        Value::Object(entries) => {
            found.push(path.to_owned());
            for (key, inner) in entries.iter().filter(|(key, _)| *key != "extras") {
                objects(inner, &format!("{path}/{key}"), found);
            }
        }
        Value::Array(items) => {
            let paths = items.iter().enumerate();
            paths.for_each(|(index, item)| objects(item, &format!("{path}/{index}"), found));
        }
        _ => (),
    }
}

#[test]
fn what_no_reader_asks_for_is_told_in_every_element() {
    let (whole, bin) = (everything(), triangle_bytes());
    let (_, before) = load(&whole, &bin);
    let harmless = ["of the metallicRoughnessTexture only the mean"];
    let is_harmless = |warning: &String| harmless.iter().any(|part| warning.contains(part));
    assert!(before.0.iter().all(is_harmless), "{before:?}");
    let mut paths = Vec::new();
    objects(&whole, "", &mut paths);
    assert!(paths.len() > 35, "{paths:?}");
    for path in &paths {
        let mut json = whole.clone();
        json.pointer_mut(path).unwrap()["unreadThing"] = json!(0);
        let (_, warnings) = load(&json, &bin);
        assert!(warnings.0.iter().any(|w| w.contains("unreadThing")), "{path}: {warnings:?}");
        if path.ends_with("/extensions") || path.ends_with("/attributes") {
            continue;
        }
        let mut json = whole.clone();
        let object = json.pointer_mut(path).unwrap().as_object_mut().unwrap();
        let extensions = object.entry("extensions").or_insert_with(|| Value::Object(Map::new()));
        extensions["VENDOR_thing"] = json!({});
        let (_, warnings) = load(&json, &bin);
        let is_told = |w: &String| w.contains("extension VENDOR_thing is not understood");
        assert!(warnings.0.iter().any(is_told), "{path}: {warnings:?}");
    }
}

#[test]
fn what_changes_the_looks_of_things_is_told_by_name() {
    let material =
        |key: &'static str, value: Value| move |json: &mut Value| json["materials"][0][key] = value;
    let attribute = |key: &'static str| {
        move |json: &mut Value| json["meshes"][0]["primitives"][0]["attributes"][key] = json!(1)
    };
    let one = |warnings: Vec<String>, part: &str| {
        assert!(warnings.len() == 1 && warnings[0].contains(part), "{part}: {warnings:?}");
    };
    one(told(attribute("COLOR_0")), "group \"lamp\": the vertex colours (COLOR_0)");
    one(told(attribute("VELOCITY")), "attribute VELOCITY is not read");
    assert_eq!(told(attribute("TEXCOORD_3")), [""; 0]);
    assert_eq!(told(attribute("_BATCH")), [""; 0]);
    one(told(material("occlusionTexture", json!({ "index": 0 }))), "occlusionTexture is not read");
    one(told(material("alphaMode", json!("BLEND"))), "is transparent all over");
    one(told(|json| json["animations"] = json!([{}])), "Animations were ignored");
    let extension = |name: &'static str, value: Value| {
        told(move |json| json["materials"][0]["extensions"][name] = value)
    };
    // A lamp shines, whatever it lets through.
    let through = json!({ "transmissionFactor": 1 });
    assert_eq!(extension("KHR_materials_transmission", through), [""; 0]);
    one(extension("KHR_materials_diffuse_transmission", json!({})), "transparent surfaces");
    let specular =
        json!({ "specularTexture": { "index": 0 }, "specularColorTexture": { "index": 0 } });
    let warnings = extension("KHR_materials_specular", specular);
    assert!(warnings.len() == 2 && warnings[1].contains("specularTexture"), "{warnings:?}");
    assert!(warnings[0].contains("material \"lamp\"'s KHR_materials_specular"), "{warnings:?}");
    one(
        extension("KHR_materials_anisotropy", json!({ "anisotropyTexture": { "index": 0 } })),
        "KHR_materials_anisotropy: the property anisotropyTexture",
    );
    one(
        told(|json| {
            json["meshes"][0]["primitives"][0]["extensions"] =
                json!({ "KHR_gaussian_splatting": {} });
        }),
        "KHR_gaussian_splatting is not understood",
    );
}

#[test]
fn a_texture_in_blocks_is_told() {
    let mut json = everything();
    json["samplers"][0]["magFilter"] = json!(9728);
    let (_, warnings) = load(&json, &triangle_bytes());
    assert!(warnings.0.iter().any(|w| w.contains("magFilter NEAREST")), "{warnings:?}");
}

#[test]
fn hidden_nodes_are_left_out_with_what_hangs_on_them() {
    let mut json = triangle_json();
    json["extensionsUsed"] = json!(["KHR_node_visibility"]);
    json["extensionsRequired"] = json!(["KHR_node_visibility"]);
    json["nodes"] = json!([
        { "name": "tri", "mesh": 0 },
        {
            "children": [2], "mesh": 0, "name": "hidden",
            "extensions": { "KHR_node_visibility": { "visible": false } }
        },
        { "mesh": 0, "name": "below", "extensions": { "KHR_node_visibility": { "visible": true } } },
        { "mesh": 0, "name": "shown", "extensions": { "KHR_node_visibility": {} } }
    ]);
    json["scenes"][0]["nodes"] = json!([0, 1, 3]);
    let (scene, warnings) = load(&json, &triangle_bytes());
    let names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["tri", "shown"]);
    assert_eq!(warnings.0, [""; 0]);
}

/// The triangle with accessors that have no bytes of their own: `values` are put in at `indices`, all of them
/// of the component types of their bytes.
fn sparse(accessor: &Value, at: (u32, &[u8]), values: &[u8]) -> (Value, Vec<u8>) {
    let (mut json, mut bin) = (triangle_json(), triangle_bytes());
    bin.resize(80, 0);
    bin.extend_from_slice(at.1);
    bin.resize(bin.len().next_multiple_of(4), 0);
    let start = bin.len();
    bin.extend_from_slice(values);
    let views = json["bufferViews"].as_array_mut().unwrap();
    views.push(json!({ "buffer": 0, "byteOffset": 80, "byteLength": at.1.len() }));
    views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": values.len() }));
    json["buffers"][0]["byteLength"] = json!(bin.len());
    let mut accessor = accessor.clone();
    let width = match at.0 {
        5121 => 1,
        5123 => 2,
        _ => 4,
    };
    accessor["sparse"] = json!({
        "count": at.1.len() / width,
        "indices": { "bufferView": 3, "componentType": at.0 },
        "values": { "bufferView": 4 }
    });
    json["accessors"].as_array_mut().unwrap().push(accessor);
    (json, bin)
}

#[test]
fn an_accessor_without_a_buffer_view_is_zeros_with_sparse_values_put_in() {
    // Positions in floats; the first vertex stays at the origin.
    let positions = json!({ "componentType": 5126, "count": 3, "type": "VEC3" });
    let values: Vec<u8> =
        [2.0f32, 0.0, 0.0, 0.0, 3.0, 0.0].into_iter().flat_map(f32::to_le_bytes).collect();
    for at in [(5121, &[1u8, 2][..]), (5123, &[1, 0, 2, 0]), (5125, &[1, 0, 0, 0, 2, 0, 0, 0])] {
        let (mut json, bin) = sparse(&positions, at, &values);
        json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(3);
        let (scene, _) = load(&json, &bin);
        let expected = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 3.0, 0.0)];
        assert_eq!(scene.objects[0].mesh.positions, expected);
    }
    // Normalised texture coordinates of every allowed type; the last one is a sparse value.
    let one: [(u32, &[u8]); 4] = [
        (5120, &[127, 129]),
        (5121, &[255, 0]),
        (5122, &[255, 127, 1, 128]),
        (5123, &[255, 255, 0, 0]),
    ];
    for (component, bytes) in one {
        let uvs = json!({
            "componentType": component, "count": 3, "type": "VEC2", "normalized": true
        });
        let (mut json, bin) = sparse(&uvs, (5121, &[2]), bytes);
        json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(3);
        let (scene, _) = load(&json, &bin);
        let low = if [5120, 5122].contains(&component) { -1.0 } else { 0.0 };
        let expected = [Vec2::ZERO, Vec2::ZERO, Vec2::new(1.0, low)];
        assert_eq!(scene.objects[0].mesh.uvs, expected, "{component}");
    }
    // Indices, of which zeros are the first vertex; here of two triangles.
    let indices = json!({ "componentType": 5123, "count": 6, "type": "SCALAR" });
    let (mut json, bin) = sparse(&indices, (5121, &[1, 2, 4, 5]), &[1, 0, 2, 0, 2, 0, 1, 0]);
    json["meshes"][0]["primitives"][0]["indices"] = json!(3);
    let (scene, _) = load(&json, &bin);
    assert_eq!(scene.objects[0].mesh.triangles, [[0, 1, 2], [0, 2, 1]]);
    // Without sparse values all positions are zero: a triangle that is a point.
    let (mut json, bin) = (triangle_json(), triangle_bytes());
    json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let folder = Folder::new();
    let read = load_scene(&folder.file("point.glb", glb(&json, &bin)));
    let told = read.map_or_else(
        |error| error.to_string(),
        |(scene, warnings)| {
            assert!(scene.objects.iter().all(|object| object.mesh.triangles.is_empty()));
            warnings.0.join("\n")
        },
    );
    assert!(!told.is_empty());
}

#[test]
fn bytes_between_elements_are_skipped() {
    // Positions and texture coordinates side by side, 20 bytes a vertex; then indices of whole numbers.
    let (mut json, mut bin) = (triangle_json(), Vec::new());
    for [x, y] in [[0.0f32, 0.0], [1.0, 0.0], [0.0, 1.0]] {
        [x, y, 0.0, 0.5 * x, 0.25 * y].into_iter().for_each(|v| bin.extend(v.to_le_bytes()));
    }
    json["buffers"][0]["byteLength"] = json!(60);
    json["bufferViews"] = json!([{ "buffer": 0, "byteLength": 60, "byteStride": 20 }]);
    json["accessors"] = json!([
        { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
        { "bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 3, "type": "VEC2" }
    ]);
    json["meshes"][0]["primitives"][0] =
        json!({ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 });
    let (scene, _) = load(&json, &bin);
    assert_eq!(scene.objects[0].mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(scene.objects[0].mesh.uvs, [Vec2::ZERO, Vec2::new(0.5, 0.0), Vec2::new(0.0, 0.25)]);
}

#[test]
fn accessors_without_bytes_are_bounded_and_those_of_compressed_meshes_refused() {
    let mut json = triangle_json();
    let accessor = json["accessors"][0].as_object_mut().unwrap();
    accessor.remove("bufferView");
    accessor.insert("count".into(), json!(u64::MAX / 4));
    let problem = fault(&json, &triangle_bytes());
    assert!(problem.contains("accessor 0") && problem.contains("memory"), "{problem}");
    for extension in ["KHR_draco_mesh_compression", "EXT_meshopt_compression"] {
        let mut json = triangle_json();
        json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        json["meshes"][0]["primitives"][0]["extensions"][extension] = json!({ "bufferView": 0 });
        let problem = fault(&json, &triangle_bytes());
        assert!(problem.contains(&format!("requires the glTF extension {extension}")), "{problem}");
    }
    let mut json = triangle_json();
    let fallback = json!({
        "byteLength": 9, "extensions": { "EXT_meshopt_compression": { "fallback": true } }
    });
    json["buffers"].as_array_mut().unwrap().push(fallback);
    let problem = fault(&json, &triangle_bytes());
    assert!(
        problem.contains("EXT_meshopt_compression") && problem.contains("gltfpack"),
        "{problem}"
    );
}

#[test]
fn unread_things_stay_in_the_file_that_is_written_back() {
    let bytes = changed(|json, _| {
        json["extensionsUsed"] = json!(["KHR_node_visibility"]);
        json["nodes"][0]["extensions"] = json!({ "KHR_node_visibility": { "visible": true } });
        json["materials"][0]["occlusionTexture"] = json!({ "index": 0 });
    });
    let folder = Folder::new();
    let path = folder.file("scene.glb", bytes);
    let (mut scene, _) = load_scene(&path).unwrap();
    scene.groups[0].material.rho_d = Rgb::splat(0.5);
    let written = unrender_formats::assign_materials(&path, &scene, &[]).unwrap();
    let length = u32::from_le_bytes(written[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&written[20..20 + length]).unwrap();
    assert!(json["materials"][0]["occlusionTexture"].is_object());
    let used = json["extensionsUsed"].as_array().unwrap();
    assert!(used.contains(&json!("KHR_node_visibility")), "{used:?}");
}

/// A second triangle, whose material lets `through` a share of the light.
fn with_a_pane(json: &mut Value, through: f64) {
    json["materials"].as_array_mut().unwrap().push(json!({
        "name": "pane",
        "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0 },
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": through, "transmissionTexture": { "index": 0 } },
            "KHR_materials_volume": { "thicknessFactor": 0.1 }
        }
    }));
    json["extensionsUsed"] = json!(["KHR_materials_transmission", "KHR_materials_volume"]);
    let mut pane = json["meshes"][0]["primitives"][0].clone();
    pane["material"] = json!(1);
    json["meshes"][0]["primitives"].as_array_mut().unwrap().push(pane);
}

#[test]
fn what_lets_light_through_is_glass_told_with_one_line() {
    let mut json = triangle_json();
    with_a_pane(&mut json, 0.9);
    let (scene, warnings) = load(&json, &triangle_bytes());
    assert_eq!(scene.ungrouped_materials(), ["pane"]);
    assert_eq!(scene.ungrouped[0].mesh.triangles.len(), 1);
    assert_eq!(scene.ungrouped[0].glass, Some(Glass::solid(1.5)));
    assert_eq!((scene.objects.len(), scene.groups.len()), (1, 1));
    assert_eq!(warnings.0.len(), 1, "{warnings:?}");
    assert!(warnings.0[0].contains("\"pane\" is glass"), "{warnings:?}");
    let mut json = triangle_json();
    with_a_pane(&mut json, 0.0);
    let (scene, warnings) = load(&json, &triangle_bytes());
    assert!(scene.ungrouped.is_empty() && scene.groups.len() == 2, "{warnings:?}");
}

#[test]
fn what_many_groups_lack_is_told_once() {
    let mut json = triangle_json();
    with_a_pane(&mut json, 0.0);
    for primitive in json["meshes"][0]["primitives"].as_array_mut().unwrap() {
        primitive["attributes"]["COLOR_0"] = json!(1);
    }
    let (_, warnings) = load(&json, &triangle_bytes());
    let told: Vec<_> = warnings.0.iter().filter(|told| told.contains("vertex colours")).collect();
    assert!(told.len() == 1 && told[0].contains("groups \"lamp\", \"pane\""), "{warnings:?}");
}
