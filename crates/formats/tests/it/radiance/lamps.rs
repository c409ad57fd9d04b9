//! Lamps of every kind, and those that are refused.

use super::*;
use glam::DVec3;
use std::f32::consts::{FRAC_PI_6, PI};
use unrender_scene::{Environment, LightKind, Rgb};

/// A lamp of one material on a square of 2 x 2 that faces down, and a floor 3 below it.
fn lamp(material: &str) -> String {
    format!(
        "{material}\nl polygon panel 0 0 12 -1 -1 3 -1 1 3 1 1 3 1 -1 3\n\
         white polygon floor 0 0 12 -9 -9 0 9 -9 0 9 9 0 -9 9 0"
    )
}

#[test]
fn glows_give_light_unless_their_radius_is_below_zero() {
    for (radius, emission) in [("0", 5.0), ("3", 5.0), ("1e5", 5.0)] {
        let scene = exactly(&lamp(&format!("void glow l 0 0 4 5 5 5 {radius}")));
        assert_eq!(group(&scene, "panel").emission, Rgb::splat(emission), "{radius}");
    }
    let (scene, warnings) = read(&lamp("void glow l 0 0 4 5 5 5 -1"));
    assert_eq!(group(&scene, "panel").emission, Rgb::ZERO);
    assert_told(&warnings, "line 5: the glow \"l\" is visible but gives no light");
}

#[test]
fn illums_give_light_and_what_is_seen_instead_is_told() {
    for (words, said) in [
        ("1 white", "line 5: the illum \"l\" gives light and looks like \"white\""),
        ("1 void", "gives light and is invisible"),
        ("0", "gives light and is invisible"),
    ] {
        let (scene, warnings) = read(&lamp(&format!("void illum l {words} 0 3 5 6 7")));
        assert_eq!(group(&scene, "panel").emission, Rgb::new(5.0, 6.0, 7.0));
        assert_told(&warnings, said);
    }
}

#[test]
fn spotlights_are_spot_lights_as_bright_where_they_shine() {
    for (direction, behind) in [("0 0 -1", 1.0), ("0 0 -.001", 0.001), ("0 0 -6", 6.0)] {
        let (scene, warnings) =
            read(&lamp(&format!("void spotlight l 0 0 7 5 5 5 60 {direction}")));
        assert_eq!(names(&scene), ["bulb", "floor"], "its surface is black but in its cone");
        let LightKind::Spot { position, direction, intensity, inner_rad, outer_rad } =
            scene.lights[0].kind
        else {
            panic!("{:?}", scene.lights)
        };
        assert_near(position, [0., 0., 3.], "position");
        assert_near(direction, [0., 0., -1.], "direction");
        assert!((outer_rad - FRAC_PI_6).abs() < 1e-6 && inner_rad > 0.99 * outer_rad);
        // On the floor: radiance times area over the square of the way from the focus.
        let on_floor = 5.0 * 4.0 / (3.0f32 + behind).powi(2);
        assert!((intensity.x / 9.0 / on_floor - 1.0).abs() < 1e-4, "{behind}: {intensity}");
        assert_told(&warnings, "3.000 m away");
    }
    // Seen from its front only, and turned with its file.
    let part = lamp("void spotlight l 0 0 7 5 5 5 60 0 0 1");
    let (scene, _) = read_beside(&[("part.rad", &part)], "!xform -rx 180 part.rad").unwrap();
    let LightKind::Spot { direction, intensity, .. } = scene.lights[0].kind else { panic!() };
    assert_near(direction, [0., 0., -1.], "turned");
    assert_eq!(intensity, Rgb::ZERO, "it shines to where its back is");
    let scene = read(&lamp("void spotlight l 0 0 7 5 5 5 270 0 0 -1")).0;
    assert_eq!(
        group(&scene, "panel").emission,
        Rgb::splat(5.0),
        "wider than half of all directions"
    );
    assert!(refusal(&lamp("void spotlight l 0 0 7 5 5 5 60 0 0 0")).contains("no direction"));
}

