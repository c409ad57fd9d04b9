//! Pictures that are cut short, damaged or lie about their size: an error each, never a panic.

use image::{ExtendedColorType, ImageEncoder};
use std::io::Cursor;
use std::path::Path;
use unrender_formats::picture;

const SIDE: u32 = 24;

/// One noisy picture in every format.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let mut state = 1u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let codes: Vec<u8> = (0..SIDE * SIDE * 3).map(|_| noise()).collect();
    let floats: Vec<f32> = codes.iter().map(|&c| f32::from(c) / 100.0).collect();
    let bytes: Vec<u8> = floats.iter().flat_map(|v| v.to_ne_bytes()).collect();
    let rgb8 = ExtendedColorType::Rgb8;
    let mut out = [(); 5].map(|()| Cursor::new(Vec::new()));
    let [png, jpeg, tiff, exr, hdr] = &mut out;
    image::codecs::png::PngEncoder::new(png).write_image(&codes, SIDE, SIDE, rgb8).unwrap();
    image::codecs::jpeg::JpegEncoder::new(jpeg).write_image(&codes, SIDE, SIDE, rgb8).unwrap();
    image::codecs::tiff::TiffEncoder::new(tiff).write_image(&codes, SIDE, SIDE, rgb8).unwrap();
    image::codecs::openexr::OpenExrEncoder::new(exr)
        .write_image(&bytes, SIDE, SIDE, ExtendedColorType::Rgb32F)
        .unwrap();
    let pixels: Vec<_> = floats.chunks_exact(3).map(|c| image::Rgb([c[0], c[1], c[2]])).collect();
    image::codecs::hdr::HdrEncoder::new(hdr).encode(&pixels, SIDE as usize, SIDE as usize).unwrap();
    ["png", "jpeg", "tiff", "exr", "hdr"].into_iter().zip(out.map(Cursor::into_inner)).collect()
}

#[test]
fn every_truncation_is_an_error() {
    for (name, bytes) in samples() {
        assert!(picture::decode(&bytes, Path::new(name)).is_ok(), "{name}");
        // The last few bytes of PNG and TIFF are not part of the picture.
        let last = bytes.len() - if matches!(name, "png" | "tiff") { 150 } else { 1 };
        for length in (0..last).step_by(7).chain([last]) {
            let result = picture::decode(&bytes[..length], Path::new(name));
            let error = result.expect_err(&format!("{name} cut to {length} of {}", bytes.len()));
            assert!(error.to_string().starts_with(name), "{error}");
        }
    }
}

#[test]
fn damaged_bytes_never_panic() {
    for (name, bytes) in samples() {
        for (turn, at) in (0..bytes.len()).filter(|i| *i < 400 || i % 5 == 0).enumerate() {
            let mut damaged = bytes.clone();
            damaged[at] = [0, 0xff, 0x80, damaged[at] ^ 1][turn % 4];
            // Damage may only change colours; decoding must end without a panic.
            let _ = picture::decode(&damaged, Path::new(name));
        }
    }
}

#[test]
fn sizes_that_the_file_cannot_hold_are_refused() {
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16000 +X 16000\n\x01\x02\x03\x04";
    let error = picture::decode(hdr, Path::new("a.hdr")).unwrap_err();
    assert!(error.to_string().contains("cannot hold"), "{error}");
    let error = picture::decode(b"GIF89a not read", Path::new("a.gif")).unwrap_err();
    assert!(error.to_string().contains("is not a PNG"), "{error}");
    let error = picture::read(Path::new("/no/such/picture.png")).unwrap_err();
    assert!(error.to_string().contains("cannot be read"), "{error}");
}
