//! The errors of the model or of the photograph: one dial each.
//!
//! The photograph shows the true scene. The model that the recovery uses has the error.

use super::dice::Dice;
use super::generate::Plan;
use clap::ValueEnum;
use glam::{Affine3A, Vec3};
use serde::{Deserialize, Serialize};
use unrender::scene::{Camera, Rgb, RgbImage};

/// An error of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Dial {
    /// The model is exact.
    Exact,
    /// The camera looks past its target by 0.2 % of the picture's width.
    Camera,
    /// An object that the photograph shows is missing.
    Missing,
    /// A lamp's sides are 10 % too long, at the same radiance.
    Lamp,
    /// A box has no bevel.
    Bevel,
}

/// The camera's error, widths of the picture: half a pixel of 240.
const CAMERA_SHIFT: f32 = 0.002;
/// The factor on the sides of a lamp.
const LAMP_LARGER: f32 = 1.1;

impl Dial {
    /// All of them.
    pub(crate) const ALL: [Self; 5] =
        [Self::Exact, Self::Camera, Self::Missing, Self::Lamp, Self::Bevel];

    /// The name in file names and on the page.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Camera => "camera",
            Self::Missing => "missing",
            Self::Lamp => "lamp",
            Self::Bevel => "bevel",
        }
    }

    /// The file of the model with this error.
    pub(crate) fn scene_file(self) -> String {
        if self == Self::Exact { "scene.glb".into() } else { format!("scene_{}.glb", self.name()) }
    }

    /// The error that the seed chooses: none in half of the scenes.
    pub(crate) fn of_seed(plan: &Plan) -> Self {
        let mut dice = Dice::new(plan.seed, "dial");
        if dice.chance(0.5) {
            return Self::Exact;
        }
        let able: Vec<Self> =
            Self::ALL.into_iter().skip(1).filter(|dial| dial.spoilt(plan).is_some()).collect();
        able[dice.index(able.len())]
    }

    /// The model with this error; none if the scene has no object for it.
    pub(crate) fn spoilt(self, plan: &Plan) -> Option<Plan> {
        let mut dice = Dice::new(plan.seed, "spoilt");
        let mut plan = plan.clone();
        match self {
            Self::Exact => {}
            Self::Camera => plan.cameras[0] = shifted(&plan.cameras[0], &mut dice),
            Self::Missing => {
                let shared = |index: &usize| {
                    let group = plan.things[*index].group;
                    plan.things.iter().filter(|thing| thing.group == group).count() > 1
                };
                // A group keeps one of its objects; otherwise it could not be recovered.
                let able: Vec<usize> = (0..plan.things.len()).filter(shared).collect();
                if able.is_empty() {
                    return None;
                }
                plan.things.remove(able[dice.index(able.len())]);
            }
            Self::Lamp => {
                let count = plan.lights.lamps.len();
                let lamp = plan.lights.lamps.get_mut(dice.index(count))?;
                enlarge(&mut lamp.mesh.positions);
            }
            Self::Bevel => {
                let able: Vec<usize> =
                    (0..plan.things.len()).filter(|&i| plan.things[i].sharp.is_some()).collect();
                let &index = able.get(dice.index(able.len()))?;
                plan.things[index].mesh = plan.things[index].sharp.take()?;
            }
        }
        Some(plan)
    }
}

/// The camera turned so that the picture moves by [`CAMERA_SHIFT`] in a random direction.
fn shifted(camera: &Camera, dice: &mut Dice) -> Camera {
    let width = 2.0 * (0.5 * camera.fov_y_rad).tan() * camera.aspect.unwrap_or(1.0);
    let angle = (CAMERA_SHIFT * width).atan();
    let (sin, cos) = dice.range(0.0, std::f32::consts::TAU).sin_cos();
    let turn = Affine3A::from_axis_angle(Vec3::new(sin, cos, 0.0), angle);
    Camera { world_from_camera: camera.world_from_camera * turn, ..camera.clone() }
}

/// Makes a lamp larger about its centre; flat ones stay in their plane.
fn enlarge(positions: &mut [Vec3]) {
    let mean = positions.iter().sum::<Vec3>() / positions.len().max(1) as f32;
    positions.iter_mut().for_each(|p| *p = mean + LAMP_LARGER * (*p - mean));
}

/// The linear picture with the noise of a camera: shot noise of `at_grey` relative to middle grey,
/// which an exposure of `exposure` shows as 0.18.
pub(crate) fn with_noise(picture: &RgbImage, seed: u64, at_grey: f32, exposure: f32) -> RgbImage {
    const GREY: f32 = 0.18;
    let mut dice = Dice::new(seed, "noise");
    let level = at_grey * at_grey * GREY * exposure;
    picture.map(|radiance| {
        let noisy = |value: f32, normal: f32| value + (level * value.max(0.0)).sqrt() * normal;
        Rgb::new(
            noisy(radiance.x, dice.normal()),
            noisy(radiance.y, dice.normal()),
            noisy(radiance.z, dice.normal()),
        )
    })
}

/// Segments of round things in scenes of full size; a quarter as many in tiny ones.
pub(crate) fn segments(height: usize) -> u32 {
    if height >= 120 { 96 } else { 24 }
}
