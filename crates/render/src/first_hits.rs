//! First hits: what the camera sees first, for compositing programs.
//!
//! Reflectance, normal and the shares of groups are means over the samples of the picture, by the same rays, so that they
//! have its edges. Means of places are places of nothing: position and depth are those of one surface, behind the pixel's
//! centre. Glass is looked through, by the way that most of the light takes; mirrors are surfaces like others, unlike in
//! [`crate::features`].

use crate::accel::Ray;
use crate::appearance::Appearance;
use crate::features::FeatureRays;
use crate::film::Accumulator;
use crate::path::{LocalBsdf, RayHit};
use crate::settings::Settings;
use crate::surface::Surface;
use crate::tracer::Tracer;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use unrender_scene::{Camera, Image, Rgb, RgbImage};

/// Groups of a pixel that are told apart. With half of them the fourth group at a corner is missing, with double of them
/// all pixels take 48 bytes more for corners of more than six groups.
pub const GROUPS: usize = 6;
/// The depth of a pixel without a surface, metres: the one that Blender writes. With half or double of it programs that look
/// for this number find no background.
pub const NO_DEPTH: f32 = 1e10;

/// The shares of groups in a pixel: group and share, the largest first, zeros behind.
pub type GroupShares = [(u32, f32); GROUPS];

/// The first surfaces of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct FirstHits {
    /// Diffuse and specular reflectance together, times what glass before it lets through; a mean over each pixel, to which
    /// rays without a surface add zero.
    pub albedo: RgbImage,
    /// Shading normal on the viewer's side, world space: a mean of unit vectors, to which rays without a surface add zero.
    pub normal: Image<Vec3>,
    /// The surface behind the pixel's centre, in coordinates of the scene, metres; none where there is none.
    pub position: Image<Option<Vec3>>,
    /// Its distance along the camera's line of sight, metres, or [`NO_DEPTH`].
    pub depth: Image<f32>,
    /// The groups in each pixel.
    pub groups: Image<GroupShares>,
}

/// The first surfaces in one pixel.
struct PixelHits {
    albedo: Rgb,
    normal: Vec3,
    position: Option<Vec3>,
    groups: GroupShares,
}

impl Tracer {
    /// The first surfaces of the samples in `accumulator`, which are the first ones of each pixel that
    /// [`Tracer::accumulate_layers`] adds with the same `camera` and `settings`; `settings.spp` has no effect. One ray a
    /// sample, and one a pixel.
    pub fn first_hits<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        settings: &Settings,
        accumulator: &Accumulator,
    ) -> FirstHits {
        let (width, height) = accumulator.size();
        let rays = FeatureRays::new(self, appearance.into(), camera, settings, (width, height));
        let counts = accumulator.image().pixels().par_iter();
        let hits = counts.enumerate().map(|(pixel, samples)| rays.first_hits(pixel, samples.count));
        let hits = Image::new(width, height, hits.collect::<Vec<PixelHits>>());
        let axis = camera.world_from_camera.matrix3.z_axis.into();
        let depth = |hit: &PixelHits| {
            hit.position.map_or(NO_DEPTH, |point| (camera.origin() - point).dot(axis))
        };
        FirstHits {
            albedo: hits.map(|hit| hit.albedo),
            normal: hits.map(|hit| hit.normal),
            position: hits.map(|hit| hit.position),
            depth: hits.map(depth),
            groups: hits.map(|hit| hit.groups),
        }
    }
}

impl FeatureRays<'_> {
    /// The first surfaces of the first `count` samples of a pixel.
    fn first_hits(&self, pixel: usize, count: u32) -> PixelHits {
        let (mut albedo, mut normal) = (DVec3::ZERO, DVec3::ZERO);
        let mut counts: Vec<(u32, u32)> = Vec::new();
        for ray in self.of(pixel, count) {
            let RayHit { surface, way, .. } = self.transport.follow(&ray, || 1.0);
            let Some(surface) = surface else { continue };
            let LocalBsdf { bsdf, frame } = self.transport.bsdf(&surface);
            albedo += (way.passage.filter * (bsdf.rho_d + bsdf.rho_s)).as_dvec3();
            normal += frame.normal.as_dvec3();
            match counts.iter_mut().find(|(group, _)| *group == surface.group) {
                Some((_, count)) => *count += 1,
                None => counts.push((surface.group, 1)),
            }
        }
        let n = f64::from(count.max(1));
        let position = self.behind_centre(pixel).map(|surface| surface.point);
        let groups = shares(counts, n);
        PixelHits {
            albedo: (albedo / n).as_vec3(),
            normal: (normal / n).as_vec3(),
            position,
            groups,
        }
    }

    /// The surface behind the centre of a pixel.
    fn behind_centre(&self, pixel: usize) -> Option<Surface> {
        let Self { transport, camera, size: (width, height), .. } = self;
        let (x, y) = ((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
        let direction = camera.direction(x, y, *width, *height);
        transport.shown(&Ray::new(camera.start(direction), direction))
    }
}

/// The shares of `counts` in `all`, the largest first; of equal ones the group that comes first in the scene.
fn shares(mut counts: Vec<(u32, u32)>, all: f64) -> GroupShares {
    counts.sort_by_key(|&(group, count)| (std::cmp::Reverse(count), group));
    let mut shares = GroupShares::default();
    let of = |(group, count): (u32, u32)| (group, (f64::from(count) / all) as f32);
    shares.iter_mut().zip(counts).for_each(|(share, count)| *share = of(count));
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_share_comes_first() {
        let found = shares(vec![(7, 2), (3, 5), (1, 2), (4, 1)], 10.0);
        assert_eq!(found[..4], [(3, 0.5), (1, 0.2), (7, 0.2), (4, 0.1)]);
        assert_eq!(found[4..], [(0, 0.0); 2]);
        let many = shares((0..9).map(|group| (group, group + 1)).collect(), 45.0);
        assert!(many.is_sorted_by(|a, b| a.1 > b.1) && many[0].0 == 8);
    }
}
