//! The sources of the photographs, and the message if they are absent.

use std::fmt::{Display, Formatter, Result as Written};
use std::path::{Path, PathBuf};

/// A set of photographs by others.
pub(crate) struct Source {
    /// Its name.
    name: &'static str,
    /// The place of its publication, and the version.
    place: &'static str,
    /// Its licence.
    licence: &'static str,
    /// The folder of it that a run needs.
    folder: &'static str,
    /// A file that is always in that folder.
    mark: &'static str,
    /// The option of the command, and the environment variable.
    given_by: [&'static str; 2],
}

/// The ball of the DiLiGenT benchmark.
pub(crate) const BALL: Source = Source {
    name: "the glossy ball of DiLiGenT (Shi et al. 2016)",
    place: "https://github.com/yqueau/robust_ps at commit 86a1fbe",
    licence: "none is stated; later commits removed the photographs for copyright reasons, so \
              do not pass them on",
    folder: "Datasets/Ball_DiliGenT",
    mark: "light_directions.txt",
    given_by: ["--ball", "UNRENDER_BALL"],
};

/// The gray and the chrome sphere.
pub(crate) const GRAY: Source = Source {
    name: "the gray sphere (University of Washington, CSE 455)",
    place: "https://github.com/NewProggie/Photometric-Stereo at commit b7b837a",
    licence: "MIT for the repository, whose author states that the photographs are not his",
    folder: "images",
    mark: "gray/gray.mask.png",
    given_by: ["--gray", "UNRENDER_GRAY"],
};

/// The box with measured walls.
pub(crate) const ISET: Source = Source {
    name: "the measured box of Stanford ISET (arXiv 2201.07411)",
    place: "the photographs of that article and fit a scene to each; fitted scenes are not published",
    licence: "none is stated for the photographs, so do not pass them on",
    folder: "iset (photo0, photo1, photo2 and truth.json)",
    mark: "truth.json",
    given_by: ["--iset", "UNRENDER_ISET"],
};

/// Data that is not on this machine.
#[derive(Debug)]
pub(crate) struct Absent(String);

impl Display for Absent {
    fn fmt(&self, f: &mut Formatter) -> Written {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Absent {}

impl Source {
    /// The folder with the data: `given` by the option, or else by the environment variable.
    ///
    /// # Errors
    /// If none was given, or if it lacks the data.
    pub(crate) fn find(&self, given: Option<&Path>) -> Result<PathBuf, Absent> {
        let [option, variable] = self.given_by;
        let in_environment = || std::env::var_os(variable).map(PathBuf::from);
        let why = match given.map(Path::to_owned).or_else(in_environment) {
            Some(folder) if folder.join(self.mark).is_file() => return Ok(folder),
            Some(folder) => format!("{} has no {}", folder.display(), self.mark),
            None => "its folder was not given".to_owned(),
        };
        Err(Absent(format!(
            "{}: {why}. Fetch {}; give the folder {} by {option} DIR or {variable}. Licence: {}.",
            self.name, self.place, self.folder, self.licence
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absent_data_is_said_to_be_with_what_to_do() {
        let said = BALL.find(None).unwrap_err().to_string();
        for word in ["yqueau/robust_ps", "86a1fbe", "Datasets/Ball_DiliGenT", "Licence", "--ball"] {
            assert!(said.contains(word), "{said}");
        }
        let said = GRAY.find(Some(Path::new("/nowhere"))).unwrap_err().to_string();
        assert!(said.contains("/nowhere has no gray/gray.mask.png"), "{said}");
    }
}
