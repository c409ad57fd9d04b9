//! Applies the numbers of a `materials.json` to the groups and lights of a scene.

use super::{GroupEntry, Hypothesis, MaterialsFile};
use crate::input::Scope;
use crate::{FileError, Input, Limits, picture};
use std::path::Path;
use std::sync::Arc;
use unrender_scene::{BrdfModel, Image, Material, Rgb, Scene, Texture, Warnings, Wrap};

/// Rounding of a reflectance of one on its way through text and single precision.
const ROUNDING: f32 = 1e-5;

/// Sets the BRDF, the materials and the lights of `scene` as `file` says; `folder` is where its texture paths
/// start. Keys that the file leaves out stay as they are in the scene, but a `rho_d` without a texture
/// replaces the scene's texture.
///
/// # Errors
/// If a number is out of its range or a texture cannot be read; the scene may be changed in part.
pub fn apply(
    file: &MaterialsFile,
    folder: &Path,
    scene: &mut Scene,
) -> Result<Warnings, FileError> {
    let own = folder.join("materials.json");
    apply_named(file, folder, (folder, &Scope::new(Input::from(&own))), scene)
}

/// Reads the file of `input` and applies it to `scene` as [`apply`] does.
///
/// # Errors
/// As those of [`super::read`] and [`apply`].
pub fn apply_from<'a>(
    input: impl Into<Input<'a>>,
    scene: &mut Scene,
) -> Result<Warnings, FileError> {
    let input = input.into();
    let folder = input.path.parent().unwrap_or(Path::new(""));
    apply_named(&super::read(input)?, folder, (input.path, &Scope::new(input)), scene)
}

/// As [`apply`]; `origin` is the file that errors name, with the limits of reading.
fn apply_named(
    file: &MaterialsFile,
    folder: &Path,
    (origin, scope): (&Path, &Scope),
    scene: &mut Scene,
) -> Result<Warnings, FileError> {
    let mut warnings = Warnings::default();
    if let Some(name) = &file.brdf {
        let named = name.parse().map_err(|problem: String| FileError::new(origin, problem))?;
        scene.brdf = scene.brdf.renamed(named);
        if !scene.brdf.is_principled() {
            scene.free();
        }
    }
    for (name, entry) in &file.groups {
        let Some(index) = scene.group_index(name) else {
            warnings.push(format!("the scene has no group \"{name}\"; its numbers were not used"));
            continue;
        };
        let model = scene.brdf;
        let material = &mut scene.groups[index].material;
        check_ranges(entry).and_then(|()| apply_numbers(entry, model, material)).map_err(
            |problem| FileError::new(origin, format!("the materials' group \"{name}\": {problem}")),
        )?;
        warnings.extend(apply_texture(name, entry, (folder, scope), material)?);
        if entry.direction.is_some() && entry.theta_deg.is_none() && is_anisotropic(material) {
            warnings.push(format!(
                "group \"{name}\": a direction without theta_deg was not used; give theta_deg"
            ));
        }
    }
    let noted = super::light_entry::apply(&file.lights, scene);
    warnings.extend(noted.map_err(|problem| FileError::new(origin, problem))?);
    Ok(warnings)
}

fn is_anisotropic(material: &Material) -> bool {
    material.is_glossy() && (material.alpha_x - material.alpha_y).abs() > 0.01 * material.alpha_x
}

fn check_ranges(entry: &GroupEntry) -> Result<(), String> {
    for (key, rho) in [("rho_d", entry.rho_d), ("rho_s", entry.rho_s)] {
        let outside = |v: &&f32| !(0.0..=1.0 + ROUNDING).contains(*v);
        if let Some(value) = rho.iter().flatten().find(outside) {
            return Err(format!("{key} is {value}; a reflectance is between 0 and 1"));
        }
    }
    for (key, alpha) in [("alpha_x", entry.alpha_x), ("alpha_y", entry.alpha_y)] {
        if let Some(value) = alpha.filter(|a| !(a.is_finite() && *a >= 0.0)) {
            return Err(format!("{key} is {value}; a roughness is zero or positive"));
        }
    }
    if let Some(value) = entry.theta_deg.filter(|t| !t.is_finite()) {
        return Err(format!("theta_deg is {value}; give an angle in degrees"));
    }
    Ok(())
}

