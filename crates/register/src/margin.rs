//! Which pixels are too close to an edge of the model to be valid.

use super::Registration;
use super::edges::is_interior;
use unrender_render::{GeometryBuffers, NOTHING};
use unrender_scene::Image;

/// The least margin, pixels: the pixels beside an edge hold parts of both sides.
const LEAST: f32 = 1.0;
/// Below this a displacement may come from the photograph's own blur.
const SLIGHT: f32 = 0.75;
/// Edges scatter about the model's by this many standard deviations.
const DEVIATIONS: f32 = 1.0;
/// An object that is off by more than this has a displacement of its own, not the scatter of edges.
const OWN: f32 = 1.0;

/// The distance from an edge within which no pixel is valid, for every pixel, in pixels.
///
/// `registration` is that of the model to the photograph under the camera of `geometry`, if it is known.
pub fn margins(geometry: &GeometryBuffers, registration: Option<&Registration>) -> Image<f32> {
    let (width, height) = (geometry.width(), geometry.height());
    let Some(registration) = registration else {
        return Image::new(width, height, vec![LEAST; width * height]);
    };
    let own = |object: u32| match object {
        NOTHING => 0.0,
        object => registration.own.get(object as usize).copied().unwrap_or(0.0),
    };
    // Both sides of an edge are as doubtful as the one that is off further.
    Image::from_fn(width, height, |x, y| {
        let around = || geometry.neighbourhood(y * width + x);
        let own = around().map(|n| own(geometry.pixels()[n].object)).fold(0.0, f32::max);
        let camera = around().map(|n| registration.displacements.pixels()[n]).fold(0.0, f32::max);
        let off = camera + if own > OWN { own } else { 0.0 };
        if off < SLIGHT { LEAST } else { LEAST + off + DEVIATIONS * registration.deviation }
    })
}

/// True for the pixels that are closer to an edge of the model than `share` of its margin. Pixels on
/// an edge always are.
pub fn near_edges(geometry: &GeometryBuffers, margins: &Image<f32>, share: f32) -> Image<bool> {
    let (width, height) = (geometry.width(), geometry.height());
    let mut near = Image::new(width, height, vec![false; width * height]);
    for index in (0..width * height).filter(|&i| !is_interior(geometry, i)) {
        // A margin of one pixel is this pixel itself.
        let radius = (share * margins.pixels()[index] - 1.0).max(0.0);
        let reach = radius as usize;
        let (x, y) = (index % width, index / width);
        for row in y.saturating_sub(reach)..(y + reach + 1).min(height) {
            for col in x.saturating_sub(reach)..(x + reach + 1).min(width) {
                let distance = (col.abs_diff(x) as f32).hypot(row.abs_diff(y) as f32);
                if distance <= radius {
                    near.pixels_mut()[row * width + col] = true;
                }
            }
        }
    }
    near
}
