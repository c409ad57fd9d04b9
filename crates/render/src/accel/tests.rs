//! Both box tests against each other and against a search over all triangles.

use super::tree::{ChildRef, LEAF_MAX, WIDTH};
use super::woop::{ShearedRay, Triangles4};
use super::*;
use glam::Vec4;

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
    for (centre, radius) in [(Vec3::ZERO, 1.0), (Vec3::splat(5000.0), 1000.0), (Vec3::ZERO, 1e-3)] {
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
    let mut hits = 0;
    for i in 0..2000u32 {
        let [a, b, c, d] = sobol_burley::sample_4d(i, 0, 7);
        let origin = Vec3::new(3.0 * a - 1.5, 3.0 * b - 1.5, 3.0);
        let target = Vec3::new(3.0 * c - 1.5, 3.0 * d - 1.5, -1.0);
        let ray = Ray::new(origin, (target - origin).normalize());
        let sheared = ShearedRay::new(&ray);
        let one_by_one = all
            .iter()
            .filter_map(|t| Triangles4::new(&[(0, *t)]).nearest(&sheared, f32::INFINITY))
            .map(|hit| hit.t)
            .fold(f32::INFINITY, f32::min);
        let found = accel.closest(&ray).map_or(f32::INFINITY, |h| h.t);
        assert_eq!(found, one_by_one);
        assert_eq!(accel.occluded(&ray), found.is_finite());
        hits += u32::from(found.is_finite());
    }
    assert!(hits > 500 && hits < 1900, "the test needs hits and misses, not {hits}");
}

/// Without AVX2 there is nothing to compare.
#[test]
fn both_kernels_find_the_same_bits() {
    let (points, triangles) = sphere(Vec3::new(0.1, 0.0, -0.2), 1.0, 40);
    let accel = Accel::build(&triangles);
    for (i, point) in points.iter().enumerate() {
        let origin = Vec3::new(0.5, 1.5, 0.2) * (i % 7) as f32 / 3.0;
        // Slab tests are sensitive to exact zeros in directions.
        let towards = if i % 5 == 0 { Vec3::Z } else { (*point - origin).normalize() };
        let ray = Ray::new(origin, towards);
        let [a, b] = [walk::portable::<false>(&accel.tree, &ray), accel.closest(&ray)];
        assert_eq!(a, b);
        assert_eq!(walk::portable::<true>(&accel.tree, &ray).is_some(), accel.occluded(&ray));
    }
}

/// Every triangle is in one leaf, no leaf is too large, and boxes contain what is below them.
fn assert_sound(accel: &Accel, triangles: &[[Vec3; 3]]) {
    let mut found = vec![0; triangles.len()];
    let mut open = vec![(ChildRef::ROOT, accel.bounds)];
    while let Some((child, [low, high])) = open.pop() {
        if child.is_leaf() {
            assert!(4 * child.blocks().len() <= LEAF_MAX);
            for block in &accel.tree.blocks[child.blocks()] {
                let mut ids = block.ids.to_vec();
                ids.sort_unstable();
                ids.dedup();
                for id in ids {
                    found[id as usize] += 1;
                    let inside = |p: &Vec3| p.cmpge(low).all() && p.cmple(high).all();
                    assert!(triangles[id as usize].iter().all(inside), "{id}");
                }
            }
            continue;
        }
        let node = &accel.tree.nodes[child.0 as usize];
        for lane in 0..WIDTH {
            let corner =
                |side: usize| Vec3::from_array([0, 1, 2].map(|a| node.bounds[a][side][lane]));
            if corner(0).cmple(corner(1)).all() {
                open.push((node.children[lane], [corner(0), corner(1)]));
            }
        }
    }
    assert!(found.iter().all(|count| *count == 1), "every triangle once");
}

#[test]
fn many_triangles_in_one_place_are_no_trouble() {
    let one = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let away = one.map(|p| p + Vec3::new(5.0, 0.0, 0.0));
    for count in [30, 33, 3000, 20_000] {
        let mut all = vec![one; count];
        all.push(away);
        let accel = Accel::build(&all);
        assert_sound(&accel, &all);
        for (x, distance) in [(0.25, 1.0), (5.25, 1.0)] {
            let ray = Ray::new(Vec3::new(x, 0.25, 1.0), Vec3::NEG_Z);
            assert_eq!(accel.closest(&ray).map(|hit| hit.t), Some(distance));
        }
        assert_eq!(accel.closest(&Ray::new(Vec3::new(3.0, 0.25, 1.0), Vec3::NEG_Z)), None);
    }
}

