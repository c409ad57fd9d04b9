//! The project that `unrender init` proposes for a scene and a photograph: what the files say, and guesses, marked as such,
//! where they do not.

use crate::check::{Checkup, capitalised, check};
use crate::job::InMemory;
use crate::{Error, Job, Project};
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};
use unrender_formats::picture::{self, Picture};
use unrender_formats::{FileError, Input, Limits};
use unrender_photo::Response;
use unrender_scene::{Camera, Depth, Scene, Warnings};

/// A photograph that is brighter than the scene in middle grey by more than this factor, or darker, has another exposure
/// than one: the reflectances of a room's surfaces are 0.5 within this factor in the mean. At half of it dark and white rooms
/// have an unknown exposure, at double reflectances come out twice too dark without a word.
const NEAR: f64 = 3.0;
/// The reflectance that is guessed for an anchor.
const GREY: f32 = 0.5;
/// The groups that are listed.
const GROUPS: usize = 24;

/// A project that is proposed.
#[derive(Debug)]
pub struct Proposed {
    /// The text of the project file.
    pub text: String,
    /// What was guessed, a sentence each.
    pub guesses: Vec<String>,
    /// The check of that project; none if the scene has no camera, so that it cannot be used yet.
    pub checkup: Option<Checkup>,
    /// What was noted on reading the files.
    pub warnings: Warnings,
}

/// What a project of these files needs to say.
struct Facts<'a> {
    scene: &'a Scene,
    photo: &'a Picture,
    /// The files, as the project names them.
    files: [String; 2],
    /// The scene's own camera that is taken.
    camera: Option<&'a Camera>,
    /// Whether the scene has no light.
    is_dark: bool,
}

/// Proposes a project file at `to` for a scene and a photograph.
///
/// # Errors
/// If one of the files cannot be read.
pub fn propose(scene: &Path, photo: &Path, to: &Path, limits: Limits) -> Result<Proposed, Error> {
    let (model, mut warnings) = unrender_formats::load_model(Input::new(scene, limits))?;
    let (picture, noted) = picture::read(Input::new(photo, limits))?;
    warnings.extend(noted);
    let folder = to.parent().unwrap_or(Path::new(""));
    let facts = Facts {
        camera: camera(&model, &picture),
        is_dark: model.sources().next().is_none(),
        files: [scene, photo].map(|file| named(&relative(file, folder))),
        photo: &picture,
        scene: &model,
    };
    let mut guesses = Vec::new();
    if facts.camera.is_none() {
        guesses.push(
            "the scene has no camera: find it by `unrender calibrate`, or fill in [camera] in the project".to_owned(),
        );
        let text = text(&facts, to, None);
        return Ok(Proposed { text, guesses, checkup: None, warnings });
    }
    // A first look with an exposure of one.
    let first = lines(&facts);
    let (project, _) = Project::parse(to, &first)?;
    let given = InMemory { scene: Some(model.clone()), photo: Some(picture.clone()), mask: None };
    let mut job = Job::assemble(Project { limits, ..project }, Warnings::default(), given)?;
    job.reduce();
    let checkup = check(&job);
    guesses.extend(told(&facts, &job, &checkup));
    let text = text(&facts, to, Some((&job, &checkup)));
    Ok(Proposed { text, guesses, checkup: Some(checkup), warnings })
}

/// The scene's camera with the photograph's aspect, or the first one.
fn camera<'s>(scene: &'s Scene, photo: &Picture) -> Option<&'s Camera> {
    let aspect = photo.values.width() as f32 / photo.values.height() as f32;
    let off = |camera: &&Camera| camera.aspect.map_or(0.0, |own| (own / aspect).ln().abs());
    scene.cameras.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// The lines of a first look: an exposure of one, and in a scene without light a sky, with something to fix its scale.
fn lines(facts: &Facts<'_>) -> String {
    let [scene, photo] = &facts.files;
    let mut text = format!("scene = {scene}\nphoto = {photo}\nexposure = 1.0\n");
    if let Some(camera) = facts.camera {
        let _ = writeln!(text, "camera = {}", quoted(&camera.name));
    }
    if facts.is_dark
        && let Some(group) = facts.scene.groups.first()
    {
        let group = quoted(&group.name);
        let _ = write!(text, "\n[anchor]\ngroup = {group}\nrho_d = {GREY}\n");
        text.push_str("\n[environment]\nunknown = true\n");
    }
    text
}

/// Whether the exposure has to be found.
fn is_exposure_unknown(facts: &Facts<'_>, checkup: &Checkup) -> bool {
    !facts.is_dark && checkup.brightness.is_some_and(|factor| factor.ln().abs() > NEAR.ln())
}

