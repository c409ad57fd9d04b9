//! Verification: is one state of the recovery better than another, judged by the whole picture?
//!
//! A sample of every group's pixels is rendered again, with all interreflection and without any cache,
//! always the same pixels and the same random numbers, so that two states differ by what they are and
//! not by noise. Each group counts by the deviance of its blocks under the observation model
//! ([`crate::model_error`]), its share of model error being estimated: what one group gains does not
//! drown in what another has always lacked. Residuals are in units of the photograph's values, so
//! that states of different exposure can be compared. A group whose hypothesis became more complex is
//! asked by itself too: its own pixels have to bear the change out.

use crate::blocks::{self, Blocks};
use crate::evidence::spread;
use crate::hypothesis::Hypothesis;
use crate::model_error::level2;
use crate::observation::{PixelStatus, Reading};
use crate::problem::{Options, Role};
use crate::residual::deviation_of_sum;
use crate::state::{Snapshot, State};
use serde::{Deserialize, Serialize};
use unrender_render::Settings;
use unrender_render::sampler::mix;
use unrender_scene::Rgb;

/// Pixels of a group that are rendered again, and paths a pixel in each of two halves. At half of
/// either, changes below a percent of a group's light are missed; double costs more than an
/// iteration.
const PIXELS: usize = 1200;
const SPP: u32 = 12;
/// A state is worse if its deviance is higher by this many standard deviations of the difference.
const WORSE: f64 = 3.0;
/// The share of model error below which nothing is told from anything: while hypotheses change, the
/// other groups follow on few light samples, and their errors of this size say nothing of the change.
/// After the refinement the light is better known. At half of it right changes are taken back because
/// of noise in other groups; at double wrong ones of faint lobes pass.
pub(crate) const FLOOR: f64 = 0.02;
pub(crate) const REFINED_FLOOR: f64 = 0.01;
/// What a change of one group's hypothesis does to its own pixels is asked down to this share: it was
/// fitted in this light. At half of it the noise of the renderings speaks, at double faint lobes are
/// taken back.
const OWN_FLOOR: f64 = 0.005;
/// Two models that are less far apart than this (three standard deviations, squared) are not told apart
/// by the sample. At half of it chance takes faint lobes back, at double it lets wrong ones pass.
const UNDECIDED: f64 = 9.0;
/// A texture explains whatever it is asked to: what it explains beyond this share does not count.
const TEXTURED_FLOOR: f64 = 0.05;
/// What an outlier costs, in squared standard deviations of its block: the same under all states.
const OUTLIER: f64 = 9.0;

/// The pixels by which states are judged.
pub(crate) struct Verifier {
    groups: Vec<Sample>,
    settings: Settings,
    /// The share of model error below which nothing counts.
    pub(crate) floor: f64,
}

/// Those of one group.
struct Sample {
    group: usize,
    pixels: Vec<u32>,
    blocks: Blocks,
    /// The squared level of every block, in the photograph's values.
    level2: Vec<Rgb>,
}

