//! Recovered materials under new light and from a new viewpoint, compared with the other renderer's
//! picture of the truth; and the same for materials that were recovered as diffuse.

use super::generate::Plan;
use super::photograph::{self, SampleBudget};
use super::recover::{self, Subject, Wanted};
use super::spoil::Dial;
use super::store::{self, Folder, Format};
use crate::Failure;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::process::Command;
use unrender::formats::picture;
use unrender::render::Tracer;
use unrender::scene::{Camera, RgbImage, Scene};

/// The noise and the samples of the reference pictures.
const BUDGET: SampleBudget = SampleBudget { noise: 0.03, spp_max: 128 };
/// Paths per pixel of our own pictures.
const SPP: u32 = 256;

/// Relative root mean square errors over a whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Case {
    /// With the recovered materials.
    pub(crate) recovered: f64,
    /// With diffuse ones, if the command can recover them.
    pub(crate) diffuse: Option<f64>,
}

impl Case {
    /// The first over the second.
    pub(crate) fn ratio(&self) -> Option<f64> {
        self.diffuse.filter(|diffuse| *diffuse > 0.0).map(|diffuse| self.recovered / diffuse)
    }
}

/// Both cases.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Relit {
    /// In the same light from another place.
    pub(crate) viewpoint: Case,
    /// In another light from the same place.
    pub(crate) light: Case,
}

/// Compares the results in `run` with the truth in both cases.
///
/// # Errors
/// If a renderer fails or a file cannot be read.
pub(crate) fn relight(
    plan: &Plan,
    scene: &Folder,
    (format, dial): (Format, Dial),
    wanted: Wanted<'_>,
    run: &Path,
) -> Result<Relit, Failure> {
    let plain = match wanted.plain {
        Some(subject) => {
            let (folder, outcome) = recover::recover(scene, subject, (format, dial), wanted.again)?;
            outcome.failure.is_none().then_some(folder)
        }
        None => None,
    };
    let case = |name: &str, built: &Scene, camera: &Camera| -> Result<Case, Failure> {
        let truth = truth(plan, scene, name, built, camera)?;
        let model = scene.path(&format!("{name}.glb"));
        store::write_neutral(&model, built)?;
        let lamps = lamps(built, camera, plan.size);
        let error = |folder: &Path| -> Result<f64, Failure> {
            let out = folder.join(format!("{name}.exr"));
            render(wanted.subject, &model, folder, (camera, plan.size), &out)?;
            Ok(difference(&picture::read(&out)?.0.values, &truth, &lamps))
        };
        Ok(Case { recovered: error(run)?, diffuse: plain.as_deref().map(error).transpose()? })
    };
    Ok(Relit {
        viewpoint: case("viewpoint", &plan.scene(), &plan.cameras[1])?,
        light: case("light", &plan.relit(), &plan.cameras[0])?,
    })
}

/// The other renderer's picture, made once.
fn truth(
    plan: &Plan,
    scene: &Folder,
    name: &str,
    built: &Scene,
    camera: &Camera,
) -> Result<RgbImage, Failure> {
    let path = scene.path(&format!("truth_{name}.exr"));
    if !path.exists() {
        let work = scene.path("work");
        let renderer = plan.style.renderer;
        let taken = photograph::take(plan, built, camera, renderer, BUDGET, &work)?;
        let _ = std::fs::remove_dir_all(&work);
        picture::write_exr(&path, &taken.mean())?;
    }
    Ok(picture::read(&path)?.0.values)
}

/// Our picture of `model` with the materials of the results in `folder`.
fn render(
    subject: &Subject,
    model: &Path,
    folder: &Path,
    (camera, size): (&Camera, (usize, usize)),
    out: &Path,
) -> Result<(), Failure> {
    let mut command = Command::new(&subject.command);
    command.arg("render").arg(model).arg("--materials").arg(folder.join("materials.json"));
    command.args(["--camera", &camera.name, "--spp", &SPP.to_string(), "--quiet", "--out"]);
    command.arg(out).args(["--width", &size.0.to_string(), "--height", &size.1.to_string()]);
    crate::peers::said(&mut command)?;
    Ok(())
}

/// The root mean square of the difference over that of the truth, over the pixels that show no lamp.
fn difference(ours: &RgbImage, truth: &RgbImage, shows_lamp: &[bool]) -> f64 {
    let pairs = ours.pixels().iter().zip(truth.pixels()).zip(shows_lamp);
    let (mut squares, mut levels) = (0.0, 0.0);
    for ((ours, truth), _) in pairs.filter(|(_, lamp)| !**lamp) {
        squares += f64::from((*ours - *truth).length_squared());
        levels += f64::from(truth.length_squared());
    }
    (squares / levels.max(1e-30)).sqrt()
}

/// Which pixels show a lamp: their brightness does not depend on the recovery.
fn lamps(scene: &Scene, camera: &Camera, size: (usize, usize)) -> Vec<bool> {
    let geometry = Tracer::new(scene).geometry(camera, size.0, size.1);
    let is_lamp =
        |group: u32| scene.groups.get(group as usize).is_some_and(|group| group.is_emitter());
    geometry.pixels().iter().map(|pixel| is_lamp(pixel.group)).collect()
}
