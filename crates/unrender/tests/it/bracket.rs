//! Brackets of exposures by the command line and in projects.

use crate::kit::floor_and_lamp;
use crate::kit::folder::{Folder, is_refused, stderr, succeeds};
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use std::path::Path;
use std::process::Output;
use unrender::formats::picture::{self, Depth};
use unrender::formats::{gltf, response_curve};
use unrender::photo::Response;
use unrender::project::ResponseChoice;
use unrender::scene::color::srgb_from_linear;
use unrender::scene::{Image, Picture, Rgb, RgbImage};
use unrender::{Job, Project};

const SIZE: (usize, usize) = (96, 72);
const TIMES: [f32; 3] = [0.125, 0.5, 2.0];
const STATED: &str = "1/8,1/2,2";

/// Fields of eight by eight pixels over three decades; the longest exposures clip the brightest of
/// them.
fn radiance(x: usize, y: usize) -> f32 {
    let field = (x / 8 * 7919 + y / 8 * 104_729) % 1000;
    4e-3 * 10f32.powf(3.0 * field as f32 / 1000.0)
}

/// A folder with a bracket of 8-bit sRGB pictures.
fn bracket() -> Folder {
    let folder = Folder::new();
    for (name, time) in ["a.png", "b.png", "c.png"].iter().zip(TIMES) {
        let code = |x, y| Rgb::splat(srgb_from_linear((time * radiance(x, y)).min(1.0)));
        let codes = RgbImage::from_fn(SIZE.0, SIZE.1, code);
        picture::write_png_codes(&folder.path(name), &codes, Depth::Eight).unwrap();
    }
    folder
}

/// Merges the bracket, with `more` arguments.
fn merge(folder: &Folder, more: &[&str]) -> Output {
    folder.run(&[&["merge-exposures", "a.png", "b.png", "c.png"], more].concat())
}

/// The picture `name` of the folder.
fn read(folder: &Folder, name: &str) -> Picture {
    picture::read(&folder.path(name)).unwrap().0
}

/// The largest error of the merged picture relative to the radiance, after scaling by one factor, and the
/// error of that factor, the best exposed photograph's white, which is extrapolated.
fn errors(merged: &Picture) -> [f32; 2] {
    let white = merged.merged.as_ref().unwrap().white_level.x;
    let mut ratios = Vec::new();
    for (x, y) in (0..SIZE.0 * SIZE.1).map(|i| (i % SIZE.0, i / SIZE.0)) {
        // Only the insides of fields: their borders lie beside clipped pixels.
        let inside = (1..7).contains(&(x % 8)) && (1..7).contains(&(y % 8));
        let value = merged.values.at(x, y).x;
        if inside && radiance(x, y) > 0.04 && value < white {
            ratios.push(value / radiance(x, y));
        }
    }
    assert!(ratios.len() > 1000, "{}", ratios.len());
    ratios.sort_by(f32::total_cmp);
    let middle = ratios[ratios.len() / 2];
    let worst = (ratios[ratios.len() - 1] / middle - 1.0).max(1.0 - ratios[0] / middle);
    let unit = TIMES.map(|time| (middle / time - 1.0).abs()).into_iter().fold(1.0, f32::min);
    [worst, unit]
}

#[test]
fn a_bracket_becomes_one_picture() {
    let folder = bracket();
    let flags = ["--times", STATED, "--out", "m.exr", "--response-out", "curve.csv"];
    let output = merge(&folder, &flags);
    let text = succeeds(&output);
    assert!(
        text.contains("reference: 1 is its white") && text.contains("response found"),
        "{text}"
    );
    let merged = read(&folder, "m.exr");
    let [worst, unit] = errors(&merged);
    assert!(worst < 0.03 && unit < 0.05, "{worst} {unit}");
    let variance = &merged.merged.as_ref().unwrap().variance;
    assert!(variance.pixels().iter().any(|v| v.x > 0.0));
    let rows = response_curve::read(&folder.path("curve.csv")).unwrap();
    assert_eq!(rows.codes.len(), 256);
    // The response as a file, and as a name.
    for response in ["curve.csv", "srgb"] {
        let output = merge(&folder, &["--times", STATED, "--response", response, "--out", "n.exr"]);
        succeeds(&output);
        let [worst, unit] = errors(&read(&folder, "n.exr"));
        assert!(worst < 0.03 && unit < 0.05, "{response}: {worst} {unit}");
    }
    // Floating-point files need none.
    for (name, time) in ["a.exr", "b.exr"].iter().zip(TIMES) {
        let image = Image::from_fn(SIZE.0, SIZE.1, |x, y| Rgb::splat(time * radiance(x, y)));
        picture::write(&folder.path(name), &image).unwrap();
    }
    let output = folder.run(&[
        "merge-exposures",
        "a.exr",
        "b.exr",
        "--times",
        "0.125,0.5",
        "--out",
        "f.exr",
    ]);
    succeeds(&output);
    let merged = read(&folder, "f.exr");
    assert!(merged.merged.is_some_and(|merged| merged.white_level == Rgb::INFINITY));
    let ratio = merged.values.at(4, 4).x / radiance(4, 4);
    assert!((ratio / 0.5 - 1.0).abs() < 1e-4, "{ratio}");
}

