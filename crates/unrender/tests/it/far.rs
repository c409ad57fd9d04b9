//! Projects of scenes far from the origin give the same picture as near it, with a camera that is stated,
//! calibrated by another program, or found from points.

use crate::kit::folder::{Folder, succeeds};
use crate::kit::meshes::{add, cuboid, quad};
use glam::{DVec3, Vec3};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use unrender::formats::{gltf, picture};
use unrender::photo::Exposure;
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Image, Rgb, RgbImage, Scene};
use unrender::{Job, Project};

const SIZE: (usize, usize) = (48, 36);
const EYE: DVec3 = DVec3::new(0.25, 1.25, 3.5);
const FOCAL: f64 = 50.0;

/// One, twenty and 500 kilometres away, and at coordinates of land registers.
const PLACES: [DVec3; 4] = [
    DVec3::new(1_000.0, 0.0, 0.0),
    DVec3::new(-12_000.0, 300.0, 16_000.0),
    DVec3::new(0.0, 0.0, -500_000.0),
    DVec3::new(500_000.0, 150.0, 5_400_000.0),
];

/// A lit room about `origin`.
fn room(origin: DVec3) -> Scene {
    let mut scene = Scene { origin, ..Scene::default() };
    let (x, y, z) = (4.0 * Vec3::X, 2.5 * Vec3::Y, 4.0 * Vec3::Z);
    let low = Vec3::new(-2.0, 0.0, -2.0);
    add(&mut scene, "floor", Rgb::new(0.5, 0.4, 0.3), quad(low + z, x, -z));
    add(&mut scene, "back", Rgb::splat(0.7), quad(low, x, y));
    add(&mut scene, "left", Rgb::new(0.6, 0.2, 0.2), quad(low + z, -z, y));
    add(&mut scene, "right", Rgb::new(0.2, 0.6, 0.2), quad(low + x, z, y));
    add(&mut scene, "ceiling", Rgb::splat(0.7), quad(low + y, x, z));
    let box_low = Vec3::new(-0.5, 0.0, -1.0);
    add(&mut scene, "box", Rgb::splat(0.5), cuboid(box_low, box_low + 0.8));
    add(&mut scene, "lamp", Rgb::ZERO, quad(Vec3::new(-0.5, 2.4, -0.5), Vec3::X, Vec3::Z));
    scene.groups[6].emission = Rgb::splat(9.0);
    scene
}

/// The three ways to state where the camera stood; it looks along -z.
fn cameras(at: DVec3) -> [String; 3] {
    let DVec3 { x, y, z } = at + EYE;
    let stated = format!(
        "[camera]\neye = [{x:?}, {y:?}, {z:?}]\ntarget = [{x:?}, {y:?}, {:?}]\nfx = {FOCAL:?}\nfy = {FOCAL:?}\n\
         cx = 24.0\ncy = 18.0\n",
        z - 1.0
    );
    [stated, "[camera]\nopencv = \"camera.yml\"\n".into(), "[camera]\ncolmap = \"sparse\"\n".into()]
}

/// A folder with the room there, and the files of OpenCV and COLMAP for its camera.
fn folder(at: DVec3) -> Folder {
    let folder = Folder::new();
    folder.write("s.glb", &gltf::to_glb(&room(at)).unwrap());
    let grey = Image::from_fn(SIZE.0, SIZE.1, |_, _| Rgb::splat(0.5));
    picture::write(&folder.path("p.png"), &grey).unwrap();
    // R is half a turn about x, so t = -R eye.
    let DVec3 { x, y, z } = DVec3::new(-1.0, 1.0, 1.0) * (at + EYE);
    let opencv = format!(
        "%YAML:1.0\n---\nimage_width: 48\nimage_height: 36\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   \
         cols: 3\n   dt: d\n   data: [ {FOCAL:?}, 0., 23.5, 0., {FOCAL:?}, 17.5, 0., 0., 1. ]\n\
         R: [ [1, 0, 0], [0, -1, 0], [0, 0, -1] ]\ntvec: [ {x:?}, {y:?}, {z:?} ]\n"
    );
    folder.write("camera.yml", &opencv);
    std::fs::create_dir(folder.path("sparse")).unwrap();
    folder.write("sparse/cameras.txt", &format!("1 PINHOLE 48 36 {FOCAL:?} {FOCAL:?} 24 18\n"));
    folder.write("sparse/images.txt", &format!("1 0 1 0 0 {x:?} {y:?} {z:?} 1 p.png\n\n"));
    folder
}

fn job(folder: &Folder, camera: &str) -> Job {
    let text = format!("scene = \"s.glb\"\nphoto = \"p.png\"\nexposure = 1\n{camera}");
    let path = folder.write("a.toml", &text);
    let (project, warnings) = Project::read(&path).unwrap();
    Job::load(project, warnings).unwrap()
}

fn picture_of(scene: &Scene, camera: &Camera) -> RgbImage {
    let settings = Settings { spp: 64, seed: 3, ..Settings::default() };
    let tracer = Tracer::new(scene);
    tracer.render(&scene.materials(), camera, SIZE, &settings, &|_| ()).mean
}

