//! What `gensky` prints: the sun as a light far away, and the brightness of the CIE's skies.
//!
//! The x axis points east, y north and z up. Skies are clear (`+s`, and `-s` without the sun), in between
//! (`+i`, `-i`), overcast (`-c`) or uniform (`-u`).
//! [Radiance, `gensky(1)`; CIE S 003 "Spatial distribution of daylight"]

use super::primitives::{Place, Primitive};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use unrender_scene::Warnings;

/// Lumens a watt of skylight and of sunlight, as Radiance has them.
const SKY_EFFICACY: f64 = 203.0;
const SUN_EFFICACY: f64 = 208.0;
/// The greatest altitude of the sun.
const HIGHEST: f64 = 87.0 * PI / 180.0;
/// The solid angle of the sun in Radiance's formula for the ground's brightness.
const SUN: f64 = 6e-5;
/// That of half a degree across, in its formula for the sun's radiance from an irradiance: pi sin^2 of a quarter
/// of a degree.
const HALF_A_DEGREE: f64 = 5.981_09e-5;
/// The default turbidity of clear skies in Radiance 6.
const TURBIDITY: f64 = 2.45;

const USE: &str = "is used as: gensky MONTH DAY HOUR or gensky -ang ALTITUDE AZIMUTH, with options";

#[derive(Clone, Copy, PartialEq, Eq)]
enum Sky {
    Clear = 1,
    Overcast = 2,
    Uniform = 3,
    Between = 4,
}

/// A brightness, stated as a radiance or as an irradiance.
#[derive(Clone, Copy)]
enum Given {
    Radiance(f64),
    Irradiance(f64),
}

/// The command line.
struct Options {
    sky: Sky,
    has_sun: bool,
    zenith: Option<Given>,
    sun: Option<Given>,
    turbidity: Option<f64>,
    ground: f64,
    latitude: f64,
    longitude: f64,
    meridian: f64,
}

/// The primitives that `gensky` prints.
pub(super) fn gensky(
    words: &[String],
    place: &Place,
    warnings: &mut Warnings,
) -> Result<Vec<Primitive>, String> {
    let [first, second, third, rest @ ..] = words else { return Err(USE.into()) };
    let options = Options::read(rest)?;
    let (altitude, azimuth) = if first == "-ang" {
        (number(second)?.to_radians(), number(third)?.to_radians())
    } else {
        options.sun_at(first, second, third)?
    };
    if options.turbidity.is_none() && options.zenith.is_none() && options.is_clear() {
        warnings.push(format!(
            "{place}: gensky has no -t; the sky was made with a turbidity of {TURBIDITY}, as Radiance 6 makes it. Earlier \
             versions take 2.75, by which it is up to a fifth brighter: state -t"
        ));
    }
    let is_covered = !options.is_clear();
    let altitude = if is_covered { altitude } else { altitude.min(HIGHEST) };
    let (sin, cos) = altitude.sin_cos();
    let sun = [-azimuth.sin() * cos, -azimuth.cos() * cos, sin];
    let (norm, f2) = options.norm(altitude);
    let zenith = options.zenith_radiance(altitude, norm);
    let shines = !is_covered && sin > 0.0 && options.sun_is_there();
    let solar = if shines { options.sun_radiance(sin) } else { 0.0 };
    let ground = options.ground * (zenith * norm + SUN / PI * solar * sin);
    let mut found = Vec::new();
    if shines && options.has_sun {
        let solar = printed(solar);
        found.push(primitive("void", "light", "solar", &[], vec![solar; 3]));
        found.push(primitive("solar", "source", "sun", &[], [&sun[..], &[0.5]].concat()));
    }
    let mut numbers = vec![f64::from(options.sky as u8), printed(zenith), printed(ground)];
    if !is_covered {
        numbers.push(printed(f2));
        numbers.extend(sun);
    }
    found.push(primitive("void", "brightfunc", "skyfunc", &["skybr", "skybright.cal"], numbers));
    Ok(found)
}

fn primitive(modifier: &str, kind: &str, id: &str, words: &[&str], reals: Vec<f64>) -> Primitive {
    let [modifier, kind, id] = [modifier, kind, id].map(str::to_owned);
    let strings = words.iter().map(|word| (*word).to_owned()).collect();
    Primitive { modifier, kind, id, strings, reals, ..Primitive::default() }
}

