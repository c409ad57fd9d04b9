//! A recovery by the command, of a scene small enough to be done at once.

use glam::Vec3;
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use unrender::formats::{gltf, picture};
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Group, Material, Mesh, Object, Rgb, Scene};

const SIZE: (usize, usize) = (48, 48);
const PROJECT: &str =
    "scene = \"scene.glb\"\nphoto = \"photo.exr\"\nresponse = \"linear\"\nexposure = 1\n";

/// Recovers a floor and a wall under a lamp into `folder`; returns what `--json` printed.
pub(crate) fn make(folder: &Path) -> Value {
    let inputs = folder.with_extension("inputs");
    std::fs::create_dir_all(&inputs).unwrap();
    let mut scene = scene();
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

fn scene() -> Scene {
    let mut scene = Scene::default();
    let quads = [
        ("floor", [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]]),
        ("wall & co", [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 2.0, -1.0], [-1.0, 2.0, -1.0]]),
        ("lamp", [[-0.4, 2.0, -0.4], [0.4, 2.0, -0.4], [0.4, 2.0, 0.4], [-0.4, 2.0, 0.4]]),
    ];
    for (group, (name, corners)) in quads.into_iter().enumerate() {
        let mesh = Mesh::flat(&corners.map(Vec3::from_array), &[], &[[0, 1, 2], [0, 2, 3]]);
        scene.objects.push(Object { name: name.into(), group, mesh });
        let is_lamp = name == "lamp";
        let emission = if is_lamp { Rgb::splat(8.0) } else { Rgb::ZERO };
        let rho_d = if is_lamp { Rgb::ZERO } else { Rgb::new(0.6, 0.4, 0.2) };
        scene.groups.push(Group {
            name: name.into(),
            material: Material::diffuse(rho_d),
            emission,
        });
    }
    let (eye, target) = (Vec3::new(0.0, 1.2, 3.0), Vec3::new(0.0, 0.7, 0.0));
    scene.cameras.push(Camera::look_at("camera", eye, target, Vec3::Y, 0.7));
    scene
}
