//! No data is not black: pixels that a file lacks, or marks as transparent or missing, are no
//! measurement.

use crate::support::Folder;
use crate::support::pictures::{Page, Part, exr_of, part, read, refusal, tiff, warned};
use exr::meta::attribute::IntegerBounds;
use exr::prelude::Vec2;
use image::ExtendedColorType::{La8, Rgba8, Rgba16};
use image::{ExtendedColorType, ImageEncoder};
use unrender_formats::picture;
use unrender_scene::Rgb;

const COLOURS: [(&str, f32); 3] = [("R", 1.0), ("G", 2.0), ("B", 3.0)];

fn window(from: (i32, i32), size: (usize, usize)) -> IntegerBounds {
    IntegerBounds::new(Vec2(from.0, from.1), Vec2(size.0, size.1))
}

/// An EXR whose data begin at `from` and have `size`, in this display window.
fn of_windows(from: (i32, i32), size: (usize, usize), display: IntegerBounds) -> Vec<u8> {
    exr_of(&[Part { name: "", from, size, channels: &COLOURS }], display, |_, _| {})
}

#[test]
fn what_lies_outside_of_the_data_window_has_no_value() {
    // Columns 1 and 2 of rows 1 to 3, at the origin and somewhere else.
    let inside = |i: usize| (1..3).contains(&(i % 4)) && i / 4 > 0;
    for at in [(0, 0), (-70, 1000)] {
        let from = (at.0 + 1, at.1 + 1);
        let picture =
            warned(&of_windows(from, (2, 3), window(at, (4, 4))), "10 pixel(s) lie outside");
        assert_eq!(picture.invalid, (0..16).filter(|i| !inside(*i)).collect::<Vec<_>>());
        for (i, value) in picture.values.pixels().iter().enumerate() {
            let expected = if inside(i) { Rgb::new(1.0, 2.0, 3.0) } else { Rgb::ZERO };
            assert_eq!(*value, expected);
        }
    }
    // Partly outside, wholly outside, and larger than the display window on all sides.
    let picture = warned(&of_windows((-2, -2), (4, 4), window((0, 0), (4, 4))), "12 pixel(s)");
    assert_eq!((picture.invalid.len(), picture.invalid[0]), (12, 2));
    let nothing = warned(&of_windows((9, 9), (2, 2), window((0, 0), (2, 2))), "4 pixel(s)");
    assert_eq!(nothing.invalid, [0, 1, 2, 3]);
    let (cropped, warnings) = read(&of_windows((-3, -3), (9, 9), window((0, 0), (3, 2))));
    assert_eq!((cropped.values.width(), cropped.values.height()), (3, 2));
    assert!(cropped.invalid.is_empty() && warnings.is_empty());
}

#[test]
fn files_that_lack_blocks_are_cut_short() {
    let whole = of_windows((0, 0), (3, 2), window((0, 0), (4, 4)));
    assert!(refusal(&whole[..whole.len() - 1]).contains("cut short"));
}

#[test]
fn transparent_pixels_are_no_measurement_and_keep_their_colours() {
    let png = |codes: &[u8], kind: ExtendedColorType| {
        let mut out = Vec::new();
        let width = (codes.len() * 8) as u32 / u32::from(kind.bits_per_pixel());
        image::codecs::png::PngEncoder::new(&mut out).write_image(codes, width, 1, kind).unwrap();
        out
    };
    let told = "1 pixel(s) are transparent (alpha is 0)";
    let picture = warned(&png(&[9, 9, 9, 255, 51, 0, 0, 0], Rgba8), told);
    assert_eq!((picture.invalid, picture.values.pixels()[1].x), (vec![1], 0.2));
    let picture = warned(&png(&[9, 0, 9, 255], La8), told);
    assert_eq!(picture.invalid, [0]);
    let deep: Vec<u8> = [7u16, 7, 7, 1, 7, 7, 7, 0].iter().flat_map(|c| c.to_ne_bytes()).collect();
    let picture = warned(&png(&deep, Rgba16), "between 0 and 1 alpha was ignored");
    assert_eq!(picture.invalid, [1]);
    // A colour that PNG calls transparent.
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, 2, 1);
    encoder.set_trns(vec![0u8, 7]);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&[7, 8]).unwrap();
    assert_eq!(warned(&out, told).invalid, [0]);
    let channels = [("R", 4.0), ("G", 4.0), ("B", 4.0), ("A", 0.0)];
    let clear = exr_of(&[part("", &channels)], window((0, 0), (5, 3)), |_, _| {});
    let (picture, warnings) = read(&clear);
    assert_eq!((picture.invalid.len(), picture.values.pixels()[0].x, warnings.len()), (15, 4.0, 2));
    assert_eq!(picture.invalid[14], 14, "in order: {:?}", picture.invalid);
}

