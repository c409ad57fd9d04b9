//! Pictures in the photograph's own encoding declare it: a viewer with colour management shows what the edits left alone
//! as it shows the photograph, and the gallery compares pictures of one encoding.

use crate::kit::encoded::{Codes, encoded, jpeg, png, shown, tiff};
use crate::kit::folder::{Folder, succeeds};
use crate::restage::{INSERT, SIZE, Stage};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use moxcms::ColorProfile;
use std::path::Path;
use unrender::formats::picture;
use unrender::scene::{Image, Rgb};

/// Steps of 16 bits: one of 8 bits of sRGB, and rounding.
const NEAR: u16 = 300;

/// Strong colours in codes of sRGB, each in a square of pixels that JPEG keeps as it is.
fn colours() -> Codes {
    let codes = (0..SIZE.0 * SIZE.1).flat_map(|index| {
        let [x, y] = [index % SIZE.0, index / SIZE.0].map(|place| place as u16 / 16);
        [14_000 + 18_000 * x, 52_000 - 16_000 * x, 16_000 + 15_000 * y]
    });
    codes.collect()
}

/// The folder after a box was put into the photograph `name` with these `bytes`; the project has the further `lines`.
fn restaged(name: &str, bytes: &[u8], lines: &str) -> Stage {
    let folder = Stage::new();
    std::fs::write(folder.path(name), bytes).unwrap();
    let project = format!("scene = \"scene.glb\"\nphoto = \"{name}\"\nexposure = 1\n{lines}");
    folder.write("p.toml", &project);
    folder.write("e.toml", &format!("project = \"p.toml\"\n{INSERT}"));
    folder.succeeds(&["e.toml", "--composite", "--spp", "2", "--out", "out"]);
    folder
}

/// The greatest difference of two lists of codes where the composite was left alone.
fn farthest(folder: &Folder, a: &Codes, b: &Codes) -> u16 {
    let (touched, _) = shown(&folder.path("out/touched.png"));
    assert!(touched.contains(&0) && touched.contains(&u16::MAX));
    let all = a.iter().zip(b).zip(&touched).filter(|(_, touched)| **touched == 0);
    all.map(|((a, b), _)| a.abs_diff(*b)).max().unwrap()
}

/// Asserts that what was left alone is shown as `expected`, to within `near`; returns the profile of the composite.
#[track_caller]
fn is_shown_as(folder: &Folder, expected: &Codes, near: u16) -> Option<Vec<u8>> {
    let [composite, photo, synthetic] = ["composite", "photo", "synthetic"]
        .map(|name| shown(&folder.path(&format!("out/{name}.png"))));
    assert_eq!(farthest(folder, &composite.0, &photo.0), 0);
    let far = farthest(folder, &composite.0, expected);
    assert!(far <= near, "{far}");
    assert!(composite.1 == photo.1 && composite.1 == synthetic.1);
    composite.1
}

#[test]
fn the_profile_of_a_jpeg_and_of_a_tiff_goes_with_its_codes() {
    let codes = colours();
    let p3 = ColorProfile::new_display_p3();
    let icc = p3.encode().unwrap();
    let folder = restaged("p.jpg", &jpeg(SIZE, &encoded(&codes, &p3), icc.clone()), "");
    // Its codes have 8 bits, of a wider space.
    assert_eq!(is_shown_as(&folder, &codes, 3 * NEAR), Some(icc));
    for profile in [ColorProfile::new_adobe_rgb(), ColorProfile::new_pro_photo_rgb()] {
        let icc = profile.encode().unwrap();
        let folder = restaged("p.tif", &tiff(SIZE, &encoded(&codes, &profile), &icc), "");
        assert_eq!(is_shown_as(&folder, &codes, NEAR), Some(icc));
    }
}

#[test]
fn colours_that_no_profile_declares_get_one() {
    let codes = colours();
    let mut adobe = ColorProfile::new_adobe_rgb();
    let curve = Some(moxcms::curve_from_gamma(1.8));
    (adobe.red_trc, adobe.green_trc, adobe.blue_trc) = (curve.clone(), curve.clone(), curve);
    let corners = [(0.3127, 0.3290), (0.64, 0.33), (0.21, 0.71), (0.15, 0.06)];
    let [white, red, green, blue] = corners;
    let declare = |info: &mut png::Info<'_>| {
        info.source_gamma = Some(png::ScaledFloat::new(1.0 / 1.8));
        info.source_chromaticities = Some(png::SourceChromaticities::new(white, red, green, blue));
    };
    let folder = restaged("p.png", &png(SIZE, &encoded(&codes, &adobe), declare, &[]), "");
    assert!(is_shown_as(&folder, &codes, NEAR).is_some());
    let p3 = encoded(&codes, &ColorProfile::new_display_p3());
    let folder = restaged("p.png", &png(SIZE, &p3, |_| (), &[(b"cICP", &[12, 13, 0, 1])]), "");
    assert!(is_shown_as(&folder, &codes, NEAR).is_some());
}

