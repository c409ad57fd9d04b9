//! `KHR_lights_punctual` and cameras, from nodes; and the lights of a scene back into its file.

use super::Problem;
use super::document::{Camera as CameraJson, Light as LightJson, Node};
use super::geometry::unit;
use super::glb::Glb;
use super::graph::Placed;
use super::names::{given, holder};
use super::source::{Source, get};
use super::ward::object;
use crate::LightUnits;
use crate::numbers::color_and_factor;
use glam::{Affine3A, DAffine3, DVec3, Mat3, Vec3};
use serde_json::{Value, json};
use std::f32::consts::FRAC_PI_2;
use unrender_scene::{Camera, Lens, Light, LightKind, Rgb, Warnings};

const PUNCTUAL: &str = "KHR_lights_punctual";

/// The light of a node; it stands at the node's origin and shines along its -z. Whether Blender's exporter
/// wrote it decides what the angles of spots mean.
pub(super) fn light(
    json: &LightJson,
    node_name: Option<&str>,
    placed: &Placed,
    (units, is_blenders): (LightUnits, bool),
    warnings: &mut Warnings,
) -> Result<Light, Problem> {
    let world_from_node = &placed.world_from_node;
    let name = name_of(json, node_name).to_owned();
    let problem = |what: &str| format!("light \"{name}\" {what}; export the scene again");
    let strength = strength(json, units);
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
            let (inner, outer) = (json.spot.inner_cone_angle, json.spot.outer_cone_angle);
            if !(outer > 0.0 && outer as f32 <= FRAC_PI_2) {
                return Err(problem("has an outerConeAngle outside 0 to pi/2"));
            }
            let [inner, outer] =
                if is_blenders { cycles_cone(inner, outer) } else { [inner, outer] };
            let outer_rad = (outer as f32).min(FRAC_PI_2);
            let inner_rad = (inner as f32).clamp(0.0, 0.999 * outer_rad);
            LightKind::Spot { position, direction, intensity: strength, inner_rad, outer_rad }
        }
        other => return Err(problem(&format!("is of the unknown type \"{other}\""))),
    };
    Ok(Light { name, kind })
}

/// The cone whose light is that of Cycles where Blender's exporter wrote these angles.
///
/// It writes `outer` for half the spot's size and `outer (1 - blend)` for `inner`. Cycles' light falls off by
/// a smooth step in the cosine, over `w = blend (1 - cos outer)` above that of `outer`. The square of a line,
/// which glTF has, sends as much light from `cos outer - w/2` to `cos outer + w`, and differs nowhere by more
/// than 15 % of the spot's intensity. With the angles taken as they are, a new spot (blend 0.15) would send
/// 12 % less.
fn cycles_cone(inner: f64, outer: f64) -> [f64; 2] {
    let blend = (1.0 - inner / outer).clamp(0.0, 1.0);
    let width = blend * (1.0 - outer.cos());
    [outer.cos() + width, (outer.cos() - 0.5 * width).max(0.0)].map(|cos| cos.min(1.0).acos())
}

/// The angles `inner` and `outer` as Blender's exporter writes a spot of this cone: [`cycles_cone`] gives the cone back.
pub(super) fn blenders_cone(inner_rad: f32, outer_rad: f32) -> [f64; 2] {
    let [inner, outer] = [inner_rad, outer_rad].map(|angle| f64::from(angle).cos());
    let width = (inner - outer) / 1.5;
    let cos = inner - width;
    // A sharp and narrow spot has no width to divide.
    let blend = if cos < 1.0 { (width / (1.0 - cos)).clamp(0.0, 1.0) } else { 0.0 };
    let outer = cos.acos();
    [outer * (1.0 - blend), outer]
}

fn name_of<'a>(json: &'a LightJson, node_name: Option<&'a str>) -> &'a str {
    node_name.or_else(|| given(json.name.as_ref())).unwrap_or("light")
}

/// The radiant intensity or irradiance of a light, by channel.
fn strength(json: &LightJson, units: LightUnits) -> Rgb {
    let radiometric = units.radiometric(json.kind == "directional");
    (DVec3::from_array(json.color) * json.intensity * radiometric).as_vec3()
}

