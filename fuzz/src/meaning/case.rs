//! The files of a run: a scene, a photograph of it or of what it was before, a project and edits.

use super::photographs::take;
use super::projects::{edits, flags, project};
use super::rooms::ROOMS;
use super::scenes::mutate;
use crate::random::Random;
use std::fs;
use std::io;
use std::path::Path;
use unrender::formats::gltf;
use unrender::scene::{Material, Rgb};

/// What is done with the files.
#[derive(Clone, Debug)]
pub(super) struct Case {
    /// The names of the mutations of the scene.
    pub(super) mutations: Vec<&'static str>,
    /// The command lines, in the order in which they are run.
    pub(super) commands: Vec<Vec<String>>,
}

/// Writes the files of case `index` under `seed` into `folder`; none if the scene cannot be written as a file.
///
/// # Errors
/// If a file cannot be written.
pub(super) fn make(folder: &Path, seed: u64, index: u64) -> io::Result<Option<Case>> {
    let mut random = Random::new(seed, index);
    let before = random.one(&ROOMS)();
    let mut world = before.clone();
    let mutations = mutate(&mut world, &mut random);
    // Half of the photographs show the scene before its mutations.
    let shown = if index.is_multiple_of(2) { &world } else { &before };
    let taken = take(shown, folder, &mut random)?;
    let project = project(&world, &taken, folder, &mut random)?;
    let edits = edits(&world, &mut random);
    let mut given = world.scene;
    if random.once_in(2) {
        let unknown = Material::diffuse(Rgb::splat(0.5));
        given.groups.iter_mut().for_each(|group| group.material = unknown.clone());
    }
    let Ok(scene) = gltf::to_glb(&given) else { return Ok(None) };
    fs::write(folder.join("scene.glb"), scene)?;
    fs::write(folder.join("project.toml"), project.to_string())?;
    fs::write(folder.join("edit.toml"), edits.to_string())?;
    let commands = commands(&mut random);
    let text: String =
        commands.iter().map(|words| format!("unrender {}\n", words.join(" "))).collect();
    fs::write(folder.join("commands.txt"), text)?;
    Ok(Some(Case { mutations, commands }))
}

/// The command lines for the files of a case.
fn commands(random: &mut Random) -> Vec<Vec<String>> {
    let split = |words: &str| words.split(' ').map(str::to_owned).collect::<Vec<_>>();
    let mut recover = split("recover project.toml --out recovered --effort draft --spp 1 --quiet");
    recover.extend(flags(random).into_iter().map(str::to_owned));
    let mut restage = split("restage edit.toml --out restaged --spp 4 --quiet");
    if random.once_in(2) {
        restage.push("--composite".into());
    }
    vec![split("check project.toml --out check.png"), recover, restage]
}
