//! How many rays to spend on a group: few while the light still changes, many at the end.
//!
//! Level 0 finds the neighbourhood, level 1 the hypotheses, level 2 the numbers. The first two are a draft,
//! whatever the effort: the joint refinement goes on from there, and under its light every hypothesis is asked
//! once more with all samples. Not so where lights are unknown: a photograph that says little of them leaves them
//! about where the levels end.

use crate::effort::Effort;
use crate::evidence::SampleBudget;
use crate::model_error::{Allowance, LightError, ModelError};
use crate::problem::Options;
use crate::rerender::round_lobes;
use unrender_render::{ProbeSettings, ProposalLobe};
use unrender_scene::Material;

/// The finest level.
pub const FINEST: usize = 2;
/// Beyond the finest level: the light has been refined.
pub const REFINED: usize = 3;
/// A level is done when no reflectance moves by more than this in an iteration.
pub const SETTLED: [f64; 3] = [0.02, 0.005, 0.002];

/// How wrong the incident light may be at each level: while the others' reflectances are rough, they
/// light a group wrongly by some percent. At half of these, slow errors of the light pass for broad
/// lobes; at double, faint broad lobes pass for errors of the light.
const LIGHT: [f64; 4] = [0.06, 0.03, 0.015, 0.01];

/// What is allowed for at a level.
pub fn allowance(level: usize, options: &Options) -> Allowance {
    let floor = [4.0, 2.0, 1.0, 1.0][level] * options.thresholds.explained;
    Allowance { light: LightError { share: LIGHT[level] }, floor: ModelError { share: floor } }
}

/// The effort of a level, where these lights are unknown.
fn effort(level: usize, options: &Options, unknown_lights: &[usize]) -> Effort {
    let is_draft = level < FINEST && unknown_lights.is_empty();
    if is_draft { Effort::Draft } else { options.effort }
}

/// Whether less light than usual may tell that a group is what it was taken for: once the light is refined. A draft's
/// is little as it is, and that of unknown lights says little of them.
pub(crate) fn is_light_to_spare(level: usize, options: &Options, unknown_lights: &[usize]) -> bool {
    level == REFINED && options.effort != Effort::Draft && unknown_lights.is_empty()
}

const PIXELS: [usize; 3] = [1500, 4000, 10000];
const COSINE: [u32; 3] = [12, 32, 64];
const GLOSSY_PIXELS: [usize; 3] = [1500, 4000, 10000];
/// A glossy group's pixels are looked at in so many points each: on a curved surface a sharp lobe
/// changes within a pixel. One makes highlights a matter of luck; sixteen with a sixteenth of the light
/// samples each see few of the lights.
const POINTS: u32 = 4;
/// Directions for each point of a pixel.
const GLOSSY_COSINE: [u32; 3] = [3, 6, 8];
const PER_LOBE: [u32; 3] = [3, 6, 8];
/// The search for candidates looks for every roughness at once.
const CANDIDATE_LOBES: [f32; 4] = [0.02, 0.06, 0.16, 0.4];
const CANDIDATE_PIXELS: usize = 2400;
const CANDIDATE_COSINE: u32 = 8;
const CANDIDATE_PER_LOBE: u32 = 6;
/// A small group's pixels are looked at in up to so many times as many points, so that its hypotheses are told
/// apart as well as those of a large one. At one the noise of a mirror's light hides whether a thing of 300
/// pixels is one; double of it pays for things of less than 150 pixels alone.
const DENSER_MAX: usize = 16;

/// For a group that is diffuse.
pub(crate) fn diffuse(level: usize, options: &Options, unknown_lights: &[usize]) -> SampleBudget {
    let effort = effort(level, options, unknown_lights);
    let cosine = effort.samples(COSINE[level]);
    let probe = ProbeSettings { cosine, seed: options.seed, ..ProbeSettings::default() };
    SampleBudget {
        pixels: effort.pixels(PIXELS[level]),
        pixels_seed: options.seed,
        allowance: allowance(level, options),
        probe,
    }
}

/// For a group whose lobe is nearly known, or that mirrors.
pub(crate) fn specular(
    level: usize,
    options: &Options,
    unknown_lights: &[usize],
    material: &Material,
) -> SampleBudget {
    let scaled = |scale: f32| ProposalLobe {
        alpha_x: scale * material.alpha_x,
        alpha_y: scale * material.alpha_y,
        theta_rad: material.theta_rad,
    };
    let effort = effort(level, options, unknown_lights);
    let lobes = if material.is_glossy() { vec![scaled(0.8), scaled(1.4)] } else { Vec::new() };
    let probe = ProbeSettings {
        probes_per_pixel: POINTS,
        cosine: effort.samples(GLOSSY_COSINE[level]),
        per_lobe: effort.samples(PER_LOBE[level]),
        lobes,
        mirror: !material.is_glossy(),
        keep_incident: material.is_glossy(),
        seed: options.seed,
        ..ProbeSettings::default()
    };
    SampleBudget {
        pixels: effort.pixels(GLOSSY_PIXELS[level]),
        pixels_seed: options.seed,
        allowance: allowance(level, options),
        probe,
    }
}

/// For trying all rungs on a group of so many `pixels`.
pub(crate) fn candidates(
    level: usize,
    options: &Options,
    unknown_lights: &[usize],
    pixels: usize,
) -> SampleBudget {
    let effort = effort(level, options, unknown_lights);
    let wanted = effort.pixels(CANDIDATE_PIXELS);
    let denser = (wanted / pixels.max(1)).clamp(1, DENSER_MAX) as u32;
    let probe = ProbeSettings {
        probes_per_pixel: denser * POINTS,
        cosine: effort.samples(CANDIDATE_COSINE),
        per_lobe: effort.samples(CANDIDATE_PER_LOBE),
        lobes: round_lobes(&CANDIDATE_LOBES),
        mirror: true,
        keep_incident: true,
        seed: options.seed,
        ..ProbeSettings::default()
    };
    SampleBudget {
        pixels: wanted,
        pixels_seed: options.seed,
        allowance: allowance(level, options),
        probe,
    }
}

/// For a texture, at every pixel of its group: while the light still changes, and at the end.
pub fn texture(last: bool, options: &Options) -> SampleBudget {
    let cosine = options.effort.samples(if last { 48 } else { 4 });
    let probe = ProbeSettings { cosine, seed: options.seed, ..ProbeSettings::default() };
    SampleBudget {
        pixels: usize::MAX,
        pixels_seed: options.seed,
        allowance: allowance(FINEST, options),
        probe,
    }
}
