//! Decoded pixels to code values.

use super::{Depth, Picture};
use image::DynamicImage;
use unrender_scene::{Image, Rgb};

/// The picture of the decoded pixels, as they are.
pub(super) fn picture_of(decoded: &DynamicImage) -> Picture {
    use DynamicImage as D;
    let depth = match decoded {
        D::ImageLuma8(_) | D::ImageLumaA8(_) | D::ImageRgb8(_) | D::ImageRgba8(_) => Depth::Eight,
        D::ImageLuma16(_) | D::ImageLumaA16(_) | D::ImageRgb16(_) | D::ImageRgba16(_) => {
            Depth::Sixteen
        }
        _ => Depth::Float,
    };
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    Picture::new(Image::new(width, height, code_values(decoded)), depth)
}

/// Sets pixels of `picture` that are not finite to zero and marks them; returns how many they are.
pub(super) fn leave_out_what_is_not_finite(picture: &mut Picture) -> usize {
    let mut count = 0;
    for (index, value) in picture.values.pixels_mut().iter_mut().enumerate() {
        if !value.is_finite() {
            *value = Rgb::ZERO;
            picture.invalid.push(index);
            count += 1;
        }
    }
    count
}

/// The code values of all pixels, grey repeated in all channels, alpha left out.
fn code_values(decoded: &DynamicImage) -> Vec<Rgb> {
    let of8 = |code: u8| f32::from(code) / 255.0;
    let of16 = |code: u16| f32::from(code) / 65535.0;
    let rgb8 = |p: [u8; 3]| Rgb::from_array(p.map(of8));
    let rgb16 = |p: [u16; 3]| Rgb::from_array(p.map(of16));
    match decoded {
        DynamicImage::ImageLuma8(p) => p.pixels().map(|p| Rgb::splat(of8(p.0[0]))).collect(),
        DynamicImage::ImageLumaA8(p) => p.pixels().map(|p| Rgb::splat(of8(p.0[0]))).collect(),
        DynamicImage::ImageRgb8(p) => p.pixels().map(|p| rgb8(p.0)).collect(),
        DynamicImage::ImageRgba8(p) => p.pixels().map(|p| rgb8([p.0[0], p.0[1], p.0[2]])).collect(),
        DynamicImage::ImageLuma16(p) => p.pixels().map(|p| Rgb::splat(of16(p.0[0]))).collect(),
        DynamicImage::ImageLumaA16(p) => p.pixels().map(|p| Rgb::splat(of16(p.0[0]))).collect(),
        DynamicImage::ImageRgb16(p) => p.pixels().map(|p| rgb16(p.0)).collect(),
        DynamicImage::ImageRgba16(p) => {
            p.pixels().map(|p| rgb16([p.0[0], p.0[1], p.0[2]])).collect()
        }
        DynamicImage::ImageRgba32F(p) => {
            p.pixels().map(|p| Rgb::new(p.0[0], p.0[1], p.0[2])).collect()
        }
        other => other.to_rgb32f().pixels().map(|p| Rgb::from_array(p.0)).collect(),
    }
}
