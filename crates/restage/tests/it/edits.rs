//! Edits done to a scene, and those that cannot be.

use crate::common::{self, insertion, model};
use glam::{DVec3, Vec2, Vec3};
use unrender_restage::insert::{self, Place};
use unrender_restage::light::{Alter, LightChange, LightEdit, NewLight};
use unrender_restage::remove::{Bearer, Remove};
use unrender_restage::repaint::{Paint, Repaint};
use unrender_restage::{Edit, apply};
use unrender_scene::{Glass, LightKind, Rgb, Scene, Ungrouped, UpAxis};

const STILL: Alter = Alter {
    scale: Rgb::ONE,
    strength: None,
    shift: Vec3::ZERO,
    direction: None,
    profile: None,
    turn_rad: None,
};

fn remove(name: &str) -> Edit {
    Edit::Remove(Remove { name: name.into(), what: Bearer::Any })
}

fn light(name: &str, change: LightChange) -> Edit {
    Edit::Light(LightEdit { name: name.into(), change, photometric: None })
}

fn repaint(group: &str, paint: Paint) -> Edit {
    Edit::Repaint(Repaint { group: group.into(), paint })
}

/// The problem of the last of `edits`, the others being fine.
#[track_caller]
fn fails(edits: &[Edit], problem: &str) {
    let error = apply(&mut model(), edits).unwrap_err();
    assert!(error.problem.contains(problem), "{error}");
    assert_eq!(error.edit, edits.len() - 1, "{error}");
}

#[test]
fn objects_are_told_from_those_that_were_there() {
    let mut scene = model();
    let edits = [remove("left"), Edit::Insert(insertion(0.3, 0.2))];
    let change = apply(&mut scene, &edits).unwrap();
    assert_eq!(change.origin, [Some(0), Some(1), Some(3), Some(4), Some(5), None]);
    let added = scene.objects.last().unwrap();
    assert_eq!(
        (added.name.as_str(), scene.groups[added.group].name.as_str()),
        ("box.red", "box.red")
    );
}

/// A glass is put down where its foot is, counts as a size, and can be taken away again.
#[test]
fn glass_is_inserted_and_removed() {
    let mut insert = insertion(0.3, 0.2);
    let object = insert.model.objects.remove(0);
    let glass = Some(Glass::solid(1.5));
    let tumbler = Ungrouped { material: "tumbler".into(), mesh: object.mesh, glass };
    insert.model.ungrouped.push(tumbler);
    insert.scale = 0.5;
    let mut scene = model();
    let objects = scene.objects.len();
    let change = apply(&mut scene, &[Edit::Insert(insert.clone())]).unwrap();
    assert_eq!(scene.objects.len(), objects);
    assert_eq!(change.origin.len(), objects);
    assert_eq!(scene.ungrouped_materials(), ["box.tumbler"]);
    let points = &scene.ungrouped[0].mesh.positions;
    let low = points.iter().copied().reduce(Vec3::min).unwrap();
    assert!(low.y.abs() < 1e-5, "{low}");
    let again = apply(&mut scene, &[Edit::Insert(insert)]).unwrap_err();
    assert!(again.problem.contains("is called \"box\" already"), "{again}");
    apply(&mut scene, &[remove("box.tumbler")]).unwrap();
    assert!(scene.ungrouped.is_empty());
    let gone = apply(&mut scene, &[remove("box.tumbler")]).unwrap_err();
    assert!(gone.problem.contains("has no \"box.tumbler\""), "{gone}");
}

#[test]
fn models_in_other_units_are_told_with_both_sizes() {
    let told = |scale: f32| {
        let insert = insert::Insert { scale, ..insertion(0.3, 0.2) };
        apply(&mut model(), &[Edit::Insert(insert)]).unwrap().warnings.0
    };
    assert_eq!(told(1.0), [""; 0]);
    for (scale, size) in [(1000.0, "too large for the scene"), (0.001, "too small for the scene")] {
        let told = told(scale);
        assert!(told.len() == 1 && told[0].contains(size), "{told:?}");
        assert!(told[0].contains("scale = 1 if"), "{told:?}");
    }
}

/// The lowest and the highest corner of the box around the last object.
fn bounds_of_last(scene: &Scene) -> [Vec3; 2] {
    let points = &scene.objects.last().unwrap().mesh.positions;
    [Vec3::min, Vec3::max].map(|of| points.iter().copied().reduce(of).unwrap())
}

#[test]
fn things_are_put_down_where_their_foot_is() {
    for (place, foot) in [
        (Place::Onto { group: "floor".into(), at: [0.5, -1.0] }, Vec3::new(0.5, 0.0, -1.0)),
        (
            Place::Seen {
                origin: Vec3::new(0.0, 1.0, 0.0),
                direction: Vec3::new(1.0, -1.0, 0.0).normalize(),
                group: Some("floor".into()),
            },
            Vec3::new(1.0, 0.0, 0.0),
        ),
        (Place::At(Vec3::new(0.1, 0.7, 0.3).as_dvec3()), Vec3::new(0.1, 0.7, 0.3)),
    ] {
        let mut scene = model();
        let mut insert = insertion(0.0, 0.0);
        (insert.place, insert.scale) = (place, 0.5);
        apply(&mut scene, &[Edit::Insert(insert)]).unwrap();
        let [low, high] = bounds_of_last(&scene);
        let found = (0.5 * (low + high)).with_y(low.y);
        assert!((found - foot).length() < 1e-5, "{found} for {foot}");
        assert!((high.y - low.y - 0.25).abs() < 1e-6);
    }
}

