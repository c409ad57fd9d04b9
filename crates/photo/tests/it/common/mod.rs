//! An independent implementation of the camera, in double precision by docs/reference/conventions.md, and
//! measured points with known errors.

use glam::{DVec2, DVec3};
use unrender_formats::points::Pair;

/// Width and height of all pictures here, pixels.
pub(crate) const SIZE: (usize, usize) = (1600, 1200);

/// What made the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truth {
    pub(crate) eye: DVec3,
    pub(crate) target: DVec3,
    /// By how much the right side of the camera is raised, radians.
    pub(crate) roll: f64,
    pub(crate) focal: f64,
    /// Pixels from the picture's centre, right and down.
    pub(crate) principal_point: DVec2,
    pub(crate) k: [f64; 2],
}

impl Truth {
    pub(crate) fn pinhole(eye: [f64; 3], target: [f64; 3], focal: f64) -> Self {
        let (eye, target) = (eye.into(), target.into());
        Self { eye, target, roll: 0.0, focal, principal_point: DVec2::ZERO, k: [0.0; 2] }
    }

    /// Right, up and forward, world space.
    pub(crate) fn axes(&self) -> [DVec3; 3] {
        let forward = (self.target - self.eye).normalize();
        let level = forward.cross(DVec3::Y).normalize();
        let above = level.cross(forward);
        let (sin, cos) = self.roll.sin_cos();
        [cos * level + sin * above, cos * above - sin * level, forward]
    }

    /// Where the point is seen, pixels from the top left corner; none behind the camera.
    pub(crate) fn pixel(&self, point: DVec3) -> Option<DVec2> {
        let [right, up, forward] = self.axes();
        let way = point - self.eye;
        let depth = way.dot(forward);
        let plane = DVec2::new(way.dot(right), -way.dot(up)) / depth;
        let r2 = plane.length_squared();
        let bent = plane * (1.0 + self.k[0] * r2 + self.k[1] * r2 * r2);
        let centre = 0.5 * DVec2::new(SIZE.0 as f64, SIZE.1 as f64) + self.principal_point;
        (depth > 0.0).then(|| self.focal * bent + centre)
    }

    /// Whether the picture shows the point.
    pub(crate) fn shows(&self, point: DVec3) -> bool {
        self.pixel(point).is_some_and(|p| {
            (0.0..SIZE.0 as f64).contains(&p.x) && (0.0..SIZE.1 as f64).contains(&p.y)
        })
    }

    /// The points as seen, with normal errors of `sigma` pixels.
    pub(crate) fn pairs(&self, points: &[DVec3], sigma: f64, random: &mut Random) -> Vec<Pair> {
        let pair = |(index, point): (usize, &DVec3)| {
            let error = sigma * DVec2::new(random.normal(), random.normal());
            let pixel = self.pixel(*point).expect("the point is in front") + error;
            Pair { name: format!("p{index}"), pixel: pixel.into(), point: (*point).into() }
        };
        points.iter().enumerate().map(pair).collect()
    }
}

/// Random numbers, the same in every run.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Evenly from zero to one.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (self.0 ^ (self.0 >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((mixed ^ (mixed >> 32)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A standard normal deviate, after Box and Muller.
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }
}
