//! A synthetic photograph of a wall with ten dark rectangles that the model lacks.
//!
//! A diffuse wall under a point light has radiance rho / pi * I cos / r^2. The photograph is that,
//! with another rho in the rectangles, times Gaussian noise; the model is the plain wall.

use super::{Bench, Outcome, group, hypothesis, three};
use crate::Failure;
use crate::table::Table;
use glam::Vec3;
use std::f64::consts::{PI, TAU};
use std::path::Path;
use unrender::formats::{atomic, gltf, picture};
use unrender::scene::{Camera, Group, Image, Light, LightKind, Material, Mesh, Object, Rgb, Scene};

/// The photograph, pixels.
const WIDTH: usize = 200;
const HEIGHT: usize = 150;
/// The wall's reflectance.
const RHO: f64 = 0.8;
/// The rectangles' reflectances go from the first to the last in equal steps; their mean is 0.2.
const DARKEST: f64 = 0.05;
const BRIGHTEST: f64 = 0.35;
/// Their sides, pixels: ten times 29 x 15 of 200 x 150 is 14.5 %.
const SIDES: [usize; 2] = [29, 15];
/// The noise's standard deviation as a share of the pixel.
const NOISE: f64 = 0.01;
/// Metres per pixel of the wall, which is the plane z = 0 with its centre at the origin.
const PITCH: f32 = 0.01;
/// The camera's distance, metres.
const DISTANCE: f32 = 2.5;
/// The place of the lamp, metres, and its radiant intensity.
const LAMP: Vec3 = Vec3::new(0.4, 0.6, 1.8);
const INTENSITY: f32 = 8.0;
/// The largest allowed error of the reflectance.
const ASKED: f64 = 0.02;

const INTRODUCTION: &str = "## A wall with dark rectangles

Synthetic, in closed form: a diffuse wall of reflectance 0.8 under a point light, 200 x 150 pixels, 1 %
noise. Ten rectangles of reflectance 0.05 to 0.35 on 14.5 % of it are in the photograph and not in the
model. Textures are switched off (`thresholds = { textured = 1e9 }`).
";

/// Writes the project, recovers and scores.
///
/// # Errors
/// If the recovery fails.
pub(super) fn measure(bench: &Bench) -> Result<Option<Outcome>, Failure> {
    let folder = bench.folder("")?;
    let photograph = photograph();
    write(&folder, &photograph)?;
    if bench.command().is_none() {
        return Ok(None);
    }
    let file = bench.recover(&folder.join("project.toml"), &folder.join("result"))?;
    let entry = group(&file, "wall")?;
    let rho_d = entry.rho_d.ok_or("the wall has no rho_d")?;
    let mean = rho_d.iter().map(|value| f64::from(*value)).sum::<f64>() / 3.0;
    let plain = least_squares(&photograph);
    let mut table = Table::new(["hypothesis", "rho_d", "truth", "equal-weight least squares"]);
    let truth = format!("{RHO}");
    table.push([hypothesis(entry), three(entry.rho_d, 4), truth, format!("{plain:.4}")]);
    let line = format!(
        "wall: {mean:.4}, {:.4} from {RHO} (asked {ASKED}), least squares {plain:.4}",
        (mean - RHO).abs()
    );
    Ok(Some(Outcome { text: format!("{INTRODUCTION}\n{}\n`{line}`\n", table.text()), line }))
}

/// The radiance of a white diffuse wall at the centre of a pixel.
fn white(x: usize, y: usize) -> f64 {
    let across = PITCH * (x as f32 + 0.5 - 0.5 * WIDTH as f32);
    let up = PITCH * (0.5 * HEIGHT as f32 - y as f32 - 0.5);
    let way = LAMP - Vec3::new(across, up, 0.0);
    let square = f64::from(way.length_squared());
    f64::from(INTENSITY) * f64::from(way.z) / square.sqrt() / square / PI
}

/// The reflectance in a pixel of the photograph.
fn painted(x: usize, y: usize) -> f64 {
    for index in 0..10 {
        // Five columns and two rows; odd columns are 11 pixels lower.
        let (column, row) = (index % 5, index / 5);
        let (left, top) = (6 + 40 * column, 20 + 70 * row + 11 * (column % 2));
        if (left..left + SIDES[0]).contains(&x) && (top..top + SIDES[1]).contains(&y) {
            return DARKEST + (BRIGHTEST - DARKEST) * index as f64 / 9.0;
        }
    }
    RHO
}

