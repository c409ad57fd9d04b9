//! Clusters of lights with similar position and orientation, and an upper bound of their irradiance
//! at a point, after [Conty Estevez and Kulla 2018].
//!
//! A cluster has a bounding sphere and a bounding cone of the emission axes. Its importance at a
//! point is
//!
//! ```text
//! strength * cos(theta') / d^2,     theta' = the least angle between any axis and the point
//! ```
//!
//! and zero where `theta'` exceeds the angle within which the lights emit. There are at most
//! [`CLUSTERS_MAX`] clusters instead of a tree of them; all are evaluated, several at a time.

use super::LampSphere;
use super::pool::{CLUSTERS_MAX, Emitter};
use crate::lanes::{Vec3x4, dot, set_lane};
use glam::{Vec3, Vec4};
use std::f32::consts::PI;
use unrender_scene::color::luminance;
use unrender_scene::{LightKind, Reach};

/// Clusters of a smaller extent are not split. Positions count in radii of the scene, orientations
/// in components of the unit axis, so 0.3 is a third of the radius or about 17 degrees. Half of it
/// makes clusters whose bounds differ little, double of it joins lamps of opposite walls.
const EXTENT_MIN: f32 = 0.3;

/// Bounds of one light at a finite distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    pub(super) light: Emitter,
    /// The bounding sphere.
    pub(super) centre: Vec3,
    pub(super) radius: f32,
    /// The axis of emission, a unit vector; zero if the light emits in all directions.
    pub(super) axis: Vec3,
    /// The angle from the axis within which it emits.
    pub(super) reach_rad: f32,
    /// Luminance of the radiance times area, or of the intensity.
    pub(super) strength: f32,
}

/// Lights with common bounds.
#[derive(Clone, Debug)]
pub(super) struct LightCluster {
    pub(super) members: Vec<LightBounds>,
    centre: Vec3,
    radius: f32,
    axis: Vec3,
    /// The angle from `axis` within which the axes of the lights lie, and the largest angle from
    /// its own axis within which a light emits.
    spread_rad: f32,
    reach_rad: f32,
    pub(super) strength: f32,
    extent: Extent,
}

/// The largest extent of a cluster among the three coordinates of position and of axis.
#[derive(Clone, Copy, Debug, Default)]
struct Extent {
    /// Which of the six coordinates.
    coordinate: usize,
    size: f32,
    middle: f32,
}

impl LightBounds {
    /// The bounds of a light at a place; none for a directional one.
    pub(super) fn of_punctual(light: Emitter, kind: &LightKind) -> Option<Self> {
        let Reach { position: centre, axis, angle_rad: reach_rad } = kind.reach()?;
        let strength = luminance(kind.strength());
        Some(Self { light, centre, radius: 0.0, axis, reach_rad, strength })
    }

    /// Position, in units of `scale`, and axis as one vector.
    fn coordinates(&self, scale: f32) -> [f32; 6] {
        let (p, n) = (self.centre / scale, self.axis);
        [p.x, p.y, p.z, n.x, n.y, n.z]
    }
}

impl LightCluster {
    /// Splits `lights` into few clusters; `scale` is the scene's radius.
    pub(super) fn all(lights: Vec<LightBounds>, scale: f32) -> Vec<Self> {
        if lights.is_empty() {
            return Vec::new();
        }
        let mut clusters = vec![Self::new(lights, scale)];
        while clusters.len() < CLUSTERS_MAX {
            let value = |cluster: &Self| cluster.strength * cluster.extent.size;
            let widest = clusters
                .iter()
                .enumerate()
                .filter(|(_, cluster)| cluster.extent.size > EXTENT_MIN)
                .max_by(|a, b| value(a.1).total_cmp(&value(b.1)))
                .map(|(index, _)| index);
            let Some(index) = widest else { break };
            let (one, other) = clusters.swap_remove(index).split(scale);
            clusters.extend([one, other]);
        }
        clusters
    }

