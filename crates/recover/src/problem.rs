//! The problem: the photograph, the renderer, and what is known of each group beforehand.

use crate::effort::Effort;
use crate::expected::Expected;
use crate::observe::observation::Observation;
use crate::observe::photometric::PhotometricParameter;
use crate::texture::Detail;
use serde::{Deserialize, Serialize};
use unrender_render::Renderer;
use unrender_scene::{Group, Hypothesis, Material, Rgb};

/// Everything that recovery starts from.
#[derive(Clone)]
pub struct Problem<'a> {
    /// The photograph, sorted by groups.
    pub observation: &'a Observation,
    /// The renderer, behind the photograph's camera.
    pub renderer: &'a dyn Renderer,
    /// All groups of the scene, in its order.
    pub groups: Vec<GroupSpec>,
    /// What turns the photograph's values into radiance.
    pub exposure: ExposureRule,
    /// The sources of light whose brightness is estimated too, numbered as in
    /// [`unrender_render::Appearance::lights`].
    pub unknown_lights: Vec<usize>,
    /// Those among them whose colour is known: one factor holds for all channels.
    pub coloured_lights: Vec<usize>,
    /// Pairs of unknown lights beside each other: the parts of an environment, of which each is about as bright as
    /// those about it.
    pub neighbouring_lights: Vec<[usize; 2]>,
    /// The parameters of the camera that are estimated too.
    pub photometric_parameters: &'a [PhotometricParameter],
    /// The photograph whose squares of pixels are those of `observation`, for textures of its own pixels.
    pub detail: Option<&'a dyn Detail>,
}

impl<'a> Problem<'a> {
    /// The problem of all `groups` of the scene, in its order, at an exposure of one; all lights and the camera are
    /// known. Fields of later versions get such values too:
    /// `Problem { exposure, ..Problem::new(observation, renderer, groups) }`.
    pub fn new(
        observation: &'a Observation,
        renderer: &'a dyn Renderer,
        groups: Vec<GroupSpec>,
    ) -> Self {
        Self {
            observation,
            renderer,
            groups,
            exposure: ExposureRule::Fixed(Rgb::ONE),
            unknown_lights: Vec::new(),
            coloured_lights: Vec::new(),
            neighbouring_lights: Vec::new(),
            photometric_parameters: &[],
            detail: None,
        }
    }
}

/// What is known of a group beforehand.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupSpec {
    /// The group's name.
    pub name: String,
    /// Whether its reflectance is to be recovered.
    pub role: Role,
    /// The reflectance of known groups and emitters; ignored for unknown ones.
    pub material: Material,
    /// The hypotheses that an unknown group may have, in any order.
    pub rungs: Vec<Hypothesis>,
    /// Bounds and starting values of an unknown group's numbers.
    pub expected: Expected,
}

impl GroupSpec {
    /// Asks for the reflectance of `group`, any hypothesis allowed; if it is an area light, its material is
    /// taken as it is.
    ///
    /// ```
    /// use unrender_recover::{GroupSpec, Hypothesis, Role};
    /// use unrender_scene::{Group, Material, Rgb};
    ///
    /// let material = Material::diffuse(Rgb::ZERO);
    /// let wall = Group { name: "wall".into(), material, emission: Rgb::ZERO };
    /// let asked = GroupSpec { rungs: vec![Hypothesis::Diffuse], ..GroupSpec::of(&wall) };
    /// assert_eq!((asked.name.as_str(), asked.role), ("wall", Role::Unknown));
    /// let lamp = Group { emission: Rgb::ONE, ..wall };
    /// assert_eq!(GroupSpec::of(&lamp).role, Role::Emitter);
    /// ```
    pub fn of(group: &Group) -> Self {
        Self {
            name: group.name.clone(),
            role: if group.is_emitter() { Role::Emitter } else { Role::Unknown },
            material: group.material.clone(),
            rungs: Hypothesis::ALL.to_vec(),
            expected: Expected::default(),
        }
    }

