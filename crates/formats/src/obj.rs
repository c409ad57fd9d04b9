//! Wavefront OBJ with MTL.
//!
//! Objects are named by `o` and `g`, groups by the material. `Kd` and `map_Kd` are the diffuse
//! part; `Ks` is the specular one, unless `illum` is 0 or 1, with `alpha = sqrt(2 / (Ns + 2))`,
//! the width of the Blinn-Phong lobe of that exponent. `Ke` is the emitted radiance.
//! There is no camera and no unit of length; metres are assumed.

use crate::input::{Input, Scope};
use crate::names::{DEFAULT, unique};
use crate::{FileError, polygon, texels};
use glam::{DVec3, Vec2, Vec3};
use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;
use tobj::{LoadError, LoadOptions};
use unrender_scene::{Group, Material, Mesh, Object, Rgb, Scene, Texture, Warnings, Wrap};

/// What an OBJ becomes takes at most so many times the memory of its text: four bytes, a corner of a
/// face and its separator, become a vertex of 32 bytes, here and in the parser.
const TEXT_TO_MESH: u64 = 16;

/// A text counted from elsewhere takes at most so many times its memory: `v 1 1 1` becomes 45 bytes.
const COUNTED: u64 = 8;

/// Reads the OBJ at `path` with the MTL files and pictures that it names.
///
/// The scene has no camera and is not yet validated: see [`load_scene`](crate::load_scene).
///
/// # Errors
/// If a file is missing or not what it should be.
pub fn read<'a>(input: impl Into<Input<'a>>) -> Result<(Scene, Warnings), FileError> {
    let input = input.into();
    let scope = Scope::new(input);
    read_in(&scope, input.path, scope.origin())
}

/// As [`read`], as a file that the input of `scope` is or names; positions count from `origin`.
pub(crate) fn read_in(
    scope: &Scope,
    path: &Path,
    origin: DVec3,
) -> Result<(Scene, Warnings), FileError> {
    let fail = |problem: String| FileError::new(path, problem);
    let text = scope.read(path).map_err(fail)?;
    scope.charge(TEXT_TO_MESH * text.len() as u64).map_err(fail)?;
    let (models, materials) = parse(scope, path, &text, origin).map_err(fail)?;
    let mut warnings = Warnings::default();
    let mut wanted: Vec<String> = materials.iter().map(|m| m.name.clone()).collect();
    wanted.push(DEFAULT.into());
    let names = unique(&wanted, &mut warnings);

    let mut scene = Scene::default();
    let mut group_of = vec![None; names.len()];
    for (index, model) in models.iter().enumerate() {
        let mesh = mesh(&model.mesh)
            .map_err(|problem| FileError::new(path, format!("\"{}\" {problem}", model.name)))?;
        if mesh.triangles.is_empty() {
            continue;
        }
        let slot = model.mesh.material_id.filter(|&id| id < materials.len());
        let slot = slot.unwrap_or(materials.len());
        let group = match group_of[slot] {
            Some(group) => group,
            None => {
                let json = materials.get(slot);
                let place = (scope, path.parent().unwrap_or(Path::new("")));
                let group = group(&names[slot], json, place, &mut warnings).map_err(fail)?;
                scene.groups.push(group);
                *group_of[slot].insert(scene.groups.len() - 1)
            }
        };
        let is_named = !model.name.is_empty() && model.name != "unnamed_object";
        let name = if is_named { model.name.clone() } else { format!("object {index}") };
        scene.objects.push(Object { name, group, mesh });
    }
    Ok((scene, warnings))
}

type Parsed = (Vec<tobj::Model>, Vec<tobj::Material>);
type MtlFile = (Vec<tobj::Material>, HashMap<String, usize>);

/// The models and the materials of the OBJ text that stands at `path`, counted from `origin`.
fn parse(scope: &Scope, path: &Path, text: &[u8], origin: DVec3) -> Result<Parsed, String> {
    let fault = || "is not an OBJ: it is not text; export the scene again".to_owned();
    let text = std::str::from_utf8(text).map_err(|_| fault())?;
    if text.contains('\0') {
        return Err(fault());
    }
    check_faces(text)?;
    if origin != DVec3::ZERO {
        scope.charge(COUNTED * text.len() as u64)?;
    }
    let text = counted_from(origin, text);
    let options = LoadOptions {
        single_index: true,
        // Polygons need not be convex: see `polygon`.
        triangulate: false,
        ignore_points: true,
        ignore_lines: true,
    };
    let problem = RefCell::new(None);
    let load_materials = |name: &Path| {
        load_mtl(scope, path, name).map_err(|text| {
            problem.borrow_mut().get_or_insert(text);
            LoadError::GenericFailure
        })
    };
    let mut bytes = text.as_bytes();
    let loaded = tobj::load_obj_buf(&mut bytes, &options, load_materials);
    if let Some(problem) = problem.take() {
        return Err(problem);
    }
    let (models, materials) =
        loaded.map_err(|error| format!("is not a valid OBJ ({error}); export the scene again"))?;
    let materials = materials.map_err(|error| {
        format!("has a material file that is not valid ({error}); export again")
    })?;
    Ok((models, materials))
}

