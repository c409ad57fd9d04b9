//! Texels from the pixels of a photograph of which the recovery sees only means over squares: the light is interpolated
//! between the squares, since it changes slowly; the detail is the photograph's.

use super::{Lit, TexelSample};
use crate::evidence::Evidence;
use crate::observe::sample::Stage;
use unrender_render::{GeometryBuffers, NOTHING};
use unrender_scene::RgbImage;

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

/// The samples of the texels by the photograph's pixels in the squares of `evidence`, which are of `group` and have the
/// light `light`.
pub(super) fn samples(
    (stage, detail): (&Stage<'_>, &dyn Detail),
    group: usize,
    evidence: &Evidence,
    light: &[Lit],
) -> Vec<TexelSample> {
    let (squares, side, values) = (stage.renderer.geometry(), detail.side(), detail.values());
    let place = super::places(squares, evidence);
    let mut samples = Vec::new();
    for first in (0..squares.height()).step_by(ROWS) {
        let rows = ROWS.min(squares.height() - first);
        let geometry = detail.geometry(first * side, rows * side);
        for (index, here) in geometry.pixels().iter().enumerate() {
            let (x, y) = (index % geometry.width(), first * side + index / geometry.width());
            let square = y / side * squares.width() + x / side;
            let Some(seen) = evidence.sample.pixels.get(place[square] as usize) else { continue };
            if here.object == NOTHING || here.group as usize != group {
                continue;
            }
            let finer = *values.at(x, y) - stage.observation.picture.values.pixels()[square];
            let radiance = seen.radiance + stage.exposure * finer;
            let at = [x, y].map(|pixel| (pixel as f32 + 0.5) / side as f32 - 0.5);
            if let Some(light) = interpolated((squares, &place, light), at, here.object) {
                samples.push(TexelSample::new(here.uv, radiance, &light));
            }
        }
    }
    samples
}

/// The light at a point, in columns and rows between the centres of `squares`, from the squares about it that show
/// `object` and have light; none without any.
fn interpolated(
    (squares, place, light): (&GeometryBuffers, &[u32], &[Lit]),
    [x, y]: [f32; 2],
    object: u32,
) -> Option<Lit> {
    let (mut sum, mut weights) = (Lit::default(), 0.0);
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
            (0..2).for_each(|set| sum.sets[set] += weight * near.sets[set]);
            sum.shine += weight * near.shine;
            weights += weight;
        }
    }
    (weights > 0.0)
        .then(|| Lit { sets: sum.sets.map(|set| set / weights), shine: sum.shine / weights })
}
