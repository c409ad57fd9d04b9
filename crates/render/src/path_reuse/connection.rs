//! Connections between reusable vertices and the receivers of a tile, four receivers at a time.

use super::receiver::{Receiver, ReceiverBsdf};
use super::reused::ReusableVertex;
use crate::accel::Bundle;
use crate::guiding::VmfMixture4;
use crate::lanes::{Vec3x4, dot, set_lane};
use crate::path::Transport;
use glam::{Vec3, Vec4};
use std::f32::consts::FRAC_1_PI;

/// The receivers of a tile as a structure of arrays.
#[derive(Default)]
pub(super) struct ReceiverSet {
    fours: Vec<Receivers4>,
    /// Their bounds, if there are any.
    bundle: Option<Bundle>,
}

/// A receiver and a reusable vertex that see each other.
pub(super) struct Connection {
    /// The place of the receiver's pixel in the tile.
    pub(super) pixel: usize,
    /// The BRDF of the receiver towards the vertex.
    pub(super) receiver: ReceiverBsdf,
    /// `cos / r^2` at the vertex, m^-2: turns densities over solid angle at the receiver into densities
    /// over area at the vertex.
    pub(super) geometry: f32,
}

impl ReceiverSet {
    /// Replaces the receivers by those of another tile.
    pub(super) fn assign(&mut self, receivers: &[Receiver]) {
        self.fours.clear();
        self.fours.extend(receivers.chunks(4).map(Receivers4::new));
        self.bundle = receivers.get(receivers.len() / 2).map(|receiver| {
            let origins = receivers.iter().map(Receiver::origin);
            Bundle::new(origins, receiver.normals()[0])
        });
    }

    /// Writes to `connections` those of `receivers`, which were assigned, to `vertex`. The receiver
    /// number `finder` found the vertex, so that nothing occludes their connection.
    pub(super) fn connect(
        &self,
        transport: &Transport<'_>,
        receivers: &[Receiver],
        (finder, vertex): (usize, &ReusableVertex),
        connections: &mut Vec<Connection>,
    ) {
        connections.clear();
        let Some(bundle) = &self.bundle else { return };
        let occluders = transport.occluders(vertex.point, bundle);
        for (at, four) in (0..).step_by(4).zip(&self.fours) {
            let mut segments = four.segments(vertex);
            while let Some(Segment { lane, wi, distance, cosine, diffuse_pdf, geometry }) =
                segments.next()
            {
                let receiver = &receivers[at + lane];
                let visible =
                    || transport.is_visible_among(&occluders, receiver.origin(), wi, distance);
                if at + lane != finder && !visible() {
                    continue;
                }
                let pixel = receiver.pixel;
                if let Some(receiver) = receiver.evaluated(wi, cosine, diffuse_pdf) {
                    connections.push(Connection { pixel, receiver, geometry });
                }
            }
        }
    }
}

/// Four receivers. Unused lanes have a normal of zero and face nothing.
struct Receivers4 {
    origin: Vec3x4,
    geometric_normal: Vec3x4,
    shading_normal: Vec3x4,
    guides: VmfMixture4,
}

/// The segments from four receivers to a vertex, those that leave both on their front sides.
struct Segments4 {
    wi: [[f32; 4]; 3],
    distance: [f32; 4],
    cosine: [f32; 4],
    diffuse_pdf: [f32; 4],
    geometry: [f32; 4],
    /// A bit for each segment that was not returned yet.
    left: u32,
}

/// The segment from one of four receivers.
struct Segment {
    lane: usize,
    /// Unit vector from the receiver to the vertex, world space.
    wi: Vec3,
    /// Metres.
    distance: f32,
    /// Between `wi` and the shading normal of the receiver.
    cosine: f32,
    /// The density over solid angle with which a diffuse receiver draws `wi`.
    diffuse_pdf: f32,
    /// [`Connection::geometry`].
    geometry: f32,
}

impl Receivers4 {
    /// Up to four receivers.
    fn new(receivers: &[Receiver]) -> Self {
        let lanes = |of: &dyn Fn(&Receiver) -> Vec3| {
            let mut lanes = [Vec4::ZERO; 3];
            for (lane, receiver) in receivers.iter().enumerate() {
                set_lane(&mut lanes, lane, of(receiver));
            }
            lanes
        };
        Self {
            origin: lanes(&Receiver::origin),
            geometric_normal: lanes(&|receiver| receiver.normals()[0]),
            shading_normal: lanes(&|receiver| receiver.normals()[1]),
            guides: VmfMixture4::new(receivers.iter().map(Receiver::guide)),
        }
    }

    /// The segments to `vertex`.
    #[inline]
    fn segments(&self, vertex: &ReusableVertex) -> Segments4 {
        let to_point: Vec3x4 = [0, 1, 2].map(|i| vertex.point[i] - self.origin[i]);
        let distance = dot(to_point, to_point).sqrt();
        let inverse = distance.recip();
        let wi = to_point.map(|coordinate| coordinate * inverse);
        let cosine = dot(wi, self.shading_normal);
        let cosine_there = -dot(wi, vertex.geometric_normal().to_array().map(Vec4::splat));
        let facing = cosine.cmpgt(Vec4::ZERO)
            & dot(wi, self.geometric_normal).cmpgt(Vec4::ZERO)
            & cosine_there.cmpgt(Vec4::ZERO);
        Segments4 {
            wi: wi.map(|coordinate| coordinate.to_array()),
            distance: distance.to_array(),
            cosine: cosine.to_array(),
            diffuse_pdf: self.guides.pdf(wi, cosine * FRAC_1_PI).to_array(),
            geometry: (cosine_there * (inverse * inverse)).to_array(),
            left: facing.bitmask(),
        }
    }
}

impl Segments4 {
    /// The next segment.
    #[inline]
    fn next(&mut self) -> Option<Segment> {
        if self.left == 0 {
            return None;
        }
        let lane = self.left.trailing_zeros() as usize % 4;
        self.left &= self.left - 1;
        let [x, y, z] = self.wi;
        Some(Segment {
            lane,
            wi: Vec3::new(x[lane], y[lane], z[lane]),
            distance: self.distance[lane],
            cosine: self.cosine[lane],
            diffuse_pdf: self.diffuse_pdf[lane],
            geometry: self.geometry[lane],
        })
    }
}
