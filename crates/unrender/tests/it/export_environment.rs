//! The light from all around in exports: the written files show every direction as it was, by the formulas that the
//! formats' own documents state for panoramas, which are written here a second time.

use crate::kit::export_scene::{SIZE, camera, scene};
use glam::{Mat4, Quat, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;
use unrender::formats::LightUnits;
use unrender::formats::export::{self, SceneView, Target};
use unrender::formats::{load_scene, picture};
use unrender::scene::{Environment, Rgb, RgbImage, Scene, Warnings};

/// The radiance in a direction, by a written file.
type Shown = Box<dyn Fn(Vec3) -> Rgb>;

/// Reads the environment of the export in a folder.
type Reader = fn(&Path) -> Shown;

/// The formats that hold environments, each with the function that reads one.
const HOLDING: [(Target, Reader); 5] = [
    (Target::Mitsuba, mitsuba),
    (Target::Blender, blender),
    (Target::Pbrt, pbrt),
    (Target::Radiance, radiance),
    (Target::Usd, usd),
];

/// The scene in the light of `around`, exported into a new folder, and what was told of the environment.
fn exported(around: Option<Environment>, target: Target) -> (tempfile::TempDir, Warnings) {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene { environment: around, ..scene() };
    let (materials, camera) = (scene.materials(), camera());
    let shot = SceneView {
        scene: &scene,
        materials: &materials,
        camera: &camera,
        size: SIZE,
        light_units: LightUnits::Radiometric,
    };
    let is_file = [Target::Gltf, Target::Usd].contains(&target);
    let path = folder.path().join(if is_file { target.usual_name() } else { String::new() });
    let (files, mut warnings) = export::export(&shot, target, &path).unwrap();
    export::write(&path, target, &files).unwrap();
    warnings.0.retain(|told| told.contains("environment"));
    (folder, warnings)
}

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

fn exr(folder: &Path) -> RgbImage {
    picture::read(&folder.join("environment.exr")).unwrap().0.values
}

/// What lies between `before` and `after` in `text`.
fn between<'a>(text: &'a str, before: &str, after: &str) -> &'a str {
    text.split_once(before).unwrap().1.split_once(after).unwrap().0
}

/// Between the pixels about a place in pixels, whole numbers at their centres; columns wrap around, rows end.
fn bilinear(picture: &RgbImage, place: Vec2) -> Rgb {
    let (width, height) = (picture.width() as i32, picture.height() as i32);
    let at =
        |x: i32, y: i32| *picture.at(x.rem_euclid(width) as usize, y.clamp(0, height - 1) as usize);
    let (low, part) = (place.floor(), place - place.floor());
    let (x, y) = (low.x as i32, low.y as i32);
    let row = |y: i32| at(x, y).lerp(at(x + 1, y), part.x);
    row(y).lerp(row(y + 1), part.y)
}

/// Mitsuba 3, `envmap`: columns by `atan2(x, -z)` from the left edge, the first and last row at the poles.
fn mitsuba(folder: &Path) -> Shown {
    let picture = exr(folder);
    let xml = text(folder, "scene.xml");
    let turn: f32 = between(&xml, "<rotate y=\"1\" angle=\"", "\"").parse().unwrap();
    assert!(between(&xml, "type=\"envmap\">", "</emitter>").contains("environment.exr"));
    Box::new(move |direction| {
        let d = Quat::from_rotation_y(-turn.to_radians()) * direction;
        let u = d.x.atan2(-d.z) / TAU;
        let v = d.y.clamp(-1.0, 1.0).acos() / PI;
        let [width, rows] = [picture.width() as f32, picture.height() as f32 - 1.0];
        bilinear(&picture, Vec2::new(u * width - 0.5, v * rows))
    })
}

/// Cycles: z is up, the panorama's middle lies along x, and y to the left of it; a *Mapping* of the type *Texture*
/// turns back what its rotation has turned.
fn blender(folder: &Path) -> Shown {
    let picture = exr(folder);
    let scene: serde_json::Value = serde_json::from_str(&text(folder, "scene.json")).unwrap();
    assert_eq!(scene["environment"]["panorama"], "environment.exr");
    let turn = FRAC_PI_2 + scene["environment"]["rotation"].as_f64().unwrap() as f32;
    assert!(text(folder, "scene.py").contains("math.pi / 2 + item[\"rotation\"]"));
    Box::new(move |direction| {
        let up = Vec3::new(direction.x, -direction.z, direction.y);
        let d = Quat::from_rotation_z(-turn) * up;
        let u = 0.5 - d.y.atan2(d.x) / TAU;
        let v = 0.5 - d.z.atan2(d.x.hypot(d.y)) / PI;
        let size = Vec2::new(picture.width() as f32, picture.height() as f32);
        bilinear(&picture, Vec2::new(u, v) * size - 0.5)
    })
}

