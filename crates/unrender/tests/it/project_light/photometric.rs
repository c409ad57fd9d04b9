//! Lamps with photometric profiles, and lamps whose brightness is stated in lumens, candela or lux.

use super::*;
use glam::Vec3;
use std::f32::consts::PI;
use unrender::Project;
use unrender::scene::{Light, LightKind, Scene};

/// 1000 cd straight down, half of it at 45 degrees and none from 90 on; twice as much towards a horizontal angle of 180.
const PROFILE: &str = "IESNA91\nTILT=NONE\n1 -1 1 3 3 1 2 0 0 0\n1 1 10\n0 45 90\n0 90 180\n\
                       1000 500 0 1000 500 0 1000 1000 0\n";

/// The lights of a scene with a point, a spot, a sun and an area light after a project with these tables.
fn lit(tables: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lamp.ies"), PROFILE).unwrap();
    let head = "scene = \"a.glb\"\nphoto = \"a.exr\"\n";
    let path = folder.path().join("project.toml");
    let project = Project::parse(&path, &format!("{head}{tables}")).map_err(|e| e.to_string())?.0;
    let (position, direction) = (Vec3::new(0.0, 2.0, 0.0), Vec3::NEG_Y);
    let intensity = Rgb::new(2.0, 1.0, 0.5);
    let kinds = [
        ("point", LightKind::Point { position, intensity }),
        (
            "spot",
            LightKind::Spot {
                position,
                direction: Vec3::X,
                intensity,
                inner_rad: 0.2,
                outer_rad: 0.6,
            },
        ),
        ("sun", LightKind::Directional { direction, irradiance: intensity }),
    ];
    let lights = kinds.map(|(name, kind)| Light { name: name.into(), kind }).to_vec();
    let mut scene = Scene { lights, ..Scene::default() };
    project.light(&mut scene).map_err(|e| e.to_string())?;
    Ok(scene)
}

/// The luminance of the irradiance by the light `name` at `point`, times 683 lm/W: lux.
fn lux(scene: &Scene, name: &str, point: Vec3) -> f32 {
    let light = scene.lights.iter().find(|light| light.name == name).unwrap();
    683.0 * unrender::scene::color::luminance(light.kind.illuminate(point).2)
}

fn near(found: f32, due: f32) {
    assert!((found / due - 1.0).abs() < 1e-5, "{found}, not {due}");
}

#[test]
fn a_lamp_has_the_candelas_of_its_file() {
    let lamp = |keys: &str| {
        let place = "add = \"point\"\nposition = [0, 2, 0]\nprofile = \"lamp.ies\"\n";
        lit(&format!("[[lights]]\nname = \"lamp\"\n{place}{keys}")).unwrap()
    };
    // 1000 cd at 2 m; at 45 degrees along +x, the horizontal angle 0, 500 cd at 8 m^2.
    near(lux(&lamp(""), "lamp", Vec3::ZERO), 250.0);
    near(lux(&lamp(""), "lamp", Vec3::new(2.0, 0.0, 0.0)), 62.5);
    near(lux(&lamp(""), "lamp", Vec3::new(-2.0, 0.0, 0.0)), 125.0);
    near(lux(&lamp("turn_deg = 180\n"), "lamp", Vec3::new(2.0, 0.0, 0.0)), 125.0);
    near(lux(&lamp("scale = 0.5\n"), "lamp", Vec3::ZERO), 125.0);
    // Colour leaves the candelas as they are, and so does the strength its own W/sr.
    near(lux(&lamp("color = [1, 0.5, 0.25]\n"), "lamp", Vec3::ZERO), 250.0);
    near(lux(&lamp("strength = 2\n"), "lamp", Vec3::ZERO), 683.0 * 2.0 / 4.0);
    near(lux(&lamp("candela = 200\n"), "lamp", Vec3::ZERO), 50.0);
    near(lux(&lamp("direction = [1, 0, 0]\n"), "lamp", Vec3::new(4.0, 2.0, 0.0)), 62.5);
    let LightKind::Profiled { profile, intensity, .. } = &lamp("lumens = 800\n").lights[3].kind
    else {
        panic!("no profile")
    };
    near(683.0 * intensity.x * profile.steradians() as f32, 800.0);
}

