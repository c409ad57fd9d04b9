//! What `recover` leaves in its folder, and the tables that it and `calibrate` print.

mod ball;
mod calibration;
mod dark;
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

use crate::check::uvs;
use crate::engine::Recovered;
use crate::listener::Console;
use crate::run::{Pictures, Run};
use crate::{Error, Job, report};
use std::path::Path;
use unrender_formats::{FileError, atomic, gltf, materials, picture};
use unrender_scene::color::srgb_from_linear;
use unrender_scene::{Rgb, Warnings};

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
    ["materials.json", "run.json", "report.html", "scene.glb", "manifest.json"].contains(&name)
        || ["photo.png", "rerendered.png", "rerendered.exr", "trust.png"].contains(&name)
        || ["error", "group"].iter().any(|stem| name.starts_with(stem) && name.ends_with(".png"))
        || name.strip_prefix("texture_").is_some_and(numbered)
        || name.starts_with("report/")
}

/// Writes all files of a recovery into `folder`, which exists, and returns what it said of itself.
pub(crate) fn write(
    job: &Job,
    recovered: &Recovered,
    folder: &Path,
    console: &Console,
) -> Result<Run, Error> {
    crate::output::prepare_folder(&folder.join(REPORT_FOLDER))?;
    let recovery = &recovered.recovery;
    let mut bad = 0;
    let file = textures::write(job, recovered, folder, &mut bad)?;
    bad += picture::write_exr(&folder.join("rerendered.exr"), recovered.rerendered())?;
    let pictures = write_pictures(job, recovered, folder, &mut bad)?;
    let balls = ball::write(job, recovered, folder)?;
    atomic::write(&folder.join("scene.glb"), &scene_file(job, recovered)?)?;
    let mut warnings = job.warnings.clone();
    warnings.extend(recovered.registered.warnings.clone());
    let mut doubts = Warnings::default();
    for (index, group) in recovery.groups.iter().enumerate() {
        if group.material.texture.is_some() {
            uvs::doubt(&job.scene, index).into_iter().for_each(|doubt| doubts.push(doubt));
        }
    }
    dark::doubt(&recovery.groups).into_iter().for_each(|doubt| doubts.push(doubt));
    console.warn(&doubts);
    warnings.extend(doubts);
    if bad > 0 {
        let noted = format!("{bad} value(s) were not finite numbers and were written as zero");
        let mut late = Warnings::default();
        late.push(noted);
        console.warn(&late);
        warnings.extend(late);
    }
    let run = run_file::build(job, recovered, &file, (pictures, balls), warnings);
    run.write(folder)?;
    report::write(folder)?;
    materials::write(&folder.join("materials.json"), &file)?;
    Ok(run)
}

/// Writes the pictures of a recovery that stand beside its report; counts bad values in `bad`.
fn write_pictures(
    job: &Job,
    recovered: &Recovered,
    folder: &Path,
    bad: &mut usize,
) -> Result<Pictures, Error> {
    let recovery = &recovered.recovery;
    let exposure = recovery.exposure;
    let as_photo = recovered.rerendered().map(|radiance| *radiance / exposure);
    *bad += picture::write_png_srgb(&folder.join("rerendered.png"), &as_photo)?;
    let fixed = matches!(job.project.exposure, unrender_photo::Exposure::Fixed(_));
    let developed = if fixed { exposure } else { Rgb::ONE };
    let photo = recovered.photo(job).map(|radiance| *radiance / developed);
    *bad += picture::write_png_srgb(&folder.join("photo.png"), &photo)?;
    status_picture::write(job, recovery, &folder.join("trust.png"))?;
    Ok(Pictures {
        photo: "photo.png".to_owned(),
        rerendered: "rerendered.png".to_owned(),
        trust: "trust.png".to_owned(),
        groups: group_picture::write(recovered, folder)?,
        errors: error_picture::write(job, recovery, folder)?,
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

/// The bytes of scene.glb. A file of the user keeps what it has beside, unless the project puts
/// lights elsewhere than it has them.
fn scene_file(job: &Job, recovered: &Recovered) -> Result<Vec<u8>, FileError> {
    let (scene, path) = (recovered.scene(job), &job.project.scene);
    // A scene that was handed over in memory has no file.
    if job.project.rebuilds_lights() || !path.exists() {
        return gltf::to_glb(&scene).map_err(|error| FileError::new(path, error));
    }
    unrender_formats::assign_materials(job.project.scene_input(), &scene)
}
