//! The perfect mirror: all light leaves in one direction, with the share `rho_s`.

use glam::Vec3;

/// The direction that a perfect mirror sends to `wo`.
pub fn reflect(wo: Vec3) -> Vec3 {
    Vec3::new(-wo.x, -wo.y, wo.z)
}
