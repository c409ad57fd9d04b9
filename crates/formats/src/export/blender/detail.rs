//! Glass, normal maps and holes in `scene.json`.

use crate::export::{Files, maps, tiling};
use crate::glasses::Kind;
use crate::numbers::{number, triple};
use crate::texels;
use serde_json::{Value, json};
use unrender_scene::{Detail, Rgb, Warnings};

/// A kind of glass: the colour of its node, and what it absorbs per metre.
pub(super) fn glass(kind: &Kind) -> Value {
    let glass = kind.glass;
    // Light passes two faces of a body, each with the root of the node's colour.
    let color = if glass.is_thin { glass.tint } else { glass.tint * glass.tint };
    let absorption = if glass.is_thin { Rgb::ZERO } else { glass.absorption };
    json!({
        "name": kind.name,
        "ior": number(glass.ior),
        "is_thin": glass.is_thin,
        "color": triple(color),
        "absorption": triple(absorption),
    })
}

/// The pictures of normals and of holes of the group called `name`; null where there is none.
pub(super) fn pictures(
    name: &str,
    id: &str,
    (detail, copies): (&Detail, [usize; 2]),
    files: &mut Files,
    warnings: &mut Warnings,
) -> Result<(Value, Value), String> {
    let mut note = |doubt: Option<&str>| {
        warnings.0.extend(doubt.map(|doubt| format!("group \"{name}\": {doubt}")));
    };
    let (mut normals, mut holes) = (Value::Null, Value::Null);
    if let Some(map) = &detail.normals {
        // Blender has tangents of its own where pictures lie mirrored.
        let tile = tiling::tile(&maps::colors(map, false), copies);
        let path = format!("textures/{id}-normals.exr");
        normals = json!({ "file": path, "clamps": tile.clamps });
        files.push((path, texels::exr(&tile.image)?));
        note(tile.doubt);
    }
    if let Some(coverage) = &detail.coverage {
        let tile = tiling::tile(&coverage.alpha, copies);
        let path = format!("textures/{id}-holes.exr");
        let cutoff = number(coverage.cutoff);
        holes = json!({ "file": path, "clamps": tile.clamps, "cutoff": cutoff });
        files.push((path, texels::exr(&tile.image.map(|alpha| Rgb::splat(*alpha)))?));
        note(tile.doubt);
    }
    Ok((normals, holes))
}
