//! The picture of the check: the pale photograph under the edges of the model.
//!
//! Green where the photograph has the edge too; red where it has it elsewhere, and yellow there; blue
//! where it shows none. Small photographs are enlarged by a whole number.

use super::{Edge, EdgeKind};
use glam::Vec2;
use unrender_scene::color::{linear_from_srgb, luminance, srgb_from_linear};
use unrender_scene::{Image, Rgb, RgbImage};

/// Photographs are enlarged to about this many columns, but no more than ...
const COLUMNS: usize = 1400;
/// ... this many times.
const ENLARGED: usize = 4;
/// The picture is scaled so that this share of its pixels is below white.
const BELOW_WHITE: f32 = 0.98;
/// Half the width of a line, and of its dark border, pixels of a picture of [`COLUMNS`] or less.
const LINE: f32 = 1.2;
const BORDER: f32 = 2.2;

/// sRGB colours of edges that fit, that are off, of their true place, and of unseen ones.
const GREEN: Rgb = Rgb::new(0.20, 0.90, 0.30);
const RED: Rgb = Rgb::new(1.00, 0.15, 0.15);
const YELLOW: Rgb = Rgb::new(1.00, 0.90, 0.10);
const BLUE: Rgb = Rgb::new(0.35, 0.60, 1.00);
const BLACK: Rgb = Rgb::ZERO;

/// Draws `edges` over the photograph's linear values; the result is linear, 0 to 1.
pub fn edge_picture(photo: &RgbImage, edges: &[Edge]) -> RgbImage {
    let of = |wanted: EdgeKind| edges.iter().filter(move |e| e.kind == wanted);
    // The most important is drawn last.
    let layers = [
        (of(EdgeKind::Unseen).map(|e| e.at).collect(), BLUE),
        (of(EdgeKind::Fits).map(|e| e.at).collect(), GREEN),
        (of(EdgeKind::Off).map(|e| e.at).collect(), RED),
        (edges.iter().filter_map(|e| e.there).collect(), YELLOW),
    ];
    drawn_over(photo, &layers)
}

/// Draws layers of dots, pixels of the photograph with their sRGB colour, over its pale linear values.
pub(crate) fn drawn_over(photo: &RgbImage, layers: &[(Vec<Vec2>, Rgb)]) -> RgbImage {
    let zoom = (COLUMNS / photo.width().max(1)).clamp(1, ENLARGED);
    let white = white(photo);
    let pale = photo.map(|value| paled(*value / white));
    let (width, height) = (zoom * photo.width(), zoom * photo.height());
    let mut picture = RgbImage::from_fn(width, height, |x, y| *pale.at(x / zoom, y / zoom));
    let wider = (width as f32 / COLUMNS as f32).max(1.0);
    for (points, color) in layers {
        for (radius, srgb) in [(BORDER, BLACK), (LINE, *color)] {
            let color = srgb.map(linear_from_srgb);
            points
                .iter()
                .for_each(|&at| dot(&mut picture, at * zoom as f32, wider * radius, color));
        }
    }
    picture
}

/// The value that shows as white.
pub(crate) fn white(photo: &RgbImage) -> f32 {
    let mut values: Vec<f32> = photo.pixels().iter().map(|v| v.max_element()).collect();
    if values.is_empty() {
        return 1.0;
    }
    let rank = (BELOW_WHITE * (values.len() - 1) as f32) as usize;
    values.select_nth_unstable_by(rank, f32::total_cmp).1.max(f32::MIN_POSITIVE)
}

/// A linear value with half of its colour and three quarters of its contrast.
fn paled(value: Rgb) -> Rgb {
    let value = value.clamp(Rgb::ZERO, Rgb::ONE);
    let grey = value.lerp(Rgb::splat(luminance(value)), 0.5).map(srgb_from_linear);
    (0.1 + 0.75 * grey).map(linear_from_srgb)
}

fn dot(picture: &mut Image<Rgb>, at: Vec2, radius: f32, color: Rgb) {
    let (width, height) = (picture.width(), picture.height());
    let range = |centre: f32, side: usize| {
        let first = (centre - radius - 0.5).ceil().max(0.0) as usize;
        let last = (centre + radius - 0.5).floor().max(-1.0) + 1.0;
        first..(last as usize).min(side)
    };
    for y in range(at.y, height) {
        for x in range(at.x, width) {
            if Vec2::new(x as f32 + 0.5, y as f32 + 0.5).distance(at) <= radius {
                picture.pixels_mut()[y * width + x] = color;
            }
        }
    }
}
