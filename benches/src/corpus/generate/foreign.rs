//! Random reflectances of the foreign family: models that the recovery does not have, and for each
//! the most similar one of ours.

use super::super::dice::Dice;
use super::super::family::Renderer;
use super::colors::color;
use super::materials::{Kind, Rules, material};
use serde_json::{Value, json};
use unrender::scene::{Material, Rgb};

/// A reflectance of another model.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Foreign {
    /// Disney's principled model, as Mitsuba and Cycles each have it; its roughness is the root of alpha.
    Principled { base_color: Rgb, metallic: f32, roughness: f32, anisotropic: f32 },
    /// A diffuse base under a rough dielectric coat (Mitsuba's `roughplastic`).
    Plastic { base_color: Rgb, alpha: f32 },
    /// A rough conductor with the measured indices of a metal (Mitsuba's `roughconductor`).
    Conductor { metal: &'static str, alpha_x: f32, alpha_y: f32 },
}

/// Metals that Mitsuba knows, with their reflectance at normal incidence.
const METALS: [(&str, [f32; 3]); 4] = [
    ("Au", [0.99, 0.78, 0.34]),
    ("Cu", [0.96, 0.64, 0.54]),
    ("Al", [0.91, 0.92, 0.92]),
    ("Cr", [0.55, 0.55, 0.55]),
];
/// The reflectance of a dielectric of index 1.5 at normal incidence.
const DIELECTRIC: f32 = 0.04;

impl Foreign {
    /// The parameters for Cycles; none if it does not have the model.
    pub(crate) fn principled(&self) -> Option<Value> {
        let Self::Principled { base_color, metallic, roughness, anisotropic } = self else {
            return None;
        };
        Some(json!({
            "base_color": base_color.to_array(), "metallic": metallic,
            "roughness": roughness, "anisotropic": anisotropic,
        }))
    }

    /// The element for Mitsuba; `texture` is the element of its base colour, if it has one.
    pub(crate) fn mitsuba(&self, texture: Option<&str>) -> String {
        let rgb = |name: &str, color: Rgb| {
            format!("<rgb name=\"{name}\" value=\"{} {} {}\"/>", color.x, color.y, color.z)
        };
        let float = |name: &str, value: f32| format!("<float name=\"{name}\" value=\"{value}\"/>");
        let base = |name: &str, color: Rgb| match texture {
            Some(texture) => texture.replace("name=\"reflectance\"", &format!("name=\"{name}\"")),
            None => rgb(name, color),
        };
        match self {
            Self::Principled { base_color, metallic, roughness, anisotropic } => format!(
                "<bsdf type=\"principled\">{}{}{}{}{}</bsdf>",
                base("base_color", *base_color),
                float("metallic", *metallic),
                float("roughness", *roughness),
                float("anisotropic", *anisotropic),
                float("specular", 0.5)
            ),
            Self::Plastic { base_color, alpha } => format!(
                "<bsdf type=\"roughplastic\"><string name=\"distribution\" value=\"ggx\"/>\
                 <boolean name=\"nonlinear\" value=\"true\"/>{}{}</bsdf>",
                base("diffuse_reflectance", *base_color),
                float("alpha", *alpha)
            ),
            Self::Conductor { metal, alpha_x, alpha_y } => format!(
                "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"{metal}\"/>\
                 <string name=\"distribution\" value=\"ggx\"/>{}{}</bsdf>",
                float("alpha_u", *alpha_x),
                float("alpha_v", *alpha_y)
            ),
        }
    }
}

/// The kinds of a group.
#[derive(Clone, Copy)]
enum Choice {
    Plain,
    Textured,
    Dielectric,
    Metal,
    Plastic,
    Conductor,
}

/// A random reflectance: the most similar one of ours, and the foreign one, if it is foreign.
pub(crate) fn reflectance(
    dice: &mut Dice,
    renderer: Renderer,
    rules: Rules,
    has_uvs: bool,
) -> (Material, Option<Foreign>) {
    let own = if renderer == Renderer::Mitsuba { 0.11 } else { 0.0 };
    let choice = dice.weighted(&[
        (Choice::Plain, 0.28),
        (Choice::Textured, if has_uvs { 0.14 } else { 0.0 }),
        (Choice::Dielectric, 0.26),
        (Choice::Metal, 0.16),
        (Choice::Plastic, own),
        (Choice::Conductor, own),
    ]);
    let roughness = dice.range(0.25, 0.75);
    let alpha = roughness * roughness;
    match choice {
        Choice::Plain => (material(dice, Kind::Diffuse, rules), None),
        Choice::Textured => {
            let picture = material(dice, Kind::Textured, rules);
            let is_glossy = dice.chance(0.5);
            let foreign = Foreign::Principled {
                base_color: picture.rho_d,
                metallic: 0.0,
                roughness: roughness.max(0.5),
                anisotropic: 0.0,
            };
            (picture, is_glossy.then_some(foreign))
        }
        Choice::Dielectric => {
            let base_color = color(dice, 0.04, 0.75);
            let (metallic, anisotropic) = (0.0, 0.0);
            let foreign = Foreign::Principled { base_color, metallic, roughness, anisotropic };
            (Material::isotropic(base_color, Rgb::splat(DIELECTRIC), alpha), Some(foreign))
        }
        Choice::Metal => {
            let base_color = color(dice, 0.3, 0.9);
            let (metallic, anisotropic) = (1.0, 0.0);
            let foreign = Foreign::Principled { base_color, metallic, roughness, anisotropic };
            (Material::isotropic(Rgb::ZERO, base_color, alpha), Some(foreign))
        }
        Choice::Plastic => {
            let base_color = color(dice, 0.04, 0.75);
            // The light that leaves the base through the coat: 0.386 = (1 - F)^2 / 1.49^2 at medium
            // angles; the coat reflects 0.596 of the light from below back.
            let rho_d = 0.386 * base_color / (Rgb::ONE - 0.596 * base_color);
            let like = Material::isotropic(rho_d, Rgb::splat(DIELECTRIC), alpha);
            (like, Some(Foreign::Plastic { base_color, alpha }))
        }
        Choice::Conductor => {
            let (metal, normal) = METALS[dice.index(METALS.len())];
            let ratio = if dice.chance(0.4) { dice.range(1.5, 3.0) } else { 1.0 };
            let (alpha_x, alpha_y) = (alpha.max(0.08), (alpha.max(0.08) * ratio).min(0.6));
            let like = Material::isotropic(Rgb::ZERO, Rgb::from_array(normal), alpha_x);
            let like = Material { alpha_y, ..like };
            (like, Some(Foreign::Conductor { metal, alpha_x, alpha_y }))
        }
    }
}
