//! Project files: valid ones, and in each line of the tables below an invalid one.

use crate::kit::project_text::{are_refused, good, parse};
use glam::Vec3;
use std::path::Path;
use unrender::formats::LightUnits;
use unrender::photo::vignetting::Law;
use unrender::photo::{Exposure, Response};
use unrender::project::{CameraChoice, ResponseChoice, VignettingChoice};
use unrender::scene::{
    Environment, Group, Hypothesis, Lens, Light, LightKind, Material, Rgb, RgbImage, Scene,
    WardModel,
};
use unrender::{Job, Project};

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
    assert_eq!(project.response, Some(ResponseChoice::Stated(Response::Srgb)));
    assert_eq!((project.black_level, project.vignetting), (Rgb::ZERO, None));
    assert_eq!(project.exposure, Exposure::Fixed(Rgb::new(1.0, 2.0, 0.5)));
    assert_eq!(project.brdf, Some(WardModel::Ward1992.into()));
    assert_eq!(project.paper_thresholds[4], 0.02);
    let model = WardModel::Ward1992.into();
    assert_eq!(project.known["ceil"].material(model), Ok(Material::diffuse(Rgb::ONE)));
    let floor = &project.known["floor"];
    assert_eq!((floor.alpha_y, floor.rho_d), (0.2, Rgb::splat(0.1)));
    assert!((floor.theta_rad - std::f32::consts::PI).abs() < 1e-6);
    let CameraChoice::Placed(camera) = project.camera else { panic!("a placed camera") };
    assert!((camera.fov_y_deg - 40.0).abs() < 1e-4);
    assert_eq!(
        camera.lens,
        Lens { principal_point: [0.01, -0.02], k1: -0.1, k2: 0.01, ..Lens::default() }
    );
}

#[test]
fn rungs_are_a_list_or_all_up_to_one() {
    use Hypothesis::{Anisotropic, Diffuse, Isotropic, Mirror};
    let project = good(
        "[recover]\nmax_rung = \"mirror\"\n[groups.a]\nrungs = [\"anisotropic\", \"isotropic\"]\n\
         [groups.b]\nsame_as = \"a\"\n",
    );
    assert_eq!(project.rungs_of("wall"), [Diffuse, Mirror]);
    assert_eq!(project.rungs_of("a"), [Isotropic, Anisotropic]);
    assert_eq!(project.same_as["b"], "a");
    assert_eq!(good("").rungs_of("wall"), Hypothesis::ALL);
}

#[test]
fn what_is_left_out_has_its_default() {
    let (project, warnings) = parse("").unwrap();
    assert_eq!(warnings.0.len(), 1, "no exposure");
    assert_eq!((project.response, project.brdf), (None, None));
    assert_eq!((project.camera, project.light_units), (CameraChoice::First, None));
    let gamma = ResponseChoice::Stated(Response::Gamma(2.0));
    assert_eq!(good("response = { gamma = 2 }").response, Some(gamma));
    let measured = ResponseChoice::Measured("folder/curves/mine.csv".into());
    assert_eq!(good("response = \"curves/mine.csv\"").response, Some(measured));
    let light_units = |name: &str| good(&format!("light_units = \"{name}\"")).light_units;
    assert_eq!(light_units("blender-standard"), Some(LightUnits::BlenderStandard));
    assert_eq!(light_units("radiometric"), Some(LightUnits::Radiometric));
    let vignetting = |text: &str| good(&format!("vignetting = {text}")).vignetting;
    assert_eq!(vignetting("\"cos4\""), Some(VignettingChoice::Stated(Law::Cos4)));
    assert_eq!(vignetting("\"auto\""), Some(VignettingChoice::Auto));
    assert_eq!(good("response = \"auto\"").response, Some(ResponseChoice::Auto));
    let radial = VignettingChoice::Stated(Law::Radial([-0.3, 0.1, 0.0]));
    assert_eq!(vignetting("{ radial = [-0.3, 0.1] }"), Some(radial));
    assert_eq!(good("black_level = 0.01").black_level, Rgb::splat(0.01));
    assert_eq!(good("black_level = [0, 0.1, 0.2]").black_level, Rgb::new(0.0, 0.1, 0.2));
    assert_eq!(good("").white_level, None);
    assert_eq!(good("white_level = [1, 0.9, 2]").white_level, Some(Rgb::new(1.0, 0.9, 2.0)));
    assert_eq!(good("camera = \"door\"").camera, CameraChoice::Named("door".into()));
    let anchor = "[anchor]\ngroup = \"wall\"\nrho_d = [0.9, 0.9, 0.9]\n";
    assert_eq!(good(&format!("exposure = \"auto\"\n{anchor}")).exposure, Exposure::Auto);
    assert_eq!(good(anchor).exposure, Exposure::Auto);
    let (_, warnings) = parse(&format!("exposure = 2\n{anchor}")).unwrap();
    assert!(warnings.0[0].contains("[anchor]"));
}

