//! Specular guiding: diffuse surfaces sample towards the mirror images of lamps in glossy planes.
//!
//! A glossy floor casts a caustic on the wall. Cosine sampling at the wall rarely hits the region
//! of the floor that reflects the lamp, and such samples are bright: they dominate the variance of
//! pictures and of parameters fitted to them. For a plane the region is known in closed form: it
//! lies towards the mirror image of the lamp. A share of the directions of a diffuse surface is
//! therefore drawn from a von Mises-Fisher lobe about that direction. The lobe is one more density
//! in the mixture that directions are drawn from, so the estimator stays unbiased [Veach and Guibas
//! 1995]. The idea is that of path guiding by vMF mixtures [Vorba et al. 2014], with the mixture
//! known instead of learned.
//!
//! Width of the lobe: when the direction is off by `epsilon`, the half vector tilts by
//! `epsilon (1 + a/b) / 2`, with `a` the distance to the plane and `b` that from there to the lamp.
//! Ward's slopes have the standard deviation `alpha / sqrt 2`, so the caustic has
//! `sqrt 2 alpha / (1 + a/b)`; the angular radius of the lamp is added in quadrature.
//!
//! Cost: each diffuse vertex of a path tests up to `PAIRS_MAX` pairs of a plane and a lamp, four at a time.

mod four_pairs;
mod vmf;

pub(crate) use four_pairs::FourPairs;
pub use vmf::VmfMixture;
pub(crate) use vmf::VmfMixture4;

use crate::appearance::{Appearance, LightSource, SourceLayout};
use crate::emitters;
use crate::surface::{Frame, Surface};
use glam::Vec3;
use std::f32::consts::PI;
use unrender_scene::color::luminance;
use unrender_scene::{LightKind, Mesh, Reach, Rgb, Scene};

/// The share of directions drawn from the lobes at the first two diffuse vertices of a path. With
/// half of it caustics are sampled half as often, with double of it rare bright paths add more noise
/// than the lobes remove.
const SHARE: f32 = 0.2;
/// The share at the vertices after them.
const SHARE_LATER: f32 = 0.1;
/// From this bounce on the share falls with the square of the bounce's number. A direction by the
/// cosine weighs `1 / (1 - share)` as much, and these weights multiply along a path: as the shares
/// have a finite sum, the product stays below 3.1 however long the path is. With half of it the light
/// of later bounces by way of a plane is noisier, with double of it the bound is 6.9.
const FALLS_FROM: u32 = 4;
/// Most pairs of a plane and a lamp in a scene: the strongest by power and reflectance. Each guided
/// vertex tests all of them; with half of them rooms of several lamps lose caustics.
const PAIRS_MAX: usize = 16;
/// Caustics narrower than this (radians) are not guided: single precision does not resolve the lobe.
const DEVIATION_MIN: f32 = 2e-3;
/// Caustics wider than this (radians) are not guided: cosine sampling finds them.
const DEVIATION_MAX: f32 = 0.5;
/// A caustic extends this many standard deviations beyond its centre; 1 % of a Gaussian in the
/// plane lies outside. With half of it caustics at the edge of a plane are missed, double of it
/// adds lobes that no light takes.
const REACH: f32 = 3.0;
/// Unit vectors with at least this cosine between them count as parallel: 0.8 degrees. With double
/// of the angle gently curved meshes count as planes.
const PARALLEL: f32 = 0.9999;

/// The planes and lamps of a scene.
#[derive(Debug, Default)]
pub(crate) struct SpecularGuide {
    planes: Vec<Plane>,
    lamps: Vec<Lamp>,
    layout: SourceLayout,
}

/// A flat object.
#[derive(Clone, Copy, Debug)]
struct Plane {
    object: u32,
    group: u32,
    point: Vec3,
    normal: Vec3,
    bounds: [Vec3; 2],
    area: f32,
}

/// The bounding sphere of an area light, or a point or spot light.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    source: LightSource,
    centre: Vec3,
    radius: f32,
    power: f32,
    /// The cone of emission.
    cone: Cone,
}

