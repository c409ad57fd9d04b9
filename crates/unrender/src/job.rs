//! Reads and checks everything that a recovery starts from.

use crate::lighting::EnvironmentChoice;
use crate::project::{CameraChoice, Found, Photographed, Project, Taken};
use crate::shot::Shot;
use crate::{Error, mask, photograph, same_as, ungrouped};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::path::Path;
use unrender_formats::picture::{self, Orientation, Picture};
use unrender_formats::{FileError, Input};
use unrender_photo::{Photo, Transfer, clipping, develop};
use unrender_render::{GeometryBuffers, PixelGeometry};
use unrender_scene::{Camera, Image, Object, Rgb, Scene, Ungrouped, Warnings};

/// Two aspects (width over height) are equal up to this share.
const ASPECT_TOLERANCE: f32 = 0.01;

/// The checked input of a recovery.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Job {
    /// The scene in the project's light; known groups have their known materials, `brdf` is the
    /// project's.
    pub scene: Scene,
    /// The camera of the photograph.
    pub camera: Camera,
    /// The photograph as in its file.
    pub picture: Picture,
    /// The photograph as radiance; with exposure "auto", for an exposure of one.
    pub photo: Photo,
    /// The side of the squares of the photograph's pixels whose means are the pixels of `photo` and `mask`, to
    /// which `camera` belongs: one, unless the job was reduced ([`Job::reduce`]).
    pub side: usize,
    /// False for the pixels of the photograph that the project's mask leaves out.
    pub mask: Option<Image<bool>>,
    /// The transfer function between the photograph's codes and that radiance.
    pub transfer: Transfer,
    /// The project, its exposure settled by [`Project::settle_scale`].
    pub project: Project,
    /// The sources of light that were off when the photograph was taken, ascending, as in `unknown_lights`.
    pub off: Vec<u32>,
    /// The further photographs, if the project has several: all fields above belong to the first.
    pub further: Vec<Shot>,
    /// The sources with unknown brightness, ascending: a group's index for area lights, and
    /// for the others the number of groups plus the index among the scene's lights.
    pub unknown_lights: Vec<usize>,
    /// The group of every object in the scene's file; in `scene`, objects of groups with `same_as`
    /// belong to the group named there.
    pub own_groups: Vec<usize>,
    /// Warnings of all of it.
    pub warnings: Warnings,
}

/// Data that a caller has in memory instead of the files that a project names.
#[derive(Clone, Debug, Default)]
pub struct InMemory {
    /// The scene; its results are written as a new glTF file.
    pub scene: Option<Scene>,
    /// The photograph, as a file would have it.
    pub photo: Option<Picture>,
    /// The mask.
    pub mask: Option<Picture>,
}

impl Job {
    /// Reads the files that `project` names; `warnings` are those of reading it.
    ///
    /// # Errors
    /// If the photograph or the scene cannot be read, if they do not fit the project, or if nothing
    /// fixes the scale of unknown lights.
    pub fn load(project: Project, warnings: Warnings) -> Result<Self, Error> {
        Self::assemble(project, warnings, InMemory::default())
    }

    /// As [`Job::load`], with data in memory instead of the named files.
    ///
    /// # Errors
    /// Those of [`Job::load`].
    pub fn assemble(
        mut project: Project,
        mut warnings: Warnings,
        given: InMemory,
    ) -> Result<Self, Error> {
        let is_file = given.photo.is_none();
        let picture = photo(&mut project, given.photo, &mut warnings)?;
        let mut scene = model(&project, given.scene, &mut warnings)?;
        warnings.extend(project.light(&mut scene)?);
        project.check_against(&scene)?;
        warnings.extend(project.settle_scale(&scene)?);
        warnings.extend(settle_brdf(&project, &mut scene)?);
        warnings.extend(validate(&mut scene, &project.scene)?);
        set_ignored_apart(&project, &mut scene);
        let own_groups = same_as::merge(&project, &mut scene);
        let first = taken(&mut project, &scene, (picture, given.mask), is_file, &mut warnings)?;
        if matches!(project.environment, Some(EnvironmentChoice::Unknown { .. })) {
            start_environment(&mut scene, &first.photo);
        }
        let further =
            project.further.iter().map(|taken| further(&project, taken, &scene, &mut warnings));
        let further = further.collect::<Result<Vec<Shot>, Error>>()?;
        let unknown_lights = project.unknown_sources(&scene);
        let Shot { camera, picture, photo, mask, transfer, off, .. } = first;
        Ok(Self {
            scene,
            camera,
            picture,
            photo,
            side: 1,
            mask,
            transfer,
            project,
            off,
            further,
            unknown_lights,
            own_groups,
            warnings,
        })
    }