#[test]
fn faults_of_light_and_of_what_counts_name_their_key_or_line() {
    are_refused(&[
        ("mask = 3", "line 3: invalid type"),
        ("[groups.a]\nignore = 1", "line 4: invalid type"),
        (
            "[groups.a]\nignore = true\nmax_rung = \"diffuse\"",
            "groups.a: with ignore = true nothing",
        ),
        ("[groups.w]\nignore = true\n[anchor]\ngroup = \"w\"\nrho_d = 1", "take another group"),
        ("lights = 3", "line 3: invalid type: integer `3`, expected tables [lights.NAME] or"),
        ("[[lights]]\nscale = 2", "line 3: missing field `name`"),
        ("[[lights]]\nname = \"a\"\nscal = 2", "line 5: unknown field `scal`"),
        ("[[lights]]\nname = \"a\"\nscale = -1", "line 5: -1 cannot be; light is not negative"),
        ("[[lights]]\nname = \"a\"\nstrength = nan", "line 5: nan is not a finite number"),
        ("[[lights]]\nname = \"a\"\nadd = \"tube\"", "line 5: unknown variant `tube`"),
        (
            "[[lights]]\nname = \"a\"\nadd = \"sphere\"\nstrength = 1\nradius = 0",
            "is not above zero",
        ),
        (
            "[[lights]]\nname = \"a\"\nadd = \"sphere\"\nstrength = 1\nposition = [0, 0, 0]",
            "lights.a: a sphere needs its radius",
        ),
        (
            "[[lights]]\nname = \"a\"\nadd = \"point\"\nposition = [0, 0, 0]\nstrength = 1e30\n\
             scale = 1e30",
            "lights.a: strength times scale is not a finite number",
        ),
        ("[[lights]]\nname = \"a\"\nradius = 1", "lights.a: size, radius, inner_deg and outer"),
        ("[[lights]]\nname = \"a\"\nposition = [0, 1, 0]", "lights.a: move = [x, y, z] moves"),
        ("[[lights]]\nname = \"a\"\n[[lights]]\nname = \"a\"", "lights.a: the list [[lights]] has"),
        ("[[lights]]\nname = \"a\"\nremove = true\nunknown = true", "lights.a: a light that is"),
        (
            "[[lights]]\nname = \"a\"\ncolor = 1",
            "lights.a: color and same_color_as are for lights with",
        ),
        (
            "[[lights]]\nname = \"a\"\nunknown = true\ncolour = 0",
            "lights.a.color: a light cannot be black",
        ),
        ("[[lights]]\nname = \"a\"\nunknown = true\ncolor = -1", "line 6: -1 cannot be"),
        (
            "[[lights]]\nname = \"a\"\nunknown = true\ncolor = 1\nsame_color_as = \"b\"",
            "lights.a: give color or same_color_as, not both",
        ),
        (
            "[[lights]]\nname = \"a\"\nunknown = true\nsame_colour_as = \"a\"",
            "lights.a.same_color_as: it names the light itself",
        ),
        (
            "[[lights]]\nname = \"a\"\nunknown = true\nsame_color_as = \"b\"\n[[lights]]\nname = \"b\"\n\
             unknown = true",
            "lights.a.same_color_as: the colour of \"b\" is unknown too",
        ),
        ("[environment]", "environment: give one of file (a panorama)"),
        ("[environment]\nfile = \"a.hdr\"\npanorama = \"a.hdr\"", "line 3: duplicate field `file`"),
        (
            "[environment]\nfile = \"a.hdr\"\ncolor = 1",
            "environment: give one of file (a panorama)",
        ),
        ("[environment]\ncolor = [1, inf, 1]", "line 4: inf is not a finite number"),
        ("[environment]\ncolor = -0.1", "line 4: -0.1 cannot be; light is not negative"),
        ("[environment]\ncolor = 1\nscale = 2", "rotation_deg and scale are for a panorama"),
        ("[environment]\nfile = \"a.hdr\"\nscale = 0", "line 5: 0 is not above zero"),
        ("[environment]\nunknown = \"dark\"", "line 4: "),
        ("[environment]\nunknown = true\nremove = true", "environment: it is unknown or removed"),
    ]);
}

