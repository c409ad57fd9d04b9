//! Where a diffuse surface should look for the light that a shiny plane throws at it.
//!
//! A floor with a gloss throws a patch of light at the wall. Directions drawn by the cosine find the
//! few square metres of floor where lamp and wall see each other in it once in a hundred times, and
//! then it is bright: most of the noise of a picture, and of all that is fitted to it. For a plane
//! the place is known: it lies towards the lamp's mirror image. A share of the directions of a
//! diffuse surface is drawn about that, by a spherical Gaussian as wide as the gloss and the lamp
//! make the patch. It is one more strategy in the mixture that directions are drawn from, so it
//! biases nothing.
//!
//! The directions that are left to the cosine weigh more, at surface after surface; so the share is
//! small, and only the first surfaces of a path look for images. Every pair of a plane and a lamp is
//! asked at each of them; so only the strongest pairs are.
//!
//! Width: with the half vector tilted by `epsilon (1 + a/b) / 2` when the direction is off by
//! `epsilon` (`a` from here to the plane, `b` on to the lamp) and Ward's slopes of the deviation
//! `alpha/sqrt 2`, the patch has the deviation `sqrt 2 alpha / (1 + a/b)`, and the lamp's own.

use crate::emitters;
use crate::surface::{Frame, Surface};
use crate::tracer::Appearance;
use glam::Vec3;
use std::f32::consts::{PI, SQRT_2, TAU};
use unrender_scene::color::luminance;
use unrender_scene::{LightKind, Mesh, Rgb, Scene};

/// The share of the directions that is drawn towards mirror images at a path's first diffuse
/// surface, the second and so on; those after look for none. The other directions weigh
/// `1/(1 - share)` as much, at every surface of a path anew: large shares make rare bright paths.
const SHARES: [f32; 4] = [0.2, 0.2, 0.1, 0.1];
/// Only the first so many surfaces of a path look for images.
pub(crate) const BOUNCES: u32 = SHARES.len() as u32;
/// Pairs of a plane and a lamp that a picture looks for at most: the strongest.
const PAIRS_MAX: usize = 16;
/// Mirror images that one surface looks for at most: the strongest that it may see.
const IMAGES_MAX: usize = 4;
/// Patches narrower than this (radians) are left to chance, as are those of a mirror and a point.
const DEVIATION_MIN: f32 = 2e-3;
/// Wider ones are found by the cosine well enough.
const DEVIATION_MAX: f32 = 0.5;
/// Where the Gaussian is below `exp(-DEPTH_MAX)` of its peak, 3e-8, it counts as nothing.
const DEPTH_MAX: f32 = 17.3;
/// A patch reaches this many deviations beyond its centre.
const REACH: f32 = 3.0;
/// Vectors whose angle has at least this cosine are taken for parallel.
const PARALLEL: f32 = 0.9999;

/// The planes and lamps of a scene.
#[derive(Debug, Default)]
pub(crate) struct Caustics {
    planes: Vec<Plane>,
    lamps: Vec<Lamp>,
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

/// An area light as a ball, or a light at a point. Directional lights are not among them.
#[derive(Clone, Copy, Debug)]
struct Lamp {
    source: u32,
    centre: Vec3,
    radius: f32,
    power: f32,
    /// The axis of the cone that it shines into, and the cosine of the cone's half angle.
    cone: (Vec3, f32),
}

/// A plane that shines under one appearance, and a lamp that it may throw about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shiny {
    plane: Plane,
    alpha: f32,
    lamp: Lamp,
}

/// One spherical Gaussian on the sphere of directions (von Mises-Fisher):
/// `pdf = kappa exp(kappa (cos - 1)) / (2 pi (1 - exp(-2 kappa)))`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Image {
    axis: Vec3,
    kappa: f32,
    norm: f32,
}

/// The mirror images that one surface looks for: nothing, or a few Gaussians of equal weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Images {
    images: [Image; IMAGES_MAX],
    count: usize,
    /// The share of directions to draw towards them, if there are any.
    share: f32,
}

