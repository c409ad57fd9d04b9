//! Which rung to stand on: the simplest whose residual the noise explains, or that explains nearly
//! as much as the best.

use crate::hypothesis::Fit;
use crate::problem::Thresholds;

/// The index of the fit to take; `fits` go from simple to complex and there is at least one.
pub fn choose(fits: &[Fit], thresholds: &Thresholds) -> usize {
    let best = fits.iter().map(|f| f.misfit.relative()).fold(f64::INFINITY, f64::min);
    let allowed = thresholds.explained.max(thresholds.simpler * best);
    let good =
        |fit: &Fit| fit.misfit.is_within(thresholds.explained) || fit.misfit.relative() <= allowed;
    fits.iter().position(good).unwrap_or(fits.len() - 1)
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
                misfit: Misfit { squared: e * e, deviation: 1e-7, with_noise: e * e },
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
