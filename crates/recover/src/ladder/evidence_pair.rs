//! The evidence on one group, gathered twice, and all uniform rungs fitted to it under the present light.

use crate::evidence::{Evidence, SampleBudget};
use crate::guess::Guess;
use crate::hypothesis::{self, Fit, Hypothesis, Search};
use crate::observe::model_error::ModelError;
use crate::problem::Options;
use crate::selection;
use crate::streams::Stream;
use rayon::prelude::*;
use std::collections::HashSet;
use std::f32::consts::FRAC_PI_2;
use unrender_render::ProposalLobe;
use unrender_scene::{Material, Rgb};

/// The search goes on for so many of the most likely candidates: the accepted one and its rival.
const PROMISING: usize = 2;

/// The evidence on one group, gathered twice: shapes of lobes are searched by the one, and hypotheses are
/// compared by the other. A search finds the shape that fits the noise of its light samples best, and the
/// more shapes there are, the better it fits; the noise of other samples is independent of that.
pub(super) struct EvidencePair {
    searching: Evidence,
    pub(super) judging: Evidence,
}

/// What evidence on one group is gathered by.
pub(super) struct Gathering<'a> {
    pub(super) options: &'a Options,
    pub(super) group: usize,
    pub(super) budget: SampleBudget,
}

/// Hypotheses that the usual evidence leaves open are compared on so many times as many pixels, or where the group has no more,
/// on so many times as many points of each. With points alone drafts of two rooms called a large round lobe brushed, which
/// 600 pixels do not tell. At half of it drafts of twelve rooms take 7 % less time and leave 22 right groups open instead of
/// 16; double of it was not tried.
const AGAIN: usize = 4;

impl Gathering<'_> {
    /// The same with as many directions by the lobes of these `materials` as by those of a search: a lobe's light has the
    /// least noise along its own directions.
    fn towards<'m>(&self, materials: impl Iterator<Item = &'m Material>) -> Self {
        let glossy = materials.filter(|of| of.is_glossy());
        let lobes: Vec<ProposalLobe> = glossy.map(ProposalLobe::of).collect();
        let mut budget = self.budget.clone();
        if !lobes.is_empty() {
            let all = budget.probe.per_lobe * budget.probe.lobes.len() as u32;
            budget.probe.per_lobe = all.div_ceil(lobes.len() as u32);
            budget.probe.lobes = lobes;
        }
        Self { budget, ..*self }
    }

    /// The evidence by the random numbers of its `purpose`, so many `times` the usual one; none where nothing was seen of the
    /// group.
    fn gather(&self, guess: &Guess<'_>, times: usize, purpose: Stream) -> Option<Evidence> {
        let pixels = &guess.observation.informative_of_group[self.group];
        let mut budget = self.budget.clone();
        let more = (pixels.len() / budget.pixels.max(1)).clamp(1, times);
        budget.pixels *= more;
        budget.probe.probes_per_pixel *= (times / more) as u32;
        budget.probe.seed = purpose.change(budget.probe.seed);
        budget.probe.max_bounces = self.options.max_bounces;
        let (stage, appearance) = (guess.stage(), guess.appearance());
        let evidence = Evidence::gather(&stage, appearance, self.group, pixels, &budget);
        let evidence = evidence
            .expecting(guess.problem.groups[self.group].expected)
            .beside(guess.plain(self.group, Rgb::ZERO));
        (!evidence.is_empty()).then_some(evidence)
    }
}

impl EvidencePair {
    /// The evidence on a group, twice; none where nothing was seen of it.
    pub(super) fn gather(guess: &Guess<'_>, by: &Gathering<'_>) -> Option<Self> {
        let searching = by.gather(guess, 1, Stream::Searching)?;
        let judging = by.gather(guess, 1, Stream::Judging)?;
        Some(Self { searching, judging })
    }