    /// Whether the group may have `hypothesis`.
    pub(crate) fn allows(&self, hypothesis: Hypothesis) -> bool {
        self.rungs.contains(&hypothesis) && self.expected.bounds.allow(hypothesis)
    }

    /// The first material of an unknown group: diffuse with `rho_d` where nothing else is expected.
    pub(crate) fn first(&self, rho_d: Rgb) -> Material {
        let lobes = [Hypothesis::Isotropic, Hypothesis::Anisotropic];
        self.expected.first(rho_d, lobes.iter().any(|lobe| self.allows(*lobe)))
    }

    /// The material of an unknown group that no pixel shows: diffuse with [`UNSEEN`] where nothing else is expected.
    pub(crate) fn unseen(&self) -> Material {
        let first = self.first(Rgb::splat(UNSEEN));
        if self.allows(Hypothesis::Diffuse) { Material::diffuse(first.rho_d) } else { first }
    }

    /// The same in words, after "taken as".
    pub(crate) fn unseen_in_words(&self) -> &'static str {
        let is_usual = self.unseen() == Material::diffuse(Rgb::splat(UNSEEN));
        if is_usual { "0.7, as walls and ceilings are" } else { "its start and bounds guess" }
    }

    /// The hypotheses without a texture that are compared for it; where there is none, the diffuse one, which
    /// every texture begins with. A perfect mirror is a partial one whose reflectance the refinement finds to be one, and
    /// is compared by itself only where a partial one is not allowed.
    pub(crate) fn uniform_rungs(&self) -> Vec<Hypothesis> {
        let is_compared = |rung: Hypothesis| {
            rung != Hypothesis::Mirror || !self.allows(Hypothesis::PartialMirror)
        };
        let mut rungs = crate::hypothesis::UNIFORM.to_vec();
        rungs.retain(|rung| self.allows(*rung) && is_compared(*rung));
        if rungs.is_empty() { vec![Hypothesis::Diffuse] } else { rungs }
    }
}

/// The reflectance that is expected of a group out of sight: that of light walls and ceilings, which light a room most. At
/// half of it everything else comes out brighter by some percent; white makes it darker by up to 7 %.
pub const UNSEEN: f32 = 0.7;

/// Whether a group's reflectance is to be recovered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// To be recovered.
    Unknown,
    /// Given by the user.
    Known,
    /// An area light; its own reflectance stays as in the scene.
    Emitter,
}

/// Scene radiance per unit of the photograph's linear values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExposureRule {
    /// Given, per channel.
    Fixed(Rgb),
    /// Unknown; fixed by the reflectance of one group.
    Anchor {
        /// The group's index; its role is [`Role::Known`].
        group: usize,
        /// Its diffuse reflectance.
        rho_d: Rgb,
    },
}

/// The user's settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// How much work to spend.
    pub effort: Effort,
    /// When to climb.
    pub thresholds: Thresholds,
    /// The seed of all random numbers.
    pub seed: u64,
    /// Paths a pixel of the final re-rendering; fewer where pixels share theirs, at no more noise.
    pub spp: u32,
    /// Reflections along a path at most.
    pub max_bounces: u32,
    /// Whether all parameters are refined together after the ladder, with their standard deviations.
    pub refine: bool,
    /// Whether pixels that show something that is not in the model are looked for.
    pub outliers: bool,
    /// Whether to go on where no reflectances explain the photograph but a factor on all light would.
    pub force: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            effort: Effort::default(),
            thresholds: Thresholds::default(),
            seed: 0,
            spp: Effort::default().last_spp(1),
            max_bounces: unrender_render::path::MAX_BOUNCES,
            refine: true,
            outliers: true,
            force: false,
        }
    }
}

