//! A small room of five colours under a lamp, and its photograph by a camera of known response and
//! lens.

use super::meshes::{add, square};
use glam::Vec3;
use unrender::photo::vignetting::Law;
use unrender::photo::{Response, Transfer, Vignetting};
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Rgb, RgbImage, Scene, WardModel};

/// The exposure of the photographs.
pub(crate) const EXPOSURE: f32 = 2.4;
/// The groups except the lamp, and their reflectances.
pub(crate) const RHO: [(&str, [f32; 3]); 5] = [
    ("floor", [0.5, 0.4, 0.3]),
    ("back", [0.7, 0.7, 0.7]),
    ("left", [0.6, 0.2, 0.15]),
    ("right", [0.2, 0.5, 0.3]),
    ("ceiling", [0.8, 0.8, 0.8]),
];

/// The room with its lamp and its camera.
pub(crate) fn room() -> Scene {
    let sides = [
        (Vec3::NEG_Y, Vec3::Y),
        (Vec3::NEG_Z, Vec3::Z),
        (Vec3::NEG_X, Vec3::X),
        (Vec3::X, Vec3::NEG_X),
        (Vec3::Y, Vec3::NEG_Y),
    ];
    let mut scene = Scene { brdf: WardModel::WardGmd.into(), ..Scene::default() };
    for ((name, rho_d), (centre, normal)) in RHO.into_iter().zip(sides) {
        add(&mut scene, name, Rgb::from_array(rho_d), square(centre, normal, 1.0));
    }
    add(&mut scene, "lamp", Rgb::ZERO, square(0.98 * Vec3::Y, Vec3::NEG_Y, 0.3));
    scene.groups[5].emission = Rgb::splat(12.0);
    let (eye, target) = (Vec3::new(0.1, 0.0, 2.6), Vec3::new(0.0, -0.05, 0.0));
    scene.cameras = vec![Camera::look_at("camera", eye, target, Vec3::Y, 0.9)];
    scene.validate().unwrap();
    scene
}

/// The code values (one is white) of a photograph of `size` pixels by a `camera` of this gamma and fall-off.
pub(crate) fn codes(
    scene: &Scene,
    camera: &Camera,
    size: (usize, usize),
    (gamma, law): (f32, Option<Law>),
) -> RgbImage {
    let render = Settings { spp: 256, seed: 77, ..Settings::default() };
    let radiance =
        Tracer::new(scene).render(&scene.materials(), camera, size, &render, &|_| {}).mean;
    let vignetting = law.map(|law| Vignetting { law, camera: camera.clone(), size });
    let plain = Transfer::plain(Response::Gamma(gamma), Rgb::splat(EXPOSURE));
    Transfer { vignetting, ..plain }.codes(&radiance)
}

/// The largest error of a reflectance of the room, where `found` gives the result for each group's
/// name.
pub(crate) fn worst(found: impl Fn(&str) -> Rgb) -> f32 {
    let error =
        |(name, rho): (&str, [f32; 3])| (found(name) - Rgb::from_array(rho)).abs().max_element();
    RHO.into_iter().map(error).fold(0.0, f32::max)
}
