//! Reduces a photograph of many pixels to fewer: the means of squares of pixels.
//!
//! Radiance is linear, so its mean over a square is exact. A camera's processing correlates neighbouring pixels (two
//! of three colours of each are interpolated from others), but mostly within a square, so that the noise of squares
//! is independent again.

use crate::Photo;
use unrender_scene::{Image, Rgb};

impl Photo {
    /// The photograph in squares of `side` pixels; incomplete columns at the right and rows at the bottom are left
    /// out. A square is valid if all its pixels are, and a lower bound if one of them is. The noise of quantisation is
    /// that of independent pixels. `clipped` and `dark` still count the photograph's pixels.
    ///
    /// # Panics
    /// If `side` is zero, or larger than the photograph.
    #[must_use]
    pub fn binned(self, side: usize) -> Self {
        if side == 1 {
            return self;
        }
        let count = (side * side) as f32;
        let mean = |values: &[Rgb]| values.iter().sum::<Rgb>() / count;
        let of_mean = |steps: &[Rgb]| {
            let variance = steps.iter().map(|step| *step * *step).sum::<Rgb>() / count;
            variance.map(f32::sqrt) / side as f32
        };
        Self {
            radiance: squares(&self.radiance, side, mean),
            valid: squares(&self.valid, side, |valid| !valid.contains(&false)),
            saturated: squares(&self.saturated, side, |saturated| saturated.contains(&true)),
            quantisation_step: squares(&self.quantisation_step, side, of_mean),
            ..self
        }
    }
}

/// Applies `of` to the pixels of every square of `image`, given row by row.
///
/// # Panics
/// As [`Photo::binned`].
pub fn squares<T: Copy, U>(image: &Image<T>, side: usize, of: impl Fn(&[T]) -> U) -> Image<U> {
    let (width, height) = (image.width() / side, image.height() / side);
    assert!(width > 0 && height > 0, "a square is larger than the photograph");
    let mut square = Vec::with_capacity(side * side);
    Image::from_fn(width, height, |x, y| {
        square.clear();
        for row in y * side..(y + 1) * side {
            let start = row * image.width() + x * side;
            square.extend_from_slice(&image.pixels()[start..start + side]);
        }
        of(&square)
    })
}

#[cfg(test)]
mod tests {
    use crate::{Response, Transfer, develop};
    use unrender_scene::{Depth, Image, Picture, Rgb};

    #[test]
    fn squares_have_the_mean_of_their_pixels_and_less_noise() {
        let codes = Image::from_fn(7, 5, |x, y| Rgb::splat((1 + x + 7 * y) as f32 / 64.0));
        let photo = develop(
            &Picture::new(codes, Depth::Sixteen),
            &Transfer::plain(Response::Linear, Rgb::ONE),
        );
        let binned = photo.clone().binned(2);
        assert_eq!((binned.radiance.width(), binned.radiance.height()), (3, 2));
        let mean = (1.0 + 2.0 + 8.0 + 9.0) / 4.0 / 64.0;
        assert!((binned.radiance.at(0, 0).x - mean).abs() < 1e-6);
        let step = photo.quantisation_step.at(0, 0).x;
        assert!((binned.quantisation_step.at(1, 1).x / (0.5 * step) - 1.0).abs() < 1e-6);
        assert_eq!(photo.clone().binned(1), photo);
    }

    #[test]
    fn one_pixel_that_is_not_valid_or_clipped_makes_its_square_so() {
        let mut codes = Image::new(6, 6, vec![Rgb::splat(0.5); 36]);
        codes.pixels_mut()[0] = Rgb::ONE;
        let mut picture = Picture::new(codes, Depth::Eight);
        picture.invalid.push(35);
        let photo = develop(&picture, &Transfer::plain(Response::Srgb, Rgb::ONE)).binned(3);
        assert_eq!(photo.valid.pixels(), [false, true, true, false]);
        assert_eq!(photo.saturated.pixels(), [true, false, false, false]);
    }
}
