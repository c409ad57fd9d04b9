//! What is free in the joint refinement, and how it reads its derivatives from a Jacobian image.
//!
//! A roughness is searched by its logarithm, which keeps it positive; reflectances and lights as
//! they are, between their bounds; the exposure as a factor on where it started.

use crate::fit::quadratic::Bounds;
use crate::hypothesis::Hypothesis;
use crate::hypothesis::isotropic::ALPHA_RANGE;
use crate::hypothesis::textured;
use crate::problem::{ExposureRule, Role};
use crate::record::Status;
use crate::state::{GroupState, State};
use nalgebra::DVector;
use unrender_render::Parameter;
use unrender_scene::Rgb;

/// One kind of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Diffuse reflectance; of a texture the mean, by the light that it sends to other groups.
    RhoD,
    /// Specular reflectance.
    RhoS,
    /// Logarithm of a roughness that is the same in all directions.
    Alpha,
    /// Logarithm of the roughness along the brushed direction.
    AlphaX,
    /// Logarithm of the roughness across it.
    AlphaY,
    /// The brushed direction, radians.
    Theta,
    /// How many times as bright as in the scene a light is.
    Light,
    /// The exposure, relative to where it started.
    Exposure,
    /// A number of the camera, from where it was when the photograph was developed.
    Camera,
}

impl Quantity {
    /// Whether it is none of a group's numbers.
    pub(crate) fn is_nuisance(self) -> bool {
        matches!(self, Self::Light | Self::Exposure | Self::Camera)
    }
}

/// One free number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Its kind.
    pub quantity: Quantity,
    /// The group, the source of light or the number of the camera; zero for the exposure.
    pub of: usize,
    /// Its channel; none for numbers that all channels share.
    pub channel: Option<usize>,
}

/// All free numbers, and the derivatives to ask for.
pub(crate) struct Unknowns {
    pub(crate) list: Vec<Unknown>,
    pub(crate) parameters: Vec<Parameter>,
    /// For each channel: the unknowns that change it.
    columns: [Vec<Column>; 3],
    exposure_start: Rgb,
    /// The standard deviations of the prior of each.
    pub(crate) deviations: Vec<f64>,
    /// By what share each number of the camera changes the whole photograph.
    relative: Vec<Rgb>,
}

/// Where an unknown's derivative stands in a Jacobian: at one parameter or at the sum of two.
struct Column {
    unknown: usize,
    parameters: [usize; 2],
}

/// A step changes no reflectance by more than this ...
const STEP_RHO: f64 = 0.3;
/// ... no specular reflectance of a lobe by more than this share of its brightest channel, or by less
/// than is hardly seen: the strength of a lobe and its roughness are not linear in each other ...
const STEP_LOBE: f64 = 0.6;
const STEP_LOBE_MIN: f64 = 0.002;
/// ... no roughness by more than this factor's logarithm ...
const STEP_LN_ALPHA: f64 = 0.4;
/// ... no direction by more than this (radians) ...
const STEP_THETA: f64 = 0.3;
/// ... and no light by more than this share of itself.
const STEP_LIGHT: f64 = 0.7;

/// The standard deviation of the prior of a texture's mean, for a texture that is seen as a whole, and what
/// is added if nothing of it is seen: seen texels are known from their own pixels, which the refinement does
/// not use, and the others are guesses from these. At half or double of either, the groups that it lights are
/// said to be surer or less sure than they are.
const TEXTURE: f64 = 0.003;
const UNSEEN: f64 = 0.15;

/// The standard deviation of the prior of a number: so
/// wide that it only speaks where the photograph is silent.
fn prior_deviation(state: &State<'_>, u: &Unknown) -> f64 {
    match u.quantity {
        Quantity::RhoD if state.groups[u.of].hypothesis == Hypothesis::Textured => {
            let seen = state.groups[u.of].seen_texels.as_ref();
            let unseen = f64::from(seen.map_or(0.0, textured::unseen_share));
            TEXTURE + UNSEEN * unseen
        }
        Quantity::RhoD | Quantity::RhoS => 0.5,
        Quantity::Alpha | Quantity::AlphaX | Quantity::AlphaY | Quantity::Theta => 1.0,
        Quantity::Light | Quantity::Exposure => 2.0,
        Quantity::Camera => state.problem.corrections[u.of].deviation,
    }
}

