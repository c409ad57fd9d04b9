//! PBRT v4: `scene.pbrt` with its meshes as PLY and its pictures as EXR.
//!
//! It follows the format's documentation, unchecked: no package registry has the renderer. A
//! glossy surface is a `mix` of `diffuse` and `conductor`, whose `reflectance` is that at normal
//! incidence, with GGX microfacets. In a mix of amount `b` the parts are `rho_d/(1-b)` and `rho_s/b`.
//! The picture plane is given by `screenwindow` at a field of view of 90 degrees, where its units are
//! tangents. [Pharr, Jakob, Humphreys: pbrt-v4 input file format]

mod square;

use super::environment::{self, Around};
use super::identifiers::{identifiers, quoted};
use super::{Files, SceneView, far, ply, tiling};
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
    let groups = identifiers("m_", shot.scene.groups.iter().map(|g| g.name.as_str()));
    for (index, id) in groups.iter().enumerate() {
        text.push_str(&material(shot, index, id, &mut files, &mut warnings)?);
    }
    let lights = identifiers("l_", shot.scene.lights.iter().map(|l| l.name.as_str()));
    for (light, id) in shot.scene.lights.iter().zip(&lights) {
        let _ = writeln!(text, "\n# light {}\n{}", quoted(&light.name), light_source(&light.kind));
        if matches!(light.kind, LightKind::Spot { .. }) {
            let name = &light.name;
            warnings
                .push(format!("light \"{name}\" ({id}): PBRT's spots fall off by another curve"));
        }
    }
    text.push_str(&infinite(shot, &mut files)?);
    let objects = identifiers("o_", shot.scene.objects.iter().map(|o| o.name.as_str()));
    for (object, id) in shot.scene.objects.iter().zip(&objects) {
        if !object.mesh.triangles.is_empty() {
            let path = format!("mesh/{id}.ply");
            text.push_str(&shape(shot, object, &path, &groups[object.group]));
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
        let tile = tiling::tile(texture);
        let path = format!("textures/{id}.exr");
        files.push((path.clone(), texels::exr(&tile.image.map(|t| *t / (1.0 - amount)))?));
        let wrap = if tile.clamps { "clamp" } else { "repeat" };
        let _ = writeln!(
            text,
            "Texture \"{id}_texture\" \"spectrum\" \"imagemap\" \"string filename\" \"{path}\" \
             \"string wrap\" \"{wrap}\""
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
    match amount {
        0.0 => named(&mut text, id, "diffuse", &diffuse),
        1.0 => named(&mut text, id, "conductor", &metal),
        _ => {
            named(&mut text, &format!("{id}_diffuse"), "diffuse", &diffuse);
            named(&mut text, &format!("{id}_shine"), "conductor", &metal);
            let parts = format!(
                "\"string materials\" [ \"{id}_diffuse\" \"{id}_shine\" ] \"float amount\" {amount}"
            );
            named(&mut text, id, "mix", &parts);
        }
    }
    Ok(text)
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

fn shape(shot: &SceneView, object: &Object, path: &str, material: &str) -> String {
    let group = &shot.scene.groups[object.group];
    let mut text = format!("\n# object {}\nAttributeBegin\n", quoted(&object.name));
    let _ = writeln!(text, "    NamedMaterial \"{material}\"");
    if group.is_emitter() {
        let _ = writeln!(text, "    AreaLightSource \"diffuse\" {}", rgb("L", group.emission));
    }
    let _ = writeln!(text, "    Shape \"plymesh\" \"string filename\" \"{path}\"\nAttributeEnd");
    text
}

fn rgb(name: &str, v: Vec3) -> String {
    format!("\"rgb {name}\" [ {} {} {} ]", v.x, v.y, v.z)
}

fn point(name: &str, v: Vec3) -> String {
    format!("\"point3 {name}\" [ {} {} {} ]", v.x, v.y, v.z)
}
