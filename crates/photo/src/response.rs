//! The camera's response: which linear value a code value stands for.

use crate::Curve;
use crate::declared::{CONTRADICTS, difference};
use std::sync::Arc;
use unrender_formats::picture::Depth;
use unrender_scene::Warnings;
use unrender_scene::color::{linear_from_srgb, srgb_from_linear};

/// How the camera or the program behind it encoded linear values.
#[derive(Clone, Debug, PartialEq)]
pub enum Response {
    /// The sRGB curve (IEC 61966-2-1).
    Srgb,
    /// Codes are proportional to radiance.
    Linear,
    /// code = linear^(1 / gamma).
    Gamma(f32),
    /// Measured, by channel; the other responses are alike in all channels.
    Measured(Arc<[Curve; 3]>),
}

impl Response {
    /// The response of measured curves, by channel.
    pub fn measured(curves: [Curve; 3]) -> Self {
        Self::Measured(Arc::new(curves))
    }

    /// The linear value of a code value in `channel`; one for one, but for measured responses,
    /// which may have another unit. Negative codes, which only floating-point files have, stay
    /// negative for [`Response::Linear`] and become zero otherwise.
    pub fn linear_from_code(&self, channel: usize, code: f32) -> f32 {
        match self {
            Self::Srgb => linear_from_srgb(code.max(0.0)),
            Self::Linear => code,
            Self::Gamma(gamma) => code.max(0.0).powf(*gamma),
            Self::Measured(curves) => curves[channel].linear(code.into()) as f32,
        }
    }

    /// The code value of a linear value in `channel`. For sRGB it is from 0 to 1, for measured
    /// responses within what was measured.
    pub fn code_from_linear(&self, channel: usize, linear: f32) -> f32 {
        match self {
            Self::Srgb => srgb_from_linear(linear),
            Self::Linear => linear,
            Self::Gamma(gamma) => linear.max(0.0).powf(1.0 / gamma),
            Self::Measured(curves) => curves[channel].code(linear.into()) as f32,
        }
    }

    /// The linear distance from `code` to the codes beside it, `step` away: the mean of both
    /// sides, or the one side that there is at the ends.
    pub fn step(&self, channel: usize, code: f32, step: f32) -> f32 {
        let below = (code - step).max(0.0);
        let above = (code + step).min(1.0);
        let distance =
            self.linear_from_code(channel, above) - self.linear_from_code(channel, below);
        distance * step / (above - below).max(0.5 * step)
    }

    /// The greatest code in `channel` whose linear value is known.
    pub fn last_code(&self, channel: usize) -> f32 {
        match self {
            Self::Measured(curves) => curves[channel].last_code() as f32,
            _ => f32::INFINITY,
        }
    }
}

/// The response to use for a file of this depth, and what is doubtful about it.
///
/// Without a word from the project, integer files are as they declare themselves, or else sRGB, and
/// floating-point files are linear.
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
        (Some(stated), Some(declared)) if difference(stated, &declared) > CONTRADICTS => {
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
    fn doubtful_responses_are_told() {
        let told = |depth, stated| {
            let (response, warnings) = choose_response(depth, stated, None);
            (response, warnings.0.len())
        };
        assert_eq!(told(Depth::Float, None), (Response::Linear, 1));
        assert_eq!(told(Depth::Float, Some(Response::Linear)), (Response::Linear, 0));
        assert_eq!(told(Depth::Float, Some(Response::Srgb)), (Response::Srgb, 1));
        assert_eq!(told(Depth::Eight, None), (Response::Srgb, 1));
        assert_eq!(told(Depth::Eight, Some(Response::Srgb)), (Response::Srgb, 0));
        assert_eq!(told(Depth::Eight, Some(Response::Linear)), (Response::Linear, 1));
        assert_eq!(told(Depth::Sixteen, Some(Response::Linear)), (Response::Linear, 0));
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

    #[test]
    fn steps_at_the_ends_are_one_sided() {
        let step = 1.0 / 255.0;
        assert!((Response::Linear.step(0, 0.0, step) - step).abs() < 1e-7);
        assert!((Response::Linear.step(0, 1.0, step) - step).abs() < 1e-7);
        assert!(Response::Gamma(2.2).step(0, 0.0, step) > 0.0, "a step is never nothing");
    }
}
