//! A small room with a brushed floor, a round gloss on the back wall, two diffuse walls, and a ceiling
//! that no pixel shows.

use glam::{Vec2, Vec3};
use unrender_scene::{BrdfModel, Camera, Group, Material, Mesh, Object, Rgb, Scene};

pub(crate) const FLOOR: usize = 0;
pub(crate) const BACK: usize = 1;
pub(crate) const LEFT: usize = 2;
pub(crate) const RIGHT: usize = 3;
pub(crate) const CEILING: usize = 4;
pub(crate) const LAMP: usize = 5;

/// A square of side 2 about `centre`, its front towards `normal`.
fn wall(group: usize, centre: Vec3, normal: Vec3, half: f32) -> Object {
    let x = if normal.x.abs() > 0.5 { Vec3::Z } else { Vec3::X };
    let y = normal.cross(x);
    let corner = |u: f32, v: f32| centre + half * (u * x + v * y);
    let positions =
        vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mesh = Mesh {
        normals: vec![normal; 4],
        tangents: vec![x.extend(1.0); 4],
        uvs: vec![Vec2::ZERO; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        positions,
        ..Mesh::default()
    };
    Object { name: format!("wall {group}"), group, mesh }
}

/// The materials of its groups.
pub(crate) fn truth() -> Vec<Material> {
    let floor = Material {
        alpha_y: 0.28,
        theta_rad: 0.4,
        ..Material::isotropic(Rgb::new(0.2, 0.25, 0.3), Rgb::new(0.4, 0.35, 0.3), 0.12)
    };
    vec![
        floor,
        Material::isotropic(Rgb::new(0.3, 0.2, 0.4), Rgb::splat(0.25), 0.2),
        Material::diffuse(Rgb::new(0.6, 0.3, 0.2)),
        Material::diffuse(Rgb::new(0.2, 0.5, 0.7)),
        Material::diffuse(Rgb::new(0.7, 0.6, 0.5)),
        Material::diffuse(Rgb::ZERO),
    ]
}

/// The room, its materials those of `brdf`.
pub(crate) fn room(brdf: BrdfModel) -> Scene {
    let names = ["floor", "back", "left", "right", "ceiling", "lamp"];
    let group = |(i, material): (usize, Material)| Group {
        name: names[i].to_owned(),
        material,
        emission: if i == LAMP { Rgb::splat(12.0) } else { Rgb::ZERO },
    };
    let mut scene = Scene {
        objects: vec![
            wall(FLOOR, Vec3::NEG_Y, Vec3::Y, 1.0),
            wall(BACK, Vec3::NEG_Z, Vec3::Z, 1.0),
            wall(LEFT, Vec3::NEG_X, Vec3::X, 1.0),
            wall(RIGHT, Vec3::X, Vec3::NEG_X, 1.0),
            wall(CEILING, Vec3::Y, Vec3::NEG_Y, 1.0),
            wall(LAMP, 0.98 * Vec3::Y, Vec3::NEG_Y, 0.35),
        ],
        groups: truth().into_iter().enumerate().map(group).collect(),
        brdf,
        ..Scene::default()
    };
    scene.validate().unwrap();
    scene
}

/// Its camera.
pub(crate) fn camera() -> Camera {
    // Looks a little down: the ceiling is out of the picture.
    Camera::look_at("camera", Vec3::new(0.0, -0.1, 1.9), Vec3::new(0.0, -0.55, 0.0), Vec3::Y, 0.75)
}
