//! IES files of all editions, their symmetries and faults, and lamps by them in glTF.

use glam::{DVec3, Vec3};
use unrender_formats::{Input, LightUnits, Limits, gltf, ies};
use unrender_scene::{
    Group, Light, LightKind, LightProfile, Material, Mesh, Object, Photometry, Rgb, Scene, Warnings,
};

/// A file with this first line, `TILT=`, factors (multiplier, ballast, lamp and ballast), type and table.
fn file(first: &str, tilt: &str, [multiplier, ballast, lamp]: [f64; 3], table: &str) -> String {
    let mut words = table.split_whitespace();
    let counts: Vec<&str> = words.by_ref().take(3).collect();
    let [kind, vertical, horizontal] = counts[..] else { panic!("{table}") };
    let rest: Vec<&str> = words.collect();
    format!(
        "{first}\n[TEST] a lamp, 1000 lm\nTILT={tilt}\n1 1000. {multiplier} {vertical} {horizontal} {kind} 1 .1 -.2 0\n\
         {ballast} {lamp} 20\n{}\n",
        rest.join(" ")
    )
}

fn parse(text: &str) -> Result<(LightProfile, Warnings), String> {
    let tilt = |name: &str| match name {
        "lamp.tlt" => Ok(b"1\n2\n0 90\n1.0 0.9\n".to_vec()),
        _ => Err("is missing".into()),
    };
    ies::parse(text.as_bytes(), &tilt)
}

const ROUND: &str = "1 3 1  0 45 90  0  100 70 10";

#[test]
fn every_edition_has_its_factors() {
    let factors = [2.0, 0.9, 0.5];
    // The last factor counts until 1991.
    for (first, factor) in [
        ("A lamp of 1986", 0.9),
        ("IESNA91", 0.9),
        ("IESNA:LM-63-1995", 1.8),
        ("IESNA:LM-63-2002", 1.8),
        ("IES:LM-63-2019", 1.8),
    ] {
        let (profile, warnings) = parse(&file(first, "NONE", factors, ROUND)).unwrap();
        assert!(warnings.0.is_empty(), "{warnings:?}");
        let found: Vec<f64> = profile.candela().map(|c| c / factor).collect();
        let due = [100.0, 70.0, 10.0];
        assert!(found.iter().zip(due).all(|(a, b)| (a - b).abs() < 1e-5), "{first}: {found:?}");
    }
}

#[test]
fn numbers_may_stand_on_any_lines_and_between_commas() {
    let plain = parse(&file("IESNA91", "NONE", [1.0; 3], ROUND)).unwrap().0;
    let odd = "IESNA91\r\n\u{e9}[KEY] =\r\n tilt = none \r\n1,1000,1\r\n3,1 1 2 0 0 0 1\r\n\r\n1 20 0\r\n45 90 0\r\n\
               100, 70 1E1\r\n\u{1a}";
    assert_eq!(parse(odd).unwrap(), (plain, Warnings::default()));
}

#[test]
fn tilted_lamps_shine_as_measured_with_a_warning() {
    let due = parse(&file("IESNA91", "NONE", [1.0; 3], ROUND)).unwrap().0;
    let include = file("IESNA91", "INCLUDE\n1\n2\n0 90\n1 0.9", [1.0; 3], ROUND);
    for text in [include, file("IESNA91", "lamp.tlt", [1.0; 3], ROUND)] {
        let (profile, warnings) = parse(&text).unwrap();
        assert_eq!(profile, due);
        assert!(warnings.0[0].starts_with("TILT:"), "{warnings:?}");
    }
    let problem = parse(&file("IESNA91", "other.tlt", [1.0; 3], ROUND)).unwrap_err();
    assert!(
        problem.contains("line 3: TILT=other.tlt") && problem.contains("is missing"),
        "{problem}"
    );
    // In a file, it is looked for beside that one, and not elsewhere.
    let folder = tempfile::tempdir().unwrap();
    let lamp = folder.path().join("lamps/lamp.ies");
    std::fs::create_dir(lamp.parent().unwrap()).unwrap();
    for (place, name, is_read) in
        [("lamps/a.tlt", "a.tlt", true), ("b.tlt", "b.tlt", false), ("b.tlt", "../b.tlt", false)]
    {
        std::fs::write(folder.path().join(place), "1 2 0 90 1 0.9").unwrap();
        std::fs::write(&lamp, file("IESNA91", name, [1.0; 3], ROUND)).unwrap();
        assert_eq!(ies::read(Input::new(&lamp, Limits::default())).is_ok(), is_read, "{name}");
    }
}

