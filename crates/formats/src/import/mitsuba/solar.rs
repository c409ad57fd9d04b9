//! The sun: where it stands, and the radiance of its disc on a clear day.
//!
//! Position: the algorithm of the Plataforma Solar de Almeria, to 0.01 degrees from 1999 to 2015 and little worse around
//! it. [Blanco-Muriel et al. 2001]
//! Radiance in Mitsuba 0.5 and 0.6: the spectrum outside the atmosphere times its transmittance for molecules, aerosols,
//! ozone, mixed gases and water vapour. [Preetham et al. 1999, appendix A.1]
//! Radiance in Mitsuba 3: a fit to that of version 3.9.1, whose numbers are Hosek and Wilkie's; at a turbidity of 5 and a
//! height of 20 degrees it is 1.5 times Preetham's. [Hosek and Wilkie 2013]

use super::colorimetry::srgb;
use glam::DVec3;
use unrender_scene::Rgb;

/// Half of the angle under which the sun is seen, degrees; over a year 0.263 to 0.2725. All programs after Preetham
/// take this mean.
pub(super) const HALF_APERTURE_DEG: f64 = 0.2679;
/// The radius of the earth over its distance from the sun.
const PARALLAX: f64 = 6371.01 / 149_597_890.0;
/// Ozone, cm at normal pressure, as Preetham assumes.
const OZONE_CM: f64 = 0.35;
/// Precipitable water, cm, as Preetham assumes.
const WATER_CM: f64 = 2.0;
/// Ångström's exponent: the share of small particles, as Preetham assumes.
const PARTICLES: f64 = 1.3;

/// The radiance of the sun outside the atmosphere, W m^-2 nm^-1 sr^-1, from 380 nm on in steps of 10 nm.
#[rustfmt::skip]
const SUN: [f64; 38] = [
    16559.0, 16233.7, 21127.5, 25888.2, 25829.1, 24232.3, 26760.5, 29658.3, 30545.4, 30057.5,
    30663.7, 28830.4, 28712.1, 27825.0, 27100.6, 27233.6, 26361.3, 25503.8, 25060.2, 25311.6,
    25355.9, 25134.2, 24631.5, 24173.2, 23685.3, 23212.1, 22827.7, 22339.8, 21970.2, 21526.7,
    21097.9, 20728.3, 20240.4, 19870.8, 19427.2, 19072.4, 18628.9, 18259.2,
];
/// The absorption of ozone, 1/cm, from 445 nm on in steps of 5 nm, to 610 nm.
#[rustfmt::skip]
const OZONE_FINE: [f64; 34] = [
    0.003, 0.003, 0.004, 0.006, 0.008, 0.009, 0.012, 0.014, 0.017, 0.021, 0.025, 0.03, 0.035, 0.04,
    0.045, 0.048, 0.057, 0.063, 0.07, 0.075, 0.08, 0.085, 0.095, 0.103, 0.11, 0.12, 0.122, 0.12,
    0.118, 0.115, 0.12, 0.125, 0.13, 0.12,
];
/// The same from 610 nm on in steps of 10 nm.
#[rustfmt::skip]
const OZONE_COARSE: [f64; 19] = [
    0.12, 0.105, 0.09, 0.079, 0.067, 0.057, 0.048, 0.036, 0.028, 0.023, 0.018, 0.014, 0.011, 0.01,
    0.009, 0.007, 0.004, 0.0, 0.0,
];
/// The absorption of water vapour, 1/cm, from 690 nm on in steps of 10 nm.
const WATER: [f64; 12] =
    [0.016, 0.024, 0.0125, 1.0, 0.87, 0.061, 0.001, 0.000_01, 0.000_01, 0.0006, 0.0175, 0.036];
/// The absorption of oxygen and carbon dioxide, 1/cm, at 759, 760, 770 and 771 nm.
const GASES: [[f64; 2]; 4] = [[759.0, 0.0], [760.0, 3.0], [770.0, 0.21], [771.0, 0.0]];

/// Where and when the sun is looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// Degrees to the north and to the east.
    pub(super) latitude: f64,
    pub(super) longitude: f64,
    /// Hours before universal time.
    pub(super) timezone: f64,
    pub(super) year: i32,
    pub(super) month: i32,
    pub(super) day: i32,
    /// Of local time, without daylight saving.
    pub(super) hours: f64,
}

