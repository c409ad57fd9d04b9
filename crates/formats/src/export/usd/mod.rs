//! Universal Scene Description: one stage with meshes, lights, cameras and materials, as text, binary or a package.
//!
//! `stage.rs` is the tree of prims, `geometry.rs`, `lights.rs` and `material.rs` make its branches, `text.rs` and `binary.rs`
//! write it, `package.rs` packs it. Lengths are metres, +y is up. Pictures lie in a folder beside the stage, or inside the
//! package.

mod binary;
mod geometry;
mod lights;
mod material;
mod network;
mod openpbr;
mod package;
mod packed;
mod preview;
mod stage;
#[cfg(test)]
mod tests;
mod text;

use super::identifiers::{Ids, identifiers};
use super::layered::Layered;
use super::{Files, SceneView, far, folder, profiles, tiling};
use crate::glasses::Glasses;
use crate::{FileError, group_detail};
use stage::{Prim, Stage, Value};
use std::path::Path;
use unrender_scene::{Camera, Light, LightKind, Warnings};

/// The extensions of text, binary and package.
pub(super) const EXTENSIONS: [&str; 3] = ["usda", "usdc", "usdz"];
/// The name of the root prim.
const ROOT: &str = "scene";
/// The name of the prim that holds the materials.
const MATERIALS: &str = "materials";
/// The folder of the pictures: its name in a package, and the end of its name beside a stage.
const PICTURES: &str = "textures";

/// How a stage is written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Text,
    Binary,
    Package,
}

impl Encoding {
    /// That of a file called `path`.
    fn of(path: &Path) -> Option<Self> {
        let own = path.extension()?;
        let all = [Self::Text, Self::Binary, Self::Package];
        let mut named = EXTENSIONS.into_iter().zip(all);
        named.find(|(name, _)| own.eq_ignore_ascii_case(name)).map(|(_, encoding)| encoding)
    }
}

/// Checks that the pictures of the stage `path` could lie beside it.
///
/// # Errors
/// If the file's name cannot stand in a stage, or if something is in the way.
pub(super) fn check(path: &Path) -> Result<(), FileError> {
    if Encoding::of(path) == Some(Encoding::Package) {
        return Ok(());
    }
    let named = pictures(path).map_err(|problem| FileError::new(path, problem))?;
    let folder = path.with_file_name(named);
    folder::check_folder(&folder).map_err(|_| {
        let stage = path.display();
        FileError::new(
            &folder,
            format!("is where the pictures of {stage} go, and has something in it; remove it, or name the stage otherwise"),
        )
    })
}

/// The name of the folder of pictures beside the stage `path`.
fn pictures(path: &Path) -> Result<String, String> {
    let is_plain = |stem: &&str| !stem.contains(|c: char| c.is_control() || c == '\\');
    let stem = path.file_stem().and_then(|stem| stem.to_str()).filter(is_plain);
    let stem =
        stem.ok_or("has a name that a stage cannot refer to: not Unicode, or with a backslash; name it otherwise")?;
    Ok(format!("{stem}_{PICTURES}"))
}

/// The files of `shot`: the stage, or a package with it, called `path`, and the pictures beside it.
///
/// # Errors
/// If a picture cannot be encoded, or if the stage is too large for its encoding.
pub(super) fn export(shot: &SceneView, path: &Path) -> Result<(Files, Warnings), String> {
    let encoding = Encoding::of(path).ok_or_else(|| {
        format!("{} does not end in .{}", path.display(), EXTENSIONS.join(" or ."))
    })?;
    let folder = if encoding == Encoding::Package { PICTURES.into() } else { pictures(path)? };
    let (mut pictures, mut warnings) = (Files::new(), Warnings::default());
    let stage = stage(shot, &folder, &mut pictures, &mut warnings)?;
    let bytes = match encoding {
        Encoding::Text => text::bytes(&stage),
        Encoding::Binary | Encoding::Package => binary::bytes(&stage)?,
    };
    // In a package, the first file is the stage.
    let mut files = vec![("scene.usdc".to_owned(), bytes)];
    files.append(&mut pictures);
    if encoding == Encoding::Package {
        files = vec![("scene.usdz".into(), package::bytes(&files)?)];
    }
    Ok((files, warnings))
}

/// The stage of `shot`, whose pictures are put among `files` in the folder called `folder`.
fn stage(
    shot: &SceneView,
    folder: &str,
    files: &mut Files,
    warnings: &mut Warnings,
) -> Result<Stage, String> {
    let scene = shot.scene;
    far::warn(scene, "USD's meshes", far::WRITTEN_BY_ROOT, warnings);
    geometry::warn_of_lens(shot.camera, warnings);
    warn_of_lights(shot, warnings);
    warn_of_materials(shot, warnings);
    let glasses = Glasses::of(scene);
    warn_of_glass(&glasses, warnings);
    let ids = Ids::of(scene, &glasses);
    let name = |file: &str| format!("{folder}/{file}");
    let parent = format!("/{ROOT}/{MATERIALS}");
    let mut materials = Prim::new("Scope", MATERIALS);
    for (index, id) in ids.groups.iter().enumerate() {
        materials.children.push(material::group(shot, index, (&parent, id), &name, files)?);
    }
    for (kind, id) in glasses.kinds.iter().zip(&ids.kinds) {
        materials.children.push(material::glass(kind, (&parent, id), warnings));
    }
    let mut root = Prim::new("Xform", ROOT);
    if let Some(moved) = geometry::root(scene) {
        root.place(moved);
    }
    root.children.extend(meshes(shot, &glasses, &ids, &parent));
    root.children.extend(lights(shot, warnings));
    root.children.extend(lights::dome(shot, name, files)?);
    root.children.extend(cameras(shot));
    root.children.push(materials);
    let metadata = vec![
        ("defaultPrim", Value::token(ROOT)),
        ("metersPerUnit", Value::Double(1.0)),
        ("upAxis", Value::token("Y")),
    ];
    Ok(Stage { metadata, root })
}

