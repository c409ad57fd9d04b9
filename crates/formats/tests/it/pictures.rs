//! Pictures: they are read as written, in every orientation, and errors name the fault.

use crate::support::Folder;
use image::codecs::png::PngEncoder;
use image::codecs::tiff::TiffEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::io::Cursor;
use std::path::Path;
use unrender_formats::picture::{self, Depth, Picture};
use unrender_scene::{Image, Rgb, RgbImage};

fn ramp() -> RgbImage {
    Image::from_fn(7, 5, |x, y| Rgb::new(x as f32, y as f32, 3.0) / 7.0)
}

fn decode(bytes: &[u8]) -> Picture {
    picture::decode(bytes, Path::new("test")).unwrap().0
}

/// The TIFF structure of an EXIF chunk, big-endian, with nothing but an orientation.
fn exif(orientation: u8) -> Vec<u8> {
    let entry = [1, 0x12, 0, 3, 0, 0, 0, 1, 0, orientation, 0, 0];
    let mut chunk = b"MM\0*\0\0\0\x08\0\x01".to_vec();
    chunk.extend(entry);
    chunk.extend([0; 4]);
    chunk
}

fn png8(codes: &[u8], width: u32, orientation: Option<u8>) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut encoder = PngEncoder::new(&mut out);
    if let Some(orientation) = orientation {
        encoder.set_exif_metadata(exif(orientation)).unwrap();
    }
    let height = codes.len() as u32 / width;
    encoder.write_image(codes, width, height, ExtendedColorType::L8).unwrap();
    out.into_inner()
}

fn greys(picture: &Picture) -> Vec<u8> {
    picture.values.pixels().iter().map(|v| (v.x * 255.0).round() as u8).collect()
}

#[test]
fn pictures_may_declare_other_primaries() {
    let icc = moxcms::ColorProfile::new_display_p3().encode().unwrap();
    let codes = [10, 200, 30, 0, 0, 255];
    let mut tagged = Cursor::new(Vec::new());
    let mut encoder = PngEncoder::new(&mut tagged);
    encoder.set_icc_profile(icc.clone()).unwrap();
    encoder.write_image(&codes, 2, 1, ExtendedColorType::Rgb8).unwrap();
    let mut jpeg = Cursor::new(Vec::new());
    let mut encoder = image::codecs::jpeg::JpegEncoder::new(&mut jpeg);
    encoder.set_icc_profile(icc).unwrap();
    encoder.write_image(&codes, 2, 1, ExtendedColorType::Rgb8).unwrap();
    for file in [tagged.into_inner(), jpeg.into_inner()] {
        let profile = decode(&file).profile.unwrap();
        assert!(profile.source.contains("Display P3"), "{}", profile.source);
        assert!(profile.srgb_from_file.is_some());
    }
    assert_eq!(decode(&png8(&[1, 2], 2, None)).profile, None);
}

#[test]
fn chunks_of_png_may_declare_a_gamma_and_primaries() {
    let file = |gamma: f32, red: (f32, f32)| {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, 1, 1);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_source_gamma(png::ScaledFloat::new(gamma));
        let (green, blue) = ((0.30, 0.60), (0.15, 0.06));
        let corners = png::SourceChromaticities::new((0.3127, 0.3290), red, green, blue);
        encoder.set_source_chromaticities(corners);
        encoder.write_header().unwrap().write_image_data(&[7]).unwrap();
        decode(&out).profile.unwrap()
    };
    let of_srgb = file(0.45455, (0.64, 0.33));
    assert_eq!((of_srgb.srgb_from_file, of_srgb.curves), (None, None));
    let other = file(0.625, (0.73, 0.26));
    assert!(other.srgb_from_file.is_some());
    assert!((other.curves.unwrap()[2][51] - 0.2f32.powf(1.6)).abs() < 1e-5);
}

#[test]
fn all_eight_orientations_are_turned_upright() {
    // Stored as 1 2 3 / 4 5 6; the upright picture by EXIF.
    let expected: [(u8, usize, [u8; 6]); 8] = [
        (1, 3, [1, 2, 3, 4, 5, 6]),
        (2, 3, [3, 2, 1, 6, 5, 4]),
        (3, 3, [6, 5, 4, 3, 2, 1]),
        (4, 3, [4, 5, 6, 1, 2, 3]),
        (5, 2, [1, 4, 2, 5, 3, 6]),
        (6, 2, [4, 1, 5, 2, 6, 3]),
        (7, 2, [6, 3, 5, 2, 4, 1]),
        (8, 2, [3, 6, 2, 5, 1, 4]),
    ];
    for (orientation, width, seen) in expected {
        let picture = decode(&png8(&[1, 2, 3, 4, 5, 6], 3, Some(orientation)));
        assert_eq!(picture.values.width(), width, "orientation {orientation}");
        assert_eq!(greys(&picture), seen, "orientation {orientation}");
    }
}

#[test]
fn jpeg_orientation_is_honoured() {
    let codes = [0, 0, 0, 255, 255, 255].repeat(8 * 8);
    let mut out = Cursor::new(Vec::new());
    let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut out, 100);
    encoder.set_exif_metadata(exif(6)).unwrap();
    encoder.write_image(&codes, 16, 8, ExtendedColorType::Rgb8).unwrap();
    let picture = decode(out.get_ref());
    assert_eq!((picture.values.width(), picture.values.height()), (8, 16));
    assert_eq!(picture.depth, Depth::Eight);
}

