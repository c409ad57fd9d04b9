//! Faulty files: each is refused with an error that names the file, the fault and the remedy.

use crate::support::{Folder, Numbers, changed, damaged, glb, triangle_bytes, triangle_json};
use serde_json::json;
use unrender_formats::{assign_materials, load_scene};

/// Asserts that the file `name` of `bytes` is refused and that the error says all of `words`.
#[track_caller]
fn refused(name: &str, bytes: impl AsRef<[u8]>, words: &[&str]) {
    let folder = Folder::new();
    let path = folder.file(name, bytes);
    let message = load_scene(&path).expect_err("is read without an error").to_string();
    assert!(message.contains(name), "\"{message}\" does not name {name}");
    for word in words {
        assert!(message.contains(word), "\"{message}\" does not say \"{word}\"");
    }
}

#[test]
fn files_that_are_no_scenes() {
    refused("a.glb", "", &["is empty"]);
    refused("a.gltf", "", &["is empty"]);
    refused("a.glb", "Dear reader, this is a letter.", &["is not glTF"]);
    refused("a.gltf", "{ \"asset\": ", &["not valid glTF", "line 1"]);
    refused("a.gltf", "{}", &["not valid glTF", "asset"]);
    refused("a.gltf", "{\"asset\":{\"version\":\"1.0\"}}", &["glTF 1.0", "2.0"]);
    refused("a.gltf", "{\"asset\":{\"version\":\"2.0\"}}", &["no triangles"]);
    refused("a.glb", b"glTF\x01\0\0\0\x14\0\0\0", &["version 1"]);
    refused("a.blend", "BLENDER", &[".glb", ".gltf", ".obj"]);
    refused("a.obj", [0xFF, 0xFE, 0x00], &["is not an OBJ"]);
    refused("a.obj", "", &["no triangles"]);
    let missing = load_scene("nowhere/a.glb").unwrap_err().to_string();
    assert_eq!(missing, "nowhere/a.glb: does not exist");
    assert!(assign_materials("nowhere/a.glb", &unrender_scene::Scene::default(), &[]).is_err());
}

#[test]
fn files_cut_short() {
    let whole = changed(|_, _| ());
    for length in [1, 4, 8, 11, 12, 19, 20, 40, whole.len() / 2, whole.len() - 1] {
        let words: &[&str] = if length < 4 { &["is not glTF"] } else { &["cut short"] };
        refused("short.glb", &whole[..length], words);
    }
}

#[test]
fn extensions_that_must_be_understood() {
    let name = "KHR_draco_mesh_compression";
    let bytes = changed(|json, _| json["extensionsRequired"] = json!([name]));
    refused("a.glb", bytes, &[name, "export the scene without it"]);
}

#[test]
fn broken_geometry() {
    let with_index_9 = changed(|_, bin| bin[74] = 9);
    refused("a.glb", with_index_9, &["tri", "vertex 9", "only 3"]);
    let with_nan = changed(|_, bin| bin[4..8].copy_from_slice(&f32::NAN.to_le_bytes()));
    refused("a.glb", with_nan, &["tri", "POSITION", "vertex 0", "finite"]);
    let with_infinity = changed(|_, bin| bin[40..44].copy_from_slice(&f32::INFINITY.to_le_bytes()));
    refused("a.glb", with_infinity, &["tri", "NORMAL", "finite"]);
    let dark = changed(|json, _| json["materials"][0]["emissiveFactor"] = json!([0, 0, 0]));
    refused("a.glb", dark, &["no light", "KHR_lights_punctual"]);
    let points = changed(|json, _| json["meshes"][0]["primitives"][0]["mode"] = json!(0));
    refused("a.glb", points, &["no triangles"]);
    let few_normals = changed(|json, _| json["accessors"][1]["count"] = json!(2));
    refused("a.glb", few_normals, &["3 POSITION", "2 NORMAL"]);
}