/// The areas of boxes of this size overflow single precision.
#[test]
fn a_huge_triangle_among_ordinary_ones_makes_no_oversized_leaf() {
    let (_, ordinary) = sphere(Vec3::new(0.1, 0.0, -0.2), 1.0, 10);
    for size in [2e19, 1e30, f32::MAX] {
        let mut all = ordinary.clone();
        all.push([size * Vec3::X, size * Vec3::Y, size * Vec3::NEG_ONE]);
        all.push([size * Vec3::NEG_X, size * Vec3::Z, size * Vec3::ONE]);
        let accel = Accel::build(&all);
        assert_sound(&accel, &all);
        let ray = Ray::new(Vec3::new(0.1, 0.0, -0.2), Vec3::new(0.3, 0.4, 0.5).normalize());
        let expected = Accel::build(&ordinary).closest(&ray).map(|hit| hit.triangle);
        assert_eq!(accel.closest(&ray).map(|hit| hit.triangle), expected);
        assert!(expected.is_some());
    }
}

/// The culled triangles of a shaft give the same visibility as rays through the whole tree.
#[test]
fn shaft_culling_does_not_change_visibility() {
    let (_, coarse) = sphere(Vec3::new(0.2, 0.1, 0.0), 0.9, 5);
    let (_, fine) = sphere(Vec3::new(-1.2, 0.4, 0.3), 0.7, 30);
    let all: Vec<_> = coarse.into_iter().chain(fine).collect();
    let accel = Accel::build(&all);
    let random = |i: u32, set: u32| Vec4::from_array(sobol_burley::sample_4d(i, 0, set)).truncate();
    // Empty shafts, short lists, too many; visible segments and occluded ones.
    let (mut kinds, mut answers) = ([0; 3], [0; 2]);
    for i in 0..2000 {
        let apex = 4.0 * random(i, 1) - 2.0;
        let centre = 4.0 * random(i, 2) - 2.0;
        let size = 0.3 * random(i, 3);
        // Every other bundle is flat along an axis that is not the box's.
        let normal = (random(i, 4) - 0.5).normalize_or(Vec3::Y);
        let flat = |p: Vec3| if i % 2 == 0 { p } else { p.reject_from_normalized(normal) };
        let points = (0..16).map(|k| centre + flat(size * (random(16 * i + k, 5) - 0.5)));
        let bundle = Bundle::new(points.clone(), normal);
        let occluders = accel.occluders(apex, &bundle);
        kinds[match occluders {
            Occluders::Blocks(_, 0) => 0,
            Occluders::Blocks(..) => 1,
            Occluders::Many => 2,
        }] += 1;
        for point in points {
            let distance = (apex - point).length();
            let direction = (apex - point) / distance;
            let ray = Ray { origin: point, direction, t_max: (1.0 - 1e-5) * distance };
            let occluded = accel.occluded(&ray);
            assert_eq!(accel.occluded_among(&occluders, &ray), occluded, "{i}: {ray:?}");
            answers[usize::from(occluded)] += 1;
        }
    }
    assert!(kinds.iter().all(|kind| *kind > 100), "{kinds:?}");
    assert!(answers.iter().all(|answer| *answer > 3000), "{answers:?}");
}

/// The shaft from points of a floor to a point above it is empty, however low that is.
#[test]
fn the_surface_of_a_bundle_is_not_among_its_occluders() {
    let corner = |i: u32, j: u32| Vec3::new(i as f32, 0.1 * (i + j) as f32, j as f32);
    let squares = (0..100).map(|k| (k / 10, k % 10));
    let floor = squares.flat_map(|(i, j)| {
        let quad = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
        [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
    });
    let floor: Vec<_> = floor.collect();
    let accel = Accel::build(&floor);
    let normal = front_normal(floor[0]);
    let off = floor.iter().map(|t| clearance(*t)).fold(0.0, f32::max);
    let on_floor = |x: f32, z: f32| Vec3::new(x, 0.1 * (x + z), z) + off * normal;
    let bundle = Bundle::new(
        (0..64).map(|k| on_floor(3.3 + 0.1 * (k / 8) as f32, 4.4 + 0.1 * (k % 8) as f32)),
        normal,
    );
    for height in [1e-3, 0.1, 3.0] {
        let apex = on_floor(6.2, 3.1) + height * normal;
        let occluders = accel.occluders(apex, &bundle);
        assert!(matches!(occluders, Occluders::Blocks(_, 0)), "{height}: {occluders:?}");
    }
    let below = on_floor(6.2, 3.1) - 0.1 * normal;
    assert!(!matches!(accel.occluders(below, &bundle), Occluders::Blocks(_, 0)));
}
