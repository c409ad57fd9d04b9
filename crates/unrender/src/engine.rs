//! A complete recovery of a job: registers the model with the photograph, finds the photometric parameters that
//! the project leaves open, and then the materials.
//!
//! It touches no file, no terminal and no signal: a [`Follower`] receives its messages.

pub use crate::recovered::{Recovered, Times};
pub use crate::registration::Alignment;

use crate::check::coplanar;
use crate::photometric::{self, Number};
use crate::problem::{self, with_problem};
use crate::registered::RegisteredModel;
use crate::{Error, Job, clear_shapes, readings, registration, same_as};
use std::ops::Range;
use std::time::Instant;
use unrender_paper::Paper;
use unrender_photo::Exposure;
use unrender_recover::{
    IterationRecord, Journal, Observer, Options, Problem, RecoverError, Recovery, Role, Thresholds,
};
use unrender_remote::Workers;
use unrender_render::Tracer;
use unrender_scene::{Image, Rgb};

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
    warn_of_the_seen(job, &tracer, &registered, follower);
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

/// Warns of what the photographs of `job` show and a recovery cannot have: surfaces that let light through, and those
/// that overlap in one plane.
fn warn_of_the_seen(
    job: &mut Job,
    tracer: &Tracer,
    registered: &[RegisteredModel],
    follower: &dyn Follower,
) {
    for (k, registered) in registered.iter().enumerate() {
        let photo = &job.photo_of(k).radiance;
        let geometry = tracer.geometry(&registered.camera, photo.width(), photo.height());
        let clear = clear_shapes::told(job, &registered.camera, &geometry);
        let clear = clear.map(|told| format!("{}{told}", job.called(k)));
        let coplanar = coplanar::warnings(job, tracer, (&registered.camera, &geometry)).0;
        for warning in clear.into_iter().chain(coplanar) {
            if !job.warnings.0.contains(&warning) {
                follower.warning(&warning);
                job.warnings.push(warning);
            }
        }
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

    fn is_cancelled(&self) -> bool {
        self.follower.is_cancelled()
    }
}
