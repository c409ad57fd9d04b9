//! Four 3-vectors as a structure of arrays: one [`Vec4`] per axis, one lane per vector. And drawing by weights that
//! come in fours.

use glam::{Vec3, Vec4};

/// Four vectors.
pub(crate) type Vec3x4 = [Vec4; 3];

/// Sets one lane to `vector`.
pub(crate) fn set_lane(vectors: &mut Vec3x4, lane: usize, vector: Vec3) {
    for (axis, coordinate) in vectors.iter_mut().zip(vector.to_array()) {
        axis[lane] = coordinate;
    }
}

/// The dot products, lane by lane.
#[inline(always)]
pub(crate) fn dot(a: Vec3x4, b: Vec3x4) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The dot products of all four with one vector.
#[inline(always)]
pub(crate) fn dot_one(a: Vec3x4, b: Vec3) -> Vec4 {
    a[0] * b.x + a[1] * b.y + a[2] * b.z
}

/// The cross products, lane by lane.
#[inline(always)]
pub(crate) fn cross([ax, ay, az]: Vec3x4, [bx, by, bz]: Vec3x4) -> Vec3x4 {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

/// The sum of the four lanes, in the same order on all processors.
#[inline(always)]
pub(crate) fn total(four: Vec4) -> f32 {
    (four.x + four.y) + (four.z + four.w)
}

/// Draws an index in proportion to `weights`, which may be zero, by a number between zero and their sum: the
/// index, its weight, and a number in [0, 1) that is uniform given the index. None if all are zero.
#[inline]
pub(crate) fn draw(weights: &[Vec4], u: f32) -> Option<(usize, f32, f32)> {
    // Where rounding leaves the sum below `u`, the last possible index is drawn.
    let (mut before, mut last) = (0.0, None);
    for (four, numbers) in weights.iter().enumerate() {
        let sum = total(*numbers);
        if sum > 0.0 {
            last = Some((four, before));
            before += sum;
            if u < before {
                break;
            }
        }
    }
    let (four, mut before) = last?;
    let mut drawn = None;
    for (lane, weight) in weights[four].to_array().into_iter().enumerate() {
        if weight > 0.0 {
            drawn = Some((4 * four + lane, weight, u - before));
            before += weight;
            if u < before {
                break;
            }
        }
    }
    drawn.map(|(index, weight, rest)| {
        (index, weight, (rest / weight).clamp(0.0, 1.0 - f32::EPSILON))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_drawn_in_proportion_to_weights() {
        let mut weights = [Vec4::ZERO; 3];
        (weights[0][1], weights[2][3]) = (1.0, 3.0);
        assert_eq!(draw(&weights, 0.5), Some((1, 1.0, 0.5)));
        assert_eq!(draw(&weights, 2.5), Some((11, 3.0, 0.5)));
        assert_eq!(draw(&weights, 4.0).map(|drawn| drawn.0), Some(11));
        assert_eq!(draw(&[Vec4::ZERO; 3], 0.0), None);
    }

    #[test]
    fn lanes_behave_like_their_vectors() {
        let vectors = [[1.0, 2.0, 3.0], [-4.0, 5.0, 0.5], [0.0, 0.25, -1.0], [7.0, -2.0, 3.0]];
        let (mut a, mut b) = ([Vec4::ZERO; 3], [Vec4::ZERO; 3]);
        let one = |lane: usize| Vec3::from_array(vectors[lane]);
        let other = |lane: usize| Vec3::from_array(vectors[(lane + 1) % 4]);
        for lane in 0..4 {
            set_lane(&mut a, lane, one(lane));
            set_lane(&mut b, lane, other(lane));
        }
        for lane in 0..4 {
            let crossed = Vec3::from_array(cross(a, b).map(|axis| axis[lane]));
            assert_eq!(crossed, one(lane).cross(other(lane)));
            assert_eq!(dot(a, b)[lane], one(lane).dot(other(lane)));
            assert_eq!(dot_one(a, other(2))[lane], one(lane).dot(other(2)));
        }
    }
}
