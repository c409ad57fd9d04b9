//! `UsdPreviewSurface`, which all programs read. [OpenUSD, UsdPreviewSurface specification]
//!
//! `alpha = roughness^2`. A metal has its reflectance at normal incidence as `diffuseColor`, a plastic its refractive index.
//! The specular workflow would have the colour of a free lobe over a base, but Blender multiplies that by the reflectance of
//! the refractive index. So such a lobe is that of a plastic, of its mean reflectance, or partly that of a metal:
//!
//! ```text
//! rho_d = (1 - metallic) color,    rho_s = metallic color,    color = rho_d + rho_s
//! ```
//!
//! with a refractive index of one; whichever leaves less of both reflectances.
//! Glass lets light straight through: `opacity` is what it takes of light at normal incidence.

use super::network::{Group, Network, Picture};
use super::stage::{Prim, Value};
use crate::export::layered::HIGHEST_F0;
use unrender_scene::reflectance::ior_of_f0;
use unrender_scene::{Glass, Reflectance, Rgb};

/// Adds the surface of `group`; returns the path of its output.
pub(super) fn group(group: &Group, network: &mut Network) -> String {
    let coordinates = coordinates(group, network);
    let mut read = |name: &str, picture: &Picture, output| {
        texture(name, picture, &coordinates, output, network)
    };
    let color = group.texture.as_ref();
    let color = color.map(|picture| read("preview_color", picture, ("float3", "outputs:rgb")));
    let normals = group.normals.as_ref();
    let normals =
        normals.map(|picture| read("preview_normals", picture, ("float3", "outputs:rgb")));
    let holes = group
        .holes
        .as_ref()
        .map(|(picture, cutoff)| (read("preview_holes", picture, ("float", "outputs:r")), *cutoff));
    let shown = shown(group);
    surface(network, |node| {
        match color {
            Some(source) => node.connect("color3f", "inputs:diffuseColor", source),
            None => node.set("color3f", "inputs:diffuseColor", Value::Float3(shown.color)),
        }
        let layered = &group.layered;
        let roughness = if layered.shines { layered.mean_roughness() } else { 1.0 };
        node.set("float", "inputs:metallic", Value::Float(shown.metallic));
        node.set("float", "inputs:roughness", Value::Float(roughness));
        node.set("float", "inputs:ior", Value::Float(shown.ior));
        if group.emission.max_element() > 0.0 {
            node.set("color3f", "inputs:emissiveColor", Value::Float3(group.emission));
        }
        if let Some(source) = normals {
            node.connect("normal3f", "inputs:normal", source);
        }
        if let Some((source, cutoff)) = holes {
            node.connect("float", "inputs:opacity", source);
            node.set("float", "inputs:opacityThreshold", Value::Float(cutoff));
        }
    })
}

/// What of the surface is colour, metal and plastic.
struct Shown {
    color: Rgb,
    metallic: f32,
    ior: f32,
}

fn shown(group: &Group) -> Shown {
    let (material, layered) = (group.material, &group.layered);
    let color = layered.base_color;
    if layered.is_metal {
        return Shown { color, metallic: 1.0, ior: layered.ior };
    }
    if let Reflectance::Dielectric { ior, .. } = material.reflectance {
        return Shown { color, metallic: 0.0, ior };
    }
    let mean = (material.rho_s.element_sum() / 3.0).min(HIGHEST_F0);
    let off_as_plastic = (material.rho_s - mean).abs().element_sum();
    let both = material.rho_d + material.rho_s;
    let metallic = material.rho_s.element_sum() / both.element_sum().max(f32::MIN_POSITIVE);
    // What the one reflectance has too much, the other lacks.
    let off_as_metal = 2.0 * (material.rho_s - metallic * both).abs().element_sum();
    if group.texture.is_none() && off_as_metal < off_as_plastic {
        return Shown { color: both, metallic, ior: 1.0 };
    }
    Shown { color, metallic: 0.0, ior: ior_of_f0(mean) }
}

/// Adds the surface of glass; returns the path of its output.
pub(super) fn glass(glass: &Glass, network: &mut Network) -> String {
    let let_through = (1.0 - glass.reflected(1.0)) * glass.tint.element_sum() / 3.0;
    surface(network, |node| {
        node.set("color3f", "inputs:diffuseColor", Value::Float3(Rgb::ZERO));
        node.set("float", "inputs:metallic", Value::Float(0.0));
        node.set("float", "inputs:roughness", Value::Float(0.0));
        node.set("float", "inputs:ior", Value::Float(glass.ior));
        node.set("float", "inputs:opacity", Value::Float(1.0 - let_through));
    })
}

fn surface(network: &mut Network, inputs: impl FnOnce(&mut Prim)) -> String {
    network.node("preview", "UsdPreviewSurface", ("token", "outputs:surface"), inputs)
}

/// Adds the reader of texture coordinates, if `group` has pictures; returns the path of its output.
fn coordinates(group: &Group, network: &mut Network) -> Option<String> {
    group.has_pictures().then(|| {
        let output = ("float2", "outputs:result");
        network.node("preview_st", "UsdPrimvarReader_float2", output, |node| {
            node.set("string", "inputs:varname", Value::String("st".into()));
        })
    })
}

/// Adds the reader of `picture`, called `name`; returns the path of its output.
fn texture(
    name: &str,
    picture: &Picture,
    coordinates: &Option<String>,
    output: (&'static str, &'static str),
    network: &mut Network,
) -> String {
    let is_normals = name.ends_with("normals");
    network.node(name, "UsdUVTexture", output, |node| {
        node.set("asset", "inputs:file", Value::Asset(picture.asset.clone()));
        node.set("token", "inputs:sourceColorSpace", Value::token("raw"));
        if let Some(source) = coordinates {
            node.connect("float2", "inputs:st", source.clone());
        }
        let mode = |repeats: bool| Value::token(if repeats { "repeat" } else { "clamp" });
        node.set("token", "inputs:wrapS", mode(picture.repeats[0]));
        node.set("token", "inputs:wrapT", mode(picture.repeats[1]));
        if is_normals {
            node.set("float4", "inputs:scale", Value::Float4([2.0, 2.0, 2.0, 1.0]));
            node.set("float4", "inputs:bias", Value::Float4([-1.0, -1.0, -1.0, 0.0]));
        }
    })
}
