//! `unrender init`, `recover` without a project file, and the picture that grows while it works.

use crate::kit::floor_and_lamp;
use crate::kit::folder::{Folder, fails, is_refused, stderr, succeeds};
use glam::Vec3;
use std::time::{Duration, Instant};
use unrender::Project;
use unrender::formats::{gltf, picture};
use unrender::lighting::EnvironmentChoice;
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Environment, RgbImage, Scene};

/// A folder with a scene, its photograph as PNG and EXR, and no project.
fn files(scene: &Scene, seen: &Scene, scale: f32) -> Folder {
    let folder = Folder::new();
    folder.write("room.glb", &gltf::to_glb(scene).unwrap());
    let settings = Settings { spp: 64, ..Settings::default() };
    let camera = &seen.cameras[0];
    let film = Tracer::new(seen).render(&seen.materials(), camera, (48, 36), &settings, &|_| ());
    let photo: RgbImage = film.mean.map(|radiance| *radiance * scale);
    picture::write_png_srgb(&folder.path("photo.png"), &photo).unwrap();
    picture::write(&folder.path("photo.exr"), &photo).unwrap();
    folder
}

fn room() -> Scene {
    floor_and_lamp::scene()
}

#[test]
fn a_project_is_made_of_two_files_and_recovers() {
    let folder = files(&room(), &room(), 1.0);
    let said = succeeds(&folder.run(&["init", "room.glb", "photo.exr"]));
    assert!(
        said.contains("project.toml is written") && said.contains("unrender check project.toml")
    );
    let (project, warnings) = Project::read(&folder.path("project.toml")).unwrap();
    assert!(warnings.0.is_empty(), "{warnings:?}");
    assert_eq!(project.scene.file_name().unwrap(), "room.glb");
    let text = folder.text("project.toml");
    assert!(text.contains("response = \"linear\"") && text.contains("exposure = 1.0"), "{text}");
    succeeds(&folder.run(&["recover", "project.toml", "--out", "out", "--effort", "draft"]));
    // No file is replaced.
    fails(&folder.run(&["init", "room.glb", "photo.exr"]), "project.toml: is there already");
    assert_eq!(folder.text("project.toml"), text);
}

#[test]
fn paths_lead_from_the_project_to_the_files() {
    let folder = files(&room(), &room(), 1.0);
    std::fs::create_dir_all(folder.path("a/b")).unwrap();
    succeeds(&folder.run(&["init", "room.glb", "photo.png", "--out", "a/b/p.toml"]));
    let text = folder.text("a/b/p.toml");
    assert!(text.contains("scene = \"../../room.glb\""), "{text}");
    Project::read(&folder.path("a/b/p.toml")).unwrap();
}

#[test]
fn what_the_files_do_not_say_is_a_guess_that_is_told() {
    let says = |folder: &Folder, photo: &str, what: &[&str]| {
        let said = succeeds(&folder.run(&["init", "room.glb", photo, "--out", "guess.toml"]));
        what.iter().for_each(|what| assert!(said.contains(what), "{what}: {said}"));
        let read = Project::read(&folder.path("guess.toml"));
        let text = folder.text("guess.toml");
        std::fs::remove_file(folder.path("guess.toml")).unwrap();
        (read, text)
    };
    // The response of a picture of 8 bits, and its exposure.
    let (read, _) = says(&files(&room(), &room(), 1.0), "photo.png", &["the response is \"srgb\""]);
    assert!(read.is_ok());
    let (read, text) = says(
        &files(&room(), &room(), 0.02),
        "photo.exr",
        &["the exposure is unknown", "which fixes how bright everything is"],
    );
    assert!(read.is_ok() && text.contains("exposure = \"auto\"") && text.contains("[anchor]"));
    // One of several cameras.
    let mut scene = room();
    let other = Camera { name: "tall".into(), aspect: Some(0.5), ..scene.cameras[0].clone() };
    scene.cameras[0].aspect = Some(4.0 / 3.0);
    scene.cameras.insert(0, other);
    let (read, text) =
        says(&files(&scene, &room(), 1.0), "photo.exr", &["of 2: it has the photo's aspect"]);
    assert!(read.is_ok() && !text.contains("camera = \"tall\""), "{text}");
    // No camera: the project cannot be used yet, and says so.
    let mut scene = room();
    scene.cameras.clear();
    let (read, text) =
        says(&files(&scene, &room(), 1.0), "photo.exr", &["no camera", "unrender calibrate"]);
    assert!(read.is_ok() && text.contains("fov_y_deg"), "{text}");
    // No light.
    let mut dark = room();
    dark.groups.iter_mut().for_each(|group| group.emission *= 0.0);
    let mut lit = dark.clone();
    let sky = RgbImage::new(1, 1, vec![unrender::scene::Rgb::ONE]);
    lit.environment = Some(Environment::new(sky, 0.0).unwrap());
    let (read, text) = says(&files(&dark, &lit, 1.0), "photo.exr", &["the scene has no light"]);
    assert!(read.is_ok() && text.contains("[environment]\nunknown = true"), "{text}");
}

