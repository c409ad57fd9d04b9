//! EXR files of other channels than R, G and B: read by the names of their channels, or refused.

use crate::support::pictures::{exr, exr_head, part, read, refusal, warned};
use crate::support::{Numbers, damaged};
use std::path::Path;
use unrender_formats::picture;
use unrender_scene::Rgb;

fn first(bytes: &[u8]) -> Rgb {
    let (picture, warnings) = read(bytes);
    assert!(warnings.is_empty(), "{warnings:?}");
    picture.values.pixels()[0]
}

#[test]
fn channels_are_read_by_their_names() {
    let colour = Rgb::new(1.0, 2.0, 3.0);
    for names in [
        ["R", "G", "B"],
        ["r", "g", "b"],
        ["red", "green", "blue"],
        ["ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"],
        ["beauty.r", "beauty.g", "beauty.b"],
    ] {
        let channels = [(names[0], 1.0), (names[1], 2.0), (names[2], 3.0)];
        assert_eq!(first(&exr(&[part("", &channels)])), colour, "{names:?}");
        assert_eq!(first(&exr(&[part("p", &channels)])), colour, "{names:?}");
    }
    assert_eq!(first(&exr(&[part("", &[("Y", 0.5)])])), Rgb::splat(0.5));
    // A layer of another name may be another pass.
    let bytes = exr(&[part("", &[("A", 1.0), ("L.Y", 0.25)])]);
    let grey = warned(&bytes, "the layer \"L\" was read, the only one with colours");
    assert_eq!(grey.values.pixels()[0], Rgb::splat(0.25));
    // The channels without a layer are the picture, whatever is beside them.
    let beside = [("R", 1.0), ("G", 2.0), ("B", 3.0), ("Y", 9.0), ("beauty.R", 9.0), ("Z", 9.0)];
    assert_eq!(first(&exr(&[part("", &beside)])), colour);
}

/// The channels R, G and B of these layers, with values that count the layers.
fn layers(names: &[String]) -> Vec<(&str, f32)> {
    names.iter().enumerate().map(|(k, name)| (name.as_str(), (k / 3) as f32)).collect()
}

fn names(layers: &[&str]) -> Vec<String> {
    layers.iter().flat_map(|l| ["R", "G", "B"].map(|c| format!("{l}.{c}"))).collect()
}

#[test]
fn among_layers_the_picture_is_taken_and_told() {
    for (of, taken) in [
        (&["diffuse", "beauty", "glossy"][..], 1.0),
        (&["ViewLayer.Combined", "ViewLayer.DiffDir"], 0.0),
        (&["Left.Combined", "Composite.Combined"], 1.0),
    ] {
        let names = names(of);
        let bytes = exr(&[part("", &layers(&names))]);
        let told = format!("the layer \"{}\" was read, and not", of[taken as usize]);
        assert_eq!(warned(&bytes, &told).values.pixels()[0], Rgb::splat(taken));
    }
    let names = names(&["diffuse", "glossy"]);
    let said = refusal(&exr(&[part("", &layers(&names))]));
    assert!(
        said.contains("has several pictures as layers, diffuse, glossy; save the one"),
        "{said}"
    );
}

#[test]
fn among_parts_the_picture_is_taken_and_told() {
    let rgb = |value| [("R", value), ("G", value), ("B", value)];
    let ([one, two], z) = ([rgb(1.0), rgb(2.0)], [("Z", 5.0)]);
    // The only part with colours, the one with a picture's name, the first one.
    assert_eq!(first(&exr(&[part("depth", &z), part("colour", &two)])), Rgb::splat(2.0));
    let bytes = exr(&[part("normals", &one), part("rgba", &two)]);
    assert_eq!(warned(&bytes, "\"rgba\" was read, and not normals").values.pixels()[0].x, 2.0);
    let bytes = exr(&[part("left", &one), part("right", &two)]);
    assert_eq!(warned(&bytes, "\"left\" was read, and not right").values.pixels()[0].x, 1.0);
}

#[test]
fn kinds_that_are_not_read_say_which_channels_they_have() {
    let normals = [("N.X", 0.0), ("N.Y", 0.0), ("N.Z", 1.0), ("depth.Z", 1.0)];
    let chroma = [("BY", 0.0), ("RY", 0.0), ("Y", 1.0)];
    for (bytes, words) in [
        (exr(&[part("", &normals)]), "has the channels N.X, N.Y, N.Z, depth.Z, among which"),
        (exr(&[part("", &[("R", 1.0)])]), "has the channels R, among which"),
        (exr(&[part("", &chroma)]), "is a luminance-chroma EXR: it has the channels BY, RY, Y"),
        (
            exr_head(&[("BY", 2), ("RY", 2), ("Y", 1)], 3, "scanlineimage"),
            "is a luminance-chroma EXR: it has the channels BY, RY, Y",
        ),
        (exr_head(&[("B", 2), ("G", 1), ("R", 2)], 3, "scanlineimage"), "without subsampling"),
        (
            exr_head(&[("A", 1), ("B", 1), ("G", 1), ("R", 1), ("Z", 1)], 3, "deepscanline"),
            "is a deep EXR: it has several samples a pixel in the channels A, B, G, R, Z",
        ),
        (exr_head(&[("B", 1), ("G", 1), ("R", 1)], 10, "scanlineimage"), "a method of EXR"),
    ] {
        let said = refusal(&bytes);
        assert!(said.contains(words) && said.contains("save"), "{words}: {said}");
        assert!(!said.contains("corrupt") && !said.contains("cut short"), "{said}");
    }
    let many: Vec<String> = (0..40).map(|k| format!("c{k:02}")).collect();
    let many: Vec<(&str, f32)> = many.iter().map(|name| (name.as_str(), 0.0)).collect();
    assert!(refusal(&exr(&[part("", &many)])).contains("c15 and 24 more"));
}

#[test]
fn what_was_cut_short_is_to_be_copied_again() {
    let bytes = exr(&[part("", &[("R", 1.0), ("G", 2.0), ("B", 3.0)])]);
    for left in [9, bytes.len() / 2, bytes.len() - 1] {
        let said = refusal(&bytes[..left]);
        assert!(said.ends_with("is cut short or corrupt; copy it or save it once more"), "{said}");
    }
}

#[test]
fn damaged_headers_never_panic() {
    let deep = exr_head(&[("R", 1), ("G", 1), ("B", 1)], 3, "deepscanline");
    let colours = [("R", 1.0), ("G", 2.0), ("B", 3.0), ("A", 0.0)];
    let layers = exr(&[part("a", &colours), part("b", &colours)]);
    let mut numbers = Numbers(7);
    for whole in [deep, layers] {
        for _ in 0..3000 {
            let _ = picture::decode(&damaged(&whole, &mut numbers), Path::new("p"));
        }
    }
}
