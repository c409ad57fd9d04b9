//! The parameters of a scene that renderings vary on fixed geometry: the materials of its groups
//! and the brightness of its light sources.

use glam::Vec3;
use unrender_scene::{Corners, Environment, Material, Rgb};

/// What emits light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightSource {
    /// The surfaces of a group, by the group's index.
    Group(u32),
    /// A point, spot or directional light, by its index among the scene's lights.
    Punctual(u32),
    /// The environment, along a unit vector.
    Environment(Vec3),
}

/// The order of the light sources in [`Appearance::lights`]: all groups, whether they emit or not,
/// then the punctual lights, then the environment, whether there is one or not: as one source, or each of its
/// parts ([`Environment::parts`]).
#[derive(Clone, Debug, Default)]
pub struct SourceLayout {
    /// The number of groups.
    pub groups: u32,
    /// The number of punctual lights.
    pub punctual: u32,
    /// The environment if it is in parts.
    parts: Option<Environment>,
}

impl SourceLayout {
    /// That of a scene with so many groups and punctual lights.
    pub fn new(groups: u32, punctual: u32, environment: Option<&Environment>) -> Self {
        let parts = environment.filter(|around| around.parts() != [1, 1]).cloned();
        Self { groups, punctual, parts }
    }

    /// The place of `source` in the order; of the environment, that of its first part.
    #[inline]
    pub fn index(&self, source: LightSource) -> u32 {
        match source {
            LightSource::Group(group) => group,
            LightSource::Punctual(light) => self.groups + light,
            LightSource::Environment(_) => self.groups + self.punctual,
        }
    }

    /// The pixels of an environment in parts that `source` lies between; none for all other sources, which have
    /// one place.
    #[inline]
    pub(crate) fn corners(&self, source: LightSource) -> Option<Corners> {
        match (&self.parts, source) {
            (Some(environment), LightSource::Environment(wi)) => Some(environment.corners(wi)),
            _ => None,
        }
    }

    /// The number of sources.
    pub fn count(&self) -> usize {
        let [columns, rows] = self.parts.as_ref().map_or([1, 1], Environment::parts);
        (self.groups + self.punctual) as usize + columns * rows
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

    /// The factor on the emission of `source`. Between parts of an environment it is bilinear like their radiance, so
    /// that it is exact where all parts have the same radiance in the scene.
    #[inline]
    pub(crate) fn brightness(&self, layout: &SourceLayout, source: LightSource) -> Rgb {
        let first = layout.index(source);
        match layout.corners(source) {
            None => self.light(first),
            Some(corners) => {
                let parts = corners.pixels.iter().zip(corners.shares());
                parts.map(|(part, share)| self.light(first + *part as u32) * share).sum()
            }
        }
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