#[test]
fn broken_references() {
    let set = |pointer: &'static str, value: serde_json::Value| {
        changed(|json, _| {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            json.pointer_mut(parent).unwrap()[key.parse::<usize>().map_or(key, |_| key)] = value;
        })
    };
    refused("a.glb", set("/nodes/0/mesh", json!(7)), &["mesh 7", "only 1"]);
    refused("a.glb", set("/nodes/0/camera", json!(0)), &["camera 0", "only 0"]);
    refused("a.glb", set("/scene", json!(3)), &["scene 3"]);
    refused("a.glb", set("/scenes/0/nodes", json!([5])), &["node 5"]);
    let material = "/meshes/0/primitives/0/material";
    refused("a.glb", set(material, json!(1)), &["material 1", "only 1"]);
    let position = "/meshes/0/primitives/0/attributes/POSITION";
    refused("a.glb", set(position, json!(11)), &["accessor 11"]);
    refused("a.glb", set("/accessors/0/bufferView", json!(11)), &["bufferView 11"]);
    refused("a.glb", set("/bufferViews/0/buffer", json!(11)), &["buffer 11"]);
    let texture = "/materials/0/pbrMetallicRoughness/baseColorTexture";
    refused("a.glb", set(texture, json!({ "index": 4 })), &["texture 4"]);
    let light = json!({ "KHR_lights_punctual": { "light": 2 } });
    refused("a.glb", set("/nodes/0/extensions", light), &["light 2"]);
}

#[test]
fn numbers_beyond_their_buffers() {
    let set = |list: &'static str, key: &'static str, value: serde_json::Value| {
        changed(|json, _| json[list][0][key] = value)
    };
    refused("a.glb", set("accessors", "count", json!(4)), &["accessor 0", "4 elements"]);
    let huge = json!(u64::MAX / 16);
    refused("a.glb", set("accessors", "count", huge.clone()), &["accessor 0", "beyond"]);
    refused("a.glb", set("accessors", "byteOffset", huge.clone()), &["accessor 0", "beyond"]);
    refused("a.glb", set("accessors", "count", json!(-1)), &["not valid glTF"]);
    refused("a.glb", set("accessors", "type", json!("VEC2")), &["VEC2", "VEC3"]);
    refused("a.glb", set("accessors", "componentType", json!(1)), &["component type 1"]);
    refused("a.glb", set("bufferViews", "byteLength", huge.clone()), &["bufferView 0", "beyond"]);
    refused("a.glb", set("bufferViews", "byteOffset", json!(u64::MAX)), &["bufferView 0"]);
    refused("a.glb", set("bufferViews", "byteStride", json!(0)), &["byteStride"]);
    refused("a.glb", set("buffers", "byteLength", huge), &["buffer 0", "cut short"]);
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": 2, "componentType": 5123, "byteOffset": 4 },
        "values": { "bufferView": 1 },
    });
    let mut other = sparse.clone();
    refused("a.glb", set("accessors", "sparse", json!({ "count": 1 })), &["not valid glTF"]);
    other["count"] = json!(1_000_000_000_000u64);
    refused("a.glb", set("accessors", "sparse", other), &["accessor 0", "beyond"]);
    let far = changed(|json, bin| {
        json["accessors"][0]["sparse"] = sparse;
        bin[76] = 200;
    });
    refused("a.glb", far, &["element 200"]);
}

#[test]
fn node_graphs_that_are_no_trees() {
    let with_nodes = |nodes: serde_json::Value| changed(|json, _| json["nodes"] = nodes);
    refused("a.glb", with_nodes(json!([{ "children": [0] }])), &["node 0", "descendant"]);
    let ring = json!([{ "children": [1] }, { "children": [2] }, { "children": [0] }]);
    refused("a.glb", with_nodes(ring.clone()), &["reached twice"]);
    let two_parents = json!([{ "children": [1, 2] }, { "children": [2] }, {}]);
    refused("a.glb", with_nodes(two_parents), &["node 2"]);
    let without_scene = changed(|json, _| {
        json["nodes"] = ring;
        json.as_object_mut().unwrap().remove("scene");
        json.as_object_mut().unwrap().remove("scenes");
    });
    refused("a.glb", without_scene, &["child of another"]);
    refused("a.glb", with_nodes(json!([{ "rotation": [0, 0, 0, 0] }])), &["rotation"]);
}

