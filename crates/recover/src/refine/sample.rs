//! The pixels of a refinement pass, and what each of them weighs.
//!
//! A pixel weighs the inverse of the variance of its mean residual: the photograph's noise (shot and
//! quantisation), the rendering's, and what the model cannot explain, the last two measured on the
//! group in the pass before, relative to its local radiance. The weight never looks at the pixel's
//! own rendering, which would favour the renderings that happen to be dark.

use crate::evidence::{Observed, Stage, observe, spread};
use crate::ladder::State;
use crate::problem::Role;
use std::collections::BTreeMap;
use unrender_scene::{Hypothesis, Rgb};

/// Pixels are gathered in blocks of this side, as JPEG has them: what is wrong with a photograph is
/// often wrong with neighbours alike.
const BLOCK: usize = 8;

/// Some pixels of one block.
pub(crate) type Block = Vec<Pixel>;

/// One pixel of the sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel {
    pub(crate) group: usize,
    pub(crate) seen: Observed,
}

/// What is not the photograph's noise in a group's residuals, relative to the local radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GroupNoise {
    /// Variance of one path's rendering.
    pub(crate) path: Rgb,
    /// Variance of what the model does not explain.
    pub(crate) misfit: Rgb,
}

/// Before anything was measured.
const START: GroupNoise = GroupNoise { path: Rgb::splat(0.5), misfit: Rgb::splat(4e-4) };
/// No model of a scene is better than this, relatively.
const MISFIT_MIN: f32 = 1e-6;

impl Default for GroupNoise {
    fn default() -> Self {
        START
    }
}

impl GroupNoise {
    /// The variance of a pixel's mean residual when each of two renderings had `spp` paths.
    pub(crate) fn variance(&self, pixel: &Observed, spp: u32) -> Rgb {
        let relative = self.misfit + self.path / (2 * spp) as f32;
        (pixel.variance + relative * pixel.level * pixel.level).max(Rgb::splat(f32::MIN_POSITIVE))
    }
}

/// At most `per_group` pixels of every group whose residual says something: those that are free or
/// known, not textures (which explain every pixel) and not lights (unless they are unknown).
pub(crate) fn sample(state: &State<'_>, per_group: usize, seed: u64) -> Vec<Block> {
    let says_something = |group: usize| match state.problem.groups[group].role {
        Role::Emitter => state.problem.unknown_lights.contains(&group),
        _ => state.standing[group].hypothesis != Hypothesis::Textured,
    };
    let groups = (0..state.materials.len()).filter(|g| says_something(*g));
    blocks(&state.stage(), groups, per_group, seed)
}

/// At most `per_group` pixels of every known group.
pub(crate) fn sample_known(state: &State<'_>, per_group: usize, seed: u64) -> Vec<Block> {
    let known = |group: &usize| match state.problem.groups[*group].role {
        Role::Emitter => state.problem.unknown_lights.contains(group),
        Role::Known => true,
        Role::Unknown => false,
    };
    let groups = (0..state.materials.len()).filter(known);
    blocks(&state.stage(), groups, per_group, seed)
}

fn blocks(
    stage: &Stage<'_>,
    groups: impl Iterator<Item = usize>,
    per_group: usize,
    seed: u64,
) -> Vec<Block> {
    let width = stage.observation.picture.values.width();
    let mut blocks: BTreeMap<(usize, usize), Block> = BTreeMap::new();
    for group in groups {
        let believed = &stage.observation.pixels_of_group[group];
        let wanted = spread(believed, per_group, seed ^ group as u64);
        for seen in observe(stage.observation, stage.exposure, group, &wanted) {
            let (x, y) = (seen.pixel as usize % width, seen.pixel as usize / width);
            blocks.entry((y / BLOCK, x / BLOCK)).or_default().push(Pixel { group, seen });
        }
    }
    blocks.into_values().collect()
}

/// Sums from which a group's [`GroupNoise`] is measured.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NoiseSums {
    difference: Rgb,
    product: Rgb,
    count: f32,
}

/// A pixel counts at most this many times the variance that is believed: one firefly is not the
/// group's noise.
const OUTLIER: f32 = 30.0;

impl NoiseSums {
    /// Adds a pixel with the residuals `a` and `b` of two renderings of `spp` paths.
    pub(crate) fn add(
        &mut self,
        pixel: &Observed,
        believed: &GroupNoise,
        spp: u32,
        a: Rgb,
        b: Rgb,
    ) {
        let level2 = (pixel.level * pixel.level).max(Rgb::splat(f32::MIN_POSITIVE));
        let most = OUTLIER * (believed.misfit + believed.path / spp as f32)
            + OUTLIER * pixel.variance / level2;
        let half = 0.5 * (a - b) * (a - b) / level2;
        self.difference += half.min(most) * spp as f32;
        self.product += (a * b / level2).clamp(-most, most) - pixel.variance / level2;
        self.count += 1.0;
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.difference += other.difference;
        self.product += other.product;
        self.count += other.count;
    }

    /// The noise, if there were enough pixels to tell.
    pub(crate) fn measured(&self) -> Option<GroupNoise> {
        const ENOUGH: f32 = 30.0;
        let mean = |sum: Rgb| sum / self.count;
        (self.count >= ENOUGH).then(|| GroupNoise {
            path: mean(self.difference).max(Rgb::splat(MISFIT_MIN)),
            misfit: mean(self.product).max(Rgb::splat(MISFIT_MIN)),
        })
    }
}
