//! MaterialX: the materials as `standard_surface`, and which objects have them. It has no words for
//! geometry, lights and camera.
//!
//! A surface without a diffuse part is a metal of colour `rho_s`; else a dielectric of colour `rho_d`
//! whose ior is the least (from 1.5 on) that reaches `rho_s` at normal incidence, with `rho_s` over
//! that as its specular colour. Both reflect more towards grazing angles than Ward's lobe.
//! `alpha = roughness^2`; an anisotropy `a` has the aspect `sqrt(1 - a)`, `alpha_x = alpha/aspect`,
//! `alpha_y = alpha aspect`, x turned by `specular_rotation` turns from the tangent.
//! [MaterialX specification 1.39; Autodesk Standard Surface, sections 4 and 5]

use super::identifiers::{identifiers, quoted};
use super::{Files, SceneView};
use crate::texels;
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use unrender_scene::{Material, Rgb, Texture, Warnings, Wrap};

const GLASS_F0: f32 = 0.04;

/// The files of `shot`.
///
/// # Errors
/// If a texture cannot be encoded.
pub(super) fn export(shot: &SceneView) -> Result<(Files, Warnings), String> {
    let mut files = Files::new();
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\" colorspace=\"lin_rec709\">\n",
    );
    let ids = identifiers("m_", shot.scene.groups.iter().map(|g| g.name.as_str()));
    for (index, id) in ids.iter().enumerate() {
        let group = &shot.scene.groups[index];
        let material = &shot.materials[index];
        if let Some(texture) = &material.texture {
            let path = format!("textures/{id}.exr");
            text.push_str(&image(id, &path, texture));
            files.push((path, texels::exr(&texture.image)?));
        }
        text.push_str(&format!(
            "  <standard_surface name=\"{id}_surface\" type=\"surfaceshader\" doc=\"{}\">\n{}  \
             </standard_surface>\n  <surfacematerial name=\"{id}\" type=\"material\">\n    \
             <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"{id}_surface\"/>\n  \
             </surfacematerial>\n",
            escaped(&group.name),
            inputs(material, group.emission, id)
        ));
    }
    let objects = identifiers("o_", shot.scene.objects.iter().map(|o| o.name.as_str()));
    text.push_str("  <look name=\"look\">\n");
    for (object, id) in shot.scene.objects.iter().zip(&objects) {
        text.push_str(&format!(
            "    <materialassign name=\"{id}_wears\" material=\"{}\" geom=\"/{id}\" doc=\"{}\"/>\n",
            ids[object.group],
            escaped(&object.name)
        ));
    }
    text.push_str("  </look>\n</materialx>\n");
    files.push(("materials.mtlx".into(), text.into_bytes()));
    Ok((files, Warnings::default()))
}

fn inputs(material: &Material, emission: Rgb, id: &str) -> String {
    let is_metal = material.texture.is_none() && material.rho_d.max_element() <= 0.0;
    let highest = material.rho_s.max_element();
    let shines = highest > 0.0;
    let is_metal = is_metal && shines;
    let base = if is_metal { material.rho_s } else { material.rho_d };
    let f0 = highest.clamp(GLASS_F0, 0.98);
    let tint = if is_metal { Rgb::ONE } else { (material.rho_s / f0).min(Rgb::ONE) };
    let (x, y) = (material.alpha_x, material.alpha_y);
    let (smooth, rough) = (x.min(y), x.max(y));
    let aspect2 = if rough > 0.0 { smooth / rough } else { 1.0 };
    let along_rough = material.theta_rad + if y > x { FRAC_PI_2 } else { 0.0 };
    let strength = emission.max_element();
    let color = if strength > 0.0 { emission / strength } else { Rgb::ONE };
    let mut text = float("base", 1.0);
    text.push_str(&match material.texture {
        Some(_) => {
            format!("    <input name=\"base_color\" type=\"color3\" nodename=\"{id}_texture\"/>\n")
        }
        None => color3("base_color", base),
    });
    text.push_str(&float("metalness", if is_metal { 1.0 } else { 0.0 }));
    text.push_str(&float("specular", if shines { 1.0 } else { 0.0 }));
    text.push_str(&color3("specular_color", if shines { tint } else { Rgb::ONE }));
    text.push_str(&float("specular_IOR", (1.0 + f0.sqrt()) / (1.0 - f0.sqrt())));
    text.push_str(&float("specular_roughness", (smooth * rough).sqrt().sqrt().min(1.0)));
    text.push_str(&float("specular_anisotropy", 1.0 - aspect2));
    text.push_str(&float("specular_rotation", along_rough.rem_euclid(PI) / TAU));
    text.push_str(&float("emission", strength));
    text.push_str(&color3("emission_color", color));
    text
}

fn image(id: &str, path: &str, texture: &Texture) -> String {
    let mode = |wrap: Wrap| match wrap {
        Wrap::Repeat => "periodic",
        Wrap::MirroredRepeat => "mirror",
        Wrap::ClampToEdge => "clamp",
    };
    format!(
        "  <image name=\"{id}_texture\" type=\"color3\">\n    \
         <input name=\"file\" type=\"filename\" value=\"{path}\" colorspace=\"lin_rec709\"/>\n    \
         <input name=\"uaddressmode\" type=\"string\" value=\"{}\"/>\n    \
         <input name=\"vaddressmode\" type=\"string\" value=\"{}\"/>\n  </image>\n",
        mode(texture.wrap_u),
        mode(texture.wrap_v)
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
