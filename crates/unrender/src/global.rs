//! The flags of all subcommands.

use crate::listener::Console;
use std::num::NonZeroUsize;
use std::sync::Arc;
use unrender_formats::Limits;
use unrender_scene::Scene;

/// Flags of all subcommands.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Global {
    /// Show no progress messages; results, errors and warnings are still shown.
    #[arg(long, global = true)]
    pub quiet: bool,
    /// Use this many threads [default: one per core]; the results do not depend on it.
    #[arg(long, global = true, value_name = "N")]
    pub threads: Option<NonZeroUsize>,
    /// Let scenes and materials name files outside their folder, too.
    #[arg(long, global = true)]
    pub allow_outside: bool,
    /// Read scenes without the meshes, textures and environment maps that they name and that are missing; a warning
    /// tells of each.
    #[arg(long, global = true)]
    pub allow_missing: bool,
    /// The memory that a scene or a picture may take while it is read, GiB [default: 2].
    #[arg(long, global = true, value_name = "GIB", value_parser = gibibytes)]
    pub input_memory: Option<f64>,
    /// Where messages go.
    #[arg(skip)]
    pub console: Console,
    /// A scene that the caller has in memory: `render`, `restage` and `export` take it instead of the file that
    /// their arguments name.
    #[arg(skip)]
    pub scene: Option<Arc<Scene>>,
}

impl Global {
    /// The limits of reading inputs.
    pub(crate) fn limits(&self) -> Limits {
        let memory = self.input_memory.map(|gib| (gib * f64::from(1 << 30)) as u64);
        let memory = memory.unwrap_or(Limits::default().memory);
        Limits { outside: self.allow_outside, missing: self.allow_missing, memory }
    }
}

fn gibibytes(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|gib: &f64| gib.is_finite() && *gib > 0.0);
    number.ok_or_else(|| "is not a positive number".into())
}