#[test]
fn a_response_that_the_project_states_gets_a_profile() {
    let codes = colours();
    let linear = |code: &u16| {
        let linear = unrender::scene::color::linear_from_srgb(f32::from(*code) / 65_535.0);
        (65_535.0 * (0.1 + 0.9 * linear)).round() as u16
    };
    let lines = "response = \"linear\"\nblack_level = 0.1\n";
    let photo: Codes = codes.iter().map(linear).collect();
    let folder = restaged("p.png", &png(SIZE, &photo, |_| (), &[]), lines);
    assert!(is_shown_as(&folder, &codes, NEAR).is_some());
    // Another gamma than that of its own profile.
    let adobe = ColorProfile::new_adobe_rgb();
    let icc = adobe.encode().unwrap();
    let own = |info: &mut png::Info<'_>| info.icc_profile = Some(icc.clone().into());
    let photo = png(SIZE, &encoded(&codes, &adobe), own, &[]);
    let stated = restaged("p.png", &photo, "response = { gamma = 1.8 }\n");
    let [seen, as_declared] =
        [shown(&stated.path("out/composite.png")), shown(&stated.path("p.png"))];
    assert_ne!(seen.1, Some(icc));
    assert!(farthest(&stated, &seen.0, &as_declared.0) > 10 * NEAR);
}

#[test]
fn codes_of_srgb_have_no_profile() {
    let codes = colours();
    for lines in ["", "response = \"srgb\"\n"] {
        let folder = restaged("p.png", &png(SIZE, &codes, |_| (), &[]), lines);
        assert_eq!(is_shown_as(&folder, &codes, 0), None);
    }
}

/// The pictures under the divider of a gallery.
fn compared(folder: &Folder) -> [Image<Rgb>; 2] {
    let page = folder.text("out/gallery.html");
    let mut sources = page.split("data:image/jpeg;base64,").skip(1);
    [(); 2].map(|()| {
        let text = sources.next().unwrap().split('"').next().unwrap();
        let bytes = BASE64_STANDARD.decode(text).unwrap();
        let read = picture::decode(&bytes, Path::new("p")).unwrap().0;
        assert_eq!(read.profile, None);
        read.values
    })
}

#[test]
fn the_gallery_shows_srgb() {
    let codes = colours();
    let plain = restaged("p.png", &png(SIZE, &codes, |_| (), &[]), "");
    for profile in [ColorProfile::new_display_p3(), ColorProfile::new_pro_photo_rgb()] {
        let icc = profile.encode().unwrap();
        let wide = restaged("p.tif", &tiff(SIZE, &encoded(&codes, &profile), &icc), "");
        for (plain, wide) in compared(&plain).iter().zip(&compared(&wide)) {
            let pairs = plain.pixels().iter().zip(wide.pixels());
            let sum: f32 = pairs.map(|(a, b)| (*a - *b).abs().element_sum()).sum();
            let mean = sum / (3 * plain.pixels().len()) as f32;
            assert!(mean < 0.004, "{mean}");
        }
    }
}

#[test]
fn a_picture_without_a_composite_has_the_profile_too() {
    let p3 = ColorProfile::new_display_p3();
    let icc = p3.encode().unwrap();
    let folder = restaged("p.tif", &tiff(SIZE, &encoded(&colours(), &p3), &icc), "");
    let frames = "[camera]\nframes = 2\nfov_y_deg = 45\n\
         [[camera.keys]]\neye = [0, 1, 3]\ntarget = [0, 0.5, 0]\n\
         [[camera.keys]]\neye = [1, 1, 3]\ntarget = [0, 0.5, 0]\n";
    folder.write("s.toml", &format!("project = \"p.toml\"\n{frames}"));
    let size = ["--width", "12", "--height", "9", "--spp", "1"];
    succeeds(&folder.restage(&[&["s.toml", "--out", "views"], &size[..]].concat()));
    for name in ["synthetic_0001", "synthetic_0002", "photo"] {
        assert_eq!(
            shown(&folder.path(&format!("views/{name}.png"))).1.as_ref(),
            Some(&icc),
            "{name}"
        );
    }
}

#[test]
fn numbers_of_other_primaries_say_so() {
    let p3 = unrender::scene::Rgb::new(0.2, 0.5, 0.3);
    let photo = Image::from_fn(SIZE.0, SIZE.1, |x, _| p3 * (1.0 + 0.01 * x as f32));
    let matrix = glam::Mat3::from_cols_array(&[
        1.2249, -0.0420, -0.0197, -0.2249, 1.0420, -0.0786, 0.0, 0.0, 1.0983,
    ]);
    let folder = Stage::new();
    picture::write_exr_as(&folder.path("photo.exr"), &photo, Some(matrix)).unwrap();
    let bytes = folder.bytes("photo.exr");
    drop(folder);
    let folder = restaged("p.exr", &bytes, "");
    let made = picture::read(&folder.path("out/composite.exr")).unwrap().0;
    let declared = made.profile.unwrap().srgb_from_file.unwrap();
    assert!(declared.abs_diff_eq(matrix, 1e-3), "{declared}");
    let (touched, _) = shown(&folder.path("out/touched.png"));
    let pairs = made.values.pixels().iter().zip(photo.pixels());
    let alone = pairs.zip(touched.chunks(3)).filter(|(_, touched)| touched[0] == 0);
    assert!(alone.clone().count() > 100 && alone.map(|(pair, _)| pair).all(|(a, b)| a == b));
}
