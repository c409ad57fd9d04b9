//! Lamps with photometric profiles beside other programs: illuminances by Radiance's `ies2rad`, and pictures of exports.

use crate::kit::export_scene::{SIZE, camera, exported};
use crate::kit::programs::{Program, need, our_picture};
use glam::Vec3;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use unrender::formats::export::Target;
use unrender::formats::{Input, Limits, ies};
use unrender::scene::{
    Group, Light, LightKind, LightProfile, Material, Mesh, Object, Photometry, Rgb, Scene,
};

/// Brighter towards 0 degrees than towards 180, and dark from 90 degrees on.
const LAMP: &str = "IESNA:LM-63-1995\n[TEST] none\nTILT=NONE\n1 1000 2 4 5 1 2 0.01 0.01 0\n0.9 0.8 20\n\
                    0 30 60 90\n0 90 180 270 360\n1000 800 400 0\n1000 700 300 0\n1000 300 100 0\n\
                    1000 500 200 0\n1000 800 400 0\n";

/// Lumens of a watt in Radiance.
const RADIANCE_LUMENS: f32 = 179.0;

/// Two metres below a lamp at zero, which is aimed along -z.
fn points() -> Vec<Vec3> {
    let steps = || (-3..=3).map(|i| 0.7 * i as f32);
    steps().flat_map(|x| steps().map(move |y| Vec3::new(x, y, -2.0))).collect()
}

/// The irradiances by the Radiance scene `octree` in `folder` at [`points`], on a plane that faces +z.
fn irradiances(folder: &Path, (programs, library): (&Path, &Path)) -> Vec<f32> {
    let path = std::env::var("PATH").unwrap_or_default();
    let command = "ies2rad -dm -t white lamp.ies && oconv lamp.rad > lamp.oct && \
                   rtrace -h -I -ab 0 -dt 0 -dc 1 -ds 0 -dj 0 lamp.oct";
    let mut shell = Command::new("sh");
    shell.args(["-ec", command]).current_dir(folder).stdin(Stdio::piped()).stdout(Stdio::piped());
    shell.env("PATH", format!("{}:{path}", programs.display()));
    shell.env("RAYPATH", format!(".:{}", library.display()));
    let mut running = shell.spawn().unwrap();
    let mut input = running.stdin.take().unwrap();
    for at in points() {
        writeln!(input, "{} {} {} 0 0 1", at.x, at.y, at.z).unwrap();
    }
    drop(input);
    let output = running.wait_with_output().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    let green = |line: &str| line.split_whitespace().nth(1).unwrap().parse().unwrap();
    text.lines().map(green).collect()
}

#[test]
#[ignore = "slow: needs Radiance, which .ci/programs installs"]
fn a_lamp_lights_points_as_ies2rad_has_it() {
    let Some(Program::Radiance(programs, library)) = need(Program::installed(Target::Radiance))
    else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lamp.ies");
    std::fs::write(&path, LAMP).unwrap();
    let profile = ies::read(Input::new(&path, Limits::default())).unwrap().0;
    let intensity = Rgb::splat(profile.peak_candela() as f32 / RADIANCE_LUMENS);
    let (position, direction, upright) = (Vec3::ZERO, Vec3::NEG_Z, Vec3::X);
    let lamp = LightKind::Profiled { position, direction, upright, intensity, profile };
    for (at, theirs) in points().into_iter().zip(irradiances(folder.path(), (&programs, &library)))
    {
        let (wi, _, irradiance) = lamp.illuminate(at);
        let ours = irradiance.y * wi.z;
        assert!((theirs / ours - 1.0).abs() < 0.01, "{at}: {theirs}, ours {ours}");
    }
}

