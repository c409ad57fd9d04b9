//! Pass after pass over the photograph: towards the minimum, then until it is known well enough.
//!
//! *Coarse*: some pixels, few paths. A step is taken while one of its numbers is certainly not zero
//! (`SIGNIFICANT`), so that noise never leads away from the ladder's answer. A pass that finds the
//! error worse than before is taken back and its step tried again with damping [Levenberg 1944;
//! Marquardt 1963].
//!
//! *Fine*: all pixels, always the same ones, and what the passes find is averaged, the residuals
//! carried along to where the parameters have moved, `r -> r - J s`. Paths go to the groups whose
//! numbers the renderings' noise leaves least certain. It ends when the last step is smaller than
//! its own standard deviation, and the renderings' noise is below the photograph's or below what
//! anyone would ask for (`precise_enough`), or after so many passes that more would help little.

use super::means::{self, Mean};
use super::normal::Normal;
use super::sample::{self, Cell};
use super::system::System;
use super::unknowns::Unknowns;
use super::{Solution, blocks};
use crate::photometric::PhotometricEstimate;
use crate::problem::Options;
use crate::record::Observer;
use crate::state::State;
use crate::unknown::{Quantity, Unknown};
use nalgebra::{DMatrix, DVector};
use unrender_render::Settings;
use unrender_render::sampler::mix;
use unrender_scene::{Material, Rgb};

/// Pixels of a group at most and paths a pixel, in each of the two renderings, of a coarse pass.
pub(super) const COARSE: (usize, u32) = (8000, 16);
/// The same of a fine pass, to begin with.
const FINE: (usize, u32) = (40_000, 32);
/// Paths a pixel that a group may get in a fine pass.
const FINE_SPP: [f64; 2] = [8.0, 256.0];
/// Coarse and fine passes at most.
const PASSES_MAX: [usize; 2] = [10, 10];
/// A coarse step is taken if one of its numbers is this many standard deviations long.
const SIGNIFICANT: f64 = 3.0;
/// What fine passes found is dropped after a step of so many standard deviations: it was found too
/// far away.
const FAR: f64 = 4.0;
/// The first damping after a step that made things worse, relative to the curvature; then tenfold.
const DAMPING: f64 = 0.1;
/// A pass is worse if its weighted squared error is higher by this many standard deviations of the
/// difference.
const WORSE: f64 = 3.0;
/// The renderings may have this share of a number's variance.
const RENDERING_SHARE: f64 = 0.35;

/// The passes of one refinement.
pub(super) struct Passes<'o> {
    options: &'o Options,
    count: u64,
}

/// Where a step started, to go back if it was wrong.
struct Place {
    materials: Vec<Material>,
    lights: Vec<Rgb>,
    exposure: Rgb,
    photometric: PhotometricEstimate,
    residuals: Vec<[Rgb; 2]>,
    weights: Vec<Rgb>,
    system: System,
}

impl<'o> Passes<'o> {
    pub(super) fn new(options: &'o Options) -> Self {
        Self { options, count: 0 }
    }

    /// Moves the unknowns of `state` to where they explain the photograph best.
    pub(super) fn converge(
        &mut self,
        state: &mut State<'_>,
        observer: &mut dyn Observer,
    ) -> Solution {
        let unknowns = Unknowns::of(state);
        let prior = unknowns.prior_mean(state);
        self.coarse(state, &unknowns, &prior, observer);
        self.fine(state, unknowns, &prior, observer)
    }

    /// The coarse passes alone.
    pub(super) fn approach(&mut self, state: &mut State<'_>, observer: &mut dyn Observer) {
        let unknowns = Unknowns::of(state);
        let prior = unknowns.prior_mean(state);
        self.coarse(state, &unknowns, &prior, observer);
    }

