//! The command `unrender recover` as a function that returns its results.

use crate::arrays::{image, picture, raster};
use crate::error::{exception, request};
use crate::remote::Called;
use crate::scene::{Scene, camera_out};
use crate::supervise::{Control, supervise_recovery};
use numpy::{PyArray2, PyArray3, PyReadonlyArray3};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use unrender::cli::{self, Global};
use unrender::commands::recover as command;
use unrender::job::{InMemory, Job};
use unrender::listener::{Console, Listener};
use unrender::project::Project;
use unrender::recover::{Covariance, IterationRecord, Quantity, Recovery, Termination};
use unrender::scene::{ENVIRONMENT, Image};
use unrender::{Error, engine};
use unrender_formats::materials::{GroupEntry, MaterialsFile, ReflectanceEntry};
use unrender_formats::picture::{Depth, Picture};

/// A recovery with its job.
#[pyclass(module = "unrender._unrender", frozen)]
#[derive(Serialize, Deserialize)]
pub(crate) struct Recovered {
    job: Job,
    recovered: engine::Recovered,
}

/// A project in memory: its text, the path that it would have, and its arrays.
#[derive(FromPyObject)]
pub(crate) struct ProjectParts<'py> {
    path: PathBuf,
    text: String,
    scene: Option<Bound<'py, Scene>>,
    photo: Option<PyReadonlyArray3<'py, f32>>,
    /// Bits of the integers of the photograph's codes; zero for floating-point numbers.
    bits: u32,
    mask: Option<PyReadonlyArray3<'py, f32>>,
}

/// The same without Python.
struct PlainParts {
    path: PathBuf,
    text: String,
    given: InMemory,
}

impl ProjectParts<'_> {
    fn read(&self) -> PyResult<PlainParts> {
        let depth = match self.bits {
            8 => Depth::Eight,
            16 => Depth::Sixteen,
            _ => Depth::Float,
        };
        let taken = |array: &Option<PyReadonlyArray3<'_, f32>>, depth| {
            let read = array.as_ref().map(|array| image(array).map(|image| coded(&image, depth)));
            read.transpose()
        };
        let given = InMemory {
            scene: self.scene.as_ref().map(|scene| scene.get().plain().clone()),
            photo: taken(&self.photo, depth)?,
            mask: taken(&self.mask, Depth::Float)?,
        };
        Ok(PlainParts { path: self.path.clone(), text: self.text.clone(), given })
    }
}

/// A picture as from a file: pixels that are not finite are invalid.
fn coded(image: &unrender::scene::RgbImage, depth: Depth) -> Picture {
    let pixels = image.pixels().iter().enumerate();
    let invalid = pixels.filter(|(_, rgb)| !rgb.is_finite()).map(|(index, _)| index).collect();
    let values = image.map(|rgb| if rgb.is_finite() { *rgb } else { unrender::scene::Rgb::ZERO });
    Picture { invalid, ..Picture::new(values, depth) }
}

/// The results; if Ctrl-C was pressed and the work did not end in time, the state after the last
/// iteration, as JSON; and whether Ctrl-C was pressed.
type Out = (Option<Recovered>, Option<String>, bool);

/// Recovers by the command line `words` of `recover`, from the `project` in memory if it is given. The
/// results are written into the folder `out`, if it is given; `workers` do the renderer's work
/// ([`crate::remote::Called`]).
#[pyfunction]
#[pyo3(signature = (words, project, out, control, workers))]
pub(crate) fn recover(
    py: Python<'_>,
    words: Vec<OsString>,
    project: Option<ProjectParts<'_>>,
    out: Option<PathBuf>,
    control: Control<'_>,
    workers: Option<Py<PyAny>>,
) -> PyResult<Out> {
    let project = project.map(|project| project.read()).transpose()?;
    let names = Arc::new(Mutex::new(Vec::new()));
    let told = Arc::clone(&names);
    let workers = workers.map(Called::new);
    let describe = |record: &IterationRecord| {
        sketch(&names.lock().unwrap_or_else(PoisonError::into_inner), record, "").ok()
    };
    let ended = supervise_recovery(py, &control, &describe, move |listener| {
        worked((words, project, out.as_deref()), listener, &told, workers.as_ref())
    })?;
    let sketch = match (&ended.result, &ended.heard.last) {
        (None, Some(record)) => {
            let names = names.lock().unwrap_or_else(PoisonError::into_inner);
            Some(
                sketch(&names, record, "interrupted ")
                    .map_err(|error| request(error.to_string()))?,
            )
        }
        _ => None,
    };
    Ok((ended.result, sketch, ended.signalled))
}

