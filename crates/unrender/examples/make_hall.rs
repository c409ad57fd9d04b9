//! Makes `examples/hall`: a tapestry on a wall with a vase on a pedestal in front of it, to be
//! removed from the photograph (`docs/guides/restage.md`).
//!
//! Run from the root of the workspace:
//!
//! ```text
//! cargo run --release --example make_hall [FOLDER]
//! ```
//!
//! It writes the scene as a user would model it (`scene.glb`, all materials grey), its photograph
//! (`photo.png`), and the true photograph without the vase (`truth_removed.png`).

// Both programs use a part of these.
#[allow(dead_code)]
#[path = "make_room/rug.rs"]
mod rug;
#[path = "make_room/sensor.rs"]
mod sensor;
#[allow(dead_code)]
#[path = "make_room/shapes.rs"]
mod shapes;

use glam::{Vec2, Vec3};
use shapes::{cuboid, quad, revolved};
use std::error::Error;
use std::path::{Path, PathBuf};
use unrender::formats::{atomic, gltf, picture};
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Group, Material, Mesh, Object, Rgb, Scene};

const SIZE: (usize, usize) = (320, 240);
/// Scene radiance of a linear pixel value of one.
const EXPOSURE: f32 = 0.8;
const SEED: u64 = 2002;
const SPP: u32 = 1024;
const GREY: f32 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or("examples/hall".into(), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    let mut scene = hall();
    scene.validate()?;
    photograph(&scene, &folder.join("photo.png"))?;
    let mut empty = scene.clone();
    empty.objects.retain(|object| !["vase", "pedestal"].contains(&object.name.as_str()));
    photograph(&empty, &folder.join("truth_removed.png"))?;
    scene.groups.iter_mut().filter(|g| !g.is_emitter()).for_each(|group| {
        group.material = Material::diffuse(Rgb::splat(GREY));
    });
    atomic::write(&folder.join("scene.glb"), &gltf::to_glb(&scene)?)?;
    Ok(())
}

fn photograph(scene: &Scene, path: &Path) -> Result<(), Box<dyn Error>> {
    let settings = Settings { spp: SPP, seed: SEED, ..Settings::default() };
    let tracer = Tracer::new(scene);
    let film = tracer.render(&scene.materials(), &scene.cameras[0], SIZE, &settings, &|_| ());
    picture::write(path, &sensor::expose(&film.mean, EXPOSURE, SEED))?;
    Ok(())
}

fn add(scene: &mut Scene, name: &str, material: Material, mesh: Mesh) {
    let group = scene.groups.len();
    scene.groups.push(Group { name: name.to_owned(), material, emission: Rgb::ZERO });
    scene.objects.push(Object { name: name.to_owned(), group, mesh });
}

fn hall() -> Scene {
    let at = Vec3::new;
    let diffuse = |r, g, b| Material::diffuse(Rgb::new(r, g, b));
    let mut scene = Scene::default();
    let (x, y, z) = (4.0 * Vec3::X, 2.6 * Vec3::Y, 3.0 * Vec3::Z);
    add(&mut scene, "floor", diffuse(0.42, 0.36, 0.30), quad(at(-2.0, 0.0, 2.0), x, -z));
    add(&mut scene, "wall", diffuse(0.72, 0.70, 0.66), quad(at(-2.0, 0.0, -1.0), x, y));
    let tapestry = Material { texture: Some(rug::texture()), ..diffuse(0.0, 0.0, 0.0) };
    let hung = quad(at(-1.3, 0.55, -0.98), 2.6 * Vec3::X, 1.3 * Vec3::Y);
    add(&mut scene, "tapestry", tapestry, hung);
    let pedestal = cuboid(at(0.05, 0.0, -0.55), at(0.4, 0.6, -0.2));
    add(&mut scene, "pedestal", diffuse(0.6, 0.6, 0.58), pedestal);
    let profile = [(0.0, 0.0), (0.09, 0.0), (0.15, 0.1), (0.17, 0.22), (0.1, 0.38), (0.07, 0.46)];
    let profile = profile.map(|(radius, height)| Vec2::new(radius, height));
    let vase = revolved(at(0.225, 0.6, -0.375), &profile, 48);
    add(&mut scene, "vase", diffuse(0.15, 0.32, 0.45), vase);
    let lamp = quad(at(-1.6, 2.5, 0.6), 1.0 * Vec3::X, 0.6 * Vec3::Z);
    add(&mut scene, "lamp", diffuse(0.0, 0.0, 0.0), lamp);
    if let Some(group) = scene.groups.last_mut() {
        group.emission = Rgb::new(13.0, 12.5, 11.5);
    }
    let (eye, target) = (at(0.5, 1.35, 3.2), at(-0.05, 0.95, -0.8));
    let camera = Camera::look_at("camera", eye, target, Vec3::Y, 42f32.to_radians());
    scene.cameras.push(Camera { aspect: Some(SIZE.0 as f32 / SIZE.1 as f32), ..camera });
    scene
}
