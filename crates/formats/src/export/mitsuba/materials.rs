//! Reflectances.

use super::detail::{self, Place};
use super::{float, reflectance, safe};
use crate::export::{Files, SceneView, maps, tiling};
use crate::group_detail;
use crate::import::mitsuba::plastics::Surface;
use crate::record::group_note;
use crate::texels;
use std::fmt::Write;
use unrender_scene::{Material, Reflectance, Rgb, Warnings};

/// The reflectance of group `index` as a BSDF called `id`, and the pictures that it names.
pub(super) fn bsdf(
    shot: &SceneView,
    index: usize,
    id: &str,
    warnings: &mut Warnings,
) -> Result<(String, Files), String> {
    let (name, material) = (&shot.scene.groups[index].name, &shot.materials[index]);
    let copies = tiling::copies(shot, index);
    let plastic = Plastic::of(material);
    let weight = if plastic.is_some() { 0.0 } else { tiling::specular_share(material) };
    let property = if plastic.is_some() { "diffuse_reflectance" } else { "reflectance" };
    let base =
        |rho: Rgb| plastic.as_ref().map_or(rho / (1.0 - weight), |p| p.surface.reflectance(rho));
    let (mut color, mut files) = (reflectance(property, base(material.rho_d)), Files::new());
    if let Some(texture) = &material.texture {
        let tile = tiling::tile(texture, copies);
        let path = format!("textures/{id}.exr");
        files.push((path.clone(), texels::exr(&tile.image.map(|texel| base(*texel)))?));
        color = detail::bitmap(property, &path, tile.mode(), "");
        warnings.0.extend(tile.doubt.map(|doubt| format!("group \"{name}\": {doubt}")));
        if tiling::is_anisotropic(material) {
            warnings.push(format!(
                "group \"{name}\": Mitsuba counts the anisotropy direction from the texture's u"
            ));
        }
    }
    let diffuse = match &plastic {
        Some(plastic) => plastic.bsdf(&color),
        None => format!("<bsdf type=\"diffuse\">{color}</bsdf>"),
    };
    let microfacets = if shot.scene.brdf.is_ggx() { "ggx" } else { "beckmann" };
    let inside = match weight {
        0.0 => diffuse,
        1.0 => specular(material, material.rho_s, microfacets),
        _ => format!(
            "<bsdf type=\"blendbsdf\">{}{diffuse}{}</bsdf>",
            float("weight", weight),
            specular(material, material.rho_s / weight, microfacets)
        ),
    };
    let place = Place { id, name, copies };
    let found = group_detail::of_group(shot.scene, index);
    let note = group_note(&shot.scene.groups[index], shot.scene.brdf);
    let mut text = String::new();
    for mirrored in [false, true] {
        // One that no object has is there all the same: it is the group.
        if !mirrored || maps::has_mirrored(shot.scene, index) {
            let made = detail::bsdf(&place, (&inside, &found, mirrored), &mut files, warnings)?;
            let _ = writeln!(text, "    {}\n    {made}", safe(&note));
        }
    }
    Ok((text, files))
}

/// A dielectric as one of Mitsuba's plastics, which are coupled.
struct Plastic {
    ior: f32,
    alpha: f32,
    surface: Surface,
}

impl Plastic {
    fn of(material: &Material) -> Option<Self> {
        let Reflectance::Dielectric { ior, .. } = material.reflectance else { return None };
        let alpha = (material.alpha_x * material.alpha_y).sqrt();
        Some(Self { ior, alpha, surface: Surface::new(ior, alpha) })
    }

    /// The BSDF with the diffuse reflectance `color`.
    fn bsdf(&self, color: &str) -> String {
        let indices = float("int_ior", self.ior) + &float("ext_ior", 1.0);
        if self.alpha <= 0.0 {
            return format!("<bsdf type=\"plastic\">{indices}{color}</bsdf>");
        }
        let alpha = float("alpha", self.alpha);
        format!(
            "<bsdf type=\"roughplastic\"><string name=\"distribution\" value=\"ggx\"/>{indices}{alpha}{color}</bsdf>"
        )
    }
}

fn specular(material: &Material, color: Rgb, microfacets: &str) -> String {
    let color = reflectance("specular_reflectance", color);
    let perfect = "<string name=\"material\" value=\"none\"/>";
    if material.is_delta() {
        return format!("<bsdf type=\"conductor\">{perfect}{color}</bsdf>");
    }
    format!(
        "<bsdf type=\"roughconductor\">{perfect}<string name=\"distribution\" value=\"{microfacets}\"/>\
         {}{}{color}</bsdf>",
        float("alpha_u", material.alpha_x),
        float("alpha_v", material.alpha_y)
    )
}
