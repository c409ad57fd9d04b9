//! The command line of the experiment.

use clap::Args;
use std::path::PathBuf;
use unrender::commands::recover::Effort;

/// Recovers one group at a time while all others have their true materials, to see whether the light or
/// the neighbours are wrong.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    cargo run --release -p unrender-benches -- one-unknown room/project.toml room/truth.json\n  \
    cargo run --release -p unrender-benches -- one-unknown room/project.toml room/truth.json \
    --groups table,floor --seeds 3\n\n\
    A group that is wrong here has right neighbours: its light is wrong, or the choice of its \
    hypothesis. A group that is right here and wrong in the whole recovery has wrong neighbours.")]
pub(crate) struct OneUnknownRequest {
    /// The project file.
    pub(super) project: PathBuf,
    /// The true materials of the scene's groups, in the format of materials.json.
    pub(super) truth: PathBuf,
    /// The groups to recover, one after the other, separated by commas [default: those that the project
    /// recovers].
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) groups: Vec<String>,
    /// Recover each group with this many seeds of the renderings' noise.
    #[arg(long, value_name = "N", default_value_t = 1,
        value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) seeds: u64,
    /// How much work to spend on each group.
    #[arg(long, value_enum, default_value_t = Effort::Draft)]
    pub(super) effort: Effort,
}
