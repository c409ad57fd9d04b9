//! The perfect mirror: a delta distribution in the mirror direction, with the reflectance `rho_s`.

use glam::Vec3;

/// The mirror direction of `wo`.
pub fn reflect(wo: Vec3) -> Vec3 {
    Vec3::new(-wo.x, -wo.y, wo.z)
}
