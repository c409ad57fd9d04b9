//! Primaries of linear values: their matrix to linear sRGB, and their profile.

use glam::{DMat3, DVec3, Mat3};
use unrender_scene::Profile;

/// Primaries are the same if no linear value changes by more than this share of white.
const SAME_PRIMARIES: f32 = 4e-3;
/// Red, green, blue and white of sRGB [IEC 61966-2-1].
pub(super) const SRGB: Corners = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];
/// The responses of the eye's cones to CIE XYZ by Bradford, by columns, for chromatic adaptation: white
/// stays white.
const BRADFORD: [[f64; 3]; 3] =
    [[0.8951, -0.7502, 0.0389], [0.2664, 1.7135, -0.0685], [-0.1614, 0.0367, 1.0296]];

/// Red, green, blue and white, each as CIE x and y.
pub(super) type Corners = [[f32; 2]; 4];

/// The profile of linear values whose matrix to linear sRGB is `matrix`; not understood without one.
pub(super) fn of_primaries(matrix: Option<Mat3>, source: &str) -> Profile {
    let understood = matrix.is_some();
    Profile {
        source: source.into(),
        srgb_from_file: matrix.and_then(other),
        curves: None,
        understood,
        icc: None,
    }
}

/// The primaries of linear values whose matrix to linear sRGB is `srgb_from_file`, with the white of sRGB.
pub(super) fn corners(srgb_from_file: Mat3) -> Option<Corners> {
    let xyz = xyz_from(SRGB)? * srgb_from_file.as_dmat3();
    let place = |xyz: DVec3| [xyz.x, xyz.y].map(|v| (v / (xyz.x + xyz.y + xyz.z)) as f32);
    Some([xyz.x_axis, xyz.y_axis, xyz.z_axis, xyz * DVec3::ONE].map(place))
}

/// Linear sRGB from linear values of these primaries, white to white; none if they span no colours.
pub(super) fn matrix(corners: Corners) -> Option<Mat3> {
    let matrix = srgb_from_rgb(corners)?.as_mat3();
    (matrix.is_finite() && matrix.determinant().abs() > 1e-3).then_some(matrix)
}

/// Linear values of these primaries from linear sRGB, white to white; none if they span no colours.
pub(super) fn rgb_from_srgb(corners: Corners) -> Option<DMat3> {
    let matrix = srgb_from_rgb(corners)?.inverse();
    matrix.is_finite().then_some(matrix)
}

/// Linear sRGB from linear values of these primaries.
fn srgb_from_rgb(corners: Corners) -> Option<DMat3> {
    let [xyz, srgb] = [xyz_from(corners)?, xyz_from(SRGB)?];
    let cones = DMat3::from_cols_array_2d(&BRADFORD);
    let [from, to] = [cones * (xyz * DVec3::ONE), cones * (srgb * DVec3::ONE)];
    let adapted = cones.inverse() * DMat3::from_diagonal(to / from) * cones;
    Some(srgb.inverse() * adapted * xyz)
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

/// The matrix, if it changes anything.
pub(super) fn other(matrix: Mat3) -> Option<Mat3> {
    let same = (matrix - Mat3::IDENTITY).to_cols_array().iter().all(|m| m.abs() < SAME_PRIMARIES);
    (!same).then_some(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn white_stays_white_and_srgb_has_nothing_to_convert() {
        assert!(matrix(SRGB).and_then(other).is_none());
        // No screen has the primaries of CIE XYZ or of ACES.
        let xyz = matrix([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]]).unwrap();
        assert!((xyz * Vec3::ONE).abs_diff_eq(Vec3::ONE, 1e-4), "{xyz}");
        let aces = matrix([[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]]);
        assert!((aces.unwrap().x_axis.x - 2.5217).abs() < 5e-3, "{aces:?}");
        let back = corners(xyz).and_then(matrix).unwrap();
        assert!(back.abs_diff_eq(xyz, 1e-4), "{back} for {xyz}");
        assert!(matrix([[0.3, 0.3]; 4]).is_none() && matrix([[f32::NAN; 2]; 4]).is_none());
    }
}
