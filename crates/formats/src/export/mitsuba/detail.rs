//! Normal maps and holes: `normalmap` and `mask` about a BSDF.
//!
//! Mitsuba takes a normal's y to be along `normal x dp/du`: upwards in the picture, as ours is, but where the picture lies
//! mirrored upon a mesh. Objects of that kind have BSDFs of their own. A mask lets light through by chance, with the
//! probability that its picture states: ours is a stencil, which is not interpolated.

use crate::export::{Files, maps, tiling};
use crate::texels;
use unrender_scene::{Detail, Warnings};

/// Where the pictures of a group are.
pub(super) struct Place<'a> {
    /// The identifier of the group.
    pub(super) id: &'a str,
    /// Its name.
    pub(super) name: &'a str,
    /// The copies in its tiles.
    pub(super) copies: [usize; 2],
}

/// The BSDF `inside` on both sides of surfaces, with `detail`, whose pictures are added to `files`.
pub(super) fn bsdf(
    place: &Place,
    (inside, detail, mirrored): (&str, &Detail, bool),
    files: &mut Files,
    warnings: &mut Warnings,
) -> Result<String, String> {
    let mut inside = inside.to_owned();
    let suffix = maps::suffix(mirrored);
    let id = format!(" id=\"{}{suffix}\"", place.id);
    if let Some(map) = &detail.normals {
        let tile = tiling::tile(&maps::colors(map, mirrored), place.copies);
        let path = format!("textures/{}{suffix}-normals.exr", place.id);
        let picture = bitmap("normalmap", &path, tile.mode(), "");
        inside = format!("<bsdf type=\"normalmap\">{picture}{inside}</bsdf>");
        files.push((path, texels::exr(&tile.image)?));
        note(place, tile.doubt, warnings);
    }
    let Some(coverage) = &detail.coverage else {
        return Ok(format!("<bsdf type=\"twosided\"{id}>{inside}</bsdf>"));
    };
    let tile = tiling::tile(&maps::stencil(coverage), place.copies);
    let path = format!("textures/{}-holes.png", place.id);
    let nearest = "<string name=\"filter_type\" value=\"nearest\"/>";
    let picture = bitmap("opacity", &path, tile.mode(), nearest);
    if !files.iter().any(|(other, _)| *other == path) {
        files.push((path, texels::png_of_numbers(&tile.image)?));
    }
    note(place, tile.doubt, warnings);
    Ok(format!("<bsdf type=\"mask\"{id}>{picture}<bsdf type=\"twosided\">{inside}</bsdf></bsdf>"))
}

/// A picture of plain numbers.
pub(super) fn bitmap(property: &str, path: &str, mode: &str, more: &str) -> String {
    format!(
        "<texture type=\"bitmap\" name=\"{property}\">\
         <string name=\"filename\" value=\"{path}\"/><boolean name=\"raw\" value=\"true\"/>\
         <string name=\"wrap_mode\" value=\"{mode}\"/>{more}</texture>"
    )
}

fn note(place: &Place, doubt: Option<&str>, warnings: &mut Warnings) {
    warnings.0.extend(doubt.map(|doubt| format!("group \"{}\": {doubt}", place.name)));
}