/// How well a state explains the photograph.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Score {
    groups: Vec<GroupScore>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct GroupScore {
    group: usize,
    blocks: Vec<Block>,
    /// The share of model error below which nothing counts.
    floor: f64,
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
        let width = observation.picture.values.width();
        let sample = |group: usize| {
            let valid = &observation.pixels_of_group[group];
            let pixels = spread(valid, PIXELS, mix(options.seed ^ 0x7E57) ^ group as u64);
            let blocks = Blocks::of(&pixels, width, blocks::side(valid.len(), pixels.len()));
            let values: Vec<Rgb> =
                pixels.iter().map(|&p| observation.picture.values.pixels()[p as usize]).collect();
            let mean = values.iter().sum::<Rgb>() / values.len().max(1) as f32;
            let level2 = blocks.smooth(&values).iter().map(|local| level2(mean, *local)).collect();
            Sample { group, pixels, blocks, level2 }
        };
        let groups = (0..state.materials.len()).filter(judged).map(sample);
        let seed = mix(options.seed ^ 0x5C04E);
        Self {
            groups: groups.filter(|sample| !sample.pixels.is_empty()).collect(),
            settings: Settings {
                spp: SPP,
                seed,
                max_bounces: options.max_bounces,
                integrator: unrender_render::Integrator::Path,
            },
            floor: FLOOR.max(options.thresholds.explained),
        }
    }

    /// Renders the sample in `state`, and keeps the state with its score.
    pub(crate) fn verify(&self, state: &State<'_>) -> Verified {
        let score = state.steps.value("verification", || self.score(state));
        Verified { snapshot: state.snapshot(), score }
    }

    /// How well `state` explains the photograph.
    pub(crate) fn score(&self, state: &State<'_>) -> Score {
        let all: Vec<u32> = self.groups.iter().flat_map(|s| s.pixels.iter().copied()).collect();
        let halves = [0u64, 1].map(|half| {
            let seed = mix(self.settings.seed).wrapping_add(half);
            let settings = Settings { seed, ..self.settings };
            state.problem.renderer.rerender(state.appearance(), &all, &settings)
        });
        let mut start = 0;
        let of_group = |sample: &Sample| {
            let range = start..start + sample.pixels.len();
            start = range.end;
            self.group(state, sample, halves.each_ref().map(|half| &half[range.clone()]))
        };
        Score { groups: self.groups.iter().map(of_group).collect() }
    }

    fn group(&self, state: &State<'_>, sample: &Sample, halves: [&[Rgb]; 2]) -> GroupScore {
        let observation = &state.observation;
        let (blocks, n) = (&sample.blocks, sample.pixels.len());
        let model = halves.map(|h| h.iter().map(|v| *v / state.exposure).collect::<Vec<Rgb>>());
        let value = |i: usize| state.value(sample.pixels[i] as usize);
        let residual: Vec<Rgb> =
            (0..n).map(|i| value(i) - 0.5 * (model[0][i] + model[1][i])).collect();
        let light: Vec<Rgb> = (0..n).map(|i| 0.5 * (model[0][i] + model[1][i])).collect();
        let smooth = blocks.smooth(&light);
        let variance: Vec<Rgb> = (0..n)
            .map(|i| {
                let noise = observation.noise(sample.group, sample.pixels[i], Rgb::ONE);
                let halves = model[0][i] - model[1][i];
                noise.variance(smooth[blocks.of_pixel[i] as usize]) + 0.25 * halves * halves
            })
            .collect();
        let counts = |i: usize| {
            let at = sample.pixels[i];
            let outlier = observation.status.pixels()[at as usize] == PixelStatus::Outlier;
            !outlier && observation.reading(at) == Reading::Value
        };
        let mut valid = vec![0u32; blocks.len()];
        (0..n).filter(|i| counts(*i)).for_each(|i| valid[blocks.of_pixel[i] as usize] += 1);
        let half: Vec<Rgb> = (0..n).map(|i| 0.5 * (model[0][i] - model[1][i])).collect();
        let half = blocks.mean_where(&half, counts);
        let residual = blocks.mean_where(&residual, counts);
        let variance = blocks.mean_where(&variance, counts);
        let terms: Vec<Block> = (0..blocks.len())
            .map(|k| Block {
                outlier: 2 * valid[k] < blocks.sizes[k],
                residual: residual[k],
                half: half[k],
                noise: variance[k] / valid[k].max(1) as f32,
                level2: sample.level2[k],
            })
            .collect();
        let textured = state.groups[sample.group].hypothesis == Hypothesis::Textured;
        let floor = if textured { TEXTURED_FLOOR.max(self.floor) } else { self.floor };
        GroupScore { group: sample.group, blocks: terms, floor }
    }
}

/// One block of one group.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Block {
    outlier: bool,
    residual: Rgb,
    /// The first half's rendering less the mean of both.
    half: Rgb,
    noise: Rgb,
    level2: Rgb,
}

impl Block {
    /// Photograph less each of the two renderings.
    fn residuals(&self) -> [Rgb; 2] {
        [self.residual - self.half, self.residual + self.half]
    }