#[test]
fn things_stand_upright_where_z_points_upwards() {
    let mut scene = model();
    scene.up = UpAxis::Z;
    for mesh in scene.objects.iter_mut().map(|object| &mut object.mesh) {
        mesh.positions.iter_mut().for_each(|p| *p = UpAxis::Z.from_y_up(*p));
        mesh.normals.iter_mut().for_each(|n| *n = UpAxis::Z.from_y_up(*n));
    }
    let ray = Place::Seen {
        origin: Vec3::new(0.0, 0.0, 1.0),
        direction: Vec3::new(1.0, 0.0, -1.0).normalize(),
        group: Some("floor".into()),
    };
    for (place, foot) in [
        (Place::Onto { group: "floor".into(), at: [0.5, 1.0] }, Vec3::new(0.5, 1.0, 0.0)),
        (ray, Vec3::new(1.0, 0.0, 0.0)),
        (Place::At(Vec3::new(0.1, 0.3, 0.7).as_dvec3()), Vec3::new(0.1, 0.3, 0.7)),
    ] {
        let mut scene = scene.clone();
        let mut insert = insertion(0.0, 0.0);
        (insert.place, insert.scale) = (place, 0.5);
        apply(&mut scene, &[Edit::Insert(insert)]).unwrap();
        let [low, high] = bounds_of_last(&scene);
        assert!(
            ((0.5 * (low + high)).with_z(low.z) - foot).length() < 1e-5,
            "{low} {high} for {foot}"
        );
        assert!((high.z - low.z - 0.25).abs() < 1e-6, "as high as it is where y points upwards");
    }
    let mut insert = insertion(0.0, 0.0);
    insert.place = Place::Onto { group: "floor".into(), at: [50.0, 1.0] };
    let error = apply(&mut scene, &[Edit::Insert(insert)]).unwrap_err();
    assert!(error.problem.contains("faces upwards at x = 50, y = 1"), "{error}");
}

#[test]
fn the_highest_surface_that_can_be_stood_on_is_found() {
    let mut scene = model();
    let mut second = insertion(0.3, 0.2);
    second.name = "second".into();
    second.place = Place::Onto { group: "box.red".into(), at: [0.3, 0.2] };
    apply(&mut scene, &[Edit::Insert(insertion(0.3, 0.2)), Edit::Insert(second)]).unwrap();
    let points = &scene.objects.last().unwrap().mesh.positions;
    let low = points.iter().fold(f32::INFINITY, |low, p| low.min(p.y));
    assert!((low - 0.5).abs() < 1e-6, "{low}");
}

#[test]
fn lights_are_changed_moved_added_and_removed() {
    let mut scene = model();
    let shift = Vec3::new(0.2, 0.0, 0.0);
    let alter = Alter { scale: Rgb::new(0.5, 1.0, 2.0), shift, ..STILL };
    let centre = Vec3::new(1.0, 2.0, 0.0);
    let (normal, size) = (Vec3::NEG_Y, Vec2::new(0.4, 0.2));
    let panel = NewLight::Area { centre, normal, size, radiance: Rgb::splat(3.0) };
    let position = Vec3::Y;
    let bulb = NewLight::Punctual(LightKind::Point { position, intensity: Rgb::ONE });
    let before = scene.objects[5].mesh.positions[0];
    let edits = [
        light("lamp", LightChange::Alter(alter)),
        light("panel", LightChange::Add(panel, DVec3::ZERO)),
        light("bulb", LightChange::Add(bulb, DVec3::ZERO)),
    ];
    let change = apply(&mut scene, &edits).unwrap();
    assert_eq!(scene.groups[5].emission, Rgb::new(4.0, 8.0, 16.0));
    assert_eq!(scene.objects[5].mesh.positions[0], before + shift);
    assert_eq!(change.origin[5..], [None, None]);
    let panel = &scene.objects[6].mesh;
    let [a, b, c] = panel.corners(0);
    let across = (b - a).cross(c - a);
    assert!(across.normalize().dot(normal) > 0.999 && (across.length() - 0.08).abs() < 1e-6);
    assert_eq!(scene.lights.len(), 1);
    let ball = NewLight::Sphere { centre, radius: 0.1, radiance: Rgb::ONE };
    let mut with_ball = scene.clone();
    let change =
        apply(&mut with_ball, &[light("ball", LightChange::Add(ball, DVec3::ZERO))]).unwrap();
    assert_eq!(change.origin.last(), Some(&None));
    let ball = &with_ball.objects[7].mesh;
    assert!(ball.positions.iter().all(|p| (p.distance(centre) - 0.1).abs() < 1e-6));
    apply(&mut scene, &[light("bulb", LightChange::Remove), light("lamp", LightChange::Remove)])
        .unwrap();
    assert!(scene.lights.is_empty() && scene.objects.len() == 6);
}