    fn coarse(
        &mut self,
        state: &mut State<'_>,
        unknowns: &Unknowns,
        prior: &DVector<f64>,
        observer: &mut dyn Observer,
    ) {
        let mut last: Option<Place> = None;
        let mut damping = 0.0;
        let effort = self.options.effort;
        let spp = vec![effort.samples(COARSE.1); state.materials.len()];
        // All passes see the same pixels by the same random numbers, so that they can be compared.
        let seed = self.seed();
        for _ in 0..effort.rounds(PASSES_MAX[0]) {
            if observer.is_cancelled() {
                return;
            }
            state.look_at_photograph();
            let cells = sample::all(state, effort.pixels(COARSE.0), seed);
            let means = self.pass(state, unknowns, &cells, (&spp, seed));
            let normal = Normal::of(&means, unknowns, state.materials.len());
            let error = relative_error(&normal, &means);
            let worse = last.as_ref().is_some_and(|last| last.is_better_than(&means));
            let place = match last.take() {
                Some(before) if worse => {
                    damping = f64::max(10.0 * damping, DAMPING);
                    before.restore(state);
                    before
                }
                _ => {
                    damping *= 0.1;
                    let values = unknowns.values(state);
                    let system = System::new(unknowns, &normal, &(prior - &values));
                    let system = system.related(unknowns, &values);
                    Place::of(state, &means, &normal, system)
                }
            };
            let covariance = place.system.covariance();
            let Some(step) = place.system.step(damping, &unknowns.bounds(state)) else { return };
            let significant = |k: usize| step[k].powi(2) > SIGNIFICANT.powi(2) * covariance[(k, k)];
            if !worse && !(0..step.len()).any(significant) {
                return;
            }
            unknowns.apply(state, &step);
            tell(state, observer, unknowns, (&step, error, &means), 0.1);
            last = Some(place);
        }
    }

    fn fine(
        &mut self,
        state: &mut State<'_>,
        unknowns: Unknowns,
        prior: &DVector<f64>,
        observer: &mut dyn Observer,
    ) -> Solution {
        let effort = self.options.effort;
        let mean_spp = effort.samples(FINE.1);
        let passes_max = effort.rounds(PASSES_MAX[1]);
        let mut spp = vec![mean_spp; state.materials.len()];
        let mut average: Vec<Mean> = Vec::new();
        let mut stated = DMatrix::zeros(unknowns.len(), unknowns.len());
        let pixels_seed = self.seed();
        let (mut settled, mut failed) = (false, false);
        for pass in 1..=passes_max {
            if observer.is_cancelled() {
                break;
            }
            state.look_at_photograph();
            let cells = sample::all(state, effort.pixels(FINE.0), pixels_seed);
            let seed = self.seed();
            let found = self.pass(state, &unknowns, &cells, (&spp, seed));
            means::average(&mut average, found);
            let normal = Normal::of(&average, &unknowns, state.materials.len());
            let values = unknowns.values(state);
            let system = System::new(&unknowns, &normal, &(prior - &values));
            let system = system.related(&unknowns, &values);
            let covariance = system.covariance();
            stated = system.stated_covariance();
            let Some(step) = system.step(0.0, &unknowns.bounds(state)) else {
                failed = true;
                break;
            };
            let step = unknowns.apply(state, &step);
            let error = relative_error(&normal, &average);
            let done = 0.1 + 0.9 * pass as f64 / passes_max as f64;
            tell(state, observer, &unknowns, (&step, error, &average), done);
            let longest = (0..step.len())
                .map(|k| step[k].abs() / covariance[(k, k)].sqrt().max(f64::MIN_POSITIVE))
                .fold(0.0, f64::max);
            let rendering = system.rendering_variance();
            settled = longest <= 1.0;
            if settled && is_precise(state, &unknowns, &covariance, &rendering) {
                break;
            }
            if longest > FAR {
                average.clear();
            } else {
                average.iter_mut().for_each(|mean| mean.move_by(&step));
            }
            spp = allocate(state, &unknowns, &rendering, (&cells, mean_spp));
        }
        Solution { unknowns, covariance: stated, settled, failed }
    }

    fn seed(&mut self) -> u64 {
        self.count += 1;
        mix(self.options.seed ^ 0x4EF1_4E00).wrapping_add(self.count << 8)
    }

    fn pass(
        &self,
        state: &State<'_>,
        unknowns: &Unknowns,
        cells: &[Cell],
        (spp, seed): (&[u32], u64),
    ) -> Vec<Mean> {
        let settings = Settings {
            spp: 0,
            seed,
            max_bounces: self.options.max_bounces,
            integrator: unrender_render::Integrator::Path,
        };
        let gather = || means::gather(state, unknowns, cells, spp, &settings);
        state.steps.value("pass", gather)
    }
}

