//! Blender: `scene.py`, which adds the scene of `scene.json` with its meshes and pictures to the open
//! file as a scene of its own, run by Blender or with the package `bpy`.
//!
//! A material is the sum of a Principled BSDF, the diffuse part, and a Glossy BSDF of Beckmann's
//! microfacets, which reflects alike at all angles; Principled's own specular part grows towards
//! grazing angles. An anisotropy `a` has `alpha_x = alpha (1 - a)` along the tangent and `alpha_y =
//! alpha/(1 - a)`. [Blender manual, Principled BSDF and Glossy BSDF]
//!
//! Solid glass is a Principled BSDF that transmits all, whose colour is that of both faces together, and a Volume
//! Absorption; a pane is a mix of a Transparent BSDF and a mirror by what both its faces reflect.

mod detail;

use super::environment::{self, Around};
use super::identifiers::{Ids, identifiers};
use super::{Files, SceneView, far, ply, profiles, tiling};
use crate::glasses::Glasses;
use crate::near;
use crate::numbers::{number, triple};
use crate::texels;
use crate::{group_detail, ies};
use glam::Mat4;
use serde_json::{Value, json};
use std::f32::consts::FRAC_PI_2;
use unrender_scene::{Camera, Light, LightKind, Material, Reflectance, Rgb, Scene, Warnings};

/// The program that builds the scene.
const SCRIPT: &str = include_str!("blender/scene.py");

/// The files of `shot`.
///
/// # Errors
/// If a texture cannot be encoded.
pub(super) fn export(shot: &SceneView) -> Result<(Files, Warnings), String> {
    let (mut files, mut warnings) = (Files::new(), Warnings::default());
    far::warn(shot.scene, "Blender", far::WRITTEN_NEARER, &mut warnings);
    let glasses = Glasses::of(shot.scene);
    let ids = Ids::of(shot.scene, &glasses);
    let mut groups = Vec::new();
    for (index, id) in ids.groups.iter().enumerate() {
        groups.push(group(shot, index, id, &mut files, &mut warnings)?);
    }
    let mut objects = Vec::new();
    for (object, id) in shot.scene.objects.iter().zip(&ids.objects) {
        if !object.mesh.triangles.is_empty() {
            let path = format!("mesh/{id}.ply");
            objects.push(json!({ "name": object.name, "group": object.group, "mesh": path }));
            files.push((
                path,
                ply::bytes(&tiling::mesh(
                    shot,
                    object,
                    smoother(&shot.materials[object.group]),
                    tiling::From::Bottom,
                )),
            ));
        }
    }
    for (shape, id) in glasses.shapes.iter().zip(&ids.shapes) {
        let path = format!("mesh/{id}.ply");
        objects.push(json!({ "name": shape.name, "glass": shape.kind, "mesh": path }));
        files.push((path, ply::bytes(shape.mesh)));
    }
    if shot.camera.lens.distorts() {
        warnings.push(format!(
            "camera \"{}\": Blender's camera knows no distortion; the picture is that of the pinhole",
            shot.camera.name
        ));
    }
    if shot.camera.lens.fx_over_fy != 1.0 {
        warnings.push(format!(
            "camera \"{}\": Blender's pixels are left square; the picture is not stretched by {}",
            shot.camera.name, shot.camera.lens.fx_over_fy
        ));
    }
    let lamps = identifiers("l_", shot.scene.lights.iter().map(|light| light.name.as_str()));
    for (light, id) in shot.scene.lights.iter().zip(&lamps) {
        if let LightKind::Profiled { profile, .. } = &light.kind {
            let text = ies::text(&profiles::in_small_steps(profile), &light.name);
            files.push((format!("profiles/{id}.ies"), text.into_bytes()));
        }
    }
    let lights: Vec<Value> =
        shot.scene.lights.iter().zip(&lamps).map(|(light, id)| light_json(light, id)).collect();
    let around = around(shot, &mut files)?;
    let others = shot.scene.cameras.iter().filter(|other| other.name != shot.camera.name);
    let cameras: Vec<Value> =
        std::iter::once(shot.camera).chain(others).map(|c| camera(shot.scene, c)).collect();
    let scene = json!({
        "size": [shot.size.0, shot.size.1],
        "cameras": cameras,
        "groups": groups,
        "glasses": glasses.kinds.iter().map(detail::glass).collect::<Vec<_>>(),
        "objects": objects,
        "lights": lights,
        "environment": around,
    });
    files.push(("scene.json".into(), format!("{scene:#}\n").into_bytes()));
    files.push(("scene.py".into(), SCRIPT.into()));
    Ok((files, warnings))
}

/// The light from all around, its panorama among `files`; null if there is none.
fn around(shot: &SceneView, files: &mut Files) -> Result<Value, String> {
    Ok(match environment::around(shot.scene) {
        None => Value::Null,
        Some(Around::Uniform(radiance)) => json!({ "radiance": triple(radiance) }),
        Some(Around::Panorama(environment)) => {
            files.push(environment::file(&environment::panorama(&environment))?);
            json!({ "panorama": environment::FILE, "rotation": number(environment.rotation_rad()) })
        }
    })
}

