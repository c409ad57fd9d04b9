//! A complete recovery of a job: registers the model with the photograph, finds the photometric parameters that
//! the project leaves open, and then the materials.
//!
//! It touches no file, no terminal and no signal: a [`Follower`] receives its messages.

pub use crate::recovered::{Recovered, Times};
pub use crate::registration::Alignment;

use crate::check::{self, Finding, Gravity};
use crate::photometric::{self, Number};
use crate::problem::{self, with_problem};
use crate::registered::RegisteredModel;
use crate::{Error, Job, readings, registration, same_as, unusable};
use std::ops::Range;
use std::time::Instant;
use unrender_formats::FileError;
use unrender_paper::Paper;
use unrender_photo::Exposure;
use unrender_recover::{
    IterationRecord, Journal, Observer, Options, Problem, RecoverError, Recovery, Role, Thresholds,
};
use unrender_remote::Workers;
use unrender_render::Tracer;
use unrender_scene::{Image, Rgb, RgbImage};

/// The photometric parameters have converged if the photograph changes by less than this share.
const NEAR: f64 = 0.005;
/// The most times that the photograph is developed again.
const ROUNDS_MAX: usize = 6;
/// The approximate share of the time that this takes at most.
const ROUNDS_SHARE: f64 = 0.7;

/// The options of a recovery beside its project.
#[derive(Clone, Default)]
pub struct Asked<'a> {
    /// How the materials are estimated.
    pub options: Options,
    /// The paper's method in place of the default one, with its settings.
    pub paper: Option<Paper>,
    /// How to register a model that does not fit the photograph.
    pub alignment: Alignment,
    /// The workers that render; if none, this process does, with the same bits.
    pub workers: Option<&'a dyn Workers>,
    /// The results of an earlier run of the same recovery; new results are saved there.
    pub journal: Option<&'a dyn Journal>,
}

impl Asked<'_> {
    /// The usual recovery of `job`, with the thresholds of its project.
    pub fn of(job: &Job) -> Self {
        Self {
            options: Options { thresholds: job.project.thresholds, ..Options::default() },
            ..Self::default()
        }
    }
}

/// Follows a recovery: receives its iterations, and its warnings as soon as they are known.
pub trait Follower: Observer {
    /// Receives, before the work, the seconds that it takes on two cores, within a factor of two or three.
    fn expected(&self, _seconds: f64) {}
    /// Receives a warning: a sentence without a final full stop.
    fn warning(&self, sentence: &str);
}

/// A follower that ignores all messages.
impl Follower for () {
    fn warning(&self, _: &str) {}
}

/// Recovers the materials of `job`'s groups. Photometric parameters that the project leaves open are found too,
/// and the photograph of `job` is developed with them in the end. A photograph of more pixels than needed is
/// reduced to squares of them ([`Job::reduce`]).
///
/// # Errors
/// If the camera sees nothing, the anchor cannot fix the exposure, or no reflectances explain the photograph
/// although a factor on all light would: then the error names the reading of the lights' units that would explain
/// it.
pub fn recover(
    job: &mut Job,
    asked: &Asked<'_>,
    follower: &mut dyn Follower,
) -> Result<Recovered, Error> {
    job.reduce();
    recover_as_read(job, asked, follower).map_err(|error| match error {
        Error::Recover(RecoverError::Unexplained { factor, unexplained, .. }) => {
            let remedy = other_reading(job, factor);
            RecoverError::Unexplained { factor, unexplained, remedy }.into()
        }
        Error::Recover(RecoverError::NothingSeen) => match unusable::why(job) {
            Some(why) => FileError::new(&job.project.photo, why).into(),
            None => error,
        },
        error => error,
    })
}

/// The reading of the lights' units that explains why all light is off by `factor`, as the end of a message; empty
/// if there is none.
fn other_reading(job: &Job, factor: Rgb) -> String {
    let all = readings::others(job);
    let behind = all.iter().find(|reading| reading.explains(job, factor));
    behind.map_or(String::new(), |reading| {
        let (units, remedy) = (reading.units, readings::remedy(reading.units));
        format!(" (light read as \"{units}\" would explain it: {}; {remedy})", reading.lamp(job))
    })
}

