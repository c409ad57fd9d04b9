//! Camera samples: the ray and the random numbers of each sample of a pixel.

use crate::accel::Ray;
use crate::sampler::Sampler;
use crate::settings::Settings;
use unrender_scene::Camera;

/// Separates the random numbers of pictures from those of probes under the same seed.
const STREAM: u64 = 0x0F11_0000_0000_0000;

/// Separates those of blocks of pixels from both.
const BLOCKS: u64 = 0x0B10_0000_0000_0000;

/// The random numbers of the sample number `index` of a pixel.
pub fn pixel_sampler(seed: u64, pixel: u32, index: u32) -> Sampler {
    Sampler::new(seed ^ STREAM, u64::from(pixel), index)
}

/// The side of a block of pixels, a power of two.
const SIDE: u32 = 8;
/// So many samples of a pixel at most are stratified among themselves; a power of two. A rendering that later ones of the
/// same seed go on from has a multiple of it. At half of it highlights are noisier by a sixth; double was not tried.
pub const TOGETHER: u32 = 16;

/// The random numbers of the sample number `index` of a pixel of a picture of `width` columns, stratified together with
/// those of the other pixels of its block of 8 x 8: means over blocks are less noisy than those of independent pixels.
///
/// The pixels of a block share one sequence, in which the first samples of all of them come one pixel after the
/// other along a Z-curve [Ahmed and Wonka 2020], and then the next ones: as many at a time as `settings.spp` has twos,
/// up to [`TOGETHER`].
pub fn block_sampler(settings: &Settings, width: usize, pixel: u32, index: u32) -> Sampler {
    let together = 1 << settings.spp.trailing_zeros().min(TOGETHER.trailing_zeros());
    let width = width as u32;
    let (x, y) = (pixel % width, pixel / width);
    let block = u64::from(y / SIDE) << 32 | u64::from(x / SIDE);
    let rank = along_z_curve(x % SIDE, y % SIDE);
    let (round, within) = (index / together, index % together);
    let index = (round * SIDE * SIDE + rank) * together + within;
    Sampler::new(settings.seed ^ BLOCKS, block, index)
}

/// The place of `(x, y)` on a Z-curve through its block.
fn along_z_curve(x: u32, y: u32) -> u32 {
    let apart = |v: u32| (v & 1) | (v & 2) << 1 | (v & 4) << 2;
    apart(x) | apart(y) << 1
}

/// A ray through a random point of a pixel: the reconstruction filter is a box over the pixel.
pub fn camera_ray(
    camera: &Camera,
    (width, height): (usize, usize),
    pixel: u32,
    sampler: &mut Sampler,
) -> Ray {
    let [dx, dy, ..] = sampler.next4();
    let x = (pixel as usize % width) as f32 + dx;
    let y = (pixel as usize / width) as f32 + dy;
    Ray::new(camera.origin(), camera.direction(x, y, width, height))
}
