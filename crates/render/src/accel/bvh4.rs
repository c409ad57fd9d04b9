//! A tree with four boxes a node, collapsed from the binary tree that `obvhs` builds.

use super::woop::{self, ShearedRay, Triangles4};
use super::{Hit, Ray};
use glam::{Vec3, Vec3A, Vec4};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use std::time::Duration;

/// Marks a child that is a leaf: the other bits are the index of its first block of triangles.
const LEAF: u32 = 1 << 31;
/// Marks a child that is not there.
const EMPTY: u32 = u32::MAX;
/// Widens the far side of the slab test by more than its rounding error (Ize 2013).
const ROUNDING: f32 = 1.0 + 2.0 * 3.0 * f32::EPSILON;
/// Deeper than any tree that fits into memory needs: each level pushes three children at most.
const STACK: usize = 128;

/// Four children, one coordinate of one side of their boxes a vector.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// `bounds[side][axis]`, side 0 the lower one.
    bounds: [[Vec4; 3]; 2],
    children: [u32; 4],
    /// For leaves: how many blocks of triangles.
    blocks: [u32; 4],
}

/// Finds the triangles that rays meet.
#[derive(Debug)]
pub struct Accel {
    nodes: Vec<Node>,
    blocks: Vec<Triangles4>,
    normals: Vec<Vec3>,
    bounds: [Vec3; 2],
}

struct Boxed([Vec3; 3]);

impl Boundable for Boxed {
    fn aabb(&self) -> Aabb {
        Aabb::from_points(&self.0.map(Vec3A::from))
    }
}

impl Accel {
    /// Builds the tree over all triangles of a scene; there must be one at least.
    pub fn build(triangles: &[[Vec3; 3]]) -> Self {
        let boxed: Vec<Boxed> = triangles.iter().map(|t| Boxed(*t)).collect();
        let binary = build_bvh2(&boxed, BvhBuildParams::medium_build(), &mut Duration::default());
        let root = binary.nodes[0].aabb;
        let mut accel = Self {
            nodes: Vec::with_capacity(binary.nodes.len() / 3 + 1),
            blocks: Vec::with_capacity(triangles.len() / 2),
            normals: triangles.iter().map(|t| woop::front_normal(*t)).collect(),
            bounds: [root.min.into(), root.max.into()],
        };
        accel.collapse(&binary, triangles, 0);
        accel
    }

    /// The lower and upper corner of the box around everything.
    pub fn bounds(&self) -> [Vec3; 2] {
        self.bounds
    }

    /// The unit normal of the front of a triangle.
    pub fn front_normal(&self, triangle: u32) -> Vec3 {
        self.normals[triangle as usize]
    }

    /// Makes the node whose children are the best four descendants of the binary node `source`.
    fn collapse(&mut self, binary: &Bvh2, triangles: &[[Vec3; 3]], source: usize) -> u32 {
        let mut wanted = vec![source];
        // Open the largest inner child until there are four.
        while wanted.len() < 4 {
            let inner = (0..wanted.len()).filter(|&i| !binary.nodes[wanted[i]].is_leaf());
            let area = |i: &usize| binary.nodes[wanted[*i]].aabb.half_area();
            let Some(open) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
            let first = binary.nodes[wanted[open]].first_index as usize;
            wanted[open] = first;
            wanted.push(first + 1);
        }
        let index = self.nodes.len() as u32;
        self.nodes.push(Node {
            bounds: [[Vec4::INFINITY; 3], [Vec4::NEG_INFINITY; 3]],
            children: [EMPTY; 4],
            blocks: [0; 4],
        });
        for (lane, &child) in wanted.iter().enumerate() {
            let node = binary.nodes[child];
            let (link, blocks) = if node.is_leaf() {
                self.leaf(binary, triangles, child)
            } else {
                (self.collapse(binary, triangles, child), 0)
            };
            let target = &mut self.nodes[index as usize];
            for axis in 0..3 {
                target.bounds[0][axis][lane] = node.aabb.min[axis];
                target.bounds[1][axis][lane] = node.aabb.max[axis];
            }
            target.children[lane] = link;
            target.blocks[lane] = blocks;
        }
        index
    }

