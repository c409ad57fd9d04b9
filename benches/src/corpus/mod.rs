//! The corpus: random scenes from seeds, photographed by other renderers, recovered and scored.
//!
//! `cargo run --release -p unrender-benches -- corpus --seeds 0..60 --family in-model --out DIR`.
//! [`generate`] makes a scene of a seed, [`photograph`] has another renderer photograph it, [`spoil`]
//! makes the errors of model and photograph, and [`verify`] compares each photograph with our own rendering.

mod dice;
mod family;
mod generate;
mod make;
mod photograph;
mod spoil;
mod store;
mod verify;

use crate::Failure;
use clap::Args;
use family::{Family, Renderer};
use std::path::PathBuf;
use store::Folder;

/// Recovers random scenes that other renderers photographed, and scores the results.
#[derive(Args)]
pub(crate) struct CorpusRequest {
    /// The seeds, B not included.
    #[arg(long, value_name = "A..B", value_parser = seeds, default_value = "0..60")]
    seeds: std::ops::Range<u64>,
    /// The family of the scenes.
    #[arg(long, value_enum, default_value_t = Family::InModel)]
    family: Family,
    /// The folder of scenes, photographs and results; what is there is kept and used.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Width and height of the photographs, pixels.
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "240x180")]
    size: (usize, usize),
    /// The renderer of the photographs [default: by the seed].
    #[arg(long, value_enum)]
    renderer: Option<Renderer>,
    /// Go on with the next scene where one fails.
    #[arg(long)]
    keep_going: bool,
    /// Make the scenes and compare the photographs with our own renderings; recover nothing.
    #[arg(long)]
    verify: bool,
}

fn seeds(text: &str) -> Result<std::ops::Range<u64>, String> {
    let problem = || format!("\"{text}\" is no range of seeds; write A..B, such as 0..60");
    let (first, last) = text.split_once("..").ok_or_else(problem)?;
    let number = |text: &str| text.trim().parse::<u64>().map_err(|_| problem());
    let range = number(first)?..number(last)?;
    if range.is_empty() { Err(format!("{text} is empty; B is not included")) } else { Ok(range) }
}

fn size(text: &str) -> Result<(usize, usize), String> {
    let problem = || format!("\"{text}\" is no size; write WIDTHxHEIGHT, such as 240x180");
    let (width, height) = text.split_once('x').ok_or_else(problem)?;
    let number = |text: &str| text.trim().parse().ok().filter(|n| (16..=8192).contains(n));
    Ok((number(width).ok_or_else(problem)?, number(height).ok_or_else(problem)?))
}

/// Does what is asked.
///
/// # Errors
/// If a scene fails, unless it is to go on.
pub(crate) fn run(request: &CorpusRequest) -> Result<(), Failure> {
    for seed in request.seeds.clone() {
        if let Err(problem) = scene(request, seed) {
            if !request.keep_going {
                return Err(problem);
            }
            eprintln!("seed {seed}: {problem}");
        }
    }
    Ok(())
}

/// One seed.
fn scene(request: &CorpusRequest, seed: u64) -> Result<(), Failure> {
    let folder = Folder::new(&request.out, request.family, seed, request.renderer);
    let plan = make::plan(seed, request.family, request.renderer, request.size);
    make::photographs(&plan, &folder)?;
    if request.verify {
        make::verify(&plan, &folder)?;
    }
    Ok(())
}
