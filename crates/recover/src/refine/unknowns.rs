//! Which numbers are free in the joint refinement, as one vector, and the rows of its Jacobian. The kind of each
//! number says what it is ([`super::parameters`]).

use super::parameters::{self, At, Linear, Range, Start};
use super::relations::{self, Relation};
use crate::fit::quadratic::Bounds;
use crate::guess::{GroupGuess, Guess};
use crate::hypothesis;
use crate::problem::{ExposureRule, Role};
use crate::record::Status;
use crate::unknown::{Quantity, Unknown};
use nalgebra::DVector;
use unrender_render::Parameter;
use unrender_scene::{Material, Rgb};

/// The largest relative step of a reflectance that is taken as one of its reciprocal: it doubles it. At half of it dark
/// groups need more passes, at double they jump to infinity.
const SMALL: f64 = 0.5;

/// All free numbers, and the derivatives to ask for.
pub(crate) struct Unknowns {
    pub(crate) list: Vec<Unknown>,
    pub(crate) parameters: Vec<Parameter>,
    /// For each channel: the unknowns that change it.
    columns: [Vec<Column>; 3],
    start: Start,
    /// The standard deviations of the prior of each.
    pub(crate) deviations: Vec<f64>,
    /// What is known of their differences.
    pub(super) relations: Vec<Relation>,
}

/// Where an unknown's derivative stands in a Jacobian: at one parameter or at the sum of two.
struct Column {
    unknown: usize,
    parameters: [usize; 2],
}

/// The kinds of numbers that are free in a group: those of its rung.
fn quantities(of_group: &GroupGuess, material: &Material) -> &'static [Quantity] {
    hypothesis::quantities(of_group.hypothesis, material)
}

impl Unknowns {
    /// What is free in `guess`: the numbers of all unknown groups that are not assumed, the unknown
    /// lights, and the exposure if an anchor fixes it.
    pub(crate) fn of(guess: &Guess<'_>) -> Self {
        let mut list = Vec::new();
        for (group, spec) in guess.problem.groups.iter().enumerate() {
            let of_group = &guess.groups[group];
            if spec.role == Role::Unknown && of_group.status != Status::Assumed {
                for &quantity in quantities(of_group, &guess.materials[group]) {
                    push(&mut list, quantity, group);
                }
            }
        }
        let mut list = Self::add_nuisances(list, guess);
        (0..guess.problem.photometric_parameters.len())
            .for_each(|k| push(&mut list, Quantity::Camera, k));
        Self::new(list, guess)
    }

    /// The same with the exposure free, whatever fixes it.
    pub(super) fn with_exposure(guess: &Guess<'_>) -> Self {
        let mut list = Self::of(guess).list;
        push(&mut list, Quantity::Exposure, 0);
        Self::new(list, guess)
    }

    /// The lights and the exposure alone.
    pub(crate) fn nuisances(guess: &Guess<'_>) -> Self {
        Self::new(Self::add_nuisances(Vec::new(), guess), guess)
    }

    fn add_nuisances(mut list: Vec<Unknown>, guess: &Guess<'_>) -> Vec<Unknown> {
        for &source in &guess.problem.unknown_lights {
            if guess.problem.coloured_lights.contains(&source) {
                list.push(Unknown { quantity: Quantity::Light, of: source, channel: None });
            } else {
                push(&mut list, Quantity::Light, source);
            }
        }
        if matches!(guess.problem.exposure, ExposureRule::Anchor { .. }) {
            push(&mut list, Quantity::Exposure, 0);
        }
        list
    }

    fn new(list: Vec<Unknown>, guess: &Guess<'_>) -> Self {
        let mut parameters = Vec::new();
        let mut columns = [const { Vec::new() }; 3];
        for (unknown, u) in list.iter().enumerate() {
            let asked = parameters::of(u.quantity).parameters(u.of as u32);
            let places = asked.map(|p| match parameters.iter().position(|q| *q == p) {
                Some(place) => place,
                None => {
                    parameters.push(p);
                    parameters.len() - 1
                }
            });
            for (channel, columns) in columns.iter_mut().enumerate() {
                if u.channel.is_none_or(|c| c == channel) {
                    columns.push(Column { unknown, parameters: places });
                }
            }
        }
        let prior = list.iter().map(|u| parameters::of(u.quantity).prior(guess, u));
        let deviations = prior.map(|prior| prior.deviation).collect();
        let start = Start::of(guess);
        let relations = relations::find(&list, At { guess, start: &start });
        Self { list, parameters, columns, start, deviations, relations }
    }