/// `text` with its vertices counted from `origin`: the parser has single precision.
fn counted_from(origin: DVec3, text: &str) -> Cow<'_, str> {
    if origin == DVec3::ZERO {
        return Cow::Borrowed(text);
    }
    let mut counted = String::with_capacity(text.len());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let mut place = || [words.next(), words.next(), words.next(), words.next()];
        let numbers = match place() {
            [Some("v"), Some(x), Some(y), Some(z)] => [x, y, z].map(|word| word.parse().ok()),
            _ => [None; 3],
        };
        if let [Some(x), Some(y), Some(z)] = numbers {
            let [x, y, z] = (DVec3::new(x, y, z) - origin).as_vec3().to_array();
            let _ = write!(counted, "v {x:e} {y:e} {z:e}");
            words.for_each(|more| counted.extend([" ", more]));
        } else {
            counted.push_str(line);
        }
        counted.push('\n');
    }
    Cow::Owned(counted)
}

/// Checks the indices of all faces; the parser computes with them before it looks at them.
fn check_faces(text: &str) -> Result<(), String> {
    const KINDS: [&str; 3] = ["v", "vt", "vn"];
    let first_word = |line: &str| line.split_whitespace().next().unwrap_or("").to_owned();
    let totals = KINDS.map(|kind| text.lines().filter(|line| first_word(line) == kind).count());
    let mut so_far = [0i64; 3];
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split('#').next().unwrap_or("").split_whitespace();
        let Some(word) = words.next() else { continue };
        if let Some(kind) = KINDS.iter().position(|kind| *kind == word) {
            so_far[kind] += 1;
        }
        if !matches!(word, "f" | "l" | "p") {
            continue;
        }
        for (kind, index) in words.flat_map(|corner| corner.split('/').enumerate()) {
            let index = if index.is_empty() { Some(1) } else { index.parse::<i64>().ok() };
            let place = index.map(|i| if i < 0 { so_far[kind.min(2)] + i } else { i - 1 });
            let end = totals[kind.min(2)].max(1) as i64;
            if kind > 2 || !place.is_some_and(|place| (0..end).contains(&place)) {
                return Err(format!(
                    "line {} has a face with an index that is no number or out of range (\"{line}\"); \
                     export the scene again",
                    number + 1
                ));
            }
        }
    }
    Ok(())
}

fn load_mtl(scope: &Scope, obj: &Path, name: &Path) -> Result<MtlFile, String> {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let shown = name.display();
    let read = scope.beside(folder, &name.to_string_lossy()).and_then(|path| scope.read(&path));
    let text = read.map_err(|problem| {
        format!("needs the material file \"{shown}\", which {problem}; put it beside the scene")
    })?;
    let text = whole_colors(&text)?;
    let mut bytes = text.as_bytes();
    let (mut materials, by_name) = tobj::load_mtl_buf(&mut bytes).map_err(|error| {
        format!("the material file \"{shown}\" is not valid ({error}); export the scene again")
    })?;
    // Seen from the folder of the MTL file; programs that write it from the OBJ's are believed, too.
    let within = name.parent().unwrap_or(Path::new(""));
    for texture in materials.iter_mut().filter_map(|m| m.diffuse_texture.as_mut()) {
        let there = within.join(texture.replace('\\', "/"));
        if !texture.starts_with('-') && folder.join(&there).is_file() {
            *texture = there.to_string_lossy().into_owned();
        }
    }
    Ok((materials, by_name))
}

/// The MTL text with colours of one number written out as three: MTL allows the short form, and
/// the parser relies on three.
fn whole_colors(text: &[u8]) -> Result<String, String> {
    let text = String::from_utf8_lossy(text);
    let mut whole = String::with_capacity(text.len());
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["Ka" | "Kd" | "Ks" | "Ke", grey] => {
                whole.push_str(&format!("{} {grey} {grey} {grey}", words[0]));
            }
            ["Ka" | "Kd" | "Ks" | "Ke"] | ["Ka" | "Kd" | "Ks" | "Ke", _, _] => {
                return Err(format!("a material file says \"{line}\"; give the colour 3 numbers"));
            }
            _ => whole.push_str(line),
        }
        whole.push('\n');
    }
    Ok(whole)
}

