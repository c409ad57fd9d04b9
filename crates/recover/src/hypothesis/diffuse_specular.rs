//! Rung 4, Lambert's surface under a perfect mirror: `rho_d` and `rho_s` from a 2x2 linear system
//! per channel (section 4.2.3).

use super::{Fit, Hypothesis, reflecting};
use crate::evidence::Evidence;
use crate::fit::linear::Terms;
use unrender_scene::{Material, Rgb};

/// The two reflectances that explain the evidence best.
pub fn fit(evidence: &Evidence) -> Fit {
    let bases = (&evidence.light.diffuse(), &evidence.light.mirror());
    let mirror = Material::mirror(Rgb::ONE);
    reflecting(Hypothesis::DiffuseSpecular, evidence, mirror, bases, Terms::default())
}
