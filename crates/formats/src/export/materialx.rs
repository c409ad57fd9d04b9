//! MaterialX: the materials as `standard_surface`, and which objects have them. It has no words for
//! geometry, lights and camera.
//!
//! The layers are those of `layered.rs`. `alpha = roughness^2`; an anisotropy `a` has the aspect `sqrt(1 - a)`, `alpha_x =
//! alpha/aspect`, `alpha_y = alpha aspect`, x turned by `specular_rotation` turns from the tangent.
//! What it cannot say stands in a comment in front of each shader, from which our own reader takes the exact numbers.
//! [MaterialX specification 1.39; Autodesk Standard Surface, sections 4 and 5]

use super::identifiers::{Ids, quoted};
use super::layered::{Layered, Transmission, strength_and_color};
use super::{Files, SceneView, maps};
use crate::glasses::Glasses;
use crate::group_detail;
use crate::record::group_note;
use crate::texels;
use std::f32::consts::TAU;
use unrender_scene::{Detail, Glass, Material, Rgb, Warnings, Wrap};

/// What is left out of glass that is coloured in both ways.
const TINT_LEFT_OUT: &str = "MaterialX has one transmission colour: of solid glass that absorbs on the way and is tinted at its \
                             faces, the tint is left out; make transmission_color darker";

/// The files of `shot`.
///
/// # Errors
/// If a texture cannot be encoded.
pub(super) fn export(shot: &SceneView) -> Result<(Files, Warnings), String> {
    let mut files = Files::new();
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\" colorspace=\"lin_rec709\">\n",
    );
    let glasses = Glasses::of(shot.scene);
    let ids = Ids::of(shot.scene, &glasses);
    for (index, id) in ids.groups.iter().enumerate() {
        let group = &shot.scene.groups[index];
        let material = &shot.materials[index];
        if let Some(texture) = &material.texture {
            let path = format!("textures/{id}.exr");
            let wraps = [texture.wrap_u, texture.wrap_v];
            text.push_str(&image((id, "texture", "color3"), &path, wraps, "linear"));
            files.push((path, texels::exr(&texture.image)?));
        }
        let found = group_detail::of_group(shot.scene, index);
        let more = detail(&found, id, &mut text, &mut files)?;
        let inputs = inputs(material, group.emission, id) + &more;
        text.push_str(&comment(&group_note(group, shot.scene.brdf)));
        text.push_str(&surface(id, &group.name, &inputs));
    }
    let mut warnings = Warnings::default();
    for (kind, id) in glasses.kinds.iter().zip(&ids.kinds) {
        text.push_str(&surface(id, &kind.name, &glass(kind.glass)));
        if Transmission::of(kind.glass).lacks_tint {
            warnings.push(TINT_LEFT_OUT);
        }
    }
    text.push_str("  <look name=\"look\">\n");
    let objects = shot.scene.objects.iter().zip(&ids.objects);
    for (object, id) in objects {
        text.push_str(&assigned(id, &ids.groups[object.group], &object.name));
    }
    for (shape, id) in glasses.shapes.iter().zip(&ids.shapes) {
        text.push_str(&assigned(id, &ids.kinds[shape.kind], &shape.name));
    }
    text.push_str("  </look>\n</materialx>\n");
    files.push(("materials.mtlx".into(), text.into_bytes()));
    Ok((files, warnings))
}

/// A comment of `text`, without what ends one.
fn comment(text: &str) -> String {
    format!("  <!-- {} -->\n", text.replace("--", "\\u002d\\u002d"))
}

/// The surface and the material called `id`, after `name`.
fn surface(id: &str, name: &str, inputs: &str) -> String {
    format!(
        "  <standard_surface name=\"{id}_surface\" type=\"surfaceshader\" doc=\"{}\">\n{inputs}  \
         </standard_surface>\n  <surfacematerial name=\"{id}\" type=\"material\">\n    \
         <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"{id}_surface\"/>\n  \
         </surfacematerial>\n",
        escaped(name)
    )
}

/// That the object called `id`, after `name`, has `material`.
fn assigned(id: &str, material: &str, name: &str) -> String {
    format!(
        "    <materialassign name=\"{id}_wears\" material=\"{material}\" geom=\"/{id}\" doc=\"{}\"/>\n",
        escaped(name)
    )
}

