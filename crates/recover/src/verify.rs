//! Verification: how well a guess explains every group, and which groups another one explains worse.
//!
//! A sample of every group's pixels is rendered again, with all interreflection and without any cache,
//! always the same pixels and the same random numbers, so that two guesses differ by what they are and
//! not by noise. Each group counts by the squared residuals of its blocks, as products of two renderings,
//! in units of their covariance under the observation model ([`crate::compare`]), the sizes of its model error being
//! estimated: the gain of one group is not lost in the residual of another. Residuals are in units of the photograph's
//! values, so that guesses of different exposure can be compared.

use crate::compare::likelihood::Likelihood;
use crate::compare::residual::{BlockResiduals, ResidualStats, residual_stats};
use crate::compare::{Contrast, Side, WORSE};
use crate::guess::Guess;
use crate::hypothesis::Hypothesis;
use crate::observe::model_error::{Allowance, FAINTEST, LightError, LightField, level2};
use crate::observe::observation::{PixelStatus, Reading};
use crate::observe::sample::{Sample, Stage};
use crate::problem::{Options, Role};
use crate::sample_budget::{self, Level};
use crate::streams::Stream;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use unrender_render::Settings;
use unrender_render::sampler::mix;
use unrender_scene::Rgb;

/// Pixels of a group that are rendered again, and paths a pixel in each of two halves. At half of
/// either, changes below a percent of a group's light are missed; double costs more than an
/// iteration.
const PIXELS: usize = 1200;
const SPP: u32 = 12;

/// The pixels by which guesses are judged.
pub(crate) struct Verifier {
    groups: Vec<GroupSample>,
    settings: Settings,
    /// How much model error is allowed for: as in comparisons of hypotheses.
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
    /// How much model error was allowed for.
    least: Allowance,
    /// How far its pixels are from the photograph.
    residual: ResidualStats,
    /// Its hypothesis, and what it reflects of even light.
    reflects: (Hypothesis, Rgb),
}

/// A guess that was verified, with its score.
#[derive(Clone)]
pub(crate) struct Verified<'a> {
    pub(crate) guess: Guess<'a>,
    pub(crate) score: Arc<Score>,
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
            allowance: sample_budget::allowance(Level::Choice, options),
        }
    }

    /// The numbers are refined from now on.
    pub(crate) fn begin_refined(&mut self, options: &Options) {
        self.allowance = sample_budget::allowance(Level::Refined, options);
    }

    /// Renders the sample under `guess`, and notes in it how well its groups are explained.
    pub(crate) fn verify<'a>(&self, mut guess: Guess<'a>) -> Verified<'a> {
        let score = guess.steps.value("verification", || self.score(&guess));
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
        Verified { guess, score: Arc::new(score) }
    }

    /// How well `guess` explains the photograph.
    fn score(&self, guess: &Guess<'_>) -> Score {
        let all: Vec<u32> = self.groups.iter().flat_map(|of| of.sample.numbers()).collect();
        let halves = render(guess, &all, &self.settings);
        let mut start = 0;
        let of_group = |of: &GroupSample| {
            let range = start..start + of.sample.pixels.len();
            start = range.end;
            let halves = halves.each_ref().map(|half| half[range.clone()].to_vec());
            of.score(guess, self.allowance, halves)
        };
        Score { groups: self.groups.iter().map(of_group).collect() }
    }

    /// Whether the light of `group` differs between two scores by more than the `share` of it: what it shows, or what a surface of
    /// the same kind has to reflect for that.
    pub(crate) fn is_changed(&self, group: usize, scores: [&Score; 2], share: f64) -> bool {
        let place = self.groups.iter().position(|sample| sample.group == group);
        place.is_some_and(|place| {
            let [mine, other] = scores.map(|score| &score.groups[place]);
            mine.residuals.change_from(&other.residuals) > share * share
                || mine.reflects_otherwise(other, share as f32)
        })
    }

    /// The groups whose pixels speak against the guess of the score `mine`: their deviance is higher than under `other` by
    /// more than [`WORSE`] standard deviations of the difference under either model, whose variance is `4 S`, with `S`
    /// their separation, plus that by the renderings' noise. Blocks count as independent: in doubt, and where a picture
    /// is no number, a guess is called worse.
    pub(crate) fn worse(&self, mine: &Score, other: &Score) -> Vec<usize> {
        let is_worse =
            |of: &Contrast| of.difference.is_nan() || of.difference > WORSE * of.variance().sqrt();
        let both = self.groups.iter().zip(mine.groups.iter().zip(&other.groups));
        let worse = both.filter(|(of, (mine, other))| is_worse(&of.contrast(mine, other)));
        worse.map(|(of, _)| of.group).collect()
    }

    /// By how much more the guess of the score `mine` leaves of the whole photograph than the `other`, in units of the
    /// covariance, and the variance of that by the renderings' noise.
    pub(crate) fn difference(&self, mine: &Score, other: &Score) -> [f64; 2] {
        let both = self.groups.iter().zip(mine.groups.iter().zip(&other.groups));
        let contrasts = both.map(|(of, (mine, other))| of.contrast(mine, other));
        contrasts.fold([0.0; 2], |sum, of| [sum[0] + of.difference, sum[1] + of.noise])
    }
}

