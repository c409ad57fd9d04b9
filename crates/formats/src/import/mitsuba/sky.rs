//! The clear sky and the sun in it: `sunsky`, and `sky` and `sun` of Mitsuba 0.5 and 0.6, as a panorama.
//!
//! The sky is Hosek and Wilkie's, by the crate `hw-skymodel`; the sun is a disc of even radiance: see
//! `solar.rs`.
//! Up is +y and north -z before `to_world` in Mitsuba 0.5 and 0.6; in Mitsuba 3 up is +z, south +x.
//! [Hosek and Wilkie 2012; Mitsuba 0.6 and 3.9 documentation]

use super::colorimetry::LUMINANCE;
use super::paint::{Context, color};
use super::solar::{self, Moment};
use super::spectrum::Use;
use super::tree::Node;
use glam::{DMat3, DVec3};
use hw_skymodel::rgb::{Channel, SkyParams, SkyState};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use unrender_scene::{Environment, Light, LightKind, Rgb, RgbImage};

/// Columns of a panorama: of the sky alone, and the most with the sun. With half as many, the brightness around the sun
/// is off by percents; with twice as many, rooms take a second longer to read.
const COLUMNS: [usize; 2] = [1024, 2048];
/// The columns that the sun's disc is wide, if there are so many. At half of it the disc is a square.
const ACROSS_SUN: f64 = 3.0;
/// Places along each side of a pixel at which the disc is looked for.
const FINE: usize = 8;
/// What Mitsuba 0.6 divides the model's radiance by, the sum of its luminous efficiency.
const OLD_LUMINANCE: f64 = 106.856_980;
/// The sky model's lowest view: it is not defined at the horizon itself.
const HORIZON: f64 = FRAC_PI_2 - 1e-4;

/// A place and a time take no sun_direction beside them.
const MOMENT: [&str; 9] =
    ["latitude", "longitude", "timezone", "year", "month", "day", "hour", "minute", "second"];

/// The sky and the sun of one emitter.
struct Sky {
    /// From the world to the emitter's own axes.
    own_from_world: DMat3,
    is_old: bool,
    /// The angle of the sun from straight up, and from north over east, radians.
    sun: [f64; 2],
    /// Angles from straight up are stretched by this, as if more than a half of the sphere were sky.
    stretch: f64,
    /// Whether the lowest row goes on below the horizon, fading.
    extends: bool,
    dome: Option<Dome>,
    /// The sun's disc: its half aperture, radians, and its irradiance across the light.
    disc: Option<(f64, Rgb)>,
}

/// The radiance of the sky.
struct Dome {
    model: SkyState,
    scale: f64,
}

/// The light that the `sunsky`, `sky` or `sun` `node` is, if the sun has no size, and the environment.
pub(super) fn read(
    context: &Context,
    node: Node,
) -> Result<(Option<Light>, Option<Environment>), String> {
    let sky = Sky::read(context, node)?;
    let id = if node.id().is_empty() { node.kind() } else { node.id() };
    let light = sky.disc.filter(|(half, _)| *half == 0.0).map(|(_, irradiance)| {
        let direction = -sky.towards_sun().as_vec3();
        let kind = LightKind::Directional { direction, irradiance };
        Light { name: id.to_owned(), kind }
    });
    if sky.dome.is_none() && sky.disc.is_none_or(|(half, _)| half == 0.0) {
        return Ok((light, None));
    }
    let panorama = sky.panorama(context).map_err(|problem| node.fail(problem))?;
    let around = Environment::new(panorama, 0.0).map_err(|error| node.fail(error))?;
    Ok((light, Some(around)))
}

