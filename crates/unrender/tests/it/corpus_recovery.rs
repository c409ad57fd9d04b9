//! Recoveries, end to end, of the tiny scenes of `examples/corpus` (docs/validation/corpus.md),
//! photographed by other renderers.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// All groups have the right hypothesis under the seeds 0 to 4; under 5 one of them, a round lobe, is called brushed, and
/// doubtful. Under 0 to 4 their largest errors are 0.0057 to 0.0126 of rho_d, 0.009 to 0.021 of rho_s, in groups of a hundred
/// pixels, whose standard deviations are 0.02 and 0.04, and 2.5 to 3.6 standard deviations; this seed's are 0.0057, 0.021
/// and 2.8.
#[test]
fn glossy_groups_of_a_tiny_photograph_by_another_renderer_are_drafted() {
    recovered("draft", [0.006, 0.022], 2.9);
}

/// The same: 0.0047 of rho_d, 0.023 of rho_s and 2.2 standard deviations: groups of a hundred pixels are not determined
/// better, and one seed may be nearer by luck.
#[test]
#[ignore = "slow: the usual effort"]
fn glossy_groups_of_a_tiny_photograph_by_another_renderer_are_recovered() {
    recovered("normal", [0.005, 0.025], 2.4);
}

/// Recovers six groups from an 8-bit picture by Radiance. The error of no reflectance (rho_d, rho_s) may exceed
/// `most`, and that of no parameter `deviations` of its standard deviations.
fn recovered(effort: &str, most: [f64; 2], deviations: f64) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/corpus/isotropic");
    let out = tempfile::tempdir().unwrap();
    let out = out.path().join("out");
    let unrender = || Command::new(env!("CARGO_BIN_EXE_unrender"));
    let mut recover = unrender();
    recover.arg("recover").arg(folder.join("project.toml")).arg("--out").arg(&out);
    assert!(
        recover.args(["--effort", effort, "--quiet", "--spp", "2"]).status().unwrap().success()
    );
    let mut score = unrender();
    score.arg("score").arg(&out).arg(folder.join("truth.json")).arg("--json");
    let scored: Value = serde_json::from_slice(&score.output().unwrap().stdout).unwrap();
    let groups = scored["groups"].as_array().unwrap();
    let counted: Vec<&Value> = groups.iter().filter(|group| group["counted"] == true).collect();
    let right = counted.iter().filter(|g| g["hypothesis"] == g["true_hypothesis"]).count();
    assert_eq!(counted.len(), 6);
    assert_eq!(right, 6, "{scored}");
    for group in counted {
        for (reflectance, most) in ["rho_d", "rho_s"].into_iter().zip(most) {
            let error = group[reflectance].as_f64().unwrap();
            assert!(error < most, "{reflectance} of {} is {error} off", group["group"]);
        }
        for parameter in group["parameters"].as_array().unwrap() {
            let in_std = parameter["in_std"].as_array().unwrap();
            let most = in_std.iter().map(|value| value.as_f64().unwrap()).fold(0.0, f64::max);
            assert!(most < deviations, "{parameter} of {}", group["group"]);
        }
    }
}
