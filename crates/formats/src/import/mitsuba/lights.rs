//! Emitters without a surface.

use super::Element;
use crate::record::Note;
use glam::{DVec3, Vec3};
use unrender_scene::{Light, LightKind, Rgb, Warnings};

/// The light that `element` is, its position counted from `origin`; none if it is of a kind that is not known.
pub(super) fn read(
    element: &Element,
    note: &Note,
    origin: DVec3,
    warnings: &mut Warnings,
) -> Result<Option<Light>, String> {
    if note.light.is_some() {
        return Ok(note.light.clone());
    }
    let id = element.attribute("id");
    let name = note.name.clone().unwrap_or(if id.is_empty() { "light".into() } else { id });
    let world = element.to_world()?;
    let here = |world: DVec3| (world - origin).as_vec3();
    let ahead = world.transform_vector3(DVec3::Z).as_vec3();
    let kind = match element.attribute("type").as_str() {
        "point" => LightKind::Point {
            position: here(element.point("position").unwrap_or(world.translation)),
            intensity: element.rgb("intensity", Rgb::ONE)?,
        },
        "directional" => LightKind::Directional {
            direction: element.direction("direction").unwrap_or(ahead).normalize_or(Vec3::NEG_Y),
            irradiance: element.rgb("irradiance", Rgb::ONE)?,
        },
        "spot" => {
            let outer = element.float("cutoff_angle", 20.0)?;
            let inner = element.float("beam_width", 0.75 * outer)?;
            warnings.push(format!(
                "light \"{name}\": Mitsuba's spots fall off by the angle, not by its cosine"
            ));
            LightKind::Spot {
                position: here(world.translation),
                direction: ahead.normalize_or(Vec3::NEG_Y),
                intensity: element.rgb("intensity", Rgb::ONE)?,
                inner_rad: inner.min(outer).to_radians(),
                outer_rad: outer.to_radians(),
            }
        }
        _ => return Ok(None),
    };
    Ok(Some(Light { name, kind }))
}