#[test]
fn sixteen_bits_grey_and_alpha_are_read() {
    let codes: Vec<u8> = [1u16, 65535, 32768, 65535].iter().flat_map(|c| c.to_ne_bytes()).collect();
    let mut png = Cursor::new(Vec::new());
    PngEncoder::new(&mut png).write_image(&codes, 4, 1, ExtendedColorType::L16).unwrap();
    let picture = decode(png.get_ref());
    assert_eq!(picture.depth, Depth::Sixteen);
    assert_eq!(picture.values.pixels()[0], Rgb::splat(1.0 / 65535.0));

    let mut tiff = Cursor::new(Vec::new());
    TiffEncoder::new(&mut tiff).write_image(&codes[..6], 1, 1, ExtendedColorType::Rgb16).unwrap();
    assert_eq!(decode(tiff.get_ref()).values.pixels()[0].y, 1.0);

    let mut png = Cursor::new(Vec::new());
    let rgba = [255, 0, 51, 7];
    PngEncoder::new(&mut png).write_image(&rgba, 1, 1, ExtendedColorType::Rgba8).unwrap();
    let (picture, warnings) = picture::decode(png.get_ref(), Path::new("a.png")).unwrap();
    assert_eq!(picture.values.pixels()[0], Rgb::new(1.0, 0.0, 0.2));
    assert_eq!(warnings.0, ["a.png: the alpha channel was ignored"]);
}

#[test]
fn float_tiffs_keep_their_values() {
    let bytes: Vec<u8> = [2.5f32, -0.5, f32::NAN].iter().flat_map(|v| v.to_ne_bytes()).collect();
    let mut tiff = Cursor::new(Vec::new());
    TiffEncoder::new(&mut tiff).write_image(&bytes, 1, 1, ExtendedColorType::Rgb32F).unwrap();
    let picture = decode(tiff.get_ref());
    assert_eq!((picture.depth, picture.invalid), (Depth::Float, vec![0]));
    assert_eq!(picture.values.pixels()[0], Rgb::ZERO);
}

#[test]
fn written_pictures_come_back() {
    let folder = Folder::new();
    for (name, tolerance) in [("a.exr", 0.0), ("a.hdr", 0.01), ("a.png", 0.005)] {
        assert_eq!(picture::write(&folder.path(name), &ramp()), Ok(0));
        let (picture, warnings) = picture::read(&folder.path(name)).unwrap();
        assert!(warnings.0.is_empty());
        for (back, wanted) in picture.to_linear().pixels().iter().zip(ramp().pixels()) {
            assert!((*back - *wanted).abs().max_element() <= tolerance, "{name}: {back} {wanted}");
        }
    }
    let error = picture::write(&folder.path("a.bmp"), &ramp()).unwrap_err();
    assert!(error.to_string().contains("end the name in .exr"), "{error}");
}

#[test]
fn what_is_not_finite_is_counted_and_never_written() {
    let folder = Folder::new();
    let mut picture = ramp();
    picture.pixels_mut()[3] = Rgb::new(f32::NAN, 1.0, f32::INFINITY);
    for name in ["a.exr", "a.hdr", "a.png"] {
        assert_eq!(picture::write(&folder.path(name), &picture), Ok(2), "{name}");
        let (back, _) = picture::read(&folder.path(name)).unwrap();
        assert!(back.invalid.is_empty());
        assert_eq!(back.values.pixels()[3].x, 0.0);
    }
}

#[test]
fn the_exposure_in_a_radiance_header_is_divided_out() {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=4\n\n-Y 1 +X 1\n".to_vec();
    bytes.extend([128, 128, 128, 129]);
    assert_eq!(decode(&bytes).values.pixels()[0], Rgb::splat(0.25));
}

#[test]
fn radiance_pictures_are_read_in_all_ways_that_they_stand() {
    // Upright, this is 1 2 3 over 4 5 6, the exponents of red.
    let standing: [(&str, [u8; 6]); 8] = [
        ("-Y 2 +X 3", [1, 2, 3, 4, 5, 6]),
        ("-Y 2 -X 3", [3, 2, 1, 6, 5, 4]),
        ("+Y 2 -X 3", [6, 5, 4, 3, 2, 1]),
        ("+Y 2 +X 3", [4, 5, 6, 1, 2, 3]),
        ("+X 3 -Y 2", [1, 4, 2, 5, 3, 6]),
        ("-X 3 -Y 2", [3, 6, 2, 5, 1, 4]),
        ("-X 3 +Y 2", [6, 3, 5, 2, 4, 1]),
        ("+X 3 +Y 2", [4, 1, 5, 2, 6, 3]),
    ];
    for (line, stored) in standing {
        let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{line}\n").into_bytes();
        stored.iter().for_each(|k| bytes.extend([128, 128, 128, 128 + k]));
        let values = decode(&bytes).values;
        assert_eq!((values.width(), values.height()), (3, 2), "{line}");
        let read: Vec<f32> = values.pixels().iter().map(|value| value.x.log2() + 1.0).collect();
        assert_eq!(read, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "{line}");
        let size = picture::stored_in(&bytes).unwrap().size;
        assert_eq!(
            size,
            if line.contains("X 3 -Y") || line.contains("X 3 +Y") { (2, 3) } else { (3, 2) }
        );
    }
}

#[test]
fn tiff_orientation_is_honoured() {
    // A 2 x 1 grey TIFF with orientation 8, every entry one SHORT but the last two.
    let entries: [(u16, u16, u32); 9] = [
        (256, 3, 2),
        (257, 3, 1),
        (258, 3, 8),
        (259, 3, 1),
        (262, 3, 1),
        (273, 4, 8),
        (274, 3, 8),
        (278, 3, 1),
        (279, 4, 2),
    ];
    let mut bytes = b"II*\0\x0a\0\0\0\x10\x20".to_vec();
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, value) in entries {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend(1u32.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0; 4]);
    let picture = decode(&bytes);
    assert_eq!((picture.values.width(), greys(&picture)), (1, vec![0x20, 0x10]));
}
