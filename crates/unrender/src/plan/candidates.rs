//! The photographs that may be taken next.

use super::RecoveredJob;
use glam::{Quat, Vec3};
use unrender_render::NOTHING;
use unrender_scene::Camera;

/// A photograph that could be taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Its name: a camera of the scene, "30 degrees to the left", or "without LAMP".
    pub name: String,
    /// Its camera.
    pub camera: Camera,
    /// The sources of light that are off, as [`crate::Job::off`] counts them.
    pub off: Vec<u32>,
}

/// The ring of cameras around the target of the first one: degrees to the right, and upwards. Half of the steps are
/// nearer to the existing photograph, double of them stand behind what it shows; neither was tried.
const RING: [(f32, f32); 6] =
    [(-60.0, 0.0), (-30.0, 0.0), (30.0, 0.0), (60.0, 0.0), (0.0, 25.0), (0.0, -15.0)];
/// The least share of pixels of a camera on the ring that show something, and the largest share nearer than a
/// quarter of its distance: otherwise it stands in a wall or behind an object. Half and double of them were not
/// tried.
const SEEN_MIN: f32 = 0.8;
const NEAR_MAX: f32 = 0.2;
const NEAR: f32 = 0.25;
/// The test rendering from there has this many times fewer pixels along both sides.
const COARSE: usize = 8;

/// The scene's cameras that took none of the photographs, a ring of cameras about what the first photograph shows, and
/// that photograph again with each of several lamps off.
pub fn candidates(of: &RecoveredJob) -> Vec<Candidate> {
    let mut all = of_scene(of);
    all.extend(ring(of));
    all.extend(switched(of));
    all
}

fn of_scene(of: &RecoveredJob) -> Vec<Candidate> {
    let photographs = (0..of.job.photographs()).map(|k| of.job.alone(k).camera.clone());
    let taken: Vec<Camera> = photographs.collect();
    let is_new = |camera: &&Camera| {
        !taken.iter().any(|t| t.world_from_camera.abs_diff_eq(camera.world_from_camera, 1e-4))
    };
    let cameras = of.job.scene.cameras.iter().filter(is_new);
    let candidate = |camera: &Camera| Candidate {
        name: format!("camera \"{}\"", camera.name),
        camera: camera.clone(),
        off: of.job.off.clone(),
    };
    cameras.map(candidate).collect()
}

/// The middle of what the first photograph shows.
fn centre(of: &RecoveredJob) -> Option<Vec3> {
    let camera = &of.registered[0].camera;
    let (width, height) = size(of);
    let seen = of.tracer.geometry(camera, width, height);
    let points = seen.pixels().iter().enumerate().filter(|(_, pixel)| pixel.group != NOTHING);
    let point = |(index, depth): (usize, f32)| {
        let (x, y) = ((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
        camera.origin() + depth * camera.direction(x, y, width, height)
    };
    let points: Vec<Vec3> = points.map(|(index, pixel)| point((index, pixel.depth))).collect();
    (!points.is_empty()).then(|| points.iter().copied().sum::<Vec3>() / points.len() as f32)
}

/// The size of a test rendering: an eighth of the photograph along both sides.
fn size(of: &RecoveredJob) -> (usize, usize) {
    let photo = &of.job.photo.radiance;
    ((photo.width() / COARSE).max(8), (photo.height() / COARSE).max(8))
}

fn ring(of: &RecoveredJob) -> Vec<Candidate> {
    let Some(centre) = centre(of) else { return Vec::new() };
    let first = &of.registered[0].camera;
    let arm = first.origin() - centre;
    let up = of.job.scene.up.unit();
    let right = first.world_from_camera.transform_vector3(Vec3::X).normalize();
    let place = |&(aside, upwards): &(f32, f32)| {
        let turn = Quat::from_axis_angle(up, aside.to_radians())
            * Quat::from_axis_angle(right, -upwards.to_radians());
        let (name, angle) = match (aside, upwards) {
            (a, _) if a > 0.0 => ("to the right", a),
            (a, _) if a < 0.0 => ("to the left", -a),
            (_, u) if u > 0.0 => ("higher", u),
            (_, u) => ("lower", -u),
        };
        let eye = centre + turn * arm;
        let camera = Camera::look_at("plan", eye, centre, up, first.fov_y_rad);
        let camera = Camera { aspect: first.aspect, ..camera };
        let name = format!("{angle:.0} degrees {name}");
        Candidate { name, camera, off: of.job.off.clone() }
    };
    RING.iter().map(place).filter(|candidate| stands_free(of, candidate, arm.length())).collect()
}

/// Whether the camera of a candidate sees the scene from `distance` and nothing in its way.
fn stands_free(of: &RecoveredJob, candidate: &Candidate, distance: f32) -> bool {
    let (width, height) = size(of);
    let seen = of.tracer.geometry(&candidate.camera, width, height);
    let share = |is: &dyn Fn(f32) -> bool| {
        let pixels = seen.pixels().iter();
        let count = pixels.filter(|pixel| pixel.group != NOTHING && is(pixel.depth)).count();
        count as f32 / seen.pixels().len() as f32
    };
    share(&|_| true) >= SEEN_MIN && share(&|depth| depth < NEAR * distance) <= NEAR_MAX
}

fn switched(of: &RecoveredJob) -> Vec<Candidate> {
    let on: Vec<(&str, u32)> = of
        .job
        .scene
        .sources()
        .map(|source| (source.name, source.index as u32))
        .filter(|(_, index)| !of.job.off.contains(index))
        .collect();
    if on.len() < 2 {
        return Vec::new();
    }
    let candidate = |(name, index): (&str, u32)| Candidate {
        name: format!("from the same place, without \"{name}\""),
        camera: of.registered[0].camera.clone(),
        off: of.job.off.iter().copied().chain([index]).collect(),
    };
    on.into_iter().map(candidate).collect()
}
