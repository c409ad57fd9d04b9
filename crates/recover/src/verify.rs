//! Verification: is one guess better than another, judged by the whole picture?
//!
//! A sample of every group's pixels is rendered again, with all interreflection and without any cache,
//! always the same pixels and the same random numbers, so that two guesses differ by what they are and
//! not by noise. Only where a refinement is about to be taken back, both guesses are rendered once more by other random
//! numbers. Each group counts by the squared residuals of its blocks, as products of two renderings,
//! in units of their covariance under the observation model ([`crate::compare`]), the sizes of its model error being
//! estimated: the gain of one group is not lost in the residual of another. Residuals are in units of the photograph's
//! values, so that guesses of different exposure can be compared. A group whose hypothesis became more complex is tested
//! alone too: its own pixels have to support the change.

use crate::compare::likelihood::Likelihood;
use crate::compare::residual::{BlockResiduals, ResidualStats, residual_stats};
use crate::compare::{Contrast, Measured, Side, WORSE};
use crate::guess::Guess;
use crate::hypothesis::Hypothesis;
use crate::observe::blocks::Blocks;
use crate::observe::model_error::{
    Allowance, FAINTEST, LightError, LightField, ModelError, level2,
};
use crate::observe::observation::{PixelStatus, Reading};
use crate::observe::sample::{Sample, Stage};
use crate::problem::{Options, Role};
use crate::sample_budget::{self, Level};
use crate::streams::Stream;
use serde::{Deserialize, Serialize};
use unrender_render::Settings;
use unrender_render::sampler::mix;
use unrender_scene::Rgb;

/// Pixels of a group that are rendered again, and paths a pixel in each of two halves. At half of
/// either, changes below a percent of a group's light are missed; double costs more than an
/// iteration.
const PIXELS: usize = 1200;
const SPP: u32 = 12;
/// The same where a group is tested alone. At half of it faint lobes are significant only in scenes
/// of large lamps, double costs as much as finding the candidate.
const OWN_SPP: u32 = 48;
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
/// all guesses.
const OUTLIER: f64 = 9.0;

/// The pixels by which guesses are judged.
pub(crate) struct Verifier {
    groups: Vec<GroupSample>,
    settings: Settings,
    /// Paths a pixel where a group is tested alone.
    own_spp: u32,
    /// The share of model error below which no difference between two guesses counts.
    floor: f64,
    /// How much model error is allowed for in what is noted of a group: as in its comparisons.
    allowance: Allowance,
}

/// Those of one group, in the photograph's values, each with its level.
struct GroupSample {
    group: usize,
    sample: Sample,
}

/// How well a guess explains the photograph.
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
    /// How far its pixels are from the photograph.
    residual: ResidualStats,
}

/// The model error of which a `share` is allowed from block to block.
fn allowance(share: f64) -> Allowance {
    Allowance { light: LightError { share: LIGHT * share }, floor: ModelError { share } }
}

/// What a change claims of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Claim {
    pub(crate) group: usize,
    /// How many more free parameters it has than the present hypothesis.
    pub(crate) adds: f64,
    /// Whether it is the present hypothesis in another minimum.
    pub(crate) is_other_minimum: bool,
}

/// A guess that was verified, with its score.
#[derive(Clone)]
pub(crate) struct Verified<'a> {
    pub(crate) guess: Guess<'a>,
    pub(crate) score: Score,
}

