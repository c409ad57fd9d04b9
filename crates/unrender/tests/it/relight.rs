//! Light layers of the command: they add up to the picture, relight it as a rendering would, and impossible
//! requests are refused.

use crate::kit::example::beside_crates;
use crate::kit::folder::{self, Folder, is_refused, stderr};
use std::process::Output;
use unrender::formats::picture;
use unrender::scene::{Rgb, RgbImage};

/// Rounding of single precision over the lights and samples of a pixel, relative to the brightest
/// pixel.
pub(crate) const ROUNDING: f32 = 1e-5;

pub(crate) fn unrender(folder: &Folder, arguments: &str) -> Output {
    let scene = beside_crates("examples/fig8/scene.glb");
    let scene = scene.to_str().unwrap();
    let words = arguments.split(' ').map(|word| if word == "SCENE" { scene } else { word });
    folder.run(&words.collect::<Vec<_>>())
}

#[track_caller]
fn succeeds(folder: &Folder, arguments: &str) {
    folder::succeeds(&unrender(folder, arguments));
}

#[track_caller]
fn fails(folder: &Folder, arguments: &str, problem: &str) -> String {
    is_refused(&unrender(folder, arguments), problem)
}

pub(crate) fn read(folder: &Folder, name: &str) -> RgbImage {
    picture::read(&folder.path(name)).unwrap().0.to_linear()
}

/// The largest difference, relative to the brightest pixel of `a`.
fn difference(a: &RgbImage, b: &RgbImage) -> f32 {
    let brightest = a.pixels().iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let pairs = a.pixels().iter().zip(b.pixels());
    pairs.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max) / brightest
}

#[test]
fn lights_become_brighter_and_darker_without_tracing() {
    let folder = &Folder::new();
    let sky = RgbImage::from_fn(4, 2, |x, y| Rgb::new(0.1, 0.2, 0.3) * (1 + x + 4 * y) as f32);
    picture::write(&folder.path("sky.exr"), &sky).unwrap();
    let render = "render SCENE --environment sky.exr --height 24 --spp 8 --quiet";
    succeeds(folder, &format!("{render} --layers --out layers.exr"));
    succeeds(folder, &format!("{render} --independent --out whole.exr"));
    let whole = read(folder, "whole.exr");
    assert_eq!(read(folder, "layers.exr"), whole, "the picture beside its layers");

    let layers = picture::read_layers(folder.path("layers.exr").as_path()).unwrap();
    let names: Vec<&str> = layers.iter().map(|layer| layer.name.as_str()).collect();
    assert_eq!((names.len(), names.last()), (2, Some(&"environment")), "{names:?}");
    let lamp = names[0];

    succeeds(folder, "relight layers.exr --out same.exr");
    assert!(difference(&whole, &read(folder, "same.exr")) < ROUNDING);
    // A sky of another strength gives other paths, as light samples choose among lights by their power; if
    // only the sky is left, the choice is the same.
    let light =
        format!("relight layers.exr --light {lamp}=0.5,1,2 --light environment=3 --out relit.exr");
    succeeds(folder, &light);
    let relit = read(folder, "relit.exr");
    for (index, relit) in relit.pixels().iter().enumerate() {
        let [lamp, sky] = [0, 1].map(|layer: usize| layers[layer].radiance.pixels()[index]);
        let expected = lamp * Rgb::new(0.5, 1.0, 2.0) + 3.0 * sky;
        assert!((*relit - expected).abs().max_element() <= ROUNDING * expected.max_element());
    }
    succeeds(folder, &format!("relight layers.exr --only {lamp} --out lamp.exr"));
    assert_eq!(read(folder, "lamp.exr"), layers[0].radiance);
    // Compared with a rendering with the lamp alone, whose light does not change without the sky.
    succeeds(folder, "render SCENE --height 24 --spp 64 --seed 5 --out alone.exr --quiet");
    let mean = |picture: &RgbImage| picture.pixels().iter().copied().sum::<Rgb>();
    let share = mean(&read(folder, "lamp.exr")) / mean(&read(folder, "alone.exr"));
    assert!((share - Rgb::ONE).abs().max_element() < 0.1, "{share}");
}

#[test]
fn a_checkpoint_goes_on_with_its_layers() {
    let folder = &Folder::new();
    let render = "render SCENE --height 16 --layers --quiet";
    succeeds(folder, &format!("{render} --spp 6 --out whole.exr"));
    succeeds(folder, &format!("{render} --spp 2 --checkpoint c.exr --out half.exr"));
    succeeds(folder, &format!("{render} --spp 6 --checkpoint c.exr --out done.exr"));
    assert_eq!(folder.bytes("whole.exr"), folder.bytes("done.exr"));
    let told = unrender(folder, "merge c.exr --out merged.exr");
    assert!(stderr(&told).contains("without its light layers"));
    assert_eq!(read(folder, "merged.exr"), read(folder, "whole.exr"));
}

#[test]
fn what_does_not_go_is_refused_before_anything_is_written() {
    let folder = &Folder::new();
    fails(folder, "render SCENE --layers --out a.png", "light layers are kept in .exr files");
    fails(folder, "render SCENE --layers --denoise --out a.exr", "cannot be used with");
    fails(folder, "farm SCENE --layers --spp 9 --out a.exr --to slurm", "have no light layers");
    succeeds(folder, "render SCENE --height 8 --spp 2 --out plain.exr --quiet");
    fails(folder, "relight plain.exr --out a.png", "has no light layers");
    fails(folder, "relight none.exr --out a.png", "none.exr");
    succeeds(folder, "render SCENE --height 8 --spp 2 --layers --out layers.exr --quiet");
    let told =
        fails(folder, "relight layers.exr --light none=1 --out a.png", "has no light \"none\"");
    assert!(told.contains("it has \""), "{told}");
    fails(folder, "relight layers.exr --light none --out a.png", "write a name and a factor");
    fails(folder, "relight layers.exr --out layers.exr", "is an input");
    let left: Vec<_> =
        std::fs::read_dir(folder.root()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");
}
