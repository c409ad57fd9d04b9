//! The state of a recovery: plain data, a material and a [`GroupState`] for every group, with what
//! belongs to the whole picture. The drivers change it; snapshots restore it.

mod step;

use crate::evidence::{Evidence, Stage};
use crate::hypothesis::{self, Fit, Hypothesis};
use crate::journal::Steps;
use crate::likelihood::Likelihood;
use crate::observation::{Observation, PixelStatus, ValidPixels};
use crate::photometric::{PhotometricEstimate, PhotometricParameter};
use crate::problem::{ExposureRule, Options, Problem, RecoverError, Role};
use crate::record::{
    CandidateRecord, Covariance, Deviations, GroupIteration, IterationRecord, LightResult, Status,
};
use crate::residual::ResidualStats;
use crate::sample_budget;
use crate::schedule::Schedule;
use serde::{Deserialize, Serialize};
use unrender_render::{Appearance, RadianceCache};
use unrender_scene::{Image, Material, Rgb, RgbImage};

/// Where a recovery stands.
pub(crate) struct State<'a> {
    pub(crate) problem: &'a Problem<'a>,
    /// The photograph, and what of it is still valid.
    pub(crate) observation: Observation,
    /// The current material of every group.
    pub(crate) materials: Vec<Material>,
    /// How many times as bright as in the scene each source of light shines (see [`Appearance`]).
    pub(crate) lights: Vec<Rgb>,
    /// The current state of every group.
    pub(crate) groups: Vec<GroupState>,
    pub(crate) exposure: Rgb,
    pub(crate) exposure_std: Option<Rgb>,
    /// The joint covariance of what was refined.
    pub(crate) covariance: Option<Covariance>,
    pub(crate) light_results: Vec<LightResult>,
    pub(crate) photometric: PhotometricEstimate,
    pub(crate) iterations: Vec<IterationRecord>,
    pub(crate) schedule: Schedule,
    /// The photograph's radiance where it shows diffuse surfaces.
    pub(crate) seen: Option<RadianceCache>,
    /// The steps that were made, and their journal.
    pub(crate) steps: Steps<'a>,
}

/// The state of one group.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct GroupState {
    pub(crate) hypothesis: Hypothesis,
    pub(crate) status: Status,
    pub(crate) residual: Option<ResidualStats>,
    /// How likely its residuals are, where it was measured on light samples.
    pub(crate) likelihood: Option<Likelihood>,
    pub(crate) selection_log: Vec<CandidateRecord>,
    pub(crate) seen_texels: Option<Image<bool>>,
    /// Whether no light reaches it where the photograph shows it.
    pub(crate) is_dark: bool,
    pub(crate) note: Option<String>,
    /// Why it has no texture, though nothing uniform explained it when it was asked last.
    pub(crate) untextured: Option<String>,
    /// The hypotheses that its last comparison left open.
    pub(crate) undecided: Vec<Hypothesis>,
    pub(crate) std: Option<Deviations>,
    /// Other fits that explain the photograph as well.
    pub(crate) alternatives: Vec<Fit>,
}

impl GroupState {
    /// Adds a sentence to what the user should know.
    pub(crate) fn add_note(&mut self, note: String) {
        self.note = match self.note.take() {
            Some(before) if before.contains(&note) => Some(before),
            Some(before) => Some(format!("{before}; {note}")),
            None => Some(note),
        };
    }

    /// Writes into the selection log, after the verification, whether the last compared candidate that was `tried` was
    /// accepted; the others were not.
    pub(crate) fn set_accepted(&mut self, tried: Hypothesis, accepted: bool) {
        let Some(last) = self.selection_log.last().map(|candidate| candidate.iteration) else {
            return;
        };
        let of_last = self.selection_log.iter_mut().rev().take(hypothesis::UNIFORM.len());
        for candidate in of_last.filter(|candidate| candidate.iteration == last) {
            candidate.accepted = accepted && candidate.hypothesis == tried;
        }
    }

    /// The last record of each hypothesis among the newest in the selection log.
    pub(crate) fn last_candidates(&self) -> impl Iterator<Item = &CandidateRecord> {
        let last = self.selection_log.iter().rev().take(hypothesis::UNIFORM.len());
        let newest = |candidate: &&CandidateRecord| {
            let newer = self.selection_log.iter().rev();
            newer
                .take_while(|other| !std::ptr::eq(*other, *candidate))
                .all(|other| other.hypothesis != candidate.hypothesis)
        };
        last.filter(newest)
    }

