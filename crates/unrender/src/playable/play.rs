//! From a folder of results to all that its page needs.

use super::approximation::{self, Errors};
use super::separated::{self, Colour, Lamp, OwnColour, Stage};
use crate::edit::{EditSheet, Flag, Photograph, Start};
use crate::global::Global;
use crate::progress::Progress;
use crate::run::{self, Run};
use crate::{Error, job};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use unrender_formats::picture;
use unrender_photo::squares;
use unrender_render::adaptive::SampleAllocation;
use unrender_render::{Accumulator, Settings, Tracer};
use unrender_scene::color::linear_from_srgb;
use unrender_scene::{Camera, Image, Rgb, RgbImage, Scene, Warnings};

/// The shares of the work that are done after the rendering and after the separation, on the room of the examples. They
/// move the progress alone.
const RENDERED: f64 = 0.35;
const SEPARATED: f64 = 0.95;
/// Where no group is.
pub(crate) const NO_GROUP: u16 = u16::MAX;

/// The most pixels of all pictures of a page together: 25 of 640 x 480. A pixel takes about two bytes, so that the page has
/// 17 MB; half of it makes rooms of many groups coarse, double of it takes a browser a second to open.
const PIXELS_MAX: usize = 8_000_000;

/// A result, ready to be played with.
pub(crate) struct Play {
    /// The results it is of.
    pub(crate) run: Run,
    /// Their project, if its file was found.
    pub(crate) project: Option<PathBuf>,
    /// The names of the scene's groups.
    pub(crate) groups: Vec<String>,
    /// How often the photograph's pixels are counted on each side in one of these pictures.
    pub(crate) side: usize,
    /// The scene with all lamps on, denoised, W sr^-1 m^-2.
    pub(crate) whole: RgbImage,
    /// The photograph, W sr^-1 m^-2; black where it is broken.
    pub(crate) photograph: RgbImage,
    /// Radiance of the value one in the photograph's picture.
    pub(crate) exposure: Rgb,
    /// Its lamps.
    pub(crate) lamps: Vec<Lamp>,
    /// The colours of its groups.
    pub(crate) colours: Vec<Colour>,
    /// The errors of each of `colours`.
    pub(crate) errors: Vec<Errors>,
    /// The number of the group in each pixel, in the order of run.json; [`NO_GROUP`] where there is none.
    pub(crate) map: Image<u16>,
}

/// Reads the results in `folder`, of `project` or of the one that they name, and separates their light by `settings`.
///
/// # Errors
/// If a file cannot be used.
pub(crate) fn play(
    folder: &Path,
    project: Option<&Path>,
    settings: &Settings,
    global: &Global,
) -> Result<Play, Error> {
    let run = Run::read(folder)?;
    let project = match project {
        Some(project) => Some(project.to_owned()),
        None => found(&run.input.project, folder),
    };
    let (start, warnings) = start(folder, project.as_deref(), global)?;
    global.console.warn(&warnings);
    let off: Vec<usize> = start.off.iter().map(|(source, _)| *source).collect();
    let mut scene = start.scene;
    for (source, strength) in start.off {
        scene.strength_mut(source).into_iter().for_each(|of_scene| *of_scene = strength);
    }
    let exposure = Rgb::from_array(run.exposure);
    let (photograph, camera) = match start.photograph {
        Some(Photograph { photo, camera, .. }) => (photo.radiance, camera),
        None => developed(folder, &run, &scene)?,
    };
    let progress = Progress::new("view", global);
    let full = (photograph.width(), photograph.height());
    let tracer = Tracer::new(&scene);
    let mut stage = Stage::new((&scene, &tracer), &off, camera);
    let pictures = 3 + stage.lamps().len() + stage.colours().len();
    let side = (1..).find(|side| full.0 * full.1 * pictures <= PIXELS_MAX * side * side);
    let side = side.unwrap_or(1).min(full.0).min(full.1).max(1);
    stage.size = (full.0 / side, full.1 / side);
    stage.camera = stage.camera.part(full, (0, 0), (stage.size.0 * side, stage.size.1 * side));
    progress.work_on("rendering", 0.0);
    let whole = denoised(&stage, settings, &|done| progress.set(RENDERED * done));
    progress.work_on("separating the light", RENDERED);
    // Ratios of the same paths have less noise than the picture, and are smoothed.
    let of_parts = Settings { spp: settings.spp / 2, ..*settings };
    let separated = separated::separate(&stage, &of_parts, &|done| {
        progress.set(RENDERED + (SEPARATED - RENDERED) * done);
    });
    progress.work_on("measuring the errors", SEPARATED);
    let changed: Vec<OwnColour> = separated.colours.iter().map(|colour| colour.own).collect();
    let errors = approximation::errors(&stage, &changed, settings.seed);
    Ok(Play {
        groups: scene.groups.iter().map(|group| group.name.clone()).collect(),
        photograph: squares(&photograph, side, |square| {
            square.iter().sum::<Rgb>() / square.len() as f32
        }),
        map: group_map(folder, &run, stage.size)?,
        run,
        project,
        side,
        whole,
        exposure,
        lamps: separated.lamps,
        colours: separated.colours,
        errors,
    })
}