impl Sky {
    fn read(context: &Context, node: Node) -> Result<Self, String> {
        let is_old = node.is_old();
        let own_from_world = axes(node)?.inverse();
        if !own_from_world.is_finite() {
            return Err(node.wrong("to_world", "a motion: it makes the sky flat"));
        }
        let turbidity = within(node, "turbidity", 3.0, [1.0, 10.0])?;
        let stretch = within(node, "stretch", 1.0, [1.0, 2.0])?;
        let sun = sun(node, &own_from_world)?;
        if sun[0] > FRAC_PI_2 {
            return Err(node.fail(format!(
                "the sun stands {:.1} degrees below the horizon, for which there is no sky; give another hour or \
                 sun_direction",
                (sun[0] - FRAC_PI_2).to_degrees()
            )));
        }
        let [sky_scale, sun_scale] = scales(node)?;
        let albedo =
            color(context, node, "albedo", Use::Reflectance, if is_old { 0.2 } else { 0.3 })?;
        let half = half_aperture(node)?;
        if node.flag("complex_sun", false)? {
            context
                .warn(node.fail("the sun was taken to be as bright at its edge as in its middle"));
        }
        let dome = if sky_scale > 0.0 {
            let elevation = (FRAC_PI_2 - sun[0]).max(0.0) as f32;
            let (turbidity, albedo) = (turbidity as f32, albedo.to_array());
            let model = SkyState::new(&SkyParams { elevation, turbidity, albedo });
            let model = model.map_err(|error| node.fail(error))?;
            let luminance = if is_old { OLD_LUMINANCE } else { LUMINANCE };
            Some(Dome { model, scale: sky_scale / luminance })
        } else {
            None
        };
        let solid_angle = TAU * (1.0 - solar::HALF_APERTURE_DEG.to_radians().cos());
        let sun_radiance = if is_old { solar::radiance } else { solar::radiance_of_3 };
        let irradiance = sun_radiance(sun[0], turbidity) * (sun_scale * solid_angle) as f32;
        let disc = (sun_scale > 0.0).then_some((half, irradiance));
        let extends = node.flag("extend", false)?;
        Ok(Self { own_from_world, is_old, sun, stretch, extends, dome, disc })
    }

    /// The unit vector towards the middle of the sun, in the world.
    fn towards_sun(&self) -> DVec3 {
        let own = direction([self.sun[0] * self.stretch, self.sun[1]], self.is_old);
        (self.own_from_world.inverse() * own).normalize_or(DVec3::Y)
    }

    /// The radiance from all directions of the world.
    fn panorama(&self, context: &Context) -> Result<RgbImage, String> {
        let columns = self.columns();
        let rows = columns / 2;
        let bytes = (columns * rows * size_of::<Rgb>()) as u64;
        // The disc is as large at its worst.
        context.scope.charge(2 * bytes)?;
        let mut panorama = RgbImage::from_fn(columns, rows, |column, row| {
            let place = [column as f64 + 0.5, row as f64 + 0.5];
            self.dome_at(towards(place, columns)).unwrap_or(Rgb::ZERO)
        });
        if let Some((half, irradiance)) = self.disc.filter(|(half, _)| *half > 0.0) {
            let covered = covered(self.towards_sun(), half, columns);
            let solid_angle: f64 = covered
                .iter()
                .map(|(pixel, share)| share * pixel_solid_angle(*pixel, columns))
                .sum();
            for (pixel, share) in covered {
                panorama.pixels_mut()[pixel] += irradiance * (share / solid_angle) as f32;
            }
        }
        Ok(panorama)
    }

    fn columns(&self) -> usize {
        let half = self.disc.map_or(0.0, |(half, _)| half);
        if half == 0.0 {
            return COLUMNS[0];
        }
        let wanted = (ACROSS_SUN * PI / half).min(COLUMNS[1] as f64) as usize;
        wanted.next_power_of_two().clamp(COLUMNS[0], COLUMNS[1])
    }

