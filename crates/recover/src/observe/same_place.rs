//! Which blocks of several photographs show the same place of a surface.
//!
//! A model error at a place (a stain, a bump, wrong light) may be in every photograph that shows it. Such residuals are
//! then no more independent than those of neighbours; their correlation is measured ([`crate::compare`]).

use crate::observe::blocks::{Blocks, Place, neighbours};
use glam::{IVec3, Vec3};
use std::collections::{BTreeMap, HashMap};
use unrender_render::Renderer;

/// Where a block lies, and what it shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) place: Place,
    /// The mean of the points of the surface, metres in world space, as far as they are known.
    pub(crate) point: Option<Vec3>,
}

/// The `blocks` of `pixels`, with the pairs of them that show the same place as `renderer` sees it.
pub(crate) fn paired(blocks: Blocks, renderer: &dyn Renderer, pixels: &[u32]) -> Blocks {
    if !are_several(&blocks.places) {
        return blocks;
    }
    let mut sums = vec![(Vec3::ZERO, 0.0f32); blocks.len()];
    for (pixel, block) in pixels.iter().zip(&blocks.of_pixel) {
        let Some(point) = renderer.point(*pixel) else { continue };
        let (sum, count) = &mut sums[*block as usize];
        (*sum, *count) = (*sum + point, *count + 1.0);
    }
    let seen = |(place, (sum, count)): (&Place, (Vec3, f32))| Seen {
        place: *place,
        point: (count > 0.0).then(|| sum / count),
    };
    let seen: Vec<Seen> = blocks.places.iter().zip(sums).map(seen).collect();
    Blocks { same: pairs(&seen), ..blocks }
}

/// Whether they are of more than one photograph.
fn are_several(places: &[Place]) -> bool {
    places.iter().any(|place| place.photograph != places[0].photograph)
}

/// All pairs of blocks of different photographs, by their indices, that show the same place. Each block is paired with
/// the nearest one of every other photograph, if that is no further than its own neighbours.
pub(crate) fn pairs(seen: &[Seen]) -> Vec<(usize, usize)> {
    let places: Vec<Place> = seen.iter().map(|seen| seen.place).collect();
    if !are_several(&places) {
        return Vec::new();
    }
    let mut reach = vec![f32::INFINITY; seen.len()];
    for (i, j) in neighbours(&places) {
        let (Some(a), Some(b)) = (seen[i].point, seen[j].point) else { continue };
        let apart = a.distance(b);
        (reach[i], reach[j]) = (reach[i].min(apart), reach[j].min(apart));
    }
    let cells = Cells::of(seen, &reach);
    let mut pairs = Vec::new();
    for (i, of) in seen.iter().enumerate().filter(|(i, _)| reach[*i].is_finite()) {
        let Some(point) = of.point else { continue };
        let mut nearest: BTreeMap<usize, (f32, usize)> = BTreeMap::new();
        for j in cells.near(point, reach[i]) {
            let (own, place, other) = (places[i], places[j], seen[j].point);
            let apart = other.map_or(f32::INFINITY, |other| point.distance(other));
            if place.photograph > own.photograph && place.fine == own.fine && apart <= reach[i] {
                let best = nearest.entry(place.photograph).or_insert((f32::INFINITY, j));
                *best = if apart < best.0 { (apart, j) } else { *best };
            }
        }
        pairs.extend(nearest.into_values().map(|(_, j)| (i, j)));
    }
    pairs
}

/// Blocks sorted into cubes of space, so that few are tried near a point.
struct Cells {
    side: f32,
    blocks: HashMap<IVec3, Vec<usize>>,
}

/// Nothing further away than so many sides of a cube is looked at. Blocks beside an edge, whose only neighbours are far away, reach
/// further than others; with double of it very many cubes are searched for them.
const CUBES: f32 = 3.0;

impl Cells {
    /// Those of `seen`, with sides as long as the median reach.
    fn of(seen: &[Seen], reach: &[f32]) -> Self {
        let mut finite: Vec<f32> =
            reach.iter().copied().filter(|reach| reach.is_finite()).collect();
        finite.sort_by(f32::total_cmp);
        let side = finite.get(finite.len() / 2).copied().unwrap_or(1.0).max(f32::MIN_POSITIVE);
        let mut cells = Self { side, blocks: HashMap::new() };
        for (i, point) in seen.iter().enumerate().filter_map(|(i, seen)| Some((i, seen.point?))) {
            cells.blocks.entry(cells.at(point)).or_default().push(i);
        }
        cells
    }

    fn at(&self, point: Vec3) -> IVec3 {
        (point / self.side).floor().as_ivec3()
    }

    /// Those within `reach` of `point`, and some more.
    fn near(&self, point: Vec3, reach: f32) -> impl Iterator<Item = usize> {
        let reach = Vec3::splat(reach.min(CUBES * self.side));
        let (low, high) = (self.at(point - reach), self.at(point + reach));
        let along = move |axis: usize| low[axis]..=high[axis];
        let cubes = along(0).flat_map(move |x| {
            along(1).flat_map(move |y| along(2).map(move |z| IVec3::new(x, y, z)))
        });
        cubes.filter_map(|cube| self.blocks.get(&cube)).flatten().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The blocks of a wall of 10 x 10 in `photograph`, which is seen moved by `offset` metres; blocks are a metre.
    fn wall(photograph: usize, offset: f32) -> Vec<Seen> {
        let at = |k: usize| {
            let (column, row) = (k % 10, k / 10);
            let point = Vec3::new(column as f32 + offset, row as f32, 0.0);
            Seen { place: Place { photograph, fine: false, column, row }, point: Some(point) }
        };
        (0..100).map(at).collect()
    }

    #[test]
    fn blocks_of_the_same_place_are_pairs() {
        let both = [wall(0, 0.0), wall(1, 0.0)].concat();
        let expected: Vec<(usize, usize)> = (0..100).map(|k| (k, 100 + k)).collect();
        let mut found = pairs(&both);
        found.sort_unstable();
        assert_eq!(found, expected);
    }

    #[test]
    fn what_only_one_photograph_shows_has_no_pair() {
        // The second photograph shows two columns that the first lacks, and lacks two.
        let both = [wall(0, 0.0), wall(1, 2.3)].concat();
        let found = pairs(&both);
        assert_eq!(found.len(), 80);
        assert!(found.iter().all(|(i, j)| i % 10 == (j - 100) % 10 + 2), "{found:?}");
        assert!(pairs(&wall(0, 0.0)).is_empty());
    }
}
