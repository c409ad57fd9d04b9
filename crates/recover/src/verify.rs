//! Verification: is one state of the recovery better than another, judged by the whole picture?
//!
//! A sample of every group's pixels is rendered again, with all interreflection and without any cache,
//! always the same pixels and the same random numbers, so that two states differ by what they are and
//! not by noise. Only where a refinement is about to be taken back, both states are rendered once more by other random
//! numbers. Each group counts by the squared residuals of its blocks, as products of two renderings,
//! in units of their covariance under the observation model ([`crate::contrast`]), the sizes of its model error being
//! estimated: the gain of one group is not lost in the residual of another. Residuals are in units of the photograph's
//! values, so that states of different exposure can be compared. A group whose hypothesis became more complex is tested
//! alone too: its own pixels have to support the change.

use crate::block_residuals::{BlockResiduals, pooled};
use crate::blocks::{Blocks, Grid};
use crate::contrast::{Contrast, Side};
use crate::hypothesis::Hypothesis;
use crate::ladder::proposal::Proposal;
use crate::likelihood::Likelihood;
use crate::model_error::{Allowance, FAINTEST, LightError, LightField, ModelError, level2};
use crate::observation::{PixelStatus, Reading};
use crate::problem::{Options, Role};
use crate::residual::ResidualStats;
use crate::same_place;
use crate::sample_budget::{self, Level};
use crate::state::{Snapshot, State};
use crate::within::Within;
use serde::{Deserialize, Serialize};
use unrender_render::sampler::mix;
use unrender_render::{Appearance, Settings};
use unrender_scene::{Image, Rgb};

/// Pixels of a group that are rendered again, and paths a pixel in each of two halves. At half of
/// either, changes below a percent of a group's light are missed; double costs more than an
/// iteration.
const PIXELS: usize = 1200;
const SPP: u32 = 12;
/// The same where a group is tested alone. At half of it faint lobes are significant only in scenes
/// of large lamps, double costs as much as finding the candidate.
const OWN_SPP: u32 = 48;
/// Changes the seed: the random numbers that confirm a verdict differ from those that led to it.
const OTHER: u64 = 0x0B57;
/// A state is worse if its deviance is higher by this many standard deviations of the difference.
const WORSE: f64 = 3.0;
/// The share of model error below which no difference is significant: while hypotheses change, the
/// other groups follow on few light samples, and their errors of this size say nothing of the change.
/// After the refinement the light is better known. At half of it right changes are taken back because
/// of noise in other groups; at double wrong ones of faint lobes pass.
const FLOOR: f64 = 0.02;
const REFINED_FLOOR: f64 = 0.01;
/// The error of the incident light that is always allowed for, as a share of the floor: the other
/// groups are not right yet, and what they send changes slowly over a surface. At half of it a right
/// change is taken back because of the level that it leaves, at double slow patterns say nothing.
const LIGHT: f64 = 1.5;
/// The effect of a change of one group's hypothesis on its own pixels is tested down to this share: it was fitted in
/// this light. At half of it the noise of the renderings decides, at double faint lobes are taken back.
const OWN_FLOOR: f64 = 0.005;
/// A texture can explain everything: what it explains below this share does not count.
const TEXTURED_FLOOR: f64 = 0.05;
/// What an outlier costs in every channel, in squared standard deviations of its block: the same under
/// all states.
const OUTLIER: f64 = 9.0;

/// The pixels by which states are judged.
pub(crate) struct Verifier {
    groups: Vec<GroupSample>,
    settings: Settings,
    /// Paths a pixel where a group is tested alone.
    own_spp: u32,
    /// The share of model error below which no difference between two states counts.
    floor: f64,
    /// How much model error is allowed for in what is noted of a group: as in its comparisons.
    allowance: Allowance,
}

/// Those of one group.
struct GroupSample {
    group: usize,
    pixels: Vec<u32>,
    blocks: Blocks,
    /// The squared level of every block, in the photograph's values.
    level2: Vec<Rgb>,
    field: LightField,
}

