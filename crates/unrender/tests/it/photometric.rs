//! Gamma and vignetting from the photograph itself: a room photographed by a camera of known
//! response and lens must give both back, and the reflectances with them.

use glam::{Vec2, Vec3};
use std::path::PathBuf;
use std::process::Command;
use unrender::formats::materials::MaterialsFile;
use unrender::formats::{gltf, materials, picture};
use unrender::photo::vignetting::Law;
use unrender::photo::{Response, Transfer, Vignetting};
use unrender::render::{Settings, Tracer};
use unrender::scene::{
    Camera, Group, Light, LightKind, Material, Mesh, Object, Rgb, RgbImage, Scene, WardModel, color,
};

const SIZE: (usize, usize) = (72, 60);
const EXPOSURE: f32 = 2.4;
const RHO: [(&str, [f32; 3]); 5] = [
    ("floor", [0.5, 0.4, 0.3]),
    ("back", [0.7, 0.7, 0.7]),
    ("left", [0.6, 0.2, 0.15]),
    ("right", [0.2, 0.5, 0.3]),
    ("ceiling", [0.8, 0.8, 0.8]),
];

/// A square about `centre`, its front towards `normal`.
fn square(group: usize, centre: Vec3, normal: Vec3, half: f32) -> Object {
    let x = if normal.x.abs() > 0.5 { Vec3::Z } else { Vec3::X };
    let y = normal.cross(x);
    let corner = |u: f32, v: f32| centre + half * (u * x + v * y);
    let positions =
        vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mesh = Mesh {
        normals: vec![normal; 4],
        tangents: vec![x.extend(1.0); 4],
        uvs: vec![Vec2::ZERO; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        positions,
    };
    Object { name: format!("square {group}"), group, mesh }
}

fn room() -> Scene {
    let camera = Camera::look_at(
        "camera",
        Vec3::new(0.1, 0.0, 2.6),
        Vec3::new(0.0, -0.05, 0.0),
        Vec3::Y,
        0.9,
    );
    let group = |(name, rho_d): (&str, [f32; 3])| Group {
        name: name.to_owned(),
        material: Material::diffuse(Rgb::from_array(rho_d)),
        emission: Rgb::ZERO,
    };
    let lamp = Group { emission: Rgb::splat(12.0), ..group(("lamp", [0.0; 3])) };
    let mut scene = Scene {
        objects: vec![
            square(0, Vec3::NEG_Y, Vec3::Y, 1.0),
            square(1, Vec3::NEG_Z, Vec3::Z, 1.0),
            square(2, Vec3::NEG_X, Vec3::X, 1.0),
            square(3, Vec3::X, Vec3::NEG_X, 1.0),
            square(4, Vec3::Y, Vec3::NEG_Y, 1.0),
            square(5, 0.98 * Vec3::Y, Vec3::NEG_Y, 0.3),
        ],
        groups: RHO.into_iter().map(group).chain([lamp]).collect(),
        cameras: vec![camera],
        brdf: WardModel::WardGmd.into(),
        ..Scene::default()
    };
    scene.validate().unwrap();
    scene
}

/// A folder with a project of the 8-bit photograph that a camera of this gamma and lens takes.
struct Shot(PathBuf);

impl Shot {
    fn new(test: &str, scene: &Scene, gamma: f32, law: Option<Law>, settings: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("unrender-{}-{test}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let camera = scene.cameras[0].clone();
        let render = Settings { spp: 256, seed: 77, ..Settings::default() };
        let tracer = Tracer::new(scene);
        let radiance = tracer.render(&scene.materials(), &camera, SIZE, &render, &|_| {}).mean;
        let vignetting = law.map(|law| Vignetting { law, camera, size: SIZE });
        let exposure = Rgb::splat(EXPOSURE);
        let transfer = Transfer { vignetting, ..Transfer::plain(Response::Gamma(gamma), exposure) };
        // The writer encodes by sRGB and rounds to 8 bits.
        let decoded = |code: Rgb| Rgb::from_array(code.to_array().map(color::linear_from_srgb));
        let as_linear: RgbImage = transfer.codes(&radiance).map(|code| decoded(*code));
        picture::write(&folder.join("photo.png"), &as_linear).unwrap();
        std::fs::write(folder.join("scene.glb"), gltf::to_glb(scene).unwrap()).unwrap();
        let text = format!(
            "scene = \"scene.glb\"\nphoto = \"photo.png\"\nexposure = {EXPOSURE}\n{settings}\n\
             [groups.back]\nknown = {{ rho_d = 0.7 }}\n"
        );
        std::fs::write(folder.join("project.toml"), text).unwrap();
        Self(folder)
    }

    /// Takes the back wall's reflectance out of the project.
    fn forget_the_back(&mut self) {
        let path = self.0.join("project.toml");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(path, &text[..text.find("[groups.back]").unwrap()]).unwrap();
    }

    fn recover(&self) -> MaterialsFile {
        let out = self.0.join("out");
        let mut recover = Command::new(env!("CARGO_BIN_EXE_unrender"));
        recover.arg("recover").arg(self.0.join("project.toml")).arg("--out").arg(&out);
        let output = recover.args(["--effort", "draft", "--spp", "4"]).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        println!("{}{}", text(&output.stderr), text(&output.stdout));
        materials::read(&out.join("materials.json")).unwrap()
    }
}

impl Drop for Shot {
    fn drop(&mut self) {
        // A folder that is left behind in the temporary files does no harm.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The largest error of a reflectance.
fn worst(found: &MaterialsFile) -> f32 {
    let error = |(name, rho): (&str, [f32; 3])| {
        let rho_d = Rgb::from_array(found.groups[name].rho_d.unwrap());
        (rho_d - Rgb::from_array(rho)).abs().max_element()
    };
    RHO.into_iter().map(error).fold(0.0, f32::max)
}

const BOTH: &str = "response = \"auto\"\nvignetting = \"auto\"";
/// The largest error of a reflectance that is found together with both.
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
    let found = Shot::new("gamma", &room(), 1.8, None, "response = \"auto\"").recover();
    let photograph = found.photograph.as_ref().unwrap();
    let std = photograph.std.as_ref().unwrap().gamma.unwrap();
    assert!(std < 0.002, "{std}");
    assert_near(photograph.gamma.unwrap(), 1.8, std, 3.0);
    assert!(worst(&found) < 0.002, "{}", worst(&found));
    assert_eq!((photograph.vignetting, &photograph.note), (None, &None));
}

#[test]
fn gamma_and_vignetting_come_back_together() {
    let found = Shot::new("both", &room(), 2.4, Some(LAW), BOTH).recover();
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

/// What it costs to believe in an ordinary camera instead.
#[test]
#[ignore = "slow: one more recovery"]
fn a_wrong_gamma_spoils_the_reflectances() {
    let ordinary = "response = { gamma = 2.2 }";
    let found = Shot::new("believed", &room(), 2.4, Some(LAW), ordinary).recover();
    assert_eq!(found.photograph, None);
    assert!(worst(&found) > 5.0 * BOTH_RHO, "{}", worst(&found));
}

#[test]
fn a_wall_of_one_colour_in_even_light_tells_nothing() {
    // The sun shines on the back wall alone, evenly: any gamma has its own reflectance.
    let mut scene = room();
    scene.objects.truncate(2);
    scene.objects.remove(0);
    let kind = LightKind::Directional { direction: Vec3::NEG_Z, irradiance: Rgb::splat(3.0) };
    scene.lights = vec![Light { name: "sun".into(), kind }];
    let mut shot = Shot::new("even", &scene, 1.8, None, "response = \"auto\"");
    shot.forget_the_back();
    let photograph = shot.recover().photograph.unwrap();
    let std = photograph.std.unwrap().gamma.unwrap();
    assert!(std > 0.3, "{std}");
    assert!(photograph.note.unwrap().contains("hardly determines its gamma"));
}