    /// Minus twice the logarithm of its likelihood, but for a constant.
    fn deviance(&self, share: f64) -> f64 {
        (0..3)
            .map(|c| {
                let at = |v: Rgb| f64::from(v[c]);
                let model = share * share * at(self.level2);
                let variance = (at(self.noise) + model).max(f64::MIN_POSITIVE);
                let square = at(self.residual).powi(2) / variance;
                variance.ln() + if self.outlier { OUTLIER } else { square }
            })
            .sum()
    }
}

/// The share of model error that makes the blocks most likely, and their deviances under it.
fn most_likely(terms: &[Block], floor: f64) -> (f64, Vec<f64>) {
    let (mut best, mut lowest, mut share) = ((floor, Vec::new()), f64::INFINITY, floor);
    while share < 4.0 {
        let deviances: Vec<f64> = terms.iter().map(|term| term.deviance(share)).collect();
        let sum = deviances.iter().sum();
        if sum < lowest {
            (best, lowest) = ((share, deviances), sum);
        }
        share *= 1.25;
    }
    best
}

impl GroupScore {
    /// How far the two models are apart, squared, in units of the residuals' variance: what the better
    /// one of them gains on the mean. The product of the two halves' differences is free of the
    /// renderings' noise.
    fn separation(&self, other: &Self) -> f64 {
        let share = most_likely(&self.with_noise_of(other), self.floor).0;
        let both = self.blocks.iter().zip(&other.blocks).filter(|(a, b)| !a.outlier && !b.outlier);
        let terms = both.map(|(a, b)| {
            let variance = a.noise.max(b.noise) + (share * share) as f32 * a.level2;
            let weight = variance.max(Rgb::splat(f32::MIN_POSITIVE)).recip();
            let [mine, others] = [a.residuals(), b.residuals()];
            f64::from((weight * (mine[0] - others[0]) * (mine[1] - others[1])).element_sum())
        });
        terms.sum()
    }

    /// Its blocks, each with the larger one of its noise and that under `other`.
    fn with_noise_of(&self, other: &Self) -> Vec<Block> {
        let larger = |(a, b): (&Block, &Block)| Block { noise: a.noise.max(b.noise), ..a.clone() };
        self.blocks.iter().zip(&other.blocks).map(larger).collect()
    }

    /// The deviance of each block less that under `other`. Both have the larger one of the two
    /// rendering noises: that one of them happens to be sampled well is no evidence for it.
    fn differences(&self, other: &Self) -> Vec<f64> {
        let mine = most_likely(&self.with_noise_of(other), self.floor).1;
        let others = most_likely(&other.with_noise_of(self), other.floor).1;
        mine.iter().zip(&others).map(|(a, b)| a - b).collect()
    }
}

impl Score {
    /// Whether the picture speaks against this state, beside `other`.
    pub(crate) fn is_worse_than(&self, other: &Self) -> bool {
        let both = self.groups.iter().zip(&other.groups);
        let differences: Vec<f64> = both.flat_map(|(a, b)| a.differences(b)).collect();
        let sum: f64 = differences.iter().sum();
        sum > WORSE * deviation_of_sum(&differences)
    }

    /// Whether the picture of `groups` alone is explained better than by `other`.
    pub(crate) fn gains(&self, other: &Self, groups: &[usize]) -> bool {
        let both = self.groups.iter().zip(&other.groups).filter(|(a, _)| groups.contains(&a.group));
        both.flat_map(|(a, b)| a.differences(b)).sum::<f64>() < 0.0
    }

    /// Whether the picture of `group` bears out this state beside `other`: it is explained better, by
    /// more than the standard deviation of the difference (a highlight fills few blocks, whose sum is
    /// known no better than that), or the sample is too small to tell the two apart.
    pub(crate) fn bears_out(&self, other: &Self, group: usize) -> bool {
        let mut both = self.groups.iter().zip(&other.groups);
        let Some((mine, other)) = both.find(|(a, _)| a.group == group) else { return true };
        let finer =
            |score: &GroupScore| GroupScore { floor: score.floor.min(OWN_FLOOR), ..score.clone() };
        let (mine, other) = (finer(mine), finer(other));
        let differences = mine.differences(&other);
        mine.separation(&other) < UNDECIDED
            || differences.iter().sum::<f64>() < -deviation_of_sum(&differences)
    }
}