fn mean(picture: &RgbImage) -> f32 {
    let sum: Rgb = picture.pixels().iter().sum();
    sum.element_sum() / picture.pixels().len() as f32
}

#[test]
fn a_room_far_away_has_the_picture_of_one_near_zero() {
    let near = folder(DVec3::ZERO);
    let near = job(&near, &cameras(DVec3::ZERO)[0]);
    let wanted = picture_of(&near.scene, &near.camera);
    assert!(mean(&wanted) > 0.1);
    for at in PLACES {
        let folder = folder(at);
        for camera in cameras(at) {
            let job = job(&folder, &camera);
            let eye = job.scene.in_world(job.camera.origin());
            assert!(eye.distance(at + EYE) < 1e-6, "{camera}: {eye}");
            assert!((job.camera.fov_y_rad - near.camera.fov_y_rad).abs() < 1e-6);
            let picture = picture_of(&job.scene, &job.camera);
            let share = mean(&picture) / mean(&wanted);
            assert!((share - 1.0).abs() < 2e-3, "{share} at {at} by {camera}");
        }
    }
}

/// Each group's rho_d, recovered from `photograph` of the room there.
fn recovered(at: DVec3, photograph: &RgbImage) -> BTreeMap<String, [f64; 3]> {
    let folder = folder(at);
    picture::write_exr(&folder.path("p.exr"), photograph).unwrap();
    let text = format!(
        "scene = \"s.glb\"\nphoto = \"p.exr\"\nresponse = \"linear\"\nexposure = 1\n{}",
        cameras(at)[0]
    );
    folder.write("a.toml", &text);
    let flags = ["--effort", "draft", "--quiet", "--spp", "2"];
    succeeds(&folder.run(&[&["recover", "a.toml", "--out", "out"], &flags[..]].concat()));
    let materials = std::fs::read_to_string(folder.path("out/materials.json")).unwrap();
    let materials: Value = serde_json::from_str(&materials).unwrap();
    let groups = materials["groups"].as_object().unwrap().iter();
    let asked = groups.filter(|(_, group)| group["status"] != "known");
    let rho_d = |group: &Value| [0, 1, 2].map(|channel| group["rho_d"][channel].as_f64().unwrap());
    asked.map(|(name, group)| (name.clone(), rho_d(group))).collect()
}

#[test]
fn what_is_recovered_far_away_is_what_is_recovered_near_zero() {
    let scene = room(DVec3::ZERO);
    let near = job(&folder(DVec3::ZERO), &cameras(DVec3::ZERO)[0]);
    let photograph = picture_of(&near.scene, &near.camera);
    let wanted = recovered(DVec3::ZERO, &photograph);
    assert_eq!(wanted.len(), 6);
    for group in scene.groups.iter().filter(|group| wanted.contains_key(&group.name)) {
        let off = distance(group.material.rho_d.to_array().map(f64::from), wanted[&group.name]);
        assert!(off < 0.005, "{off} of {}", group.name);
    }
    for at in [PLACES[1], PLACES[3]] {
        for (name, rho_d) in recovered(at, &photograph) {
            let off = distance(rho_d, wanted[&name]);
            assert!(off < 0.0003, "{name} at {at}: {rho_d:?}, {:?}", wanted[&name]);
        }
    }
}

/// The largest difference of a channel.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_camera_far_away_is_found_and_written_where_it_stood() {
    let near = job(&folder(DVec3::ZERO), &cameras(DVec3::ZERO)[0]);
    for at in [DVec3::ZERO, PLACES[3]] {
        let folder = folder(at);
        let mut points = String::from("x_px,y_px,x_m,y_m,z_m\n");
        for n in 0..12 {
            let (u, v, w) = (f64::from(n % 3), f64::from(n / 3 % 2), f64::from(n / 6));
            let place = DVec3::new(0.75 * u - 0.5, 0.5 + v, 0.75 * w - 1.5);
            let (x, y) = near.camera.project(place.as_vec3(), SIZE.0, SIZE.1).unwrap();
            let world = at + place;
            writeln!(points, "{x},{y},{},{},{}", world.x, world.y, world.z).unwrap();
        }
        folder.write("points.csv", &points);
        for out in ["b.toml", "b.glb"] {
            let arguments =
                ["calibrate", "p.png", "--scene", "s.glb", "--points", "points.csv", "--out", out];
            succeeds(&folder.run(&arguments));
        }
        let (mut project, warnings) = Project::read(&folder.path("b.toml")).unwrap();
        project.exposure = Exposure::Fixed(Rgb::ONE);
        let job = Job::load(project, warnings).unwrap();
        let eye = job.scene.in_world(job.camera.origin());
        assert!(eye.distance(at + EYE) < 0.01, "{eye}");
        let (placed, _) = unrender::formats::load_scene(&folder.path("b.glb")).unwrap();
        assert!(placed.in_world(placed.cameras[0].origin()).distance(eye) < 1e-5);
    }
}