    fn new(members: Vec<LightBounds>, scale: f32) -> Self {
        let count = members.len() as f32;
        let centre = members.iter().map(|m| m.centre).sum::<Vec3>() / count;
        let radius = |m: &LightBounds| m.centre.distance(centre) + m.radius;
        let radius = members.iter().map(radius).fold(0.0, f32::max);
        let axis = members.iter().map(|m| m.axis).sum::<Vec3>().normalize_or_zero();
        let off =
            |m: &LightBounds| if m.axis == Vec3::ZERO { PI } else { axis.angle_between(m.axis) };
        let spread_rad =
            if axis == Vec3::ZERO { PI } else { members.iter().map(off).fold(0.0, f32::max) };
        let reach_rad = members.iter().map(|m| m.reach_rad).fold(0.0, f32::max);
        let strength = members.iter().map(|m| m.strength).sum();
        let extent = Extent::of(&members, scale);
        Self { members, centre, radius, axis, spread_rad, reach_rad, strength, extent }
    }

    /// Splits at the middle of the largest extent; neither part is empty if that is positive.
    fn split(self, scale: f32) -> (Self, Self) {
        let Extent { coordinate, middle, .. } = self.extent;
        let (one, other) =
            self.members.into_iter().partition(|m| m.coordinates(scale)[coordinate] <= middle);
        (Self::new(one, scale), Self::new(other, scale))
    }
}

impl Extent {
    fn of(members: &[LightBounds], scale: f32) -> Self {
        let along = |coordinate: usize| {
            let values = members.iter().map(|m| m.coordinates(scale)[coordinate]);
            let [low, high] = values.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], v| {
                [low.min(v), high.max(v)]
            });
            Self { coordinate, size: high - low, middle: 0.5 * (low + high) }
        };
        (0..6).map(along).max_by(|a, b| a.size.total_cmp(&b.size)).unwrap_or_default()
    }
}

/// The bounds of all clusters, four at a time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClusterBounds {
    fours: [Bounds4; CLUSTERS_MAX / 4],
    count: usize,
}

/// The bounds of four clusters, one per lane; a lane without a cluster has no strength.
#[derive(Clone, Copy, Debug, Default)]
struct Bounds4 {
    centre: Vec3x4,
    axis: Vec3x4,
    radius: Vec4,
    /// Cosine and sine of the half angle of the cone of axes.
    spread: [Vec4; 2],
    cos_reach: Vec4,
    strength: Vec4,
}

impl ClusterBounds {
    pub(super) fn new(clusters: &[LightCluster]) -> Self {
        let mut bounds = Self { count: clusters.len(), ..Self::default() };
        for (index, cluster) in clusters.iter().enumerate() {
            let (four, lane) = (&mut bounds.fours[index / 4], index % 4);
            set_lane(&mut four.centre, lane, cluster.centre);
            set_lane(&mut four.axis, lane, cluster.axis);
            let everywhere = cluster.spread_rad + cluster.reach_rad >= PI;
            let spread = if everywhere { PI } else { cluster.spread_rad };
            four.spread[0][lane] = if everywhere { -2.0 } else { spread.cos() };
            four.spread[1][lane] = spread.sin();
            four.cos_reach[lane] = cluster.reach_rad.cos();
            four.radius[lane] = cluster.radius;
            four.strength[lane] = cluster.strength;
        }
        bounds
    }

    /// The bounding sphere of a cluster.
    pub(super) fn sphere(&self, cluster: usize) -> LampSphere {
        let (four, lane) = (&self.fours[cluster / 4], cluster % 4);
        let [centre, axis] =
            [four.centre, four.axis].map(|all| Vec3::from_array(all.map(|x| x[lane])));
        // One axis, within rounding.
        let is_one = four.spread[0][lane] > 1.0 - 1e-5;
        LampSphere {
            centre,
            radius: four.radius[lane],
            axis: if is_one { axis } else { Vec3::ZERO },
            cos_reach: if is_one { four.cos_reach[lane] } else { -1.0 },
        }
    }

    /// The strength of a cluster; none if there are not as many.
    pub(super) fn strength(&self, cluster: usize) -> Option<f32> {
        (cluster < self.count).then(|| self.fours[cluster / 4].strength[cluster % 4])
    }

    /// The number of fours that have a cluster.
    #[inline]
    pub(super) fn fours(&self) -> usize {
        self.count.div_ceil(4)
    }

