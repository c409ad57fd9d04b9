//! Pass after pass over the photograph: towards the minimum, then until it is precise enough.
//!
//! *Approach*: few paths are traced, once ([`super::kept`]), and steps are made on them while one of their numbers is
//! significant, so that noise never leads away from the ladder's answer. A pass that finds the error
//! worse than before is taken back and its step tried again with damping [Levenberg 1944; Marquardt 1963]. Where a lobe
//! has left the range that the paths carry, they are traced anew.
//!
//! *Accumulation*: from there, more pixels and fresh paths, since the parameters are fitted to the noise of those of
//! the approach. What the passes find is averaged, the residuals extrapolated to where the parameters have moved,
//! `r -> r - J s`. Each pass continues the random sequences of the one before, and after the first one traces the paths
//! that are lacking ([`super::needs`]), where the noise comes from ([`super::origins`]). It ends when no number lacks
//! any, or after so many passes that more would help little.

use super::Solution;
use super::descent::{Descent, Evaluated, STEPS_MAX, Taken, in_deviations, system};
use super::kept::KeptPaths;
use super::means::{self, Mean, RelativeErrors};
use super::needs;
use super::normal::Normal;
use super::origins::Origins;
use super::sample;
use super::unknowns::Unknowns;
use crate::effort::Effort;
use crate::guess::Guess;
use crate::problem::{Options, Role};
use crate::progress::Progress;
use crate::sample_budget::{self, TOGETHER};
use crate::streams::Stream;
use crate::unknown::Quantity;
use nalgebra::{DMatrix, DVector};
use unrender_render::Settings;
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
/// How often the paths of an approach may be traced, and passes of an accumulation at most, also of a draft.
/// With six passes a room takes a tenth less time; double was not tried. With two a draft takes a fifth less, and stops
/// short of the minimum: unknown lights are three and a half of their standard deviations off.
const TRACED_MAX: usize = 3;
const PASSES_MAX: usize = 10;
const PASSES_DRAFT: usize = 6;
/// How often an exposure that is far off is matched to the renderings, whose paths end in the photograph and follow it.
/// Half of it leaves half of what reflections add; double changes nothing.
const BRIGHTER_MAX: usize = 6;
/// What an accumulation found is dropped after a step of so many standard deviations: it was found too
/// far away.
const FAR: f64 = 4.0;
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

    /// Moves the unknowns of `guess` to where they explain the photograph best.
    pub(super) fn converge<'a>(
        &mut self,
        guess: Guess<'a>,
        progress: &mut Progress<'_>,
    ) -> (Guess<'a>, Solution) {
        self.rounds += 1;
        let unknowns = Unknowns::of(&guess);
        let prior = unknowns.prior_mean(&guess);
        let effort = self.options.effort;
        let (guess, shown) = self.approach_with(guess, (&unknowns, &prior), effort, progress);
        let origins = shown.map(|shown| Origins::of(&shown.means, &shown.normal, &shown.inverse));
        let origins = origins.unwrap_or_default();
        self.accumulate(guess, unknowns, (&prior, &origins), progress)
    }

    /// The approach alone.
    pub(super) fn approach<'a>(
        &mut self,
        guess: Guess<'a>,
        effort: Effort,
        progress: &mut Progress<'_>,
    ) -> Guess<'a> {
        let unknowns = Unknowns::of(&guess);
        let prior = unknowns.prior_mean(&guess);
        self.approach_with(guess, (&unknowns, &prior), effort, progress).0
    }

    /// Moves `unknowns` to where they explain the photograph best on few paths; if `is_far`, first to where photograph
    /// and renderings are equally bright. Returns where they came, and the share of the photograph that is left there.
    pub(super) fn nearest<'a>(
        &mut self,
        mut guess: Guess<'a>,
        unknowns: &Unknowns,
        is_far: bool,
    ) -> (Guess<'a>, f64) {
        let prior = unknowns.prior_mean(&guess);
        let pixels = (Effort::Draft.pixels(COARSE.0), self.pixels_seed());
        guess.look_at_photograph();
        let settings = Settings { spp: Effort::Draft.samples(COARSE.1), ..self.settings() };
        let kept = KeptPaths::new(&guess, pixels, &settings);
        for _ in 0..if is_far { BRIGHTER_MAX } else { 0 } {
            guess.look_at_photograph();
            let means = guess.steps.value("pass", || kept.means(&guess, unknowns));
            equal_brightness(&mut guess, &means);
        }
        let (mut guess, _) = self.steps(guess, unknowns, &prior, &kept, None);
        guess.look_at_photograph();
        let means = guess.steps.value("pass", || kept.means(&guess, unknowns));
        let left = RelativeErrors::of(&means, guess.materials.len()).all;
        (guess, left)
    }

    /// The same, with what its paths showed at the end, none if no equations could be solved.
    fn approach_with<'a>(
        &mut self,
        mut guess: Guess<'a>,
        (unknowns, prior): (&Unknowns, &DVector<f64>),
        effort: Effort,
        progress: &mut Progress<'_>,
    ) -> (Guess<'a>, Option<Evaluated>) {
        let pixels = (effort.pixels(COARSE.0), self.pixels_seed());
        let spp = effort.samples(COARSE.1);
        let mut shown = None;
        for _ in 0..TRACED_MAX {
            let what = if progress.is_refining() { "refining" } else { "fitting" };
            progress.working(&format!("{what} all groups together"), 0.0);
            guess.look_at_photograph();
            let settings = Settings { spp, ..self.settings() };
            let kept = KeptPaths::new(&guess, pixels, &settings);
            (guess, shown) = self.steps(guess, unknowns, prior, &kept, Some(progress));
            if kept.carry(&guess) || progress.is_cancelled() {
                break;
            }
        }
        (guess, shown)
    }

    /// Steps on the same paths, while they are significant, and what they showed at the end.
    fn steps<'a>(
        &self,
        guess: Guess<'a>,
        unknowns: &Unknowns,
        prior: &DVector<f64>,
        kept: &KeptPaths<'a>,
        mut progress: Option<&mut Progress<'_>>,
    ) -> (Guess<'a>, Option<Evaluated>) {
        if progress.as_ref().is_some_and(|progress| progress.is_cancelled()) {
            return (guess, None);
        }
        let descent = Descent { unknowns, prior };
        let show = |guess: &Guess<'a>| guess.steps.value("pass", || kept.means(guess, unknowns));
        descent.run(guess, &show, &mut |guess, Taken { number, step, errors }| {
            let Some(progress) = &mut progress else { return true };
            let done = self.within(0.1 + 0.3 * *number as f64 / STEPS_MAX as f64);
            tell(guess, progress, unknowns, (step, errors), done);
            !progress.is_cancelled()
        })
    }

    /// Fresh paths, and more of them where they are lacking.
    fn accumulate<'a>(
        &mut self,
        mut guess: Guess<'a>,
        unknowns: Unknowns,
        (prior, origins): (&DVector<f64>, &Origins),
        progress: &mut Progress<'_>,
    ) -> (Guess<'a>, Solution) {
        let effort = self.options.effort;
        let settings = self.settings();
        let [known, unknown] = FINE;
        let spp = if guess.problem.unknown_lights.is_empty() { known } else { unknown };
        let first = effort.samples(spp).max(TOGETHER);
        let mut average: Vec<Mean> = Vec::new();
        let (pixels, passes_max) = match effort {
            Effort::Draft => (PIXELS_DRAFT, PASSES_DRAFT),
            Effort::Normal | Effort::High => (effort.pixels(PIXELS), PASSES_MAX),
        };
        let mut cells = sample::all(&guess, pixels, self.pixels_seed());
        let origins = origins.of_cells(&cells, unknowns.len());
        let mut samples = vec![0..first; cells.len()];
        let mut stated = DMatrix::zeros(unknowns.len(), unknowns.len());
        let (mut settled, mut failed) = (false, false);
        for pass in 1..=passes_max {
            if progress.is_cancelled() {
                break;
            }
            guess.look_at_photograph();
            sample::expose(&guess, &mut cells);
            let gather = || means::gather(&guess, &unknowns, &cells, &samples, &settings);
            means::average(&mut average, guess.steps.value("pass", gather));
            let normal = Normal::of(&average, &unknowns, guess.materials.len());
            let system = system(&guess, &unknowns, &normal, prior);
            let covariance = system.covariance();
            stated = system.stated_covariance();
            let Some(step) = system.step(0.0, &unknowns.bounds(&guess)) else {
                failed = true;
                break;
            };
            let step = unknowns.apply(&mut guess, &step);
            let done = self.within(0.4 + 0.6 * pass as f64 / passes_max as f64);
            let errors = RelativeErrors::of(&average, guess.materials.len());
            tell(&guess, progress, &unknowns, (&step, &errors), done);
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
                    &guess,
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
        (guess, Solution { unknowns, covariance: stated, settled, failed })
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
        let seed = self.pixels_seed().wrapping_add(self.count << 8);
        sample_budget::paths(0, seed, self.options)
    }

    /// The seed of the choice of pixels, which is the same in all passes.
    fn pixels_seed(&self) -> u64 {
        Stream::Refinement.seed(self.options.seed)
    }
}

