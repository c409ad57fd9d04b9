//! Writes materials.json and the texture files that it names.

use crate::engine::Recovered;
use crate::{Error, Job};
use std::path::Path;
use unrender_formats::materials::MaterialsFile;
use unrender_formats::picture;
use unrender_recover::GroupResult;
use unrender_scene::{Image, Rgb, RgbImage};

/// The contents of materials.json; writes the textures beside it and counts bad values in `bad`.
pub(super) fn write(
    job: &Job,
    recovered: &Recovered,
    folder: &Path,
    bad: &mut usize,
) -> Result<MaterialsFile, Error> {
    let mut file = recovered.materials(job);
    let groups = recovered.recovery.groups.iter().enumerate();
    for ((index, group), entry) in groups.zip(file.groups.values_mut()) {
        entry.texture = write_texture(group, index, folder, bad)?;
    }
    Ok(file)
}

/// Writes a group's texture as PNG and EXR and the mask of the texels that the photograph shows;
/// returns the PNG's name.
fn write_texture(
    group: &GroupResult,
    index: usize,
    folder: &Path,
    bad: &mut usize,
) -> Result<Option<String>, Error> {
    let Some(texture) = &group.material.texture else { return Ok(None) };
    let stem = format!("texture_{index}_{}", file_name(&group.name));
    let png = format!("{stem}.png");
    *bad += picture::write_png_srgb(&folder.join(&png), &texture.image)?;
    *bad += picture::write_exr(&folder.join(format!("{stem}.exr")), &texture.image)?;
    if let Some(seen) = &group.seen_texels {
        let mask = mask_picture(seen);
        *bad += picture::write_png_srgb(&folder.join(format!("{stem}_seen.png")), &mask)?;
    }
    Ok(Some(png))
}

/// White where the photograph shows the texel, black where it was filled from its neighbours.
fn mask_picture(seen: &Image<bool>) -> RgbImage {
    seen.map(|seen| if *seen { Rgb::ONE } else { Rgb::ZERO })
}

/// A group's name as part of a file name: letters and digits, the rest as underscores.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}
