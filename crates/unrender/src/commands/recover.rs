//! `unrender recover`: from a project to the materials of its groups.

use crate::engine::{self, Alignment, Asked, Recovered};
use crate::global::Global;
use crate::growing_picture::GrowingPicture;
use crate::interrupt::{self, Pausable};
use crate::own_project::{OwnProject, Written};
use crate::progress::Progress;
use crate::recovery_journal::{self, Head, RecoveryJournal};
use crate::recovery_progress::RecoveryProgress;
use crate::result_folder::ResultFolder;
use crate::{Error, Job, Project, output, results};
use clap::ValueEnum;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use unrender_formats::Limits;
use unrender_paper::{Direction, Paper};
use unrender_recover::{Journal, Options, Termination, effort};
use unrender_remote::Workers;
use unrender_scene::{Hypothesis, Warnings};

/// Recovers the materials of a project's groups from its photograph.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  unrender recover room/project.toml --out room/result\n  \
    unrender recover --scene room.glb --photo room.jpg --out result --effort draft\n\nCtrl-C \
    ends with the best state so far, its report marked as interrupted; a second one ends at once. \
    After either, and after a crash, the same command with --resume continues from the last \
    iteration.")]
pub struct Args {
    /// The project file; `unrender init` makes one.
    #[arg(required_unless_present = "scene")]
    pub project: Option<PathBuf>,
    /// Without a project file: the scene. The project that `unrender init` would make is written into the folder of the
    /// results, as project.toml.
    #[arg(long, value_name = "FILE", requires = "photo", conflicts_with = "project")]
    pub scene: Option<PathBuf>,
    /// Without a project file: the photograph.
    #[arg(long, value_name = "FILE", requires = "scene", conflicts_with = "project")]
    pub photo: Option<PathBuf>,
    /// The folder for the results: a new one, or one with earlier results.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Continue the recovery that was interrupted in this folder; the results are, to the bit, those
    /// of a recovery without interruption.
    #[arg(long)]
    pub resume: bool,
    /// The ladder of hypotheses to climb.
    #[arg(long, value_enum, default_value_t = Ladder::Default)]
    pub ladder: Ladder,
    /// How the paper's ladder finds the anisotropy direction.
    #[arg(long, value_enum, default_value_t = PaperDirection::Rerender)]
    pub paper_direction: PaperDirection,
    /// How much work to spend.
    #[arg(long, value_enum, default_value_t = Effort::Normal)]
    pub effort: Effort,
    /// Chooses the noise of the renderings; the same seed gives the same bits.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Paths per pixel of the final re-rendering; where nearby pixels share paths, fewer are traced
    /// for the same noise [default: 64; 16 for a draft; fewer above 512 x 512 pixels].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// The size of the last picture, if a photograph of more than a megapixel is reduced to means of squares
    /// of pixels.
    #[arg(long, value_enum, default_value_t = PictureSize::Worked)]
    pub picture: PictureSize,
    /// The most reflections of a path; 1 is direct light only [default: until it carries nothing].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub bounces: Option<u32>,
    /// Leave out the joint refinement after the ladder, and with it the standard deviations.
    #[arg(long)]
    pub no_refine: bool,
    /// The most complex hypothesis that a group may have: diffuse, mirror, partial-mirror,
    /// diffuse-specular, isotropic, anisotropic or textured; "diffuse" is the diffuse-only baseline
    /// [default: as the project says, else textured].
    #[arg(long, value_name = "RUNG")]
    pub max_rung: Option<Hypothesis>,
    /// Move the camera to where the model's edges lie on the photograph's [default: if a quick
    /// rendering is nearer to the photograph there].
    #[arg(long, conflicts_with_all = ["keep_camera", "no_filter"])]
    pub refine_camera: bool,
    /// Keep the camera as it is given; pixels that may show something else are left out.
    #[arg(long)]
    pub keep_camera: bool,
    /// Assume that the model fits to the pixel, and that it contains all that the photograph shows.
    #[arg(long)]
    pub no_filter: bool,
    /// Continue if no reflectances explain the photograph, but a factor on all light would.
    #[arg(long)]
    pub force: bool,
    /// Print the run as JSON (as in run.json) instead of the table.
    #[arg(long)]
    pub json: bool,
}

