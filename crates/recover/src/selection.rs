//! Model selection: the simplest hypothesis whose residual is statistically indistinguishable from
//! the best.
//!
//! A pure step: fits of one group on the same evidence go in, a choice with its numbers comes out.
//! Hypotheses are compared by the Bayesian information criterion [Schwarz 1978]
//! `IC = (N_eff / N) D + p ln N_eff`, with `p` free parameters. `D` is the sum of the squared residuals in
//! units of their covariance, the same for both of the hypotheses that are compared
//! ([`crate::compare`]); `N` is the number of blocks and `N_eff` the number of independent ones among
//! them, from the correlation `r` of neighbouring blocks' residuals under the best hypothesis:
//! `N_eff = N ((1 - r) / (1 + r))^2`.
//!
//! Noise is no reason for a more complex one: of two whose difference is within the noise the simpler one is chosen,
//! and a more complex one never where a simpler one is expected to be better. Nor is noise a reason to give up the present
//! one, which was chosen by other samples: it stays where no simpler one is expected to be better.

use crate::compare::{Difference, STRONG, difference, independent_blocks};
use crate::evidence::Evidence;
use crate::hypothesis::{Fit, Hypothesis, parameters};
use std::collections::BTreeMap;
use unrender_scene::{Material, Rgb};

/// What was chosen for one group, and by which numbers.
#[derive(Clone, Debug)]
pub(crate) struct Choice {
    /// The index of the fit to take.
    pub(crate) chosen: usize,
    /// For each fit: its information criterion less that of the chosen one.
    pub(crate) excess: Vec<Difference>,
    /// Those that may turn out to be better with less noise of the light, by index.
    pub(crate) open: Vec<usize>,
}

/// Sorts `fits` from simple to complex, those with as many numbers as they were: a plastic, whose lobe has one number, and a
/// lobe without colour, which has two, come before a mirror over a base. A perfect mirror, which has none, stays behind a
/// diffuse surface: noisy light beats no hypothesis without numbers.
pub(crate) fn sort(fits: &mut [Fit]) {
    let diffuse = parameters(Hypothesis::Diffuse, &Material::diffuse(Rgb::ZERO));
    let numbers = |fit: &Fit| parameters(fit.hypothesis, &fit.material).max(diffuse);
    fits.sort_by(|a, b| numbers(a).total_cmp(&numbers(b)));
}

/// The comparison of all fits of one group on the same evidence, pair by pair.
pub(crate) struct Comparison<'a> {
    fits: &'a [Fit],
    evidence: &'a Evidence,
    independent: f64,
    /// The criterion of a fit less that of another, where it was asked for.
    differences: BTreeMap<(usize, usize), Difference>,
}

impl<'a> Comparison<'a> {
    /// For `fits`, of which there is at least one and which go from simple to complex.
    pub(crate) fn new(fits: &'a [Fit], evidence: &'a Evidence) -> Self {
        let deviance = |fit: &&Fit| fit.likelihood.deviance;
        let best = fits.iter().min_by(|a, b| deviance(a).total_cmp(&deviance(b)));
        let independent = best.map_or(1.0, |best| independent_blocks(best.explained(), evidence));
        Self { fits, evidence, independent, differences: BTreeMap::new() }
    }

    /// Chooses the simplest fit that no other certainly beats, or the `present` one if that is such and expected to be better.
    /// With `simpler`, the simplest is preferred whose error is at most so many times the least.
    pub(crate) fn choose(&mut self, present: Hypothesis, simpler: Option<f64>) -> Choice {
        let errors: Vec<f64> = self.fits.iter().map(|fit| fit.residual.relative()).collect();
        let present = self.fits.iter().position(|fit| fit.hypothesis == present);
        let (chosen, open) = choose(&errors, (present, simpler), |i, j| self.excess(i, j));
        let excess = (0..self.fits.len()).map(|i| self.excess(i, chosen)).collect();
        Choice { chosen, excess, open }
    }

    /// The information criterion of fit `i` less that of fit `j`, under their common noise.
    fn excess(&mut self, i: usize, j: usize) -> Difference {
        if i == j {
            return Difference::default();
        }
        if i > j {
            return -self.excess(j, i);
        }
        if let Some(known) = self.differences.get(&(i, j)) {
            return *known;
        }
        let [a, b] = [&self.fits[i], &self.fits[j]];
        let parameters =
            parameters(a.hypothesis, &a.material) - parameters(b.hypothesis, &b.material);
        let sides = [a, b].map(Fit::explained);
        let mut difference = difference(sides, self.evidence, self.independent);
        difference.price = parameters * self.independent.max(1.0).ln();
        difference.value += difference.price;
        self.differences.insert((i, j), difference);
        difference
    }
}