    /// The same with more and other evidence to compare the present hypothesis and what was `searched` by; none where nothing
    /// was seen of the group.
    pub(super) fn judged_again(
        self,
        guess: &Guess<'_>,
        by: &Gathering<'_>,
        searched: &Searched,
    ) -> Option<Self> {
        let present = &guess.materials[by.group];
        let fits = searched.fits.iter().chain(&searched.broad);
        let compared = fits.map(|fit| &fit.material).chain([present]);
        let judging = by.towards(compared).gather(guess, AGAIN, Stream::JudgingAgain)?;
        Some(Self { judging, ..self })
    }

    /// The same without the pixels of `judging` that are flagged.
    pub(super) fn without(self, flags: &[bool]) -> Self {
        let flagged = self.judging.sample.pixels.iter().zip(flags).filter(|(_, flag)| **flag);
        let flagged: HashSet<u32> = flagged.map(|(seen, _)| seen.pixel).collect();
        let of_searching: Vec<bool> =
            self.searching.sample.pixels.iter().map(|seen| flagged.contains(&seen.pixel)).collect();
        Self {
            searching: self.searching.without(&of_searching),
            judging: self.judging.without(flags),
        }
    }

    /// All uniform rungs that the group may have, under common weights: those of the most likely fit's
    /// light. Shapes are from one half, reflectances and likelihoods from the other; the present lobe may keep its
    /// shape, which the refinement may have found from all pixels. Fits that overflowed are left out.
    pub(super) fn fit_all(mut self, guess: &Guess<'_>, group: usize) -> (Self, Fits) {
        let searched = self.search(guess, group);
        let fits = self.judge(&searched, guess, group);
        (self, fits)
    }

    /// What was `searched`, fitted to the evidence that hypotheses are compared by.
    pub(super) fn judge(&mut self, searched: &Searched, guess: &Guess<'_>, group: usize) -> Fits {
        let Searched { fits, broad, material, error } = searched;
        share_weights(&mut self.judging, material, *error);
        let again =
            |fit: &Fit| hypothesis::fit(fit.hypothesis, &self.judging, &fit.material, Search::Kept);
        let mut fits: Vec<Fit> = fits.par_iter().map(again).collect();
        let present = self.present(guess, group);
        let broad: Vec<Fit> = broad.par_iter().map(again).collect();
        for other in broad.into_iter().chain(present.clone()) {
            let same = fits.iter_mut().find(|fit| fit.hypothesis == other.hypothesis);
            if let Some(fit) = same.filter(|fit| deviance(&other) < deviance(fit)) {
                *fit = other;
            }
        }
        fits.retain(Fit::is_finite);
        selection::sort(&mut fits);
        Fits { all: fits, present }
    }

    /// Searches everywhere for the shapes of all rungs.
    pub(super) fn search(&mut self, guess: &Guess<'_>, group: usize) -> Searched {
        search_all(&mut self.searching, guess, group)
    }

    /// The present lobe of `group`, if it has one: as it is, or in the minimum that it leads to.
    fn present(&self, guess: &Guess<'_>, group: usize) -> Option<Fit> {
        let (rung, material) = (guess.groups[group].hypothesis, &guess.materials[group]);
        if !matches!(rung, Hypothesis::Isotropic | Hypothesis::Anisotropic) {
            return None;
        }
        let nearby = hypothesis::fit(rung, &self.searching, material, Search::Local).material;
        let judged = [material, &nearby]
            .map(|material| hypothesis::fit(rung, &self.judging, material, Search::Kept));
        let finite = judged.into_iter().filter(Fit::is_finite);
        finite.min_by(|a, b| deviance(a).total_cmp(&deviance(b)))
    }
}

/// The candidates of one group.
pub(super) struct Fits {
    /// All rungs, from simple to complex.
    pub(super) all: Vec<Fit>,
    /// The present lobe, as it is or fitted locally.
    pub(super) present: Option<Fit>,
}

fn deviance(fit: &Fit) -> f64 {
    fit.likelihood.deviance
}