    /// For every pixel of `geometry`, as seen by the `camera` of `photograph`, whether the project includes it: it is
    /// not masked, its group is not ignored, and no glass or ignored shape is before it.
    pub(crate) fn counts(
        &self,
        photograph: usize,
        (camera, geometry): (&Camera, &GeometryBuffers),
    ) -> Vec<bool> {
        let groups = self.scene.groups.iter();
        let ignored: Vec<bool> =
            groups.map(|group| self.project.ignored.contains(&group.name)).collect();
        let is_ignored = |group: u32| ignored.get(group as usize).copied().unwrap_or(false);
        let mask = self.mask_of(photograph);
        let masked = |index: usize| mask.is_some_and(|mask| !mask.pixels()[index]);
        let clear = ungrouped::covered(&self.scene, camera, geometry);
        let is_clear = |index: usize| clear.as_ref().is_some_and(|clear| clear[index]);
        let pixels = geometry.pixels().iter().enumerate();
        let counts = |(index, pixel): (usize, &PixelGeometry)| {
            !masked(index) && !is_ignored(pixel.group) && !is_clear(index)
        };
        pixels.map(counts).collect()
    }
}

/// Takes the objects of ignored groups of which nothing is known out of the light: they belong to no group. Lamps stay,
/// and what is stated of a group beside `ignore` is what its objects are.
fn set_ignored_apart(project: &Project, scene: &mut Scene) {
    let groups = &scene.groups;
    let is_apart = |object: &Object| {
        let group = &groups[object.group];
        let name = &group.name;
        project.ignored.contains(name) && !project.known.contains_key(name) && !group.is_emitter()
    };
    let (apart, kept): (Vec<_>, Vec<_>) =
        std::mem::take(&mut scene.objects).into_iter().partition(is_apart);
    scene.objects = kept;
    let shape = |object: Object| {
        let material = scene.groups[object.group].name.clone();
        Ungrouped { material, mesh: object.mesh, glass: None }
    };
    scene.ungrouped.extend(apart.into_iter().map(shape).collect::<Vec<_>>());
}

/// Gives the scene the BRDF model of the project, if that states one, and known groups their materials.
fn settle_brdf(project: &Project, scene: &mut Scene) -> Result<Warnings, Error> {
    let mut warnings = Warnings::default();
    scene.brdf = project.brdf.unwrap_or(scene.brdf).with_layering(project.layering);
    if !scene.brdf.is_principled() {
        scene.free();
    } else if let Some(layering) = project.layering {
        scene.layer(layering);
    }
    for (name, known) in &project.known {
        let Some(index) = scene.group_index(name) else { continue };
        if let Some(file) = &known.file {
            warnings.extend(file.apply(scene, index, project.limits)?);
        } else {
            let material = known.material(scene.brdf).map_err(|problem| {
                FileError::new(&project.path, format!("groups.{name}.known: {problem}"))
            })?;
            scene.groups[index].material = material;
        }
    }
    Ok(warnings)
}

/// The photograph of `project` with its camera in `scene`; `picture` is read already, `mask` if it was given in
/// memory.
fn taken(
    project: &mut Project,
    scene: &Scene,
    (mut picture, mask): (Picture, Option<Picture>),
    is_file: bool,
    warnings: &mut Warnings,
) -> Result<Shot, Error> {
    let Found { camera, is_mirrored, warnings: noted } =
        choose_camera(project, scene, &picture, is_file)?;
    warnings.extend(noted);
    if is_mirrored {
        picture = picture.mirrored();
    }
    let (transfer, noted) = photograph::transfer(project, &picture, &camera)?;
    warnings.extend(noted);
    let photo = develop(&picture, &transfer);
    if photo.dark > 0 {
        warnings.push(format!(
            "{} pixel(s) of the photo lie in the noise near black and were left out",
            photo.dark
        ));
    }
    let mask = match mask {
        Some(mask) => {
            let counts = mask::counts(&mask, &picture.values);
            Some(counts.map_err(|problem| FileError::new(&project.path, problem))?)
        }
        None => mask::read(project, &picture)?,
    };
    let mask = if is_mirrored { mask.map(|mask| mask.mirrored()) } else { mask };
    let (width, height) = (photo.radiance.width(), photo.radiance.height());
    warnings.extend(doubtful_aspect(&camera, width, height));
    warnings.extend(folded_lens(&camera, width, height));
    let off = project.switched.off(scene);
    Ok(Shot { project: project.clone(), camera, picture, photo, mask, transfer, off })
}

/// A further photograph of `project`, stated by `taken`.
fn further(
    project: &Project,
    how: &Taken,
    scene: &Scene,
    warnings: &mut Warnings,
) -> Result<Shot, Error> {
    let mut alone = project.of_further(how);
    let mut noted = Warnings::default();
    let picture = photo(&mut alone, None, &mut noted)?;
    let shot = taken(&mut alone, scene, (picture, None), true, &mut noted)?;
    let name = how.photo.file_name().unwrap_or(how.photo.as_os_str()).to_string_lossy();
    noted.0.iter().for_each(|warning| warnings.push(format!("{name}: {warning}")));
    Ok(shot)
}

