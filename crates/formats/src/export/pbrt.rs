//! PBRT v4: `scene.pbrt` with its meshes as PLY and its pictures as EXR.
//!
//! It follows the format's documentation, unchecked: no package registry has the renderer. A
//! glossy surface is a `mix` of `diffuse` and `conductor`, whose `reflectance` is that at normal
//! incidence, with GGX microfacets. In a mix of amount `b` the parts are `rho_d/(1-b)` and `rho_s/b`.
//! The picture plane is given by `screenwindow` at a field of view of 90 degrees, where its units are
//! tangents. [Pharr, Jakob, Humphreys: pbrt-v4 input file format]

mod detail;
mod glass;
mod square;

use super::environment::{self, Around};
use super::identifiers::{Ids, identifiers, quoted};
use super::{Files, SceneView, far, maps, ply, profiles, tiling};
use crate::glasses::Glasses;
use crate::group_detail;
use crate::texels;
use glam::{Mat4, Vec3, Vec4};
use std::fmt::Write;
use unrender_scene::{LightKind, Object, Rgb, Warnings};

/// PBRT wants conductors' reflectances below one.
const HIGHEST: f32 = 0.9999;

/// The files of `shot`.
///
/// # Errors
/// If a texture cannot be encoded.
pub(super) fn export(shot: &SceneView) -> Result<(Files, Warnings), String> {
    let (mut files, mut warnings) = (Files::new(), Warnings::default());
    let mut text = String::from("# A scene for PBRT v4, written by unrender.\n");
    far::warn(shot.scene, "PBRT", far::WRITTEN_NEARER, &mut warnings);
    text.push_str(&camera(shot, &mut warnings));
    text.push_str("\nWorldBegin\n");
    let glasses = Glasses::of(shot.scene);
    let ids = Ids::of(shot.scene, &glasses);
    for (index, id) in ids.groups.iter().enumerate() {
        text.push_str(&material(shot, index, id, &mut files, &mut warnings)?);
    }
    text.push_str(&glass::materials(&glasses, &ids.kinds, &mut warnings));
    let lights = identifiers("l_", shot.scene.lights.iter().map(|l| l.name.as_str()));
    for (light, id) in shot.scene.lights.iter().zip(&lights) {
        let kind = profiles::without(light, "PBRT", &mut warnings);
        let _ = writeln!(text, "\n# light {}\n{}", quoted(&light.name), light_source(&kind));
        if matches!(light.kind, LightKind::Spot { .. }) {
            let name = &light.name;
            warnings
                .push(format!("light \"{name}\" ({id}): PBRT's spots fall off by another curve"));
        }
    }
    text.push_str(&infinite(shot, &mut files)?);
    let named = shot.scene.objects.iter().map(|object| (object.name.as_str(), &object.mesh));
    maps::warn_of_halves(named, "PBRT", &mut warnings);
    for (object, id) in shot.scene.objects.iter().zip(&ids.objects) {
        if !object.mesh.triangles.is_empty() {
            let path = format!("mesh/{id}.ply");
            text.push_str(&object_text(shot, object, &path, &ids.groups[object.group]));
            files.push((
                path,
                ply::bytes(&tiling::mesh(
                    shot,
                    object,
                    shot.materials[object.group].theta_rad,
                    tiling::From::Bottom,
                )),
            ));
        }
    }
    for (one, id) in glasses.shapes.iter().zip(&ids.shapes) {
        let path = format!("mesh/{id}.ply");
        text.push_str(&shape(&one.name, &path, &ids.kinds[one.kind], ["", ""]));
        files.push((path, ply::bytes(one.mesh)));
    }
    files.push(("scene.pbrt".into(), text.into_bytes()));
    Ok((files, warnings))
}

fn camera(shot: &SceneView, warnings: &mut Warnings) -> String {
    let camera = shot.camera;
    if camera.lens.distorts() {
        warnings.push(format!(
            "camera \"{}\": PBRT's perspective knows no distortion; the picture is that of the pinhole",
            camera.name
        ));
    }
    // PBRT's camera looks along +z, with x to the right and y up.
    let axes = camera.world_from_camera.matrix3;
    let [right, up, ahead] = [axes.x_axis, axes.y_axis, -axes.z_axis].map(Vec3::from);
    let row = |axis: Vec3| axis.extend(-axis.dot(camera.origin()));
    let camera_from_world =
        Mat4::from_cols(row(right), row(up), row(ahead), Vec4::W).transpose().to_cols_array();
    let numbers = camera_from_world.map(|v| v.to_string()).join(" ");
    let (width, height) = shot.size;
    let (x, y) = camera.principal_point(width, height);
    let pixel = 2.0 * (0.5 * camera.fov_y_rad).tan() / height as f32;
    let across = pixel / camera.lens.fx_over_fy;
    let window = [-x * across, (width as f32 - x) * across, (y - height as f32) * pixel, y * pixel];
    let window = window.map(|edge| edge.to_string());
    format!(
        "Transform [ {numbers} ]\n\
         # camera {}\n\
         Camera \"perspective\" \"float fov\" 90 \"float screenwindow\" [ {} ]\n\
         Film \"rgb\" \"integer xresolution\" {width} \"integer yresolution\" {height} \
         \"string filename\" \"picture.exr\"\n\
         PixelFilter \"box\" \"float xradius\" 0.5 \"float yradius\" 0.5\n\
         Sampler \"zsobol\" \"integer pixelsamples\" 256\n\
         Integrator \"path\" \"integer maxdepth\" 100\n",
        quoted(&camera.name),
        window.join(" ")
    )
}

