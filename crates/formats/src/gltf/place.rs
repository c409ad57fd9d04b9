//! The file that a scene came from, with one camera more.

use super::Problem;
use super::source::Source;
use super::write::Glb;
use crate::{FileError, Input};
use serde_json::json;
use unrender_scene::Camera;

/// The bytes of a `.glb` with everything that is in the glTF file `source`, and `camera` in its
/// default scene. A camera of the same name there is replaced. What the lens does cannot be said.
///
/// # Errors
/// If `source` cannot be read, or if the result would be larger than 4 GiB.
pub fn place<'a>(source: impl Into<Input<'a>>, camera: &Camera) -> Result<Vec<u8>, FileError> {
    let source = source.into();
    let fail = |problem| FileError::new(source.path, problem);
    let opened = Source::open(source).map_err(fail)?;
    placed(&opened, camera).map_err(fail)
}

fn placed(source: &Source, camera: &Camera) -> Result<Vec<u8>, Problem> {
    let mut glb = Glb::embedding(source);
    let node = glb.camera_node(camera);
    let scene = glb.root["scene"].as_u64().unwrap_or(0) as usize;
    if glb.root["scenes"].get(scene).is_none() {
        return Err("has no scene to place a camera in; export it again".into());
    }
    let roots = glb.root["scenes"][scene]["nodes"].as_array().cloned().unwrap_or_default();
    let taken = |index: &usize| {
        let node = &glb.root["nodes"][*index];
        node["name"] == json!(camera.name) && node.get("camera").is_some()
    };
    let indices = roots.iter().filter_map(|root| root.as_u64()).map(|root| root as usize);
    let replaced = indices.into_iter().find(taken);
    match replaced {
        Some(index) => glb.root["nodes"][index] = node,
        None => {
            let index = glb.push("nodes", node);
            let mut roots = roots;
            roots.push(json!(index));
            glb.root["scenes"][scene]["nodes"] = json!(roots);
        }
    }
    glb.finish()
}
