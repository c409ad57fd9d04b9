//! Camera responses: the map from pixel values (codes) to linear values.

use crate::Curve;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::str::FromStr;
use std::sync::Arc;
use unrender_scene::color::{linear_from_srgb, srgb_from_linear};

/// The encoding of linear values by the camera or its software.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Response {
    /// The sRGB curve (IEC 61966-2-1).
    Srgb,
    /// Codes are proportional to radiance.
    Linear,
    /// code = linear^(1 / gamma).
    Gamma(f32),
    /// Measured, per channel; the other responses are the same in all channels.
    Measured(#[serde(serialize_with = "pointee", deserialize_with = "pointer")] Arc<[Curve; 3]>),
}

fn pointee<S: Serializer>(curves: &Arc<[Curve; 3]>, serializer: S) -> Result<S::Ok, S::Error> {
    curves.as_ref().serialize(serializer)
}

fn pointer<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<[Curve; 3]>, D::Error> {
    <[Curve; 3]>::deserialize(deserializer).map(Arc::new)
}

/// There is no response of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no response \"{0}\"; those with a name are {names}", names = Response::NAMES.join(" and "))]
pub struct UnknownResponse(pub String);

impl FromStr for Response {
    type Err = UnknownResponse;

    /// The response of one of [`Response::NAMES`].
    fn from_str(name: &str) -> Result<Self, UnknownResponse> {
        match name {
            "srgb" => Ok(Self::Srgb),
            "linear" => Ok(Self::Linear),
            _ => Err(UnknownResponse(name.to_owned())),
        }
    }
}

impl Response {
    /// The names of the responses without a number or a measurement.
    pub const NAMES: [&str; 2] = ["srgb", "linear"];

    /// The response of measured curves, one per channel.
    pub fn measured(curves: [Curve; 3]) -> Self {
        Self::Measured(Arc::new(curves))
    }

    /// The linear value of a code in `channel`. The code one has the linear value one, except in
    /// measured responses, which may have another unit. Negative codes, which only floating-point
    /// files have, stay negative for [`Response::Linear`] and become zero otherwise.
    pub fn linear_from_code(&self, channel: usize, code: f32) -> f32 {
        match self {
            Self::Srgb => linear_from_srgb(code.max(0.0)),
            Self::Linear => code,
            Self::Gamma(gamma) => code.max(0.0).powf(*gamma),
            Self::Measured(curves) => curves[channel].linear(code.into()) as f32,
        }
    }

    /// The code of a linear value in `channel`, clamped to 0 to 1 for sRGB and to the measured
    /// range for measured responses.
    pub fn code_from_linear(&self, channel: usize, linear: f32) -> f32 {
        match self {
            Self::Srgb => srgb_from_linear(linear),
            Self::Linear => linear,
            Self::Gamma(gamma) => linear.max(0.0).powf(1.0 / gamma),
            Self::Measured(curves) => curves[channel].code(linear.into()) as f32,
        }
    }

    /// The linear difference between `code` and the adjacent codes, `step` away: the mean of both
    /// sides, one-sided at the ends.
    pub fn step(&self, channel: usize, code: f32, step: f32) -> f32 {
        let below = (code - step).max(0.0);
        let above = (code + step).min(1.0);
        let distance =
            self.linear_from_code(channel, above) - self.linear_from_code(channel, below);
        distance * step / (above - below).max(0.5 * step)
    }

    /// The largest code in `channel` with a known linear value.
    pub fn last_code(&self, channel: usize) -> f32 {
        match self {
            Self::Measured(curves) => curves[channel].last_code() as f32,
            _ => f32::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_read() {
        let read = Response::NAMES.map(|name| name.parse::<Response>().unwrap());
        assert_eq!(read, [Response::Srgb, Response::Linear]);
        let error = "gamma".parse::<Response>().unwrap_err();
        assert!(Response::NAMES.iter().all(|name| error.to_string().contains(name)), "{error}");
    }

    #[test]
    fn steps_at_the_ends_are_one_sided() {
        let step = 1.0 / 255.0;
        assert!((Response::Linear.step(0, 0.0, step) - step).abs() < 1e-7);
        assert!((Response::Linear.step(0, 1.0, step) - step).abs() < 1e-7);
        assert!(Response::Gamma(2.2).step(0, 0.0, step) > 0.0, "a step is never nothing");
    }
}
