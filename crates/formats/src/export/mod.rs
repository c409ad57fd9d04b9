//! Scenes for other programs: what they need to render the picture that unrender renders.
//!
//! One target is one module with one function, from a [`SceneView`] to [`Files`]. To add another: write
//! such a module, name it in [`Target`], and state in [`Target::lobe`] which lobe it has. Writers
//! get the materials already converted to that lobe (`SceneView::materials`); the caller converts
//! Ward's.

mod anisotropy;
mod blender;
mod environment;
mod far;
mod folder;
mod identifiers;
mod layered;
mod maps;
mod materialx;
mod mitsuba;
mod obj;
mod pbrt;
mod ply;
mod profiles;
mod radiance;
mod tiling;
mod usd;

pub use blender::BlenderInputs;

use crate::{FileError, LightUnits, atomic, gltf, group_detail};
use std::fmt;
use std::path::Path;
use std::str::FromStr;
use unrender_scene::{
    BrdfModel, Camera, Lens, Lobe, Material, Reflectance, Scene, WardModel, Warnings,
};

/// What is exported: a scene as one camera sees it.
#[derive(Clone, Copy, Debug)]
pub struct SceneView<'a> {
    /// Geometry, names, lights, and the exact materials.
    pub scene: &'a Scene,
    /// For each group its material, with roughness and rho_s for the target's lobe.
    pub materials: &'a [Material],
    /// The camera.
    pub camera: &'a Camera,
    /// Width and height of the picture, pixels.
    pub size: (usize, usize),
    /// The units of a glTF file's lights.
    pub light_units: LightUnits,
}

/// The files of an export: their paths relative to its folder, with forward slashes, and contents.
pub type Files = Vec<(String, Vec<u8>)>;

/// A program that scenes can be written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Target {
    /// Blender.
    Blender,
    /// glTF 2.0, one binary file.
    Gltf,
    /// MaterialX.
    Materialx,
    /// Mitsuba 3.
    Mitsuba,
    /// PBRT v4.
    Pbrt,
    /// Radiance.
    Radiance,
    /// Universal Scene Description: text, binary or a package, by the ending of the file's name.
    Usd,
}

impl Target {
    /// All targets, by name.
    pub const ALL: [Self; 7] = [
        Self::Blender,
        Self::Gltf,
        Self::Materialx,
        Self::Mitsuba,
        Self::Pbrt,
        Self::Radiance,
        Self::Usd,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Blender => "blender",
            Self::Gltf => "gltf",
            Self::Materialx => "materialx",
            Self::Mitsuba => "mitsuba",
            Self::Pbrt => "pbrt",
            Self::Radiance => "radiance",
            Self::Usd => "usd",
        }
    }

    /// The extensions of which one ends the name of an export that is a file; none if it is a folder of files.
    fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Gltf => &["glb"],
            Self::Usd => &usd::EXTENSIONS,
            _ => &[],
        }
    }

    /// A name that an export may have.
    pub fn usual_name(self) -> String {
        match self.extensions() {
            [] => "scene".into(),
            [first, ..] => format!("scene.{first}"),
        }
    }

    /// What to do with an export at `path`, as a line for the user.
    pub fn next_step(self, path: &Path) -> String {
        let path = path.display();
        match self {
            Self::Blender => {
                format!("blender --background --python {path}/scene.py -- picture.exr scene.blend")
            }
            Self::Materialx => format!("open {path}/materials.mtlx"),
            Self::Pbrt => format!("pbrt {path}/scene.pbrt"),
            Self::Gltf => format!("open {path} in any program that reads glTF 2.0"),
            Self::Mitsuba => format!("mitsuba {path}/scene.xml"),
            Self::Radiance => format!("sh {path}/render.sh picture.hdr"),
            Self::Usd => format!("open {path} in any program that reads USD"),
        }
    }

    /// The lobe that it uses for a scene of `model`: the same if it has it, else the nearest.
    pub fn lobe(self, model: BrdfModel) -> Lobe {
        match self {
            Self::Radiance => Lobe::Model(WardModel::WardGmd.into()),
            _ if model.is_ggx() => Lobe::Model(model),
            Self::Blender | Self::Mitsuba => Lobe::Beckmann,
            _ => Lobe::Model(BrdfModel::Ggx),
        }
    }

    /// Whether an export holds the light from all around.
    pub fn has_environments(self) -> bool {
        match self {
            Self::Blender | Self::Mitsuba | Self::Pbrt | Self::Radiance | Self::Usd => true,
            Self::Gltf | Self::Materialx => false,
        }
    }

    /// Whether an export has words for this reflectance of a lobe; else it has the free one that looks the same at normal
    /// incidence.
    pub fn keeps(self, reflectance: Reflectance) -> bool {
        match reflectance {
            Reflectance::Free => true,
            Reflectance::Dielectric { .. } => {
                matches!(self, Self::Blender | Self::Gltf | Self::Mitsuba | Self::Usd)
            }
            Reflectance::Metal { .. } => matches!(self, Self::Blender | Self::Gltf | Self::Usd),
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Target {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|t| t.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("there is no format \"{name}\"; there are {names}")
        })
    }
}