/// The colour of a light of this strength, and its intensity in `units`: to the bit for our own files;
/// else the colour's greatest channel is one, and the power is that of the light.
pub(super) fn color_and_intensity(kind: &LightKind, units: LightUnits) -> (Value, f64) {
    let strength = kind.strength().as_dvec3();
    let greatest = strength.max_element();
    if units == LightUnits::Radiometric || greatest <= 0.0 {
        return color_and_factor(kind.strength());
    }
    let is_directional = matches!(kind, LightKind::Directional { .. });
    (json!((strength / greatest).to_array()), greatest / units.radiometric(is_directional))
}

/// Makes the light with the index `index` of the node `placed` as bright as the next one that is wanted, if that has its
/// name, in the file's own units.
pub(super) fn assign<'a>(
    glb: &mut Glb,
    source: &Source,
    (placed, index): (&Placed, usize),
    wanted: &mut impl Iterator<Item = &'a Light>,
) -> Result<(), Problem> {
    let (document, units) = (&source.document, source.light_units);
    let json = get(&document.extensions.punctual.lights, index, "light")?;
    let name = name_of(json, holder(document, placed));
    let Some(light) = wanted.next().filter(|light| light.name == name) else { return Ok(()) };
    if strength(json, units) == light.kind.strength() {
        return Ok(());
    }
    let uses = |other: &Node| other.extensions.punctual.as_ref().map(|p| p.light);
    let shared = document.nodes.iter().filter(|other| uses(other) == Some(index)).count() > 1;
    let own = if shared { own_light(glb, placed.node, index) } else { index };
    let (color, intensity) = color_and_intensity(&light.kind, units);
    let json = object(&mut glb.root["extensions"][PUNCTUAL]["lights"][own]);
    json.insert("color".into(), color);
    json.insert("intensity".into(), json!(intensity));
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

/// The name of a camera: that of its node, else its own.
pub(super) fn camera_name<'a>(json: &'a CameraJson, node_name: Option<&'a str>) -> &'a str {
    node_name.or_else(|| given(json.name.as_ref())).unwrap_or("camera")
}

/// The camera of a node, if it is one in perspective.
pub(super) fn camera(
    json: &CameraJson,
    node_name: Option<&str>,
    world_from_node: &DAffine3,
    warnings: &mut Warnings,
) -> Result<Option<Camera>, Problem> {
    let name = camera_name(json, node_name).to_owned();
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
    let (size, lens) = (None, Lens::default());
    let near = perspective.znear as f32;
    let near = if near.is_finite() && near > 0.0 { near } else { 0.0 };
    Ok(Some(Camera { name, world_from_camera, fov_y_rad, aspect, size, lens, near }))
}

/// The motion without scale and shear that keeps the camera's view direction and, nearly, its right
/// axis.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spot_from_blender_falls_off_as_in_cycles() {
        let (size, blend) = (45f64.to_radians(), 0.15);
        let outer = 0.5 * size;
        let cone = cycles_cone(outer * (1.0 - blend), outer).map(f64::cos);
        let cycles = |cos: f64| {
            let t = (cos - outer.cos()) / (blend * (1.0 - outer.cos()));
            let t = t.clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        let gltf = |cos: f64| ((cos - cone[1]) / (cone[0] - cone[1])).clamp(0.0, 1.0).powi(2);
        let cosines = || (0..=10_000).map(|i| 0.9 + 1e-5 * f64::from(i));
        let sum = |of: &dyn Fn(f64) -> f64| cosines().map(of).sum::<f64>();
        assert!((sum(&gltf) / sum(&cycles) - 1.0).abs() < 1e-3);
        let apart = cosines().map(|cos| (gltf(cos) - cycles(cos)).abs()).fold(0.0, f64::max);
        assert!(apart < 0.15, "{apart}");
        // Without blend the edge is sharp.
        assert_eq!(cycles_cone(outer, outer), [outer.cos().acos(); 2]);
        // Blender gets back what it wrote, also of the softest spot.
        for blend in [0.0, 0.15, 1.0] {
            let [inner_rad, outer_rad] =
                cycles_cone(outer * (1.0 - blend), outer).map(|angle| angle as f32);
            let [inner, again] = blenders_cone(inner_rad, outer_rad);
            assert!((again - outer).abs() < 1e-6 && (inner - outer * (1.0 - blend)).abs() < 1e-5);
        }
    }
}
