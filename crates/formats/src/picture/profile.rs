//! What a picture file declares of its colours: an ICC profile (PNG, JPEG, TIFF), the chunks `gAMA`
//! and `cHRM` of PNG, the chromaticities of EXR, or the EXIF data's word for Adobe RGB.
//!
//! Profiles of three primaries and three curves are understood; those made of tables are not.

use super::exif::is_adobe_rgb;
use glam::Mat3;
use image::ImageFormat;
use moxcms::{Chromaticity, ColorPrimaries, ColorProfile, DataColorSpace, ToneReprCurve, XyY};
use std::io::Cursor;
use unrender_scene::Profile;

/// Codes at which curves are sampled.
const SAMPLES: u16 = 256;
/// Primaries are the same if no linear value changes by more than this share of white.
const SAME_PRIMARIES: f32 = 4e-3;
/// The `gAMA` that writers of sRGB pictures give.
const GAMMA_OF_SRGB: f32 = 0.454_55;

/// What the file `bytes` declares, whose ICC profile, if any, is `icc`.
pub(super) fn of(bytes: &[u8], format: ImageFormat, icc: Option<&[u8]>) -> Option<Profile> {
    if let Some(icc) = icc {
        return Some(of_icc(icc));
    }
    match format {
        ImageFormat::Png => of_png(bytes),
        ImageFormat::OpenExr => of_exr(bytes),
        ImageFormat::Jpeg | ImageFormat::Tiff if is_adobe_rgb(bytes) => {
            let source = "its EXIF data (Adobe RGB)".to_owned();
            Some(of_profile(&ColorProfile::new_adobe_rgb(), source))
        }
        _ => None,
    }
}

fn of_icc(icc: &[u8]) -> Profile {
    let Ok(profile) = ColorProfile::new_from_slice(icc) else {
        return not_understood("an ICC profile that cannot be read".to_owned());
    };
    let name = profile.description.as_ref().map(|text| match text {
        moxcms::ProfileText::PlainString(text) => text.clone(),
        moxcms::ProfileText::Localizable(texts) => {
            texts.first().map_or(String::new(), |text| text.value.clone())
        }
        moxcms::ProfileText::Description(text) => text.ascii_string.clone(),
    });
    let name = name.unwrap_or_default();
    of_profile(&profile, format!("its ICC profile \"{}\"", name.trim_matches(['\0', ' '])))
}

fn not_understood(source: String) -> Profile {
    Profile { source, srgb_from_file: None, curves: None, understood: false }
}

fn of_profile(profile: &ColorProfile, source: String) -> Profile {
    let curves = match profile.color_space {
        DataColorSpace::Gray => [&profile.gray_trc; 3],
        _ => [&profile.red_trc, &profile.green_trc, &profile.blue_trc],
    };
    let [Some(red), Some(green), Some(blue)] = curves.map(|curve| curve.as_ref().and_then(sampled))
    else {
        return not_understood(source);
    };
    let grey = profile.color_space == DataColorSpace::Gray;
    let srgb_from_file = if grey { None } else { other_primaries(profile) };
    Profile { source, srgb_from_file, curves: Some([red, green, blue]), understood: true }
}

fn sampled(curve: &ToneReprCurve) -> Option<Vec<f32>> {
    let curve = curve.make_linear_evaluator().ok()?;
    let code = |k| f32::from(k) / f32::from(SAMPLES - 1);
    let values: Vec<f32> = (0..SAMPLES).map(|k| curve.evaluate_value(code(k))).collect();
    values.iter().all(|value| value.is_finite()).then_some(values)
}

/// Linear sRGB from the linear values of `profile`, if these have other primaries.
fn other_primaries(profile: &ColorProfile) -> Option<Mat3> {
    let rows = profile.transform_matrix(&ColorProfile::new_srgb()).v;
    let matrix = Mat3::from_cols_array_2d(&rows.map(|row| row.map(|m| m as f32))).transpose();
    let same = (matrix - Mat3::IDENTITY).to_cols_array().iter().all(|m| m.abs() < SAME_PRIMARIES);
    (matrix.is_finite() && matrix.determinant().abs() > 1e-3 && !same).then_some(matrix)
}

