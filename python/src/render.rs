//! The command `unrender render` as a function that returns its picture.

use crate::arrays::picture;
use crate::scene::{Materials, Scene};
use crate::supervise::{Control, supervise};
use numpy::PyArray3;
use pyo3::prelude::*;
use std::ffi::OsString;
use unrender::cli;
use unrender::commands::render::{InMemory, picture as rendered};
use unrender::scene as plain;

/// The picture, its relative standard error, the range of its samples, whether it ended before its
/// goal, and whether by Ctrl-C.
type Rendered<'py> = (Option<Bound<'py, PyArray3<f32>>>, f64, (u32, u32), bool, bool);

/// Renders by the command line `words` of `render`: the `scene`, if it is given, with `materials`.
#[pyfunction]
#[pyo3(signature = (words, scene, materials, control))]
pub(crate) fn render<'py>(
    py: Python<'py>,
    words: Vec<OsString>,
    scene: Option<Bound<'py, Scene>>,
    materials: Option<Materials<'py>>,
    control: Control<'py>,
) -> PyResult<Rendered<'py>> {
    let scene = scene.map(|scene| scene.get().plain().clone());
    let materials = materials.map(|materials| materials.read()).transpose()?;
    let ended = supervise(py, &control, move |listener| {
        let (mut global, args) = cli::render_args(words)?;
        global.console = unrender::listener::Console::new(listener);
        let put = |scene: &mut plain::Scene| match &materials {
            Some(given) => given.put_onto(scene),
            None => Ok(plain::Warnings::default()),
        };
        rendered(&args, InMemory { scene, materials: Some(&put) }, &global)
    })?;
    let Some(rendering) = ended.result else {
        return Ok((None, f64::NAN, (0, 0), true, ended.signalled));
    };
    let samples = (rendering.samples.start, rendering.samples.end);
    let radiance = picture(py, rendering.radiance)?;
    Ok((Some(radiance), rendering.noise, samples, rendering.interrupted, ended.signalled))
}
