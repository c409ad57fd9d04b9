//! Pass after pass over the photograph: towards the minimum, then until it is precise enough.
//!
//! *Approach*: few paths are traced, once ([`super::kept`]), and steps are made on them while one of their numbers is
//! significant (`SIGNIFICANT`), so that noise never leads away from the ladder's answer. A pass that finds the error
//! worse than before is taken back and its step tried again with damping [Levenberg 1944; Marquardt 1963]. Where a lobe
//! has left the range that the paths carry, they are traced anew.
//!
//! *Accumulation*: from there, more pixels and fresh paths, since the parameters are fitted to the noise of those of
//! the approach. What the passes find is averaged, the residuals extrapolated to where the parameters have moved,
//! `r -> r - J s`. Each pass continues the random sequences of the one before, and after the first one traces the paths
//! that are lacking ([`super::needs`]), where the noise comes from ([`super::origins`]). It ends when no number lacks
//! any, or after so many passes that more would help little.

use super::Solution;
use super::descent::{Descent, Evaluated, Taken, in_deviations, relative_error, system};
use super::kept::KeptPaths;
use super::means::{self, Mean};
use super::needs;
use super::normal::Normal;
use super::origins::Origins;
use super::sample;
use super::unknowns::Unknowns;
use crate::effort::Effort;
use crate::problem::{Options, Role};
use crate::record::Observer;
use crate::sample_budget::TOGETHER;
use crate::state::State;
use crate::unknown::Quantity;
use nalgebra::{DMatrix, DVector};
use unrender_render::Settings;
use unrender_render::sampler::mix;
use unrender_scene::Rgb;

/// Pixels of a group at most and paths a pixel, in each of the two renderings, of an approach.
pub(super) const COARSE: (usize, u32) = (8000, 16);
/// Pixels of a group at most in an accumulation, and in that of a draft: with 10 000 and all passes a draft takes half as
/// much time again, and is no more often right; half and double of it were not tried.
const PIXELS: usize = 40_000;
const PIXELS_DRAFT: usize = 4000;
/// Paths a pixel of its first pass, and of each other one over the whole picture at most: where lights are known, and
/// where not. Derivatives by each direction of a sky are noisy, and with half of it a sky is a tenth further off. Where they
/// are known, double of it takes a room of 9 groups a tenth more time, and brings it no nearer.
const FINE: [u32; 2] = [16, 32];
/// Steps of an approach at most, how often its paths may be traced, and passes of an accumulation at most, also of a draft.
/// With six passes a room takes a tenth less time; double was not tried. With two a draft takes a fifth less, and stops
/// short of the minimum: unknown lights are three and a half of their standard deviations off.
const STEPS_MAX: usize = 10;
const TRACED_MAX: usize = 3;
const PASSES_MAX: usize = 10;
const PASSES_DRAFT: usize = 6;
/// A step of an approach is taken if one of its numbers is this many standard deviations long. At a thirtieth of
/// it drafts follow the noise of their paths away from the ladder's answer; at double the accumulation begins off
/// the minimum.
const SIGNIFICANT: f64 = 3.0;
/// How often an exposure that is far off is matched to the renderings, whose paths end in the photograph and follow it.
/// Half of it leaves half of what reflections add; double changes nothing.
const BRIGHTER_MAX: usize = 6;
/// What an accumulation found is dropped after a step of so many standard deviations: it was found too
/// far away.
const FAR: f64 = 4.0;
/// A pass is worse if its weighted squared error is higher by this many standard deviations of the
/// difference.
const WORSE: f64 = 3.0;

/// The share of the remaining time that each accumulation of a refinement takes: as a rule the first one is the last,
/// and a verdict may ask for others.
const ROUND: f64 = 0.6;

/// The passes of one refinement.
pub(super) struct Passes<'o> {
    options: &'o Options,
    count: u64,
    /// How many accumulations have begun.
    rounds: i32,
}

impl<'o> Passes<'o> {
    pub(super) fn new(options: &'o Options) -> Self {
        Self { options, count: 0, rounds: 0 }
    }

    /// Moves the unknowns of `state` to where they explain the photograph best.
    pub(super) fn converge(
        &mut self,
        state: &mut State<'_>,
        observer: &mut dyn Observer,
    ) -> Solution {
        self.rounds += 1;
        let unknowns = Unknowns::of(state);
        let prior = unknowns.prior_mean(state);
        let effort = self.options.effort;
        let shown = self.approach_with(state, (&unknowns, &prior), effort, observer);
        let origins = shown.map(|shown| Origins::of(&shown.means, &shown.normal, &shown.inverse));
        let origins = origins.unwrap_or_default();
        self.accumulate(state, unknowns, (&prior, &origins), observer)
    }

