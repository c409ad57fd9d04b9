//! Ten textures and ten patterns that are none, in closed form.

use super::lit::Lit;
use super::pattern::{ALPHAS, Judge, Pattern};
use crate::observe::observation::Noise;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;
use unrender_render::sampler::mix;
use unrender_render::{GeometryBuffers, PixelGeometry};
use unrender_scene::{Image, Rgb};

/// The side of the square of pixels that shows the group.
const SIDE: usize = 80;
/// The contrast that makes a texture by default.
const LEAST: f64 = 0.035;

/// A plane whose texture repeats after so many pixels.
fn plane(period: f32) -> GeometryBuffers {
    Image::from_fn(SIDE, SIDE, |x, y| PixelGeometry {
        object: 0,
        group: 0,
        depth: 1.0,
        normal: Vec3::Z,
        tangent: Vec3::X,
        uv: Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / period,
        front: true,
    })
}

/// A number from -1 to 1 of standard deviation 0.58 for each `i` of a stream.
fn scatter(stream: u64, i: usize) -> f32 {
    (mix(mix(stream) ^ i as u64) >> 40) as f32 / (1u64 << 23) as f32 - 1.0
}

/// About normal noise of standard deviation one.
fn noise(stream: u64, i: usize) -> f32 {
    (0..12).map(|k| scatter(stream * 16 + k, i)).sum::<f32>() / 2.0
}

/// A pixel of what the photograph shows of a surface of the reflectance 0.4.
#[derive(Clone, Copy)]
struct Pixel {
    /// The reflectance relative to the mean.
    pattern: Rgb,
    /// The light that really arrives, and the one that is known of, twice.
    light: f32,
    known: [f32; 2],
    /// What is added to the photograph, and what the best uniform reflectance has beside the diffuse light.
    added: f32,
    lobe: f32,
    /// The photograph's noise, relative.
    noise: f32,
}

/// A diffuse surface.
const PLAIN: Pixel =
    Pixel { pattern: Rgb::ONE, light: 1.0, known: [1.0; 2], added: 0.0, lobe: 0.0, noise: 0.0 };

/// The `pixels`, by column and row, of a plane whose texture repeats after so many, without a lobe; and their judge.
fn judged(period: f32, pixels: impl Fn(usize, usize) -> Pixel) -> (Lit, Judge) {
    let all: Vec<Pixel> = (0..SIDE * SIDE).map(|i| pixels(i % SIDE, i / SIDE)).collect();
    let half = |h: usize| all.iter().map(|p| Rgb::splat(p.known[h])).collect::<Vec<Rgb>>();
    let shown = |p: &Pixel| (0.4 * p.light * p.pattern + p.added) * (1.0 + p.noise);
    let lit = Lit {
        pixels: (0..all.len() as u32).collect(),
        shown: all.iter().map(shown).collect(),
        noise: vec![Noise::NONE; all.len()],
        base: [half(0), half(1)],
        shine: [vec![Rgb::ZERO; all.len()], vec![Rgb::ZERO; all.len()]],
        ..Lit::default()
    };
    let uniform = [0, 1].map(|h: usize| -> Vec<Rgb> {
        all.iter().map(|p| Rgb::splat(0.4 * p.known[h] + p.lobe)).collect()
    });
    let plain = [0, 1].map(|h: usize| all.iter().map(|p| Rgb::splat(0.4 * p.known[h])).collect());
    let judge = Judge::of(&lit, &[uniform, plain], &plane(period)).unwrap();
    (lit, judge)
}

/// What is predicted of them.
fn predicted(period: f32, pixels: impl Fn(usize, usize) -> Pixel) -> Pattern {
    let (lit, judge) = judged(period, pixels);
    judge.predicted(&lit)
}

/// A highlight around the middle of the plane whose width is that of a lobe of the roughness `alpha`.
fn highlight(alpha: f32, x: usize, y: usize) -> f32 {
    let far = (x as f32 - 40.0).powi(2) + (y as f32 - 40.0).powi(2);
    0.02 / alpha * (-0.5 * far / (160.0 * alpha).powi(2)).exp()
}

/// The roughness of the lobe over the texture of the `pixels`.
fn roughness(pixels: impl Fn(usize, usize) -> Pixel) -> Option<f32> {
    roughness_under(highlight, pixels)
}