impl Caustics {
    pub(crate) fn new(scene: &Scene) -> Self {
        let planes = scene.objects.iter().zip(0..).filter_map(|(object, index)| {
            let mut plane = Plane::of(&object.mesh)?;
            (plane.object, plane.group) = (index, object.group as u32);
            Some(plane)
        });
        let emitting = scene.objects.iter().filter(|o| scene.groups[o.group].is_emitter());
        let area = emitting.map(|object| {
            let emission = scene.groups[object.group].emission;
            Lamp::of_area(&object.mesh, emission, object.group as u32)
        });
        let sources = scene.groups.len() as u32..;
        let points = scene.lights.iter().zip(sources);
        let points = points.filter_map(|(light, source)| Lamp::at_point(&light.kind, source));
        Self { planes: planes.collect(), lamps: area.chain(points).collect() }
    }

    /// What shines under `appearance`: the strongest pairs of a plane and a lamp, by the power of
    /// the lamp, and the plane's area and reflectance.
    pub(crate) fn shiny(&self, appearance: &Appearance<'_>) -> Vec<Shiny> {
        let shines = |plane: &Plane| {
            let material = appearance.materials.get(plane.group as usize)?;
            let alpha = (material.alpha_x * material.alpha_y).sqrt();
            Some((plane.area * luminance(material.rho_s), (*plane, alpha)))
        };
        let planes = strongest(self.planes.iter().filter_map(shines));
        if planes.is_empty() {
            return Vec::new();
        }
        let brightness = |lamp: &Lamp| lamp.power * luminance(appearance.light(lamp.source));
        let lamps = strongest(self.lamps.iter().map(|lamp| (brightness(lamp), *lamp)));
        let pairs = planes.iter().flat_map(|&(reflectance, (plane, alpha))| {
            let pair = move |&(power, lamp): &(f32, Lamp)| {
                (reflectance * power, Shiny { plane, alpha, lamp })
            };
            lamps.iter().map(pair).filter(|(_, pair)| pair.lamp.lights(&pair.plane))
        });
        strongest(pairs).into_iter().map(|(_, pair)| pair).collect()
    }
}

/// Those of a positive strength, the strongest first, and not too many.
fn strongest<T>(items: impl Iterator<Item = (f32, T)>) -> Vec<(f32, T)> {
    let mut items: Vec<_> = items.filter(|(strength, _)| *strength > 0.0).collect();
    items.sort_by(|a, b| b.0.total_cmp(&a.0));
    items.truncate(PAIRS_MAX);
    items
}

impl Plane {
    /// The plane of a mesh that is flat, and shaded so.
    fn of(mesh: &Mesh) -> Option<Self> {
        let cross = |i: usize| {
            let [a, b, c] = mesh.corners(i);
            (b - a).cross(c - a)
        };
        let all = 0..mesh.triangles.len();
        let largest =
            all.clone().max_by(|&i, &j| cross(i).length().total_cmp(&cross(j).length()))?;
        let (size, normal) = (cross(largest).length(), cross(largest).try_normalize()?);
        // Triangles without an area have no normal, and no ray meets them.
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
    /// A group's mesh that emits `radiance`.
    fn of_area(mesh: &Mesh, radiance: Rgb, source: u32) -> Self {
        let (mut facing, mut area) = (Vec3::ZERO, 0.0);
        for [a, b, c] in (0..mesh.triangles.len()).map(|i| mesh.corners(i)) {
            let half = 0.5 * (b - a).cross(c - a);
            facing += half;
            area += half.length();
        }
        // A flat lamp shines to its front, others may shine everywhere.
        let flat = facing.length() >= PARALLEL * area;
        let cone = if flat { (facing.normalize_or_zero(), 0.0) } else { (Vec3::ZERO, 0.0) };
        let [low, high] =
            bounds(mesh.triangles.iter().flatten().map(|&v| mesh.positions[v as usize]));
        let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low).length());
        Self { source, centre, radius, power: PI * area * luminance(radiance), cone }
    }

    /// A light without a surface that stands somewhere.
    fn at_point(kind: &LightKind, source: u32) -> Option<Self> {
        let (centre, cone) = match *kind {
            LightKind::Point { position, .. } => (position, (Vec3::ZERO, 0.0)),
            LightKind::Spot { position, direction, outer_rad, .. } => {
                (position, (direction, outer_rad.cos()))
            }
            LightKind::Directional { .. } => return None,
        };
        Some(Self { source, centre, radius: 0.0, power: emitters::power(kind, 0.0), cone })
    }

    /// Whether it shines towards `point`, by its centre.
    fn shines_at(&self, point: Vec3) -> bool {
        let (axis, cos) = self.cone;
        let to_point = point - self.centre;
        to_point.dot(axis) >= cos * to_point.length()
    }

    /// Whether it stands before or behind `plane` and can shine at its box.
    fn lights(&self, plane: &Plane) -> bool {
        let height = (self.centre - plane.point).dot(plane.normal);
        let [low, high] = plane.bounds;
        let far = self.centre.distance(low).max(self.centre.distance(high));
        // The corner of the box that is furthest along the axis of the cone.
        let axis = self.cone.0;
        let corner = Vec3::select(axis.cmpge(Vec3::ZERO), high, low);
        let before = (corner - self.centre).dot(axis) >= 0.0;
        height.abs() > 1e-4 * far && before
    }
}

