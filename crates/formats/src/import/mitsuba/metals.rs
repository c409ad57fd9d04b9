//! What conductors and dielectrics reflect at normal incidence.

use super::paint::{Context, color};
use super::spectrum::Use;
use super::tree::{Node, Value};
use unrender_scene::Rgb;
use unrender_scene::reflectance::IOR_MAX;

/// What Mitsuba's conductors reflect at normal incidence, linear sRGB: Fresnel's equations with the index
/// of refraction and the coefficient of extinction, each as linear sRGB, as in Mitsuba's rgb modes.
/// [Palik 1985; mitsuba-data, folder `ior`]
const CONDUCTORS: [(&str, [f32; 3]); 39] = [
    ("Ag", [0.975, 0.958, 0.906]),
    ("Al", [0.928, 0.918, 0.919]),
    ("AlAs", [0.320, 0.278, 0.143]),
    ("AlSb", [1.000, 0.373, 0.448]),
    ("Au", [0.967, 0.802, 0.324]),
    ("Be", [0.598, 0.521, 0.506]),
    ("Cr", [0.688, 0.649, 0.687]),
    ("CsI", [0.133, 0.068, 0.062]),
    ("Cu", [0.952, 0.620, 0.511]),
    ("Cu2O", [0.315, 0.246, 0.238]),
    ("CuO", [0.291, 0.198, 0.183]),
    ("Hg", [0.814, 0.770, 0.763]),
    ("HgTe", [0.470, 0.366, 0.351]),
    ("Ir", [0.743, 0.680, 0.631]),
    ("K", [0.954, 0.936, 0.920]),
    ("Li", [0.925, 0.884, 0.793]),
    ("MgO", [0.124, 0.060, 0.053]),
    ("Mo", [0.618, 0.562, 0.541]),
    ("Na", [0.979, 0.960, 0.932]),
    ("Nb", [0.564, 0.489, 0.473]),
    ("Ni", [0.700, 0.594, 0.494]),
    ("Rh", [0.824, 0.754, 0.722]),
    ("Se", [0.379, 0.251, 0.241]),
    ("Se-e", [0.502, 0.403, 0.423]),
    ("SiC", [0.271, 0.187, 0.181]),
    ("SnTe", [0.407, 0.108, 0.015]),
    ("Ta", [0.456, 0.342, 0.380]),
    ("Te", [0.635, 0.578, 0.562]),
    ("Te-e", [0.710, 0.673, 0.653]),
    ("ThF4", [0.086, 0.033, 0.026]),
    ("TiC", [0.548, 0.440, 0.412]),
    ("TiN", [0.641, 0.452, 0.198]),
    ("TiO2", [0.304, 0.225, 0.238]),
    ("V", [0.573, 0.511, 0.536]),
    ("VC", [0.530, 0.418, 0.380]),
    ("VN", [0.525, 0.393, 0.311]),
    ("W", [0.575, 0.478, 0.433]),
    ("a-C", [0.279, 0.194, 0.169]),
    ("d-C", [0.212, 0.158, 0.145]),
];

/// Indices of refraction by Mitsuba's names.
const DIELECTRICS: [(&str, f32); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water ice", 1.31),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("fused quartz", 1.458),
    ("carbon tetrachloride", 1.461),
    ("pyrex", 1.47),
    ("glycerol", 1.4729),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("benzene", 1.501),
    ("bk7", 1.5046),
    ("silicone oil", 1.520_45),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("bromine", 1.661),
    ("diamond", 2.419),
];

/// What the metal of a conductor reflects at normal incidence.
pub(super) fn conductor(context: &Context, node: Node) -> Result<Rgb, String> {
    let has_index = node.has("eta") || node.has("k");
    let default = if node.is_old() && !has_index { "Cu" } else { "none" };
    let material = node.text("material")?.unwrap_or(default);
    if material != "none" {
        if has_index {
            return Err(node.fail("there is a material beside eta and k; leave one of them out"));
        }
        let plain = material.strip_suffix("_palik").unwrap_or(material);
        let found = CONDUCTORS.iter().find(|(name, _)| *name == plain);
        return found.map(|(_, color)| Rgb::from_array(*color)).ok_or_else(|| {
            node.wrong("material", &format!("known: \"{material}\"; give its eta and k"))
        });
    }
    // Without any of them it is a perfect mirror.
    // Fresnel's equations know the squares of both only: published indices are below zero in red where the colour of
    // their spectrum is out of gamut.
    let outside = index(node, "ext_eta", 1.0)?;
    let eta = color(context, node, "eta", Use::Refraction, 0.0)?.abs() / outside;
    let k = color(context, node, "k", Use::Refraction, 1.0)?.abs() / outside;
    let square = |v: Rgb| v * v;
    Ok((square(eta - 1.0) + square(k)) / (square(eta + 1.0) + square(k)).max(Rgb::splat(1e-9)))
}

/// The index of refraction of the inside, relative to that of the outside.
pub(super) fn relative_index(node: Node, inside: f32) -> Result<f32, String> {
    let relative = ratio(node, inside)?;
    if relative <= IOR_MAX {
        return Ok(relative);
    }
    Err(node.fail(format!(
        "its refractive index is {relative} times that outside; up to {IOR_MAX} is read, what reflects more is a conductor"
    )))
}

/// As [`relative_index`], without a bound.
pub(super) fn ratio(node: Node, inside: f32) -> Result<f32, String> {
    Ok(index(node, "int_ior", inside)? / index(node, "ext_ior", 1.000_277)?)
}

fn index(node: Node, name: &str, default: f32) -> Result<f32, String> {
    if let Some(Value::Text(text)) = node.value(name) {
        let found = DIELECTRICS.iter().find(|(known, _)| known == text);
        return found.map(|(_, index)| *index).ok_or_else(|| {
            node.wrong(name, &format!("known: \"{text}\"; give the index of refraction"))
        });
    }
    node.positive(name, default)
}

/// What a dielectric reflects at normal incidence.
pub(super) fn dielectric(index: f32) -> f32 {
    ((index - 1.0) / (index + 1.0)).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_reflects_as_published() {
        assert!((dielectric(1.5) - 0.04).abs() < 1e-6);
    }
}
