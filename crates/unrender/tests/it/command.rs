//! Exit codes and messages of the `unrender` command.

use crate::kit::floor_and_lamp;
use crate::kit::folder::{Folder, command, ends_in_error, fails, succeeds};
use serde_json::json;
use std::ffi::OsStr;
use std::path::Path;
use std::process::Output;
use unrender::formats::picture;
use unrender::scene::{Image, Rgb};

/// Runs the command with `arguments`, which are words and whole paths.
fn unrender(arguments: &[&dyn AsRef<OsStr>]) -> Output {
    command(arguments).output().unwrap()
}

fn recover(project: &Path, out: &Path) -> Output {
    unrender(&[&"recover", &project, &"--out", &out, &"--quiet"])
}

const PROJECT: &str = "scene = \"s.glb\"\nphoto = \"p.png\"\nexposure = 1\nresponse = \"srgb\"\n";

#[test]
fn missing_files_are_named() {
    let folder = Folder::new();
    fails(&recover(&folder.path("no.toml"), &folder.path("out")), "no.toml: cannot be read");
    let project = folder.write("a.toml", PROJECT);
    fails(&recover(&project, &folder.path("out")), "scene: there is no file");
    assert!(!folder.path("out").exists());
    let out = folder.path("a.exr");
    let scene = folder.path("no.glb");
    fails(&unrender(&[&"render", &scene, &"--out", &out]), "no.glb");
    fails(&unrender(&[&"score", &folder.root(), &"truth.json"]), "materials.json");
}

/// A room of Mitsuba whose second mesh is not there.
#[test]
fn a_scene_is_rendered_at_its_own_size_and_without_what_is_missing() {
    let folder = Folder::new();
    folder.write("there.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let shape = |file: &str, bsdf: &str| {
        format!(
            "<shape type=\"obj\"><string name=\"filename\" value=\"{file}\"/><bsdf id=\"{bsdf}\" type=\"{bsdf}\"/></shape>"
        )
    };
    let text = format!(
        "<scene version=\"3.0.0\"><sensor type=\"perspective\"><film type=\"hdrfilm\">
         <integer name=\"width\" value=\"24\"/><integer name=\"height\" value=\"16\"/></film>
         <transform name=\"to_world\"><lookat origin=\"0 0 5\" target=\"0 0 0\" up=\"0 1 0\"/></transform></sensor>
         <emitter type=\"constant\"/>{}{}{}</scene>",
        shape("there.obj", "diffuse"),
        shape("there.obj", "dielectric"),
        shape("gone.obj", "diffuse").replace("bsdf id=\"diffuse\"", "bsdf id=\"other\""),
    );
    let scene = folder.write("scene.xml", &text);
    let out = folder.path("a.exr");
    let render = |more: &[&str]| {
        let words: [&dyn AsRef<OsStr>; 7] =
            [&"render", &scene, &"--out", &out, &"--spp", &"1", &"--quiet"];
        command(&words).args(more).output().unwrap()
    };
    fails(&render(&[]), "gone.obj");
    let output = render(&["--allow-missing"]);
    succeeds(&output);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(told.contains("\"gone.obj\" is missing"), "{told}");
    assert_eq!(told.matches("\"dielectric\" is glass").count(), 1, "{told}");
    let (read, _) = picture::read(&out).unwrap();
    assert_eq!((read.values.width(), read.values.height()), (24, 16));
}

#[test]
fn what_is_no_project_is_named_as_what_it_is() {
    let folder = Folder::new();
    let photo = folder.path("photo.exr");
    picture::write(&photo, &Image::from_fn(8, 8, |_, _| Rgb::ONE)).unwrap();
    std::fs::copy(&photo, folder.path("photo")).unwrap();
    folder.write("raw.heic", b"\0\0\0\x18ftypheic\0\0\0\0");
    for scene in ["room.glb", "room.obj", "room.XML"] {
        folder.write(scene, "");
    }
    let out = folder.path("out");
    for (name, what) in [
        ("photo.exr", "a picture"),
        ("photo", "a picture"),
        ("raw.heic", "a picture"),
        ("room.glb", "a scene"),
        ("room.obj", "a scene"),
        ("room.XML", "a scene"),
        ("", "a folder"),
    ] {
        let path = folder.root().join(name);
        let told = format!("is {what}; expected a project file");
        fails(&recover(&path, &out), &told);
        fails(&unrender(&[&"check", &path, &"--out", &folder.path("c.png")]), &told);
        let told = format!("is {what}; expected an edit file");
        fails(&unrender(&[&"restage", &path, &"--out", &out]), &told);
        assert!(!out.exists() && !folder.path("c.png").exists());
    }
    folder.write("room.toml", PROJECT);
    fails(&recover(folder.root(), &out), "did you mean ");
}

