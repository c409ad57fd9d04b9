//! Wavefront OBJ with MTL.
//!
//! Objects are named by the latest `g` or `o`, groups by `usemtl`. Names that no material file has
//! are groups, too; where there is no `usemtl` at all, each name of `g` and `o` is one. `Kd` and
//! `map_Kd` are the diffuse part; `Ks` is the specular one, unless `illum` is 0 or 1, with `alpha =
//! sqrt(2 / (Ns + 2))`, the width of the Blinn-Phong lobe of that exponent. `Ke` is the emitted
//! radiance. Glass: see `glass.rs`; normal maps and holes: `relief.rs`. There is no camera and no unit of length; metres are assumed.
//!
//! No library is used, since the existing ones drop or change data that is needed here. They give a
//! whole object texture coordinates and normals if one face has them, make triangles of lines, forget
//! the names of materials that no file has, stop at characters that are not UTF-8, and do not report
//! what they skip.

pub(crate) mod document;
mod glass;
mod material;
mod mesh;
mod mtl;
mod relief;
mod text;
mod unread;

use crate::FileError;
use crate::entry::Table;
use crate::input::{Input, Scope};
use crate::names::{DEFAULT, unique};
use crate::relief::give;
use document::Document;
use glam::DVec3;
use material::ASSUMED_RHO_D;
use mesh::Piece;
use mtl::Materials;
use std::collections::HashMap;
use std::path::Path;
use unread::listed;
use unrender_scene::{Detail, Mesh, Object, Scene, Ungrouped, Warnings};

/// Reads the OBJ at `path` with the MTL files and pictures that it names; positions count from the
/// origin that the input states.
///
/// The scene has no camera and is not yet validated: see [`load_scene`](crate::load_scene).
///
/// # Errors
/// If a file is missing or not valid.
pub fn read<'a>(input: impl Into<Input<'a>>) -> Result<(Scene, Warnings), FileError> {
    let input = input.into();
    let scope = Scope::new(input);
    let fail = |problem: String| FileError::new(input.path, problem);
    let (document, parts) = geometry(&scope, input.path, scope.origin()).map_err(fail)?;
    let materials =
        Materials::read(&scope, input.path, document.libraries.given()).map_err(fail)?;
    let mut warnings = Warnings::default();
    let (place, by_object) = ((&scope, input.path), are_objects_groups(&document));
    let mut unread = Vec::new();
    let scene = scene(place, &document, parts, (&materials, &mut unread), &mut warnings);
    let scene = scene.map_err(fail)?;
    scope.complete().map_err(fail)?;
    tell(input.path, document, &mut warnings);
    let groups = scene.groups.iter().map(|group| group.name.as_str());
    let used = groups.chain(scene.ungrouped_materials());
    materials.tell(used.filter(|_| !by_object), &unread, &mut warnings);
    scene.glass_told().into_iter().for_each(|told| warnings.push(told));
    if scene.objects.is_empty() && scene.ungrouped.is_empty() && !warnings.0.is_empty() {
        let why = warnings.0.join(" ");
        return Err(fail(format!("has no triangles. {}", why.trim_end_matches('.'))));
    }
    Ok((scene, warnings))
}

/// What is read of OBJ and MTL.
pub(crate) fn tables() -> Vec<Table> {
    vec![
        Table::new("OBJ", "word", document::WORDS.iter().chain(&document::CASES)),
        Table::new("MTL", "word", mtl::WORDS.iter().chain(&mtl::CASES)),
    ]
}

/// A mesh, and the name that `usemtl` gives it, if there is one.
pub(crate) type Named = (Option<String>, Mesh);

/// Reads the meshes of the OBJ at `path`. The input of `scope` names it and states its materials: no
/// MTL is read. Positions count from `origin`.
pub(crate) fn read_in(
    scope: &Scope,
    path: &Path,
    origin: DVec3,
) -> Result<(Vec<Named>, Warnings), FileError> {
    let fail = |problem: String| FileError::new(path, problem);
    let (document, parts) = geometry(scope, path, origin).map_err(fail)?;
    let named = |part: Piece| (document.materials.get(part.material).map(str::to_owned), part.mesh);
    let meshes = parts.into_iter().map(named).collect();
    let mut warnings = Warnings::default();
    tell(path, document, &mut warnings);
    Ok((meshes, warnings))
}

fn geometry(scope: &Scope, path: &Path, origin: DVec3) -> Result<(Document, Vec<Piece>), String> {
    let mut document = document::read(scope, &scope.read(path)?, origin)?;
    let parts = mesh::parts(scope, &mut document)?;
    Ok((document, parts))
}

fn tell(path: &Path, document: Document, warnings: &mut Warnings) {
    document.unread.tell(&file_name(path), warnings);
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Whether the names of `g` and `o` are the groups, since no face names a material.
fn are_objects_groups(document: &Document) -> bool {
    document.materials.given().next().is_none()
}

/// The name of the group that `part` is in, if it has any.
fn group_name<'a>(document: &'a Document, materials: &Materials, part: &Piece) -> Option<&'a str> {
    if are_objects_groups(document) {
        return document.objects.get(part.object);
    }
    document.materials.get(part.material).map(|name| materials.resolve(name))
}

