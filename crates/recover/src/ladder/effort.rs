//! How many rays to spend on a group: few while the light still changes, many at the end.
//!
//! Level 0 finds the neighbourhood, level 1 the hypotheses, level 2 the numbers.

use crate::evidence::Effort;
use crate::rerender::round_lobes;
use unrender_render::{ProbeSettings, ProposalLobe};
use unrender_scene::Material;

/// The finest level.
pub const FINEST: usize = 2;
/// A level is done when no reflectance moves by more than this in a turn.
pub const SETTLED: [f64; 3] = [0.02, 0.005, 0.002];

const PIXELS: [usize; 3] = [1500, 4000, 10000];
const COSINE: [u32; 3] = [12, 32, 64];
const GLOSSY_PIXELS: [usize; 3] = [1500, 4000, 10000];
const GLOSSY_COSINE: [u32; 3] = [12, 24, 32];
const PER_LOBE: [u32; 3] = [12, 24, 32];
/// A trial looks for every roughness at once.
const TRIAL_LOBES: [f32; 4] = [0.02, 0.06, 0.16, 0.4];
const TRIAL_PIXELS: usize = 4000;

/// For a group that is diffuse.
pub fn diffuse(level: usize, seed: u64) -> Effort {
    let probe = ProbeSettings { cosine: COSINE[level], seed, ..ProbeSettings::default() };
    Effort { pixels: PIXELS[level], probe }
}

/// For a group whose lobe is nearly known, or that mirrors.
pub fn specular(level: usize, seed: u64, material: &Material) -> Effort {
    let scaled = |scale: f32| ProposalLobe {
        alpha_x: scale * material.alpha_x,
        alpha_y: scale * material.alpha_y,
        theta_rad: material.theta_rad,
    };
    let lobes = if material.is_glossy() { vec![scaled(0.8), scaled(1.4)] } else { Vec::new() };
    let probe = ProbeSettings {
        cosine: GLOSSY_COSINE[level],
        per_lobe: PER_LOBE[level],
        lobes,
        mirror: !material.is_glossy(),
        keep_incident: material.is_glossy(),
        seed,
        ..ProbeSettings::default()
    };
    Effort { pixels: GLOSSY_PIXELS[level], probe }
}

/// For trying all rungs.
pub fn trial(seed: u64) -> Effort {
    let probe = ProbeSettings {
        cosine: 32,
        per_lobe: 24,
        lobes: round_lobes(&TRIAL_LOBES),
        mirror: true,
        keep_incident: true,
        seed,
        ..ProbeSettings::default()
    };
    Effort { pixels: TRIAL_PIXELS, probe }
}

/// For a texture, at every pixel of its group: while the light still changes, and at the end.
pub fn texture(last: bool, seed: u64) -> Effort {
    let cosine = if last { 48 } else { 4 };
    Effort { pixels: usize::MAX, probe: ProbeSettings { cosine, seed, ..ProbeSettings::default() } }
}
