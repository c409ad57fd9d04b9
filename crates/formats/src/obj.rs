//! Wavefront OBJ with MTL.
//!
//! Objects are named by `o` and `g`, groups by the material. `Kd` and `map_Kd` are the diffuse
//! part; `Ks` is the specular one, unless `illum` is 0 or 1, with `alpha = sqrt(2 / (Ns + 2))`,
//! the width of the Blinn-Phong lobe of that exponent. `Ke` is the emitted radiance.
//! There is no camera and no unit of length; metres are assumed.

use crate::names::{DEFAULT, unique};
use crate::{FileError, texels};
use glam::{Vec2, Vec3};
use std::cell::RefCell;
use std::collections::HashMap;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;
use tobj::{LoadError, LoadOptions};
use unrender_scene::{Group, Material, Mesh, Object, Rgb, Scene, Texture, Warnings, Wrap};

/// Reads the OBJ at `path` with the MTL files and pictures that it names.
///
/// The scene has no camera and is not yet validated: see [`load_scene`](crate::load_scene).
///
/// # Errors
/// If a file is missing or not what it should be.
pub fn read(path: &Path) -> Result<(Scene, Warnings), FileError> {
    let fail = |problem: String| FileError::new(path, problem);
    let text = read_file(path).map_err(fail)?;
    let (models, materials) = parse(path, &text).map_err(fail)?;
    let folder = path.parent().unwrap_or(Path::new(""));
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
                let group = group(&names[slot], json, folder, &mut warnings).map_err(fail)?;
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

/// The models and the materials of the OBJ text that stands at `path`.
fn parse(path: &Path, text: &[u8]) -> Result<Parsed, String> {
    let fault = || "is not an OBJ: it is not text; export the scene again".to_owned();
    let text = std::str::from_utf8(text).map_err(|_| fault())?;
    if text.contains('\0') {
        return Err(fault());
    }
    check_faces(text)?;
    let options = LoadOptions {
        single_index: true,
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
    };
    let problem = RefCell::new(None);
    let load_materials = |name: &Path| {
        load_mtl(path, name).map_err(|text| {
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

fn load_mtl(obj: &Path, name: &Path) -> Result<MtlFile, String> {
    let path = obj.with_file_name(name);
    let shown = name.display();
    let text = read_file(&path).map_err(|problem| {
        format!("needs the material file \"{shown}\", which {problem}; put it beside the scene")
    })?;
    let text = whole_colors(&text)?;
    let mut bytes = text.as_bytes();
    tobj::load_mtl_buf(&mut bytes).map_err(|error| {
        format!("the material file \"{shown}\" is not valid ({error}); export the scene again")
    })
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
    folder: &Path,
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
        let image = texture_file(folder, file)
            .map_err(|problem| format!("material \"{name}\": its map_Kd \"{file}\" {problem}"))?;
        let image = image.map(|texel| *texel * kd);
        material.rho_d = texels::mean(&image);
        let wrap = Wrap::Repeat;
        material.texture = Some(Arc::new(Texture { image, wrap_u: wrap, wrap_v: wrap }));
    }
    Ok(Group { name: name.into(), material, emission: rgb(mtl.emissive, "Ke")? })
}

fn texture_file(folder: &Path, file: &str) -> Result<unrender_scene::RgbImage, String> {
    if file.starts_with('-') {
        return Err("has options, which are not supported; remove them".into());
    }
    let bytes = read_file(&folder.join(file.replace('\\', "/")))?;
    Ok(texels::linear(&texels::decode(&bytes)?))
}

fn mesh(mesh: &tobj::Mesh) -> Result<Mesh, String> {
    let positions: Vec<Vec3> = mesh.positions.chunks_exact(3).map(Vec3::from_slice).collect();
    let count = positions.len();
    if let Some(index) = mesh.indices.iter().find(|&&i| i as usize >= count) {
        return Err(format!("uses vertex {index} of {count}; export the scene again"));
    }
    let triangles: Vec<[u32; 3]> =
        mesh.indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
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

fn read_file(path: &Path) -> Result<Vec<u8>, String> {
    fs::read(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound => "does not exist".into(),
        _ => format!("cannot be read: {error}"),
    })
}
