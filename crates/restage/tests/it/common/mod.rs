//! A small room for the proofs: a textured floor, white walls, a mirror, a lamp, a red box.

// Every test file compiles this module anew and uses a part of it.
#![allow(dead_code)]

use glam::{Quat, Vec2, Vec3};
use std::sync::Arc;
use unrender_render::{Settings, Tracer};
use unrender_restage::insert::{Insert, Place};
use unrender_scene::{
    Camera, Group, Image, Material, Mesh, Object, Rgb, RgbImage, Scene, Texture, Wrap,
};

pub(crate) const SIZE: (usize, usize) = (64, 48);

pub(crate) fn quad(corner: Vec3, across: Vec3, up: Vec3) -> Mesh {
    let positions = [corner, corner + across, corner + across + up, corner + up];
    let uvs = [Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.0), Vec2::ZERO];
    Mesh::flat(&positions, &uvs, &[[0, 1, 2], [0, 2, 3]])
}

/// A box between two corners that faces outwards.
pub(crate) fn cuboid(low: Vec3, high: Vec3) -> Mesh {
    let size = high - low;
    let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
    let faces = [
        quad(low + z, x, y),
        quad(high - y - z, -x, y),
        quad(high - y, -z, y),
        quad(low, z, y),
        quad(high - x, x, -z),
        quad(low, x, z),
    ];
    let mut all = Mesh::default();
    for face in faces {
        let first = all.positions.len() as u32;
        all.positions.extend(face.positions);
        all.normals.extend(face.normals);
        all.triangles.extend(face.triangles.iter().map(|t| t.map(|i| i + first)));
    }
    all
}

pub(crate) fn add(scene: &mut Scene, name: &str, material: Material, mesh: Mesh) {
    let group = scene.groups.len();
    scene.groups.push(Group { name: name.into(), material, emission: Rgb::ZERO });
    scene.objects.push(Object { name: name.into(), group, mesh });
}

/// Stripes of a light and a dark wood, with the mean reflectance `rho`.
fn stripes(rho: Rgb) -> Material {
    let share = |x: usize| if x % 4 < 2 { 1.3 } else { 0.7 };
    let image = Image::from_fn(64, 4, |x, _| rho * share(x));
    let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
    Material { texture: Some(Arc::new(texture)), ..Material::diffuse(rho) }
}

/// The colour of the floor, on the mean.
pub(crate) const FLOOR: Rgb = Rgb::new(0.5, 0.35, 0.2);

/// The room as it is: the floor has a texture, the walls have stripes too.
pub(crate) fn truth() -> Scene {
    let mut scene = Scene::default();
    let (x, y, z) = (4.0 * Vec3::X, 2.5 * Vec3::Y, 4.0 * Vec3::Z);
    let low = Vec3::new(-2.0, 0.0, -2.0);
    add(&mut scene, "floor", stripes(FLOOR), quad(low + z, x, -z));
    add(&mut scene, "back", stripes(Rgb::splat(0.6)), quad(low, x, y));
    add(&mut scene, "left", Material::diffuse(Rgb::splat(0.7)), quad(low + z, -z, y));
    add(&mut scene, "right", Material::diffuse(Rgb::splat(0.7)), quad(low + x, z, y));
    let mirror = quad(Vec3::new(-1.99, 0.3, 0.6), -2.2 * Vec3::Z, 1.5 * Vec3::Y);
    add(&mut scene, "mirror", Material::mirror(Rgb::splat(0.9)), mirror);
    add(
        &mut scene,
        "lamp",
        Material::diffuse(Rgb::ZERO),
        quad(Vec3::new(-0.5, 2.4, -0.5), Vec3::X, Vec3::Z),
    );
    scene.groups[5].emission = Rgb::splat(8.0);
    scene
}

/// The room as a recovery may leave it: no texture, and all reflectances a little wrong.
pub(crate) fn model() -> Scene {
    let mut scene = truth();
    for (index, off) in [1.02, 0.98, 1.01, 0.99].into_iter().enumerate() {
        let material = &mut scene.groups[index].material;
        *material = Material::diffuse(material.rho_d * off);
    }
    scene
}

pub(crate) fn camera() -> Camera {
    Camera::look_at("camera", Vec3::new(0.6, 1.5, 3.4), Vec3::new(-0.2, 0.7, -0.5), Vec3::Y, 0.8)
}

/// A red box of half a metre, as a model of its own.
pub(crate) fn red_box() -> Scene {
    let mut scene = Scene::default();
    let half = Vec3::new(0.25, 0.0, 0.25);
    let material = Material::diffuse(Rgb::new(0.7, 0.1, 0.08));
    add(&mut scene, "red", material, cuboid(-half, half + 0.5 * Vec3::Y));
    scene
}

/// The box put onto the floor.
pub(crate) fn insertion(x: f32, z: f32) -> Insert {
    Insert {
        name: "box".into(),
        model: red_box(),
        rotation: Quat::from_rotation_y(0.4),
        scale: 1.0,
        place: Place::Onto { group: "floor".into(), at: [x.into(), z.into()] },
        paint: Vec::new(),
    }
}

/// A picture of `scene`. Two scenes have the same picture where no path meets a difference.
pub(crate) fn picture(scene: &Scene, spp: u32) -> RgbImage {
    let settings = Settings { spp, seed: 77, ..Settings::default() };
    let tracer = Tracer::new(scene);
    tracer.render(&scene.materials(), &camera(), SIZE, &settings, &|_| ()).mean
}

/// The peak signal-to-noise ratio of sRGB codes over the pixels that `counts`, decibels.
pub(crate) fn psnr(a: &RgbImage, b: &RgbImage, counts: impl Fn(usize) -> bool) -> f64 {
    let code = |v: f32| unrender_scene::color::srgb_from_linear(v);
    let (mut squares, mut count) = (0.0, 0);
    for index in (0..a.pixels().len()).filter(|i| counts(*i)) {
        let (a, b) = (a.pixels()[index], b.pixels()[index]);
        squares += (0..3).map(|c| f64::from(code(a[c]) - code(b[c])).powi(2)).sum::<f64>();
        count += 3;
    }
    assert!(count > 0, "no pixel counts");
    -10.0 * (squares / f64::from(count)).log10()
}
