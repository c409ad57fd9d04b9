//! Shapes of glass into a file, as [`glass`](super::glass) reads them.

use super::glb::Glb;
use crate::glasses::Kind;
use crate::numbers::number;
use serde_json::{Value, json};
use unrender_scene::{Glass, Rgb};

impl Glb {
    /// Lists the material of a `kind` of glass and returns its index.
    pub(super) fn push_glass(&mut self, kind: &Kind) -> usize {
        let glass = kind.glass;
        let mut volume = json!({ "thicknessFactor": if glass.is_thin { 0.0 } else { 1.0 } });
        if !glass.is_thin && glass.absorption.max_element() > 0.0 {
            attenuate(&mut volume, glass.absorption);
        }
        let [r, g, b] = base_color(glass);
        self.push(
            "materials",
            json!({
                "name": kind.name,
                "pbrMetallicRoughness": {
                    "baseColorFactor": [r, g, b, 1.0],
                    "metallicFactor": 0.0,
                    "roughnessFactor": 0.0,
                },
                // Both sides of a pane are its front.
                "doubleSided": glass.is_thin,
                "extensions": {
                    "KHR_materials_transmission": { "transmissionFactor": 1.0 },
                    "KHR_materials_ior": { "ior": number(glass.ior) },
                    "KHR_materials_volume": volume,
                },
            }),
        )
    }
}

/// The colour of light that went through: past both faces of a body.
fn base_color(glass: &Glass) -> [f64; 3] {
    let tint = glass.tint.to_array();
    if glass.is_thin { tint.map(number) } else { tint.map(|share| f64::from(share).powi(2)) }
}

/// What is left of light after the way on which the strongest channel falls to 1/e.
fn attenuate(volume: &mut Value, absorption: Rgb) {
    let strongest = f64::from(absorption.max_element());
    let left = absorption.to_array().map(|per_metre| (-f64::from(per_metre) / strongest).exp());
    volume["attenuationColor"] = json!(left);
    volume["attenuationDistance"] = json!(1.0 / strongest);
}
