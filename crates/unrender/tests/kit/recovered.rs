//! A recovery by the command, of a very small scene.

use super::floor_and_lamp::{self, RHO};
use super::meshes::{add, square};
use glam::Vec3;
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use unrender::formats::{gltf, picture};
use unrender::render::{Settings, Tracer};

const SIZE: (usize, usize) = (48, 48);
const PROJECT: &str =
    "scene = \"scene.glb\"\nphoto = \"photo.exr\"\nresponse = \"linear\"\nexposure = 1\n";

/// Recovers a floor and a wall under a lamp into `folder`; returns what `--json` printed.
pub(crate) fn make(folder: &Path) -> Value {
    let inputs = folder.with_extension("inputs");
    std::fs::create_dir_all(&inputs).unwrap();
    let mut scene = floor_and_lamp::scene();
    add(&mut scene, "wall & co", RHO, square(Vec3::new(0.0, 1.0, -1.0), Vec3::Z, 1.0));
    scene.validate().unwrap();
    let settings = Settings { spp: 64, ..Settings::default() };
    let tracer = Tracer::new(&scene);
    let film = tracer.render(&scene.materials(), &scene.cameras[0], SIZE, &settings, &|_| ());
    picture::write_exr(&inputs.join("photo.exr"), &film.mean).unwrap();
    std::fs::write(inputs.join("scene.glb"), gltf::to_glb(&scene).unwrap()).unwrap();
    std::fs::write(inputs.join("project.toml"), PROJECT).unwrap();
    let mut unrender = Command::new(env!("CARGO_BIN_EXE_unrender"));
    unrender.args(["recover", "--quiet", "--json", "--spp", "8", "--no-refine"]);
    let output = unrender.arg(inputs.join("project.toml")).arg("--out").arg(folder);
    let output = output.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}
