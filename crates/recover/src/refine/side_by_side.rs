//! Hypotheses of one group side by side on the same paths, everything else held.
//!
//! Each is fitted by Gauss-Newton to the group's pixels, and they are compared on other paths ([`super::contenders`]):
//! what one of them gained by the noise of the paths that it was fitted on, it does not gain there. What they leave is
//! weighted as in the joint refinement, and compared by the Bayesian information criterion [Schwarz 1978] with as many
//! observations as blocks are independent of each other. Where the noise of the paths leaves open which one it is, those
//! that it may be are compared by more paths.

use super::contenders::{self, Ground, Left, Rung};
use crate::block_residuals::BlockResiduals;
use crate::contrast::{Contrast, Side};
use crate::effort::Effort;
use crate::model_error::{Allowance, LightError, ModelError};
use crate::problem::Options;
use crate::sample_budget::TOGETHER;
use crate::selection::parameters;
use crate::state::State;
use unrender_render::sampler::mix;
use unrender_render::{Integrator, Settings};

/// Paths in each of two renderings, for fits and again for the comparison: at first, and where the answer is open. With
/// double two rooms take as long, and the same of their groups are right; half of it was not tried.
const PATHS: [u32; 2] = [1 << 16, 1 << 18];
/// What one hypothesis gains beside another counts less so many standard deviations of the paths' noise. Half and double
/// of it were not tried.
const CERTAIN: f64 = 2.0;

/// What the comparison came to.
pub(crate) struct Choice {
    /// Which one it is: the simplest that no other certainly beats.
    pub(crate) chosen: usize,
    /// All of them, where they were fitted last.
    pub(crate) rungs: Vec<Rung>,
    /// The information criterion of each less that of the one that was chosen when they were compared last.
    pub(crate) excess: Vec<f64>,
}

/// The information criterion of one less that of another: what it is, and the least and the most that it may be.
#[derive(Clone, Copy, Default)]
struct Excess {
    value: f64,
    least: f64,
    most: f64,
}

/// How a group's rungs are compared.
pub(crate) struct By<'o> {
    pub(crate) options: &'o Options,
    /// How many paths.
    pub(crate) effort: Effort,
    /// How wrong the model and the others' light may always be.
    pub(crate) allowance: Allowance,
    /// The most that the others' light may be wrong.
    pub(crate) most: LightError,
}

/// What one rung leaves more than another, in units of its covariance, the variance of that by the noise of the paths, and
/// the share of the blocks that are independent of each other.
#[derive(Clone, Copy)]
struct Gain {
    value: f64,
    variance: f64,
    independent: f64,
}

/// Those that are compared.
struct AllLeft<'a> {
    left: &'a [Left],
    ground: &'a Ground,
    floor: ModelError,
}

/// Compares `rungs` of `group`, which go from simple to complex. The group keeps what it is.
pub(crate) fn compare(
    state: &mut State<'_>,
    by: &By<'_>,
    group: usize,
    rungs: Vec<Rung>,
) -> Choice {
    let of_group = &state.groups[group];
    let present =
        Rung { hypothesis: of_group.hypothesis, material: state.materials[group].clone() };
    let starts = rungs.clone();
    let mut competing: Vec<usize> = (0..rungs.len()).collect();
    let mut choice = Choice { chosen: 0, excess: vec![0.0; rungs.len()], rungs };
    for (level, paths) in PATHS.into_iter().enumerate() {
        let settings = Settings {
            first: 0,
            together: TOGETHER,
            spp: by.effort.samples(paths),
            seed: mix(by.options.seed ^ 0xBE51DE ^ ((level as u64) << 32)),
            max_bounces: by.options.max_bounces,
            integrator: Integrator::Path,
        };
        let rungs: Vec<Rung> = competing.iter().map(|i| starts[*i].clone()).collect();
        let allowed = (by.allowance, by.most);
        let (left, ground) = contenders::leave(state, group, rungs, allowed, settings);
        for (i, left) in competing.iter().zip(&left) {
            choice.rungs[*i] = left.rung.clone();
        }
        let all = AllLeft { left: &left, ground: &ground, floor: by.allowance.floor };
        competing = choice.choose(&competing, &all, by.options.thresholds.simpler);
        if competing.len() == 1 {
            break;
        }
    }
    present.put(state, group);
    choice
}

