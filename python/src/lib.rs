//! The Python module `unrender._unrender`: the library's commands as functions.
//!
//! This is the thin half of the package. The user's functions are in `python/unrender`, with types and
//! docstrings; this half does what that one cannot: it calls the library without the interpreter's
//! lock, exchanges arrays, and passes on warnings, progress and Ctrl-C (`supervise`). Structured data
//! goes through JSON, as in the files of the command.

mod arrays;
mod command;
mod error;
mod picture;
mod recovery;
mod remote;
mod render;
mod scene;
mod supervise;

use pyo3::prelude::*;

/// The Python module.
#[pymodule]
mod _unrender {
    #[pymodule_export]
    use super::command::{call, description, main, toml_text};
    #[pymodule_export]
    use super::picture::{png_bytes, read_picture, write_picture};
    #[pymodule_export]
    use super::recovery::{Recovered, recover};
    #[pymodule_export]
    use super::remote::Worker;
    #[pymodule_export]
    use super::render::render;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::supervise::Token;
}