/// Chooses among hypotheses, which go from simple to complex and have these `errors`, by the `excess` of the first of two
/// over the second: the simplest one that no other certainly beats, of those that are expected to be better than all
/// simpler ones; or the `present` one if it is such. With `simpler`, the simplest is preferred whose error is at most so many
/// times the least. Returns it, and those that less noise may show to be better: more complex ones, and the simplest one
/// that the present one is preferred to.
pub(crate) fn choose(
    errors: &[f64],
    (present, simpler): (Option<usize>, Option<f64>),
    mut excess: impl FnMut(usize, usize) -> Difference,
) -> (usize, Vec<usize>) {
    let n = errors.len();
    let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
    let (mut simplest, mut lowest) = (0, f64::INFINITY);
    let mut chosen = None;
    for (i, error) in errors.iter().enumerate() {
        if (0..i).any(|j| excess(i, j).value > 0.0) {
            continue;
        }
        let behind = (0..n).map(|j| excess(i, j).least()).fold(0.0, f64::max);
        let is_enough = simpler.is_some_and(|times| *error <= times * least);
        if chosen.is_none() && (is_enough || behind < lowest) {
            (simplest, lowest) = (i, behind);
        }
        if is_enough || behind <= 0.0 {
            let is_present = simpler.is_none() && present == Some(i);
            chosen = if is_present { Some(i) } else { chosen.or(Some(i)) };
        }
    }
    let chosen = chosen.unwrap_or(simplest);
    let mut open: Vec<usize> =
        (chosen + 1..n).filter(|i| excess(chosen, *i).most() > 0.0).collect();
    if simplest < chosen {
        open.push(simplest);
    }
    (chosen, open)
}

/// Whether there is no strong evidence that `fit` explains less than `best`.
pub fn explains_alike(fit: &Fit, best: &Fit, evidence: &Evidence) -> bool {
    let [fit, best] = [fit, best].map(Fit::explained);
    difference([fit, best], evidence, independent_blocks(best, evidence)).least() <= STRONG
}

#[cfg(test)]
mod tests {
    use super::{Difference, choose, sort};
    use crate::compare::likelihood::Likelihood;
    use crate::compare::residual::{BlockResiduals, ResidualStats};
    use crate::hypothesis::{Fit, Hypothesis};
    use crate::observe::model_error::{LightError, ModelError};
    use unrender_scene::reflectance::{IOR, Layering};
    use unrender_scene::{Material, Rgb};

    /// Chooses among hypotheses with these criteria, where comparisons with the one number `noisy` have a deviation of 30
    /// and others one of 2.
    fn chosen(criteria: &[f64], noisy: usize, present: Option<usize>) -> (usize, Vec<usize>) {
        let excess = |i: usize, j: usize| Difference {
            value: criteria[i] - criteria[j],
            deviation: if i == noisy || j == noisy { 30.0 } else { 2.0 },
            price: 0.0,
        };
        choose(&vec![1.0; criteria.len()], (present, None), excess)
    }

    #[test]
    fn noise_is_no_reason_for_more() {
        // Nothing certainly beats the second one, which is expected to be worse than the first; the third beats that.
        assert_eq!(chosen(&[25.0, 42.0, 0.0], 1, None), (2, vec![]));
        // The second one is expected to be better, and noise leaves that open.
        assert_eq!(chosen(&[25.0, 0.0], 1, None), (0, vec![1]));
        assert_eq!(chosen(&[25.0, 0.0], 2, None), (1, vec![]));
    }

    #[test]
    fn noise_is_no_reason_to_give_up_what_is_expected_to_be_better() {
        assert_eq!(chosen(&[25.0, 0.0], 1, Some(1)), (1, vec![0]));
        assert_eq!(
            chosen(&[0.0, 25.0], 1, Some(1)),
            (0, vec![1]),
            "a simpler one is expected to be better"
        );
        assert_eq!(
            chosen(&[25.0, 0.0, -50.0], 0, Some(1)),
            (2, vec![]),
            "another one certainly is"
        );
    }

    #[test]
    fn a_lobe_without_colour_is_simpler_than_a_mirror_over_a_base_and_a_coloured_one_is_not() {
        let half = Rgb::splat(0.5);
        let plastic = Material::plastic(half, IOR, Layering::default(), 0.1);
        let over_base = Material { rho_d: half, ..Material::mirror(half) };
        let colourless = Material::isotropic(half, half, 0.1);
        let coloured = Material::isotropic(half, Rgb::new(0.5, 0.4, 0.3), 0.1);
        let order = |lobe: Material| {
            let of = [
                (Hypothesis::Diffuse, Material::diffuse(half)),
                (Hypothesis::Mirror, Material::mirror(Rgb::ONE)),
                (Hypothesis::DiffuseSpecular, over_base.clone()),
                (Hypothesis::Isotropic, lobe),
            ];
            let mut fits: Vec<Fit> =
                of.map(|(hypothesis, material)| fit(hypothesis, material)).into();
            sort(&mut fits);
            fits.iter().map(|fit| fit.hypothesis).collect::<Vec<_>>()
        };
        use Hypothesis::{Diffuse, DiffuseSpecular, Isotropic, Mirror};
        for simpler in [plastic, colourless] {
            assert_eq!(order(simpler), [Diffuse, Mirror, Isotropic, DiffuseSpecular]);
        }
        assert_eq!(order(coloured), [Diffuse, Mirror, DiffuseSpecular, Isotropic]);
    }

    fn fit(hypothesis: Hypothesis, material: Material) -> Fit {
        let none = || Vec::new();
        Fit {
            hypothesis,
            material,
            residual: ResidualStats::default(),
            residuals: BlockResiduals {
                residual: none(),
                noise: none(),
                rendering: none(),
                half: none(),
                missing: none(),
                level2: none(),
                light: none(),
            },
            likelihood: Likelihood {
                deviance: 0.0,
                error: ModelError { share: 0.0 },
                light: LightError { share: 0.0 },
                blocks: 0,
            },
        }
    }
}