#[test]
fn a_photograph_of_what_gets_no_light_is_refused_before_any_work() {
    let folder = floor_and_lamp::project();
    let seen_from = |eye: &str, target: &str| {
        let camera = format!("camera = {{ eye = {eye}, target = {target}, fov_y_deg = 40 }}\n");
        let project = folder.write("dark.toml", &(folder.text("p.toml") + &camera));
        let out = folder.path("dark");
        let output = recover(&project, &out);
        assert!(output.status.success() || !out.exists());
        output
    };
    // From below, where the lamp does not shine; along the floor's lower side, as where another axis is up.
    for (eye, target) in [("[0, -1, 1]", "[0, 0, 0]"), ("[0.2, -2, 0.1]", "[0, 0, 0]")] {
        ends_in_error(
            &seen_from(eye, target),
            "no light of the scene reaches what the camera sees (\"floor\")",
        );
    }
    succeeds(&seen_from("[0, 1.4, 2]", "[0, 0, 0]"));
}

#[test]
fn the_scene_of_a_result_has_the_camera_that_the_project_describes() {
    let folder = floor_and_lamp::project();
    let described = "[camera]\neye = [0, 1.4, 2]\ntarget = [0, 0, 0]\nfov_y_deg = 45\n";
    folder.write("p.toml", &(folder.text("p.toml") + described));
    let recover = ["recover", "p.toml", "--effort", "draft", "--quiet", "--out", "result"];
    succeeds(&folder.run(&recover));
    let (scene, _) = unrender::formats::load_scene(&folder.path("result/scene.glb")).unwrap();
    let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["camera", "photograph"]);
    let [named, described] = &scene.cameras[..] else { panic!("{names:?}") };
    assert!(described.origin().distance(named.origin()) < 1e-4);
    assert!((described.fov_y_rad.to_degrees() - 45.0).abs() < 1e-3);
}

#[test]
fn materials_are_a_file_or_the_folder_of_a_result() {
    let folder = floor_and_lamp::project();
    succeeds(
        &folder.run(&["recover", "p.toml", "--effort", "draft", "--quiet", "--out", "result"]),
    );
    let render = |materials: &str, out: &str| {
        let arguments = ["render", "scene.glb", "--height", "12", "--spp", "2", "--quiet"];
        let output =
            folder.run(&[&arguments[..], &["--materials", materials, "--out", out]].concat());
        succeeds(&output);
        folder.bytes(out)
    };
    let by_folder = render("result", "folder.exr");
    assert_eq!(by_folder, render("result/materials.json", "file.exr"));
    succeeds(&folder.run(&["score", "result", "result/materials.json"]));
    let edited =
        ["restage", "--scene", "scene.glb", "--materials", "result", "--spp", "1", "--quiet"];
    succeeds(&folder.run(&[&edited[..], &["--height", "8", "--out", "edited"]].concat()));
    let export =
        ["export", "--scene", "scene.glb", "--materials", "result", "--to", "gltf", "--quiet"];
    succeeds(&folder.run(&[&export[..], &["--out", "exported.glb"]].concat()));
    // Files of two runs are no result.
    folder.write("result/materials.json", "{\"groups\": {}}");
    let output = folder.run(&["render", "scene.glb", "--materials", "result", "--out", "no.png"]);
    fails(&output, "changed since they were written");
    let output = folder.run(&["render", "scene.glb", "--materials", "nowhere", "--out", "no.png"]);
    fails(&output, "nowhere: cannot be read");
}

