//! ICC profiles: those of three primaries and three curves, or of one curve for grey.

use super::curves::sampled;
use super::primaries::other;
use glam::Mat3;
use moxcms::{ColorProfile, DataColorSpace, ToneReprCurve};
use unrender_scene::Profile;

/// What the ICC profile `icc` says.
pub(super) fn profile(icc: &[u8]) -> Profile {
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

/// The profile of Adobe RGB, which `source` declares.
pub(super) fn adobe_rgb(source: &str) -> Profile {
    of_profile(&ColorProfile::new_adobe_rgb(), source.to_owned())
}

/// A profile of a kind that is not understood.
pub(super) fn not_understood(source: String) -> Profile {
    Profile { source, srgb_from_file: None, curves: None, understood: false }
}

fn of_profile(profile: &ColorProfile, source: String) -> Profile {
    let curves = match profile.color_space {
        DataColorSpace::Gray => [&profile.gray_trc; 3],
        _ => [&profile.red_trc, &profile.green_trc, &profile.blue_trc],
    };
    let [Some(red), Some(green), Some(blue)] = curves.map(|curve| curve.as_ref().and_then(values))
    else {
        return not_understood(source);
    };
    let grey = profile.color_space == DataColorSpace::Gray;
    let srgb_from_file = if grey { None } else { other_primaries(profile) };
    Profile { source, srgb_from_file, curves: Some([red, green, blue]), understood: true }
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
}
