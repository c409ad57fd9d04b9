//! The command line of the rooms.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

use crate::{peers, root};

/// Recovers rooms that artists made and Mitsuba photographed, and scores the results.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    cargo run --release -p unrender-benches -- rooms trees\n  \
    cargo run --release -p unrender-benches -- rooms trees --room staircase --effort normal --peer 600")]
pub(crate) struct RoomsRequest {
    /// The folder with the trees dppm/, rg/, ppg/ and jg/ that benches/rooms/take_out.py takes out of fetched
    /// repositories.
    pub(super) folder: PathBuf,
    /// A room to measure; may be repeated [default: all whose files are there].
    #[arg(long = "room", value_name = "NAME")]
    pub(super) rooms: Vec<String>,
    /// How much work each recovery spends.
    #[arg(long, value_enum, default_value_t = RoomEffort::Draft)]
    pub(super) effort: RoomEffort,
    /// The photograph's format: linear EXR or 8-bit PNG.
    #[arg(long, value_enum, default_value_t = Photos::Both)]
    pub(super) photo: Photos,
    /// What unrender reads: the published file as it is, or the one rewritten for Mitsuba 3.9.1.
    #[arg(long, value_enum, default_value_t = Input::Published)]
    pub(super) input: Input,
    /// The lobe to recover, as `brdf` in a project [default: the program's for a Mitsuba scene].
    #[arg(long, value_name = "NAME")]
    pub(super) brdf: Option<String>,
    /// Also run Mitsuba's own inverse (prb and Adam) for this many seconds.
    #[arg(long, value_name = "SECONDS")]
    pub(super) peer: Option<f64>,
    /// Score the materials alone: no new view, no new light, no recovery of diffuse materials beside it.
    #[arg(long)]
    pub(super) materials_only: bool,
    /// Instead of the rooms, measure three tasks with one unknown texture each, beside Mitsuba at equal time.
    #[arg(long)]
    pub(super) one_texture: bool,
    /// Small photographs of few samples, as a trial; the page is not changed.
    #[arg(long)]
    pub(super) quick: bool,
    /// The folder of photographs and results; existing ones are used [default: target/performance/rooms].
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// The unrender command under test [default: built from this tree].
    #[arg(long, value_name = "PATH")]
    pub(super) command: Option<PathBuf>,
    /// Recover even if there are results of the same command with the same flags.
    #[arg(long)]
    pub(super) again: bool,
    /// Recoveries that take longer are ended and count as failed, seconds.
    #[arg(long, value_name = "S", default_value_t = 3600)]
    pub(super) limit: u64,
    /// The name of the program under test in the tables: rows of other names stay [default: its version].
    #[arg(long, value_name = "TEXT")]
    label: Option<String>,
    /// The page [default: docs/validation/rooms.md].
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
}

/// The effort of a recovery.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum RoomEffort {
    Draft,
    Normal,
    High,
}

impl RoomEffort {
    /// Its name for `unrender recover`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Normal => "normal",
            Self::High => "high",
        }
    }
}

/// The format of a photograph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Photo {
    /// 32-bit floats, linear.
    Exr,
    /// 8 bits, sRGB.
    Png,
}

impl Photo {
    /// Its extension.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Exr => "exr",
            Self::Png => "png",
        }
    }
}

/// The formats to recover from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Photos {
    Exr,
    Png,
    Both,
}

impl Photos {
    pub(super) fn all(self) -> Vec<Photo> {
        match self {
            Self::Exr => vec![Photo::Exr],
            Self::Png => vec![Photo::Png],
            Self::Both => vec![Photo::Exr, Photo::Png],
        }
    }
}

/// The scene file that unrender reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Input {
    Published,
    Prepared,
}

impl RoomsRequest {
    /// The folder of photographs and results; quick ones lie apart.
    pub(super) fn kept(&self) -> PathBuf {
        let folder =
            self.keep.clone().unwrap_or_else(|| peers::target_folder().join("performance/rooms"));
        if self.quick { folder.join("quick") } else { folder }
    }

    /// The page to write.
    pub(super) fn page(&self) -> Option<PathBuf> {
        match &self.page {
            Some(path) => Some(path.clone()),
            None if self.quick => None,
            None => Some(root().join("docs/validation/rooms.md")),
        }
    }

    /// The program's name in the tables.
    pub(super) fn label(&self) -> String {
        self.label.clone().unwrap_or_else(|| env!("CARGO_PKG_VERSION").to_owned())
    }

    /// Further arguments of `unrender recover`: scenes and meshes lie in two folders.
    pub(super) fn recover_words(&self) -> Vec<String> {
        ["--effort", self.effort.name(), "--allow-outside"].map(str::to_owned).to_vec()
    }
}