    /// The radiance of the sky from the direction `world`; none below the horizon.
    fn dome_at(&self, world: DVec3) -> Option<Rgb> {
        let Dome { model, scale } = self.dome.as_ref()?;
        let [zenith, azimuth] =
            angles((self.own_from_world * world).normalize_or(DVec3::Y), self.is_old);
        let mut theta = zenith / self.stretch;
        let mut fade = 1.0;
        if theta >= FRAC_PI_2 {
            if !self.extends {
                return None;
            }
            let height = (2.0 - 2.0 * zenith / PI).clamp(0.0, 1.0);
            (theta, fade) = (HORIZON, height * height * (3.0 - 2.0 * height));
        }
        let [(sin, cos), (sun_sin, sun_cos)] = [theta.sin_cos(), self.sun[0].sin_cos()];
        let turn = (azimuth - self.sun[1]).cos();
        let gamma = (cos * sun_cos + sin * sun_sin * turn).clamp(-1.0, 1.0).acos();
        let channels = [Channel::R, Channel::G, Channel::B];
        let radiance = channels.map(|channel| {
            let radiance = f64::from(model.radiance(theta as f32, gamma as f32, channel));
            (radiance * scale * fade).max(0.0) as f32
        });
        Some(Rgb::from_array(radiance))
    }
}

/// The emitter's axes in the world, of unit length.
fn axes(node: Node) -> Result<DMat3, String> {
    let world = node.motion("to_world")?.matrix3;
    let unit = |axis: DVec3| axis.normalize_or_zero();
    Ok(DMat3::from_cols(unit(world.x_axis), unit(world.y_axis), unit(world.z_axis)))
}

/// A number in a range.
fn within(node: Node, name: &str, default: f32, [low, high]: [f64; 2]) -> Result<f64, String> {
    let number = f64::from(node.number(name, default)?);
    if (low..=high).contains(&number) {
        return Ok(number);
    }
    Err(node.wrong(name, &format!("a number from {low} to {high}")))
}

/// A whole number in a range.
fn whole(node: Node, name: &str, default: f32, range: [f64; 2]) -> Result<i32, String> {
    let number = within(node, name, default, range)?;
    if number.fract() == 0.0 { Ok(number as i32) } else { Err(node.wrong(name, "a whole number")) }
}

/// The factors of the sky's radiance and of the sun's.
fn scales(node: Node) -> Result<[f64; 2], String> {
    let factor =
        |name: &str, default: f64| within(node, name, default as f32, [0.0, f64::INFINITY]);
    let scale = factor("scale", 1.0)?;
    Ok(match node.kind() {
        "sky" => [scale, 0.0],
        "sun" => [0.0, scale],
        _ => [factor("sky_scale", scale)?, factor("sun_scale", scale)?],
    })
}

/// Half of the angle under which the sun is seen, radians.
fn half_aperture(node: Node) -> Result<f64, String> {
    let widest = 90.0 / solar::HALF_APERTURE_DEG;
    let larger = within(node, "sun_radius_scale", 1.0, [0.0, widest])?;
    let usual = 2.0 * solar::HALF_APERTURE_DEG * larger;
    Ok(0.5 * within(node, "sun_aperture", usual as f32, [0.0, 180.0])?.to_radians())
}

/// The angles of the sun, which a direction in the world states, or a place and a time.
fn sun(node: Node, own_from_world: &DMat3) -> Result<[f64; 2], String> {
    if let Some(stated) = node.point("sun_direction")? {
        if let Some(other) = MOMENT.iter().find(|name| node.has(name)) {
            return Err(node.wrong(other, "given beside sun_direction; leave one of them out"));
        }
        let own = (*own_from_world * stated).try_normalize();
        let own =
            own.ok_or_else(|| node.wrong("sun_direction", "a direction: it has no length"))?;
        return Ok(angles(own, node.is_old()));
    }
    let any = |name: &str, default: f32, most: f64| within(node, name, default, [-most, most]);
    let hour = any("hour", 15.0, 48.0)?;
    let minute = any("minute", 0.0, 3000.0)?;
    let second = any("second", 0.0, 200_000.0)?;
    let moment = Moment {
        latitude: any("latitude", 35.6894, 90.0)?,
        longitude: any("longitude", 139.6917, 360.0)?,
        timezone: any("timezone", 9.0, 24.0)?,
        year: whole(node, "year", 2010.0, [1000.0, 3000.0])?,
        month: whole(node, "month", 7.0, [1.0, 12.0])?,
        day: whole(node, "day", 10.0, [1.0, 31.0])?,
        hours: hour + (minute + second / 60.0) / 60.0,
    };
    Ok(moment.sun())
}