    /// Whether the last entry of the selection log is not of `hypothesis`.
    pub(crate) fn is_new_to(&self, hypothesis: Hypothesis) -> bool {
        self.selection_log.last().is_none_or(|candidate| candidate.hypothesis != hypothesis)
    }
}

/// Every unknown group of which nothing is expected starts as diffuse with this reflectance.
const START: f32 = 0.5;

impl<'a> State<'a> {
    pub(crate) fn new(problem: &'a Problem<'a>) -> Result<Self, RecoverError> {
        let seen = |group: usize| !problem.observation.pixels_of_group[group].is_empty();
        if (0..problem.groups.len()).all(|g| !seen(g)) {
            return Err(RecoverError::NothingSeen);
        }
        if problem.observation.mean().max_element() <= 0.0 {
            return Err(RecoverError::Black);
        }
        let material = |group: usize| match problem.groups[group].role {
            Role::Unknown if seen(group) => problem.groups[group].first(Rgb::splat(START)),
            Role::Unknown => problem.groups[group].unseen(),
            Role::Known | Role::Emitter => problem.groups[group].material.clone(),
        };
        let materials: Vec<Material> = (0..problem.groups.len()).map(material).collect();
        let groups = |group: usize| GroupState {
            hypothesis: hypothesis::of(&materials[group]),
            status: match problem.groups[group].role {
                Role::Unknown if seen(group) => Status::Recovered,
                Role::Unknown => Status::Assumed,
                Role::Known | Role::Emitter => Status::Known,
            },
            residual: None,
            likelihood: None,
            selection_log: Vec::new(),
            seen_texels: None,
            is_dark: false,
            note: None,
            untextured: None,
            undecided: Vec::new(),
            std: None,
            alternatives: Vec::new(),
        };
        let groups = (0..problem.groups.len()).map(groups).collect();
        let exposure = match problem.exposure {
            ExposureRule::Fixed(exposure) => exposure,
            ExposureRule::Anchor { .. } => Rgb::ONE,
        };
        let lights = Vec::new();
        let steps = vec![0.0; problem.photometric_parameters.len()];
        let photometric = PhotometricEstimate { steps, covariance: Vec::new() };
        Ok(Self {
            problem,
            observation: problem.observation.clone(),
            materials,
            lights,
            groups,
            exposure,
            exposure_std: None,
            covariance: None,
            light_results: Vec::new(),
            photometric,
            iterations: Vec::new(),
            schedule: Schedule::new(problem, &Options::default()),
            seen: None,
            steps: Steps::default(),
        })
    }

    /// The photograph's value at a pixel with the camera's numbers as they stand, before exposure.
    pub(crate) fn value(&self, pixel: usize) -> Rgb {
        self.observation.picture.values.pixels()[pixel] + self.photometric_change(pixel)
    }

    /// What the camera's numbers add to the value of a pixel.
    pub(crate) fn photometric_change(&self, pixel: usize) -> Rgb {
        let photometric_parameters =
            self.problem.photometric_parameters.iter().zip(&self.photometric.steps);
        let change = |c: &PhotometricParameter| c.change(&self.observation, pixel as u32);
        photometric_parameters.map(|(c, step)| change(c) * *step as f32).sum()
    }

