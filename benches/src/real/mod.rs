//! Recovers from real photographs, and scores the results:
//! `cargo run --release -p unrender-benches -- real`.
//!
//! The photographs belong to others and are not part of the repository; `docs/validation/real.md`, which
//! this module writes, describes where each set is and how to fetch it. A case whose data is absent is left
//! out, with a message. Every case has two steps: it writes projects (`--prepare` stops there), and it
//! scores the `result` folders beside them (`--score` does only that).

mod ball;
mod data;
mod fit;
mod gray;
mod iset;
mod page;
mod sphere;
mod wall;

use crate::command::Unrender;
use crate::{Failure, peers, root};
use clap::{Args, ValueEnum};
use sphere::{Circle, Lamp};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use unrender::formats::materials::{self, GroupEntry, MaterialsFile};
use unrender::formats::{atomic, picture};
use unrender::scene::{Image, Rgb};

/// Recovers materials from real photographs and scores them.
#[derive(Args)]
pub(crate) struct RealRequest {
    /// The cases [default: all whose data is available].
    #[arg(value_enum)]
    cases: Vec<Case>,
    /// The folder `Datasets/Ball_DiliGenT` of yqueau/robust_ps at 86a1fbe [default: the environment variable
    /// UNRENDER_BALL].
    #[arg(long, value_name = "DIR")]
    ball: Option<PathBuf>,
    /// The folder `images` of NewProggie/Photometric-Stereo [default: the environment variable
    /// UNRENDER_GRAY].
    #[arg(long, value_name = "DIR")]
    gray: Option<PathBuf>,
    /// The folder with photo0, photo1, photo2 and truth.json of the measured box [default: the environment
    /// variable UNRENDER_ISET].
    #[arg(long, value_name = "DIR")]
    iset: Option<PathBuf>,
    /// The unrender command to measure [default: that of this repository, built].
    #[arg(long, value_name = "PATH")]
    command: Option<PathBuf>,
    /// The folder for projects and results [default: target/performance/work/real].
    #[arg(long, value_name = "DIR")]
    work: Option<PathBuf>,
    /// The folder of the page [default: docs/validation].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write the projects and stop.
    #[arg(long, conflicts_with = "score")]
    prepare: bool,
    /// Score existing results; recover nothing.
    #[arg(long)]
    score: bool,
    /// More options for `unrender recover`, after `--`.
    #[arg(last = true)]
    more: Vec<String>,
}

/// The cases, in the order of the page.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Case {
    /// A glossy ball: one photograph predicts others (DiLiGenT).
    Ball,
    /// A gray sphere under twelve lamps.
    Gray,
    /// A box with measured walls.
    Iset,
    /// A synthetic wall with dark rectangles that the model lacks.
    Wall,
}

/// The result of a case.
pub(crate) struct Outcome {
    /// Markdown, from its heading on.
    pub(crate) text: String,
    /// The last line.
    pub(crate) line: String,
}

/// The steps of a run, and its command.
pub(crate) struct Bench<'a> {
    command: Option<&'a Unrender>,
    folder: PathBuf,
    recovers: bool,
    more: &'a [String],
}

impl Case {
    fn name(self) -> &'static str {
        match self {
            Self::Ball => "ball",
            Self::Gray => "gray",
            Self::Iset => "iset",
            Self::Wall => "wall",
        }
    }

    fn run(self, request: &RealRequest, bench: &Bench) -> Result<Option<Outcome>, Failure> {
        match self {
            Self::Ball => ball::measure(&data::BALL.find(request.ball.as_deref())?, bench),
            Self::Gray => gray::measure(&data::GRAY.find(request.gray.as_deref())?, bench),
            Self::Iset => iset::measure(&data::ISET.find(request.iset.as_deref())?, bench),
            Self::Wall => wall::measure(bench),
        }
    }
}