impl Moment {
    /// The angle of the sun from straight up, and from north over east, radians.
    pub(super) fn sun(&self) -> [f64; 2] {
        let universal = self.hours - self.timezone;
        let days = f64::from(self.days()) - 0.5 + universal / 24.0;
        let omega = 2.1429 - 0.001_039_459_4 * days;
        let anomaly = 6.240_06 + 0.017_201_969_9 * days;
        let longitude = 4.895_063
            + 0.017_202_791_698 * days
            + 0.033_416_07 * anomaly.sin()
            + 0.000_348_94 * (2.0 * anomaly).sin()
            - 0.000_113_4
            - 0.000_020_3 * omega.sin();
        let obliquity = 0.409_092_8 - 6.214e-9 * days + 0.000_039_6 * omega.cos();
        let ascension = (obliquity.cos() * longitude.sin()).atan2(longitude.cos());
        let declination = (obliquity.sin() * longitude.sin()).asin();
        let sidereal = 6.697_424_324_2 + 0.065_709_828_3 * days + universal;
        let hour_angle = (15.0 * sidereal + self.longitude).to_radians() - ascension;
        let (sin, cos) = self.latitude.to_radians().sin_cos();
        let height = cos * hour_angle.cos() * declination.cos() + declination.sin() * sin;
        let zenith = height.clamp(-1.0, 1.0).acos();
        let north = declination.tan() * cos - sin * hour_angle.cos();
        [zenith + PARALLAX * zenith.sin(), (-hour_angle.sin()).atan2(north)]
    }

    /// Days from noon of 1 January 2000 to noon of this one.
    fn days(&self) -> i32 {
        let early = (self.month - 14) / 12;
        let julian = (1461 * (self.year + 4800 + early)) / 4
            + (367 * (self.month - 2 - 12 * early)) / 12
            - (3 * ((self.year + 4900 + early) / 100)) / 4
            + self.day
            - 32075;
        julian - 2_451_545
    }
}

/// The fit to Mitsuba 3's sun by channel: ln L = a + b m + c m^2 + d m^3 - g (e m + f m^2) for the air mass m and the haze
/// g. It is within 1 % at heights of 10 degrees and more up to a turbidity of 7, and within 0.9 % of the sun at noon
/// everywhere.
const FIT: [[f64; 6]; 3] = [
    [10.095_784, -0.064_501, -0.000_031, -0.000_017, 0.994_279, 0.008_911],
    [10.003_611, -0.135_734, -0.000_305, 0.000_054, 1.102_824, 0.007_093],
    [9.943_168, -0.311_805, 0.000_648, -0.000_13, 1.046_275, 0.007_343],
];
/// The haze of the fit at the turbidities 1 to 10.
const HAZE: [f64; 10] =
    [0.0, 0.009_24, 0.0245, 0.049_68, 0.076_88, 0.096_45, 0.128_77, 0.182_05, 0.269_99, 0.415_08];
/// The air mass at a height of 2 degrees: below, Mitsuba 3's sun does not change.
const MOST_AIR: f64 = 19.54;

/// The mass of the air in the light's way over that straight up. [Kasten 1965]
fn air_mass(zenith: f64) -> f64 {
    1.0 / (zenith.cos() + 0.15 * (93.885 - zenith.to_degrees()).max(1e-3).powf(-1.253))
}

/// The mean radiance of the disc at the angle `zenith` from straight up, radians, in Mitsuba 3; linear sRGB.
pub(super) fn radiance_of_3(zenith: f64, turbidity: f64) -> Rgb {
    let air = air_mass(zenith).min(MOST_AIR);
    let haze = between(&HAZE, (1.0, 1.0), turbidity);
    let channel = |[a, b, c, d, e, f]: [f64; 6]| {
        let clear = a + air * (b + air * (c + air * d));
        (clear - haze * air * (e + air * f)).exp() as f32
    };
    Rgb::from_array(FIT.map(channel))
}