/// The ladders of hypotheses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Ladder {
    /// All rungs on the same samples of light; selects the simplest that the noise allows.
    Default,
    /// The method of Boivin and Gagalowicz (2002).
    Paper,
}

/// How the paper's ladder finds the anisotropy direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PaperDirection {
    /// By re-rendering: of 64 directions, the one that differs least from the photograph.
    Rerender,
    /// As in the paper's text, from the difference of the photograph and a mirror.
    Text,
}

/// How much work to spend on a recovery.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Effort {
    /// A first answer, with an eighth of the samples and without checks: faint and small lobes may
    /// be missed, and surfaces that light each other may keep each other wrong.
    Draft,
    /// The usual one.
    Normal,
    /// Four times as many samples.
    High,
}

impl Effort {
    /// The same for the library.
    pub(crate) fn of_recovery(self) -> effort::Effort {
        match self {
            Self::Draft => effort::Effort::Draft,
            Self::Normal => effort::Effort::Normal,
            Self::High => effort::Effort::High,
        }
    }
}

/// The size of the last picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PictureSize {
    /// The size to which the photograph was reduced.
    Worked,
    /// The size of the photograph.
    Full,
}

/// Runs the command.
///
/// # Errors
/// If the input cannot be used or the results cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    let proposed = args.proposed(global)?;
    let (mut project, warnings) = match &proposed {
        Some(proposed) => proposed.parsed()?,
        None => Project::read(args.project()?)?,
    };
    settle(args, &mut project, global);
    let folder = ResultFolder::open(&args.out, "recover", &results::writes, &project.inputs())?;
    let mut job = Job::load(project, warnings)?;
    // Written last, so that no input that is refused leaves a project behind.
    let written = proposed.map(OwnProject::write).transpose()?.flatten();
    if !global.quiet && job.project.brdf.is_none() {
        global.console.tell(&format!(
            "brdf \"{}\", as in the scene; [recover] brdf in the project chooses another",
            job.scene.brdf
        ));
    }
    if args.resume && recovery_journal::has_ended(&args.out) {
        let out = args.out.display();
        global.console.tell(&format!(
            "the recovery in {out} has ended: there is nothing to resume, and nothing was done; without --resume it starts \
             again"
        ));
        return Ok(ExitCode::SUCCESS);
    }
    let head = Head::of(&job, args.choices(global.limits()));
    let journal = RecoveryJournal::open(&args.out, head, args.resume)?;
    let progress = Progress::new("recover", global);
    let growing = (job.photographs() == 1).then_some(&folder);
    let share = 1.0 - WRITING_SHARE;
    let follow = Follow { progress: &progress, share, journal: Some(&journal), growing };
    let recovered = match recovered_with(args, &mut job, global, &follow, None) {
        Ok(recovered) => recovered,
        Err(error) => {
            // There is nothing to resume.
            journal.remove();
            GrowingPicture::remove(&folder);
            written.into_iter().for_each(Written::remove);
            return Err(error);
        }
    };
    progress.work_on("writing the results", follow.share);
    let warn = |warnings: &Warnings| progress.warn(warnings);
    let run = folder.write(false, |place| results::write(&job, &recovered, place, &warn))?;
    drop(progress);
    if args.json {
        global.console.print(&run.to_text()?);
    } else {
        global.console.print(&results::summary(&job, &recovered));
    }
    if recovered.recovery.termination == Termination::Interrupted {
        output::tell("the same command with --resume continues from here");
        return Ok(interrupt::code());
    }
    journal.remove();
    if !global.quiet {
        global.console.tell(&format!(
            "open {} to see how the result came about",
            args.out.join("report.html").display()
        ));
    }
    Ok(ExitCode::SUCCESS)
}