    /// The approach alone.
    pub(super) fn approach(
        &mut self,
        state: &mut State<'_>,
        effort: Effort,
        observer: &mut dyn Observer,
    ) {
        let unknowns = Unknowns::of(state);
        let prior = unknowns.prior_mean(state);
        self.approach_with(state, (&unknowns, &prior), effort, observer);
    }

    /// Moves `unknowns` to where they explain the photograph best on few paths; if `is_far`, first to where photograph
    /// and renderings are equally bright. Returns the relative squared error that is left there.
    pub(super) fn nearest(
        &mut self,
        state: &mut State<'_>,
        unknowns: &Unknowns,
        is_far: bool,
    ) -> f64 {
        let prior = unknowns.prior_mean(state);
        let pixels = (Effort::Draft.pixels(COARSE.0), self.pixels_seed());
        state.look_at_photograph();
        let settings = Settings { spp: Effort::Draft.samples(COARSE.1), ..self.settings() };
        let kept = KeptPaths::new(state, pixels, &settings);
        for _ in 0..if is_far { BRIGHTER_MAX } else { 0 } {
            state.look_at_photograph();
            let means = state.steps.value("pass", || kept.means(state, unknowns));
            equal_brightness(state, &means);
        }
        self.steps(state, unknowns, &prior, &kept, &mut ());
        state.look_at_photograph();
        let means = state.steps.value("pass", || kept.means(state, unknowns));
        relative_error(&Normal::of(&means, unknowns, state.materials.len()), &means)
    }

    /// The same; returns what its paths showed at the end, none if no equations could be solved.
    fn approach_with(
        &mut self,
        state: &mut State<'_>,
        (unknowns, prior): (&Unknowns, &DVector<f64>),
        effort: Effort,
        observer: &mut dyn Observer,
    ) -> Option<Evaluated> {
        let pixels = (effort.pixels(COARSE.0), self.pixels_seed());
        let spp = effort.samples(COARSE.1);
        let mut shown = None;
        for _ in 0..TRACED_MAX {
            let what = if state.schedule.is_refining() { "refining" } else { "fitting" };
            observer.working(&format!("{what} all groups together"), state.schedule.share(0.0));
            state.look_at_photograph();
            let settings = Settings { spp, ..self.settings() };
            let kept = KeptPaths::new(state, pixels, &settings);
            shown = self.steps(state, unknowns, prior, &kept, observer);
            if kept.carry(state) || observer.is_cancelled() {
                break;
            }
        }
        shown
    }

