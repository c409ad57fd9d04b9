//! The paper's method as written (section 4 and its Figure 1): the baseline that ours is measured
//! against.
//!
//! In every iteration the whole scene is rendered again, each group's error is read off the difference,
//! and its reflectance is corrected under its present hypothesis: by the ratio of eqs. 1 to 3 for
//! diffuse surfaces and mirrors, by the 2x2 system, by downhill simplex over re-renderings, or by
//! the radiosity texture. A group whose rung has had its iterations and still shows an error above its
//! threshold goes one rung up.
//!
//! One thing is not as written: the ratio is damped (`RELAXATION`), since without it the diffuse
//! iterations do not settle. Where the paper is silent: the difference is measured as the product of two renderings'
//! residuals, for else our noise would count as error and every search would shun shine; the simplex runs channel by channel on a
//! sample of the group's pixels, and the roughness is the mean over the channels.
//!
//! The direction of an anisotropic surface is read off the photograph first ([`brushed`]).

pub mod brushed;

use crate::blocks::spread;
use crate::evidence::{Evidence, SampleBudget, observe};
use crate::fit::simplex;
use crate::hypothesis::{self, Hypothesis, textured};
use crate::problem::{Options, RecoverError};
use crate::record::{CandidateRecord, Observer, Termination};
use crate::residual::{ResidualStats, residual_stats};
use crate::sample_budget;
use crate::state::{State, distance};
use serde::{Deserialize, Serialize};
use unrender_render::{Appearance, ProbeSettings, Settings};
use unrender_scene::{Material, Rgb};

/// Iterations on a rung that is corrected by ratios: at least these (the paper finds four sufficient) ...
const RATIO_ITERATIONS: usize = 4;
/// ... and at most these, while the reflectances still move.
const RATIO_ITERATIONS_MAX: usize = 12;
/// The ratio's exponent. With one, as eq. 3 has it, all groups overshoot together on Figure 8 and
/// swing between two states for ever (change 0.257 in every iteration from the third to the twelfth).
const RELAXATION: f32 = 0.5;
/// Ratios have come to rest when no reflectance of the group moves by more than this.
const AT_REST: f64 = 0.02;
/// Only groups with at least this share of the worst error climb: the others may be in error
/// because of the light that the worst one sends them.
const WORST: f64 = 0.75;
/// Pixels of a group that an iteration looks at, and that a simplex step renders again.
const ITERATION_PIXELS: usize = 4000;
const SIMPLEX_PIXELS: usize = 600;
/// Paths a pixel of both.
const SPP: u32 = 16;
/// The method ends when no reflectance moves by more than this.
const SETTLED: f64 = 0.02;
const SIMPLEX_TURNS: u64 = 80;