fn bounds(points: impl Iterator<Item = Vec3>) -> [Vec3; 2] {
    let nothing = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    points.fold(nothing, |[low, high], p| [low.min(p), high.max(p)])
}

impl Shiny {
    /// The direction to the lamp's mirror image in the plane and the deviation of the patch about
    /// it, radians; none if no light can come to `surface` that way.
    fn image(&self, surface: &Surface) -> Option<(Vec3, f32)> {
        let Plane { object, point, normal, bounds, .. } = self.plane;
        let here = (surface.point - point).dot(normal);
        let there = (self.lamp.centre - point).dot(normal);
        // Both on one side, and neither in the plane.
        if surface.object == object || here * there <= 0.0 || here.abs() < 1e-4 * there.abs() {
            return None;
        }
        let to_image = self.lamp.centre - 2.0 * there * normal - surface.point;
        let distance = to_image.length();
        let direction = to_image / distance;
        if !surface.is_above(direction) {
            return None;
        }
        let share = here / (here + there);
        let of_gloss = SQRT_2 * self.alpha * (1.0 - share);
        let of_lamp = 0.5 * self.lamp.radius / distance;
        let deviation = of_gloss.hypot(of_lamp);
        if !(DEVIATION_MIN..DEVIATION_MAX).contains(&deviation) {
            return None;
        }
        let met = surface.point + share * to_image;
        let outside = met - met.clamp(bounds[0], bounds[1]);
        let reach = REACH * deviation * share * distance;
        let useful = outside.length() <= reach && self.lamp.shines_at(met);
        useful.then_some((direction, deviation))
    }
}

impl Image {
    fn new(axis: Vec3, deviation: f32) -> Self {
        let kappa = 1.0 / (deviation * deviation);
        Self { axis, kappa, norm: kappa / (TAU * (1.0 - (-2.0 * kappa).exp())) }
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        // 1 - cos from the difference of the vectors, which keeps its digits near the axis.
        let depth = 0.5 * self.kappa * (wi - self.axis).length_squared();
        if depth > DEPTH_MAX { 0.0 } else { self.norm * (-depth).exp() }
    }

    fn sample(&self, u: [f32; 2]) -> Vec3 {
        let below = (-2.0 * self.kappa).exp();
        // 1 - cos theta, distributed as exp(-kappa (1 - cos)).
        let versine = -(1.0 - u[0] * (1.0 - below)).ln() / self.kappa;
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        let (y, x) = (TAU * u[1]).sin_cos();
        let (tangent, bitangent) = self.axis.any_orthonormal_pair();
        self.axis * (1.0 - versine) + (tangent * x + bitangent * y) * sin
    }
}

impl Images {
    /// No mirror image anywhere.
    pub const NONE: Self = Self {
        images: [Image { axis: Vec3::Z, kappa: 0.0, norm: 0.0 }; IMAGES_MAX],
        count: 0,
        share: SHARES[0],
    };

