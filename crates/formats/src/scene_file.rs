//! Scenes by file extension: the one place that knows which formats there are.

use crate::import::{mitsuba, radiance};
use crate::{FileError, Input, gltf, near, obj};
use glam::DVec3;
use std::path::Path;
use unrender_scene::{Camera, Scene, SceneError, Warnings};

enum Format {
    Gltf,
    Obj,
    Mitsuba,
    Radiance,
}

impl Format {
    /// The scene of `input`. A scene far from zero is read a second time, relative to its middle: positions are
    /// in single precision, files may have more digits.
    fn read(&self, input: Input<'_>) -> Result<(Scene, Warnings), FileError> {
        let (scene, warnings) = self.read_about(input)?;
        let origin = scene.far_origin();
        if origin == DVec3::ZERO {
            return Ok((scene, warnings));
        }
        // Freed before the second one is allocated.
        drop(scene);
        let (scene, warnings) = self.read_about(input.about(origin))?;
        Ok((Scene { origin, ..scene }, warnings))
    }

    fn read_about(&self, input: Input<'_>) -> Result<(Scene, Warnings), FileError> {
        match self {
            Self::Gltf => gltf::read(input),
            Self::Obj => obj::read(input),
            Self::Mitsuba => mitsuba::read(input),
            Self::Radiance => radiance::read(input),
        }
    }
}

/// Reads and validates the scene at `path`.
///
/// The scene may have no camera.
///
/// ```
/// use unrender_formats::{gltf, load_scene};
/// use unrender_scene::{Group, Material, Mesh, Object, Rgb, Scene};
///
/// let mut scene = Scene::default();
/// let material = Material::diffuse(Rgb::splat(0.5));
/// scene.groups.push(Group { name: "lamp".into(), material, emission: Rgb::ONE });
/// let mesh = Mesh::sphere(glam::Vec3::ZERO, 0.1);
/// scene.objects.push(Object { name: "bulb".into(), group: 0, mesh });
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scene.glb");
/// std::fs::write(&path, gltf::to_glb(&scene)?)?;
/// let (back, warnings) = load_scene(&path)?;
/// assert_eq!(back.groups[0].name, "lamp");
/// assert!(warnings.0.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the file is missing, of no known format, damaged, or its scene unusable.
pub fn load_scene<'a>(input: impl Into<Input<'a>>) -> Result<(Scene, Warnings), FileError> {
    load(input.into(), Scene::validate)
}

/// Reads the model at `path`, which is to be put into a scene and needs no light of its own.
///
/// # Errors
/// If the file is missing, of no known format, damaged, or its meshes unusable.
pub fn load_model<'a>(input: impl Into<Input<'a>>) -> Result<(Scene, Warnings), FileError> {
    load(input.into(), Scene::validate_meshes)
}

fn load(
    input: Input<'_>,
    validate: fn(&mut Scene) -> Result<Warnings, SceneError>,
) -> Result<(Scene, Warnings), FileError> {
    let path = input.path;
    let format = format_of(path)?;
    if !path.exists() {
        return Err(FileError::new(path, "does not exist"));
    }
    let (mut scene, mut warnings) = format.read(input)?;
    near::settle(&mut scene, &mut warnings);
    let doubts = validate(&mut scene)
        .map_err(|error| FileError::because(path, "", error).after(&warnings))?;
    warnings.extend(doubts);
    Ok((scene, warnings))
}

/// The bytes of a `.glb` that shows what `source` shows, with the materials of `scene`; `added` are those of its cameras
/// that the file lacks.
///
/// A glTF file keeps everything else in it ([`gltf::assign_materials`]); from other formats the scene
/// itself is written ([`gltf::to_glb`]).
///
/// # Errors
/// If `source` cannot be read or the scene cannot be written.
pub fn assign_materials<'a>(
    source: impl Into<Input<'a>>,
    scene: &Scene,
    added: &[Camera],
) -> Result<Vec<u8>, FileError> {
    let source = source.into();
    match format_of(source.path)? {
        Format::Gltf => gltf::assign_materials(source, scene, added),
        _ => gltf::to_glb(scene).map_err(|error| FileError::new(source.path, error)),
    }
}

/// The bytes of a `.glb` that shows what `source` shows, with one more camera, whose position counts from
/// `origin` ([`Scene::origin`] of the scene that was read); one of the same name is replaced. glTF cannot
/// express distortion.
///
/// # Errors
/// If `source` cannot be read or the scene cannot be written.
pub fn place<'a>(
    source: impl Into<Input<'a>>,
    camera: &Camera,
    origin: DVec3,
) -> Result<Vec<u8>, FileError> {
    let source = source.into();
    match format_of(source.path)? {
        Format::Gltf => gltf::place(source, camera, origin),
        format => {
            let (mut scene, _) = format.read(source)?;
            let mut camera = camera.clone();
            camera.world_from_camera.translation += (origin - scene.origin).as_vec3a();
            scene.cameras.push(camera);
            gltf::to_glb(&scene).map_err(|error| FileError::new(source.path, error))
        }
    }
}

/// Whether the file at `path` is called as a scene of a known format.
pub(crate) fn is_scene(path: &Path) -> bool {
    format_of(path).is_ok()
}

fn format_of(path: &Path) -> Result<Format, FileError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        "glb" | "gltf" => Ok(Format::Gltf),
        "obj" => Ok(Format::Obj),
        "xml" => Ok(Format::Mitsuba),
        "rad" => Ok(Format::Radiance),
        _ => Err(FileError::new(
            path,
            "is no scene of a known format; scenes are read from .glb, .gltf, .obj, .xml (Mitsuba 3) and .rad (Radiance)",
        )),
    }
}
