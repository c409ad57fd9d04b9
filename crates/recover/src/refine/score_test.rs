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
use crate::effort::Effort;
use crate::fit::quadratic::{Bounds, minimise};
use crate::hypothesis::{self, Hypothesis};
use crate::problem::Options;
use crate::sample_budget::TOGETHER;
use crate::selection::parameters;
use crate::state::{Snapshot, State};
use crate::unknown::{Quantity, Unknown};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use unrender_render::sampler::mix;
use unrender_render::{Integrator, Settings};
use unrender_scene::{Material, Rgb};

/// Changes the seed: the paths of a comparison differ from those of the test.
const JUDGING: u64 = 0x7D6E;

/// What a specular part of one group would do.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Gain {
    /// How much less the whole picture's squared residual would be, in units of its variance.
    pub(crate) value: f64,
    /// The specular reflectance that does it.
    pub(crate) rho_s: Rgb,
}

/// What a specular part of the roughness `alpha`, or a mirror's, would gain for each of `groups`, which are diffuse.
/// `state` is afterwards what it was.
pub(crate) fn gains(
    state: &mut State<'_>,
    options: &Options,
    groups: &[usize],
    alpha: Option<f32>,
) -> Vec<Gain> {
    if groups.is_empty() {
        return Vec::new();
    }
    let gains = state.step("score test", |state| {
        let before = state.snapshot();
        let gains = test(state, options, groups, alpha);
        state.restore(&before);
        gains
    });
    state.look_at_photograph();
    gains
}

/// The hypothesis of a surface that is diffuse and has a specular part of this roughness, and its material.
pub(crate) fn with_specular(rho_d: Rgb, rho_s: Rgb, alpha: Option<f32>) -> (Hypothesis, Material) {
    match alpha {
        Some(alpha) => (Hypothesis::Isotropic, Material::isotropic(rho_d, rho_s, alpha)),
        None => (Hypothesis::DiffuseSpecular, Material { rho_d, ..Material::mirror(rho_s) }),
    }
}

/// How much better the state `specular` explains the pixels of the groups other than `group` than the state `diffuse`,
/// in standard deviations: the mean gain of a cell, less the cost of the additional parameters [Schwarz 1978], over its
/// spread [Vuong 1989], on common paths that neither was fitted on. The group's own pixels do not count: they were
/// tested alone, where slow changes over them may be errors of the light, which a needless lobe explains. `state` is
/// afterwards what it was.
pub(crate) fn certainty(
    state: &mut State<'_>,
    options: &Options,
    group: usize,
    [specular, diffuse]: [&Snapshot; 2],
) -> f64 {
    let now = state.snapshot();
    state.restore(specular);
    let half = Rgb::splat(0.5);
    (state.materials[group].rho_d, state.materials[group].rho_s) = (half, half);
    let kept = paths(state, options, JUDGING);
    let unknowns = Unknowns::none(state);
    let [mine, other] = [specular, diffuse].map(|snapshot| {
        state.restore(snapshot);
        state.look_at_photograph();
        state.steps.value("pass", || kept.means(state, &unknowns))
    });
    state.restore(&now);
    state.look_at_photograph();
    let normal = Normal::of(&mine, &unknowns, state.materials.len());
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
    let free = |snapshot: &Snapshot| {
        let material = snapshot.material(group);
        parameters(hypothesis::of(material), material)
    };
    let cost = (free(specular) - free(diffuse)) * f64::max(independent, 1.0).ln();
    (gain - cost) / variance.sqrt().max(f64::MIN_POSITIVE)
}

/// A draft's paths, drawn from the materials of `state`; they end only on what is diffuse in these.
fn paths<'a>(state: &mut State<'a>, options: &Options, purpose: u64) -> KeptPaths<'a> {
    state.look_at_photograph();
    let effort = Effort::Draft;
    let settings = Settings {
        first: 0,
        together: TOGETHER,
        spp: TOGETHER,
        seed: mix(options.seed ^ 0x5C02_E7E5 ^ purpose),
        max_bounces: options.max_bounces,
        integrator: Integrator::Path,
    };
    KeptPaths::new(state, (effort.pixels(COARSE.0), settings.seed), &settings)
}

fn test(
    state: &mut State<'_>,
    options: &Options,
    groups: &[usize],
    alpha: Option<f32>,
) -> Vec<Gain> {
    let put = |state: &mut State<'_>, group: usize, rho_d: Rgb, rho_s: Rgb| {
        let (hypothesis, material) = with_specular(rho_d, rho_s, alpha);
        (state.groups[group].hypothesis, state.materials[group]) = (hypothesis, material);
    };
    let present: Vec<Rgb> = groups.iter().map(|group| state.materials[*group].rho_d).collect();
    // Half of the paths leave a surface by a cosine and half by its specular part: they carry both.
    let half = Rgb::splat(0.5);
    groups.iter().for_each(|group| put(state, *group, half, half));
    let kept = paths(state, options, 0);
    groups.iter().zip(present).for_each(|(group, rho_d)| put(state, *group, rho_d, Rgb::ZERO));
    let unknowns = Unknowns::of(state);
    let means = kept.means(state, &unknowns);
    let normal = Normal::of(&means, &unknowns, state.materials.len());
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