    /// What the scene looks like under the present hypotheses.
    pub(crate) fn appearance(&self) -> Appearance<'_> {
        Appearance { materials: &self.materials, lights: &self.lights }
    }

    /// Gives the unknown groups their `materials`, one for each group.
    pub(crate) fn assign_materials(&mut self, materials: &[Material]) {
        for (group, material) in materials.iter().enumerate() {
            if self.problem.groups[group].role == Role::Unknown {
                let material = self.problem.groups[group].expected.bounds.nearest(material);
                self.groups[group].hypothesis = hypothesis::of(&material);
                self.materials[group] = material;
            }
        }
    }

    /// Makes one channel of a source `factor` times as bright as in the scene.
    pub(crate) fn set_light(&mut self, source: usize, channel: usize, factor: f32) {
        if self.lights.len() <= source {
            self.lights.resize(source + 1, Rgb::ONE);
        }
        self.lights[source][channel] = factor;
    }

    /// Where evidence comes from now.
    pub(crate) fn stage(&self) -> Stage<'_> {
        Stage {
            seen: self.seen.as_ref(),
            observation: &self.observation,
            exposure: self.exposure,
            renderer: self.problem.renderer,
        }
    }

    /// Updates the radiance cache from the photograph: all valid pixels of groups that are taken as
    /// diffuse or textured.
    pub(crate) fn look_at_photograph(&mut self) {
        let observation = &self.observation;
        let values = &observation.picture.values;
        let (width, height) = (values.width(), values.height());
        let mut known = Image::new(width, height, vec![false; width * height]);
        for (group, pixels) in observation.pixels_of_group.iter().enumerate() {
            let material = &self.materials[group];
            let emits = self.problem.groups[group].role == Role::Emitter;
            if !emits && material.rho_s == Rgb::ZERO {
                pixels.iter().for_each(|&p| known.pixels_mut()[p as usize] = true);
            }
        }
        let exposure = self.exposure;
        let radiance = (0..width * height).map(|pixel| exposure * self.value(pixel)).collect();
        let radiance = RgbImage::new(width, height, radiance);
        self.seen = Some(RadianceCache { radiance, valid: known });
    }

    /// Why the photograph says nothing of `group`, in words.
    pub(crate) fn why_unseen(&self, group: usize) -> &'static str {
        match self.observation.all_pixels_of_group[group].is_empty() {
            true => "no pixel shows this group",
            false if self.groups[group].is_dark => "no light of the scene reaches this group",
            false => "no pixel that shows this group is valid",
        }
    }

    /// The groups to be recovered that the photograph shows.
    pub(crate) fn visible_unknowns(&self) -> Vec<usize> {
        let asked = |g: &usize| self.problem.groups[*g].role == Role::Unknown;
        let seen = |g: &usize| !self.observation.pixels_of_group[*g].is_empty();
        (0..self.materials.len()).filter(asked).filter(seen).collect()
    }

    /// With an anchor: the exposure that makes the anchor group's photograph and `D` agree,
    /// channel by channel, `exposure = rho_d sum D / sum value`.
    pub(crate) fn update_exposure(&mut self, options: &Options) -> Result<(), RecoverError> {
        let ExposureRule::Anchor { group, rho_d } = self.problem.exposure else { return Ok(()) };
        let unseen = || RecoverError::AnchorUnseen(self.problem.groups[group].name.clone());
        let by_anchor = || self.exposure_by_anchor(group, rho_d, options);
        self.exposure = self.steps.value("anchor", by_anchor).ok_or_else(unseen)?;
        Ok(())
    }

    /// The exposure by the `group` of diffuse reflectance `rho_d`; none if it is not seen lit.
    fn exposure_by_anchor(&self, group: usize, rho_d: Rgb, options: &Options) -> Option<Rgb> {
        let stage = Stage { exposure: Rgb::ONE, ..self.stage() };
        let pixels = &self.observation.pixels_of_group[group];
        let mut budget = sample_budget::diffuse(options);
        budget.probe.max_bounces = options.max_bounces;
        let evidence = Evidence::gather(&stage, self.appearance(), group, pixels, &budget);
        let [a, b] = evidence.diffuse();
        let light: Rgb = 0.5 * (a.iter().sum::<Rgb>() + b.iter().sum::<Rgb>());
        let values: Rgb = evidence.pixels.iter().map(|p| p.radiance).sum();
        let is_seen = values.min_element() > 0.0 && light.min_element() > 0.0;
        is_seen.then(|| rho_d * light / values)
    }

    /// Notes the end of a pass over all groups, with the error that it started from: of all
    /// groups together, and of each, and the share of the present part that is `done`.
    pub(crate) fn end_pass(
        &mut self,
        change: f64,
        (error, errors): (f64, &[Option<f64>]),
        done: f64,
    ) -> &IterationRecord {
        let record = IterationRecord {
            refining: self.schedule.is_refining(),
            iteration: self.iterations.len() + 1,
            change,
            worst_error: error,
            open_groups: Vec::new(),
            groups: self.group_iterations(|group| errors[group]),
            done: self.schedule.share(done),
        };
        self.iterations.push(record);
        &self.iterations[self.iterations.len() - 1]
    }

    /// Where each group stands now, with its error.
    fn group_iterations(&self, error: impl Fn(usize) -> Option<f64>) -> Vec<GroupIteration> {
        let iteration = |(group, of_group): (usize, &GroupState)| GroupIteration {
            hypothesis: of_group.hypothesis,
            material: Material { texture: None, ..self.materials[group].clone() },
            error: error(group),
        };
        self.groups.iter().enumerate().map(iteration).collect()
    }

    /// Notes the end of an iteration in which the largest change was `change`; `open` groups are not
    /// explained yet, and `done` is the share of the present part that is done.
    pub(crate) fn end_iteration(
        &mut self,
        change: f64,
        open: &[usize],
        done: f64,
    ) -> &IterationRecord {
        let is_asked = |group: usize| self.problem.groups[group].role == Role::Unknown;
        let error = |group: usize| {
            self.groups[group].residual.filter(|_| is_asked(group)).map(|r| r.relative())
        };
        let record = IterationRecord {
            refining: false,
            iteration: self.iterations.len() + 1,
            change,
            worst_error: (0..self.groups.len()).filter_map(error).fold(0.0, f64::max),
            open_groups: self.names(open),
            groups: self.group_iterations(error),
            done: self.schedule.share(done),
        };
        self.iterations.push(record);
        &self.iterations[self.iterations.len() - 1]
    }

    /// Notes in the last iteration so far that the groups `open` are not explained.
    pub(crate) fn note_open(&mut self, open: &[usize]) {
        let names = self.names(open);
        if let Some(last) = self.iterations.last_mut() {
            last.open_groups = names;
        }
    }

    fn names(&self, groups: &[usize]) -> Vec<String> {
        groups.iter().map(|group| self.problem.groups[*group].name.clone()).collect()
    }

    /// All that a candidate may change, to be restored.
    pub(crate) fn snapshot(&self) -> Snapshot {
        Snapshot {
            materials: self.materials.clone(),
            groups: self.groups.clone(),
            lights: self.lights.clone(),
            exposure: self.exposure,
            photometric: self.photometric.clone(),
            exposure_std: self.exposure_std,
            light_results: self.light_results.clone(),
            covariance: self.covariance.clone(),
            valid: self.observation.valid_pixels(),
        }
    }

    /// Forgets the standard deviations of numbers, which are about to move.
    pub(crate) fn forget_deviations(&mut self) {
        self.groups.iter_mut().for_each(|of_group| of_group.std = None);
        self.exposure_std = None;
        self.light_results.clear();
        self.covariance = None;
        self.photometric.covariance.clear();
    }

    /// Goes back to `snapshot`. The selection log and the iterations stay: they happened.
    pub(crate) fn restore(&mut self, snapshot: &Snapshot) {
        self.materials.clone_from(&snapshot.materials);
        for (group, before) in self.groups.iter_mut().zip(&snapshot.groups) {
            let log = std::mem::take(&mut group.selection_log);
            *group = GroupState { selection_log: log, ..before.clone() };
        }
        self.lights.clone_from(&snapshot.lights);
        self.exposure = snapshot.exposure;
        self.photometric.clone_from(&snapshot.photometric);
        self.exposure_std = snapshot.exposure_std;
        self.light_results.clone_from(&snapshot.light_results);
        self.covariance.clone_from(&snapshot.covariance);
        self.observation.restore_valid_pixels(&snapshot.valid);
    }
}