#[test]
fn lamps_whose_brightness_is_not_understood_are_refused() {
    let table = "void brightdata d 4 flatcorr l.dat source.cal src_theta 0 1 2000\n";
    for (text, said) in [
        (
            lamp(&format!("{table}d light l 0 0 3 1 1 1")),
            "the light \"l\" is as bright as the brightdata \"d\" says",
        ),
        (
            lamp("void brightfunc d 2 f f.cal 0 0\nd glow l 0 0 4 1 1 1 0"),
            "as the brightfunc \"d\" says",
        ),
        (lamp("void colorpict d 7 red green blue p.hdr . u v 0 0\nd illum l 0 0 3 1 1 1"), "p.hdr"),
        (
            lamp("void brightfunc d 2 skybr skybright.cal 0 3 2 9 1\nd light l 0 0 3 1 1 1"),
            "\"d\" says",
        ),
        (lamp("void spectrum d 0 0 3 1 1 1\nd light l 0 0 3 1 1 1"), "the spectrum \"d\" says"),
        (
            format!("{table}d light l 0 0 3 1 1 1\nl source sun 0 0 4 0 0 1 .5"),
            "the brightdata \"d\" says",
        ),
        ("void spotlight l 0 0 7 1 1 1 30 0 0 1\nl source s 0 0 4 0 0 1 1".into(), "far away"),
        ("lamp source s 0 0 4 0 0 0 1".into(), "the source \"s\" has no direction"),
        ("lamp source s 0 0 4 0 0 1 0".into(), "the source \"s\" has no size"),
    ] {
        let told = refusal(&text);
        assert!(told.contains(said), "{told}");
    }
    // Constants are understood.
    let scene = exactly(&lamp("void brightfunc d 2 A1 . 0 1 .5\nd light l 0 0 3 8 8 8"));
    assert_eq!(group(&scene, "panel").emission, Rgb::splat(4.0));
}

/// The irradiance by `environment` of a surface that faces `up`.
fn irradiance(environment: &Environment, up: Vec3) -> Vec3 {
    let rows = 400;
    let mut sum = DVec3::ZERO;
    for (x, y) in (0..2 * rows).flat_map(|x| (0..rows).map(move |y| (x, y))) {
        let cos_polar = 1.0 - 2.0 * (y as f32 + 0.5) / rows as f32;
        let direction = environment.direction((x as f32 + 0.5) / (2 * rows) as f32, cos_polar);
        sum += (environment.radiance(direction) * direction.dot(up).max(0.0)).as_dvec3();
    }
    (sum / (2 * rows * rows) as f64).as_vec3() * 4.0 * PI
}

#[test]
fn narrow_sources_are_directional_and_wide_ones_surround_the_scene() {
    let scene = exactly("lamp source sun 0 0 4 0 0 2 5");
    let LightKind::Directional { direction, irradiance: found } = scene.lights[0].kind else {
        panic!()
    };
    let sin = 2.5f32.to_radians().sin();
    assert_eq!((direction, scene.environment.is_some()), (Vec3::NEG_Z, false));
    assert!((found.x / (10.0 * PI * sin * sin) - 1.0).abs() < 1e-5);
    for (angle, turn) in [(10.0f32, Vec3::Z), (60.0, Vec3::X), (180.0, Vec3::Z), (360.0, Vec3::Y)] {
        let scene =
            exactly(&format!("lamp source far 0 0 4 {} {} {} {angle}", turn.x, turn.y, turn.z));
        assert!(scene.lights.is_empty());
        let sin = (0.5 * angle.min(180.0)).to_radians().sin();
        let found = irradiance(scene.environment.as_ref().unwrap(), turn).x;
        assert!((found / (10.0 * PI * sin * sin) - 1.0).abs() < 0.02, "{angle}: {found}");
    }
    let (scene, warnings) =
        read("void glow g 0 0 4 1 1 1 -1\ng source s 0 0 4 0 0 1 180\nred source t 0 0 4 0 0 1 9");
    assert!(scene.environment.is_none());
    assert_told(&warnings, "line 6: the source \"s\" gives no light and was left out");
    assert_told(&warnings, "line 7: the source \"t\" gives no light and was left out");
    let many = "lamp source s 0 0 4 0 0 1 90\n".repeat(65);
    assert!(refusal(&many).contains("more than 64 sources"));
}

