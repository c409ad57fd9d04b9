//! Surfaces of two groups that overlap in one plane: rays meet the one or the other by chance, and those that start at
//! the one pass through the other, so that light is lost.
//!
//! The renderer moves the smaller one in front where that is clear. Else points of what the picture shows, and of the fronts of area lights that it could see, are looked for in the triangles
//! of all other groups. A box that stands on the floor does no harm: nothing sees its lower side.

use super::finding::{Findings, Gravity};
use super::lights::{SurfacePoint, area, is_free, spread_over};
use super::{length, some, surface_behind};
use crate::Job;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use unrender_render::accel::clearance;
use unrender_render::coplanar::{APART, InFront};
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

/// A point of an object's surface.
#[derive(Clone, Copy, Debug)]
struct Sample {
    at: SurfacePoint,
    object: usize,
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
    for ([one, other], Overlap { points, clearance }) in overlapping(scene, samples) {
        if points >= AGREE {
            let area = |object: usize| area(&scene.objects[object].mesh);
            let (small, large) = if area(one) <= area(other) { (one, other) } else { (other, one) };
            let of_large = behind.entry(large).or_default();
            of_large.0.insert(small);
            of_large.1 = of_large.1.max(clearance);
        }
    }
    let mut found = Findings::default();
    for (large, (small, clearance)) in &behind {
        let (lie, it) = lie_in_the_plane(scene, *large, small);
        found.push(Gravity::Part, format!(
            "{lie}: which of them is seen and gets light is random, and light is lost. Move {it} out by {} or more, or cut \
             the other one away there",
            length(APART * clearance),
        ));
    }
    found.extend(in_front(scene, tracer, geometry));
    found
}

/// What the picture shows, or what lights it, in front of another surface in whose plane it lies.
fn in_front(scene: &Scene, tracer: &Tracer, geometry: &GeometryBuffers) -> Findings {
    let shown: BTreeSet<usize> = geometry.pixels().iter().map(|p| p.object as usize).collect();
    let mut before: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    let counts = |object: &usize| {
        shown.contains(object) || scene.groups[scene.objects[*object].group].is_emitter()
    };
    for InFront { object, of } in tracer.in_front().iter().filter(|it| counts(&it.object)) {
        before.entry(*of).or_default().insert(*object);
    }
    let mut found = Findings::default();
    for (large, small) in &before {
        let (lie, _) = lie_in_the_plane(scene, *large, small);
        found.push(Gravity::Note, format!("{lie}: the smaller is taken to lie in front"));
    }
    found
}

/// That objects lie in the plane of a larger one, and the word for them.
fn lie_in_the_plane(
    scene: &Scene,
    large: usize,
    small: &BTreeSet<usize>,
) -> (String, &'static str) {
    let name = |object: &usize| scene.objects[*object].name.as_str();
    let names: Vec<&str> = small.iter().map(name).collect();
    let [lie, overlap, it] = match names[..] {
        [_] => ["lies", "overlaps", "it"],
        _ => ["lie", "overlap", "them"],
    };
    let large = name(&large);
    (format!("{} {lie} in the plane of \"{large}\" and {overlap} it", some(&names)), it)
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
        Some(Sample { object: surface.object as usize, at: surface.into() })
    };
    let sample = |pixels: &Vec<u32>| unrender_recover::observe::blocks::spread(pixels, POINTS, 0);
    pixels.values().flat_map(sample).filter_map(point).collect()
}

/// Points of the fronts of area lights from which some of the points that are `seen` are free.
fn lamps(scene: &Scene, tracer: &Tracer, seen: &[Sample]) -> Vec<Sample> {
    let step = seen.len().div_ceil(SEEN).max(1);
    let shines = |from: &SurfacePoint| {
        seen.iter().step_by(step).any(|to| {
            let way = to.at.point - from.point;
            way.dot(from.normal) > 0.0 && is_free(tracer, from.start(), to.at.start())
        })
    };
    let lamps = scene.objects.iter().enumerate().filter(|(_, object)| {
        scene.groups[object.group].is_emitter() && !object.mesh.triangles.is_empty()
    });
    lamps
        .flat_map(|(object, lamp)| {
            let points = spread_over(&lamp.mesh, POINTS).into_iter().filter(shines);
            points.map(move |at| Sample { at, object })
        })
        .collect()
}

/// Two objects in one plane.
#[derive(Clone, Copy, Debug, Default)]
struct Overlap {
    /// Samples of the one that lie on the other.
    points: usize,
    /// The greatest distance at which rays start off the surfaces there, metres.
    clearance: f32,
}

impl Overlap {
    fn add(&mut self, other: Self) {
        self.points += other.points;
        self.clearance = self.clearance.max(other.clearance);
    }
}

/// The pairs of objects of two groups of which `samples` of one lie on the other, the lower index first.
fn overlapping(scene: &Scene, mut samples: Vec<Sample>) -> BTreeMap<[usize; 2], Overlap> {
    samples.sort_by(|a, b| a.at.point.x.total_cmp(&b.at.point.x));
    let of_object = |(index, object): (usize, &Object)| {
        let mut found: BTreeMap<[usize; 2], Overlap> = BTreeMap::new();
        let mut met = BTreeSet::new();
        for triangle in 0..object.mesh.triangles.len() {
            let corners = object.mesh.corners(triangle);
            for number in near(&samples, &corners) {
                let sample = &samples[number];
                let is_other = scene.objects[sample.object].group != object.group;
                // A point where triangles of one mesh meet counts once.
                if is_other && lies_in(&sample.at, &corners) && met.insert(number) {
                    let both = [index.min(sample.object), index.max(sample.object)];
                    let clearance = sample.at.clearance.max(clearance(corners));
                    found.entry(both).or_default().add(Overlap { points: 1, clearance });
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
    let reach = clearance(*corners);
    let first = samples.partition_point(|sample| sample.at.point.x < low.x - reach);
    let last = samples.partition_point(|sample| sample.at.point.x <= high.x + reach);
    first..last.max(first)
}

/// Whether a point lies inside a triangle, as far as rays can tell.
fn lies_in(sample: &SurfacePoint, [a, b, c]: &[Vec3; 3]) -> bool {
    let (u, v, way) = (*b - *a, *c - *a, sample.point - *a);
    let across = u.cross(v);
    let Some(normal) = across.try_normalize() else { return false };
    let near = sample.clearance.max(clearance([*a, *b, *c]));
    if way.dot(normal).abs() > near || normal.dot(sample.normal).abs() < PARALLEL {
        return false;
    }
    let area = across.length();
    let second = way.cross(v).dot(normal) / area;
    let third = u.cross(way).dot(normal) / area;
    second > INSIDE && third > INSIDE && second + third < 1.0 - INSIDE
}
