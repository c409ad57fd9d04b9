//! Project files: what they may say, and a fault a line of the table below.

use std::path::Path;
use unrender::Project;
use unrender::formats::FileError;
use unrender::photo::{Exposure, Response};
use unrender::project::CameraChoice;
use unrender::scene::{Group, Lens, Material, Rgb, Scene, WardModel, Warnings};

const FILES: &str = "scene = \"s.glb\"\nphoto = \"p.png\"\n";

fn parse(text: &str) -> Result<(Project, Warnings), FileError> {
    Project::parse(Path::new("folder/a.toml"), &format!("{FILES}{text}"))
}

fn good(text: &str) -> Project {
    parse(text).unwrap_or_else(|error| panic!("{text}: {error}")).0
}

#[test]
fn a_full_project_is_understood() {
    let project = good(
        "response = \"srgb\"\nexposure = [1, 2, 0.5]\n\
         camera = { eye = [0, 1, 5], target = [0, 1, 0], up = [0, 1, 0], fov_y_deg = 40, \
         principal_point = [0.01, -0.02], k1 = -0.1, k2 = 0.01 }\n\
         [groups.ceil]\nknown = { rho_d = [1, 1, 1] }\n\
         [groups.floor]\nknown = { rho_d = 0.1, rho_s = [0.9, 0.9, 0.9], alpha_x = 0.1, \
         alpha_y = 0.2, theta_deg = 180 }\n\
         [recover]\nbrdf = \"ward-1992\"\nthresholds = { isotropic = 0.02 }\n",
    );
    assert_eq!(project.scene, Path::new("folder/s.glb"));
    assert_eq!(project.response, Some(Response::Srgb));
    assert_eq!(project.exposure, Exposure::Fixed(Rgb::new(1.0, 2.0, 0.5)));
    assert_eq!(project.brdf, WardModel::Ward1992);
    assert_eq!(project.thresholds.paper[4], 0.02);
    assert_eq!(project.known["ceil"].material(), Material::diffuse(Rgb::ONE));
    let floor = project.known["floor"];
    assert_eq!((floor.alpha_y, floor.rho_d), (0.2, Rgb::splat(0.1)));
    assert!((floor.theta_rad - std::f32::consts::PI).abs() < 1e-6);
    let CameraChoice::Placed(camera) = project.camera else { panic!("a placed camera") };
    assert!((camera.fov_y_rad.to_degrees() - 40.0).abs() < 1e-4);
    assert_eq!(camera.lens, Lens { principal_point: [0.01, -0.02], k1: -0.1, k2: 0.01 });
}

#[test]
fn what_is_left_out_has_its_default() {
    let (project, warnings) = parse("").unwrap();
    assert_eq!(warnings.0.len(), 1, "no exposure");
    assert_eq!((project.response, project.brdf), (None, WardModel::WardGmd));
    assert_eq!(project.camera, CameraChoice::First);
    assert_eq!(good("response = { gamma = 2 }").response, Some(Response::Gamma(2.0)));
    assert_eq!(good("camera = \"door\"").camera, CameraChoice::Named("door".into()));
    let anchor = "[anchor]\ngroup = \"wall\"\nrho_d = [0.9, 0.9, 0.9]\n";
    assert_eq!(good(&format!("exposure = \"auto\"\n{anchor}")).exposure, Exposure::Auto);
    assert_eq!(good(anchor).exposure, Exposure::Auto);
    let (_, warnings) = parse(&format!("exposure = 2\n{anchor}")).unwrap();
    assert!(warnings.0[0].contains("[anchor]"));
}