#[test]
fn lines_that_mend_what_looks_wrong_are_offered() {
    // An open floor under a sky that the scene does not have, seen past its edge.
    let mut lit = room();
    lit.cameras[0] =
        Camera::look_at("camera", Vec3::new(0.0, 0.6, 2.0), 0.6 * Vec3::Y, Vec3::Y, 0.8);
    let mut scene = lit.clone();
    let sky = RgbImage::new(1, 1, vec![unrender::scene::Rgb::ONE]);
    lit.environment = Some(Environment::new(sky, 0.0).unwrap());
    scene.environment = None;
    let folder = files(&scene, &lit, 1.0);
    let said = succeeds(&folder.run(&["init", "room.glb", "photo.exr"]));
    assert!(said.contains("Looks wrong:\n") && said.contains("the scene has no sky"), "{said}");
    let text = folder.text("project.toml");
    let offered = "\n# [environment]\n# unknown = true\n";
    assert!(text.contains(offered), "{text}");
    // Uncommented, it is a project.
    folder.write("sky.toml", &text.replace(offered, &offered.replace("# ", "")));
    let (project, _) = Project::read(&folder.path("sky.toml")).unwrap();
    assert!(matches!(project.environment, Some(EnvironmentChoice::Unknown { .. })), "{text}");
}

#[test]
fn files_in_the_wrong_place_are_refused_and_leave_nothing() {
    let folder = files(&room(), &room(), 1.0);
    fails(&folder.run(&["init", "photo.png", "room.glb"]), "name the scene first");
    fails(&folder.run(&["init", "room.glb", "no.png"]), "no.png");
    fails(&folder.run(&["init", "no.glb", "photo.png"]), "no.glb");
    fails(&folder.run(&["init", "room.glb", "photo.png", "--out", "p.txt"]), ".toml");
    assert!(!folder.path("project.toml").exists() && !folder.path("p.txt").exists());
    let words = ["recover", "--scene", "room.glb", "--photo", "no.png", "--out", "out"];
    fails(&folder.run(&words), "no.png");
    assert!(!folder.path("out").exists());
    is_refused(&folder.run(&["recover", "--scene", "room.glb", "--out", "out"]), "--photo");
    is_refused(&folder.run(&["recover", "--out", "out"]), "PROJECT");
}

#[test]
fn a_scene_and_a_photograph_are_enough_for_a_recovery() {
    let folder = files(&room(), &room(), 1.0);
    let words = [
        "recover",
        "--scene",
        "room.glb",
        "--photo",
        "photo.png",
        "--out",
        "out",
        "--effort",
        "draft",
    ];
    let output = folder.run(&words);
    succeeds(&output);
    assert!(stderr(&output).contains("guess: the response is \"srgb\""), "{}", stderr(&output));
    let text = folder.text("out/project.toml");
    let first = folder.bytes("out/materials.json");
    // Again, and from the project that it has written.
    succeeds(&folder.run(&words));
    assert_eq!(folder.text("out/project.toml"), text);
    let by_project = ["recover", "out/project.toml", "--out", "again", "--effort", "draft"];
    succeeds(&folder.run(&by_project));
    let groups = |bytes: &[u8]| {
        serde_json::from_slice::<serde_json::Value>(bytes).unwrap()["groups"].clone()
    };
    assert_eq!(groups(&folder.bytes("again/materials.json")), groups(&first));
    // A project that was edited is not replaced.
    folder.write("out/project.toml", &format!("{text}# edited\n"));
    fails(&folder.run(&words), "out/project.toml");
}

#[test]
fn a_picture_is_there_from_the_first_fit_on() {
    let folder = files(&room(), &room(), 0.5);
    succeeds(&folder.run(&["init", "room.glb", "photo.exr"]));
    let project = folder.text("project.toml").replace("exposure = 1.0", "exposure = 2.0");
    folder.write("project.toml", &project);
    let words = ["recover", "project.toml", "--out", "out", "--effort", "high"];
    let mut running = folder.command(&words).stderr(std::process::Stdio::null()).spawn().unwrap();
    let (started, picture) = (Instant::now(), folder.path("out/rerendered.png"));
    while !picture.exists() {
        assert!(started.elapsed() < Duration::from_secs(120), "no picture grows");
        std::thread::sleep(Duration::from_millis(2));
    }
    let is_early = !folder.path("out/materials.json").exists();
    assert!(is_early);
    // At the photograph's exposure.
    let mean = |name: &str| {
        let codes = picture::read(&folder.path(name)).unwrap().0.values;
        codes.pixels().iter().sum::<unrender::scene::Rgb>() / codes.pixels().len() as f32
    };
    let off = (mean("out/rerendered.png") - mean("photo.png")).abs().max_element();
    assert!(off < 0.03, "{off}");
    assert!(running.wait().unwrap().success());
    // What is there already stays whole until the new results are.
    let before = folder.bytes("out/rerendered.png");
    let mut running = folder.command(&words).stderr(std::process::Stdio::null()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    running.kill().unwrap();
    running.wait().unwrap();
    assert_eq!(folder.bytes("out/rerendered.png"), before);
    succeeds(&folder.run(&["report", "out"]));
}
