//! Which pixels of the photograph an edit touches.
//!
//! A new object changes the light everywhere, if only by a ten-thousandth. A pixel is touched if
//!  - it shows something else than before, or
//!  - its radiance changes by more than half a step of the photograph's code, and by more than
//!    [`SIGMAS`] standard deviations of the change's own noise; either the pixel by itself (a thin
//!    shadow), or the mean over the pixels of the same object around it (a faint wide one), in some
//!    channel.
//!
//! A change of less than half a step rounds to the code that was there, and one that is not
//! significant is as likely noise.

use crate::pair::Paired;
use glam::Vec3;
use unrender_render::GeometryBuffers;
use unrender_scene::{Image, Rgb, RgbImage};

/// So many standard deviations are more than noise.
pub const SIGMAS: f32 = 4.0;
/// The mean is taken over the pixels at most so far to the left and right, above and below.
pub const REACH: usize = 4;
/// Neighbouring normals further apart than this (cosine) are of different faces.
const SAME_NORMAL: f32 = 0.95;

/// The pixels that are touched. `geometry` is what the camera saw before, `step` the radiance between
/// one code and the next, zero for floating-point files.
pub fn touched(paired: &Image<Paired>, geometry: &GeometryBuffers, step: &RgbImage) -> Image<bool> {
    Image::from_fn(paired.width(), paired.height(), |x, y| {
        let pixel = paired.at(x, y);
        let limit = *step.at(x, y) * 0.5;
        let alone = exceeds(pixel.after - pixel.before, pixel.change_variance, limit);
        pixel.replaced > 0.0 || alone || around(paired, geometry, (x, y), limit)
    })
}

/// Whether the change is above the limit and above its noise in some channel.
fn exceeds(change: Rgb, variance: Rgb, limit: Rgb) -> bool {
    let noise = Vec3::from_array(variance.to_array().map(f32::sqrt)) * SIGMAS;
    change.abs().cmpgt(limit.max(noise)).any()
}

/// As [`exceeds`] for the mean over the neighbours that show the same face.
fn around(
    paired: &Image<Paired>,
    geometry: &GeometryBuffers,
    (x, y): (usize, usize),
    limit: Rgb,
) -> bool {
    let centre = geometry.at(x, y);
    let (mut change, mut variance, mut count) = (Rgb::ZERO, Rgb::ZERO, 0.0);
    for row in y.saturating_sub(REACH)..(y + REACH + 1).min(paired.height()) {
        for column in x.saturating_sub(REACH)..(x + REACH + 1).min(paired.width()) {
            let (pixel, shown) = (paired.at(column, row), geometry.at(column, row));
            let same_face =
                shown.object == centre.object && shown.normal.dot(centre.normal) > SAME_NORMAL;
            if same_face && pixel.replaced == 0.0 {
                change += pixel.after - pixel.before;
                variance += pixel.change_variance;
                count += 1.0;
            }
        }
    }
    count > 0.0 && exceeds(change / count, variance / (count * count), limit)
}