fn recover_as_read(
    job: &mut Job,
    asked: &Asked<'_>,
    follower: &mut dyn Follower,
) -> Result<Recovered, Error> {
    let options = &asked.options;
    let started = Instant::now();
    if let Some(seconds) = expected_seconds(job, asked) {
        follower.expected(seconds);
    }
    follower.working("aligning the model with the photo", 0.0);
    let tracer = Tracer::new(&job.scene);
    let registered = register(job, &tracer, asked.alignment)?;
    let warnings = registered.iter().flat_map(|registered| &registered.warnings.0);
    warnings.for_each(|warning| follower.warning(warning));
    follower.working("checking the input", 0.0);
    warn_of_findings(job, &tracer, &registered, follower);
    let until_registered = started.elapsed().as_secs_f64();
    let numbers = photometric::asked(&job.project);
    let mut begun = 0.0;
    if !photometric::are_linear(&numbers) && options.refine && asked.paper.is_none() {
        // A texture would explain any error of a wrong gamma.
        let thresholds = Thresholds { textured: f64::INFINITY, ..options.thresholds };
        let rough = Options { thresholds, spp: 1, ..options.clone() };
        let rough = Asked { options: rough, ..asked.clone() };
        for _ in 0..ROUNDS_MAX {
            // The number of rounds is not known in advance: each gets half of the remaining share.
            let share = begun..begun + 0.5 * (ROUNDS_SHARE - begun);
            begun = share.end;
            let mut stage = Stage::new(follower, started, share);
            let change =
                recover_once(job, (&tracer, &registered), &numbers, &rough, &mut stage)?.change;
            if change < NEAR || follower.is_cancelled() {
                break;
            }
        }
    }
    let developed = started.elapsed().as_secs_f64();
    let mut stage = Stage::new(follower, started, begun..1.0);
    let Once { mut recovery, group_map, object_map, .. } =
        recover_once(job, (&tracer, &registered), &numbers, asked, &mut stage)?;
    let iterations = stage.iterations;
    if let Exposure::Fixed(exposure) = job.project.exposure {
        // The photograph was developed with this exposure.
        recovery.exposure = exposure;
    }
    same_as::share(&job.project, &mut recovery.groups);
    let photographs = photometric::found(job, &numbers, &recovery);
    let all = started.elapsed().as_secs_f64();
    let times = Times { registered: until_registered, developed, iterations, all };
    let mut recovered = Recovered {
        recovery,
        options: options.clone(),
        paper: asked.paper,
        photographs,
        registered,
        group_map,
        object_map,
        full: Vec::new(),
        times,
    };
    for (k, odd) in recovered.odd_photographs(job).into_iter().enumerate() {
        odd.0.iter().for_each(|warning| follower.warning(warning));
        recovered.registered[k].warnings.extend(odd);
    }
    Ok(recovered)
}

/// The seconds that the recovery of `job` takes on two cores; none if it is not known how often it repeats its work.
fn expected_seconds(job: &Job, asked: &Asked<'_>) -> Option<f64> {
    let is_once = photometric::are_linear(&photometric::asked(&job.project));
    let groups = (0..job.scene.groups.len()).map(|group| problem::spec(job, group));
    let unknown = groups.filter(|spec| spec.role == Role::Unknown).count();
    let pixels = (0..job.photographs()).map(|k| job.photo_of(k).radiance.pixels().len()).sum();
    (is_once && asked.paper.is_none())
        .then(|| unrender_recover::expected_seconds(unknown, pixels, &asked.options))
}

/// Warns of what `check` finds in `job`, the gravest first, before the work: no more than three of the grave findings
/// at length. All are among the warnings of the result.
fn warn_of_findings(
    job: &mut Job,
    tracer: &Tracer,
    registered: &[RegisteredModel],
    follower: &dyn Follower,
) {
    /// At double of it nobody reads the first one.
    const TOLD: usize = 3;
    let mut all: Vec<Finding> = Vec::new();
    for (k, registered) in registered.iter().enumerate() {
        let found = check::before_recovery(&job.alone(k), tracer, registered);
        for found in found {
            let sentence = format!("{}{}", job.called(k), found.sentence);
            if !job.warnings.0.contains(&sentence) {
                all.push(Finding { sentence, ..found });
            }
        }
    }
    all.sort_by_key(|finding| finding.gravity);
    let sentences = |is_note: bool| {
        let of = all.iter().filter(move |finding| (finding.gravity == Gravity::Note) == is_note);
        of.map(|finding| finding.sentence.clone())
    };
    job.warnings.0.splice(0..0, sentences(false));
    job.warnings.0.extend(sentences(true));
    let grave = all.iter().filter(|finding| finding.gravity < Gravity::Note);
    grave.clone().take(TOLD).for_each(|finding| follower.warning(&finding.sentence));
    let more = grave.count().saturating_sub(TOLD);
    if more > 0 {
        let [things, them] = if more == 1 { ["thing", "it"] } else { ["things", "them"] };
        let sentence = format!(
            "{more} more {things} to check: see {them} in the report, or by `unrender check`"
        );
        follower.warning(&sentence);
    }
}

