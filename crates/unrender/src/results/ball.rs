//! A ball of every group's material under one fixed light, which shows what the parameters look
//! like.
//!
//! The light is a panorama made for this purpose: a large window on the left, a narrow one on the
//! right, a grey room above and a darker floor. Balls are brushed along their circles of latitude. A
//! textured group is shown with its mean.

use super::report_folder;
use crate::engine::Recovered;
use crate::{Error, Job};
use glam::{Vec3, Vec4};
use std::f32::consts::{PI, TAU};
use std::path::Path;
use unrender_formats::picture;
use unrender_recover::Effort;
use unrender_render::{Settings, Tracer};
use unrender_scene::{Camera, Environment, Group, Material, Mesh, Object, Rgb, RgbImage, Scene};

/// Pixels in a row and in a column.
const SIZE: usize = 96;
/// Paths per pixel: of a draft, whose balls show grain, and of other recoveries. With the latter
/// the balls of 13 groups take a quarter of a draft's time; half and double of either were not
/// tried.
const SPP: [u32; 2] = [16, 64];
/// Facets around the ball, and half as many from pole to pole.
const FACETS: u32 = 96;
/// The camera's distance from the centre, radii.
const DISTANCE: f32 = 8.0;

/// Renders a ball for each group that reflects something; returns the names of the files in
/// `folder`, in the order of the groups.
pub(super) fn write(
    job: &Job,
    recovered: &Recovered,
    folder: &Path,
) -> Result<Vec<Option<String>>, Error> {
    let recovery = &recovered.recovery;
    let material = Material::diffuse(Rgb::ZERO);
    let group = Group { name: "ball".to_owned(), material, emission: Rgb::ZERO };
    let object = Object { name: "ball".to_owned(), group: 0, mesh: sphere() };
    let scene = Scene {
        objects: vec![object],
        groups: vec![group],
        environment: Environment::new(panorama(), 0.0).ok(),
        brdf: job.scene.brdf,
        ..Scene::default()
    };
    let tracer = Tracer::new(&scene);
    // The ball's outline touches the picture's edges.
    let fov_y_rad = 2.0 * (1.0 / DISTANCE).asin();
    let camera = Camera::look_at("ball", DISTANCE * Vec3::Z, Vec3::ZERO, Vec3::Y, fov_y_rad);
    let [of_draft, usual] = SPP;
    let spp = if recovered.options.effort == Effort::Draft { of_draft } else { usual };
    let settings = Settings { spp, ..Settings::default() };
    let mut files = Vec::new();
    for (index, group) in recovery.groups.iter().enumerate() {
        let material = Material { texture: None, ..group.material.clone() };
        if (material.rho_d + material.rho_s).max_element() <= 0.0 {
            files.push(None);
            continue;
        }
        let film = tracer.render(&[material][..], &camera, (SIZE, SIZE), &settings, &|_| {});
        let file = report_folder(&format!("ball_{index}.png"));
        picture::write_png_srgb(&folder.join(&file), &film.mean)?;
        files.push(Some(file));
    }
    Ok(files)
}

/// The light of all balls.
fn panorama() -> RgbImage {
    RgbImage::from_fn(128, 64, |x, y| {
        let (u, v) = ((x as f32 + 0.5) / 128.0, (y as f32 + 0.5) / 64.0);
        let inside = |left: f32, right: f32, top: f32, bottom: f32| {
            (left..right).contains(&u) && (top..bottom).contains(&v)
        };
        // The middle of the panorama lies behind the ball, its edges behind the camera.
        if inside(0.04, 0.20, 0.14, 0.40) {
            Rgb::splat(5.0)
        } else if inside(0.76, 0.79, 0.25, 0.55) {
            Rgb::splat(4.0)
        } else if v < 0.5 {
            Rgb::splat(0.25 + 0.3 * (0.5 - v))
        } else {
            Rgb::splat(0.10)
        }
    })
}

/// A ball of radius one about the origin, its tangents along the circles of latitude.
fn sphere() -> Mesh {
    let mut mesh = Mesh::default();
    let rows = FACETS / 2;
    for row in 0..=rows {
        let (ring, y) = (PI * row as f32 / rows as f32).sin_cos();
        for column in 0..=FACETS {
            let (sin, cos) = (TAU * column as f32 / FACETS as f32).sin_cos();
            mesh.positions.push(Vec3::new(ring * sin, y, ring * cos));
            mesh.tangents.push(Vec4::new(cos, 0.0, -sin, 1.0));
        }
    }
    mesh.normals.clone_from(&mesh.positions);
    for row in 0..rows {
        for column in 0..FACETS {
            let a = row * (FACETS + 1) + column;
            let b = a + FACETS + 1;
            mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    mesh
}
