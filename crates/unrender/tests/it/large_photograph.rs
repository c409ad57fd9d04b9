//! A photograph of more than a megapixel is reduced to squares of its pixels; its textures are made from the pixels
//! themselves.

use crate::kit::example::shrunk;
use crate::kit::floor_and_lamp;
use crate::kit::folder::{Folder, succeeds};
use crate::kit::meshes::{add, quad, square};
use glam::{Vec2, Vec3};
use serde_json::Value;
use std::sync::Arc;
use unrender::formats::picture::{self, Depth};
use unrender::formats::{Input, Limits, gltf};
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Lens, Material, Mesh, Rgb, RgbImage, Scene, Texture, Wrap};

/// Neither side is a whole number of squares.
const SIZE: (usize, usize) = (1251, 903);
const WALL: Rgb = Rgb::new(0.3, 0.4, 0.5);
/// Texels along a side of the floor: about a pixel and a half each.
const TEXELS: usize = 256;

/// The pattern of the floor: light and dark texels at random.
fn pattern() -> RgbImage {
    RgbImage::from_fn(TEXELS, TEXELS, |x, y| {
        let hash = ((x as u32).wrapping_mul(73_856_093) ^ (y as u32).wrapping_mul(19_349_663))
            .wrapping_mul(2_654_435_761);
        Rgb::splat(if hash >> 31 == 0 { 0.7 } else { 0.3 })
    })
}

/// A floor with that pattern, a wall and a lamp, and a camera whose axis is not in the middle of its picture.
fn scene() -> Scene {
    let mut scene = Scene::default();
    let floor = quad(Vec3::new(-0.5, 0.0, 0.5), Vec3::X, -Vec3::Z);
    let uvs = vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::ZERO, Vec2::ONE, Vec2::Y];
    add(&mut scene, "floor", Rgb::splat(0.5), Mesh { uvs, ..floor });
    add(&mut scene, "wall", WALL, quad(Vec3::new(-1.0, 0.0, -1.0), 2.0 * Vec3::X, 1.5 * Vec3::Y));
    add(&mut scene, "lamp", Rgb::ZERO, square(2.0 * Vec3::Y, Vec3::NEG_Y, 0.3));
    scene.groups[2].emission = Rgb::splat(8.0);
    let camera = Camera::look_at("camera", Vec3::new(0.2, 1.6, 1.9), Vec3::ZERO, Vec3::Y, 0.9);
    let lens = Lens { principal_point: [0.02, -0.01], ..Lens::default() };
    scene.cameras.push(Camera { lens, ..camera });
    scene
}

