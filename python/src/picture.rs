//! Picture files as arrays.

use crate::arrays::{image, picture};
use crate::error::exception;
use numpy::{PyArray3, PyReadonlyArray3};
use pyo3::prelude::*;
use std::path::PathBuf;
use unrender::Error;
use unrender_formats::picture as files;

/// The picture in a file as linear values (H, W, 3), and its warnings; integer files are taken as
/// sRGB.
#[pyfunction]
pub(crate) fn read_picture(
    py: Python<'_>,
    path: PathBuf,
) -> PyResult<(Bound<'_, PyArray3<f32>>, Vec<String>)> {
    let read = || files::read(&path).map(|(read, told)| (read.to_linear(), told.0));
    let (linear, told) = py.detach(read).map_err(|error| exception(py, &Error::File(error)))?;
    Ok((picture(py, linear)?, told))
}

/// Writes linear values (H, W, 3) to a .exr, .hdr or .png file; returns how many were not finite.
#[pyfunction]
pub(crate) fn write_picture(
    py: Python<'_>,
    path: PathBuf,
    values: PyReadonlyArray3<'_, f32>,
) -> PyResult<usize> {
    let values = image(&values)?;
    let written = py.detach(|| files::write(&path, &values));
    written.map_err(|error| exception(py, &Error::File(error)))
}

/// The 8-bit PNG of code values (H, W, 3), 0 to 1.
#[pyfunction]
pub(crate) fn png_bytes(codes: PyReadonlyArray3<'_, f32>) -> PyResult<Vec<u8>> {
    files::png_bytes(&image(&codes)?).map_err(crate::error::request)
}
