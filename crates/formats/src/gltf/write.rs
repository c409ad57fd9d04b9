//! A scene to a `.glb`: one node an object, a light, a camera; everything in world space.
//!
//! The vertices of a scene far from zero stay near it, and its nodes say where they are: those are numbers of
//! JSON, in double precision.

use super::glb::Glb;
use super::{Problem, lights, material, profiles, units, ward};
use crate::glasses::Glasses;
use crate::near;
use crate::numbers::{number, triple};
use crate::{LightUnits, group_detail};
use glam::{Affine3A, DVec3, Mat3, Vec3};
use serde_json::{Value, json};
use unrender_scene::origin::in_digits;
use unrender_scene::{Camera, Light, LightKind, Material, Mesh, Object, Scene};

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// Why a scene cannot be written as glTF.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the scene cannot be written as glTF: {0}")]
#[non_exhaustive]
pub struct GlbError(String);

/// The bytes of a `.glb` of `scene`, all of it in world space.
///
/// The exact Ward parameters stand in the `extras` of the materials; [`read`](super::read())
/// gets the same scene back, textures to the 8 bits of their PNGs.
///
/// # Errors
/// If the scene has coordinates that are not finite or is larger than 4 GiB.
pub fn to_glb(scene: &Scene) -> Result<Vec<u8>, GlbError> {
    build(scene, &scene.materials(), LightUnits::Radiometric).map_err(GlbError)
}

/// As [`to_glb`], but other programs see the materials `shown`, converted to glTF's own lobe (GGX),
/// one per group; the exact ones are the scene's. Its lights are in `units`.
///
/// # Errors
/// As those of [`to_glb`].
pub fn to_glb_as(
    scene: &Scene,
    shown: &[Material],
    units: LightUnits,
) -> Result<Vec<u8>, GlbError> {
    build(scene, shown, units).map_err(GlbError)
}

fn build(scene: &Scene, shown: &[Material], units: LightUnits) -> Result<Vec<u8>, Problem> {
    let mut glb = Glb::empty();
    glb.root["asset"] = json!({ "version": "2.0", "generator": units::GENERATOR });
    if units != LightUnits::Radiometric {
        units::note(&mut glb.root, units);
    }
    glb.root["scene"] = json!(0);
    for (index, shown) in (0..scene.groups.len()).zip(shown) {
        let material = glb.material(index, shown, scene)?;
        glb.push("materials", material);
    }
    let glasses = Glasses::of(scene);
    let kinds: Vec<usize> = glasses.kinds.iter().map(|kind| glb.push_glass(kind)).collect();
    let mut nodes = Vec::new();
    for object in &scene.objects {
        // glTF cannot express an object without triangles.
        if !object.mesh.triangles.is_empty() {
            let Object { name, group, mesh } = object;
            nodes.push(glb.mesh_node(name, mesh, *group, scene.origin)?);
        }
    }
    for shape in &glasses.shapes {
        nodes.push(glb.mesh_node(&shape.name, shape.mesh, kinds[shape.kind], scene.origin)?);
    }
    nodes.extend(
        scene.cameras.iter().map(|camera| {
            camera_node(&mut glb, (camera, near::written(scene, camera)), scene.origin)
        }),
    );
    nodes.extend(scene.lights.iter().map(|light| glb.light_node(light, scene.origin, units)));
    let indices: Vec<usize> = nodes.into_iter().map(|node| glb.push("nodes", node)).collect();
    // glTF forbids empty lists, this one as well.
    let nodes = if indices.is_empty() { json!({}) } else { json!({ "nodes": indices }) };
    glb.root["scenes"] = json!([nodes]);
    glb.finish()
}

impl Glb {
    fn material(
        &mut self,
        index: usize,
        shown: &Material,
        scene: &Scene,
    ) -> Result<Value, Problem> {
        let group = &scene.groups[index];
        let detail = group_detail::of_group(scene, index);
        let mut json = json!({ "name": group.name });
        if group.is_emitter() {
            material::set_emission(&mut json, group.emission);
        }
        self.paint(&mut json, (shown, &group.material), scene.brdf, detail.coverage.as_deref())?;
        self.emboss(&mut json, &detail)?;
        ward::note_exact(ward::object(&mut json), &group.material, scene.brdf);
        Ok(json)
    }

    fn mesh_node(
        &mut self,
        name: &str,
        mesh: &Mesh,
        material: usize,
        origin: DVec3,
    ) -> Result<Value, Problem> {
        let attributes = self
            .attributes(mesh)
            .ok_or_else(|| format!("object \"{name}\" has coordinates that are not finite"))?;
        let bytes: Vec<u8> =
            mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.push_view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        let indices = self.push(
            "accessors",
            json!({
                "bufferView": view,
                "componentType": UNSIGNED_INT,
                "count": 3 * mesh.triangles.len(),
                "type": "SCALAR",
            }),
        );
        let mesh = self.push(
            "meshes",
            json!({
                "name": name,
                "primitives": [
                    { "attributes": attributes, "indices": indices, "material": material }
                ],
            }),
        );
        let mut node = json!({ "name": name, "mesh": mesh });
        if origin != DVec3::ZERO {
            node["translation"] = json!(origin.to_array());
        }
        Ok(node)
    }

