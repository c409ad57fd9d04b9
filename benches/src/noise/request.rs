//! The command line of the benchmark.

use clap::Args;
use std::path::PathBuf;

/// Measures how noisy our light is: renders each scene twice with its true materials and compares the
/// pictures, group by group.
#[derive(Args)]
#[command(after_help = HELP)]
pub(crate) struct NoiseRequest {
    /// The scenes by name [default: all available ones].
    #[arg(value_name = "CASES")]
    pub(super) cases: Vec<String>,
    /// Paths per pixel of each of the two pictures.
    #[arg(long, value_name = "N", default_value_t = 64,
        value_parser = clap::value_parser!(u32).range(2..))]
    pub(super) spp: u32,
    /// The seed of both pictures' random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) seed: u64,
    /// A folder of scenes of the corpus: each folder in it with exr_exact.toml and truth.json is a scene,
    /// with that folder's name.
    #[arg(long, value_name = "DIR")]
    pub(super) corpus: Option<PathBuf>,
    /// Writes the numbers to this file, after each scene.
    #[arg(long, value_name = "FILE.json")]
    pub(super) save: Option<PathBuf>,
    /// Compares with the numbers of an earlier run.
    #[arg(long, value_name = "FILE.json")]
    pub(super) against: Option<PathBuf>,
    /// Prints below each scene the kinds of paths that cause its noise; takes as long as the pictures again.
    #[arg(long)]
    pub(super) explain: bool,
}

const HELP: &str = "\
Columns:
  mean       mean radiance of the group, mean of the three channels; all noise is in units of it
  rms %      root mean square of the noise of one picture
  robust %   the same from the median, which a few bright pixels do not change
  ratio      rms over robust: 1 for Gaussian noise that is equal everywhere, 1 to 2 where light is uneven,
             more where a few pixels are much too bright (fireflies)
  worst %    share of the variance in the worst 0.1 % of the pixels, at least one pixel: 1 for Gaussian noise of
             many pixels, near 100 for a few fireflies
  s          seconds of one rendering
  Mpaths/s   million paths from the camera per second
Pixels that show a lamp, even in part, and pixels that show nothing are not used. Groups of fewer than 100
pixels have no row, but count in the row (picture).

Columns with --against (above 1 is better, except for \"mean x\"):
  mean x      mean radiance over that of before: if it differs from 1 by more than noise, one of the two has a bias
  efficiency  variance x seconds before over the same now: the speedup at the same noise
  of groups   the geometric mean of the groups' efficiencies
  of robust   the same from the robust noise: the effect of a change on all pixels except the worst
  speed       paths per second over those of before

Kinds of paths with --explain, a letter for each vertex: D diffuse, G glossy, M mirror; then how the light was found:
L a ray hit it, l a light sample, E and e the same for the environment, v a light sample via planar mirrors; g before
l, e and v: a glossy lobe reflects most of it. \"D M L\" is a caustic. Paths of both pictures have a line from 20 times
the picture's mean radiance on. Their share of the variance is their covariance with the difference of the two
pictures: all shares sum to 100, and paths that contribute equally to both pictures have none.

Examples:
  cargo run --release --bin performance -- noise
  cargo run --release --bin performance -- noise facing_mirrors corpus/mirror --explain
  cargo run --release --bin performance -- noise --save before.json
  cargo run --release --bin performance -- noise --against before.json";
