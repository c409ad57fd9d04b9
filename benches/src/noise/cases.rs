//! The scenes by name, and how they are loaded.

use super::made::{self, Make};
use super::measure::Shot;
use crate::{Failure, root};
use std::fs;
use std::path::{Path, PathBuf};
use unrender::formats::materials;
use unrender::scene::Scene;
use unrender::{Job, Project};

/// Pictures are as large as fits into this width and height, pixels. At half of it small groups are not seen, at
/// double a scene takes four times as long for the same result.
const FITS: (usize, usize) = (240, 180);
/// The project file and the truth of a scene of the corpus.
const OF_CORPUS: [&str; 2] = ["exr_exact.toml", "truth.json"];

/// A scene that can be requested.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    /// Its name.
    pub(crate) name: String,
    source: Source,
}

/// The source of a scene.
#[derive(Clone, Debug)]
enum Source {
    /// A project, and the file of its true materials. Without a truth the materials are those of the scene's
    /// file: `examples/hall` has none, and all its groups have the same grey, the default of a modeller.
    Project { project: PathBuf, truth: Option<PathBuf> },
    /// Code.
    Made(Make),
}

/// All scenes: those of `examples`, those made by code, and those in the folder `corpus`.
///
/// # Errors
/// If a folder cannot be read, the corpus has no scene, or two scenes have one name.
pub(crate) fn all(corpus: Option<&Path>) -> Result<Vec<Case>, Failure> {
    let examples = root().join("examples");
    let mut cases = Vec::new();
    for name in ["fig8", "room", "hall"] {
        let folder = examples.join(name);
        cases.extend(of_project(name, &folder, [&format!("{name}.toml"), "truth.json"]));
    }
    let tiny = of_folder(&examples.join("corpus"), ["project.toml", "truth.json"])?;
    cases.extend(
        tiny.into_iter().map(|case| Case { name: format!("corpus/{}", case.name), ..case }),
    );
    cases.extend(
        made::ALL.map(|(name, make)| Case { name: name.to_owned(), source: Source::Made(make) }),
    );
    if let Some(folder) = corpus {
        let found = of_folder(folder, OF_CORPUS)?;
        if found.is_empty() {
            let folder = folder.display();
            let [project, truth] = OF_CORPUS;
            return Err(format!(
                "--corpus: no folder in {folder} has a {project} and a {truth}; give the folder of \
                 the corpus's scenes"
            )
            .into());
        }
        cases.extend(found);
    }
    match twice(&cases) {
        Some(name) => {
            Err(format!("two scenes are called \"{name}\"; rename one of the folders").into())
        }
        None => Ok(cases),
    }
}

/// Those of `cases` that are `named`, each once, in the order of the names; all if none is.
///
/// # Errors
/// If there is no scene of a name.
pub(crate) fn choose(cases: Vec<Case>, named: &[String]) -> Result<Vec<Case>, Failure> {
    if named.is_empty() {
        return Ok(cases);
    }
    let mut chosen: Vec<Case> = Vec::new();
    for name in named {
        let Some(case) = cases.iter().find(|case| case.name == *name) else {
            let names: Vec<&str> = cases.iter().map(|case| case.name.as_str()).collect();
            return Err(format!(
                "there is no scene \"{name}\"; there are {} (those of the corpus, with --corpus DIR)",
                names.join(", ")
            )
            .into());
        };
        if !chosen.iter().any(|other| other.name == *name) {
            chosen.push(case.clone());
        }
    }
    Ok(chosen)
}

impl Case {
    /// The scene with its true materials.
    ///
    /// # Errors
    /// If a file cannot be read, or its contents cannot be used.
    pub(crate) fn load(&self) -> Result<Shot, Failure> {
        match &self.source {
            Source::Made(make) => made_shot(make()?),
            Source::Project { project, truth } => project_shot(project, truth.as_deref()),
        }
    }
}

fn made_shot(mut scene: Scene) -> Result<Shot, Failure> {
    scene.validate()?;
    let camera = scene.cameras.first().ok_or("the scene has no camera")?.clone();
    Ok(Shot { scene, camera, size: made::SIZE })
}