#[test]
fn what_is_merged_is_read_back() {
    let folder = bracket();
    let variance = RgbImage::from_fn(3, 2, |x, y| Rgb::splat(0.01 * (x + y) as f32));
    let values = RgbImage::from_fn(3, 2, |x, y| Rgb::new(x as f32, y as f32, 7.0));
    let white_level = Rgb::new(9.0, 10.0, 11.0);
    let merged = Some(picture::Merged { variance, white_level });
    let mut written = Picture { merged, ..Picture::new(values, Depth::Float) };
    written.is_linear = true;
    written.invalid = vec![4];
    written.values.pixels_mut()[4] = Rgb::ZERO;
    written.merged.as_mut().unwrap().variance.pixels_mut()[4] = Rgb::ZERO;
    picture::write_merged(&folder.path("m.exr"), &written).unwrap();
    // The file states the primaries of sRGB.
    written.profile = read(&folder, "m.exr").profile;
    assert!(written.profile.as_ref().unwrap().srgb_from_file.is_none());
    assert_eq!(read(&folder, "m.exr"), written);
    written.merged.as_mut().unwrap().white_level = Rgb::INFINITY;
    picture::write_merged(&folder.path("m.exr"), &written).unwrap();
    assert_eq!(read(&folder, "m.exr"), written);
    written.merged.as_mut().unwrap().white_level = Rgb::new(1.0, -1.0, 1.0);
    picture::write_merged(&folder.path("m.exr"), &written).unwrap();
    let fault = picture::read(&folder.path("m.exr")).unwrap_err().to_string();
    assert!(fault.contains("unrenderWhiteLevel that is not above zero"), "{fault}");
}

#[test]
fn faults_are_said_and_nothing_is_written() {
    let folder = bracket();
    let small = RgbImage::from_fn(8, 8, |_, _| Rgb::splat(0.5));
    picture::write_png_codes(&folder.path("small.png"), &small, Depth::Eight).unwrap();
    let black = RgbImage::from_fn(SIZE.0, SIZE.1, |_, _| Rgb::ZERO);
    picture::write_png_codes(&folder.path("black.png"), &black, Depth::Eight).unwrap();
    let out = ["--out", "m.exr"];
    for (words, problem) in [
        (&["a.png", "--times", "1"][..], "there is 1"),
        (
            &["a.png", "b.png"],
            "a.png: states no exposure time; give those of all photographs of the bracket by --times",
        ),
        (&["a.png", "b.png", "--times", "1,1"], "same exposure"),
        (&["a.png", "b.png", "--times", "1,nan"], "is nan; give positive numbers"),
        (&["a.png", "b.png", "--times", "1,0"], "is 0; give positive numbers"),
        (&["a.png", "b.png", "--times", "1,1/0"], "is 1/0; give positive numbers"),
        (&["a.png", "b.png", "--times", "1,2,3"], "there are 3 exposure times for 2"),
        (&["a.png", "small.png", "--times", "1,2"], "8 x 8 pixels, but a.png has 96 x 72"),
        (&["a.png", "none.png", "--times", "1,2"], "none.png: cannot be read: it does not exist"),
        (&["a.png", "black.png", "--times", "1,2"], "black.png is darker than a.png"),
        (&["black.png", "a.png", "--times", "1,2"], "too few places are well exposed"),
        // Times in another order than the photographs, and one photograph twice.
        (
            &["a.png", "b.png", "c.png", "--times", "1/2,1/8,2"],
            "From dark to bright the photographs are a.png, b.png, c.png; by their exposures they are \
             b.png, a.png, c.png",
        ),
        (
            &["a.png", "b.png", "--times", "1,0.25", "--response", "srgb"],
            "a.png is darker than b.png, but its exposure is stated to be longer",
        ),
        (
            &["a.png", "b.png", "b.png", "--times", "1/8,1/2,2"],
            "b.png and b.png are the same picture",
        ),
        (
            &["a.png", "b.png", "--times", "1,4", "--response", "none.csv"],
            "none.csv: cannot be read",
        ),
        (&["a.png", "b.png", "--times", "1,4", "--black-level", "0.6"], "from 0 to below 0.5"),
        (
            &["a.png", "b.png", "--times", "1,4", "--response", "srgb", "--response-out", "r.csv"],
            "no response was found, as it is stated",
        ),
    ] {
        let output = folder.run(&[&["merge-exposures"], words, &out].concat());
        is_refused(&output, problem);
        assert!(!folder.path("m.exr").exists() && !folder.path("r.csv").exists(), "{words:?}");
    }
    let output = merge(&folder, &["--times", STATED, "--out", "m.png"]);
    assert!(stderr(&output).contains("end the name of the merged picture in .exr"));
}