/// The same where lobes of a roughness show this, by column and row.
fn roughness_under(
    highlight: impl Fn(f32, usize, usize) -> f32,
    pixels: impl Fn(usize, usize) -> Pixel,
) -> Option<f32> {
    let (plain, judge) = judged(16.0, pixels);
    let under = |alpha: f32| {
        let shine = plain.pixels.iter().map(|i| {
            let (x, y) = (*i as usize % SIDE, *i as usize / SIDE);
            Rgb::splat(highlight(alpha, x, y))
        });
        let shine: Vec<Rgb> = shine.collect();
        (alpha, Lit { shine: [shine.clone(), shine], ..plain.clone() })
    };
    judge.roughness(&plain, &ALPHAS.map(under))
}

#[test]
fn a_lobe_over_a_texture_is_found_where_its_highlight_covers_several_places() {
    let textured = |x: usize, y: usize, added: f32| Pixel {
        added,
        lobe: added,
        noise: 0.02 * noise(1, y * SIDE + x),
        ..grey(0.3 * sine(x, 16.0) * sine(y, 8.0))
    };
    let found = roughness(|x, y| textured(x, y, highlight(0.14, x, y))).unwrap();
    assert!((found / 0.14 - 1.0).abs() < 0.1, "{found}");
    assert_eq!(roughness(|x, y| textured(x, y, 0.0)), None);
    // What is brightest of a lobe, a window's reflection in one place, does not hide the rest of it.
    let glare = |x: usize, y: usize| if x.abs_diff(8) + y.abs_diff(8) < 4 { 20.0 } else { 0.0 };
    let with_glare =
        |alpha: f32, x: usize, y: usize| highlight(alpha, x, y) + 0.14 / alpha * glare(x, y);
    let found = roughness_under(with_glare, |x, y| textured(x, y, with_glare(0.14, x, y))).unwrap();
    assert!((found / 0.14 - 1.0).abs() < 0.1, "{found}");
    // A bright thing in one place that no lobe has, however bright.
    let bright = |x: usize, y: usize| if x.abs_diff(40) + y.abs_diff(40) < 6 { 50.0 } else { 0.0 };
    assert_eq!(roughness(|x, y| Pixel { added: bright(x, y), ..textured(x, y, 0.0) }), None);
}

/// A picture that is smooth over so many pixels, without repeats.
fn picture(stream: u64, smooth: f32) -> impl Fn(usize, usize) -> f32 {
    move |x, y| {
        let (x, y) = (x as f32 / smooth, y as f32 / smooth);
        let (left, top) = (x.floor(), y.floor());
        let at = |dx: f32, dy: f32| {
            let (x, y) = ((left + dx) as usize, (top + dy) as usize);
            scatter(stream, y * 1000 + x)
        };
        let (fx, fy) = (x - left, y - top);
        let upper = at(0.0, 0.0) * (1.0 - fx) + at(1.0, 0.0) * fx;
        let lower = at(0.0, 1.0) * (1.0 - fx) + at(1.0, 1.0) * fx;
        upper * (1.0 - fy) + lower * fy
    }
}

/// Pixels by column and row.
type Picture = Box<dyn Fn(usize, usize) -> Pixel>;

fn grey(contrast: f32) -> Pixel {
    Pixel { pattern: Rgb::splat(1.0 + contrast), ..PLAIN }
}

fn sine(at: usize, period: f32) -> f32 {
    (TAU * (at as f32 + 0.5) / period).sin()
}

