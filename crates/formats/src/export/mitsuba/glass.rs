//! Glass: `dielectric` and `thindielectric`, which reflect as ours does.

use super::{comment, float, rgb};
use crate::glasses::Glasses;
use unrender_scene::{Glass, Warnings};

/// The refractive index of glass that reflects nothing: Mitsuba wants the two sides to differ. This reflects 2.5e-11 of
/// the light; a tenth of the difference is lost in single precision, ten times of it is not seen either.
const CLEAR: f32 = 1.000_01;

/// What is left out of glass that absorbs.
const ABSORBING: &str = "Mitsuba's dielectrics colour light at their faces alone: what solid glass absorbs on the way through it \
                         is left out; put a homogeneous medium inside its shapes";

/// A BSDF for each kind of glass.
pub(super) fn bsdfs(glasses: &Glasses, ids: &[String], warnings: &mut Warnings) -> String {
    if glasses.any(|glass| !glass.is_thin && glass.absorption.max_element() > 0.0) {
        warnings.push(ABSORBING);
    }
    let kinds = glasses.kinds.iter().zip(ids);
    kinds.map(|(kind, id)| bsdf(&kind.name, kind.glass, id)).collect()
}

fn bsdf(name: &str, glass: &Glass, id: &str) -> String {
    let plugin = if glass.is_thin { "thindielectric" } else { "dielectric" };
    let ior = if glass.ior == 1.0 { CLEAR } else { glass.ior };
    format!(
        "    {}\n    <bsdf type=\"{plugin}\" id=\"{id}\">{}{}{}</bsdf>\n",
        comment("glass", name),
        float("int_ior", ior),
        float("ext_ior", 1.0),
        rgb("specular_transmittance", glass.tint)
    )
}