#[test]
fn paint_takes_the_place_of_a_texture_and_leaves_the_rest() {
    let mut scene = common::truth();
    let paint = Paint { rho_d: Some(Rgb::splat(0.2)), ..Paint::default() };
    apply(&mut scene, &[repaint("floor", paint)]).unwrap();
    assert_eq!(scene.groups[0].material, unrender_scene::Material::diffuse(Rgb::splat(0.2)));
    let gloss = Paint { rho_s: Some(Rgb::splat(0.1)), alpha_x: Some(0.2), ..Paint::default() };
    fails(&[repaint("floor", gloss)], "both are positive");
}

#[test]
fn what_cannot_be_is_reported() {
    fails(&[remove("sofa")], "no \"sofa\" to remove; its groups: back, floor");
    // What is like the name comes first.
    fails(&[remove("Floor")], "no \"Floor\" to remove; its groups: floor, back");
    fails(&[repaint("sofa", Paint::default())], "no group \"sofa\"");
    fails(&[remove("back"), repaint("back", Paint::default())], "no surface left");
    fails(&[repaint("back", Paint::default()), repaint("back", Paint::default())], "edited twice");
    fails(&[light("sun", LightChange::Remove)], "no light \"sun\"; it has lamp");
    let direction = Alter { direction: Some(Vec3::X), ..STILL };
    fails(&[light("lamp", LightChange::Alter(direction))], "area light, which has no direction");
    let insert = Edit::Insert(insertion(0.3, 0.2));
    fails(&[insert.clone(), insert], "\"box\" already");
    fails(&[Edit::Insert(insertion(9.0, 0.0))], "no surface of \"floor\" faces upwards");
    let mut far = insertion(0.0, 0.0);
    far.place = Place::At(DVec3::new(0.0, 30.0, 0.0));
    fails(&[Edit::Insert(far)], "stands outside the scene");
    let mut wall = insertion(0.0, 0.0);
    let (origin, direction) = (Vec3::Y, Vec3::NEG_Z);
    wall.place = Place::Seen { origin, direction, group: Some("floor".into()) };
    fails(&[Edit::Insert(wall.clone())], "shows \"back\", not \"floor\"");
    wall.place = Place::Seen { origin, direction, group: None };
    fails(&[Edit::Insert(wall)], "does not face upwards");
}

#[test]
fn places_far_away_are_those_of_the_world() {
    let origin = DVec3::new(5e5, 0.0, 5.4e6);
    let place = Vec3::new(0.1, 0.7, 0.3);
    let bulb = NewLight::Punctual(LightKind::Point { position: Vec3::ZERO, intensity: Rgb::ONE });
    let edits = |at: DVec3, midst: DVec3| {
        let mut insert = insertion(0.0, 0.0);
        insert.rotation = glam::Quat::IDENTITY;
        // The model may be far from its own zero, where it is put.
        insert.place = Place::At(at + place.as_dvec3() - midst);
        insert.model.origin = midst;
        let light = light("bulb", LightChange::Add(bulb.clone(), at + place.as_dvec3()));
        [Edit::Insert(insert), light]
    };
    let mut near = model();
    apply(&mut near, &edits(DVec3::ZERO, DVec3::ZERO)).unwrap();
    for midst in [DVec3::ZERO, DVec3::new(2e4, 0.0, -3e5)] {
        let mut far = model();
        far.origin = origin;
        apply(&mut far, &edits(origin, midst)).unwrap();
        let positions =
            |scene: &unrender_scene::Scene| scene.objects.last().unwrap().mesh.positions.clone();
        let pairs = positions(&near).into_iter().zip(positions(&far));
        assert!(pairs.into_iter().all(|(a, b)| a.distance(b) < 1e-6));
        let [LightKind::Point { position: a, .. }, LightKind::Point { position: b, .. }] =
            [&near, &far].map(|scene| scene.lights[0].kind.clone())
        else {
            panic!("two bulbs")
        };
        assert!(a.distance(b) < 1e-6, "{a} {b}");
    }
    let mut far = model();
    far.origin = origin;
    let mut beside = insertion(0.0, 0.0);
    beside.place = Place::Onto { group: "floor".into(), at: [5e5 + 0.3, 5.4e6] };
    apply(&mut far, &[Edit::Insert(beside)]).unwrap();
    let mut beside = insertion(0.0, 0.0);
    beside.place = Place::At(DVec3::ZERO);
    far = model();
    far.origin = origin;
    let error = apply(&mut far, &[Edit::Insert(beside)]).unwrap_err();
    assert!(
        error.problem.contains("outside the scene, which reaches from [49999"),
        "{}",
        error.problem
    );
}
