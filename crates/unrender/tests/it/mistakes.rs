//! Everyday mistakes and ways of other programs, as whole jobs: each is done right, or told.

use crate::kit::folder::{Folder, fails, stderr, succeeds};
use crate::kit::meshes::{add, cuboid, quad};
use crate::kit::project_text::{are_refused, good, parse};
use glam::Vec3;
use std::fmt::Write as _;
use unrender::formats::{gltf, picture};
use unrender::scene::{Camera, Rgb, RgbImage, Scene, UpAxis};

/// A floor, a back wall and a block, without any light.
fn dark() -> Scene {
    let mut scene = Scene::default();
    let low = Vec3::new(-2.0, 0.0, -2.0);
    add(
        &mut scene,
        "floor",
        Rgb::splat(0.5),
        quad(low + 4.0 * Vec3::Z, 4.0 * Vec3::X, -4.0 * Vec3::Z),
    );
    add(&mut scene, "back", Rgb::splat(0.7), quad(low, 4.0 * Vec3::X, 2.5 * Vec3::Y));
    let block = Vec3::new(-0.8, 0.0, -1.0);
    add(&mut scene, "block: oak.001", Rgb::new(0.6, 0.3, 0.2), cuboid(block, block + 0.7));
    let (eye, target) = (Vec3::new(0.4, 1.4, 3.4), Vec3::new(0.0, 0.6, -1.0));
    scene.cameras.push(Camera::look_at("photo", eye, target, Vec3::Y, 0.8));
    scene
}

const SIZE: [&str; 6] = ["--width", "24", "--height", "18", "--spp", "4"];

/// Runs `restage` in `folder` into the folder `out`.
fn restage(folder: &Folder, arguments: &[&str]) -> std::process::Output {
    folder.run(&[&["restage", "--quiet"], arguments, &SIZE, &["--out", "out"]].concat())
}

/// The mean of a picture that was written.
fn mean(folder: &Folder, name: &str) -> Rgb {
    let values = picture::read(&folder.path(name)).unwrap().0.values;
    values.pixels().iter().copied().sum::<Rgb>() / values.pixels().len() as f32
}

#[test]
fn an_edit_brings_the_light_of_a_scene_without_any() {
    let folder = Folder::new();
    folder.write("s.glb", &gltf::to_glb(&dark()).unwrap());
    let sky = RgbImage::from_fn(8, 4, |_, row| Rgb::splat(if row < 2 { 1.0 } else { 0.0 }));
    picture::write_exr(&folder.path("sky.exr"), &sky).unwrap();
    let lamp = "[[lights]]\nname = \"key\"\nadd = \"point\"\nposition = [0, 2, 2]\nstrength = 20\n";
    let area = "[[lights]]\nname = \"key\"\nadd = \"area\"\nposition = [0, 2.4, 0]\ndirection = [0, -1, 0]\n\
                size = [1, 1]\nstrength = 5\n";
    for light in
        [lamp, area, "[environment]\ncolor = [1, 1, 1]\n", "[environment]\nfile = \"sky.exr\"\n"]
    {
        folder.write("edit.toml", &format!("scene = \"s.glb\"\n{light}"));
        succeeds(&restage(&folder, &["edit.toml"]));
        assert!(mean(&folder, "out/synthetic.exr").min_element() > 0.01, "{light}");
    }
    succeeds(&restage(&folder, &["--scene", "s.glb", "--environment", "sky.exr"]));
    // Without any, it is refused with what would help; and an export needs none.
    fails(&restage(&folder, &["--scene", "s.glb"]), "[[lights]] or [environment]");
    for format in ["gltf", "mitsuba", "blender", "pbrt", "radiance"] {
        let out = format!("{format}.glb");
        succeeds(&folder.run(&["export", "--scene", "s.glb", "--to", format, "--out", &out]));
    }
}

/// An edit with a path of the camera through `keys`: times and eyes.
fn path(keys: &[(f32, [f32; 3])]) -> String {
    let head = "scene = \"s.glb\"\n[environment]\ncolor = [1, 1, 1]\n[camera]\nframes = 7\nfov_y_deg = 40\n";
    keys.iter().fold(head.to_owned(), |mut text, (time, eye)| {
        let _ =
            writeln!(text, "[[camera.keys]]\ntime = {time}\neye = {eye:?}\ntarget = [0, 1, -9]");
        text
    })
}