/// The groups and objects of `parts`; what is not read of their materials is added to `unread`, with the name of each and
/// the line.
fn scene(
    (scope, path): (&Scope, &Path),
    document: &Document,
    parts: Vec<Piece>,
    (materials, unread): (&Materials, &mut Vec<(String, &'static str, usize)>),
    warnings: &mut Warnings,
) -> Result<Scene, String> {
    let mut slots: Vec<Option<&str>> = Vec::new();
    let mut slot_of: HashMap<Option<&str>, usize> = HashMap::new();
    let mut scene = Scene { brdf: scope.brdf().unwrap_or_default(), ..Scene::default() };
    for (index, part) in parts.into_iter().enumerate() {
        let wanted = group_name(document, materials, &part);
        let group = *slot_of.entry(wanted).or_insert(slots.len());
        if group == slots.len() {
            slots.push(wanted);
        }
        let name = document.objects.get(part.object).map(str::to_owned);
        let name = name.unwrap_or_else(|| format!("object {index}"));
        scene.objects.push(Object { name, group, mesh: part.mesh });
    }
    let default = default_name(&slots);
    let place = (scope, path.parent().unwrap_or(Path::new("")));
    let of_materials = (!are_objects_groups(document)).then_some(materials);
    let (mut missing, mut details) = (Vec::new(), Vec::new());
    for slot in &slots {
        let found = slot.and_then(|name| of_materials?.get(name));
        if let (Some(name), None) = (slot, found) {
            missing.push(*name);
        }
        let name = slot.unwrap_or(&default);
        let mut untold = relief::Unread::new();
        details.push(match found {
            Some(found) => relief::detail(found, place, &mut untold)
                .map_err(|problem| format!("material \"{name}\": a map {problem}"))?,
            None => Detail::default(),
        });
        unread.extend(untold.into_iter().map(|(what, line)| (name.to_owned(), what, line)));
        scene.groups.push(match found {
            Some(found) => material::group(name, found, place, warnings)?,
            None => material::unstated(name),
        });
    }
    let without = slots.contains(&None).then_some(default.as_str());
    warn_of_assumed(path, of_materials.is_some(), &missing, without, warnings);
    warn_of_missing_uvs(&scene, &details, warnings);
    for object in &mut scene.objects {
        give(&mut object.mesh, &details[object.group]);
    }
    let glass = |group: usize| {
        let found = slots[group].and_then(|name| of_materials?.get(name));
        found.map(|(mtl, _)| mtl).filter(|mtl| mtl.is_glass())
    };
    set_apart(&mut scene, glass);
    Ok(scene)
}

/// Takes the objects of glass, and their groups, out of those of `scene`; `glass` is the material of a group of it.
fn set_apart<'a>(scene: &mut Scene, glass: impl Fn(usize) -> Option<&'a mtl::Material>) {
    let groups = std::mem::take(&mut scene.groups);
    let mut places = Vec::new();
    let mut kept = Vec::new();
    for (index, group) in groups.iter().enumerate() {
        places.push(kept.len());
        if glass(index).is_none() {
            kept.push(group.clone());
        }
    }
    scene.groups = kept;
    for object in std::mem::take(&mut scene.objects) {
        let Object { group, mesh, .. } = object;
        if let Some(mtl) = glass(group) {
            let (material, glass) = (groups[group].name.clone(), Some(glass::on(mtl, &mesh)));
            scene.ungrouped.push(Ungrouped { material, mesh, glass });
        } else {
            scene.objects.push(Object { name: object.name, group: places[group], mesh });
        }
    }
}

/// The name of the group of faces that name none: no other group has it.
fn default_name(slots: &[Option<&str>]) -> String {
    let given = slots.iter().flatten().map(|&name| name.to_owned());
    let all: Vec<String> = given.chain([DEFAULT.to_owned()]).collect();
    unique(&all, &mut Warnings::default()).pop().unwrap_or_default()
}

/// Warns of groups with an assumed reflectance: `missing` and the one called `default`.
fn warn_of_assumed(
    path: &Path,
    has_materials: bool,
    missing: &[&str],
    default: Option<&str>,
    warnings: &mut Warnings,
) {
    if !missing.is_empty() {
        let (file, names) = (file_name(path), listed(missing, missing.len()));
        let what = if has_materials {
            format!("no material file (mtllib) has the materials {names}")
        } else {
            format!("no face names a material (usemtl), but an object or group: {names}")
        };
        warnings.push(format!(
            "{file}: {what}; each is a group of its own, taken as diffuse with rho_d = {ASSUMED_RHO_D}."
        ));
    }
    if let Some(name) = default {
        warnings.push(format!(
            "Some faces have no material; they are the group \"{name}\", taken as diffuse with \
             rho_d = {ASSUMED_RHO_D}."
        ));
    }
}

fn warn_of_missing_uvs(scene: &Scene, details: &[Detail], warnings: &mut Warnings) {
    for Object { name, group, mesh } in &scene.objects {
        let has_detail = !details[*group].is_none();
        let group = &scene.groups[*group];
        if mesh.uvs.is_empty() && (has_detail || group.material.texture.is_some()) {
            warnings.push(format!(
                "object \"{name}\" has no texture coordinates at {} of its triangles for the texture \
                 of \"{}\"; unwrap it and export the scene again.",
                mesh.triangles.len(),
                group.name
            ));
        }
    }
}
