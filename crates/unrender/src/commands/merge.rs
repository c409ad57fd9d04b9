//! `unrender merge`: merges parts of a rendering into the picture of one run.

use crate::global::Global;
use crate::output::Encoding;
use crate::progressive_render::DIRECT;
use crate::{Error, interrupt, output, progressive, shard};
use std::path::PathBuf;
use std::process::ExitCode;
use unrender_formats::FileError;

/// Merges parts of a rendering into the picture of one run, to the bit.
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
    /// Accept that samples are missing between the parts. The picture is noisier, but unbiased.
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
    output::check_inputs(&args.out, args.parts.iter().map(PathBuf::as_path))?;
    let (sum, mut warnings) = shard::join(&args.parts, args.allow_gaps)?;
    // A picture to be denoised has a second layer with half of its samples; it is merged without
    // denoising.
    let is_picture = sum.head.layers.first().is_some_and(|layer| layer == "picture");
    let Some(accumulator) = sum.layers.first().filter(|_| is_picture) else {
        return Err(FileError::new(
            &args.parts[0],
            "is a part of a composite; `unrender restage EDIT.toml --composite --parts ...` puts \
             such parts together",
        )
        .into());
    };
    match sum.head.layers.get(1) {
        None => {}
        Some(layer) if layer.starts_with("light ") || layer == DIRECT => warnings.push(
            "the picture is written without its light layers: `render --layers`, or `--aov` if it was \
             made so, with the checkpoint writes them",
        ),
        Some(_) => warnings.push(
            "the picture was to be denoised, and is written as it is: `render --denoise` with the \
             checkpoint denoises it",
        ),
    }
    global.console.warn(&warnings);
    if !global.quiet {
        global.console.tell(&progressive::in_words(sum.head.samples.end, accumulator));
    }
    let _until_written = interrupt::writing();
    global.console.warn(&output::write_picture(&args.out, accumulator, None, Encoding::default())?);
    Ok(ExitCode::SUCCESS)
}
