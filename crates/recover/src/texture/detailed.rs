//! Texels from the pixels of a photograph of which the recovery sees only means over squares: the light is interpolated
//! between the squares, since it changes slowly; the detail is the photograph's.

use super::Shown;
use super::footprint::Footprint;
use super::lit::{self, Lit};
use super::near::Near;
use crate::observe::sample::Stage;
use unrender_render::{GeometryBuffers, NOTHING};
use unrender_scene::{Rgb, RgbImage};

/// The photograph whose squares of pixels are those of a [`crate::Problem`].
pub trait Detail: Sync {
    /// The pixels on a side of a square, at least one.
    fn side(&self) -> usize;
    /// Its radiance before the exposure is applied. Behind the last whole square of a row there may be more pixels, and
    /// more rows below the last ones.
    fn values(&self) -> RgbImage;
    /// The geometry behind the pixels of `rows` rows, of which `first` is the first, as far as whole squares go.
    fn geometry(&self, first: usize, rows: usize) -> GeometryBuffers;
}

/// Rows of squares whose geometry is held at a time: 70 MB for a photograph of 12 megapixels. Double of it holds twice as
/// much; half of it was not tried.
const ROWS: usize = 64;

/// What the photograph's pixels in the squares of `lit` show, which are of `group`.
pub(super) fn shown((stage, detail): (&Stage<'_>, &dyn Detail), group: usize, lit: &Lit) -> Shown {
    let (squares, side, values) = (stage.renderer.geometry(), detail.side(), detail.values());
    let width = squares.width() * side;
    let mut place = vec![u32::MAX; squares.pixels().len()];
    lit.pixels.iter().enumerate().for_each(|(i, pixel)| place[*pixel as usize] = i as u32);
    let shine = lit::mean(&lit.shine);
    let light: Vec<[Rgb; 3]> =
        (0..shine.len()).map(|i| [lit.base[0][i], lit.base[1][i], shine[i]]).collect();
    let mut pixels = Vec::new();
    let (mut footprints, mut under, mut noise) = (Vec::new(), Vec::new(), Vec::new());
    let mut base = [Vec::new(), Vec::new()];
    for first in (0..squares.height()).step_by(ROWS) {
        let rows = ROWS.min(squares.height() - first);
        let geometry = detail.geometry(first * side, rows * side);
        for (index, here) in geometry.pixels().iter().enumerate() {
            let (x, y) = (index % geometry.width(), first * side + index / geometry.width());
            let square = y / side * squares.width() + x / side;
            let place_of_square = place[square] as usize;
            let Some(seen) = lit.shown.get(place_of_square) else { continue };
            if here.object == NOTHING || here.group as usize != group {
                continue;
            }
            let finer = *values.at(x, y) - stage.observation.picture.values.pixels()[square];
            let at = [x, y].map(|pixel| (pixel as f32 + 0.5) / side as f32 - 0.5);
            if let Some([a, b, shine]) = interpolated((squares, &place, &light), at, here.object) {
                footprints.push(Footprint::of(&geometry, index));
                under.push(*seen + stage.exposure * finer - shine);
                base[0].push(a);
                base[1].push(b);
                noise.push(lit.noise[place_of_square].of_one_in(side * side));
                pixels.push((y * width + x) as u32);
            }
        }
    }
    Shown { footprints, near: Near::of(&pixels, width), under, noise, light: base }
}

/// The light on a base, twice, and on the lobe above it at a point, in columns and rows between the centres of `squares`, from the
/// squares about it that show `object` and have light; none without any.
fn interpolated(
    (squares, place, light): (&GeometryBuffers, &[u32], &[[Rgb; 3]]),
    [x, y]: [f32; 2],
    object: u32,
) -> Option<[Rgb; 3]> {
    let (mut sum, mut weights) = ([Rgb::ZERO; 3], 0.0);
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let share = |at: f32, step: i64| {
            let beyond = at - at.floor();
            if step == 1 { beyond } else { 1.0 - beyond }
        };
        let (column, row) = (x.floor() as i64 + dx, y.floor() as i64 + dy);
        let inside = (0..squares.width() as i64).contains(&column)
            && (0..squares.height() as i64).contains(&row);
        if !inside {
            continue;
        }
        let square = row as usize * squares.width() + column as usize;
        let Some(near) = light.get(place[square] as usize) else { continue };
        if squares.pixels()[square].object == object {
            let weight = share(x, dx) * share(y, dy);
            sum.iter_mut().zip(near).for_each(|(sum, near)| *sum += weight * *near);
            weights += weight;
        }
    }
    (weights > 0.0).then(|| sum.map(|sum| sum / weights))
}
