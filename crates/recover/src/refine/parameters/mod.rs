//! The kinds of free number of the joint refinement: one file for each, with all that the refinement needs of it.
//!
//! The refinement itself ([`super::unknowns`], [`super::passes`]) knows no kind of number. It asks the kind of each
//! unknown ([`of`]) for its value and its prior, how far it may move, and how the residual depends on it, as solvers
//! such as Ceres do. To add a kind: name it in [`Quantity`], write it in a file beside `camera.rs`, return it
//! from [`of`], and say in [`super::unknowns`] when it is free.

mod camera;
mod direction;
mod exposure;
mod light;
mod reflectance;
mod roughness;

use crate::guess::Guess;
use crate::observe::photometric::PhotometricParameter;
use crate::unknown::{Quantity, Unknown};
use unrender_render::Parameter;
use unrender_scene::Rgb;

/// The prior mean and standard deviation of a number, so wide that they only count where the
/// photograph does not determine it.
pub(super) struct Prior {
    /// None where it is the value that the refinement starts from.
    pub(super) mean: Option<f64>,
    pub(super) deviation: f64,
}

/// Between which values a number may lie, and how far one step may take it: as far as the model is
/// about linear in it.
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) step: f64,
}

/// How the renderer and the camera depend on one number, in one channel of some pixels.
pub(super) struct Linear<'a> {
    /// The derivative of the radiance by the renderer's parameters, summed over
    /// [`ParameterKind::parameters`].
    pub(super) derivative: f64,
    /// The radiance itself.
    pub(super) radiance: f64,
    /// By what share each number of the camera changes the photograph there.
    pub(super) changes: &'a [Rgb],
    /// The photograph of the pixels.
    pub(super) photograph: usize,
    pub(super) channel: usize,
}

/// Where the refinement stands, and where it started.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    pub(super) guess: &'a Guess<'a>,
    pub(super) start: &'a Start,
}

/// What does not change from one step to the next.
pub(super) struct Start {
    /// The exposure, of which the unknown one is a multiple.
    pub(super) exposure: Rgb,
    /// By what share each number of the camera changes its whole photograph.
    pub(super) relative: Vec<Rgb>,
}

impl Start {
    pub(super) fn of(guess: &Guess<'_>) -> Self {
        let relative = |c: &PhotometricParameter| c.relative(&guess.observation);
        let relative = guess.problem.photometric_parameters.iter().map(relative).collect();
        Self { exposure: guess.exposure, relative }
    }
}

/// One kind of free number. `u` is the unknown that is asked about, of this kind.
pub(super) trait ParameterKind: Sync {
    /// Its name in notes.
    fn name(&self) -> &'static str;

    /// Whether it does not belong to a group.
    fn is_nuisance(&self) -> bool {
        false
    }

    /// The kind with which it may sum to at most one, where the reflectance model is bounded.
    fn complement(&self) -> Option<Quantity> {
        None
    }

    fn prior(&self, guess: &Guess<'_>, u: &Unknown) -> Prior;

    /// The standard deviation that is small enough.
    fn precise_enough(&self, guess: &Guess<'_>, u: &Unknown) -> f64;

    /// The standard deviation of its difference from the `value` of another group that it is like `within` a share;
    /// none if such numbers may differ between like materials.
    fn likeness(&self, _value: f64, _within: f64) -> Option<f64> {
        None
    }

    /// The value.
    fn value(&self, at: At<'_>, u: &Unknown) -> f64;

    /// Gives it another value.
    fn set(&self, guess: &mut Guess<'_>, start: &Start, u: &Unknown, value: f64);

    /// The bounds; `value` is where it stands.
    fn range(&self, guess: &Guess<'_>, u: &Unknown, value: f64) -> Range;

    /// The renderer's parameters whose derivatives add up to its own; one is named twice.
    fn parameters(&self, of: u32) -> [Parameter; 2];

    /// The derivative of (rendering - photograph) by it.
    fn derivative(&self, at: At<'_>, u: &Unknown, linear: &Linear<'_>) -> f64;
}

/// What the refinement asks of a kind of number.
pub(super) fn of(quantity: Quantity) -> &'static dyn ParameterKind {
    use roughness::Along;
    match quantity {
        Quantity::RhoD => &reflectance::Diffuse,
        Quantity::RhoS => &reflectance::Specular,
        Quantity::Alpha => &roughness::Roughness(Along::Both),
        Quantity::AlphaX => &roughness::Roughness(Along::X),
        Quantity::AlphaY => &roughness::Roughness(Along::Y),
        Quantity::Theta => &direction::Direction,
        Quantity::Light => &light::Light,
        Quantity::Exposure => &exposure::Exposure,
        Quantity::Camera => &camera::Camera,
    }
}
