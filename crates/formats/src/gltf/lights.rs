//! `KHR_lights_punctual` and cameras, from nodes; and the lights of a scene back into its file.

use super::Problem;
use super::document::{Camera as CameraJson, Document, Light as LightJson, Node};
use super::geometry::unit;
use super::graph::placed_nodes;
use super::names::given;
use super::source::get;
use super::ward::object;
use super::write::Glb;
use crate::numbers::color_and_factor;
use glam::{Affine3A, DAffine3, DVec3, Mat3, Vec3};
use serde_json::{Value, json};
use unrender_scene::{Camera, Lens, Light, LightKind, Rgb, Scene, Warnings};

const PUNCTUAL: &str = "KHR_lights_punctual";

/// The light of a node; it stands at the node's origin and shines along its -z.
pub(super) fn light(
    json: &LightJson,
    node_name: Option<&str>,
    world_from_node: &DAffine3,
    warnings: &mut Warnings,
) -> Result<Light, Problem> {
    let name = name_of(json, node_name).to_owned();
    let problem = |what: &str| format!("light \"{name}\" {what}; export the scene again");
    let strength = strength(json);
    if !strength.is_finite() || strength.min_element() < 0.0 {
        return Err(problem("has a negative or infinite intensity"));
    }
    if json.range.is_some() {
        warnings.push(format!("light \"{name}\": its range was ignored; light has no end."));
    }
    let position: Vec3 = world_from_node.translation.as_vec3();
    let direction = unit(-world_from_node.matrix3.z_axis);
    if !position.is_finite() || !direction.is_finite() {
        return Err(problem("stands at no finite place"));
    }
    if direction == Vec3::ZERO && json.kind != "point" {
        return Err(problem("has no direction, as its node is scaled to nothing"));
    }
    let kind = match json.kind.as_str() {
        "point" => LightKind::Point { position, intensity: strength },
        "directional" => LightKind::Directional { direction, irradiance: strength },
        "spot" => {
            let outer_rad = json.spot.outer_cone_angle as f32;
            if !(outer_rad > 0.0 && outer_rad <= std::f32::consts::FRAC_PI_2) {
                return Err(problem("has an outerConeAngle outside 0 to pi/2"));
            }
            let inner_rad = (json.spot.inner_cone_angle as f32).clamp(0.0, 0.999 * outer_rad);
            LightKind::Spot { position, direction, intensity: strength, inner_rad, outer_rad }
        }
        other => return Err(problem(&format!("is of the unknown type \"{other}\""))),
    };
    Ok(Light { name, kind })
}

fn name_of<'a>(json: &'a LightJson, node_name: Option<&'a str>) -> &'a str {
    node_name.or_else(|| given(json.name.as_ref())).unwrap_or("light")
}

fn strength(json: &LightJson) -> Rgb {
    (DVec3::from_array(json.color) * json.intensity).as_vec3()
}

/// Makes the lights of the file `document`, which `glb` is to become, as bright as those of `scene`,
/// which was read from it.
pub(super) fn dress(glb: &mut Glb, document: &Document, scene: &Scene) -> Result<(), Problem> {
    let mut wanted = scene.lights.iter();
    for placed in placed_nodes(document)? {
        let node = get(&document.nodes, placed.node, "node")?;
        let Some(index) = node.extensions.punctual.as_ref().map(|punctual| punctual.light) else {
            continue;
        };
        let json = get(&document.extensions.punctual.lights, index, "light")?;
        let name = name_of(json, given(node.name.as_ref()));
        let Some(light) = wanted.next().filter(|light| light.name == name) else { continue };
        if strength(json) == light.kind.strength() {
            continue;
        }
        let uses = |other: &Node| other.extensions.punctual.as_ref().map(|p| p.light);
        let shared = document.nodes.iter().filter(|other| uses(other) == Some(index)).count() > 1;
        let own = if shared { own_light(glb, placed.node, index) } else { index };
        let (color, intensity) = color_and_factor(light.kind.strength());
        let json = object(&mut glb.root["extensions"][PUNCTUAL]["lights"][own]);
        json.insert("color".into(), color);
        json.insert("intensity".into(), json!(intensity));
    }
    Ok(())
}

/// Gives `node` a copy of the light that it shares with others; returns the copy's index.
fn own_light(glb: &mut Glb, node: usize, light: usize) -> usize {
    let Value::Array(lights) = &mut glb.root["extensions"][PUNCTUAL]["lights"] else {
        return light;
    };
    lights.push(lights[light].clone());
    let own = lights.len() - 1;
    glb.root["nodes"][node]["extensions"][PUNCTUAL]["light"] = json!(own);
    own
}

/// The camera of a node, if it is one in perspective.
pub(super) fn camera(
    json: &CameraJson,
    node_name: Option<&str>,
    world_from_node: &DAffine3,
    warnings: &mut Warnings,
) -> Result<Option<Camera>, Problem> {
    let name = node_name.or_else(|| given(json.name.as_ref())).unwrap_or("camera").to_owned();
    let Some(perspective) = &json.perspective else {
        warnings.push(format!(
            "camera \"{name}\" is not in perspective and was left out; make it a perspective camera."
        ));
        return Ok(None);
    };
    let fov_y_rad = perspective.yfov as f32;
    let aspect = perspective.aspect_ratio.map(|aspect| aspect as f32);
    let has_fov = fov_y_rad > 0.0 && fov_y_rad < std::f32::consts::PI;
    let has_aspect = aspect.is_none_or(|aspect| aspect.is_finite() && aspect > 0.0);
    if !has_fov || !has_aspect {
        return Err(format!(
            "camera \"{name}\" has a yfov outside 0 to pi or no valid aspectRatio; export it again"
        ));
    }
    if world_from_node.matrix3.determinant() < 0.0 {
        warnings.push(format!("camera \"{name}\" is mirrored by its node; it was turned back."));
    }
    let world_from_camera = rigid(world_from_node).ok_or_else(|| {
        format!("camera \"{name}\" is scaled to nothing or stands at no finite place; move it")
    })?;
    Ok(Some(Camera { name, world_from_camera, fov_y_rad, aspect, lens: Lens::default() }))
}

/// The motion without scale and shear that keeps where the camera looks and, nearly, its right.
fn rigid(transform: &DAffine3) -> Option<Affine3A> {
    let m = transform.matrix3;
    let error = m.transpose() * m - glam::DMat3::IDENTITY;
    let is_rigid = error.to_cols_array().iter().all(|e| e.abs() < 1e-6) && m.determinant() > 0.0;
    let axes: Mat3 = if is_rigid {
        m.as_mat3()
    } else {
        let back = m.z_axis.try_normalize()?;
        let right = m.y_axis.cross(back).try_normalize()?;
        glam::DMat3::from_cols(right, back.cross(right), back).as_mat3()
    };
    let rigid = Affine3A::from_mat3_translation(axes, transform.translation.as_vec3());
    rigid.is_finite().then_some(rigid)
}