/// When a hypothesis is good enough; relative errors, 0.01 is one percent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// Model error, as a share of the local light, that always counts as explained: no difference
    /// below it decides anything.
    pub explained: f64,
    /// Where given: a simpler rung is preferred whose error is at most this many times the best
    /// rung's, whatever the significance of the difference.
    pub simpler: Option<f64>,
    /// A group is textured if texels from some of its pixels predict a contrast of the others above this, relative and root
    /// mean square, that no uniform rung predicts. At half of the default a lobe that is not in the model passes for a
    /// texture, at double worn floors are flat.
    pub textured: f64,
    /// The paper's lambda (eq. 3): objects whose ratio is further than this from the median of
    /// their group, relatively, do not count.
    pub dispersion: f64,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self { explained: 0.003, simpler: None, textured: 0.035, dispersion: 0.5 }
    }
}

/// Why recovery cannot start, or need not go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecoverError {
    /// The photograph shows none of the scene's groups.
    #[error(
        "the camera sees none of the scene's groups: check the camera's position and direction"
    )]
    NothingSeen,
    /// All valid pixels of the photograph are black.
    #[error(
        "the photograph is black wherever it shows the scene: was it developed too dark, or is black_level (or the \
         response) of the project not the photograph's?"
    )]
    Black,
    /// No light of the scene reaches the groups that the photograph shows, which are these.
    #[error(
        "no light of the scene reaches what the camera sees ({}). Does the camera stand outside of a closed room or inside \
         of something (near in the project's [camera] lets it look through a wall, as a near clipping plane does), are the lamps shut in, or is another axis up than in the scene? `unrender check` draws what \
         the camera sees",
        some_names(_0)
    )]
    NoLight(Vec<String>),
    /// The anchor fixes nothing.
    #[error(
        "the anchor group \"{0}\" is not visible in the photograph (or not lit): choose another \
         anchor, or give the exposure as a number"
    )]
    AnchorUnseen(String),
    /// All light is a factor off.
    #[error(
        "no reflectances explain this photograph: the nearest leave {:.0} % of it unexplained. If all light of the scene \
         were {} as bright, {:.0} % would be left: correct the units of the lights, or the project's exposure or \
         response{remedy}. --force continues anyway",
        100.0 * unexplained[0], times(*factor), 100.0 * unexplained[1]
    )]
    Unexplained {
        /// How many times as bright the light of the scene would have to be, per channel; infinite in a channel in which
        /// there is none.
        factor: Rgb,
        /// The share of the photograph that is not explained as it is, and with the factor.
        unexplained: [f64; 2],
        /// What a caller who knows the scene's files adds on such a factor, a clause behind the message; empty at
        /// first.
        remedy: String,
    },
}

/// The first of `names` in a sentence.
fn some_names(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().take(4).map(|name| format!("\"{name}\"")).collect();
    match names.len() - quoted.len() {
        0 => quoted.join(", "),
        rest => format!("{} and {rest} more", quoted.join(", ")),
    }
}

/// A factor in words: one number where the channels agree.
fn times(factor: Rgb) -> String {
    let number = |value: f32| match value {
        value if !value.is_finite() => "infinitely many".to_owned(),
        value if value >= 100.0 => format!("{value:.0}"),
        value if value >= 1.0 => format!("{value:.1}"),
        value => format!("{value:.3}"),
    };
    let mean = factor.element_sum() / 3.0;
    if (factor - mean).abs().max_element() < 0.1 * mean {
        return format!("{} times", number(mean));
    }
    let [r, g, b] = factor.to_array().map(number);
    format!("{r} (red), {g} (green), {b} (blue) times")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perfect_mirror_is_compared_only_where_a_partial_one_is_not_allowed() {
        let material = Material::diffuse(Rgb::ZERO);
        let group = Group { name: "wall".into(), material, emission: Rgb::ZERO };
        let all = GroupSpec::of(&group);
        assert!(!all.uniform_rungs().contains(&Hypothesis::Mirror));
        let rungs = vec![Hypothesis::Diffuse, Hypothesis::Mirror];
        let few = GroupSpec { rungs: rungs.clone(), ..all };
        assert_eq!(few.uniform_rungs(), rungs);
    }
}