#[test]
fn a_truncated_photo_is_named() {
    let folder = Folder::new();
    folder.write("s.glb", "");
    let photo = folder.path("p.png");
    picture::write(&photo, &Image::from_fn(64, 64, |x, y| Rgb::splat((x * y) as f32 / 4096.0)))
        .unwrap();
    let bytes = folder.bytes("p.png");
    folder.write("p.png", &bytes[..bytes.len() / 2]);
    let project = folder.write("a.toml", PROJECT);
    fails(&recover(&project, &folder.path("out")), "p.png: is cut short or corrupt");
}

#[test]
fn an_output_that_cannot_be_written_is_told_before_any_work() {
    let folder = Folder::new();
    folder.write("s.glb", "");
    let photo = folder.write("p.png", "not even a picture");
    let project = folder.write("a.toml", PROJECT);
    fails(&recover(&project, &photo.join("out")), "results cannot be written there");
    let scene = folder.path("s.glb");
    let render = |out: &Path| unrender(&[&"render", &scene, &"--out", &out]);
    fails(&render(&folder.path("no/a.exr")), "cannot be written");
    fails(&render(&folder.path("a.bmp")), ".exr, .hdr or .png");
}

#[test]
fn faults_in_the_project_have_a_line() {
    let folder = Folder::new();
    let project = folder.write("a.toml", &format!("{PROJECT}colour = 1\n"));
    fails(&recover(&project, &folder.path("out")), "a.toml: line 5: unknown field `colour`");
}

/// The smallest glTF scene: one glowing triangle called "lamp" and a camera.
const TRIANGLE: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 3]}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
    "materials": [{"name": "lamp", "emissiveFactor": [1, 1, 1]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri": "triangle.bin"}]}"#;

/// A folder with that scene and a white photograph.
fn triangle() -> Folder {
    let folder = Folder::new();
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    folder.write("triangle.bin", &bytes);
    folder.write("s.gltf", TRIANGLE);
    picture::write(&folder.path("p.png"), &Image::from_fn(8, 8, |_, _| Rgb::ONE)).unwrap();
    folder
}

#[test]
fn responses_and_lenses_must_make_sense() {
    let folder = triangle();
    let files = "scene = \"s.gltf\"\nphoto = \"p.png\"\nexposure = 1\n";
    let recovered = |settings: &str| {
        recover(&folder.write("a.toml", &format!("{files}{settings}\n")), &folder.path("out"))
    };
    let curve = "response = \"curve.csv\"";
    fails(&recovered(curve), "response: there is no file");
    folder.write("curve.csv", "code,linear\n0,0\n0.6,0.5\n0.5,1\n");
    fails(&recovered(curve), "curve.csv: is not monotone: code is 0.6 in row 2 and 0.5");
    folder.write("curve.csv", "code,linear\n0,0\n");
    fails(&recovered(curve), "curve.csv: has 1 row(s)");
    let dark = "vignetting = { radial = [-1.5] }";
    fails(&recovered(dark), "a.toml: vignetting: a pixel of the photo would get");
    assert!(!folder.path("out/materials.json").exists());
}

#[test]
fn unknown_groups_are_named() {
    let folder = triangle();
    let text = PROJECT.replace("s.glb", "s.gltf") + "[groups.lam]\nknown = { rho_d = 1 }\n";
    let output = recover(&folder.write("a.toml", &text), &folder.path("out"));
    fails(&output, "groups.lam: the scene has no group \"lam\"; it has lamp");
}

#[test]
fn panoramas_that_cannot_be_used_are_named() {
    let folder = Folder::new();
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    folder.write("triangle.bin", &bytes);
    let (scene, out) = (folder.write("s.gltf", TRIANGLE), folder.path("a.exr"));
    let render = |panorama: &Path, scale: &str| {
        let scale = format!("--environment-scale={scale}");
        let size = "--height=4";
        unrender(&[&"render", &scene, &size, &"--environment", &panorama, &scale, &"--out", &out])
    };
    fails(&render(&folder.path("no.hdr"), "1"), "no.hdr: cannot be read");
    let text = folder.write("text.hdr", "no picture");
    fails(&render(&text, "1"), "text.hdr: is not a PNG, JPEG, BMP, TIFF, EXR or HDR file");
    let sky = folder.path("sky.exr");
    picture::write(&sky, &Image::from_fn(4, 2, |_, _| Rgb::splat(9.0))).unwrap();
    fails(&render(&sky, "1e38"), "sky.exr: pixel 0 of the panorama is negative or not");
    assert!(!out.exists());
    let lit = render(&sky, "0.5");
    assert!(lit.status.success() && lit.stderr.is_empty());
    // Its upper left corner shows the sky, which is half as bright as in the file.
    assert_eq!(*picture::read(&out).unwrap().0.values.at(0, 0), Rgb::splat(4.5));
}

#[test]
fn usage_errors_have_exit_code_two() {
    for arguments in [
        &["render"][..],
        &["polish"],
        &["recover", "a.toml", "--out", "o", "--spp", "0"],
        &["render", "s.glb", "--out", "a.exr", "--samples", "3..3"],
        &["render", "s.glb", "--out", "a.exr", "--samples", "0..3", "--spp", "3"],
        &["render", "s.glb", "--out", "a.exr", "--noise", "0"],
        &["render", "s.glb", "--out", "a.exr", "--time", "-1"],
        &["render", "s.glb", "--out", "a.exr", "--environment-rotation", "90"],
        &["merge", "--out", "a.exr"],
    ] {
        assert_eq!(command(arguments).output().unwrap().status.code(), Some(2));
    }
    let help = unrender(&[&"render", &"--help"]);
    assert!(String::from_utf8_lossy(&help.stdout).contains("Examples:"));
}

#[test]
fn score_prints_columns_or_json_and_holds_limits() {
    let folder = Folder::new();
    let entry = |rho: f32| {
        format!(
            r#"{{"groups": {{"wall": {{"hypothesis": "diffuse", "status": "recovered",
                "rho_d": [0.5, 0.5, {rho}], "rho_s": [0, 0, 0]}}}}}}"#
        )
    };
    folder.write("materials.json", &entry(0.51));
    let truth = folder.write("truth.json", &entry(0.5));
    let plain = unrender(&[&"score", &folder.root(), &truth]);
    let text = String::from_utf8_lossy(&plain.stdout).into_owned();
    assert!(plain.status.success(), "{text}");
    assert_eq!(text.lines().count(), 3, "{text}");
    assert!(text.lines().all(|line| line.starts_with(['g', 'w'])) && text.contains("0.0100"));
    assert!(unrender(&[&"score", &folder.root(), &truth, &"--max-rho", &"0.02"]).status.success());
    let over = unrender(&[&"score", &folder.root(), &truth, &"--max-rho", &"0.005", &"--json"]);
    fails(&over, "wall: rho_d is 0.0100 off");
    let json: serde_json::Value = serde_json::from_slice(&over.stdout).unwrap();
    assert_eq!(json["worst"]["counted"], 1);
    assert_eq!((&json["certainty"], &json["lights"]), (&serde_json::Value::Null, &json!([])));
}

