//! The files that `recover` writes into its folder, and the tables that it and `calibrate` print.

mod artist;
mod ball;
mod calibration;
mod dark;
mod difference;
mod error_picture;
mod group_picture;
mod memory;
pub(crate) mod restaged;
mod run_file;
mod scale_bar;
mod status_picture;
mod summary;
mod textures;

pub(crate) use calibration::calibration;
pub(crate) use summary::summary;

use difference::{Difference, Missed};

use crate::check::uvs;
use crate::engine::Recovered;
use crate::project::CameraChoice;
use crate::result_folder::MATERIALS;
use crate::run::{self, MissEntry, Pictures, Run};
use crate::{Error, Job, report};
use std::path::Path;
use unrender_formats::{FileError, atomic, gltf, materials, picture};
use unrender_scene::color::srgb_from_linear;
use unrender_scene::{Camera, Rgb, Status, Warnings};

impl Recovered {
    /// The table that the command prints.
    pub fn summary(&self, job: &Job) -> String {
        summary(job, self)
    }
}

/// The folder of the pictures that only the report shows.
const REPORT_FOLDER: &str = "report";

/// Whether [`write`] may write a file of this name, relative to its folder.
pub(crate) fn writes(name: &str) -> bool {
    let numbered = |rest: &str| rest.starts_with(|c: char| c.is_ascii_digit());
    [MATERIALS, "run.json", report::FILE, report::VIEW, "scene.glb", run::PANORAMA, "manifest.json"]
        .contains(&name)
        || is_picture(name)
        || ["error", "group"].iter().any(|stem| name.starts_with(stem) && name.ends_with(".png"))
        || name.strip_prefix("texture_").is_some_and(numbered)
        || name.starts_with("report/")
}

/// Whether it is a picture of a photograph, numbered if there are several.
fn is_picture(name: &str) -> bool {
    let Some((stem, extension)) = name.rsplit_once('.') else { return false };
    let (kind, number) = stem.split_once('_').unwrap_or((stem, "1"));
    let is_number = number.bytes().all(|byte| byte.is_ascii_digit());
    let is_kind = ["photo", "rerendered", "trust"].contains(&kind);
    is_number && is_kind && (extension == "png" || (kind, extension) == ("rerendered", "exr"))
}

/// Writes all files of a recovery into `folder`, which exists, and returns its run.json. New warnings go to `warn`.
pub(crate) fn write(
    job: &Job,
    recovered: &Recovered,
    folder: &Path,
    warn: &dyn Fn(&Warnings),
) -> Result<Run, Error> {
    crate::output::prepare_folder(&folder.join(REPORT_FOLDER))?;
    let recovery = &recovered.recovery;
    let mut bad = 0;
    let file = textures::write(job, recovered, folder, &mut bad)?;
    let mut pictures = Vec::new();
    let mut misses: Vec<Option<Missed>> = vec![None; recovery.groups.len()];
    for k in 0..job.photographs() {
        let number = if job.photographs() > 1 { format!("_{}", k + 1) } else { String::new() };
        let (alone, recovered) = (job.alone(k), recovered.alone(job, k));
        let difference = Difference::of(&alone, &recovered.recovery);
        let to = (folder, number.as_str());
        pictures.push(write_pictures(&alone, &recovered, &difference, to, &mut bad)?);
        for (group, missed) in misses.iter_mut().enumerate() {
            let more = difference.miss(&recovered.group_map, group, k + 1);
            *missed = missed.zip(more).map(|(missed, more)| missed.and(more)).or(*missed).or(more);
        }
    }
    let misses: Vec<Option<MissEntry>> =
        misses.into_iter().map(|missed| missed.map(Missed::entry)).collect();
    let balls = ball::write(job, recovered, folder)?;
    atomic::write(&folder.join("scene.glb"), &scene_file(job, recovered)?)?;
    if let Some(environment) = &recovered.scene(job).environment {
        run::write_panorama(environment, folder)?;
    }
    let mut warnings = job.warnings.clone();
    recovered.registered.iter().for_each(|of| warnings.extend(of.warnings.clone()));
    let mut doubts = Warnings::default();
    for (index, group) in recovery.groups.iter().enumerate() {
        let is_textured = group.material.texture.is_some();
        if is_textured || group.status == Status::Doubtful {
            let doubt = uvs::doubt(&job.scene, index, is_textured);
            doubt.into_iter().for_each(|doubt| doubts.push(doubt));
        }
    }
    dark::doubt(&recovery.groups).into_iter().for_each(|doubt| doubts.push(doubt));
    warn(&doubts);
    warnings.extend(doubts);
    if bad > 0 {
        let noted = format!("{bad} value(s) were not finite numbers and were written as zero");
        let mut late = Warnings::default();
        late.push(noted);
        warn(&late);
        warnings.extend(late);
    }
    let run = run_file::build(job, recovered, &file, (pictures, balls, &misses), warnings);
    run.write(folder)?;
    report::write(folder)?;
    materials::write(&folder.join(MATERIALS), &file)?;
    Ok(run)
}

