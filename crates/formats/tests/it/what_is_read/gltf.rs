//! glTF: one more property or extension in a file that has one of every element.

use super::{assert_taken, rows};
use crate::gltf_unread::everything;
use crate::support::{Folder, glb, triangle_bytes};
use serde_json::{Value, json};
use unrender_formats::load_scene;
use unrender_formats::what_is_read::{Row, Taken};
use unrender_scene::Warnings;

fn read(json: &Value) -> Result<Warnings, String> {
    let folder = Folder::new();
    let read = load_scene(&folder.file("scene.glb", glb(json, &triangle_bytes())));
    read.map(|(_, warnings)| warnings).map_err(|error| error.to_string())
}

/// Where an element of each kind is in the file.
fn place(element: &str) -> &'static str {
    match element {
        "file" | "all" => "",
        "asset" => "/asset",
        "scenes" => "/scenes/0",
        "nodes" => "/nodes/0",
        "meshes" => "/meshes/0",
        "primitives" => "/meshes/0/primitives/0",
        "materials" => "/materials/0",
        "pbrMetallicRoughness" => "/materials/0/pbrMetallicRoughness",
        "textureInfo" => "/materials/0/pbrMetallicRoughness/baseColorTexture",
        "textures" => "/textures/0",
        "images" => "/images/0",
        "samplers" => "/samplers/0",
        "accessors" => "/accessors/0",
        "sparse" => "/accessors/0/sparse",
        "sparse indices and values" => "/accessors/0/sparse/indices",
        "bufferViews" => "/bufferViews/0",
        "buffers" => "/buffers/0",
        "cameras" => "/cameras/0",
        "perspective" => "/cameras/0/perspective",
        "light" => "/extensions/KHR_lights_punctual/lights/0",
        "spot" => "/extensions/KHR_lights_punctual/lights/0/spot",
        "profile" => "/extensions/EXT_lights_ies/lights/0",
        "KHR_materials_specular" => "/materials/0/extensions/KHR_materials_specular",
        "KHR_materials_anisotropy" => "/materials/0/extensions/KHR_materials_anisotropy",
        "KHR_materials_clearcoat" => "/materials/0/extensions/KHR_materials_clearcoat",
        "KHR_materials_transmission" => "/materials/0/extensions/KHR_materials_transmission",
        "KHR_materials_volume" => "/materials/0/extensions/KHR_materials_volume",
        other => panic!("no place of {other}"),
    }
}

/// The warnings of the file with `value` as the property, without those of the file itself.
fn with(row: &Row, value: Value) -> Result<Warnings, String> {
    let mut json = everything();
    let before = read(&json)?;
    let object = json.pointer_mut(place(row.within)).unwrap().as_object_mut().unwrap();
    object.insert(row.element.into(), value);
    let mut told = read(&json)?;
    told.0.retain(|warning| !before.0.contains(warning));
    Ok(told)
}

/// A test beside the table shows that properties that are read cause no warning: they have a field.
#[test]
fn properties_are_told_and_passed_over_as_their_rows_say() {
    for row in rows("glTF: properties") {
        let value = match row.element {
            "alphaCutoff" | "znear" => json!(0.1),
            "zfar" | "range" => json!(100.0),
            "targets" => json!([{ "POSITION": 0 }]),
            "skin" | "target" | "minFilter" => json!(0),
            "name" | "copyright" | "minVersion" | "mimeType" => json!("any"),
            "type" => json!("perspective"),
            _ => json!({ "index": 0 }),
        };
        match row.taken {
            // The file has its mean already.
            Taken::WarnedOf if row.element == "metallicRoughnessTexture" => {
                let told = read(&everything()).unwrap();
                assert_taken(&row, row.element, Ok(told));
            }
            Taken::WarnedOf | Taken::PassedOver => assert_taken(&row, "", with(&row, value)),
            _ => {}
        }
    }
}

#[test]
fn extensions_are_taken_as_their_rows_say() {
    for row in rows("glTF: extensions that a file uses") {
        let mut json = everything();
        let before = read(&json).unwrap();
        let name = if row.element == "others" { "VENDOR_thing" } else { row.element };
        json["extensionsUsed"] = json!([name]);
        let told = read(&json).map(|mut told| {
            told.0.retain(|warning| !before.0.contains(warning));
            told
        });
        assert_taken(&row, name, told);
    }
    for row in rows("glTF: extensions that a file requires") {
        let mut json = everything();
        let name = if row.element == "others" { "VENDOR_thing" } else { row.element };
        json["extensionsRequired"] = json!([name]);
        let told = read(&json);
        assert!(told.as_ref().is_err_and(|error| error.contains(row.done)), "{name}: {told:?}");
        assert_taken(&row, name, told);
    }
}

#[test]
fn attributes_are_taken_as_their_rows_say() {
    // Tangents have four numbers, which no accessor of the file has; other tests read some.
    let rows = rows("glTF: attributes of vertices");
    for row in rows.iter().filter(|row| row.element != "TANGENT") {
        let name = match row.element {
            "_" => "_MINE".to_owned(),
            "TEXCOORD_n" => "TEXCOORD_1".to_owned(),
            name => name.replace('n', "0"),
        };
        let mut json = everything();
        let before = read(&json).unwrap();
        let attributes = &mut json["meshes"][0]["primitives"][0]["attributes"];
        if attributes.get(&name).is_none() {
            attributes[&name] = json!(0);
        }
        let mut told = read(&json);
        if let Ok(told) = &mut told {
            told.0.retain(|warning| !before.0.contains(warning));
        }
        assert_taken(row, &name, told);
    }
}
