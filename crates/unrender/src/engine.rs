//! The seam to the recovery.

use crate::cli::warn;
use crate::progress::Progress;
use crate::registration::{self, Alignment, Laid};
use crate::{Error, Job};
use std::time::Instant;
use unrender_photo::Exposure;
use unrender_recover::{
    ExposureRule, GroupSpec, LadderKind, Observation, Observer, Options, Picture, Problem,
    Recovery, Role, TurnRecord, View,
};
use unrender_render::Tracer;
use unrender_scene::{Image, Rgb};

/// A recovery, how it was asked for and how long it took.
pub(crate) struct Recovered {
    pub(crate) recovery: Recovery,
    pub(crate) options: Options,
    /// How the model was found to lie on the photograph.
    pub(crate) laid: Laid,
    /// The group of every pixel, or [`unrender_render::NOTHING`].
    pub(crate) group_map: Image<u32>,
    /// Seconds until the ladder began, until the end of each turn, and until all was done.
    pub(crate) registered: f64,
    pub(crate) turns: Vec<f64>,
    pub(crate) seconds: f64,
}

/// Recovers the materials of `job`'s groups.
pub(crate) fn recover(
    job: &Job,
    options: &Options,
    alignment: Alignment,
    progress: &Progress,
) -> Result<Recovered, Error> {
    let started = Instant::now();
    let tracer = Tracer::new(&job.scene);
    let size = (job.photo.radiance.width(), job.photo.radiance.height());
    let laid = registration::lay(job, &tracer, alignment);
    warn(&laid.warnings);
    let view = View::new(&tracer, &laid.camera, size, job.scene.brdf);
    let picture = Picture {
        values: job.photo.radiance.clone(),
        trusted: job.photo.trusted.clone(),
        quantum: job.photo.quantum.clone(),
    };
    let groups = job.scene.groups.len();
    let geometry = unrender_recover::Renderer::geometry(&view);
    let group_map = geometry.map(|pixel| pixel.group);
    let observation = Observation::with_margins(picture, geometry, &laid.margins, groups);
    let problem = Problem {
        observation: &observation,
        renderer: &view,
        groups: (0..groups).map(|group| spec(job, group)).collect(),
        exposure: exposure_rule(job),
        unknown_lights: job.unknown_lights.clone(),
    };
    let registered = started.elapsed().as_secs_f64();
    let paper = options.ladder == LadderKind::Paper;
    let mut teller = Teller { progress, paper, started, turns: Vec::new() };
    let mut recovery = unrender_recover::recover(&problem, options, &mut teller)?;
    if let Exposure::Fixed(exposure) = job.project.exposure {
        // The photograph was developed with it.
        recovery.exposure = exposure;
    }
    let (options, turns) = (options.clone(), teller.turns);
    let seconds = started.elapsed().as_secs_f64();
    Ok(Recovered { recovery, options, laid, group_map, registered, turns, seconds })
}

fn spec(job: &Job, group: usize) -> GroupSpec {
    let of_scene = &job.scene.groups[group];
    let anchored = job.project.used_anchor().filter(|a| a.group == of_scene.name);
    let (role, material) = if of_scene.is_emitter() {
        (Role::Emitter, of_scene.material.clone())
    } else if let Some(anchor) = anchored {
        (Role::Known, unrender_scene::Material::diffuse(anchor.rho_d))
    } else if job.project.known.contains_key(&of_scene.name) {
        (Role::Known, of_scene.material.clone())
    } else {
        (Role::Unknown, of_scene.material.clone())
    };
    GroupSpec { name: of_scene.name.clone(), role, material }
}

fn exposure_rule(job: &Job) -> ExposureRule {
    let anchor = job.project.anchor.as_ref();
    let index = anchor.and_then(|a| job.scene.group_index(&a.group).map(|i| (i, a.rho_d)));
    match (job.project.exposure, index) {
        (Exposure::Auto, Some((group, rho_d))) => ExposureRule::Anchor { group, rho_d },
        _ => ExposureRule::Fixed(Rgb::ONE),
    }
}

/// Passes a recovery's progress on to the terminal, and keeps the time of its turns.
struct Teller<'a> {
    progress: &'a Progress,
    paper: bool,
    started: Instant,
    /// Seconds from the start to the end of each turn.
    turns: Vec<f64>,
}

/// The final picture's share of the time, roughly.
const PICTURE: f64 = 0.4;

impl Observer for Teller<'_> {
    fn turn(&mut self, record: &TurnRecord) {
        self.turns.push(self.started.elapsed().as_secs_f64());
        let open = match record.open_groups.len() {
            0 => "none".to_owned(),
            n if n <= 4 => record.open_groups.join(", "),
            n => format!("{n} groups"),
        };
        let ladder = match (self.paper, record.refining) {
            (true, _) => "paper's ladder, ",
            (_, true) => "refining all, ",
            _ => "",
        };
        self.progress.say(
            format!(
                "{ladder}turn {}: error {:.2} %, change {:.4}, still open: {open}",
                record.turn,
                100.0 * record.worst_error,
                record.change
            ),
            (1.0 - PICTURE) * record.done,
        );
    }

    fn picture(&self, share: f64) {
        self.progress.set(1.0 - PICTURE + PICTURE * share);
    }
}