/// Starts the search for an unknown environment at the mean of the photograph: light that makes things this bright
/// is about as bright.
fn start_environment(scene: &mut Scene, photo: &Photo) {
    let valid = photo.radiance.pixels().iter().zip(photo.valid.pixels());
    let valid = valid.filter(|(_, valid)| **valid).map(|(radiance, _)| radiance.as_dvec3());
    let (sum, count) = valid.fold((DVec3::ZERO, 0.0), |(sum, n), value| (sum + value, n + 1.0));
    let mean = (sum / f64::max(count, 1.0)).as_vec3();
    // A channel without light starts at one.
    let mean = Rgb::select(mean.cmpgt(Rgb::ZERO), mean, Rgb::ONE);
    scene.environment.iter_mut().for_each(|environment| environment.scale(mean));
}

/// The photograph of `project`, as given or from its files, with warnings of clipped codes.
fn photo(
    project: &mut Project,
    given: Option<Picture>,
    warnings: &mut Warnings,
) -> Result<Picture, Error> {
    let picture = match (given, project.bracket.clone()) {
        (Some(picture), _) => picture,
        (None, Some(frames)) => photograph::merged(project, &frames, warnings)?,
        (None, None) => {
            let (picture, noted) = picture::read(Input::new(&project.photo, project.limits))?;
            warnings.extend(noted.clone());
            if picture.invalid.len() == picture.values.pixels().len() {
                return Err(without_measurement(&project.photo, &noted).into());
            }
            picture
        }
    };
    if let (Some(max), [r, g, b]) = (picture.depth.max_code(), clipping::full_codes(&picture)) {
        let codes = [("red", r), ("green", g), ("blue", b)];
        for (channel, code) in codes.iter().filter_map(|(c, code)| code.map(|code| (c, code))) {
            warnings.push(format!(
                "the {channel} of the photo saturates at the code {code} of {max}: pixels of that \
                 code are taken as clipped"
            ));
        }
    }
    Ok(picture)
}

/// The error of a photograph without a valid pixel, for the reasons in `noted`.
fn without_measurement(path: &Path, noted: &Warnings) -> FileError {
    let reasons: Vec<&str> = noted.0.iter().map(String::as_str).collect();
    let problem =
        "has no pixel with a measurement; if its alpha channel is no coverage, save it without one";
    FileError::new(path, format!("{problem} ({})", reasons.join("; ")))
}

/// The meshes and materials of `project`, as given or from its file; its light may be only in the project.
fn model(project: &Project, given: Option<Scene>, warnings: &mut Warnings) -> Result<Scene, Error> {
    let (scene, noted) = match given {
        Some(mut scene) => {
            let noted = validate_meshes(&mut scene, &project.scene)?;
            (scene, noted)
        }
        None => unrender_formats::load_model(project.scene_input())?,
    };
    warnings.extend(noted);
    Ok(scene)
}

/// A warning where the lens of `camera` shows two directions in one place of the photograph.
fn folded_lens(camera: &Camera, width: usize, height: usize) -> Warnings {
    let mut warnings = Warnings::default();
    if !camera.covers(width, height) {
        warnings.push(format!(
            "the distortion of camera \"{}\" (k1 = {}, k2 = {}, k3 = {}) folds over before the \
             corners of the photo; the picture beyond is wrong",
            camera.name, camera.lens.k1, camera.lens.k2, camera.lens.k3
        ));
    }
    warnings
}

/// [`Scene::validate`] with the file's name in the error.
pub(crate) fn validate(scene: &mut Scene, path: &Path) -> Result<Warnings, Error> {
    scene.validate().map_err(|source| Error::Scene { path: path.to_owned(), source })
}

/// [`Scene::validate_meshes`] with the file's name in the error.
pub(crate) fn validate_meshes(scene: &mut Scene, path: &Path) -> Result<Warnings, Error> {
    scene.validate_meshes().map_err(|source| Error::Scene { path: path.to_owned(), source })
}

