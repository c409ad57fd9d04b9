//! Surfaces that let light through (`KHR_materials_transmission`): shapes of glass, which belong to no group.
//!
//! A shape with a `KHR_materials_volume` is solid, or thin where its thickness is zero. glTF calls others thin, and so they
//! are where they are open; but Blender writes no volume, and what it means by a closed shape of glass is a body.

use super::document::{Document, Material};
use super::material;
use super::ward::EXTRAS_KEY;
use unrender_scene::reflectance::IOR;
use unrender_scene::{Glass, Object, Rgb, Scene, Ungrouped};

/// Whether surfaces of the material `json` let light through. Lamps and what was recovered reflect.
fn lets_through(json: &Material) -> bool {
    let factor = json.extensions.transmission.as_ref().map_or(0.0, |t| t.transmission_factor);
    let is_dark = material::emission(json) == Some(Rgb::ZERO);
    factor > 0.0 && is_dark && json.extras.get(EXTRAS_KEY).is_none()
}

/// The glass of a material; that of a `closed` shape is solid.
fn glass(json: &Material, is_closed: bool) -> Glass {
    let stated = json.extensions.ior.as_ref().map_or(f64::from(IOR), |ior| ior.ior) as f32;
    let ior = if stated.is_finite() && stated > 0.0 { stated } else { IOR };
    let color = json.pbr_metallic_roughness.as_ref().map_or([1.0; 4], |pbr| pbr.base_color_factor);
    let color = Rgb::new(color[0] as f32, color[1] as f32, color[2] as f32);
    let color = color.clamp(Rgb::ZERO, Rgb::ONE);
    let written = json.extensions.volume.as_ref();
    let volume = written.filter(|volume| volume.thickness_factor > 0.0);
    let is_thin = volume.is_none() && (written.is_some() || !is_closed);
    let absorption = volume.map_or(Rgb::ZERO, |volume| {
        let left = Rgb::from_array(volume.attenuation_color.map(|c| c as f32));
        let per_metre = -left.clamp(Rgb::splat(f32::MIN_POSITIVE), Rgb::ONE).ln();
        let distance = volume.attenuation_distance.unwrap_or(f64::INFINITY) as f32;
        if distance > 0.0 { per_metre / distance } else { Rgb::ZERO }
    });
    // Light passes two faces of a body, each with the root of the colour, as in Blender.
    let tint = if is_thin { color } else { color.map(f32::sqrt) };
    Glass { ior, tint, absorption, is_thin }
}

/// Takes the objects of glass, whose group is still the index of a material, out of those of `scene`.
pub(super) fn set_apart(document: &Document, names: &[String], scene: &mut Scene) {
    let material = |object: &Object| {
        document.materials.get(object.group).filter(|material| lets_through(material))
    };
    let objects = std::mem::take(&mut scene.objects).into_iter();
    let (clear, kept): (Vec<_>, Vec<_>) = objects.partition(|object| material(object).is_some());
    scene.objects = kept;
    let shape = |object: Object| {
        let glass = material(&object).map(|json| glass(json, object.mesh.is_closed()));
        let name = names.get(object.group).cloned().unwrap_or_default();
        Ungrouped { material: name, mesh: object.mesh, glass }
    };
    scene.ungrouped.extend(clear.into_iter().map(shape));
}
