//! The Lambertian term `f = rho_d / pi`, with cosine-weighted sampling [Pharr et al. 2023, section
//! A.5.3].

use crate::turn;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// `f / rho_d`, sr^-1.
pub const VALUE: f32 = FRAC_1_PI;

/// Draws a direction with density `cos / pi` from two numbers in [0, 1).
#[inline]
pub fn sample(u: [f32; 2]) -> Vec3 {
    let radius = u[0].sqrt();
    let (sin, cos) = turn::sin_cos(u[1]);
    Vec3::new(radius * cos, radius * sin, (1.0 - u[0]).max(0.0).sqrt())
}

/// The density of [`sample`] over solid angle.
#[inline]
pub fn pdf(wi: Vec3) -> f32 {
    wi.z.max(0.0) * FRAC_1_PI
}

/// The factor on light from `wi` to bumps that shade themselves on a mesh of the normal `mesh`, unit vectors in the frame of
/// the bumps. With `g = (n . wi) / ((b . wi)(n . b))`, of the normals `n` of the mesh and `b` of the bumps, and `g` below one
/// it is `g + g^2 - g^3`, so that it fades out where light grazes the mesh [Conty Estevez et al. 2019].
#[inline]
pub fn lit(mesh: Vec3, wi: Vec3) -> f32 {
    let g = mesh.dot(wi) / (wi.z * mesh.z);
    if g < 1.0 { (g + g * g - g * g * g).max(0.0) } else { 1.0 }
}
