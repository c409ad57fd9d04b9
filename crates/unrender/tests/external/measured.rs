//! Tests with photographs that are not part of the repository: they lie in `shared/data` beside it.

use crate::kit::example::{Limits, beside_crates, recovers};
use crate::kit::folder::Folder;
use crate::kit::programs::need;
use std::path::{Path, PathBuf};
use std::process::Command;
use unrender::formats::{load_scene, materials};
use unrender::scene::{Group, Rgb, Warnings};

/// The folder of `file`, which is beside the repository.
fn data(file: &str) -> Result<PathBuf, String> {
    let path = beside_crates("../shared/data").join(file);
    let folder = path.parent().map(Path::to_owned).unwrap_or_default();
    if path.is_file() { Ok(folder) } else { Err(format!("{} is not there", path.display())) }
}

/// The folder of `file`; none if it is missing, as it may not be copied into the repository.
#[track_caller]
fn present(file: &str) -> Option<PathBuf> {
    need(data(file))
}

#[test]
fn what_is_missing_is_a_failure_where_it_is_required() {
    let missing = std::panic::catch_unwind(|| present("there is no such file"));
    let is_required = std::env::var("UNRENDER_REQUIRE_TOOLS").is_ok_and(|v| v == "1");
    assert_eq!(missing.is_err(), is_required);
}

/// A box with a brushed plate in it.
fn plate(file: &str) {
    let limits = Limits { rho: 0.01, alpha_percent: 4.0, degrees: 1.0 };
    if let Some(folder) = present(&format!("plate/{file}")) {
        recovers(&folder, file, &[], &limits);
    }
}

#[test]
#[ignore = "slow: needs shared/data beside the repository"]
fn the_plate_is_recovered_from_linear_radiance() {
    plate("project_exr.toml");
}

#[test]
#[ignore = "slow: needs shared/data beside the repository"]
fn the_plate_is_recovered_from_8_bits() {
    plate("project_png.toml");
}

#[test]
#[ignore = "slow: needs shared/data beside the repository"]
fn the_scenes_of_the_outside_checks_are_read_well() {
    for (name, groups, cameras) in [("fig8", 8, 1), ("plate", 7, 1), ("iset/photo0", 0, 1)] {
        let Some(folder) = present(&format!("{name}/scene.glb")) else { continue };
        let (scene, warnings) = load_scene(&folder.join("scene.glb")).unwrap();
        assert_eq!(warnings, Warnings::default(), "{name}");
        assert!(groups == 0 || scene.groups.len() == groups, "{name}");
        assert_eq!(scene.cameras.len(), cameras, "{name}");
        assert!(scene.groups.iter().any(Group::is_emitter), "{name}");
        assert!(scene.groups.iter().all(|g| g.material.rho_s == Rgb::ZERO), "{name}");
    }
}

/// The largest relative error that the data's own comparison allows.
const WITHIN: f64 = 0.15;
/// The groups of the white walls.
const WHITE: [&str; 3] = ["back_wall", "floor", "ceiling"];

/// The largest relative error of a recovery with `flags`.
fn error(data: &Path, flags: &[&str]) -> f64 {
    let folder = Folder::new();
    let out = folder.path("out");
    let mut recover = Command::new(env!("CARGO_BIN_EXE_unrender"));
    recover.arg("recover").arg(data.join("photo0/project.toml")).arg("--out").arg(&out);
    recover.args(["--quiet", "--spp", "2"]).args(flags);
    assert!(recover.status().unwrap().success(), "recover {flags:?}");
    let found = materials::read(&out.join("materials.json")).unwrap();
    let rho_d = |group: &str| found.groups[group].rho_d.unwrap().map(f64::from);
    let white = |channel: usize| WHITE.iter().map(|g| rho_d(g)[channel]).sum::<f64>() / 3.0;
    let truth: serde_json::Value =
        serde_json::from_slice(&std::fs::read(data.join("truth.json")).unwrap()).unwrap();
    let measured = |key: &str, channel: usize| truth[key]["truth"][channel].as_f64().unwrap();
    let red =
        [0, 1].map(|c| (rho_d("left_wall")[c] / white(c)) / measured("red_over_white", c) - 1.0);
    let green = rho_d("right_wall");
    let color = measured("green_over_white", 0) / measured("green_over_white", 1);
    let green = (green[0] / white(0)) / (green[1] / white(1)) / color - 1.0;
    println!("{flags:?}: red wall {:+.3} {:+.3}, green wall's colour {green:+.3}", red[0], red[1]);
    red.into_iter().chain([green]).map(f64::abs).fold(0.0, f64::max)
}

/// A box of 30 cm with measured walls under a small lamp.
///
/// The test compares the red wall's reflectance over that of the white ones, in red and green, and
/// the colour of the green wall, red over green. The measurements are accurate to a few percent,
/// the lamp's cone is modelled roughly, and another program's inversion of the same model is 11 %
/// off.
#[test]
#[ignore = "slow: needs shared/data beside the repository"]
fn a_measured_box_is_recovered_and_without_interreflection_it_is_not() {
    let Some(data) = present("iset/truth.json") else { return };
    let with = error(&data, &[]);
    assert!(with < WITHIN, "{with} off");
    let without = error(&data, &["--bounces", "1"]);
    assert!(without > 3.0 * with, "{without} off without interreflection, {with} with it");
}
