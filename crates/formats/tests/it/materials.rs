//! materials.json: read leniently, written in a fixed order, applied to a scene.

use crate::support::Folder;
use glam::Vec3;
use std::path::Path;
use unrender_formats::materials::{
    self, AlternativeEntry, GroupEntry, Hypothesis, LightEntry, MaterialsFile, Status, StatusEntry,
    StdEntry,
};
use unrender_formats::picture;
use unrender_scene::{Group, Image, Light, LightKind, Material, Rgb, Scene, WardModel};

fn scene(names: &[&str]) -> Scene {
    let group = |name: &&str| Group {
        name: (*name).to_owned(),
        material: Material::isotropic(Rgb::splat(0.5), Rgb::splat(0.25), 0.2),
        emission: Rgb::ZERO,
    };
    Scene { groups: names.iter().map(group).collect(), ..Scene::default() }
}

fn parsed(text: &str) -> MaterialsFile {
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_truth_file_reads_and_applies() {
    let file = parsed(
        r#"{"brdf": "ward-1992", "made by": "hand", "groups": {
            "wall": {"rho_d": [0.66, 0.5, 0.4], "rho_s": [0, 0, 0], "alpha_x": null, "new": 1},
            "floor": {"hypothesis": "anisotropic", "alpha_x": 0.07, "alpha_y": 0.11,
                      "theta_deg": 90.0, "direction": null, "texture": null},
            "ghost": {}}}"#,
    );
    let mut scene = scene(&["floor", "wall", "other"]);
    let warnings = materials::apply(&file, Path::new("."), &mut scene).unwrap();
    assert_eq!(warnings.0, ["the scene has no group \"ghost\"; its numbers were not used"]);
    assert_eq!(scene.brdf, WardModel::Ward1992.into());
    let [floor, wall, other] = [0, 1, 2].map(|i| scene.groups[i].material.clone());
    assert_eq!((floor.alpha_x, floor.alpha_y, floor.rho_d), (0.07, 0.11, Rgb::splat(0.5)));
    assert!((floor.theta_rad - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    assert_eq!((wall.rho_d, wall.rho_s), (Rgb::new(0.66, 0.5, 0.4), Rgb::ZERO));
    assert_eq!(wall.alpha_x, 0.2, "null means as in the scene");
    assert_eq!(other, Material::isotropic(Rgb::splat(0.5), Rgb::splat(0.25), 0.2));
}

#[test]
fn lights_shine_as_the_file_says() {
    let file = parsed(
        r#"{"groups": {}, "lights": {
            "lamp": {"intensity": [1, 2.5, 40], "std": null},
            "sun": {"intensity": [3, 2, 1], "std": [0.1, 0.1, 0.1], "note": "bright"},
            "spot": {"intensity": null}, "floor": {"intensity": [1, 1, 1]},
            "twin": {"intensity": [1, 1, 1]}}}"#,
    );
    let mut scene = scene(&["floor", "lamp"]);
    scene.groups[1].emission = Rgb::ONE;
    let (position, direction, half) = (Vec3::ZERO, Vec3::NEG_Y, Rgb::splat(0.5));
    for (name, kind) in [
        ("sun", LightKind::Directional { direction, irradiance: half }),
        (
            "spot",
            LightKind::Spot {
                position,
                direction,
                intensity: half,
                inner_rad: 0.1,
                outer_rad: 0.2,
            },
        ),
        ("twin", LightKind::Point { position, intensity: half }),
        ("twin", LightKind::Point { position, intensity: half }),
    ] {
        scene.lights.push(Light { name: name.into(), kind });
    }
    let warnings = materials::apply(&file, Path::new("."), &mut scene).unwrap();
    let told = [
        "the scene has no light \"floor\"; its numbers were not used",
        "the scene has several lights called \"twin\"; its numbers were not used",
    ];
    assert_eq!(warnings.0, told);
    let strengths: Vec<Rgb> = scene.sources().map(|source| source.strength).collect();
    let wanted = [Rgb::new(1.0, 2.5, 40.0), Rgb::new(3.0, 2.0, 1.0), half, half, half];
    assert_eq!(strengths, wanted);
    assert_eq!(scene.groups[0].emission, Rgb::ZERO);

    let file = parsed(r#"{"groups": {}, "lights": {"lamp": {"intensity": [1, -2, 0]}}}"#);
    let error = materials::apply(&file, Path::new("a"), &mut scene).unwrap_err().to_string();
    assert!(error.contains("light \"lamp\": intensity is -2"), "{error}");
}