impl Choice {
    /// Chooses among those that are `competing`, by what they left, and returns it with those that may still be better.
    /// With `simpler`, one is preferred whose error is at most so many times the least.
    fn choose(
        &mut self,
        competing: &[usize],
        all: &AllLeft<'_>,
        simpler: Option<f64>,
    ) -> Vec<usize> {
        let n = competing.len();
        let pairs = all.pairs();
        let excess = |i: usize, j: usize| pairs[i][j];
        let behind = |i: usize| (0..n).map(|j| excess(i, j).least).fold(0.0, f64::max);
        let errors: Vec<f64> = (0..n).map(|i| all.error(i)).collect();
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let is_near = |i: usize| simpler.is_some_and(|times| errors[i] <= times * least);
        let (mut chosen, mut lowest) = (0, f64::INFINITY);
        for i in 0..n {
            let behind = behind(i);
            if behind < lowest {
                (chosen, lowest) = (i, behind);
            }
            if is_near(i) || behind <= 0.0 {
                chosen = i;
                break;
            }
        }
        let stands = is_near(chosen);
        let open = |i: &usize| *i > chosen && !stands && excess(chosen, *i).most > 0.0;
        let mut next: Vec<usize> = vec![competing[chosen]];
        next.extend((0..n).filter(open).map(|i| competing[i]));
        for (i, place) in competing.iter().enumerate() {
            self.excess[*place] = excess(i, chosen).value;
        }
        self.chosen = competing[chosen];
        next
    }
}

impl AllLeft<'_> {
    /// The information criterion of each less that of each.
    fn pairs(&self) -> Vec<Vec<Excess>> {
        let n = self.left.len();
        let mut pairs = vec![vec![Excess::default(); n]; n];
        for i in 0..n {
            for j in i + 1..n {
                let Excess { value, least, most } = self.excess([&self.left[i], &self.left[j]]);
                pairs[i][j] = Excess { value, least, most };
                pairs[j][i] = Excess { value: -value, least: -most, most: -least };
            }
        }
        pairs
    }

    /// The information criterion of `a` less that of `b`.
    fn excess(&self, [a, b]: [&Left; 2]) -> Excess {
        let Gain { value, variance, independent } = self.gain([a, b]);
        let [first, second] = [a, b].map(|left| parameters(left.rung.hypothesis));
        let count = (independent * self.ground.blocks.len() as f64).max(1.0);
        // Each is taken as good as it is without the noise of its fit. What that costs is a sum of squares.
        let gain = value + b.loss - a.loss;
        let variance = variance + 2.0 * (a.loss + b.loss);
        let value = independent * gain + (first - second) * count.ln();
        let uncertain = CERTAIN * independent * variance.sqrt();
        Excess { value, least: value - uncertain, most: value + uncertain }
    }

    /// What `a` leaves more than `b`. On paths that carry both, most of their noise is common to both; else each may be
    /// compared with the simplest one on its own paths, which carry that too.
    fn gain(&self, [a, b]: [&Left; 2]) -> Gain {
        let on = |a: &Left, of_a: usize, b: &Left, of_b: usize| {
            let both = [a.residuals[of_a].as_ref()?, b.residuals[of_b].as_ref()?];
            Some(self.gain_of(both))
        };
        let common = [b.drawn, a.drawn].into_iter().find_map(|drawn| on(a, drawn, b, drawn));
        let simplest = &self.left[0];
        let beside_simplest = |left: &Left| on(left, left.drawn, simplest, left.drawn);
        let apart = || {
            let direct = on(a, a.drawn, b, b.drawn).unwrap_or(Gain::UNKNOWN);
            let (Some(a), Some(b)) = (beside_simplest(a), beside_simplest(b)) else {
                return direct;
            };
            let by = Gain {
                value: a.value - b.value,
                variance: a.variance + b.variance,
                independent: direct.independent,
            };
            if by.variance < direct.variance { by } else { direct }
        };
        common.unwrap_or_else(apart)
    }

    fn gain_of(&self, both: [&BlockResiduals; 2]) -> Gain {
        let (field, floor) = (&self.ground.field, self.floor);
        let sides = both.map(|residuals| Side { residuals, field, floor });
        let contrast = Contrast::of(&self.ground.blocks, sides.each_ref());
        Gain {
            value: contrast.difference,
            variance: contrast.noise,
            independent: contrast.independent,
        }
    }

    /// The relative error of one.
    fn error(&self, i: usize) -> f64 {
        let left = &self.left[i];
        let Some(residuals) = &left.residuals[left.drawn] else { return f64::INFINITY };
        let [a, b] = residuals.halves();
        let square = a.iter().zip(&b).map(|(a, b)| f64::from((*a * *b).element_sum())).sum::<f64>();
        let light: f64 = residuals.light.iter().map(|v| f64::from((*v * *v).element_sum())).sum();
        (square.max(0.0) / light.max(f64::MIN_POSITIVE)).sqrt()
    }
}