/// The kinds of numbers that a group has: those of its rung, and of a texture the mean where some of it is
/// unseen.
fn quantities(of_group: &GroupState) -> &'static [Quantity] {
    use Quantity::{Alpha, AlphaX, AlphaY, RhoD, RhoS, Theta};
    match of_group.hypothesis {
        Hypothesis::Textured => match &of_group.seen_texels {
            Some(seen) if textured::is_partly_unseen(seen) => &[RhoD],
            _ => &[],
        },
        Hypothesis::Diffuse => &[RhoD],
        Hypothesis::Mirror => &[],
        Hypothesis::PartialMirror => &[RhoS],
        Hypothesis::DiffuseSpecular => &[RhoD, RhoS],
        Hypothesis::Isotropic => &[RhoD, RhoS, Alpha],
        Hypothesis::Anisotropic => &[RhoD, RhoS, AlphaX, AlphaY, Theta],
    }
}

impl Unknowns {
    /// What is free in `state`: the numbers of all groups that are asked for and not assumed, the
    /// unknown lights, and the exposure if an anchor fixes it.
    pub(crate) fn of(state: &State<'_>) -> Self {
        let mut list = Vec::new();
        for (group, spec) in state.problem.groups.iter().enumerate() {
            let of_group = &state.groups[group];
            if spec.role == Role::Unknown && of_group.status != Status::Assumed {
                for &quantity in quantities(of_group) {
                    push(&mut list, quantity, group);
                }
            }
        }
        let mut list = Self::add_nuisances(list, state);
        (0..state.problem.corrections.len()).for_each(|k| push(&mut list, Quantity::Camera, k));
        Self::new(list, state)
    }

    /// The lights and the exposure alone.
    pub(crate) fn nuisances(state: &State<'_>) -> Self {
        Self::new(Self::add_nuisances(Vec::new(), state), state)
    }

    fn add_nuisances(mut list: Vec<Unknown>, state: &State<'_>) -> Vec<Unknown> {
        for &source in &state.problem.unknown_lights {
            if state.problem.coloured_lights.contains(&source) {
                list.push(Unknown { quantity: Quantity::Light, of: source, channel: None });
            } else {
                push(&mut list, Quantity::Light, source);
            }
        }
        if matches!(state.problem.exposure, ExposureRule::Anchor { .. }) {
            push(&mut list, Quantity::Exposure, 0);
        }
        list
    }