#[test]
fn faults_of_what_is_known_of_groups_name_their_key() {
    are_refused(&[
        ("[groups.a]\nrungs = \"diffuse\"", "line 4: invalid type"),
        ("[groups.a]\nrungs = []", "groups.a.rungs: it is empty"),
        ("[groups.a]\nrungs = [\"shiny\"]", "groups.a.rungs: "),
        ("[groups.a]\nrungs = [\"mirror\"]\nmax_rung = \"mirror\"", "groups.a: rungs and max_rung"),
        ("[groups.a]\nrungs = [\"mirror\"]\nignore = true", "leave out rungs"),
        ("[recover]\nrungs = [\"shiny\"]", "recover.rungs: "),
        ("[groups.a]\nsame_as = \"a\"", "groups.a.same_as: it names the group itself"),
        (
            "[groups.a]\nsame_as = \"b\"\n[groups.b]\nsame_as = \"c\"",
            "groups.a.same_as: groups.b has same_as = \"c\" itself",
        ),
        ("[groups.a]\nsame_as = \"b\"\nknown = { rho_d = 1 }", "known belongs to groups.b"),
        ("[groups.a]\nsame_as = \"b\"\nmax_rung = \"diffuse\"", "max_rung belongs to groups.b"),
        (
            "[groups.a]\nsame_as = \"b\"\n[anchor]\ngroup = \"a\"\nrho_d = 1",
            "anchor.group: groups.a has same_as = \"b\"; take that one",
        ),
    ]);
}

#[test]
fn colours_may_be_spelt_either_way() {
    let of = |word: &str| good(&format!("[environment]\n{word} = [1, 0.9, 0.8]")).environment;
    assert!(of("color").is_some());
    assert_eq!(of("colour"), of("color"));
}