#[test]
fn projects_name_brackets() {
    let folder = bracket();
    folder.write("scene.glb", &gltf::to_glb(&floor_and_lamp::scene()).unwrap());
    let bracket =
        "photo = { bracket = [\"a.png\", \"b.png\", \"c.png\"], times = [\"1/8\", 0.5, 2] }";
    let text = |photo: &str| format!("scene = \"scene.glb\"\n{photo}\nexposure = 3\n");
    folder.write("p.toml", &text(bracket));
    let (project, warnings) = Project::read(&folder.path("p.toml")).unwrap();
    assert_eq!((project.inputs().len(), project.photo.clone()), (5, folder.path("a.png")));
    let job = Job::load(project, warnings).unwrap();
    assert_eq!(job.transfer.response, Response::Linear);
    assert_eq!(job.project.response, Some(ResponseChoice::Stated(Response::Linear)));
    let ratio = job.photo.radiance.at(20, 20).x / (3.0 * radiance(20, 20));
    assert!([0.125, 0.5, 2.0].iter().any(|unit| (ratio / unit - 1.0).abs() < 0.06), "{ratio}");
    // Its noise is that of the merged values, and the pixels that the shortest exposure clips are
    // clipped.
    let variance = job.picture.merged.as_ref().unwrap().variance.at(20, 20).x;
    let step = job.photo.quantisation_step.at(20, 20).x;
    assert!((step / (3.0 * (12.0 * variance).sqrt()) - 1.0).abs() < 1e-4);
    let white = job.picture.merged.as_ref().unwrap().white_level.x;
    assert!(job.transfer.white_level.x == white && white.is_finite());
    // The merged file is the same photograph.
    let output = merge(&folder, &["--times", STATED, "--out", "m.exr", "--quiet"]);
    succeeds(&output);
    folder.write("m.toml", &text("photo = \"m.exr\""));
    let (project, warnings) = Project::read(&folder.path("m.toml")).unwrap();
    let merged = Job::load(project, warnings).unwrap();
    assert!(merged.photo == job.photo && merged.transfer.white_level == job.transfer.white_level);
    // A missing file, and times one of which is not a number.
    std::fs::remove_file(folder.path("b.png")).unwrap();
    let fault = Project::read(&folder.path("p.toml")).unwrap_err().to_string();
    assert!(fault.contains("photo.bracket: there is no file"), "{fault}");
    for (photo, problem) in [
        ("photo = { bracket = [\"a.png\"] }", "photo.bracket names 1 photograph(s)"),
        ("photo = { bracket = [\"a.png\", \"c.png\"], times = [1, nan] }", "a time is nan"),
        ("photo = { bracket = [\"a.png\", \"c.png\"], times = [1] }", "has 1 times for 2"),
        ("photo = { bracket = 3 }", "line 2"),
    ] {
        let error = Project::parse(Path::new("p.toml"), &text(photo)).unwrap_err().to_string();
        assert!(error.contains(problem), "{photo}: {error}");
    }
    for (times, problem) in [
        ("", "give those of all photographs of the bracket in the project, as in photo = {"),
        (", times = [1, 1]", "same exposure"),
        (", times = [2, 1]", "From dark to bright the photographs are a.png, c.png"),
    ] {
        let photo = format!("photo = {{ bracket = [\"a.png\", \"c.png\"]{times} }}");
        folder.write("p.toml", &text(&photo));
        let (project, warnings) = Project::read(&folder.path("p.toml")).unwrap();
        let error = Job::load(project, warnings).unwrap_err().to_string();
        assert!(error.contains(problem), "{times}: {error}");
    }
}