fn worked(
    (words, project, out): (Vec<OsString>, Option<PlainParts>, Option<&Path>),
    listener: Arc<dyn Listener>,
    names: &Mutex<Vec<String>>,
    workers: Option<&Called>,
) -> Result<Recovered, Error> {
    let (mut global, args) = cli::recover_args(words)?;
    global.console = Console::new(listener);
    let ((mut project, warnings), given) = match project {
        None => (Project::read(args.project()?)?, InMemory::default()),
        Some(PlainParts { path, text, given }) => (Project::parse(&path, &text)?, given),
    };
    command::settle(&args, &mut project, &global);
    if let Some(out) = out {
        command::check(&project, out)?;
    }
    let mut job = Job::assemble(project, warnings, given)?;
    let groups = job.scene.groups.iter().map(|group| group.name.clone());
    *names.lock().unwrap_or_else(PoisonError::into_inner) = groups.collect();
    let recovered = match workers {
        None => command::recovered(&args, &mut job, &global)?,
        Some(workers) => command::recovered_by(&args, &mut job, &global, workers)?,
    };
    if let Some(out) = out {
        command::write(&job, &recovered, out, &global)?;
    }
    Ok(Recovered { job, recovered })
}

/// The state of a recovery after an iteration, as the text of a materials.json; `how` begins the sentence
/// about its end.
fn sketch(names: &[String], record: &IterationRecord, how: &str) -> serde_json::Result<String> {
    let termination = format!(
        "{how}after {} global re-renderings; the results are those after the last one",
        record.iteration
    );
    let mut file = MaterialsFile { termination: Some(termination), ..MaterialsFile::default() };
    for (name, group) in names.iter().zip(&record.groups) {
        let material = &group.material;
        let entry = GroupEntry {
            hypothesis: Some(group.hypothesis),
            rho_d: Some(material.rho_d.to_array()),
            rho_s: Some(material.rho_s.to_array()),
            reflectance: ReflectanceEntry::of(material),
            alpha_x: Some(material.alpha_x),
            alpha_y: Some(material.alpha_y),
            theta_deg: Some(material.theta_rad.to_degrees()),
            error: group.error,
            ..GroupEntry::default()
        };
        file.groups.insert(name.clone(), entry);
    }
    serde_json::to_string(&file)
}

impl Recovered {
    fn recovery(&self) -> &Recovery {
        &self.recovered.recovery
    }

    /// The result of `look` for one photograph and the recovery of that photograph.
    fn of<T>(
        &self,
        photograph: usize,
        look: impl FnOnce(&Job, &unrender::engine::Recovered) -> T,
    ) -> PyResult<T> {
        let count = self.job.photographs();
        if photograph >= count {
            return Err(request(format!("there is no photograph {photograph}; there are {count}")));
        }
        let recovered = self.recovered.alone(&self.job, photograph);
        Ok(look(&self.job.alone(photograph), &recovered))
    }
}

