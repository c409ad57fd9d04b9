//! What the edits are applied to: a scene with its materials, and its photograph.

use super::developed::Photograph;
use super::edit_sheet::EditSheet;
use super::raw_camera;
use crate::project::CameraTable;
use crate::result_folder::MATERIALS;
use crate::{Error, Job, Project, job, result_folder, run, up_axis};
use std::path::{Path, PathBuf};
use toml::Spanned;
use unrender_formats::{FileError, Input, Limits, material_file};
use unrender_photo::Exposure;
use unrender_scene::{Camera, Environment, Rgb, Scene, UpAxis, Warnings};

/// The scene before the edits.
#[derive(Debug)]
pub struct Start {
    /// The scene, with the recovered materials.
    pub scene: Scene,
    /// Its file.
    pub path: PathBuf,
    /// The photograph of it.
    pub photograph: Option<Photograph>,
    /// The lights that were off in the photograph, as the scene numbers its sources, and their strength when on.
    pub off: Vec<(usize, Rgb)>,
}

/// The path that `sheets` give for a key, and the name of its place in messages.
fn stated<'a>(
    sheets: &'a [EditSheet],
    key: fn(&EditSheet) -> Option<&Spanned<PathBuf>>,
) -> Option<(PathBuf, &'a EditSheet, String)> {
    let of_sheet = |sheet: &'a EditSheet| {
        let path = key(sheet)?;
        Some((sheet.written.path(path.get_ref()), sheet, sheet.written.place(path.span())))
    };
    // A flag, which follows the file, overrides it.
    sheets.iter().rev().find_map(of_sheet)
}

impl Start {
    /// Reads the scene that `sheets` start from.
    ///
    /// # Errors
    /// If no scene is named, or a file cannot be used.
    pub fn load(sheets: &[EditSheet]) -> Result<(Self, Warnings), Error> {
        let recovered = stated(sheets, |s| s.raw.recovered.as_ref());
        let project = stated(sheets, |s| s.raw.project.as_ref());
        let scene = stated(sheets, |s| s.raw.scene.as_ref());
        let own = stated(sheets, |s| s.raw.materials.as_ref()).map(|m| m.0);
        let limits = sheets.first().map_or_else(Limits::default, |sheet| sheet.written.limits);
        let light_units = sheets.first().and_then(|sheet| sheet.written.light_units);
        if let Some((folder, ..)) = &recovered {
            result_folder::check(folder)?;
        }
        let of_recovery = recovered.as_ref().map(|(folder, ..)| folder.join(MATERIALS));
        let own = own.as_deref().map(result_folder::materials).transpose()?;
        let materials = own.or(of_recovery);
        if let (Some(_), Some((.., place))) = (&project, &scene) {
            return Err(Error::Request(format!(
                "{place}: the project names its scene; give one of them"
            )));
        }
        let up = sheets.iter().rev().find_map(|sheet| sheet.raw.up_axis);
        if let Some((path, ..)) = project {
            let recovered = recovered.as_ref().map(|r| &*r.0);
            let (mut project, warnings) = Project::read(&path)?;
            project.limits = limits;
            project.light_units = light_units.or(project.light_units);
            project.up_axis = up.unwrap_or(project.up_axis);
            return Self::of_project(project, warnings, materials.as_deref(), recovered);
        }
        let folder = recovered.as_ref().filter(|_| scene.is_none()).map(|r| &*r.0);
        let around = folder.map(|folder| run::recovered_environment(folder, limits));
        let around = around.transpose()?.unwrap_or_default();
        let of_run =
            || folder.map(|folder| run::recovered_up(&folder.join("run.json"))).transpose();
        let mut noted = Warnings::default();
        let up = up.map_or_else(of_run, |up| Ok(Some(up)))?;
        let up = up_axis::settled(up, raw_camera::up_axis(sheets), &mut noted);
        let given = scene.as_ref().and_then(|(_, sheet, _)| sheet.written.scene.as_deref());
        let scene = scene.map(|s| s.0).or(recovered.map(|(folder, ..)| folder.join("scene.glb")));
        let scene = scene.ok_or_else(|| {
            Error::Request(
                "nothing to start from: give recovered = \"DIR\", the folder of a recovery, with \
                 project = \"PROJECT.toml\" for its photograph, or scene = \"FILE\""
                    .into(),
            )
        })?;
        let source = Input::new(&scene, limits).in_light_units(light_units);
        let mut warnings = around.warnings;
        let around_scene = around.environment;
        let (start, told) =
            Self::of_scene(source, given, (around_scene, up), materials.as_deref())?;
        warnings.extend(noted);
        warnings.extend(told);
        if let Some(environment) = around.lacking {
            warnings.push(format!(
                "the recovery had an environment ({environment}), which its older results do not hold: \
                 give project = \"PROJECT.toml\", or the environment again"
            ));
        }
        Ok((start, warnings))
    }

