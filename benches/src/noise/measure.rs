//! Renders one scene twice, and measures the noise.

use super::statistics::Noise;
use crate::Failure;
use serde::{Deserialize, Serialize};
use std::time::Instant;
use unrender::render::{Integrator, NOTHING, Settings, Tracer};
use unrender::scene::{Camera, RgbImage, Scene};

/// Groups of fewer pixels have no row. At half of it the noise of a group is known only to a tenth, at double many
/// things in pictures of this size have no row.
const LEAST: usize = 100;
/// Each pixel is divided into this many parts across and down, to find lamps in a part of it: the edge of a lamp
/// within a pixel is noise of the camera's samples, not of the light. At half of it thin edges are missed, at double
/// no more pixels are found.
const PARTS: usize = 4;

/// A scene with its true materials, and its camera.
pub(crate) struct Shot {
    /// The scene.
    pub(crate) scene: Scene,
    /// The camera.
    pub(crate) camera: Camera,
    /// Width and height of the picture, pixels.
    pub(crate) size: (usize, usize),
}

/// The number of paths of a pixel, and their seed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Paths {
    /// Paths per pixel.
    pub(super) spp: u32,
    /// The seed of both pictures.
    pub(super) seed: u64,
}

impl Paths {
    /// The settings of both pictures: independent paths, and different random numbers.
    pub(super) fn of_both(self) -> [Settings; 2] {
        let first = self.seed.wrapping_mul(2);
        [first, first.wrapping_add(1)].map(|seed| Settings {
            spp: self.spp,
            seed,
            integrator: Integrator::Path,
            ..Settings::default()
        })
    }
}

/// The noise of a scene, as it is printed and saved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct SceneNoise {
    /// Width and height of the pictures, pixels.
    pub(super) size: [usize; 2],
    /// Paths per pixel.
    pub(super) spp: u32,
    /// The seed of both pictures.
    pub(super) seed: u64,
    /// Seconds of one rendering, the mean of both.
    pub(super) seconds: f64,
    /// Of all pixels that are used.
    pub(super) picture: Noise,
    /// The groups with enough pixels, in the scene's order.
    pub(super) groups: Vec<GroupNoise>,
}

/// The noise of one group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct GroupNoise {
    /// Its name.
    pub(super) name: String,
    /// The noise of the pixels whose centre shows it.
    pub(super) noise: Noise,
}

impl SceneNoise {
    /// Paths from the camera per second.
    pub(super) fn speed(&self) -> f64 {
        let [width, height] = self.size;
        (width * height) as f64 * f64::from(self.spp) / self.seconds
    }
}

/// The data of both pictures for further questions.
pub(super) struct Pictures {
    /// The scene, prepared.
    pub(super) tracer: Tracer,
    /// The group of each pixel that is used.
    pub(super) group_of: Vec<Option<usize>>,
    /// The value of each pixel in both pictures.
    pub(super) values: Vec<[f64; 2]>,
}

/// Renders a scene twice. A pixel's value is the mean of the three channels: a recovery fits all three equally,
/// and luminance would hide the noise of blue light.
///
/// # Errors
/// If the scene cannot be rendered.
pub(super) fn measure(shot: &Shot, paths: Paths) -> Result<(SceneNoise, Pictures), Failure> {
    let tracer = Tracer::try_new(&shot.scene)?;
    let materials = shot.scene.materials();
    let mut seconds = 0.0;
    let [a, b] = paths.of_both().map(|settings| {
        let started = Instant::now();
        let film = tracer.render(&materials, &shot.camera, shot.size, &settings, &|_| {});
        seconds += 0.5 * started.elapsed().as_secs_f64();
        values(&film.mean)
    });
    let group_of = group_of(shot, &tracer);
    let pictures =
        Pictures { tracer, group_of, values: a.into_iter().zip(b).map(<[f64; 2]>::from).collect() };
    let groups = shot.scene.groups.iter().enumerate().map(|(index, group)| GroupNoise {
        name: group.name.clone(),
        noise: pictures.noise(|shown| shown == index),
    });
    let noise = SceneNoise {
        size: shot.size.into(),
        spp: paths.spp,
        seed: paths.seed,
        seconds,
        picture: pictures.noise(|_| true),
        groups: groups.filter(|group| group.noise.pixels >= LEAST).collect(),
    };
    Ok((noise, pictures))
}

impl Pictures {
    /// The mean value of the pixels that are used.
    pub(super) fn mean(&self) -> f64 {
        self.noise(|_| true).mean
    }

    /// The noise of the pixels that are used and whose group `is_wanted`.
    fn noise(&self, is_wanted: impl Fn(usize) -> bool) -> Noise {
        let pixels = self.group_of.iter().zip(&self.values);
        let pixels = pixels.filter(|(group, _)| group.is_some_and(&is_wanted));
        Noise::of(&pixels.map(|(_, values)| *values).collect::<Vec<_>>())
    }
}

/// The mean of the channels of each pixel.
fn values(picture: &RgbImage) -> Vec<f64> {
    picture.pixels().iter().map(|pixel| pixel.as_dvec3().element_sum() / 3.0).collect()
}

/// The group that each pixel's centre shows; none if it shows nothing, or if a part of it shows a lamp.
fn group_of(shot: &Shot, tracer: &Tracer) -> Vec<Option<usize>> {
    let (width, height) = shot.size;
    let parts = tracer.geometry(&shot.camera, PARTS * width, PARTS * height);
    let emits = |group: u32| group != NOTHING && shot.scene.groups[group as usize].is_emitter();
    let shows_lamp = |x: usize, y: usize| {
        let mut of_pixel =
            (0..PARTS * PARTS).map(|i| (PARTS * x + i % PARTS, PARTS * y + i / PARTS));
        of_pixel.any(|(x, y)| emits(parts.at(x, y).group))
    };
    let centres = tracer.geometry(&shot.camera, width, height);
    let of_pixel = |(index, centre): (usize, &unrender::render::PixelGeometry)| {
        let counts = centre.group != NOTHING
            && !emits(centre.group)
            && !shows_lamp(index % width, index / width);
        counts.then_some(centre.group as usize)
    };
    centres.pixels().iter().enumerate().map(of_pixel).collect()
}
