//! What a picture file declares of its colours: an ICC profile (PNG, JPEG, BMP, TIFF), the chunks `cICP`, `gAMA` and
//! `cHRM` of PNG, the header of Radiance, tags of TIFF, or the EXIF data's word for Adobe RGB.
//!
//! Profiles of three primaries and three curves are understood; those made of tables are not. What EXR declares is
//! read with its channels.

use super::exif::is_adobe_rgb;
use super::tiff::{Directory, Tiff};
use super::{bmp, cicp, png_chunks, tiff_says};
use glam::{DMat3, DVec3, Mat3};
use image::ImageFormat;
use moxcms::{ColorProfile, DataColorSpace, ToneReprCurve};
use std::io::Cursor;
use unrender_scene::Profile;

/// Codes at which curves are sampled.
pub(super) const SAMPLES: u16 = 256;
/// Primaries are the same if no linear value changes by more than this share of white.
const SAME_PRIMARIES: f32 = 4e-3;
/// The `gAMA` that writers of sRGB pictures give.
const GAMMA_OF_SRGB: f32 = 0.454_55;
/// Red, green, blue and white of sRGB [IEC 61966-2-1].
const SRGB: Corners = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];
/// The responses of the eye's cones to CIE XYZ by Bradford, by columns: what is white stays white by them.
const BRADFORD: [[f64; 3]; 3] =
    [[0.8951, -0.7502, 0.0389], [0.2664, 1.7135, -0.0685], [-0.1614, 0.0367, 1.0296]];

/// Red, green, blue and white, each as CIE x and y.
pub(super) type Corners = [[f32; 2]; 4];

/// What the file `bytes` declares, whose ICC profile, if any, is `icc`; `tiff` is the page, if it is a TIFF.
///
/// # Errors
/// If it declares codes that are no light of a scene.
pub(super) fn of(
    bytes: &[u8],
    format: ImageFormat,
    icc: Option<&[u8]>,
    tiff: Option<(&Tiff<'_>, &Directory)>,
) -> Result<Option<Profile>, String> {
    // The order of precedence in PNG: cICP, iCCP, sRGB, and then gAMA and cHRM.
    if format == ImageFormat::Png
        && let Some(data) = png_chunks::find(bytes, &png_chunks::CICP)
    {
        return cicp::profile(data).map(Some);
    }
    if let Some(icc) = icc {
        return Ok(Some(of_icc(icc)));
    }
    let stated = tiff.and_then(|(tiff, page)| tiff_says::profile(tiff, page));
    Ok(match format {
        ImageFormat::Png => of_png(bytes),
        ImageFormat::Bmp => bmp::profile(bytes),
        _ if stated.is_some() => stated,
        ImageFormat::Jpeg | ImageFormat::Tiff if is_adobe_rgb(bytes) => {
            let source = "its EXIF data (Adobe RGB)".to_owned();
            Some(of_profile(&ColorProfile::new_adobe_rgb(), source))
        }
        _ => None,
    })
}

pub(super) fn of_icc(icc: &[u8]) -> Profile {
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

pub(super) fn not_understood(source: String) -> Profile {
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
    other(matrix).filter(|m| m.is_finite() && m.determinant().abs() > 1e-3)
}

/// The profile of linear values with the primaries whose matrix to linear sRGB is `matrix`, if they have one.
pub(super) fn of_primaries(matrix: Option<Mat3>, source: &str) -> Profile {
    let understood = matrix.is_some();
    Profile {
        source: source.into(),
        srgb_from_file: matrix.and_then(other),
        curves: None,
        understood,
    }
}

/// The matrix, if it changes anything.
fn other(matrix: Mat3) -> Option<Mat3> {
    let same = (matrix - Mat3::IDENTITY).to_cols_array().iter().all(|m| m.abs() < SAME_PRIMARIES);
    (!same).then_some(matrix)
}

/// Linear sRGB from linear values of these primaries, white to white; none if they span no colours.
pub(super) fn matrix(corners: Corners) -> Option<Mat3> {
    let [xyz, srgb] = [xyz_from(corners)?, xyz_from(SRGB)?];
    let cones = DMat3::from_cols_array_2d(&BRADFORD);
    let [from, to] = [cones * (xyz * DVec3::ONE), cones * (srgb * DVec3::ONE)];
    let adapted = cones.inverse() * DMat3::from_diagonal(to / from) * cones;
    let matrix = (srgb.inverse() * adapted * xyz).as_mat3();
    (matrix.is_finite() && matrix.determinant().abs() > 1e-3).then_some(matrix)
}

/// CIE XYZ from linear values of these primaries; white has a luminance of one.
fn xyz_from(corners: Corners) -> Option<DMat3> {
    let [red, green, blue, white] = corners.map(|[x, y]| {
        let [x, y] = [f64::from(x), f64::from(y)];
        DVec3::new(x, y, 1.0 - x - y)
    });
    let directions = DMat3::from_cols(red, green, blue);
    let lengths = directions.inverse() * (white / white.y);
    let usable = directions.determinant().abs() > 1e-6 && lengths.is_finite() && white.y > 0.0;
    usable.then(|| directions * DMat3::from_diagonal(lengths))
}

fn of_png(bytes: &[u8]) -> Option<Profile> {
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    let info = reader.info();
    if info.srgb.is_some() || (info.gama_chunk.is_none() && info.chrm_chunk.is_none()) {
        return None;
    }
    let gamma = info.gama_chunk.map(png::ScaledFloat::into_value);
    let gamma = gamma.filter(|g| *g > 0.05 && (g - GAMMA_OF_SRGB).abs() > 1e-3);
    let primaries = info.chrm_chunk.map(|chrm| {
        let of = |(x, y): (png::ScaledFloat, png::ScaledFloat)| [x.into_value(), y.into_value()];
        matrix([of(chrm.red), of(chrm.green), of(chrm.blue), of(chrm.white)])
    });
    let curve = |gamma: f32| {
        (0..SAMPLES).map(|k| (f32::from(k) / f32::from(SAMPLES - 1)).powf(1.0 / gamma)).collect()
    };
    let curves = gamma.map(|gamma| {
        let curve: Vec<f32> = curve(gamma);
        [curve.clone(), curve.clone(), curve]
    });
    let primaries = primaries.unwrap_or(Some(Mat3::IDENTITY));
    Some(Profile { curves, ..of_primaries(primaries, "its chunks gAMA and cHRM") })
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
            super::matrix([[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], [0.3127, 0.3290]]);
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
        assert!(matrix(SRGB).and_then(other).is_none());
        // CIE XYZ and the primaries of ACES are none that a screen has.
        let xyz = matrix([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]]).unwrap();
        assert!((xyz * Vec3::ONE).abs_diff_eq(Vec3::ONE, 1e-4), "{xyz}");
        let aces = matrix([[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]]);
        assert!((aces.unwrap().x_axis.x - 2.5217).abs() < 5e-3, "{aces:?}");
        assert!(matrix([[0.3, 0.3]; 4]).is_none() && matrix([[f32::NAN; 2]; 4]).is_none());
        assert!(!of_icc(b"no profile").understood);
    }
}
