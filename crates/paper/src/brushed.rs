//! The anisotropy direction straight from the photograph, as the paper reads it (section 4.2.5 and its
//! Figures 4 and 5).
//!
//! The surface is rendered as a perfect mirror and subtracted from the photograph. Where a surface
//! S is mirrored, the difference smears out across the anisotropy direction and hardly along it. S is
//! the mirrored surface with the largest `Area(S) / d(S, P)`. Then directions about the normal are
//! tried: the difference is cut into lines along each, and the direction with the least average standard deviation
//! along its lines wins.
//!
//! On a plane that mirrors a room this finds the mirrored edges: the result is the same for all anisotropy directions,
//! and for a round lobe (`docs/method/paper.md`, made by the example `paper_direction`). It is the answer of
//! `--paper-direction text`; otherwise the ladder finds the direction by re-rendering.

use glam::{Vec2, Vec3};
use std::collections::BTreeMap;
use std::f32::consts::PI;
use unrender_recover::evidence::Evidence;
use unrender_render::{GeometryBuffers, Probe};
use unrender_scene::color::luminance;

/// Directions tried over half a turn: steps of 2.8 degrees, the paper's own error.
pub const DIRECTIONS: usize = 64;
/// The window about the mirrored surface is this many times its half extent.
const WINDOW: f32 = 1.5;
/// Lines with fewer pixels say nothing about a deviation.
const PIXELS_PER_LINE: usize = 5;

/// The anisotropy direction's angle from the tangent, radians in [0, pi); none if the mirror shows
/// nothing. The evidence must hold the mirror's radiance.
pub fn direction(evidence: &Evidence, geometry: &GeometryBuffers) -> Option<f32> {
    let points = difference_on_plane(evidence, geometry);
    let probes: Vec<&Probe> = evidence.light.sets[0].first().collect();
    let reference = reference_surface(&probes)?;
    let mirrors = |i: &usize| probes[*i].mirrored.is_some_and(|m| m.object == reference);
    let of_reference = (0..points.len()).filter(mirrors).map(|i| points[i].0);
    let window = Window::around(of_reference, WINDOW)?;
    let inside: Vec<(Vec2, f32)> = points.into_iter().filter(|p| window.contains(p.0)).collect();
    least(&deviations(&inside))
}

/// The pixels of the difference picture: where each lies in the surface's tangent plane, and the
/// luminance of photograph minus mirror.
fn difference_on_plane(evidence: &Evidence, geometry: &GeometryBuffers) -> Vec<(Vec2, f32)> {
    let mirror = evidence.light.mirror();
    let one = |(i, probe): (usize, &Probe)| {
        let at = geometry.pixels()[evidence.sample.pixels[i].pixel as usize];
        let front_normal = if at.front { at.normal } else { -at.normal };
        let bitangent = front_normal.cross(at.tangent);
        let shown = 0.5 * (mirror[0][i] + mirror[1][i]);
        let position = Vec2::new(probe.point.dot(at.tangent), probe.point.dot(bitangent));
        (position, luminance(evidence.sample.pixels[i].radiance - shown))
    };
    evidence.light.sets[0].first().enumerate().map(one).collect()
}

/// The mirrored object with the largest `Area(S) / d(S, P)`.
pub fn reference_surface(probes: &[&Probe]) -> Option<u32> {
    let own_centre = probes.iter().map(|p| p.point).sum::<Vec3>() / probes.len().max(1) as f32;
    let mut seen: BTreeMap<u32, (f32, Vec3)> = BTreeMap::new();
    for mirrored in probes.iter().filter_map(|p| p.mirrored) {
        let entry = seen.entry(mirrored.object).or_insert((0.0, Vec3::ZERO));
        entry.0 += 1.0;
        entry.1 += mirrored.point;
    }
    let merit = |&(area, sum): &(f32, Vec3)| area / (sum / area).distance(own_centre).max(1e-6);
    seen.into_iter().max_by(|a, b| merit(&a.1).total_cmp(&merit(&b.1))).map(|best| best.0)
}

/// An upright rectangle of the plane.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    centre: Vec2,
    half_extent: Vec2,
}

impl Window {
    /// The one around `points`, `scale` times as wide and high; none without points.
    pub fn around(points: impl Iterator<Item = Vec2>, scale: f32) -> Option<Self> {
        let corners = points.fold(None, |corners: Option<(Vec2, Vec2)>, point| {
            let (low, high) = corners.unwrap_or((point, point));
            Some((low.min(point), high.max(point)))
        });
        let (low, high) = corners?;
        let half_extent = (0.5 * scale * (high - low)).max(Vec2::splat(1e-6));
        Some(Self { centre: 0.5 * (low + high), half_extent })
    }

    /// Whether it has `position` in it.
    pub fn contains(&self, position: Vec2) -> bool {
        (position - self.centre).abs().cmple(self.half_extent).all()
    }
}

