//! The paths of a refinement: traced once, evaluated in every pass (`unrender_render::StoredPaths`).
//!
//! Gauss-Newton needs radiance and derivatives under one appearance after the other, all near the first. On the same
//! paths that takes an eighth of the time of tracing them, and the passes differ only by their materials. Others have
//! reweighted paths for one gradient after the other [Czerninski and Schechner 2023], and have estimated the second
//! derivatives of a rendering [Wang et al. 2025].

use super::means::{self, Mean};
use super::sample::{self, Cell};
use super::unknowns::Unknowns;
use crate::guess::Guess;
use std::cell::OnceCell;
use std::ops::Range;
use std::sync::Arc;
use unrender_render::{Appearance, Parameter, Query, RadianceCache, Settings, Stored};
use unrender_scene::{Material, Rgb};

/// The memory that the paths may take, bytes: 16 paths, twice, of 129 000 pixels. At half of it the first steps see
/// half as many pixels of a large picture; double is more than small machines have beside a scene.
const MEMORY: usize = 1 << 30;
/// What a path takes, bytes: 160 to 260 in seven scenes. At half of it the memory is exceeded, at double half of it
/// is used.
const PATH: usize = 260;
/// Paths carry a lobe whose roughness is between these multiples of the one that they were drawn with; beyond, its
/// weight rests on few paths. Half and double of the range were not tried.
const CARRIED: [f32; 2] = [0.5, 4.0];

/// Paths of some cells.
pub(super) struct KeptPaths<'a> {
    cells: Vec<Cell>,
    samples: Vec<Range<u32>>,
    settings: Settings,
    /// What they are drawn from, and where they end.
    materials: Vec<Material>,
    lights: Vec<Rgb>,
    seen: Option<Arc<RadianceCache>>,
    /// The two renderings of each tile, once one is needed.
    tiles: OnceCell<Vec<[Box<dyn Stored + 'a>; 2]>>,
}

impl<'a> KeptPaths<'a> {
    /// Paths of up to `per_group` pixels of every group of `guess`, `settings.spp` a pixel in each of two
    /// renderings. Where they would take too much memory, of fewer pixels.
    pub(super) fn new(
        guess: &Guess<'a>,
        (per_group, pixels_seed): (usize, u64),
        settings: &Settings,
    ) -> Self {
        let fitting = fitting(guess, per_group, settings.spp);
        let cells = sample::all(guess, fitting, pixels_seed);
        Self {
            samples: vec![settings.samples(); cells.len()],
            cells,
            settings: *settings,
            materials: guess.materials.clone(),
            lights: guess.lights.clone(),
            seen: guess.seen.clone(),
            tiles: OnceCell::new(),
        }
    }

    /// What the cells show under the appearance of `guess`.
    pub(super) fn means(&self, guess: &Guess<'a>, unknowns: &Unknowns) -> Vec<Mean> {
        let tiles = self.tiles.get_or_init(|| self.trace(guess, &unknowns.parameters));
        let seen = self.ends(guess);
        let mut cells = self.cells.clone();
        sample::expose(guess, &mut cells);
        means::of_tiles(guess, unknowns, &cells, &self.samples, |index, _| {
            let (appearance, asked) = (guess.appearance(), &unknowns.parameters);
            let replayed =
                |half: usize| tiles[index][half].replay(appearance, asked, seen.as_ref());
            [replayed(0), replayed(1)]
        })
    }

    /// The photograph's present radiance where the paths end, which is where it was valid when they were traced: a lobe
    /// that has vanished since ends no path.
    fn ends(&self, guess: &Guess<'_>) -> Option<RadianceCache> {
        let (now, traced) = (guess.seen.as_ref()?, self.seen.as_ref()?);
        Some(RadianceCache { radiance: now.radiance.clone(), valid: traced.valid.clone() })
    }

    fn trace(&self, guess: &Guess<'a>, asked: &[Parameter]) -> Vec<[Box<dyn Stored + 'a>; 2]> {
        let drawn = Appearance { materials: &self.materials, lights: &self.lights };
        let renderer = guess.problem.renderer;
        let of_tile = |tile: Range<usize>| {
            let pixels = self.cells[tile].iter().flat_map(|cell| &cell.pixels);
            let pixels: Vec<u32> = pixels.map(|seen| seen.pixel).collect();
            means::halves(&self.settings).map(|settings| {
                renderer.store(&Query {
                    parameters: asked,
                    seen: self.seen.as_deref(),
                    ..Query::new(drawn, &pixels, &settings)
                })
            })
        };
        means::tiles(&self.cells).into_iter().map(of_tile).collect()
    }

    /// Whether the paths carry the lobes of `guess`.
    pub(super) fn carry(&self, guess: &Guess<'_>) -> bool {
        guess.materials.iter().zip(&self.materials).all(|(now, drawn)| is_near(now, drawn))
    }
}

/// Whether paths that were drawn from `drawn` carry the lobe of `now`, if it has one.
fn is_near(now: &Material, drawn: &Material) -> bool {
    let within = |now: f32, drawn: f32| {
        let [least, most] = CARRIED;
        now >= least * drawn && now <= most * drawn
    };
    !now.is_glossy() || within(now.alpha_x, drawn.alpha_x) && within(now.alpha_y, drawn.alpha_y)
}

/// At most `per_group` pixels a group, so few that the paths of all groups fit into [`MEMORY`].
fn fitting(guess: &Guess<'_>, per_group: usize, spp: u32) -> usize {
    let most = MEMORY / (2 * spp.max(1) as usize * PATH);
    let pixels = |per_group: usize| {
        let of_group = |pixels: &Vec<u32>| pixels.len().min(per_group);
        guess.observation.informative_of_group.iter().map(of_group).sum::<usize>()
    };
    let mut fitting = per_group;
    while fitting > 1 && pixels(fitting) > most {
        fitting = fitting * 3 / 4;
    }
    fitting
}
