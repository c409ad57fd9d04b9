//! Materials of MTL that are glass.
//!
//! An `illum` of glass or refraction alone is written by some programs for whatever shines; so is a `d` below one for what is
//! only thin. Both together, or `Tf` with the former, are glass. `Ni` is its refractive index. A file without one, or
//! with that of air, means ordinary glass: Wavefront's own text has 1.5 for glass, and programs that know no index write 1,
//! by which glass would be nothing at all. `Tf` is what is left of light behind a whole body or pane; where it is black
//! the surface is opaque. `Kd`, `Ks` and how far `d` is below one do not matter.

use super::mtl::Material;
use unrender_scene::reflectance::IOR;
use unrender_scene::{Glass, Mesh, Rgb};

/// Indices nearer to one than this are one: files have three digits or more.
const NEAR_ONE: f32 = 1e-3;

/// The glass of the material on `mesh`: a pane where that is open.
pub(super) fn on(mtl: &Material, mesh: &Mesh) -> Glass {
    let stated = mtl.ni.filter(|ni| ni.is_finite() && *ni > 0.0 && (ni - 1.0).abs() > NEAR_ONE);
    let filter = mtl.tf.filter(|tf| tf.is_finite()).unwrap_or(Rgb::ONE).clamp(Rgb::ZERO, Rgb::ONE);
    let is_thin = !mesh.is_closed();
    // Light passes two faces of a body.
    let tint = if is_thin { filter } else { filter.map(f32::sqrt) };
    Glass { tint, is_thin, ..Glass::solid(stated.unwrap_or(IOR)) }
}
