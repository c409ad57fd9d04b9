//! Radiance scenes as Radiance itself means them: words, commands, materials, lamps, and what is refused.

mod commands;
mod lamps;
mod materials;
mod what_is_read;
mod words;

use crate::support::Folder;
use glam::Vec3;
use unrender_formats::{load_model, load_scene};
use unrender_scene::{Group, Mesh, Scene, Warnings};

/// Two materials, and a lamp far from everything.
const BASE: &str = "void plastic white 0 0 5 .7 .7 .7 0 0
void plastic red 0 0 5 .7 .1 .1 0 0
void light lamp 0 0 3 10 10 10
lamp sphere bulb 0 0 4 0 0 90 .1
";

/// The lines of [`BASE`].
const BASE_LINES: usize = 4;

/// Reads the scene of [`BASE`] and `text`, in a folder with further `files`.
fn read_beside(files: &[(&str, &str)], text: &str) -> Result<(Scene, Warnings), String> {
    let folder = Folder::new();
    for (name, text) in files {
        let path = folder.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        folder.file(name, text);
    }
    let path = folder.file("scene.rad", format!("{BASE}{text}\n"));
    load_scene(&path).map_err(|error| error.to_string())
}

/// As [`read_beside`], without further files.
fn read(text: &str) -> (Scene, Warnings) {
    read_beside(&[], text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// As [`read`], without a warning.
fn exactly(text: &str) -> Scene {
    let (scene, warnings) = read(text);
    assert!(warnings.0.is_empty(), "{text}: {warnings:?}");
    scene
}

/// Why `text` is refused.
fn refusal(text: &str) -> String {
    match read_beside(&[], text) {
        Err(told) => told,
        Ok(_) => panic!("was read: {text}"),
    }
}

/// A scene that needs no lamp.
fn model(text: &str) -> Scene {
    let folder = Folder::new();
    load_model(&folder.file("model.rad", text)).unwrap_or_else(|error| panic!("{error}")).0
}

fn mesh<'a>(scene: &'a Scene, name: &str) -> &'a Mesh {
    let found = scene.objects.iter().find(|object| object.name == name);
    &found.unwrap_or_else(|| panic!("no {name} in {:?}", names(scene))).mesh
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.objects.iter().map(|object| object.name.as_str()).collect()
}

/// The group of the object called `name`.
fn group<'a>(scene: &'a Scene, name: &str) -> &'a Group {
    let object = scene.objects.iter().find(|object| object.name == name).unwrap();
    &scene.groups[object.group]
}

/// The lowest and the highest corner.
fn bounds(mesh: &Mesh) -> [Vec3; 2] {
    let corners = mesh.positions.iter().map(|p| [*p, *p]);
    corners.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap()
}

/// The area, and twice the area by its direction.
fn area(mesh: &Mesh) -> (f32, Vec3) {
    let areas = (0..mesh.triangles.len()).map(|index| {
        let [a, b, c] = mesh.corners(index);
        0.5 * (b - a).cross(c - a)
    });
    areas.fold((0.0, Vec3::ZERO), |(sum, way), area| (sum + area.length(), way + area))
}

fn assert_near(found: Vec3, expected: [f32; 3], what: &str) {
    let expected = Vec3::from_array(expected);
    assert!(found.abs_diff_eq(expected, 1e-4), "{what}: {found} instead of {expected}");
}

fn assert_told(warnings: &Warnings, words: &str) {
    assert!(warnings.0.iter().any(|told| told.contains(words)), "{words}: {warnings:?}");
}
