//! `unrender init`: from a scene and a photograph to a project.

use crate::check::Checkup;
use crate::global::Global;
use crate::proposed::{self, Proposed};
use crate::shell_word::quoted;
use crate::{Error, output};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use unrender_formats::{FileError, Kind};

/// Makes a project file for a scene and a photograph.
///
/// Reads both, chooses camera, response, exposure and BRDF by what they say, and marks what it had to guess. It changes no
/// file, and replaces none.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender init room.glb photo.jpg\n  \
    unrender init room/scene.xml room/photo.exr --out room/project.toml")]
pub struct Args {
    /// The scene: glTF, OBJ, Mitsuba 3 or PBRT.
    pub scene: PathBuf,
    /// The photograph.
    pub photo: PathBuf,
    /// The project file to write.
    #[arg(long, value_name = "FILE.toml", default_value = "project.toml")]
    pub out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// If a file cannot be read, or the project cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    output::check_file(&args.out, &["toml"], "end the name of the project in .toml")?;
    proposed::is_free(&args.out)?;
    if Kind::of(&args.scene) == Some(Kind::Picture) {
        let problem = "is a picture; name the scene first, and then the photo";
        return Err(FileError::new(&args.scene, problem).into());
    }
    let proposed = proposed::propose(&args.scene, &args.photo, &args.out, global.limits())?;
    proposed::write(&proposed.text, &args.out)?;
    global.console.print(&summary(&proposed, &args.out));
    Ok(ExitCode::SUCCESS)
}

/// What was written, what was guessed, what looks wrong, and what to do next.
fn summary(proposed: &Proposed, out: &Path) -> String {
    let path = out.display();
    let mut text = format!("{path} is written.\n");
    let listed = |text: &mut String, heading: &str, sentences: &[String]| {
        if !sentences.is_empty() {
            text.push_str(&format!("\n{heading}:\n"));
            sentences.iter().for_each(|sentence| text.push_str(&format!("- {sentence}\n")));
        }
    };
    listed(&mut text, "Guessed", &proposed.guesses);
    let grave = |checkup: &Checkup| checkup.warnings.0[..checkup.grave].to_vec();
    let grave = proposed.checkup.as_ref().map(grave).unwrap_or_default();
    listed(&mut text, "Looks wrong", &grave);
    let word = |path: &Path| quoted(&path.to_string_lossy());
    let (project, folder) = (word(out), word(&out.with_extension("")));
    let next = [
        (format!("unrender check {project}"), "draws the model's edges over the photo"),
        (format!("unrender recover {project} --out {folder} --effort draft"), "a first result"),
    ];
    text.push_str("\nNext:\n");
    let wide = next.iter().map(|(command, _)| command.len()).max().unwrap_or(0);
    for (command, what) in next {
        text.push_str(&format!("  {command:wide$}  # {what}\n"));
    }
    text
}