/// `pixels` under `guess`, twice.
fn render(guess: &Guess<'_>, pixels: &[u32], settings: &Settings) -> [Vec<Rgb>; 2] {
    [0u64, 1].map(|half| {
        let settings = Settings { seed: mix(settings.seed).wrapping_add(half), ..*settings };
        guess.problem.renderer.rerender(guess.appearance(), pixels, &settings)
    })
}

impl GroupScore {
    /// Whether a surface of the same kind reflects more or less than in the `other` by this `share`.
    fn reflects_otherwise(&self, other: &Self, share: f32) -> bool {
        let ((kind, mine), (other_kind, other)) = (self.reflects, other.reflects);
        kind == other_kind
            && (mine - other).abs().max_element() > share * mine.max(other).max_element()
    }

    /// It as one side of a comparison, where the light may be wrong by the `field`.
    fn side<'a>(&'a self, field: &'a LightField) -> Side<'a> {
        Side { residuals: &self.residuals, field, floor: self.least.floor }
    }
}

impl GroupSample {
    /// How well `guess` explains it down to the `least` model error, by two renderings of it.
    fn score(&self, guess: &Guess<'_>, least: Allowance, halves: [Vec<Rgb>; 2]) -> GroupScore {
        let model = halves.map(|half| half.iter().map(|v| *v / guess.exposure).collect());
        let [a, b]: &[Vec<Rgb>; 2] = &model;
        let light: Vec<Rgb> = a.iter().zip(b).map(|(a, b)| 0.5 * (*a + *b)).collect();
        let mut sample = self.sample.clone();
        let share = least.floor.share;
        let (status, smooth) = (&guess.observation.status, sample.blocks.smooth(&light));
        for (seen, &block) in sample.pixels.iter_mut().zip(&sample.blocks.of_pixel) {
            let block = block as usize;
            seen.radiance = guess.value(seen.pixel as usize);
            seen.variance = seen.noise.variance(smooth[block]);
            seen.weight =
                (seen.variance + (share * share) as f32 * seen.level * seen.level).recip();
            if status.pixels()[seen.pixel as usize] == PixelStatus::Outlier {
                seen.reading = Reading::Nothing;
            }
        }
        let residuals = BlockResiduals::over(&sample, &model);
        let residual = residual_stats(&sample.pixels, &model);
        let material = &guess.materials[self.group];
        let reflects = (guess.groups[self.group].hypothesis, material.rho_d + material.rho_s);
        GroupScore { residuals, least, residual, reflects }
    }

    /// Compares two guesses.
    fn contrast(&self, mine: &GroupScore, other: &GroupScore) -> Contrast {
        let fields = [mine, other]
            .map(|of| LightField { least: of.least.light, ..self.sample.field.clone() });
        let sides = [mine.side(&fields[0]), other.side(&fields[1])];
        Contrast::of(&self.sample.blocks, sides.each_ref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observe::model_error::ModelError;

    /// A group of this reflectance that shows one unit of light.
    fn score(kind: Hypothesis, reflectance: f32) -> GroupScore {
        let one = || vec![Rgb::ONE];
        let none = || vec![Rgb::ZERO];
        let residuals = BlockResiduals {
            residual: none(),
            noise: none(),
            rendering: none(),
            half: none(),
            missing: none(),
            level2: one(),
            light: one(),
        };
        GroupScore {
            residuals,
            least: Allowance {
                light: LightError { share: 0.03 },
                floor: ModelError { share: 0.01 },
            },
            residual: ResidualStats::default(),
            reflects: (kind, Rgb::splat(reflectance)),
        }
    }

    #[test]
    fn light_that_a_fit_has_made_up_for_shows_in_what_the_group_reflects() {
        let before = score(Hypothesis::Diffuse, 0.5);
        let twice_the_light = score(Hypothesis::Diffuse, 0.25);
        assert_eq!(twice_the_light.residuals.change_from(&before.residuals), 0.0);
        assert!(twice_the_light.reflects_otherwise(&before, 0.03));
        assert!(!score(Hypothesis::Diffuse, 0.49).reflects_otherwise(&before, 0.03));
        // Surfaces of two kinds reflect different shares of the same light.
        assert!(!score(Hypothesis::Mirror, 1.0).reflects_otherwise(&before, 0.03));
    }
}
