//! Surfaces of two groups that overlap in one plane: rays meet the one or the other by chance, and those that start at
//! the one pass through the other, so that light is lost.
//!
//! Points of what the picture shows, and of the fronts of area lights that it could see, are looked for in the triangles
//! of all other groups. A box that stands on the floor does no harm: nothing sees its lower side.

use super::finding::{Findings, Gravity};
use super::lights::{SurfacePoint, area, is_free, spread_over};
use super::{length, some, surface_behind};
use crate::Job;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use unrender_render::accel::offset;
use unrender_render::{GeometryBuffers, NOTHING, Tracer};
use unrender_scene::{Camera, Object, Scene};

/// Points of each object that are examined: an overlap of a sixteenth of it has four on average. At half of it, two, and
/// many are missed; double of it takes twice as long.
const POINTS: usize = 64;
/// So many points of two objects have to agree: one may lie where three surfaces meet.
const AGREE: usize = 2;
/// The least cosine between normals of one plane; planes that enclose more are told apart by their distance.
const PARALLEL: f32 = 0.999;
/// Points nearer to the edge of a triangle than this share of its height belong to its neighbour, too.
const INSIDE: f32 = 1e-4;
/// Points of the picture that an area light has to be free to shine at.
const SEEN: usize = 32;
/// The distance that is proposed as a remedy, in ray offsets: both surfaces' rays start beside the other one then. At half
/// of it they may just touch; double of it is twice as visible.
const APART: f32 = 4.0;

/// A point of an object's surface.
#[derive(Clone, Copy, Debug)]
struct Sample {
    point: Vec3,
    normal: Vec3,
    object: usize,
}

impl Sample {
    /// How far rays that start here are moved off the surface: what is nearer is one with it to them.
    fn offset(&self) -> f32 {
        offset(self.point, self.normal).distance(self.point)
    }
}

/// Warnings of the surfaces that `camera` sees in the scene of `job`, or that light these.
pub(super) fn warnings(
    job: &Job,
    tracer: &Tracer,
    (camera, geometry): (&Camera, &GeometryBuffers),
) -> Findings {
    let scene = &job.scene;
    let mut samples = seen(tracer, camera, geometry);
    samples.extend(lamps(scene, tracer, &samples));
    let mut behind: BTreeMap<usize, (BTreeSet<usize>, f32)> = BTreeMap::new();
    for ([one, other], Overlap { points, offset }) in overlapping(scene, samples) {
        if points >= AGREE {
            let area = |object: usize| area(&scene.objects[object].mesh);
            let (small, large) = if area(one) <= area(other) { (one, other) } else { (other, one) };
            let of_large = behind.entry(large).or_default();
            of_large.0.insert(small);
            of_large.1 = of_large.1.max(offset);
        }
    }
    let mut found = Findings::default();
    let name = |object: &usize| scene.objects[*object].name.as_str();
    for (large, (small, offset)) in &behind {
        let names: Vec<&str> = small.iter().map(name).collect();
        let [lie, overlap, it] = match names[..] {
            [_] => ["lies", "overlaps", "it"],
            _ => ["lie", "overlap", "them"],
        };
        found.push(Gravity::Part, format!(
            "{} {lie} in the plane of \"{}\" and {overlap} it: which of them is seen and gets light is random, and light is \
             lost. Move {it} out by {} or more, or cut the other one away there",
            some(&names),
            name(large),
            length(APART * offset),
        ));
    }
    found
}

/// Points of all objects that the picture shows.
fn seen(tracer: &Tracer, camera: &Camera, geometry: &GeometryBuffers) -> Vec<Sample> {
    let (width, height) = (geometry.width(), geometry.height());
    let mut pixels: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (pixel, shown) in geometry.pixels().iter().enumerate().filter(|(_, p)| p.object != NOTHING)
    {
        pixels.entry(shown.object).or_default().push(pixel as u32);
    }
    let point = |pixel: u32| {
        let surface = surface_behind(tracer, camera, (width, height), pixel)?;
        let (point, normal) = (surface.point, surface.geometric_normal);
        Some(Sample { point, normal, object: surface.object as usize })
    };
    let sample = |pixels: &Vec<u32>| unrender_recover::observe::blocks::spread(pixels, POINTS, 0);
    pixels.values().flat_map(sample).filter_map(point).collect()
}

