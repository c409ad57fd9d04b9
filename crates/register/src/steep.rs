//! Where the photograph changes so fast that a model which is some pixels off looks at something
//! else: at the edges of shadows, of mirror images, of patterns.
//!
//! The steepness of a pixel is `(max - min) / (max + min)` of the photograph's values, in the brightest channel, as far
//! around it as the model may be off, without the range of the noise.

use super::offset::EdgePicture;
use unrender_scene::{Image, Rgb};

/// The range of the noise around a pixel, in its standard deviations.
const NOISE_RANGE: f32 = 5.0;

/// How steep the photograph is about every pixel: 0 where it is even, or where `margins` is one pixel
/// and the model fits; 1 where black meets white.
pub fn steepness(picture: &EdgePicture, margins: &Image<f32>) -> Image<f32> {
    let (width, height) = (margins.width(), margins.height());
    Image::from_fn(width, height, |x, y| {
        let radius = *margins.at(x, y) - 1.0;
        if radius <= 0.0 {
            return 0.0;
        }
        let reach = radius.ceil() as usize;
        let (mut low, mut high) = (Rgb::INFINITY, Rgb::ZERO);
        for row in y.saturating_sub(reach)..(y + reach + 1).min(height) {
            for col in x.saturating_sub(reach)..(x + reach + 1).min(width) {
                if (col.abs_diff(x) as f32).hypot(row.abs_diff(y) as f32) <= radius {
                    low = low.min(*picture.roots().at(col, row));
                    high = high.max(*picture.roots().at(col, row));
                }
            }
        }
        // The values are square roots, in which noise is alike everywhere.
        let range = ((high - low).max_element() - NOISE_RANGE * picture.noise()).max(0.0);
        let high = high.max_element().max(f32::MIN_POSITIVE);
        let low = (high - range).max(0.0);
        (high * high - low * low) / (high * high + low * low)
    })
}
