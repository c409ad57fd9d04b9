//! A small room and its photograph.

pub(crate) use crate::kit::meshes::{append, cuboid, quad};
use glam::Vec3;
use std::sync::OnceLock;
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Group, Material, Mesh, Object, Rgb, RgbImage, Scene, Warnings};

pub(crate) const SIZE: (usize, usize) = (120, 90);
pub(crate) const LAMP: usize = 4;
pub(crate) const BLOCK: usize = 3;
pub(crate) const GROUPS: [(&str, [f32; 3]); 5] = [
    ("back_wall", [0.6, 0.6, 0.55]),
    ("floor", [0.5, 0.4, 0.3]),
    ("walls", [0.3, 0.4, 0.6]),
    ("block", [0.7, 0.3, 0.2]),
    ("lamp", [0.0, 0.0, 0.0]),
];

/// The mesh with its other side as the front.
pub(crate) fn flipped(mesh: &Mesh) -> Mesh {
    let mut mesh = mesh.clone();
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    mesh.normals.iter_mut().for_each(|normal| *normal = -*normal);
    mesh
}

pub(crate) fn object(group: usize, mesh: Mesh) -> Object {
    Object { name: format!("the {}", GROUPS[group].0), group, mesh }
}

/// Back wall, floor, side walls, a block, and a lamp below the place of the missing ceiling.
pub(crate) fn room() -> Scene {
    let (x, y, z) = (2.0 * Vec3::X, 2.0 * Vec3::Y, 2.0 * Vec3::Z);
    let low = Vec3::new(-1.0, 0.0, -1.0);
    let mut walls = quad(low, y, z);
    walls = flipped(&flipped(&walls));
    append(&mut walls, &quad(low + x, z, y));
    let meshes = [
        (0, quad(low, x, y)),
        (1, quad(low, z, x)),
        (2, walls),
        (BLOCK, cuboid(Vec3::new(-0.5, 0.0, -0.6), Vec3::new(0.0, 0.7, -0.1))),
        (LAMP, quad(Vec3::new(-0.4, 1.95, -0.4), 0.8 * Vec3::X, 0.8 * Vec3::Z)),
    ];
    let group = |(i, (name, rho)): (usize, (&str, [f32; 3]))| Group {
        name: name.to_owned(),
        material: Material::diffuse(Rgb::from_array(rho)),
        emission: if i == LAMP { Rgb::splat(6.0) } else { Rgb::ZERO },
    };
    let mut scene = Scene {
        objects: meshes.into_iter().map(|(group, mesh)| object(group, mesh)).collect(),
        groups: GROUPS.into_iter().enumerate().map(group).collect(),
        ..Scene::default()
    };
    assert_eq!(scene.validate(), Ok(Warnings::default()));
    scene
}

pub(crate) fn camera() -> Camera {
    Camera::look_at("camera", Vec3::new(0.1, 1.0, 3.2), Vec3::new(0.0, 0.7, 0.0), Vec3::Y, 0.55)
}

/// The photograph of `scene` by `camera`.
pub(crate) fn photograph(scene: &Scene, camera: &Camera) -> RgbImage {
    let settings = Settings { spp: 64, seed: 5, max_bounces: 6, ..Settings::default() };
    Tracer::new(scene).render(&scene.materials(), camera, SIZE, &settings, &|_| ()).mean
}

/// The photograph of `room()` by `camera()`.
pub(crate) fn photo_of_room() -> RgbImage {
    static PHOTO: OnceLock<RgbImage> = OnceLock::new();
    PHOTO.get_or_init(|| photograph(&room(), &camera())).clone()
}