/// The scene of results that `project` or their own scene file describes.
fn start(
    folder: &Path,
    project: Option<&Path>,
    global: &Global,
) -> Result<(Start, Warnings), Error> {
    let flags = [(Flag::Recovered, Some(folder)), (Flag::Project, project)];
    let sheets = flags.into_iter().filter_map(|(flag, path)| {
        let sheet = EditSheet::of_flag(flag, &path?.to_string_lossy());
        Some(sheet.map(|sheet| sheet.within(global.limits())))
    });
    Start::load(&sheets.collect::<Result<Vec<_>, _>>()?)
}

/// The project that results in `folder` name, where it is found: as it was named, or beside the folder.
fn found(named: &Path, folder: &Path) -> Option<PathBuf> {
    let name = named.file_name()?;
    let beside = folder.ancestors().map(|above| above.join(name));
    let near = std::iter::once(named.to_owned()).chain(beside.take(3));
    near.filter(|path| !path.as_os_str().is_empty()).find(|path| path.is_file())
}

/// The photograph that results without a project show, and the camera that they state.
fn developed(folder: &Path, run: &Run, scene: &Scene) -> Result<(RgbImage, Camera), Error> {
    let (read, _) = picture::read(&folder.join(&run.pictures.photo))?;
    let exposure = Rgb::from_array(run.exposure);
    let radiance = read.values.map(|code| code.map(linear_from_srgb) * exposure);
    let stated = run::recovered_camera(&folder.join(Run::FILE))?;
    let camera = match stated {
        Some(table) => table.camera("photograph", scene.origin),
        None => job::named_camera(scene, None, &folder.join("scene.glb"))?.0,
    };
    let (width, height, side) = (run.input.width, run.input.height, run.input.side.max(1));
    let in_squares = (width / side * side, height / side * side);
    Ok((radiance, camera.part((width, height), (0, 0), in_squares)))
}

/// The picture with all lamps on, denoised.
fn denoised(stage: &Stage<'_>, settings: &Settings, progress: &dyn Fn(f64)) -> RgbImage {
    let samples = SampleAllocation::Uniform(settings.samples());
    let Stage { tracer, materials, camera, size, .. } = stage;
    let halves = [0, 1].map(|half| {
        let mut sum = Accumulator::new(size.0, size.1);
        tracer.accumulate_half(materials, camera, settings, (&samples, half), &mut sum, &|_| {});
        progress(0.5 * (half + 1) as f64);
        sum
    });
    tracer.denoise(materials, camera, settings, [&halves[0], &halves[1]]).radiance
}

/// The number of the group in each pixel, in the order of run.json; [`NO_GROUP`] where there is none.
fn group_map(folder: &Path, run: &Run, size: (usize, usize)) -> Result<Image<u16>, Error> {
    let (read, _) = picture::read(&folder.join(&run.pictures.groups))?;
    let colours = run.groups.values().map(|group| group.map_color.as_str()).enumerate();
    let numbers: HashMap<&str, u16> =
        colours.map(|(number, colour)| (colour, number as u16)).collect();
    let (width, height) = (read.values.width(), read.values.height());
    Ok(Image::from_fn(size.0, size.1, |x, y| {
        let near = |at: usize, of: usize, size: usize| (2 * at + 1) * of / (2 * size);
        let code = read.values.at(near(x, width, size.0), near(y, height, size.1));
        let [r, g, b] = code.to_array().map(|v| (255.0 * v).round() as u8);
        numbers.get(format!("#{r:02x}{g:02x}{b:02x}").as_str()).copied().unwrap_or(NO_GROUP)
    }))
}
