//! A scene whose light is wrong by a factor is refused, with the factor, after the choice of hypotheses and before
//! the refinement.

use crate::kit::example::beside_crates;
use crate::kit::folder::{Folder, ends_in_error, stderr};
use std::fs;

/// The factor in the message, if the example's photograph is stated to be `times` as bright.
fn told(folder: &Folder, times: f64) -> f64 {
    let project = folder.text("project.toml");
    let exposure = format!("exposure = {}", 1.79 * times);
    assert!(project.contains("exposure = 1.79"), "{project}");
    folder.write("off.toml", &project.replace("exposure = 1.79", &exposure));
    let output =
        folder.run(&["recover", "off.toml", "--out", "out", "--effort", "draft", "--quiet"]);
    ends_in_error(&output, "no reflectances explain this photograph: the nearest leave");
    let said = stderr(&output);
    let factor = said.split("scene were ").nth(1).and_then(|rest| rest.split(" times").next());
    factor.and_then(|factor| factor.parse().ok()).expect(&said)
}

#[test]
fn light_that_is_a_factor_off_is_refused_with_the_factor() {
    let folder = Folder::new();
    let example = beside_crates("examples/corpus/isotropic");
    for name in ["project.toml", "scene.glb", "photo.png"] {
        fs::copy(example.join(name), folder.path(name)).unwrap();
    }
    let times = 30.0;
    let factor = told(&folder, times);
    assert!((factor / times - 1.0).abs() < 0.1, "{factor}");
    assert!(!folder.path("out").exists(), "a refused photograph leaves nothing behind");
}

#[test]
fn lights_of_another_lighting_mode_are_refused_with_its_name() {
    let folder = Folder::new();
    let example = beside_crates("examples/corpus/anisotropic");
    for entry in fs::read_dir(example).unwrap().map(Result::unwrap) {
        fs::copy(entry.path(), folder.path(&entry.file_name())).unwrap();
    }
    // The file's own are W/sr, as Blender's Unitless.
    let project = format!("light_units = \"blender-standard\"\n{}", folder.text("project.toml"));
    folder.write("off.toml", &project);
    let recover = ["recover", "off.toml", "--out", "out", "--effort", "draft", "--quiet"];
    // The name comes of the factor, which the other test looks for among all hypotheses.
    let output = folder.run(&[&recover[..], &["--max-rung", "diffuse"]].concat());
    ends_in_error(&output, "light read as \"unitless\" would explain it");
    let said = stderr(&output);
    assert!(said.contains("say light_units = \"unitless\" in the project"), "{said}");
}

#[test]
fn where_all_reflectances_are_known_none_is_asked_to_explain_the_photograph() {
    let folder = Folder::new();
    let example = beside_crates("examples/corpus/isotropic");
    for name in ["scene.glb", "photo.png"] {
        fs::copy(example.join(name), folder.path(name)).unwrap();
    }
    let truth = fs::read(example.join("truth.json")).unwrap();
    let truth: serde_json::Value = serde_json::from_slice(&truth).unwrap();
    let mut project =
        "scene = \"scene.glb\"\nphoto = \"photo.png\"\nresponse = \"srgb\"\nexposure = 9\n\
                       camera = \"camera\"\n"
            .to_owned();
    for name in truth["groups"].as_object().unwrap().keys() {
        project += &format!("[groups.{name}]\nknown = {{ rho_d = 0.5 }}\n");
    }
    folder.write("known.toml", &project);
    let output =
        folder.run(&["recover", "known.toml", "--out", "out", "--effort", "draft", "--quiet"]);
    assert!(output.status.success(), "{}", stderr(&output));
}