    /// Gaussians about the first few of the `axes`, each with its standard deviation in radians
    /// (within reason) on the sphere's tangent plane, all of equal weight.
    pub fn towards(axes: &[(Vec3, f32)]) -> Self {
        let mut images = Self::NONE;
        for (axis, deviation) in axes {
            if let Some(axis) = axis.try_normalize() {
                images.push(axis, deviation.clamp(DEVIATION_MIN, DEVIATION_MAX));
            }
        }
        images
    }

    /// The mirror images that light may reach `surface` from, in `frame`; it is the surface of the
    /// reflection number `bounce`, less than [`BOUNCES`].
    pub(crate) fn seen_from(
        surface: &Surface,
        frame: &Frame,
        shiny: &[Shiny],
        bounce: u32,
    ) -> Self {
        let mut images = Self { share: SHARES[bounce as usize], ..Self::NONE };
        for (direction, deviation) in shiny.iter().filter_map(|pair| pair.image(surface)) {
            images.push(frame.local_from_world(direction), deviation);
            if images.count == IMAGES_MAX {
                break;
            }
        }
        images
    }

    fn push(&mut self, axis: Vec3, deviation: f32) {
        if let Some(image) = self.images.get_mut(self.count) {
            *image = Image::new(axis, deviation);
            self.count += 1;
        }
    }

    /// The share of directions to draw towards images.
    pub(crate) fn share(&self) -> f32 {
        if self.count == 0 { 0.0 } else { self.share }
    }

    fn all(&self) -> &[Image] {
        &self.images[..self.count]
    }

    /// The density of [`Images::sample`] over solid angle; zero without images.
    pub(crate) fn pdf(&self, wi: Vec3) -> f32 {
        let sum: f32 = self.all().iter().map(|image| image.pdf(wi)).sum();
        sum / self.count.max(1) as f32
    }

    /// Draws a direction; `pick` in [0, 1) chooses the image, of which there is at least one. It may
    /// fall below the surface.
    pub(crate) fn sample(&self, pick: f32, u: [f32; 2]) -> Vec3 {
        let image = ((pick * self.count as f32) as usize).min(self.count.saturating_sub(1));
        self.images[image].sample(u).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_scene::{Group, Light, Material, Object};

    const UP: [Vec3; 2] = [Vec3::Z, Vec3::X];
    const DOWN: [Vec3; 2] = [Vec3::X, Vec3::Z];

    fn quad(centre: Vec3, [x, y]: [Vec3; 2]) -> Mesh {
        let corners = [centre - x - y, centre + x - y, centre + x + y, centre - x + y];
        Mesh::flat(&corners, &[], &[[0, 1, 2], [0, 2, 3]])
    }

    fn merged(meshes: impl IntoIterator<Item = Mesh>) -> Mesh {
        meshes.into_iter().fold(Mesh::default(), |mut all, mesh| {
            let first = all.positions.len() as u32;
            all.positions.extend(mesh.positions);
            all.normals.extend(mesh.normals);
            all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
            all
        })
    }

    /// The faces of a box around the origin.
    fn cuboid(half: Vec3) -> Mesh {
        let face = |i: usize| {
            let axis = |j: usize| Vec3::AXES[j % 3] * half[j % 3];
            let (x, y, z) = (axis(i + 1), axis(i + 2), axis(i));
            [quad(z, [x, y]), quad(-z, [y, x])]
        };
        merged((0..3).flat_map(face))
    }

    /// Every mesh an object of a group of its own, shiny or emitting as told.
    fn scene(parts: Vec<(Mesh, f32, f32)>) -> Scene {
        let mut scene = Scene::default();
        for (group, (mesh, rho_s, emission)) in parts.into_iter().enumerate() {
            let material = Material::isotropic(Rgb::splat(0.1), Rgb::splat(rho_s), 0.1);
            let (name, emission) = (String::new(), Rgb::splat(emission));
            scene.groups.push(Group { name: name.clone(), material, emission });
            scene.objects.push(Object { name, group, mesh });
        }
        scene
    }

    fn shiny(scene: &Scene) -> Vec<Shiny> {
        Caustics::new(scene).shiny(&(&scene.materials()).into())
    }

    #[test]
    fn what_is_flat_is_a_plane_and_nothing_else() {
        let floor = || quad(Vec3::ZERO, UP);
        let mut double_sided = floor();
        double_sided.triangles.extend([[2, 1, 0], [5, 4, 3]]);
        // Its first triangle has no area, and flat normals for that point anywhere.
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, 2.0 * Vec3::X];
        let with_a_needle = Mesh::flat(&corners, &[], &[[0, 1, 3], [0, 1, 2]]);
        let unused = Mesh { triangles: Vec::new(), ..quad(7.0 * Vec3::Y, DOWN) };
        for (name, mesh) in [
            ("quad", floor()),
            ("turned", quad(Vec3::splat(7.0), [Vec3::new(1.0, 0.2, 0.3), Vec3::Y])),
            ("two quads", merged([floor(), quad(4.0 * Vec3::X, UP)])),
            ("double sided", double_sided),
            ("needle", with_a_needle),
            ("unused corners", merged([floor(), unused])),
        ] {
            let plane = Plane::of(&mesh).unwrap_or_else(|| panic!("{name} is a plane"));
            assert!((plane.normal.length() - 1.0).abs() < 1e-6, "{name}");
        }
        assert!((Plane::of(&floor()).map_or(0.0, |plane| plane.area) - 4.0).abs() < 1e-6);

        let mut bent = floor();
        bent.positions[2].y += 0.05;
        let mut smooth = floor();
        smooth.normals[0] = Vec3::new(0.3, 1.0, 0.0).normalize();
        let ball = {
            let mut mesh = cuboid(Vec3::ONE);
            mesh.normals = mesh.positions.iter().map(|p| p.normalize()).collect();
            mesh.positions.clone_from(&mesh.normals);
            mesh
        };
        for (name, mesh) in [
            ("bent", bent),
            ("shaded as if bent", smooth),
            ("ball", ball),
            ("box", cuboid(Vec3::ONE)),
            ("thin box", cuboid(Vec3::new(1.0, 1e-3, 1.0))),
            ("two floors", merged([floor(), quad(0.01 * Vec3::Y, UP)])),
            ("no triangles", Mesh::default()),
            ("no area", without_area()),
        ] {
            assert!(Plane::of(&mesh).is_none(), "{name} is no plane");
        }
    }

