//! A scene for tests that need any scene: a floor under a lamp.

use super::folder::Folder;
use super::meshes::{add, square};
use glam::Vec3;
use unrender::formats::{gltf, picture};
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Material, Rgb, Scene};

/// The reflectance of the floor.
pub(crate) const RHO: Rgb = Rgb::new(0.6, 0.4, 0.2);

/// The floor, which is group 0, the lamp, and a camera that looks down at the floor.
pub(crate) fn scene() -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, "floor", RHO, square(Vec3::ZERO, Vec3::Y, 1.0));
    add(&mut scene, "lamp", Rgb::ZERO, square(2.0 * Vec3::Y, Vec3::NEG_Y, 0.4));
    scene.groups[1].emission = Rgb::splat(4.0);
    let eye = Vec3::new(0.0, 1.4, 2.0);
    scene.cameras.push(Camera::look_at("camera", eye, Vec3::ZERO, Vec3::Y, 0.8));
    scene
}

/// A folder with the scene, whose floor is unknown, its photograph, and the project of both,
/// `p.toml`.
pub(crate) fn project() -> Folder {
    let folder = Folder::new();
    let mut scene = scene();
    // The reflectance of the floor is not in the file.
    scene.groups[0].material = Material::diffuse(Rgb::ZERO);
    folder.write("scene.glb", &gltf::to_glb(&scene).unwrap());
    scene.groups[0].material = Material::diffuse(RHO);
    let settings = Settings { spp: 64, ..Settings::default() };
    let camera = scene.cameras[0].clone();
    let tracer = Tracer::new(&scene);
    let view = unrender::recover::View::new(&tracer, &camera, (24, 24), scene.brdf);
    let photo = view.render(&scene.materials(), &settings, &|_| {}).mean;
    picture::write(&folder.path("photo.png"), &photo).unwrap();
    let project =
        "scene = \"scene.glb\"\nphoto = \"photo.png\"\nexposure = 1\nresponse = \"srgb\"\n";
    folder.write("p.toml", project);
    folder
}
