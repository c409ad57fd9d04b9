//! `unrender calibrate`: from measured points, lines along axes, or an fSpy project, to the camera of a photograph.

mod lines;

use crate::global::Global;
use crate::project::{CameraTable, Project};
use crate::{Error, interrupt, output, results};
use clap::ValueEnum;
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use unrender_formats::gltf::to_glb;
use unrender_formats::points::{self, Pair};
use unrender_formats::{FileError, Input, Limits, atomic, fspy, input, picture};
use unrender_photo::calibrate::{Calibration, Focal, Request, calibrate, doubtful_pairs};
use unrender_scene::{Lens, Picture, Warnings};

/// Finds the camera of a photograph from points of the scene that it shows, or from lines along its axes.
///
/// POINTS.csv has one line per point, below the header x_px,y_px,x_m,y_m,z_m,name: pixels of the
/// upright photo ((0, 0) is its top left corner, the centre of the first pixel (0.5, 0.5)), then
/// metres in the scene (right-handed, y up). The name may be left out; lines that begin with # are
/// comments.
///
/// Pose alone needs 4 pairs (--fov-y-deg), with the focal length 5, with the principal point or the
/// distortion 6, with both 7; twice as many show which are wrong. Up to a third of the pairs may be
/// wrong; these are left out.
///
/// LINES.csv has one line per straight edge that is parallel to an axis, below the header
/// axis,x1_px,y1_px,x2_px,y2_px,length_m,name: x, y (upwards) or z, and both ends. Two lines each along two axes give
/// focal length and direction; give more, long ones, that converge. The origin is the first end of the line with a
/// length_m, in metres, which the camera's position follows from; --camera-height does as well. No model is needed:
/// --out camera.glb is a new scene, of the camera and a square metre at the origin. --lines auto looks for the lines in the photo.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender calibrate room.jpg --scene room.glb --points desk.csv --out room.toml\n  \
    unrender calibrate --points desk.csv --distortion --out room.toml\n  \
    unrender calibrate room.jpg --scene room.glb --points desk.csv --out room_seen.glb\n  \
    unrender calibrate room.jpg --lines auto --camera-height 1.6 --show-lines lines.png --out camera.glb\n  \
    unrender calibrate room.jpg --lines lines.csv --out camera.glb\n  \
    unrender calibrate room.jpg --scene room.glb --fspy room.fspy --out room.toml")]
pub struct Args {
    /// The photograph [default: that of the project in --out].
    pub photo: Option<PathBuf>,
    /// The scene file [default: that of the project in --out].
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Points of the scene and where the photograph shows them.
    #[arg(long, value_name = "FILE.csv", required_unless_present_any = ["fspy", "lines"])]
    pub points: Option<PathBuf>,
    /// Lines along the scene's axes, or "auto" to find them in the photo.
    #[arg(long, value_name = "FILE.csv|auto", conflicts_with_all = ["points", "fspy", "distortion"])]
    pub lines: Option<PathBuf>,
    /// The camera's height above the origin, metres; the origin is below the camera.
    #[arg(long, value_name = "M", requires = "lines")]
    pub camera_height: Option<f64>,
    /// Draw the lines over the photo: red along x, green along y, blue along z, yellow if rejected.
    #[arg(long, value_name = "FILE.png", requires = "lines")]
    pub show_lines: Option<PathBuf>,
    /// Write the lines, such as those that were found, to correct them and give them to --lines.
    #[arg(long, value_name = "FILE.csv", requires = "lines")]
    pub save_lines: Option<PathBuf>,
    /// Take the camera of an fSpy project instead.
    #[arg(long, value_name = "FILE.fspy", conflicts_with_all = ["points", "principal_point", "distortion", "fov_y_deg", "seed"])]
    pub fspy: Option<PathBuf>,
    /// The axis of the fSpy project that points upwards [default: whichever does in the picture].
    #[arg(long, value_enum, requires = "fspy")]
    pub fspy_up: Option<UpAxis>,
    /// Find the principal point too; else it is the picture's centre.
    #[arg(long)]
    pub principal_point: bool,
    /// Find the radial distortion k1, k2 too; else there is none.
    #[arg(long)]
    pub distortion: bool,
    /// The vertical field of view in degrees, if it is known; else it is found.
    #[arg(long, value_name = "X")]
    pub fov_y_deg: Option<f64>,
    /// Chooses the subsets of pairs that are tried; the same seed gives the same camera.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// The camera's name in a .glb.
    #[arg(long, value_name = "NAME", default_value = "calibrated")]
    pub name: String,
    /// A project file (.toml): a new one, or one whose camera is replaced; or the scene with the
    /// camera in it (.glb).
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
}

