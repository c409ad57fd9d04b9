//! `EXT_lights_ies`: lamps by photometric profiles, from nodes and back into the file.
//!
//! A lamp stands at its node's origin. The directions of the profile's table are those of the node: the axis is -z, and
//! the horizontal angle 0 of type C, or upwards of types A and B, is +x. Its radiant intensity is
//! `color * multiplier * candela`, in the [units](super::units) of the file's lights.

use super::Problem;
use super::document::NodeProfile;
use super::geometry::unit;
use super::glb::{Glb, PROFILE_MIME, PROFILES};
use super::graph::Placed;
use super::lights::color_and_intensity;
use super::names::{given, holder};
use super::source::{Source, get};
use super::ward::object;
use crate::{LightUnits, ies};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use unrender_scene::{Light, LightKind, LightProfile, Rgb, Warnings};

/// The lamp of a node; none if the file of its profile is missing.
pub(super) fn light(
    source: &Source,
    json: &NodeProfile,
    node_name: Option<&str>,
    placed: &Placed,
    warnings: &mut Warnings,
) -> Result<Option<Light>, Problem> {
    let name = name_of(source, json, node_name)?.to_owned();
    let problem = |what: &str| format!("light \"{name}\" {what}; export the scene again");
    let Some(bytes) = source.profile(json.light)? else { return Ok(None) };
    let no_tilt = |_: &str| Err("is not part of glTF".into());
    let (profile, told) = ies::parse(&bytes, &no_tilt)
        .map_err(|what| format!("light \"{name}\": its profile {what}"))?;
    told.0.into_iter().for_each(|told| warnings.push(format!("light \"{name}\": {told}")));
    let intensity = strength(json, &profile, source.light_units);
    if !intensity.is_finite() || intensity.min_element() < 0.0 {
        return Err(problem("has a negative or infinite intensity"));
    }
    let world_from_node = &placed.world_from_node;
    let position: Vec3 = world_from_node.translation.as_vec3();
    let direction = unit(-world_from_node.matrix3.z_axis);
    if !position.is_finite() || !direction.is_finite() {
        return Err(problem("stands at no finite place"));
    }
    if direction == Vec3::ZERO {
        return Err(problem("has no direction, as its node is scaled to nothing"));
    }
    let upright = unit(world_from_node.matrix3.x_axis);
    let is_straight = upright.dot(direction).abs() < 1e-6;
    let upright = if is_straight { upright } else { LightKind::upright(direction, upright) };
    let kind = LightKind::Profiled { position, direction, upright, intensity, profile };
    Ok(Some(Light { name, kind }))
}

fn name_of<'a>(
    source: &'a Source,
    json: &NodeProfile,
    node_name: Option<&'a str>,
) -> Result<&'a str, Problem> {
    let profile = get(&source.document.extensions.profiles.lights, json.light, "profile")?;
    Ok(node_name.or_else(|| given(profile.name.as_ref())).unwrap_or("light"))
}

/// The radiant intensity where the profile has its greatest, by channel.
fn strength(json: &NodeProfile, profile: &LightProfile, units: LightUnits) -> Rgb {
    let of_one = profile.peak_candela() * units.radiometric_of_candela();
    (DVec3::from_array(json.color) * (json.multiplier * of_one)).as_vec3()
}

/// What a node says of the strength of a profiled light.
pub(super) fn strength_json(kind: &LightKind, units: LightUnits) -> Value {
    let LightKind::Profiled { profile, .. } = kind else { return Value::Null };
    let (color, intensity) = color_and_intensity(kind, units);
    let of_one = profile.peak_candela() * units.radiometric_of_candela();
    json!({ "color": color, "multiplier": intensity * units.radiometric(false) / of_one })
}

/// Lists `profile` of the lamp `name` in `glb`; the extensions of its node, whose strength is `strength`.
pub(super) fn push(
    glb: &mut Glb,
    (profile, name): (&LightProfile, &str),
    mut strength: Value,
) -> Value {
    let view = glb.push_view(ies::text(profile, name).as_bytes(), None);
    let json = json!({ "name": name, "bufferView": view, "mimeType": PROFILE_MIME });
    strength["light"] = json!(glb.push_light(PROFILES, json));
    json!({ PROFILES: strength })
}

/// Makes the lamp of the node `placed` as bright as the next one that is wanted, if that has its name.
pub(super) fn assign<'a>(
    glb: &mut Glb,
    source: &Source,
    (placed, json): (&Placed, &NodeProfile),
    wanted: &mut impl Iterator<Item = &'a Light>,
) -> Result<(), Problem> {
    if source.profile(json.light)?.is_none() {
        return Ok(());
    }
    let name = name_of(source, json, holder(&source.document, placed))?;
    let Some(light) = wanted.next().filter(|light| light.name == name) else { return Ok(()) };
    let LightKind::Profiled { profile, intensity, .. } = &light.kind else { return Ok(()) };
    if strength(json, profile, source.light_units) != *intensity {
        let new = strength_json(&light.kind, source.light_units);
        let node = object(&mut glb.root["nodes"][placed.node]["extensions"][PROFILES]);
        for key in ["color", "multiplier"] {
            node.insert(key.into(), new[key].clone());
        }
    }
    Ok(())
}