fn material(
    shot: &SceneView,
    index: usize,
    id: &str,
    files: &mut Files,
    warnings: &mut Warnings,
) -> Result<String, String> {
    let (name, material) = (&shot.scene.groups[index].name, &shot.materials[index]);
    let amount = tiling::specular_share(material);
    let mut text = format!("\n# group {}\n", quoted(name));
    let mut diffuse = rgb("reflectance", material.rho_d / (1.0 - amount).max(1e-6));
    if let Some(texture) = &material.texture {
        let tile = tiling::tile(texture, tiling::copies(shot, index));
        let path = format!("textures/{id}.exr");
        files.push((path.clone(), texels::exr(&tile.image.map(|t| *t / (1.0 - amount)))?));
        let _ = writeln!(
            text,
            "Texture \"{id}_texture\" \"spectrum\" \"imagemap\" \"string filename\" \"{path}\" \
             \"string wrap\" \"{}\"",
            tile.mode()
        );
        diffuse = format!("\"texture reflectance\" \"{id}_texture\"");
        warnings.0.extend(tile.doubt.map(|doubt| format!("group \"{name}\": {doubt}")));
    }
    let metal = format!(
        "{} \"float uroughness\" {} \"float vroughness\" {} \"bool remaproughness\" false",
        rgb("reflectance", (material.rho_s / amount.max(1e-6)).min(Rgb::splat(HIGHEST))),
        material.alpha_x,
        material.alpha_y
    );
    text.push_str(&detail::holes(shot, index, id, files, warnings)?);
    for (id, map) in detail::normals(shot, index, id, files, warnings)? {
        named_material(
            &mut text,
            &id,
            amount,
            [&(diffuse.clone() + &map), &(metal.clone() + &map)],
        );
    }
    Ok(text)
}

/// The material called `id`, whose lobe has the share `amount` of a mix.
fn named_material(text: &mut String, id: &str, amount: f32, [diffuse, metal]: [&str; 2]) {
    match amount {
        0.0 => named(text, id, "diffuse", diffuse),
        1.0 => named(text, id, "conductor", metal),
        _ => {
            named(text, &format!("{id}_diffuse"), "diffuse", diffuse);
            named(text, &format!("{id}_shine"), "conductor", metal);
            let parts = format!(
                "\"string materials\" [ \"{id}_diffuse\" \"{id}_shine\" ] \"float amount\" {amount}"
            );
            named(text, id, "mix", &parts);
        }
    }
}

fn named(text: &mut String, id: &str, kind: &str, parameters: &str) {
    let _ = writeln!(text, "MakeNamedMaterial \"{id}\" \"string type\" \"{kind}\" {parameters}");
}

fn light_source(kind: &LightKind) -> String {
    match *kind {
        LightKind::Point { position, intensity } => {
            format!("LightSource \"point\" {} {}", rgb("I", intensity), point("from", position))
        }
        LightKind::Spot { position, direction, intensity, inner_rad, outer_rad } => format!(
            "LightSource \"spot\" {} {} {} \"float coneangle\" {} \"float conedeltaangle\" {}",
            rgb("I", intensity),
            point("from", position),
            point("to", position + direction),
            outer_rad.to_degrees(),
            (outer_rad - inner_rad).to_degrees()
        ),
        LightKind::Directional { direction, irradiance } => format!(
            "LightSource \"distant\" {} {} {}",
            rgb("L", irradiance),
            point("from", Vec3::ZERO),
            point("to", direction)
        ),
        // The caller has put a point in its place.
        LightKind::Profiled { .. } => String::new(),
    }
}

/// The light from all around, its panorama among `files`.
fn infinite(shot: &SceneView, files: &mut Files) -> Result<String, String> {
    let radiance = match environment::around(shot.scene) {
        None => return Ok(String::new()),
        Some(Around::Uniform(radiance)) => rgb("L", radiance),
        Some(Around::Panorama(environment)) => {
            files.push(environment::file(&square::panorama(&environment))?);
            format!("\"string filename\" \"{}\"", environment::FILE)
        }
    };
    Ok(format!("\n# environment\nLightSource \"infinite\" {radiance}\n"))
}

fn object_text(shot: &SceneView, object: &Object, path: &str, id: &str) -> String {
    let group = &shot.scene.groups[object.group];
    let mut lamp = String::new();
    if group.is_emitter() {
        lamp = format!("    AreaLightSource \"diffuse\" {}\n", rgb("L", group.emission));
    }
    let has_holes = group_detail::of_group(shot.scene, object.group).coverage.is_some();
    let has_holes = has_holes && !object.mesh.uvs.is_empty();
    let holes = if has_holes { detail::parameter(id) } else { String::new() };
    let material = format!("{id}{}", maps::suffix(maps::is_mirrored(&object.mesh)));
    shape(&object.name, path, &material, [&lamp, &holes])
}

fn shape(name: &str, path: &str, material: &str, [lamp, parameters]: [&str; 2]) -> String {
    format!(
        "\n# object {}\nAttributeBegin\n    NamedMaterial \"{material}\"\n{lamp}    \
         Shape \"plymesh\" \"string filename\" \"{path}\"{parameters}\nAttributeEnd\n",
        quoted(name)
    )
}

fn rgb(name: &str, v: Vec3) -> String {
    format!("\"rgb {name}\" [ {} {} {} ]", v.x, v.y, v.z)
}

fn point(name: &str, v: Vec3) -> String {
    format!("\"point3 {name}\" [ {} {} {} ]", v.x, v.y, v.z)
}