impl Args {
    /// The project file.
    ///
    /// # Errors
    /// If the arguments name none.
    pub fn project(&self) -> Result<&Path, Error> {
        let named = self.project.as_deref();
        named.ok_or_else(|| Error::Request("name a project file: `unrender init` makes one".into()))
    }

    /// The project of a scene and a photograph that are named without one.
    fn proposed(&self, global: &Global) -> Result<Option<OwnProject>, Error> {
        let (Some(scene), Some(photo)) = (&self.scene, &self.photo) else { return Ok(None) };
        OwnProject::of(scene, photo, &self.out, global).map(Some)
    }

    /// The choices that the results depend on, by name: if one differs, the results may differ.
    fn choices(&self, limits: Limits) -> BTreeMap<String, String> {
        let Self { ladder, effort, seed, spp, bounces, no_refine, max_rung, .. } = self;
        let Self { refine_camera, keep_camera, no_filter, force, paper_direction, .. } = self;
        let word = |value: &dyn std::fmt::Debug| format!("{value:?}").to_lowercase();
        let number = |value: Option<u32>| value.map_or_else(|| "default".into(), |n| n.to_string());
        let stated = [
            ("ladder", word(ladder)),
            ("paper-direction", word(paper_direction)),
            ("effort", word(effort)),
            ("seed", seed.to_string()),
            ("spp", number(*spp)),
            ("bounces", number(*bounces)),
            ("max-rung", max_rung.map_or("default", Hypothesis::name).to_owned()),
        ];
        let flags = [
            ("no-refine", *no_refine),
            ("refine-camera", *refine_camera),
            ("keep-camera", *keep_camera),
            ("no-filter", *no_filter),
            ("force", *force),
            ("allow-outside", limits.outside),
            ("allow-missing", limits.missing),
        ];
        let flags =
            flags.map(|(name, is_given)| (name, if is_given { "yes" } else { "no" }.to_owned()));
        let all = stated.into_iter().chain(flags);
        all.map(|(name, value)| (name.to_owned(), value)).collect()
    }
}

/// The recovery of [`run`] from `job`, without files. Warnings and progress go to the console.
///
/// # Errors
/// If the camera sees nothing, or the anchor cannot fix the exposure.
pub fn recovered(args: &Args, job: &mut Job, global: &Global) -> Result<Recovered, Error> {
    recovered_by_any(args, job, global, None)
}

/// As [`recovered`], but `workers` do the renderer's work, with the same bits.
///
/// # Errors
/// As those of [`recovered`].
pub fn recovered_by(
    args: &Args,
    job: &mut Job,
    global: &Global,
    workers: &dyn Workers,
) -> Result<Recovered, Error> {
    recovered_by_any(args, job, global, Some(workers))
}

fn recovered_by_any(
    args: &Args,
    job: &mut Job,
    global: &Global,
    workers: Option<&dyn Workers>,
) -> Result<Recovered, Error> {
    let progress = Progress::new("recover", global);
    let follow = Follow { progress: &progress, share: 1.0, journal: None, growing: None };
    recovered_with(args, job, global, &follow, workers)
}

/// What follows a recovery.
struct Follow<'a> {
    progress: &'a Progress,
    /// The share of the recovery in the whole work.
    share: f64,
    journal: Option<&'a RecoveryJournal>,
    /// The folder in which a picture grows.
    growing: Option<&'a ResultFolder>,
}

