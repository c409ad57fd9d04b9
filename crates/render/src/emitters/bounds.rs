//! Lights that are near each other and shine the same way, drawn by what they may bring to a point.
//!
//! A cluster has a ball around its lights and a cone around their axes. What it may bring is bounded
//! by `strength cos_out / d^2`, with the least angle that any of its lights may shine at the point
//! under; where that is more than they shine at all it brings nothing [after Conty Estevez and Kulla,
//! "Importance Sampling of Many Lights with Adaptive Tree Splitting", HPG 2018]. There are a few
//! clusters and no tree of them: all are asked.

use glam::Vec3;
use std::f32::consts::PI;
use unrender_scene::LightKind;
use unrender_scene::color::luminance;

/// Clusters at most. What stands before a point is not known, so more would not be much better.
pub(super) const CLUSTERS_MAX: usize = 16;
/// Clusters that extend less than this are not split: in units of the scene, and of unit normals.
const EXTENT_MIN: f32 = 0.3;

/// A light with a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beacon {
    /// Its index among all emitting triangles and lights.
    pub(super) index: usize,
    pub(super) centre: Vec3,
    /// No point of it is further from the centre.
    pub(super) radius: f32,
    /// Where it shines, a unit vector; zero if to all sides.
    pub(super) axis: Vec3,
    /// The angle from the axis within which it shines.
    pub(super) reach_rad: f32,
    /// Radiance times area, or intensity; the luminance.
    pub(super) strength: f32,
}

/// Some lights that are drawn together.
#[derive(Clone, Debug)]
pub(super) struct Cluster {
    pub(super) members: Vec<Beacon>,
    centre: Vec3,
    radius: f32,
    axis: Vec3,
    /// The angle from `axis` within which the axes of its lights lie, and how far those shine beyond.
    spread_rad: f32,
    reach_rad: f32,
    pub(super) strength: f32,
    /// The coordinate in which the lights differ most, by how much, and the middle.
    extent: (usize, f32, f32),
}

impl Beacon {
    /// A light without a surface, if it stands somewhere.
    pub(super) fn at_point(index: usize, kind: &LightKind) -> Option<Self> {
        let (centre, intensity, axis, reach_rad) = match *kind {
            LightKind::Point { position, intensity } => (position, intensity, Vec3::ZERO, PI),
            LightKind::Spot { position, direction, intensity, outer_rad, .. } => {
                (position, intensity, direction, outer_rad)
            }
            LightKind::Directional { .. } => return None,
        };
        let strength = luminance(intensity);
        Some(Self { index, centre, radius: 0.0, axis, reach_rad, strength })
    }

    /// The place and the axis as one vector, with places in units of `scale`.
    fn place(&self, scale: f32) -> [f32; 6] {
        let (p, n) = (self.centre / scale, self.axis);
        [p.x, p.y, p.z, n.x, n.y, n.z]
    }
}

impl Cluster {
    /// All of `beacons` in few clusters; `scale` is the scene's radius.
    pub(super) fn all(beacons: Vec<Beacon>, scale: f32) -> Vec<Self> {
        if beacons.is_empty() {
            return Vec::new();
        }
        let mut clusters = vec![Self::new(beacons, scale)];
        while clusters.len() < CLUSTERS_MAX {
            let value = |cluster: &Self| cluster.strength * cluster.extent.1;
            let widest = clusters
                .iter()
                .enumerate()
                .filter(|(_, cluster)| cluster.extent.1 > EXTENT_MIN)
                .max_by(|a, b| value(a.1).total_cmp(&value(b.1)))
                .map(|(index, _)| index);
            let Some(index) = widest else { break };
            let (one, other) = clusters.swap_remove(index).split(scale);
            clusters.extend([one, other]);
        }
        clusters
    }

    fn new(members: Vec<Beacon>, scale: f32) -> Self {
        let count = members.len() as f32;
        let centre = members.iter().map(|m| m.centre).sum::<Vec3>() / count;
        let radius = |m: &Beacon| m.centre.distance(centre) + m.radius;
        let radius = members.iter().map(radius).fold(0.0, f32::max);
        let axis = members.iter().map(|m| m.axis).sum::<Vec3>().normalize_or_zero();
        let off = |m: &Beacon| if m.axis == Vec3::ZERO { PI } else { axis.angle_between(m.axis) };
        let spread_rad =
            if axis == Vec3::ZERO { PI } else { members.iter().map(off).fold(0.0, f32::max) };
        let reach_rad = members.iter().map(|m| m.reach_rad).fold(0.0, f32::max);
        let strength = members.iter().map(|m| m.strength).sum();
        let extent = extent(&members, scale);
        Self { members, centre, radius, axis, spread_rad, reach_rad, strength, extent }
    }

    /// The lights before the middle and those after it; neither is empty if they extend at all.
    fn split(self, scale: f32) -> (Self, Self) {
        let (axis, _, middle) = self.extent;
        let (one, other) =
            self.members.into_iter().partition(|member| member.place(scale)[axis] <= middle);
        (Self::new(one, scale), Self::new(other, scale))
    }
}

/// The coordinate in which lights differ most, by how much, and the middle.
fn extent(members: &[Beacon], scale: f32) -> (usize, f32, f32) {
    let along = |axis: usize| {
        let values = members.iter().map(|m| m.place(scale)[axis]);
        let (low, high) = values
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        (axis, high - low, 0.5 * (low + high))
    };
    (0..6).map(along).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0, 0.0))
}

/// The bounds of all clusters, side by side, so that several are worked out at a time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bounds {
    centre: [Lanes; 3],
    axis: [Lanes; 3],
    radius: Lanes,
    /// Cosine and sine of the angle that the axes spread to.
    spread: [Lanes; 2],
    cos_reach: Lanes,
    strength: Lanes,
}