/// How well a state explains the photograph.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Score {
    groups: Vec<GroupScore>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct GroupScore {
    residuals: BlockResiduals,
    /// Whether most of a block's pixels are outliers: its residuals are zero then.
    outlier: Vec<bool>,
    /// The model error below which nothing counts.
    least: Allowance,
    /// What is left within blocks, beyond a model error of [`FLOOR`].
    within: Within,
    /// How far its pixels are from the photograph.
    residual: ResidualStats,
}

/// The model error of which a `share` is allowed from block to block.
fn allowance(share: f64) -> Allowance {
    Allowance { light: LightError { share: LIGHT * share }, floor: ModelError { share } }
}

/// A state that was verified, with its score.
pub(crate) struct Verified {
    pub(crate) snapshot: Snapshot,
    pub(crate) score: Score,
}

impl Verifier {
    /// The sample for the problem of `state`.
    pub(crate) fn new(state: &State<'_>, options: &Options) -> Self {
        let judged = |g: &usize| state.problem.groups[*g].role != Role::Emitter;
        let observation = &state.observation;
        let wanted = observation.sheet.of_all(options.effort.pixels(PIXELS));
        let faintest = FAINTEST * observation.mean();
        let sample = |group: usize| {
            let valid = &observation.pixels_of_group[group];
            let grid = Grid::of(observation, group, valid, wanted);
            let pixels = grid.sample(valid, wanted, mix(options.seed ^ 0x7E57) ^ group as u64);
            let renderer = state.problem.renderer;
            let blocks = same_place::paired(Blocks::of(&pixels, &grid), renderer, &pixels);
            let values: Vec<Rgb> =
                pixels.iter().map(|&p| observation.picture.values.pixels()[p as usize]).collect();
            let mean = values.iter().sum::<Rgb>() / values.len().max(1) as f32;
            let mean = mean.max(faintest);
            let level2 = blocks.smooth(&values).iter().map(|local| level2(mean, *local)).collect();
            let none = LightError { share: 0.0 };
            let geometry = (&observation.sheet, renderer.geometry());
            let field = LightField::of(&blocks, &pixels, geometry, none);
            GroupSample { group, pixels, blocks, level2, field }
        };
        let groups = (0..state.materials.len()).filter(judged).map(sample);
        let seed = mix(options.seed ^ 0x5C04E);
        Self {
            groups: groups.filter(|sample| !sample.pixels.is_empty()).collect(),
            settings: Settings {
                first: 0,
                together: sample_budget::TOGETHER,
                spp: options.effort.samples(SPP),
                seed,
                max_bounces: options.max_bounces,
                integrator: unrender_render::Integrator::Path,
            },
            own_spp: options.effort.samples(OWN_SPP),
            floor: FLOOR.max(options.thresholds.explained),
            allowance: sample_budget::allowance(Level::Choice, options),
        }
    }

    /// The numbers are refined from now on.
    pub(crate) fn begin_refined(&mut self, options: &Options) {
        self.floor = REFINED_FLOOR.max(options.thresholds.explained);
        self.allowance = sample_budget::allowance(Level::Refined, options);
    }

    /// Renders the sample in `state`, and keeps the state with its score.
    pub(crate) fn verify(&self, state: &mut State<'_>) -> Verified {
        let score = state.steps.value("verification", || self.score(state, &self.settings));
        self.judge(state, &score);
        Verified { snapshot: state.snapshot(), score }
    }

    /// Notes in `state` how well its groups are explained.
    fn judge(&self, state: &mut State<'_>, score: &Score) {
        for (sample, of_group) in self.groups.iter().zip(&score.groups) {
            let at = &mut state.groups[sample.group];
            if at.hypothesis == Hypothesis::Textured {
                (at.residual, at.likelihood) = (None, None);
                continue;
            }
            let field = LightField { least: self.allowance.light, ..sample.field.clone() };
            at.residual = Some(of_group.residual);
            at.likelihood = Some(Likelihood::of(&of_group.residuals, &field, self.allowance.floor));
        }
    }

