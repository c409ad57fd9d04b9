//! Errors of the library as exceptions of `unrender.errors`.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::path::Path;
use unrender::Error;

/// The Python exception for `error`.
pub(crate) fn exception(py: Python<'_>, error: &Error) -> PyErr {
    let (kind, path) = match error {
        Error::File(file) => ("FileError", Some(file.path.as_path())),
        Error::Scene { path, .. } => ("SceneError", Some(path.as_path())),
        Error::Calibrate { path, .. } => ("CalibrateError", Some(path.as_path())),
        Error::Request(_) => ("RequestError", None),
        Error::Recover(_) => ("RecoverError", None),
        _ => ("Error", None),
    };
    made(py, kind, &message(error), path).unwrap_or_else(|failed| failed)
}

/// The exception of a request that cannot be met.
pub(crate) fn request(problem: impl Into<String>) -> PyErr {
    Python::attach(|py| exception(py, &Error::Request(problem.into())))
}

/// The exception for a panic of the library: a fault of ours, which must not end the interpreter.
pub(crate) fn internal() -> PyErr {
    PyRuntimeError::new_err("unrender has a fault; please report the message above")
}

fn made(py: Python<'_>, kind: &str, message: &str, path: Option<&Path>) -> PyResult<PyErr> {
    let class = py.import("unrender.errors")?.getattr(kind)?;
    Ok(PyErr::from_value(class.call1((message, path))?))
}

/// The error and its causes, as one sentence.
fn message(error: &Error) -> String {
    let mut text = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(inner) = cause {
        text = format!("{text}: {inner}");
        cause = inner.source();
    }
    text
}
