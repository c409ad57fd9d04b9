//! Glass: `dielectric` and `glass`.
//!
//! Radiance's `glass` is a pane of the transmissivity `t`: of light that meets it straight on, `t (1 - f)^2 / (1 - t^2 f^2)`
//! passes, where a face reflects `f`. Ours lets `(1 - R)` times the tint through, which gives `t`. A `dielectric` has the
//! share of light that is left after a unit of length, a metre here.

use super::triple;
use crate::export::identifiers::quoted;
use crate::glasses::Glasses;
use std::fmt::Write;
use unrender_scene::{Glass, Rgb, Warnings};

/// What is left out of solid glass that is coloured at its faces.
const TINTED: &str = "Radiance's dielectrics colour light on its way alone: the tint of the faces of solid glass is left out; \
                      lower the transmissivities of its dielectric";

/// A material for each kind of glass.
pub(super) fn materials(glasses: &Glasses, ids: &[String], warnings: &mut Warnings) -> String {
    if glasses.any(|glass| !glass.is_thin && glass.tint != Rgb::ONE) {
        warnings.push(TINTED);
    }
    let mut text = String::new();
    for (kind, id) in glasses.kinds.iter().zip(ids) {
        let _ = writeln!(text, "\n# glass {}", quoted(&kind.name));
        text.push_str(&material(kind.glass, id));
    }
    text
}

fn material(glass: &Glass, id: &str) -> String {
    let ior = glass.ior;
    if glass.is_thin {
        let transmissivity = glass.tint.map(|tint| transmissivity(glass, tint));
        return format!("void glass {id}\n0\n0\n4 {} {ior}\n", triple(transmissivity));
    }
    let left = (-glass.absorption).exp();
    format!("void dielectric {id}\n0\n0\n5 {} {ior} 0\n", triple(left))
}

/// The transmissivity of a pane that lets through `tint` of what it does not reflect.
fn transmissivity(glass: &Glass, tint: f32) -> f32 {
    let wanted = f64::from(tint) * (1.0 - f64::from(glass.reflected(1.0)));
    let face = f64::from(Glass { is_thin: false, ..*glass }.reflected(1.0));
    let passed = (1.0 - face).powi(2);
    // The root of `wanted f^2 t^2 + (1 - f)^2 t - wanted`, in a form that keeps its digits where f is small.
    let root = (passed * passed + (2.0 * wanted * face).powi(2)).sqrt();
    (2.0 * wanted / (passed + root)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pane_lets_through_what_ours_does() {
        for (ior, tint) in [(1.5, 1.0), (1.5, 0.5), (1.0, 0.3), (2.4, 0.9)] {
            let glass = Glass::pane(ior);
            let t = transmissivity(&glass, tint);
            let face = Glass::solid(ior).reflected(1.0);
            let passed = t * (1.0 - face).powi(2) / (1.0 - t * t * face * face);
            assert!((passed - tint * (1.0 - glass.reflected(1.0))).abs() < 1e-6, "{ior} {tint}");
        }
        assert!((transmissivity(&Glass::pane(1.5), 1.0) - 1.0).abs() < 1e-6);
    }
}
