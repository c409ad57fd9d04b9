//! Fresh paths and more pixels, pass after pass, until a goal is reached.
//!
//! The numbers of an approach suit its own paths better than others. What the passes find is averaged, the residuals
//! carried along to where the parameters have moved, `r -> r - J s`. After the first pass most paths go to the groups
//! whose numbers the renderings' noise leaves too uncertain ([`super::needs`]).

use super::means::{self, Mean};
use super::needs;
use super::normal::Normal;
use super::passes::{Passes, in_deviations, relative_error, system, tell};
use super::sample;
use super::unknowns::Unknowns;
use super::Solution;
use crate::record::Observer;
use crate::state::State;
use nalgebra::{DMatrix, DVector};

/// Pixels of a group at most and paths a pixel, in each of the two renderings, of the first pass; the others take so
/// many paths a pixel at most, over all groups.
const FINE: (usize, u32) = (40_000, 32);
/// What was found is dropped after a step of so many standard deviations: it was found too far away.
const FAR: f64 = 4.0;

/// When an accumulation has paths enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Goal {
    /// The standard deviations that are asked for, as multiples of those below which nobody asks for more.
    pub(super) deviation: f64,
    /// Passes at most.
    pub(super) passes: usize,
}

impl Goal {
    /// To judge hypotheses: what is not significant at such deviations is too small to be looked for. At half of
    /// them a hypothesis that falls costs as many passes as one that stands; at double weak lobes would fall.
    pub(super) const JUDGE: Self = Self { deviation: 3.0, passes: 4 };
    /// For the result. With four passes the roughness and the direction of a small Figure 8 are twice as far off in
    /// drafts; more than ten would lower the noise by less than a twentieth each.
    pub(super) const END: Self = Self { deviation: 1.0, passes: 10 };
}

/// What the passes have found so far.
pub(super) struct Accumulation {
    unknowns: Unknowns,
    prior: DVector<f64>,
    average: Vec<Mean>,
    passes: usize,
    last: Option<Last>,
    failed: bool,
}

/// Where the last pass left the unknowns.
struct Last {
    covariance: DMatrix<f64>,
    stated: DMatrix<f64>,
    /// The variances that come from the renderings' noise.
    rendering: DVector<f64>,
    /// The last step, in standard deviations.
    moved: Vec<f64>,
    /// The pixels of each group.
    seen: Vec<f64>,
}

impl Accumulation {
    /// Nothing is found yet of `unknowns`, whose prior has the mean `prior`.
    pub(super) fn new(unknowns: Unknowns, prior: DVector<f64>) -> Self {
        Self { unknowns, prior, average: Vec::new(), passes: 0, last: None, failed: false }
    }

    /// Makes passes until no group lacks paths for `goal`, or there were so many that more would help little.
    pub(super) fn run(
        &mut self,
        passes: &mut Passes<'_>,
        state: &mut State<'_>,
        goal: Goal,
        observer: &mut dyn Observer,
    ) {
        while self.passes < goal.passes && !self.failed && !observer.is_cancelled() {
            let Some(spp) = self.wanted(passes, state, goal) else { return };
            self.pass(passes, state, &spp, observer);
        }
    }

    /// Where the unknowns stand, and how well they are known.
    pub(super) fn solution(&self) -> Solution {
        let n = self.unknowns.len();
        let last = self.last.as_ref();
        Solution {
            unknowns: self.unknowns.clone(),
            covariance: last.map_or_else(|| DMatrix::zeros(n, n), |last| last.stated.clone()),
            settled: last.is_some_and(|last| last.moved.iter().all(|moved| *moved <= 1.0)),
            failed: self.failed,
        }
    }

    /// The paths a pixel of every group in the next pass; none if no group lacks any.
    fn wanted(&self, passes: &Passes<'_>, state: &State<'_>, goal: Goal) -> Option<Vec<u32>> {
        let effort = passes.options.effort;
        let mean_spp = effort.samples(FINE.1);
        let alike = vec![mean_spp; state.materials.len()];
        let Some(last) = &self.last else { return Some(alike) };
        let asked = goal.deviation * effort.deviation(1.0);
        let variances = (&last.covariance, &last.rendering);
        let needs = needs::of(state, (&self.unknowns, asked), variances, &last.moved, &last.seen);
        if !needs.iter().any(|need| need.lacks) {
            return None;
        }
        let dropped = self.average.is_empty();
        Some(if dropped { alike } else { needs::allocate(&last.seen, &needs, mean_spp) })
    }

    fn pass(
        &mut self,
        passes: &mut Passes<'_>,
        state: &mut State<'_>,
        spp: &[u32],
        observer: &mut dyn Observer,
    ) {
        let groups = state.materials.len();
        state.look_at_photograph();
        let most = passes.options.effort.pixels(FINE.0);
        let cells = sample::all(state, most, passes.pixels_seed());
        let found = passes.pass(state, &self.unknowns, &cells, spp);
        means::average(&mut self.average, found);
        let normal = Normal::of(&self.average, &self.unknowns, groups);
        let system = system(state, &self.unknowns, &normal, &self.prior);
        let covariance = system.covariance();
        self.passes += 1;
        let Some(step) = system.step(0.0, &self.unknowns.bounds(state)) else {
            self.failed = true;
            return;
        };
        let step = self.unknowns.apply(state, &step);
        let error = relative_error(&normal, &self.average);
        let done = 0.4 + 0.6 * self.passes as f64 / Goal::END.passes as f64;
        tell(state, observer, &self.unknowns, (&step, error, &self.average), done);
        let moved = in_deviations(&step, &covariance);
        self.last = Some(Last {
            stated: system.stated_covariance(),
            rendering: system.rendering_variance(),
            seen: means::pixels_of_groups(&self.average, groups),
            covariance,
            moved,
        });
        if self.last.iter().any(|last| last.moved.iter().any(|moved| *moved > FAR)) {
            self.average.clear();
        } else {
            self.average.iter_mut().for_each(|mean| mean.move_by(&step));
        }
    }
}
