//! Glass: `dielectric` and `thindielectric`.

use super::named;
use crate::export::identifiers::quoted;
use crate::glasses::Glasses;
use std::fmt::Write;
use unrender_scene::{Rgb, Warnings};

/// What is left out of glass that has a colour of its own.
const COLOURED: &str = "PBRT's dielectrics are clear: the tint of glass is left out; colour the light behind it, or give solid \
                        glass a medium";
/// What is left out of glass that absorbs.
const ABSORBING: &str = "PBRT's dielectrics are clear: what solid glass absorbs on the way through it is left out; put a \
                         homogeneous medium inside its shapes, and take the integrator volpath";

/// A material for each kind of glass.
pub(super) fn materials(glasses: &Glasses, ids: &[String], warnings: &mut Warnings) -> String {
    if glasses.any(|glass| glass.tint != Rgb::ONE) {
        warnings.push(COLOURED);
    }
    if glasses.any(|glass| !glass.is_thin && glass.absorption.max_element() > 0.0) {
        warnings.push(ABSORBING);
    }
    let mut text = String::new();
    for (kind, id) in glasses.kinds.iter().zip(ids) {
        let _ = writeln!(text, "\n# glass {}", quoted(&kind.name));
        let plugin = if kind.glass.is_thin { "thindielectric" } else { "dielectric" };
        named(&mut text, id, plugin, &format!("\"float eta\" {}", kind.glass.ior));
    }
    text
}
