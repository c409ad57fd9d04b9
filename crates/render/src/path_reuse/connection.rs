//! The first surfaces of a square as viewers of one point, four side by side.

use super::first::{First, View};
use super::second::Second;
use crate::accel::Bundle;
use crate::caustic::Images4;
use crate::lanes::{Vec3x4, dot, put};
use crate::path::Transport;
use glam::{Vec3, Vec4};
use std::f32::consts::FRAC_1_PI;

/// All first surfaces of a square.
#[derive(Default)]
pub(super) struct Viewers {
    fours: Vec<Four>,
    /// The box around them, if there are any.
    bundle: Option<Bundle>,
}

/// A first surface and a second one that see each other.
pub(super) struct Link {
    /// The pixel that looks at the first.
    pub(super) pixel: usize,
    pub(super) view: View,
    /// What brings densities over solid angle at the first to area at the second, m^-2.
    pub(super) geometry: f32,
}

impl Viewers {
    /// Takes in the first surfaces of another square.
    pub(super) fn gather(&mut self, firsts: &[First]) {
        self.fours.clear();
        self.fours.extend(firsts.chunks(4).map(Four::new));
        self.bundle = firsts.get(firsts.len() / 2).map(|first| {
            let origins = firsts.iter().map(First::origin);
            Bundle::new(origins, first.normals()[0])
        });
    }

    /// Those of `firsts`, which were gathered, that see `second`, into `links`. The one number
    /// `finder` found it.
    pub(super) fn links(
        &self,
        transport: &Transport<'_>,
        firsts: &[First],
        (finder, second): (usize, &Second),
        links: &mut Vec<Link>,
    ) {
        links.clear();
        let Some(bundle) = &self.bundle else { return };
        let between = transport.between(second.point, bundle);
        for (at, four) in (0..).step_by(4).zip(&self.fours) {
            let mut sight = four.sight(second);
            while let Some(seen) = sight.next() {
                let first = &firsts[at + seen.lane];
                let distance = seen.distance;
                let free = || transport.is_free_among(&between, first.origin(), seen.wi, distance);
                if at + seen.lane != finder && !free() {
                    continue;
                }
                if let Some(view) = first.view(seen.wi, seen.cosine, seen.diffuse_pdf) {
                    links.push(Link { pixel: first.pixel, view, geometry: seen.geometry });
                }
            }
        }
    }
}

/// Four first surfaces. Lanes beyond the last have no normal and see nothing.
struct Four {
    origin: Vec3x4,
    geometric_normal: Vec3x4,
    shading_normal: Vec3x4,
    images: Images4,
}

/// What four first surfaces see of a point that they turn their fronts to, and it to them, if nothing
/// stands between.
struct Sight {
    wi: [[f32; 4]; 3],
    distance: [f32; 4],
    cosine: [f32; 4],
    diffuse_pdf: [f32; 4],
    geometry: [f32; 4],
    /// A bit for each that has not been asked for yet.
    left: u32,
}

/// What one of four first surfaces sees.
struct Seen {
    lane: usize,
    /// Unit vector to the point, in the world.
    wi: Vec3,
    /// Metres.
    distance: f32,
    /// Of `wi` to the shading normal.
    cosine: f32,
    /// The density over solid angle with which the surface looks there if it has no lobe.
    diffuse_pdf: f32,
    /// What brings densities over solid angle here to area at the point, m^-2.
    geometry: f32,
}

impl Four {
    /// Of up to four first surfaces.
    fn new(firsts: &[First]) -> Self {
        let lanes = |of: &dyn Fn(&First) -> Vec3| {
            let mut lanes = [Vec4::ZERO; 3];
            for (lane, first) in firsts.iter().enumerate() {
                put(&mut lanes, lane, of(first));
            }
            lanes
        };
        Self {
            origin: lanes(&First::origin),
            geometric_normal: lanes(&|first| first.normals()[0]),
            shading_normal: lanes(&|first| first.normals()[1]),
            images: Images4::new(firsts.iter().map(First::images)),
        }
    }

    /// How they see the place of `second`.
    #[inline]
    fn sight(&self, second: &Second) -> Sight {
        let to_point: Vec3x4 = [0, 1, 2].map(|i| second.point[i] - self.origin[i]);
        let distance = dot(to_point, to_point).sqrt();
        let inverse = distance.recip();
        let wi = to_point.map(|coordinate| coordinate * inverse);
        let cosine = dot(wi, self.shading_normal);
        let [geometric_normal, shading_normal] =
            second.normals().map(|normal| normal.to_array().map(Vec4::splat));
        let cosine_there = -dot(wi, geometric_normal);
        let faced = cosine.cmpgt(Vec4::ZERO)
            & dot(wi, self.geometric_normal).cmpgt(Vec4::ZERO)
            & cosine_there.cmpgt(Vec4::ZERO)
            & dot(wi, shading_normal).cmplt(Vec4::ZERO);
        Sight {
            wi: wi.map(|coordinate| coordinate.to_array()),
            distance: distance.to_array(),
            cosine: cosine.to_array(),
            diffuse_pdf: self.images.pdf(wi, cosine * FRAC_1_PI).to_array(),
            geometry: (cosine_there * (inverse * inverse)).to_array(),
            left: faced.bitmask(),
        }
    }
}

impl Sight {
    /// One of those that face the point.
    #[inline]
    fn next(&mut self) -> Option<Seen> {
        if self.left == 0 {
            return None;
        }
        let lane = self.left.trailing_zeros() as usize % 4;
        self.left &= self.left - 1;
        let [x, y, z] = self.wi;
        Some(Seen {
            lane,
            wi: Vec3::new(x[lane], y[lane], z[lane]),
            distance: self.distance[lane],
            cosine: self.cosine[lane],
            diffuse_pdf: self.diffuse_pdf[lane],
            geometry: self.geometry[lane],
        })
    }
}
