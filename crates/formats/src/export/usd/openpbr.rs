//! OpenPBR as nodes of MaterialX, for programs that read those. [OpenPBR 1.1; MaterialX specification 1.39]
//!
//! With the roughness `r` and the anisotropy `a`, the alpha along the tangent is `r^2 sqrt(2/(1 + (1 - a)^2))`, across it
//! `1 - a` times that. Meshes of brushed groups have texture coordinates that grow along the rougher direction, from which
//! programs take the tangent.

use super::network::{Group, Network, Picture};
use super::stage::{Prim, Value};
use crate::export::layered::{Layered, Transmission, strength_and_color};
use unrender_scene::{Glass, Rgb};

/// The output of MaterialX's nodes.
const OUT: &str = "outputs:out";

/// Adds the surface of `group`; returns the path of its output.
pub(super) fn group(group: &Group, network: &mut Network) -> String {
    let coordinates = group.has_pictures().then(|| {
        network.node("openpbr_st", "ND_geompropvalue_vector2", ("float2", OUT), |node| {
            node.set("string", "inputs:geomprop", Value::String("st".into()));
        })
    });
    let mut read = |name: &str, id: &str, kind, picture: &Picture| {
        image((name, id, kind), picture, &coordinates, network)
    };
    let color = group.texture.as_ref();
    let color = color.map(|picture| read("openpbr_color", "ND_image_color3", "color3f", picture));
    let normals = group.normals.as_ref();
    let normals =
        normals.map(|picture| read("openpbr_bumps", "ND_image_vector3", "float3", picture));
    let coverage = group.holes.as_ref().map(|(picture, cutoff)| {
        (read("openpbr_coverage", "ND_image_float", "float", picture), *cutoff)
    });
    let normals = normals.map(|source| {
        network.node("openpbr_normals", "ND_normalmap_float", ("float3", OUT), |node| {
            node.connect("float3", "inputs:in", source);
        })
    });
    let opacity = coverage.map(|(source, cutoff)| cut(source, cutoff, network));
    surface(network, |node| {
        layers(&group.layered, color, node);
        if group.emission.max_element() > 0.0 {
            let (strength, color) = strength_and_color(group.emission);
            node.set("float", "inputs:emission_luminance", Value::Float(strength));
            node.set("color3f", "inputs:emission_color", Value::Float3(color));
        }
        if let Some(source) = normals {
            node.connect("float3", "inputs:geometry_normal", source);
        }
        if let Some(source) = opacity {
            node.connect("float", "inputs:geometry_opacity", source);
        }
    })
}

/// The inputs of base and lobe, with the base colour from `color` if that is a picture.
fn layers(layered: &Layered, color: Option<String>, node: &mut Prim) {
    let share = |is_there: bool| Value::Float(if is_there { 1.0 } else { 0.0 });
    let roughness = roughness(layered.alphas);
    node.set("float", "inputs:base_weight", Value::Float(1.0));
    match color {
        Some(source) => node.connect("color3f", "inputs:base_color", source),
        None => node.set("color3f", "inputs:base_color", Value::Float3(layered.base_color)),
    }
    node.set("float", "inputs:base_metalness", share(layered.is_metal));
    node.set("float", "inputs:specular_weight", share(layered.shines));
    node.set("color3f", "inputs:specular_color", Value::Float3(layered.specular_color));
    node.set("float", "inputs:specular_ior", Value::Float(layered.ior));
    node.set("float", "inputs:specular_roughness", Value::Float(roughness));
    let anisotropy = 1.0 - layered.aspect();
    node.set("float", "inputs:specular_roughness_anisotropy", Value::Float(anisotropy));
}

/// The roughness that gives these alphas at the anisotropy of their ratio.
pub(super) fn roughness([smooth, rough]: [f32; 2]) -> f32 {
    (0.5 * (smooth * smooth + rough * rough)).sqrt().sqrt().min(1.0)
}

/// Adds the surface of glass; returns the path of its output.
pub(super) fn glass(glass: &Glass, transmission: Transmission, network: &mut Network) -> String {
    surface(network, |node| {
        node.set("color3f", "inputs:base_color", Value::Float3(Rgb::ZERO));
        node.set("float", "inputs:specular_weight", Value::Float(1.0));
        node.set("float", "inputs:specular_ior", Value::Float(glass.ior));
        node.set("float", "inputs:specular_roughness", Value::Float(0.0));
        node.set("float", "inputs:transmission_weight", Value::Float(1.0));
        node.set("color3f", "inputs:transmission_color", Value::Float3(transmission.color));
        node.set("float", "inputs:transmission_depth", Value::Float(transmission.depth));
        node.set("bool", "inputs:geometry_thin_walled", Value::Bool(glass.is_thin));
    })
}

fn surface(network: &mut Network, inputs: impl FnOnce(&mut Prim)) -> String {
    network.node("openpbr", "ND_open_pbr_surface_surfaceshader", ("token", OUT), inputs)
}

/// Adds the reader of `picture`, of a name, a kind and a type; returns the path of its output.
fn image(
    (name, id, kind): (&str, &str, &'static str),
    picture: &Picture,
    coordinates: &Option<String>,
    network: &mut Network,
) -> String {
    network.node(name, id, (kind, OUT), |node| {
        node.set("asset", "inputs:file", Value::Asset(picture.asset.clone()));
        if let Some(source) = coordinates {
            node.connect("float2", "inputs:texcoord", source.clone());
        }
        let mode = |repeats: bool| Value::String(if repeats { "periodic" } else { "clamp" }.into());
        node.set("string", "inputs:uaddressmode", mode(picture.repeats[0]));
        node.set("string", "inputs:vaddressmode", mode(picture.repeats[1]));
    })
}

/// Adds a node that is 1 where `coverage` is at least the cutoff and 0 elsewhere; returns the path of its output.
fn cut(coverage: String, cutoff: f32, network: &mut Network) -> String {
    network.node("openpbr_holes", "ND_ifgreatereq_float", ("float", OUT), |node| {
        node.connect("float", "inputs:value1", coverage);
        node.set("float", "inputs:value2", Value::Float(cutoff));
        node.set("float", "inputs:in1", Value::Float(1.0));
        node.set("float", "inputs:in2", Value::Float(0.0));
    })
}