impl Verifier {
    /// The sample for the problem of `guess`.
    pub(crate) fn new(guess: &Guess<'_>, options: &Options) -> Self {
        let judged = |g: &usize| guess.problem.groups[*g].role != Role::Emitter;
        let observation = &guess.observation;
        let wanted = options.effort.pixels(PIXELS);
        let faintest = FAINTEST * observation.mean();
        let stage = Stage { exposure: Rgb::ONE, ..guess.stage() };
        let sample = |group: usize| {
            let valid = &observation.pixels_of_group[group];
            let seed = Stream::VerifiedPixels.seed(options.seed);
            let (pixels, grid) = Sample::choose(observation, group, valid, wanted, seed);
            let none = LightError { share: 0.0 };
            let mut sample = Sample::of(&stage, group, (&pixels, &grid), none);
            let values: Vec<Rgb> = sample.pixels.iter().map(|seen| seen.radiance).collect();
            let mean = values.iter().sum::<Rgb>() / values.len().max(1) as f32;
            let smooth = sample.blocks.smooth(&values);
            for (seen, block) in sample.pixels.iter_mut().zip(&sample.blocks.of_pixel) {
                let level2 = level2(mean.max(faintest), smooth[*block as usize]);
                seen.level = level2.map(f32::sqrt);
            }
            GroupSample { group, sample }
        };
        let groups = (0..guess.materials.len()).filter(judged).map(sample);
        let seed = Stream::Verification.seed(options.seed);
        Self {
            groups: groups.filter(|of| !of.sample.pixels.is_empty()).collect(),
            settings: sample_budget::paths(options.effort.samples(SPP), seed, options),
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

    /// Renders the sample under `guess`, and notes in it how well its groups are explained.
    pub(crate) fn verify<'a>(&self, mut guess: Guess<'a>) -> Verified<'a> {
        let score = guess.steps.value("verification", || self.score(&guess, &self.settings));
        for (GroupSample { group, sample }, of_group) in self.groups.iter().zip(&score.groups) {
            let at = &mut guess.groups[*group];
            if at.hypothesis == Hypothesis::Textured {
                (at.residual, at.likelihood) = (None, None);
                continue;
            }
            let field = LightField { least: self.allowance.light, ..sample.field.clone() };
            at.residual = Some(of_group.residual);
            at.likelihood = Some(Likelihood::of(&of_group.residuals, &field, self.allowance.floor));
        }
        Verified { guess, score }
    }

    /// Whether `found` is worse than `best` by other random numbers, and more of them: of guesses that were judged by the
    /// same ones, the best is partly the one that fits their noise.
    pub(crate) fn confirms_worse(&self, found: &Guess<'_>, best: &Guess<'_>) -> bool {
        let seed = Stream::Confirmation.change(self.settings.seed);
        let settings = Settings { seed, spp: self.own_spp, ..self.settings };
        let score =
            |guess: &Guess<'_>| guess.steps.value("verification", || self.score(guess, &settings));
        self.compare(&score(found), &score(best)).is_worse()
    }

    /// How well `guess` explains the photograph, by the paths of `settings`.
    fn score(&self, guess: &Guess<'_>, settings: &Settings) -> Score {
        let all: Vec<u32> = self.groups.iter().flat_map(|of| of.sample.numbers()).collect();
        let halves = render(guess, &all, settings);
        let mut start = 0;
        let of_group = |of: &GroupSample| {
            let range = start..start + of.sample.pixels.len();
            start = range.end;
            let halves = halves.each_ref().map(|half| half[range.clone()].to_vec());
            let is_textured = guess.groups[of.group].hypothesis == Hypothesis::Textured;
            let floor = if is_textured { TEXTURED_FLOOR.max(self.floor) } else { self.floor };
            of.score(guess, allowance(floor), halves)
        };
        Score { groups: self.groups.iter().map(of_group).collect() }
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
        Contrasts { groups: both.map(of_group).collect(), paths: self.settings.spp }
    }

    /// Whether the picture of a group in `guess` supports the `claim` of its change from the `present` one: it has the
    /// lower information criterion ([`crate::selection`]), or is not significantly wrong.
    pub(crate) fn bears_out(
        &self,
        guess: &Guess<'_>,
        present: &Verified<'_>,
        claim: Claim,
    ) -> Measured {
        let before = &present.guess;
        let Claim { group, adds, is_other_minimum } = claim;
        let Some(of) = self.groups.iter().find(|of| of.group == group) else {
            return Measured { holds: true, ..Measured::default() };
        };
        let rendered = || {
            let mut other = guess.clone();
            other.materials[group].clone_from(&before.materials[group]);
            other.observation.clone_from(&before.observation);
            let settings = Settings { spp: self.own_spp, ..self.settings };
            let least = allowance(OWN_FLOOR);
            let numbers = of.sample.numbers();
            [guess, &other].map(|guess| of.score(guess, least, render(guess, &numbers, &settings)))
        };
        let [mine, other] = &guess.steps.value("own verification", rendered);
        let contrast = of.contrast(mine, other, Contrast::of);
        let independent = contrast.independent * of.sample.blocks.len() as f64;
        let asks = adds * independent.max(1.0).ln();
        let criterion = contrast.independent * contrast.difference + asks;
        let may_be_right = !is_other_minimum && contrast.may_be_right();
        Measured {
            holds: criterion < 0.0 || may_be_right,
            difference: contrast.independent * contrast.difference,
            deviation: contrast.independent * contrast.variance().sqrt(),
            price: asks,
            paths: self.own_spp,
        }
    }
}

