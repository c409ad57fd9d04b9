//! Rung 3, the mirror that swallows some light: `rho_d = 0`, `rho_s` found (section 4.2.2).

use super::{Fit, Hypothesis, reflecting};
use crate::evidence::Evidence;
use crate::fit::linear::Terms;
use unrender_scene::{Material, Rgb};

/// The specular reflectance that explains the evidence best.
pub fn fit(evidence: &Evidence) -> Fit {
    let bases = (&evidence.light.diffuse(), &evidence.light.mirror());
    let mirror = Material::mirror(Rgb::ONE);
    let terms = Terms { rho_d: Some(0.0), rho_s: None };
    reflecting(Hypothesis::PartialMirror, evidence, mirror, bases, terms)
}