#[test]
fn the_two_forms_of_lights_say_what_to_do() {
    are_refused(&[
        (
            "[[lights]]\nname = \"a\"\nunknown = true\n[lights.b]\nunknown = true",
            "not both in one file: write the table as an entry of the list",
        ),
        (
            "[lights.b]\nunknown = true\n[[lights]]\nname = \"a\"\nunknown = true",
            "not both in one file: write the table as an entry of the list",
        ),
        (
            "[lights.b]\nunknown = true\ncolour = [1, 0.9, 0.8]",
            "the colour of an unknown light goes into a list: instead of [lights.NAME] write [[lights]]",
        ),
        (
            "[lights.b]\nunknown = true\nsame_color_as = \"a\"",
            "the colour of an unknown light goes into a list",
        ),
        ("[lights.b]\nunknown = true\nfoo = 1", "line 5: unknown field `foo`, expected `unknown`"),
        ("[groups.a]\nignore = true\n[groups.a]\nignore = true", "duplicate key"),
    ]);
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
        ("response = { gamma = 0 }", "response.gamma is 0"),
        ("response = { gama = 2 }", "response: give"),
        ("response = 3", "response: give"),
        ("response = { gamma = -2.2 }", "response.gamma is -2.2"),
        ("black_level = -0.1", "black_level is -0.1"),
        ("black_level = 16", "divide that of an 8-bit file by 255"),
        ("black_level = [0, 0]", "black_level is [0, 0]"),
        ("black_level = nan", "black_level is nan"),
        ("white_level = 0", "white_level is 0; it is a code above black_level"),
        ("white_level = nan", "white_level is nan"),
        ("white_level = [1, inf, 1]", "white_level is [1, inf, 1]"),
        ("black_level = 0.2\nwhite_level = [1, 0.2, 1]", "white_level is [1, 0.2, 1]"),
        ("white_level = [1, 1]", "white_level is [1, 1]; give a number or three"),
        ("light_units = \"lumen\"", "light_units: there are no light units \"lumen\""),
        ("light_units = 683", "invalid type"),
        ("vignetting = \"strong\"", "vignetting: there is no \"strong\""),
        ("vignetting = 0.5", "vignetting: give \"cos4\""),
        ("vignetting = { radial = 0.5 }", "vignetting: give \"cos4\""),
        ("vignetting = { radial = [] }", "vignetting.radial is []"),
        ("vignetting = { radial = [1, 2, 3, 4] }", "give one to three numbers"),
        ("vignetting = { radial = [nan] }", "vignetting.radial is [nan]"),
        ("vignetting = { cos = 4 }", "vignetting: give \"cos4\""),
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
        ("[lights.a]", "line 3: missing field `unknown`"),
        ("[lights.a]\nunknown = 1", "line 4: invalid type"),
        ("[lights.a]\nunkown = true", "line 4: unknown field `unkown`"),
        ("[recover]\nbrdf = \"phong\"", "recover.brdf: unknown brdf \"phong\""),
        ("[recover]\nthresholds = { shiny = 1 }", "recover.thresholds.shiny"),
        ("[recover]\nthresholds = { diffuse = 0 }", "recover.thresholds.diffuse is 0"),
        ("camera = 3", "camera: give a name"),
        ("camera = { eye = [0, 0, 0] }", "camera: give eye and target with"),
        ("camera = { eye = [0,0,1], target = [0,0,1], fov_y_deg = 40 }", "camera: eye and"),
        ("camera = { eye = [0,5,0], target = [0,0,0], fov_y_deg = 40 }", "camera.up"),
        ("camera = { eye = [0,0,5], target = [0,0,0], fov_y_deg = 180 }", "camera.fov_y_deg"),
        (
            "camera = { eye = [0,0,5], target = [0,0,0], fov_y_deg = 40, principal_point = [320, 9] }",
            "camera.principal_point is [320.0, 9.0]",
        ),
        ("camera = { eye = [0,0,5], target = [0,0,0], fov_y_deg = 40, k1 = nan }", "camera.k1 is"),
        (
            "camera = { eye = [0,0,5], target = [0,0,0], fov_y_deg = 40, fx_over_fy = 0 }",
            "is 0; it",
        ),
    ];
    are_refused(&faults);
    let error = Project::parse(Path::new("a.toml"), "photo = \"p\"").unwrap_err();
    assert!(error.to_string().contains("missing field `scene`"), "{error}");
}

/// A scene of a wall, of groups that emit and of lights from above.
fn lit(emitters: &[(&str, Rgb)], lights: &[&str]) -> Scene {
    let group = |name: &str, emission| Group {
        name: name.into(),
        material: Material::diffuse(Rgb::ONE),
        emission,
    };
    let kind = LightKind::Directional { direction: Vec3::NEG_Y, irradiance: Rgb::ONE };
    Scene {
        groups: std::iter::once(group("wall", Rgb::ZERO))
            .chain(emitters.iter().map(|(name, emission)| group(name, *emission)))
            .collect(),
        lights: lights
            .iter()
            .map(|&name| Light { name: name.into(), kind: kind.clone() })
            .collect(),
        ..Scene::default()
    }
}

#[test]
fn names_are_checked_against_the_scene() {
    let scene = lit(&[("lamp", Rgb::ONE)], &[]);
    let check = |text: &str| good(text).check_against(&scene).map_err(|e| e.to_string());
    assert_eq!(check("[groups.wall]\nknown = { rho_d = 1 }"), Ok(()));
    let error = check("[groups.wal]\nknown = { rho_d = 1 }").unwrap_err();
    assert!(error.contains("groups.wal: ") && error.contains("it has wall, lamp"), "{error}");
    let error = check("[anchor]\ngroup = \"lamp\"\nrho_d = 1").unwrap_err();
    assert!(error.contains("anchor.group: the group emits"), "{error}");
    let error = check("[groups.wall]\nsame_as = \"floor\"").unwrap_err();
    assert!(error.contains("groups.wall.same_as: the scene has no group \"floor\""), "{error}");
    let error = check("[groups.wall]\nsame_as = \"lamp\"").unwrap_err();
    assert!(error.contains("groups.wall.same_as: one of the two emits light"), "{error}");
    let error = check("camera = \"door\"").unwrap_err();
    assert!(error.contains("camera: the scene has no \"door\"; it has none"), "{error}");
}