    /// The strength of the light called `name` when it is on, and its number as a source of the scene, if it was off in
    /// the photograph.
    pub(super) fn switched_off(&self, name: &str) -> Option<(usize, Rgb)> {
        let is_called = |source: usize| match self.scene.groups.get(source) {
            Some(group) => group.name == name,
            None => self.scene.lights[source - self.scene.groups.len()].name == name,
        };
        self.off.iter().copied().find(|(source, _)| is_called(*source))
    }

    /// The scene, with those of the lights that were off in the photograph on that `sheets` switch on.
    pub(super) fn switched(&self, sheets: &[EditSheet]) -> Scene {
        let mut scene = self.scene.clone();
        let lights = sheets.iter().flat_map(|sheet| &sheet.raw.lights).map(Spanned::get_ref);
        for light in lights.filter(|light| light.on == Some(true)) {
            if let Some((source, strength)) = self.switched_off(&light.name)
                && let Some(of_scene) = scene.strength_mut(source)
            {
                *of_scene = strength;
            }
        }
        scene
    }

    /// The scene in a file, or the one that is `given` instead; in the environment `around` it, if that is not the
    /// scene's own.
    fn of_scene(
        source: Input<'_>,
        given: Option<&Scene>,
        (around, up): (Option<Environment>, UpAxis),
        materials: Option<&Path>,
    ) -> Result<(Self, Warnings), Error> {
        let Input { path, limits, .. } = source;
        let (mut scene, mut warnings) = match given {
            Some(scene) => (scene.clone(), Warnings::default()),
            // Its light may be all around it, or that of the edits.
            None => unrender_formats::load_model(source)?,
        };
        scene.up = up;
        let around = around.map(|around| around.with_up(up));
        scene.environment = around.or(scene.environment.take());
        if let Some(materials) = materials {
            let materials = Input::new(materials, limits);
            warnings.extend(material_file::apply(materials, &mut scene)?);
        }
        warnings.extend(job::validate_meshes(&mut scene, path)?);
        Ok((Self { scene, path: path.to_owned(), photograph: None, off: Vec::new() }, warnings))
    }

    fn of_project(
        project: Project,
        warnings: Warnings,
        materials: Option<&Path>,
        recovered: Option<&Path>,
    ) -> Result<(Self, Warnings), Error> {
        let Job {
            mut scene,
            mut camera,
            picture,
            mut photo,
            mut transfer,
            project,
            off,
            mut warnings,
            ..
        } = Job::load(project, warnings)?;
        let mut found = None;
        if let Some(materials) = materials {
            let input = Input::new(materials, project.limits);
            warnings.extend(material_file::apply(input, &mut scene)?);
            found = material_file::exposure(input)?;
        }
        let mut switched = Vec::new();
        for source in off.into_iter().map(|source| source as usize) {
            switched.extend(scene.strength_mut(source).map(|strength| (source, *strength)));
            scene.scale_source(source, Rgb::ZERO);
        }
        if project.exposure == Exposure::Auto {
            let found = found.ok_or_else(|| {
                FileError::new(
                    &project.path,
                    "exposure is \"auto\"; name the recovery that found it",
                )
            })?;
            for values in [&mut photo.radiance, &mut photo.quantisation_step] {
                values.pixels_mut().iter_mut().for_each(|value| *value *= found);
            }
            transfer.exposure = found;
        }
        // The recovery may have moved the camera to where the model fits the photograph.
        let run = recovered.map(|folder| folder.join("run.json"));
        if let Some(used) = run.map(|run| run::recovered_camera(&run)).transpose()?.flatten()
            && used != CameraTable::of(&camera, 1.0, scene.origin)
        {
            camera = Camera { aspect: camera.aspect, ..used.camera(&camera.name, scene.origin) };
        }
        let photograph = Photograph { picture, photo, transfer, camera };
        Ok((
            Self { scene, path: project.scene, photograph: Some(photograph), off: switched },
            warnings,
        ))
    }
}