/// The scene, the light and the camera of a project, with the materials and the lobes of `truth`.
fn project_shot(project: &Path, truth: Option<&Path>) -> Result<Shot, Failure> {
    let (project, warnings) = Project::read(project)?;
    let Job { mut scene, camera, photo, .. } = Job::load(project, warnings)?;
    if let Some(truth) = truth {
        materials::apply_from(truth, &mut scene)?;
    }
    let size = fitted((photo.radiance.width(), photo.radiance.height()));
    Ok(Shot { scene, camera, size })
}

/// The largest size of the same aspect that fits, and not larger than `(width, height)`.
fn fitted((width, height): (usize, usize)) -> (usize, usize) {
    let share = |fits: usize, is: usize| fits as f64 / is.max(1) as f64;
    let scale = share(FITS.0, width).min(share(FITS.1, height)).min(1.0);
    let scaled = |pixels: usize| ((pixels as f64 * scale).round() as usize).max(1);
    (scaled(width), scaled(height))
}

/// The scene of a folder with these files; none if there is no project. The truth may be missing.
fn of_project(name: &str, folder: &Path, [project, truth]: [&str; 2]) -> Option<Case> {
    let there = |file: &str| Some(folder.join(file)).filter(|path| path.is_file());
    let source = Source::Project { project: there(project)?, truth: there(truth) };
    Some(Case { name: name.to_owned(), source })
}

/// The scenes of the folders in `folder` that have both files, by name.
fn of_folder(folder: &Path, files: [&str; 2]) -> Result<Vec<Case>, Failure> {
    let unread = |problem| format!("{}: {problem}", folder.display());
    let mut cases = Vec::new();
    for entry in fs::read_dir(folder).map_err(unread)? {
        let path = entry.map_err(unread)?.path();
        if files.iter().all(|file| path.join(file).is_file())
            && let Some(name) = path.file_name()
        {
            cases.extend(of_project(&name.to_string_lossy(), &path, files));
        }
    }
    cases.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(cases)
}

/// A name that two of `cases` have, if there is one.
fn twice(cases: &[Case]) -> Option<&str> {
    let is_earlier = |(index, case): &(usize, &Case)| {
        cases[..*index].iter().any(|other| other.name == case.name)
    };
    cases.iter().enumerate().find(is_earlier).map(|(_, case)| case.name.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(cases: &[Case]) -> Vec<&str> {
        cases.iter().map(|case| case.name.as_str()).collect()
    }

    #[test]
    fn all_examples_and_all_made_scenes_are_there() {
        let cases = all(None).unwrap();
        let names = names(&cases);
        for name in ["fig8", "room", "hall", "corpus/mirror", "corpus/principled", "sun_on_mirror"]
        {
            assert!(names.contains(&name), "{name} is not in {names:?}");
        }
        assert_eq!(names.len(), 3 + 6 + 4);
    }

    #[test]
    fn scenes_are_chosen_by_name_each_once() {
        let named = |named: &[&str]| {
            let named: Vec<String> = named.iter().map(|name| (*name).to_owned()).collect();
            choose(all(None).unwrap(), &named)
        };
        let chosen = named(&["sharp_floor", "fig8", "sharp_floor"]).unwrap();
        assert_eq!(names(&chosen), ["sharp_floor", "fig8"]);
        assert_eq!(named(&[]).unwrap().len(), all(None).unwrap().len());
        let refused = named(&["fig8", "fig9"]).unwrap_err().to_string();
        assert!(refused.starts_with("there is no scene \"fig9\"; there are fig8, room, hall, c"));
        assert!(refused.contains("--corpus DIR"), "{refused}");
    }

    #[test]
    fn a_folder_without_scenes_and_a_name_given_twice_are_refused() {
        let refused = all(Some(&root().join("docs"))).unwrap_err().to_string();
        assert!(refused.starts_with("--corpus: no folder in"), "{refused}");
        let mut cases = all(None).unwrap();
        assert_eq!(twice(&cases), None);
        cases.push(cases[1].clone());
        assert_eq!(twice(&cases), Some("room"));
    }

    #[test]
    fn pictures_keep_their_aspect_and_do_not_grow() {
        assert_eq!(fitted((480, 360)), (240, 180));
        assert_eq!(fitted((512, 512)), (180, 180));
        assert_eq!(fitted((1000, 10)), (240, 2));
        assert_eq!(fitted((64, 48)), (64, 48));
    }
}