/// The wall with its rectangles and noise, the same in every run.
fn photograph() -> Image<Rgb> {
    let mut state = 1_u64;
    Image::from_fn(WIDTH, HEIGHT, |x, y| {
        let radiance = painted(x, y) * white(x, y);
        let noise: [f64; 3] = std::array::from_fn(|_| 1.0 + NOISE * gaussian(&mut state));
        Rgb::from_array(noise.map(|noise| (radiance * noise) as f32))
    })
}

/// A standard normal number (Box and Muller 1958).
fn gaussian(state: &mut u64) -> f64 {
    let (a, b) = (uniform(state), uniform(state));
    (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos()
}

/// A number from 0 to 1 (splitmix64, Steele et al. 2014).
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// The equal-weight fit of one reflectance to all pixels.
fn least_squares(photograph: &Image<Rgb>) -> f64 {
    let (mut products, mut squares) = (0.0, 0.0);
    for (index, value) in photograph.pixels().iter().enumerate() {
        let white = white(index % WIDTH, index / WIDTH);
        products += white * f64::from(value.element_sum() / 3.0);
        squares += white * white;
    }
    products / squares
}

/// Photograph, scene and project.
fn write(folder: &Path, photograph: &Image<Rgb>) -> Result<(), Failure> {
    picture::write(&folder.join("photo.exr"), photograph)?;
    atomic::write(&folder.join("scene.glb"), &gltf::to_glb(&scene())?)?;
    let project = "scene = \"scene.glb\"\nphoto = \"photo.exr\"\nresponse = \"linear\"\n\
                   exposure = 1.0\n\n[recover]\nbrdf = \"ward-gmd\"\n\
                   thresholds = { textured = 1e9 }\n";
    Ok(atomic::write(&folder.join("project.toml"), project.as_bytes())?)
}

/// The plain wall, a tenth larger than the picture on every side.
fn scene() -> Scene {
    let (x, y) = (0.6 * PITCH * WIDTH as f32, 0.6 * PITCH * HEIGHT as f32);
    let corners = [[-x, -y], [x, -y], [x, y], [-x, y]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let mesh = Mesh::flat(&corners, &[], &[[0, 1, 2], [0, 2, 3]]);
    let mut scene = Scene::default();
    let material = Material::diffuse(Rgb::splat(0.5));
    scene.groups.push(Group { name: "wall".to_owned(), material, emission: Rgb::ZERO });
    scene.objects.push(Object { name: "wall".to_owned(), group: 0, mesh });
    let kind = LightKind::Point { position: LAMP, intensity: Rgb::splat(INTENSITY) };
    scene.lights.push(Light { name: "lamp".to_owned(), kind });
    let fov = 2.0 * (0.5 * PITCH * HEIGHT as f32 / DISTANCE).atan();
    let eye = Vec3::Z * DISTANCE;
    scene.cameras.push(Camera::look_at("camera", eye, Vec3::ZERO, Vec3::Y, fov));
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender::recover::View;
    use unrender::render::{Settings, Tracer};

    #[test]
    fn the_rectangles_cover_what_they_should() {
        let pixels = (0..WIDTH * HEIGHT).map(|index| painted(index % WIDTH, index / WIDTH));
        let dark: Vec<f64> = pixels.filter(|rho| *rho < RHO).collect();
        assert_eq!(dark.len(), 4350);
        assert!((dark.iter().sum::<f64>() / 4350.0 - 0.2).abs() < 1e-9);
    }

    #[test]
    fn the_scene_is_the_wall_in_closed_form() {
        let scene = scene();
        let tracer = Tracer::new(&scene);
        let view = View::new(&tracer, &scene.cameras[0], (WIDTH, HEIGHT), scene.brdf);
        let settings = Settings { spp: 4, ..Settings::default() };
        let white_paint = [Material::diffuse(Rgb::ONE)];
        let rendered = view.render(&white_paint, &settings, &|_| {}).mean;
        for (x, y) in [(0, 0), (100, 75), (199, 149), (20, 130)] {
            let (ours, closed) = (f64::from(rendered.at(x, y).x), white(x, y));
            assert!((ours / closed - 1.0).abs() < 0.01, "{x} {y}: {ours} {closed}");
        }
    }
}
