//! Mitsuba 3: `scene.xml` with its meshes as PLY and its pictures as EXR.
//!
//! Diffuse surfaces and mirrors are Mitsuba's own. A glossy one is a blend of `diffuse` and
//! `roughconductor`, whose microfacets are Beckmann's, with a reflectance of one that
//! `specular_reflectance` scales: in a blend of weight `b` the parts are `rho_d/(1-b)` and `rho_s/b`.
//! [Jakob et al., Mitsuba 3 documentation, plugin reference]

mod detail;
mod glass;
mod lights;
mod materials;
mod sensor;

use super::identifiers::{Ids, quoted};
use super::{Files, SceneView, far, maps, ply, tiling};
use crate::glasses::Glasses;
use crate::numbers::triple_at;
use glam::{Affine3A, DVec3, Mat4, Vec3};
use std::fmt::Write;
use unrender_scene::origin::in_digits;
use unrender_scene::{Object, Warnings};

/// The files of `shot`.
///
/// # Errors
/// If a texture cannot be encoded.
pub(super) fn export(shot: &SceneView) -> Result<(Files, Warnings), String> {
    let (mut files, mut warnings) = (Files::new(), Warnings::default());
    let mut xml = String::from(
        "<!-- A scene for Mitsuba 3, written by unrender. Render it with: mitsuba scene.xml -->\n\
         <scene version=\"3.0.0\">\n\
         \x20   <integrator type=\"path\">\n\
         \x20       <integer name=\"max_depth\" value=\"-1\"/>\n\
         \x20       <integer name=\"rr_depth\" value=\"16\"/>\n\
         \x20   </integrator>\n",
    );
    far::warn(shot.scene, "Mitsuba", far::WRITTEN_THERE, &mut warnings);
    xml.push_str(&sensor::text(shot, &mut warnings));
    let glasses = Glasses::of(shot.scene);
    let ids = Ids::of(shot.scene, &glasses);
    for (index, id) in ids.groups.iter().enumerate() {
        let (text, pictures) = materials::bsdf(shot, index, id, &mut warnings)?;
        xml.push_str(&text);
        files.extend(pictures);
    }
    xml.push_str(&glass::bsdfs(&glasses, &ids.kinds, &mut warnings));
    let named = shot.scene.objects.iter().map(|object| (object.name.as_str(), &object.mesh));
    maps::warn_of_halves(named, "Mitsuba", &mut warnings);
    for (object, id) in shot.scene.objects.iter().zip(&ids.objects) {
        if !object.mesh.triangles.is_empty() {
            let path = format!("mesh/{id}.ply");
            files.push((
                path.clone(),
                ply::bytes(&tiling::mesh(
                    shot,
                    object,
                    shot.materials[object.group].theta_rad,
                    tiling::From::Top,
                )),
            ));
            let suffix = maps::suffix(maps::is_mirrored(&object.mesh));
            let material = format!("{}{suffix}", ids.groups[object.group]);
            xml.push_str(&object_text(shot, object, &path, &material));
        }
    }
    for (shape, id) in glasses.shapes.iter().zip(&ids.shapes) {
        let path = format!("mesh/{id}.ply");
        files.push((path.clone(), ply::bytes(shape.mesh)));
        let material = &ids.kinds[shape.kind];
        xml.push_str(&shape_text(&shape.name, &path, material, shot.scene.origin, ""));
    }
    let (text, pictures) = lights::text(shot, &mut warnings)?;
    xml.push_str(&text);
    files.extend(pictures);
    xml.push_str("</scene>\n");
    files.push(("scene.xml".into(), xml.into_bytes()));
    Ok((files, warnings))
}

fn object_text(shot: &SceneView, object: &Object, path: &str, material: &str) -> String {
    let group = &shot.scene.groups[object.group];
    let mut emitter = String::new();
    if group.is_emitter() {
        let radiance = rgb("radiance", group.emission);
        emitter = format!("        <emitter type=\"area\">{radiance}</emitter>\n");
    }
    shape_text(&object.name, path, material, shot.scene.origin, &emitter)
}

fn shape_text(name: &str, path: &str, material: &str, origin: DVec3, inside: &str) -> String {
    let mut text = format!(
        "    {}\n    <shape type=\"ply\">\n\
         \x20       <string name=\"filename\" value=\"{path}\"/>\n\
         \x20       <ref id=\"{material}\"/>\n",
        comment("object", name)
    );
    if origin != DVec3::ZERO {
        let [x, y, z] = origin.to_array();
        let _ = writeln!(
            text,
            "        <transform name=\"to_world\"><translate x=\"{x}\" y=\"{y}\" z=\"{z}\"/></transform>"
        );
    }
    text.push_str(inside);
    text.push_str("    </shape>\n");
    text
}

/// A comment with the name of something; two hyphens may not stand in one.
fn comment(what: &str, name: &str) -> String {
    safe(&format!("{what} {}", quoted(name)))
}

fn safe(text: &str) -> String {
    format!("<!-- {} -->", text.replace("--", "\\u002d\\u002d"))
}

fn rgb(name: &str, value: Vec3) -> String {
    format!("<rgb name=\"{name}\" value=\"{} {} {}\"/>", value.x, value.y, value.z)
}

/// A reflectance; parts of a blend may have one above one, which Mitsuba wants stated.
fn reflectance(name: &str, value: Vec3) -> String {
    if value.max_element() <= 1.0 {
        return rgb(name, value);
    }
    let color = rgb("color", value);
    format!(
        "<spectrum type=\"srgb\" name=\"{name}\">{color}<boolean name=\"unbounded\" \
         value=\"true\"/></spectrum>"
    )
}

fn float(name: &str, value: f32) -> String {
    format!("<float name=\"{name}\" value=\"{value}\"/>")
}

fn vector(name: &str, v: Vec3) -> String {
    format!("<vector name=\"{name}\" x=\"{}\" y=\"{}\" z=\"{}\"/>", v.x, v.y, v.z)
}

/// A point that counts from `origin`.
fn point(name: &str, here: Vec3, origin: DVec3) -> String {
    let [x, y, z] = triple_at(origin, here);
    format!("<point name=\"{name}\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")
}

/// `to_world` as a matrix, row by row, of a transform to positions that count from `origin`.
fn to_world(here_from_local: Affine3A, origin: DVec3) -> String {
    let mut rows = Mat4::from(here_from_local).transpose().to_cols_array().map(|v| v.to_string());
    for axis in 0..3 {
        let here = here_from_local.translation[axis];
        rows[4 * axis + 3] = in_digits(origin[axis], here).to_string();
    }
    let numbers = rows.join(" ");
    format!("<transform name=\"to_world\"><matrix value=\"{numbers}\"/></transform>")
}
