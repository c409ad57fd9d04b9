//! The guess: what a recovery takes the scene to be. A plain value: a material and a [`GroupGuess`] for every group, with
//! what belongs to the whole picture. To ask what another one would show, clone it, change the clone, and drop it.

use crate::compare::likelihood::Likelihood;
use crate::compare::residual::ResidualStats;
use crate::evidence::Evidence;
use crate::hypothesis::{self, Fit, Hypothesis, plastic};
use crate::journal::Steps;
use crate::observe::observation::Observation;
use crate::observe::photometric::PhotometricEstimate;
use crate::observe::sample::Stage;
use crate::problem::{ExposureRule, Options, Problem, RecoverError, Role};
use crate::record::{CandidateRecord, Covariance, Deviations, LightResult, Status};
use crate::sample_budget;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use unrender_render::{Appearance, RadianceCache};
use unrender_scene::{Image, Material, Rgb, RgbImage};

/// What a recovery takes the scene to be, with the problem that it is a guess at. Clones share what is large.
#[derive(Clone)]
pub(crate) struct Guess<'a> {
    pub(crate) problem: &'a Problem<'a>,
    /// The photograph, and which pixels of it count.
    pub(crate) observation: Arc<Observation>,
    /// The current material of every group.
    pub(crate) materials: Vec<Material>,
    /// How many times as bright as in the scene each source of light shines (see [`Appearance`]).
    pub(crate) lights: Vec<Rgb>,
    /// What is held of every group.
    pub(crate) groups: Vec<GroupGuess>,
    pub(crate) exposure: Rgb,
    pub(crate) exposure_std: Option<Rgb>,
    /// The joint covariance of what was refined.
    pub(crate) covariance: Option<Covariance>,
    pub(crate) light_results: Vec<LightResult>,
    pub(crate) photometric: PhotometricEstimate,
    /// The photograph's radiance where it shows diffuse surfaces.
    pub(crate) seen: Option<Arc<RadianceCache>>,
    /// Whether surfaces without gloss are taken to have a coat, where the scene's format has one.
    pub(crate) is_coated: bool,
    /// The journal of the steps that were made.
    pub(crate) steps: Steps<'a>,
}

/// What is held of one group.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct GroupGuess {
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
    /// The hypotheses that its last comparison left open.
    pub(crate) undecided: Vec<Hypothesis>,
    pub(crate) std: Option<Deviations>,
    /// Other fits that explain the photograph as well.
    pub(crate) alternatives: Vec<Fit>,
}

impl GroupGuess {
    /// Adds a sentence to what the user should know.
    pub(crate) fn add_note(&mut self, note: String) {
        self.note = match self.note.take() {
            Some(before) if before.contains(&note) => Some(before),
            Some(before) => Some(format!("{before}; {note}")),
            None => Some(note),
        };
    }

    /// Whether the last entry of the selection log is not of `hypothesis`.
    pub(crate) fn is_new_to(&self, hypothesis: Hypothesis) -> bool {
        self.selection_log.last().is_none_or(|candidate| candidate.hypothesis != hypothesis)
    }
}

/// Every unknown group of which nothing is expected starts as diffuse with this reflectance.
const START: f32 = 0.5;

impl<'a> Guess<'a> {
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
        let groups = |group: usize| GroupGuess {
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
            observation: Arc::new(problem.observation.clone()),
            materials,
            lights,
            groups,
            exposure,
            exposure_std: None,
            covariance: None,
            light_results: Vec::new(),
            photometric,
            seen: None,
            is_coated: false,
            steps: Steps::default(),
        })
    }

    /// The photograph's value at a pixel with the camera's numbers as they stand, before exposure.
    pub(crate) fn value(&self, pixel: usize) -> Rgb {
        self.stage().value(pixel as u32)
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
            seen: self.seen.as_deref(),
            observation: &self.observation,
            camera: (self.problem.photometric_parameters, &self.photometric.steps),
            exposure: self.exposure,
            renderer: self.problem.renderer,
        }
    }

    /// Updates the radiance cache from the photograph: all valid pixels of groups that are taken to look the same from all
    /// directions, or nearly so.
    pub(crate) fn look_at_photograph(&mut self) {
        let observation = &self.observation;
        let values = &observation.picture.values;
        let (width, height) = (values.width(), values.height());
        let mut known = Image::new(width, height, vec![false; width * height]);
        for (group, pixels) in observation.pixels_of_group.iter().enumerate() {
            let emits = self.problem.groups[group].role == Role::Emitter;
            if !emits && plastic::is_dull(&self.materials[group]) {
                pixels.iter().for_each(|&p| known.pixels_mut()[p as usize] = true);
            }
        }
        let exposure = self.exposure;
        let radiance = (0..width * height).map(|pixel| exposure * self.value(pixel)).collect();
        let radiance = RgbImage::new(width, height, radiance);
        self.seen = Some(Arc::new(RadianceCache { radiance, valid: known }));
    }

    /// `group` as a surface of which nothing but its colour is known: diffuse, or a dull plastic.
    pub(crate) fn plain(&self, group: usize, rho_d: Rgb) -> Material {
        let spec = &self.problem.groups[group];
        let may_have = self.is_coated && spec.allows(Hypothesis::Isotropic);
        let coat = || plastic::dull(self.problem.renderer.model(), &spec.expected.bounds);
        match may_have.then(coat).flatten() {
            Some(coat) => Material { rho_d, ..coat },
            None => Material::diffuse(rho_d),
        }
    }

    /// The same guess with a coat over what is diffuse, where all surfaces of the scene's format have one.
    pub(crate) fn coated(mut self) -> Self {
        self.is_coated = true;
        for group in self.visible_unknowns() {
            if self.groups[group].hypothesis == Hypothesis::Diffuse {
                self.materials[group] = self.plain(group, self.materials[group].rho_d);
            }
        }
        self
    }

    /// Makes the outliers of `group` count again.
    pub(crate) fn forget_outliers(&mut self, group: usize) {
        if self.observation.outlier_share(group) > 0.0 {
            Arc::make_mut(&mut self.observation).forget_outliers(group);
        }
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
        let [a, b] = evidence.light.diffuse();
        let light: Rgb = 0.5 * (a.iter().sum::<Rgb>() + b.iter().sum::<Rgb>());
        let values: Rgb = evidence.sample.pixels.iter().map(|p| p.radiance).sum();
        let is_seen = values.min_element() > 0.0 && light.min_element() > 0.0;
        is_seen.then(|| rho_d * light / values)
    }

    /// Forgets the standard deviations of numbers, which are about to move.
    pub(crate) fn forget_deviations(&mut self) {
        self.groups.iter_mut().for_each(|of_group| of_group.std = None);
        self.exposure_std = None;
        self.light_results.clear();
        self.covariance = None;
        self.photometric.covariance.clear();
    }
}
