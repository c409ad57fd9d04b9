//! The claims about the speed of unrender, measured beside the programs that one would use instead.
//!
//! `cargo run --profile dist -p unrender-benches` measures all claims, one after the other, and writes
//! them to `docs/validation/performance.md`; `-- traversal` and so on one of them, whose section it
//! replaces. Ratios are of measurements that alternate in one run, so that other load of the machine
//! affects both. The other programs are installed from PyPI into a folder beside the build's outputs; if
//! one is not available, its rows state it. To add a claim, write a module with a `measure` beside
//! [`traversal`] and name it in [`Claim`].
//!
//! Seven requests are not about speed: [`real`], [`corpus`] and [`rooms`] recover from photographs that the program
//! did not make, [`one_unknown`] is a fast experiment on one group at a time, [`noise`] measures the noise of our
//! light, before and after a change of the renderer, [`stored_paths`] the cost of stored paths, and [`halves`]
//! the effect of half and double of a constant.

mod command;
mod corpus;
mod halves;
mod machine;
mod noise;
mod one_unknown;
mod page;
mod peers;
mod plot;
mod real;
mod recovery;
mod rendering;
mod rooms;
mod scaling;
mod scenes;
mod statistics;
mod stored_paths;
mod table;
mod traversal;

use clap::{Parser, Subcommand, ValueEnum};
use page::Section;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Any error that ends a measurement.
type Failure = Box<dyn std::error::Error>;

/// Measures the claims about the speed of unrender, and writes the page.
#[derive(Parser)]
#[command(args_conflicts_with_subcommands = true)]
struct Request {
    #[command(subcommand)]
    other: Option<Other>,
    /// The claims to measure [default: all].
    #[arg(value_enum)]
    claims: Vec<Claim>,
    /// Measure little, as a trial; the page is not changed.
    #[arg(long)]
    quick: bool,
    /// The folder of the page and of its plots [default: docs/validation, or with --quick
    /// target/performance].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// The other requests.
#[derive(Subcommand)]
enum Other {
    /// Recovers materials from real photographs and scores them.
    Real(real::RealRequest),
    /// Recovers random scenes that other renderers photographed, and scores the results.
    Corpus(corpus::CorpusRequest),
    /// Recovers one group at a time while all others have their true materials.
    OneUnknown(one_unknown::OneUnknownRequest),
    /// Recovers tiny scenes with half and double of the recovery's constants.
    Halves(halves::HalvesRequest),
    /// Measures the noise of our light, scene by scene and group by group.
    Noise(noise::NoiseRequest),
    /// Recovers rooms that artists made and Mitsuba photographed, and scores the results.
    Rooms(rooms::RoomsRequest),
    /// Measures stored paths: the cost of recording and replaying them, beside that of tracing
    /// them.
    Stored(stored_paths::StoredRequest),
}

/// The effort of a measurement.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Effort {
    Quick,
    Full,
}

impl Effort {
    /// One of two numbers.
    fn pick<T>(self, quick: T, full: T) -> T {
        if self == Self::Quick { quick } else { full }
    }
}

/// The claims, in the order of the page.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Claim {
    /// Rays per second, beside Embree.
    Traversal,
    /// Pictures at equal time, beside Mitsuba 3 and Radiance.
    Rendering,
    /// Recovery, beside Mitsuba 3 and our own renderings.
    Recovery,
    /// Time and memory against pixels, triangles, groups and bounces.
    Scaling,
}

impl Claim {
    fn measure(self, effort: Effort) -> Result<Section, Failure> {
        match self {
            Self::Traversal => traversal::measure(effort),
            Self::Rendering => rendering::measure(effort),
            Self::Recovery => recovery::measure(effort),
            Self::Scaling => scaling::measure(effort),
        }
    }

    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

fn main() -> ExitCode {
    let request = Request::parse();
    match run(&request) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn run(request: &Request) -> Result<(), Failure> {
    match &request.other {
        Some(Other::Real(real)) => return real::run(real),
        Some(Other::Corpus(corpus)) => return corpus::run(corpus),
        Some(Other::OneUnknown(one_unknown)) => return one_unknown::run(one_unknown),
        Some(Other::Halves(halves)) => return halves::run(halves),
        Some(Other::Noise(noise)) => return noise::run(noise),
        Some(Other::Rooms(rooms)) => return rooms::run(rooms),
        Some(Other::Stored(stored)) => return stored_paths::run(stored),
        None => {}
    }
    let effort = if request.quick { Effort::Quick } else { Effort::Full };
    let folder = match &request.out {
        Some(folder) => folder.clone(),
        None if request.quick => peers::target_folder().join("performance"),
        None => root().join("docs/validation"),
    };
    let chosen = |claim: &&Claim| request.claims.is_empty() || request.claims.contains(claim);
    for claim in Claim::value_variants().iter().filter(chosen) {
        let name = claim.name();
        eprintln!("== {name}");
        let section = claim.measure(effort)?;
        println!("{}", section.text);
        page::write(&folder, &name, &section)?;
    }
    eprintln!("written to {}", folder.join(page::FILE).display());
    Ok(())
}

/// The root of the repository.
fn root() -> PathBuf {
    let benches = Path::new(env!("CARGO_MANIFEST_DIR"));
    benches.parent().unwrap_or(benches).to_owned()
}
