//! `unrender split`: writes a scene in which groups of two materials are split.

use crate::global::Global;
use crate::project::Project;
use crate::recovered::labels;
use crate::run::Run;
use crate::{Error, interrupt, output};
use std::path::PathBuf;
use std::process::ExitCode;
use unrender_formats::{FileError, atomic, gltf};
use unrender_scene::{Camera, Group, Lens, Scene, Warnings};

/// Writes the scene with those groups split that contain two materials.
///
/// A recovery compares photograph and re-rendering object by object. Where one reflectance does not
/// explain all objects of a group, this writes the project's scene with a group for each part: the
/// first keeps its name, the others are called "NAME 2", "NAME 3". Name that file in the project, and
/// recover again.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
    unrender split result --out room_apart.glb\n  \
    unrender split result --group wall --out room_apart.glb")]
pub struct Args {
    /// The folder of the results.
    pub results: PathBuf,
    /// Only this group [default: all that one reflectance does not explain].
    #[arg(long, value_name = "NAME")]
    pub group: Option<String>,
    /// The scene to write.
    #[arg(long, value_name = "FILE.glb")]
    pub out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// If the results or the scene cannot be read, no group is to be split, or the file cannot be
/// written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    output::check_file(&args.out, &["glb"], "end --out in .glb")?;
    let run = Run::read(&args.results)?;
    let (mut project, _) = Project::read(&run.input.project)?;
    project.limits = global.limits();
    output::check_inputs(&args.out, project.inputs())?;
    let (mut scene, warnings) = unrender_formats::load_model(project.scene_input())?;
    global.console.warn(&warnings);
    let wanted = |name: &&String| args.group.as_ref().is_none_or(|group| group == *name);
    if let Some(name) = args.group.as_ref().filter(|name| !run.groups.contains_key(*name)) {
        return Err(Error::Request(format!("the results have no group \"{name}\"")));
    }
    let apart = run.groups.iter().filter(|(name, group)| wanted(name) && group.parts.len() > 1);
    let mut noted = String::new();
    for (name, group) in apart {
        let split = split(&mut scene, name, &group.parts);
        let names = split.map_err(|problem| FileError::new(&project.scene, problem))?;
        noted.push_str(&format!("{name}: {}\n", names.join(", ")));
    }
    if noted.is_empty() {
        return Err(Error::Request(match &args.group {
            Some(name) => format!("one material explains all objects of \"{name}\""),
            None => "one material explains all objects of every group".into(),
        }));
    }
    let bends = |camera: &Camera| camera.lens != Lens::default();
    if scene.environment.is_some() || scene.cameras.iter().any(bends) {
        let mut lost = Warnings::default();
        lost.push(
            "glTF cannot express an environment or a lens: state them in the project, by \
             [environment] and [camera]",
        );
        global.console.warn(&lost);
    }
    let units = project.light_units.unwrap_or_default();
    let bytes = gltf::to_glb_as(&scene, &scene.materials(), units)
        .map_err(|error| FileError::new(&args.out, error))?;
    let _until_written = interrupt::writing();
    atomic::write(&args.out, &bytes)?;
    global.console.print(&noted);
    Ok(ExitCode::SUCCESS)
}

/// Gives each of the `parts` of the group `name` except the first a group of its own, with the same
/// material; returns each group's name with its objects, in words.
fn split(scene: &mut Scene, name: &str, parts: &[Vec<String>]) -> Result<Vec<String>, String> {
    let changed = || format!("has no group \"{name}\" any more; recover again");
    let group = scene.group_index(name).ok_or_else(changed)?;
    let mut names = Vec::new();
    let labels = labels::labels(scene);
    for (number, part) in parts.iter().enumerate() {
        let mut of_part = name.to_owned();
        if number > 0 {
            of_part = free_name(scene, name, number + 1);
            let Group { material, emission, .. } = scene.groups[group].clone();
            scene.groups.push(Group { name: of_part.clone(), material, emission });
            let last = scene.groups.len() - 1;
            let mut moved = 0;
            for (object, label) in scene.objects.iter_mut().zip(&labels) {
                if object.group == group && part.contains(label) {
                    object.group = last;
                    moved += 1;
                }
            }
            if moved == 0 {
                return Err(format!(
                    "has no object \"{}\" any more; recover again",
                    part.join(", ")
                ));
            }
        }
        names.push(format!("\"{of_part}\" of {}", part.join(", ")));
    }
    Ok(names)
}

/// `name` with a number, as no other group is called.
fn free_name(scene: &Scene, name: &str, first: usize) -> String {
    let mut names = (first..).map(|number| format!("{name} {number}"));
    names.find(|name| scene.group_index(name).is_none()).unwrap_or_default()
}