/// `pixels` under `guess`, twice.
fn render(guess: &Guess<'_>, pixels: &[u32], settings: &Settings) -> [Vec<Rgb>; 2] {
    [0u64, 1].map(|half| {
        let settings = Settings { seed: mix(settings.seed).wrapping_add(half), ..*settings };
        guess.problem.renderer.rerender(guess.appearance(), pixels, &settings)
    })
}

impl GroupSample {
    /// How well `guess` explains it down to the `least` model error, by two renderings of it.
    fn score(&self, guess: &Guess<'_>, least: Allowance, halves: [Vec<Rgb>; 2]) -> GroupScore {
        let model = halves.map(|half| half.iter().map(|v| *v / guess.exposure).collect());
        let [a, b]: &[Vec<Rgb>; 2] = &model;
        let light: Vec<Rgb> = a.iter().zip(b).map(|(a, b)| 0.5 * (*a + *b)).collect();
        let mut sample = self.sample.clone();
        let (status, smooth) = (&guess.observation.status, sample.blocks.smooth(&light));
        let (mut counted, sizes) = (vec![0u32; sample.blocks.len()], &sample.blocks.sizes);
        for (seen, &block) in sample.pixels.iter_mut().zip(&sample.blocks.of_pixel) {
            let block = block as usize;
            seen.radiance = guess.value(seen.pixel as usize);
            seen.variance = seen.noise.variance(smooth[block]);
            seen.weight =
                (seen.variance + (FLOOR * FLOOR) as f32 * seen.level * seen.level).recip();
            if status.pixels()[seen.pixel as usize] == PixelStatus::Outlier {
                seen.reading = Reading::Nothing;
            }
            counted[block] += u32::from(seen.reading == Reading::Value);
        }
        let mut residuals = BlockResiduals::over(&sample, &model);
        let outlier: Vec<bool> = counted.iter().zip(sizes).map(|(v, n)| 2 * v < *n).collect();
        for (block, _) in outlier.iter().enumerate().filter(|(_, outlier)| **outlier) {
            (residuals.residual[block], residuals.half[block]) = (Rgb::ZERO, Rgb::ZERO);
        }
        let residual = residual_stats(&sample.pixels, &model);
        GroupScore { residuals, outlier, least, residual }
    }

    /// Compares two guesses by the comparison `of` their residuals. An outlier costs the same under both.
    fn contrast(
        &self,
        mine: &GroupScore,
        other: &GroupScore,
        of: impl Fn(&Blocks, [&Side<'_>; 2]) -> Contrast,
    ) -> Contrast {
        let field = |score: &GroupScore| LightField {
            least: score.least.light,
            ..self.sample.field.clone()
        };
        let fields = [field(mine), field(other)];
        let sides = [(mine, &fields[0]), (other, &fields[1])].map(|(score, field)| Side {
            residuals: &score.residuals,
            field,
            floor: score.least.floor,
        });
        let contrast = of(&self.sample.blocks, sides.each_ref());
        let outliers = |score: &GroupScore| score.outlier.iter().filter(|o| **o).count() as f64;
        let difference = contrast.difference + 3.0 * OUTLIER * (outliers(mine) - outliers(other));
        Contrast { difference, ..contrast }
    }
}

/// The contrast of two guesses, group by group.
pub(crate) struct Contrasts {
    groups: Vec<(usize, Contrast)>,
    paths: u32,
}

impl Contrasts {
    /// Whether the picture speaks against the one guess: its deviance is higher by more than [`WORSE`] standard
    /// deviations of the difference under either model, whose variance is `4 S`, with `S` their separation, plus that
    /// by the renderings' noise. Blocks count as independent: in doubt, and where a picture is no number, a guess is
    /// called worse.
    pub(crate) fn is_worse(&self) -> bool {
        !self.measured().holds
    }

    /// The difference of the whole picture, for the record; it holds if the picture does not speak against it.
    pub(crate) fn measured(&self) -> Measured {
        let difference: f64 = self.groups.iter().map(|(_, c)| c.difference).sum();
        let deviation = self.groups.iter().map(|(_, c)| c.variance()).sum::<f64>().sqrt();
        let holds = !(difference.is_nan() || difference > WORSE * deviation);
        Measured { holds, difference, deviation, price: 0.0, paths: self.paths }
    }

    /// Whether the picture of `groups` alone is explained better.
    pub(crate) fn gains(&self, groups: &[usize]) -> bool {
        let of_groups = self.groups.iter().filter(|(group, _)| groups.contains(group));
        of_groups.map(|(_, c)| c.difference).sum::<f64>() < 0.0
    }
}
