//! Fractional Brownian motion: octaves of value noise (Musgrave, in Ebert et al., *Texturing and
//! Modeling*, 2003, chapter 16).

use glam::{IVec3, Vec3};

/// The sum of `octaves` octaves at `point`, each of twice the frequency and half the height of the
/// one before; about -1 to 1.
pub(crate) fn fbm(point: Vec3, octaves: i32) -> f32 {
    (0..octaves).map(|i| value(point * (1 << i) as f32, i) / (1 << (i + 1)) as f32).sum()
}

/// Smooth noise between random values at whole numbers, -1 to 1.
fn value(point: Vec3, seed: i32) -> f32 {
    let cell = point.floor();
    let inside = point - cell;
    let weight = inside * inside * (Vec3::splat(3.0) - 2.0 * inside);
    let mut sum = 0.0;
    for corner in 0..8 {
        let step = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
        let share = Vec3::select(step.cmpeq(IVec3::ONE), weight, Vec3::ONE - weight);
        sum += share.element_product() * random(cell.as_ivec3() + step, seed);
    }
    sum
}

/// A number of -1 to 1 for each point of the lattice.
fn random(at: IVec3, seed: i32) -> f32 {
    let mut hash = seed as u32;
    for coordinate in at.to_array() {
        hash = (hash ^ coordinate as u32).wrapping_mul(0x9E37_79B1);
        hash = (hash ^ (hash >> 15)).wrapping_mul(0x85EB_CA77);
        hash ^= hash >> 13;
    }
    (hash >> 8) as f32 / (1 << 23) as f32 - 1.0
}