/// The standard deviation below which nobody asks for more.
fn precise_enough(state: &State<'_>, u: &Unknown) -> f64 {
    blocks::of(u.quantity).precise_enough(state, u)
}

/// Whether the renderings' noise matters nowhere.
fn is_precise(
    state: &State<'_>,
    unknowns: &Unknowns,
    covariance: &DMatrix<f64>,
    rendering: &DVector<f64>,
) -> bool {
    unknowns.list.iter().enumerate().all(|(k, u)| {
        rendering[k] <= RENDERING_SHARE * covariance[(k, k)]
            || rendering[k] <= precise_enough(state, u).powi(2)
    })
}

/// The paths a pixel of every group for the next pass: `mean_spp` on average, most for
/// the groups whose worst number has the largest variance from the renderings.
fn allocate(
    state: &State<'_>,
    unknowns: &Unknowns,
    rendering: &DVector<f64>,
    (cells, mean_spp): (&[Cell], u32),
) -> Vec<u32> {
    let groups = state.materials.len();
    let mut need = vec![0.0f64; groups];
    for (k, u) in unknowns.list.iter().enumerate() {
        if !blocks::of(u.quantity).is_nuisance() {
            need[u.of] = need[u.of].max(rendering[k] / precise_enough(state, u).powi(2));
        }
    }
    let mut pixels = vec![0.0f64; groups];
    cells.iter().for_each(|cell| pixels[cell.group] += cell.pixels.len() as f64);
    let paths = f64::from(mean_spp) * pixels.iter().sum::<f64>();
    let wanted: f64 = pixels.iter().zip(&need).map(|(n, need)| n * need).sum();
    let spp = |need: &f64| (paths * need / wanted.max(f64::MIN_POSITIVE)).round();
    need.iter().map(|n| spp(n).clamp(FINE_SPP[0], FINE_SPP[1]) as u32).collect()
}

/// Notes the end of a pass that ended with a step.
fn tell(
    state: &mut State<'_>,
    observer: &mut dyn Observer,
    unknowns: &Unknowns,
    (step, error, means): (&DVector<f64>, f64, &[Mean]),
    done: f64,
) {
    let reflectance = |q: Quantity| matches!(q, Quantity::RhoD | Quantity::RhoS);
    let steps = unknowns.list.iter().zip(step.iter());
    let change = steps.filter(|(u, _)| reflectance(u.quantity)).map(|(_, s)| s.abs());
    let change = change.fold(0.0, f64::max);
    let errors = means::relative_errors(means, state.materials.len());
    observer.iteration(state.end_pass(change, (error.max(0.0).sqrt(), &errors), done));
}

impl Place {
    fn of(state: &State<'_>, means: &[Mean], normal: &Normal, system: System) -> Self {
        Self {
            materials: state.materials.clone(),
            lights: state.lights.clone(),
            exposure: state.exposure,
            photometric: state.photometric.clone(),
            residuals: means.iter().map(|mean| mean.residuals).collect(),
            weights: normal.weights.clone(),
            system,
        }
    }

    /// Whether `means`, of the same cells with the same random numbers, are further from the
    /// photograph: by more than the standard deviation that the difference has under either model,
    /// `2 sqrt(S)` with `S` the squared distance of both.
    fn is_better_than(&self, means: &[Mean]) -> bool {
        let (mut difference, mut separation) = (0.0, 0.0);
        for ((mean, weight), before) in means.iter().zip(&self.weights).zip(&self.residuals) {
            let ([a, b], [c, d]) = (mean.residuals, *before);
            difference += f64::from((*weight * (a * b - c * d)).element_sum());
            separation += f64::from((*weight * (a - c) * (b - d)).element_sum());
        }
        difference > WORSE * 2.0 * separation.max(0.0).sqrt()
    }

    fn restore(&self, state: &mut State<'_>) {
        state.materials.clone_from(&self.materials);
        state.lights.clone_from(&self.lights);
        state.exposure = self.exposure;
        state.photometric.clone_from(&self.photometric);
    }
}

/// The relative squared error.
fn relative_error(normal: &Normal, means: &[Mean]) -> f64 {
    let n = 3.0 * means.iter().map(|m| m.pixels).sum::<f64>().max(1.0);
    normal.errors.iter().sum::<f64>() / n
}
