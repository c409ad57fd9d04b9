//! Rung 4, Lambert's surface under a perfect mirror: `rho_d` and `rho_s` from a 2x2 linear system
//! per channel (section 4.2.3).

use super::{Fit, Hypothesis, judged};
use crate::evidence::Evidence;
use crate::fit::linear::{self, Terms};
use unrender_scene::Material;

/// The two reflectances that explain the evidence best.
pub fn fit(evidence: &Evidence) -> Fit {
    let (diffuse, mirror) = (evidence.light.diffuse(), evidence.light.mirror());
    let found = linear::fit(evidence, &diffuse, Some(&mirror), Terms::Both);
    let material = Material { rho_d: found.rho_d, ..Material::mirror(found.rho_s) };
    judged(Hypothesis::DiffuseSpecular, evidence, material, &diffuse, Some(&mirror))
}