#[test]
fn every_fault_names_its_key_or_line() {
    let faults = [
        ("exposur = 1", "line 3: unknown field `exposur`"),
        ("exposure = = 1", "line 3"),
        ("exposure = \"auto\"", "needs a table [anchor]"),
        ("exposure = \"bright\"", "exposure: there is no \"bright\""),
        ("exposure = -1", "exposure is -1"),
        ("exposure = nan", "exposure is nan"),
        ("exposure = [1, 2]", "exposure is [1, 2]"),
        ("response = \"sRGB\"", "response: there is no \"sRGB\""),
        ("response = \"curve.csv\"", "not read yet"),
        ("response = { gamma = 0 }", "response.gamma is 0"),
        ("response = { gama = 2 }", "response: give"),
        ("response = 3", "response: give"),
        ("[anchor]\ngroup = \"w\"", "line 3: missing field `rho_d`"),
        ("[anchor]\ngroup = \"w\"\nrho_d = 1.5", "anchor.rho_d is 1.5"),
        ("[anchor]\ngroup = \"w\"\nrho_d = [0, 1, 1]", "anchor.rho_d: a channel is zero"),
        ("[groups.a]\nknown = { }", "groups.a.known: give rho_d"),
        ("[groups.a]\nknown = { rho_d = [1, 1, 2] }", "groups.a.known.rho_d is [1, 1, 2]"),
        ("[groups.a]\nknown = { rho_d = true }", "groups.a.known.rho_d is true"),
        ("[groups.a]\nknown = { rho_s = 1, alpha_x = -1 }", "groups.a.known.alpha_x is -1"),
        ("[groups.a]\nknown = { rho_s = 1, alpha_y = inf }", "alpha_x is inf"),
        ("[groups.a]\nknown = { rho_s = 1, alpha_x = 0.1, alpha_y = 0 }", "both"),
        ("[groups.a]\nknown = { rho_s = 1, theta_deg = nan }", "theta_deg is"),
        ("[groups.a]\nfixed = 1", "line 4: unknown field `fixed`"),
        ("[recover]\nbrdf = \"phong\"", "recover.brdf: unknown brdf \"phong\""),
        ("[recover]\nthresholds = { shiny = 1 }", "recover.thresholds.shiny"),
        ("[recover]\nthresholds = { diffuse = 0 }", "recover.thresholds.diffuse is 0"),
        ("camera = 3", "camera: give a name"),
        ("camera = { eye = [0, 0, 0] }", "camera: missing field"),
        ("camera = { eye = [0,0,1], target = [0,0,1], fov_y_deg = 40 }", "camera: eye and"),
        ("camera = { eye = [0,5,0], target = [0,0,0], fov_y_deg = 40 }", "camera.up"),
        ("camera = { eye = [0,0,5], target = [0,0,0], fov_y_deg = 180 }", "camera.fov_y_deg"),
        (
            "camera = { eye = [0,0,5], target = [0,0,0], fov_y_deg = 40, principal_point = [320, 9] }",
            "camera.principal_point is [320.0, 9.0]",
        ),
        ("camera = { eye = [0,0,5], target = [0,0,0], fov_y_deg = 40, k1 = nan }", "camera.k1 is"),
    ];
    for (text, problem) in faults {
        let error = parse(text).expect_err(text).to_string();
        assert!(error.starts_with("folder/a.toml: ") && error.contains(problem), "{text}: {error}");
    }
    let error = Project::parse(Path::new("a.toml"), "photo = \"p\"").unwrap_err();
    assert!(error.to_string().contains("missing field `scene`"), "{error}");
}

#[test]
fn names_are_checked_against_the_scene() {
    let group = |name: &str, emission| Group {
        name: name.into(),
        material: Material::diffuse(Rgb::ONE),
        emission,
    };
    let groups = vec![group("wall", Rgb::ZERO), group("lamp", Rgb::ONE)];
    let scene = Scene { groups, ..Scene::default() };
    let check = |text: &str| good(text).check_against(&scene).map_err(|e| e.to_string());
    assert_eq!(check("[groups.wall]\nknown = { rho_d = 1 }"), Ok(()));
    let error = check("[groups.wal]\nknown = { rho_d = 1 }").unwrap_err();
    assert!(error.contains("groups.wal: ") && error.contains("it has wall, lamp"), "{error}");
    let error = check("[anchor]\ngroup = \"lamp\"\nrho_d = 1").unwrap_err();
    assert!(error.contains("anchor.group: the group emits"), "{error}");
    let error = check("camera = \"door\"").unwrap_err();
    assert!(error.contains("camera: the scene has no \"door\"; it has none"), "{error}");
}

#[test]
fn the_readmes_project_files_are_understood() {
    let readme = include_str!("../../../README.md");
    let blocks: Vec<&str> = readme.split("```toml\n").skip(1).collect();
    assert_eq!(blocks.len(), 2, "a whole project, and a camera as a table");
    for block in blocks {
        let text = block.split("```").next().unwrap();
        let files = if text.contains("scene = ") { "" } else { FILES };
        let read = Project::parse(Path::new("readme.toml"), &format!("{files}{text}"));
        assert!(read.is_ok(), "{:?} in {text}", read.err());
    }
}
