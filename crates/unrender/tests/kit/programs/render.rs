//! Pictures of exported scenes by other renderers, and by ours.

use super::install::{installed, python, run};
use std::path::{Path, PathBuf};
use std::process::Command;
use unrender::formats::export::Target;
use unrender::formats::picture;
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Image, Rgb, RgbImage, Scene};

/// A renderer that is installed.
pub(crate) enum Program {
    /// The folder of Radiance's programs and of its library.
    Radiance(PathBuf, PathBuf),
    /// The Python that has Mitsuba.
    Mitsuba(PathBuf),
    /// The Python that has Blender as a module.
    Blender(PathBuf),
    /// The same, which imports USD.
    BlenderByUsd(PathBuf),
}

impl Program {
    /// The one that renders exports for `target`, as `.ci/programs` has installed it.
    ///
    /// # Errors
    /// If it has not.
    pub(crate) fn installed(target: Target) -> Result<Self, String> {
        let python = |name| installed(name).map(|folder| folder.join("bin/python"));
        match target {
            Target::Mitsuba => python("mitsuba").map(Self::Mitsuba),
            Target::Radiance => Self::radiance_of(python("pyradiance")?),
            Target::Blender => python("bpy").map(Self::Blender),
            Target::Usd => python("bpy").map(Self::BlenderByUsd),
            _ => Err(format!("no renderer is known for {target}")),
        }
    }

    /// The one that renders exports for `target`; installed, if it is not there.
    pub(crate) fn for_target(target: Target) -> Result<Self, String> {
        match target {
            Target::Mitsuba => Self::mitsuba(),
            Target::Radiance => Self::radiance(),
            Target::Blender => Self::blender().map(Self::Blender),
            Target::Usd => Self::blender().map(Self::BlenderByUsd),
            _ => Err(format!("no renderer is installed for {target}")),
        }
    }

    /// Radiance, from `pyradiance` of PyPI.
    pub(crate) fn radiance() -> Result<Self, String> {
        Self::radiance_of(python("pyradiance", &["pyradiance==1.3.1"])?)
    }

    fn radiance_of(python: PathBuf) -> Result<Self, String> {
        let code = "import pyradiance, os; print(os.path.dirname(pyradiance.__file__))";
        let output = Command::new(python).args(["-c", code]).output();
        let output = output.map_err(|error| error.to_string())?;
        let folder = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
        Ok(Self::Radiance(folder.join("bin"), folder.join("lib")))
    }

    /// Mitsuba 3, from `mitsuba` of PyPI.
    pub(crate) fn mitsuba() -> Result<Self, String> {
        python("mitsuba", &["mitsuba==3.9.1", "numpy==1.26.4"]).map(Self::Mitsuba)
    }

    /// Blender, from `bpy` of PyPI: 350 MB.
    fn blender() -> Result<PathBuf, String> {
        python("bpy", &["bpy==4.5.*", "numpy<2"])
    }

    /// The picture of `size` (width and height, pixels) of the export at `path`, by about `spp` paths a pixel.
    pub(crate) fn picture(
        &self,
        path: &Path,
        size: (usize, usize),
        spp: u32,
    ) -> Result<RgbImage, String> {
        match self {
            Self::Radiance(programs, library) => radiance(programs, library, path, spp),
            Self::Mitsuba(python) => mitsuba(python, path, spp),
            Self::Blender(python) => blender(python, path, spp),
            Self::BlenderByUsd(python) => imported(python, path, size, spp),
        }
    }
}

/// Runs `render.sh`, which renders 16 finer pixels per pixel, with the number of rays into the
/// hemisphere (`-ad`) for each that gives `spp`.
fn radiance(programs: &Path, library: &Path, folder: &Path, spp: u32) -> Result<RgbImage, String> {
    let path = std::env::var("PATH").unwrap_or_default();
    let mut script = Command::new("sh");
    script.arg(folder.join("render.sh")).arg("picture.hdr");
    script.args(["-w", "-ad", &(spp / 16).max(1).to_string()]);
    script.env("PATH", format!("{}:{path}", programs.display())).env("RAYPATH", library);
    run(&mut script)?;
    // Radiance's own program reads its format: a code stands for the middle of its step.
    let picture = folder.join("picture.hdr");
    let mut values = Command::new(programs.join("pvalue"));
    let floats = values.args(["-h", "-H", "-df"]).arg(&picture).output();
    let floats = floats.map_err(|error| error.to_string())?.stdout;
    let floats: Vec<f32> = floats
        .chunks_exact(4)
        .map(|bytes| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
        .collect();
    let pixels = floats.chunks_exact(3).map(Rgb::from_slice).collect();
    let size = read(&picture)?;
    Ok(Image::new(size.width(), size.height(), pixels))
}

const MITSUBA: &str = "
import sys, mitsuba
mitsuba.set_variant('scalar_rgb')
scene = mitsuba.load_file(sys.argv[1])
picture = mitsuba.Bitmap(mitsuba.render(scene, spp=int(sys.argv[2])))
picture.convert(mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, False).write(sys.argv[3])
";

/// Renders `scene.xml` by the scalar variant, which needs no compiler.
fn mitsuba(python: &Path, folder: &Path, spp: u32) -> Result<RgbImage, String> {
    let picture = folder.join("picture.exr");
    let mut command = Command::new(python);
    command.args(["-c", MITSUBA]).arg(folder.join("scene.xml")).arg(spp.to_string()).arg(&picture);
    run(&mut command)?;
    read(&picture)
}

/// Runs `scene.py`, which renders by Cycles on the processor.
fn blender(python: &Path, folder: &Path, spp: u32) -> Result<RgbImage, String> {
    let picture = folder.join("picture.exr");
    let mut command = Command::new(python);
    command.arg(folder.join("scene.py")).args(["--spp", &spp.to_string()]).arg(&picture);
    run(&mut command)?;
    read(&picture)
}

/// Imports a USD stage into Blender, and renders it by Cycles. A stage does not say how large its picture is.
fn imported(
    python: &Path,
    stage: &Path,
    (width, height): (usize, usize),
    spp: u32,
) -> Result<RgbImage, String> {
    let picture = stage.with_extension("picture.exr");
    let mut command = Command::new(python);
    command.args(["-c", include_str!("import_usd.py")]).arg(stage);
    command.args([width.to_string(), height.to_string(), spp.to_string()]).arg(&picture);
    run(&mut command)?;
    read(&picture)
}

fn read(path: &Path) -> Result<RgbImage, String> {
    let (picture, _) = picture::read(path).map_err(|error| error.to_string())?;
    Ok(picture.to_linear())
}

/// The picture by unrender.
pub(crate) fn our_picture(
    scene: &Scene,
    camera: &Camera,
    size: (usize, usize),
    spp: u32,
) -> RgbImage {
    let settings = Settings { spp, ..Settings::default() };
    Tracer::new(scene).render(&scene.materials(), camera, size, &settings, &|_| {}).mean
}