/// Climbs one rung at a time.
pub(crate) fn run(
    state: &mut State<'_>,
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Termination, RecoverError> {
    let mut rungs = vec![Rung::default(); state.materials.len()];
    for iteration in 1..=options.max_iterations {
        state.update_exposure(options)?;
        let climber = PaperIteration { options, iteration };
        let views = state.step("paper's iteration", |state| climber.look(state));
        let all_at_rest = views.iter().all(|view| {
            rungs[view.group].has_had_its_iterations(state.groups[view.group].hypothesis)
        });
        // While reflectances still move anywhere, errors say little.
        let leaving = if all_at_rest { climber.leaving(state, &views) } else { Vec::new() };
        let mut next = state.materials.clone();
        for view in &views {
            let group = view.group;
            let leaves = leaving.contains(&group);
            next[group] = climber.correct(state, view, leaves, &mut rungs[group]);
            rungs[group].change = distance(&state.materials[group], &next[group]);
        }
        state.materials = next;
        if !leaving.is_empty() {
            // A group on a new rung changes the light of all: their ratios get their iterations again.
            rungs.iter_mut().for_each(|rung| rung.iterations = 0);
        }
        let change = rungs.iter().map(|r| r.change).fold(0.0, f64::max);
        let done = iteration as f64 / (iteration as f64 + 8.0);
        let open: Vec<usize> = climber.in_error(state, &views);
        observer.iteration(state.end_iteration(change, &open, done));
        if observer.is_cancelled() {
            return Ok(Termination::Interrupted);
        }
        if leaving.is_empty() && all_at_rest && change < SETTLED {
            return Ok(Termination::Settled);
        }
    }
    Ok(Termination::IterationLimit)
}

/// How long a group has stood on its rung, and how far its last iteration moved it.
#[derive(Clone, Copy, Default)]
struct Rung {
    iterations: usize,
    change: f64,
}

impl Rung {
    /// Whether the rung has had its iterations under `hypothesis`.
    fn has_had_its_iterations(self, hypothesis: Hypothesis) -> bool {
        match hypothesis {
            Hypothesis::Diffuse | Hypothesis::PartialMirror => {
                self.iterations >= RATIO_ITERATIONS_MAX
                    || (self.iterations >= RATIO_ITERATIONS && self.change < AT_REST)
            }
            _ => self.iterations >= 1,
        }
    }
}

/// A group's pixels in the present re-rendering.
#[derive(Serialize, Deserialize)]
struct Rerendered {
    group: usize,
    pixels: Vec<u32>,
    rerendered: Vec<Rgb>,
    error: ResidualStats,
}

struct PaperIteration<'o> {
    options: &'o Options,
    iteration: usize,
}