/// Runs the requested cases, prints their tables and last lines, and writes the page.
///
/// # Errors
/// If a named case has no data, or one fails; the others are measured.
pub(crate) fn run(request: &RealRequest) -> Result<(), Failure> {
    let command = match &request.command {
        _ if request.prepare => None,
        Some(path) => Some(Unrender::at(path)?),
        None => Some(Unrender::build()?),
    };
    let work = request.work.clone().unwrap_or_else(|| peers::work_folder("real"));
    let page = request.out.clone().unwrap_or_else(|| root().join("docs/validation"));
    let named = |case: &Case| request.cases.contains(case);
    let (mut lines, mut failed) = (Vec::new(), false);
    for case in Case::value_variants() {
        if !request.cases.is_empty() && !named(case) {
            continue;
        }
        eprintln!("== {}", case.name());
        let bench = Bench {
            command: command.as_ref(),
            folder: work.join(case.name()),
            recovers: !request.prepare && !request.score,
            more: &request.more,
        };
        match case.run(request, &bench) {
            Ok(Some(outcome)) => {
                println!("{}", outcome.text);
                page::write(&page, case.name(), &outcome.text)?;
                lines.push(outcome.line);
            }
            Ok(None) => eprintln!("projects written to {}", bench.folder.display()),
            Err(problem) => {
                failed |= named(case) || !problem.is::<data::Absent>();
                lines.push(format!("{}: not measured: {problem}", case.name()));
            }
        }
    }
    lines.iter().for_each(|line| println!("{line}"));
    if failed { Err("not every case was measured".into()) } else { Ok(()) }
}

impl Bench<'_> {
    /// The command; none if only projects are written.
    pub(crate) fn command(&self) -> Option<&Unrender> {
        self.command
    }

    /// The folder `name` of this case, made if it is missing.
    ///
    /// # Errors
    /// If it cannot be made.
    pub(crate) fn folder(&self, name: &str) -> Result<PathBuf, Failure> {
        let folder = self.folder.join(name);
        std::fs::create_dir_all(&folder)
            .map_err(|error| format!("{}: {error}", folder.display()))?;
        Ok(folder)
    }

    /// Recovers `project` into the folder `result`, unless existing results are to be scored.
    ///
    /// # Errors
    /// If that fails, or there is no result.
    pub(crate) fn recover(&self, project: &Path, result: &Path) -> Result<MaterialsFile, Failure> {
        if let (true, Some(command)) = (self.recovers, self.command) {
            eprintln!("{}", project.display());
            let mut arguments: Vec<OsString> =
                vec!["recover".into(), project.into(), "--out".into(), result.into()];
            arguments.extend(self.more.iter().map(OsString::from));
            command.run(&arguments)?;
        }
        Ok(materials::read(&result.join("materials.json"))?)
    }
}

/// The group of this name.
///
/// # Errors
/// If the results lack it.
pub(crate) fn group<'a>(file: &'a MaterialsFile, name: &str) -> Result<&'a GroupEntry, Failure> {
    file.groups.get(name).ok_or_else(|| format!("materials.json has no group {name}").into())
}

/// A group's hypothesis in words.
pub(crate) fn hypothesis(entry: &GroupEntry) -> String {
    entry.hypothesis.map_or_else(|| "-".to_owned(), |hypothesis| hypothesis.to_string())
}

/// Three numbers with `digits` decimals.
pub(crate) fn three(values: Option<[f32; 3]>, digits: usize) -> String {
    let one = |value: f32| format!("{value:.digits$}");
    values.map_or_else(|| "-".to_owned(), |values| values.map(one).join(" "))
}

/// The square crop of `side` pixels of the picture at `path`, from pixel (`left`, `top`) on, as
/// code values from 0 to 1.
///
/// # Errors
/// If it cannot be read or is smaller.
pub(crate) fn cut(
    path: &Path,
    left: usize,
    top: usize,
    side: usize,
) -> Result<Image<Rgb>, Failure> {
    let (whole, _) = picture::read(path)?;
    let whole = whole.values;
    if whole.width() < left + side || whole.height() < top + side {
        let size = format!("{} x {} pixels", whole.width(), whole.height());
        return Err(format!("{}: its {size} are not those of the data set", path.display()).into());
    }
    Ok(Image::from_fn(side, side, |x, y| *whole.at(left + x, top + y)))
}

/// Writes the scene of a sphere under one lamp, and the project for `photo.png` beside it.
///
/// # Errors
/// If they cannot be written.
pub(crate) fn write_sphere(
    folder: &Path,
    circle: Circle,
    side: usize,
    lamp: Lamp,
) -> Result<(), Failure> {
    circle.write(side, lamp, &folder.join("scene.glb"))?;
    let project = "scene = \"scene.glb\"\nphoto = \"photo.png\"\nresponse = \"linear\"\n\
                   exposure = 1.0\n\n[recover]\nbrdf = \"ward-gmd\"\n";
    Ok(atomic::write(&folder.join("project.toml"), project.as_bytes())?)
}
