//! Runs Mitsuba 3, from `mitsuba` of PyPI; its variant llvm also needs a shared library of LLVM.

use super::Worker;
use super::shot::Shot;
use crate::Failure;
use serde_json::json;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use unrender::formats::export::Target;
use unrender::formats::picture;
use unrender::scene::{BrdfModel, RgbImage, Scene, WardModel};

/// A Python that has Mitsuba.
///
/// # Errors
/// If it cannot be installed.
pub(crate) fn python() -> Result<PathBuf, String> {
    super::python("mitsuba", &["mitsuba==3.9.1", "numpy==1.26.4"])
}

/// The lobe of glossy groups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lobe {
    /// That of `unrender export`.
    Beckmann,
    /// The same lobe as ours, by `benches/peers/ward.py`.
    Ward,
}

/// Variant, lobe and sampler.
pub(crate) type Way = (&'static str, Lobe, &'static str);

/// Writes the scene into `folder` for Mitsuba; returns the file's path.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(
    shot: &Shot,
    folder: &Path,
    lobe: Lobe,
    sampler: &str,
) -> Result<PathBuf, Failure> {
    super::shot::export(shot, Target::Mitsuba, folder)?;
    let path = folder.join("scene.xml");
    let mut text = std::fs::read_to_string(&path)?;
    text = text.replace("type=\"independent\"", &format!("type=\"{sampler}\""));
    if lobe == Lobe::Ward {
        text = with_ward(&text, shot.scene);
    }
    std::fs::write(&path, text)?;
    Ok(path)
}

/// The scene with the plugin `ward` for the reflectances of glossy groups, which are a line each.
fn with_ward(text: &str, scene: &Scene) -> String {
    let mut lines = String::new();
    for line in text.lines() {
        let glossy = scene.groups.iter().find(|group| {
            let id = format!("<bsdf type=\"twosided\" id=\"m_{}\">", group.name);
            group.material.is_glossy() && line.trim_start().starts_with(&id)
        });
        let Some(group) = glossy else {
            lines.push_str(line);
            lines.push('\n');
            continue;
        };
        let m = &group.material;
        let color = |rgb: glam::Vec3| format!("{} {} {}", rgb.x, rgb.y, rgb.z);
        let _ = writeln!(
            lines,
            "<bsdf type=\"ward\" id=\"m_{}\"><boolean name=\"gmd\" value=\"{}\"/>\
             <boolean name=\"ggx\" value=\"{}\"/>\
             <rgb name=\"rho_d\" value=\"{}\"/><rgb name=\"rho_s\" value=\"{}\"/>\
             <float name=\"alpha_x\" value=\"{}\"/><float name=\"alpha_y\" value=\"{}\"/></bsdf>",
            group.name,
            scene.brdf == WardModel::WardGmd.into(),
            scene.brdf == BrdfModel::Ggx,
            color(m.rho_d),
            color(m.rho_s),
            m.alpha_x,
            m.alpha_y
        );
    }
    lines
}

/// A Mitsuba that has loaded a scene.
pub(crate) struct Mitsuba {
    worker: Worker,
    picture: PathBuf,
}

impl Mitsuba {
    /// Loads the scene at `path` with `variant`.
    ///
    /// # Errors
    /// If Mitsuba fails here.
    pub(crate) fn load(python: &Path, variant: &str, path: &Path) -> Result<Self, Failure> {
        let scene = path.display().to_string();
        let worker = Worker::start(python, "mitsuba_render.py", [variant.to_owned(), scene])?;
        Ok(Self { worker, picture: path.with_file_name(format!("{variant}.exr")) })
    }

    /// Its version.
    pub(crate) fn version(&self) -> String {
        format!("Mitsuba {}", self.worker.greeting["version"].as_str().unwrap_or("3"))
    }

    /// A picture and the seconds that it took.
    ///
    /// # Errors
    /// If Mitsuba ended.
    pub(crate) fn render(&mut self, spp: u32, seed: u32) -> Result<(RgbImage, f64), Failure> {
        let question = json!({ "spp": spp, "seed": seed, "picture": self.picture });
        let answer = self.worker.ask(&question)?;
        let seconds = answer["seconds"].as_f64().ok_or("Mitsuba gave no time")?;
        Ok((picture::read(&self.picture)?.0.values, seconds))
    }
}
