//! Gamma and vignetting from the photograph itself: from a room photographed by a camera of known
//! response and lens, both are recovered, and the reflectances too.

use crate::kit::coloured_room::{self, EXPOSURE, codes, room};
use crate::kit::folder::Folder;
use glam::Vec3;
use std::process::Command;
use unrender::formats::materials::MaterialsFile;
use unrender::formats::picture::Depth;
use unrender::formats::{gltf, materials, picture};
use unrender::photo::vignetting::Law;
use unrender::scene::{Light, LightKind, Rgb, Scene};

const SIZE: (usize, usize) = (72, 60);

/// A folder with a project of the 8-bit photograph that a camera of this gamma and lens takes.
struct Shot(Folder);

impl Shot {
    fn new(scene: &Scene, gamma: f32, law: Option<Law>, settings: &str) -> Self {
        let folder = Folder::new();
        let codes = codes(scene, &scene.cameras[0], SIZE, (gamma, law));
        picture::write_png_codes(&folder.path("photo.png"), &codes, Depth::Eight).unwrap();
        folder.write("scene.glb", &gltf::to_glb(scene).unwrap());
        let text = format!(
            "scene = \"scene.glb\"\nphoto = \"photo.png\"\nexposure = {EXPOSURE}\n{settings}\n\
             [groups.back]\nknown = {{ rho_d = 0.7 }}\n"
        );
        folder.write("project.toml", &text);
        Self(folder)
    }

    /// Removes the back wall's reflectance from the project.
    fn forget_the_back(&mut self) {
        let path = self.0.path("project.toml");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(path, &text[..text.find("[groups.back]").unwrap()]).unwrap();
    }

    fn recover(&self) -> MaterialsFile {
        let out = self.0.path("out");
        let mut recover = Command::new(env!("CARGO_BIN_EXE_unrender"));
        recover.arg("recover").arg(self.0.path("project.toml")).arg("--out").arg(&out);
        let output = recover.args(["--effort", "draft", "--spp", "4"]).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        println!("{}{}", text(&output.stderr), text(&output.stdout));
        materials::read(&out.join("materials.json")).unwrap()
    }
}

/// The largest error of a reflectance.
fn worst(found: &MaterialsFile) -> f32 {
    coloured_room::worst(|name| Rgb::from_array(found.groups[name].rho_d.unwrap()))
}

const BOTH: &str = "response = \"auto\"\nvignetting = \"auto\"";
/// The largest error of a reflectance that is recovered together with both.
const BOTH_RHO: f32 = 0.005;
const LAW: Law = Law::Radial([-0.4, 0.1, 0.0]);

/// Asserts that `found` is within `deviations` standard deviations of `truth`.
#[track_caller]
fn assert_near(found: f64, truth: f64, std: f64, deviations: f64) {
    assert!((found - truth).abs() <= deviations * std, "{found}, std {std}, against {truth}");
}

#[test]
#[ignore = "slow: gamma and vignetting together are found on every run"]
fn a_gamma_comes_back_and_the_reflectances_with_it() {
    let found = Shot::new(&room(), 1.8, None, "response = \"auto\"").recover();
    let photograph = found.photograph.as_ref().unwrap();
    let std = photograph.std.as_ref().unwrap().gamma.unwrap();
    assert!(std < 0.002, "{std}");
    assert_near(photograph.gamma.unwrap(), 1.8, std, 3.0);
    assert!(worst(&found) < 0.002, "{}", worst(&found));
    assert_eq!((photograph.vignetting, &photograph.note), (None, &None));
}

#[test]
fn gamma_and_vignetting_come_back_together() {
    let found = Shot::new(&room(), 2.4, Some(LAW), BOTH).recover();
    let photograph = found.photograph.as_ref().unwrap();
    let std = photograph.std.as_ref().unwrap();
    assert_near(photograph.gamma.unwrap(), 2.4, std.gamma.unwrap(), 3.0);
    assert_near(photograph.corner.unwrap(), 0.7, std.corner.unwrap(), 3.0);
    let coefficients = photograph.vignetting.unwrap().into_iter().zip(std.vignetting.unwrap());
    for ((found, std), truth) in coefficients.zip([-0.4, 0.1, 0.0]) {
        assert_near(found, truth, std, 3.0);
    }
    assert!(std.corner.unwrap() < 0.01, "{std:?}");
    assert!(worst(&found) < BOTH_RHO, "{}", worst(&found));
}

/// The error if an ordinary camera is assumed instead.
#[test]
#[ignore = "slow: one more recovery"]
fn a_wrong_gamma_spoils_the_reflectances() {
    let ordinary = "response = { gamma = 2.2 }";
    let found = Shot::new(&room(), 2.4, Some(LAW), ordinary).recover();
    assert_eq!(found.photograph, None);
    assert!(worst(&found) > 5.0 * BOTH_RHO, "{}", worst(&found));
}

#[test]
fn a_wall_of_one_colour_in_even_light_tells_nothing() {
    // The sun shines evenly on the back wall alone: for any gamma some reflectance fits.
    let mut scene = room();
    scene.objects.truncate(2);
    scene.objects.remove(0);
    let kind = LightKind::Directional { direction: Vec3::NEG_Z, irradiance: Rgb::splat(3.0) };
    scene.lights = vec![Light { name: "sun".into(), kind }];
    let mut shot = Shot::new(&scene, 1.8, None, "response = \"auto\"");
    shot.forget_the_back();
    let photograph = shot.recover().photograph.unwrap();
    let std = photograph.std.unwrap().gamma.unwrap();
    assert!(std > 0.3, "{std}");
    assert!(photograph.note.unwrap().contains("hardly determines its gamma"));
}