#[test]
fn textures_are_found() {
    let square = |x: usize, y: usize, side: usize| {
        if (x / side + y / side).is_multiple_of(2) { 1.0 } else { -1.0 }
    };
    let all: [(&str, f32, Picture); 10] = [
        ("checkers", 16.0, Box::new(move |x, y| grey(0.5 * square(x, y, 8)))),
        ("stripes", 10.0, Box::new(|x, _| grey(0.2 * sine(x, 5.0)))),
        (
            "noisy wallpaper",
            10.0,
            Box::new(|x, y| {
                let pattern = 0.15 * (sine(x, 10.0) * sine(y, 10.0));
                Pixel { noise: 0.12 * noise(1, y * SIDE + x), ..grey(pattern) }
            }),
        ),
        ("planks", 80.0, Box::new(|x, y| grey(0.45 * picture(2, 4.0)(x, y / 20)))),
        ("a painting", 80.0, Box::new(|x, y| grey(0.6 * picture(3, 6.0)(x, y)))),
        (
            "faint tiles",
            16.0,
            Box::new(move |x, y| Pixel {
                noise: 0.02 * noise(4, y * SIDE + x),
                ..grey(0.06 * square(x, y, 8))
            }),
        ),
        (
            "dots",
            12.0,
            Box::new(|x, y| {
                let far = Vec2::new((x % 12) as f32 - 6.0, (y % 12) as f32 - 6.0).length();
                grey(if far < 3.0 { 0.5 } else { -0.1 })
            }),
        ),
        ("mosaic", 80.0, Box::new(|x, y| grey(0.4 * scatter(5, y / 5 * 100 + x / 5)))),
        (
            "colours of one brightness",
            20.0,
            Box::new(|x, y| {
                let hue = 0.2 * sine(x, 20.0) * sine(y, 20.0);
                Pixel { pattern: Rgb::new(1.0 + hue, 1.0, 1.0 - hue), ..PLAIN }
            }),
        ),
        (
            "a pattern in the light of a lamp",
            33.0,
            Box::new(|x, y| {
                let light = 0.2
                    + 4.0
                        * (-((x as f32 - 20.0).powi(2) + (y as f32 - 30.0).powi(2)) / 800.0).exp();
                Pixel {
                    light,
                    known: [light; 2],
                    noise: 0.05 * noise(6, y * SIDE + x),
                    ..grey(0.15 * sine(x, 11.0) * sine(y, 16.5))
                }
            }),
        ),
    ];
    for (name, period, pixels) in all {
        let found = predicted(period, pixels);
        assert!(found.is_texture(LEAST), "{name}: {found:?}");
    }
}

#[test]
fn what_only_looks_like_a_texture_is_none() {
    let bump = |x: usize, y: usize, size: f32| {
        let far = (x as f32 - 40.0).powi(2) + (y as f32 - 40.0).powi(2);
        (-0.5 * far / (size * size)).exp()
    };
    let all: [(&str, Picture); 10] = [
        ("nothing at all", Box::new(|_, _| PLAIN)),
        ("noise", Box::new(|x, y| Pixel { noise: 0.1 * noise(1, y * SIDE + x), ..PLAIN })),
        (
            "blocks of a JPEG",
            Box::new(|x, y| Pixel {
                noise: 0.01 * noise(2, y * SIDE + x) + 0.02 * scatter(3, y / 8 * 100 + x / 8),
                ..PLAIN
            }),
        ),
        (
            "noise of demosaicing",
            Box::new(|x, y| {
                let near = (0..9).map(|k| noise(4, (y + k / 3) * 100 + x + k % 3)).sum::<f32>();
                Pixel { noise: 0.05 * near / 3.0, ..PLAIN }
            }),
        ),
        (
            "a lamp of another size",
            Box::new(move |x, y| {
                let light = |size: f32| 0.3 + bump(x, y, size);
                Pixel { light: light(22.0), known: [light(20.0); 2], ..PLAIN }
            }),
        ),
        (
            "a broad highlight that is not in the model",
            Box::new(move |x, y| Pixel {
                added: 0.2 * bump(x, y, 16.0),
                noise: 0.01 * noise(5, y * SIDE + x),
                ..PLAIN
            }),
        ),
        (
            "a mirror image, displaced",
            Box::new(|x, y| {
                let image = |x: usize| 0.4 + 0.3 * picture(6, 8.0)(x, y);
                Pixel { added: image(x), lobe: image(x + 2), ..PLAIN }
            }),
        ),
        (
            "a shadow beside its place",
            Box::new(|x, y| {
                let lit = |edge: usize| if x + y / 4 < edge { 1.0 } else { 0.3 };
                Pixel {
                    light: lit(50),
                    known: [lit(51); 2],
                    noise: 0.01 * noise(7, y * SIDE + x),
                    ..PLAIN
                }
            }),
        ),
        (
            "outliers",
            Box::new(|x, y| {
                let is_out = scatter(8, y * SIDE + x) > 0.96;
                Pixel {
                    added: if is_out { 0.8 } else { 0.0 },
                    noise: 0.02 * noise(9, y * SIDE + x),
                    ..PLAIN
                }
            }),
        ),
        (
            "noise of the known light",
            Box::new(|x, y| {
                let known = [10, 11].map(|stream| 1.0 + 0.1 * noise(stream, y * SIDE + x));
                Pixel { known, noise: 0.02 * noise(12, y * SIDE + x), ..PLAIN }
            }),
        ),
    ];
    for (name, pixels) in all {
        for period in [80.0, 20.0] {
            let found = predicted(period, &pixels);
            assert!(!found.is_texture(LEAST), "{name}, {period}: {found:?}");
        }
    }
}
