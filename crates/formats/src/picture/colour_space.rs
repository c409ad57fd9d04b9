//! The colour spaces of linear pictures that are written.
//!
//! Radiance is kept in the primaries of sRGB, which are those of Rec. 709. Studios work in others. White stays white:
//! from D65 to the white of ACES it is adapted by Bradford, as OpenColorIO does. The attribute
//! `chromaticities` of an EXR says which primaries its values have.

use super::primaries::{Corners, SRGB, rgb_from_srgb};
use exr::meta::attribute::Chromaticities;
use exr::prelude::Vec2;
use glam::DMat3;
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;
use unrender_scene::RgbImage;

/// The white of ACES, as CIE x and y [SMPTE ST 2065-1].
const ACES_WHITE: [f32; 2] = [0.321_68, 0.337_67];
/// The white of daylight, D65, as CIE x and y.
const D65: [f32; 2] = [0.3127, 0.3290];
/// Red, green, blue and white of ACES 2065-1, which is AP0 [SMPTE ST 2065-1].
pub(super) const AP0: Corners = [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], ACES_WHITE];
/// Red, green, blue and white of `ACEScg`, which is AP1 [AMPAS S-2014-004].
const AP1: Corners = [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], ACES_WHITE];
/// Red, green, blue and white of P3 with the white D65 [SMPTE RP 431-2].
const P3_D65: Corners = [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06], D65];
/// Red, green, blue and white of Rec. 2020 [ITU-R BT.2020].
const REC2020: Corners = [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], D65];

/// The colour space of a linear picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourSpace {
    /// Linear values with the primaries of Rec. 709 and sRGB.
    #[default]
    LinRec709,
    /// `ACEScg`: linear values with the primaries AP1.
    AcesCg,
    /// Linear values with the primaries of P3 and the white D65.
    LinP3D65,
    /// Linear values with the primaries of Rec. 2020.
    LinRec2020,
    /// ACES 2065-1: linear values with the primaries AP0.
    Aces2065,
}

impl ColourSpace {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::LinRec709, Self::AcesCg, Self::LinP3D65, Self::LinRec2020, Self::Aces2065];

    /// The name in flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::LinRec709 => "lin-rec709",
            Self::AcesCg => "acescg",
            Self::LinP3D65 => "lin-p3d65",
            Self::LinRec2020 => "lin-rec2020",
            Self::Aces2065 => "aces2065-1",
        }
    }

    /// Red, green, blue and white.
    fn corners(self) -> Corners {
        match self {
            Self::LinRec709 => SRGB,
            Self::AcesCg => AP1,
            Self::LinP3D65 => P3_D65,
            Self::LinRec2020 => REC2020,
            Self::Aces2065 => AP0,
        }
    }

    /// The matrix to this space from linear values with the primaries of Rec. 709, white to white.
    ///
    /// ```
    /// use unrender_formats::picture::ColourSpace;
    ///
    /// let red = ColourSpace::AcesCg.from_rec709().x_axis;
    /// assert!((red.x - 0.613_097).abs() < 1e-6);
    /// ```
    pub fn from_rec709(self) -> DMat3 {
        match self {
            Self::LinRec709 => DMat3::IDENTITY,
            _ => rgb_from_srgb(self.corners()).unwrap_or(DMat3::IDENTITY),
        }
    }

    /// `picture`, whose primaries are those of Rec. 709, in this space.
    pub fn of(self, picture: &RgbImage) -> Cow<'_, RgbImage> {
        if self == Self::LinRec709 {
            return Cow::Borrowed(picture);
        }
        let matrix = self.from_rec709();
        Cow::Owned(picture.map(|value| (matrix * value.as_dvec3()).as_vec3()))
    }

    /// The attribute of an EXR that says so.
    pub(crate) fn chromaticities(self) -> Chromaticities {
        declared(self.corners())
    }
}

/// The attribute of an EXR with these primaries.
pub(super) fn declared(corners: Corners) -> Chromaticities {
    let [red, green, blue, white] = corners.map(|[x, y]| Vec2(x, y));
    Chromaticities { red, green, blue, white }
}

impl fmt::Display for ColourSpace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ColourSpace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|space| space.name() == text);
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            format!("no such colour space; there are {}", names.join(", "))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// What OpenColorIO 2.6.0 makes of (0.18, 0.5, 4) by its configuration `ocio://default`, from
    /// `Linear Rec.709 (sRGB)`, in single precision.
    const BY_OCIO: [(ColourSpace, [f64; 3]); 4] = [
        (ColourSpace::AcesCg, [0.469_636_917, 0.524_621_427, 3.537_754_297]),
        (ColourSpace::Aces2065, [0.980_141_580, 0.810_016_034, 3.542_579_651]),
        (ColourSpace::LinP3D65, [0.236_812_174, 0.489_377_856, 3.681_353_331]),
        (ColourSpace::LinRec2020, [0.450_826_526, 0.517_656_982, 3.629_338_026]),
    ];
    /// Its matrix to `ACEScg`, by rows.
    const ACESCG_BY_OCIO: [[f64; 3]; 3] = [
        [0.613_097_429, 0.339_523_137, 0.047_379_453],
        [0.070_193_723, 0.916_353_881, 0.013_452_399],
        [0.020_615_593, 0.109_569_773, 0.869_814_634],
    ];

    #[test]
    fn colours_are_those_of_opencolorio() {
        for (space, expected) in BY_OCIO {
            let found = space.from_rec709() * DVec3::new(0.18, 0.5, 4.0);
            let off = (found / DVec3::from(expected) - DVec3::ONE).abs().max_element();
            assert!(off < 1e-5, "{space}: {found} for {expected:?}");
        }
        let found = ColourSpace::AcesCg.from_rec709().transpose().to_cols_array_2d();
        for (found, expected) in found.iter().zip(&ACESCG_BY_OCIO) {
            let pairs = found.iter().zip(expected);
            pairs.for_each(|(found, expected)| assert!((found / expected - 1.0).abs() < 1e-5));
        }
    }

    #[test]
    fn white_stays_white_and_names_are_read() {
        for space in ColourSpace::ALL {
            let white = space.from_rec709() * DVec3::ONE;
            assert!(white.abs_diff_eq(DVec3::ONE, 1e-7), "{space}: {white}");
            assert_eq!(space.name().parse(), Ok(space));
        }
        let error = "rec709".parse::<ColourSpace>().unwrap_err();
        assert!(error.contains("lin-rec709, acescg"), "{error}");
    }
}