#[test]
fn lights_are_unknown_where_the_project_says_so() {
    let text = "[lights.sun]\nunknown = true\n[lights.lamp]\nunknown = false\n";
    let project = good(text);
    assert_eq!(project.unknown_lights.iter().collect::<Vec<_>>(), ["sun"]);
    assert_eq!(project.known_lights.iter().collect::<Vec<_>>(), ["lamp"]);
    let mut scene = lit(&[("lamp", Rgb::ONE)], &["sun"]);
    let check = |scene: &Scene| project.check_against(scene).map_err(|e| e.to_string());
    assert_eq!(check(&scene), Ok(()));
    scene.groups[1].emission = Rgb::ZERO;
    let error = check(&scene).unwrap_err();
    assert!(error.contains("no light \"lamp\"; it has sun; the group"), "{error}");
    let error = check(&lit(&[("lamp", Rgb::ONE), ("ball", Rgb::ONE)], &["son"])).unwrap_err();
    assert!(error.starts_with("folder/a.toml: lights.sun: "), "{error}");
    assert!(error.ends_with("no light \"sun\"; it has lamp, ball, son"), "{error}");
    let error = check(&lit(&[("lamp", Rgb::ONE)], &["sun", "sun"])).unwrap_err();
    assert!(error.contains("lights.sun: the scene has 2 lights of this name"), "{error}");
}

const UNKNOWN_LAMP: &str = "[lights.lamp]\nunknown = true\n";
const ANCHOR: &str = "[anchor]\ngroup = \"wall\"\nrho_d = [0.9, 0.9, 0.9]\n";
const LOOSE: &str = "folder/a.toml: every light is unknown and no reflectance is known: light and \
    reflectance can be separated only up to one common factor. Give an [anchor], a known group, or \
    one light's intensity";

/// The project after [`Project::settle_scale`], and its warnings.
fn settled(text: &str, scene: &Scene) -> Result<(Project, Vec<String>), String> {
    let mut project = good(text);
    project.check_against(scene).map_err(|e| e.to_string())?;
    let warnings = project.settle_scale(scene).map_err(|e| e.to_string())?;
    Ok((project, warnings.0))
}

#[test]
fn something_must_fix_the_scale_of_unknown_lights() {
    let scene = lit(&[("lamp", Rgb::ONE)], &[]);
    let fixed = format!("exposure = 2\n{UNKNOWN_LAMP}");
    assert_eq!(settled(&fixed, &scene).unwrap_err(), LOOSE);
    for known in ["wall]\nknown = { rho_d = 0 }", "lamp]\nknown = { rho_d = 1 }"] {
        assert_eq!(settled(&format!("{fixed}[groups.{known}"), &scene).unwrap_err(), LOOSE);
    }
    for known in ["rho_d = 0.1", "rho_s = 0.1"] {
        let text = format!("{fixed}[groups.wall]\nknown = {{ {known} }}");
        assert_eq!(settled(&text, &scene).unwrap().1, [""; 0]);
    }
    let two = lit(&[("lamp", Rgb::ONE)], &["sun"]);
    assert_eq!(settled(&fixed, &two).unwrap().1, [""; 0]);
    assert!(settled(&format!("{fixed}[lights.sun]\nunknown = true"), &two).is_err());
    let removed = "exposure = 2\n[[lights]]\nname = \"lamp\"\nunknown = true\n\
        [[lights]]\nname = \"fire\"\nremove = true\n";
    let fire = lit(&[("lamp", Rgb::ONE), ("fire", Rgb::ONE)], &[]);
    assert_eq!(settled(removed, &fire).unwrap_err(), LOOSE);
    // So does an environment, in the channels in which it emits.
    let mut around = lit(&[("lamp", Rgb::ONE)], &[]);
    let mut surround = |color| {
        let panorama = RgbImage::new(1, 1, vec![color]);
        around.environment = Environment::new(panorama, 0.0).ok();
        settled(&fixed, &around).map(|(_, warnings)| warnings)
    };
    assert_eq!(surround(Rgb::splat(0.1)), Ok(Vec::new()));
    assert!(surround(Rgb::new(0.1, 0.0, 0.1)).unwrap_err().contains("in green every light is"));
    assert_eq!(settled("exposure = 2", &scene).unwrap().1, [""; 0]);
}