    /// Whether `state`, whose snapshot is `found`, is worse than `best` by other random numbers, and more of them: of
    /// states that were judged by the same ones, the best is partly the one that fits their noise.
    pub(crate) fn confirms_worse(
        &self,
        state: &mut State<'_>,
        found: &Snapshot,
        best: &Snapshot,
    ) -> bool {
        let settings =
            Settings { seed: self.settings.seed ^ OTHER, spp: self.own_spp, ..self.settings };
        let score =
            |state: &State<'_>| state.steps.value("verification", || self.score(state, &settings));
        let mine = score(state);
        state.restore(best);
        let others = score(state);
        state.restore(found);
        self.compare(&mine, &others).is_worse()
    }

    /// How well `state` explains the photograph, by the paths of `settings`.
    fn score(&self, state: &State<'_>, settings: &Settings) -> Score {
        let all: Vec<u32> = self.groups.iter().flat_map(|s| s.pixels.iter().copied()).collect();
        let halves = self.render(state.appearance(), state, &all, settings);
        let mut start = 0;
        let of_group = |sample: &GroupSample| {
            let range = start..start + sample.pixels.len();
            start = range.end;
            let halves = halves.each_ref().map(|half| &half[range.clone()]);
            let is_textured = state.groups[sample.group].hypothesis == Hypothesis::Textured;
            let floor = if is_textured { TEXTURED_FLOOR.max(self.floor) } else { self.floor };
            self.group(state, (&state.observation.status, allowance(floor)), sample, halves)
        };
        Score { groups: self.groups.iter().map(of_group).collect() }
    }

    /// `pixels` with `appearance`, twice.
    fn render(
        &self,
        appearance: Appearance<'_>,
        state: &State<'_>,
        pixels: &[u32],
        settings: &Settings,
    ) -> [Vec<Rgb>; 2] {
        [0u64, 1].map(|half| {
            let seed = mix(settings.seed).wrapping_add(half);
            let settings = Settings { seed, ..*settings };
            state.problem.renderer.rerender(appearance, pixels, &settings)
        })
    }

    /// The score of one group's sample: of the pixels that `status` says count, down to the `least` model error.
    fn group(
        &self,
        state: &State<'_>,
        (status, least): (&Image<PixelStatus>, Allowance),
        sample: &GroupSample,
        halves: [&[Rgb]; 2],
    ) -> GroupScore {
        let observation = &state.observation;
        let (blocks, n) = (&sample.blocks, sample.pixels.len());
        let model = halves.map(|h| h.iter().map(|v| *v / state.exposure).collect::<Vec<Rgb>>());
        let value = |i: usize| state.value(sample.pixels[i] as usize);
        let light: Vec<Rgb> = (0..n).map(|i| 0.5 * (model[0][i] + model[1][i])).collect();
        let residual: Vec<Rgb> = (0..n).map(|i| value(i) - light[i]).collect();
        let half: Vec<Rgb> = (0..n).map(|i| 0.5 * (model[0][i] - model[1][i])).collect();
        let smooth = blocks.smooth(&light);
        let photograph = |i: usize| {
            let noise = observation.noise(sample.group, sample.pixels[i], Rgb::ONE);
            noise.variance(smooth[blocks.of_pixel[i] as usize])
        };
        let photograph: Vec<Rgb> = (0..n).map(photograph).collect();
        let rendering: Vec<Rgb> = half.iter().map(|half| *half * *half).collect();
        let rendering = pooled(&blocks.smooth(&rendering), &smooth);
        let counts = |i: usize| {
            let at = sample.pixels[i];
            let outlier = status.pixels()[at as usize] == PixelStatus::Outlier;
            !outlier && observation.reading(at) == Reading::Value
        };
        let mut valid = vec![0u32; blocks.len()];
        (0..n).filter(|i| counts(*i)).for_each(|i| valid[blocks.of_pixel[i] as usize] += 1);
        let outlier: Vec<bool> = valid.iter().zip(&blocks.sizes).map(|(v, n)| 2 * v < *n).collect();
        let of_blocks = |values: &[Rgb]| {
            let mut means = blocks.mean_where(values, counts);
            means.iter_mut().zip(&outlier).filter(|(_, o)| **o).for_each(|(m, _)| *m = Rgb::ZERO);
            means
        };
        let of_half = |half: &Vec<Rgb>| (0..n).map(|i| value(i) - half[i]).collect::<Vec<Rgb>>();
        let of_halves = model.each_ref().map(of_half);
        let model_error = (FLOOR * FLOOR) as f32;
        let variance =
            |i: usize| photograph[i] + model_error * sample.level2[blocks.of_pixel[i] as usize];
        let of_halves = of_halves.each_ref().map(Vec::as_slice);
        let of_light = model.each_ref().map(Vec::as_slice);
        let within = Within::of(blocks, (of_halves, of_light), variance, counts);
        let squares = |i: usize| -> [f64; 3] {
            let weight = variance(i).recip();
            let of = |rgb: Rgb| f64::from((weight * rgb).element_sum());
            let [a, b] = [of_halves[0][i], of_halves[1][i]];
            [of(a * b), of(photograph[i]), of(value(i) * value(i))]
        };
        let squares: Vec<[f64; 3]> = (0..n).filter(|i| counts(*i)).map(squares).collect();
        let residual_stats = ResidualStats::of(&squares);
        let photograph = blocks.mean_where(&photograph, counts);
        let pixels = |k: usize| valid[k].max(1) as f32;
        let rendering: Vec<Rgb> = (0..blocks.len()).map(|k| rendering[k] / pixels(k)).collect();
        let noise = |k: usize| photograph[k] / pixels(k) + rendering[k];
        let noise = (0..blocks.len()).map(noise).collect();
        let (residual, half) = (of_blocks(&residual), of_blocks(&half));
        let mut level2 = sample.level2.clone();
        blocks.spread_over_fine(&mut level2);
        let missing = vec![Rgb::ZERO; blocks.len()];
        let light = smooth;
        let residuals = BlockResiduals { residual, noise, rendering, half, missing, level2, light };
        GroupScore { residuals, outlier, least, within, residual: residual_stats }
    }

