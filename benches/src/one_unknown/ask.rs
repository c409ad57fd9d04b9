//! Recovers one group while all others are held at the truth.

use super::choice::{self, Candidate};
use super::request::OneUnknownRequest;
use super::row::{Numbers, Row, runner_up};
use crate::corpus::score::{Verdict, simpler};
use crate::{Failure, peers};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use unrender::cli::{self, Global};
use unrender::commands::recover;
use unrender::engine::Recovered;
use unrender::formats::materials::{self, MaterialsFile, ReflectanceEntry};
use unrender::formats::picture;
use unrender::listener::{Console, Listener};
use unrender::photo::Exposure;
use unrender::project::Known;
use unrender::recover::{
    GroupResult, Hypothesis, IterationRecord, Observation, Picture, Status, hypothesis,
};
use unrender::render::Tracer;
use unrender::scene::{Group, Material, Rgb};
use unrender::score::{GroupScore, score};
use unrender::{Job, Project};

/// The data that are read once.
pub(super) struct Experiment {
    /// The arguments of `recover`.
    args: recover::Args,
    global: Global,
    /// The job of the project.
    given: Job,
    /// The same with every group known at the truth.
    at_truth: Job,
    truth: MaterialsFile,
    /// The folder of the truth's textures.
    truth_folder: PathBuf,
    /// The scene's groups, in its order.
    pub(super) candidates: Vec<Candidate>,
}

impl Experiment {
    /// Reads project, scene, photograph and truth.
    ///
    /// # Errors
    /// If one of them cannot be read, or the truth lacks a group.
    pub(super) fn load(request: &OneUnknownRequest) -> Result<Self, Failure> {
        // Nothing is written there, but the command needs the name of a folder.
        let words = ["recover".into(), request.project.clone(), "--out".into(), "unused".into()];
        let (mut global, mut args) = cli::recover_args(words.map(PathBuf::into_os_string))?;
        args.effort = request.effort;
        global.console = Console::new(Arc::new(Warner::default()));
        let (mut project, warnings) = Project::read(args.project()?)?;
        recover::settle(&args, &mut project, &global);
        let given = Job::load(project, warnings)?;
        let truth = materials::read(&request.truth)?;
        let candidates = choice::candidates(&given.project, &given.scene.groups);
        choice::check_truth(&candidates, (&truth, &request.truth), &request.project)?;
        Ok(Self {
            args,
            global,
            at_truth: at_truth(&given, &request.truth)?,
            given,
            truth,
            truth_folder: request.truth.parent().unwrap_or(Path::new("")).to_owned(),
            candidates,
        })
    }

    /// For each group, the relative error of its re-rendering with the true materials of all groups.
    ///
    /// # Errors
    /// If the camera sees nothing.
    pub(super) fn errors_at_truth(&self) -> Result<Vec<Option<f64>>, Failure> {
        let recovered = recover::recovered(&self.args, &mut self.at_truth.clone(), &self.global)?;
        Ok(recovered.recovery.groups.iter().map(|group| group.error).collect())
    }

    /// Recovers only `group`, whose error with its true material is `error_at_truth`.
    ///
    /// # Errors
    /// If the camera sees nothing, or a texture cannot be compared.
    pub(super) fn ask(
        &mut self,
        group: usize,
        seed: u64,
        error_at_truth: Option<f64>,
    ) -> Result<Row, Failure> {
        let mut job = self.alone(group);
        self.args.seed = seed;
        let recovered = recover::recovered(&self.args, &mut job, &self.global)?;
        let score = self.score(&job, &recovered, group)?;
        let found: &GroupResult = &recovered.recovery.groups[group];
        let truth = score.true_hypothesis.unwrap_or(found.hypothesis);
        let is_seen = found.status != Status::Assumed;
        let verdict = || self.verdict(&recovered, group, truth);
        Ok(Row {
            group: found.name.clone(),
            seed,
            found: found.hypothesis,
            truth,
            verdict: is_seen.then(verdict),
            error: found.error,
            error_at_truth,
            runner_up: runner_up(&found.selection_log, found.hypothesis),
            numbers: Numbers::of(&score),
            seconds: recovered.times.all,
        })
    }

    /// The job in which only `group` is unknown. It does not contain its true material.
    fn alone(&self, group: usize) -> Job {
        let mut job = self.at_truth.clone();
        let asked = &self.given.scene.groups[group];
        job.project.known.remove(&asked.name);
        job.scene.groups[group].material = asked.material.clone();
        job
    }