/// Linear sRGB from the linear values of primaries and white, each as CIE x and y.
fn of_chromaticities([red, green, blue, white]: [[f32; 2]; 4]) -> Option<Mat3> {
    let primary = |[x, y]: [f32; 2]| Chromaticity::new(x, y);
    let mut profile = ColorProfile::new_srgb();
    let primaries =
        ColorPrimaries { red: primary(red), green: primary(green), blue: primary(blue) };
    profile.update_rgb_colorimetry(XyY::new(white[0].into(), white[1].into(), 1.0), primaries);
    other_primaries(&profile)
}

fn of_png(bytes: &[u8]) -> Option<Profile> {
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    let info = reader.info();
    if info.srgb.is_some() || (info.gama_chunk.is_none() && info.chrm_chunk.is_none()) {
        return None;
    }
    let gamma = info.gama_chunk.map(png::ScaledFloat::into_value);
    let gamma = gamma.filter(|g| *g > 0.05 && (g - GAMMA_OF_SRGB).abs() > 1e-3);
    let srgb_from_file = info.chrm_chunk.and_then(|chrm| {
        let of = |(x, y): (png::ScaledFloat, png::ScaledFloat)| [x.into_value(), y.into_value()];
        of_chromaticities([of(chrm.red), of(chrm.green), of(chrm.blue), of(chrm.white)])
    });
    let curve = |gamma: f32| {
        (0..SAMPLES).map(|k| (f32::from(k) / f32::from(SAMPLES - 1)).powf(1.0 / gamma)).collect()
    };
    let curves = gamma.map(|gamma| {
        let curve: Vec<f32> = curve(gamma);
        [curve.clone(), curve.clone(), curve]
    });
    let source = "its chunks gAMA and cHRM".to_owned();
    Some(Profile { source, srgb_from_file, curves, understood: true })
}

fn of_exr(bytes: &[u8]) -> Option<Profile> {
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).ok()?;
    let stated = meta.headers.first()?.shared_attributes.chromaticities?;
    let of = |xy: exr::math::Vec2<f32>| [xy.x(), xy.y()];
    let matrix =
        of_chromaticities([of(stated.red), of(stated.green), of(stated.blue), of(stated.white)]);
    let source = "its chromaticities".to_owned();
    Some(Profile { source, srgb_from_file: matrix, curves: None, understood: true })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Display P3 to sRGB, as CSS Color 4 has it.
    const SRGB_FROM_P3: [[f32; 3]; 3] = [
        [1.224_94, -0.224_94, 0.0],
        [-0.042_057, 1.042_057, 0.0],
        [-0.019_638, -0.078_636, 1.098_274],
    ];

    #[test]
    fn display_p3_has_the_published_matrix() {
        let icc = ColorProfile::new_display_p3().encode().unwrap();
        let profile = of_icc(&icc);
        assert!(profile.understood && profile.source.contains("P3"), "{}", profile.source);
        let matrix = profile.srgb_from_file.unwrap();
        let published = Mat3::from_cols_array_2d(&SRGB_FROM_P3).transpose();
        assert!(matrix.abs_diff_eq(published, 2e-3), "{matrix}");
        assert!((matrix * Vec3::ONE).abs_diff_eq(Vec3::ONE, 1e-3), "white stays white");
        let by_corners =
            of_chromaticities([[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], [0.3127, 0.3290]]);
        assert!(by_corners.unwrap().abs_diff_eq(published, 2e-3));
        let curve = &profile.curves.unwrap()[1];
        let srgb = unrender_scene::color::linear_from_srgb(128.0 / 255.0);
        assert!((curve[128] - srgb).abs() < 1e-3, "{} against {srgb}", curve[128]);
    }

    #[test]
    fn adobe_rgb_has_its_gamma_and_srgb_nothing_to_convert() {
        let adobe = of_icc(&ColorProfile::new_adobe_rgb().encode().unwrap());
        let curve = &adobe.curves.as_ref().unwrap()[0];
        assert!((curve[128] - (128.0f32 / 255.0).powf(2.199)).abs() < 1e-3);
        assert!((adobe.srgb_from_file.unwrap().x_axis.x - 1.3984).abs() < 2e-3);
        let srgb = of_icc(&ColorProfile::new_srgb().encode().unwrap());
        assert!(srgb.understood && srgb.srgb_from_file.is_none());
        assert!(!of_icc(b"no profile").understood);
    }
}