/// PBRT v4, `EqualAreaSphereToSquare`, and the pixel there.
fn pbrt(folder: &Path) -> Shown {
    let picture = exr(folder);
    assert_eq!(picture.width(), picture.height());
    let scene = text(folder, "scene.pbrt");
    let world = scene.split_once("WorldBegin").unwrap().1;
    // Outside of all attributes, so that nothing turns it.
    let before =
        world.split_once("LightSource \"infinite\" \"string filename\" \"environment.exr\"");
    assert!(!before.unwrap().0.contains("AttributeBegin"), "{world}");
    Box::new(move |d| {
        let r = (1.0 - d.z.abs()).max(0.0).sqrt();
        let phi = d.y.abs().atan2(d.x.abs()) / FRAC_PI_2;
        let (mut u, mut v) = (r - phi * r, phi * r);
        if d.z < 0.0 {
            (u, v) = (1.0 - v, 1.0 - u);
        }
        let place = Vec2::new(u.copysign(d.x), v.copysign(d.y)) * 0.5 + 0.5;
        let last = picture.width() - 1;
        let [x, y] = (place * picture.width() as f32).to_array().map(|p| (p as usize).min(last));
        *picture.at(x, y)
    })
}

/// Radiance: pictures are as high or as wide as one along their shorter side, from below, and the centres of the
/// outermost pixels lie at their edges.
fn radiance(folder: &Path) -> Shown {
    let scene = text(folder, "scene.rad");
    assert!(scene.contains("environment.panorama glow environment\n0\n0\n4 1 1 1 0\n"), "{scene}");
    assert!(scene.contains("environment source environment.sky\n0\n0\n4 0 1 0 360\n"), "{scene}");
    let (picture, _) = picture::read(&folder.join("environment.hdr")).unwrap();
    let picture = picture.values;
    let line = between(&scene, "7 red green blue ./environment.hdr . ", "\n").to_owned();
    let (across, up) = line.split_once(' ').unwrap();
    let number = |text: &str, before, after| between(text, before, after).parse::<f32>().unwrap();
    assert!(across.starts_with("(frac(.5+(atan2(Dx,-Dz)+("), "{across}");
    assert!(up.starts_with("((1-atan2(sqrt(Dx*Dx+Dz*Dz),Dy)/"), "{up}");
    let turn = number(across, "atan2(Dx,-Dz)+(", ")");
    let scales = |text: &str| {
        let scale = text.rsplit_once('*').unwrap().1.parse::<f32>().unwrap();
        (text.rsplit_once("+.5)*").unwrap().0.rsplit_once('*').unwrap().1.parse().unwrap(), scale)
    };
    let [(columns, to_x), (rows, to_y)]: [(f32, f32); 2] = [scales(across), scales(up)];
    Box::new(move |d| {
        let u = 0.5 + (d.x.atan2(-d.z) + turn) / TAU;
        let x = ((u - u.floor()) * columns + 0.5) * to_x;
        let y = ((1.0 - d.x.hypot(d.z).atan2(d.y) / PI) * rows + 0.5) * to_y;
        let (width, height) = (picture.width() as f32, picture.height() as f32);
        let shorter = width.min(height);
        let place =
            Vec2::new(x * shorter / width * (width - 1.0), y * shorter / height * (height - 1.0));
        bilinear(&picture, Vec2::new(place.x, height - 1.0 - place.y))
    })
}

/// OpenEXR's maps of latitude and longitude, which USD names: longitude 0 in the middle, along z, and a quarter of a turn, along
/// x, to the left of it. The first three rows of the dome's transform are where it has its axes.
fn usd(folder: &Path) -> Shown {
    let stage = text(folder, "scene.usda");
    let dome = between(&stage, "def DomeLight \"environment\"", "\n    }");
    assert!(dome.contains("inputs:texture:file = @./scene_textures/environment.exr@"), "{dome}");
    assert!(
        dome.contains("color3f inputs:color = (1, 1, 1)\n        float inputs:intensity = 1\n")
    );
    let rows = between(dome, "xformOp:transform = ( ", " )");
    let numbers = rows.split(['(', ')', ',', ' ']).filter_map(|word| word.parse::<f32>().ok());
    let axes = Mat4::from_cols_slice(&numbers.collect::<Vec<_>>());
    let picture = exr(&folder.join("scene_textures"));
    Box::new(move |direction| {
        let d = axes.transpose().transform_vector3(direction);
        let u = 0.5 - d.x.atan2(d.z) / TAU;
        let v = d.y.clamp(-1.0, 1.0).acos() / PI;
        let size = Vec2::new(picture.width() as f32, picture.height() as f32);
        bilinear(&picture, Vec2::new(u, v) * size - 0.5)
    })
}