#[test]
fn the_scale_is_fixed_in_every_channel() {
    let warm = lit(&[("lamp", Rgb::ONE), ("fire", Rgb::new(1.0, 0.5, 0.0))], &[]);
    let fixed = format!("exposure = 2\n{UNKNOWN_LAMP}");
    let error = settled(&fixed, &warm).unwrap_err();
    assert!(error.contains("a.toml: in blue every light is unknown and"), "{error}");
    let text = format!("{fixed}[groups.wall]\nknown = {{ rho_d = [0, 0, 0.5] }}");
    assert_eq!(settled(&text, &warm).unwrap().1, [""; 0]);
    let error =
        settled(&format!("exposure = \"auto\"\n{ANCHOR}{UNKNOWN_LAMP}"), &warm).unwrap_err();
    assert!(error.contains("in blue every light is unknown, and so is the exposure"), "{error}");
    // A channel without any light needs nothing.
    let red = lit(&[("lamp", Rgb::X)], &[]);
    let error = settled(&fixed, &red).unwrap_err();
    assert_eq!(error, LOOSE);
    let text = format!("{fixed}[groups.wall]\nknown = {{ rho_d = [0.5, 0, 0] }}");
    let told = settled(&text, &red).unwrap().1;
    assert!(told[0].contains("\"lamp\" has no green and blue in the scene"), "{told:?}");
    let mut black = lit(&[("lamp", Rgb::ONE)], &["sun"]);
    *black.strength_mut(2).unwrap() = Rgb::ZERO;
    let error = settled("[lights.sun]\nunknown = true", &black).unwrap_err();
    assert!(error.contains("lights.sun: the light is black in the scene"), "{error}");
}

#[test]
fn an_anchor_serves_unknown_exposures_and_unknown_lights() {
    let (one, two) = (lit(&[("lamp", Rgb::ONE)], &[]), lit(&[("lamp", Rgb::ONE)], &["sun"]));
    let stated = format!("exposure = 2\n{ANCHOR}");
    assert_eq!(good(&stated).used_anchor(), None);
    let (project, warnings) = parse(&format!("{stated}{UNKNOWN_LAMP}")).unwrap();
    assert_eq!(warnings.0, [""; 0]);
    assert_eq!(project.used_anchor().unwrap().group, "wall");
    let (project, warnings) = settled(&format!("{stated}{UNKNOWN_LAMP}"), &one).unwrap();
    assert_eq!((project.exposure, warnings.len()), (Exposure::Fixed(Rgb::splat(2.0)), 0));

    let auto = format!("exposure = \"auto\"\n{ANCHOR}{UNKNOWN_LAMP}");
    let (project, warnings) = settled(&auto, &two).unwrap();
    assert_eq!((project.exposure, warnings.len()), (Exposure::Auto, 0));
    let (project, warnings) = settled(&auto, &one).unwrap();
    assert_eq!(project.exposure, Exposure::Fixed(Rgb::ONE));
    assert!(warnings[0].contains("per unit of exposure"), "{warnings:?}");
    assert_eq!(project.used_anchor().unwrap().group, "wall");
}

#[test]
fn a_job_counts_unknown_lights_as_the_renderer_does() {
    let scene = lit(&[("lamp", Rgb::ONE), ("fire", Rgb::ONE)], &["sun", "moon"]);
    let project = good("[lights.moon]\nunknown = true\n[lights.fire]\nunknown = true\n");
    assert_eq!(project.unknown_sources(&scene), [2, 4]);
    let fig8 = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/fig8");
    let text = "scene = \"scene.glb\"\nphoto = \"photo.exr\"\nresponse = \"linear\"\n\
        exposure = \"auto\"\n[anchor]\ngroup = \"floor\"\nrho_d = 0.1\n\
        [lights.light]\nunknown = true\n";
    let (project, warnings) = Project::parse(&fig8.join("a.toml"), text).unwrap();
    let job = Job::load(project, warnings).unwrap();
    assert_eq!(job.unknown_lights, [job.scene.group_index("light").unwrap()]);
    assert_eq!(job.project.exposure, Exposure::Fixed(Rgb::ONE));
    assert_eq!(job.warnings.0.len(), 1, "{:?}", job.warnings);
}
