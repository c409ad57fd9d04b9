//! Four virtual lamps at once: the approximate irradiance of each at a point, where its mirrors show it.

use super::chain::{Chain, MIRRORS_MAX, Mirror};
use super::lamps::VirtualLamp;
use crate::emitters::PoolOrigin;
use crate::lanes::{Vec3x4, dot, set_lane};
use glam::{BVec4A, Vec3, Vec4};

/// A lamp that is seen from the side counts as if its cosine were at least this: its other side may
/// face the point. Half or double of it moves a few samples from one lamp to another.
const FACING_MIN: f32 = 0.05;

/// Four virtual lamps, one per lane, by chains of as many mirrors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Four {
    mirrors: [Mirror4; MIRRORS_MAX],
    count: usize,
    /// Their centres, or the directions towards them, as seen before each mirror.
    images: [Vec3x4; MIRRORS_MAX],
    /// One for lamps at a distance, zero for those at infinity.
    near: Vec4,
    /// One for light from all sides, which counts as seen in all mirrors.
    anywhere: Vec4,
    radius: Vec4,
    /// The axis of emission as seen before the first mirror, zero without one.
    axis: Vec3x4,
    cos_reach: Vec4,
    /// [`FACING_MIN`], or one for lamps without an axis.
    facing_min: Vec4,
    strength: Vec4,
}

/// A mirror of each of four chains.
#[derive(Clone, Copy, Debug, Default)]
struct Mirror4 {
    point: Vec3x4,
    normal: Vec3x4,
    bounds: [Vec3x4; 2],
    margin: Vec4,
}

impl Four {
    /// Of at most four lamps by chains of one length; lanes without a lamp have no strength.
    pub(super) fn new(lamps: &[VirtualLamp], chains: &[Chain]) -> Self {
        let mut four = Self {
            mirrors: [Mirror4::default(); MIRRORS_MAX],
            count: lamps.first().map_or(0, |lamp| chains[lamp.chain].mirrors().len()),
            images: [[Vec4::ZERO; 3]; MIRRORS_MAX],
            near: Vec4::ZERO,
            anywhere: Vec4::ZERO,
            radius: Vec4::ZERO,
            axis: [Vec4::ZERO; 3],
            cos_reach: Vec4::NEG_ONE,
            facing_min: Vec4::ONE,
            strength: Vec4::ZERO,
        };
        for (lane, lamp) in lamps.iter().enumerate() {
            four.set(lane, lamp, &chains[lamp.chain]);
        }
        four
    }

    fn set(&mut self, lane: usize, lamp: &VirtualLamp, chain: &Chain) {
        for (slot, mirror) in self.mirrors.iter_mut().zip(chain.mirrors()) {
            slot.set(lane, mirror);
        }
        for (slot, image) in self.images.iter_mut().zip(lamp.images) {
            set_lane(slot, lane, image);
        }
        self.strength[lane] = lamp.strength;
        match lamp.lamp.origin {
            PoolOrigin::Anywhere => self.anywhere[lane] = 1.0,
            PoolOrigin::Direction(_) => {}
            PoolOrigin::Sphere(sphere) => {
                self.near[lane] = 1.0;
                self.radius[lane] = sphere.radius;
                if lamp.axis != Vec3::ZERO {
                    set_lane(&mut self.axis, lane, lamp.axis);
                    self.cos_reach[lane] = sphere.cos_reach;
                    self.facing_min[lane] = FACING_MIN;
                }
            }
        }
    }

    /// The approximate irradiance at `origin` from each, W m^-2; zero where its mirrors do not show it.
    #[inline]
    pub(super) fn irradiances(&self, origin: Vec3) -> Vec4 {
        let origin = origin.to_array().map(Vec4::splat);
        let mut seen = self.strength.cmpgt(Vec4::ZERO);
        let (mut point, mut radius) = (origin, self.radius);
        for (mirror, image) in self.mirrors[..self.count].iter().zip(&self.images) {
            // To the image, or along the direction of a lamp at infinity.
            let way = [0, 1, 2].map(|k| image[k] - self.near * point[k]);
            let share = -mirror.height(point) / dot(way, mirror.normal);
            let is_between = share.cmpgt(Vec4::ZERO) & (self.near * share).cmplt(Vec4::ONE);
            point = [0, 1, 2].map(|k| point[k] + share * way[k]);
            seen &= is_between & mirror.are_near(point, radius * share);
            // The rest of the way sees the lamp under the same angle as the whole way.
            radius *= 1.0 - share;
        }
        seen |= self.anywhere.cmpgt(Vec4::ZERO);
        if !seen.any() {
            return Vec4::ZERO;
        }
        Vec4::select(seen, self.unoccluded(origin), Vec4::ZERO)
    }

    /// The same if the mirrors show them everywhere: the strength, times a bound of the cosine at the lamp, over
    /// the squared distance.
    #[inline]
    fn unoccluded(&self, origin: Vec3x4) -> Vec4 {
        let from_lamp = [0, 1, 2].map(|k| origin[k] - self.images[0][k]);
        let distance2 = dot(from_lamp, from_lamp).max(Vec4::splat(f32::MIN_POSITIVE));
        let distance = distance2.sqrt();
        let along = dot(from_lamp, self.axis) + self.radius;
        let edge = (distance - self.radius) * self.cos_reach - 1e-4 * distance;
        let facing = (along / distance).max(self.facing_min).min(Vec4::ONE);
        let least = distance2.max(self.radius * self.radius);
        let near = Vec4::select(along.cmpgt(edge), self.strength * facing / least, Vec4::ZERO);
        Vec4::select(self.near.cmpgt(Vec4::ZERO), near, self.strength)
    }
}

impl Mirror4 {
    fn set(&mut self, lane: usize, mirror: &Mirror) {
        set_lane(&mut self.point, lane, mirror.face.point);
        set_lane(&mut self.normal, lane, mirror.face.normal);
        for (slot, corner) in self.bounds.iter_mut().zip(mirror.face.bounds) {
            set_lane(slot, lane, corner);
        }
        self.margin[lane] = mirror.margin;
    }

    /// [`super::faces::FlatFace::height`] in each lane.
    #[inline]
    fn height(&self, point: Vec3x4) -> Vec4 {
        dot([0, 1, 2].map(|k| point[k] - self.point[k]), self.normal)
    }

    /// [`Mirror::is_near`] in each lane.
    #[inline]
    fn are_near(&self, point: Vec3x4, slack: Vec4) -> BVec4A {
        let [low, high] = self.bounds;
        let outside = [0, 1, 2].map(|k| point[k] - point[k].max(low[k]).min(high[k]));
        let slack = slack + self.margin;
        dot(outside, outside).cmple(slack * slack)
    }
}