impl PaperIteration<'_> {
    /// Renders all groups again and measures their errors.
    fn look(&self, state: &mut State<'_>) -> Vec<Rerendered> {
        let mut views = Vec::new();
        for group in state.visible_unknowns() {
            let valid = &state.observation.pixels_of_group[group];
            let whole = state.groups[group].hypothesis == Hypothesis::Textured;
            let count = if whole { usize::MAX } else { ITERATION_PIXELS };
            let pixels = spread(valid, count, self.options.seed);
            let halves = [0u64, 1].map(|half| {
                let seed = self.options.seed.wrapping_mul(2).wrapping_add(half);
                self.rerender(state, &state.materials, &pixels, seed)
            });
            let observed = observe(&state.observation, state.exposure, group, &pixels);
            let error = residual_stats(&observed, &halves);
            state.groups[group].residual = Some(error);
            let rerendered =
                halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (*a + *b)).collect();
            views.push(Rerendered { group, pixels, rerendered, error });
        }
        views
    }

    /// The groups that leave their rungs: those in error above its threshold, and among the worst.
    fn leaving(&self, state: &State<'_>, views: &[Rerendered]) -> Vec<usize> {
        let hypothesis = |v: &Rerendered| state.groups[v.group].hypothesis;
        let in_error = |v: &&Rerendered| {
            hypothesis(v) != Hypothesis::Textured
                && v.error.total() > self.options.thresholds.paper[hypothesis(v) as usize]
        };
        let worst = views.iter().filter(in_error).map(|v| v.error.total()).fold(0.0, f64::max);
        let among_worst = |v: &&Rerendered| v.error.total() >= WORST * worst;
        views.iter().filter(in_error).filter(among_worst).map(|v| v.group).collect()
    }

    /// The groups in error above the threshold of their rungs.
    fn in_error(&self, state: &State<'_>, views: &[Rerendered]) -> Vec<usize> {
        let hypothesis = |v: &Rerendered| state.groups[v.group].hypothesis;
        let in_error = |v: &&Rerendered| {
            hypothesis(v) != Hypothesis::Textured
                && v.error.total() > self.options.thresholds.paper[hypothesis(v) as usize]
        };
        views.iter().filter(in_error).map(|v| v.group).collect()
    }

    /// Corrects a group under its hypothesis, or under the next one if it `leaves` its rung.
    fn correct(
        &self,
        state: &mut State<'_>,
        seen: &Rerendered,
        leaves: bool,
        rung: &mut Rung,
    ) -> Material {
        let Rerendered { group, pixels, rerendered, error } = seen;
        let hypothesis = state.groups[*group].hypothesis;
        if leaves || (rung.iterations == 1 && state.groups[*group].is_new_to(hypothesis)) {
            let material = state.materials[*group].clone();
            let candidate = CandidateRecord {
                iteration: self.iteration,
                hypothesis,
                material,
                residual: *error,
                model_error: error.relative(),
                criterion: 0.0,
                accepted: !leaves,
            };
            state.groups[*group].selection_log.push(candidate);
        }
        let next = if leaves { next_rung(hypothesis) } else { hypothesis };
        let parameters = || self.parameters(state, *group, next, pixels, rerendered);
        let material = state.steps.value("paper's parameters", parameters);
        // A group without texture coordinates stays where it is.
        rung.iterations = if leaves && material.is_some() { 0 } else { rung.iterations + 1 };
        state.groups[*group].hypothesis = if material.is_some() { next } else { hypothesis };
        let material = material.unwrap_or_else(|| state.materials[*group].clone());
        state.problem.groups[*group].expected.bounds.nearest(&material)
    }

    fn rerender(&self, s: &State<'_>, materials: &[Material], px: &[u32], seed: u64) -> Vec<Rgb> {
        let settings = Settings {
            first: 0,
            together: crate::sample_budget::TOGETHER,
            spp: SPP,
            seed,
            max_bounces: self.options.max_bounces,
            integrator: unrender_render::Integrator::Path,
        };
        let appearance = Appearance { materials, lights: &s.lights };
        s.problem.renderer.rerender(appearance, px, &settings)
    }

    /// The group's parameters on `rung`, from the picture `rerendered` of its `pixels`.
    fn parameters(
        &self,
        state: &State<'_>,
        group: usize,
        rung: Hypothesis,
        pixels: &[u32],
        rerendered: &Vec<Rgb>,
    ) -> Option<Material> {
        let now = &state.materials[group];
        let stays = rung == state.groups[group].hypothesis;
        let ratio = || self.ratio(state, pixels, rerendered).powf(RELAXATION);
        Some(match rung {
            Hypothesis::Diffuse => {
                Material::diffuse((now.rho_d * ratio()).clamp(Rgb::ZERO, Rgb::ONE))
            }
            Hypothesis::Mirror => Material::mirror(Rgb::ONE),
            Hypothesis::PartialMirror if stays => {
                Material::mirror((now.rho_s * ratio()).clamp(Rgb::ZERO, Rgb::ONE))
            }
            Hypothesis::PartialMirror => Material::mirror(ratio().clamp(Rgb::ZERO, Rgb::ONE)),
            // Found once: searching again in every iteration only walks with the noise of the search.
            Hypothesis::Isotropic | Hypothesis::Anisotropic if stays => now.clone(),
            Hypothesis::Isotropic => self.simplex(state, group, now, false),
            Hypothesis::Anisotropic => {
                let geometry = state.problem.renderer.geometry();
                let evidence = self.gather(state, group);
                let theta_rad = brushed::direction(&evidence, geometry).unwrap_or(0.0);
                self.simplex(state, group, &Material { theta_rad, ..now.clone() }, true)
            }
            Hypothesis::Textured => {
                let before = if stays { now.texture.as_deref() } else { None };
                let ones = vec![Rgb::ONE; pixels.len()];
                let shown = if stays { rerendered } else { &ones };
                let found = textured::rebalance(&state.stage(), before, pixels, shown)?;
                let rho_d = textured::mean(&found);
                Material { texture: Some(found.texture), ..Material::diffuse(rho_d) }
            }
            _ => hypothesis::fit(rung, &self.gather(state, group), now, SEARCH).material,
        })
    }

    /// Eqs. 1 to 3: the mean over the group's objects of mean photograph over mean re-rendering,
    /// weighted by pixels; objects far from the median do not count.
    fn ratio(&self, state: &State<'_>, pixels: &[u32], rerendered: &[Rgb]) -> Rgb {
        let stage = state.stage();
        let geometry = stage.renderer.geometry();
        let mut objects: std::collections::BTreeMap<u32, (Rgb, Rgb, f32)> = Default::default();
        for (&pixel, &radiance) in pixels.iter().zip(rerendered) {
            let entry = objects.entry(geometry.pixels()[pixel as usize].object).or_default();
            entry.0 += stage.exposure * stage.observation.picture.values.pixels()[pixel as usize];
            entry.1 += radiance;
            entry.2 += 1.0;
        }
        Rgb::from_array(std::array::from_fn(|c| {
            let ratios: Vec<(f32, f32)> = objects
                .values()
                .filter(|(_, synthetic, _)| synthetic[c] > 0.0)
                .map(|(photo, synthetic, pixels)| (photo[c] / synthetic[c], *pixels))
                .collect();
            mean_near_median(ratios, self.options.thresholds.dispersion as f32)
        }))
    }

    fn gather(&self, state: &State<'_>, group: usize) -> Evidence {
        let probe = ProbeSettings {
            cosine: SPP,
            mirror: true,
            seed: self.options.seed,
            max_bounces: self.options.max_bounces,
            ..ProbeSettings::default()
        };
        let pixels = &state.observation.pixels_of_group[group];
        let allowance = sample_budget::allowance(sample_budget::Level::Refined, self.options);
        let budget =
            SampleBudget { pixels: ITERATION_PIXELS, pixels_seed: probe.seed, allowance, probe };
        Evidence::gather(&state.stage(), state.appearance(), group, pixels, &budget)
    }

    /// Sections 4.2.4 and 4.2.5: downhill simplex over `rho_d`, `rho_s` and the roughness, every
    /// step a re-rendering of the group; the case `rho_s = 1` apart from the others.
    fn simplex(
        &self,
        state: &State<'_>,
        group: usize,
        start: &Material,
        brushed: bool,
    ) -> Material {
        let valid = &state.observation.pixels_of_group[group];
        let pixels = spread(valid, SIMPLEX_PIXELS, self.options.seed);
        let observed = observe(&state.observation, state.exposure, group, &pixels);
        let mut materials = state.materials.clone();
        let mut sums = (Rgb::ZERO, Rgb::ZERO, [0.0f32; 2]);
        let alphas = if start.is_glossy() { [start.alpha_x, start.alpha_y] } else { [0.1; 2] };
        for c in 0..3 {
            let mut error = |p: &[f64; 4]| {
                materials[group] = grey(p, start.theta_rad);
                let [a, b] = [0u64, 1].map(|half| {
                    let seed = self.options.seed.wrapping_mul(2).wrapping_add(half);
                    self.rerender(state, &materials, &pixels, seed)
                });
                let product = |i: usize| {
                    let photo = observed[i].radiance[c];
                    f64::from((photo - a[i][c]) * (photo - b[i][c]))
                };
                (0..pixels.len()).map(product).sum::<f64>()
            };
            let first = [start.rho_d[c], start.rho_s[c], alphas[0], alphas[1]].map(f64::from);
            let best = search(&mut error, first, brushed);
            sums.0[c] = best[0] as f32;
            sums.1[c] = best[1] as f32;
            sums.2[0] += best[2] as f32 / 3.0;
            sums.2[1] += best[3] as f32 / 3.0;
        }
        let (rho_d, rho_s, [alpha_x, alpha_y]) = sums;
        Material { rho_s, alpha_x, alpha_y, theta_rad: start.theta_rad, ..Material::diffuse(rho_d) }
    }
}

