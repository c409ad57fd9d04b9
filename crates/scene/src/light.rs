//! Punctual lights, those of glTF's `KHR_lights_punctual` and `EXT_lights_ies`.
//!
//! Area lights are groups whose `emission` is not zero.
//! glTF counts these lights in candela and lux; the numbers are taken as radiometric, per channel.

use crate::{Environment, LightProfile, Rgb, Scene};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A point, spot or directional light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Light {
    /// The node's name in the scene file.
    pub name: String,
    /// Its kind, with the position in world space.
    pub kind: LightKind,
}

/// The kinds of punctual lights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LightKind {
    /// Isotropic emission from a point.
    Point {
        /// Position, metres.
        position: Vec3,
        /// Radiant intensity, W sr^-1 per channel.
        intensity: Rgb,
    },
    /// Emission from a point into a cone.
    Spot {
        /// Position, metres.
        position: Vec3,
        /// Unit vector along the axis, away from the light.
        direction: Vec3,
        /// Radiant intensity along the axis, W sr^-1 per channel.
        intensity: Rgb,
        /// Half angle up to which the intensity is full, radians.
        inner_rad: f32,
        /// Half angle from which it is zero, radians; above `inner_rad`, at most pi/2.
        outer_rad: f32,
    },
    /// Parallel light from infinity.
    Directional {
        /// Unit vector in which the light travels.
        direction: Vec3,
        /// Irradiance on a surface that faces it, W m^-2 per channel.
        irradiance: Rgb,
    },
    /// Emission from a point by a photometric profile.
    Profiled {
        /// Position, metres.
        position: Vec3,
        /// Unit vector along the profile's axis: where its lamp is aimed.
        direction: Vec3,
        /// Unit vector at right angles to the axis: the horizontal angle 0 of type C, upwards of types A and B.
        upright: Vec3,
        /// Radiant intensity where the profile has its greatest, W sr^-1 per channel.
        intensity: Rgb,
        /// The intensity by direction.
        profile: LightProfile,
    },
}

/// Where the light of a lamp without a surface comes from, and into which cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// The lamp's place, metres.
    pub position: Vec3,
    /// The axis of the cone, a unit vector; zero if light goes in all directions.
    pub axis: Vec3,
    /// Half the cone's angle, radians; pi if light goes in all directions.
    pub angle_rad: f32,
}

/// A named light source: an area light or a punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source<'a> {
    /// The group's index for area lights; for the others, the number of groups plus the index in
    /// [`Scene::lights`]; for the environment, the number of groups and lights, where its parts begin.
    pub index: usize,
    /// The name of the group or of the light; two sources may share one. That of the environment is
    /// [`ENVIRONMENT`].
    pub name: &'a str,
    /// Its strength: radiance of area lights, radiant intensity of point and spot lights,
    /// irradiance of directional ones, mean radiance of the environment.
    pub strength: Rgb,
}

/// The luminous efficacy of projects and of Blender's files, lm/W: that in the definition of the candela, of monochromatic
/// light at 540 THz. It is a definition: half and double of it would read lights twice and half as bright.
pub const LUMENS_PER_WATT: f64 = 683.0;

/// The least width of a spot's rim, in cosines. At half of it rounding shows in the rim, with double sharp spots blur.
const RIM: f32 = 1e-3;

/// The name of the environment among the sources.
pub const ENVIRONMENT: &str = "environment";

