//! How bright the sky is in each direction, by the functions of `gensky` and `gendaylit`, and skies as
//! environments.
//!
//! Near the horizon, sky and ground are blended: the weight of the sky is `(Dz + 1.01)^10`, that of the
//! ground one over it. [Radiance, `skybright.cal`, `perezlum.cal`; CIE S 003; Perez, Seals, Michalsky
//! 1993]

use super::motion::Motion;
use super::primitives::Primitive;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use unrender_scene::{Environment, Image, Rgb};

/// Rows of the panorama; a row is 0.7 degrees.
const ROWS: usize = 256;

/// A pixel is the mean of this many places along each side.
const FINER: usize = 2;

/// The most sources; each costs a tenth of a second.
const MAX_PARTS: usize = 64;

/// The light from all around by direction.
pub(super) type Panorama = Arc<Environment>;

/// The brightness of a sky by direction.
#[derive(Clone, Debug)]
pub(super) struct Sky {
    is_perez: bool,
    /// The numbers of the function, A1 first; as many as its formula needs.
    numbers: Vec<f64>,
    /// The motion that turned the sky.
    motion: Motion,
}

impl Sky {
    /// The sky that the pattern `p` describes, if it is one.
    pub(super) fn of(p: &Primitive) -> Option<Self> {
        let [name, file, motion @ ..] = p.strings.as_slice() else { return None };
        let file = file.rsplit(['/', '\\']).next().unwrap_or(file);
        let (is_perez, count) = match (name.as_str(), file) {
            ("skybr" | "skybright", "skybright.cal") => {
                let kind = p.reals.first().copied().filter(|kind| (1.0..=4.0).contains(kind))?;
                (false, if kind == 2.0 || kind == 3.0 { 3 } else { 7 })
            }
            ("skybright", "perezlum.cal") => (true, 10),
            _ => return None,
        };
        let motion = Motion::of_all(motion).ok()?;
        (p.kind == "brightfunc" && p.reals.len() == count).then(|| Self {
            is_perez,
            numbers: p.reals.clone(),
            motion,
        })
    }

    /// The factor of the source's radiance in `direction`.
    pub(super) fn at(&self, direction: DVec3) -> f64 {
        let d = self.motion.vector_before(direction).normalize_or_zero();
        let (sky, ground) = if self.is_perez { self.perez(d) } else { self.cie(d) };
        let above = (d.z + 1.01).powi(10);
        ((above * sky + ground / above) / (above + 1.0 / above)).max(0.0)
    }

    /// The cosine and the angle between `d` and the sun, whose direction begins at `at`.
    fn to_sun(&self, d: DVec3, at: usize) -> (f64, f64) {
        let cos = d.dot(DVec3::from_slice(&self.numbers[at..at + 3]));
        (cos, cos.clamp(-1.0, 1.0).acos())
    }

    fn cie(&self, d: DVec3) -> (f64, f64) {
        let [kind, zenith, ground] = [0, 1, 2].map(|k| self.numbers[k]);
        let shape = match kind as u8 {
            2 => (1.0 + 2.0 * d.z) / 3.0,
            3 => 1.0,
            1 => {
                let (cos, gamma) = self.to_sun(d, 4);
                let thick = if d.z > 0.01 { 1.0 - (-0.32 / d.z).exp() } else { 1.0 };
                (0.91 + 10.0 * (-3.0 * gamma).exp() + 0.45 * cos * cos) * thick / self.numbers[3]
            }
            _ => {
                let (_, gamma) = self.to_sun(d, 4);
                let [eta, zt] = [d.z, self.numbers[6]].map(|z| z.clamp(-1.0, 1.0).acos());
                let gradient =
                    (1.35 * (5.631 - 3.59 * eta).sin() + 3.12) * (4.396 - 2.6 * zt).sin() + 6.37
                        - eta;
                let halo = (-0.563 * gamma * ((2.629 - eta) * (1.562 - zt) + 0.812)).exp();
                gradient / 2.326 * halo / self.numbers[3]
            }
        };
        (zenith * shape, ground)
    }

    fn perez(&self, d: DVec3) -> (f64, f64) {
        let [norm, ground, a, b, c, e, f] = [0, 1, 2, 3, 4, 5, 6].map(|k| self.numbers[k]);
        let (cos, gamma) = self.to_sun(d, 7);
        let gradient = 1.0 + a * (b / d.z.max(0.01)).exp();
        (norm * gradient * (1.0 + c * (e * gamma).exp() + f * cos * cos), ground)
    }
}

/// A disk of light infinitely far away.
#[derive(Clone, Debug)]
pub(super) struct Disk {
    pub(super) direction: DVec3,
    /// Its angular diameter, degrees.
    pub(super) angle_deg: f64,
    pub(super) radiance: Rgb,
    pub(super) sky: Option<Sky>,
    /// What it shows; its radiance is a factor on that.
    pub(super) panorama: Option<Panorama>,
    /// Where glows overlap, the last is seen; where lights overlap, the first, in front of all glows.
    pub(super) is_glow: bool,
}

/// The environment of all `disks`, if there are any.
pub(super) fn environment(disks: &[Disk]) -> Result<Option<Environment>, String> {
    if disks.is_empty() {
        return Ok(None);
    }
    if disks.len() > MAX_PARTS {
        return Err(format!(
            "has more than {MAX_PARTS} sources that are more than 5 degrees across"
        ));
    }
    if let [Disk { radiance, panorama: Some(panorama), angle_deg, sky: None, .. }] = disks
        && *angle_deg >= 360.0
    {
        let mut around = Environment::clone(panorama);
        around.scale(*radiance);
        return Ok(Some(around));
    }
    let (lights, glows): (Vec<&Disk>, Vec<&Disk>) = disks.iter().partition(|disk| !disk.is_glow);
    let seen: Vec<&Disk> = lights.into_iter().chain(glows.into_iter().rev()).collect();
    let covers = |disk: &Disk, direction: DVec3| {
        direction.dot(disk.direction) >= (0.5 * disk.angle_deg).to_radians().min(PI).cos()
    };
    let radiance = |direction: DVec3| {
        let disk = seen.iter().find(|disk| covers(disk, direction));
        disk.map_or(Rgb::ZERO, |disk| {
            let shown = disk.panorama.as_ref().map(|around| around.radiance(direction.as_vec3()));
            let bright = disk.sky.as_ref().map_or(1.0, |sky| sky.at(direction)) as f32;
            disk.radiance * shown.unwrap_or(Rgb::ONE) * bright
        })
    };
    let step =
        |at: usize, k: usize, of: usize| (at as f64 + (k as f64 + 0.5) / FINER as f64) / of as f64;
    let pixel = |x: usize, y: usize| {
        let places =
            (0..FINER * FINER).map(|k| (step(x, k % FINER, 2 * ROWS), step(y, k / FINER, ROWS)));
        let sum: Vec3 = places.map(|(u, v)| radiance(direction(u, v))).sum();
        sum / (FINER * FINER) as f32
    };
    let panorama = Image::from_fn(2 * ROWS, ROWS, pixel);
    let environment = Environment::new(panorama, 0.0);
    environment.map(Some).map_err(|error| format!("has an invalid sky: {error}"))
}

/// The direction at `u` widths and `v` heights of a panorama; see [`Environment`].
fn direction(u: f64, v: f64) -> DVec3 {
    let ((sin, cos), (ring, y)) = (((u - 0.5) * TAU).sin_cos(), (v * PI).sin_cos());
    DVec3::new(ring * sin, y, -ring * cos)
}