/// The diffuse-specular rung has nothing to search for.
const SEARCH: crate::hypothesis::Search = crate::hypothesis::Search::Local;

fn next_rung(hypothesis: Hypothesis) -> Hypothesis {
    let up = hypothesis::UNIFORM.iter().position(|h| *h == hypothesis).map(|i| i + 1);
    up.and_then(|i| hypothesis::UNIFORM.get(i).copied()).unwrap_or(Hypothesis::Textured)
}

/// A material with the same reflectances `[rho_d, rho_s, alpha_x, alpha_y]` in all channels: light
/// of one channel never reaches another.
fn grey(p: &[f64; 4], theta_rad: f32) -> Material {
    let [rho_d, rho_s, alpha_x, alpha_y] = p.map(|v| v as f32);
    Material {
        rho_s: Rgb::splat(rho_s.clamp(0.0, 1.0)),
        alpha_x: alpha_x.clamp(0.005, 1.0),
        alpha_y: alpha_y.clamp(0.005, 1.0),
        theta_rad,
        ..Material::diffuse(Rgb::splat(rho_d.clamp(0.0, 1.0)))
    }
}

/// The better of the simplex with `rho_s` free and with `rho_s = 1`; with one roughness, or two.
fn search(error: &mut dyn FnMut(&[f64; 4]) -> f64, first: [f64; 4], brushed: bool) -> [f64; 4] {
    let error = std::cell::RefCell::new(error);
    let full = |rho_d: f64, rho_s: f64, alphas: &[f64]| {
        let last = alphas[alphas.len() - 1].exp();
        [rho_d.clamp(0.0, 1.0), rho_s.clamp(0.0, 1.0), alphas[0].exp(), last]
    };
    let logs: Vec<f64> =
        if brushed { vec![first[2].ln(), first[3].ln() + 0.2] } else { vec![first[2].ln()] };
    let mut steps = vec![0.2, 0.2];
    steps.extend(logs.iter().map(|_| 0.4));
    let start: Vec<f64> = [first[0], first[1]].into_iter().chain(logs.clone()).collect();
    let free = |p: &[f64]| full(p[0], p[1], &p[2..]);
    let fixed = |p: &[f64]| full(p[0], 1.0, &p[1..]);
    let cost_free = |p: &[f64]| (error.borrow_mut())(&free(p));
    let (p_free, e_free) = simplex::minimise(cost_free, &start, &steps, 1e-12, SIMPLEX_TURNS);
    let cost_fixed = |p: &[f64]| (error.borrow_mut())(&fixed(p));
    let start: Vec<f64> = std::iter::once(0.0).chain(logs).collect();
    let (p_fixed, e_fixed) =
        simplex::minimise(cost_fixed, &start, &steps[1..], 1e-12, SIMPLEX_TURNS);
    if e_fixed < e_free { fixed(&p_fixed) } else { free(&p_free) }
}

