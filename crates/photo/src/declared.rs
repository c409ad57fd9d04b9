//! What a file declares of its colours against what the project states.

use crate::{Curve, Response};
use unrender_formats::picture::Profile;
use unrender_scene::color::linear_from_srgb;

/// Curves are the same if no linear value differs by more than this.
const SAME: f32 = 5e-3;
/// From this difference on, a stated response contradicts a declared one.
pub(crate) const CONTRADICTS: f32 = 0.02;

/// The response that `profile` declares; none if it declares no curve, or one that does not grow.
pub fn declared_response(profile: &Profile) -> Option<Response> {
    let curves = profile.curves.as_ref()?;
    let code = |k: usize| k as f32 / (curves[0].len() - 1) as f32;
    let is_srgb = |curve: &Vec<f32>| {
        let mut errors =
            curve.iter().enumerate().map(|(k, v)| (v - linear_from_srgb(code(k))).abs());
        errors.all(|error| error < SAME)
    };
    if curves.iter().all(is_srgb) {
        return Some(Response::Srgb);
    }
    if !curves.iter().all(|curve| curve.windows(2).all(|w| w[0] < w[1])) {
        return None;
    }
    let codes: Vec<f64> = (0..curves[0].len()).map(|k| f64::from(code(k))).collect();
    let curve = |values: &Vec<f32>| {
        let values: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
        Curve::new(&codes, &values)
    };
    Some(Response::measured(curves.each_ref().map(curve)))
}

/// The largest difference of linear values by two responses.
pub(crate) fn difference(a: &Response, b: &Response) -> f32 {
    let at = |k: u8| {
        let code = f32::from(k) / 255.0;
        let channels =
            (0..3).map(|c| (a.linear_from_code(c, code) - b.linear_from_code(c, code)).abs());
        channels.fold(0.0, f32::max)
    };
    (0..=255).map(at).fold(0.0, f32::max)
}
