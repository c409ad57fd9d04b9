//! Figure 8 of the paper from its picture: a Cornell box with an anisotropic floor. At full size it
//! takes minutes; a picture of a sixteenth of the pixels guards the same on every run.

mod common;

use common::{Limits, beside_crates, recovers};
use std::path::Path;
use unrender::formats::picture;
use unrender::scene::{Image, Rgb, RgbImage};

/// Pixels of the full picture on a side of one of the small picture.
const SHRINK: usize = 4;

/// The picture of `SHRINK` times larger pixels: their radiance is the mean.
fn small(picture: &RgbImage) -> RgbImage {
    Image::from_fn(picture.width() / SHRINK, picture.height() / SHRINK, |x, y| {
        let at = |i: usize| *picture.at(SHRINK * x + i % SHRINK, SHRINK * y + i / SHRINK);
        let count = SHRINK * SHRINK;
        (0..count).map(at).sum::<Rgb>() / count as f32
    })
}

/// Recovers the example's project `file` from the small picture, written as its `photo`.
fn recovers_small(file: &str, photo: &str, limits: &Limits) {
    let example = beside_crates("examples/fig8");
    let folder = tempfile::tempdir().unwrap();
    let folder: &Path = folder.path();
    for name in [file, "scene.glb", "truth.json"] {
        std::fs::copy(example.join(name), folder.join(name)).unwrap();
    }
    let (full, _) = picture::read(&example.join("photo.exr")).unwrap();
    picture::write(&folder.join(photo), &small(&full.to_linear())).unwrap();
    recovers(folder, file, &["--spp", "2"], limits);
}

#[test]
fn a_small_figure_8_is_recovered_from_linear_radiance() {
    let limits = Limits { rho: 0.0025, alpha_percent: 0.7, degrees: 0.4 };
    recovers_small("fig8.toml", "photo.exr", &limits);
}

#[test]
fn a_small_figure_8_is_recovered_from_8_bits() {
    let limits = Limits { rho: 0.02, alpha_percent: 5.0, degrees: 2.0 };
    recovers_small("fig8_png.toml", "photo.png", &limits);
}

// The direction's standard deviation is 0.18 degrees: it is not held to the tenth of a degree that
// was wished for.
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