/// The files of `shot` for `target`, to be written as `path`, and what they cannot express.
///
/// # Errors
/// If the target cannot express the scene at all, or if `path` has none of its extensions.
pub fn export(shot: &SceneView, target: Target, path: &Path) -> Result<(Files, Warnings), String> {
    let (files, mut warnings) = match target {
        Target::Blender => blender::export(shot),
        Target::Gltf => gltf(shot),
        Target::Materialx => materialx::export(shot),
        Target::Mitsuba => mitsuba::export(shot),
        Target::Pbrt => pbrt::export(shot),
        Target::Radiance => radiance::export(shot),
        Target::Usd => usd::export(shot, path),
    }?;
    note_detail(shot.scene, &mut warnings);
    if !target.has_environments() {
        warnings.0.extend(environment::left_out(shot.scene, target));
    }
    Ok((files, warnings))
}

/// What of normal maps and holes no format can express as it is.
fn note_detail(scene: &Scene, warnings: &mut Warnings) {
    for name in group_detail::mixed(scene) {
        warnings.push(format!(
            "group \"{name}\": its objects differ in normal maps or holes, and all were given the same; give each kind a \
             material of its own"
        ));
    }
    let unplaced = group_detail::unplaced(scene);
    if let Some(first) = unplaced.first() {
        let more = match unplaced.len() - 1 {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        warnings.push(format!(
            "object \"{first}\"{more}: without texture coordinates for the holes of its material it may get some of them \
             anywhere; unwrap it, or give it a material of its own"
        ));
    }
}

/// One file, with the camera in place of the scene's.
fn gltf(shot: &SceneView) -> Result<(Files, Warnings), String> {
    let mut warnings = Warnings::default();
    if shot.camera.lens != Lens::default() {
        warnings.push(format!(
            "camera \"{}\": glTF has no words for what a lens does; its camera is the pinhole",
            shot.camera.name
        ));
    }
    let aspect = Some(shot.size.0 as f32 / shot.size.1 as f32);
    let camera = Camera { aspect, ..shot.camera.clone() };
    let scene = Scene { cameras: vec![camera], ..shot.scene.clone() };
    let bytes = gltf::to_glb_as(&scene, shot.materials, shot.light_units);
    let bytes = bytes.map_err(|error| error.to_string())?;
    Ok((vec![("scene.glb".into(), bytes)], warnings))
}

/// Checks, before the work, that an export for `target` could be called `path`.
///
/// # Errors
/// If `path` has the wrong extension, or if something is in the way.
pub fn check_path(path: &Path, target: Target) -> Result<(), FileError> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    if let Some(parent) = parent.filter(|parent| !parent.is_dir()) {
        return Err(FileError::new(path, format!("there is no folder {}", parent.display())));
    }
    if target.extensions().is_empty() {
        return folder::check_folder(path);
    }
    if path.is_dir() {
        return Err(FileError::new(path, "is a folder; name a file"));
    }
    let has = |wanted: &&str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(wanted));
    if !target.extensions().iter().any(has) {
        let wanted = target.extensions().join(" or .");
        return Err(FileError::new(
            path,
            format!("is not called .{wanted}, as files for {target} are"),
        ));
    }
    if target == Target::Usd {
        usd::check(path)?;
    }
    atomic::check(path)
}

/// Writes an export for `target` as `path`, whole or not at all: a file, a file with a folder beside it, or a folder. The
/// folder is not there yet.
///
/// # Errors
/// If `path` cannot be written; nothing is left behind then.
pub fn write(path: &Path, target: Target, files: &Files) -> Result<(), FileError> {
    match files.as_slice() {
        _ if target.extensions().is_empty() => folder::write_folder(path, files),
        [] => Ok(()),
        [(_, bytes)] => atomic::write(path, bytes),
        [(_, bytes), others @ ..] => folder::write_beside(path, bytes, others),
    }
}