/// The angles of the unit vector `own` of the emitter's axes: from straight up, and from north over east.
fn angles(own: DVec3, is_old: bool) -> [f64; 2] {
    if is_old {
        [own.y.clamp(-1.0, 1.0).acos(), own.x.atan2(-own.z)]
    } else {
        [own.z.clamp(-1.0, 1.0).acos(), (-own.y).atan2(-own.x)]
    }
}

/// The unit vector of these [`angles`].
fn direction([zenith, azimuth]: [f64; 2], is_old: bool) -> DVec3 {
    let ((sin, cos), (east, north)) = (zenith.sin_cos(), azimuth.sin_cos());
    if is_old {
        DVec3::new(sin * east, cos, -sin * north)
    } else {
        DVec3::new(-sin * north, -sin * east, cos)
    }
}

/// The direction of a place in a panorama, pixels from its upper left corner; see [`Environment`].
fn towards([x, y]: [f64; 2], columns: usize) -> DVec3 {
    let heading = TAU * (x / columns as f64 - 0.5);
    let (sin, cos) = (PI * y / (columns / 2) as f64).sin_cos();
    DVec3::new(sin * heading.sin(), cos, -sin * heading.cos())
}

/// The solid angle of a pixel of a panorama.
fn pixel_solid_angle(pixel: usize, columns: usize) -> f64 {
    let row = (pixel / columns) as f64;
    let [above, below] = [row, row + 1.0].map(|y| (PI * y / (columns / 2) as f64).cos());
    (above - below) * TAU / columns as f64
}

/// The pixels of a panorama that the disc of this `half` aperture about `middle` covers, each with the share of it; the
/// pixel of the middle where the disc is smaller than what is looked at.
fn covered(middle: DVec3, half: f64, columns: usize) -> Vec<(usize, f64)> {
    let rows = columns / 2;
    let least = half.cos();
    let near = (half + 2.0 * TAU / columns as f64).min(PI).cos();
    let fine = |k: usize| (k as f64 + 0.5) / FINE as f64;
    // Only rows at about the height of the middle.
    let [first, last] = [-1.0, 1.0].map(|side| {
        let polar = middle.y.clamp(-1.0, 1.0).acos() + side * near.acos();
        (polar / PI * rows as f64).clamp(0.0, rows as f64) as usize
    });
    let mut found = Vec::new();
    for pixel in first * columns..(last + 1).min(rows) * columns {
        let [x, y] = [pixel % columns, pixel / columns].map(|at| at as f64);
        if towards([x + 0.5, y + 0.5], columns).dot(middle) < near {
            continue;
        }
        let places = (0..FINE * FINE).map(|k| [x + fine(k % FINE), y + fine(k / FINE)]);
        let hits = places.filter(|place| towards(*place, columns).dot(middle) >= least).count();
        if hits > 0 {
            found.push((pixel, hits as f64 / (FINE * FINE) as f64));
        }
    }
    if found.is_empty() {
        let row = ((middle.y.clamp(-1.0, 1.0).acos() / PI * rows as f64) as usize).min(rows - 1);
        let turn = middle.x.atan2(-middle.z) / TAU + 0.5;
        let column = ((turn * columns as f64) as usize).min(columns - 1);
        found.push((row * columns + column, 1.0));
    }
    found
}
