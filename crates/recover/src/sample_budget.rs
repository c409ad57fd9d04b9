//! How many rays to spend on a group: few while hypotheses are chosen, many at the end.
//!
//! Hypotheses are chosen with a draft's samples, whatever the effort: under the light of the joint refinement each is
//! compared once more, with all samples. With unknown lights the choice has all samples too: if the photograph says
//! little of them, they stay about where the choice ends.

use crate::effort::Effort;
use crate::evidence::SampleBudget;
use crate::observe::model_error::{Allowance, LightError, ModelError};
use crate::problem::Options;
use unrender_render::{Integrator, ProbeSettings, ProposalLobe, Settings};
use unrender_scene::Material;

/// How well the light is known under which hypotheses are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// All numbers were fitted together on few paths; hypotheses still change.
    Choice,
    /// They were refined.
    Refined,
}

impl Level {
    /// How wrong the incident light may be: while the others' reflectances are rough estimates, their light is wrong by
    /// some percent. At half of these, slow errors of the light pass for broad lobes; at double, faint broad lobes pass
    /// for errors of the light.
    fn light(self) -> f64 {
        match self {
            Self::Choice => 0.03,
            Self::Refined => 0.01,
        }
    }

    /// The effort of the level, where these lights are unknown.
    pub(crate) fn effort(self, options: &Options, unknown_lights: &[usize]) -> Effort {
        let is_draft = self == Self::Choice && unknown_lights.is_empty();
        if is_draft { Effort::Draft } else { options.effort }
    }
}

/// What is allowed for at a level.
pub fn allowance(level: Level, options: &Options) -> Allowance {
    let floors = if level == Level::Choice { 2.0 } else { 1.0 };
    Allowance {
        light: LightError { share: level.light() },
        floor: ModelError { share: floors * options.thresholds.explained },
    }
}

/// So many paths of a pixel are stratified among themselves, and beyond that those of a block: passes are short, and what
/// counts are means over blocks. At four times as many drafts of three rooms are twice as far off in rho_d; with half as
/// many a highlight's roughness is noisier by about an eighth.
pub(crate) const TOGETHER: u32 = 16;

/// `spp` independent paths a pixel, by the random numbers of `seed`.
pub fn paths(spp: u32, seed: u64, options: &Options) -> Settings {
    Settings {
        spp,
        first: 0,
        together: TOGETHER,
        seed,
        max_bounces: options.max_bounces,
        integrator: Integrator::Path,
    }
}

/// Pixels of a diffuse group, and directions for each.
const DIFFUSE: (usize, u32) = (10_000, 64);
/// A glossy group's pixels are looked at in so many points each: on a curved surface a sharp lobe
/// changes within a pixel. One makes highlights a matter of luck; sixteen with a sixteenth of the light
/// samples each see few of the lights.
const POINTS: u32 = 4;
/// The search for candidates looks for every roughness at once.
const CANDIDATE_LOBES: [f32; 4] = [0.02, 0.06, 0.16, 0.4];
const CANDIDATE_PIXELS: usize = 2400;
const CANDIDATE_COSINE: u32 = 8;
/// As many for each lobe and along the mirror direction, in which there is no less noise: with one path in four of these drafts
/// of a room of metal took its mirror of 16 000 pixels for a sharp lobe with three seeds of four. Double of it was not tried.
const CANDIDATE_PER_LOBE: u32 = 6;
/// A small group's pixels are looked at in up to so many times as many points, so that its hypotheses are distinguished
/// as well as those of a large one. At one the noise of a mirror's light hides whether an object of 300 pixels is one;
/// double of it only helps objects of less than 150 pixels.
const DENSER_MAX: usize = 16;

/// For a group that is diffuse.
pub(crate) fn diffuse(options: &Options) -> SampleBudget {
    let (pixels, cosine) = (options.effort.pixels(DIFFUSE.0), options.effort.samples(DIFFUSE.1));
    let probe = ProbeSettings { cosine, seed: options.seed, ..ProbeSettings::default() };
    let allowance = allowance(Level::Refined, options);
    SampleBudget { pixels, pixels_seed: options.seed, allowance, probe }
}

/// For trying all rungs on a group of so many `pixels`.
pub(crate) fn candidates(
    level: Level,
    options: &Options,
    unknown_lights: &[usize],
    pixels: usize,
) -> SampleBudget {
    let effort = level.effort(options, unknown_lights);
    let wanted = effort.pixels(CANDIDATE_PIXELS);
    let denser = (wanted / pixels.max(1)).clamp(1, DENSER_MAX) as u32;
    let probe = ProbeSettings {
        probes_per_pixel: denser * POINTS,
        cosine: effort.samples(CANDIDATE_COSINE),
        per_lobe: effort.samples(CANDIDATE_PER_LOBE),
        lobes: ProposalLobe::round(&CANDIDATE_LOBES),
        mirror: effort.samples(CANDIDATE_PER_LOBE),
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

/// For a texture under this `lobe`, at every pixel of its group: while the light still changes, and at the end.
pub(crate) fn texture(last: bool, lobe: &Material, options: &Options) -> SampleBudget {
    let cosine = options.effort.samples(if last { 8 } else { 2 });
    let mut probe = ProbeSettings { cosine, seed: options.seed, ..ProbeSettings::default() };
    if lobe.is_glossy() {
        probe.lobes = ProposalLobe::round(&[lobe.alpha_x]);
        (probe.per_lobe, probe.keep_incident) = (cosine, true);
    }
    SampleBudget {
        pixels: usize::MAX,
        pixels_seed: options.seed,
        allowance: allowance(Level::Refined, options),
        probe,
    }
}
