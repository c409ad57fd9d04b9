//! Never worse than plain: for every group, the hypothesis that was accepted is compared with the
//! simplest explanation, a diffuse reflectance by least squares with equal weights. Where the
//! re-rendering of the group's pixels is further from the photograph with the accepted one, the plain
//! one is delivered.

use crate::blocks::{Blocks, Grid};
use crate::hypothesis::{self, Hypothesis, Search};
use crate::observation::Reading;
use crate::problem::Options;
use crate::residual::deviation_of_sum;
use crate::sample_budget;
use crate::state::State;
use unrender_render::sampler::mix;
use unrender_render::{Appearance, Settings};
use unrender_scene::{Material, Rgb};

/// Pixels that are rendered again for each group, and paths a pixel in each of two halves. At half
/// of either the comparison is noisier and the accepted hypothesis stays more often.
const PIXELS: usize = 1500;
const SPP: u32 = 16;
/// Plain is better if the squared error is lower by this many standard deviations of the difference.
const BETTER: f64 = 3.0;

/// Replaces hypotheses that explain their group worse than a plain diffuse reflectance; whether there were any.
pub(crate) fn replace_worse(state: &mut State<'_>, options: &Options) -> bool {
    let mut replaced = false;
    for group in state.visible_unknowns() {
        let hypothesis = state.groups[group].hypothesis;
        let may_be_plain = state.problem.groups[group].allows(Hypothesis::Diffuse);
        if hypothesis == Hypothesis::Diffuse || !may_be_plain {
            continue;
        }
        let budget = sample_budget::diffuse(options);
        let evidence = state.gather(options, group, budget);
        if evidence.is_empty() {
            continue;
        }
        // As gathered, all pixels have the same weight.
        let start = &state.materials[group];
        let plain = hypothesis::fit(Hypothesis::Diffuse, &evidence, start, Search::Local);
        let squares = |material: &Material| squares(state, options, group, material);
        let (accepted, simple) = (squares(&state.materials[group]), squares(&plain.material));
        let differences: Vec<f64> = accepted.iter().zip(&simple).map(|(a, b)| a - b).collect();
        if differences.iter().sum::<f64>() > BETTER * deviation_of_sum(&differences) {
            let of_group = &mut state.groups[group];
            of_group.hypothesis = Hypothesis::Diffuse;
            (of_group.residual, of_group.likelihood) =
                (Some(plain.residual), Some(plain.likelihood));
            (of_group.std, of_group.seen_texels) = (None, None);
            of_group.alternatives.clear();
            of_group.add_note(format!(
                "a plain diffuse reflectance is nearer to the photograph than the {hypothesis} one \
                 that was found: taken as diffuse"
            ));
            state.materials[group] = plain.material;
            replaced = true;
        }
    }
    replaced
}

/// The squared residuals of the group's blocks with `material`, the rendering noise taken out.
fn squares(state: &State<'_>, options: &Options, group: usize, material: &Material) -> Vec<f64> {
    let valid = &state.observation.pixels_of_group[group];
    let wanted = options.effort.pixels(PIXELS);
    let grid = Grid::of(&state.observation, group, valid, wanted);
    let pixels = grid.sample(valid, wanted, mix(options.seed ^ 0x91A1));
    let blocks = Blocks::of(&pixels, &grid);
    let mut materials = state.materials.clone();
    materials[group] = material.clone();
    let halves = [0u64, 1].map(|half| {
        let seed = mix(options.seed ^ 0x91A1).wrapping_add(half);
        let max_bounces = options.max_bounces;
        let spp = options.effort.samples(SPP);
        let integrator = unrender_render::Integrator::Path;
        let settings = Settings { first: 0, spp, seed, max_bounces, integrator };
        let appearance = Appearance { materials: &materials, lights: &state.lights };
        state.problem.renderer.rerender(appearance, &pixels, &settings)
    });
    let residual = |i: usize| {
        let photo = state.exposure * state.value(pixels[i] as usize);
        photo - 0.5 * (halves[0][i] + halves[1][i])
    };
    let residuals: Vec<Rgb> = (0..pixels.len()).map(residual).collect();
    let noise = |i: usize| 0.25 * (halves[0][i] - halves[1][i]) * (halves[0][i] - halves[1][i]);
    let noise: Vec<Rgb> = (0..pixels.len()).map(noise).collect();
    let counts = |i: usize| state.observation.reading(pixels[i]) == Reading::Value;
    let (residuals, noise) =
        (blocks.mean_where(&residuals, counts), blocks.mean_where(&noise, counts));
    let square = |k: usize| {
        let size = blocks.sizes[k] as f32;
        let square = residuals[k] * residuals[k] - noise[k] / size;
        f64::from(size * square.element_sum())
    };
    (0..blocks.len()).map(square).collect()
}