#[test]
fn files_that_are_missing() {
    let with_uri = |uri: &str| {
        let mut json = triangle_json();
        json["buffers"][0]["uri"] = json!(uri);
        json.to_string()
    };
    refused("a.gltf", with_uri("no%20such.bin"), &["is missing", "\n  no such.bin"]);
    refused("a.gltf", with_uri("data:application/octet-stream;base64,AA"), &["base64"]);
    refused("a.gltf", with_uri("data:application/octet-stream;base64,AAAA"), &["cut short"]);
    refused("a.gltf", with_uri("https://example.com/a.bin"), &["https", "copy it there"]);
    refused("a.gltf", triangle_json().to_string(), &["buffer 0 has no data"]);
    let image = changed(|json, _| {
        json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
        json["textures"] = json!([{ "source": 0 }]);
        json["images"] = json!([{ "uri": "gone.png" }]);
    });
    refused("a.glb", image, &["gone.png", "is missing"]);
    let no_image = changed(|json, _| {
        json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
        json["textures"] = json!([{ "source": 0 }]);
        json["images"] = json!([{ "bufferView": 0 }]);
    });
    refused("a.glb", no_image, &["image 0", "PNG"]);
}

#[test]
fn lights_cameras_and_materials_with_impossible_numbers() {
    let with_light = |light: serde_json::Value| {
        changed(|json, _| {
            json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
            json["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
        })
    };
    refused("a.glb", with_light(json!({ "type": "laser" })), &["laser"]);
    refused("a.glb", with_light(json!({ "type": "point", "intensity": -1 })), &["intensity"]);
    refused("a.glb", with_light(json!({ "type": "point", "intensity": 1e300 })), &["intensity"]);
    let wide = json!({ "type": "spot", "spot": { "outerConeAngle": 2 } });
    refused("a.glb", with_light(wide), &["outerConeAngle"]);
    let flat = changed(|json, _| {
        json["nodes"][0]["camera"] = json!(0);
        json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 0 } }]);
    });
    refused("a.glb", flat, &["tri", "yfov"]);
    let dark = changed(|json, _| json["materials"][0]["emissiveFactor"] = json!([-1, 0, 0]));
    refused("a.glb", dark, &["lamp", "emission"]);
    let extras = |extras: serde_json::Value| {
        changed(|json, _| json["materials"][0]["extras"] = json!({ "unrender": extras }))
    };
    refused("a.glb", extras(json!(3)), &["lamp", "extras.unrender"]);
    let strange = json!({ "brdf": "phong", "rho_d": [0, 0, 0], "rho_s": [0, 0, 0],
        "alpha_x": 0, "alpha_y": 0, "theta_deg": 0 });
    refused("a.glb", extras(strange), &["lamp", "phong", "ward-gmd"]);
}

#[test]
fn faulty_obj_files() {
    refused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", &["line 4", "out of range"]);
    refused("a.obj", "v 0 zero 0\n", &["not a valid OBJ"]);
    refused("a.obj", "mtllib gone.mtl\nv 0 0 0\n", &["gone.mtl", "is missing"]);
    refused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", &["finite"]);
    refused("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &["no light"]);
    let folder = Folder::new();
    folder.file("a.mtl", "newmtl m\nKd 1 2\n");
    let path = folder.file("a.obj", "mtllib a.mtl\n");
    let message = load_scene(&path).unwrap_err().to_string();
    assert!(message.contains("Kd 1 2"), "{message}");
}

#[test]
fn damaged_files_never_panic() {
    let json = {
        let mut json = triangle_json();
        json["nodes"][0]["camera"] = json!(0);
        json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1 } }]);
        json
    };
    let glb = glb(&json, &triangle_bytes());
    let obj = "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0 1\nvt 0 0\nvn 0 0 1\nusemtl m\nf 1/1/1 2/1/1 \\\n-1/-1/-1\n\
         g b\nf 1/1 2//1 3\nf 1 2 3 1 3 2\nl 1 2\ns 1\nusemtl x #2\nf 1 2 3\n";
    let obj = &format!("mtllib a.mtl\n{obj}");
    let mtl = "newmtl m\nKd 1 0.5 0\nKe 1\nKs 0 0.1 0.2\nNs 20\nillum 2\nd 1\nNi 1.5\nTr 0.5\nx\n\
         map_Kd -s 1 1 x.png\nnewmtl n\nmap_Ke x\n";
    let mut numbers = Numbers(7);
    let folder = Folder::new();
    for _ in 0..3000 {
        let path = folder.file("a.glb", damaged(&glb, &mut numbers));
        if let Ok((scene, _)) = load_scene(&path) {
            // A file that can be read can be given materials.
            assign_materials(&path, &scene, &[]).unwrap();
        }
        folder.file("a.mtl", damaged(mtl.as_bytes(), &mut numbers));
        let _ = load_scene(&folder.file("a.obj", obj));
        let _ = load_scene(&folder.file("b.obj", damaged(obj.as_bytes(), &mut numbers)));
    }
}
