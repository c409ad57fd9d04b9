//! Hypotheses of one group side by side on the same paths, everything else held.
//!
//! Each is fitted by Gauss-Newton to the group's pixels, and they are compared on other paths ([`super::contenders`]):
//! what one of them gained by the noise of the paths that it was fitted on, it does not gain there. Their residuals are
//! compared under the observation model ([`crate::compare`]) and one is chosen as always ([`crate::selection`]), with
//! the independent blocks as observations. Where the noise of the paths leaves the choice open, those that remain are
//! compared on more paths.

use super::contenders::{self, Contender, Rung};
use crate::compare::Difference;
use crate::compare::{Contrast, Side};
use crate::effort::Effort;
use crate::guess::Guess;
use crate::observe::model_error::{Allowance, ModelError};
use crate::observe::sample::Sample;
use crate::problem::Options;
use crate::sample_budget;
use crate::selection::{self, Choice, parameters};
use crate::streams::Stream;

/// Paths in each of two renderings, for fits and again for the comparison: at first, and where the answer is open. With
/// double, two rooms take as long and have the same groups right; half of it was not tried.
const PATHS: [u32; 2] = [1 << 16, 1 << 18];

/// The rungs of a group, compared.
pub(crate) struct Compared {
    /// All of them, as they were fitted last.
    pub(crate) rungs: Vec<Rung>,
    /// Which one, by their last comparison.
    pub(crate) choice: Choice,
}

/// How a group's rungs are compared.
pub(crate) struct Criteria<'o> {
    pub(crate) options: &'o Options,
    /// How many paths.
    pub(crate) effort: Effort,
    /// How much error of the model and the others' light is always allowed for.
    pub(crate) allowance: Allowance,
}

/// Those that are compared.
struct Contenders<'a> {
    all: &'a [Contender],
    sample: &'a Sample,
    floor: ModelError,
}

/// Compares `rungs` of `group`, which go from simple to complex. If no pixel shows it, the simplest is chosen.
pub(crate) fn compare(
    guess: &Guess<'_>,
    by: &Criteria<'_>,
    group: usize,
    rungs: Vec<Rung>,
) -> Compared {
    let starts = rungs.clone();
    let mut competing: Vec<usize> = (0..rungs.len()).collect();
    let excess = vec![Difference::default(); rungs.len()];
    let choice = Choice { chosen: 0, excess, open: Vec::new() };
    let mut compared = Compared { rungs, choice };
    if guess.observation.informative_of_group[group].is_empty() {
        return compared;
    }
    for (level, paths) in PATHS.into_iter().enumerate() {
        let spp = guess.observation.sheet.of_all(by.effort.samples(paths) as usize) as u32;
        let seed = Stream::SideBySide.seed(by.options.seed ^ ((level as u64) << 32));
        let settings = sample_budget::paths(spp, seed, by.options);
        let rungs: Vec<Rung> = competing.iter().map(|i| starts[*i].clone()).collect();
        let (found, sample) =
            contenders::fit_and_render(guess, group, rungs, by.allowance, settings);
        for (i, contender) in competing.iter().zip(&found) {
            compared.rungs[*i] = contender.rung.clone();
        }
        let found = Contenders { all: &found, sample: &sample, floor: by.allowance.floor };
        let choice = &mut compared.choice;
        found.choose(&competing, choice, by.options.thresholds.simpler);
        if choice.open.is_empty() {
            break;
        }
        competing = std::iter::once(choice.chosen).chain(choice.open.iter().copied()).collect();
    }
    compared
}

