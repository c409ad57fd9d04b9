//! A small scene with one of everything that an export must carry: each kind of material, a texture,
//! smooth normals, a tangent frame, each kind of light, a turned panorama around it, a shifted camera, and difficult
//! names.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::path::PathBuf;
use std::sync::Arc;
use unrender::converted::converted;
use unrender::formats::LightUnits;
use unrender::formats::export::{self, SceneView, Target};
use unrender::scene::{
    Camera, Environment, Group, Image, Lens, Light, LightKind, Material, Mesh, Object, Rgb,
    RgbImage, Scene, Texture, Wrap,
};

/// The size of the picture.
pub(crate) const SIZE: (usize, usize) = (80, 60);

/// The camera, its axis beside the picture's centre.
pub(crate) fn camera() -> Camera {
    let (eye, target) = (Vec3::new(0.1, 1.3, 3.6), Vec3::new(0.0, 0.85, 0.0));
    let camera = Camera::look_at("the \"camera\"", eye, target, Vec3::Y, 0.75);
    let lens = Lens { principal_point: [0.06, -0.04], ..Lens::default() };
    Camera { lens, ..camera }
}

/// The scene.
pub(crate) fn scene() -> Scene {
    let mut scene = Scene { cameras: vec![camera()], ..Scene::default() };
    let brushed = Material {
        alpha_y: 0.3,
        theta_rad: 0.6,
        ..Material::isotropic(Rgb::new(0.3, 0.1, 0.05), Rgb::new(0.3, 0.4, 0.5), 0.12)
    };
    let metal = Material::isotropic(Rgb::new(0.16, 0.08, 0.04), Rgb::new(0.64, 0.32, 0.16), 0.15);
    let white = Material::diffuse(Rgb::new(0.7, 0.68, 0.6));
    let tiles = Material { texture: Some(Arc::new(tiles())), ..Material::diffuse(Rgb::splat(0.4)) };
    let black = Material::diffuse(Rgb::ZERO);
    let mirror = Material::mirror(Rgb::new(0.9, 0.8, 0.7));
    let glossy = Material::isotropic(Rgb::new(0.1, 0.4, 0.3), Rgb::splat(0.2), 0.2);
    let wall = wall([-1.5, 0.0, -1.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    add(&mut scene, "wall é \"门\" \\ 100 %", white, Rgb::ZERO, "o", wall);
    let mut floor = self::wall([-1.5, 0.0, 1.5], [3.0, 0.0, 0.0], [0.0, 0.0, -2.5]);
    floor.uvs = [[0.0, 0.0], [2.2, 0.0], [2.2, 1.6], [0.0, 1.6]].map(Vec2::from_array).to_vec();
    floor = Mesh::flat(&floor.positions, &floor.uvs, &floor.triangles);
    add(&mut scene, "Wall", tiles, Rgb::ZERO, "o", floor);
    let plate = self::wall([-1.5, 0.0, 1.0], [0.4, 0.0, -2.0], [0.0, 1.2, 0.0]);
    add(&mut scene, "wall", brushed, Rgb::ZERO, "o", plate);
    let plate = self::wall([1.1, 0.0, -1.0], [0.4, 0.0, 2.0], [0.0, 1.2, 0.0]);
    add(&mut scene, "<metal & 'co'>", metal, Rgb::ZERO, "", plate);
    let plate = self::wall([-0.9, 1.0, -0.95], [0.9, 0.0, 0.0], [0.0, 0.6, 0.3]);
    add(&mut scene, "mirror\nof two lines", mirror, Rgb::ZERO, "mirror; rm -rf", plate);
    add(&mut scene, "ball", glossy, Rgb::ZERO, "ball", ball(Vec3::new(0.3, 0.4, 0.1), 0.4));
    let panel = self::wall([-0.6, 1.99, -0.6], [1.2, 0.0, 0.0], [0.0, 0.0, 0.9]);
    add(&mut scene, "lamp", black, Rgb::new(6.0, 5.0, 4.0), "lamp", panel);
    scene.lights = lights();
    scene.environment = Environment::new(sky(), -2.1).ok();
    scene
}

/// Blue above and red on one side, so that it is not symmetric under any turn.
fn sky() -> RgbImage {
    RgbImage::from_fn(32, 16, |x, y| {
        let (around, down) = (TAU * x as f32 / 32.0, y as f32 / 16.0);
        Rgb::new(0.15 + 0.15 * around.sin(), 0.1, 0.4 * (1.0 - down))
    })
}

fn lights() -> Vec<Light> {
    let kinds = [
        LightKind::Spot {
            position: Vec3::new(-0.8, 1.8, 1.2),
            direction: Vec3::new(0.5, -0.8, -0.6).normalize(),
            intensity: Rgb::new(2.0, 3.0, 3.0),
            inner_rad: 0.2,
            outer_rad: 0.6,
        },
        LightKind::Point { position: Vec3::new(1.2, 1.7, 1.3), intensity: Rgb::splat(0.8) },
        LightKind::Directional {
            direction: Vec3::new(-0.4, -1.0, -0.7).normalize(),
            irradiance: Rgb::new(0.6, 0.5, 0.4),
        },
    ];
    kinds.map(|kind| Light { name: "light".into(), kind }).to_vec()
}

/// A parallelogram from a corner and two edges, its front towards `across` x `up`.
fn wall(corner: [f32; 3], across: [f32; 3], up: [f32; 3]) -> Mesh {
    let [corner, across, up] = [corner, across, up].map(Vec3::from_array);
    let positions = [corner, corner + across, corner + across + up, corner + up];
    let normal = across.cross(up).normalize();
    Mesh {
        positions: positions.to_vec(),
        normals: vec![normal; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A ball with smooth normals.
fn ball(centre: Vec3, radius: f32) -> Mesh {
    const AROUND: u32 = 32;
    const UP: u32 = 16;
    let mut mesh = Mesh::default();
    for (i, j) in (0..=UP).flat_map(|i| (0..AROUND).map(move |j| (i, j))) {
        let (height, turn) =
            (PI * i as f32 / UP as f32 - FRAC_PI_2, TAU * j as f32 / AROUND as f32);
        let normal = Vec3::new(height.cos() * turn.cos(), height.sin(), -height.cos() * turn.sin());
        mesh.normals.push(normal);
        mesh.positions.push(centre + radius * normal);
    }
    for (i, j) in (0..UP).flat_map(|i| (0..AROUND).map(move |j| (i, j))) {
        let at = |i: u32, j: u32| i * AROUND + j % AROUND;
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    // At the poles one of the two triangles has no area.
    let positions = mesh.positions.clone();
    let corner = |i: u32| positions[i as usize];
    mesh.triangles.retain(|t| {
        let [a, b, c] = t.map(corner);
        (b - a).cross(c - a).length() > 1e-6
    });
    mesh
}

/// Not square, and not symmetric under any reflection.
fn tiles() -> Texture {
    let image = Image::from_fn(24, 16, |x, y| {
        let dark = (x / 6 + y / 4) % 2 == 0;
        let red = if dark { 0.1 } else { 0.8 };
        Rgb::new(red, 0.1 + 0.6 * x as f32 / 23.0, 0.1 + 0.6 * y as f32 / 15.0)
    });
    // A texture that repeats mirrored looks the same from both edges, so v must not repeat that
    // way.
    Texture { image, wrap_u: Wrap::MirroredRepeat, wrap_v: Wrap::Repeat }
}

fn add(
    scene: &mut Scene,
    group: &str,
    material: Material,
    emission: Rgb,
    object: &str,
    mesh: Mesh,
) {
    let index = scene.groups.len();
    scene.groups.push(Group { name: group.into(), material, emission });
    scene.objects.push(Object { name: object.into(), group: index, mesh });
}

/// Exports `scene` as `target` into a new folder; returns that folder and the exported file or
/// folder.
pub(crate) fn exported(scene: &Scene, target: Target) -> (tempfile::TempDir, PathBuf) {
    exported_as(scene, target, &target.usual_name())
}

/// The same under a name of its own.
pub(crate) fn exported_as(
    scene: &Scene,
    target: Target,
    name: &str,
) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let camera = camera();
    let converted = converted(scene, &camera, SIZE, target.lobe(scene.brdf));
    let materials: Vec<Material> = converted.into_iter().map(|c| c.material).collect();
    let (camera, materials) = (&camera, &materials[..]);
    let shot =
        SceneView { scene, materials, camera, size: SIZE, light_units: LightUnits::Radiometric };
    let (files, warnings) = export::export(&shot, target, &path).unwrap();
    // The scene's camera has a lens, and there is light around it, which glTF cannot express; nor can USD its spot, its lamp,
    // and its brushed plate.
    let is_expected = |w: &String| {
        target == Target::Gltf && w.contains("what a lens does")
            || target == Target::Usd
                && ["spots fall off", "which side", "no anisotropy", "straight through"]
                    .iter()
                    .any(|of| w.contains(of))
            || !target.has_environments() && w.contains("no words for the environment")
    };
    assert!(warnings.0.iter().all(is_expected), "{warnings:?}");
    export::write(&path, target, &files).unwrap();
    (folder, path)
}
