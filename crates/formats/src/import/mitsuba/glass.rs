//! BSDFs that let light through as smooth glass: `dielectric`, `roughdielectric` taken as smooth, `thindielectric`, and the
//! two principled ones.
//!
//! Each colour is the factor on light that passes one surface, as in Mitsuba. Bodies of glass that are not closed are
//! panes.

use super::metals;
use super::paint::{Context, color, share};
use super::spectrum::Use;
use super::tree::Node;
use unrender_scene::reflectance::ior_of_f0;
use unrender_scene::{Glass, Mesh, Rgb};

/// The refractive index of Mitsuba's dielectrics that state none: that of "bk7".
const IOR: f32 = 1.5046;

const NO_COLOR: &str =
    "the colour of its specular reflectance was left out: Fresnel's reflectance has none";
const SMOOTH: &str = "it is rough, but was taken as smooth";
const NO_BASE: &str = "its spec_trans is below one, but all of it was taken as glass";

/// Glass, and in what it differs from the BSDF.
pub(super) type Read = (Glass, Vec<&'static str>);

/// The `dielectric`, `roughdielectric` or `thindielectric` `node`.
pub(super) fn dielectric(context: &Context, node: Node) -> Result<Read, String> {
    let ior = metals::ratio(node, IOR)?;
    let tint = color(context, node, "specular_transmittance", Use::Index, 1.0)?.min(Rgb::ONE);
    let reflected = color(context, node, "specular_reflectance", Use::Index, 1.0)?;
    let is_thin = node.kind() == "thindielectric";
    let is_rough = node.kind() == "roughdielectric";
    let doubts = [is_rough.then_some(SMOOTH), (reflected != Rgb::ONE).then_some(NO_COLOR)];
    let glass = Glass { tint, is_thin, ..Glass::solid(ior) };
    Ok((glass, doubts.into_iter().flatten().collect()))
}

/// The `principled` or `principledthin` `node` of this `base` colour, if it lets light through.
pub(super) fn principled(context: &Context, node: Node, base: Rgb) -> Result<Option<Read>, String> {
    let through = share(context, node, "spec_trans", 0.0)?;
    if through <= 0.0 {
        return Ok(None);
    }
    let is_thin = node.kind() == "principledthin";
    let ior = if is_thin || node.has("eta") {
        share(context, node, "eta", 1.5)?
    } else {
        ior_of_f0(0.08 * share(context, node, "specular", 0.5)?.clamp(0.0, 1.0))
    };
    if ior <= 0.0 {
        return Err(node.wrong("eta", "above zero"));
    }
    let is_rough = share(context, node, "roughness", 0.5)? > 0.0;
    let doubts = [is_rough.then_some(SMOOTH), (through < 1.0).then_some(NO_BASE)];
    node.pass_all();
    // Light passes two faces of a body.
    let tint = if is_thin { base } else { base.map(f32::sqrt) };
    let tint = tint.clamp(Rgb::ZERO, Rgb::ONE);
    let glass = Glass { tint, is_thin, ..Glass::solid(ior) };
    Ok(Some((glass, doubts.into_iter().flatten().collect())))
}

/// `glass` on `mesh`: a body of it that is not closed is a pane.
pub(super) fn on(glass: Glass, mesh: &Mesh) -> Glass {
    Glass { is_thin: glass.is_thin || !mesh.is_closed(), ..glass }
}
