//! Streaks in the photograph of a brushed floor: a strength that varies across the brush and not along it.

use glam::Vec2;
use unrender_render::sampler::mix;

/// The width of a streak on the floor, metres: one to three pixels of the picture.
const WIDTH: f32 = 0.012;

/// The strength of the lobe at `position` on a floor brushed along `degrees`, relative to its mean: that of each streak
/// is uniform between one minus and one plus `amplitude`.
pub(crate) fn strength(position: Vec2, degrees: f32, amplitude: f32) -> f32 {
    let theta = degrees.to_radians();
    let across = position.dot(Vec2::new(-theta.sin(), theta.cos()));
    let streak = (across / WIDTH).floor() as i64;
    // The upper bits as a number from zero to one.
    let even = (mix(streak as u64) >> 40) as f32 / (1u64 << 24) as f32;
    1.0 + amplitude * (2.0 * even - 1.0)
}
