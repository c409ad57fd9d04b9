//! Every parameter of every group at once, against the whole photograph, with how well it is known.
//!
//! The ladder has chosen the hypotheses and stands near their best parameters. What is left is a
//! least-squares problem of tens of unknowns, for which Gauss-Newton needs a handful of passes:
//! each renders the radiance and its derivatives twice ([`normal`]), solves
//! `(H + P + damping) s = g + P (p_0 - p)` within the bounds ([`crate::fit::quadratic`]), and moves
//! by `s`. `P` is the inverse of the variances that are believed beforehand, so wide that it only
//! matters where the photograph is silent. A pass that made the error worse is taken back, and the
//! damping raised [Levenberg 1944, Marquardt 1963].
//!
//! The covariance of the result is `(H + P)^-1 (G + P) (H + P)^-1` with `G` the covariance of the
//! gradient as the blocks of the picture show it [Huber 1967, White 1982]: it holds the noise of
//! the photograph, of our renderings, and what the model does not explain, without being told how
//! large they are.
//!
//! It ends when no step is larger than its own standard deviation. Then [`verdict`] says what the
//! photograph could not tell; where that makes a hypothesis simpler, the rest is refined again.

mod means;
mod normal;
mod sample;
mod unknowns;
mod verdict;

use crate::error::deviation_of_sum;
use crate::fit::quadratic;
use crate::ladder::State;
use crate::problem::Options;
use crate::record::{Observer, Termination};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use normal::Normal;
use unknowns::{Quantity, Unknowns, prior_deviation};
use unrender_render::Settings;
use unrender_render::sampler::mix;
use unrender_scene::{Material, Rgb};

/// Pixels of a group at most, from pass to pass.
const PIXELS: [usize; 4] = [2000, 6000, 20_000, 40_000];
/// Paths a pixel in each of the two renderings.
const SPP: [u32; 4] = [8, 16, 24, 32];
/// Passes at most over one set of hypotheses.
const PASSES_MAX: usize = 12;
/// How often hypotheses may be made simpler.
const ROUNDS_MAX: usize = 3;
/// The first damping after a step that made things worse, relative to the curvature; then tenfold.
const DAMPING: f64 = 0.1;
/// A pass is worse if its error is higher by this many standard deviations of the difference.
const WORSE: f64 = 3.0;

/// Where the joint refinement stands.
struct Solution {
    unknowns: Unknowns,
    covariance: DMatrix<f64>,
    settled: bool,
}

/// Refines all unknowns of `state` together and says how well they are known.
pub(crate) fn refine(
    state: &mut State<'_>,
    options: &Options,
    observer: &mut dyn Observer,
) -> Termination {
    let mut refiner = Refiner { options, level: 0, passes: 0 };
    for round in 1.. {
        let solution = refiner.converge(state, observer);
        if round < ROUNDS_MAX && verdict::simplify(state, &solution) {
            continue;
        }
        verdict::record(state, &solution);
        if !solution.settled {
            return Termination::RefinementLimit;
        }
        break;
    }
    Termination::Refined
}

/// One Gauss-Newton step for the lights and the exposure alone, from the pixels of the groups that
/// are known: it brings them near enough for the ladder to begin.
pub(crate) fn adjust_nuisances(state: &mut State<'_>, options: &Options) {
    let unknowns = Unknowns::nuisances(state);
    let cells = sample::known(state, PIXELS[0], options.seed);
    if unknowns.len() == 0 || cells.is_empty() {
        return;
    }
    let seed = mix(options.seed ^ 0x11687);
    let settings = Settings { spp: SPP[0], seed, max_bounces: options.max_bounces };
    let means = means::gather(state, &unknowns, &cells, &settings);
    let normal = Normal::of(&means, unknowns.len(), state.materials.len());
    let values = unknowns.values(state);
    let system = System::new(&unknowns, &normal, &(&values - &values));
    if let Some(step) = system.step(0.0, &unknowns.bounds(state)) {
        unknowns.apply(state, &step);
    }
}