/// A cone of directions.
#[derive(Clone, Copy, Debug)]
struct Cone {
    /// Unit vector; zero for all directions.
    axis: Vec3,
    /// The cosine of its half angle.
    cos: f32,
}

impl Cone {
    /// All directions.
    const SPHERE: Self = Self { axis: Vec3::ZERO, cos: 0.0 };
}

/// A glossy plane and a lamp that it reflects.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GlossyPair {
    plane: Plane,
    alpha: f32,
    lamp: Lamp,
}

impl SpecularGuide {
    /// Finds the planes and lamps of `scene`, whose light sources have the order `layout`.
    pub(crate) fn new(scene: &Scene, layout: SourceLayout) -> Self {
        let planes = scene.objects.iter().zip(0..).filter_map(|(object, index)| {
            let mut plane = Plane::of(&object.mesh)?;
            (plane.object, plane.group) = (index, object.group as u32);
            Some(plane)
        });
        let emitting = scene.objects.iter().filter(|o| scene.groups[o.group].is_emitter());
        let area = emitting.map(|object| {
            let emission = scene.groups[object.group].emission;
            Lamp::of_area(&object.mesh, emission, LightSource::Group(object.group as u32))
        });
        let points = scene.lights.iter().zip(0..);
        let points = points
            .filter_map(|(light, index)| Lamp::at_point(&light.kind, LightSource::Punctual(index)));
        Self { planes: planes.collect(), lamps: area.chain(points).collect(), layout }
    }

    /// The strongest pairs of a glossy plane and a lamp under `appearance`, by the product of the
    /// lamp's power, the plane's area and its specular reflectance; the strongest first.
    pub(crate) fn pairs(&self, appearance: &Appearance<'_>) -> Vec<GlossyPair> {
        let glossy = |plane: &Plane| {
            let material = appearance.materials.get(plane.group as usize)?;
            // The lamps in a perfect mirror have light samples of their own (`crate::virtual_lamps`).
            if material.is_delta() {
                return None;
            }
            let alpha = (material.alpha_x * material.alpha_y).sqrt();
            Some((plane.area * luminance(material.rho_s), (*plane, alpha)))
        };
        let planes = strongest(self.planes.iter().filter_map(glossy));
        if planes.is_empty() {
            return Vec::new();
        }
        let brightness =
            |lamp: &Lamp| lamp.power * luminance(appearance.light(self.layout.index(lamp.source)));
        let lamps = strongest(self.lamps.iter().map(|lamp| (brightness(lamp), *lamp)));
        let pairs = planes.iter().flat_map(|&(reflectance, (plane, alpha))| {
            let pair = move |&(power, lamp): &(f32, Lamp)| {
                (reflectance * power, GlossyPair { plane, alpha, lamp })
            };
            lamps.iter().map(pair).filter(|(_, pair)| pair.lamp.lights(&pair.plane))
        });
        strongest(pairs).into_iter().map(|(_, pair)| pair).collect()
    }
}

/// The [`PAIRS_MAX`] strongest items of positive strength, the strongest first.
fn strongest<T>(items: impl Iterator<Item = (f32, T)>) -> Vec<(f32, T)> {
    let mut items: Vec<_> = items.filter(|(strength, _)| *strength > 0.0).collect();
    items.sort_by(|a, b| b.0.total_cmp(&a.0));
    items.truncate(PAIRS_MAX);
    items
}

