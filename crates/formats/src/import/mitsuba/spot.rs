//! The cone of a spot: Mitsuba's fades linearly in the angle, ours by the square of a line in the cosine.

use std::f64::consts::FRAC_PI_2;

/// Angles at which two cones are compared.
const ANGLES: usize = 256;
/// Outer angles that are tried, from the one of the file on.
const TRIED: usize = 32;
/// The widest outer angle that is tried is wider by this share of the fading ring. The best ones are at 0.12 to
/// 0.4 of it; with half of this, cones that fade slowly would stop too early.
const WIDER: f64 = 0.5;
/// Halvings of the interval in which an inner angle is sought.
const HALVINGS: usize = 20;

/// A cone, and how far it is from Mitsuba's.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    pub(super) inner_rad: f32,
    pub(super) outer_rad: f32,
    /// The largest difference at any angle, as a share of the intensity on the axis.
    pub(super) off: f64,
}

/// The cone of ours that is nearest to Mitsuba's of `beam` and `cutoff`, radians, and sends as much light in
/// total.
pub(super) fn nearest(beam: f64, cutoff: f64) -> Cone {
    let as_meant = Cone { inner_rad: beam as f32, outer_rad: cutoff as f32, off: 0.0 };
    if beam >= cutoff {
        return as_meant;
    }
    let meant = |angle: f64| ((cutoff - angle) / (cutoff - beam)).clamp(0.0, 1.0);
    let widest = (cutoff + WIDER * (cutoff - beam)).min(FRAC_PI_2);
    let step = widest / ANGLES as f64;
    let angles: Vec<[f64; 3]> = (0..ANGLES)
        .map(|k| {
            let angle = (k as f64 + 0.5) * step;
            [angle.cos(), angle.sin(), meant(angle)]
        })
        .collect();
    let wanted: f64 = angles.iter().map(|[_, sin, meant]| sin * meant).sum();
    let sent = |cone: [f64; 2]| -> f64 {
        let cosines = cone.map(f64::cos);
        angles.iter().map(|[cos, sin, _]| sin * falloff(*cos, cosines)).sum()
    };
    let outers = (0..TRIED).map(|k| cutoff + k as f64 / TRIED as f64 * (widest - cutoff));
    let fitted = outers.filter_map(|outer| {
        let [mut low, mut high] = [0.0, outer];
        for _ in 0..HALVINGS {
            let inner = 0.5 * (low + high);
            if sent([inner, outer]) < wanted { low = inner } else { high = inner }
        }
        // Too wide a cone sends too much however early it fades.
        if low == 0.0 {
            return None;
        }
        let cosines = [low, outer].map(f64::cos);
        let differences =
            angles.iter().map(|[cos, _, meant]| (falloff(*cos, cosines) - meant).abs());
        let off = differences.fold(0.0, f64::max);
        Some(Cone { inner_rad: low as f32, outer_rad: outer as f32, off })
    });
    fitted.min_by(|a, b| a.off.total_cmp(&b.off)).unwrap_or(Cone { off: 1.0, ..as_meant })
}

/// Our share of the intensity at an angle of this cosine, for the cosines of an inner and an outer angle.
fn falloff(cos: f64, [inner, outer]: [f64; 2]) -> f64 {
    let share = ((cos - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0);
    share * share
}
