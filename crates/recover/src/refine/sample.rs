//! The pixels of a refinement pass, in blocks.

use crate::guess::Guess;
use crate::observe::blocks::{Grid, Place};
use crate::observe::observation::Reading;
use crate::observe::sample::{Observed, Stage};
use crate::problem::Role;
use glam::Vec3;
use std::collections::BTreeMap;

/// The side of a block in pixels, that of JPEG: errors of a photograph are often alike in
/// neighbouring pixels.
const SIDE_MAX: usize = 8;
/// A picture has at least this many blocks, or their spread would not give the noise of tens of
/// numbers: in small pictures blocks are smaller.
const BLOCKS_MIN: usize = 250;

/// The pixels of one group in one block.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    pub(crate) group: usize,
    /// Its place among the group's blocks.
    pub(crate) place: Place,
    /// The mean of the points of the surface that its pixels show, metres in world space, as far as they are known.
    pub(crate) point: Option<Vec3>,
    /// Whether its pixels are clipped, and their values lower bounds.
    pub(crate) bound: bool,
    pub(crate) pixels: Vec<Observed>,
}

/// At most `per_group` pixels of every group whose residual says something: those that are free or
/// known, not lights (unless they are unknown).
pub(crate) fn all(guess: &Guess<'_>, per_group: usize, seed: u64) -> Vec<Cell> {
    let says_something = |group: &usize| match guess.problem.groups[*group].role {
        Role::Emitter => guess.problem.unknown_lights.contains(group),
        _ => true,
    };
    let groups = (0..guess.materials.len()).filter(says_something);
    cells(&guess.stage(), groups, per_group, seed)
}

/// Takes the radiances of `cells`, and their noise, by the exposure and the camera's numbers as they stand in
/// `guess`.
pub(super) fn expose(guess: &Guess<'_>, cells: &mut [Cell]) {
    for cell in cells {
        for seen in &mut cell.pixels {
            seen.radiance = guess.exposure * guess.value(seen.pixel as usize);
            seen.noise = guess.observation.noise(cell.group, seen.pixel, guess.exposure);
        }
    }
}

/// At most `per_group` pixels of every group that is known, and of every unknown light.
pub(crate) fn known(guess: &Guess<'_>, per_group: usize, seed: u64) -> Vec<Cell> {
    let known = |group: &usize| match guess.problem.groups[*group].role {
        Role::Emitter => guess.problem.unknown_lights.contains(group),
        Role::Known => true,
        Role::Unknown => false,
    };
    let groups = (0..guess.materials.len()).filter(known);
    cells(&guess.stage(), groups, per_group, seed)
}

/// The cells of `groups`, group by group.
fn cells(
    stage: &Stage<'_>,
    groups: impl Iterator<Item = usize>,
    per_group: usize,
    seed: u64,
) -> Vec<Cell> {
    let (width, height) =
        (stage.observation.picture.values.width(), stage.observation.picture.values.height());
    let side = ((width * height / BLOCKS_MIN).isqrt()).clamp(1, SIDE_MAX);
    let mut cells: BTreeMap<(usize, Place, bool), Vec<Observed>> = BTreeMap::new();
    for group in groups {
        let valid = &stage.observation.informative_of_group[group];
        let grid = Grid::even(&stage.observation.sheet, side).dividing_uneven(
            stage.observation,
            group,
            valid,
        );
        let count = stage.observation.sheet.of_all(per_group);
        let wanted = grid.sample(valid, count, seed ^ group as u64);
        for seen in stage.observe(group, &wanted) {
            let bound = seen.reading == Reading::AtLeast;
            cells.entry((group, grid.place(seen.pixel), bound)).or_default().push(seen);
        }
    }
    let cell = |((group, place, bound), pixels): ((usize, Place, bool), Vec<Observed>)| {
        let points = pixels.iter().filter_map(|seen| stage.renderer.point(seen.pixel));
        let (sum, count) = points.fold((Vec3::ZERO, 0.0), |(sum, n), point| (sum + point, n + 1.0));
        let point = (count > 0.0).then(|| sum / count);
        Cell { group, place, point, bound, pixels }
    };
    cells.into_iter().map(cell).collect()
}
