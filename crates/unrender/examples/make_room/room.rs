//! The room: its walls and furniture, its lights, its camera, and what everything is made of.
//!
//! Metres, y up. The room reaches from -2 to 2 in x and z; the camera stands near the wall at
//! z = 2 and looks towards the one at z = -2.

use crate::rug;
use crate::shapes::{cuboid, ellipsoid, merged, quad, revolved};
use glam::{Vec2, Vec3};
use unrender::scene::{
    Camera, Group, Light, LightKind, Material, Mesh, Object, Rgb, Scene, WardModel,
};

/// Width and height of the photograph.
pub(crate) const SIZE: (usize, usize) = (480, 360);
/// The groups that the picture hardly shows (a sliver of the ceiling) or does not show.
pub(crate) const UNSEEN: [&str; 2] = ["ceiling", "wardrobe"];

const HEIGHT: f32 = 2.6;
/// Scale of the vase: its profile is that of a small one.
const VASE_SCALE: f32 = 1.6;

/// The furnished room with its true materials.
pub(crate) fn scene() -> Scene {
    let mut scene = Scene { brdf: WardModel::WardGmd.into(), ..Scene::default() };
    shell(&mut scene);
    furniture(&mut scene);
    small_things(&mut scene);
    lights(&mut scene);
    let eye = Vec3::new(0.7, 1.68, 1.93);
    let fov_y_rad = 60f32.to_radians();
    let mut camera =
        Camera::look_at("camera", eye, Vec3::new(-0.12, 0.68, -1.1), Vec3::Y, fov_y_rad);
    camera.aspect = Some(SIZE.0 as f32 / SIZE.1 as f32);
    scene.cameras.push(camera);
    scene
}

/// Adds a group with one object per mesh.
fn add(scene: &mut Scene, name: &str, material: Material, meshes: Vec<Mesh>) {
    let group = scene.groups.len();
    scene.groups.push(Group { name: name.to_owned(), material, emission: Rgb::ZERO });
    let several = meshes.len() > 1;
    scene.objects.extend(meshes.into_iter().enumerate().map(|(i, mesh)| Object {
        name: if several { format!("{name}_{}", i + 1) } else { name.to_owned() },
        group,
        mesh,
    }));
}

fn diffuse(r: f32, g: f32, b: f32) -> Material {
    Material::diffuse(Rgb::new(r, g, b))
}