/// The meshes that have triangles, with materials below the path `materials`.
fn meshes(shot: &SceneView, glasses: &Glasses, ids: &Ids, materials: &str) -> Vec<Prim> {
    let objects = shot.scene.objects.iter().zip(&ids.objects);
    let objects = objects.filter(|(object, _)| !object.mesh.triangles.is_empty());
    let objects = objects.map(|(object, id)| {
        let rougher_rad = Layered::of(&shot.materials[object.group]).rougher_rad;
        let mesh = tiling::mesh(shot, object, rougher_rad, tiling::From::Bottom);
        let material = format!("{materials}/{}", ids.groups[object.group]);
        geometry::mesh(id, &mesh, material).named(&object.name)
    });
    let shapes = glasses.shapes.iter().zip(&ids.shapes).map(|(shape, id)| {
        let material = format!("{materials}/{}", ids.kinds[shape.kind]);
        geometry::mesh(id, shape.mesh, material).named(&shape.name)
    });
    objects.chain(shapes).collect()
}

fn lights(shot: &SceneView, warnings: &mut Warnings) -> Vec<Prim> {
    let lights = &shot.scene.lights;
    let ids = identifiers("l_", lights.iter().map(|light| light.name.as_str()));
    let mut prim = |(light, id): (&Light, &String)| {
        lights::light(id, &light.name, &profiles::without(light, "USD", warnings))
    };
    lights.iter().zip(&ids).filter_map(&mut prim).collect()
}

/// The cameras: that of the picture first.
fn cameras(shot: &SceneView) -> Vec<Prim> {
    let others = shot.scene.cameras.iter().filter(|other| other.name != shot.camera.name);
    let all: Vec<&Camera> = std::iter::once(shot.camera).chain(others).collect();
    let ids = identifiers("c_", all.iter().map(|camera| camera.name.as_str()));
    let aspect = |[width, height]: [f64; 2]| width / height;
    let own = aspect([shot.size.0 as f64, shot.size.1 as f64]);
    let of = |(place, camera): (usize, &&Camera)| {
        let size = camera.size.map(|size| aspect(size.map(f64::from)));
        let stated = size.or(camera.aspect.map(f64::from)).filter(|_| place > 0);
        geometry::camera(&ids[place], shot.scene, camera, stated.unwrap_or(own))
    };
    all.iter().enumerate().map(of).collect()
}

/// Warns of lights that USD shows otherwise.
fn warn_of_lights(shot: &SceneView, warnings: &mut Warnings) {
    let lights = shot.scene.lights.iter();
    let spots = lights.filter(|light| matches!(light.kind, LightKind::Spot { .. }));
    let spots: Vec<&str> = spots.map(|light| light.name.as_str()).collect();
    if !spots.is_empty() {
        warnings.push(format!(
            "USD's spots fall off by another curve: their rims differ, and they send the same light in all, of: {}",
            spots.join(", ")
        ));
    }
    let is_open = |index: usize| {
        let mut own = shot.scene.objects.iter().filter(|object| object.group == index);
        own.any(|object| !object.mesh.triangles.is_empty() && !object.mesh.is_closed())
    };
    let groups = shot.scene.groups.iter().enumerate();
    let open = groups.filter(|(index, group)| group.is_emitter() && is_open(*index));
    let open: Vec<&str> = open.map(|(_, group)| group.name.as_str()).collect();
    if !open.is_empty() {
        warnings.push(format!(
            "USD does not say which side of a surface emits, and programs show both, of: {}; cover their backs",
            open.join(", ")
        ));
    }
}

/// Warns of materials that `UsdPreviewSurface` or the meshes' texture coordinates cannot express.
fn warn_of_materials(shot: &SceneView, warnings: &mut Warnings) {
    let groups = shot.scene.groups.iter().zip(shot.materials).enumerate();
    let brushed: Vec<(usize, &str)> = groups
        .filter(|(_, (_, material))| tiling::is_anisotropic(material))
        .map(|(index, (group, _))| (index, group.name.as_str()))
        .collect();
    if brushed.is_empty() {
        return;
    }
    let names: Vec<&str> = brushed.iter().map(|(_, name)| *name).collect();
    warnings.push(format!(
        "UsdPreviewSurface knows no anisotropy: programs that do not read OpenPBR show a mean roughness, of: {}",
        names.join(", ")
    ));
    for (index, name) in brushed {
        let detail = group_detail::of_group(shot.scene, index);
        if shot.materials[index].texture.is_some() || !detail.is_none() {
            warnings.push(format!(
                "group \"{name}\": USD counts the anisotropy direction from the texture's u"
            ));
        }
    }
}

/// Warns of glass that `UsdPreviewSurface` cannot express.
fn warn_of_glass(glasses: &Glasses, warnings: &mut Warnings) {
    if glasses.any(|glass| !glass.is_thin || glass.tint.max_element() != glass.tint.min_element()) {
        warnings.push(
            "UsdPreviewSurface lets light straight through glass, without colour or refraction; only programs that read \
             OpenPBR show it as it is",
        );
    }
}
