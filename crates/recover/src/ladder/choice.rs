//! Which rung to stand on: the simplest that explains as much as the best, as far as the noise and
//! the user's threshold let anyone tell.
//!
//! Two rungs are compared pixel by pixel on the same light: most of the noise is in both and drops
//! out of the difference, so that a difference can be told long before either error can. A rung
//! whose error drowns in noise of its own has no claim to be the best, nor to be as good as it.

use crate::error::deviation_of_sum;
use crate::hypothesis::Fit;
use crate::problem::Thresholds;

/// The index of the fit to take; `fits` go from simple to complex, all on the same evidence, and
/// there is at least one.
pub fn choose(fits: &[Fit], thresholds: &Thresholds) -> usize {
    let at_most = |fit: &Fit| fit.misfit.squared + 2.0 * fit.misfit.deviation;
    let Some(best) = fits.iter().min_by(|a, b| at_most(a).total_cmp(&at_most(b))) else {
        return 0;
    };
    let allowed = thresholds.simpler * best.misfit.relative();
    let good = |fit: &Fit| {
        let unexplained = thresholds.explained.powi(2);
        let like_best = fit.misfit.squared <= at_most(best) + unexplained;
        fit.misfit.relative() <= allowed || (like_best && excess(fit, best) <= unexplained)
    };
    fits.iter().position(good).unwrap_or(fits.len() - 1)
}

/// How much more `fit` leaves unexplained than `best` (relative, squared), less two standard
/// deviations of the difference.
fn excess(fit: &Fit, best: &Fit) -> f64 {
    let difference: Vec<f64> =
        fit.by_pixel.iter().zip(&best.by_pixel).map(|(a, b)| a - b).collect();
    difference.iter().sum::<f64>() - 2.0 * deviation_of_sum(&difference)
}

/// Whether no difference between two fits to the same evidence can be told, or `fit` is better.
pub(crate) fn explains_alike(fit: &Fit, best: &Fit) -> bool {
    excess(fit, best) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Misfit;
    use crate::hypothesis::{self, Hypothesis};
    use unrender_scene::{Material, Rgb};

    fn chosen(errors: [f64; 6]) -> Hypothesis {
        let fits: Vec<Fit> = hypothesis::UNIFORM
            .iter()
            .zip(errors)
            .map(|(&hypothesis, e)| Fit {
                hypothesis,
                material: Material::diffuse(Rgb::ONE),
                misfit: Misfit { squared: e * e, deviation: 0.0, with_noise: e * e },
                by_pixel: vec![e * e / 100.0; 100],
            })
            .collect();
        fits[choose(&fits, &Thresholds::default())].hypothesis
    }

    #[test]
    fn the_simplest_explanation_wins_unless_a_better_one_is_much_better() {
        assert_eq!(chosen([0.005, 0.9, 0.8, 0.004, 0.003, 0.003]), Hypothesis::Diffuse);
        assert_eq!(chosen([0.30, 0.005, 0.004, 0.004, 0.004, 0.004]), Hypothesis::Mirror);
        assert_eq!(chosen([0.30, 0.20, 0.20, 0.15, 0.004, 0.003]), Hypothesis::Isotropic);
        assert_eq!(chosen([0.30, 0.20, 0.20, 0.15, 0.06, 0.004]), Hypothesis::Anisotropic);
        // Nothing explains it well: the simplest that is nearly as good as the best.
        assert_eq!(chosen([0.40, 0.9, 0.9, 0.40, 0.38, 0.37]), Hypothesis::Diffuse);
    }
}
