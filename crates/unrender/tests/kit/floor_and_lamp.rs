//! A scene for tests that need just any: a floor under a lamp.

use super::meshes::{add, square};
use glam::Vec3;
use unrender::scene::{Camera, Rgb, Scene};

/// What the floor reflects.
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