/// Directions all over the sphere, about `count` of them.
fn directions(count: usize) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |k| {
        let y = 1.0 - (2.0 * k as f32 + 1.0) / count as f32;
        let (sin, cos) = (k as f32 * 2.399_963).sin_cos();
        let ring = (1.0 - y * y).sqrt();
        Vec3::new(ring * sin, y, ring * cos)
    })
}

/// Not symmetric under any turn or reflection, smooth, and of three different channels.
fn motley(columns: usize, rows: usize) -> RgbImage {
    RgbImage::from_fn(columns, rows, |x, y| {
        let (u, v) = (TAU * (x as f32 + 0.5) / columns as f32, (y as f32 + 0.5) / rows as f32);
        let ring = (PI * v).sin();
        Rgb::new(1.2 + ring * u.sin(), 0.2 + v * v, 1.5 + ring * ring * (2.0 * u + 0.4).cos())
    })
}

fn around(panorama: RgbImage, rotation_deg: f32) -> Environment {
    Environment::new(panorama, rotation_deg.to_radians()).unwrap()
}

/// The largest difference over all directions but those close to the poles, where the pixels of a row meet, relative to
/// the brightest.
fn off(shown: &dyn Fn(Vec3) -> Rgb, truth: &Environment) -> f32 {
    let worst = directions(2000)
        .filter(|d| d.y.abs() < 0.998)
        .map(|d| (shown(d) - truth.radiance(d)).abs().max_element())
        .fold(0.0, f32::max);
    worst / truth.panorama().pixels().iter().map(|p| p.max_element()).fold(0.0, f32::max)
}

/// As it is, turned both ways, by more than a turn, brighter, of a camera's own aspect, and as few pixels as a recovery
/// finds.
#[test]
fn every_direction_is_as_bright_as_it_was() {
    let cases = [
        around(motley(64, 32), 0.0),
        around(motley(64, 32), 70.0),
        around(motley(64, 32), -130.0),
        around(motley(64, 32), 400.0),
        around(motley(60, 40).map(|rgb| *rgb * 25.0), 10.0),
        around(motley(8, 4), 0.0).in_parts(),
        around(motley(8, 4), -20.0),
        around(motley(600, 300), 35.0),
    ];
    for case in cases {
        for (target, read) in HOLDING {
            let (folder, told) = exported(Some(case.clone()), target);
            assert_eq!(told, Warnings::default(), "{target}");
            let off = off(&read(folder.path()), &case);
            // PBRT does not interpolate; its pixels are 0.6 degrees wide. Radiance has 8 bits a channel.
            let limit = match target {
                Target::Pbrt => 0.03,
                Target::Radiance => 0.01,
                _ => 0.005,
            };
            let (size, turn) = (case.panorama().width(), case.rotation_rad());
            assert!(off < limit, "{target}, {size} columns turned by {turn}: {off}");
        }
    }
}

/// One bright pixel among black ones: its light comes from where it did, and as much of it.
#[test]
fn a_lone_sun_stands_where_it_stood() {
    for (x, y, rotation_deg) in [(5, 3, 0.0), (20, 8, 110.0), (0, 12, -45.0), (31, 1, 15.0)] {
        let sun = |i: usize, j: usize| if (i, j) == (x, y) { Rgb::splat(100.0) } else { Rgb::ZERO };
        let truth = around(RgbImage::from_fn(32, 16, sun), rotation_deg);
        let centre = truth
            .direction((x as f32 + 0.5) / 32.0, Environment::cos_polar((y as f32 + 0.5) / 16.0));
        // The mean over all directions, and the mean direction.
        let seen = |shown: &dyn Fn(Vec3) -> Rgb| {
            let lit = directions(200_000).map(|d| (shown(d).x, d));
            let (sum, way) = lit.fold((0.0, Vec3::ZERO), |(s, w), (l, d)| (s + l, w + l * d));
            (sum / 200_000.0, way.normalize())
        };
        let (light, way) = seen(&|d| truth.radiance(d));
        assert!(way.dot(centre) > 2f32.to_radians().cos());
        for (target, read) in HOLDING {
            let (folder, _) = exported(Some(truth.clone()), target);
            let (theirs, there) = seen(&read(folder.path()));
            assert!((theirs / light - 1.0).abs() < 0.01, "{target}: {theirs} for {light}");
            assert!(there.dot(way) > 0.2f32.to_radians().cos(), "{target}: {there} for {way}");
        }
    }
}

