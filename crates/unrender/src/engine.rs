//! The seam to the recovery.

use crate::interrupt::Pausable;
use crate::photometric::{self, Number};
use crate::problem::with_problem;
use crate::progress::Progress;
use crate::recovery_journal::RecoveryJournal;
use crate::registered::RegisteredModel;
use crate::registration::{self, Alignment};
use crate::{Error, Job, readings, same_as};
use std::ops::Range;
use std::time::Instant;
use unrender_formats::materials::PhotographEntry;
use unrender_photo::Exposure;
use unrender_recover::{
    IterationRecord, LadderKind, Observer, Options, Problem, RecoverError, Recovery, Thresholds,
};
use unrender_remote::Workers;
use unrender_render::Tracer;
use unrender_scene::{Camera, Image, RgbImage};

/// A recovery, how it was asked for and how long it took.
pub struct Recovered {
    /// What came out.
    pub recovery: Recovery,
    /// How it was asked for.
    pub options: Options,
    /// The numbers of the camera, where they were asked for.
    pub photograph: Option<PhotographEntry>,
    /// How the model was found to lie on the photograph.
    pub(crate) registered: RegisteredModel,
    /// The group of every pixel, or [`unrender_render::NOTHING`].
    pub group_map: Image<u32>,
    /// The object of every pixel, likewise.
    pub object_map: Image<u32>,
    /// The re-rendering in all pixels of the photograph, radiance, where it was asked for and `recovery` has fewer.
    pub full: Option<RgbImage>,
    /// When each part of the work was done.
    pub times: Times,
}

impl Recovered {
    /// The camera of the photograph of `job` that the recovery went on with.
    pub fn camera(&self, job: &Job) -> Camera {
        job.camera_of_photograph(&self.registered.camera)
    }
}

/// Seconds since the beginning.
pub struct Times {
    /// Until the model lay on the photograph.
    pub registered: f64,
    /// Until the camera's numbers were near enough.
    pub developed: f64,
    /// Until the end of each iteration.
    pub iterations: Vec<f64>,
    /// Until all was done.
    pub all: f64,
}

/// The camera's numbers are near enough if the photograph would change by less than this share.
const NEAR: f64 = 0.005;
/// How often the photograph is developed anew at most.
const ROUNDS_MAX: usize = 6;
/// The share of the time that all this takes at most, roughly.
const ROUNDS_SHARE: f64 = 0.7;

/// What is asked of a recovery.
pub(crate) struct Asked<'a> {
    pub(crate) options: &'a Options,
    pub(crate) alignment: Alignment,
    /// The share of the whole work that it is, for the progress.
    pub(crate) share: f64,
}

/// As [`recover_as_read`]; an error of brightness names the reading of the lights' units that would explain it.
pub(crate) fn recover(
    job: &mut Job,
    asked: &Asked<'_>,
    progress: &Progress,
    journal: &RecoveryJournal,
    workers: Option<&dyn Workers>,
) -> Result<Recovered, Error> {
    recover_as_read(job, asked, progress, journal, workers).map_err(|error| match error {
        Error::Recover(RecoverError::Unexplained { factor, unexplained, .. }) => {
            let all = readings::others(job);
            let behind = all.iter().find(|reading| reading.explains(job, factor));
            let remedy = behind.map_or(String::new(), |reading| {
                let (units, remedy) = (reading.units, readings::remedy(reading.units));
                format!(
                    " (light read as \"{units}\" would explain it: {}; {remedy})",
                    reading.lamp(job)
                )
            });
            RecoverError::Unexplained { factor, unexplained, remedy }.into()
        }
        error => error,
    })
}

/// Recovers the materials of `job`'s groups. Where the project asks for numbers of the camera, they
/// are found too, and the photograph of `job` ends as developed with them. The renderer's work is done
/// by `workers`, where they are given.
fn recover_as_read(
    job: &mut Job,
    &Asked { options, alignment, share: end }: &Asked<'_>,
    progress: &Progress,
    journal: &RecoveryJournal,
    workers: Option<&dyn Workers>,
) -> Result<Recovered, Error> {
    let started = Instant::now();
    let pausable = Pausable::new();
    let registered = registration::register(job, &Tracer::new(&job.scene), alignment);
    progress.warn(&registered.warnings);
    let until_registered = started.elapsed().as_secs_f64();
    let numbers = photometric::asked(&job.project);
    let mut begun = 0.0;
    if !numbers.is_empty() && options.refine && options.ladder == LadderKind::Default {
        // A texture explains whatever a wrong gamma does to a group.
        let thresholds = Thresholds { textured: Some(f64::INFINITY), ..options.thresholds };
        let rough = Options { thresholds, spp: 1, ..options.clone() };
        for _ in 0..ROUNDS_MAX {
            // How many rounds there will be is not known: each has half of what is left of their share.
            let share = begun..begun + 0.5 * (ROUNDS_SHARE * end - begun);
            begun = share.end;
            let mut teller = Teller::new(progress, options, started, (&pausable, journal), share);
            let asked = (&rough, workers);
            let change = recover_once(job, &registered, &numbers, asked, &mut teller)?.change;
            if change < NEAR || teller.is_cancelled() {
                break;
            }
        }
    }
    let developed = started.elapsed().as_secs_f64();
    let mut teller = Teller::new(progress, options, started, (&pausable, journal), begun..end);
    let Once { mut recovery, group_map, object_map, .. } =
        recover_once(job, &registered, &numbers, (options, workers), &mut teller)?;
    if let Exposure::Fixed(exposure) = job.project.exposure {
        // The photograph was developed with it.
        recovery.exposure = exposure;
    }
    same_as::share(&job.project, &mut recovery.groups);
    let photograph =
        (!numbers.is_empty()).then(|| photometric::found(job, &numbers, &recovery.photometric));
    let all = started.elapsed().as_secs_f64();
    let times =
        Times { registered: until_registered, developed, iterations: teller.iterations, all };
    Ok(Recovered {
        recovery,
        options: options.clone(),
        photograph,
        registered,
        group_map,
        object_map,
        full: None,
        times,
    })
}