    /// The groups whose light differs between the scores `mine` and `other` by more than the `share` of
    /// it.
    pub(crate) fn changed(&self, mine: &Score, other: &Score, share: f64) -> Vec<usize> {
        let both = self.groups.iter().zip(mine.groups.iter().zip(&other.groups));
        let is_changed = |(mine, other): (&GroupScore, &GroupScore)| {
            mine.residuals.change_from(&other.residuals) > share * share
        };
        let changed = both.filter(|(_, scores)| is_changed(*scores));
        changed.map(|(sample, _)| sample.group).collect()
    }

    /// Compares the score `mine` with `other`.
    pub(crate) fn compare(&self, mine: &Score, other: &Score) -> Contrasts {
        let both = self.groups.iter().zip(mine.groups.iter().zip(&other.groups));
        let of_group = |(sample, (mine, other)): (&GroupSample, (&GroupScore, &GroupScore))| {
            (sample.group, sample.contrast(mine, other, Contrast::of))
        };
        Contrasts { groups: both.map(of_group).collect() }
    }

    /// Whether the picture of a group in `state` supports its change by `proposal` from the `present` state: it has the
    /// lower information criterion ([`crate::selection`]), or is not significantly wrong. A texture, which fits every
    /// block, has to gain significantly more than from residuals that are chance, or that the better ones of the other
    /// groups have too: from block to block, where slow changes over the surface may also be an error of a lobe, or
    /// from pixel to pixel within blocks. There the other groups show what is chance, as the noise of a compressed
    /// photograph is larger than its neighbouring pixels show.
    pub(crate) fn bears_out(
        &self,
        state: &State<'_>,
        present: &Verified,
        proposal: &Proposal,
    ) -> bool {
        let before = &present.snapshot;
        let Proposal { group, adds, least, .. } = *proposal;
        let Some(sample) = self.groups.iter().find(|sample| sample.group == group) else {
            return true;
        };
        let rendered = || {
            let mut materials = state.materials.clone();
            let now = (&state.materials[group], &state.observation.status);
            [now, (before.material(group), before.status())].map(|(material, status)| {
                materials[group].clone_from(material);
                let appearance = Appearance { materials: &materials, lights: &state.lights };
                let settings = Settings { spp: self.own_spp, ..self.settings };
                let halves = self.render(appearance, state, &sample.pixels, &settings);
                let least = least.unwrap_or_else(|| allowance(OWN_FLOOR));
                self.group(state, (status, least), sample, halves.each_ref().map(Vec::as_slice))
            })
        };
        let [mine, other] = &state.steps.value("own verification", rendered);
        let is_textured = state.groups[group].hypothesis == Hypothesis::Textured;
        // A lobe may lack what a Fresnel reflectance adds; on a diffuse surface only the light is wrong.
        let is_slow_allowed = is_textured && before.material(group).rho_s != Rgb::ZERO;
        let contrast = if is_slow_allowed { Contrast::of_pattern } else { Contrast::of };
        let contrast = sample.contrast(mine, other, contrast);
        let independent = contrast.independent * sample.blocks.len() as f64;
        let asks = if is_textured {
            // The squares that it removes from residuals by chance, and how much more chance and noise may make them.
            let chance = contrast.independent * contrast.chance;
            let noise = contrast.independent.powi(2) * contrast.noise;
            chance + WORSE * (2.0 * chance + noise).sqrt()
        } else {
            adds * independent.max(1.0).ln()
        };
        let criterion = contrast.independent * contrast.difference + asks;
        let is_fine_pattern = || {
            let chance = self.usual(state, present, group) * mine.within.count;
            is_textured && mine.within.gains(&other.within, chance, WORSE)
        };
        let may_be_right = !is_textured && !proposal.is_other_minimum && contrast.may_be_right();
        criterion < 0.0 || is_fine_pattern() || may_be_right
    }
}

