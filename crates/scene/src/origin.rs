//! Scenes far from the origin of their file: where to put their own origin.
//!
//! Positions are single precision. Two kilometres from zero they lie in steps of 0.1 mm, and a room there comes out
//! too bright; at the coordinates of a land register the steps are half a metre. So the positions of such a scene are
//! relative to a point in its middle, [`Scene::origin`], which is kept in double precision.

use crate::{Mesh, Scene};
use glam::{DVec3, Vec3};

/// A scene is far from zero if its middle is farther from it than so many times the extent of half of its surfaces. At
/// twice of it a room of 5 m counts from zero up to 250 m, where positions have steps of 15 um instead of 0.2; at half
/// of it, a lamp on a mast of 50 m is a scene of its own.
const FAR: f64 = 32.0;

/// The most triangles that are sampled. With half or double of it the same scenes are far.
const SAMPLES: usize = 4096;

/// The coordinate `here`, relative to `origin`, in the world: the shortest decimal that is read back as `here`. A
/// number that a file has in no more digits than are kept is written as it was there.
///
/// ```
/// use unrender_scene::origin::in_digits;
///
/// let here = (5_400_000.7_f64 - 5.4e6) as f32;
/// assert_eq!(in_digits(5.4e6, here), 5_400_000.7);
/// assert_eq!(in_digits(0.0, 0.7), 0.7);
/// ```
pub fn in_digits(origin: f64, here: f32) -> f64 {
    let exact = origin + f64::from(here);
    let short = if origin == 0.0 {
        here.to_string().parse().ok().filter(|short: &f64| *short as f32 == here)
    } else {
        let short = (0..16).filter_map(|digits| format!("{exact:.digits$}").parse::<f64>().ok());
        short.into_iter().find(|world| (world - origin) as f32 == here)
    };
    short.unwrap_or(exact)
}

impl Scene {
    /// The point `world` of the scene's file as a position of the scene.
    ///
    /// ```
    /// use glam::{DVec3, Vec3};
    /// use unrender_scene::Scene;
    ///
    /// let scene = Scene { origin: DVec3::new(5e5, 0.0, 0.0), ..Scene::default() };
    /// let here = scene.here(DVec3::new(500_001.25, 1.0, 2.0));
    /// assert_eq!(here, Vec3::new(1.25, 1.0, 2.0));
    /// assert_eq!(scene.in_world(here), DVec3::new(500_001.25, 1.0, 2.0));
    /// ```
    pub fn here(&self, world: DVec3) -> Vec3 {
        (world - self.origin).as_vec3()
    }

    /// The position `here` in the world of the scene's file.
    pub fn in_world(&self, here: Vec3) -> DVec3 {
        self.origin + here.as_dvec3()
    }

    /// The position `here` in the world of the scene's file, for people.
    pub fn shown(&self, here: Vec3) -> String {
        let axes = [0, 1, 2].map(|axis| in_digits(self.origin[axis], here[axis]).to_string());
        format!("[{}]", axes.join(", "))
    }

    /// A better origin of the scene's positions, relative to the present one; zero if the scene is near enough. It has
    /// few digits, as it is shown to people.
    ///
    /// The scene need not be valid. Surfaces count by their area, so that a cube that was forgotten at zero does
    /// not hide that everything else is elsewhere.
    pub fn far_origin(&self) -> DVec3 {
        let corners = self.samples();
        if corners.is_empty() || corners.iter().any(|(corner, _)| !corner.is_finite()) {
            return DVec3::ZERO;
        }
        let quartiles = [0, 1, 2].map(|axis| quartiles(&corners, axis));
        let spread = DVec3::from_array(quartiles.map(|[low, _, high]| high - low)).length();
        let step = if spread > 0.0 { 10f64.powi(spread.log10().floor() as i32) } else { 1.0 };
        let middle = DVec3::from_array(quartiles.map(|[_, middle, _]| middle));
        if middle.abs().max_element() > FAR * spread {
            (middle / step).round() * step
        } else {
            DVec3::ZERO
        }
    }