fn recovered_with(
    args: &Args,
    job: &mut Job,
    global: &Global,
    follow: &Follow<'_>,
    workers: Option<&dyn Workers>,
) -> Result<Recovered, Error> {
    let Follow { progress, share: all, journal, growing } = *follow;
    // The number of its pixels then decides the samples of the last picture.
    job.reduce();
    global.console.warn(&job.warnings);
    let pixels = (0..job.photographs()).map(|k| job.photo_of(k).radiance.pixels().len()).sum();
    let asked = Asked {
        options: options(args, &job.project, pixels),
        paper: paper(args, &job.project),
        alignment: alignment(args),
        workers,
        journal: journal.map(|journal| journal as &dyn Journal),
    };
    let is_full = args.picture == PictureSize::Full && job.side > 1;
    let share = if is_full { all * (1.0 - FULL_SHARE) } else { all };
    let (is_papers, pausable) = (asked.paper.is_some(), Pausable::new());
    let growing = growing.and_then(|folder| GrowingPicture::new(folder, job.project.exposure));
    let mut follower = RecoveryProgress { progress, is_papers, share, pausable, journal, growing };
    let mut recovered = engine::recover(job, &asked, &mut follower)?;
    drop(follower);
    if is_full && recovered.recovery.termination != Termination::Interrupted {
        recovered.render_full(job, &|done: f64| {
            progress.work_on("rendering all pixels of the photo", share + done * (all - share));
        });
    }
    Ok(recovered)
}

/// The approximate share of the time in which results are written: 2 to 8 % in the rooms of the corpus.
const WRITING_SHARE: f64 = 0.05;
/// The approximate share of the time for a last picture of all pixels of a photograph.
const FULL_SHARE: f64 = 0.5;

/// Gives `project` the rung of the arguments and the limits of `global`.
pub fn settle(args: &Args, project: &mut Project, global: &Global) {
    if let Some(rung) = args.max_rung {
        project.rungs = Some(crate::project::up_to(rung));
        project.group_rungs = BTreeMap::new();
    }
    project.limits = global.limits();
}

/// Checks before the work whether results can be written into the folder at `out`.
///
/// # Errors
/// Those of [`write()`].
pub fn check(project: &Project, out: &Path) -> Result<(), Error> {
    ResultFolder::open(out, "recover", &results::writes, &project.inputs()).map(drop)
}

/// Writes the results of a recovery, as [`run`] does, into the folder `out`, which is created if it is
/// missing.
///
/// # Errors
/// If they cannot be written, or would replace an input of the recovery or a foreign file.
pub fn write(job: &Job, recovered: &Recovered, out: &Path, global: &Global) -> Result<(), Error> {
    let inputs = job.project.inputs();
    let folder = ResultFolder::open(out, "recover", &results::writes, &inputs)?;
    let warn = |warnings: &Warnings| global.console.warn(warnings);
    folder.write(false, |place| results::write(job, recovered, place, &warn))?;
    Ok(())
}

fn alignment(args: &Args) -> Alignment {
    match args {
        Args { no_filter: true, .. } => Alignment::Ignore,
        Args { refine_camera: true, .. } => Alignment::RefineCamera,
        Args { keep_camera: true, .. } => Alignment::KeepCamera,
        _ => Alignment::Auto,
    }
}

/// The settings of the paper's method, if that is asked for.
fn paper(args: &Args, project: &Project) -> Option<Paper> {
    let direction = match args.paper_direction {
        PaperDirection::Rerender => Direction::Rerender,
        PaperDirection::Text => Direction::Text,
    };
    let thresholds = project.paper_thresholds;
    let paper = Paper { direction, thresholds, ..Paper::default() };
    (args.ladder == Ladder::Paper).then_some(paper)
}

/// The options of a recovery from this many `pixels`.
fn options(args: &Args, project: &Project, pixels: usize) -> Options {
    let effort = args.effort.of_recovery();
    Options {
        effort,
        seed: args.seed,
        spp: args.spp.unwrap_or(effort.last_spp(pixels)),
        max_bounces: args.bounces.unwrap_or(Options::default().max_bounces),
        thresholds: project.thresholds,
        refine: !args.no_refine,
        outliers: !args.no_filter,
        force: args.force,
    }
}