impl Verifier {
    /// The median over the other groups without a texture of the ratio of squared residuals within blocks to their
    /// variance, and at least one: less would be chance.
    fn usual(&self, state: &State<'_>, Verified { score, .. }: &Verified, group: usize) -> f64 {
        let others = self.groups.iter().zip(&score.groups).filter(|(sample, _)| {
            let is_textured = state.groups[sample.group].hypothesis == Hypothesis::Textured;
            sample.group != group && !is_textured
        });
        let mut ratios: Vec<f64> = others.map(|(_, score)| score.within.over_variance()).collect();
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).map_or(1.0, |usual| usual.max(1.0))
    }
}

impl GroupSample {
    /// Compares two states by the comparison `of` their residuals. An outlier costs the same under both.
    fn contrast(
        &self,
        mine: &GroupScore,
        other: &GroupScore,
        of: impl Fn(&Blocks, [&Side<'_>; 2]) -> Contrast,
    ) -> Contrast {
        let field =
            |score: &GroupScore| LightField { least: score.least.light, ..self.field.clone() };
        let fields = [field(mine), field(other)];
        let sides = [(mine, &fields[0]), (other, &fields[1])].map(|(score, field)| Side {
            residuals: &score.residuals,
            field,
            floor: score.least.floor,
        });
        let contrast = of(&self.blocks, sides.each_ref());
        let outliers = |score: &GroupScore| score.outlier.iter().filter(|o| **o).count() as f64;
        let difference = contrast.difference + 3.0 * OUTLIER * (outliers(mine) - outliers(other));
        Contrast { difference, ..contrast }
    }
}

/// The contrast of two states, group by group.
pub(crate) struct Contrasts {
    groups: Vec<(usize, Contrast)>,
}

impl Contrasts {
    /// Whether the picture speaks against the one state: its deviance is higher by more than [`WORSE`] standard
    /// deviations of the difference under either model, whose variance is `4 S`, with `S` their separation, plus that
    /// by the renderings' noise. Blocks count as independent: in doubt, and where a picture is no number, a state is
    /// called worse.
    pub(crate) fn is_worse(&self) -> bool {
        let difference: f64 = self.groups.iter().map(|(_, c)| c.difference).sum();
        let deviation = self.groups.iter().map(|(_, c)| c.variance()).sum::<f64>().sqrt();
        difference.is_nan() || difference > WORSE * deviation
    }

    /// Whether the picture of `groups` alone is explained better.
    pub(crate) fn gains(&self, groups: &[usize]) -> bool {
        let of_groups = self.groups.iter().filter(|(group, _)| groups.contains(group));
        of_groups.map(|(_, c)| c.difference).sum::<f64>() < 0.0
    }
}