/// Registers the model of `job` with each of its photographs. Exposures relative to the first photograph start
/// where both are about equally bright.
fn register(
    job: &mut Job,
    tracer: &Tracer,
    alignment: Alignment,
) -> Result<Vec<RegisteredModel>, Error> {
    let all = |job: &Job, alignment: Alignment| -> Vec<RegisteredModel> {
        let one = |k: usize| {
            registration::register(&job.alone(k), tracer, alignment).named(&job.called(k))
        };
        (0..job.photographs()).map(one).collect()
    };
    if job.photographs() > 1 {
        let as_given = all(job, Alignment::Ignore);
        let starts = with_problem(job, tracer, &as_given, (&[], None), |problem| {
            Ok(photometric::relative_exposures(job, problem))
        })?;
        for (photograph, start) in starts.into_iter().enumerate() {
            if let Some(start) = start {
                let mut transfer = job.transfer_of(photograph).clone();
                transfer.exposure *= start;
                job.develop_again(photograph, transfer);
            }
        }
    }
    Ok(all(job, alignment))
}

/// The result of one round.
struct Once {
    recovery: Recovery,
    group_map: Image<u32>,
    object_map: Image<u32>,
    /// The relative change of the photograph when it was developed again.
    change: f64,
}

/// One recovery, after which the photograph is developed again with the estimated `numbers`.
fn recover_once(
    job: &mut Job,
    (tracer, registered): (&Tracer, &[RegisteredModel]),
    numbers: &[Number],
    asked: &Asked<'_>,
    stage: &mut Stage<'_>,
) -> Result<Once, Error> {
    let photometric_parameters = photometric::photometric_parameters(job, numbers);
    let options = &asked.options;
    let recover = |problem: &Problem<'_>| {
        let geometry = problem.renderer.geometry();
        let maps = (geometry.map(|pixel| pixel.group), geometry.map(|pixel| pixel.object));
        let recovery = match (&asked.paper, asked.journal) {
            (Some(paper), journal) => {
                unrender_paper::recover(problem, options, paper, stage, journal)?
            }
            (None, Some(journal)) => {
                unrender_recover::recover_with(problem, options, stage, journal)?
            }
            (None, None) => unrender_recover::recover(problem, options, stage)?,
        };
        Ok((recovery, maps))
    };
    let beside = (photometric_parameters.as_slice(), asked.workers);
    let (recovery, (group_map, object_map)) =
        with_problem(job, tracer, registered, beside, recover)?;
    let change = if numbers.is_empty() {
        0.0
    } else {
        photometric::apply(job, numbers, &recovery.photometric.steps)
    };
    Ok(Once { recovery, group_map, object_map, change })
}

/// One recovery as a stage of the whole work: passes on its messages, and records the time of its iterations.
struct Stage<'a> {
    follower: &'a mut dyn Follower,
    started: Instant,
    /// Its range in the whole work, 0 to 1.
    share: Range<f64>,
    /// Seconds since the start at the end of each iteration.
    iterations: Vec<f64>,
}

impl<'a> Stage<'a> {
    fn new(follower: &'a mut dyn Follower, started: Instant, share: Range<f64>) -> Self {
        Self { follower, started, share, iterations: Vec::new() }
    }

    /// The share of the whole work when `done` of this stage is done.
    fn of_all(&self, done: f64) -> f64 {
        let Range { start, end } = self.share;
        start + done * (end - start)
    }
}

impl Observer for Stage<'_> {
    fn iteration(&mut self, record: &IterationRecord) {
        self.iterations.push(self.started.elapsed().as_secs_f64());
        let mut of_all = record.clone();
        of_all.done = self.of_all(record.done);
        self.follower.iteration(&of_all);
    }

    fn working(&self, what: &str, done: f64) {
        self.follower.working(what, self.of_all(done));
    }

    fn wants_picture(&self) -> bool {
        self.follower.wants_picture()
    }

    fn picture(&mut self, rough: RgbImage) {
        self.follower.picture(rough);
    }

    fn is_cancelled(&self) -> bool {
        self.follower.is_cancelled()
    }
}