#[pymethods]
impl Recovered {
    /// The results as JSON: the text of materials.json, and the records.
    fn document(&self) -> PyResult<String> {
        let recovery = self.recovery();
        // As text, as in the file: JSON values would have the digits of double precision.
        let materials = serde_json::to_string(&self.recovered.materials(&self.job))
            .map_err(|error| request(error.to_string()))?;
        let names: Vec<&str> = recovery.groups.iter().map(|group| group.name.as_str()).collect();
        let times = self.recovered.times.iterations.iter();
        let iterations = recovery.iterations.iter().zip(times);
        let iterations = iterations.map(|(record, seconds)| iteration(&names, record, *seconds));
        let valid = recovery.groups.iter().map(|g| (g.name.clone(), g.valid_pixels.into()));
        Ok(json!({
            "materials": materials,
            "interrupted": recovery.termination == Termination::Interrupted,
            "exposure_std": recovery.exposure_std.map(|std| std.to_array()),
            "iterations": iterations.collect::<Vec<_>>(),
            "valid_pixels": valid.collect::<serde_json::Map<_, _>>(),
            "photographs": self.job.photographs(),
            "warnings": self.job.warnings.0,
            "summary": self.recovered.summary(&self.job),
            "brdf": self.job.scene.brdf.name(),
        })
        .to_string())
    }

    /// The camera of a photograph, as JSON.
    fn camera(&self, photograph: usize) -> PyResult<String> {
        self.of(photograph, |job, of| camera_out(&of.camera(job), &job.scene).to_string())
    }

    /// One of the pictures `rerendered`, `photo` (both radiance) of a photograph.
    fn picture<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        photograph: usize,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let image = match name {
            "rerendered" => self.of(photograph, |_, of| of.rerendered().clone())?,
            "photo" => self.of(photograph, |job, of| of.photo(job))?,
            _ => return Err(request(format!("there is no picture \"{name}\""))),
        };
        picture(py, image)
    }

    /// The standard deviation of the noise (H, W).
    fn noise<'py>(
        &self,
        py: Python<'py>,
        photograph: usize,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        raster(py, self.of(photograph, |_, of| of.recovery.noise.clone())?)
    }

    /// The group of every pixel (H, W), -1 for none.
    fn group_map<'py>(
        &self,
        py: Python<'py>,
        photograph: usize,
    ) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let number = |group: &u32| i32::try_from(*group).unwrap_or(-1);
        raster(py, self.of(photograph, |_, of| of.group_map.map(number))?)
    }

    /// Which pixels were used (H, W): 0 for those that were, otherwise the reason why not.
    fn status_map<'py>(
        &self,
        py: Python<'py>,
        photograph: usize,
    ) -> PyResult<Bound<'py, PyArray2<u8>>> {
        raster(py, self.of(photograph, |_, of| of.recovery.status.map(|status| *status as u8))?)
    }

    /// The texture of a group (H, W, 3) and which of its texels were seen (H, W), if it has one.
    #[allow(clippy::type_complexity)]
    fn texture<'py>(
        &self,
        py: Python<'py>,
        group: &str,
    ) -> PyResult<Option<(Bound<'py, PyArray3<f32>>, Option<Bound<'py, PyArray2<bool>>>)>> {
        let found = self.recovery().groups.iter().find(|result| result.name == group);
        let Some(result) = found else { return Err(request(format!("there is no group {group}"))) };
        let Some(texture) = &result.material.texture else { return Ok(None) };
        let seen = result.seen_texels.clone().map(|seen: Image<bool>| raster(py, seen));
        Ok(Some((picture(py, texture.image.clone())?, seen.transpose()?)))
    }

    /// The names of the refined parameters, as JSON, and their covariance (N, N).
    #[allow(clippy::type_complexity)]
    fn covariance<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(String, Bound<'py, PyArray2<f64>>)>> {
        let Some(covariance) = &self.recovery().covariance else { return Ok(None) };
        let (names, units): (Vec<Value>, Vec<f64>) = self.named(covariance).into_iter().unzip();
        let rows = covariance.matrix.iter().zip(&units);
        let scaled = rows.flat_map(|(row, a)| row.iter().zip(&units).map(move |(v, b)| a * v * b));
        let matrix = Image::new(names.len(), names.len(), scaled.collect());
        Ok(Some((Value::from(names).to_string(), raster(py, matrix)?)))
    }

    /// The scene with the recovered materials and lights.
    fn scene(&self) -> Scene {
        Scene::new(self.recovered.scene(&self.job))
    }

    /// The recovery as bytes, for another process with the same build.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| postcard::to_stdvec(self));
        let bytes = bytes.map_err(|error| request(format!("the recovery: {error}")))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The recovery of [`Recovered::to_bytes`].
    #[staticmethod]
    fn from_bytes(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        py.detach(|| postcard::from_bytes(bytes)).map_err(|error| {
            request(format!("these are not the bytes of a recovery from the same build: {error}"))
        })
    }

    /// Writes the results into a folder, as the command does.
    fn save(&self, py: Python<'_>, out: PathBuf) -> PyResult<()> {
        let global = Global { quiet: true, ..Global::default() };
        let written = py.detach(|| command::write(&self.job, &self.recovered, &out, &global));
        written.map_err(|error| exception(py, &error))
    }
}