/// The largest group that is to be recovered.
fn anchor(checkup: &Checkup) -> Option<&str> {
    let unknown = checkup.groups.iter().filter(|group| group.role == "unknown");
    unknown.max_by_key(|group| group.valid).map(|group| group.name.as_str())
}

/// The guesses, a sentence each.
fn told(facts: &Facts<'_>, job: &Job, checkup: &Checkup) -> Vec<String> {
    let mut guesses = Vec::new();
    if facts.photo.depth != Depth::Float && facts.photo.profile.is_none() {
        let name = response(&job.transfer.response).unwrap_or("as the file says");
        guesses.push(format!("the response is \"{name}\": the photo does not say"));
    }
    if facts.photo.depth != Depth::Float && !is_exposure_unknown(facts, checkup) {
        guesses.push("the exposure is 1: reflectances are as far off as it is".to_owned());
    }
    if facts.scene.cameras.len() > 1
        && let Some(camera) = facts.camera
    {
        let why =
            if camera.aspect.is_some() { "it has the photo's aspect" } else { "it is the first" };
        guesses.push(format!(
            "the camera is {}, of {}: {why}",
            quoted(&camera.name),
            facts.scene.cameras.len()
        ));
    }
    if facts.is_dark {
        guesses.push("the scene has no light: light from all around is to be recovered".to_owned());
    }
    let needs_anchor = facts.is_dark || is_exposure_unknown(facts, checkup);
    if let Some(factor) = checkup.brightness
        && is_exposure_unknown(facts, checkup)
    {
        let by = if factor > 1.0 { factor } else { factor.recip() };
        let than = if factor > 1.0 { "brighter" } else { "darker" };
        guesses.push(format!(
            "the exposure is unknown: the photo is {by:.0} times {than} than the scene in middle grey"
        ));
    }
    if needs_anchor && let Some(group) = anchor(checkup) {
        guesses.push(format!(
            "the diffuse reflectance of \"{group}\" is {GREY}, which fixes how bright everything is: put in a measured \
             one, or a better guess"
        ));
    }
    guesses
}

/// The whole file, with comments.
fn text(facts: &Facts<'_>, to: &Path, found: Option<(&Job, &Checkup)>) -> String {
    let mut text = format!(
        "# {}: made by `unrender init`. Guesses are marked as such; docs/reference/project.md has all keys.\n\n",
        to.file_name().unwrap_or_default().to_string_lossy()
    );
    let [scene, photo] = &facts.files;
    let (groups, triangles) = (facts.scene.groups.len(), facts.scene.triangle_count());
    commented(
        &mut text,
        &format!("scene = {scene}"),
        &format!("{groups} groups, {triangles} triangles"),
    );
    let (width, height) = (facts.photo.values.width(), facts.photo.values.height());
    let depth = match facts.photo.depth {
        Depth::Eight => "8 bits",
        Depth::Sixteen => "16 bits",
        Depth::Float => "floating point",
    };
    commented(&mut text, &format!("photo = {photo}"), &format!("{width} x {height}, {depth}"));
    if let Some((job, _)) = found
        && let Some(name) = response(&job.transfer.response)
    {
        let is_guess = facts.photo.depth != Depth::Float && facts.photo.profile.is_none();
        let why =
            if is_guess { "a guess: most pictures of 8 bits are" } else { "as the file says" };
        commented(&mut text, &format!("response = \"{name}\""), why);
    }
    camera_lines(&mut text, facts);
    let unknown = found.filter(|(_, checkup)| is_exposure_unknown(facts, checkup));
    if unknown.is_some() {
        commented(
            &mut text,
            "exposure = \"auto\"",
            "a guess: the photo is far from the scene's brightness",
        );
    } else {
        let why =
            "radiance of a linear value of one; \"auto\", with an [anchor], if it is not known";
        commented(&mut text, "exposure = 1.0", why);
    }
    if unknown.is_some() || facts.is_dark {
        let group = found.and_then(|(_, checkup)| anchor(checkup));
        let group = group.or(facts.scene.groups.first().map(|group| group.name.as_str()));
        let _ = write!(
            text,
            "\n# What fixes how bright everything is: a group whose diffuse reflectance is known.\n[anchor]\n\
             group = {}\nrho_d = {GREY}                    # a guess: measure one\n",
            quoted(group.unwrap_or_default())
        );
    }
    if facts.is_dark {
        text.push_str("\n# The scene has no light.\n[environment]\nunknown = true\n");
    }
    if let Some((job, checkup)) = found {
        let _ = write!(
            text,
            "\n[recover]\nbrdf = \"{}\"             # as the scene's format has it\n",
            job.scene.brdf
        );
        light_lines(&mut text, facts.scene);
        remedy_lines(&mut text, checkup);
        group_lines(&mut text, checkup);
    }
    text
}

