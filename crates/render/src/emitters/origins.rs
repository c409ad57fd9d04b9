//! Where the light of each pool comes from, for finding it by way of mirrors
//! ([`crate::virtual_lamps`]).

use super::Emitters;
use super::pool::{DIRECTIONAL, ENVIRONMENT, Emitter};
use glam::Vec3;
use unrender_scene::LightKind;

/// An environment whose light comes from fewer steradians than this counts as a lamp: mirrors
/// concentrate it. Ten times the sun with its aureole; with half or double of it the light of the few panoramas in
/// between is sampled in mirrors or found by chance.
const SUN_SR: f32 = 0.1;

/// Where the light of a pool comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PoolOrigin {
    Sphere(LampSphere),
    /// The unit vector towards one light at infinity.
    Direction(Vec3),
    /// Several directions.
    Anywhere,
}

/// The bounding sphere of lights, and the cone that they emit into.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LampSphere {
    pub(crate) centre: Vec3,
    pub(crate) radius: f32,
    /// The axis of emission, a unit vector, if all lights have one; else zero.
    pub(crate) axis: Vec3,
    /// The cosine of the angle from the axis within which they emit.
    pub(crate) cos_reach: f32,
}

impl Emitters {
    /// Where the light of the pool with the index `pool` comes from; none if it has nothing to sample in mirrors.
    pub(crate) fn origin(&self, pool: usize) -> Option<PoolOrigin> {
        let lights = &self.pools[pool].lights;
        match pool {
            _ if lights.is_empty() => None,
            ENVIRONMENT => {
                let is_sun = self.environment.as_ref().is_some_and(|e| e.spread_sr() < SUN_SR);
                is_sun.then_some(PoolOrigin::Anywhere)
            }
            DIRECTIONAL => Some(match *lights.at(0) {
                Emitter::Punctual(light) if lights.len() == 1 => {
                    match self.punctual[light as usize] {
                        LightKind::Directional { direction, .. } => {
                            PoolOrigin::Direction(-direction)
                        }
                        _ => PoolOrigin::Anywhere,
                    }
                }
                _ => PoolOrigin::Anywhere,
            }),
            _ => Some(PoolOrigin::Sphere(self.bounds.sphere(pool))),
        }
    }

    /// The strength of a pool: luminance of radiance times area, or of the intensity; of lights at infinity, of
    /// the irradiance.
    pub(crate) fn strength(&self, pool: usize) -> f32 {
        self.bounds.strength(pool).unwrap_or_else(|| self.irradiances.of(pool))
    }
}
