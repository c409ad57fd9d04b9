//! The number of samples: the flags that `render` and `restage` share.

use crate::progressive::Goal;
use crate::shard::Identity;
use serde::Serialize;
use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;
use unrender_render::Settings;
use unrender_render::path::MAX_BOUNCES;
use unrender_scene::Camera;

const DEFAULT_SPP: u32 = 64;

/// How many samples are rendered, which ones, and where they are kept.
#[derive(Debug, clap::Args)]
pub struct SamplingArgs {
    /// Samples per pixel, on average; with --time or --noise the most [default: 64 without those].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Stop after this many seconds of rendering; the number of samples then depends on the
    /// machine.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time: Option<Duration>,
    /// Stop when the picture's relative standard error is at most this: the root mean square of
    /// the standard errors of all pixels and channels over their mean. 0.01 is one percent.
    #[arg(long, value_name = "TARGET", value_parser = target)]
    pub noise: Option<f64>,
    /// Take more samples where the picture is noisy, fewer where it is not.
    #[arg(long)]
    pub adaptive: bool,
    /// Render only the samples A up to B, B not included, as a part of the picture: the same
    /// picture can be rendered in pieces on many machines. The part is an EXR file.
    #[arg(long, value_name = "A..B", value_parser = range)]
    #[arg(conflicts_with_all = ["spp", "time", "noise", "adaptive"])]
    pub samples: Option<Range<u32>>,
    /// Save the samples to this EXR file, every minute and on Ctrl-C, and continue from it if it
    /// exists. The picture is the same to the bit.
    #[arg(long, value_name = "FILE.exr")]
    pub checkpoint: Option<PathBuf>,
    /// Chooses the noise; the same seed gives the same bits.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Trace paths for every pixel alone. Otherwise neighbouring pixels reuse each other's paths, if
    /// a test on a few squares of the picture shows that it pays: a path then takes three times as
    /// long and gains more than that, but the noise of nearby pixels is correlated. Use it for
    /// pictures whose noise is measured, or from which materials are recovered.
    #[arg(long)]
    pub independent: bool,
    /// The most reflections of a path [default: until it carries nothing more].
    #[arg(long, value_name = "N")]
    pub bounces: Option<u32>,
}

impl SamplingArgs {
    pub(crate) fn settings(&self) -> Settings {
        let max_bounces = self.bounces.unwrap_or(MAX_BOUNCES);
        Settings {
            seed: self.seed,
            max_bounces,
            integrator: unrender_render::Integrator::with_path_reuse(!self.independent),
            ..Settings::default()
        }
    }

    /// Whether time or noise decides when the picture is done.
    pub(crate) fn is_open(&self) -> bool {
        self.time.is_some() || self.noise.is_some()
    }

    pub(crate) fn goal(&self) -> Goal {
        let spp = self.spp.unwrap_or(if self.is_open() { u32::MAX } else { DEFAULT_SPP });
        Goal {
            samples: self.samples.clone().unwrap_or(0..spp),
            time: self.time,
            noise: self.noise,
            checkpoint: self.checkpoint.clone(),
        }
    }

    /// The identity of the rendering of `scene`; without fingerprints if nothing compares them.
    pub(crate) fn identity(
        &self,
        scene: &impl Serialize,
        camera: &Camera,
        (width, height): (usize, usize),
    ) -> Identity {
        let is_kept = self.samples.is_some() || self.checkpoint.is_some();
        let identity = Identity {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: String::new(),
            camera: String::new(),
            width,
            height,
            seed: self.seed,
            bounces: self.settings().max_bounces,
            adaptive: self.adaptive,
            shared: !self.independent,
        };
        if is_kept { identity.with_fingerprints(scene, camera) } else { identity }
    }
}

/// A range of numbers, as in `64..128`.
pub(crate) fn range(text: &str) -> Result<Range<u32>, String> {
    let (start, end) = text.split_once("..").ok_or("write two numbers, as in 64..128")?;
    let number = |text: &str| text.parse::<u32>().map_err(|error| format!("{text:?}: {error}"));
    let (start, end) = (number(start)?, number(end)?);
    if start < end { Ok(start..end) } else { Err(format!("{start}..{end} is empty")) }
}

fn seconds(text: &str) -> Result<Duration, String> {
    Duration::try_from_secs_f64(positive(text)?).map_err(|error| error.to_string())
}

fn target(text: &str) -> Result<f64, String> {
    positive(text)
}

/// A finite number above zero.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "is no number")?;
    let fits = number > 0.0 && number.is_finite();
    if fits { Ok(number) } else { Err("must be a number above zero".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_samples_have_two_ends_and_something_between() {
        assert_eq!(range("64..128"), Ok(64..128));
        for bad in ["64", "64..64", "9..8", "a..b", "-1..3", "0..5000000000", ".."] {
            assert!(range(bad).is_err(), "{bad}");
        }
    }
}
