//! Pictures of whole numbers come back to the bit, and panoramas as environments; errors name the
//! fault.

use crate::support::Folder;
use std::path::Path;
use unrender_formats::picture::{self, read_environment};
use unrender_formats::planes::{self, Planes};
use unrender_scene::{Image, Rgb, RgbImage};

fn ramp() -> RgbImage {
    Image::from_fn(7, 5, |x, y| Rgb::new(x as f32, y as f32, 3.0) / 7.0)
}

fn planes() -> Planes {
    let numbers = |seed: u32| (0..35u32).map(|i| (i + seed).wrapping_mul(0x9E37_79B9)).collect();
    let channels = vec![("count".into(), vec![16; 35]), ("sum_r_0".into(), numbers(1))];
    Planes { width: 7, height: 5, text: "{\"a\": \"ü\"}".into(), channels }
}

#[test]
fn whole_numbers_come_back_and_the_picture_is_a_picture() {
    let folder = Folder::new();
    let path = folder.path("a.exr");
    planes::write(&path, planes(), &ramp()).unwrap();
    let back = planes::read(&path).unwrap();
    assert_eq!(back, planes());
    assert_eq!(back.channel("count"), Some(&[16; 35][..]));
    assert_eq!(back.channel("nothing"), None);
    assert_eq!(picture::read(&path).unwrap().0.values, ramp());
}

#[test]
fn files_of_another_kind_and_damaged_ones_are_reported() {
    let folder = Folder::new();
    let path = folder.path("a.exr");
    let problem = |path: &Path| planes::read(path).unwrap_err().to_string();
    assert!(problem(&path).contains("cannot be read"));
    picture::write(&path, &ramp()).unwrap();
    assert!(problem(&path).contains("without the sums"), "{}", problem(&path));
    planes::write(&path, planes(), &ramp()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    for length in (0..bytes.len()).step_by(5) {
        std::fs::write(&path, &bytes[..length]).unwrap();
        assert!(problem(&path).contains("cut short"), "{length} of {}", bytes.len());
    }
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0xff;
        std::fs::write(&path, damaged).unwrap();
        // Not every damage can be detected; reading must end without a panic.
        let _ = planes::read(&path);
    }
}

#[test]
fn panoramas_are_linear_and_what_is_doubtful_is_reported() {
    let folder = Folder::new();
    let path = folder.path("sky.exr");
    let told = |path: &Path| {
        let (environment, warnings) = read_environment(path, 0.0, 2.0).unwrap();
        (*environment.panorama().at(1, 0), warnings.0)
    };
    let sky = Image::from_fn(4, 2, |x, _| Rgb::splat(0.5 * x as f32));
    picture::write(&path, &sky).unwrap();
    assert_eq!(told(&path), (Rgb::ONE, vec![]));
    picture::write(&path, &sky.map(|rgb| *rgb - 0.25)).unwrap();
    let (value, warnings) = told(&path);
    assert!(value == Rgb::splat(0.5) && warnings[0].contains("2 pixel(s) have negative"));
    picture::write(&path, &ramp()).unwrap();
    assert!(told(&path).1[0].contains("twice as wide as high; this one has 7 x 5"));
    picture::write(&path, &sky.map(|_| Rgb::ZERO)).unwrap();
    assert!(told(&path).1[0].contains("is black"));
    let png = folder.path("sky.png");
    picture::write(&png, &sky).unwrap();
    let (value, warnings) = told(&png);
    assert!((value - Rgb::ONE).abs().max_element() < 0.01, "{value}");
    assert!(warnings[0].contains("sRGB picture"), "{warnings:?}");
    picture::write(&path, &sky).unwrap();
    let error = read_environment(&path, 0.0, f32::MAX).unwrap_err().to_string();
    assert!(error.contains("sky.exr: pixel 3 of the panorama is"), "{error}");
}
