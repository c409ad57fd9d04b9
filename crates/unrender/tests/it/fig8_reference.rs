//! The renderer against another one: Figure 8 with its true materials is compared with the picture
//! by Mitsuba 3 with 2048 paths per pixel and unlimited bounces.
//!
//! A pixel is four by four pixels of the reference. More paths make a stricter test:
//! `UNRENDER_REFERENCE_SPP=16384 cargo test --release --test it fig8_reference -- --nocapture` prints
//! the ratios that the paths of a quick run do not determine.

use crate::kit::example::{beside_crates, shrunk};
use glam::DVec3;
use std::collections::BTreeMap;
use unrender::formats::{load_scene, materials, picture};
use unrender::render::{Film, Settings, Tracer};
use unrender::scene::RgbImage;

/// Paths per pixel if the environment variable does not request more.
const SPP: u32 = 192;
/// Pixels of the reference per compared pixel, along each side.
const SHRINK: usize = 4;
/// The reference's paths in a compared pixel. Its variance is our variance times the ratio of our paths to these.
const REFERENCE_SPP: f64 = 2048.0 * (SHRINK * SHRINK) as f64;
/// Means of groups agree to this share plus three standard deviations of the remaining noise.
const SAME_MEAN: f64 = 0.003;
/// Tiles of this side are compared by their noise. Single pixels are not: a pixel whose paths have
/// missed a rare bright one underestimates its variance.
const TILE: usize = 8;

#[test]
fn figure_8_agrees_with_an_independent_renderer() {
    let folder = beside_crates("examples/fig8");
    let (mut scene, _) = load_scene(&folder.join("scene.glb")).unwrap();
    materials::apply_from(&folder.join("truth.json"), &mut scene).unwrap();
    let (reference, _) = picture::read(&folder.join("photo.exr")).unwrap();
    let reference = shrunk(&reference.to_linear(), SHRINK);
    let size = (reference.width(), reference.height());
    let tracer = Tracer::new(&scene);
    let asked = std::env::var("UNRENDER_REFERENCE_SPP").ok().and_then(|spp| spp.parse().ok());
    let spp = asked.unwrap_or(SPP);
    let settings = Settings { spp, seed: 8, ..Settings::default() };
    let film = tracer.render(&scene.materials(), &scene.cameras[0], size, &settings, &|_| {});
    let geometry = tracer.geometry(&scene.cameras[0], size.0, size.1);

    for (index, group) in scene.groups.iter().enumerate() {
        let same = |i: usize| geometry.pixels()[i].group == index as u32;
        let inside = |i: &usize| geometry.neighbourhood(*i).all(same);
        let pixels: Vec<usize> = (0..geometry.pixels().len()).filter(inside).collect();
        if !pixels.is_empty() {
            let noise = 1.0 + f64::from(spp) / REFERENCE_SPP;
            means_agree(&group.name, &pixels, &film, &reference, noise);
            tiles_agree(&group.name, &pixels, &film, &reference, noise);
        }
    }
}

fn sum(image: &RgbImage, pixels: &[usize]) -> DVec3 {
    pixels.iter().map(|&i| image.pixels()[i].as_dvec3()).sum()
}

fn means_agree(name: &str, pixels: &[usize], film: &Film, reference: &RgbImage, noise: f64) {
    let (ours, theirs) = (sum(&film.mean, pixels), sum(reference, pixels));
    let variance = noise * sum(&film.variance, pixels);
    for channel in (0..3).filter(|&c| theirs[c] > 0.0) {
        let ratio = ours[channel] / theirs[channel];
        let deviation = variance[channel].sqrt() / theirs[channel];
        println!("{name}, channel {channel}: mean ratio {ratio:.5}, deviation {deviation:.5}");
        let allowed = SAME_MEAN + 3.0 * deviation;
        assert!((ratio - 1.0).abs() < allowed, "{name}, channel {channel}: {ratio}");
        assert!(deviation < 0.005, "{name}, channel {channel}: too noisy, {deviation}");
    }
}

/// Compares tiles by their differences in units of their standard deviation. Paths are stratified,
/// so the variance is an upper bound: the mean square must not be far above one.
fn tiles_agree(name: &str, pixels: &[usize], film: &Film, reference: &RgbImage, noise: f64) {
    let mut tiles: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &i in pixels {
        let (x, y) = (i % reference.width() / TILE, i / reference.width() / TILE);
        tiles.entry(y * reference.width() + x).or_default().push(i);
    }
    let mut z_squares = Vec::new();
    for tile in tiles.values().filter(|tile| tile.len() >= TILE * TILE / 2) {
        let difference = sum(&film.mean, tile) - sum(reference, tile);
        let variance = noise * sum(&film.variance, tile);
        for channel in (0..3).filter(|&c| variance[c] > 0.0) {
            z_squares.push(difference[channel] * difference[channel] / variance[channel]);
        }
    }
    let count = z_squares.len() as f64;
    let mean_square = z_squares.iter().sum::<f64>() / count;
    let far = z_squares.iter().filter(|z| **z > 16.0).count() as f64 / count;
    println!("{name}: {count} tiles, mean z^2 {mean_square:.3}, |z| > 4 in {:.2} %", 100.0 * far);
    assert!(mean_square < 2.0, "{name}: mean z^2 {mean_square}");
    assert!(far < 0.02, "{name}: |z| > 4 in {far}");
}
