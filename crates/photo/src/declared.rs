//! Chooses the response: the one that a file declares, or the one that the project states.

use crate::{Curve, Response};
use unrender_scene::color::linear_from_srgb;
use unrender_scene::{Depth, Profile, Warnings};

/// Curves are the same if no linear value differs by more than this: about one step of 8 bits. Half
/// of it separates roundings of the sRGB curve, double of it joins gammas of 2.2 and sRGB.
const SAME: f32 = 5e-3;
/// A stated response contradicts a declared one if a linear value differs by more than this: sRGB
/// and a gamma of 2.2 do not, sRGB and a gamma of 1.8 do.
const CONTRADICTS: f32 = 0.02;

/// The response that `profile` declares; none without a curve, or with one that is not increasing.
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

/// The largest difference between the linear values of two responses.
fn difference(a: &Response, b: &Response) -> f32 {
    let at = |k: u8| {
        let code = f32::from(k) / 255.0;
        let channels =
            (0..3).map(|c| (a.linear_from_code(c, code) - b.linear_from_code(c, code)).abs());
        channels.fold(0.0, f32::max)
    };
    (0..=255).map(at).fold(0.0, f32::max)
}

/// The response to use for a file of this depth, with warnings.
///
/// If the project states none, integer files have the response that they declare, or else sRGB, and
/// floating-point files are linear. Formats that only hold linear values declare [`Response::Linear`].
pub fn choose_response(
    depth: Depth,
    stated: Option<Response>,
    declared: Option<Response>,
) -> (Response, Warnings) {
    let mut warnings = Warnings::default();
    match (&stated, declared) {
        (None, Some(declared)) if depth != Depth::Float => {
            warnings.push("the project states no response; that of the photo's profile was taken");
            return (declared, warnings);
        }
        (None, Some(Response::Linear)) => return (Response::Linear, warnings),
        (Some(stated), Some(declared))
            if depth != Depth::Float && difference(stated, &declared) > CONTRADICTS =>
        {
            warnings.push(
                "the photo's profile declares another response than the project states; the \
                 project's was taken",
            );
        }
        _ => {}
    }
    let response = match (depth, stated) {
        (Depth::Float, None) => {
            warnings.push(
                "the project states no response; the photo has floating-point values, \
                 so \"linear\" was taken",
            );
            Response::Linear
        }
        (_, None) => {
            warnings.push("the project states no response; \"srgb\" was taken");
            Response::Srgb
        }
        (Depth::Eight, Some(Response::Linear)) => {
            warnings.push(
                "response = \"linear\" for an 8-bit photo is unusual; \
                 if it looks right on a screen, it is \"srgb\"",
            );
            Response::Linear
        }
        (Depth::Float, Some(response @ (Response::Srgb | Response::Gamma(_)))) => {
            warnings.push(
                "the photo has floating-point values, which are nearly always linear, \
                 but the project states another response",
            );
            response
        }
        (_, Some(response)) => response,
    };
    (response, warnings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubtful_responses_give_warnings() {
        let chosen = |depth, stated| {
            let (response, warnings) = choose_response(depth, stated, None);
            (response, warnings.0.len())
        };
        assert_eq!(chosen(Depth::Float, None), (Response::Linear, 1));
        assert_eq!(chosen(Depth::Float, Some(Response::Linear)), (Response::Linear, 0));
        // EXR and HDR are linear; a TIFF of floating-point values need not be.
        let of_exr = |stated| choose_response(Depth::Float, stated, Some(Response::Linear));
        assert_eq!(of_exr(None), (Response::Linear, Warnings::default()));
        assert_eq!(of_exr(Some(Response::Srgb)).1.0.len(), 1);
        assert_eq!(chosen(Depth::Float, Some(Response::Srgb)), (Response::Srgb, 1));
        assert_eq!(chosen(Depth::Eight, None), (Response::Srgb, 1));
        assert_eq!(chosen(Depth::Eight, Some(Response::Srgb)), (Response::Srgb, 0));
        assert_eq!(chosen(Depth::Eight, Some(Response::Linear)), (Response::Linear, 1));
        assert_eq!(chosen(Depth::Sixteen, Some(Response::Linear)), (Response::Linear, 0));
    }

    #[test]
    fn files_may_declare_their_response() {
        let declared = Some(Response::Gamma(1.8));
        let (response, warnings) = choose_response(Depth::Eight, None, declared.clone());
        assert_eq!((response, warnings.0.len()), (Response::Gamma(1.8), 1));
        let stated = Some(Response::Srgb);
        let (response, warnings) = choose_response(Depth::Eight, stated.clone(), declared);
        assert!(response == Response::Srgb && warnings.0[0].contains("another response"));
        // A gamma of 2.2 is as good as sRGB.
        let near = Some(Response::Gamma(2.2));
        assert!(choose_response(Depth::Eight, stated, near).1.0.is_empty());
    }
}
