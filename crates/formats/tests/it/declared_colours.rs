//! What files declare of their colours, of the shape of their pixels and of what was done to their values.

use crate::support::pictures::{Page, exr_of, part, read, refusal, tiff, warned, with_chunk};
use exr::meta::attribute::{AttributeValue, Chromaticities, IntegerBounds};
use exr::prelude::Vec2;
use image::ImageEncoder;
use unrender_formats::picture;
use unrender_scene::color::linear_from_srgb;
use unrender_scene::{Rgb, RgbImage};

const P3: [(f32, f32); 4] = [(0.3127, 0.3290), (0.680, 0.320), (0.265, 0.690), (0.150, 0.060)];

/// A PNG of one pixel, with the primaries or the ICC profile of Display P3 if asked for.
fn png(with_chrm: bool, with_icc: bool) -> Vec<u8> {
    let mut out = Vec::new();
    if with_icc {
        let mut encoder = image::codecs::png::PngEncoder::new(&mut out);
        let icc = moxcms::ColorProfile::new_display_p3().encode().unwrap();
        encoder.set_icc_profile(icc).unwrap();
        encoder.write_image(&[9, 99, 199], 1, 1, image::ExtendedColorType::Rgb8).unwrap();
        return out;
    }
    let mut encoder = png::Encoder::new(&mut out, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    if with_chrm {
        let [white, red, green, blue] = P3;
        encoder.set_source_chromaticities(png::SourceChromaticities::new(white, red, green, blue));
    }
    encoder.write_header().unwrap().write_image_data(&[9, 99, 199]).unwrap();
    out
}

#[test]
fn code_points_of_png_are_converted_as_the_primaries_are() {
    let by_chrm = read(&png(true, false)).0.profile.unwrap().srgb_from_file.unwrap();
    let p3 = read(&with_chunk(&png(false, false), b"cICP", &[12, 13, 0, 1])).0.profile.unwrap();
    assert!(p3.understood && p3.source.contains("cICP (Display P3)"), "{}", p3.source);
    assert!(p3.srgb_from_file.unwrap().abs_diff_eq(by_chrm, 1e-4));
    assert!((p3.curves.unwrap()[1][128] - linear_from_srgb(128.0 / 255.0)).abs() < 1e-5);
    // cICP takes precedence over iCCP and over cHRM.
    for file in [png(false, true), png(true, false)] {
        let srgb = read(&with_chunk(&file, b"cICP", &[1, 13, 0, 1])).0.profile.unwrap();
        assert!(srgb.srgb_from_file.is_none() && srgb.source.contains("sRGB"), "{}", srgb.source);
    }
    let video = read(&with_chunk(&png(false, false), b"cICP", &[9, 1, 0, 1])).0.profile.unwrap();
    assert!((video.srgb_from_file.unwrap().x_axis.x - 1.6605).abs() < 1e-3);
    // The middle code of BT.709 is 0.26 of white, that of sRGB 0.21.
    assert!((video.curves.unwrap()[0][128] - 0.2613).abs() < 1e-3);
    let other = read(&with_chunk(&png(false, false), b"cICP", &[2, 2, 0, 1])).0.profile.unwrap();
    assert!(!other.understood);
}

#[test]
fn codes_for_screens_are_refused() {
    for (points, words) in [
        ([9, 16, 0, 1], "PQ (SMPTE ST 2084)"),
        ([12, 16, 0, 1], "PQ (SMPTE ST 2084)"),
        ([9, 18, 0, 1], "HLG (ARIB STD-B67)"),
        ([1, 13, 0, 0], "narrow range"),
    ] {
        let said = refusal(&with_chunk(&png(false, false), b"cICP", &points));
        assert!(said.contains(words) && said.contains("save it"), "{said}");
    }
}

/// A Radiance picture of one pixel of [0.5, 0.5, 0.5] with these lines in its header.
fn hdr(lines: &str) -> Vec<u8> {
    let head = format!("#?RADIANCE\n{lines}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n");
    [head.as_bytes(), &[128, 128, 128, 128]].concat()
}

#[test]
fn what_radiance_multiplied_is_divided_out() {
    let value = |lines: &str| read(&hdr(lines)).0.values.pixels()[0];
    assert_eq!(value("COLORCORR= 2 1 0.5\n"), Rgb::new(0.25, 0.5, 1.0));
    assert_eq!(
        value("COLORCORR=2 1 1\nEXPOSURE=2\nCOLORCORR=2 4 1\n"),
        Rgb::new(0.0625, 0.0625, 0.25)
    );
    assert_eq!(value("EXPOSURE=4\nEXPOSURE= 0.5\n"), Rgb::splat(0.25));
    // Lines of the pictures that this one was made from.
    assert_eq!(value("pcomb a.hdr\n\tEXPOSURE=4\n\tCOLORCORR=2 2 2\n"), Rgb::splat(0.5));
    for (line, words) in [
        ("COLORCORR=1 2\n", "COLORCORR=1 2 that has no 3 number(s)"),
        ("COLORCORR=1 0 1\n", "not above zero"),
        ("EXPOSURE=-2\n", "not above zero"),
        ("EXPOSURE=1e30\nEXPOSURE=1e30\n", "no number above zero"),
        ("PRIMARIES=1 2 3\n", "no 8 number(s)"),
        ("PIXASPECT=wide\n", "no 1 number(s)"),
    ] {
        let said = refusal(&hdr(line));
        assert!(said.contains(words), "{line}: {said}");
    }
    let xyz = refusal(b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\x80\x80\x80\x80");
    assert!(xyz.contains("CIE XYZ") && xyz.contains("ra_xyze"), "{xyz}");
}

#[test]
fn primaries_of_radiance_are_those_of_the_file() {
    let by_chrm = read(&png(true, false)).0.profile.unwrap().srgb_from_file.unwrap();
    let p3 = "PRIMARIES= 0.68 0.32 0.265 0.69 0.15 0.06 0.3127 0.329\n";
    let picture = read(&hdr(p3)).0;
    assert!(picture.profile.clone().unwrap().srgb_from_file.unwrap().abs_diff_eq(by_chrm, 1e-4));
    assert!((picture.to_linear().pixels()[0] - Rgb::splat(0.5)).length() < 1e-4, "grey stays grey");
    let srgb = read(&hdr("PRIMARIES=.64 .33 .3 .6 .15 .06 .3127 .329\n")).0.profile.unwrap();
    assert!(srgb.understood && srgb.srgb_from_file.is_none());
    let none = read(&hdr("PRIMARIES=.3 .3 .3 .3 .3 .3 .3 .3\n")).0.profile.unwrap();
    assert!(!none.understood);
}

/// An EXR of pure red with these changes.
fn red(
    change: impl Fn(&mut exr::meta::header::ImageAttributes, &mut exr::prelude::LayerAttributes),
) -> Vec<u8> {
    let channels = [("R", 1.0), ("G", 0.0), ("B", 0.0)];
    exr_of(&[part("", &channels)], IntegerBounds::from_dimensions((4, 3)), change)
}

#[test]
fn primaries_of_exr_are_converted() {
    let with = |corners: [(f32, f32); 4]| {
        let [white, red_, green, blue] = corners.map(|(x, y)| Vec2(x, y));
        red(|shared, _| {
            shared.chromaticities = Some(Chromaticities { red: red_, green, blue, white });
        })
    };
    let (p3, warnings) = read(&with(P3));
    assert!(warnings.is_empty());
    let by_chrm = read(&png(true, false)).0.profile.unwrap().srgb_from_file.unwrap();
    assert!(p3.profile.clone().unwrap().srgb_from_file.unwrap().abs_diff_eq(by_chrm, 1e-4));
    // Panoramas and textures have them as well.
    assert!((p3.to_linear().pixels()[0].x - by_chrm.x_axis.x).abs() < 1e-4);
    let third = 1.0 / 3.0;
    let xyz = [(third, third), (1.0, 0.0), (0.0, 1.0), (0.0, 0.0)];
    let xyz = read(&with(xyz)).0.profile.unwrap();
    assert!(xyz.understood && xyz.srgb_from_file.is_some());
    let aces = red(|_, own| {
        own.other.insert("acesImageContainerFlag".into(), AttributeValue::I32(1));
    });
    assert!((read(&aces).0.profile.unwrap().srgb_from_file.unwrap().x_axis.x - 2.52).abs() < 0.01);
}

#[test]
fn numbers_are_written_with_their_primaries() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.exr");
    let values = RgbImage::from_fn(4, 3, |x, y| Rgb::new(x as f32, y as f32, -0.5));
    let corners = [P3, [(0.32168, 0.33767), (0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.077)]];
    for [white, red, green, blue] in corners.map(|corners| corners.map(|(x, y)| Vec2(x, y))) {
        let stated = Chromaticities { red, green, blue, white };
        let file = exr_of(
            &[part("", &[("R", 1.0), ("G", 0.0), ("B", 0.0)])],
            IntegerBounds::from_dimensions((4, 3)),
            |shared, _| shared.chromaticities = Some(stated),
        );
        let matrix = read(&file).0.profile.unwrap().srgb_from_file;
        picture::write_exr_as(&path, &values, matrix).unwrap();
        let (back, warnings) = picture::read(&path).unwrap();
        assert!(back.values == values && warnings.0.is_empty(), "{warnings:?}");
        let declared = back.profile.unwrap().srgb_from_file.unwrap();
        assert!(declared.abs_diff_eq(matrix.unwrap(), 1e-4), "{declared}");
    }
    picture::write_exr_as(&path, &values, None).unwrap();
    let plain = picture::read(&path).unwrap().0.profile.unwrap();
    assert!(plain.understood && plain.srgb_from_file.is_none());
}

#[test]
fn colour_spaces_by_name_and_units_of_white_are_told() {
    let said = |name: &'static str, space: &'static str| {
        red(move |_, own| {
            own.other.insert(name.into(), AttributeValue::Text(space.into()));
        })
    };
    warned(&said("colorSpace", "ACEScg"), "names the colour space \"ACEScg\"");
    warned(&said("oiio:ColorSpace", "sRGB"), "names the colour space \"sRGB\"");
    warned(&said("colorInteropID", "lin_ap1_scene"), "lin_ap1_scene");
    for linear in ["Linear", "lin_rec709", "scene_linear", "Linear Rec.709 (sRGB)"] {
        assert_eq!(read(&said("oiio:ColorSpace", linear)).1, [""; 0], "{linear}");
    }
    warned(&red(|_, own| own.white_luminance = Some(100.0)), "its white has 100 cd/m2");
}

#[test]
fn pixels_that_are_not_square_are_told() {
    warned(&red(|shared, _| shared.pixel_aspect = 2.0), "2.000 times as wide as high");
    warned(&hdr("PIXASPECT=2\n"), "0.500 times as wide as high, by the line PIXASPECT=");
    let phys: Vec<u8> = [1000u32, 2000].iter().flat_map(|n| n.to_be_bytes()).chain([1]).collect();
    warned(&with_chunk(&png(false, false), b"pHYs", &phys), "2.000 times as wide as high");
    let page = Page::grey((2, 2), 9).with(282, 5, &[150, 1]).with(283, 5, &[300, 2]);
    assert_eq!(read(&tiff(std::slice::from_ref(&page))).1, [""; 0]);
    warned(
        &tiff(&[page.with(283, 5, &[75, 1])]),
        "0.500 times as wide as high, by its resolutions",
    );
    let mut jpeg = Vec::new();
    let mut encoder = image::codecs::jpeg::JpegEncoder::new(&mut jpeg);
    encoder.set_pixel_density(image::codecs::jpeg::PixelDensity {
        density: (100, 130),
        unit: image::codecs::jpeg::PixelDensityUnit::Inches,
    });
    encoder.write_image(&[9; 64], 8, 8, image::ExtendedColorType::L8).unwrap();
    warned(&jpeg, "1.300 times as wide as high, by its JFIF header");
    // Neither a rounding error nor zeros cause a warning.
    assert_eq!(read(&red(|shared, _| shared.pixel_aspect = 1.0005)).1, [""; 0]);
    let none: Vec<u8> = [0u32, 0].iter().flat_map(|n| n.to_be_bytes()).chain([0]).collect();
    assert_eq!(read(&with_chunk(&png(false, false), b"pHYs", &none)).1, [""; 0]);
}

#[test]
fn tags_of_tiff_may_declare_primaries_and_curves() {
    let page = Page::new((1, 1), 3, 8, vec![9, 99, 199]);
    let corners = [640, 1000, 330, 1000, 210, 1000, 710, 1000, 150, 1000, 60, 1000];
    let white = [3127, 10_000, 3290, 10_000];
    let adobe = page.clone().with(319, 5, &corners).with(318, 5, &white);
    let profile = read(&tiff(&[adobe])).0.profile.unwrap();
    assert!(
        (profile.srgb_from_file.unwrap().x_axis.x - 1.3984).abs() < 2e-3
            && profile.curves.is_none()
    );
    let square: Vec<u32> = (0..256u32).map(|k| 65_535 * k * k / (255 * 255)).collect();
    let curves =
        read(&tiff(&[page.clone().with(301, 3, &square)])).0.profile.unwrap().curves.unwrap();
    assert!((curves[2][51] - 0.04).abs() < 1e-4);
    let three = [square.clone(), vec![7; 256], square].concat();
    let curves =
        read(&tiff(&[page.clone().with(301, 3, &three)])).0.profile.unwrap().curves.unwrap();
    assert!((curves[1][200] - 7.0 / 65_535.0).abs() < 1e-6 && curves[2][255] == 1.0);
    // The dark codes of a steep curve are all zero, and a falling curve is invalid.
    let steep: Vec<u32> =
        (0..256).map(|k| (65_535.0 * (f64::from(k) / 255.0).powf(2.6)).round() as u32).collect();
    assert_eq!(steep[1], 0);
    let declared = read(&tiff(&[page.clone().with(301, 3, &steep)])).0.profile.unwrap();
    assert!(declared.curves.unwrap()[0].windows(2).all(|w| w[0] < w[1]));
    let falling: Vec<u32> = (0..256).rev().collect();
    assert!(!read(&tiff(&[page.clone().with(301, 3, &falling)])).0.profile.unwrap().understood);
    assert_eq!(read(&tiff(&[page])).0.profile, None);
}

#[test]
fn inks_are_told() {
    let page = Page::new((1, 1), 4, 8, vec![0, 0, 0, 0]).with(262, 3, &[5]);
    warned(&tiff(&[page]), "holds inks (CMYK)");
}
