//! Four pairs of a glossy plane and a lamp side by side, one in each lane.

use super::{DEVIATION_MAX, DEVIATION_MIN, GlossyPair, REACH};
use crate::lanes::{Vec3x4, dot, dot_one, set_lane};
use crate::surface::Surface;
use glam::{BVec4A, Vec3, Vec4};
use std::f32::consts::SQRT_2;

/// A lobe about the direction to the mirror image of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ImageLobe {
    /// Unit vector in world space.
    pub(super) direction: Vec3,
    /// Standard deviation, radians.
    pub(super) deviation: f32,
}

/// Up to four pairs; a lane without one has no lobe anywhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FourPairs {
    /// Of the plane: its object, normal and bounding box.
    objects: [Option<u32>; 4],
    normal: Vec3x4,
    low: Vec3x4,
    high: Vec3x4,
    /// Where the plane is along its normal, m.
    offset: Vec4,
    /// The height of the lamp above the plane, m; zero where there is no pair.
    height: Vec4,
    /// The lamp's centre, and its mirror image in the plane.
    centre: Vec3x4,
    image: Vec3x4,
    /// Half of the lamp's radius, m, and its cone of emission.
    half_radius: Vec4,
    axis: Vec3x4,
    cos: Vec4,
    /// Twice the standard deviation of the half vector's slope, radians.
    of_gloss: Vec4,
}

impl FourPairs {
    /// All of `pairs`, in the same order.
    pub(crate) fn all(pairs: &[GlossyPair]) -> Vec<Self> {
        pairs.chunks(4).map(Self::of).collect()
    }

    fn of(pairs: &[GlossyPair]) -> Self {
        let (none, zero) = ([Vec4::ZERO; 3], Vec4::ZERO);
        let mut four = Self {
            objects: [None; 4],
            normal: none,
            low: none,
            high: none,
            offset: zero,
            height: zero,
            centre: none,
            image: none,
            half_radius: zero,
            axis: none,
            cos: zero,
            of_gloss: zero,
        };
        for (lane, GlossyPair { plane, alpha, lamp }) in pairs.iter().enumerate() {
            let height = (lamp.centre - plane.point).dot(plane.normal);
            four.objects[lane] = Some(plane.object);
            set_lane(&mut four.normal, lane, plane.normal);
            set_lane(&mut four.low, lane, plane.bounds[0]);
            set_lane(&mut four.high, lane, plane.bounds[1]);
            four.offset[lane] = plane.point.dot(plane.normal);
            four.height[lane] = height;
            set_lane(&mut four.centre, lane, lamp.centre);
            set_lane(&mut four.image, lane, lamp.centre - 2.0 * height * plane.normal);
            four.half_radius[lane] = 0.5 * lamp.radius;
            set_lane(&mut four.axis, lane, lamp.cone.axis);
            four.cos[lane] = lamp.cone.cos;
            four.of_gloss[lane] = SQRT_2 * alpha;
        }
        four
    }

    /// The lobes at `surface` of the pairs of which light can arrive there by way of the plane.
    #[inline]
    pub(super) fn lobes(&self, surface: &Surface) -> impl Iterator<Item = ImageLobe> + use<> {
        let point = surface.point.to_array().map(Vec4::splat);
        let here = dot(point, self.normal) - self.offset;
        // Surface and lamp must lie on one side, and neither in the plane.
        let is_beside =
            (here * self.height).cmpgt(Vec4::ZERO) & here.abs().cmpge(1e-4 * self.height.abs());
        let to_image = minus(self.image, point);
        // As `Surface::is_above`, of four directions.
        let faces = |normal: Vec3| dot_one(to_image, normal).cmpgt(Vec4::ZERO);
        let is_above = faces(surface.geometric_normal) & faces(surface.frame.normal);
        let may_be = is_beside & is_above & self.are_not(surface.object);
        let (mut bits, mut found) = (0, [Vec4::ZERO; 4]);
        if may_be.any() {
            let share = here / (here + self.height);
            let distance = dot(to_image, to_image).sqrt();
            let [of_gloss, of_lamp] =
                [self.of_gloss * (Vec4::ONE - share), self.half_radius / distance];
            let deviation = (of_gloss * of_gloss + of_lamp * of_lamp).sqrt();
            let is_lobe = deviation.cmpge(Vec4::splat(DEVIATION_MIN))
                & deviation.cmplt(Vec4::splat(DEVIATION_MAX));
            let hit = [0, 1, 2].map(|i| point[i] + share * to_image[i]);
            let reach = REACH * deviation * share * distance;
            bits = (may_be & is_lobe & self.are_hit(hit, reach)).bitmask();
            let [x, y, z] = to_image.map(|axis| axis / distance);
            found = [x, y, z, deviation];
        }
        (0..4).filter(move |lane| bits >> lane & 1 == 1).map(move |lane| {
            let [x, y, z, deviation] = found.map(|of| of[lane]);
            ImageLobe { direction: Vec3::new(x, y, z), deviation }
        })
    }

    /// The pairs whose plane is not the object with this number.
    #[inline]
    fn are_not(&self, object: u32) -> BVec4A {
        let [a, b, c, d] = self.objects.map(|own| own != Some(object));
        BVec4A::new(a, b, c, d)
    }

    /// The pairs whose plane is within `reach` of the point `hit` of its extension, towards which the lamp emits.
    #[inline]
    fn are_hit(&self, hit: Vec3x4, reach: Vec4) -> BVec4A {
        let outside = [0, 1, 2].map(|i| hit[i] - hit[i].max(self.low[i]).min(self.high[i]));
        let from_lamp = minus(hit, self.centre);
        let distance = dot(from_lamp, from_lamp).sqrt();
        dot(outside, outside).cmple(reach * reach)
            & dot(from_lamp, self.axis).cmpge(self.cos * distance)
    }
}

/// The differences, lane by lane.
#[inline(always)]
fn minus(a: Vec3x4, b: Vec3x4) -> Vec3x4 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