#[test]
fn a_sky_and_a_ground_are_both_seen() {
    let scene = exactly(
        "void glow sky 0 0 4 2 3 4 0\nsky source up 0 0 4 0 0 1 180\n\
         void glow ground 0 0 4 .5 .4 .3 0\nground source down 0 0 4 0 0 -1 180",
    );
    let environment = scene.environment.unwrap();
    let up = irradiance(&environment, Vec3::Z) / PI;
    assert!((up / Vec3::new(2.0, 3.0, 4.0) - 1.0).abs().max_element() < 0.01, "{up}");
    let down = irradiance(&environment, Vec3::NEG_Z) / PI;
    assert!((down / Vec3::new(0.5, 0.4, 0.3) - 1.0).abs().max_element() < 0.01, "{down}");
}

const GLOWS: &str = "skyfunc glow sky_glow 0 0 4 1 1 1 0\nsky_glow source sky 0 0 4 0 0 1 180\n";

#[test]
fn gensky_makes_sun_and_sky() {
    // The irradiance of an overcast sky is given; a third of its zenith's radiance is at the horizon.
    let scene = exactly(&format!("!gensky -ang 45 0 -c -B 100\n{GLOWS}"));
    let environment = scene.environment.unwrap();
    let found = irradiance(&environment, Vec3::Z).x;
    assert!((found / 100.0 - 1.0).abs() < 0.02, "{found}");
    let zenith = environment.radiance(Vec3::Z).x;
    assert!((zenith * PI * 7.0 / 9.0 / 100.0 - 1.0).abs() < 0.01, "{zenith}");
    let low = environment.radiance(Vec3::new(1.0, 0.0, 0.2).normalize()).x;
    assert!((low / zenith - (1.0 + 2.0 * 0.196) / 3.0).abs() < 0.01, "{low}");
    // A uniform one, and skies with a sun in the west, brightest beside it.
    let uniform = exactly(&format!("!gensky -ang 45 0 -u -b 7\n{GLOWS}")).environment.unwrap();
    assert!((uniform.radiance(Vec3::new(0.5, 0.5, 0.7).normalize()).x - 7.0).abs() < 1e-3);
    for kind in ["+s", "+i"] {
        let scene = exactly(&format!("!gensky -ang 30 90 {kind} -R 500 -B 80\n{GLOWS}"));
        let LightKind::Directional { direction, irradiance: sun } = scene.lights[0].kind else {
            panic!()
        };
        assert_near(
            -direction,
            [-0.75f32.sqrt(), 0.0, 0.5],
            "azimuths count from the south to the west",
        );
        // Horizontal, with the solid angle of half a degree.
        assert!((sun.x * 0.5 / 500.0 - 1.0).abs() < 0.01, "{sun}");
        let environment = scene.environment.unwrap();
        let found = irradiance(&environment, Vec3::Z).x;
        assert!((found / 80.0 - 1.0).abs() < 0.06, "{kind}: {found}");
        let at = |x: f32| environment.radiance(Vec3::new(x, 0.0, 0.5).normalize()).x;
        assert!(at(-0.8) > 2.0 * at(0.8), "{kind}");
    }
    assert!(exactly("!gensky -ang 30 90 -s -t 3").lights.is_empty());
    assert!(exactly("!gensky -ang 30 90 +s -t 3 -R 0").lights.is_empty());
}

#[test]
fn gensky_is_that_of_radiance_6() {
    // The zenith's radiance and the sun's, as that version prints them.
    for (options, zenith, sun) in [
        ("+s", 8.325, 6.622e6),
        ("+s -t 2.75", 10.03, 6.622e6),
        ("+i", 18.08, 9.934e5),
        ("+i -t 3", 19.65, 9.934e5),
        ("+s -b 20 -r 1e6", 20.0, 1e6),
        ("+s -B 100 -R 500", 18.52, 1.301e7),
    ] {
        let (scene, warnings) = read(&format!("!gensky -ang 40 30 {options}\n{GLOWS}"));
        let found = scene.environment.unwrap().radiance(Vec3::Z).x;
        assert!((found / zenith - 1.0).abs() < 0.01, "{options}: {found} for {zenith}");
        let LightKind::Directional { irradiance, .. } = scene.lights[0].kind else { panic!() };
        let found = irradiance.x / 5.98109e-5;
        assert!((found / sun - 1.0).abs() < 1e-3, "{options}: {found} for {sun}");
        let says_how_hazy = options.contains("-t") || options.to_lowercase().contains("-b");
        assert_eq!(warnings.0.is_empty(), says_how_hazy, "{options}: {warnings:?}");
        if !says_how_hazy {
            assert_told(&warnings, "state -t");
        }
    }
}

