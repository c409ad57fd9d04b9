//! Converts rasters and vertices to NumPy arrays, and back. Arrays for Python are not copied: the array
//! owns the vector.

use bytemuck::allocation::cast_vec;
use glam::{Vec2, Vec3};
use numpy::{
    Element, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2,
    PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use unrender::scene::{Image, Rgb, RgbImage};

/// A picture as an array (H, W, 3).
pub(crate) fn picture(py: Python<'_>, image: RgbImage) -> PyResult<Bound<'_, PyArray3<f32>>> {
    let size = [image.height(), image.width(), 3];
    vectors(py, image.into_pixels()).reshape(size)
}

/// A raster of single values as an array (H, W).
pub(crate) fn raster<T: Element>(
    py: Python<'_>,
    image: Image<T>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let size = [image.height(), image.width()];
    image.into_pixels().into_pyarray(py).reshape(size)
}

/// Vectors as their coordinates, one after the other.
fn vectors(py: Python<'_>, vectors: Vec<Vec3>) -> Bound<'_, PyArray1<f32>> {
    cast_vec::<Vec3, [f32; 3]>(vectors).into_flattened().into_pyarray(py)
}

/// Vectors as an array (N, 3).
pub(crate) fn rows3(py: Python<'_>, rows: Vec<Vec3>) -> PyResult<Bound<'_, PyArray2<f32>>> {
    let size = [rows.len(), 3];
    vectors(py, rows).reshape(size)
}

/// Vectors as an array (N, 2).
pub(crate) fn rows2(py: Python<'_>, rows: Vec<Vec2>) -> PyResult<Bound<'_, PyArray2<f32>>> {
    let size = [rows.len(), 2];
    cast_vec::<Vec2, [f32; 2]>(rows).into_flattened().into_pyarray(py).reshape(size)
}

/// Triangles as an array (N, 3).
pub(crate) fn triangles(py: Python<'_>, rows: Vec<[u32; 3]>) -> PyResult<Bound<'_, PyArray2<u32>>> {
    let size = [rows.len(), 3];
    rows.into_flattened().into_pyarray(py).reshape(size)
}

/// The picture in an array (H, W, 3).
pub(crate) fn image(array: &PyReadonlyArray3<'_, f32>) -> PyResult<RgbImage> {
    let &[height, width, channels] = array.shape() else {
        return Err(PyValueError::new_err("a picture is an array (H, W, 3)"));
    };
    if channels != 3 || width == 0 || height == 0 {
        let problem =
            format!("a picture is an array (H, W, 3), not ({height}, {width}, {channels})");
        return Err(PyValueError::new_err(problem));
    }
    let (pixels, _) = array.as_slice()?.as_chunks::<3>();
    Ok(Image::new(width, height, pixels.iter().map(|rgb| Rgb::from_array(*rgb)).collect()))
}

/// The rows of `N` values in an array (M, N); `name` is the array's name in errors.
pub(crate) fn rows<T: Element + Copy, const N: usize>(
    array: &PyReadonlyArray2<'_, T>,
    name: &str,
) -> PyResult<Vec<[T; N]>> {
    let shape = array.shape();
    if shape.get(1) != Some(&N) {
        let problem = format!("{name} is an array (count, {N}), not of the shape {shape:?}");
        return Err(PyValueError::new_err(problem));
    }
    Ok(array.as_slice()?.as_chunks::<N>().0.to_vec())
}
