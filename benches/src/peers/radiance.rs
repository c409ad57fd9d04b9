//! Radiance, from `pyradiance` of PyPI. Its rays are traced by `rtrace`, which uses all cores and
//! returns floats: pictures would be rounded to a hundredth.

use super::said;
use super::shot::{self, Shot};
use crate::{Failure, machine};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;
use unrender::formats::export::Target;
use unrender::scene::{Image, Rgb, RgbImage};

/// Options of every rendering: those of the export's `render.sh` for the way of sampling light, not
/// for the number of samples.
const COMMON: &str = "-h- -fff -u+ -bv+ -st 0 -dj 1 -ds 0.1 -dt 0 -dc 1 -dr 2";

/// The settings of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setting {
    /// Rays across a pixel, and down.
    pub(crate) finer: usize,
    /// Further options of `rtrace`.
    pub(crate) options: &'static str,
}

/// A scene that is prepared for Radiance.
pub(crate) struct Radiance {
    programs: PathBuf,
    library: PathBuf,
    folder: PathBuf,
    size: (usize, usize),
}

impl Radiance {
    /// Writes the scene into `folder` and makes its octree.
    ///
    /// # Errors
    /// If Radiance is not available or cannot read the scene.
    pub(crate) fn load(shot: &Shot, folder: &Path) -> Result<Self, Failure> {
        let python = super::python("pyradiance", &["pyradiance==1.3.1"])?;
        let code = "import pyradiance, os; print(os.path.dirname(pyradiance.__file__))";
        let package = PathBuf::from(said(Command::new(python).args(["-c", code]))?);
        shot::export(shot, Target::Radiance, folder)?;
        let this = Self {
            programs: package.join("bin"),
            library: package.join("lib"),
            folder: folder.to_owned(),
            size: shot.size,
        };
        // The lines of its script before the picture.
        let prepare = "grep -E '^(obj2mesh|oconv)' render.sh | sh -e";
        said(this.command("sh").args(["-c", prepare]))?;
        Ok(this)
    }

    /// Its version.
    pub(crate) fn version(&self) -> String {
        let version = said(self.command("rtrace").arg("-version")).unwrap_or_default();
        version.split_whitespace().take(2).collect::<Vec<_>>().join(" ")
    }

    /// A picture and the seconds that it took, without reading the scene. Radiance's random numbers
    /// change every second.
    ///
    /// # Errors
    /// If Radiance fails.
    pub(crate) fn render(&self, setting: Setting) -> Result<(RgbImage, f64), Failure> {
        let rays = self.folder.join(format!("rays{}.bin", setting.finer));
        let (width, height) = (self.size.0 * setting.finer, self.size.1 * setting.finer);
        let mut view = self.command("vwrays");
        view.args(["-ff", "-vf", "view.vf", "-pj", "1"]);
        view.args(["-x", &width.to_string(), "-y", &height.to_string()]);
        said(view.stdout(File::create(&rays)?).stderr(Stdio::piped()))?;
        let nothing = self.folder.join("nothing.bin");
        std::fs::write(&nothing, [])?;
        let reading = self.trace(setting, &nothing)?;
        let seconds = self.trace(setting, &rays)? - reading;
        Ok((self.picture(setting.finer)?, seconds))
    }

    /// Traces the rays of a file in the scene; returns the seconds that it took.
    fn trace(&self, setting: Setting, rays: &Path) -> Result<f64, Failure> {
        // The cache of ambient light belongs to one picture.
        let kept = self.folder.join("ambient");
        let _ = std::fs::remove_file(&kept);
        let mut trace = self.command("rtrace");
        trace.args(["-n", &machine::cores().to_string()]).args(COMMON.split_whitespace());
        trace.args(setting.options.split_whitespace()).args(["-af", "ambient", "scene.oct"]);
        trace.stdin(File::open(rays)?).stdout(File::create(self.folder.join("picture.bin"))?);
        let started = Instant::now();
        let ended = trace.stderr(Stdio::null()).status()?;
        let seconds = started.elapsed().as_secs_f64();
        if ended.success() { Ok(seconds) } else { Err(format!("{trace:?}: {ended}").into()) }
    }

    /// The means over the rays of each pixel.
    fn picture(&self, finer: usize) -> Result<RgbImage, Failure> {
        let bytes = std::fs::read(self.folder.join("picture.bin"))?;
        let float = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        let colors: Vec<Rgb> = bytes
            .chunks_exact(12)
            .map(|b| Rgb::new(float(b), float(&b[4..]), float(&b[8..])))
            .collect();
        let (width, height) = self.size;
        if colors.len() != width * height * finer * finer {
            return Err("Radiance gave another number of pixels".into());
        }
        let mean = |x: usize, y: usize| {
            let rows = y * finer..(y + 1) * finer;
            let rays =
                rows.flat_map(|row| (0..finer).map(move |i| row * width * finer + x * finer + i));
            rays.map(|ray| colors[ray]).sum::<Rgb>() / (finer * finer) as f32
        };
        Ok(Image::from_fn(width, height, mean))
    }

    fn command(&self, program: &str) -> Command {
        let path = std::env::var("PATH").unwrap_or_default();
        let ours = self.programs.join(program);
        let mut command = Command::new(if ours.exists() { ours } else { program.into() });
        command.env("PATH", format!("{}:{path}", self.programs.display()));
        command.env("RAYPATH", &self.library).current_dir(&self.folder);
        command
    }
}