/// A folder with the scene and its photograph.
fn project() -> Folder {
    let folder = Folder::new();
    let mut truth = scene();
    let texture = Texture { image: pattern(), wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
    truth.groups[0].material =
        Material { texture: Some(Arc::new(texture)), ..Material::diffuse(Rgb::splat(0.5)) };
    truth.validate().unwrap();
    let settings = Settings { spp: 6, seed: 5, ..Settings::default() };
    let tracer = Tracer::new(&truth);
    let photo = tracer.render(&truth.materials(), &truth.cameras[0], SIZE, &settings, &|_| ()).mean;
    picture::write_png_codes(&folder.path("photo.png"), &photo, Depth::Sixteen).unwrap();
    folder.write("scene.glb", &gltf::to_glb(&scene()).unwrap());
    folder.write(
        "project.toml",
        "scene = \"scene.glb\"\nphoto = \"photo.png\"\nresponse = \"linear\"\nexposure = 1\n\
         [camera]\neye = [0.2, 1.6, 1.9]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\n\
         fov_y_deg = 51.56620156\nprincipal_point = [0.02, -0.01]\n\
         [groups.floor]\nrungs = [\"textured\"]\n",
    );
    folder
}

/// The correlation of a texture with the pattern, where the floor is seen: in its middle.
fn correlation(found: &RgbImage) -> f64 {
    let texture = Texture { image: found.clone(), wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
    let truth = pattern();
    let middle = TEXELS / 4..3 * TEXELS / 4;
    let texels = middle.clone().flat_map(|y| middle.clone().map(move |x| (x, y)));
    let pairs = texels.map(|(x, y)| {
        let uv = (Vec2::new(x as f32, y as f32) + 0.5) / TEXELS as f32;
        [texture.sample(uv).y, truth.at(x, y).y].map(f64::from)
    });
    let pairs: Vec<[f64; 2]> = pairs.collect();
    let mean = |f: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(f).sum::<f64>() / pairs.len() as f64;
    let [a, b] = [mean(&|p| p[0]), mean(&|p| p[1])];
    let product = mean(&|p| (p[0] - a) * (p[1] - b));
    product / (mean(&|p| (p[0] - a).powi(2)) * mean(&|p| (p[1] - b).powi(2))).sqrt()
}

fn read(folder: &Folder, name: &str) -> RgbImage {
    picture::read(Input::new(&folder.path(name), Limits::default())).unwrap().0.values
}

#[test]
fn it_is_worked_on_in_squares_and_its_textures_keep_its_pixels() {
    let folder = project();
    let recover = [
        "recover",
        "project.toml",
        "--effort",
        "draft",
        "--keep-camera",
        "--no-refine",
        "--spp",
        "1",
    ];
    let with = |more: &[&str]| succeeds(&folder.run(&[&recover[..], more].concat()));
    with(&["--out", "out", "--picture", "full"]);
    let run: Value = serde_json::from_str(&folder.text("out/run.json")).unwrap();
    let input = &run["input"];
    assert_eq!((&input["width"], &input["side"]), (&Value::from(SIZE.0), &Value::from(2)));
    let principal = run["registration"]["camera"]["principal_point"].as_array().unwrap();
    let off = principal.iter().zip([0.02, -0.01]).map(|(at, given)| at.as_f64().unwrap() - given);
    assert!(off.map(f64::abs).fold(0.0, f64::max) < 1e-5, "{principal:?}");
    let rho_d = run["groups"]["wall"]["rho_d"].as_array().unwrap();
    let off = rho_d
        .iter()
        .zip(WALL.to_array())
        .map(|(rho, truth)| rho.as_f64().unwrap() - f64::from(truth));
    let off = off.map(f64::abs).fold(0.0, f64::max);
    let texture = run["groups"]["floor"]["texture"].as_str().unwrap();
    let texture = read(&folder, &format!("out/{texture}"));
    // A square is four texels wide.
    let [fine, coarse] = [&texture, &shrunk(&texture, 4)].map(correlation);
    println!("{off} {fine} {coarse} {} x {}", texture.width(), texture.height());
    assert!(off < 0.001, "{off}");
    assert!(fine > 0.8 && fine > coarse + 0.1, "{fine}, in squares {coarse}");
    let size = |picture: RgbImage| (picture.width(), picture.height());
    assert_eq!(size(read(&folder, "out/rerendered.exr")), SIZE);
    assert_eq!(size(read(&folder, "out/photo.png")), SIZE);
    assert_eq!(size(read(&folder, "out/trust.png")), (SIZE.0 / 2, SIZE.1 / 2));
}

#[test]
fn the_memory_of_whoever_starts_a_recovery_is_not_counted_as_its_own() {
    const HELD: usize = 400 << 20;
    // It is written to, so that its memory is really allocated.
    let held = vec![1u8; HELD];
    let folder = floor_and_lamp::project();
    succeeds(&folder.run(&["recover", "p.toml", "--no-refine", "--spp", "1", "--out", "out"]));
    assert!(held.iter().all(|byte| *byte == 1));
    let run: Value = serde_json::from_str(&folder.text("out/run.json")).unwrap();
    let peak = run["peak_memory_bytes"].as_u64();
    // A recovery needs some tens of megabytes; some systems do not report it.
    assert!(peak.is_none_or(|peak| peak < HELD as u64 / 2), "{peak:?}");
}
