//! `unrender merge`: parts of a rendering become the picture that one run would have made.

use crate::cli::{Global, warn};
use crate::part::{self, Part};
use crate::{Error, interrupt, output, passes};
use std::path::PathBuf;
use std::process::ExitCode;
use unrender_formats::FileError;
use unrender_render::Tally;
use unrender_scene::Warnings;

/// Puts parts of a rendering together: to the bit the picture that one run would have made.
///
/// Parts are made by `unrender render --samples A..B`; the checkpoint of a rendering is one too.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples, on two machines and then on either:\n  \
    unrender render room.glb --samples 0..512 --out part1.exr\n  \
    unrender render room.glb --samples 512..1024 --out part2.exr\n  \
    unrender merge part1.exr part2.exr --out room.png")]
pub struct Args {
    /// The parts, in any order.
    #[arg(required = true, value_name = "PART.exr")]
    pub parts: Vec<PathBuf>,
    /// Take it that samples are missing between the parts. The picture is noisier, and right.
    #[arg(long)]
    pub allow_gaps: bool,
    /// The picture to write: .exr or .hdr (linear radiance), or .png (8-bit sRGB).
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// If a part cannot be read, if the parts are not of one rendering, overlap or leave gaps, or if the
/// picture cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    output::check_picture(&args.out)?;
    let mut sum: Option<Part> = None;
    let mut ranges = Vec::new();
    for path in &args.parts {
        let part = part::read(path)?;
        ranges.push((part.head.samples.clone(), path));
        match &mut sum {
            None => sum = Some(part),
            Some(sum) => add(sum, &part)?,
        }
    }
    ranges.sort_by_key(|(samples, _)| (samples.start, samples.end));
    let mut warnings = Warnings::default();
    let mut end = 0;
    for (index, (samples, path)) in ranges.iter().enumerate() {
        if samples.start < end {
            let (before, other) = &ranges[index - 1];
            return Err(FileError::new(path, format!(
                "has the samples {}..{}, of which {} has some too ({}..{}); leave one of them out",
                samples.start, samples.end, other.display(), before.start, before.end
            ))
            .into());
        }
        if samples.start > end {
            let gap = format!("the samples {end}..{} are in no part", samples.start);
            if !args.allow_gaps {
                let remedy = "render them, or take the picture without them by --allow-gaps";
                return Err(Error::Request(format!("{gap}; {remedy}")));
            }
            warnings.push(format!("{gap}; the picture was made without them"));
        }
        end = samples.end;
    }
    warn(&warnings);
    let tally = sum.map_or_else(|| Tally::new(0, 0), |part| part.tally);
    if !global.quiet {
        let count = ranges.iter().map(|(samples, _)| samples.end - samples.start).sum();
        eprintln!("{}", passes::in_words(count, &tally));
    }
    let _until_written = interrupt::writing();
    output::write_picture(&args.out, &tally)?;
    Ok(ExitCode::SUCCESS)
}

/// Adds the samples of `part`, if both are of one rendering.
fn add(sum: &mut Part, part: &Part) -> Result<(), Error> {
    let problem = if let Some(difference) = part.head.identity.difference(&sum.head.identity) {
        format!("does not belong to {}: it has {difference}", sum.path.display())
    } else if part.head.identity.adaptive {
        "was sampled adaptively, which is not done in parts; it can only be merged alone".into()
    } else {
        sum.tally.add(&part.tally);
        return Ok(());
    };
    Err(FileError::new(&part.path, problem).into())
}