/// Writes the pictures of one photograph of a recovery that lie beside its report, with its `number` in
/// their names; counts bad values in `bad`.
fn write_pictures(
    job: &Job,
    recovered: &Recovered,
    difference: &Difference,
    (folder, number): (&Path, &str),
    bad: &mut usize,
) -> Result<Pictures, Error> {
    let recovery = &recovered.recovery;
    let named = |stem: &str| format!("{stem}{number}.png");
    let (photo, rerendered, trust) = (named("photo"), named("rerendered"), named("trust"));
    let radiance = recovered.rerendered();
    *bad += picture::write_exr(&folder.join(format!("rerendered{number}.exr")), radiance)?;
    let exposure = recovered.exposure_of(job, 0);
    let denoised = recovered.denoised(job);
    let as_photo = denoised.as_ref().unwrap_or(radiance).map(|radiance| *radiance / exposure);
    *bad += picture::write_png_srgb(&folder.join(&rerendered), &as_photo)?;
    let developed = job.transfer.exposure;
    let as_linear = recovered.photo(job).map(|radiance| *radiance / developed);
    *bad += picture::write_png_srgb(&folder.join(&photo), &as_linear)?;
    status_picture::write(job, recovery, &folder.join(&trust))?;
    let errors = error_picture::write(difference, (folder, number))?;
    Ok(Pictures {
        photo,
        rerendered,
        trust,
        groups: group_picture::write(recovered, (folder, number))?,
        errors: errors.pictures,
        difference: Some(errors.entry),
        denoised: denoised.is_some(),
    })
}

/// The path of one of the report's own pictures, relative to the folder of the results.
fn report_folder(file: &str) -> String {
    format!("{REPORT_FOLDER}/{file}")
}

/// A linear colour as `#rrggbb`.
fn hex(color: Rgb) -> String {
    let code = |v: f32| (255.0 * srgb_from_linear(v)).round() as u8;
    let [r, g, b] = color.to_array().map(code);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The bytes of scene.glb. It keeps everything else in the user's file, unless the project changes
/// the places of lights.
fn scene_file(job: &Job, recovered: &Recovered) -> Result<Vec<u8>, FileError> {
    let (mut scene, path) = (recovered.scene(job), &job.project.scene);
    let added = cameras_of_project(job, recovered);
    scene.cameras.retain(|camera| added.iter().all(|added| added.name != camera.name));
    scene.cameras.extend_from_slice(&added);
    // A scene that was handed over in memory has no file.
    if job.project.rebuilds_lights() || !path.exists() {
        return gltf::to_glb(&scene).map_err(|error| FileError::new(path, error));
    }
    unrender_formats::assign_materials(job.project.scene_input(), &scene, &added)
}

/// The cameras of the photographs that the scene's file lacks, since the project describes them.
fn cameras_of_project(job: &Job, recovered: &Recovered) -> Vec<Camera> {
    let count = job.photographs();
    let of_photograph = |k: usize| {
        let alone = job.alone(k);
        if matches!(alone.project.camera, CameraChoice::First | CameraChoice::Named(_)) {
            return None;
        }
        let number = if count > 1 { format!(" {}", k + 1) } else { String::new() };
        let camera = alone.camera_of_photograph(&recovered.registered[k].camera);
        Some(Camera { name: format!("photograph{number}"), ..camera })
    };
    (0..count).filter_map(of_photograph).collect()
}
