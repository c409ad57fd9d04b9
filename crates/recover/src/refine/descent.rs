//! Gauss-Newton on the same paths, with damping after a step that made things worse [Levenberg 1944; Marquardt 1963].

use super::means::{Mean, RelativeErrors};
use super::normal::Normal;
use super::system::System;
use super::unknowns::Unknowns;
use crate::compare::WORSE;
use crate::guess::Guess;
use nalgebra::{DMatrix, DVector};
use unrender_scene::Rgb;

/// The first damping after a step that made things worse, relative to the curvature; then tenfold.
const DAMPING: f64 = 0.1;

/// Steps at most.
pub(super) const STEPS_MAX: usize = 10;
/// A step is taken if one of its numbers is this many standard deviations long. At a thirtieth of it drafts follow the
/// noise of their paths away from the ladder's answer; at double the accumulation begins off the minimum.
const SIGNIFICANT: f64 = 3.0;

/// The descent of some unknowns to where they explain the photograph best.
pub(super) struct Descent<'u> {
    pub(super) unknowns: &'u Unknowns,
    pub(super) prior: &'u DVector<f64>,
}

/// What paths showed, and its normal equations.
pub(super) struct Evaluated {
    pub(super) means: Vec<Mean>,
    pub(super) normal: Normal,
    pub(super) inverse: DMatrix<f64>,
}

/// A step that was made.
pub(super) struct Taken<'s> {
    /// Its number, from one.
    pub(super) number: usize,
    pub(super) step: &'s DVector<f64>,
    /// What it leaves to explain, before it.
    pub(super) errors: &'s RelativeErrors,
}

/// Where a step starts: the guess, what it leaves of the photograph, and its equations.
struct StepStart<'a> {
    guess: Guess<'a>,
    residuals: Vec<[Rgb; 2]>,
    weights: Vec<Rgb>,
    system: System,
}

impl Descent<'_> {
    /// Moves the unknowns of `guess` step by step, each by what the paths `show` there, until `goes_on` is false after
    /// one. Returns where they came, and what they showed in the last place that was not worse than the one before, if any.
    pub(super) fn run<'a>(
        &self,
        mut guess: Guess<'a>,
        show: &dyn Fn(&Guess<'a>) -> Vec<Mean>,
        goes_on: &mut dyn FnMut(&Guess<'a>, &Taken<'_>) -> bool,
    ) -> (Guess<'a>, Option<Evaluated>) {
        let unknowns = self.unknowns;
        let mut shown = None;
        let mut last: Option<StepStart<'a>> = None;
        let mut damping = 0.0;
        for number in 1..=STEPS_MAX {
            guess.look_at_photograph();
            let means = show(&guess);
            let normal = Normal::of(&means, unknowns, guess.materials.len());
            let errors = RelativeErrors::of(&means, guess.materials.len());
            let worse = last.as_ref().is_some_and(|last| last.is_better_than(&means));
            let start = match last.take() {
                Some(before) if worse => {
                    damping = f64::max(10.0 * damping, DAMPING);
                    before
                }
                _ => {
                    damping *= 0.1;
                    let system = system(&guess, unknowns, &normal, self.prior);
                    let start = StepStart::of(guess, &means, &normal, system);
                    shown = Some(Evaluated { means, normal, inverse: start.system.inverse() });
                    start
                }
            };
            let Some(step) = start.system.step(damping, &unknowns.bounds(&start.guess)) else {
                return (start.guess, shown);
            };
            let moved = in_deviations(&step, &start.system.covariance());
            if !worse && moved.iter().all(|moved| *moved <= SIGNIFICANT) {
                return (start.guess, shown);
            }
            guess = start.guess.clone();
            unknowns.apply(&mut guess, &step);
            if !goes_on(&guess, &Taken { number, step: &step, errors: &errors }) {
                break;
            }
            last = Some(start);
        }
        (guess, shown)
    }
}

impl<'a> StepStart<'a> {
    fn of(guess: Guess<'a>, means: &[Mean], normal: &Normal, system: System) -> Self {
        Self {
            guess,
            residuals: means.iter().map(|mean| mean.residuals).collect(),
            weights: normal.weights.clone(),
            system,
        }
    }

    /// Whether `means`, of the same cells with the same random numbers, are further from the photograph by more than
    /// [`WORSE`] times the standard deviation of the difference under either model, `2 sqrt(S)` with `S` the squared
    /// distance of both.
    fn is_better_than(&self, means: &[Mean]) -> bool {
        let (mut difference, mut separation) = (0.0, 0.0);
        for ((mean, weight), before) in means.iter().zip(&self.weights).zip(&self.residuals) {
            let ([a, b], [c, d]) = (mean.residuals, *before);
            difference += f64::from((*weight * (a * b - c * d)).element_sum());
            separation += f64::from((*weight * (a - c) * (b - d)).element_sum());
        }
        difference > WORSE * 2.0 * separation.max(0.0).sqrt()
    }
}

/// The equations at the place of `guess`, with the mean of the prior.
pub(super) fn system(
    guess: &Guess<'_>,
    unknowns: &Unknowns,
    normal: &Normal,
    prior: &DVector<f64>,
) -> System {
    let values = unknowns.values(guess);
    System::new(unknowns, normal, &(prior - &values)).related(unknowns, &values)
}

/// How many standard deviations long a step is in each number.
pub(super) fn in_deviations(step: &DVector<f64>, covariance: &DMatrix<f64>) -> Vec<f64> {
    let of = |k: usize| step[k].abs() / covariance[(k, k)].sqrt().max(f64::MIN_POSITIVE);
    (0..step.len()).map(of).collect()
}
