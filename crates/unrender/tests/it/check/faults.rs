//! What spoils a recovery without a word: a sky that is forgotten, a lamp of another strength, glass, smooth shading, and
//! photographs of which nothing can be used.

use super::*;
use unrender::check::Gravity;
use unrender::engine::{self, Asked};
use unrender::scene::Environment;

/// A photograph of `real` that is claimed to be one of `scene`.
fn claimed(real: &Scene, scene: &Scene, camera: &Camera) -> Input {
    let codes = Picture::new(photograph(real, camera), Depth::Float);
    Input::new(scene, camera.clone(), codes, Response::Linear, "exposure = 1\n")
}

/// `scene` below a sky of this radiance.
fn under(mut scene: Scene, sky: Rgb) -> Scene {
    let panorama = RgbImage::new(1, 1, vec![sky]);
    scene.environment = Some(Environment::new(panorama, 0.0).unwrap());
    scene
}

#[test]
fn a_sky_that_is_forgotten_is_told() {
    let blue = Rgb::new(0.3, 0.5, 0.8);
    let lit = under(room(), blue);
    // Seen above the walls.
    let from_afar = Camera::look_at("c", Vec3::new(0.1, 1.6, 6.0), Vec3::Y, Vec3::Y, 0.6);
    claimed(&lit, &room(), &from_afar)
        .warns("where the model has nothing", "[environment] with unknown = true");
    // Not seen, but it lights the room.
    claimed(&lit, &room(), &camera())
        .warns("light came from outside", "[environment] with unknown = true");
    let says_nothing = |input: &Input| {
        let told = input.check().warnings.0;
        assert!(told.iter().all(|told| !told.contains("[environment]")), "{told:?}");
    };
    says_nothing(&claimed(&lit, &lit, &camera()));
    says_nothing(&claimed(&room(), &room(), &from_afar));
}

#[test]
fn a_lamp_that_is_seen_with_another_brightness_is_told() {
    let looking_up =
        Camera::look_at("c", Vec3::new(0.2, 0.6, 1.4), Vec3::new(0.0, 1.9, 0.0), Vec3::Y, 0.8);
    let with = |factor: f32| {
        let mut scene = room();
        scene.groups[LAMP].emission *= factor;
        scene
    };
    for (factor, told) in [(3.0, "3.0 times brighter"), (0.4, "2.5 times darker")] {
        claimed(&with(factor), &room(), &looking_up)
            .warns(&format!("the photo shows lamp \"lamp\" {told}"), "[lights.\"lamp\"]");
    }
    let told = claimed(&room(), &room(), &looking_up).check().warnings.0;
    assert!(told.iter().all(|told| !told.contains("shows lamp")), "{told:?}");
}

#[test]
fn glass_by_its_name_is_told() {
    let mut scene = room();
    scene.groups[BLOCK].name = "Window_Glass.001".into();
    Input::of_room(&scene).warns(
        "\"Window_Glass.001\" sounds like glass",
        "[groups.\"Window_Glass.001\"] with ignore = true",
    );
}

#[test]
fn smooth_shading_over_sharp_edges_is_told() {
    let mut scene = room();
    let mesh = &mut scene.objects[BLOCK].mesh;
    let middle = mesh.positions.iter().sum::<Vec3>() / mesh.positions.len() as f32;
    mesh.normals = mesh.positions.iter().map(|corner| (*corner - middle).normalize()).collect();
    Input::of_room(&scene).warns("\"the block\" is shaded as if", "Split the normals");
}

#[test]
fn photographs_of_which_nothing_can_be_used_are_refused_with_the_reason() {
    let fails = |codes: RgbImage, text: &str| {
        let picture = Picture::new(codes, Depth::Eight);
        let text = format!("exposure = 1\n{text}");
        let mut input = Input::new(&room(), camera(), picture, Response::Srgb, &text);
        let asked = Asked::of(&input.0);
        engine::recover(&mut input.0, &asked, &mut ()).err().unwrap().to_string()
    };
    let of = |value: f32| RgbImage::from_fn(SIZE.0, SIZE.1, |_, _| Rgb::splat(value));
    let white = fails(of(1.0), "");
    assert!(white.contains("p.png: no pixel of the photo can be used: all "), "{white}");
    assert!(white.contains("are clipped") && white.contains("shorter exposure"), "{white}");
    let black = fails(of(0.0), "");
    assert!(black.contains("black wherever it shows the scene"), "{black}");
    let ignored: Vec<String> =
        GROUPS.iter().map(|(name, _)| format!("[groups.{name}]\nignore = true\n")).collect();
    let ignored = fails(of(0.5), &ignored.concat());
    assert!(ignored.contains("belong to groups that the project ignores"), "{ignored}");
}

#[test]
fn the_gravest_finding_comes_first() {
    assert!(Gravity::All < Gravity::Part && Gravity::Part < Gravity::Note);
    let mut scene = room();
    scene.groups[BLOCK].name = "glass".into();
    let codes = Picture::new(photo_of_room(), Depth::Float);
    let input = Input::new(&scene, camera(), codes, Response::Linear, "exposure = 90\n");
    let told = input.check().warnings.0;
    assert!(told[0].contains("times as bright as") && told[1].contains("sounds like"), "{told:?}");
}