impl Contenders<'_> {
    /// Changes the `choice` to one among the `competing` ones, which these are. With `simpler`, the simplest is preferred
    /// whose error is at most so many times the least.
    fn choose(&self, competing: &[usize], choice: &mut Choice, simpler: Option<f64>) {
        let errors: Vec<f64> = (0..competing.len()).map(|i| self.error(i)).collect();
        let pairs = self.pairs();
        let (chosen, open) = selection::choose(&errors, simpler, |i, j| pairs[i][j]);
        for (i, place) in competing.iter().enumerate() {
            choice.excess[*place] = pairs[i][chosen];
        }
        choice.chosen = competing[chosen];
        choice.open = open.into_iter().map(|i| competing[i]).collect();
    }

    /// The information criterion of each less that of each.
    fn pairs(&self) -> Vec<Vec<Difference>> {
        let n = self.all.len();
        let mut pairs = vec![vec![Difference::default(); n]; n];
        for i in 0..n {
            for j in i + 1..n {
                let excess = self.excess([&self.all[i], &self.all[j]]);
                (pairs[i][j], pairs[j][i]) = (excess, -excess);
            }
        }
        pairs
    }

    /// The information criterion of `a` less that of `b`.
    fn excess(&self, [a, b]: [&Contender; 2]) -> Difference {
        let Some(Contrast { difference, noise, independent, .. }) = self.contrast([a, b]) else {
            return Difference { value: 0.0, deviation: f64::INFINITY, price: 0.0 };
        };
        let [first, second] = [a, b].map(|of| parameters(of.rung.hypothesis, &of.rung.material));
        let count = (independent * self.sample.blocks.len() as f64).max(1.0);
        // Each is compared without the loss by the noise of its fit, which is a sum of squares.
        let corrected = difference + b.loss - a.loss;
        let variance = noise + 2.0 * (a.loss + b.loss);
        let price = (first - second) * count.ln();
        let value = independent * corrected + price;
        Difference { value, deviation: independent * variance.sqrt(), price }
    }

    /// How much more `a` leaves than `b`. On paths that carry both, most of their noise is common to both; else each is
    /// compared with the simplest one on its own paths, which carry that too.
    fn contrast(&self, [a, b]: [&Contender; 2]) -> Option<Contrast> {
        let on = |a: &Contender, of_a: usize, b: &Contender, of_b: usize| {
            let both = [a.residuals[of_a].as_ref()?, b.residuals[of_b].as_ref()?];
            let (field, floor) = (&self.sample.field, self.floor);
            let sides = both.map(|residuals| Side { residuals, field, floor });
            Some(Contrast::of(&self.sample.blocks, sides.each_ref()))
        };
        let common = [b.drawn, a.drawn].into_iter().find_map(|drawn| on(a, drawn, b, drawn));
        if common.is_some() {
            return common;
        }
        let direct = on(a, a.drawn, b, b.drawn);
        let beside_simplest = |of: &Contender| on(of, of.drawn, &self.all[0], of.drawn);
        let Some((of_a, of_b)) = beside_simplest(a).zip(beside_simplest(b)) else { return direct };
        let independent = direct.as_ref().map_or(1.0, |direct| direct.independent);
        let by = Contrast {
            difference: of_a.difference - of_b.difference,
            noise: of_a.noise + of_b.noise,
            independent,
            ..of_a
        };
        Some(direct.filter(|direct| direct.noise <= by.noise).unwrap_or(by))
    }

    /// The relative error of one.
    fn error(&self, i: usize) -> f64 {
        let contender = &self.all[i];
        let Some(residuals) = &contender.residuals[contender.drawn] else { return f64::INFINITY };
        let [a, b] = residuals.halves();
        let square = a.iter().zip(&b).map(|(a, b)| f64::from((*a * *b).element_sum())).sum::<f64>();
        let light: f64 = residuals.light.iter().map(|v| f64::from((*v * *v).element_sum())).sum();
        (square.max(0.0) / light.max(f64::MIN_POSITIVE)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::residual::BlockResiduals;
    use crate::hypothesis::Hypothesis;
    use crate::observe::blocks::{Blocks, Grid};
    use crate::observe::model_error::LightError;
    use crate::observe::model_error::LightField;
    use unrender_render::sampler::mix;
    use unrender_scene::Sheet;
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

    /// A rung that was fitted on the paths number `drawn`, with its residuals on each of all.
    fn left(
        hypothesis: Hypothesis,
        drawn: usize,
        residuals: impl IntoIterator<Item = Option<BlockResiduals>>,
    ) -> Contender {
        let rung = Rung { hypothesis, material: Material::diffuse(Rgb::ONE) };
        let residuals = residuals.into_iter().collect();
        Contender { rung, drawn, radiance: Vec::new(), residuals, loss: 0.0 }
    }

    /// The chosen one of `left`, and those that stay open.
    fn chosen(left: &[Contender]) -> (usize, Vec<usize>) {
        let pixels: Vec<u32> = (0..(SIDE * SIDE) as u32).collect();
        let blocks = Blocks::of(&pixels, &Grid::even(&Sheet::of(&[(SIDE, SIDE)]), 1));
        let field = LightField::constant(blocks.len(), LightError { share: 0.001 });
        let sample = Sample { pixels: Vec::new(), blocks, field };
        let found = Contenders { all: left, sample: &sample, floor: ModelError { share: 0.003 } };
        let excess = vec![Difference::default(); left.len()];
        let mut choice = Choice { chosen: 0, excess, open: Vec::new() };
        let competing: Vec<usize> = (0..left.len()).collect();
        found.choose(&competing, &mut choice, None);
        (choice.chosen, choice.open)
    }

    #[test]
    fn noise_that_two_have_in_common_cancels() {
        let wrong = 0.025;
        // The simple one is wrong by half of the noise, and that is certain where both have the same.
        let simple = left(Hypothesis::Diffuse, 0, [Some(residuals(wrong, 1))]);
        let complex = left(Hypothesis::Isotropic, 0, [Some(residuals(0.0, 1))]);
        assert_eq!(chosen(&[simple, complex]), (1, vec![]));
        // It is not where each has its own, and the simple one stays until there are more paths.
        let simple = left(Hypothesis::PartialMirror, 0, [Some(residuals(wrong, 1)), None]);
        let complex = left(Hypothesis::Isotropic, 1, [None, Some(residuals(0.0, 2))]);
        assert_eq!(chosen(&[simple, complex]), (0, vec![1]));
    }

    #[test]
    fn those_on_other_paths_are_compared_by_what_both_have() {
        // A mirror and a lobe on paths of their own, which both carry what is diffuse.
        let of_diffuse = [1, 2].map(|noise| Some(residuals(0.025, noise)));
        let diffuse = left(Hypothesis::Diffuse, 1, of_diffuse);
        let mirror = left(Hypothesis::PartialMirror, 0, [Some(residuals(0.025, 1)), None]);
        let lobe = left(Hypothesis::Isotropic, 1, [None, Some(residuals(0.0, 2))]);
        assert_eq!(chosen(&[diffuse, mirror, lobe]), (2, vec![]));
    }

    #[test]
    fn what_is_no_better_is_not_taken_for_being_more() {
        let simple = left(Hypothesis::Diffuse, 0, [Some(residuals(0.0, 1))]);
        let complex = left(Hypothesis::Anisotropic, 0, [Some(residuals(0.0, 1))]);
        assert_eq!(chosen(&[simple, complex]), (0, vec![]));
    }
}
