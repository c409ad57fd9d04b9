//! Lamps: `light`, `glow`, `illum` and `spotlight` on surfaces, and sources far away.
//!
//! A `glow` gives the same light as a `light` in a program that follows all paths; one whose radius is
//! below zero is visible and gives no light. An `illum` gives light and looks like another material. A
//! `spotlight` sends light into a cone, and its brightness falls off as if from a point behind its surface.

use super::sky::{Disk, Panorama, Sky, environment};
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};
use unrender_scene::{Environment, Light, LightKind, Mesh, Object, Rgb, Warnings};

/// Sources up to this angular diameter are directional lights, degrees: the irradiance is the same, and
/// shadows from 5 degrees blur by a twelfth of the way.
const NARROW_DEG: f32 = 5.0;

/// The most spotlights; each searches all triangles.
const MAX_SPOTS: usize = 256;

/// A lamp on a surface, as its material states it.
#[derive(Clone, Debug)]
pub(super) struct Spot {
    pub(super) radiance: Rgb,
    /// The full angle of its cone, degrees.
    pub(super) angle_deg: f32,
    /// Where it points; its length is how far behind the surface the light seems to come from.
    pub(super) direction: DVec3,
}

/// A source far away, as its material states it.
#[derive(Clone, Debug)]
pub(super) struct Far {
    pub(super) radiance: Rgb,
    pub(super) sky: Option<Sky>,
    pub(super) panorama: Option<Panorama>,
    pub(super) is_glow: bool,
}

/// All lamps that are not groups.
#[derive(Default)]
pub(super) struct Lamps {
    pub(super) lights: Vec<Light>,
    disks: Vec<Disk>,
    spots: Vec<(String, Spot, Mesh)>,
}

impl Lamps {
    /// Adds a source in the direction of the first three of `reals`; the fourth is its angular diameter,
    /// degrees.
    pub(super) fn far(&mut self, id: &str, reals: [f32; 4], far: Far) -> Result<(), String> {
        let [x, y, z, angle_deg] = reals;
        let direction = Vec3::new(x, y, z).as_dvec3().try_normalize();
        let direction = direction.ok_or_else(|| format!("the source \"{id}\" has no direction"))?;
        if angle_deg <= 0.0 {
            return Err(format!("the source \"{id}\" has no size"));
        }
        if angle_deg <= NARROW_DEG {
            let brightness = far.sky.as_ref().map_or(1.0, |sky| sky.at(direction)) as f32;
            let sin = (0.5 * angle_deg).to_radians().sin();
            let shown = far.panorama.as_ref().map(|around| around.radiance(direction.as_vec3()));
            let radiance = far.radiance * shown.unwrap_or(Rgb::ONE);
            let irradiance = radiance * brightness * PI * sin * sin;
            let kind = LightKind::Directional { direction: -direction.as_vec3(), irradiance };
            self.lights.push(Light { name: id.to_owned(), kind });
            return Ok(());
        }
        let Far { radiance, sky, panorama, is_glow } = far;
        let angle_deg = f64::from(angle_deg);
        self.disks.push(Disk { direction, angle_deg, radiance, sky, panorama, is_glow });
        Ok(())
    }

    /// Adds a spotlight with the surface `mesh`.
    pub(super) fn spot(&mut self, id: &str, spot: Spot, mesh: Mesh) -> Result<(), String> {
        if self.spots.len() == MAX_SPOTS {
            return Err(format!("there are more than {MAX_SPOTS} spotlights"));
        }
        if spot.direction.try_normalize().is_none() || spot.angle_deg <= 0.0 {
            return Err(format!("the spotlight of \"{id}\" has no direction or no angle"));
        }
        self.spots.push((id.to_owned(), spot, mesh));
        Ok(())
    }

    /// The lights and the environment of a scene of `objects`.
    pub(super) fn finished(
        mut self,
        objects: &[Object],
        warnings: &mut Warnings,
    ) -> Result<(Vec<Light>, Option<Environment>), String> {
        for (id, spot, mesh) in &self.spots {
            let (kind, way) = spot_light(spot, mesh, objects);
            warnings.push(match way {
                Some(way) => format!(
                    "the spotlight \"{id}\" was taken as a spot light without a surface; it is as bright as \
                     in Radiance {way:.3} m away, where its axis meets something"
                ),
                None => format!("the spotlight \"{id}\" was taken as a spot light without a surface"),
            });
            self.lights.push(Light { name: id.clone(), kind });
        }
        Ok((self.lights, environment(&self.disks)?))
    }
}

/// The spot light for `spot` on the surface `mesh`, and the distance at which it is exactly as
/// bright.
fn spot_light(spot: &Spot, mesh: &Mesh, objects: &[Object]) -> (LightKind, Option<f64>) {
    let axis = spot.direction.normalize();
    let corner = |i: u32| mesh.positions[i as usize].as_dvec3();
    // The area projected along the axis, and the middle of the surface.
    let (mut seen, mut total, mut middle) = (0.0, 0.0, DVec3::ZERO);
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(corner);
        let area = 0.5 * (b - a).cross(c - a);
        seen += area.dot(axis).max(0.0);
        total += area.length();
        middle += (a + b + c) / 3.0 * area.length();
    }
    let middle = if total > 0.0 { middle / total } else { middle };
    let way = first_hit(middle, axis, objects);
    let behind = spot.direction.length();
    let nearer = way.map_or(1.0, |way| (way / (way + behind)).powi(2));
    let outer_rad = (0.5 * spot.angle_deg).to_radians().min(FRAC_PI_2);
    let kind = LightKind::Spot {
        position: middle.as_vec3(),
        direction: axis.as_vec3(),
        intensity: spot.radiance * (seen * nearer) as f32,
        inner_rad: 0.999 * outer_rad,
        outer_rad,
    };
    (kind, way)
}

/// The distance from `start` to the first triangle that a ray along the unit vector `axis` hits.
fn first_hit(start: DVec3, axis: DVec3, objects: &[Object]) -> Option<f64> {
    let triangles = objects.iter().flat_map(|object| {
        (0..object.mesh.triangles.len()).map(|index| object.mesh.corners(index))
    });
    let ways = triangles.filter_map(|corners| {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3() - start);
        // On the same side of all edges.
        let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|edge| edge.dot(axis));
        let is_met = sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0);
        let normal = (b - a).cross(c - a);
        let way = a.dot(normal) / axis.dot(normal);
        (is_met && way.is_finite() && way > 1e-3).then_some(way)
    });
    ways.min_by(f64::total_cmp)
}