    /// Stores the triangles of a binary leaf in blocks of four.
    fn leaf(&mut self, binary: &Bvh2, triangles: &[[Vec3; 3]], leaf: usize) -> (u32, u32) {
        let node = &binary.nodes[leaf];
        let first = node.first_index as usize;
        let ids = &binary.primitive_indices[first..first + node.prim_count as usize];
        let start = self.blocks.len() as u32;
        for four in ids.chunks(4) {
            let block: Vec<_> = four.iter().map(|&id| (id, triangles[id as usize])).collect();
            self.blocks.push(Triangles4::new(&block));
        }
        (start | LEAF, self.blocks.len() as u32 - start)
    }

    /// The nearest triangle along the ray, from either side.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let sheared = ShearedRay::new(ray);
        let mut best: Option<Hit> = None;
        self.walk(ray, |block, t_max| {
            let hits = block.intersect(&sheared, *t_max);
            let t = hits.t.min_element();
            if t < *t_max {
                let lane = (0..4).find(|&i| hits.t[i] == t).unwrap_or(0);
                let barycentric = [hits.u[lane], hits.v[lane]];
                best = Some(Hit { t, triangle: block.ids[lane], barycentric });
                *t_max = t;
            }
            false
        });
        best
    }

    /// Whether anything stands on the ray before its end.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let sheared = ShearedRay::new(ray);
        let mut met = false;
        self.walk(ray, |block, t_max| {
            met = block.intersect(&sheared, *t_max).t.min_element() < *t_max;
            met
        });
        met
    }

    /// Shows `visit` every block of triangles whose box the ray enters, near ones first, until it
    /// returns true; it may shorten the ray.
    fn walk(&self, ray: &Ray, mut visit: impl FnMut(&Triangles4, &mut f32) -> bool) {
        let slabs = Slabs::new(ray);
        let mut t_max = ray.t_max;
        let mut stack = [(0u32, 0u32, 0.0f32); STACK];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (link, blocks, t_enter) = stack[depth];
            if t_enter > t_max {
                continue;
            }
            if link & LEAF != 0 {
                let first = (link & !LEAF) as usize;
                for block in &self.blocks[first..first + blocks as usize] {
                    if visit(block, &mut t_max) {
                        return;
                    }
                }
                continue;
            }
            let node = &self.nodes[link as usize];
            let (enter, entered) = slabs.enter(node, t_max);
            let base = depth;
            for lane in 0..4 {
                if entered & (1 << lane) == 0 {
                    continue;
                }
                // Insertion sort: the nearest child ends on top of the stack.
                let mut at = depth;
                while at > base && stack[at - 1].2 < enter[lane] {
                    stack[at] = stack[at - 1];
                    at -= 1;
                }
                stack[at] = (node.children[lane], node.blocks[lane], enter[lane]);
                depth += 1;
            }
        }
    }
}

/// The ray as the box test wants it.
struct Slabs {
    origin: [Vec4; 3],
    inverse: [Vec4; 3],
    /// For each axis: which side of the box the ray meets first.
    near: [usize; 3],
}

impl Slabs {
    fn new(ray: &Ray) -> Self {
        // A direction of zero would make 0 * infinity; a huge finite slope does not.
        let inverse = ray
            .direction
            .to_array()
            .map(|d| if d.abs() > 1e-18 { 1.0 / d } else { 1e18f32.copysign(d) });
        Self {
            origin: ray.origin.to_array().map(Vec4::splat),
            inverse: inverse.map(Vec4::splat),
            near: inverse.map(|i| usize::from(i < 0.0)),
        }
    }