/// A floor under a lamp with this profile, which is aimed slantwise.
fn floor(profile: LightProfile) -> Scene {
    let corners =
        [(-3.0, -3.0), (-3.0, 3.0), (3.0, 3.0), (3.0, -3.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    let mesh = Mesh::flat(&corners, &[], &[[0, 1, 2], [0, 2, 3]]);
    let (material, emission) = (Material::diffuse(Rgb::splat(0.5)), Rgb::ZERO);
    let direction = Vec3::new(0.2, -0.9, -0.3).normalize();
    let upright = LightKind::upright(Vec3::new(-0.3, 0.2, 0.9).normalize(), Vec3::Y);
    let upright = (upright - direction * upright.dot(direction)).normalize();
    let (position, intensity) = (Vec3::new(0.3, 1.4, 0.6), Rgb::new(20.0, 15.0, 10.0));
    let kind = LightKind::Profiled { position, direction, upright, intensity, profile };
    Scene {
        groups: vec![Group { name: "floor".into(), material, emission }],
        objects: vec![Object { name: "floor".into(), group: 0, mesh }],
        lights: vec![Light { name: "lamp".into(), kind }],
        cameras: vec![camera()],
        ..Scene::default()
    }
}

/// A profile of each type, symmetric or not.
fn profiles() -> Vec<LightProfile> {
    let of = |photometry, vertical: &[f32], horizontal: &[f32]| {
        let count = vertical.len() * horizontal.len();
        // Four of twelve later again: at 0 and at 360 degrees a lamp is the same.
        let candela = (0..count).map(|i| 300.0 + (i % 12 * 7 % 5) as f64 * 60.0);
        let candela: Vec<f64> = candela.collect();
        LightProfile::new(photometry, vertical.to_vec(), horizontal.to_vec(), &candela).unwrap()
    };
    let below = [0.0, 25.0, 50.0, 90.0];
    let both = [-90.0, -30.0, 10.0, 90.0];
    vec![
        of(Photometry::C, &below, &[0.0]),
        of(Photometry::C, &below, &[0.0, 40.0, 90.0]),
        of(Photometry::C, &below, &[0.0, 60.0, 180.0]),
        of(Photometry::C, &below, &[90.0, 150.0, 270.0]),
        of(Photometry::C, &[0.0, 60.0, 120.0, 180.0], &[0.0, 100.0, 220.0, 360.0]),
        of(Photometry::B, &both, &[-90.0, 0.0, 35.0, 90.0]),
        of(Photometry::A, &both, &[0.0, 35.0, 90.0]),
    ]
}

/// Pictures of 4 by 4 pixels each.
fn is_as_bright(target: Target, limit: f32) {
    let Some(program) = need(Program::installed(target)) else { return };
    for (index, profile) in profiles().into_iter().enumerate() {
        let scene = floor(profile);
        let (_folder, path) = exported(&scene, target);
        let theirs = program.picture(&path, SIZE, 64).unwrap();
        let ours = our_picture(&scene, &camera(), (theirs.width(), theirs.height()), 64);
        let of = |picture: &unrender::scene::RgbImage, x: usize, y: usize| -> Rgb {
            (0..16).map(|i| *picture.at(4 * x + i % 4, 4 * y + i / 4)).sum()
        };
        let brightest = of(&ours, 10, 10).max_element();
        let mut worst = 0.0f32;
        for y in 9..15 {
            for x in 0..20 {
                let [ours, theirs] = [&ours, &theirs].map(|picture| of(picture, x, y));
                if ours.min_element() > 0.05 * brightest {
                    worst = worst.max((theirs / ours - 1.0).abs().max_element());
                }
            }
        }
        println!("{target}, profile {index}: {:.2} %", 100.0 * worst);
        assert!(worst < limit, "{target}, profile {index}: {worst}");
    }
}

#[test]
#[ignore = "slow: needs Radiance, which .ci/programs installs"]
fn radiance_renders_profiles_alike() {
    is_as_bright(Target::Radiance, 0.01);
}

#[test]
#[ignore = "slow: needs Blender, which .ci/programs installs"]
fn blender_renders_profiles_alike() {
    is_as_bright(Target::Blender, 0.03);
}