/// A state to be restored.
#[derive(Clone)]
pub(crate) struct Snapshot {
    materials: Vec<Material>,
    groups: Vec<GroupState>,
    lights: Vec<Rgb>,
    exposure: Rgb,
    photometric: PhotometricEstimate,
    exposure_std: Option<Rgb>,
    light_results: Vec<LightResult>,
    covariance: Option<Covariance>,
    valid: ValidPixels,
}

impl Snapshot {
    /// The exposure in it.
    pub(crate) fn exposure(&self) -> Rgb {
        self.exposure
    }

    /// What `group` was made of.
    pub(crate) fn material(&self, group: usize) -> &Material {
        &self.materials[group]
    }

    /// For each pixel: whether it counted.
    pub(crate) fn status(&self) -> &Image<PixelStatus> {
        self.valid.status()
    }
}

/// How far two materials are apart: the largest difference of a reflectance, or of the logarithm
/// of a roughness.
pub(crate) fn distance(a: &Material, b: &Material) -> f64 {
    let rho = (a.rho_d - b.rho_d).abs().max((a.rho_s - b.rho_s).abs()).max_element();
    let log = |x: f32, y: f32| if x > 0.0 && y > 0.0 { (x / y).ln().abs() } else { 0.0 };
    let visible = a.rho_s.max(b.rho_s).max_element().min(1.0);
    let alpha = log(a.alpha_x, b.alpha_x).max(log(a.alpha_y, b.alpha_y)) * visible;
    f64::from(rho.max(0.1 * alpha))
}