impl Plane {
    /// The plane of a mesh whose triangles and shading normals are flat.
    fn of(mesh: &Mesh) -> Option<Self> {
        let cross = |i: usize| {
            let [a, b, c] = mesh.corners(i);
            (b - a).cross(c - a)
        };
        let all = 0..mesh.triangles.len();
        let largest =
            all.clone().max_by(|&i, &j| cross(i).length().total_cmp(&cross(j).length()))?;
        let (size, normal) = (cross(largest).length(), cross(largest).try_normalize()?);
        // Triangles without area have no normal, and no ray hits them.
        let flat = |i: usize| {
            let (cross, length) = (cross(i), cross(i).length());
            let along = |n: Vec3| n.dot(normal).abs() >= PARALLEL;
            let smooth = || mesh.triangles[i].iter().all(|&v| along(mesh.normals[v as usize]));
            length <= 1e-6 * size || (along(cross / length) && smooth())
        };
        let corners = || all.clone().flat_map(|i| mesh.corners(i));
        let bounds = bounds(corners());
        let point = mesh.corners(largest)[0];
        let thickness = 1e-4 * (bounds[1] - bounds[0]).length();
        let thin = |p: Vec3| (p - point).dot(normal).abs() <= thickness;
        let area = all.clone().map(|i| 0.5 * cross(i).length()).sum();
        let plane = Self { object: 0, group: 0, point, normal, bounds, area };
        (all.clone().all(flat) && corners().all(thin)).then_some(plane)
    }
}

impl Lamp {
    /// A mesh that emits `radiance`.
    fn of_area(mesh: &Mesh, radiance: Rgb, source: LightSource) -> Self {
        let (mut facing, mut area) = (Vec3::ZERO, 0.0);
        for [a, b, c] in (0..mesh.triangles.len()).map(|i| mesh.corners(i)) {
            let half = 0.5 * (b - a).cross(c - a);
            facing += half;
            area += half.length();
        }
        // A flat lamp emits to its front, others in all directions.
        let flat = facing.length() >= PARALLEL * area;
        let front = Cone { axis: facing.normalize_or_zero(), cos: 0.0 };
        let cone = if flat { front } else { Cone::SPHERE };
        let [low, high] =
            bounds(mesh.triangles.iter().flatten().map(|&v| mesh.positions[v as usize]));
        let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
        Self { source, centre, radius, power: PI * area * luminance(radiance), cone }
    }

    /// A light at a place; none for a directional one.
    fn at_point(kind: &LightKind, source: LightSource) -> Option<Self> {
        let Reach { position: centre, axis, angle_rad } = kind.reach()?;
        let is_cone = axis != Vec3::ZERO;
        let cone = if is_cone { Cone { axis, cos: angle_rad.cos() } } else { Cone::SPHERE };
        Some(Self { source, centre, radius: 0.0, power: emitters::power(kind, 0.0), cone })
    }

    /// Whether it lies off `plane` and emits towards its bounding box.
    fn lights(&self, plane: &Plane) -> bool {
        let height = (self.centre - plane.point).dot(plane.normal);
        let [low, high] = plane.bounds;
        let far = self.centre.distance(low).max(self.centre.distance(high));
        // The corner of the box farthest along the axis of the cone.
        let axis = self.cone.axis;
        let corner = Vec3::select(axis.cmpge(Vec3::ZERO), high, low);
        let towards = (corner - self.centre).dot(axis) >= 0.0;
        height.abs() > 1e-4 * far && towards
    }
}

fn bounds(points: impl Iterator<Item = Vec3>) -> [Vec3; 2] {
    let nothing = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    points.fold(nothing, |[low, high], p| [low.min(p), high.max(p)])
}

/// The share of directions drawn from the lobes at the bounce number `bounce`.
fn share(bounce: u32) -> f32 {
    match bounce {
        0..2 => SHARE,
        2..FALLS_FROM => SHARE_LATER,
        _ => SHARE_LATER * (FALLS_FROM as f32 / bounce as f32).powi(2),
    }
}

/// The mixture of lobes for `surface`, given in `frame`: those of the first `pairs` whose light can
/// arrive there. The surface is the vertex number `bounce` of its path.
pub(crate) fn mixture(
    surface: &Surface,
    frame: &Frame,
    pairs: &[FourPairs],
    bounce: u32,
) -> VmfMixture {
    let mut mixture = VmfMixture::with_share(share(bounce));
    for lobe in pairs.iter().flat_map(|four| four.lobes(surface)) {
        if !mixture.push(frame.local_from_world(lobe.direction), lobe.deviation) {
            break;
        }
    }
    mixture
}

#[cfg(test)]
mod tests;