    /// Where the ray enters each of the node's boxes, and a bit for each box that it does enter.
    fn enter(&self, node: &Node, t_max: f32) -> (Vec4, u32) {
        let side = |axis: usize, far: usize| {
            let side = self.near[axis] ^ far;
            (node.bounds[side][axis] - self.origin[axis]) * self.inverse[axis]
        };
        let enter = side(0, 0).max(side(1, 0)).max(side(2, 0)).max(Vec4::ZERO);
        let leave = side(0, 1).min(side(1, 1)).min(side(2, 1)) * ROUNDING;
        let inside = enter.cmple(leave.min(Vec4::splat(t_max)));
        (enter, inside.bitmask())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A closed sphere of triangles around `centre`.
    fn sphere(centre: Vec3, radius: f32, steps: usize) -> (Vec<Vec3>, Vec<[Vec3; 3]>) {
        let point = |i: usize, j: usize| {
            let theta = std::f32::consts::PI * i as f32 / steps as f32;
            let phi = std::f32::consts::TAU * (j % (2 * steps)) as f32 / (2 * steps) as f32;
            let ring = if i == 0 || i == steps { 0.0 } else { theta.sin() };
            centre + radius * Vec3::new(ring * phi.cos(), theta.cos(), ring * phi.sin())
        };
        let mut triangles = Vec::new();
        let mut points = Vec::new();
        for i in 0..steps {
            for j in 0..2 * steps {
                let quad = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                points.push(quad[0]);
                points.push(0.5 * (quad[0] + quad[1]));
                points.push(0.5 * (quad[0] + quad[2]));
                triangles.push([quad[0], quad[1], quad[2]]);
                triangles.push([quad[0], quad[2], quad[3]]);
            }
        }
        (points, triangles)
    }

    #[test]
    fn rays_at_vertices_and_edges_of_a_closed_mesh_never_leak() {
        for (centre, radius) in
            [(Vec3::ZERO, 1.0), (Vec3::splat(5000.0), 1000.0), (Vec3::ZERO, 1e-3)]
        {
            let (points, triangles) = sphere(centre, radius, 60);
            let accel = Accel::build(&triangles);
            let origin = centre + radius * Vec3::new(0.13, -0.21, 0.08);
            for point in points {
                let ray = Ray::new(origin, (point - origin).normalize());
                assert!(accel.closest(&ray).is_some(), "leak at {point}, radius {radius}");
                assert!(accel.occluded(&ray));
            }
        }
    }

    #[test]
    fn the_tree_finds_what_a_search_over_all_triangles_finds() {
        let (_, triangles) = sphere(Vec3::new(0.2, 0.1, 0.0), 0.9, 9);
        let (_, more) = sphere(Vec3::new(-1.2, 0.4, 0.3), 0.7, 7);
        let all: Vec<_> = triangles.into_iter().chain(more).collect();
        let accel = Accel::build(&all);
        let mut met = 0;
        for i in 0..2000u32 {
            let [a, b, c, d] = sobol_burley::sample_4d(i, 0, 7);
            let origin = Vec3::new(3.0 * a - 1.5, 3.0 * b - 1.5, 3.0);
            let target = Vec3::new(3.0 * c - 1.5, 3.0 * d - 1.5, -1.0);
            let ray = Ray::new(origin, (target - origin).normalize());
            let sheared = ShearedRay::new(&ray);
            let one_by_one = all
                .iter()
                .map(|t| Triangles4::new(&[(0, *t)]).intersect(&sheared, f32::INFINITY).t.x)
                .fold(f32::INFINITY, f32::min);
            let found = accel.closest(&ray).map_or(f32::INFINITY, |h| h.t);
            assert_eq!(found, one_by_one);
            assert_eq!(accel.occluded(&ray), found.is_finite());
            met += u32::from(found.is_finite());
        }
        assert!(met > 500 && met < 1900, "the test wants hits and misses, not {met}");
    }
}