    /// The importance of each cluster of the four number `four` at `point`, W m^-2; zero only if no light of
    /// it arrives.
    #[inline]
    pub(super) fn importances(&self, four: usize, point: Vec3) -> Vec4 {
        let four = &self.fours[four];
        let from = [0, 1, 2].map(|axis| Vec4::splat(point[axis]) - four.centre[axis]);
        // Keeps the importance finite at a light: a picometre.
        let distance2 = dot(from, from).max(Vec4::splat(1e-24));
        let distance = distance2.sqrt();
        // The largest distance of the point from the sphere's centre along any of the axes: by
        // the difference of the angle to the mean axis and the half angle of the cone.
        let along = dot(from, four.axis);
        let across = (distance2 - along * along).max(Vec4::ZERO).sqrt();
        let [cos, sin] = four.spread;
        let turned = along * cos + across * sin;
        let along = Vec4::select(along.cmpge(distance * cos), distance, turned);
        // The same from any point of the sphere.
        let (before, radius) = (along + four.radius, four.radius);
        // The margin covers rounding at the edge of the cone of emission.
        let edge = (distance - radius) * four.cos_reach - 1e-4 * distance;
        let facing = before.max(1e-3 * distance).min(distance);
        let bound = four.strength * facing / (distance * distance2.max(radius * radius));
        Vec4::select(before.cmpgt(edge), bound, Vec4::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_2;

    fn lamp(index: u32, centre: Vec3, axis: Vec3) -> LightBounds {
        let light = Emitter::Triangle(index);
        LightBounds { light, centre, radius: 0.1, axis, reach_rad: FRAC_PI_2, strength: 2.0 }
    }

    #[test]
    fn lamps_at_other_places_or_with_other_axes_are_other_clusters() {
        let close = [lamp(0, Vec3::ZERO, Vec3::Y), lamp(1, 0.1 * Vec3::X, Vec3::Y)];
        assert_eq!(LightCluster::all(close.to_vec(), 1.0).len(), 1);
        let apart = [close[0], lamp(1, Vec3::X, Vec3::Y), lamp(2, Vec3::ZERO, Vec3::NEG_Y)];
        let clusters = LightCluster::all(apart.to_vec(), 1.0);
        assert_eq!(clusters.len(), 3);
        let many = (0..1000).map(|i| lamp(i, i as f32 * Vec3::X, Vec3::Y)).collect();
        let clusters = LightCluster::all(many, 1000.0);
        assert_eq!(clusters.iter().map(|c| c.members.len()).sum::<usize>(), 1000);
        assert!(clusters.len() <= CLUSTERS_MAX);
        let alike = (0..1000).map(|i| lamp(i, Vec3::ZERO, Vec3::Y)).collect();
        assert_eq!(LightCluster::all(alike, 1.0).len(), 1);
    }

    #[test]
    fn importance_is_zero_behind_a_lamp_and_falls_with_the_distance() {
        let cluster = LightCluster::new(vec![lamp(0, Vec3::ZERO, Vec3::Y)], 1.0);
        let bounds = ClusterBounds::new(&[cluster]);
        let at = |point: Vec3| bounds.importances(0, point)[0];
        assert_eq!(at(-Vec3::Y), 0.0);
        assert!((at(Vec3::Y) - 2.0).abs() < 1e-6);
        assert!((at(2.0 * Vec3::Y) - 0.5).abs() < 1e-6);
        // Beside it, above the plane of its centre and below by less than its radius.
        assert!(at(Vec3::new(1.0, 0.01, 0.0)) > 0.0);
        assert!(at(Vec3::new(1.0, -0.05, 0.0)) > 0.0);
        assert!(at(Vec3::ZERO).is_finite());
    }

    #[test]
    fn the_importance_of_a_spot_is_zero_outside_of_its_cone() {
        let kind = LightKind::Spot {
            position: Vec3::ZERO,
            direction: Vec3::NEG_Y,
            intensity: Vec3::ONE,
            inner_rad: 0.1,
            outer_rad: 0.3,
        };
        let spot = LightBounds::of_punctual(Emitter::Punctual(0), &kind);
        let spot = spot.map(|bounds| LightCluster::new(vec![bounds], 1.0));
        let bounds = ClusterBounds::new(&[spot.expect("a spot has bounds")]);
        let at = |angle: f32| bounds.importances(0, Vec3::new(angle.sin(), -angle.cos(), 0.0))[0];
        assert!(at(0.29) > 0.0 && at(0.31) == 0.0);
    }
}
