//! Measures the effect of half and double of a constant of the recovery:
//! `cargo run --release -p unrender-benches -- halves NAMES`.
//!
//! [`code`] finds the constants in the code and writes other values into a copy of it, [`measure`] builds that copy and
//! recovers the tiny scenes of `examples/corpus` with it, and [`page`] writes a row for each constant into
//! `docs/validation/halves.md`. Rows of other constants stay: a constant takes about three minutes.

mod code;
mod measure;
mod page;

use crate::{Failure, root};
use clap::Args;
use code::Constant;
use measure::Bench;
use std::path::PathBuf;

/// Recovers the tiny scenes of examples/corpus with half and with double of constants of the recovery.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    cargo run --release -p unrender-benches -- halves WORST driver::BETTER\n  \
    cargo run --release -p unrender-benches -- halves --seeds 3\n\n\
    The code is copied and built for each value; yours stays as it is.")]
pub(crate) struct HalvesRequest {
    /// The constants, by name, or by file and name where files share one [default: all of crates/recover
    /// whose value is one number].
    names: Vec<String>,
    /// Recover every scene with this many seeds.
    #[arg(long, value_name = "N", default_value_t = 2,
        value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// The folder of the page.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Measures one constant after the other; its row is written at once.
///
/// # Errors
/// If a constant is unknown, or the unchanged code cannot be built or recovers nothing.
pub(crate) fn run(request: &HalvesRequest) -> Result<(), Failure> {
    let all = code::constants()?;
    let chosen: Vec<&Constant> = match request.names.as_slice() {
        [] => all.iter().collect(),
        names => names.iter().map(|name| one(&all, name)).collect::<Result<_, _>>()?,
    };
    let folder = request.out.clone().unwrap_or_else(|| root().join("docs/validation"));
    let bench = Bench::new(request.seeds)?;
    let as_it_is = bench.measure(None)?;
    eprintln!("as it is: {as_it_is}");
    for constant in chosen {
        let [half, double] = [0.5, 2.0].map(|factor| bench.measure(Some((constant, factor))));
        let say = |found: &Result<_, Failure>| match found {
            Ok(outcome) => format!("{outcome}"),
            Err(problem) => format!("not built: {}", page::first_line(&problem.to_string())),
        };
        eprintln!("{constant}: half {}; double {}", say(&half), say(&double));
        page::write(&folder, constant, &as_it_is, [say(&half), say(&double)])?;
    }
    Ok(())
}

/// The constant called `name`.
fn one<'a>(all: &'a [Constant], name: &str) -> Result<&'a Constant, Failure> {
    let found: Vec<&Constant> = all.iter().filter(|constant| constant.is_called(name)).collect();
    match found.as_slice() {
        [one] => Ok(one),
        [] => Err(format!("no constant {name} of crates/recover is one number").into()),
        several => {
            let names: Vec<String> = several.iter().map(|c| c.to_string()).collect();
            Err(format!("{name} may be {}", names.join(" or ")).into())
        }
    }
}
