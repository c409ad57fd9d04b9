//! ICC profiles: those of three primaries and three curves, or of one curve for grey.

use super::curves::sampled;
use super::primaries::{of_primaries, other};
use glam::{DMat3, DVec3, Mat3};
use moxcms::{ColorProfile, DataColorSpace, LocalizableString, ProfileText, ToneReprCurve, Xyzd};
use std::ops::Range;
use unrender_scene::Profile;

/// Where the header of a profile has the time of its creation.
const CREATED: Range<usize> = 24..36;

/// What the ICC profile `icc` says.
pub(super) fn profile(icc: &[u8]) -> Profile {
    let Ok(profile) = ColorProfile::new_from_slice(icc) else {
        return of_primaries(None, "an ICC profile that cannot be read");
    };
    let name = profile.description.as_ref().map(|text| match text {
        ProfileText::PlainString(text) => text.clone(),
        ProfileText::Localizable(texts) => {
            texts.first().map_or(String::new(), |text| text.value.clone())
        }
        ProfileText::Description(text) => text.ascii_string.clone(),
    });
    let name = name.unwrap_or_default();
    let source = format!("its ICC profile \"{}\"", name.trim_matches(['\0', ' ']));
    let own = (profile.color_space == DataColorSpace::Rgb).then(|| icc.to_vec());
    Profile { icc: own, ..of_profile(&profile, &source) }
}

/// The ICC profile called `name` of codes whose linear values are `linear`, by channel, with these primaries. Linear
/// values beyond 0 to 1 are clipped.
///
/// # Errors
/// If it cannot be encoded.
pub fn icc_profile(
    name: &str,
    linear: impl Fn(usize, f32) -> f32,
    srgb_from_file: Option<Mat3>,
) -> Result<Vec<u8>, String> {
    let mut profile = ColorProfile::new_srgb();
    profile.cicp = None;
    profile.description = Some(ProfileText::Localizable(vec![LocalizableString::new(
        "en".to_owned(),
        "US".to_owned(),
        name.to_owned(),
    )]));
    let word = |value: f32| (65_535.0 * value.clamp(0.0, 1.0)).round() as u16;
    let curve = |channel| {
        let samples = sampled(|code| linear(channel, code));
        Some(ToneReprCurve::Lut(samples.into_iter().map(word).collect()))
    };
    (profile.red_trc, profile.green_trc, profile.blue_trc) = (curve(0), curve(1), curve(2));
    if let Some(matrix) = srgb_from_file {
        let own = &mut profile;
        let colorants = [&mut own.red_colorant, &mut own.green_colorant, &mut own.blue_colorant];
        let [red, green, blue] = colorants.each_ref().map(|xyz| DVec3::new(xyz.x, xyz.y, xyz.z));
        let columns = DMat3::from_cols(red, green, blue) * matrix.as_dmat3();
        for (colorant, [x, y, z]) in colorants.into_iter().zip(columns.to_cols_array_2d()) {
            *colorant = Xyzd { x, y, z };
        }
    }
    let encoded = profile.encode();
    let mut bytes =
        encoded.map_err(|error| format!("its ICC profile cannot be encoded: {error}"))?;
    // The same input has the same bytes, so without the time.
    bytes.get_mut(CREATED).into_iter().for_each(|time| time.fill(0));
    Ok(bytes)
}

/// The profile of Adobe RGB, which `source` declares.
pub(super) fn adobe_rgb(source: &str) -> Profile {
    of_profile(&ColorProfile::new_adobe_rgb(), source)
}

fn of_profile(profile: &ColorProfile, source: &str) -> Profile {
    let curves = match profile.color_space {
        DataColorSpace::Gray => [&profile.gray_trc; 3],
        _ => [&profile.red_trc, &profile.green_trc, &profile.blue_trc],
    };
    let [Some(red), Some(green), Some(blue)] = curves.map(|curve| curve.as_ref().and_then(values))
    else {
        return of_primaries(None, source);
    };
    let grey = profile.color_space == DataColorSpace::Gray;
    let srgb_from_file = if grey { None } else { other_primaries(profile) };
    Profile {
        source: source.to_owned(),
        srgb_from_file,
        curves: Some([red, green, blue]),
        understood: true,
        icc: None,
    }
}

fn values(curve: &ToneReprCurve) -> Option<Vec<f32>> {
    let curve = curve.make_linear_evaluator().ok()?;
    let values = sampled(|code| curve.evaluate_value(code));
    values.iter().all(|value| value.is_finite()).then_some(values)
}