#[test]
fn the_last_horizontal_angle_may_lack() {
    let short = "1 2 4  0 90  0 90 180 270  1 0  2 0  3 0  4 0";
    let whole = "1 2 5  0 90  0 90 180 270 360  1 0  2 0  3 0  4 0  1 0";
    let (profile, warnings) = parse(&file("IESNA91", "NONE", [1.0; 3], short)).unwrap();
    // 270 is an angle at which no symmetry ends, but from there to 360 it is as far as between the others.
    assert_eq!(profile, parse(&file("IESNA91", "NONE", [1.0; 3], whole)).unwrap().0);
    assert!(warnings.0[0].contains("360"), "{warnings:?}");
}

#[test]
fn faults_are_told_with_their_line() {
    let table = |table: &str| file("IESNA91", "NONE", [1.0; 3], table);
    for (text, line, part) in [
        ("a lamp\n".to_owned(), "", "no line TILT="),
        (table("1 3 1 0 45 90 0 100 70"), "", "ends within the candelas"),
        (table("1 999999999 999999999 0"), "line 4", "999999999"),
        (table("1 2.5 1 0 90 0 1 1"), "line 4", "2.5"),
        (table("7 2 1 0 90 0 1 1"), "line 4", "photometric type"),
        (table("1 2 1 0 90 0 x 1"), "line 6", "\"x\""),
        (table("1 2 1 0 90 0 inf 1"), "line 6", "\"inf\""),
        (table("1 2 1 0 90 0 1 -1"), "line 4", "-1"),
        (table("1 2 1 90 0 0 1 1"), "line 4", "do not ascend"),
        (table("1 2 2 0 90 0 45 1 1 1 1"), "line 4", "0 to 45"),
        (table("1 2 1 0 90 0 0 0"), "line 4", "zero"),
        (file("IESNA91", "NONE", [0.0, 1.0, 1.0], ROUND), "line 4", "multiplier"),
        (file("IESNA91", "INCLUDE", [1.0; 3], ROUND), "", ""),
        ("TILT=NONE".to_owned(), "", "ends before"),
    ] {
        let problem = parse(&text).unwrap_err();
        assert!(problem.contains(line) && problem.contains(part), "{problem}");
    }
}

/// A profile of each type, with numbers that have no short decimals.
fn profiles() -> [LightProfile; 3] {
    let candela = [1.0 / 3.0, 700.1, 1e-3, 50.0, 0.0, 2.0 / 7.0];
    let (three, two) = (vec![0.0, 33.3, 90.0], vec![-20.5, 71.125]);
    [
        LightProfile::new(Photometry::C, three.clone(), vec![0.0, 90.0], &candela).unwrap(),
        LightProfile::new(Photometry::B, two.clone(), three.clone(), &candela).unwrap(),
        LightProfile::new(Photometry::A, three, two, &candela).unwrap(),
    ]
}

#[test]
fn profiles_are_written_and_read_back_to_the_bit() {
    for profile in profiles() {
        let text = ies::text(&profile, "a\nlamp");
        assert_eq!(parse(&text).unwrap(), (profile, Warnings::default()), "{text}");
        assert!(text.lines().all(|line| line.len() <= 132), "{text}");
    }
}

fn room() -> Scene {
    let mesh = Mesh::flat(&[Vec3::ZERO, Vec3::X, Vec3::Z], &[], &[[0, 2, 1]]);
    let material = Material::diffuse(Rgb::splat(0.5));
    let directions = [Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8), Vec3::new(0.48, -0.6, 0.64)];
    let lights = profiles().into_iter().zip(directions).enumerate().map(|(index, (profile, d))| {
        let upright = LightKind::upright(d, Vec3::Y);
        let intensity = Rgb::new(7.3, 0.1, 1.0 / 3.0) * (index + 1) as f32;
        let position = Vec3::new(0.1, 2.0, -0.7);
        let kind = LightKind::Profiled { position, direction: d, upright, intensity, profile };
        Light { name: format!("lamp {index}"), kind }
    });
    Scene {
        groups: vec![Group { name: "floor".into(), material, emission: Rgb::ZERO }],
        objects: vec![Object { name: "floor".into(), group: 0, mesh }],
        lights: lights.collect(),
        ..Scene::default()
    }
}