fn camera_lines(text: &mut String, facts: &Facts<'_>) {
    match facts.camera {
        Some(camera) => {
            let count = facts.scene.cameras.len();
            let why = if count > 1 {
                format!("a guess, of {count}: the first with the photo's aspect")
            } else {
                "the scene's only camera".to_owned()
            };
            commented(text, &format!("camera = {}", quoted(&camera.name)), &why);
        }
        None => {
            let [low, high] = facts.scene.bounds().unwrap_or_default();
            let (middle, size) = (0.5 * (low + high), low.distance(high));
            let eye = middle + glam::Vec3::Z * size;
            let at = |v: glam::Vec3| format!("[{:.3}, {:.3}, {:.3}]", v.x, v.y, v.z);
            let _ = write!(
                text,
                "\n# The scene has no camera. `unrender calibrate` finds it from points that you measure in the photo; or fill \
                 in:\ncamera = {{ eye = {}, target = {}, up = [0, 1, 0], fov_y_deg = 40.0 }}\n\n",
                at(eye),
                at(middle)
            );
        }
    }
}

fn light_lines(text: &mut String, scene: &Scene) {
    let names: Vec<String> = scene.sources().map(|source| quoted(source.name)).collect();
    let Some(first) = names.first() else { return };
    let _ = write!(
        text,
        "\n# The lights are taken as the scene has them: {}. If the brightness of one is not known:\n# [lights.{first}]\n\
         # unknown = true\n",
        names.join(", ")
    );
}

/// What looks wrong and can be mended in the project, with the lines to uncomment.
fn remedy_lines(text: &mut String, checkup: &Checkup) {
    for (sentence, lines) in &checkup.remedies {
        let lines = lines.replace('\n', "\n# ");
        let _ = write!(text, "\n# {}:\n# {lines}\n", capitalised(sentence));
    }
}

fn group_lines(text: &mut String, checkup: &Checkup) {
    let mut groups: Vec<_> =
        checkup.groups.iter().filter(|group| group.role == "unknown").collect();
    groups.sort_by_key(|group| std::cmp::Reverse(group.pixels));
    let Some(first) = groups.first() else { return };
    text.push_str("\n# What is recovered: the groups, by the pixels that show them.\n");
    for group in groups.iter().take(GROUPS) {
        let _ = writeln!(text, "#   {} {}", group.pixels, quoted(&group.name));
    }
    let more = groups.len().saturating_sub(GROUPS);
    if more > 0 {
        let _ = writeln!(text, "#   and {more} smaller ones");
    }
    let _ = write!(
        text,
        "# What is known of one need not be recovered; what the model lacks can be left out:\n# [groups.{0}]\n\
         # known = {{ rho_d = [0.8, 0.8, 0.8] }}\n# ignore = true\n",
        quoted(&first.name)
    );
}

/// A line with a comment, in columns.
fn commented(text: &mut String, line: &str, comment: &str) {
    let _ = writeln!(text, "{line:30} # {comment}");
}

/// The name of a response that has one.
fn response(response: &Response) -> Option<&'static str> {
    match response {
        Response::Srgb => Some("srgb"),
        Response::Linear => Some("linear"),
        Response::Gamma(_) | Response::Measured(_) => None,
    }
}

/// A text as TOML has it.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// A path as a project has it: with forward slashes.
fn named(path: &Path) -> String {
    let parts: Vec<_> = path.components().map(|part| part.as_os_str().to_string_lossy()).collect();
    let is_relative = path.is_relative();
    quoted(&if is_relative { parts.join("/") } else { path.to_string_lossy().into_owned() })
}

/// The absolute path without links, also of what does not exist yet.
fn real(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let is_there = |above: &&Path| above.exists();
    let there = path.ancestors().find(is_there).unwrap_or(&path);
    let rest = path.strip_prefix(there).unwrap_or(Path::new(""));
    there.canonicalize().unwrap_or_else(|_| there.to_owned()).join(rest)
}

/// The path of `file` from `folder`; absolute where there is none, as between two drives.
fn relative(file: &Path, folder: &Path) -> PathBuf {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (file, folder) = (real(file), real(folder));
    let common = file.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    if common == 0 {
        return file;
    }
    let up = folder.components().skip(common).map(|_| Component::ParentDir);
    up.chain(file.components().skip(common)).collect()
}

/// Checks that no file is at `to` yet.
///
/// # Errors
/// If there is one.
pub(crate) fn is_free(to: &Path) -> Result<(), FileError> {
    if to.exists() {
        let problem = "is there already; name another file by --out, or move it away";
        return Err(FileError::new(to, problem));
    }
    Ok(())
}

/// Writes the `text` of a project to a new file at `to`.
///
/// # Errors
/// If there is a file already, or it cannot be written.
pub(crate) fn write(text: &str, to: &Path) -> Result<(), FileError> {
    is_free(to)?;
    unrender_formats::atomic::write(to, text.as_bytes())
}
