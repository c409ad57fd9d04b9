//! The statements of a project about light: the environment and the lights that the scene lacks. A
//! corner of a room whose file has no light is photographed, recovered and rendered again.

use crate::kit::folder::{Folder, fails, stderr, succeeds};
use crate::kit::meshes::{add, quad};
use glam::Vec3;
use std::ops::Deref;
use std::process::Output;
use unrender::formats::materials::{Status, StatusEntry};
use unrender::formats::picture::{self, Depth};
use unrender::formats::{gltf, materials};
use unrender::render::accel::Ray;
use unrender::render::{Settings, Tracer};
use unrender::scene::color::srgb_from_linear;
use unrender::scene::{Camera, Environment, Hypothesis, LightKind, Mesh, Rgb, RgbImage, Scene};
use unrender::{Job, Project};

const SIZE: (usize, usize) = (48, 36);
const FLOOR: Rgb = Rgb::new(0.5, 0.4, 0.3);
const WALL: Rgb = Rgb::new(0.3, 0.5, 0.6);
const AMBIENT: Rgb = Rgb::new(0.2, 0.25, 0.3);
const BULB: (Vec3, f32) = (Vec3::new(-0.6, 1.2, 0.2), 0.15);
const HEAD: &str =
    "scene = \"scene.glb\"\nphoto = \"photo.png\"\nresponse = \"srgb\"\nexposure = 1\n";
const LIGHTS: &str = "[environment]\ncolor = [0.2, 0.25, 0.3]\n\
    [[lights]]\nname = \"bulb\"\nadd = \"sphere\"\nposition = [-0.6, 1.2, 0.2]\nradius = 0.15\n\
    strength = [4, 4, 4]\n";

mod counted;
mod photometric;
mod stated;
mod unknown;

/// A folder with the scene, which has no light, and a photograph of it taken in light.
struct Corner(Folder);

impl Deref for Corner {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Corner {
    /// The corner in light of one colour from all around.
    fn new() -> Self {
        let ambient = RgbImage::new(1, 1, vec![AMBIENT]);
        Self::in_light(Environment::new(ambient, 0.0).unwrap())
    }

    /// The corner in the light of `around`.
    fn in_light(around: Environment) -> Self {
        let folder = Folder::new();
        let mut scene = corner();
        folder.write("scene.glb", &gltf::to_glb(&scene).unwrap());
        let radiance = photograph(&mut scene, around);
        let codes = radiance.map(|rgb| rgb.map(srgb_from_linear));
        picture::write_png_codes(&folder.path("photo.png"), &codes, Depth::Sixteen).unwrap();
        folder.write("project.toml", &format!("{HEAD}{LIGHTS}"));
        Self(folder)
    }

    fn read(&self, name: &str) -> RgbImage {
        picture::read(&self.path(name)).unwrap().0.values
    }

    /// The command with `arguments`, in this folder.
    fn run(&self, arguments: &[&str]) -> Output {
        self.0.run(&[&["--quiet"], arguments].concat())
    }

    /// Its messages on stderr when it succeeds.
    #[track_caller]
    fn succeeds(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        succeeds(&output);
        stderr(&output)
    }

    /// Recovers the project with little effort and these `flags`, into `out`.
    #[track_caller]
    fn drafts(&self, flags: &[&str]) {
        let recover = ["recover", "project.toml", "--effort", "draft", "--out", "out"];
        self.succeeds(&[&recover[..], flags].concat());
    }

    /// Asserts that `check` refuses a project with the lines `text` because of `problem`.
    #[track_caller]
    fn refuses(&self, text: &str, problem: &str) {
        self.write("bad.toml", &format!("{HEAD}{text}"));
        fails(&self.run(&["check", "bad.toml"]), problem);
    }
}

fn corner() -> Scene {
    let mut scene = Scene::default();
    let (x, y, z) = (3.0 * Vec3::X, 2.0 * Vec3::Y, 3.0 * Vec3::Z);
    let low = Vec3::new(-1.5, 0.0, -1.5);
    for (name, rho_d, a, b, c) in [("floor", FLOOR, low + z, x, -z), ("wall", WALL, low, x, y)] {
        add(&mut scene, name, rho_d, quad(a, b, c));
    }
    let (eye, target) = (Vec3::new(0.3, 1.3, 2.6), Vec3::new(0.0, 0.5, -0.5));
    let camera = Camera::look_at("photo", eye, target, Vec3::Y, 0.8);
    scene.cameras.push(Camera { aspect: Some(48.0 / 36.0), ..camera });
    scene
}

/// Adds the bulb and the environment `around` to `scene`, and photographs it.
fn photograph(scene: &mut Scene, around: Environment) -> RgbImage {
    scene.environment = Some(around);
    add(scene, "bulb", Rgb::ZERO, Mesh::sphere(BULB.0, BULB.1));
    scene.groups.last_mut().unwrap().emission = Rgb::splat(4.0);
    scene.validate().unwrap();
    let settings = Settings { spp: 256, seed: 5, ..Settings::default() };
    let tracer = Tracer::new(scene);
    tracer.render(&scene.materials(), &scene.cameras[0], SIZE, &settings, &|_| ()).mean
}

/// The mean over the pixels of the largest difference of a channel.
fn difference(a: &RgbImage, b: &RgbImage) -> f32 {
    let pairs = a.pixels().iter().zip(b.pixels());
    let sum: f32 = pairs.map(|(a, b)| (*a - *b).abs().max_element()).sum();
    sum / a.pixels().len() as f32
}