#[test]
fn score_prints_every_std_that_is_stated() {
    let folder = Folder::new();
    let wall = r#""wall": {"status": "recovered", "rho_d": [0.5, 0.5, 0.5],
        "std": {"rho_d": [0.1, 0.2, 0.4]}}"#;
    let lamp = r#""lamp": {"intensity": [9, 9, 9], "std": [1, 1, 1]}"#;
    let file = format!(r#"{{"groups": {{{wall}}}, "lights": {{{lamp}}}}}"#);
    folder.write("materials.json", &file);
    let truth = folder.write("truth.json", &file.replace("0.5, 0.5, 0.5", "0.7, 0.7, 0.7"));
    let plain = unrender(&[&"score", &folder.root(), &truth]);
    let text = String::from_utf8_lossy(&plain.stdout).into_owned();
    assert!(text.contains("\n\nlight  error %\nlamp      0.00\n\ngroup  parameter"), "{text}");
    assert!(text.ends_with("6 parameters: 83 % within 1 std, 100 % within 2 std, worst 2.0\n"));
    let output = unrender(&[&"score", &folder.root(), &truth, &"--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["groups"][0]["parameters"][0]["parameter"], "rho_d");
    assert_eq!(json["lights"][0]["parameters"][0]["in_std"], json!([0.0, 0.0, 0.0]));
    assert_eq!(json["certainty"]["parameters"], 6);
}