/// The inputs that say what of `detail` there is; their nodes are added to `text`.
fn detail(
    detail: &Detail,
    id: &str,
    text: &mut String,
    files: &mut Files,
) -> Result<String, String> {
    let mut inputs = String::new();
    if let Some(map) = &detail.normals {
        let picture = maps::colors(map, false);
        let path = format!("textures/{id}-normals.exr");
        let wraps = [picture.wrap_u, picture.wrap_v];
        text.push_str(&image((id, "bumps", "vector3"), &path, wraps, "linear"));
        text.push_str(&format!(
            "  <normalmap name=\"{id}_normal\" type=\"vector3\">\n    \
             <input name=\"in\" type=\"vector3\" nodename=\"{id}_bumps\"/>\n  </normalmap>\n"
        ));
        inputs.push_str(&format!(
            "    <input name=\"normal\" type=\"vector3\" nodename=\"{id}_normal\"/>\n"
        ));
        files.push((path, texels::exr(&picture.image)?));
    }
    if let Some(coverage) = &detail.coverage {
        let stencil = maps::stencil(coverage);
        let path = format!("textures/{id}-holes.png");
        let wraps = [stencil.wrap_u, stencil.wrap_v];
        text.push_str(&image((id, "holes", "color3"), &path, wraps, "closest"));
        inputs.push_str(&format!(
            "    <input name=\"opacity\" type=\"color3\" nodename=\"{id}_holes\"/>\n"
        ));
        files.push((path, texels::png_of_numbers(&stencil.image)?));
    }
    Ok(inputs)
}

/// The inputs of glass.
fn glass(glass: &Glass) -> String {
    let Transmission { color, depth, .. } = Transmission::of(glass);
    let mut text = float("base", 0.0);
    text.push_str(&float("specular", 1.0));
    text.push_str(&float("specular_IOR", glass.ior));
    text.push_str(&float("specular_roughness", 0.0));
    text.push_str(&float("transmission", 1.0));
    text.push_str(&color3("transmission_color", color));
    text.push_str(&float("transmission_depth", depth));
    let thin = glass.is_thin;
    text.push_str(&format!(
        "    <input name=\"thin_walled\" type=\"boolean\" value=\"{thin}\"/>\n"
    ));
    text
}

fn inputs(material: &Material, emission: Rgb, id: &str) -> String {
    let layered = Layered::of(material);
    let (strength, color) = strength_and_color(emission);
    let share = |is_there: bool| if is_there { 1.0 } else { 0.0 };
    let mut text = float("base", 1.0);
    text.push_str(&match material.texture {
        Some(_) => {
            format!("    <input name=\"base_color\" type=\"color3\" nodename=\"{id}_texture\"/>\n")
        }
        None => color3("base_color", layered.base_color),
    });
    text.push_str(&float("metalness", share(layered.is_metal)));
    text.push_str(&float("specular", share(layered.shines)));
    text.push_str(&color3("specular_color", layered.specular_color));
    text.push_str(&float("specular_IOR", layered.ior));
    text.push_str(&float("specular_roughness", layered.mean_roughness()));
    text.push_str(&float("specular_anisotropy", 1.0 - layered.aspect()));
    text.push_str(&float("specular_rotation", layered.rougher_rad / TAU));
    text.push_str(&float("emission", strength));
    text.push_str(&color3("emission_color", color));
    text
}

/// The node `id`_`what` of the type `kind`: the picture at `path`.
fn image(
    (id, what, kind): (&str, &str, &str),
    path: &str,
    wraps: [Wrap; 2],
    filter: &str,
) -> String {
    let mode = |wrap: Wrap| match wrap {
        Wrap::Repeat => "periodic",
        Wrap::MirroredRepeat => "mirror",
        Wrap::ClampToEdge => "clamp",
    };
    format!(
        "  <image name=\"{id}_{what}\" type=\"{kind}\">\n    \
         <input name=\"file\" type=\"filename\" value=\"{path}\" colorspace=\"lin_rec709\"/>\n    \
         <input name=\"uaddressmode\" type=\"string\" value=\"{}\"/>\n    \
         <input name=\"vaddressmode\" type=\"string\" value=\"{}\"/>\n    \
         <input name=\"filtertype\" type=\"string\" value=\"{filter}\"/>\n  </image>\n",
        mode(wraps[0]),
        mode(wraps[1])
    )
}

fn float(name: &str, value: f32) -> String {
    format!("    <input name=\"{name}\" type=\"float\" value=\"{value}\"/>\n")
}

fn color3(name: &str, v: Rgb) -> String {
    format!("    <input name=\"{name}\" type=\"color3\" value=\"{}, {}, {}\"/>\n", v.x, v.y, v.z)
}

/// A name as an attribute: in quotes of its own, without what XML keeps for itself.
fn escaped(name: &str) -> String {
    let name = quoted(name).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    name.replace('"', "&quot;")
}
