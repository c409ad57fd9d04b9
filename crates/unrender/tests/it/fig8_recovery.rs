//! Figure 8 of the paper from its picture: a Cornell box with an anisotropic floor. At full size it
//! takes minutes; each `.ci/run` recovers a draft from a picture of a sixteenth of the pixels.

use crate::kit::example::{Limits, beside_crates, errors_of, recovers, shrunk};
use unrender::formats::picture;

/// Pixels of the full picture per pixel of the small picture, along each side.
const SHRINK: usize = 4;

// Under the seeds 0 to 5 all hypotheses are right, and errors are 0.0009 to 0.0038, 0.12 to 1.25 % and 0.11 to 0.83
// degrees.
#[test]
#[ignore = "slow: a recovery of 128 x 128 pixels"]
fn a_small_figure_8_is_drafted() {
    let limits = Limits { rho: 0.004, alpha_percent: 1.3, degrees: 0.9 };
    let flags = ["--effort", "draft", "--spp", "2"];
    recovers(small_figure_8().path(), "fig8.toml", &flags, &limits);
}

// With the seeds 0 to 2 errors are 0.0012 to 0.0027, 0.16 to 0.23 % and 0.18 to 0.42 degrees, where the direction's standard
// deviation is 0.30 to 0.58 degrees. The limits are the largest of them: all three seeds, below, take 80 seconds more than `.ci/run` has.
#[test]
#[ignore = "slow: the usual effort"]
fn a_small_figure_8_is_recovered() {
    let limits = Limits { rho: 0.0028, alpha_percent: 0.24, degrees: 0.45 };
    recovers(small_figure_8().path(), "fig8.toml", &["--spp", "2"], &limits);
}

// One seed alone is a matter of luck.
#[test]
#[ignore = "slow: three recoveries at the usual effort"]
fn three_seeds_recover_a_small_figure_8() {
    let folder = small_figure_8();
    let errors: Vec<Limits> = ["0", "1", "2"]
        .map(|seed| errors_of(folder.path(), "fig8.toml", &["--spp", "2", "--seed", seed]))
        .into();
    let median = |of: fn(&Limits) -> f64| {
        let mut all: Vec<f64> = errors.iter().map(of).collect();
        all.sort_by(f64::total_cmp);
        all[1]
    };
    let medians = [median(|e| e.rho), median(|e| e.alpha_percent), median(|e| e.degrees)];
    println!("{medians:?}");
    let limits = [0.0025, 0.4, 0.3];
    assert!(medians.iter().zip(limits).all(|(error, limit)| *error <= limit), "{medians:?}");
}

/// Figure 8 from a picture of a sixteenth of the pixels.
fn small_figure_8() -> tempfile::TempDir {
    let example = beside_crates("examples/fig8");
    let folder = tempfile::tempdir().unwrap();
    for name in ["fig8.toml", "scene.glb", "truth.json"] {
        std::fs::copy(example.join(name), folder.path().join(name)).unwrap();
    }
    let (full, _) = picture::read(&example.join("photo.exr")).unwrap();
    picture::write(&folder.path().join("photo.exr"), &shrunk(&full.to_linear(), SHRINK)).unwrap();
    folder
}

// The direction's standard deviation is 0.18 degrees, so the desired limit of a tenth of a degree
// is not applied.
#[test]
#[ignore = "slow: Figure 8 at 512 x 512"]
fn figure_8_is_recovered_from_linear_radiance() {
    let limits = Limits { rho: 0.002, alpha_percent: 0.5, degrees: 0.25 };
    recovers(&beside_crates("examples/fig8"), "fig8.toml", &[], &limits);
}

#[test]
#[ignore = "slow: Figure 8 at 512 x 512"]
fn figure_8_is_recovered_from_8_bits() {
    let limits = Limits { rho: 0.005, alpha_percent: 2.0, degrees: 0.5 };
    recovers(&beside_crates("examples/fig8"), "fig8_png.toml", &[], &limits);
}
