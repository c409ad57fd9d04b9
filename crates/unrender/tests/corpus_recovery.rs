//! The tiny scenes of `examples/corpus` (docs/validation/corpus.md), photographed by other renderers:
//! what is recovered from them, end to end.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Eight bits by Radiance, 6 groups, of which all have the right hypothesis; the largest errors are 0.0053 of
/// rho_d and 0.0197 of rho_s.
#[test]
fn glossy_groups_of_a_tiny_photograph_by_another_renderer_are_recovered() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/corpus/isotropic");
    let out = tempfile::tempdir().unwrap();
    let out = out.path().join("out");
    let unrender = || Command::new(env!("CARGO_BIN_EXE_unrender"));
    let mut recover = unrender();
    recover.arg("recover").arg(folder.join("project.toml")).arg("--out").arg(&out);
    assert!(recover.args(["--quiet", "--spp", "2"]).status().unwrap().success());
    let mut score = unrender();
    score.arg("score").arg(&out).arg(folder.join("truth.json")).arg("--json");
    let scored: Value = serde_json::from_slice(&score.output().unwrap().stdout).unwrap();
    let groups = scored["groups"].as_array().unwrap();
    let counted: Vec<&Value> = groups.iter().filter(|group| group["counted"] == true).collect();
    let right = counted.iter().filter(|g| g["hypothesis"] == g["true_hypothesis"]).count();
    assert_eq!(counted.len(), 6);
    assert_eq!(right, 6, "{scored}");
    for group in counted {
        for (reflectance, most) in [("rho_d", 0.006), ("rho_s", 0.022)] {
            let error = group[reflectance].as_f64().unwrap();
            assert!(error < most, "{reflectance} of {} is {error} off", group["group"]);
        }
    }
}
