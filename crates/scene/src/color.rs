//! Linear RGB and the sRGB transfer curve (IEC 61966-2-1).

/// Three linear channels: red, green, blue with the primaries of sRGB / Rec. 709.
///
/// Depending on its use it is a radiance (W sr^-1 m^-2 per channel), an intensity
/// (W sr^-1), an irradiance (W m^-2) or a reflectance (0 to 1).
pub type Rgb = glam::Vec3;

/// The luminances of the three primaries [ITU-R BT.709]. They define the channels: with others whites would not be grey.
pub const LUMINANCE: Rgb = Rgb::new(0.2126, 0.7152, 0.0722);

/// Luminance of linear RGB by the Rec. 709 weights; the weights sum to one.
#[inline]
pub fn luminance(rgb: Rgb) -> f32 {
    rgb.dot(LUMINANCE)
}

/// One linear channel from its sRGB-encoded value, both in 0 to 1.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB-encoded value of one linear channel, both in 0 to 1; values outside are clamped.
pub fn srgb_from_linear(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_curves_invert_each_other() {
        for code in 0..=255u8 {
            let encoded = f32::from(code) / 255.0;
            let back = srgb_from_linear(linear_from_srgb(encoded));
            assert!((back - encoded).abs() < 1e-6, "{code}: {back} against {encoded}");
        }
    }

    #[test]
    fn srgb_of_middle_grey_is_the_published_value() {
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-5);
    }
}
