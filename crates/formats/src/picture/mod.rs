//! Pictures: photographs, textures and renderings as PNG, JPEG, BMP, TIFF, EXR and HDR files.
//!
//! [`read`] hands out the code values of the file, not yet radiance: `unrender-photo` knows what
//! the camera did to them. The writers take linear values.

mod bmp;
mod budget;
mod cicp;
mod claims;
mod codes;
mod colour_space;
mod coverage;
mod cryptomatte;
mod curves;
mod denoised;
mod embed;
mod exif;
mod exr_channels;
mod exr_picture;
mod exr_refused;
mod exr_says;
mod hdr_header;
mod hdr_resolution;
mod icc;
mod jpeg;
mod kind;
mod layers;
mod merged;
mod one_layer;
mod orientation;
mod panorama;
mod passes;
mod pixel_shape;
mod png_chunks;
mod primaries;
mod profile;
mod raw;
mod read;
mod tables;
mod tiff;
mod tiff_page;
mod tiff_says;
mod tiff_tags;
mod write;

pub(crate) use budget::{check as check_budget, exr_block};
pub use colour_space::ColourSpace;
pub use cryptomatte::{Matte, RANKS};
pub use denoised::write_denoised;
pub use embed::{jpeg_bytes, png_bytes};
pub use exif::{ExifExposure, exif_focal_px, exposure_of};
pub(crate) use exr_refused::fault as exr_fault;
pub(crate) use hdr_header::read as hdr_header_of;
pub use icc::icc_profile;
pub use layers::{LightLayer, read_layers, write_layers};
pub use merged::write_merged;
pub use orientation::{Orientation, Stored, stored, stored_in};
pub use panorama::read_environment;
pub use passes::{Pass, Passes, Values, write_passes};
pub(crate) use raw::other as other_kind;
pub(crate) use read::is_picture;
pub(crate) use read::read_in;
pub use read::{decode, read};
pub(crate) use tables::tables;
pub use unrender_scene::{Depth, Merged, Picture, Profile};
pub use write::{
    HDR_OF_REC709, write, write_exr, write_exr_as, write_exr_in, write_hdr, write_in, write_png_as,
    write_png_codes, write_png_srgb,
};

/// A picture, with notes for the user, as ends of sentences about its file.
struct Decoded {
    picture: Picture,
    notes: Vec<String>,
}
