//! Which pixels of the photograph an edit touches, and by how much.
//!
//! A new object changes the light everywhere, if only by a ten-thousandth, and a rendering of that
//! has noise. A change is *believed* if in some channel it is more than half a step of the
//! photograph's code, and more than [`SIGMAS`] standard deviations of its noise. A pixel is touched if
//!  - it shows something else than before,
//!  - its own change is believed (a shadow's edge, an image in a mirror): then it is changed by that;
//!  - or the mean change of the face around it is believed, over the pixels whose own change is not
//!    (a faint wide shadow): then it is changed by that mean.
//!
//! A change of less than half a step rounds to the code that was there, and one that is not
//! significant is as likely noise. The more paths there are, the fewer pixels need the mean.

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

/// For each pixel that is touched: by how much the light changes that comes from the surface which
/// was seen before. `geometry` is what the camera saw before, `step` the radiance between one code
/// and the next, zero for floating-point files.
pub fn touched(
    paired: &Image<Paired>,
    geometry: &GeometryBuffers,
    step: &RgbImage,
) -> Image<Option<Rgb>> {
    let (width, height) = (paired.width(), paired.height());
    let alone = Image::from_fn(width, height, |x, y| {
        let pixel = paired.at(x, y);
        let half_step = 0.5 * *step.at(x, y);
        pixel.replaced > 0.0 || is_believed(pixel.kept_change, pixel.change_variance, half_step)
    });
    Image::from_fn(width, height, |x, y| {
        if *alone.at(x, y) {
            return Some(paired.at(x, y).kept_change);
        }
        let (mean, variance) = around(paired, geometry, &alone, (x, y));
        is_believed(mean, variance, 0.5 * *step.at(x, y)).then_some(mean)
    })
}

/// Whether a change is above half a step and above its noise in some channel.
fn is_believed(change: Rgb, variance: Rgb, half_step: Rgb) -> bool {
    let noise = Vec3::from_array(variance.to_array().map(f32::sqrt)) * SIGMAS;
    change.abs().cmpgt(half_step.max(noise)).any()
}

/// The mean change and its variance over the pixels around (`x`, `y`) that show the same face and
/// are not touched by themselves.
fn around(
    paired: &Image<Paired>,
    geometry: &GeometryBuffers,
    alone: &Image<bool>,
    (x, y): (usize, usize),
) -> (Rgb, Rgb) {
    let centre = geometry.at(x, y);
    let (mut change, mut variance, mut count) = (Rgb::ZERO, Rgb::ZERO, 0.0);
    for row in y.saturating_sub(REACH)..(y + REACH + 1).min(paired.height()) {
        for column in x.saturating_sub(REACH)..(x + REACH + 1).min(paired.width()) {
            let (pixel, shown) = (paired.at(column, row), geometry.at(column, row));
            let same_face =
                shown.object == centre.object && shown.normal.dot(centre.normal) > SAME_NORMAL;
            if same_face && !*alone.at(column, row) {
                change += pixel.kept_change;
                variance += pixel.change_variance;
                count += 1.0;
            }
        }
    }
    // The pixel itself is one of them.
    (change / count, variance / (count * count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_render::PixelGeometry;

    const SIDE: usize = 24;

    /// A face of whose pixels each changes by `change` of its place, with this deviation.
    fn told(change: impl Fn(usize, usize) -> f32, deviation: f32, step: f32) -> Image<Option<Rgb>> {
        let paired = Image::from_fn(SIDE, SIDE, |x, y| Paired {
            kept_change: Rgb::splat(change(x, y)),
            change_variance: Rgb::splat(deviation * deviation),
            ..Paired::default()
        });
        let face = PixelGeometry { object: 0, group: 0, normal: Vec3::Z, ..PixelGeometry::EMPTY };
        let geometry = Image::from_fn(SIDE, SIDE, |_, _| face);
        touched(&paired, &geometry, &Image::from_fn(SIDE, SIDE, |_, _| Rgb::splat(step)))
    }

    #[test]
    fn below_half_a_step_nothing_is_touched() {
        assert!(told(|_, _| 0.004, 0.0, 0.01).pixels().iter().all(Option::is_none));
        assert!(told(|_, _| 0.006, 0.0, 0.01).pixels().iter().all(Option::is_some));
    }

    #[test]
    fn a_faint_change_is_believed_by_its_face_and_noise_is_not() {
        // A deviation of 1: alone 1 is noise, the mean of 25 to 81 pixels is not.
        let faint = told(|x, y| if (x + y) % 2 == 0 { 2.0 } else { 0.0 }, 1.0, 0.0);
        let mean = faint.at(12, 12).unwrap().x;
        assert!((mean - 1.0).abs() < 0.02, "{mean}");
        let noise = told(|x, y| if (x + y) % 2 == 0 { 1.0 } else { -1.0 }, 1.0, 0.0);
        assert!(noise.pixels().iter().all(Option::is_none));
    }

    #[test]
    fn an_edge_stays_sharp() {
        let edge = told(|x, _| if x < 12 { -9.0 } else { 0.0 }, 1.0, 0.0);
        assert_eq!(edge.at(11, 5).unwrap().x, -9.0);
        assert_eq!(*edge.at(12, 5), None);
    }
}