/// Points of the fronts of area lights from which some of the points that are `seen` are free.
fn lamps(scene: &Scene, tracer: &Tracer, seen: &[Sample]) -> Vec<Sample> {
    let step = seen.len().div_ceil(SEEN).max(1);
    let shines = |(point, front): &SurfacePoint| {
        let from = offset(*point, *front);
        seen.iter().step_by(step).any(|to| {
            let way = to.point - from;
            way.dot(*front) > 0.0 && is_free(tracer, from, offset(to.point, to.normal))
        })
    };
    let lamps = scene.objects.iter().enumerate().filter(|(_, object)| {
        scene.groups[object.group].is_emitter() && !object.mesh.triangles.is_empty()
    });
    lamps
        .flat_map(|(object, lamp)| {
            let points = spread_over(&lamp.mesh, POINTS).into_iter().filter(shines);
            points.map(move |(point, normal)| Sample { point, normal, object })
        })
        .collect()
}

/// Two objects in one plane.
#[derive(Clone, Copy, Debug, Default)]
struct Overlap {
    /// Samples of the one that lie on the other.
    points: usize,
    /// The greatest offset of rays there, metres.
    offset: f32,
}

impl Overlap {
    fn add(&mut self, other: Self) {
        self.points += other.points;
        self.offset = self.offset.max(other.offset);
    }
}

/// The pairs of objects of two groups of which `samples` of one lie on the other, the lower index first.
fn overlapping(scene: &Scene, mut samples: Vec<Sample>) -> BTreeMap<[usize; 2], Overlap> {
    samples.sort_by(|a, b| a.point.x.total_cmp(&b.point.x));
    let of_object = |(index, object): (usize, &Object)| {
        let mut found: BTreeMap<[usize; 2], Overlap> = BTreeMap::new();
        let mut met = BTreeSet::new();
        for triangle in 0..object.mesh.triangles.len() {
            let corners = object.mesh.corners(triangle);
            for number in near(&samples, &corners) {
                let sample = &samples[number];
                let is_other = scene.objects[sample.object].group != object.group;
                // A point where triangles of one mesh meet counts once.
                if is_other && lies_in(sample, &corners) && met.insert(number) {
                    let both = [index.min(sample.object), index.max(sample.object)];
                    let offset = sample.offset();
                    found.entry(both).or_default().add(Overlap { points: 1, offset });
                }
            }
        }
        found
    };
    let each: Vec<_> = scene.objects.par_iter().enumerate().map(of_object).collect();
    let mut all: BTreeMap<[usize; 2], Overlap> = BTreeMap::new();
    for (both, overlap) in each.into_iter().flatten() {
        all.entry(both).or_default().add(overlap);
    }
    all
}

/// The numbers of the samples, which are sorted by x, that may lie in a triangle.
fn near(samples: &[Sample], corners: &[Vec3; 3]) -> std::ops::Range<usize> {
    let [a, b, c] = *corners;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let reach = within(low.abs().max(high.abs()));
    let first = samples.partition_point(|sample| sample.point.x < low.x - reach);
    let last = samples.partition_point(|sample| sample.point.x <= high.x + reach);
    first..last.max(first)
}

/// More than the offset of any ray at points of these coordinates.
fn within(point: Vec3) -> f32 {
    offset(point, Vec3::ONE).distance(point)
}

/// Whether a point lies inside a triangle, as far as rays can tell.
fn lies_in(sample: &Sample, [a, b, c]: &[Vec3; 3]) -> bool {
    let (u, v, way) = (*b - *a, *c - *a, sample.point - *a);
    let across = u.cross(v);
    let Some(normal) = across.try_normalize() else { return false };
    if way.dot(normal).abs() > sample.offset() || normal.dot(sample.normal).abs() < PARALLEL {
        return false;
    }
    let area = across.length();
    let second = way.cross(v).dot(normal) / area;
    let third = u.cross(way).dot(normal) / area;
    second > INSIDE && third > INSIDE && second + third < 1.0 - INSIDE
}