#[test]
fn lights_and_alternatives_come_back_and_are_left_out_where_there_are_none() {
    let folder = Folder::new();
    let path = folder.path("materials.json");
    let mut file = MaterialsFile::default();
    let light = |intensity, std| LightEntry { intensity, std, panorama: None };
    file.lights.insert("z".into(), light(Some([1.0, 2.0, 0.1]), Some([0.1, f32::NAN, 0.1])));
    file.lights.insert("a".into(), light(Some([f32::INFINITY; 3]), Some([0.5; 3])));
    let alternative = AlternativeEntry {
        hypothesis: Some(Hypothesis::Isotropic),
        rho_d: Some([0.1, 0.2, 0.3]),
        rho_s: Some([f32::NAN; 3]),
        alpha_x: Some(0.2),
        alpha_y: Some(0.2),
        theta_deg: None,
        error: Some(0.004),
    };
    let group = GroupEntry { alternatives: vec![alternative], ..GroupEntry::default() };
    file.groups.insert("floor".into(), group);
    materials::write(&path, &file).unwrap();
    file.lights["z"].std = None;
    file.lights["a"].intensity = None;
    file.groups["floor"].alternatives[0].rho_s = None;
    assert_eq!(materials::read(&path).unwrap(), file);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.find("\"z\"").unwrap() < text.find("\"a\"").unwrap(), "{text}");
    assert!(text.contains("\"std\": null") && text.contains("\"alternatives\""), "{text}");

    file.lights.clear();
    file.groups["floor"].alternatives.clear();
    materials::write(&path, &file).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(!text.contains("lights") && !text.contains("alternatives"), "{text}");
}

