//! Which pixels are cut off at the top of an integer file's range.

use unrender_formats::picture::Picture;
use unrender_scene::Image;

/// The indices of the pixels that have the greatest code in some channel; none for
/// floating-point files, which have no greatest code.
pub fn clipped_pixels(picture: &Picture) -> Vec<usize> {
    let Some(max_code) = picture.depth.max_code() else { return Vec::new() };
    // Half a code below the top: codes are exact, their quotients are rounded.
    let top = (max_code - 0.5) / max_code;
    let pixels = picture.values.pixels().iter().enumerate();
    pixels.filter(|(_, value)| value.max_element() >= top).map(|(index, _)| index).collect()
}

/// True for the pixels of `like` that are not among `pixels` and not beside one of them.
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
    use unrender_formats::picture::Depth;
    use unrender_scene::Rgb;

    #[test]
    fn only_the_greatest_code_is_clipped() {
        for (depth, max) in [(Depth::Eight, 255.0), (Depth::Sixteen, 65535.0)] {
            let values = [max - 1.0, max].map(|code: f32| Rgb::new(0.0, code / max, 0.0));
            let values = Image::new(2, 1, values.to_vec());
            let picture = Picture { values, depth, invalid: Vec::new() };
            assert_eq!(clipped_pixels(&picture), [1]);
        }
    }
}