fn at(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// Floor, walls and ceiling; all fronts look inwards.
fn shell(scene: &mut Scene) {
    let (x, y, z) = (4.0 * Vec3::X, HEIGHT * Vec3::Y, 4.0 * Vec3::Z);
    let boards = Material::isotropic(Rgb::new(0.36, 0.24, 0.14), Rgb::splat(0.15), 0.15);
    add(scene, "floor", boards, vec![quad(at(-2.0, 0.0, 2.0), x, -z)]);
    let walls = vec![
        quad(at(-2.0, 0.0, 2.0), -z, y),
        quad(at(2.0, 0.0, -2.0), z, y),
        quad(at(2.0, 0.0, 2.0), -x, y),
    ];
    add(scene, "walls", diffuse(0.80, 0.78, 0.73), walls);
    add(scene, "green_wall", diffuse(0.28, 0.44, 0.36), vec![quad(at(-2.0, 0.0, -2.0), x, y)]);
    add(scene, "ceiling", diffuse(0.85, 0.85, 0.83), vec![quad(at(-2.0, HEIGHT, -2.0), x, z)]);
}

/// A table leg or the like: a square bar of the given width between two heights.
fn bar(x: f32, z: f32, width: f32, low: f32, high: f32) -> Mesh {
    let half = 0.5 * width;
    cuboid(at(x - half, low, z - half), at(x + half, high, z + half))
}

fn furniture(scene: &mut Scene) {
    let sofa = vec![
        cuboid(at(-1.35, 0.08, -1.9), at(0.35, 0.42, -1.1)),
        cuboid(at(-1.35, 0.42, -1.9), at(0.35, 0.86, -1.68)),
        cuboid(at(-1.55, 0.08, -1.9), at(-1.35, 0.62, -1.1)),
        cuboid(at(0.35, 0.08, -1.9), at(0.55, 0.62, -1.1)),
    ];
    add(scene, "sofa", diffuse(0.62, 0.27, 0.14), sofa);

    let rug = Material { texture: Some(rug::texture()), ..diffuse(0.0, 0.0, 0.0) };
    let laid = quad(at(-1.2, 0.008, 0.4), 1.7 * Vec3::X, -0.85 * Vec3::Z);
    add(scene, "rug", rug, vec![laid]);

    let steel = Material {
        alpha_x: 0.08,
        alpha_y: 0.2,
        theta_rad: 30f32.to_radians(),
        ..Material::isotropic(Rgb::splat(0.05), Rgb::new(0.70, 0.69, 0.66), 0.1)
    };
    let front = quad(at(0.85, 0.06, -1.5), 0.95 * Vec3::X, 1.64 * Vec3::Y);
    add(scene, "steel", steel, vec![front]);

    let glass = Material::mirror(Rgb::new(0.50, 0.55, 0.60));
    let top = cuboid(at(-0.85, 0.40, -0.98), at(0.1, 0.43, -0.46));
    add(scene, "dark_glass", glass, vec![top]);

    let mirror = quad(at(-1.98, 0.95, -0.35), -0.95 * Vec3::Z, 1.15 * Vec3::Y);
    add(scene, "mirror", Material::mirror(Rgb::ONE), vec![mirror]);

    let legs = [(-0.8, -0.93), (0.05, -0.93), (-0.8, -0.51), (0.05, -0.51)];
    let mut oak: Vec<Mesh> = legs.iter().map(|&(x, z)| bar(x, z, 0.05, 0.0, 0.40)).collect();
    // The shelf, the cupboard behind its steel front, the lamp's pole and foot, the mirror's frame.
    oak.push(cuboid(at(-1.3, 1.42, -2.0), at(0.3, 1.46, -1.76)));
    oak.push(cuboid(at(0.85, 0.0, -2.0), at(1.8, 1.76, -1.502)));
    oak.push(bar(1.55, -0.4, 0.03, 0.03, 1.2));
    oak.push(bar(1.55, -0.4, 0.28, 0.0, 0.03));
    oak.push(cuboid(at(-2.0, 0.90, -1.35), at(-1.985, 2.15, -0.30)));
    add(scene, "oak", diffuse(0.50, 0.33, 0.18), oak);

    let wardrobe = cuboid(at(-1.9, 0.0, 1.4), at(-0.5, 2.0, 1.98));
    add(scene, "wardrobe", diffuse(0.35, 0.28, 0.22), vec![wardrobe]);
}

fn small_things(scene: &mut Scene) {
    let spines = [(0.05, 0.27), (0.04, 0.24), (0.06, 0.29), (0.05, 0.22), (0.07, 0.26)];
    let mut x = -1.15;
    let mut books = Vec::new();
    for (i, (thick, high)) in spines.into_iter().cycle().take(11).enumerate() {
        let depth = if i % 2 == 0 { 0.19 } else { 0.17 };
        books.push(cuboid(at(x, 1.46, -1.98), at(x + thick, 1.46 + high, -1.98 + depth)));
        x += thick + if i == 5 { 0.25 } else { 0.008 };
    }
    add(scene, "books", diffuse(0.14, 0.22, 0.42), books);

    let profile = [
        (0.055, 0.0),
        (0.085, 0.03),
        (0.115, 0.08),
        (0.13, 0.14),
        (0.12, 0.20),
        (0.09, 0.25),
        (0.062, 0.29),
        (0.052, 0.33),
        (0.06, 0.37),
    ];
    let profile: Vec<Vec2> = profile.map(|p| VASE_SCALE * Vec2::from(p)).to_vec();
    let glazed = Material::isotropic(Rgb::new(0.10, 0.30, 0.48), Rgb::splat(0.30), 0.12);
    add(scene, "vase", glazed, vec![revolved(at(0.95, 0.0, -0.55), &profile, 48)]);

    let pouf = ellipsoid(at(-1.6, 0.0, -0.15), 0.34, 0.21, 24);
    add(scene, "pouf", diffuse(0.70, 0.50, 0.12), vec![pouf]);
}

fn lights(scene: &mut Scene) {
    let panel = quad(at(-0.9, HEIGHT - 0.01, -0.5), 1.8 * Vec3::X, 1.2 * Vec3::Z);
    let globe = ellipsoid(at(1.55, 1.2, -0.4), 0.16, 0.16, 12);
    for (name, mesh, emission) in [
        ("ceiling_panel", panel, Rgb::new(2.8, 2.7, 2.5)),
        ("globe", merged(&[globe]), Rgb::new(6.0, 5.0, 3.5)),
    ] {
        add(scene, name, diffuse(0.0, 0.0, 0.0), vec![mesh]);
        if let Some(group) = scene.groups.last_mut() {
            group.emission = emission;
        }
    }
    let position = at(-0.9, 2.45, -1.7);
    scene.lights.push(Light {
        name: "spot".to_owned(),
        kind: LightKind::Spot {
            position,
            direction: (at(-0.3, 0.0, -0.2) - position).normalize(),
            intensity: Rgb::new(6.0, 5.5, 4.7),
            inner_rad: 18f32.to_radians(),
            outer_rad: 32f32.to_radians(),
        },
    });
}
