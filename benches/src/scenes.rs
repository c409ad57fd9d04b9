//! The scenes of the measurements: Figure 8, and a room of any number of triangles.

mod cube;
mod noise;
mod room;

pub(crate) use cube::blown_up_cube;
pub(crate) use room::{Room, room};

use crate::{Failure, root};
use glam::Vec3;
use unrender::formats::{load_scene, materials};
use unrender::scene::Scene;

/// The paper's Figure 8 with its true materials.
///
/// # Errors
/// If the example is not there.
pub(crate) fn figure8() -> Result<Scene, Failure> {
    let folder = root().join("examples/fig8");
    let (mut scene, _) = load_scene(&folder.join("scene.glb"))?;
    materials::apply_from(&folder.join("truth.json"), &mut scene)?;
    scene.validate()?;
    Ok(scene)
}

/// The corners of all triangles of a scene, object by object.
pub(crate) fn triangles(scene: &Scene) -> Vec<[Vec3; 3]> {
    let of = |mesh: &unrender::scene::Mesh| {
        (0..mesh.triangles.len()).map(|index| mesh.corners(index)).collect::<Vec<_>>()
    };
    scene.objects.iter().flat_map(|object| of(&object.mesh)).collect()
}
