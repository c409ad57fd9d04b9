//! Warnings about measured points and about the camera estimated from them.

use super::{Calibration, Focal};
use glam::{DVec3, Vec3};
use unrender_scene::{Pair, Warnings};

/// Focal lengths that differ from the EXIF data's by more than this share are reported. EXIF data are
/// rounded to whole millimetres, 4 % of a phone's 26 mm, and focal lengths change by some percent
/// with focus. At half of it, sound photographs are reported; at double, a crop to three quarters of
/// the width is missed.
const EXIF_TOLERANCE: f64 = 0.15;
/// Measured points may lie outside the scene by this share of its size: things that are not modelled
/// stand out by less. At half of it, a chimney is reported; at double, centimetres for metres still
/// are.
const OUTSIDE: f32 = 0.1;

impl Focal {
    /// The known focal length of a camera with the full vertical field of view `fov_y_deg`, whose
    /// pictures have `height` rows; none if no camera has that field of view.
    ///
    /// ```
    /// use unrender_photo::calibrate::Focal;
    ///
    /// let Some(Focal::Known(focal_px)) = Focal::of_fov_y_deg(90.0, 200) else { panic!() };
    /// assert!((focal_px - 100.0).abs() < 1e-9);
    /// assert_eq!(Focal::of_fov_y_deg(180.0, 200), None);
    /// ```
    pub fn of_fov_y_deg(fov_y_deg: f64, height: usize) -> Option<Self> {
        let is_possible = fov_y_deg > 0.0 && fov_y_deg < 180.0;
        let focal_px = 0.5 * height as f64 / (0.5 * fov_y_deg).to_radians().tan();
        is_possible.then_some(Self::Known(focal_px))
    }
}

impl Calibration {
    /// A warning if the focal length is far from `exif_px`, that of the photograph's EXIF data.
    pub fn doubtful_exif(&self, exif_px: f64) -> Warnings {
        let mut warnings = Warnings::default();
        let focal = self.focal_px.value;
        let tolerance = self.focal_px.std.map_or(0.0, |std| 3.0 * std);
        if (focal - exif_px).abs() > (EXIF_TOLERANCE * exif_px).max(tolerance) {
            warnings.push(format!(
                "the photo's EXIF data say a focal length of {exif_px:.0} px, but it is \
                 {focal:.0} px by the points; is the photo cropped, or are lengths not in metres?"
            ));
        }
        warnings
    }
}

/// Warnings of pairs beside a photograph of `size` (width, height) pixels, and beside the scene with
/// these `bounds`, if they are known.
pub fn doubtful_pairs(
    pairs: &[Pair],
    (width, height): (usize, usize),
    bounds: Option<[Vec3; 2]>,
) -> Warnings {
    let mut warnings = Warnings::default();
    let mut tell = |is_doubtful: &dyn Fn(&Pair) -> bool, what: &str| {
        let doubtful = pairs.iter().filter(|pair| is_doubtful(pair));
        let names: Vec<&str> = doubtful.map(|pair| pair.name.as_str()).collect();
        if !names.is_empty() {
            warnings.push(format!("{what}: {}", names.join(", ")));
        }
    };
    let sides = [width as f64, height as f64];
    tell(
        &|pair| (0..2).any(|n| !(0.0..=sides[n]).contains(&pair.pixel[n])),
        &format!("points that are not in the photo of {width} x {height} pixels"),
    );
    if let Some([low, high]) = bounds {
        let margin = OUTSIDE * (high - low).max_element();
        let is_away = |pair: &Pair| {
            let point = DVec3::from_array(pair.point).as_vec3();
            (point - point.max(low).min(high)).length() > margin
        };
        tell(&is_away, "points outside the scene; are they in its axes, in metres?");
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(name: &str, pixel: [f64; 2], point: [f64; 3]) -> Pair {
        Pair { name: name.into(), pixel, point }
    }

    #[test]
    fn pairs_beside_picture_and_scene_are_named() {
        let pairs = [
            pair("good", [10.0, 10.0], [0.5; 3]),
            pair("left", [-1.0, 10.0], [0.5; 3]),
            pair("in cm", [10.0, 10.0], [50.0; 3]),
        ];
        let bounds = Some([Vec3::ZERO, Vec3::ONE]);
        let warnings = doubtful_pairs(&pairs, (20, 20), bounds).0;
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(warnings[0].ends_with("20 x 20 pixels: left"), "{warnings:?}");
        assert!(warnings[1].ends_with("metres?: in cm"), "{warnings:?}");
        assert_eq!(doubtful_pairs(&pairs[..1], (20, 20), None), Warnings::default());
    }
}