#[test]
fn numbers_out_of_range_name_group_and_key() {
    for (entry, key) in [
        (r#"{"rho_d": [0.1, 1.2, 0]}"#, "rho_d is 1.2"),
        (r#"{"rho_s": [-0.1, 0, 0]}"#, "rho_s is -0.1"),
        (r#"{"alpha_x": -1}"#, "alpha_x is -1"),
        (r#"{"alpha_y": 0}"#, "alpha_y is 0"),
    ] {
        let file = parsed(&format!(r#"{{"groups": {{"floor": {entry}}}}}"#));
        let error = materials::apply(&file, Path::new("."), &mut scene(&["floor"])).unwrap_err();
        let error = error.to_string();
        assert!(error.contains("\"floor\"") && error.contains(key), "{error}");
    }
    let file = MaterialsFile { brdf: Some("phong".into()), ..MaterialsFile::default() };
    let error = materials::apply(&file, Path::new("."), &mut scene(&[])).unwrap_err();
    assert!(error.to_string().contains("unknown brdf"), "{error}");
}

#[test]
fn statuses_are_words_and_those_of_before_stay_readable() {
    let of = |text: &str| serde_json::from_str::<StatusEntry>(&format!("\"{text}\""));
    for (text, status) in [
        ("recovered", StatusEntry::Of(Status::Recovered)),
        ("known", StatusEntry::Of(Status::Known)),
        ("assumed", StatusEntry::Of(Status::Assumed)),
        ("doubtful", StatusEntry::Of(Status::Doubtful)),
        ("ignored", StatusEntry::Ignored),
        ("same as old oak", StatusEntry::SameAs("old oak".into())),
    ] {
        assert_eq!(of(text).unwrap(), status);
        assert_eq!(serde_json::to_string(&status).unwrap(), format!("\"{text}\""));
    }
    assert!(of("guessed").unwrap_err().to_string().contains("no status \"guessed\""));
}

#[test]
fn files_come_back_as_they_were_written() {
    let folder = Folder::new();
    let path = folder.path("materials.json");
    let floor = GroupEntry {
        hypothesis: Some(Hypothesis::PartialMirror),
        status: Some(StatusEntry::Of(Status::Assumed)),
        rho_d: Some([0.1, 0.2, 0.3]),
        theta_deg: Some(f32::NAN),
        std: Some(StdEntry { alpha_x: Some(f32::INFINITY), ..StdEntry::default() }),
        pixels: Some(3),
        note: Some("out of sight".into()),
        ..GroupEntry::default()
    };
    let mut file = MaterialsFile { version: Some(1), seconds: Some(1.5), ..Default::default() };
    file.groups.insert("z".into(), floor);
    file.groups.insert("a".into(), GroupEntry::default());
    materials::write(&path, &file).unwrap();
    file.groups["z"].theta_deg = None;
    file.groups["z"].std = Some(StdEntry::default());
    assert_eq!(materials::read(&path).unwrap(), file);
    let text = std::fs::read_to_string(&path).unwrap();
    let at = |key: &str| text.find(key).unwrap();
    assert!(at("\"z\"") < at("\"a\"") && at("hypothesis") < at("status"), "{text}");
    assert!(text.contains("partial-mirror") && text.contains("0.1,"), "{text}");
}

#[test]
fn faulty_files_are_named() {
    let folder = Folder::new();
    let path = folder.path("m.json");
    for (text, problem) in [
        ("{", "EOF"),
        ("{}", "missing field `groups`"),
        (r#"{"groups": {"a": {"rho_d": 3}}}"#, "line 1"),
        (r#"{"groups": {"a": {"hypothesis": "shiny"}}}"#, "unknown variant `shiny`"),
        (r#"{"version": 9, "groups": {}}"#, "later version"),
    ] {
        std::fs::write(&path, text).unwrap();
        let error = materials::read(&path).unwrap_err().to_string();
        assert!(error.contains(problem) && error.contains("m.json"), "{error}");
    }
    std::fs::write(&path, r#"{"groups": {"a": {"alpha_x": -1}}}"#).unwrap();
    let error = materials::apply_from(&path, &mut scene(&["a"])).unwrap_err().to_string();
    assert!(error.contains("m.json: the materials' group \"a\": alpha_x"), "{error}");
}

#[test]
fn textures_prefer_the_linear_exr_and_give_way_to_rho_d() {
    let folder = Folder::new();
    let texture = Image::from_fn(2, 1, |x, _| Rgb::splat(if x == 0 { 0.2 } else { 0.3 }));
    picture::write(&folder.path("t.png"), &texture).unwrap();
    let file = parsed(r#"{"groups": {"floor": {"texture": "t.png"}}}"#);
    let mut scene = scene(&["floor"]);
    let first = |scene: &Scene| scene.groups[0].material.texture.as_ref().unwrap().image.clone();

    materials::apply(&file, folder.root(), &mut scene).unwrap();
    assert!((first(&scene).pixels()[0].x - 0.2).abs() < 2e-3);
    picture::write(&folder.path("t.exr"), &texture).unwrap();
    materials::apply(&file, folder.root(), &mut scene).unwrap();
    assert_eq!(first(&scene), texture);
    assert!((scene.groups[0].material.rho_d.x - 0.25).abs() < 1e-6);

    let file = parsed(r#"{"groups": {"floor": {"rho_d": [1, 1, 1]}}}"#);
    let warnings = materials::apply(&file, folder.root(), &mut scene).unwrap();
    assert!(scene.groups[0].material.texture.is_none() && warnings.0.len() == 1);

    let file = parsed(r#"{"groups": {"floor": {"texture": "none.png"}}}"#);
    let error = materials::apply(&file, folder.root(), &mut scene).unwrap_err();
    assert!(error.to_string().contains("none.png"), "{error}");
}