    fn new(list: Vec<Unknown>, state: &State<'_>) -> Self {
        let mut parameters = Vec::new();
        let mut columns = [const { Vec::new() }; 3];
        for (unknown, u) in list.iter().enumerate() {
            let places = derivative_of(u).map(|p| match parameters.iter().position(|q| *q == p) {
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
        let deviations = list.iter().map(|u| prior_deviation(state, u)).collect();
        let values = &state.observation.picture.values;
        let relative = state.problem.corrections.iter().map(|c| c.relative(values)).collect();
        Self { list, parameters, columns, exposure_start: state.exposure, deviations, relative }
    }

    /// For each unknown: whether it is a specular reflectance.
    pub(crate) fn are_specular(&self) -> Vec<bool> {
        self.list.iter().map(|u| u.quantity == Quantity::RhoS).collect()
    }

    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// The row of the Jacobian in `channel`: which unknowns it hangs on and how strongly, from the
    /// derivatives of two renderings by [`Unknowns::parameters`] and their `radiance`. The latter
    /// stands in for the photograph's, which moves with the exposure but whose noise is that of the
    /// residuals too. `changes` are those of the photograph by the numbers of the camera.
    pub(crate) fn row(
        &self,
        state: &State<'_>,
        (derivatives, changes): (&[Vec<Rgb>; 2], &[Rgb]),
        channel: usize,
        radiance: [f64; 2],
    ) -> Vec<(usize, f64, f64)> {
        let one = |column: &Column| {
            let unknown = &self.list[column.unknown];
            let [a, b] = [0, 1].map(|half: usize| {
                let derivatives = &derivatives[half];
                let at = |p: usize| f64::from(derivatives[p][channel]);
                let [one, two] = column.parameters;
                let sum = if one == two { at(one) } else { at(one) + at(two) };
                if unknown.quantity == Quantity::Camera {
                    let seen = sum * f64::from(self.relative[unknown.of][channel]);
                    return seen - f64::from(changes[unknown.of][channel]);
                }
                self.scaled(state, unknown, sum, radiance[half])
            });
            (a != 0.0 || b != 0.0).then_some((column.unknown, a, b))
        };
        self.columns[channel].iter().filter_map(one).collect()
    }

    /// The derivative of (rendering - photograph) by the unknown, from the renderer's `derivative`.
    fn scaled(&self, state: &State<'_>, u: &Unknown, derivative: f64, radiance: f64) -> f64 {
        match u.quantity {
            // The renderer's is by a factor on the texture.
            Quantity::RhoD if state.materials[u.of].texture.is_some() => {
                derivative / self.value(state, u).max(f64::from(textured::MEAN_MIN))
            }
            Quantity::Alpha | Quantity::AlphaX => {
                derivative * f64::from(state.materials[u.of].alpha_x)
            }
            Quantity::AlphaY => derivative * f64::from(state.materials[u.of].alpha_y),
            Quantity::Exposure => (derivative - radiance) / self.value(state, u),
            _ => derivative,
        }
    }

    /// Where the unknown stands.
    pub(crate) fn value(&self, state: &State<'_>, u: &Unknown) -> f64 {
        let channel = u.channel.unwrap_or(0);
        let value = match u.quantity {
            Quantity::RhoD => state.materials[u.of].rho_d[channel],
            Quantity::RhoS => state.materials[u.of].rho_s[channel],
            Quantity::Alpha | Quantity::AlphaX => state.materials[u.of].alpha_x.ln(),
            Quantity::AlphaY => state.materials[u.of].alpha_y.ln(),
            Quantity::Theta => state.materials[u.of].theta_rad,
            Quantity::Light => state.appearance().light(u.of as u32)[channel],
            Quantity::Exposure => state.exposure[channel] / self.exposure_start[channel],
            Quantity::Camera => return state.corrected.steps[u.of],
        };
        f64::from(value)
    }

    /// All values.
    pub(crate) fn values(&self, state: &State<'_>) -> DVector<f64> {
        DVector::from_iterator(self.len(), self.list.iter().map(|u| self.value(state, u)))
    }

    /// How far each unknown may move from where it stands.
    pub(crate) fn bounds(&self, state: &State<'_>) -> Bounds {
        let [ln_min, ln_max] = ALPHA_RANGE.map(|alpha| f64::from(alpha).ln());
        let interval = |u: &Unknown| {
            let value = self.value(state, u);
            let (low, high, step) = match u.quantity {
                Quantity::RhoS if state.materials[u.of].is_glossy() => {
                    let brightest = f64::from(state.materials[u.of].rho_s.max_element());
                    (0.0, 1.0, (STEP_LOBE * brightest).clamp(STEP_LOBE_MIN, STEP_RHO))
                }
                Quantity::RhoD | Quantity::RhoS => (0.0, 1.0, STEP_RHO),
                Quantity::Alpha | Quantity::AlphaX | Quantity::AlphaY => {
                    (ln_min, ln_max, STEP_LN_ALPHA)
                }
                Quantity::Theta => (f64::NEG_INFINITY, f64::INFINITY, STEP_THETA),
                Quantity::Light | Quantity::Exposure => (0.0, f64::INFINITY, STEP_LIGHT * value),
                Quantity::Camera => {
                    let reach = state.problem.corrections[u.of].reach;
                    (-reach, reach, f64::INFINITY)
                }
            };
            // A start beyond a bound (a white group by rounding) may stay where it is.
            [(low - value).max(-step).min(0.0), (high - value).min(step).max(0.0)]
        };
        let intervals: Vec<[f64; 2]> = self.list.iter().map(interval).collect();
        let bounded = state.problem.renderer.model().is_bounded();
        let pairs = if bounded { self.pairs_below_one(state) } else { Vec::new() };
        Bounds { intervals, pairs }
    }

    /// rho_d + rho_s <= 1 in every channel of the groups that have both.
    fn pairs_below_one(&self, state: &State<'_>) -> Vec<([usize; 2], f64)> {
        let mut pairs = Vec::new();
        for (i, d) in self.list.iter().enumerate().filter(|(_, u)| u.quantity == Quantity::RhoD) {
            let specular = Unknown { quantity: Quantity::RhoS, ..*d };
            if let Some(j) = self.list.iter().position(|u| *u == specular) {
                let sum = self.value(state, d) + self.value(state, &specular);
                pairs.push(([i, j], (1.0 - sum).max(0.0)));
            }
        }
        pairs
    }

    /// Moves the state by `step`.
    pub(crate) fn apply(&self, state: &mut State<'_>, step: &DVector<f64>) {
        for (u, step) in self.list.iter().zip(step.iter()) {
            let value = (self.value(state, u) + step) as f32;
            let channel = u.channel.unwrap_or(0);
            match u.quantity {
                Quantity::RhoD => match &state.groups[u.of].seen_texels {
                    Some(seen) => {
                        textured::set_mean(&mut state.materials[u.of], seen, channel, value);
                    }
                    None => state.materials[u.of].rho_d[channel] = value,
                },
                Quantity::RhoS => state.materials[u.of].rho_s[channel] = value,
                Quantity::Alpha => {
                    state.materials[u.of].alpha_x = value.exp();
                    state.materials[u.of].alpha_y = value.exp();
                }
                Quantity::AlphaX => state.materials[u.of].alpha_x = value.exp(),
                Quantity::AlphaY => state.materials[u.of].alpha_y = value.exp(),
                Quantity::Theta => state.materials[u.of].theta_rad = value,
                Quantity::Light => match u.channel {
                    Some(channel) => state.set_light(u.of, channel, value),
                    None => (0..3).for_each(|channel| state.set_light(u.of, channel, value)),
                },
                Quantity::Camera => state.corrected.steps[u.of] += step,
                Quantity::Exposure => {
                    state.exposure[channel] = value * self.exposure_start[channel];
                }
            }
        }
    }
}

fn push(list: &mut Vec<Unknown>, quantity: Quantity, of: usize) {
    use Quantity::{Alpha, AlphaX, AlphaY, Camera, Theta};
    if matches!(quantity, Alpha | AlphaX | AlphaY | Theta | Camera) {
        list.push(Unknown { quantity, of, channel: None });
    } else {
        list.extend((0..3).map(|c| Unknown { quantity, of, channel: Some(c) }));
    }
}

/// The renderer's parameters whose derivatives add up to the unknown's; one is named twice.
fn derivative_of(u: &Unknown) -> [Parameter; 2] {
    let of = u.of as u32;
    match u.quantity {
        Quantity::RhoD => [Parameter::RhoD(of); 2],
        Quantity::RhoS => [Parameter::RhoS(of); 2],
        Quantity::Alpha => [Parameter::AlphaX(of), Parameter::AlphaY(of)],
        Quantity::AlphaX => [Parameter::AlphaX(of); 2],
        Quantity::AlphaY => [Parameter::AlphaY(of); 2],
        Quantity::Theta => [Parameter::Theta(of); 2],
        Quantity::Light => [Parameter::Light(of); 2],
        Quantity::Exposure | Quantity::Camera => [Parameter::Cache; 2],
    }
}