#[test]
fn gltf_carries_lamps_by_their_profiles() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.glb");
    let scene = room();
    for units in [LightUnits::Radiometric, LightUnits::BlenderStandard] {
        std::fs::write(&path, gltf::to_glb_as(&scene, &scene.materials(), units).unwrap()).unwrap();
        let (again, warnings) = gltf::read(&path).unwrap();
        assert!(warnings.0.iter().all(|told| told.contains("lights read as")), "{warnings:?}");
        for (old, new) in scene.lights.iter().zip(&again.lights) {
            let (LightKind::Profiled { profile: a, .. }, LightKind::Profiled { profile: b, .. }) =
                (&old.kind, &new.kind)
            else {
                panic!("{new:?}")
            };
            assert_eq!((a, &old.name), (b, &new.name));
            let off = (old.kind.strength() - new.kind.strength()).abs().max_element();
            assert!(off <= if units == LightUnits::Radiometric { 0.0 } else { 1e-5 }, "{off}");
            for at in [Vec3::ZERO, Vec3::X, Vec3::new(-1.0, 0.5, 3.0)] {
                let [old, new] = [old, new].map(|light| light.kind.illuminate(at).2);
                assert!((old - new).abs().max_element() < 1e-4, "{old} {new}");
            }
        }
    }
    // Brighter lamps in the file that they came from.
    let mut brighter = gltf::read(&path).unwrap().0;
    let old = brighter.lights[1].kind.strength();
    *brighter.lights[1].kind.strength_mut() *= 2.5;
    std::fs::write(&path, gltf::assign_materials(&path, &brighter, &[]).unwrap()).unwrap();
    let again = gltf::read(&path).unwrap().0;
    assert!((again.lights[1].kind.strength() / old - 2.5).abs().max_element() < 1e-5);
    assert_eq!(again.lights[0], brighter.lights[0]);
}

#[test]
fn gltf_names_its_profile_as_the_extension_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.gltf");
    std::fs::write(folder.path().join("lamp.ies"), file("IESNA91", "NONE", [1.0; 3], ROUND))
        .unwrap();
    // An untransformed lamp shines along -z, and its horizontal plane is that of x and y.
    let text = r#"{ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }],
        "extensionsUsed": ["EXT_lights_ies"], "extensionsRequired": ["EXT_lights_ies"],
        "extensions": { "EXT_lights_ies": { "lights": [{ "uri": "lamp.ies" }] } },
        "nodes": [{ "name": "lamp", "scale": [2, 2, 2], "translation": [0, 0, 1],
            "extensions": { "EXT_lights_ies": { "light": 0, "multiplier": 3, "color": [1, 0.5, 0.25] } } }] }"#;
    std::fs::write(&path, text).unwrap();
    let lamp = |units| {
        let read = gltf::read(Input::new(&path, Limits::default()).in_light_units(units));
        read.unwrap().0.lights[0].kind.clone()
    };
    let straight = lamp(None).illuminate(Vec3::ZERO).2;
    assert!((straight - Rgb::new(300.0, 150.0, 75.0)).length() < 1e-3, "{straight}");
    let aside = lamp(None).illuminate(Vec3::new(-1.0, 0.0, 0.0)).2;
    assert!((aside.x - 0.5 * 210.0).abs() < 1e-3, "{aside}");
    let blenders = lamp(Some(LightUnits::BlenderStandard)).strength().as_dvec3();
    assert!((blenders * 683.0 - DVec3::new(300.0, 150.0, 75.0)).length() < 1e-3);
    std::fs::remove_file(folder.path().join("lamp.ies")).unwrap();
    assert!(gltf::read(&path).unwrap_err().to_string().contains("lamp.ies"));
}