/// Axes that may point upwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UpAxis {
    /// As in glTF.
    Y,
    /// As in Blender.
    Z,
}

/// The file that gets the camera.
struct Target {
    /// The text of the project file, if there is one already.
    project: Option<String>,
    photo: Option<PathBuf>,
    scene: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// If the input cannot be used, gives no camera, or the result cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    let remedy = "end --out in .toml for a project file, or in .glb for the scene with the camera";
    output::check_file(&args.out, &["toml", "glb"], remedy)?;
    let is_project = output::extension(&args.out) == "toml";
    if !is_project && (args.principal_point || args.distortion) {
        return Err(lens_in_gltf(&args.out));
    }
    // An existing project or scene gets the camera; nothing else in it changes.
    let inputs = [&args.points, &args.lines, &args.fspy, &args.photo];
    let inputs = || inputs.into_iter().flatten().map(PathBuf::as_path);
    output::check_inputs(&args.out, inputs())?;
    lines::check_outputs(args, inputs())?;
    let target = target(args, global)?;
    let found = match (&args.fspy, &args.lines, &args.points) {
        (Some(path), ..) => from_fspy(args, path, global)?,
        (None, Some(path), _) => lines::from_lines(args, path, &target, global)?,
        (None, None, Some(path)) => from_points(args, path, &target, global)?,
        (None, None, None) => {
            return Err(Error::Request("give --points, --lines or --fspy".into()));
        }
    };
    let _until_written = interrupt::writing();
    if is_project {
        write_project(args, &target, &found)?;
    } else {
        write_scene(args, &target, &found, global.limits())?;
    }
    for further in &found.further {
        further.write()?;
    }
    global.console.print(&found.summary);
    Ok(ExitCode::SUCCESS)
}

/// The photograph and the scene, from the arguments or from the existing project.
fn target(args: &Args, global: &Global) -> Result<Target, Error> {
    let mut target = Target { project: None, photo: args.photo.clone(), scene: args.scene.clone() };
    if output::extension(&args.out) != "toml" || !args.out.exists() {
        // Of a scene that is not modelled yet, lines still give the camera.
        let camera_alone = args.lines.is_some() && output::extension(&args.out) == "glb";
        if target.scene.is_none() && !camera_alone {
            return Err(Error::Request(
                "give the scene (--scene), or the project file that names it (--out)".into(),
            ));
        }
        return Ok(target);
    }
    let text = input::text(&args.out).map_err(|error| FileError::because(&args.out, "", error))?;
    let (project, _) = Project::parse(&args.out, &text)?;
    if !project.further.is_empty() {
        let problem = "is a project of several photographs; calibrate each in a project of its \
        own, and copy the camera to its entry of [[photos]]";
        return Err(FileError::new(&args.out, problem).into());
    }
    let mut warnings = Warnings::default();
    for (given, stated, key) in
        [(&mut target.photo, project.photo, "photo"), (&mut target.scene, project.scene, "scene")]
    {
        let same = |path: &Path| path.canonicalize().ok() == stated.canonicalize().ok();
        if given.as_deref().is_some_and(|path| !same(path)) {
            warnings.push(format!(
                "{}: names another {key}, {}; only its camera was changed",
                args.out.display(),
                stated.display()
            ));
        }
        given.get_or_insert(stated);
    }
    global.console.warn(&warnings);
    target.project = Some(text);
    Ok(target)
}

/// A camera that was found.
struct Found {
    table: CameraTable,
    /// The origin of the scene's positions.
    zero: DVec3,
    /// Where the camera comes from, in words.
    origin: String,
    summary: String,
    /// What is written beside it.
    further: Vec<lines::Further>,
}

