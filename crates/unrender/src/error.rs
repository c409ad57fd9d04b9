//! The error of a command.

use unrender_formats::FileError;
use unrender_scene::SceneError;

/// Why a command ended without its result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file cannot be read or written, or is not valid.
    #[error(transparent)]
    File(#[from] FileError),
    /// The scene cannot be rendered.
    #[error("{}: the scene cannot be used", path.display())]
    Scene {
        /// The scene's file.
        path: std::path::PathBuf,
        /// What is wrong with it.
        source: SceneError,
    },
    /// A request does not fit the scene or the machine.
    #[error("{0}")]
    Request(String),
    /// The measured points do not determine a camera.
    #[error("{}: {problem}", path.display())]
    Calibrate {
        /// The file with the points.
        path: std::path::PathBuf,
        /// Why.
        problem: unrender_photo::calibrate::CalibrateError,
    },
    /// Recovery cannot start.
    #[error(transparent)]
    Recover(#[from] unrender_recover::RecoverError),
}
