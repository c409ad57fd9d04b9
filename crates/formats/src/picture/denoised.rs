//! Denoised pictures: an EXR states it.
//!
//! The errors of neighbouring pixels are correlated, which is not visible. The attribute
//! `unrenderDenoised` tells readers of the file.

use super::colour_space::ColourSpace;
use super::one_layer;
use super::write::write_in;
use crate::FileError;
use exr::meta::attribute::AttributeValue;
use std::path::Path;
use unrender_scene::RgbImage;

/// The attribute that says that noise was removed.
pub(super) const ATTRIBUTE: &str = "unrenderDenoised";

/// As [`write_in`], but an EXR gets the attribute `unrenderDenoised`, of which its reader warns. Returns how many
/// values were not finite and were written as zero.
///
/// # Errors
/// If the extension is another one or the file cannot be written.
pub fn write_denoised(
    path: &Path,
    picture: &RgbImage,
    space: ColourSpace,
) -> Result<usize, FileError> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("exr")) {
        return write_in(path, picture, space);
    }
    one_layer::write(path, &space.of(picture), space, |_, own| {
        own.other.insert(ATTRIBUTE.into(), AttributeValue::I32(1));
    })
}
