//! The pixels of the photograph that an edit changes significantly, and by how much.
//!
//! A new object changes the light everywhere, if only by a ten-thousandth, and the rendered change
//! has noise. A change is *significant* if in some channel it exceeds half a quantisation step of
//! the photograph and [`SIGMAS`] standard deviations of its noise. A pixel is touched if
//!  - it shows another surface than before;
//!  - its own change is significant (the edge of a shadow, a reflection): the change is its own;
//!  - or the local mean change is significant, over nearby pixels of the same face whose own change
//!    is not (a faint wide shadow): the change is that mean.
//!
//! A change of less than half a step rounds to the same pixel value. With more samples fewer pixels
//! need the local mean.

use crate::pair::Paired;
use glam::Vec3;
use unrender_render::GeometryBuffers;
use unrender_scene::{Image, Rgb, RgbImage};

/// The significance threshold, standard deviations: a share of 6e-5 of normal noise exceeds it, a
/// few dozen pixels of a megapixel. With 2 every twentieth pixel would be touched by noise, with 8
/// faint shadows are lost.
pub const SIGMAS: f32 = 4.0;
/// Half the side of the window of the local mean, pixels: 81 pixels reduce the noise to a ninth.
/// Not derived from the resolution: it sets the reduction of noise, which is per pixel. Half of it
/// reduces the noise to a fifth only, double of it blurs the edges of faint shadows.
pub const REACH: usize = 4;
/// Normals belong to one face if the cosine between them is above this, 18 degrees. At 9 degrees
/// curved surfaces fall apart, at 36 degrees edges are blurred.
const SAME_NORMAL: f32 = 0.95;

/// For each touched pixel the change of the radiance of the surface that was visible before.
/// `geometry` is that before the edits, `step` the quantisation step in radiance, zero for floating-point files.
pub fn touched(
    paired: &Image<Paired>,
    geometry: &GeometryBuffers,
    step: &RgbImage,
) -> Image<Option<Rgb>> {
    let (width, height) = (paired.width(), paired.height());
    let alone = Image::from_fn(width, height, |x, y| {
        let pixel = paired.at(x, y);
        let half_step = 0.5 * *step.at(x, y);
        pixel.replaced > 0.0 || is_significant(pixel.kept_change, pixel.change_variance, half_step)
    });
    Image::from_fn(width, height, |x, y| {
        if *alone.at(x, y) {
            return Some(paired.at(x, y).kept_change);
        }
        let (mean, variance) = local_mean(paired, geometry, &alone, (x, y));
        is_significant(mean, variance, 0.5 * *step.at(x, y)).then_some(mean)
    })
}

/// Whether a change exceeds half a step and its noise in some channel.
fn is_significant(change: Rgb, variance: Rgb, half_step: Rgb) -> bool {
    let noise = Vec3::from_array(variance.to_array().map(f32::sqrt)) * SIGMAS;
    change.abs().cmpgt(half_step.max(noise)).any()
}

/// The mean change and its variance over the pixels near (`x`, `y`) that show the same face and
/// whose own change is not significant.
fn local_mean(
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
    // The count is positive: the pixel itself is one of them.
    (change / count, variance / (count * count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_render::PixelGeometry;

    const SIDE: usize = 24;

    /// The touched pixels of a face whose pixels change by `change`, with this standard deviation.
    fn changes(
        change: impl Fn(usize, usize) -> f32,
        deviation: f32,
        step: f32,
    ) -> Image<Option<Rgb>> {
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
        assert!(changes(|_, _| 0.004, 0.0, 0.01).pixels().iter().all(Option::is_none));
        assert!(changes(|_, _| 0.006, 0.0, 0.01).pixels().iter().all(Option::is_some));
    }

    #[test]
    fn a_faint_change_is_significant_as_a_local_mean_and_noise_is_not() {
        // With a standard deviation of 1 a change of 1 is noise, as a mean of 25 to 81 pixels it is
        // not.
        let faint = changes(|x, y| if (x + y) % 2 == 0 { 2.0 } else { 0.0 }, 1.0, 0.0);
        let mean = faint.at(12, 12).unwrap().x;
        assert!((mean - 1.0).abs() < 0.02, "{mean}");
        let noise = changes(|x, y| if (x + y) % 2 == 0 { 1.0 } else { -1.0 }, 1.0, 0.0);
        assert!(noise.pixels().iter().all(Option::is_none));
    }

    #[test]
    fn an_edge_stays_sharp() {
        let edge = changes(|x, _| if x < 12 { -9.0 } else { 0.0 }, 1.0, 0.0);
        assert_eq!(edge.at(11, 5).unwrap().x, -9.0);
        assert_eq!(*edge.at(12, 5), None);
    }
}