/// A photograph whose pixels are measured.
struct Measured {
    picture: Picture,
    /// Width and height, pixels.
    size: (usize, usize),
    /// The focal length of its EXIF data, pixels.
    exif: Option<f64>,
}

impl Measured {
    fn read(target: &Target, limits: Limits) -> Result<Self, Error> {
        let Some(photo) = &target.photo else {
            return Err(Error::Request("give the photo whose pixels are measured".into()));
        };
        let bytes = input::read(Input::new(photo, limits))
            .map_err(|error| FileError::because(photo, "", error))?;
        let (picture, _) = picture::read(Input::new(photo, limits))?;
        let size = (picture.values.width(), picture.values.height());
        Ok(Self { picture, size, exif: picture::exif_focal_px(&bytes, size.0, size.1) })
    }

    /// The camera of a calibration, with the warnings of it.
    fn found(
        &self,
        mut found: Calibration,
        zero: DVec3,
        (all, what): (usize, &str),
        path: &Path,
        mut warnings: Warnings,
        global: &Global,
    ) -> Found {
        warnings.extend(found.warnings.clone());
        if let Some(exif) = self.exif {
            warnings.extend(found.doubtful_exif(exif));
        }
        global.console.warn(&warnings);
        let eye = found.camera("").origin();
        let distance = eye.distance(DVec3::from_array(found.target).as_vec3());
        let table = CameraTable::of(&found.camera("photo"), distance.max(0.1), zero);
        for axis in 0..3 {
            found.eye[axis].value += zero[axis];
            found.target[axis] += zero[axis];
        }
        let origin = format!(
            "from {}: {} of {all} {what}, {:.2} px rms.",
            file_name(path),
            all - found.rejected.len(),
            found.rms_px
        );
        let summary = results::calibration(&found, all, what);
        Found { table, zero, origin, summary, further: Vec::new() }
    }
}

fn from_fspy(args: &Args, path: &Path, global: &Global) -> Result<Found, Error> {
    let up = args.fspy_up.map(|up| match up {
        UpAxis::Y => fspy::Up::Y,
        UpAxis::Z => fspy::Up::Z,
    });
    let (matched, mut warnings) = fspy::read(path, up)?;
    let (width, height) = matched.size;
    if let Some(photo) = &args.photo {
        let (picture, _) = picture::read(Input::new(photo, global.limits()))?;
        let size = (picture.values.width(), picture.values.height());
        if size.0 * height != size.1 * width {
            warnings.push(format!(
                "{} has {} x {} pixels, the picture in {} {width} x {height}; is it the same?",
                photo.display(),
                size.0,
                size.1,
                path.display()
            ));
        }
    }
    global.console.warn(&warnings);
    // fSpy's origin is a point that the user marked in the picture.
    let distance = matched.camera.origin().length().max(0.1);
    let table = CameraTable::of(&matched.camera, distance, DVec3::ZERO);
    let [x, y, z] = table.eye.to_array();
    let axis = match matched.up {
        fspy::Up::Y => "y",
        fspy::Up::Z => "z",
    };
    let summary = format!(
        "eye ({x:.4}, {y:.4}, {z:.4}) m, vertical field of view {:.3} deg; fSpy's {axis} points \
         upwards\n",
        table.fov_y_deg
    );
    let origin = format!("by fSpy: {}.", file_name(path));
    Ok(Found { table, zero: DVec3::ZERO, origin, summary, further: Vec::new() })
}

fn from_points(args: &Args, path: &Path, target: &Target, global: &Global) -> Result<Found, Error> {
    let limits = global.limits();
    let photo = Measured::read(target, limits)?;
    let mut pairs = points::read(path)?;
    let scene = target.scene.as_deref().map(|s| Input::new(s, limits));
    let (warnings, zero) = doubtful_points(&mut pairs, photo.size, scene)?;
    let request = Request {
        focal: focal(args.fov_y_deg, photo.exif, photo.size.1)?,
        principal_point: args.principal_point,
        distortion: args.distortion,
        seed: args.seed,
    };
    let found = calibrate(&pairs, photo.size, &request)
        .map_err(|problem| Error::Calibrate { path: path.to_owned(), problem })?;
    Ok(photo.found(found, zero, (pairs.len(), "pairs"), path, warnings, global))
}