    fn without_area() -> Mesh {
        Mesh::flat(&[Vec3::ONE; 3], &[], &[[0, 1, 2]])
    }

    #[test]
    fn pairs_are_planes_that_shine_with_lamps_that_shine_at_them() {
        let floor = |rho_s| (quad(Vec3::ZERO, UP), rho_s, 0.0);
        let lamp = |height: f32, facing| (quad(height * Vec3::Y, facing), 0.0, 5.0);
        for (count, parts) in [
            (1, vec![floor(0.5), lamp(1.0, DOWN)]),
            (2, vec![floor(0.5), lamp(1.0, DOWN), lamp(-1.0, UP)]),
            // Dull, facing away, in the plane, dark, without an area.
            (0, vec![floor(0.0), lamp(1.0, DOWN)]),
            (0, vec![floor(0.5), lamp(1.0, UP)]),
            (0, vec![floor(0.5), lamp(0.0, UP)]),
            (0, vec![floor(0.5), (quad(Vec3::Y, DOWN), 0.0, 0.0)]),
            (0, vec![floor(0.5), (without_area(), 0.0, 5.0)]),
            (0, vec![floor(0.5), (Mesh::default(), 0.0, 5.0)]),
            // A lamp that shines itself is no image of its own, but shows others.
            (0, vec![(quad(Vec3::ZERO, UP), 0.5, 5.0)]),
            (1, vec![(quad(Vec3::ZERO, UP), 0.5, 5.0), lamp(1.0, DOWN)]),
        ] {
            assert_eq!(shiny(&scene(parts)).len(), count);
        }
    }