/// For each of [`DIRECTIONS`], the mean over all lines along it of the standard deviation of the values
/// on them; infinite where no line has enough points.
pub fn deviations(points: &[(Vec2, f32)]) -> Vec<f32> {
    let window = Window::around(points.iter().map(|point| point.0), 1.0);
    let size = window.map_or(0.0, |window| 2.0 * window.half_extent.length());
    let width = (size / (points.len() as f32).sqrt().max(1.0)).max(f32::MIN_POSITIVE);
    (0..DIRECTIONS).map(|i| mean_deviation(points, angle(i), width)).collect()
}

/// The direction of the least of these deviations, radians from the tangent.
pub fn least(deviations: &[f32]) -> Option<f32> {
    let finite = deviations.iter().enumerate().filter(|(_, deviation)| deviation.is_finite());
    finite.min_by(|a, b| a.1.total_cmp(b.1)).map(|(i, _)| angle(i))
}

/// The direction number `index`, radians from the tangent.
pub fn angle(index: usize) -> f32 {
    PI * index as f32 / DIRECTIONS as f32
}

fn mean_deviation(points: &[(Vec2, f32)], theta: f32, width: f32) -> f32 {
    let across = Vec2::new(-theta.sin(), theta.cos());
    let mut sums: BTreeMap<i32, (f32, f32, usize)> = BTreeMap::new();
    for (position, value) in points {
        let line = (position.dot(across) / width).floor() as i32;
        let entry = sums.entry(line).or_default();
        entry.0 += value;
        entry.1 += value * value;
        entry.2 += 1;
    }
    let full: Vec<_> = sums.values().filter(|s| s.2 >= PIXELS_PER_LINE).collect();
    let count: usize = full.iter().map(|s| s.2).sum();
    let deviation = |&&(sum, squares, n): &&(f32, f32, usize)| {
        let mean = sum / n as f32;
        (squares / n as f32 - mean * mean).max(0.0).sqrt() * n as f32
    };
    let sum = full.iter().map(deviation).sum::<f32>();
    if count > 0 { sum / count as f32 } else { f32::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_recover::Sheet;
    use unrender_recover::evidence::{Gathered, Light};
    use unrender_recover::observe::blocks::{Blocks, Grid};
    use unrender_recover::observe::model_error::{Allowance, LightError, LightField, ModelError};
    use unrender_recover::observe::observation::{Noise, Reading};
    use unrender_recover::observe::sample::{Observed, Sample};
    use unrender_render::Probes;
    use unrender_render::geometry::PixelGeometry;
    use unrender_render::probe::Mirrored;
    use unrender_scene::{BrdfModel, Image, Material, Rgb};

    const SIDE: usize = 60;

    /// A plane on which the photograph differs from the mirror by waves along `theta`.
    fn waves(theta: f32) -> (Evidence, GeometryBuffers) {
        let across = Vec2::new(-theta.sin(), theta.cos());
        let position = |i: usize| Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) / SIDE as f32;
        let probe = |i: usize| Probe {
            pixel: i as u32,
            group: 0,
            throughput: Rgb::ONE,
            wo: Vec3::Z,
            point: position(i).extend(0.0),
            emitted: Rgb::ZERO,
            diffuse: Rgb::ZERO,
            straight: Rgb::ZERO,
            mirror: Rgb::splat(0.5),
            mirrored: Some(Mirrored { object: 1, point: Vec3::Z }),
            first: 0,
            count: 0,
        };
        let observed = |i: usize| Observed {
            pixel: i as u32,
            radiance: Rgb::splat(0.5 + 0.3 * (9.0 * position(i).dot(across)).sin()),
            reading: Reading::Value,
            noise: Noise::NONE,
            variance: Rgb::ZERO,
            level: Rgb::ONE,
            weight: Rgb::ONE,
        };
        let all = 0..SIDE * SIDE;
        let probes = all.clone().map(probe).collect();
        let numbers: Vec<u32> = all.clone().map(|i| i as u32).collect();
        let blocks = Blocks::of(&numbers, &Grid::even(&Sheet::of(&[(SIDE, SIDE)]), 3));
        let set = Gathered::new(BrdfModel::default(), Probes { probes, incident: Vec::new() });
        let light = LightError { share: 0.01 };
        let evidence = Evidence {
            sample: Sample {
                pixels: all.map(observed).collect(),
                field: LightField::constant(blocks.len(), light),
                blocks,
            },
            light: Light { model: BrdfModel::default(), sets: [set.clone(), set] },
            allowance: Allowance { light, floor: ModelError { share: 0.003 } },
            least_noise: None,
            expected: Default::default(),
            plain: Material::diffuse(Rgb::ZERO),
        };
        let facing = PixelGeometry { normal: Vec3::Z, tangent: Vec3::X, ..PixelGeometry::EMPTY };
        (evidence, Image::new(SIDE, SIDE, vec![facing; SIDE * SIDE]))
    }

    #[test]
    fn the_difference_varies_least_along_the_brushed_direction() {
        for degrees in [0.0f32, 37.0, 90.0, 141.0] {
            let (evidence, geometry) = waves(degrees.to_radians());
            let found = direction(&evidence, &geometry).unwrap().to_degrees();
            let off = (found - degrees + 90.0).rem_euclid(180.0) - 90.0;
            assert!(off.abs() <= 3.0, "{degrees} came out as {found}");
        }
    }
}