impl Recovered {
    /// The name of each parameter of `covariance`, and the factor to its unit in materials.json.
    fn named(&self, covariance: &Covariance) -> Vec<(Value, f64)> {
        let groups = &self.recovery().groups;
        let scene = &self.job.scene;
        let sources: Vec<_> = scene.sources().collect();
        let parts = scene.environment_parts();
        // The name of a source of light, and its strength in the scene.
        let source = |of: usize| match (
            sources.iter().find(|source| source.index == of),
            &scene.environment,
        ) {
            (_, Some(around)) if parts.len() > 1 && parts.contains(&of) => {
                let part = of - parts.start;
                Some((format!("{ENVIRONMENT} {part}"), around.panorama().pixels()[part]))
            }
            (found, _) => found.map(|source| (source.name.to_owned(), source.strength)),
        };
        let one = |unknown: &unrender::recover::Unknown| {
            let of = unknown.of;
            let material = groups.get(of).map(|group| &group.material);
            let alpha = |f: fn(&unrender::scene::Material) -> f32| material.map_or(1.0, f);
            let strength = |rgb: unrender::scene::Rgb| rgb[unknown.channel.unwrap_or(0)];
            let (name, unit) = match unknown.quantity {
                Quantity::RhoD => ("rho_d", 1.0),
                Quantity::RhoS => ("rho_s", 1.0),
                Quantity::Alpha => ("alpha", alpha(|m| m.alpha_x)),
                Quantity::AlphaX => ("alpha_x", alpha(|m| m.alpha_x)),
                Quantity::AlphaY => ("alpha_y", alpha(|m| m.alpha_y)),
                Quantity::Theta => ("theta_deg", 1f32.to_degrees()),
                Quantity::Light => {
                    let of_source = source(of);
                    ("intensity", of_source.map_or(1.0, |(_, unit)| strength(unit)))
                }
                Quantity::Exposure => ("exposure", strength(self.recovery().exposure)),
                Quantity::Camera => ("camera", 1.0),
            };
            let owner = match unknown.quantity {
                Quantity::Light => source(of).map(|(name, _)| name),
                Quantity::Exposure | Quantity::Camera => None,
                _ => groups.get(of).map(|group| group.name.clone()),
            };
            (json!([name, owner, unknown.channel]), f64::from(unit))
        };
        covariance.of.iter().map(one).collect()
    }
}

/// A global re-rendering as JSON.
fn iteration(names: &[&str], record: &IterationRecord, seconds: f64) -> Value {
    let errors = names.iter().zip(&record.groups);
    let errors = errors.map(|(name, group)| ((*name).to_owned(), json!(group.error)));
    json!({
        "iteration": record.iteration, "refining": record.refining, "seconds": seconds,
        "change": record.change, "worst_error": record.worst_error,
        "open_groups": record.open_groups,
        "errors": errors.collect::<serde_json::Map<_, _>>(),
    })
}
