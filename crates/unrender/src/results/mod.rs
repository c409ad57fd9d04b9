//! What `recover` leaves in its folder, and the tables that it and `calibrate` print.

mod calibration;
mod error_picture;
mod materials_file;
mod report;
pub(crate) mod restaged;
mod run_file;
mod scale_bar;
mod summary;
mod trust_picture;

pub(crate) use calibration::calibration;
pub(crate) use run_file::camera as recovered_camera;
pub(crate) use summary::{summary, table};

use crate::engine::Recovered;
use crate::{Error, Job, interrupt};
use std::path::Path;
use unrender_formats::{atomic, materials, picture};
use unrender_scene::{Scene, Warnings};

/// Writes all files of a recovery into `folder`, which exists. Ctrl-C waits until they are whole.
pub(crate) fn write(job: &Job, recovered: &Recovered, folder: &Path) -> Result<Warnings, Error> {
    let _until_written = interrupt::writing();
    let recovery = &recovered.recovery;
    let mut bad = 0;
    let file = materials_file::build(job, recovered, folder, &mut bad)?;
    bad += picture::write_exr(&folder.join("rerendered.exr"), &recovery.rerendered)?;
    let exposure = recovery.exposure;
    let as_photo = recovery.rerendered.map(|radiance| *radiance / exposure);
    bad += picture::write_png_srgb(&folder.join("rerendered.png"), &as_photo)?;
    let fixed = matches!(job.project.exposure, unrender_photo::Exposure::Fixed(_));
    let developed = if fixed { exposure } else { unrender_scene::Rgb::ONE };
    let photo = job.photo.radiance.map(|radiance| *radiance / developed);
    bad += picture::write_png_srgb(&folder.join("photo.png"), &photo)?;
    error_picture::write(job, recovery, &folder.join("error.png"))?;
    trust_picture::write(job, recovery, &folder.join("trust.png"))?;
    report::write(job, recovered, folder)?;
    let glb = unrender_formats::wear(&job.project.scene, &dressed(job, recovered))?;
    atomic::write(&folder.join("scene.glb"), &glb)?;
    run_file::write(recovered, &folder.join("run.json"))?;
    materials::write(&folder.join("materials.json"), &file)?;
    let mut warnings = Warnings::default();
    if bad > 0 {
        warnings.push(format!("{bad} value(s) were not finite numbers and were written as zero"));
    }
    Ok(warnings)
}

/// The scene with the recovered materials on.
fn dressed(job: &Job, recovered: &Recovered) -> Scene {
    let mut scene = job.scene.clone();
    for (group, result) in scene.groups.iter_mut().zip(&recovered.recovery.groups) {
        group.material = result.material.clone();
    }
    for light in &recovered.recovery.lights {
        if let Some(strength) = scene.strength_mut(light.source) {
            *strength *= light.factor;
        }
    }
    scene
}