#[test]
fn gensky_knows_where_the_sun_is() {
    // At noon at 45 degrees north it is 45 degrees high at the equinox, higher in June, lower in
    // December.
    for (command, z, y_below) in [
        ("3 21 +12 -a 45", 0.707, -0.7),
        ("6 21 +12 -a 45", 0.93, -0.3),
        ("12 21 +12:00 -a 45", 0.37, -0.9),
        ("3 21 12 -a 45 -o 0 -m 0", 0.70, -0.6),
    ] {
        let scene = exactly(&format!("!gensky {command} -t 3"));
        let LightKind::Directional { direction, .. } = scene.lights[0].kind else { panic!() };
        assert!(
            (-direction.z - z).abs() < 0.02 && -direction.y < y_below,
            "{command}: {direction}"
        );
    }
    let east = exactly("!gensky 3 21 +9 -a 45 -t 3");
    let LightKind::Directional { direction, .. } = east.lights[0].kind else { panic!() };
    assert!(-direction.x > 0.5, "in the morning it is in the east: {direction}");
    for (command, said) in [
        ("13 1 12", "gensky is used as"),
        ("6 21 12EST", "gensky has the hour \"12EST\""),
        ("6 21 12 -q", "gensky has \"-q\""),
        ("6 21", "gensky is used as"),
    ] {
        assert!(refusal(&format!("!gensky {command}")).contains(said), "{command}");
    }
}

#[test]
fn skies_are_turned_by_xform_and_perez_is_known() {
    let sky = format!("!gensky -ang 30 90 +s -t 3\n{GLOWS}");
    let (scene, _) = read_beside(&[("sky.rad", &sky)], "!xform -rz -90 sky.rad").unwrap();
    let LightKind::Directional { direction, .. } = scene.lights[0].kind else { panic!() };
    assert_near(-direction, [0.0, 0.75f32.sqrt(), 0.5], "from the west to the north");
    let environment = scene.environment.unwrap();
    let at = |y: f32| environment.radiance(Vec3::new(0.0, y, 0.5).normalize()).x;
    assert!(at(0.8) > 2.0 * at(-0.8));
    // 4 (1 + .5 exp(-1/z)) (1 + 2 exp(-3 g) + .1 cos2 g), from the sun in the zenith.
    let scene = exactly(&format!(
        "void brightfunc skyfunc 2 skybright perezlum.cal 0 10 4 1 .5 -1 2 -3 .1 0 0 1\n{GLOWS}"
    ));
    let environment = scene.environment.unwrap();
    for z in [0.95f32, 0.6, 0.3] {
        let gradient = 1.0 + 0.5 * (-1.0 / z).exp();
        let expected = 4.0 * gradient * (1.0 + 2.0 * (-3.0 * z.acos()).exp() + 0.1 * z * z);
        let found = environment.radiance(Vec3::new((1.0 - z * z).sqrt(), 0.0, z)).x;
        assert!((found / expected - 1.0).abs() < 0.02, "{z}: {found} instead of {expected}");
    }
}

#[test]
fn an_export_to_formats_without_environments_tells_that_the_sky_is_not_in_it() {
    use unrender_formats::LightUnits;
    use unrender_formats::export::{SceneView, Target, export};
    for (text, has_sky) in [("lamp source sky 0 0 4 0 0 1 180", true), ("", false)] {
        let scene = exactly(text);
        let camera = unrender_scene::Camera::look_at("c", Vec3::X, Vec3::ZERO, Vec3::Z, 0.8);
        let materials = scene.materials();
        let light_units = LightUnits::default();
        let shot = SceneView {
            scene: &scene,
            materials: &materials,
            camera: &camera,
            size: (4, 3),
            light_units,
        };
        for target in Target::ALL {
            let (_, warnings) = export(&shot, target, target.usual_name().as_ref()).unwrap();
            let told = warnings.0.iter().any(|told| told.contains("no words for the environment"));
            assert_eq!(told, has_sky && !target.has_environments(), "{target:?}: {warnings:?}");
        }
    }
}