    fn attributes(&mut self, mesh: &Mesh) -> Option<Value> {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for position in &mesh.positions {
            (low, high) = (low.min(*position), high.max(*position));
        }
        if !mesh.positions.iter().all(|p| p.is_finite()) {
            return None;
        }
        let mut attributes = json!({});
        let position = self.floats(mesh.positions.iter().map(|p| p.to_array()), "VEC3");
        self.root["accessors"][position]["min"] = json!(triple(low));
        self.root["accessors"][position]["max"] = json!(triple(high));
        attributes["POSITION"] = json!(position);
        let normals = mesh.normals.iter().map(|n| n.to_array());
        attributes["NORMAL"] = json!(self.floats(normals, "VEC3"));
        if !mesh.tangents.is_empty() {
            let tangents = mesh.tangents.iter().map(|t| t.to_array());
            attributes["TANGENT"] = json!(self.floats(tangents, "VEC4"));
        }
        if !mesh.uvs.is_empty() {
            let uvs = mesh.uvs.iter().map(|uv| uv.to_array());
            attributes["TEXCOORD_0"] = json!(self.floats(uvs, "VEC2"));
        }
        Some(attributes)
    }

    fn floats<const N: usize>(
        &mut self,
        elements: impl ExactSizeIterator<Item = [f32; N]>,
        kind: &str,
    ) -> usize {
        let count = elements.len();
        let bytes: Vec<u8> = elements.flatten().flat_map(f32::to_le_bytes).collect();
        let view = self.push_view(&bytes, Some(ARRAY_BUFFER));
        let accessor =
            json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": kind });
        self.push("accessors", accessor)
    }

    fn light_node(&mut self, light: &Light, origin: DVec3, units: LightUnits) -> Value {
        let (mut json, place) = light_json(&light.kind, units);
        let extensions = if let LightKind::Profiled { profile, .. } = &light.kind {
            profiles::push(self, (profile, &light.name), json)
        } else {
            json["name"] = json!(light.name);
            let index = self.push_light("KHR_lights_punctual", json);
            json!({ "KHR_lights_punctual": { "light": index } })
        };
        json!({
            "name": light.name,
            "matrix": matrix(&place, origin),
            "extensions": extensions,
        })
    }
}

/// Lists `camera` in `glb` and returns a node that places it, its position counted from `origin`.
pub(super) fn camera_node(glb: &mut Glb, (camera, near): (&Camera, f32), origin: DVec3) -> Value {
    let mut perspective = json!({ "yfov": number(camera.fov_y_rad), "znear": number(near) });
    if let Some(aspect) = camera.aspect {
        perspective["aspectRatio"] = json!(number(aspect));
    }
    let index = glb.push(
        "cameras",
        json!({ "name": camera.name, "type": "perspective", "perspective": perspective }),
    );
    let matrix = matrix(&camera.world_from_camera, origin);
    json!({ "name": camera.name, "camera": index, "matrix": matrix })
}

fn light_json(kind: &LightKind, units: LightUnits) -> (Value, Affine3A) {
    let strong = |name: &str| {
        let (color, intensity) = lights::color_and_intensity(kind, units);
        json!({ "type": name, "color": color, "intensity": intensity })
    };
    match *kind {
        LightKind::Point { position, .. } => {
            (strong("point"), Affine3A::from_translation(position))
        }
        LightKind::Directional { direction, .. } => {
            (strong("directional"), along(direction, Vec3::ZERO))
        }
        LightKind::Spot { position, direction, inner_rad, outer_rad, .. } => {
            let mut json = strong("spot");
            let [inner, outer] = match units {
                LightUnits::Radiometric => [inner_rad, outer_rad].map(number),
                _ => lights::blenders_cone(inner_rad, outer_rad),
            };
            json["spot"] = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
            (json, along(direction, position))
        }
        LightKind::Profiled { position, direction, upright, .. } => {
            let axes = Mat3::from_cols(upright, upright.cross(direction), -direction);
            (profiles::strength_json(kind, units), Affine3A::from_mat3_translation(axes, position))
        }
    }
}

/// A motion that takes -z to `direction` and the origin to `position`.
fn along(direction: Vec3, position: Vec3) -> Affine3A {
    let back = -direction;
    let right = back.any_orthonormal_vector();
    Affine3A::from_mat3_translation(Mat3::from_cols(right, back.cross(right), back), position)
}

fn matrix(here_from_node: &Affine3A, origin: DVec3) -> [f64; 16] {
    let mut numbers = glam::Mat4::from(*here_from_node).to_cols_array().map(number);
    for axis in 0..3 {
        numbers[12 + axis] = in_digits(origin[axis], here_from_node.translation[axis]);
    }
    numbers
}