/// Makes the photograph as bright as the known groups are in the renderings `means`, or as all are where none is known,
/// and then each group as bright as it.
fn equal_brightness(guess: &mut Guess<'_>, means: &[Mean]) {
    let roles: Vec<Role> = guess.problem.groups.iter().map(|group| group.role).collect();
    let is_any_known = means.iter().any(|mean| roles[mean.group] == Role::Known);
    let tells = |group: usize| !is_any_known || roles[group] == Role::Known;
    let factor = means::brightness(means, tells);
    guess.exposure *= factor;
    for (group, spec) in guess.problem.groups.iter().enumerate() {
        if spec.role == Role::Unknown {
            let ratio = factor / means::brightness(means, |g| g == group);
            let material = &mut guess.materials[group];
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
    guess: &Guess<'_>,
    progress: &mut Progress<'_>,
    unknowns: &Unknowns,
    (step, errors): (&DVector<f64>, &RelativeErrors),
    done: f64,
) {
    let reflectance = |q: Quantity| matches!(q, Quantity::RhoD | Quantity::RhoS);
    let steps = unknowns.list.iter().zip(step.iter());
    let change = steps.filter(|(u, _)| reflectance(u.quantity)).map(|(_, s)| s.abs());
    let change = change.fold(0.0, f64::max);
    progress.end_pass(guess, change, (errors.all, &errors.of_groups), done);
}
