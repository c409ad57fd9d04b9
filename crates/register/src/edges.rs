//! Where the model says that the photograph has an edge: between neighbouring pixels that show
//! different objects or clearly different normals.

use glam::{Vec2, Vec3};
use unrender_render::{GeometryBuffers, NOTHING, PixelGeometry};
use unrender_scene::Camera;

/// Neighbouring normals further apart than this (cosine) make an edge.
const SAME_NORMAL: f32 = 0.95;
/// The direction of an edge is read from a window that reaches this many pixels of the geometry to
/// each side.
const WINDOW: isize = 5;
/// The model's edges are found in a picture with up to this many times as many rows, so that their
/// places are known to a fraction of a pixel ...
const FINER_MAX: usize = 3;
/// ... but with no more pixels than this.
const PIXELS_MAX: usize = 8_000_000;

/// The rows of the picture in which edges are found, for each row of a photograph of `size`.
pub fn finer((width, height): (usize, usize)) -> usize {
    (PIXELS_MAX / (width * height).max(1)).isqrt().clamp(1, FINER_MAX)
}

/// A point on an edge of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edgel {
    /// Where it is in the picture, pixels from the top left.
    pub at: Vec2,
    /// Unit direction across the edge, in the picture.
    pub across: Vec2,
    /// The point of the nearer surface, world space.
    pub point: Vec3,
    /// The object of that surface.
    pub object: u32,
}

/// Whether two pixels show one object with one smooth normal.
pub fn is_same_surface(a: &PixelGeometry, b: &PixelGeometry) -> bool {
    a.object == b.object && a.normal.dot(b.normal) > SAME_NORMAL
}

/// Whether a pixel and all its neighbours show one object with one smooth normal.
pub fn is_interior(geometry: &GeometryBuffers, index: usize) -> bool {
    let centre = &geometry.pixels()[index];
    geometry.neighbourhood(index).all(|n| is_same_surface(&geometry.pixels()[n], centre))
}

/// The edges of the model as `camera` sees them, one point for every two neighbouring pixels of the
/// `geometry` that an edge divides; it has `finer` times the rows of the photograph, whose pixels are the unit of the
/// places.
pub fn edgels(geometry: &GeometryBuffers, camera: &Camera, finer: usize) -> Vec<Edgel> {
    let (width, height) = (geometry.width(), geometry.height());
    let mut found = Vec::new();
    for y in 0..height {
        for x in 0..width {
            for (to_x, to_y) in [(x + 1, y), (x, y + 1)] {
                if to_x < width && to_y < height {
                    found.extend(edgel(geometry, camera, (x, y), (to_x, to_y)));
                }
            }
        }
    }
    found.iter_mut().for_each(|edgel| edgel.at /= finer as f32);
    found
}

fn edgel(
    geometry: &GeometryBuffers,
    camera: &Camera,
    (x, y): (usize, usize),
    (to_x, to_y): (usize, usize),
) -> Option<Edgel> {
    let (here, there) = (geometry.at(x, y), geometry.at(to_x, to_y));
    if is_same_surface(here, there) || (here.object == NOTHING && there.object == NOTHING) {
        return None;
    }
    let across = direction_across(geometry, (x, y))?;
    // Along the edge, points between pixels side by side and one above the other alternate; one of
    // the two kinds is enough.
    let horizontal = to_x > x;
    if (across.x.abs() > across.y.abs()) != horizontal {
        return None;
    }
    let nearer = if here.depth <= there.depth { here } else { there };
    let at = Vec2::new(0.5 * (x + to_x + 1) as f32, 0.5 * (y + to_y + 1) as f32);
    let towards = camera.direction(at.x, at.y, geometry.width(), geometry.height());
    let point = camera.origin() + towards * nearer.depth;
    Some(Edgel { at, across, point, object: nearer.object })
}

/// The direction in which the surface at a pixel ends: from the middle of the pixels around it that
/// show it to the middle of the others. None where that is no straight edge.
fn direction_across(geometry: &GeometryBuffers, (x, y): (usize, usize)) -> Option<Vec2> {
    let (width, height) = (geometry.width() as isize, geometry.height() as isize);
    let here = geometry.at(x, y);
    let (mut same, mut other) = ((Vec2::ZERO, 0.0), (Vec2::ZERO, 0.0));
    for dy in -WINDOW..=WINDOW {
        for dx in -WINDOW..=WINDOW {
            let (col, row) = (x as isize + dx, y as isize + dy);
            if !(0..width).contains(&col) || !(0..height).contains(&row) {
                return None;
            }
            let belongs = is_same_surface(geometry.at(col as usize, row as usize), here);
            let side = if belongs { &mut same } else { &mut other };
            side.0 += Vec2::new(dx as f32, dy as f32);
            side.1 += 1.0;
        }
    }
    let across = other.0 / f32::max(other.1, 1.0) - same.0 / f32::max(same.1, 1.0);
    // A straight edge through the window separates the two centres by half its side; a corner, a
    // thin bar or a speck by less.
    (across.length() > 0.7 * WINDOW as f32).then(|| across.normalize())
}
