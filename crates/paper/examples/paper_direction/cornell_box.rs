//! The box of the paper's Figure 8, as `examples/fig8` has it: metres, y up.

use glam::{Vec2, Vec3};
use unrender_scene::{BrdfModel, Camera, Group, Material, Mesh, Object, Rgb, Scene, WardModel};

pub(crate) const FLOOR: usize = 0;
pub(crate) const LIGHT: usize = 7;

const NAMES: [&str; 8] =
    ["floor", "ceil", "back_wall", "right_wall", "left_wall", "small_block", "big_block", "light"];

/// The materials of its groups; the floor is brushed along `degrees` from world +x.
pub(crate) fn truth(degrees: f32) -> Vec<Material> {
    let floor = Material {
        alpha_y: 0.11,
        theta_rad: degrees.to_radians(),
        ..Material::isotropic(Rgb::splat(0.1), Rgb::splat(0.9), 0.07)
    };
    let diffuse = [
        Rgb::ONE,
        Rgb::new(0.65, 0.65, 0.0),
        Rgb::new(0.69, 0.0, 0.95),
        Rgb::splat(0.66),
        Rgb::new(0.0, 0.76, 0.26),
        Rgb::new(0.77, 0.0, 0.0),
        Rgb::ZERO,
    ];
    std::iter::once(floor).chain(diffuse.map(Material::diffuse)).collect()
}

/// Four corners of each face.
type Faces = Vec<[[f32; 3]; 4]>;

fn faces() -> [Faces; 8] {
    let (right, left, high, depth) = (0.0, 0.556, 0.5488, 0.5592);
    [
        vec![[[0.5528, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, depth], [0.5496, 0.0, depth]]],
        vec![[[left, high, 0.0], [left, high, depth], [right, high, depth], [right, high, 0.0]]],
        vec![[[0.5496, 0.0, depth], [0.0, 0.0, depth], [0.0, high, depth], [left, high, depth]]],
        vec![[[0.0, 0.0, depth], [0.0, 0.0, 0.0], [0.0, high, 0.0], [0.0, high, depth]]],
        vec![[[0.5528, 0.0, 0.0], [0.5496, 0.0, depth], [left, high, depth], [left, high, 0.0]]],
        block([[0.130, 0.065], [0.082, 0.225], [0.240, 0.272], [0.290, 0.114]], 0.165),
        block([[0.423, 0.247], [0.265, 0.296], [0.314, 0.456], [0.472, 0.406]], 0.33),
        vec![[
            [0.343, 0.5487, 0.227],
            [0.343, 0.5487, 0.332],
            [0.213, 0.5487, 0.332],
            [0.213, 0.5487, 0.227],
        ]],
    ]
}

/// The top of a block, whose corners are at these x and z, and its sides.
fn block(corners: [[f32; 2]; 4], high: f32) -> Faces {
    let at = |i: usize, y: f32| [corners[i % 4][0], y, corners[i % 4][1]];
    let top = [at(0, high), at(1, high), at(2, high), at(3, high)];
    let side = |i: usize| [at(i + 1, 0.0), at(i + 1, high), at(i, high), at(i, 0.0)];
    std::iter::once(top).chain((0..4).map(side)).collect()
}

fn object(group: usize, faces: &[[[f32; 3]; 4]]) -> Object {
    let positions: Vec<Vec3> = faces.iter().flatten().map(|corner| Vec3::from(*corner)).collect();
    // The tangent of the floor is +x.
    let uvs: Vec<Vec2> = positions.iter().map(|p| Vec2::new(p.x + 0.37 * p.y, p.z)).collect();
    let triangles: Vec<[u32; 3]> = (0..faces.len() as u32)
        .flat_map(|face| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i: u32| 4 * face + i)))
        .collect();
    Object { name: NAMES[group].into(), group, mesh: Mesh::flat(&positions, &uvs, &triangles) }
}

/// The box of these materials.
pub(crate) fn scene(materials: &[Material]) -> Scene {
    let group = |(i, material): (usize, &Material)| Group {
        name: NAMES[i].to_owned(),
        material: material.clone(),
        emission: if i == LIGHT { Rgb::splat(40.0) } else { Rgb::ZERO },
    };
    let mut scene = Scene {
        objects: faces().iter().enumerate().map(|(i, faces)| object(i, faces)).collect(),
        groups: materials.iter().enumerate().map(group).collect(),
        brdf: BrdfModel::Ward(WardModel::Ward1992),
        ..Scene::default()
    };
    scene.validate().unwrap();
    scene
}

/// Its camera; the ceiling is out of the picture.
pub(crate) fn camera() -> Camera {
    let eye = Vec3::new(0.278, 0.4, -0.8);
    let towards = Vec3::new(0.0, -0.175_364_69, 0.984_503_5);
    Camera::look_at("camera", eye, eye + towards, Vec3::Y, 0.558_505_36)
}
