//! A recovery through the library alone: no command, no file, no terminal. The same tests run without the crate's
//! features: `cargo test --release -p unrender --no-default-features --test library`.

// The parts of the shared code that need no command.
#[path = "../kit/coloured_room.rs"]
mod coloured_room;
#[allow(dead_code)]
#[path = "../kit/meshes.rs"]
mod meshes;

use coloured_room::{EXPOSURE, codes, room};
use glam::{Vec2, Vec3};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use unrender::engine::{self, Asked, Follower, Recovered};
use unrender::job::{InMemory, Job};
use unrender::project::Project;
use unrender::recover::{Effort, IterationRecord, Observer, Options};
use unrender::scene::{Camera, Depth, Picture, Rgb};

/// The room, photographed by `camera` with this `gamma`; the project states `response`.
fn job(camera: &Camera, size: (usize, usize), gamma: f32, response: &str) -> Job {
    let scene = room();
    let photo = codes(&scene, camera, size, (gamma, None));
    let photo = photo.map(|code| (255.0 * code.clamp(Rgb::ZERO, Rgb::ONE)).round() / 255.0);
    let text = format!(
        "scene = \"scene.glb\"\nphoto = \"photo.png\"\nexposure = {EXPOSURE}\n\
         response = {response}\n[groups.back]\nknown = {{ rho_d = 0.7 }}\n"
    );
    let (project, warnings) = Project::parse(Path::new("project.toml"), &text).unwrap();
    let photo = Some(Picture::new(photo, Depth::Eight));
    let given = InMemory { scene: Some(scene), photo, mask: None };
    let mut job = Job::assemble(project, warnings, given).unwrap();
    // Their reflectances are unknown, not given.
    for group in job.scene.groups.iter_mut().filter(|group| group.name != "back") {
        group.material.rho_d = Rgb::ZERO;
    }
    job
}

/// A quick recovery of `job`.
fn draft(job: &mut Job, follower: &mut dyn Follower) -> Recovered {
    let usual = Asked::of(job);
    let options = Options { effort: Effort::Draft, spp: 4, ..usual.options.clone() };
    engine::recover(job, &Asked { options, ..usual }, follower).unwrap()
}

/// The largest error of a reflectance.
fn worst(recovered: &Recovered) -> f32 {
    let groups = &recovered.recovery.groups;
    let found = |name: &str| groups.iter().find(|group| group.name == name).unwrap();
    coloured_room::worst(|name| found(name).material.rho_d)
}

/// Records the messages.
#[derive(Default)]
struct Heard {
    shares: Vec<f64>,
    working: AtomicUsize,
    warnings: Mutex<Vec<String>>,
}

impl Observer for Heard {
    fn iteration(&mut self, record: &IterationRecord) {
        self.shares.push(record.done);
    }

    fn working(&self, _: &str, _: f64) {
        self.working.fetch_add(1, Ordering::Relaxed);
    }
}

impl Follower for Heard {
    fn warning(&self, sentence: &str) {
        self.warnings.lock().unwrap().push(sentence.to_owned());
    }
}

#[test]
fn an_automatic_response_is_found() {
    let camera = room().cameras[0].clone();
    let mut job = job(&camera, (72, 60), 1.8, "\"auto\"");
    let mut heard = Heard::default();
    let recovered = draft(&mut job, &mut heard);
    let file = recovered.materials(&job);
    let photograph = file.photograph.as_ref().unwrap();
    let (gamma, std) = (photograph.gamma.unwrap(), photograph.std.as_ref().unwrap());
    let std = std.gamma.unwrap();
    assert!(std < 0.01 && (gamma - 1.8).abs() <= 3.0 * std, "{gamma}, std {std}");
    assert!(worst(&recovered) < 0.01, "{}", worst(&recovered));
    let floor = recovered.scene(&job).groups[0].material.rho_d;
    assert_eq!(file.groups["floor"].rho_d, Some(floor.to_array()));
    // The shares are of all rounds together.
    assert!(heard.shares.is_sorted() && heard.shares.len() > recovered.recovery.iterations.len());
    assert!(heard.shares.iter().all(|share| (0.0..=1.0).contains(share)), "{:?}", heard.shares);
    assert!(heard.working.into_inner() > 0);
}

#[test]
fn a_camera_that_stands_elsewhere_is_found() {
    let given = room().cameras[0].clone();
    let (eye, target) = (Vec3::new(0.1, 0.0, 2.6), Vec3::new(0.024, -0.066, 0.0));
    let truth = Camera::look_at("camera", eye, target, Vec3::Y, 0.9);
    let mut job = job(&truth, (144, 120), 2.2, "{ gamma = 2.2 }");
    let mut heard = Heard::default();
    let recovered = draft(&mut job, &mut heard);
    let found = recovered.camera(&job);
    // How far the back wall's middle moves in the picture, pixels.
    let off = |camera: &Camera| {
        let at = |camera: &Camera| Vec2::from(camera.project(Vec3::NEG_Z, 144, 120).unwrap());
        at(camera).distance(at(&truth))
    };
    assert!(off(&given) > 1.0 && off(&found) < 0.5, "{} and {}", off(&given), off(&found));
    let warnings = heard.warnings.into_inner().unwrap();
    assert!(warnings.iter().any(|w| w.contains("the camera was moved there")), "{warnings:?}");
    let rerendered = recovered.rerendered();
    assert_eq!((rerendered.width(), rerendered.height()), (144, 120));
    assert!(worst(&recovered) < 0.02, "{}", worst(&recovered));
}
