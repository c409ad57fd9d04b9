//! The command line of the corpus.

use super::family::{Family, Renderer};
use super::generate::Plan;
use super::spoil::Dial;
use super::store::Format;
use clap::{Args, ValueEnum};
use std::ops::Range;
use std::path::PathBuf;

/// Recovers random scenes that other renderers photographed, and scores the results.
#[derive(Args)]
pub(crate) struct CorpusRequest {
    /// The seeds, B not included.
    #[arg(long, value_name = "A..B", value_parser = seeds, default_value = "0..60")]
    pub(super) seeds: Range<u64>,
    /// The family of the scenes.
    #[arg(long, value_enum, default_value_t = Family::InModel)]
    pub(super) family: Family,
    /// The folder of scenes, photographs and results; existing ones are used.
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Width and height of the photographs, pixels [default: 240x180].
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<(usize, usize)>,
    /// Small photographs of few samples, as a trial.
    #[arg(long)]
    pub(super) quick: bool,
    /// The renderer of the photographs [default: by the seed].
    #[arg(long, value_enum)]
    pub(super) renderer: Option<Renderer>,
    /// The formats of the photographs.
    #[arg(long, value_enum, default_value_t = Formats::BySeed)]
    formats: Formats,
    /// The errors of the model.
    #[arg(long, value_enum, default_value_t = Dials::BySeed)]
    dial: Dials,
    /// Continue with the next scene if one fails.
    #[arg(long)]
    pub(super) keep_going: bool,
    /// Make the photographs and recover nothing.
    #[arg(long)]
    pub(super) photographs: bool,
    /// Make the tiny scenes of examples/corpus in the folder, and nothing else.
    #[arg(long)]
    pub(super) tiny: bool,
    /// Compare the photographs with our own renderings of the truth, and recover nothing.
    #[arg(long)]
    pub(super) verify: bool,
    /// Photograph each scene again from two and four places, and with a lamp off, and recover from all of them.
    #[arg(long)]
    pub(super) several: bool,
    /// The unrender command under test [default: built from this tree].
    #[arg(long, value_name = "PATH")]
    pub(super) command: Option<PathBuf>,
    /// Further flags of its `recover`, as one argument.
    #[arg(long, value_name = "FLAGS", default_value = "", allow_hyphen_values = true)]
    pub(super) recover_args: String,
    /// Recover even if there are results of the same command with the same flags.
    #[arg(long)]
    pub(super) again: bool,
    /// Test in new light and from a new viewpoint (always done for the foreign family).
    #[arg(long)]
    pub(super) relight: bool,
    /// Recoveries that take longer are ended and count as failed, seconds.
    #[arg(long, value_name = "S", default_value_t = 1200)]
    pub(super) limit: u64,
    /// The page for the results, such as docs/validation/corpus.md [default: only printed].
    #[arg(long, value_name = "FILE")]
    pub(super) page: Option<PathBuf>,
}

/// The choice of the photographs' formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Formats {
    BySeed,
    All,
    Exr,
    Png,
    Jpeg,
}

/// The choice of the models' errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Dials {
    BySeed,
    All,
    Exact,
    Camera,
    Missing,
    Lamp,
    Bevel,
}

/// Width and height of photographs.
const SIZE: (usize, usize) = (240, 180);
const QUICK_SIZE: (usize, usize) = (120, 90);

impl CorpusRequest {
    /// Width and height of the photographs.
    pub(super) fn picture_size(&self) -> (usize, usize) {
        self.size.unwrap_or(if self.quick { QUICK_SIZE } else { SIZE })
    }

    /// The photographs and models with which a scene is recovered.
    pub(super) fn ways(&self, plan: &Plan) -> Vec<(Format, Dial)> {
        let formats = match self.formats {
            Formats::BySeed => vec![Format::ALL[plan.seed as usize % Format::ALL.len()]],
            Formats::All => Format::ALL.to_vec(),
            Formats::Exr => vec![Format::Exr],
            Formats::Png => vec![Format::Png],
            Formats::Jpeg => vec![Format::Jpeg],
        };
        let dials = match self.dial {
            Dials::BySeed => vec![Dial::of_seed(plan)],
            Dials::All => Dial::ALL.to_vec(),
            Dials::Exact => vec![Dial::Exact],
            Dials::Camera => vec![Dial::Camera],
            Dials::Missing => vec![Dial::Missing],
            Dials::Lamp => vec![Dial::Lamp],
            Dials::Bevel => vec![Dial::Bevel],
        };
        let able = dials.into_iter().filter(|dial| dial.spoilt(plan).is_some());
        able.flat_map(|dial| formats.iter().map(move |&format| (format, dial))).collect()
    }
}

fn seeds(text: &str) -> Result<Range<u64>, String> {
    let problem = || format!("\"{text}\" is not a range of seeds; write A..B, such as 0..60");
    let (first, last) = text.split_once("..").ok_or_else(problem)?;
    let number = |text: &str| text.trim().parse::<u64>().map_err(|_| problem());
    let range = number(first)?..number(last)?;
    if range.is_empty() { Err(format!("{text} is empty; B is not included")) } else { Ok(range) }
}

fn size(text: &str) -> Result<(usize, usize), String> {
    let problem = || format!("\"{text}\" is not a size; write WIDTHxHEIGHT, such as 240x180");
    let (width, height) = text.split_once('x').ok_or_else(problem)?;
    let number = |text: &str| text.trim().parse().ok().filter(|n| (16..=8192).contains(n));
    Ok((number(width).ok_or_else(problem)?, number(height).ok_or_else(problem)?))
}
