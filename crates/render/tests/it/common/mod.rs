//! What the proofs share: small scenes, random numbers without strata, and the comparison of two
//! estimates by their own noise.

// Not all of it is always in use.
#![allow(dead_code)]

use glam::{DVec3, Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use unrender_render::sampler::mix;
use unrender_render::{Film, Settings, Tracer};
use unrender_scene::{Camera, Group, Light, LightKind, Material, Mesh, Object, Rgb, Scene};

/// A scene under construction.
#[derive(Default)]
pub(crate) struct Stage {
    pub(crate) scene: Scene,
}

impl Stage {
    /// Adds a group and returns its index.
    pub(crate) fn group(&mut self, material: Material, emission: Rgb) -> usize {
        let name = format!("group {}", self.scene.groups.len());
        self.scene.groups.push(Group { name, material, emission });
        self.scene.groups.len() - 1
    }

    pub(crate) fn mesh(&mut self, group: usize, mesh: Mesh) {
        let name = format!("object {}", self.scene.objects.len());
        self.scene.objects.push(Object { name, group, mesh });
    }

    pub(crate) fn light(&mut self, kind: LightKind) {
        self.scene.lights.push(Light { name: "light".into(), kind });
    }

    /// A flat polygon with four corners, counter-clockwise seen from the front.
    pub(crate) fn quad(&mut self, group: usize, corners: [Vec3; 4]) {
        self.mesh(group, quad_mesh(corners, &[]));
    }

    /// A rectangle around `centre` that faces along `x` cross `y`.
    pub(crate) fn plate(&mut self, group: usize, centre: Vec3, x: Vec3, y: Vec3) {
        self.quad(group, plate_corners(centre, x, y));
    }

    /// The six walls of a box around the origin; they face inwards.
    pub(crate) fn room(&mut self, group: usize, half: Vec3) {
        for axis in 0..3 {
            let unit = |i: usize| Vec3::AXES[i % 3] * half[i % 3];
            let (x, y, z) = (unit(axis + 1), unit(axis + 2), unit(axis));
            self.plate(group, -z, x, y);
            self.plate(group, z, y, x);
        }
    }

    /// A smooth sphere that faces outwards.
    pub(crate) fn sphere(&mut self, group: usize, centre: Vec3, radius: f32, steps: usize) {
        let mut mesh = Mesh::default();
        let columns = 2 * steps;
        for i in 0..=steps {
            for j in 0..columns {
                let (theta, phi) = (PI * i as f32 / steps as f32, TAU * j as f32 / columns as f32);
                let normal =
                    Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos());
                mesh.positions.push(centre + radius * normal);
                mesh.normals.push(normal);
            }
        }
        let at = |i: usize, j: usize| (i * columns + j % columns) as u32;
        for i in 0..steps {
            for j in 0..columns {
                mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        self.mesh(group, mesh);
    }

    pub(crate) fn tracer(&self) -> Tracer {
        let mut scene = self.scene.clone();
        scene.validate().expect("a test scene is sound");
        Tracer::new(&scene)
    }

    pub(crate) fn render(&self, camera: &Camera, side: usize, settings: Settings) -> Film {
        let materials = self.scene.materials();
        self.tracer().render(&materials, camera, (side, side), &settings, &|_| ())
    }
}

pub(crate) fn plate_corners(centre: Vec3, x: Vec3, y: Vec3) -> [Vec3; 4] {
    [centre - x - y, centre + x - y, centre + x + y, centre - x + y]
}

pub(crate) fn quad_mesh(corners: [Vec3; 4], uvs: &[Vec2]) -> Mesh {
    Mesh::flat(&corners, uvs, &[[0, 1, 2], [0, 2, 3]])
}

/// A camera at `eye` that looks at `target`; +y is up where that can be, else -z.
pub(crate) fn camera(eye: Vec3, target: Vec3, fov_y_rad: f32) -> Camera {
    let vertical = (target - eye).cross(Vec3::Y).length() < 1e-6;
    let up = if vertical { Vec3::NEG_Z } else { Vec3::Y };
    Camera::look_at("camera", eye, target, up, fov_y_rad)
}

pub(crate) fn settings(spp: u32) -> Settings {
    Settings { spp, seed: 1, ..Settings::default() }
}

/// Independent uniform numbers: stratified ones would flatter a chi-squared test.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(mix(seed))
    }

    /// A number in [0, 1).
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        (mix(self.0) >> 40) as f32 / (1u32 << 24) as f32
    }

    pub(crate) fn next3(&mut self) -> [f32; 3] {
        [self.next(), self.next(), self.next()]
    }

    pub(crate) fn rgb(&mut self, lower: f32, upper: f32) -> Rgb {
        Vec3::from_array(self.next3()) * (upper - lower) + lower
    }
}

/// A mean with the standard deviation of its noise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    pub(crate) mean: DVec3,
    pub(crate) sigma: DVec3,
}

impl Estimate {
    pub(crate) fn exactly(mean: Rgb) -> Self {
        Self { mean: mean.as_dvec3(), sigma: DVec3::ZERO }
    }

    /// The mean over a picture.
    pub(crate) fn of_film(film: &Film) -> Self {
        let n = film.mean.pixels().len() as f64;
        let mean: DVec3 = film.mean.pixels().iter().map(|p| p.as_dvec3()).sum();
        let variance: DVec3 = film.variance.pixels().iter().map(|p| p.as_dvec3()).sum();
        Self { mean: mean / n, sigma: variance.map(f64::sqrt) / n }
    }

    /// The mean of samples that are independent, or better spread than that.
    pub(crate) fn of_samples(samples: &[DVec3]) -> Self {
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<DVec3>() / n;
        let squares = samples.iter().map(|s| (s - mean) * (s - mean)).sum::<DVec3>();
        Self { mean, sigma: (squares / (n * (n - 1.0))).map(f64::sqrt) }
    }

    /// The largest distance to `other` over the channels, in standard deviations.
    pub(crate) fn z(&self, other: &Self) -> f64 {
        let sigma = self.sigma.map(|s| s * s) + other.sigma.map(|s| s * s);
        ((self.mean - other.mean) / sigma.map(f64::sqrt)).abs().max_element()
    }
}

/// Fails unless both agree within 4.5 standard deviations (and the rounding of single precision),
/// or if the noise is too large for that to say much: above the share `noise_max` of the value.
#[track_caller]
pub(crate) fn assert_agree(what: &str, found: Estimate, expected: Estimate, noise_max: f64) {
    for channel in 0..3 {
        let (a, b) = (found.mean[channel], expected.mean[channel]);
        let sigma = found.sigma[channel].hypot(expected.sigma[channel]);
        assert!(
            sigma <= noise_max * b.abs(),
            "{what}, channel {channel}: noise of {sigma} in {b} says too little"
        );
        assert!(
            (a - b).abs() <= 4.5 * sigma + 3e-5 * b.abs(),
            "{what}, channel {channel}: {a} is not {b}; noise {sigma}"
        );
    }
}