#[test]
fn the_fourth_channel_of_a_tiff_is_coverage_where_it_says_so() {
    let page = Page::new((2, 1), 4, 8, vec![5, 5, 5, 0, 5, 5, 5, 255]);
    for (extra, invalid) in [(Some(1), &[0][..]), (Some(2), &[0]), (Some(0), &[]), (None, &[])] {
        let page = match extra {
            Some(extra) => page.clone().with(338, 3, &[extra]),
            None => page.clone(),
        };
        let told = if invalid.is_empty() { "was ignored" } else { "are transparent" };
        assert_eq!(warned(&tiff(&[page]), told).invalid, invalid, "{extra:?}");
    }
}

#[test]
fn values_for_no_data_are_left_out() {
    let told = "for no data (GDAL_NODATA)";
    let grey = |codes: &[u8]| Page::new((codes.len() as u32, 1), 1, 8, codes.to_vec());
    assert_eq!(warned(&tiff(&[grey(&[0, 7, 255]).text(42_113, "255 ")]), told).invalid, [2]);
    assert_eq!(warned(&tiff(&[grey(&[0, 7, 255]).text(42_113, "0")]), told).invalid, [0]);
    // In this page white is zero.
    let inverted = grey(&[0, 7, 255]).with(262, 3, &[0]).text(42_113, "7");
    assert_eq!(warned(&tiff(&[inverted]), told).invalid, [1]);
    let words: Vec<u8> = [65_535u16, 1, 2, 3, 4, 5].iter().flat_map(|n| n.to_le_bytes()).collect();
    let deep = Page::new((2, 1), 3, 16, words).text(42_113, "65535");
    assert_eq!(warned(&tiff(&[deep]), told).invalid, [0]);
    let floats: Vec<u8> = [f32::MIN, f32::MIN, f32::MIN, -9999.0, 0.0, f32::NAN]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    let float = Page::new((2, 1), 3, 32, floats).with(339, 3, &[3, 3, 3]);
    let missing = float.clone().text(42_113, "-3.4028234663852886e+38");
    assert_eq!(read(&tiff(&[missing])).0.invalid, [0, 1]);
    assert_eq!(read(&tiff(&[float.text(42_113, "nan")])).0.invalid, [1]);
    // A value that the file cannot hold matches no pixel.
    assert_eq!(read(&tiff(&[grey(&[0, 7]).text(42_113, "-9999")])).1, [""; 0]);
}

#[test]
fn half_floats_and_other_kinds_of_tiff_are_refused_by_name() {
    let half = Page::new((1, 1), 3, 16, vec![0; 6]).with(339, 3, &[3, 3, 3]);
    let said = refusal(&tiff(&[half]));
    assert!(
        said.contains("floating-point numbers of 16 bits") && said.contains("save it"),
        "{said}"
    );
    let grey = Page::new((1, 1), 1, 32, vec![0; 4]).with(339, 3, &[3]);
    let said = refusal(&tiff(&[grey]));
    assert!(said.contains("grey, 1 channel(s) of floating-point numbers of 32 bits"), "{said}");
    let lab = Page::new((1, 1), 3, 8, vec![0; 3]).with(262, 3, &[8]);
    assert!(refusal(&tiff(&[lab])).contains("CIE L*a*b*"));
}

#[test]
fn jpegs_of_other_kinds_are_refused_by_name() {
    let frame = |marker: u8, bits: u8| {
        [&[0xff, 0xd8, 0xff, marker, 0, 11, bits, 0, 8, 0, 8, 1, 1, 0x11, 0][..], &[0xff, 0xd9]]
            .concat()
    };
    assert!(refusal(&frame(0xc3, 8)).contains("a lossless JPEG"));
    assert!(refusal(&frame(0xc9, 8)).contains("arithmetic coding"));
    assert!(refusal(&frame(0xf7, 8)).contains("a JPEG-LS"));
    assert!(refusal(&frame(0xc1, 12)).contains("a JPEG of 12 bits"));
}

#[test]
fn panoramas_take_the_colours_of_what_is_transparent() {
    let folder = Folder::new();
    let channels = [("R", 4.0), ("G", 4.0), ("B", 4.0), ("A", 0.0)];
    let clear = exr_of(&[part("", &channels)], window((0, 0), (6, 3)), |_, _| {});
    let path = folder.file("sky.exr", clear);
    let (sky, warnings) = picture::read_environment(&path, 0.0, 1.0).unwrap();
    assert!(sky.is_bright());
    let told = "6 pixel(s) without a value give no light here";
    assert!(warnings.0.iter().any(|warning| warning.contains(told)), "{warnings:?}");
}
