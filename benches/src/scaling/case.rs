//! A scene that is photographed, and then recovered from the photograph.

use crate::command::Unrender;
use crate::{Failure, peers};
use unrender::formats::{atomic, gltf, picture};
use unrender::scene::{RgbImage, Scene};

/// A point on an axis.
pub(crate) struct Case {
    /// The position on the axis.
    pub(crate) value: usize,
    pub(crate) scene: Scene,
    /// A group that is out of sight; its reflectance is given.
    pub(crate) known: &'static str,
    /// Width and height, pixels.
    pub(crate) size: (usize, usize),
    /// The most reflections, if that is limited.
    pub(crate) bounces: Option<usize>,
    /// Paths per pixel of the photograph.
    pub(crate) spp: u32,
    /// Each rendered pixel is repeated this many times along each side of the photograph.
    pub(crate) repeat: usize,
    /// Whether a draft of it is recovered, too.
    pub(crate) draft: bool,
}

/// The cost of a recovery.
#[derive(Debug)]
pub(crate) struct Recovery {
    pub(crate) seconds: f64,
    /// The peak memory, if the system reports it.
    pub(crate) mebibytes: Option<f64>,
}

/// The cost of a case.
#[derive(Debug)]
pub(crate) struct Cost {
    /// Seconds to make the photograph.
    pub(crate) rendering: f64,
    /// Recovered with `--effort draft`.
    pub(crate) draft: Option<Recovery>,
    /// As by default.
    pub(crate) full: Recovery,
}

impl Case {
    /// Renders and recovers.
    ///
    /// # Errors
    /// If that fails.
    pub(crate) fn measure(&self, command: &Unrender) -> Result<Cost, Failure> {
        let folder = peers::work_folder("scaling");
        std::fs::create_dir_all(&folder)?;
        let (scene, photo) = (folder.join("scene.glb"), folder.join("photo.exr"));
        let project = folder.join("project.toml");
        atomic::write(&scene, &gltf::to_glb(&self.scene)?)?;
        atomic::write(&project, self.project().as_bytes())?;
        let bounces = self.bounces.map(|bounces| bounces.to_string());
        let limit: Vec<&str> =
            bounces.iter().flat_map(|bounces| ["--bounces", bounces.as_str()]).collect();
        let flags = [&["--independent"], limit.as_slice()].concat();
        let size = (self.size.0 / self.repeat, self.size.1 / self.repeat);
        let rendering = command.render(&scene, size, self.spp, &photo, &flags)?;
        if self.repeat > 1 {
            let (photograph, _) = picture::read(&photo)?;
            picture::write_exr(&photo, &repeated(&photograph.values, self.repeat))?;
        }
        let recover = |more: &[&str]| -> Result<Recovery, Failure> {
            let flags: Vec<&str> = limit.iter().chain(more).copied().collect();
            let (seconds, run) = command.recover(&project, &folder.join("out"), &flags)?;
            let mebibytes = run.peak_memory_bytes.map(|b| b as f64 / f64::from(1 << 20));
            Ok(Recovery { seconds, mebibytes })
        };
        let draft = self.draft.then(|| recover(&["--effort", "draft"])).transpose()?;
        Ok(Cost { rendering, draft, full: recover(&[])? })
    }

    fn project(&self) -> String {
        let known = self.scene.groups.iter().find(|group| group.name == self.known);
        let rho_d = known.map_or([0.0; 3], |group| group.material.rho_d.to_array());
        format!(
            "scene = \"scene.glb\"\nphoto = \"photo.exr\"\nresponse = \"linear\"\nexposure = 1.0\n\
             [groups.{}]\nknown = {{ rho_d = {rho_d:?} }}\n[recover]\nbrdf = \"{}\"\n",
            self.known, self.scene.brdf
        )
    }
}

/// The picture with each of its pixels repeated `times` by `times`.
fn repeated(picture: &RgbImage, times: usize) -> RgbImage {
    let (width, height) = (times * picture.width(), times * picture.height());
    let at = |i: usize| picture.pixels()[i / width / times * picture.width() + i % width / times];
    RgbImage::new(width, height, (0..width * height).map(at).collect())
}
