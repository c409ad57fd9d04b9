//! The commands for the faults, with their inputs and their results without a fault.

use super::AS_COMMAND;
use super::rights::{Disk, User};
use super::state::{State, files_of};
use glam::{Vec2, Vec3};
use std::fs::{self, Permissions};
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;
use unrender::formats::{gltf, picture};
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Group, Material, Mesh, Object, Rgb, Scene};

/// The sides of the photograph, pixels: a recovery takes about a second.
const SIDE: usize = 24;

/// A command.
#[derive(Clone, Debug)]
pub(crate) struct Work {
    pub(crate) name: &'static str,
    /// Its arguments, and those that continue after a fault.
    pub(crate) words: Vec<String>,
    pub(crate) again: Vec<String>,
    /// The file or folder that it writes.
    pub(crate) out: &'static str,
    /// The arguments of a run before, which wrote something else there.
    before: Option<Vec<String>>,
    /// Its result without a fault, and that of the run before.
    pub(crate) new: State,
    pub(crate) old: Option<State>,
    /// Its time without a fault.
    pub(crate) seconds: f64,
    /// The size of its result, bytes.
    pub(crate) bytes: u64,
}

impl Work {
    fn new(name: &'static str, out: &'static str, words: &str, before: Option<&str>) -> Self {
        let words = split(words);
        Self {
            name,
            again: words.clone(),
            words,
            out,
            before: before.map(split),
            new: State::default(),
            old: None,
            seconds: 0.0,
            bytes: 0,
        }
    }

    /// The files in which `state` differs from the command's result.
    pub(crate) fn difference(&self, state: &State) -> String {
        self.new.difference(state).join(", ")
    }
}

fn split(words: &str) -> Vec<String> {
    words.split(' ').map(str::to_owned).collect()
}

/// All of them.
pub(crate) fn all() -> Vec<Work> {
    let recover = "recover ../in/p.toml --effort draft --spp 1 --out out";
    let restage = "restage --recovered ../in/base --height 24 --spp 256 --out out";
    let render = "render ../in/shown.glb --height 24 --spp 1024 --checkpoint c.exr --out a.exr";
    let gltf = "export ../in/base --to gltf --out a.glb";
    let with_resume = |mut work: Work| {
        work.again.push("--resume".into());
        work
    };
    vec![
        with_resume(Work::new("recover", "out", recover, Some(&format!("{recover} --seed 1")))),
        Work::new("restage", "out", restage, Some(&format!("{restage} --seed 1"))),
        Work::new(
            "render",
            "a.exr",
            render,
            Some("render ../in/shown.glb --height 24 --spp 1 --seed 1 --out a.exr"),
        ),
        Work::new(
            "merge",
            "a.exr",
            "merge ../in/part1.exr ../in/part2.exr --out a.exr",
            Some("render ../in/shown.glb --height 24 --spp 1 --seed 1 --out a.exr"),
        ),
        Work::new(
            "export",
            "a.glb",
            gltf,
            Some("export --scene ../in/scene.glb --to gltf --out a.glb"),
        ),
        Work::new("export-folder", "out", "export ../in/base --to mitsuba --out out", None),
    ]
}

/// The place of the runs: inputs in one folder, each command in a folder beside it.
pub(crate) struct Bench {
    root: PathBuf,
    program: PathBuf,
    pub(crate) user: User,
}

impl Bench {
    /// Makes the inputs.
    pub(crate) fn new(root: &Path) -> io::Result<Self> {
        let program = std::env::current_exe()?;
        let user = User::choose(&program, root)?;
        // Other users must be able to read it.
        fs::set_permissions(root, Permissions::from_mode(0o755))?;
        let bench = Self { root: root.to_owned(), program, user };
        let inputs = bench.inputs();
        fs::create_dir_all(&inputs)?;
        let scene = room();
        let glb = gltf::to_glb(&scene).map_err(io::Error::other)?;
        fs::write(inputs.join("scene.glb"), glb)?;
        let mut shown = scene.clone();
        shown.groups[0].material = Material::diffuse(Rgb::new(0.6, 0.4, 0.2));
        shown.groups[1].material = Material::isotropic(Rgb::splat(0.3), Rgb::splat(0.2), 0.15);
        let glb = gltf::to_glb(&shown).map_err(io::Error::other)?;
        fs::write(inputs.join("shown.glb"), glb)?;
        let settings = Settings { spp: 64, ..Settings::default() };
        let tracer = Tracer::new(&shown);
        let size = (SIDE, SIDE);
        let film = tracer.render(&shown.materials(), &shown.cameras[0], size, &settings, &|_| {});
        picture::write(&inputs.join("photo.png"), &film.mean).map_err(io::Error::other)?;
        let project =
            "scene = \"scene.glb\"\nphoto = \"photo.png\"\nexposure = 1\nresponse = \"srgb\"\n";
        fs::write(inputs.join("p.toml"), project)?;
        user.owns(&inputs)?;
        let render = "render shown.glb --height 24 --samples";
        for words in [
            "recover p.toml --effort draft --spp 1 --no-refine --out base".to_owned(),
            format!("{render} 0..4 --out part1.exr"),
            format!("{render} 4..8 --out part2.exr"),
        ] {
            bench.must(&inputs, &split(&words))?;
        }
        Ok(bench)
    }