/// What a search found: the fits, and the most likely material and model error that their weights are
/// from.
pub(super) struct Searched {
    fits: Vec<Fit>,
    /// Broader lobes beside the sharp ones among these.
    broad: Vec<Fit>,
    material: Material,
    error: ModelError,
}

/// Weights for all candidates: those under the light of `material`, and no less noise than that of a
/// diffuse surface.
fn share_weights(evidence: &mut Evidence, material: &Material, error: ModelError) {
    evidence.reweigh(material, error);
    evidence.least_noise = None;
    evidence.least_noise = Some(hypothesis::diffuse::fit(evidence).residuals.noise);
}

/// All uniform rungs that the group may have, searched for everywhere and then near the most likely ones.
fn search_all(evidence: &mut Evidence, guess: &Guess<'_>, group: usize) -> Searched {
    let rungs = guess.problem.groups[group].uniform_rungs();
    let diffuse = hypothesis::diffuse::fit(evidence);
    share_weights(evidence, &diffuse.material, ModelError::START);
    let mut fits: Vec<Fit> = Vec::new();
    for rung in rungs {
        let start = fits.last().map_or(diffuse.material.clone(), |f| f.material.clone());
        fits.push(hypothesis::fit(rung, evidence, &start, Search::Global));
    }
    let best = fits.iter().min_by(|a, b| deviance(a).total_cmp(&deviance(b)));
    let (material, error) = best.map_or((diffuse.material, ModelError::START), |b| {
        (b.material.clone(), b.likelihood.error)
    });
    let mut ranked: Vec<f64> = fits.iter().map(deviance).collect();
    ranked.sort_by(f64::total_cmp);
    let promising = ranked.get(PROMISING - 1).copied().unwrap_or(f64::INFINITY);
    share_weights(evidence, &material, error);
    let evidence = &*evidence;
    fits.par_iter_mut().for_each(|fit| {
        let is_promising = deviance(fit) <= promising;
        let again = |search| hypothesis::fit(fit.hypothesis, evidence, &fit.material, search);
        let kept = again(Search::Kept);
        let polished = is_promising.then(|| again(Search::Local));
        let better = polished.filter(|polished| deviance(polished) < deviance(&kept));
        *fit = better.unwrap_or(kept);
    });
    let broad = fits.par_iter().flat_map(|fit| broader(fit, evidence)).collect();
    Searched { fits, broad, material, error }
}

/// A lobe is sharp below this mean roughness. At half of it lobes that fit noise pass for broad ones, at double
/// broad lobes are searched for twice.
const SHARP: f32 = 0.12;
/// The mean roughness at which the search for a broader one starts. Half of it is hardly broader, double of it
/// hardly differs from diffuse.
const BROAD: f32 = 0.3;
/// If it is anisotropic: the square root of `alpha_y / alpha_x` at the start. At one the direction has no
/// effect, at double the start is far from most lobes.
const LONGER: f32 = 1.5;

/// If the search ended at a sharp lobe: the best broad ones. Few light samples hit a sharp lobe, so that it can fit
/// their noise; on other samples a broad one may be better.
fn broader(fit: &Fit, evidence: &Evidence) -> Vec<Fit> {
    let Material { alpha_x, alpha_y, theta_rad, .. } = fit.material;
    if !fit.material.is_glossy() || (alpha_x * alpha_y).sqrt() > SHARP {
        return Vec::new();
    }
    let near = |alpha_x: f32, alpha_y: f32, theta_rad: f32| {
        let start = Material { alpha_x, alpha_y, theta_rad, ..fit.material.clone() };
        hypothesis::fit(fit.hypothesis, evidence, &start, Search::Local)
    };
    if fit.hypothesis == Hypothesis::Isotropic {
        return vec![near(BROAD, BROAD, 0.0)];
    }
    let turned = |theta_rad: f32| near(BROAD / LONGER, BROAD * LONGER, theta_rad);
    let (along, across) = rayon::join(|| turned(theta_rad), || turned(theta_rad + FRAC_PI_2));
    vec![along, across]
}
