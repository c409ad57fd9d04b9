//! A recovery over several machines: Python objects send the bytes and know the workers; this is the
//! interface between them and the library.

use crate::error::request;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList};
use unrender::remote::{self, Shared, Workers};

/// A Python object with the methods `count()` and `answers(shared, requests)`: the shared data are pairs
/// of a number and bytes, the answers a list of bytes, or None if there are no workers.
pub(crate) struct Called {
    object: Py<PyAny>,
}

impl Called {
    pub(crate) fn new(object: Py<PyAny>) -> Self {
        Self { object }
    }

    fn asked(&self, shared: &[Shared], requests: &[Vec<u8>]) -> PyResult<Option<Vec<Vec<u8>>>> {
        Python::attach(|py| {
            let pair = |shared: &Shared| (shared.number, PyBytes::new(py, &shared.bytes));
            let shared = PyList::new(py, shared.iter().map(pair))?;
            let requests = PyList::new(py, requests.iter().map(|r| PyBytes::new(py, r)))?;
            let answers = self.object.bind(py).call_method1("answers", (shared, requests))?;
            let answers: Option<Vec<Bound<'_, PyBytes>>> = answers.extract()?;
            Ok(answers.map(|all| all.iter().map(|answer| answer.as_bytes().to_vec()).collect()))
        })
    }
}

impl Workers for Called {
    fn count(&self) -> usize {
        Python::attach(|py| {
            let count = self.object.bind(py).call_method0("count");
            let count = count.and_then(|count| count.extract());
            count.unwrap_or_else(|error| none(py, &error))
        })
    }

    fn answers(&self, shared: &[Shared; 3], requests: &[Vec<u8>]) -> Option<Vec<Vec<u8>>> {
        let answers = self.asked(shared, requests);
        answers.unwrap_or_else(|error| Python::attach(|py| none(py, &error)))
    }
}

/// Handles an exception that has no receiver: it is printed, and there is no answer.
fn none<T: Default>(py: Python<'_>, error: &PyErr) -> T {
    error.clone_ref(py).write_unraisable(py, None);
    T::default()
}

/// A scene and a camera on a worker, made from the first of the shared data.
#[pyclass(module = "unrender._unrender", frozen)]
pub(crate) struct Worker {
    worker: remote::Worker,
}

#[pymethods]
impl Worker {
    #[new]
    fn new(py: Python<'_>, setup: &[u8]) -> PyResult<Self> {
        let worker = py.detach(|| remote::Worker::new(setup));
        worker.map(|worker| Self { worker }).map_err(|fault| request(fault.to_string()))
    }

    /// The answer to a request, with the second and the third of the shared data.
    fn answer<'py>(
        &self,
        py: Python<'py>,
        appearance: &[u8],
        cache: &[u8],
        asked: &[u8],
    ) -> PyResult<Bound<'py, PyBytes>> {
        let answer = py.detach(|| self.worker.answer(appearance, cache, asked));
        answer.map(|bytes| PyBytes::new(py, &bytes)).map_err(|fault| request(fault.to_string()))
    }
}
