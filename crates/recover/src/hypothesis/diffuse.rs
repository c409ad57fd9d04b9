//! Rung 1, Lambert's surface: `rho_d` from the radiance of the pixels (section 4.2.1).
//!
//! The paper's ratio update `rho_d <- rho_d mean(B) / mean(L)` is this fit with one pixel weight;
//! since `L = rho_d D` exactly, one step finds what `D` allows, and only the light that the groups send each other
//! needs iterations.

use super::{Fit, Hypothesis, judged, plastic};
use crate::evidence::Evidence;
use crate::fit::linear::{self, Terms};
use unrender_scene::Material;

/// The diffuse reflectance that explains the evidence best, under the coat that all surfaces have where there is one.
pub fn fit(evidence: &Evidence) -> Fit {
    if evidence.plain.is_glossy() {
        return plastic::with_base(Hypothesis::Diffuse, evidence, evidence.plain.clone());
    }
    let diffuse = evidence.light.diffuse();
    let found = linear::fit(evidence, &diffuse, None, Terms::beside(0.0));
    judged(Hypothesis::Diffuse, evidence, Material::diffuse(found.rho_d), &diffuse, None)
}
