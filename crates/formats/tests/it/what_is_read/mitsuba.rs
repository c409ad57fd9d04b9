//! Mitsuba: each plugin in the smallest scene that has it, and each of its properties in that scene.

use super::{assert_taken, rows};
use crate::mitsuba_meshes::serialized;
use crate::support::Folder;
use unrender_formats::import::mitsuba;
use unrender_formats::picture;
use unrender_formats::what_is_read::Row;
use unrender_scene::{Rgb, RgbImage, Warnings};

/// The warnings of a scene of `inside`, all in one line.
fn read(inside: &str) -> Result<Warnings, String> {
    let folder = Folder::new();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    folder.file("q.obj", triangle);
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                  property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    folder.file("q.ply", format!("{header}0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
    folder.file("q.serialized", serialized(4, &[1.0], false));
    folder.file("part.xml", "<scene version=\"3.0.0\"></scene>");
    let image = RgbImage::new(2, 1, vec![Rgb::splat(0.5); 2]);
    picture::write_png_srgb(&folder.path("p.png"), &image).unwrap();
    picture::write_hdr(&folder.path("p.hdr"), &image).unwrap();
    let scene = format!("<scene version=\"3.0.0\">{inside}</scene>");
    let read = mitsuba::read(&folder.file("scene.xml", scene));
    read.map(|(_, warnings)| warnings).map_err(|error| error.to_string())
}

/// As XML, a picture of normals.
fn normals() -> String {
    let picture =
        "<string name=\"filename\" value=\"p.png\"/><boolean name=\"raw\" value=\"true\"/>";
    format!("<texture type=\"bitmap\">{picture}</texture>")
}

/// As XML, the property `name` of a plugin of the type `within`.
fn property(within: &str, name: &str) -> String {
    let element = |tag: &str, value: &str| format!("<{tag} name=\"{name}\" value=\"{value}\"/>");
    match name {
        "<bsdf>" if within == "blendbsdf" => "<bsdf type=\"diffuse\"/>".repeat(2),
        "<bsdf>" => "<bsdf type=\"diffuse\"/>".into(),
        "<emitter>" if within == "scene" => "<emitter type=\"constant\"/>".into(),
        "<emitter>" => "<emitter type=\"area\"/>".into(),
        "<shape>" if within == "instance" => {
            "<shape type=\"shapegroup\"><shape type=\"cube\"/></shape>".into()
        }
        "<shape>" => "<shape type=\"cube\"/>".into(),
        "<sensor>" => "<sensor type=\"perspective\"/>".into(),
        "<texture>" if within.ends_with("map") => normals(),
        "<texture>" => "<texture type=\"srgb\"/>".into(),
        plugin if plugin.starts_with('<') => plugin.replace('>', " type=\"any\"/>"),
        "to_world" | "to_uv" => {
            format!("<transform name=\"{name}\"><translate x=\"1\"/></transform>")
        }
        "flip_normals" | "face_normals" | "flip_tex_coords" | "raw" | "nonlinear"
        | "sample_visible" | "unbounded" | "mis_compensation" | "compensate" | "sample_border"
        | "banner" | "high_quality_edges" | "accel" | "attach_log" | "complex_sun" | "extend"
        | "use_fast_approx" => element("boolean", "true"),
        "filename" => {
            let file = match within {
                "bitmap" => "p.png",
                "envmap" => "p.hdr",
                "ply" => "q.ply",
                "obj" => "q.obj",
                _ => "q.serialized",
            };
            element("string", file)
        }
        "filter_type" => element("string", "nearest"),
        "wrap_mode" => element("string", "mirror"),
        "distribution" => element("string", "ggx"),
        "variant" => element("string", "ward"),
        "material" => element("string", "Au"),
        "int_ior" | "ext_ior" | "ext_eta" => element("string", "water"),
        "focal_length" => element("string", "35mm"),
        "fov_axis" => element("string", "y") + "<float name=\"fov\" value=\"40\"/>",
        "values" => element("string", "0.5 0.5"),
        "wavelengths" => element("string", "400 700"),
        "pixel_format" | "component_format" | "file_format" | "compression" | "format" => {
            element("string", "any")
        }
        "center" | "p0" | "position" | "direction" => element("point", "0 0 -1"),
        "p1" => element("point", "0 0 2"),
        "reflectance"
        | "diffuse_reflectance"
        | "specular_reflectance"
        | "specular_transmittance"
        | "base_color"
        | "albedo"
        | "color"
        | "color0"
        | "color1"
        | "radiance"
        | "intensity"
        | "irradiance"
        | "texture" => element("rgb", "0.5 0.4 0.3"),
        "value" if within.ends_with("regular") => element("spectrum", "400:0.5, 700:0.5"),
        "shape_index" => element("integer", "0"),
        "wavelength_min" | "lambda_min" => element("float", "400"),
        "wavelength_max" | "lambda_max" => element("float", "700"),
        // Without an index, any extinction is a perfect mirror.
        "k" => element("float", "2") + "<float name=\"eta\" value=\"1.5\"/>",
        "temperature" => element("float", "3000"),
        "opacity" => element("float", "1"),
        "width" | "height" | "crop_width" | "crop_height" => element("integer", "100"),
        "crop_offset_x" => {
            element("integer", "10") + "<integer name=\"crop_width\" value=\"100\"/>"
        }
        "crop_offset_y" => {
            element("integer", "10") + "<integer name=\"crop_height\" value=\"100\"/>"
        }
        "fov" | "cutoff_angle" | "beam_width" => element("float", "15"),
        _ => {
            of_sky(name).map_or_else(|| element("float", "0.5"), |(tag, value)| element(tag, value))
        }
    }
}

/// The element and the value of the property `name` of a sky, if a half is no value of it.
fn of_sky(name: &str) -> Option<(&'static str, &'static str)> {
    Some(match name {
        "sun_direction" => ("vector", "1 0 2"),
        "turbidity" => ("float", "4"),
        "stretch" => ("float", "1.5"),
        "hour" => ("float", "11"),
        "timezone" => ("float", "8"),
        "year" => ("integer", "2012"),
        "month" | "day" => ("integer", "8"),
        "resolution" => ("integer", "64"),
        _ => return None,
    })
}

/// The properties that a plugin of the type `kind` must have.
fn needed(kind: &str) -> &'static [&'static str] {
    match kind {
        "ply" | "obj" | "serialized" | "bitmap" | "envmap" => &["filename"],
        "instance" => &["<shape>"],
        "mask" => &["<bsdf>", "opacity"],
        "twosided" | "blendbsdf" | "coating" | "roughcoating" => &["<bsdf>"],
        "bumpmap" | "normalmap" => &["<bsdf>", "<texture>"],
        "roughconductor" => &["distribution"],
        "blackbody" => &["temperature"],
        "regular" => &["values"],
        "irregular" => &["wavelengths", "values"],
        _ => &[],
    }
}

/// A scene with a plugin of `tag` and `kind` that has all that it needs, and the property `name`.
fn scene(tag: &str, kind: &str, name: Option<&str>) -> String {
    let is_whole = name == Some("value") && kind.ends_with("regular");
    let others = needed(kind).iter().filter(|other| Some(**other) != name && !is_whole);
    let others = others.map(|other| property(kind, other));
    // A wide sun needs a quarter of the panorama's pixels.
    let is_narrow = kind == "sunsky" && name != Some("sun_aperture");
    let wide = is_narrow.then(|| "<float name=\"sun_aperture\" value=\"10\"/>".to_owned());
    let inside: String = others.chain(name.map(|name| property(kind, name))).chain(wide).collect();
    let plugin = |tag: &str, more: &str| {
        let kind = if kind == "others" { "curvy" } else { kind };
        format!("<{tag} type=\"{kind}\"{more}>{inside}</{tag}>")
    };
    match tag {
        "scene" => inside,
        "bsdf" => format!("<shape type=\"cube\">{}</shape>", plugin(tag, "")),
        "texture" if kind == "blackbody" => {
            let light = plugin("spectrum", " name=\"radiance\"");
            format!("<emitter type=\"constant\">{light}</emitter>")
        }
        "texture" => {
            let painted = plugin(tag, " name=\"reflectance\"");
            format!("<shape type=\"cube\"><bsdf type=\"diffuse\">{painted}</bsdf></shape>")
        }
        "emitter" if kind == "area" => format!("<shape type=\"cube\">{}</shape>", plugin(tag, "")),
        "sensor" if kind == "film" => {
            format!("<sensor type=\"perspective\">{}</sensor>", plugin("film", ""))
        }
        _ => plugin(tag, ""),
    }
}

/// The warnings of `whole` that `base` does not cause; numbers are not compared.
fn added(base: &str, whole: &str) -> Result<Warnings, String> {
    let words = |warning: &String| warning.replace(|c: char| c.is_ascii_digit() || c == '.', "");
    let base: Vec<String> = read(base)?.0.iter().map(words).collect();
    let mut whole = read(whole)?;
    whole.0.retain(|warning| !base.contains(&words(warning)));
    Ok(whole)
}

#[test]
fn every_plugin_and_every_property_is_taken_as_its_row_says() {
    for (title, tag) in [
        ("Mitsuba: the scene", "scene"),
        ("Mitsuba: shapes", "shape"),
        ("Mitsuba: BSDFs", "bsdf"),
        ("Mitsuba: textures and spectra", "texture"),
        ("Mitsuba: emitters", "emitter"),
        ("Mitsuba: sensors and films", "sensor"),
    ] {
        for row in rows(title) {
            let Row { within, element, .. } = row;
            let kind = match within {
                "shapes" => "cube",
                "emitters" => "constant",
                "sunsky, sky and sun" => "sunsky",
                "sensors" => "perspective",
                kind => kind,
            };
            if kind.is_empty() {
                assert_taken(&row, "", read(&scene(tag, element, None)));
            } else {
                let whole = scene(tag, kind, Some(element));
                // Without what it needs there is nothing to compare with.
                let told = if needed(kind).contains(&element) {
                    read(&whole).map(|mut told| {
                        told.0.retain(|warning| warning.contains("is not read"));
                        told
                    })
                } else {
                    added(&scene(tag, kind, None), &whole)
                };
                assert_taken(&row, "", told);
            }
        }
    }
}

#[test]
fn every_element_is_taken_as_its_row_says() {
    let shape = |inside: &str| format!("<shape type=\"sphere\">{inside}</shape>");
    let moved = |step: &str| shape(&format!("<transform name=\"to_world\">{step}</transform>"));
    let light = |inside: &str| format!("<emitter type=\"constant\">{inside}</emitter>");
    for row in rows("Mitsuba: elements") {
        let inside = match row.element {
            "shape" => shape(""),
            "bsdf" => "<bsdf type=\"diffuse\"/>".into(),
            "emitter" => light(""),
            "sensor" => "<sensor type=\"perspective\"/>".into(),
            "float" | "integer" => light(&format!("<{} name=\"radiance\" value=\"1\"/>", row.element)),
            "boolean" => shape("<boolean name=\"flip_normals\" value=\"True\"/>"),
            "string" => {
                "<sensor type=\"perspective\"><string name=\"focal_length\" value=\"35mm\"/></sensor>"
                    .into()
            }
            "srgb" => light("<srgb name=\"radiance\" value=\"#102030\"/>"),
            "rgb" => light("<rgb name=\"radiance\" value=\"1 2 3\"/>"),
            "spectrum" => light("<spectrum name=\"radiance\" value=\"400:1 700:2\"/>"),
            "point" => shape("<point name=\"center\" x=\"1\" y=\"2\" z=\"3\"/>"),
            "vector" => shape("<vector name=\"center\" value=\"1, 2, 3\"/>"),
            "include" => "<include filename=\"part.xml\"/>".into(),
            "default" => "<default name=\"a\" value=\"1\"/>".into(),
            "path" => "<path value=\".\"/>".into(),
            "alias" => "<bsdf type=\"diffuse\" id=\"a\"/><alias id=\"a\" as=\"b\"/>".into(),
            "ref" => shape("<ref id=\"a\"/>") + "<bsdf type=\"diffuse\" id=\"a\"/>",
            "transform" => moved(""),
            "translate" => moved("<translate x=\"1\"/>"),
            "scale" => moved("<scale value=\"2\"/>"),
            "rotate" => moved("<rotate y=\"1\" angle=\"30\"/>"),
            "lookat" => moved("<lookat origin=\"0, 0, 0\" target=\"1, 0, 0\" up=\"0, 0, 1\"/>"),
            "matrix" => moved("<matrix value=\"1 0 0 0 1 0 0 0 1\"/>"),
            plugin => format!("<{plugin} type=\"any\"/>"),
        };
        assert_taken(&row, "", read(&inside));
    }
    assert!(read("<blob/>").is_err());
    assert!(read(&moved("<blob/>")).is_err());
}