/// What came out once.
struct Once {
    recovery: Recovery,
    group_map: Image<u32>,
    object_map: Image<u32>,
    /// The share by which developing the photograph anew changed it.
    change: f64,
}

/// A recovery, after which the photograph is developed anew with `numbers` as they came out.
fn recover_once(
    job: &mut Job,
    registered: &RegisteredModel,
    numbers: &[Number],
    (options, workers): (&Options, Option<&dyn Workers>),
    teller: &mut Teller<'_>,
) -> Result<Once, Error> {
    let photometric_parameters = photometric::photometric_parameters(job, numbers);
    let recover = |problem: &Problem<'_>| {
        let geometry = problem.renderer.geometry();
        let maps = (geometry.map(|pixel| pixel.group), geometry.map(|pixel| pixel.object));
        let journal = teller.journal;
        Ok((unrender_recover::recover_with(problem, options, teller, journal)?, maps))
    };
    let tracer = Tracer::new(&job.scene);
    let asked = (photometric_parameters.as_slice(), workers);
    let (recovery, (group_map, object_map)) =
        with_problem(job, &tracer, registered, asked, recover)?;
    let change = if numbers.is_empty() {
        0.0
    } else {
        photometric::apply(job, numbers, &recovery.photometric.steps)
    };
    Ok(Once { recovery, group_map, object_map, change })
}

/// Passes a recovery's progress on to the terminal, and keeps the time of its iterations.
struct Teller<'a> {
    progress: &'a Progress,
    paper: bool,
    started: Instant,
    /// From which to which share of the whole work this recovery is.
    share: Range<f64>,
    /// Seconds since the start at the end of each iteration.
    iterations: Vec<f64>,
    pausable: &'a Pausable,
    journal: &'a RecoveryJournal,
}

impl<'a> Teller<'a> {
    fn new(
        progress: &'a Progress,
        options: &Options,
        started: Instant,
        (pausable, journal): (&'a Pausable, &'a RecoveryJournal),
        share: Range<f64>,
    ) -> Self {
        let paper = options.ladder == LadderKind::Paper;
        Self { progress, paper, started, share, iterations: Vec::new(), pausable, journal }
    }

    /// The share of the whole work, where `done` of this recovery is done.
    fn of_all(&self, done: f64) -> f64 {
        let Range { start, end } = self.share;
        start + done * (end - start)
    }
}

impl Observer for Teller<'_> {
    fn iteration(&mut self, record: &IterationRecord) {
        self.iterations.push(self.started.elapsed().as_secs_f64());
        self.progress.iteration(record);
        let (error, change) = (100.0 * record.worst_error, record.change);
        let said = if self.paper {
            let open = match record.open_groups.len() {
                0 => "none".to_owned(),
                n if n <= 4 => record.open_groups.join(", "),
                n => format!("{n} groups"),
            };
            format!(
                "paper's ladder, iteration {}: error of the worst group {error:.2} %, change \
                 {change:.4}, still open: {open}",
                record.iteration
            )
        } else {
            let what = if record.refining { "refining" } else { "fitting" };
            format!(
                "{what} all, iteration {}: error of all groups {error:.2} %, change {change:.4}",
                record.iteration
            )
        };
        self.progress.say(said, self.of_all(record.done));
    }

    fn working(&self, what: &str, done: f64) {
        self.progress.work_on(what, self.of_all(done));
    }

    fn is_cancelled(&self) -> bool {
        let is_asked = self.pausable.is_asked() || self.progress.is_cancelled();
        if is_asked {
            // What follows is not what a recovery that goes on does.
            self.journal.close();
        }
        is_asked
    }
}
