//! The parameters of a scene that renderings vary on fixed geometry: the materials of its groups
//! and the brightness of its light sources.

use unrender_scene::{Material, Rgb};

/// What emits light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSource {
    /// The surfaces of a group, by the group's index.
    Group(u32),
    /// A point, spot or directional light, by its index among the scene's lights.
    Punctual(u32),
    /// The environment.
    Environment,
}

/// The order of the light sources in [`Appearance::lights`]: all groups, whether they emit or not,
/// then the punctual lights, then the environment, whether there is one or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SourceLayout {
    /// The number of groups.
    pub groups: u32,
    /// The number of punctual lights.
    pub punctual: u32,
}

impl SourceLayout {
    /// The place of `source` in the order.
    #[inline]
    pub fn index(&self, source: LightSource) -> u32 {
        match source {
            LightSource::Group(group) => group,
            LightSource::Punctual(light) => self.groups + light,
            LightSource::Environment => self.groups + self.punctual,
        }
    }

    /// The number of sources.
    pub fn count(&self) -> usize {
        self.index(LightSource::Environment) as usize + 1
    }
}

/// The materials of all groups and the brightness of all light sources.
#[derive(Clone, Copy, Debug)]
pub struct Appearance<'a> {
    /// One material per group.
    pub materials: &'a [Material],
    /// The factor on the emission of each light source, per channel, in the order of
    /// [`SourceLayout`]. Sources beyond the end have the factor one.
    pub lights: &'a [Rgb],
}

impl Appearance<'_> {
    /// The factor on the emission of the light source at the place `index`.
    #[inline]
    pub fn light(&self, index: u32) -> Rgb {
        self.lights.get(index as usize).copied().unwrap_or(Rgb::ONE)
    }
}

impl<'a> From<&'a [Material]> for Appearance<'a> {
    fn from(materials: &'a [Material]) -> Self {
        Self { materials, lights: &[] }
    }
}

impl<'a, const N: usize> From<&'a [Material; N]> for Appearance<'a> {
    fn from(materials: &'a [Material; N]) -> Self {
        materials.as_slice().into()
    }
}

impl<'a> From<&'a Vec<Material>> for Appearance<'a> {
    fn from(materials: &'a Vec<Material>) -> Self {
        materials.as_slice().into()
    }
}