fn focal(fov_y_deg: Option<f64>, exif: Option<f64>, height: usize) -> Result<Focal, Error> {
    match (fov_y_deg, exif) {
        (Some(fov), _) => Focal::of_fov_y_deg(fov, height).ok_or_else(|| {
            Error::Request(format!("--fov-y-deg is {fov}; it is between 0 and 180"))
        }),
        (None, Some(focal)) => Ok(Focal::Near(focal)),
        (None, None) => Ok(Focal::Unknown),
    }
}

/// Warnings of points beside the photograph and beside the scene. Returns the origin of the scene's positions, too,
/// and moves the points of `pairs` to it.
fn doubtful_points(
    pairs: &mut [Pair],
    size: (usize, usize),
    scene: Option<Input<'_>>,
) -> Result<(Warnings, DVec3), Error> {
    let Some(scene) = scene else {
        return Ok((doubtful_pairs(pairs, size, None), DVec3::ZERO));
    };
    if !scene.path.is_file() {
        return Err(FileError::new(scene.path, "there is no such scene file").into());
    }
    // A scene without lights can be used for calibration, too.
    match unrender_formats::load_model(scene) {
        Ok((scene, _)) => {
            for pair in pairs.iter_mut() {
                pair.point = (DVec3::from_array(pair.point) - scene.origin).to_array();
            }
            Ok((doubtful_pairs(pairs, size, scene.bounds()), scene.origin))
        }
        Err(error) => {
            let mut warnings = doubtful_pairs(pairs, size, None);
            warnings.push(format!("the points were not compared with the scene: {error}"));
            Ok((warnings, DVec3::ZERO))
        }
    }
}

fn write_project(args: &Args, target: &Target, found: &Found) -> Result<(), Error> {
    let text = match (&target.project, &target.photo, &target.scene) {
        (Some(text), ..) => text.clone(),
        (None, Some(photo), Some(scene)) => {
            let mut document = toml_edit::DocumentMut::new();
            for (key, path) in [("scene", scene), ("photo", photo)] {
                document[key] = toml_edit::value(relative(path, output::folder(&args.out)));
            }
            document.to_string()
        }
        _ => {
            return Err(Error::Request(format!(
                "{}: a new project needs the photo and --scene",
                args.out.display()
            )));
        }
    };
    let text = found.table.put_into(&text, &args.out, &found.origin)?;
    Project::parse(&args.out, &text)?;
    atomic::write(&args.out, text.as_bytes())?;
    Ok(())
}

fn write_scene(args: &Args, target: &Target, found: &Found, limits: Limits) -> Result<(), Error> {
    if found.table.lens != Lens::default() {
        return Err(lens_in_gltf(&args.out));
    }
    let camera = found.table.camera(&args.name, found.zero);
    let placed = match &target.scene {
        Some(scene) => unrender_formats::place(Input::new(scene, limits), &camera, found.zero)?,
        None => to_glb(&lines::begun(camera))
            .map_err(|error| FileError::because(&args.out, "", error))?,
    };
    atomic::write(&args.out, &placed)?;
    Ok(())
}

fn lens_in_gltf(out: &Path) -> Error {
    let problem = "glTF has no words for a principal point or a distortion; end --out in .toml";
    FileError::new(out, problem).into()
}

/// `path` as seen from `folder`, with forward slashes; `path` itself if that is not possible.
fn relative(path: &Path, folder: &Path) -> String {
    let noted = path.canonicalize().ok().zip(folder.canonicalize().ok()).map(|(path, folder)| {
        let shared = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
        let up = folder.components().skip(shared).map(|_| "..".to_owned());
        let down = path.components().skip(shared);
        let down = down.map(|part| part.as_os_str().to_string_lossy().into_owned());
        up.chain(down).collect::<Vec<_>>().join("/")
    });
    noted.unwrap_or_else(|| path.display().to_string())
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