    /// Steps on the same paths, while they are significant, and what they showed at the end.
    fn steps<'a>(
        &self,
        state: &mut State<'a>,
        unknowns: &Unknowns,
        prior: &DVector<f64>,
        kept: &KeptPaths<'a>,
        observer: &mut dyn Observer,
    ) -> Option<Evaluated> {
        if observer.is_cancelled() {
            return None;
        }
        let descent = Descent {
            unknowns,
            prior,
            steps_max: STEPS_MAX,
            significant: SIGNIFICANT,
            worse: WORSE,
        };
        let show = |state: &State<'a>| state.steps.value("pass", || kept.means(state, unknowns));
        descent.run(state, &show, &mut |state, Taken { number, step, error, errors }| {
            let done = self.within(0.1 + 0.3 * *number as f64 / STEPS_MAX as f64);
            tell(state, observer, unknowns, (step, *error, errors), done);
            !observer.is_cancelled()
        })
    }

    /// Fresh paths, and more of them where they are lacking.
    fn accumulate(
        &mut self,
        state: &mut State<'_>,
        unknowns: Unknowns,
        (prior, origins): (&DVector<f64>, &Origins),
        observer: &mut dyn Observer,
    ) -> Solution {
        let effort = self.options.effort;
        let settings = self.settings();
        let [known, unknown] = FINE;
        let spp = if state.problem.unknown_lights.is_empty() { known } else { unknown };
        let first = effort.samples(spp).max(TOGETHER);
        let mut average: Vec<Mean> = Vec::new();
        let (pixels, passes_max) = match effort {
            Effort::Draft => (PIXELS_DRAFT, PASSES_DRAFT),
            Effort::Normal | Effort::High => (effort.pixels(PIXELS), PASSES_MAX),
        };
        let mut cells = sample::all(state, pixels, self.pixels_seed());
        let origins = origins.of_cells(&cells, unknowns.len());
        let mut samples = vec![0..first; cells.len()];
        let mut stated = DMatrix::zeros(unknowns.len(), unknowns.len());
        let (mut settled, mut failed) = (false, false);
        for pass in 1..=passes_max {
            if observer.is_cancelled() {
                break;
            }
            state.look_at_photograph();
            sample::expose(state, &mut cells);
            let gather = || means::gather(state, &unknowns, &cells, &samples, &settings);
            means::average(&mut average, state.steps.value("pass", gather));
            let normal = Normal::of(&average, &unknowns, state.materials.len());
            let system = system(state, &unknowns, &normal, prior);
            let covariance = system.covariance();
            stated = system.stated_covariance();
            let Some(step) = system.step(0.0, &unknowns.bounds(state)) else {
                failed = true;
                break;
            };
            let step = unknowns.apply(state, &step);
            let error = relative_error(&normal, &average);
            let done = self.within(0.4 + 0.6 * pass as f64 / passes_max as f64);
            let errors = means::relative_errors(&average, state.materials.len());
            tell(state, observer, &unknowns, (&step, error, &errors), done);
            let moved = in_deviations(&step, &covariance);
            settled = moved.iter().all(|moved| *moved <= 1.0);
            let rendering = system.rendering_variance();
            let is_far = moved.iter().any(|moved| *moved > FAR);
            let paths = if is_far {
                average.clear();
                vec![first; samples.len()]
            } else {
                average.iter_mut().for_each(|mean| mean.move_by(&step));
                let variances = (&covariance, &rendering, &normal.doubt);
                needs::of(
                    state,
                    (&unknowns, effort),
                    variances,
                    &moved,
                    (&average, &origins),
                    first,
                )
            };
            if paths.iter().all(|paths| *paths == 0) {
                break;
            }
            samples.iter_mut().zip(paths).for_each(|(s, paths)| *s = s.end..s.end + paths);
        }
        Solution { unknowns, covariance: stated, settled, failed }
    }

    /// The share of the refinement that is done where `done` of its present accumulation is.
    fn within(&self, done: f64) -> f64 {
        match self.rounds {
            0 => done,
            rounds => 1.0 - (1.0 - ROUND).powi(rounds - 1) * (1.0 - ROUND * done),
        }
    }

    /// The settings of the next rendering, but for its paths a pixel.
    fn settings(&mut self) -> Settings {
        self.count += 1;
        Settings {
            first: 0,
            together: TOGETHER,
            spp: 0,
            seed: mix(self.options.seed ^ 0x4EF1_4E00).wrapping_add(self.count << 8),
            max_bounces: self.options.max_bounces,
            integrator: unrender_render::Integrator::Path,
        }
    }

    /// The seed of the choice of pixels, which is the same in all passes.
    fn pixels_seed(&self) -> u64 {
        mix(self.options.seed ^ 0x4EF1_4E00)
    }
}

/// Makes the photograph as bright as the known groups are in the renderings `means`, or as all are where none is known,
/// and then each group as bright as it.
fn equal_brightness(state: &mut State<'_>, means: &[Mean]) {
    let roles: Vec<Role> = state.problem.groups.iter().map(|group| group.role).collect();
    let is_any_known = means.iter().any(|mean| roles[mean.group] == Role::Known);
    let tells = |group: usize| !is_any_known || roles[group] == Role::Known;
    let factor = means::brightness(means, tells);
    state.exposure *= factor;
    for (group, spec) in state.problem.groups.iter().enumerate() {
        if spec.role == Role::Unknown {
            let ratio = factor / means::brightness(means, |g| g == group);
            let material = &mut state.materials[group];
            material.rho_d = (material.rho_d * ratio).clamp(Rgb::ZERO, Rgb::ONE);
            if material.reflectance.is_free() {
                material.rho_s = (material.rho_s * ratio).clamp(Rgb::ZERO, Rgb::ONE);
            }
            *material = spec.expected.bounds.nearest(material);
        }
    }
}

/// Notes the end of a pass that ended with a step.
fn tell(
    state: &mut State<'_>,
    observer: &mut dyn Observer,
    unknowns: &Unknowns,
    (step, error, errors): (&DVector<f64>, f64, &[Option<f64>]),
    done: f64,
) {
    let reflectance = |q: Quantity| matches!(q, Quantity::RhoD | Quantity::RhoS);
    let steps = unknowns.list.iter().zip(step.iter());
    let change = steps.filter(|(u, _)| reflectance(u.quantity)).map(|(_, s)| s.abs());
    let change = change.fold(0.0, f64::max);
    observer.iteration(state.end_pass(change, (error.max(0.0).sqrt(), errors), done));
}