#[test]
fn one_radiance_from_everywhere_needs_no_panorama() {
    let radiance = Rgb::new(0.25, 0.5, 0.75);
    let written = [
        (
            Target::Mitsuba,
            "scene.xml",
            "<rgb name=\"radiance\" value=\"0.25 0.5 0.75\"/></emitter>",
        ),
        (Target::Pbrt, "scene.pbrt", "LightSource \"infinite\" \"rgb L\" [ 0.25 0.5 0.75 ]"),
        (Target::Radiance, "scene.rad", "void glow environment\n0\n0\n4 0.25 0.5 0.75 0\n"),
        (Target::Blender, "scene.json", "\"environment\":{\"radiance\":[0.25,0.5,0.75]}"),
        (
            Target::Usd,
            "scene.usda",
            "color3f inputs:color = (0.33333334, 0.6666667, 1) float inputs:intensity = 0.75 }",
        ),
    ];
    let blank = |text: String| text.replace([' ', '\n'], "");
    for panorama in [RgbImage::new(1, 1, vec![radiance]), RgbImage::from_fn(8, 4, |_, _| radiance)]
    {
        for (target, name, words) in written {
            let (folder, told) = exported(Some(around(panorama.clone(), 30.0)), target);
            assert_eq!(told, Warnings::default(), "{target}");
            assert!(blank(text(folder.path(), name)).contains(&blank(words.into())), "{target}");
            for file in ["environment.exr", "environment.hdr"] {
                assert!(!folder.path().join(file).exists(), "{target}");
            }
        }
    }
}

/// Our readers of these formats find the same light; rows that Mitsuba has at the poles are half a row off.
#[test]
fn environments_come_back() {
    for (target, file) in [(Target::Mitsuba, "scene.xml"), (Target::Radiance, "scene.rad")] {
        for case in [around(motley(64, 32), -130.0), around(motley(8, 4), 75.0)] {
            let (folder, _) = exported(Some(case.clone()), target);
            let (back, warnings) = load_scene(&folder.path().join(file)).unwrap();
            assert_eq!(warnings, Warnings::default(), "{target}");
            let back = back.environment.unwrap();
            let off = off(&|d| back.radiance(d), &case);
            assert!(off < 0.01, "{target}: {off}");
        }
        let uniform = around(RgbImage::new(1, 1, vec![Rgb::new(0.25, 0.5, 0.75)]), 0.0);
        let (folder, _) = exported(Some(uniform.clone()), target);
        let (back, _) = load_scene(&folder.path().join(file)).unwrap();
        assert!(off(&|d| back.environment.as_ref().unwrap().radiance(d), &uniform) < 1e-6);
    }
}

#[test]
fn formats_without_environments_say_what_they_leave_out() {
    for target in [Target::Gltf, Target::Materialx] {
        let (_folder, told) = exported(Some(around(motley(64, 32), -130.0)), target);
        let [told] = &told.0[..] else { panic!("{told:?}") };
        for words in
            ["64 x 32 pixels", "middle what lies along -z", "turned about +y by -130.0", "is [1.2"]
        {
            assert!(told.contains(words), "{target}: {told}");
        }
        let uniform = around(RgbImage::new(1, 1, vec![Rgb::new(0.25, 0.5, 0.75)]), 0.0);
        let (_folder, told) = exported(Some(uniform), target);
        assert!(told.0[0].contains("[0.25, 0.5, 0.75] from everywhere"), "{told:?}");
    }
    // Without light there is nothing to say.
    let black = around(RgbImage::new(2, 1, vec![Rgb::ZERO; 2]), 0.0);
    for around in [None, Some(black)] {
        for target in Target::ALL {
            let (folder, told) = exported(around.clone(), target);
            assert_eq!(told, Warnings::default(), "{target}");
            assert!(!folder.path().join("environment.exr").exists(), "{target}");
        }
    }
}