impl Scene {
    /// All named light sources: the groups that emit, then the punctual lights, then the environment if there
    /// is one.
    pub fn sources(&self) -> impl Iterator<Item = Source<'_>> {
        let groups = self.groups.iter().enumerate().filter(|(_, group)| group.is_emitter());
        let area = groups.map(|(index, g)| Source { index, name: &g.name, strength: g.emission });
        let others = self.lights.iter().enumerate().map(|(index, light)| Source {
            index: self.groups.len() + index,
            name: &light.name,
            strength: light.kind.strength(),
        });
        let around = self.environment.iter().map(|environment| Source {
            index: self.groups.len() + self.lights.len(),
            name: ENVIRONMENT,
            strength: environment.mean(),
        });
        area.chain(others).chain(around)
    }

    /// The indices of the parts of the environment among the sources: one if it is not in parts, none if there is
    /// no environment.
    pub fn environment_parts(&self) -> std::ops::Range<usize> {
        let first = self.groups.len() + self.lights.len();
        let [columns, rows] = self.environment.as_ref().map_or([0, 0], Environment::parts);
        first..first + columns * rows
    }

    /// Multiplies the strength of the light source with this index by `factor`, channel by channel; nothing happens if
    /// there is none. The parts of an environment have consecutive indices.
    pub fn scale_source(&mut self, index: usize, factor: Rgb) {
        if let Some(strength) = self.strength_mut(index) {
            *strength *= factor;
        } else {
            let part = index - self.groups.len() - self.lights.len();
            self.environment.iter_mut().for_each(|around| around.scale_part(part, factor));
        }
    }

    /// The strength of the area light or punctual light with this index; none if there is none.
    pub fn strength_mut(&mut self, index: usize) -> Option<&mut Rgb> {
        match index.checked_sub(self.groups.len()) {
            None => Some(&mut self.groups[index].emission),
            Some(light) => self.lights.get_mut(light).map(|light| light.kind.strength_mut()),
        }
    }
}

impl LightKind {
    /// Its strength: radiant intensity, or irradiance of directional lights.
    pub fn strength(&self) -> Rgb {
        match *self {
            Self::Point { intensity, .. }
            | Self::Spot { intensity, .. }
            | Self::Profiled { intensity, .. } => intensity,
            Self::Directional { irradiance, .. } => irradiance,
        }
    }

    /// [`LightKind::strength`] by mutable reference.
    pub fn strength_mut(&mut self) -> &mut Rgb {
        match self {
            Self::Point { intensity, .. }
            | Self::Spot { intensity, .. }
            | Self::Profiled { intensity, .. } => intensity,
            Self::Directional { irradiance, .. } => irradiance,
        }
    }

    /// Its flux over its strength, steradians: of a spot, the integral of its fall-off. None for directional lights,
    /// whose light has no end.
    pub fn steradians(&self) -> Option<f64> {
        match self {
            Self::Point { .. } => Some(4.0 * PI),
            Self::Spot { inner_rad, outer_rad, .. } => {
                let [inner, outer] = [inner_rad, outer_rad].map(|angle| f64::from(*angle).cos());
                let width = (inner - outer).max(RIM.into());
                // The square of a line has a third of its width's integral.
                Some(2.0 * PI * (1.0 - outer - width * (2.0 / 3.0)))
            }
            Self::Directional { .. } => None,
            Self::Profiled { profile, .. } => Some(profile.steradians()),
        }
    }

    /// Where its light comes from; none for directional lights.
    pub fn reach(&self) -> Option<Reach> {
        let everywhere = |position| Reach { position, axis: Vec3::ZERO, angle_rad: PI as f32 };
        match *self {
            Self::Point { position, .. } => Some(everywhere(position)),
            Self::Spot { position, direction: axis, outer_rad: angle_rad, .. } => {
                Some(Reach { position, axis, angle_rad })
            }
            Self::Directional { .. } => None,
            Self::Profiled { position, direction: axis, ref profile, .. } => {
                let angle_rad = profile.reach_rad();
                let is_cone = angle_rad < PI as f32;
                Some(if is_cone {
                    Reach { position, axis, angle_rad }
                } else {
                    everywhere(position)
                })
            }
        }
    }

    /// The horizontal angle 0 of a profile whose lamp is aimed along `direction`, a unit vector, in a world of which `up`
    /// points upwards: as far upwards as possible, or +x where the lamp is aimed straight up or down.
    pub fn upright(direction: Vec3, up: Vec3) -> Vec3 {
        /// The sine between the axis and the vertical below which rounding decides where upwards is: 0.06 degrees. At half
        /// of it rounded directions still count, with double, none that anybody states.
        const VERTICAL: f32 = 1e-3;
        let across = up - direction * up.dot(direction);
        let across = if across.length() < VERTICAL { Vec3::X } else { across };
        (across - direction * across.dot(direction))
            .normalize_or(direction.any_orthonormal_vector())
    }

