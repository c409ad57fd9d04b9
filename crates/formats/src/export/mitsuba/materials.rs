//! Reflectances.

use super::{float, reflectance, safe};
use crate::export::{Files, SceneView, tiling};
use crate::record::group_note;
use crate::texels;
use unrender_scene::{BrdfModel, Material, Rgb, Warnings};

/// The reflectance of group `index` as a BSDF called `id`, and the picture that it names.
pub(super) fn bsdf(
    shot: &SceneView,
    index: usize,
    id: &str,
    warnings: &mut Warnings,
) -> Result<(String, Files), String> {
    let (name, material) = (&shot.scene.groups[index].name, &shot.materials[index]);
    let weight = tiling::specular_share(material);
    let (mut color, mut files) =
        (reflectance("reflectance", material.rho_d / (1.0 - weight)), Files::new());
    if let Some(texture) = &material.texture {
        let tile = tiling::tile(texture);
        let path = format!("textures/{id}.exr");
        let image = tile.image.map(|texel| *texel / (1.0 - weight));
        files.push((path.clone(), texels::exr(&image)?));
        let mode = if tile.clamps { "clamp" } else { "repeat" };
        color = format!(
            "<texture type=\"bitmap\" name=\"reflectance\">\
             <string name=\"filename\" value=\"{path}\"/><boolean name=\"raw\" value=\"true\"/>\
             <string name=\"wrap_mode\" value=\"{mode}\"/></texture>"
        );
        warnings.0.extend(tile.doubt.map(|doubt| format!("group \"{name}\": {doubt}")));
        if tiling::is_anisotropic(material) {
            warnings.push(format!(
                "group \"{name}\": Mitsuba counts the anisotropy direction from the texture's u"
            ));
        }
    }
    let diffuse = format!("<bsdf type=\"diffuse\">{color}</bsdf>");
    let microfacets = if shot.scene.brdf == BrdfModel::Ggx { "ggx" } else { "beckmann" };
    let inside = match weight {
        0.0 => diffuse,
        1.0 => specular(material, material.rho_s, microfacets),
        _ => format!(
            "<bsdf type=\"blendbsdf\">{}{diffuse}{}</bsdf>",
            float("weight", weight),
            specular(material, material.rho_s / weight, microfacets)
        ),
    };
    let text = format!(
        "    {}\n    <bsdf type=\"twosided\" id=\"{id}\">{inside}</bsdf>\n",
        safe(&group_note(&shot.scene.groups[index], shot.scene.brdf))
    );
    Ok((text, files))
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