/// A number for each cluster.
pub(super) type Lanes = [f32; CLUSTERS_MAX];

impl Bounds {
    pub(super) fn new(clusters: &[Cluster]) -> Self {
        let mut bounds = Self::default();
        for (lane, cluster) in clusters.iter().enumerate() {
            for (axis, all) in bounds.centre.iter_mut().enumerate() {
                all[lane] = cluster.centre[axis];
            }
            for (axis, all) in bounds.axis.iter_mut().enumerate() {
                all[lane] = cluster.axis[axis];
            }
            let to_all_sides = cluster.spread_rad + cluster.reach_rad >= PI;
            let spread = if to_all_sides { PI } else { cluster.spread_rad };
            bounds.spread[0][lane] = if to_all_sides { -2.0 } else { spread.cos() };
            bounds.spread[1][lane] = spread.sin();
            bounds.cos_reach[lane] = cluster.reach_rad.cos();
            bounds.radius[lane] = cluster.radius;
            bounds.strength[lane] = cluster.strength;
        }
        bounds
    }

    /// What each cluster may bring to `point`, W m^-2, by bounds; zero only if it brings nothing.
    #[inline]
    pub(super) fn importances(&self, point: Vec3) -> Lanes {
        let mut importances = [0.0; CLUSTERS_MAX];
        for (lane, importance) in importances.iter_mut().enumerate() {
            let x = point.x - self.centre[0][lane];
            let y = point.y - self.centre[1][lane];
            let z = point.z - self.centre[2][lane];
            // As for points at a light: what it brings stays finite.
            let distance2 = (x * x + y * y + z * z).max(1e-12);
            let distance = distance2.sqrt();
            // How far before the ball's centre the point lies along any of the axes, at most: with
            // the angle between it and the mean axis made smaller by the spread.
            let along = x * self.axis[0][lane] + y * self.axis[1][lane] + z * self.axis[2][lane];
            let across = (distance2 - along * along).max(0.0).sqrt();
            let [cos, sin] = [self.spread[0][lane], self.spread[1][lane]];
            let turned = along * cos + across * sin;
            let along = if along >= distance * cos { distance } else { turned };
            // Before any point of the ball.
            let (before, radius) = (along + self.radius[lane], self.radius[lane]);
            // Rounding may put the edge to either side.
            let edge = (distance - radius) * self.cos_reach[lane] - 1e-4 * distance;
            let share = (before / distance).clamp(1e-3, 1.0);
            let bound = self.strength[lane] * share / distance2.max(radius * radius);
            *importance = if before > edge { bound } else { 0.0 };
        }
        importances
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_2;

    fn lamp(index: usize, centre: Vec3, axis: Vec3) -> Beacon {
        Beacon { index, centre, radius: 0.1, axis, reach_rad: FRAC_PI_2, strength: 2.0 }
    }

    #[test]
    fn lamps_far_apart_or_turned_apart_are_clusters_of_their_own() {
        let close = [lamp(0, Vec3::ZERO, Vec3::Y), lamp(1, 0.1 * Vec3::X, Vec3::Y)];
        assert_eq!(Cluster::all(close.to_vec(), 1.0).len(), 1);
        let apart = [close[0], lamp(1, Vec3::X, Vec3::Y), lamp(2, Vec3::ZERO, Vec3::NEG_Y)];
        let clusters = Cluster::all(apart.to_vec(), 1.0);
        assert_eq!(clusters.len(), 3);
        let many = (0..1000).map(|i| lamp(i, i as f32 * Vec3::X, Vec3::Y)).collect();
        let clusters = Cluster::all(many, 1000.0);
        assert_eq!(clusters.iter().map(|c| c.members.len()).sum::<usize>(), 1000);
        assert!(clusters.len() <= CLUSTERS_MAX);
        let alike = (0..1000).map(|i| lamp(i, Vec3::ZERO, Vec3::Y)).collect();
        assert_eq!(Cluster::all(alike, 1.0).len(), 1);
    }

    #[test]
    fn nothing_comes_from_behind_and_more_from_near() {
        let cluster = Cluster::new(vec![lamp(0, Vec3::ZERO, Vec3::Y)], 1.0);
        let bounds = Bounds::new(&[cluster]);
        let at = |point: Vec3| bounds.importances(point)[0];
        assert_eq!(at(-Vec3::Y), 0.0);
        assert!((at(Vec3::Y) - 2.0).abs() < 1e-6);
        assert!((at(2.0 * Vec3::Y) - 0.5).abs() < 1e-6);
        // Beside it, above the plane of its centre and below by less than its radius.
        assert!(at(Vec3::new(1.0, 0.01, 0.0)) > 0.0);
        assert!(at(Vec3::new(1.0, -0.05, 0.0)) > 0.0);
        assert!(at(Vec3::ZERO).is_finite());
    }

    #[test]
    fn spots_bring_nothing_beyond_their_cone() {
        let kind = LightKind::Spot {
            position: Vec3::ZERO,
            direction: Vec3::NEG_Y,
            intensity: Vec3::ONE,
            inner_rad: 0.1,
            outer_rad: 0.3,
        };
        let spot = Beacon::at_point(0, &kind).map(|beacon| Cluster::new(vec![beacon], 1.0));
        let bounds = Bounds::new(&[spot.expect("it stands somewhere")]);
        let at = |angle: f32| bounds.importances(Vec3::new(angle.sin(), -angle.cos(), 0.0))[0];
        assert!(at(0.29) > 0.0 && at(0.31) == 0.0);
    }
}