fn apply_numbers(
    entry: &GroupEntry,
    model: BrdfModel,
    material: &mut Material,
) -> Result<(), String> {
    let reflectance = |rho: [f32; 3]| Rgb::from_array(rho).min(Rgb::ONE);
    material.rho_d = entry.rho_d.map_or(material.rho_d, reflectance);
    material.rho_s = entry.rho_s.map_or(material.rho_s, reflectance);
    material.alpha_x = entry.alpha_x.unwrap_or(material.alpha_x);
    material.alpha_y = entry.alpha_y.unwrap_or(material.alpha_y);
    material.theta_rad = entry.theta_deg.map_or(material.theta_rad, f32::to_radians);
    entry.reflectance.apply(entry.rho_s.is_some(), model, material)?;
    let one_is_zero = (material.alpha_x > 0.0) != (material.alpha_y > 0.0);
    if material.is_glossy() && one_is_zero {
        return Err(format!(
            "alpha_x is {} and alpha_y is {}; either both are positive or, for a mirror, both zero",
            material.alpha_x, material.alpha_y
        ));
    }
    Ok(())
}

fn apply_texture(
    group: &str,
    entry: &GroupEntry,
    (folder, scope): (&Path, &Scope),
    material: &mut Material,
) -> Result<Warnings, FileError> {
    let mut warnings = Warnings::default();
    if let Some(relative) = &entry.texture {
        let (image, noted) = texture_in(scope, folder, relative)?;
        warnings.extend(noted);
        if entry.rho_d.is_none() {
            material.rho_d = mean_of(&image);
        }
        let (wrap_u, wrap_v) = material
            .texture
            .as_ref()
            .map_or((Wrap::default(), Wrap::default()), |t| (t.wrap_u, t.wrap_v));
        material.texture = Some(Arc::new(Texture { image, wrap_u, wrap_v }));
    } else if entry.rho_d.is_some() && material.texture.take().is_some() {
        // A result states its intention by its hypothesis; a hand-written file may not intend this.
        if entry.hypothesis.is_none_or(|h| h.of_paper() == Hypothesis::Textured) {
            warnings
                .push(format!("group \"{group}\": rho_d took the place of the scene's texture"));
        }
    }
    Ok(warnings)
}

/// Reads a texture as linear reflectance: the EXR beside it if there is one, which has full
/// precision, else the file itself.
///
/// # Errors
/// If neither can be read.
pub fn read_texture<'a>(input: impl Into<Input<'a>>) -> Result<(Image<Rgb>, Warnings), FileError> {
    let Input { path, limits, .. } = input.into();
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let folder = path.parent().unwrap_or(Path::new(""));
    // The user may name a file anywhere.
    let limits = Limits { outside: true, ..limits };
    texture_in(&Scope::new(Input::new(path, limits)), folder, &name)
}

/// As [`read_texture`], the file that a `materials.json` in `folder` calls `name`.
///
/// # Errors
/// As those of [`read_texture`], and if the file lies outside the folder.
pub fn read_texture_beside(
    folder: &Path,
    name: &str,
    limits: Limits,
) -> Result<(Image<Rgb>, Warnings), FileError> {
    let own = folder.join("materials.json");
    texture_in(&Scope::new(Input::new(&own, limits)), folder, name)
}

fn texture_in(
    scope: &Scope,
    folder: &Path,
    name: &str,
) -> Result<(Image<Rgb>, Warnings), FileError> {
    let exr = Path::new(name).with_extension("exr");
    let chosen = scope.beside(folder, &exr.to_string_lossy()).ok().filter(|path| path.is_file());
    let found = chosen.map_or_else(|| scope.beside(folder, name), Ok);
    let path = found.map_err(|problem| FileError::new(&folder.join(name), problem))?;
    let (picture, warnings) = picture::read_in(scope, &path)?;
    Ok((picture.to_linear().map(|rho| rho.clamp(Rgb::ZERO, Rgb::ONE)), warnings))
}

/// The mean over all texels, summed in double precision: textures have millions of them.
pub fn mean_of(texture: &Image<Rgb>) -> Rgb {
    let sum: glam::DVec3 = texture.pixels().iter().map(|rho| rho.as_dvec3()).sum();
    (sum / texture.pixels().len().max(1) as f64).as_vec3()
}