    /// Compares the result for `group` with the truth.
    fn score(&self, job: &Job, recovered: &Recovered, group: usize) -> Result<GroupScore, Failure> {
        let name = &job.scene.groups[group].name;
        let mut found = recovered.materials(job);
        found.groups.retain(|other, _| other == name);
        let mut truth = self.truth.clone();
        truth.groups.retain(|other, _| other == name);
        for entry in truth.groups.values_mut() {
            // Known groups do not count, but this one was recovered here.
            entry.status = None;
            let material = &self.at_truth.scene.groups[group].material;
            entry.hypothesis.get_or_insert(hypothesis::of(material));
        }
        let folder = peers::work_folder("one-unknown");
        let file = format!("texture_{}.exr", std::process::id());
        let texture = recovered.recovery.groups[group].material.texture.as_ref();
        if let Some(texture) = texture {
            std::fs::create_dir_all(&folder)?;
            picture::write_exr(&folder.join(&file), &texture.image)?;
            found.groups.values_mut().for_each(|entry| entry.texture = Some(file.clone()));
        }
        let scores = score(&found, &folder, &truth, &self.truth_folder)?;
        if texture.is_some() {
            std::fs::remove_file(folder.join(&file))?;
        }
        Ok(scores.into_iter().next().unwrap_or_default())
    }

    /// Whether the hypothesis found for `group` is right. A simpler one counts too, if the photograph cannot
    /// distinguish it from the truth.
    fn verdict(&self, recovered: &Recovered, group: usize, truth: Hypothesis) -> Verdict {
        let found = recovered.recovery.groups[group].hypothesis;
        if found == truth {
            return Verdict::Right;
        }
        let Job { scene, photo, project, .. } = &self.at_truth;
        let tracer = Tracer::new(scene);
        let size = (photo.radiance.width(), photo.radiance.height());
        let camera = recovered.camera(&self.at_truth);
        let geometry = tracer.geometry(&camera, size.0, size.1);
        let picture = Picture {
            values: photo.radiance.clone(),
            valid: photo.valid.clone(),
            saturated: photo.saturated.clone(),
            quantisation_step: photo.quantisation_step.clone(),
        };
        let observation = Observation::new(picture, &geometry, scene.groups.len());
        let pixels = &observation.pixels_of_group[group];
        let Some(middle) = pixels.get(pixels.len() / 2) else { return Verdict::Wrong };
        let exposure = match project.exposure {
            // The photograph was developed with the exposure.
            Exposure::Fixed(_) => Rgb::ONE,
            Exposure::Auto => recovered.recovery.exposure,
        };
        let noise = observation.noise(group, *middle, exposure);
        let deviation = |level: f64| {
            f64::from(noise.variance(Rgb::splat(level as f32)).element_sum() / 3.0).sqrt()
        };
        let observed = simpler::Observed {
            scene,
            tracer: &tracer,
            camera: &camera,
            size,
            group,
            pixels,
            noise: &deviation,
        };
        if simpler::explains(&observed, found.name()) { Verdict::Simpler } else { Verdict::Wrong }
    }
}

/// The job of `given` with all groups known by the file `truth`. Its light is that of the project.
///
/// # Errors
/// If a value or a texture of the truth cannot be used, or its lobes are not those of the project.
fn at_truth(given: &Job, truth: &Path) -> Result<Job, Failure> {
    let mut scene = given.scene.clone();
    let mut job = given.clone();
    job.warnings.extend(materials::apply_from(truth, &mut scene)?);
    let shines = |group: &&Group| !group.is_emitter() && group.material.is_glossy();
    let (theirs, ours) = (scene.brdf, given.scene.brdf);
    if theirs != ours
        && let Some(group) = scene.groups.iter().find(shines)
    {
        return Err(format!(
            "{}: its lobes, such as that of \"{}\", are {theirs}, but {} recovers {ours}; set brdf \
             = \"{theirs}\" under [recover] there",
            truth.display(),
            group.name,
            given.project.path.display()
        )
        .into());
    }
    for (group, of_truth) in job.scene.groups.iter_mut().zip(scene.groups) {
        group.material = of_truth.material;
        if !group.is_emitter() {
            job.project.known.insert(group.name.clone(), known(&group.material));
        }
    }
    Ok(job)
}

/// `material` in the form of a project; its texture stays with the scene.
fn known(material: &Material) -> Known {
    let Material { rho_d, rho_s, alpha_x, alpha_y, theta_rad, .. } = *material;
    let reflectance = ReflectanceEntry::of(material);
    Known { file: None, rho_d, rho_s: Some(rho_s), reflectance, alpha_x, alpha_y, theta_rad }
}

/// Prints each warning once: every group is recovered from the same photograph.
#[derive(Default)]
struct Warner(Mutex<BTreeSet<String>>);

impl Listener for Warner {
    fn warning(&self, sentence: &str) {
        let mut told = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if told.insert(sentence.to_owned()) {
            eprintln!("warning: {sentence}");
        }
    }

    fn progress(&self, _: Option<&str>, _: f64) {}

    fn result(&self, _: &str) {}

    fn iteration(&self, _: &IterationRecord) {}

    fn is_cancelled(&self) -> bool {
        false
    }
}