/// Slanted edges, texture and shading over two decades; with `with_thing`, a dark object in the middle.
fn still_life(x: usize, y: usize, with_thing: bool) -> [f32; 3] {
    let slanted = x + y / 3;
    let field = (slanted / 37 * 7919 + y / 41 * 104_729) % 1000;
    let grain = if field.is_multiple_of(3) { ((x * 31 + y * 17) % 7) as f32 / 12.0 } else { 0.0 };
    let level = 0.015 * 10f32.powf(2.0 * field as f32 / 1000.0) * (0.8 + grain);
    let is_thing = with_thing && (110..170).contains(&x) && (80..140).contains(&y);
    let level = if is_thing { 0.01 } else { level };
    let hue = field as f32 / 1000.0;
    [level * (1.0 - 0.5 * hue), 0.9 * level, level * (0.5 + 0.5 * hue)]
}

/// Writes a photograph of [`still_life`] as a JPEG, with the noise of a camera.
fn write_jpeg(path: &Path, time: f32, with_thing: bool) {
    let (width, height) = (320, 240);
    let mut codes = Vec::new();
    let mut state = u64::from(time.to_bits());
    let mut uniform = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    for (x, y) in (0..width * height).map(|i| (i % width, i / width)) {
        for light in still_life(x, y, with_thing) {
            let normal = (0..12).map(|_| uniform()).sum::<f32>() - 6.0;
            let light = time * light;
            let light = light + (4e-7 + 1e-4 * light).sqrt() * normal;
            codes.push((255.0 * srgb_from_linear(light.clamp(0.0, 1.0))).round() as u8);
        }
    }
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, 85)
        .encode(&codes, width as u32, height as u32, ExtendedColorType::Rgb8)
        .unwrap();
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn the_errors_of_jpeg_are_no_motion_and_motion_is_seen_beside_them() {
    let folder = Folder::new();
    let merge = |moved: bool| {
        for (name, time) in ["a.jpg", "b.jpg", "c.jpg"].iter().zip([0.5, 2.0, 8.0]) {
            write_jpeg(&folder.path(name), time, moved && time == 8.0);
        }
        let flags = ["--times", "0.5,2,8", "--out", "m.exr"];
        let output =
            folder.run(&[&["merge-exposures", "a.jpg", "b.jpg", "c.jpg"][..], &flags].concat());
        succeeds(&output);
        stderr(&output)
    };
    let still = merge(false);
    assert!(!still.contains("moved"), "{still}");
    let moved = merge(true);
    let says = "something moved between the photographs of the bracket, in ";
    let (_, share) = moved.split_once(says).unwrap_or_else(|| panic!("{moved}"));
    let share: f64 = share.split_once(' ').unwrap().0.parse().unwrap();
    // The object covers 4.7 % of the picture; parts of it are as bright as the background, or beside
    // edges.
    assert!((1.0..7.0).contains(&share), "{moved}");
}

#[test]
fn a_file_of_a_linear_format_needs_no_response() {
    let folder = bracket();
    folder.write("scene.glb", &gltf::to_glb(&floor_and_lamp::scene()).unwrap());
    succeeds(&merge(&folder, &["--times", STATED, "--out", "m.exr"]));
    let image = Image::from_fn(SIZE.0, SIZE.1, |x, y| Rgb::splat(radiance(x, y)));
    picture::write(&folder.path("r.exr"), &image).unwrap();
    picture::write(&folder.path("r.hdr"), &image).unwrap();
    for photo in ["m.exr", "r.exr", "r.hdr"] {
        folder.write(
            "p.toml",
            &format!("scene = \"scene.glb\"\nphoto = \"{photo}\"\nexposure = 1\n"),
        );
        let (project, warnings) = Project::read(&folder.path("p.toml")).unwrap();
        let job = Job::load(project, warnings).unwrap();
        assert_eq!(job.transfer.response, Response::Linear);
        assert!(!job.warnings.0.iter().any(|w| w.contains("response")), "{:?}", job.warnings);
    }
}