    /// The unit vector from `point` to the light, the distance (infinite for directional lights)
    /// and the unoccluded irradiance on a surface at `point` that faces it.
    pub fn illuminate(&self, point: Vec3) -> (Vec3, f32, Rgb) {
        match *self {
            Self::Point { position, intensity } => from_position(point, position, intensity),
            Self::Spot { position, direction, intensity, inner_rad, outer_rad } => {
                let (wi, distance, irradiance) = from_position(point, position, intensity);
                (wi, distance, irradiance * spot_falloff(-wi.dot(direction), inner_rad, outer_rad))
            }
            Self::Directional { direction, irradiance } => (-direction, f32::INFINITY, irradiance),
            Self::Profiled { position, direction, upright, intensity, ref profile } => {
                let (wi, distance, irradiance) = from_position(point, position, intensity);
                let aside = upright.cross(direction);
                let towards = [upright, aside, direction].map(|axis| -wi.dot(axis));
                (wi, distance, irradiance * profile.relative(towards))
            }
        }
    }
}

fn from_position(point: Vec3, position: Vec3, intensity: Rgb) -> (Vec3, f32, Rgb) {
    let to_light = position - point;
    let distance2 = to_light.length_squared().max(1e-12);
    let distance = distance2.sqrt();
    (to_light / distance, distance, intensity / distance2)
}

/// The fraction of the axial intensity at an angle with cosine `cos_angle` from the axis
/// (the formula recommended by `KHR_lights_punctual`).
fn spot_falloff(cos_angle: f32, inner_rad: f32, outer_rad: f32) -> f32 {
    let (cos_inner, cos_outer) = (inner_rad.cos(), outer_rad.cos());
    let linear = ((cos_angle - cos_outer) / (cos_inner - cos_outer).max(RIM)).clamp(0.0, 1.0);
    linear * linear
}

#[cfg(test)]
mod profiled;
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn point_lights_fall_off_with_the_square_of_the_distance() {
        let light = LightKind::Point { position: Vec3::Y * 2.0, intensity: Rgb::splat(8.0) };
        let (wi, distance, irradiance) = light.illuminate(Vec3::ZERO);
        assert_eq!((wi, distance, irradiance), (Vec3::Y, 2.0, Rgb::splat(2.0)));
    }

    #[test]
    fn sources_count_the_groups_then_the_lights() {
        let group = |name: &str, emission| crate::Group {
            name: name.into(),
            material: crate::Material::diffuse(Rgb::ONE),
            emission,
        };
        let kind = LightKind::Directional { direction: Vec3::NEG_Y, irradiance: Rgb::ONE };
        let mut scene = Scene {
            groups: vec![group("wall", Rgb::ZERO), group("lamp", Rgb::splat(2.0))],
            lights: vec![Light { name: "sun".into(), kind }],
            ..Scene::default()
        };
        for index in [1, 2] {
            *scene.strength_mut(index).unwrap() *= 3.0;
        }
        assert_eq!(scene.strength_mut(3), None);
        let listed: Vec<_> = scene.sources().map(|s| (s.index, s.name, s.strength.x)).collect();
        assert_eq!(listed, [(1, "lamp", 6.0), (2, "sun", 3.0)]);
    }

    #[test]
    fn spots_are_full_within_the_inner_and_dark_beyond_the_outer_cone() {
        let light = LightKind::Spot {
            position: Vec3::ZERO,
            direction: Vec3::NEG_Y,
            intensity: Rgb::ONE,
            inner_rad: 0.3,
            outer_rad: 0.5,
        };
        let at = |angle: f32| light.illuminate(Vec3::new(angle.sin(), -angle.cos(), 0.0)).2.x;
        assert!((at(0.2) - 1.0).abs() < 1e-6);
        assert!(at(0.4) > 0.05 && at(0.4) < 0.95);
        assert_eq!(at(0.6), 0.0);
    }
}