/// The camera of the project's photograph, which is in memory unless it `is_file`.
fn choose_camera(
    project: &Project,
    scene: &Scene,
    picture: &Picture,
    is_file: bool,
) -> Result<Found, Error> {
    let size = (picture.values.width(), picture.values.height());
    let as_it_is = |(camera, warnings)| Found { camera, is_mirrored: false, warnings };
    match &project.camera {
        CameraChoice::InPixels { stand, intrinsics } => {
            let pose = stand.camera("project", scene.origin, 1.0).world_from_camera;
            let camera = intrinsics.camera("project", pose, size);
            let fault = |problem| FileError::new(&project.path, format!("camera: {problem}"));
            Ok(as_it_is((camera.map_err(fault)?, Warnings::default())))
        }
        CameraChoice::Calibrated(calibrated) => {
            let upright = Ok(Orientation::UPRIGHT);
            let orientation = if is_file { photograph::orientation(project) } else { upright }?;
            let photo = Photographed { size, orientation };
            Ok(calibrated.read(photo, scene.origin, project.limits)?)
        }
        CameraChoice::Placed(table) => {
            Ok(as_it_is((table.camera("project", scene.origin), Warnings::default())))
        }
        CameraChoice::Named(name) => named_camera(scene, Some(name), &project.scene).map(as_it_is),
        CameraChoice::First => named_camera(scene, None, &project.scene).map(as_it_is),
    }
}

/// The scene's camera called `name`, or its first one; `path` names the scene in messages.
pub(crate) fn named_camera(
    scene: &Scene,
    name: Option<&str>,
    path: &Path,
) -> Result<(Camera, Warnings), Error> {
    let names: Vec<&str> = scene.cameras.iter().map(|c| c.name.as_str()).collect();
    let path = path.display();
    let mut warnings = Warnings::default();
    let chosen = match name {
        Some(name) => scene.cameras.iter().find(|c| c.name == name).ok_or_else(|| {
            format!("{path}: there is no camera \"{name}\"; there are: {}", names.join(", "))
        }),
        None => scene.cameras.first().ok_or_else(|| {
            format!(
                "{path}: the scene has no camera; export it with one, or give the project a table \
                 [camera] with eye, target, up and fov_y_deg"
            )
        }),
    };
    if name.is_none() && names.len() > 1 {
        warnings.push(format!(
            "{path}: there are the cameras {}; the first was taken: choose one by its name",
            names.join(", ")
        ));
    }
    Ok((chosen.map_err(Error::Request)?.clone(), warnings))
}

/// Warnings of a photo of `width` x `height` pixels by this camera.
fn doubtful_aspect(camera: &Camera, width: usize, height: usize) -> Warnings {
    let mut warnings = Warnings::default();
    let Some(stated) = camera.aspect else { return warnings };
    let photo = width as f32 / height as f32;
    let differs = |a: f32, b: f32| (a / b - 1.0).abs() > ASPECT_TOLERANCE;
    if !differs(stated, photo) {
        return warnings;
    }
    let name = |aspect: f32| if aspect > 1.0 { "landscape" } else { "portrait" };
    if name(stated) != name(photo) && differs(stated, 1.0) && differs(photo, 1.0) {
        warnings.push(format!(
            "the photo is {} ({width} x {height}), but camera \"{}\" is {} (aspect {stated:.3}); \
             is the photo turned?",
            name(photo),
            camera.name,
            name(stated)
        ));
    } else {
        warnings.push(format!(
            "the photo's aspect is {photo:.3}, that of camera \"{}\" {stated:.3}; \
             the camera's vertical field of view was kept, which is right only if the photo was \
             cropped or widened at its sides",
            camera.name
        ));
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn camera(name: &str, aspect: Option<f32>) -> Camera {
        let camera = Camera::look_at(name, Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0);
        Camera { aspect, ..camera }
    }

    #[test]
    fn aspects_that_do_not_fit_are_reported() {
        let noted = |aspect, width, height| doubtful_aspect(&camera("c", aspect), width, height).0;
        assert!(noted(None, 3, 2).is_empty());
        assert!(noted(Some(1.5), 300, 200).is_empty());
        assert!(noted(Some(1.5), 301, 200).is_empty());
        assert!(noted(Some(1.5), 320, 200)[0].contains("vertical field of view"));
        assert!(noted(Some(1.5), 200, 300)[0].contains("is portrait (200 x 300)"));
        assert!(noted(Some(1.0), 200, 300)[0].contains("vertical field of view"));
    }

    #[test]
    fn cameras_are_chosen_by_name_or_the_first_with_a_warning() {
        let path = Path::new("s.glb");
        let mut scene = Scene::default();
        let error = named_camera(&scene, None, path).unwrap_err().to_string();
        assert!(error.contains("[camera]"), "{error}");
        scene.cameras = vec![camera("a", None), camera("b", None)];
        let (chosen, warnings) = named_camera(&scene, None, path).unwrap();
        assert_eq!((chosen.name.as_str(), warnings.0.len()), ("a", 1));
        let (chosen, warnings) = named_camera(&scene, Some("b"), path).unwrap();
        assert_eq!((chosen.name.as_str(), warnings.0.len()), ("b", 0));
        let error = named_camera(&scene, Some("x"), path).unwrap_err().to_string();
        assert!(error.contains("there are: a, b"), "{error}");
    }
}
