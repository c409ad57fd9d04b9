//! The file that a scene came from, with one more camera.

use super::Problem;
use super::glb::Glb;
use super::graph::{Placed, placed_nodes};
use super::lights::camera_name;
use super::names::holder;
use super::source::Source;
use super::ward::object;
use super::write::camera_node;
use crate::{FileError, Input};
use glam::DVec3;
use serde_json::json;
use unrender_scene::Camera;

/// The near clipping plane of a camera without one, metres: the format requires one. A reader that finds nothing before it
/// passes over it; half of it serves as well, at double it may cut into scenes of a few centimetres.
const NEAR: f32 = 1e-3;

/// The bytes of a `.glb` with everything that is in the glTF file `source`, and `camera`, whose position counts
/// from `origin`, in its
/// default scene. A camera of the same name there is replaced. Distortion cannot be expressed.
///
/// # Errors
/// If `source` cannot be read, or if the result would be larger than 4 GiB.
pub fn place<'a>(
    source: impl Into<Input<'a>>,
    camera: &Camera,
    origin: DVec3,
) -> Result<Vec<u8>, FileError> {
    let source = source.into();
    let fail = |problem| FileError::new(source.path, problem);
    let opened = Source::open(source).map_err(fail)?;
    placed(&opened, camera, origin).map_err(fail)
}

fn placed(source: &Source, camera: &Camera, origin: DVec3) -> Result<Vec<u8>, Problem> {
    let mut glb = Glb::embedding(source);
    if !put(&mut glb, source, camera, origin)? {
        return Err("has no scene to place a camera in; export it again".into());
    }
    glb.finish()
}

/// Puts `camera` into the default scene of `glb`, which embeds `source`, as [`place`] does; false if it has no scene.
pub(super) fn put(
    glb: &mut Glb,
    source: &Source,
    camera: &Camera,
    origin: DVec3,
) -> Result<bool, Problem> {
    let document = &source.document;
    let scene = glb.root["scene"].as_u64().unwrap_or(0) as usize;
    if glb.root["scenes"].get(scene).is_none() {
        return Ok(false);
    }
    let mut former = None;
    for placed in placed_nodes(document)? {
        let held = document.nodes[placed.node].camera.and_then(|index| document.cameras.get(index));
        if held.is_some_and(|held| camera_name(held, holder(document, &placed)) == camera.name) {
            former = Some(placed);
            break;
        }
    }
    let near = if camera.near > 0.0 { camera.near } else { NEAR };
    let node = camera_node(glb, (camera, near), origin);
    let stands_alone = |former: &Placed| {
        let node = &document.nodes[former.node];
        let holds_more = node.mesh.is_some()
            || node.extensions.punctual.is_some()
            || node.extensions.profiled.is_some();
        former.parent.is_none() && node.children.is_empty() && !holds_more
    };
    match former {
        Some(former) if stands_alone(&former) => glb.root["nodes"][former.node] = node,
        former => {
            // The children of the node and its parent stay as they are.
            if let Some(former) = former {
                object(&mut glb.root["nodes"][former.node]).remove("camera");
            }
            let index = glb.push("nodes", node);
            let roots = &glb.root["scenes"][scene]["nodes"];
            let mut roots = roots.as_array().cloned().unwrap_or_default();
            roots.push(json!(index));
            glb.root["scenes"][scene]["nodes"] = json!(roots);
        }
    }
    Ok(true)
}
