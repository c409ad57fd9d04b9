//! Camera samples: the ray and the random numbers of each sample of a pixel.

use crate::accel::Ray;
use crate::sampler::Sampler;
use unrender_scene::Camera;

/// Separates the random numbers of pictures from those of probes under the same seed.
const STREAM: u64 = 0x0F11_0000_0000_0000;

/// The random numbers of the sample number `index` of a pixel.
pub fn pixel_sampler(seed: u64, pixel: u32, index: u32) -> Sampler {
    Sampler::new(seed ^ STREAM, u64::from(pixel), index)
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
