//! Rung 3, the mirror that swallows some light: `rho_d = 0`, `rho_s` found (section 4.2.2).

use super::{Fit, Hypothesis, judged};
use crate::evidence::Evidence;
use crate::fit::linear::{self, Terms};
use unrender_scene::Material;

/// The specular reflectance that explains the evidence best.
pub fn fit(evidence: &Evidence) -> Fit {
    let (diffuse, mirror) = (evidence.light.diffuse(), evidence.light.mirror());
    let found = linear::fit(evidence, &diffuse, Some(&mirror), Terms::Specular);
    let material = Material::mirror(found.rho_s);
    judged(Hypothesis::PartialMirror, evidence, material, &diffuse, Some(&mirror))
}