fn group(
    name: &str,
    mtl: Option<&tobj::Material>,
    (scope, folder): (&Scope, &Path),
    warnings: &mut Warnings,
) -> Result<Group, String> {
    let Some(mtl) = mtl else {
        warnings.push(format!(
            "Some faces have no material; they are the group \"{name}\", taken as diffuse with \
             rho_d = 0.5."
        ));
        let material = Material::diffuse(Rgb::splat(0.5));
        return Ok(Group { name: name.into(), material, emission: Rgb::ZERO });
    };
    let rgb = |value: Option<[f32; 3]>, key: &str| {
        let rgb = Rgb::from_array(value.unwrap_or_default());
        if rgb.is_finite() && rgb.min_element() >= 0.0 {
            return Ok(rgb);
        }
        Err(format!("material \"{name}\" has a {key} that is no colour; repair the MTL file"))
    };
    let has_texture = mtl.diffuse_texture.is_some();
    let kd = rgb(mtl.diffuse.or(has_texture.then_some([1.0; 3])), "Kd")?.min(Rgb::ONE);
    let ks = rgb(mtl.specular, "Ks")?.min(Rgb::ONE);
    let is_glossy = ks.max_element() > 0.0 && !matches!(mtl.illumination_model, Some(0 | 1));
    let mut material = if is_glossy {
        let shininess = mtl.shininess.unwrap_or(0.0).max(0.0);
        Material::isotropic(kd, ks, (2.0 / (shininess + 2.0)).sqrt())
    } else {
        Material::diffuse(kd)
    };
    if let Some(file) = &mtl.diffuse_texture {
        let image = texture_file(scope, folder, file)
            .map_err(|problem| format!("material \"{name}\": its map_Kd \"{file}\" {problem}"))?;
        let image = image.map(|texel| *texel * kd);
        material.rho_d = texels::mean(&image);
        let wrap = Wrap::Repeat;
        material.texture = Some(Arc::new(Texture { image, wrap_u: wrap, wrap_v: wrap }));
    }
    Ok(Group { name: name.into(), material, emission: rgb(mtl.emissive, "Ke")? })
}

fn texture_file(
    scope: &Scope,
    folder: &Path,
    file: &str,
) -> Result<unrender_scene::RgbImage, String> {
    if file.starts_with('-') {
        return Err("has options, which are not supported; remove them".into());
    }
    let bytes = scope.read(&scope.beside(folder, &file.replace('\\', "/"))?)?;
    Ok(texels::linear(&texels::decode(scope, &bytes)?))
}

fn mesh(mesh: &tobj::Mesh) -> Result<Mesh, String> {
    let positions: Vec<Vec3> = mesh.positions.chunks_exact(3).map(Vec3::from_slice).collect();
    let count = positions.len();
    if let Some(index) = mesh.indices.iter().find(|&&i| i as usize >= count) {
        return Err(format!("uses vertex {index} of {count}; export the scene again"));
    }
    let triangles = triangles(mesh, &positions)?;
    // OBJ counts v from the bottom, glTF from the top.
    let uvs = mesh.texcoords.chunks_exact(2).map(|uv| Vec2::new(uv[0], 1.0 - uv[1]));
    let mut uvs: Vec<Vec2> = uvs.collect();
    if uvs.len() != count {
        uvs.clear();
    }
    let normals: Vec<Vec3> = mesh.normals.chunks_exact(3).map(Vec3::from_slice).collect();
    let has_normals = normals.len() == count && normals.iter().all(|n| n.length_squared() > 0.0);
    if !has_normals {
        return Ok(Mesh::flat(&positions, &uvs, &triangles));
    }
    let normals = normals.into_iter().map(Vec3::normalize).collect();
    Ok(Mesh { positions, normals, uvs, tangents: Vec::new(), triangles })
}

fn triangles(mesh: &tobj::Mesh, positions: &[Vec3]) -> Result<Vec<[u32; 3]>, String> {
    let mut triangles = Vec::new();
    let mut rest = mesh.indices.as_slice();
    let of_three = vec![3; if mesh.face_arities.is_empty() { rest.len() / 3 } else { 0 }];
    for arity in mesh.face_arities.iter().chain(&of_three) {
        let (corners, others) = rest.split_at((*arity as usize).min(rest.len()));
        rest = others;
        polygon::split(corners, |&i| positions[i as usize], &mut triangles)?;
    }
    Ok(triangles)
}
