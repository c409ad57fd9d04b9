//! Clipped pixels: at the top of the range of an integer file, or beyond a measured response.

use crate::Response;
use unrender_formats::picture::Picture;
use unrender_scene::{Image, Rgb};

/// The indices of the pixels with a channel at the largest pixel value, or beyond the last value
/// that `response` was measured for; floating-point files have no largest value.
pub fn clipped_pixels(picture: &Picture, response: &Response) -> Vec<usize> {
    // Half a value below the top: pixel values are exact, their quotients are rounded.
    let top = picture.depth.max_code().map_or(f32::INFINITY, |max| (max - 0.5) / max);
    let beyond = |value: &Rgb| (0..3).any(|c| value[c] >= top || value[c] > response.last_code(c));
    let pixels = picture.values.pixels().iter().enumerate();
    pixels.filter(|(_, value)| beyond(value)).map(|(index, _)| index).collect()
}

/// The mask, of the size of `like`, of pixels that are not in `pixels` nor adjacent to one of them.
pub fn away_from<T>(like: &Image<T>, pixels: &[usize]) -> Image<bool> {
    let mut away = like.map(|_| true);
    for &index in pixels {
        for neighbour in like.neighbourhood(index) {
            away.pixels_mut()[neighbour] = false;
        }
    }
    away
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Curve;
    use unrender_formats::picture::Depth;

    #[test]
    fn only_the_largest_pixel_value_is_clipped() {
        for (depth, max) in [(Depth::Eight, 255.0), (Depth::Sixteen, 65535.0)] {
            let values = [max - 1.0, max].map(|code: f32| Rgb::new(0.0, code / max, 0.0));
            let values = Image::new(2, 1, values.to_vec());
            let picture = Picture::new(values, depth);
            assert_eq!(clipped_pixels(&picture, &Response::Srgb), [1]);
        }
    }

    #[test]
    fn values_beyond_the_measured_response_are_clipped() {
        let line = || Curve::new(&[0.0, 0.8], &[0.0, 1.0]);
        let response = Response::measured([line(), line(), line()]);
        let values = [0.8, 0.81].map(|code| Rgb::new(0.0, code, 0.0));
        let picture = Picture::new(Image::new(2, 1, values.to_vec()), Depth::Float);
        assert_eq!(clipped_pixels(&picture, &response), [1]);
    }
}