impl Gain {
    /// Nothing is known.
    const UNKNOWN: Self = Self { value: 0.0, variance: f64::INFINITY, independent: 1.0 };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::{Blocks, Grid};
    use crate::hypothesis::Hypothesis;
    use crate::model_error::LightField;
    use unrender_scene::{Material, Rgb};

    const SIDE: usize = 16;

    /// A number for `i`, uniform from -1 to 1.
    fn scatter(i: usize) -> f32 {
        (mix(i as u64) >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }

    /// The residuals of a model that is wrong by a pattern of the size `wrong`, with the noise number `noise` of its
    /// renderings, a tenth of the light.
    fn residuals(wrong: f32, noise: usize) -> BlockResiduals {
        let n = SIDE * SIDE;
        let of_half = |half: usize, k: usize| 0.1 * scatter(7919 * (2 * noise + half) + 31 * k);
        let residual =
            |k: usize| wrong * (0.9 * k as f32).sin() - 0.5 * (of_half(0, k) + of_half(1, k));
        let half = |k: usize| 0.5 * (of_half(0, k) - of_half(1, k));
        BlockResiduals {
            residual: (0..n).map(|k| Rgb::splat(residual(k))).collect(),
            noise: vec![Rgb::splat(0.002); n],
            rendering: vec![Rgb::splat(0.0017); n],
            half: (0..n).map(|k| Rgb::splat(half(k))).collect(),
            missing: vec![Rgb::ZERO; n],
            level2: vec![Rgb::ONE; n],
            light: vec![Rgb::ONE; n],
        }
    }

    /// What a rung leaves, which was fitted on the paths number `drawn`, on each of these.
    fn left(
        hypothesis: Hypothesis,
        drawn: usize,
        residuals: impl IntoIterator<Item = Option<BlockResiduals>>,
    ) -> Left {
        let rung = Rung { hypothesis, material: Material::diffuse(Rgb::ONE) };
        let residuals = residuals.into_iter().collect();
        Left { rung, drawn, radiance: Vec::new(), residuals, loss: 0.0 }
    }

    /// What is chosen of `left`, and those that it may be.
    fn chosen(left: &[Left]) -> (usize, Vec<usize>) {
        let pixels: Vec<u32> = (0..(SIDE * SIDE) as u32).collect();
        let blocks = Blocks::of(&pixels, &Grid::even(SIDE, 1));
        let field = LightField::constant(blocks.len(), LightError { share: 0.001 });
        let ground = Ground::new(blocks, field);
        let all = AllLeft { left, ground: &ground, floor: ModelError { share: 0.003 } };
        let rungs: Vec<Rung> = left.iter().map(|left| left.rung.clone()).collect();
        let excess = vec![0.0; rungs.len()];
        let mut choice = Choice { chosen: 0, rungs, excess };
        let competing: Vec<usize> = (0..left.len()).collect();
        let next = choice.choose(&competing, &all, None);
        (choice.chosen, next)
    }

    #[test]
    fn noise_that_two_have_in_common_cancels() {
        let wrong = 0.025;
        // The simple one is wrong by half of the noise, and that is certain where both have the same.
        let simple = left(Hypothesis::Diffuse, 0, [Some(residuals(wrong, 1))]);
        let complex = left(Hypothesis::Isotropic, 0, [Some(residuals(0.0, 1))]);
        assert_eq!(chosen(&[simple, complex]), (1, vec![1]));
        // It is not where each has its own, and the simple one stands until there are more paths.
        let simple = left(Hypothesis::PartialMirror, 0, [Some(residuals(wrong, 1)), None]);
        let complex = left(Hypothesis::Isotropic, 1, [None, Some(residuals(0.0, 2))]);
        assert_eq!(chosen(&[simple, complex]), (0, vec![0, 1]));
    }

    #[test]
    fn those_on_other_paths_are_compared_by_what_both_have() {
        // A mirror and a lobe on paths of their own, which both carry what is diffuse.
        let of_diffuse = [1, 2].map(|noise| Some(residuals(0.025, noise)));
        let diffuse = left(Hypothesis::Diffuse, 1, of_diffuse);
        let mirror = left(Hypothesis::PartialMirror, 0, [Some(residuals(0.025, 1)), None]);
        let lobe = left(Hypothesis::Isotropic, 1, [None, Some(residuals(0.0, 2))]);
        assert_eq!(chosen(&[diffuse, mirror, lobe]), (2, vec![2]));
    }

    #[test]
    fn what_is_no_better_is_not_taken_for_being_more() {
        let simple = left(Hypothesis::Diffuse, 0, [Some(residuals(0.0, 1))]);
        let complex = left(Hypothesis::Anisotropic, 0, [Some(residuals(0.0, 1))]);
        assert_eq!(chosen(&[simple, complex]), (0, vec![0]));
    }
}