#[test]
fn lamps_of_the_scene_get_a_profile() {
    let with = |name: &str, keys: &str| {
        lit(&format!("[[lights]]\nname = \"{name}\"\nprofile = \"lamp.ies\"\n{keys}"))
    };
    // A point shines down, a spot where it did; both in their own colour.
    let point = with("point", "").unwrap();
    near(lux(&point, "point", Vec3::ZERO), 250.0);
    let color = point.lights[0].kind.strength();
    near(color.x / color.z, 4.0);
    near(lux(&with("spot", "").unwrap(), "spot", Vec3::new(2.0, 2.0, 0.0)), 250.0);
    near(
        lux(&with("spot", "direction = [0, 0, 1]\n").unwrap(), "spot", Vec3::new(0.0, 2.0, 2.0)),
        250.0,
    );
    for (name, keys, part) in [
        ("sun", "", "infinitely far"),
        ("point", "strength = 1\nlumens = 3\n", "one of strength, lumens"),
        ("new", "add = \"spot\"\nposition = [0, 1, 0]\ndirection = [0, 1, 0]\n", "add = \"point\""),
        ("new", "add = \"point\"\n", "position"),
        ("point", "remove = true\n", "no profile"),
    ] {
        let told = with(name, keys).unwrap_err();
        assert!(told.contains(part), "{told}");
    }
    let told = lit("[[lights]]\nname = \"point\"\nprofile = \"no.ies\"\n").unwrap_err();
    assert!(told.contains("lights.point: ") && told.contains("no.ies"), "{told}");
    let told = lit("[[lights]]\nname = \"point\"\nturn_deg = 3\n").unwrap_err();
    assert!(told.contains("has no profile"), "{told}");
}

#[test]
fn lumens_candela_and_lux_are_what_they_say() {
    let of = |name: &str, keys: &str| lit(&format!("[[lights]]\nname = \"{name}\"\n{keys}\n"));
    near(lux(&of("point", "lumens = 800").unwrap(), "point", Vec3::ZERO), 800.0 / (4.0 * PI) / 4.0);
    near(lux(&of("point", "candela = 100").unwrap(), "point", Vec3::ZERO), 25.0);
    near(lux(&of("sun", "lux = 50000").unwrap(), "sun", Vec3::ZERO), 50000.0);
    let spot = of("spot", "lumens = 100").unwrap();
    // The flux, by adding up rings.
    let rings = (0..100_000).map(|i| (f64::from(i) + 0.5) * 0.6 / 100_000.0);
    let flux: f64 = rings
        .map(|angle| {
            let at = Vec3::new(angle.cos() as f32, 2.0 + angle.sin() as f32, 0.0);
            let ring = 2.0 * std::f64::consts::PI * angle.sin() * 0.6 / 100_000.0;
            f64::from(lux(&spot, "spot", at)) * ring
        })
        .sum();
    assert!((flux / 100.0 - 1.0).abs() < 1e-3, "{flux}");
    // A sphere and a panel by their area; the colour is the stated one.
    let add = "position = [0, 1, 0]\nlumens = 1000\ncolor = [1, 1, 0]\n";
    let panel = format!("add = \"area\"\ndirection = [0, -1, 0]\nsize = [0.5, 0.2]\n{add}");
    let radiance = of("panel", &panel).unwrap().groups[0].emission;
    near(683.0 * PI * 0.1 * unrender::scene::color::luminance(radiance), 1000.0);
    assert_eq!((radiance.x, radiance.z), (radiance.y, 0.0));
    let ball = of("ball", &format!("add = \"sphere\"\nradius = 0.1\n{add}")).unwrap();
    let about = 1000.0 / (683.0 * PI * 4.0 * PI * 0.01);
    let found = unrender::scene::color::luminance(ball.groups[0].emission);
    assert!((found / about - 1.0).abs() < 0.02, "{found} {about}");
    for (name, keys) in [("sun", "lumens = 1"), ("sun", "candela = 1"), ("point", "lux = 1")] {
        let told = of(name, keys).unwrap_err();
        assert!(told.contains("lumens are for lamps"), "{told}");
    }
}