    /// Corners of triangles from all over the scene, and the areas of these.
    fn samples(&self) -> Vec<(DVec3, f64)> {
        let each = self.triangle_count().div_ceil(SAMPLES).max(1);
        let triangles = self.objects.iter().flat_map(|object| {
            object.mesh.triangles.iter().map(|triangle| (&object.mesh, triangle))
        });
        let corners = |(mesh, triangle): (&Mesh, &[u32; 3])| {
            let [a, b, c] = triangle.map(|i| Some(mesh.positions.get(i as usize)?.as_dvec3()));
            Some([a?, b?, c?])
        };
        let with_area = |[a, b, c]: [DVec3; 3]| {
            let area = (b - a).cross(c - a).length();
            [a, b, c].map(|corner| (corner, area))
        };
        let triangles = triangles.step_by(each).filter_map(corners);
        let samples: Vec<_> = triangles.flat_map(with_area).collect();
        // Far out, all areas may be rounded to zero.
        if samples.iter().any(|(_, area)| *area > 0.0) {
            return samples;
        }
        samples.into_iter().map(|(corner, _)| (corner, 1.0)).collect()
    }
}

/// The quartiles of the samples' positions along `axis`, weighted by area.
fn quartiles(samples: &[(DVec3, f64)], axis: usize) -> [f64; 3] {
    let mut along: Vec<(f64, f64)> = samples.iter().map(|(p, area)| (p[axis], *area)).collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = along.iter().map(|(_, area)| area).sum();
    [0.25, 0.5, 0.75].map(|share| {
        let mut passed = 0.0;
        let reaches = |(_, area): &&(f64, f64)| {
            passed += area;
            passed >= share * total
        };
        along.iter().find(reaches).or(along.last()).map_or(0.0, |(at, _)| *at)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Object;

    /// A scene with balls of these radii there.
    fn balls(balls: &[(Vec3, f32)]) -> Scene {
        let object = |&(centre, radius): &(Vec3, f32)| Object {
            name: "ball".into(),
            group: 0,
            mesh: Mesh::sphere(centre, radius),
        };
        Scene { objects: balls.iter().map(object).collect(), ..Scene::default() }
    }

    #[test]
    fn coordinates_far_away_are_written_as_they_were_read() {
        for world in [5_400_001.25, 499_998.7, 5_400_000.0, 499_999.999_9, 500_003.123_4] {
            let origin = if world > 1e6 { 5.4e6 } else { 5e5 };
            let here = (world - origin) as f32;
            assert_eq!(in_digits(origin, here), world);
            assert_eq!(in_digits(-origin, -here), -world);
        }
        // Nearer than this to their own zero, f64 has no more digits either: a nanometre.
        let mut here = 0.02f32;
        while here < 1e5 {
            let world = in_digits(5.4e6, here);
            assert_eq!((world - 5.4e6) as f32, here, "{world}");
            here *= 1.37;
        }
        assert!((in_digits(5.4e6, 1e-5) - 5_400_000.000_01).abs() < 1e-9);
        assert_eq!(in_digits(0.0, 0.07).to_string(), "0.07");
    }

    #[test]
    fn near_scenes_stay_and_far_ones_count_from_round_numbers_in_their_midst() {
        for near in [Vec3::ZERO, Vec3::new(40.0, -30.0, 10.0)] {
            assert_eq!(balls(&[(near, 2.0)]).far_origin(), DVec3::ZERO, "{near}");
        }
        for far in [Vec3::new(1e3, 1.0, -2e4), Vec3::new(5e5, 3.0, 5.4e6), Vec3::new(0.0, 2e5, 0.0)]
        {
            let origin = balls(&[(far, 2.0)]).far_origin();
            assert!(origin.distance(far.as_dvec3()) < 5.0, "{origin} for {far}");
            assert_eq!(origin, origin.round());
        }
        // As small as it is near, in units other than metres.
        let origin = balls(&[(Vec3::X, 1e-3)]).far_origin();
        assert!((origin - DVec3::X).length() < 2e-3, "{origin}");
    }

    #[test]
    fn what_was_forgotten_at_zero_hides_nothing() {
        let room = Vec3::new(5e5, 0.0, 5.4e6);
        let origin = balls(&[(room, 3.0), (Vec3::ZERO, 1.0)]).far_origin();
        assert!(origin.distance(room.as_dvec3()) < 6.0, "{origin}");
        let origin = balls(&[(Vec3::ZERO, 3.0), (room, 1.0)]).far_origin();
        assert_eq!(origin, DVec3::ZERO);
    }

    #[test]
    fn what_is_no_scene_is_not_far() {
        assert_eq!(Scene::default().far_origin(), DVec3::ZERO);
        let mut broken = balls(&[(Vec3::splat(1e6), 1.0)]);
        broken.objects[0].mesh.triangles = vec![[0, 1, 99_999]];
        assert_eq!(broken.far_origin(), DVec3::ZERO);
        let infinite = balls(&[(Vec3::splat(f32::INFINITY), 1.0)]);
        assert_eq!(infinite.far_origin(), DVec3::ZERO);
    }
}