/// Eq. 3 for one channel: `sum f m eps / sum f m`, with f = 0 for ratios further than
/// `dispersion` from the median, relatively.
fn mean_near_median(mut ratios: Vec<(f32, f32)>, dispersion: f32) -> f32 {
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(median) = ratios.get(ratios.len() / 2).map(|r| r.0) else { return 1.0 };
    let near = ratios.iter().filter(|r| (r.0 - median).abs() <= dispersion * median);
    let (sum, count) = near.fold((0.0, 0.0), |(s, n), (ratio, m)| (s + ratio * m, n + m));
    if count > 0.0 { sum / count } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_far_from_their_group_do_not_count() {
        let ratios = vec![(1.0, 100.0), (1.2, 100.0), (9.0, 5.0)];
        assert!((mean_near_median(ratios, 0.5) - 1.1).abs() < 1e-6);
        assert_eq!(mean_near_median(Vec::new(), 0.5), 1.0);
    }

    #[test]
    fn the_rungs_follow_each_other_up_to_the_texture() {
        let mut rung = Hypothesis::Diffuse;
        for next in [1, 2, 3, 4, 5].map(|i| hypothesis::UNIFORM[i]) {
            rung = next_rung(rung);
            assert_eq!(rung, next);
        }
        assert_eq!(next_rung(rung), Hypothesis::Textured);
    }
}
