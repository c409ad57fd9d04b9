//! Files that a scene names and that are not there: one error lists them all, or the rest is read.

use crate::support::{Folder, triangle_json};
use serde_json::json;
use std::path::Path;
use unrender_formats::{Input, Limits, load_model};
use unrender_scene::{Rgb, Scene, Warnings};

/// The error of the scene at `path`, and what is read of it without the files.
fn both(path: &Path) -> (String, Scene, Warnings) {
    let error = load_model(path).expect_err("files are missing").to_string();
    let limits = Limits { missing: true, ..Limits::default() };
    let (scene, warnings) = load_model(Input::new(path, limits)).unwrap();
    (error, scene, warnings)
}

fn lists(error: &str, files: &[&str]) {
    assert!(error.contains("--allow-missing"), "{error}");
    for file in files {
        assert!(error.contains(&format!("\n  {file}")), "{file}: {error}");
    }
    assert_eq!(error.lines().count(), files.len() + 1, "{error}");
}

fn tell(warnings: &Warnings, words: &[&str]) {
    for word in words {
        assert!(warnings.0.iter().any(|told| told.contains(word)), "{word}: {warnings:?}");
    }
}

#[test]
fn a_scene_of_mitsuba_lists_its_missing_files_and_is_read_without_them() {
    let folder = Folder::new();
    let bitmap = |file: &str| {
        format!(
            "<texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"{file}\"/></texture>"
        )
    };
    let shape = |kind: &str, file: &str| {
        format!(
            "<shape type=\"{kind}\"><string name=\"filename\" value=\"{file}\"/><ref id=\"wall\"/></shape>"
        )
    };
    let text = format!(
        "<scene version=\"3.0.0\">\n<bsdf type=\"diffuse\" id=\"wall\">{}</bsdf>\n{}{}{}
         <shape type=\"cube\"><ref id=\"wall\"/></shape>
         <emitter type=\"envmap\"><string name=\"filename\" value=\"sky.hdr\"/></emitter></scene>",
        bitmap("textures/gone.png"),
        shape("obj", "a.obj"),
        shape("serialized", "b.serialized"),
        shape("ply", "a.obj"),
    );
    let (error, scene, warnings) = both(&folder.file("scene.xml", text));
    lists(&error, &["a.obj", "b.serialized", "sky.hdr", "textures/gone.png"]);
    assert_eq!(scene.objects.len(), 1);
    assert_eq!(scene.groups[0].material.rho_d, Rgb::splat(0.5));
    assert!(scene.environment.is_none());
    tell(
        &warnings,
        &["\"textures/gone.png\" is missing", "\"a.obj\" is missing", "\"sky.hdr\" is missing"],
    );
}

#[test]
fn a_gltf_file_lists_its_missing_buffers_and_pictures() {
    let folder = Folder::new();
    let mut json = triangle_json();
    json["buffers"] = json!([{ "byteLength": 78, "uri": "gone.bin" }]);
    json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    json["textures"] = json!([{ "source": 0 }]);
    json["images"] = json!([{ "uri": "gone.png" }]);
    let path = folder.file("scene.gltf", json.to_string());
    let error = load_model(&path).unwrap_err().to_string();
    // The picture of a material that no mesh has is not looked for.
    lists(&error, &["gone.bin"]);
    folder.file("gone.bin", crate::support::triangle_bytes());
    let (error, scene, warnings) = both(&path);
    lists(&error, &["gone.png"]);
    let texture = scene.groups[0].material.texture.as_ref().unwrap();
    let expected = 0.5 * Rgb::new(0.25, 0.5, 0.75);
    assert!((*texture.image.at(0, 0) - expected).abs().max_element() < 1e-6);
    tell(&warnings, &["material \"lamp\": its texture is missing"]);
}

#[test]
fn an_obj_lists_its_missing_materials_and_pictures() {
    let folder = Folder::new();
    folder.file("a.mtl", "newmtl wall\nKd 1 1 1\nmap_Kd gone.png\n");
    let square =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl wall\nf 1/1 2/1 3/1\nusemtl floor\nf 1 2 3\n";
    let path = folder.file("scene.obj", format!("mtllib a.mtl\nmtllib gone.mtl\n{square}"));
    let (error, scene, warnings) = both(&path);
    lists(&error, &["gone.mtl", "gone.png"]);
    assert_eq!(scene.groups[0].material.rho_d, Rgb::splat(0.5));
    tell(
        &warnings,
        &["its map_Kd \"gone.png\" is missing", "material file \"gone.mtl\" is missing"],
    );
}