struct Refiner<'o> {
    options: &'o Options,
    level: usize,
    passes: u64,
}

/// What a step changes, to be taken back if it was wrong.
struct Place {
    materials: Vec<Material>,
    lights: Vec<Rgb>,
    exposure: Rgb,
    error: Error,
    system: System,
}

/// A relative squared error and its standard deviation.
#[derive(Clone, Copy)]
struct Error {
    mean: f64,
    deviation: f64,
}

impl Refiner<'_> {
    /// Passes until no step is larger than its uncertainty.
    fn converge(&mut self, state: &mut State<'_>, observer: &mut dyn Observer) -> Solution {
        let unknowns = Unknowns::of(state);
        let believed = believed(state, &unknowns);
        let mut last: Option<Place> = None;
        let mut damping = 0.0;
        let mut covariance = DMatrix::zeros(unknowns.len(), unknowns.len());
        for _ in 0..PASSES_MAX {
            let (normal, pixels) = self.pass(state, &unknowns);
            let error = Error::of(&normal, pixels);
            let worse = last.as_ref().is_some_and(|last| error.is_above(&last.error));
            let place = match last.take() {
                Some(before) if worse && damping < 1e3 => {
                    damping = f64::max(10.0 * damping, DAMPING);
                    before.restore(state);
                    before
                }
                _ => {
                    damping *= 0.1;
                    let to_belief = &believed - unknowns.values(state);
                    Place::of(state, error, System::new(&unknowns, &normal, &to_belief))
                }
            };
            covariance = place.system.covariance();
            for (k, u) in unknowns.list.iter().enumerate() { if u.of == 0 || u.quantity == Quantity::Theta { eprintln!("{:?} {} {:?} value {:.5} std {:.5}", u.quantity, u.of, u.channel, unknowns.value(state, u), covariance[(k,k)].sqrt()); } }
            let bounds = unknowns.bounds(state);
            let Some(step) = place.system.step(damping, &bounds) else { break };
            unknowns.apply(state, &step);
            let small = (0..step.len()).all(|k| step[k].powi(2) <= covariance[(k, k)]);
            self.tell(state, observer, &unknowns, &step, error);
            let finest = self.level + 1 == PIXELS.len();
            if small && finest && !worse {
                return Solution { unknowns, covariance, settled: true };
            }
            self.level = (self.level + 1).min(PIXELS.len() - 1);
            last = Some(place);
        }
        Solution { unknowns, covariance, settled: false }
    }

    /// The normal equations at the present place, and over how many pixels.
    fn pass(&mut self, state: &mut State<'_>, unknowns: &Unknowns) -> (Normal, usize) {
        state.look_at_photograph();
        self.passes += 1;
        let seed = mix(self.options.seed ^ 0x4EF1_4E00).wrapping_add(self.passes << 8);
        let cells = sample::all(state, PIXELS[self.level], seed);
        let max_bounces = self.options.max_bounces;
        let settings = Settings { spp: SPP[self.level], seed, max_bounces };
        let means = means::gather(state, unknowns, &cells, &settings);
        let normal = Normal::of(&means, unknowns.len(), state.materials.len());
        (normal, cells.iter().map(|cell| cell.pixels.len()).sum())
    }

    fn tell(
        &self,
        state: &mut State<'_>,
        observer: &mut dyn Observer,
        unknowns: &Unknowns,
        step: &DVector<f64>,
        error: Error,
    ) {
        let reflectance = |q: Quantity| matches!(q, Quantity::RhoD | Quantity::RhoS);
        let steps = unknowns.list.iter().zip(step.iter());
        let change = steps.filter(|(u, _)| reflectance(u.quantity)).map(|(_, s)| s.abs());
        let change = change.fold(0.0, f64::max);
        let done = (self.level + 1) as f64 / (PIXELS.len() + 1) as f64;
        observer.turn(state.end_pass(change, error.mean.max(0.0).sqrt(), done));
    }
}

