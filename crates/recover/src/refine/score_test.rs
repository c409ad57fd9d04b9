//! Which diffuse group's specular part would explain most of the whole picture's residual: a score test [Rao 1948].
//!
//! A lobe of the floor lights the walls, and the floor's own pixels may hardly show it. So all diffuse groups get a
//! specular part of zero reflectance, and the derivatives of all pixels by all of these reflectances say what each of
//! them would gain if it were free beside all other numbers: one pass on paths that were drawn for all of them.

use super::kept::KeptPaths;
use super::normal::{Normal, dependence};
use super::passes::COARSE;
use super::system::System;
use super::unknowns::Unknowns;
use crate::compare::Measured;
use crate::effort::Effort;
use crate::fit::quadratic::{Bounds, minimise};
use crate::guess::Guess;
use crate::hypothesis::{self, Hypothesis};
use crate::problem::Options;
use crate::sample_budget::{self, TOGETHER};
use crate::selection::parameters;
use crate::streams::Stream;
use crate::unknown::{Quantity, Unknown};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use unrender_scene::{Material, Rgb};

/// What a specular part of one group would do.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Gain {
    /// How much less the whole picture's squared residual would be, in units of its variance.
    pub(crate) value: f64,
    /// The specular reflectance that does it.
    pub(crate) rho_s: Rgb,
}

/// What a specular part of the roughness `alpha`, or a mirror's, would gain for each of `groups`, which are diffuse.
pub(crate) fn gains(
    guess: &Guess<'_>,
    options: &Options,
    groups: &[usize],
    alpha: Option<f32>,
) -> Vec<Gain> {
    if groups.is_empty() {
        return Vec::new();
    }
    guess.steps.value("score test", || test(guess, options, groups, alpha))
}

/// The hypothesis of a surface that is diffuse and has a specular part of this roughness, and its material.
pub(crate) fn with_specular(rho_d: Rgb, rho_s: Rgb, alpha: Option<f32>) -> (Hypothesis, Material) {
    match alpha {
        Some(alpha) => (Hypothesis::Isotropic, Material::isotropic(rho_d, rho_s, alpha)),
        None => (Hypothesis::DiffuseSpecular, Material { rho_d, ..Material::mirror(rho_s) }),
    }
}

/// How much better the guess `specular` explains the pixels of the groups other than `group` than the guess `diffuse`,
/// the gain of all cells beside its spread [Vuong 1989] and the cost of the additional parameters [Schwarz 1978], on common
/// paths that neither was fitted on. The group's own pixels do not count: they were
/// tested alone, where slow changes over them may be errors of the light, which a needless lobe explains.
pub(crate) fn gain_of_others(
    options: &Options,
    group: usize,
    [specular, diffuse]: [&Guess<'_>; 2],
) -> Measured {
    let half = Rgb::splat(0.5);
    let mut drawn = specular.clone();
    (drawn.materials[group].rho_d, drawn.materials[group].rho_s) = (half, half);
    let kept = paths(drawn, options, Stream::Judging);
    let unknowns = Unknowns::none(specular);
    let [mine, other] = [specular, diffuse].map(|guess| {
        let mut guess = guess.clone();
        guess.look_at_photograph();
        guess.steps.value("pass", || kept.means(&guess, &unknowns))
    });
    let normal = Normal::of(&mine, &unknowns, specular.materials.len());
    let dependence = dependence(&mine, &normal.weights);
    let (mut gain, mut variance, mut independent) = (0.0, 0.0, 0.0);
    let cells = mine.iter().zip(&other).zip(&normal.weights);
    for ((mine, other), weight) in cells.filter(|((mine, _), _)| mine.group != group) {
        let square = |[a, b]: [Rgb; 2]| *weight * a * b;
        let more = square(other.residuals) - square(mine.residuals);
        let (more, share) = (f64::from(more.element_sum()), dependence[&mine.group].recip());
        gain += share * more;
        variance += share * more * more;
        independent += share;
    }
    let free = |guess: &Guess<'_>| {
        let material = &guess.materials[group];
        parameters(hypothesis::of(material), material)
    };
    let cost = (free(specular) - free(diffuse)) * f64::max(independent, 1.0).ln();
    let deviation = variance.sqrt().max(f64::MIN_POSITIVE);
    Measured { holds: gain > cost, difference: -gain, deviation, price: cost, paths: TOGETHER }
}

/// A draft's paths, drawn from the materials of `guess`; they end only on what is dull in these.
fn paths<'a>(mut guess: Guess<'a>, options: &Options, purpose: Stream) -> KeptPaths<'a> {
    guess.look_at_photograph();
    let effort = Effort::Draft;
    let seed = Stream::ScoreTest.seed(purpose.change(options.seed));
    let settings = sample_budget::paths(TOGETHER, seed, options);
    KeptPaths::new(&guess, (effort.pixels(COARSE.0), settings.seed), &settings)
}

fn test(present: &Guess<'_>, options: &Options, groups: &[usize], alpha: Option<f32>) -> Vec<Gain> {
    let with = |rho: &dyn Fn(usize) -> [Rgb; 2]| {
        let mut guess = present.clone();
        for &group in groups {
            let [rho_d, rho_s] = rho(group);
            let (hypothesis, material) = with_specular(rho_d, rho_s, alpha);
            (guess.groups[group].hypothesis, guess.materials[group]) = (hypothesis, material);
        }
        guess
    };
    // Half of the paths leave a surface by a cosine and half by its specular part: they carry both.
    let kept = paths(with(&|_| [Rgb::splat(0.5); 2]), options, Stream::Searching);
    let mut guess = with(&|group| [present.materials[group].rho_d, Rgb::ZERO]);
    guess.look_at_photograph();
    let unknowns = Unknowns::of(&guess);
    let means = kept.means(&guess, &unknowns);
    let normal = Normal::of(&means, &unknowns, guess.materials.len());
    let system = System::new(&unknowns, &normal, &DVector::zeros(unknowns.len()));
    let is_asked = |u: &Unknown| u.quantity == Quantity::RhoS && groups.contains(&u.of);
    let places = |of: &dyn Fn(&Unknown) -> bool| -> Vec<usize> {
        (0..unknowns.len()).filter(|k| of(&unknowns.list[*k])).collect()
    };
    let others = places(&|u| !is_asked(u));
    let of_group = |&group: &usize| {
        let own = places(&|u| is_asked(u) && u.of == group);
        let bounds = Bounds { intervals: vec![[0.0, 1.0]; own.len()], pairs: Vec::new() };
        let equations = system.beside(&own, &others);
        let found = equations.and_then(|(h, g)| {
            let step = minimise(&h, &g, &bounds)?;
            Some((2.0 * g.dot(&step) - step.dot(&(&h * &step)), step))
        });
        let (value, step) = found.unwrap_or((0.0, DVector::zeros(own.len())));
        let mut rho_s = Rgb::ZERO;
        for (k, step) in own.iter().zip(step.iter()) {
            rho_s[unknowns.list[*k].channel.unwrap_or(0)] = *step as f32;
        }
        Gain { value, rho_s }
    };
    groups.iter().map(of_group).collect()
}