/// The radiance of the disc at the angle `zenith` from straight up, radians, in Mitsuba 0.5 and 0.6; linear sRGB.
pub(super) fn radiance(zenith: f64, turbidity: f64) -> Rgb {
    let air = air_mass(zenith);
    let of = |nm: f64| between(&SUN, (380.0, 10.0), nm) * transmittance(nm, air, turbidity);
    srgb(of, false).max(DVec3::ZERO).as_vec3()
}

/// The share of light of the wavelength `nm` that comes through so much air, relative to the least, straight down.
fn transmittance(nm: f64, air: f64, turbidity: f64) -> f64 {
    let micrometres = nm / 1000.0;
    let haze = 0.046_083_658_220_50 * turbidity - 0.045_860_259_285_22;
    let ozone = if nm < 610.0 {
        between(&OZONE_FINE, (445.0, 5.0), nm)
    } else {
        between(&OZONE_COARSE, (610.0, 10.0), nm)
    };
    let gases = GASES.windows(2).find(|pair| (pair[0][0]..=pair[1][0]).contains(&nm));
    let gases = gases.map_or(0.0, |pair| {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        y0 + (nm - x0) / (x1 - x0) * (y1 - y0)
    });
    let water = between(&WATER, (690.0, 10.0), nm) * WATER_CM;
    let depth = 0.008_735 * air * micrometres.powf(-4.08)
        + air * haze * micrometres.powf(-PARTICLES)
        + air * ozone * OZONE_CM
        + 1.41 * gases * air / (1.0 + 118.93 * gases * air).powf(0.45)
        + 0.2385 * water * air / (1.0 + 20.07 * water * air).powf(0.45);
    (-depth).exp()
}

/// The value at `nm` of a table that begins at `first` and goes on in equal steps; zero outside of it.
fn between(table: &[f64], (first, step): (f64, f64), nm: f64) -> f64 {
    let place = (nm - first) / step;
    if !(0.0..=(table.len() - 1) as f64).contains(&place) {
        return 0.0;
    }
    let below = (place as usize).min(table.len() - 2);
    let share = place - below as f64;
    table[below] * (1.0 - share) + table[below + 1] * share
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tokyo in the afternoon of a day in July: by an almanac 44 degrees from straight up, west by 4 degrees south.
    #[test]
    fn the_sun_is_where_an_almanac_has_it() {
        let tokyo = Moment {
            latitude: 35.6894,
            longitude: 139.6917,
            timezone: 9.0,
            year: 2010,
            month: 7,
            day: 10,
            hours: 15.0,
        };
        let [zenith, azimuth] = tokyo.sun().map(f64::to_degrees);
        assert!((zenith - 43.9).abs() < 0.3, "{zenith}");
        assert!((azimuth.rem_euclid(360.0) - 265.7).abs() < 0.5, "{azimuth}");
        let midnight = Moment { hours: 0.0, ..tokyo };
        assert!(midnight.sun()[0].to_degrees() > 90.0);
    }

    /// What Mitsuba 3.9.1 evaluates at turbidities of 3 and 5 and heights of 30 and 60 degrees.
    #[test]
    fn the_sun_of_mitsuba_3_is_that_of_mitsuba_3() {
        for (turbidity, height, wanted) in [
            (3.0, 30f64, [20274.0, 15950.0, 10618.0]),
            (3.0, 60.0, [21873.0, 18316.0, 14106.0]),
            (5.0, 30.0, [18239.0, 14190.0, 9505.0]),
        ] {
            let found = radiance_of_3((90.0 - height).to_radians(), turbidity);
            let off = found / Rgb::from_array(wanted) - 1.0;
            assert!(off.abs().max_element() < 5e-3, "{turbidity} {height}: {found}");
        }
    }

    /// Outside of the atmosphere the disc has about 2.4e4 W m^-2 nm^-1 sr^-1 in the green; near the horizon it is red.
    #[test]
    fn air_dims_the_sun_and_makes_it_red() {
        let [high, low] = [30f64, 85.0].map(|zenith| radiance(zenith.to_radians(), 3.0));
        assert!(high.y > 1.4e4 && high.y < 2.2e4, "{high}");
        assert!(low.y < 0.5 * high.y && low.x / low.z > 2.0 * high.x / high.z, "{low} {high}");
        assert!(radiance(0.5, 8.0).y < radiance(0.5, 2.0).y);
        assert!(radiance(90f64.to_radians(), 10.0).is_finite());
    }
}
