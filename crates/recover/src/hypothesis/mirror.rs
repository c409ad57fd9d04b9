//! Rung 2, the perfect mirror: `rho_d = 0`, `rho_s = 1`, nothing to find (section 4.2.2).

use super::{Fit, Hypothesis, judged};
use crate::evidence::Evidence;
use unrender_scene::{Material, Rgb};

/// The perfect mirror's residual.
pub fn fit(evidence: &Evidence) -> Fit {
    let material = Material::mirror(Rgb::ONE);
    judged(
        Hypothesis::Mirror,
        evidence,
        material,
        &evidence.light.diffuse(),
        Some(&evidence.light.mirror()),
    )
}