    /// Whether there can be file systems of a few kilobytes.
    pub(crate) fn has_disks(&self) -> bool {
        self.case().is_ok_and(|folder| Disk::at(&folder).is_ok())
    }

    pub(crate) fn inputs(&self) -> PathBuf {
        self.root.join("in")
    }

    /// `unrender` with `words`, in `folder`.
    pub(crate) fn command(&self, folder: &Path, words: &[String]) -> Command {
        self.prepared_command(Command::new(&self.program), folder, words)
    }

    /// The same in its own session, without a terminal.
    pub(crate) fn in_session(&self, folder: &Path, words: &[String]) -> Command {
        let mut session = Command::new("setsid");
        session.arg("--wait").arg(&self.program).env_remove("TERM");
        self.prepared_command(session, folder, words)
    }

    fn prepared_command(&self, mut command: Command, folder: &Path, words: &[String]) -> Command {
        command.current_dir(folder).args(words).env(AS_COMMAND, "1").stdin(Stdio::null());
        self.user.runs(&mut command);
        command
    }

    fn must(&self, folder: &Path, words: &[String]) -> io::Result<()> {
        let output = self.command(folder, words).output()?;
        let said = String::from_utf8_lossy(&output.stderr);
        let failed = || io::Error::other(format!("unrender {}: {}", words.join(" "), said.trim()));
        if output.status.success() { Ok(()) } else { Err(failed()) }
    }

    /// `work` with its results without a fault.
    pub(crate) fn prepared(&self, work: Work) -> io::Result<Work> {
        let folder = self.root.join(format!("new-{}", work.name));
        fs::create_dir_all(&folder)?;
        self.user.owns(&folder)?;
        let started = Instant::now();
        self.must(&folder, &work.words)?;
        let seconds = started.elapsed().as_secs_f64();
        let new = State::of(&folder, work.out)?;
        let bytes = files_of(&folder)?.iter().map(|(_, bytes)| bytes.len() as u64).sum();
        let old = match &work.before {
            None => None,
            Some(words) => {
                let folder = self.root.join(format!("old-{}", work.name));
                fs::create_dir_all(&folder)?;
                self.user.owns(&folder)?;
                self.must(&folder, words)?;
                Some(State::of(&folder, work.out)?)
            }
        };
        Ok(Work { new, old, seconds, bytes, ..work })
    }

    /// A folder for one run of a command.
    pub(crate) fn case(&self) -> io::Result<PathBuf> {
        let folder = self.root.join("case");
        fs::create_dir_all(&folder)?;
        Ok(folder)
    }

    /// Fills it with the result of a run before, or with nothing.
    pub(crate) fn fill(&self, folder: &Path, work: &Work, had_old: bool) -> io::Result<()> {
        if had_old {
            let from = self.root.join(format!("old-{}", work.name)).join(work.out);
            copy(&from, &folder.join(work.out))?;
        }
        self.user.owns(folder)
    }
}

fn copy(from: &Path, to: &Path) -> io::Result<()> {
    if !from.is_dir() {
        return fs::copy(from, to).map(drop);
    }
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        copy(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}

/// A floor, a wall and a lamp.
fn room() -> Scene {
    let quads = [
        ("floor", [[-1., 0., 1.], [1., 0., 1.], [1., 0., -1.], [-1., 0., -1.]], 0.0),
        ("wall", [[-1., 0., -1.], [1., 0., -1.], [1., 2., -1.], [-1., 2., -1.]], 0.0),
        ("lamp", [[-0.4, 2., -0.4], [0.4, 2., -0.4], [0.4, 2., 0.4], [-0.4, 2., 0.4]], 4.0),
    ];
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    let mut scene = Scene::default();
    for (group, (name, corners, emission)) in quads.into_iter().enumerate() {
        let mesh = Mesh::flat(&corners.map(Vec3::from_array), &uvs, &[[0, 1, 2], [0, 2, 3]]);
        scene.objects.push(Object { name: name.into(), group, mesh });
        let material = Material::diffuse(Rgb::ZERO);
        scene.groups.push(Group { name: name.into(), material, emission: Rgb::splat(emission) });
    }
    let (eye, target) = (Vec3::new(0.2, 1.4, 2.4), Vec3::new(0.0, 0.5, 0.0));
    let camera = Camera::look_at("camera", eye, target, Vec3::Y, 0.8);
    scene.cameras.push(Camera { aspect: Some(1.0), ..camera });
    scene
}
