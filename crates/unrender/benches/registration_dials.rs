//! Recovers the room when photograph and model do not quite fit:
//! `cargo bench -p unrender --bench registration_dials [-- WORDS]`.
//!
//! Turns the camera of `examples/room` by some pixels, compresses the photograph, adds noise, or
//! hangs something on the wall that the model lacks; recovers with the built command, with and
//! without the registration, and prints the largest errors against the truth. WORDS choose the rows
//! that contain all of them. Nothing is asserted; all rows take half an hour.

use glam::{Affine3A, Quat, Vec2, Vec3};
use image::codecs::jpeg::JpegEncoder;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use unrender::formats::materials::Hypothesis;
use unrender::formats::{self, materials, picture};
use unrender::project::CameraTable;
use unrender::render::sampler::mix;
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Group, Material, Mesh, Object, Rgb, RgbImage, Scene};
use unrender::score;

/// As in `make_room`.
const EXPOSURE: f32 = 0.65;
const SPP: u32 = 512;
const JPEG_QUALITY: u8 = 85;
/// Standard deviation of the added noise at middle grey, relative to it.
const NOISE: f32 = 0.03;
const GREY: f32 = 0.18;
/// Which way the model's picture moves, pixels to the right and down.
const DIRECTION: Vec2 = Vec2::new(0.8, 0.6);

/// One disturbance, or several.
#[derive(Clone, Copy, Default)]
struct Dial {
    name: &'static str,
    pixels: f32,
    jpeg: bool,
    noise: bool,
    unmodelled: bool,
}

const DIALS: [Dial; 7] = {
    let none = Dial { name: "as it is", pixels: 0.0, jpeg: false, noise: false, unmodelled: false };
    [
        none,
        Dial { name: "displaced by 1 px", pixels: 1.0, ..none },
        Dial { name: "displaced by 2 px", pixels: 2.0, ..none },
        Dial { name: "displaced by 3 px", pixels: 3.0, ..none },
        Dial { name: "JPEG, quality 85", jpeg: true, ..none },
        Dial { name: "a box on the wall, unmodelled", unmodelled: true, ..none },
        Dial {
            name: "all: 3 px, JPEG, noise, box",
            pixels: 3.0,
            jpeg: true,
            noise: true,
            unmodelled: true,
        },
    ]
};

/// The ways to recover, with their flags.
const WAYS: [(&str, &[&str]); 3] =
    [("no filter", &["--no-filter"]), ("keep camera", &["--keep-camera"]), ("default", &[])];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if !arguments.iter().any(|argument| argument == "--bench") {
        println!("skipped: this takes an hour; run it by `cargo bench`");
        return Ok(());
    }
    let words: Vec<&String> = arguments.iter().filter(|a| !a.starts_with("--")).collect();
    let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/room");
    let folder = tempfile::tempdir()?;
    println!("| photograph and model | | hypotheses | rho_d | rho_s | rho_d, no texture |");
    println!("|---|---|---|---|---|---|");
    for dial in DIALS {
        let ways = WAYS.iter().filter(|(way, _)| {
            let row = format!("{} {way}", dial.name);
            words.iter().all(|word| row.contains(word.as_str()))
        });
        for (way, flags) in ways {
            let project = prepare(&dial, &room, folder.path())?;
            let row = recover(&project, flags, &room, &folder.path().join("out"))?;
            println!("| {} | {way} | {row} |", dial.name);
        }
    }
    Ok(folder.close()?)
}

/// Writes photograph and project of `dial`; returns the project's path.
fn prepare(dial: &Dial, room: &Path, folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let scene = formats::load_scene(&room.join("scene.glb"))?.0;
    let (camera, origin) = (scene.cameras[0].clone(), scene.origin);
    let mut values = if dial.unmodelled {
        with_box(scene, room)?
    } else {
        picture::read(&room.join("photo.png"))?.0.values.map(|code| linear(*code))
    };
    if dial.noise {
        values = noisy(&values);
    }
    let photo = folder.join(if dial.jpeg { "photo.jpg" } else { "photo.png" });
    if dial.jpeg {
        write_jpeg(&values, &photo)?;
    } else {
        picture::write_png_srgb(&photo, &values)?;
    }
    let table = CameraTable::of(&turned(&camera, dial.pixels, values.height()), 3.0, origin);
    let project = std::fs::read_to_string(room.join("room.toml"))?
        .replace("\"scene.glb\"", &format!("{:?}", room.join("scene.glb")))
        .replace("\"photo.png\"", &format!("{photo:?}"));
    let path = folder.join("project.toml");
    std::fs::write(&path, table.put_into(&project, &path, "turned")?)?;
    Ok(path)
}