/// A number rounded to the four digits that `gensky` prints.
fn printed(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn number(word: &str) -> Result<f64, String> {
    let number = word.parse::<f64>().ok().filter(|v| (*v as f32).is_finite());
    number.ok_or_else(|| format!("has \"{word}\" where a number should be; it {USE}"))
}

impl Options {
    fn read(words: &[String]) -> Result<Self, String> {
        // Radiance's default: a site near San Francisco.
        let mut read = Self {
            sky: Sky::Clear,
            has_sun: true,
            zenith: None,
            sun: None,
            turbidity: None,
            ground: 0.2,
            latitude: 0.66,
            longitude: 2.13,
            meridian: 2.0944,
        };
        let mut words = words.iter();
        while let Some(word) = words.next() {
            let mut next = || words.next().ok_or(USE.to_owned()).and_then(|word| number(word));
            match word.as_str() {
                "+s" | "-s" => (read.sky, read.has_sun) = (Sky::Clear, word == "+s"),
                "+i" | "-i" => (read.sky, read.has_sun) = (Sky::Between, word == "+i"),
                "-c" => read.sky = Sky::Overcast,
                "-u" => read.sky = Sky::Uniform,
                "-b" => read.zenith = Some(Given::Radiance(next()?)),
                "-B" => read.zenith = Some(Given::Irradiance(next()?)),
                "-r" => read.sun = Some(Given::Radiance(next()?)),
                "-R" => read.sun = Some(Given::Irradiance(next()?)),
                "-t" => read.turbidity = Some(next()?),
                "-g" => read.ground = next()?,
                "-a" => read.latitude = next()?.to_radians(),
                "-o" => read.longitude = next()?.to_radians(),
                "-m" => read.meridian = next()?.to_radians(),
                _ => return Err(format!("has \"{word}\", which is not built in; it {USE}")),
            }
        }
        Ok(read)
    }

    /// The altitude and the azimuth of the sun, from the south towards the west.
    fn sun_at(&self, month: &str, day: &str, hour: &str) -> Result<(f64, f64), String> {
        const BEFORE: [f64; 12] =
            [0., 31., 59., 90., 120., 151., 181., 212., 243., 273., 304., 334.];
        let month = month.parse::<usize>().ok().filter(|month| (1..=12).contains(month));
        let day = day.parse::<u8>().ok().filter(|day| (1..=31).contains(day));
        let (Some(month), Some(day)) = (month, day) else { return Err(USE.into()) };
        let date = BEFORE[month - 1] + f64::from(day);
        let (is_solar, clock) = hour.strip_prefix('+').map_or((false, hour), |hour| (true, hour));
        let hours = match clock.split_once(':') {
            Some((hours, minutes)) => number(hours)? + number(minutes)? / 60.0,
            None => clock.parse::<f64>().map_err(|_| {
                format!(
                    "has the hour \"{hour}\"; give the time without its zone, and the zone's -m"
                )
            })?,
        };
        let difference = 0.17 * (4.0 * PI / 373.0 * (date - 80.0)).sin()
            - 0.129 * (2.0 * PI / 355.0 * (date - 8.0)).sin()
            + 12.0 * (self.meridian - self.longitude) / PI;
        let time = (hours + if is_solar { 0.0 } else { difference }) * PI / 12.0;
        let declination = 0.4093 * (2.0 * PI / 368.0 * (date - 81.0)).sin();
        let ((sin_d, cos_d), (sin_l, cos_l)) = (declination.sin_cos(), self.latitude.sin_cos());
        let altitude = (sin_l * sin_d - cos_l * cos_d * time.cos()).clamp(-1.0, 1.0).asin();
        let azimuth = -(cos_d * time.sin()).atan2(-cos_l * sin_d - sin_l * cos_d * time.cos());
        Ok((altitude, azimuth))
    }

    /// The sky's irradiance over pi times its zenith's radiance, and the divisor of its formula.
    fn norm(&self, altitude: f64) -> (f64, f64) {
        let down = FRAC_PI_2 - altitude;
        let x = (altitude - FRAC_PI_4) / FRAC_PI_4;
        let polynomial = |c: [f64; 5]| c.into_iter().rev().fold(0.0, |sum, c| sum * x + c);
        match self.sky {
            Sky::Uniform => (1.0, 1.0),
            Sky::Overcast => (7.0 / 9.0, 1.0),
            Sky::Clear => {
                let sin = altitude.sin();
                let f2 = 0.274 * (0.91 + 10.0 * (-3.0 * down).exp() + 0.45 * sin * sin);
                let norm = polynomial([2.766521, 0.547665, -0.369832, 0.009237, 0.059229]);
                (norm / f2 / PI, f2)
            }
            Sky::Between => {
                let f2 = (2.739 + 0.9891 * (0.3119 + 2.6 * altitude).sin())
                    * (-down * (0.4441 + 1.48 * altitude)).exp();
                let norm = polynomial([3.5556, -2.7152, -1.3081, 1.0660, 0.60227]);
                (norm / f2 / PI, f2)
            }
        }
    }

    fn zenith_radiance(&self, altitude: f64, norm: f64) -> f64 {
        let overcast = 8.6 * altitude.sin() + 0.123;
        let clear = (1.376 * self.turbidity.unwrap_or(TURBIDITY) - 1.81) * altitude.tan() + 0.38;
        let luminance = match (self.zenith, self.sky) {
            (Some(Given::Radiance(radiance)), _) => return radiance,
            (Some(Given::Irradiance(irradiance)), _) => return irradiance / (norm * PI),
            (None, Sky::Overcast | Sky::Uniform) => overcast,
            (None, Sky::Clear) => clear,
            (None, Sky::Between) => 0.5 * (clear + overcast),
        };
        luminance.max(0.0) * 1000.0 / SKY_EFFICACY
    }

    fn is_clear(&self) -> bool {
        matches!(self.sky, Sky::Clear | Sky::Between)
    }

    fn sun_is_there(&self) -> bool {
        match self.sun {
            None => true,
            Some(Given::Radiance(bright) | Given::Irradiance(bright)) => bright > 0.0,
        }
    }

    fn sun_radiance(&self, sin: f64) -> f64 {
        match self.sun {
            Some(Given::Radiance(radiance)) => radiance,
            Some(Given::Irradiance(irradiance)) => irradiance / (HALF_A_DEGREE * sin),
            None => {
                let veiled = if self.sky == Sky::Between { 0.15 } else { 1.0 };
                veiled * 1.5e9 / SUN_EFFICACY * (1.147 - 0.147 / sin.max(0.16))
            }
        }
    }
}
