//! The isotropic rung as a plastic: a dielectric's lobe over a diffuse base. Beside its base it has one number, the
//! roughness, since Fresnel's equations fix how strong its lobe is.
//!
//! With the roughness given, the base follows by least squares from `B - S = rho_d D`: `S` is the dielectric's lobe in the
//! light that arrives, `D` that of a white base under it.

use super::roughness::{STEPS, anywhere, downhill_by};
use super::{Fit, Hypothesis, Search, judged};
use crate::evidence::Evidence;
use crate::expected::ParameterBounds;
use crate::fit::linear::{self, Terms};
use unrender_scene::reflectance::{IOR, Layering, f0_of_ior};
use unrender_scene::{BrdfModel, Material, Rgb};

/// The plastic that explains the evidence best; none if the user's bounds exclude a reflectance of 4 %.
pub(super) fn fit(evidence: &Evidence, start: &Material, search: Search) -> Option<Fit> {
    let bounds = &evidence.expected.bounds;
    if !is_within(bounds) {
        return None;
    }
    let round = |alpha: f32| bounds.nearest_round(alpha);
    let known = (start.alpha_x * start.alpha_y).sqrt();
    let alpha = match search {
        Search::Kept if start.is_glossy() => round(known),
        Search::Local if start.is_glossy() => {
            let by_log = |p: &[f64]| round(p[0].exp() as f32);
            let fitted = |p: &[f64]| of_roughness(evidence, by_log(p));
            let first = [f64::from(known).ln()];
            by_log(&downhill_by(evidence, &fitted, (&first, &[0.1]), STEPS[1]))
        }
        _ => {
            let part = evidence.thinned();
            let deviance = |alpha: f32| of_roughness(&part, round(alpha)).likelihood.deviance;
            round(anywhere(&part, &deviance))
        }
    };
    Some(of_roughness(evidence, alpha))
}

/// The roughness of a dull plastic, of which nothing but the colour is known: that of cloth, plaster and matt paint, 0.8 in
/// Blender and glTF. At 0.5 the ceiling of an artist's room comes out 0.031 too dark instead of 0.018. Half of it reflects
/// 0.053 of even light instead of 0.033 and was not tried; double is beyond the largest.
const DULL: f32 = 0.64;

/// A black dull plastic within `bounds`, in a scene of `model`; none where surfaces may be without a coat: in the scenes of
/// Blender and glTF all are dielectrics over a base.
pub(crate) fn dull(model: BrdfModel, bounds: &ParameterBounds) -> Option<Material> {
    let is_coated = model == BrdfModel::Principled(Layering::AlbedoScaled);
    (is_coated && is_within(bounds)).then(|| of_alpha(model, bounds.nearest_round(DULL)))
}

/// Whether `material` looks the same from all directions, or nearly so: it has no lobe, or that of a dull plastic, which
/// reflects a thirtieth of even light.
pub(crate) fn is_dull(material: &Material) -> bool {
    material.rho_s == Rgb::ZERO || (!material.reflectance.is_free() && material.alpha_x == DULL)
}

/// Whether the user's bounds allow the lobe of a plastic, which reflects 4 % at normal incidence.
pub(crate) fn is_within(bounds: &ParameterBounds) -> bool {
    let f0 = Rgb::splat(f0_of_ior(IOR));
    let [low, high] = bounds.rho_s;
    low.cmple(f0).all() && f0.cmple(high).all()
}

/// The plastic of the roughness `alpha` over a black base, in a scene of `model`.
pub(crate) fn of_alpha(model: BrdfModel, alpha: f32) -> Material {
    Material::plastic(Rgb::ZERO, IOR, model.layering(), alpha)
}

/// The fit with the roughness given.
fn of_roughness(evidence: &Evidence, alpha: f32) -> Fit {
    with_base(Hypothesis::Isotropic, evidence, of_alpha(evidence.light.model, alpha))
}

/// The base that explains the evidence best under the lobe of `coat`.
pub(super) fn with_base(hypothesis: Hypothesis, evidence: &Evidence, coat: Material) -> Fit {
    let (diffuse, specular) = (evidence.light.base(&coat), evidence.light.specular(&coat));
    let rho_d =
        linear::fit(evidence, &diffuse, Some(&specular), Terms::beside(coat.rho_s.x.into())).rho_d;
    judged(hypothesis, evidence, Material { rho_d, ..coat }, &diffuse, Some(&specular))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypothesis::diffuse;
    use glam::Vec3;
    use std::f32::consts::{PI, TAU};
    use unrender_render::Incident;

    const SIDE: usize = 12;
    const GLTF: BrdfModel = BrdfModel::Principled(Layering::AlbedoScaled);

    /// A plastic of the roughness `alpha` over a base of 0.5 in even light, seen at 20 to 60 degrees, and taken for `plain`
    /// where nothing but its colour is known.
    fn plastic(alpha: f32, plain: Material) -> Evidence {
        let rings = (0..16).flat_map(|ring| (0..16).map(move |turn| (ring, turn)));
        let even = |(ring, turn): (u32, u32)| {
            let (z2, turn) = ((ring as f32 + 0.5) / 16.0, turn as f32 * TAU / 16.0);
            let across = (1.0 - z2).sqrt();
            let wi = Vec3::new(across * turn.cos(), across * turn.sin(), z2.sqrt());
            Incident { wi, irradiance: Rgb::splat(PI / 256.0) }
        };
        let lights: Vec<Incident> = rings.map(even).collect();
        let wo = |i: usize| {
            let angle = (20.0 + 40.0 * (i % SIDE) as f32 / SIDE as f32).to_radians();
            Vec3::new(angle.sin(), 0.0, angle.cos())
        };
        let evidence = Evidence::square(GLTF, SIDE, &lights, wo).beside(plain);
        let truth = Material { rho_d: Rgb::splat(0.5), ..of_alpha(GLTF, alpha) };
        let shown = evidence.light.mean_radiance(&truth);
        evidence.showing(shown)
    }

    #[test]
    fn a_base_under_an_unknown_coat_is_told_better_than_without_one() {
        for (alpha, least) in [(0.5, 0.01), (0.81, 0.01), (1.0, 0.008)] {
            let off = |plain: Material| {
                let fit = diffuse::fit(&plastic(alpha, plain));
                assert_eq!(fit.hypothesis, Hypothesis::Diffuse);
                (fit.material.rho_d.x - 0.5).abs()
            };
            let dull = off(of_alpha(GLTF, DULL));
            let matt = off(Material::diffuse(Rgb::ZERO));
            println!("{alpha}: {dull} and {matt} off");
            assert!(dull < 0.006 && matt > least, "{alpha}: {dull} and {matt} off");
        }
    }

    #[test]
    fn only_scenes_of_coated_surfaces_have_dull_plastics() {
        let free = ParameterBounds::default();
        let coat = dull(GLTF, &free).unwrap();
        assert_eq!((coat.rho_d, coat.alpha_x), (Rgb::ZERO, DULL));
        assert_eq!(crate::hypothesis::of(&coat), Hypothesis::Diffuse);
        let coupled = BrdfModel::Principled(Layering::Coupled);
        for model in [coupled, BrdfModel::Ggx, BrdfModel::default()] {
            assert_eq!(dull(model, &free), None, "{model:?}");
        }
        let matt = ParameterBounds { rho_s: [Rgb::ZERO; 2], ..free };
        assert_eq!(dull(GLTF, &matt), None);
    }
}