    #[test]
    fn lights_at_a_point_are_lamps_and_spots_shine_where_they_point() {
        let (position, intensity) = (Vec3::Y, Rgb::ONE);
        let spot = |direction| LightKind::Spot {
            position,
            direction,
            intensity,
            inner_rad: 0.1,
            outer_rad: 0.5,
        };
        for (count, kind) in [
            (1, LightKind::Point { position, intensity }),
            (0, LightKind::Point { position, intensity: Rgb::ZERO }),
            (1, spot(Vec3::NEG_Y)),
            (0, spot(Vec3::Y)),
            (0, LightKind::Directional { direction: Vec3::NEG_Y, irradiance: intensity }),
        ] {
            let mut scene = scene(vec![(quad(Vec3::ZERO, UP), 0.5, 0.0)]);
            scene.lights.push(Light { name: String::new(), kind });
            assert_eq!(shiny(&scene).len(), count, "{kind:?}");
        }
    }

    #[test]
    fn of_many_pairs_the_strongest_are_kept_and_lamps_that_are_off_are_none() {
        let mut parts = Vec::new();
        for i in 0..40 {
            let aside = 5.0 * i as f32 * Vec3::X;
            parts.push((quad(aside, UP), 0.02 * i as f32, 0.0));
            parts.push((quad(aside + Vec3::Y, DOWN), 0.0, (i + 1) as f32));
        }
        let scene = scene(parts);
        let pairs = shiny(&scene);
        assert_eq!(pairs.len(), PAIRS_MAX);
        assert_eq!((pairs[0].plane.group, pairs[0].lamp.source), (78, 79));
        let materials = scene.materials();
        let lights = vec![Rgb::ZERO; scene.groups.len()];
        let appearance = Appearance { materials: &materials, lights: &lights };
        assert!(Caustics::new(&scene).shiny(&appearance).is_empty());
    }

    /// A point of a wall that looks along +z.
    fn wall(point: Vec3) -> Surface {
        let frame = Frame::new(Vec3::Z, Vec3::X, true);
        let (geometric_normal, uv) = (Vec3::Z, glam::Vec2::ZERO);
        let (triangle, object, group, front) = (0, 9, 9, true);
        Surface { point, triangle, object, group, front, geometric_normal, frame, uv }
    }

    #[test]
    fn images_lie_where_the_mirror_shows_the_lamp() {
        let lamp = (quad(Vec3::Y, [0.1 * Vec3::X, 0.1 * Vec3::Z]), 0.0, 5.0);
        let pairs = shiny(&scene(vec![(quad(Vec3::ZERO, UP), 0.5, 0.0), lamp]));
        let at = |point: Vec3| pairs[0].image(&wall(point));
        let (direction, deviation) = at(Vec3::new(0.0, 1.0, -0.9)).expect("the floor shows it");
        assert!((direction - Vec3::new(0.0, -2.0, 0.9).normalize()).length() < 1e-6);
        // sqrt 2 alpha / 2, and a little for the lamp.
        assert!(deviation > 0.0707 && deviation < 0.09, "{deviation}");
        // Below the floor, on it, too far for it, and with the back to it.
        assert_eq!(at(Vec3::new(0.0, -1.0, -0.9)), None);
        assert_eq!(at(Vec3::new(0.0, 0.0, -0.9)), None);
        assert_eq!(at(Vec3::new(0.0, 1.0, -9.0)), None);
        assert_eq!(at(Vec3::new(0.0, 1.0, 0.9)), None);
        // No number that is none comes out of numbers that are.
        for odd in [f32::NAN, f32::INFINITY, f32::MAX, 1e30, f32::MIN_POSITIVE] {
            for point in Vec3::AXES.map(|axis| odd * axis - 0.9 * Vec3::Z) {
                let image = at(point);
                assert!(image.is_none_or(|(d, s)| d.is_finite() && s.is_finite()), "{image:?}");
            }
        }
    }

    #[test]
    fn there_is_room_for_a_few_images_only() {
        let axes = [(Vec3::Z, 0.1); 9];
        assert_eq!(Images::towards(&axes).count, IMAGES_MAX);
        assert_eq!(Images::towards(&[(Vec3::ZERO, 0.1), (Vec3::NAN, 0.1)]), Images::NONE);
        assert_eq!(Images::towards(&[]).share(), 0.0);
    }
}