    /// For each unknown: whether it is a specular reflectance.
    pub(crate) fn are_specular(&self) -> Vec<bool> {
        self.list.iter().map(|u| u.quantity == Quantity::RhoS).collect()
    }

    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// The row of the Jacobian in `channel`: which unknowns it depends on and how strongly, from the derivatives of two
    /// renderings by [`Unknowns::parameters`] and their `radiance`. `changes` are those of the `photograph` of that
    /// number by the numbers of the camera.
    pub(crate) fn row(
        &self,
        guess: &Guess<'_>,
        (derivatives, changes, photograph): (&[Vec<Rgb>; 2], &[Rgb], usize),
        channel: usize,
        radiance: [f64; 2],
    ) -> Vec<(usize, f64, f64)> {
        let at = self.at(guess);
        let one = |column: &Column| {
            let unknown = &self.list[column.unknown];
            let [a, b] = [0, 1].map(|half: usize| {
                let rendered = |p: usize| f64::from(derivatives[half][p][channel]);
                let [one, two] = column.parameters;
                let sum = if one == two { rendered(one) } else { rendered(one) + rendered(two) };
                let radiance = radiance[half];
                let linear = Linear { derivative: sum, radiance, changes, photograph, channel };
                parameters::of(unknown.quantity).derivative(at, unknown, &linear)
            });
            (a != 0.0 || b != 0.0).then_some((column.unknown, a, b))
        };
        self.columns[channel].iter().filter_map(one).collect()
    }

    fn at<'a>(&'a self, guess: &'a Guess<'_>) -> At<'a> {
        At { guess, start: &self.start }
    }

    /// The value of the unknown.
    pub(crate) fn value(&self, guess: &Guess<'_>, u: &Unknown) -> f64 {
        parameters::of(u.quantity).value(self.at(guess), u)
    }

    /// All values.
    pub(crate) fn values(&self, guess: &Guess<'_>) -> DVector<f64> {
        DVector::from_iterator(self.len(), self.list.iter().map(|u| self.value(guess, u)))
    }

    /// The mean of the prior: where a kind has none of its own, the present value.
    pub(crate) fn prior_mean(&self, guess: &Guess<'_>) -> DVector<f64> {
        let mean = |u: &Unknown| {
            let prior = parameters::of(u.quantity).prior(guess, u);
            prior.mean.unwrap_or_else(|| self.value(guess, u))
        };
        DVector::from_iterator(self.len(), self.list.iter().map(mean))
    }

    /// How far each unknown may move from where it stands.
    pub(crate) fn bounds(&self, guess: &Guess<'_>) -> Bounds {
        let interval = |u: &Unknown| {
            let value = self.value(guess, u);
            let Range { low, high, step } = parameters::of(u.quantity).range(guess, u, value);
            // A start beyond a bound (a white group by rounding) may stay where it is.
            [(low - value).max(-step).min(0.0), (high - value).min(step).max(0.0)]
        };
        let intervals: Vec<[f64; 2]> = self.list.iter().map(interval).collect();
        let bounded = guess.problem.renderer.model().is_bounded();
        let pairs = if bounded { self.pairs_below_one(guess) } else { Vec::new() };
        Bounds { intervals, pairs }
    }

    /// rho_d + rho_s <= 1 in every channel of the groups that have both.
    fn pairs_below_one(&self, guess: &Guess<'_>) -> Vec<([usize; 2], f64)> {
        let mut pairs = Vec::new();
        for (i, u) in self.list.iter().enumerate() {
            let Some(quantity) = parameters::of(u.quantity).complement() else { continue };
            let other = Unknown { quantity, ..*u };
            if let Some(j) = self.list.iter().position(|u| *u == other) {
                let sum = self.value(guess, u) + self.value(guess, &other);
                pairs.push(([i, j], (1.0 - sum).max(0.0)));
            }
        }
        pairs
    }

    /// Moves `guess` by `step`, and returns how far it went: differences of numbers, of angles the short way.
    ///
    /// Where lights are unknown, a reflectance `rho` goes to `rho / (1 - s)` for a relative step `s`, which is a
    /// straight step of its reciprocal: the picture is `P = rho (B + f E)` with a known light `B` and unknown
    /// factors `f`, so that all that explain it equally well, `P / rho = B + f E`, are on a line in `1 / rho` and `f`.
    pub(crate) fn apply(&self, guess: &mut Guess<'_>, step: &DVector<f64>) -> DVector<f64> {
        let is_light_unknown = !guess.problem.unknown_lights.is_empty();
        let values = self.values(guess);
        let mut moved = step.clone();
        for (k, u) in self.list.iter().enumerate() {
            let (kind, value) = (parameters::of(u.quantity), values[k]);
            let share = step[k] / value;
            let is_factor = matches!(u.quantity, Quantity::RhoD | Quantity::RhoS);
            if is_light_unknown && is_factor && share <= SMALL {
                let Range { low, high, .. } = kind.range(guess, u, value);
                let next = (value / (1.0 - share)).clamp(low.min(value), high.max(value));
                moved[k] = next - value;
            }
            kind.set(guess, &self.start, u, value + moved[k]);
        }
        moved
    }
}

fn push(list: &mut Vec<Unknown>, quantity: Quantity, of: usize) {
    if quantity.has_channels() {
        list.extend((0..3).map(|c| Unknown { quantity, of, channel: Some(c) }));
    } else {
        list.push(Unknown { quantity, of, channel: None });
    }
}
