//! A chain of planar mirrors, and the images of a point in them.

use super::faces::FlatFace;
use glam::Vec3;

/// Most mirrors of a chain. In two facing mirrors the third image carries the cube of their
/// reflectance through a window that gets ever smaller; it is found by chance.
pub(crate) const MIRRORS_MAX: usize = 2;
/// Points closer to a mirror's plane than this share of its extent have no image: they lie on it.
/// With half of it rounding shows, with double of it what touches a mirror loses light samples.
const CLOSE: f32 = 1e-4;
/// A line meets a mirror if it meets its bounding box grown by this share of its extent. It covers
/// rounding; a ray then finds out whether the mirror is really there.
const MARGIN: f32 = 1e-3;

/// Mirrors in the order of a path towards the light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chain {
    mirrors: [Mirror; MIRRORS_MAX],
    count: usize,
    /// The product of the luminances of the reflectances.
    pub(super) reflectance: f32,
}

/// A flat face that reflects as a perfect mirror.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mirror {
    /// Its place among the faces of the scene.
    pub(super) place: u16,
    pub(super) face: FlatFace,
    /// Luminance of the specular reflectance.
    pub(super) reflectance: f32,
    /// What counts as rounding, metres.
    pub(super) margin: f32,
}

/// A point, and its images in the first mirror, in the first two, and so on.
pub(super) type Images = [Vec3; MIRRORS_MAX + 1];

/// The points at which a line of sight meets the mirrors, in the order of the path.
pub(super) type Crossings = [Vec3; MIRRORS_MAX];

impl Chain {
    /// Of one mirror.
    pub(super) fn single(mirror: Mirror) -> Self {
        Self { mirrors: [mirror; MIRRORS_MAX], count: 1, reflectance: mirror.reflectance }
    }

    /// Of two mirrors.
    pub(super) fn pair(first: Mirror, second: Mirror) -> Self {
        let reflectance = first.reflectance * second.reflectance;
        Self { mirrors: [first, second], count: 2, reflectance }
    }

    /// The mirrors.
    pub(super) fn mirrors(&self) -> &[Mirror] {
        &self.mirrors[..self.count]
    }

    /// The area of its smallest mirror, square metres.
    pub(super) fn area(&self) -> f32 {
        self.mirrors().iter().map(|mirror| mirror.face.area).fold(f32::INFINITY, f32::min)
    }

    /// The images of `origin`; none if it or an image of it lies in a mirror's plane.
    #[inline]
    pub(super) fn images(&self, origin: Vec3) -> Option<Images> {
        let mut images = [origin; MIRRORS_MAX + 1];
        for (index, mirror) in self.mirrors().iter().enumerate() {
            if mirror.is_close(images[index]) {
                return None;
            }
            images[index + 1] = mirror.image(images[index]);
        }
        Some(images)
    }

    /// The last of the images: the one that sees lamps by way of all mirrors in a straight line.
    #[inline]
    pub(super) fn last(&self, images: &Images) -> Vec3 {
        images[self.count]
    }

    /// Where the line of sight from the last image along the unit vector `direction` to something at
    /// `distance` meets the mirrors; none if it misses one, or the end lies behind one.
    pub(super) fn crossings(
        &self,
        images: &Images,
        mut direction: Vec3,
        mut distance: f32,
    ) -> Option<Crossings> {
        let mut crossings = [Vec3::ZERO; MIRRORS_MAX];
        for (index, mirror) in self.mirrors().iter().enumerate().rev() {
            let image = images[index + 1];
            let along = -mirror.face.height(image) / direction.dot(mirror.face.normal);
            let point = image + along * direction;
            if !(along > 0.0 && along < distance && mirror.is_near(point, 0.0)) {
                return None;
            }
            crossings[index] = point;
            // The image before this one is as far from the point.
            (direction, distance) = ((point - images[index]) / along, along);
        }
        Some(crossings)
    }
}

impl Mirror {
    pub(super) fn new(place: u16, face: FlatFace, reflectance: f32) -> Self {
        Self { place, face, reflectance, margin: MARGIN * face.extent() }
    }

    /// Whether `point`, which lies in its plane, is less than `slack` outside of its bounding box, but for
    /// rounding.
    #[inline]
    pub(super) fn is_near(&self, point: Vec3, slack: f32) -> bool {
        let outside = point - point.clamp(self.face.bounds[0], self.face.bounds[1]);
        let slack = slack + self.margin;
        outside.length_squared() <= slack * slack
    }

    /// The mirror image of a point.
    pub(super) fn image(&self, point: Vec3) -> Vec3 {
        point - 2.0 * self.face.height(point) * self.face.normal
    }

    /// The mirror image of a direction.
    pub(super) fn image_of_direction(&self, direction: Vec3) -> Vec3 {
        direction - 2.0 * direction.dot(self.face.normal) * self.face.normal
    }

    /// Whether a point lies in its plane.
    pub(super) fn is_close(&self, point: Vec3) -> bool {
        self.face.height(point).abs() <= CLOSE * self.face.extent()
    }
}