#[test]
fn a_camera_that_goes_through_a_wall_is_told() {
    let folder = Folder::new();
    folder.write("s.glb", &gltf::to_glb(&dark()).unwrap());
    let front = [0.0, 1.0, 1.0];
    for (keys, through) in [
        (vec![(0.0, front), (1.0, [0.0, 1.0, -3.5])], Some("\"back\"")),
        (vec![(0.0, front), (1.0, [0.0, -1.0, 1.0])], Some("\"floor\"")),
        (vec![(0.0, front), (1.0, [-0.5, 0.3, -0.5])], Some("\"block: oak.001\"")),
        // It stops just before the wall, holds, and returns: between the keys it does not swing out.
        (
            vec![(0.0, front), (1.0, [0.0, 1.0, -1.99]), (3.0, [0.0, 1.0, -1.99]), (4.0, front)],
            None,
        ),
    ] {
        folder.write("edit.toml", &path(&keys));
        let output = restage(&folder, &["edit.toml"]);
        succeeds(&output);
        let told = stderr(&folder.run(&[
            "restage",
            "edit.toml",
            "--spp",
            "1",
            "--width",
            "8",
            "--out",
            "out",
        ]));
        match through {
            Some(name) => {
                assert!(told.contains(&format!("it goes through {name}")), "{name}: {told}")
            }
            None => assert!(!told.contains("goes through"), "{told}"),
        }
    }
}

#[test]
fn a_flag_names_what_the_scene_calls_by_a_colon() {
    let folder = Folder::new();
    let mut scene = dark();
    let panel = quad(Vec3::new(-0.5, 2.4, -0.5), Vec3::X, Vec3::Z);
    add(&mut scene, " lamp: a=1 ", Rgb::ZERO, panel);
    scene.groups[3].emission = Rgb::splat(6.0);
    folder.write("s.glb", &gltf::to_glb(&scene).unwrap());
    let of = |flag: &str, value: &str| {
        succeeds(&restage(&folder, &["--scene", "s.glb", flag, value]));
        mean(&folder, "out/synthetic.exr").x
    };
    let before = of("--light", " lamp: a=1 : scale = 1");
    let dimmed = of("--light", " lamp: a=1 : scale = 0.5");
    assert!((dimmed / before - 0.5).abs() < 0.01, "{dimmed} of {before}");
    assert!(of("--repaint", "block: oak.001: rho_d = [0, 0, 0]") < before);
    assert!(of("--remove", "block: oak.001") != before);
}

#[test]
fn the_axis_upwards_is_stated_or_said_by_the_camera() {
    let camera = |up: &str, target: &str| {
        format!("camera = {{ eye = [0, -5, 2], target = {target}, {up} fov_y_deg = 40 }}\n")
    };
    let up_z = camera("up = [0, 0, 1],", "[0, 0, 1]");
    let said = parse(&up_z).unwrap();
    assert_eq!(said.0.up_axis, UpAxis::Z);
    assert!(said.1.0.iter().any(|told| told.contains("up_axis = \"z\"")), "{:?}", said.1);
    for (text, up) in [
        (format!("up_axis = \"y\"\n{up_z}"), UpAxis::Y),
        (format!("up_axis = \"z\"\n{up_z}"), UpAxis::Z),
        (camera("up = [0, 1, 0],", "[3, -5, 1]"), UpAxis::Y),
        (camera("", "[3, -5, 1]"), UpAxis::Y),
        // The floor plan of a scene whose y points upwards: it looks down.
        (camera("up = [0, 0, 1],", "[0, -9, 2]"), UpAxis::Y),
    ] {
        let (project, told) = parse(&text).unwrap();
        assert_eq!(project.up_axis, up, "{text}");
        assert!(!told.0.iter().any(|told| told.contains("up_axis")), "{told:?}");
    }
    // A camera stands upright by default.
    let upright = good(&format!("up_axis = \"z\"\n{}", camera("", "[0, 0, 1]")));
    let stated = good(&format!("up_axis = \"z\"\n{up_z}"));
    assert_eq!(upright.camera, stated.camera);
    are_refused(&[("up_axis = \"x\"\n", "`y` or `z`"), ("up_axis = 2\n", "line 3: wanted string")]);
}

/// The scene with z upwards.
fn turned(mut scene: Scene) -> Scene {
    for mesh in scene.objects.iter_mut().map(|object| &mut object.mesh) {
        mesh.positions.iter_mut().for_each(|p| *p = UpAxis::Z.from_y_up(*p));
        mesh.normals.iter_mut().for_each(|n| *n = UpAxis::Z.from_y_up(*n));
    }
    scene.cameras.clear();
    scene
}

