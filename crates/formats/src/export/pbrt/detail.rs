//! Normal maps and holes: the parameter `normalmap` of materials, and `alpha` of shapes.
//!
//! PBRT takes a normal's y to be along `normal x dp/du`: upwards in the picture, as ours is, but where the picture lies
//! mirrored upon a mesh. Objects of that kind have materials of their own. Alpha lets light through by chance: ours is a
//! stencil, which is not interpolated.

use crate::export::{Files, SceneView, maps, tiling};
use crate::group_detail;
use crate::texels;
use unrender_scene::Warnings;

/// What PBRT does with the edges of normal maps.
const REPEATED: &str = "PBRT repeats normal maps beyond the edges that they should hold";

/// The parameter of a shape that names the holes of group `id`.
pub(super) fn parameter(id: &str) -> String {
    format!(" \"texture alpha\" \"{id}-holes\"")
}

/// The texture of the holes of group `index`, if it has some.
pub(super) fn holes(
    shot: &SceneView,
    index: usize,
    id: &str,
    files: &mut Files,
    warnings: &mut Warnings,
) -> Result<String, String> {
    let detail = group_detail::of_group(shot.scene, index);
    let Some(coverage) = detail.coverage else { return Ok(String::new()) };
    let tile = tiling::tile(&maps::stencil(&coverage), tiling::copies(shot, index));
    let path = format!("textures/{id}-holes.png");
    let text = format!(
        "Texture \"{id}-holes\" \"float\" \"imagemap\" \"string filename\" \"{path}\" \"string wrap\" \"{}\" \
         \"string filter\" \"point\" \"string encoding\" \"linear\"\n",
        tile.mode()
    );
    files.push((path, texels::png_of_numbers(&tile.image)?));
    let name = &shot.scene.groups[index].name;
    warnings.0.extend(tile.doubt.map(|doubt| format!("group \"{name}\": {doubt}")));
    Ok(text)
}

/// The materials of group `index`: of each its identifier and what to add to its parameters.
pub(super) fn normals(
    shot: &SceneView,
    index: usize,
    id: &str,
    files: &mut Files,
    warnings: &mut Warnings,
) -> Result<Vec<(String, String)>, String> {
    let detail = group_detail::of_group(shot.scene, index);
    let Some(map) = detail.normals else { return Ok(vec![(id.to_owned(), String::new())]) };
    let mut materials = Vec::new();
    for mirrored in [false, true] {
        let suffix = maps::suffix(mirrored);
        if mirrored && !maps::has_mirrored(shot.scene, index) {
            continue;
        }
        let tile = tiling::tile(&maps::colors(&map, mirrored), tiling::copies(shot, index));
        let path = format!("textures/{id}{suffix}-normals.exr");
        materials.push((format!("{id}{suffix}"), format!(" \"string normalmap\" \"{path}\"")));
        files.push((path, texels::exr(&tile.image)?));
        if tile.clamps || tile.doubt.is_some() {
            warnings.push(REPEATED);
        }
    }
    Ok(materials)
}
