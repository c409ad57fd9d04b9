//! Surfaces that let light through (`KHR_materials_transmission`): their shapes are left out of the scene.

use super::document::{Document, Material};
use super::material;
use super::ward::EXTRAS_KEY;
use unrender_scene::{LeftOut, Rgb, Scene};

/// Whether surfaces of the material `json` let light through. Lamps and what was recovered reflect.
fn lets_through(json: &Material) -> bool {
    let factor = json.extensions.transmission.as_ref().map_or(0.0, |t| t.transmission_factor);
    let is_dark = material::emission(json) == Some(Rgb::ZERO);
    factor > 0.0 && is_dark && json.extras.get(EXTRAS_KEY).is_none()
}

/// Takes the objects out of `scene` whose group, still the index of a material, lets light through.
pub(super) fn leave_out(document: &Document, names: &[String], scene: &mut Scene) {
    let is_clear = |material: usize| document.materials.get(material).is_some_and(lets_through);
    let objects = std::mem::take(&mut scene.objects).into_iter();
    let (clear, kept): (Vec<_>, Vec<_>) = objects.partition(|object| is_clear(object.group));
    scene.objects = kept;
    let shape = |object: unrender_scene::Object| {
        let material = names.get(object.group).cloned().unwrap_or_default();
        LeftOut { material, mesh: object.mesh }
    };
    scene.left_out.extend(clear.into_iter().map(shape));
}