fn linear(code: Rgb) -> Rgb {
    code.map(unrender::scene::color::linear_from_srgb)
}

/// The room with a red box of half a metre on its green wall, through the room's own camera.
fn with_box(mut scene: Scene, room: &Path) -> Result<RgbImage, Box<dyn Error>> {
    materials::apply_from(&room.join("truth.json"), &mut scene)?;
    let (left, right) = (Vec3::new(0.15, 1.75, -1.97), Vec3::new(0.65, 2.15, -1.97));
    let (x, y) = (Vec3::new(right.x, left.y, left.z), Vec3::new(left.x, right.y, left.z));
    let mesh = Mesh {
        positions: vec![left, x, right, y],
        normals: vec![Vec3::Z; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let group = scene.groups.len();
    let material = Material::diffuse(Rgb::new(0.5, 0.08, 0.06));
    scene.groups.push(Group { name: "box".to_owned(), material, emission: Rgb::ZERO });
    scene.objects.push(Object { name: "box".to_owned(), group, mesh });
    scene.validate()?;
    let settings = Settings { spp: SPP, seed: 11, ..Settings::default() };
    let photo = picture::read(&room.join("photo.png"))?.0.values;
    let size = (photo.width(), photo.height());
    let film =
        Tracer::new(&scene).render(&scene.materials(), &scene.cameras[0], size, &settings, &|_| ());
    Ok(film.mean.map(|radiance| *radiance / EXPOSURE))
}

/// `camera` turned so that the middle of its picture, of `height` rows, moves by `pixels`.
fn turned(camera: &Camera, pixels: f32, height: usize) -> Camera {
    let focal = 0.5 * height as f32 / (0.5 * camera.fov_y_rad).tan();
    let by = DIRECTION * (pixels / focal).atan();
    let turn = Quat::from_scaled_axis(Vec3::new(by.y, by.x, 0.0));
    let world_from_camera = camera.world_from_camera * Affine3A::from_quat(turn);
    Camera { world_from_camera, ..camera.clone() }
}

fn noisy(values: &RgbImage) -> RgbImage {
    let uniform = |key: u64| ((mix(key) >> 40) as f32 + 0.5) / (1u64 << 24) as f32;
    // The sum of twelve uniform numbers is close enough to normal here.
    let normal = |key: u64| (0..12).map(|i| uniform(12 * key + i)).sum::<f32>() - 6.0;
    let mut index = 0;
    values.map(|value| {
        index += 3;
        let sigma = |channel: usize| NOISE * (GREY * value[channel].max(0.0)).sqrt();
        let noise = |channel: usize| sigma(channel) * normal(index + channel as u64);
        *value + Rgb::new(noise(0), noise(1), noise(2))
    })
}

fn write_jpeg(values: &RgbImage, path: &Path) -> Result<(), Box<dyn Error>> {
    let code = |v: f32| {
        (255.0 * unrender::scene::color::srgb_from_linear(v.clamp(0.0, 1.0))).round() as u8
    };
    let codes: Vec<u8> = values.pixels().iter().flat_map(|v| v.to_array().map(code)).collect();
    let (width, height) = (values.width() as u32, values.height() as u32);
    let file = std::fs::File::create(path)?;
    let encoder = JpegEncoder::new_with_quality(file, JPEG_QUALITY);
    Ok(image::ImageEncoder::write_image(
        encoder,
        &codes,
        width,
        height,
        image::ExtendedColorType::Rgb8,
    )?)
}

/// Recovers `project` and compares with the truth: the rest of a row.
fn recover(
    project: &Path,
    flags: &[&str],
    room: &Path,
    out: &Path,
) -> Result<String, Box<dyn Error>> {
    let status = Command::new(env!("CARGO_BIN_EXE_unrender"))
        .args(["recover", "--quiet", "--no-refine", "--out"])
        .args([out, project])
        .args(flags)
        .stderr(std::process::Stdio::null())
        .status()?;
    if !status.success() {
        return Err(format!("recover {flags:?} ended with {status}").into());
    }
    let found = materials::read(&out.join("materials.json"))?;
    let truth = materials::read(&room.join("truth.json"))?;
    let scores = score::score(&found, out, &truth, room)?;
    let worst = score::worst(&scores);
    let uniform: Vec<_> =
        scores.into_iter().filter(|s| s.true_hypothesis != Some(Hypothesis::Textured)).collect();
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.4}"));
    Ok(format!(
        "{} of {} | {} | {} | {}",
        worst.hypotheses_right,
        worst.counted,
        number(worst.rho_d),
        number(worst.rho_s),
        number(score::worst(&uniform).rho_d)
    ))
}
