//! Photographs in encodings other than sRGB, and pictures as a viewer with colour management shows them: by a library
//! of its own, not by ours.

use image::ImageEncoder;
use image::codecs::jpeg::JpegEncoder;
use moxcms::{ColorProfile, Layout, TransformOptions};
use std::path::Path;

/// Codes of 16 bits, three a pixel.
pub(crate) type Codes = Vec<u16>;

/// `codes` of sRGB in the encoding of `profile`.
pub(crate) fn encoded(codes: &Codes, profile: &ColorProfile) -> Codes {
    converted(codes, &ColorProfile::new_srgb(), profile)
}

/// The PNG at `path` as codes of sRGB, by the ICC profile in it, and that profile.
pub(crate) fn shown(path: &Path) -> (Codes, Option<Vec<u8>>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut bytes).unwrap();
    let codes: Codes = match frame.bit_depth {
        png::BitDepth::Sixteen => {
            bytes.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect()
        }
        _ => bytes.iter().map(|byte| 257 * u16::from(*byte)).collect(),
    };
    let icc = reader.info().icc_profile.as_ref().map(|icc| icc.to_vec());
    let shown = match &icc {
        Some(icc) => {
            let profile = ColorProfile::new_from_slice(icc).unwrap();
            converted(&codes, &profile, &ColorProfile::new_srgb())
        }
        None => codes,
    };
    (shown, icc)
}

fn converted(codes: &Codes, from: &ColorProfile, to: &ColorProfile) -> Codes {
    let options = TransformOptions::default();
    let transform = from.create_transform_16bit(Layout::Rgb, to, Layout::Rgb, options).unwrap();
    let mut out = vec![0; codes.len()];
    transform.transform(codes, &mut out).unwrap();
    out
}

/// A PNG of 16 bits with these declarations in its header, and these chunks.
pub(crate) fn png(
    (width, height): (usize, usize),
    codes: &Codes,
    declare: impl FnOnce(&mut png::Info<'_>),
    chunks: &[(&[u8; 4], &[u8])],
) -> Vec<u8> {
    let mut info = png::Info::with_size(width as u32, height as u32);
    info.color_type = png::ColorType::Rgb;
    info.bit_depth = png::BitDepth::Sixteen;
    declare(&mut info);
    let mut out = Vec::new();
    let mut writer = png::Encoder::with_info(&mut out, info).unwrap().write_header().unwrap();
    for (name, data) in chunks {
        writer.write_chunk(png::chunk::ChunkType(**name), data).unwrap();
    }
    let bytes: Vec<u8> = codes.iter().flat_map(|code| code.to_be_bytes()).collect();
    writer.write_image_data(&bytes).unwrap();
    drop(writer);
    out
}

/// A JPEG, with an ICC profile.
pub(crate) fn jpeg((width, height): (usize, usize), codes: &Codes, icc: Vec<u8>) -> Vec<u8> {
    let bytes: Vec<u8> = codes.iter().map(|code| (code / 257) as u8).collect();
    let mut out = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut out, 100);
    encoder.set_icc_profile(icc).unwrap();
    let size = (width as u32, height as u32);
    encoder.write_image(&bytes, size.0, size.1, image::ExtendedColorType::Rgb8).unwrap();
    out
}

/// A TIFF of 16 bits with an ICC profile.
pub(crate) fn tiff((width, height): (usize, usize), codes: &Codes, icc: &[u8]) -> Vec<u8> {
    /// The fields of its directory.
    const FIELDS: u32 = 10;
    let pixels: Vec<u8> = codes.iter().flat_map(|code| code.to_le_bytes()).collect();
    let bits_at = 8 + 2 + 12 * FIELDS + 4;
    let (pixels_at, icc_at) = (bits_at + 6, bits_at + 6 + pixels.len() as u32);
    let mut out =
        [b"II*\0".as_slice(), &8u32.to_le_bytes(), &(FIELDS as u16).to_le_bytes()].concat();
    let (short, long, bytes) = (3u16, 4u16, 7u16);
    for (tag, kind, count, value) in [
        (256u16, long, 1, width as u32),
        (257, long, 1, height as u32),
        (258, short, 3, bits_at),
        (259, short, 1, 1),
        (262, short, 1, 2),
        (273, long, 1, pixels_at),
        (277, short, 1, 3),
        (278, long, 1, height as u32),
        (279, long, 1, pixels.len() as u32),
        (34_675, bytes, icc.len() as u32, icc_at),
    ] {
        out.extend(tag.to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend(u32::to_le_bytes(count));
        out.extend(value.to_le_bytes());
    }
    out.extend(0u32.to_le_bytes());
    out.extend([16, 0, 16, 0, 16, 0]);
    out.extend(pixels);
    out.extend(icc);
    out
}