fn group(
    shot: &SceneView,
    index: usize,
    id: &str,
    files: &mut Files,
    warnings: &mut Warnings,
) -> Result<Value, String> {
    let (group, material) = (&shot.scene.groups[index], &shot.materials[index]);
    let copies = tiling::copies(shot, index);
    let found = group_detail::of_group(shot.scene, index);
    let (normals, holes) = detail::pictures(&group.name, id, (&found, copies), files, warnings)?;
    let mut picture = Value::Null;
    if let Some(texture) = &material.texture {
        let tile = tiling::tile(texture, copies);
        let path = format!("textures/{id}.exr");
        files.push((path.clone(), texels::exr(&tile.image)?));
        picture = json!({ "file": path, "clamps": tile.clamps });
        let name = &group.name;
        warnings.0.extend(tile.doubt.map(|doubt| format!("group \"{name}\": {doubt}")));
        if tiling::is_anisotropic(material) {
            warnings.push(format!(
                "group \"{name}\": Blender counts the anisotropy direction from the texture's u"
            ));
        }
    }
    let inputs = BlenderInputs::of(material);
    Ok(json!({
        "name": group.name,
        "rho_d": triple(material.rho_d),
        "rho_s": triple(material.rho_s),
        "reflectance": material.reflectance.name(),
        "base_color": triple(inputs.base_color),
        "metallic": inputs.is_metal,
        "ior": inputs.ior.map(number),
        "microfacets": if shot.scene.brdf.is_ggx() { "GGX" } else { "BECKMANN" },
        "roughness": number(inputs.roughness),
        "anisotropy": number(inputs.anisotropy),
        "emission": triple(group.emission),
        "texture": picture,
        "normals": normals,
        "holes": holes,
    }))
}

/// What a material is in Blender: values of the inputs of its shader nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlenderInputs {
    /// *Base Color* of the Principled BSDF, linear RGB; of a textured material the mean of the texture.
    pub base_color: Rgb,
    /// *Roughness* of the node that has the lobe: the square root of alpha; one without a lobe.
    pub roughness: f32,
    /// Whether *Metallic* is one.
    pub is_metal: bool,
    /// *IOR* of a dielectric.
    pub ior: Option<f32>,
    /// *Anisotropy* of the Glossy BSDF.
    pub anisotropy: f32,
    /// Whether the lobe is a Glossy BSDF beside the Principled one, with the colour rho_s.
    pub is_glossy: bool,
}

impl BlenderInputs {
    /// The inputs for a material whose lobe is one of Blender's.
    pub fn of(material: &Material) -> Self {
        let (x, y) = (material.alpha_x, material.alpha_y);
        let (smooth, rough) = (x.min(y), x.max(y));
        let ratio = if tiling::is_anisotropic(material) { smooth / rough } else { 1.0 };
        let is_metal = matches!(material.reflectance, Reflectance::Metal { .. });
        let is_free = material.reflectance.is_free();
        let is_glossy = is_free && material.rho_s.max_element() > 0.0;
        let is_matte = is_free && !is_glossy;
        Self {
            base_color: if is_metal { material.rho_s } else { material.rho_d },
            roughness: if is_matte { 1.0 } else { (smooth * rough).sqrt().sqrt() },
            is_metal,
            ior: match material.reflectance {
                Reflectance::Dielectric { ior, .. } => Some(ior),
                Reflectance::Free | Reflectance::Metal { .. } => None,
            },
            anisotropy: 1.0 - ratio.sqrt(),
            is_glossy,
        }
    }
}

/// The angle of the smoother direction, along which Blender's tangent goes.
fn smoother(material: &Material) -> f32 {
    material.theta_rad + if material.alpha_x > material.alpha_y { FRAC_PI_2 } else { 0.0 }
}

fn camera(scene: &Scene, camera: &Camera) -> Value {
    let columns = Mat4::from(camera.world_from_camera).transpose().to_cols_array_2d();
    json!({
        "name": camera.name,
        "fov_y": number(camera.fov_y_rad),
        "near": number(near::written(scene, camera)),
        "principal_point": camera.lens.principal_point.map(number),
        "world_from_camera": columns.map(|row| row.map(number)),
    })
}

fn light_json(light: &Light, id: &str) -> Value {
    let Light { name, kind } = light;
    let strength = triple(kind.strength());
    match *kind {
        LightKind::Point { position, .. } => {
            json!({ "name": name, "kind": "point", "strength": strength, "position": triple(position) })
        }
        LightKind::Directional { direction, .. } => json!({
            "name": name, "kind": "directional", "strength": strength, "direction": triple(direction),
        }),
        LightKind::Spot { position, direction, inner_rad, outer_rad, .. } => json!({
            "name": name,
            "kind": "spot",
            "strength": strength,
            "position": triple(position),
            "direction": triple(direction),
            "cos_inner": number(inner_rad.cos()),
            "cos_outer": number(outer_rad.cos()),
        }),
        LightKind::Profiled { position, direction, upright, ref profile, .. } => json!({
            "name": name,
            "kind": "profiled",
            "strength": strength,
            "position": triple(position),
            "direction": triple(direction),
            "upright": triple(upright),
            "profile": format!("profiles/{id}.ies"),
            "candela": profile.peak_candela(),
        }),
    }
}