#[test]
fn panoramas_and_models_stand_upright_where_z_points_upwards() {
    let folder = Folder::new();
    folder.write("y.glb", &gltf::to_glb(&dark()).unwrap());
    folder.write("z.glb", &gltf::to_glb(&turned(dark())).unwrap());
    let mut vase = Scene::default();
    add(
        &mut vase,
        "vase",
        Rgb::new(0.1, 0.2, 0.7),
        cuboid(Vec3::new(-0.1, 0.0, -0.1), Vec3::new(0.1, 0.9, 0.1)),
    );
    folder.write("vase.glb", &gltf::to_glb(&vase).unwrap());
    // Bright to the upper right, so that every turn shows.
    let sky = RgbImage::from_fn(8, 4, |x, y| {
        Rgb::new(0.2, 0.2, 0.3) * if (x, y) == (5, 1) { 40.0 } else { 1.0 }
    });
    picture::write_exr(&folder.path("sky.exr"), &sky).unwrap();
    let rest = "[environment]\nfile = \"sky.exr\"\nrotation_deg = 20\n[[insert]]\nfile = \"vase.glb\"\non = \"floor\"\n";
    let camera = |eye: &str, target: &str| {
        format!("[camera]\neye = {eye}\ntarget = {target}\nfov_y_deg = 45\n")
    };
    let picture = |head: &str, camera: String, at: &str| {
        folder.write("edit.toml", &format!("{head}\n{camera}{rest}at = {at}\n"));
        let size = ["--width", "32", "--height", "24", "--spp", "256", "--out", "out"];
        succeeds(&folder.run(&[&["restage", "--quiet", "edit.toml"], &size[..]].concat()));
        picture::read(&folder.path("out/synthetic.exr")).unwrap().0.values
    };
    let y = picture("scene = \"y.glb\"", camera("[0.4, 1.4, 3.4]", "[0, 0.6, -1]"), "[0.6, 0.2]");
    let z = camera("[0.4, -3.4, 1.4]", "[0, 1, 0.6]");
    let stated = picture("scene = \"z.glb\"\nup_axis = \"z\"", z.clone(), "[0.6, -0.2]");
    let said = picture("scene = \"z.glb\"", format!("{z}up = [0, 0, 1]\n"), "[0.6, -0.2]");
    for other in [&stated, &said] {
        let off = y.pixels().iter().zip(other.pixels()).map(|(a, b)| (*a - *b).length_squared());
        let all: f32 = y.pixels().iter().map(|a| a.length_squared()).sum();
        let off = (off.sum::<f32>() / all).sqrt();
        assert!(off < 0.1, "noise, not another scene: {off}");
    }
    assert_eq!(stated, said);
}

#[test]
fn a_near_clipping_plane_is_read_and_told() {
    let folder = Folder::new();
    let mut scene = dark();
    add(
        &mut scene,
        "front",
        Rgb::splat(0.6),
        quad(Vec3::new(-2.0, 0.0, 2.0), 4.0 * Vec3::X, 2.5 * Vec3::Y),
    );
    let panel = quad(Vec3::new(-0.5, 2.4, -0.5), Vec3::X, Vec3::Z);
    add(&mut scene, "lamp", Rgb::ZERO, panel);
    scene.groups[4].emission = Rgb::splat(6.0);
    let name = |file: &str| format!("scene = \"{file}\"\nphoto = \"p.exr\"\nexposure = 1\n");
    scene.cameras[0].near = 1.6;
    folder.write("cut.glb", &gltf::to_glb(&scene).unwrap());
    scene.cameras[0].near = 0.0;
    folder.write("whole.glb", &gltf::to_glb(&scene).unwrap());
    for file in ["cut", "whole"] {
        let (scene, out) = (format!("{file}.glb"), format!("{file}.exr"));
        succeeds(&folder.run(&[&["render", &scene, "--out", &out], &SIZE[..]].concat()));
    }
    assert!(
        mean(&folder, "cut.exr").x > 5.0 * mean(&folder, "whole.exr").x,
        "the wall hides the room"
    );
    std::fs::copy(folder.path("cut.exr"), folder.path("p.exr")).unwrap();
    folder.write("cut.toml", &name("cut.glb"));
    let camera = "camera = { eye = [0.4, 1.4, 3.4], target = [0, 0.6, -1], fov_y_deg = 45.84, near = 1.6 }\n";
    folder.write("stated.toml", &format!("{}{camera}", name("whole.glb")));
    folder.write("whole.toml", &name("whole.glb"));
    let told = |project: &str| {
        let output = folder.run(&["check", project, "--json"]);
        succeeds(&output);
        String::from_utf8(output.stdout).unwrap()
    };
    let cut = "near clipping plane, 1.600 m, is not seen: parts of \\\"front\\\"";
    assert!(told("cut.toml").contains(cut), "{}", told("cut.toml"));
    assert!(told("stated.toml").contains(cut));
    assert!(!told("whole.toml").contains("near clipping plane"));
    are_refused(&[(&camera.replace("1.6 }", "-1 }"), "camera.near is -1")]);
}