/// Where the prior stands: at the ladder's answer; for groups out of sight, which have none, in the
/// middle.
fn believed(state: &State<'_>, unknowns: &Unknowns) -> DVector<f64> {
    const MIDDLE: f64 = 0.5;
    let out_of_sight = |g: usize| state.problem.observation.pixels_of_group[g].is_empty();
    let believed = unknowns.list.iter().map(|u| match u.quantity {
        Quantity::RhoD if out_of_sight(u.of) => MIDDLE,
        _ => unknowns.value(state, u),
    });
    DVector::from_iterator(unknowns.len(), believed)
}

impl Place {
    fn of(state: &State<'_>, error: Error, system: System) -> Self {
        Self {
            materials: state.materials.clone(),
            lights: state.lights.clone(),
            exposure: state.exposure,
            error,
            system,
        }
    }

    fn restore(&self, state: &mut State<'_>) {
        state.materials.clone_from(&self.materials);
        state.lights.clone_from(&self.lights);
        state.exposure = self.exposure;
    }
}

impl Error {
    fn of(normal: &Normal, pixels: usize) -> Self {
        let n = 3.0 * pixels.max(1) as f64;
        let mean = normal.errors.iter().sum::<f64>() / n;
        Self { mean, deviation: deviation_of_sum(&normal.errors) / n }
    }

    fn is_above(&self, other: &Self) -> bool {
        self.mean - other.mean > WORSE * self.deviation.hypot(other.deviation)
    }
}

/// The normal equations with the prior, in units of the prior's standard deviations.
struct System {
    unit: DVector<f64>,
    h: DMatrix<f64>,
    g: DVector<f64>,
    g_covariance: DMatrix<f64>,
}

impl System {
    /// `to_belief` leads from where the unknowns stand to where the prior does.
    fn new(unknowns: &Unknowns, normal: &Normal, to_belief: &DVector<f64>) -> Self {
        let n = unknowns.len();
        let deviations = unknowns.list.iter().map(|u| prior_deviation(u.quantity));
        let unit = DVector::from_iterator(n, deviations);
        let scaled =
            |m: &DMatrix<f64>| DMatrix::from_fn(n, n, |i, j| unit[i] * m[(i, j)] * unit[j]);
        // Noise can give the curvature a direction below zero; nothing is known along it.
        let mut eigen = SymmetricEigen::new(scaled(&normal.h));
        eigen.eigenvalues.apply(|v| *v = v.max(0.0));
        let one = DMatrix::identity(n, n);
        let h = eigen.recompose() + &one;
        let g = normal.g.component_mul(&unit) + to_belief.component_div(&unit);
        let g_covariance = scaled(&normal.g_covariance) + one;
        Self { unit, h, g, g_covariance }
    }

    /// The step to the minimum within `bounds`; `damping` shortens it.
    fn step(&self, damping: f64, bounds: &quadratic::Bounds) -> Option<DVector<f64>> {
        let mut h = self.h.clone();
        for i in 0..h.nrows() {
            h[(i, i)] *= 1.0 + damping;
        }
        let h =
            DMatrix::from_fn(h.nrows(), h.ncols(), |i, j| h[(i, j)] / self.unit[i] / self.unit[j]);
        quadratic::minimise(&h, &self.g.component_div(&self.unit), bounds)
    }

    /// The covariance of the minimum.
    fn covariance(&self) -> DMatrix<f64> {
        let n = self.unit.len();
        let inverse = self.h.clone().cholesky().map_or(DMatrix::identity(n, n), |c| c.inverse());
        let covariance = &inverse * &self.g_covariance * &inverse;
        DMatrix::from_fn(n, n, |i, j| self.unit[i] * covariance[(i, j)] * self.unit[j])
    }
}
