//! A small robot to put into the room: a model of its own, about half a metre high.

use crate::shapes::{cuboid, ellipsoid, merged, revolved};
use glam::{Vec2, Vec3};
use unrender::scene::{Group, Material, Mesh, Object, Rgb, Scene, WardModel};

/// The robot, standing on the origin and looking along +z.
pub(crate) fn scene() -> Scene {
    let mut scene = Scene { brdf: WardModel::WardGmd.into(), ..Scene::default() };
    let paint = Material::isotropic(Rgb::new(0.75, 0.72, 0.66), Rgb::splat(0.06), 0.12);
    let rubber = Material::diffuse(Rgb::splat(0.06));
    let steel = Material::isotropic(Rgb::splat(0.08), Rgb::new(0.62, 0.62, 0.60), 0.16);
    let red = Material::diffuse(Rgb::new(0.55, 0.05, 0.04));
    add(&mut scene, "paint", paint, merged(&[block((0.0, 0.24, 0.0), (0.26, 0.22, 0.20)), head()]));
    add(&mut scene, "rubber", rubber, merged(&[feet(), eyes()]));
    add(&mut scene, "steel", steel, limbs());
    add(&mut scene, "red", red, block((0.0, 0.27, 0.103), (0.12, 0.05, 0.012)));
    scene
}

fn add(scene: &mut Scene, name: &str, material: Material, mesh: Mesh) {
    let group = scene.groups.len();
    scene.groups.push(Group { name: name.to_owned(), material, emission: Rgb::ZERO });
    scene.objects.push(Object { name: name.to_owned(), group, mesh });
}

/// A box about `centre`.
fn block(centre: (f32, f32, f32), size: (f32, f32, f32)) -> Mesh {
    let (centre, half) = (Vec3::from(centre), 0.5 * Vec3::from(size));
    cuboid(centre - half, centre + half)
}

fn head() -> Mesh {
    ellipsoid(Vec3::new(0.0, 0.37, 0.0), 0.11, 0.075, 24)
}

fn eyes() -> Mesh {
    let eye = |x: f32| ellipsoid(Vec3::new(x, 0.43, 0.092), 0.022, 0.022, 12);
    merged(&[eye(-0.045), eye(0.045)])
}

fn feet() -> Mesh {
    merged(&[-0.08, 0.08].map(|x| block((x, 0.03, 0.03), (0.10, 0.06, 0.22))))
}

/// Legs, arms, neck and antenna.
fn limbs() -> Mesh {
    let post = |x: f32, low: f32, high: f32, radius: f32| {
        let profile = [(0.0, 0.0), (radius, 0.0), (radius, high - low), (0.0, high - low)];
        revolved(Vec3::new(x, low, 0.0), &profile.map(|(r, y)| Vec2::new(r, y)), 24)
    };
    merged(&[
        post(-0.08, 0.05, 0.14, 0.025),
        post(0.08, 0.05, 0.14, 0.025),
        post(-0.16, 0.14, 0.33, 0.022),
        post(0.16, 0.14, 0.33, 0.022),
        post(0.0, 0.34, 0.38, 0.05),
        post(0.0, 0.51, 0.60, 0.006),
    ])
}