/// Linear sRGB from the linear values of `profile`, if these have other primaries.
fn other_primaries(profile: &ColorProfile) -> Option<Mat3> {
    let rows = profile.transform_matrix(&ColorProfile::new_srgb()).v;
    let matrix = Mat3::from_cols_array_2d(&rows.map(|row| row.map(|m| m as f32))).transpose();
    other(matrix).filter(|m| m.is_finite() && m.determinant().abs() > 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::primaries;
    use glam::Vec3;

    /// Display P3 to sRGB, from CSS Color 4.
    const SRGB_FROM_P3: [[f32; 3]; 3] = [
        [1.224_94, -0.224_94, 0.0],
        [-0.042_057, 1.042_057, 0.0],
        [-0.019_638, -0.078_636, 1.098_274],
    ];

    #[test]
    fn display_p3_has_the_published_matrix() {
        let icc = ColorProfile::new_display_p3().encode().unwrap();
        let profile = profile(&icc);
        assert!(profile.understood && profile.source.contains("P3"), "{}", profile.source);
        let matrix = profile.srgb_from_file.unwrap();
        let published = Mat3::from_cols_array_2d(&SRGB_FROM_P3).transpose();
        assert!(matrix.abs_diff_eq(published, 2e-3), "{matrix}");
        assert!((matrix * Vec3::ONE).abs_diff_eq(Vec3::ONE, 1e-3), "white stays white");
        let by_corners =
            primaries::matrix([[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], [0.3127, 0.3290]]);
        assert!(by_corners.unwrap().abs_diff_eq(published, 2e-3));
        let curve = &profile.curves.unwrap()[1];
        let srgb = unrender_scene::color::linear_from_srgb(128.0 / 255.0);
        assert!((curve[128] - srgb).abs() < 1e-3, "{} against {srgb}", curve[128]);
    }

    #[test]
    fn adobe_rgb_has_its_gamma_and_srgb_nothing_to_convert() {
        let adobe = profile(&ColorProfile::new_adobe_rgb().encode().unwrap());
        let curve = &adobe.curves.as_ref().unwrap()[0];
        assert!((curve[128] - (128.0f32 / 255.0).powf(2.199)).abs() < 1e-3);
        assert!((adobe.srgb_from_file.unwrap().x_axis.x - 1.3984).abs() < 2e-3);
        let srgb = profile(&ColorProfile::new_srgb().encode().unwrap());
        assert!(srgb.understood && srgb.srgb_from_file.is_none());
        assert!(!profile(b"no profile").understood);
    }

    #[test]
    fn a_profile_that_was_made_says_what_it_was_made_of() {
        let published = Mat3::from_cols_array_2d(&SRGB_FROM_P3).transpose();
        // Dark codes have no light, or so little that 16 bits round it to nothing.
        let gammas = [1.0, 1.8, 2.6];
        let linear =
            |channel: usize, code: f32| ((code - 0.1) / 0.9).max(0.0).powf(gammas[channel]);
        let icc = icc_profile("A camera", linear, Some(published)).unwrap();
        let read = profile(&icc);
        assert!(read.understood && read.source.contains("A camera"), "{}", read.source);
        assert_eq!(read.icc, Some(icc));
        assert!(read.srgb_from_file.unwrap().abs_diff_eq(published, 1e-3));
        for (channel, curve) in read.curves.unwrap().iter().enumerate() {
            assert!(curve.windows(2).all(|w| w[0] < w[1]), "curve {channel} grows");
            let off = |k: usize| (curve[k] - linear(channel, k as f32 / 255.0)).abs();
            assert!((0..256).all(|k| off(k) < 2e-5), "{channel}");
        }
        let plain = icc_profile("sRGB", |_, code| code, None).unwrap();
        assert!(profile(&plain).srgb_from_file.is_none());
    }

    #[test]
    fn profiles_of_grey_and_of_inks_are_not_for_three_colours() {
        let grey = profile(&ColorProfile::new_gray_with_gamma(2.2).encode().unwrap());
        assert!(grey.understood && grey.icc.is_none());
        let mut inks = ColorProfile::new_srgb();
        inks.color_space = DataColorSpace::Cmyk;
        assert_eq!(profile(&inks.encode().unwrap()).icc, None);
    }
}
