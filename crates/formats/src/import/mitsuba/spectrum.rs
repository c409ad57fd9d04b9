//! Spectra, and the linear sRGB that Mitsuba's rgb modes make of them.
//!
//! A reflectance is seen under D65, so that a constant one is grey; an emission is seen directly, so
//! that a constant one is slightly red.

use super::colorimetry::{srgb, srgb_of_xyz};
use super::motion::{number, words};
use glam::DVec3;
use unrender_scene::Rgb;

/// What a colour describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// A share, 0 to 1.
    Reflectance,
    /// Light.
    Emission,
    /// A normal of a normal map, whose codes are taken as they are.
    Normal,
    /// A number of zero or more, as a roughness.
    Index,
    /// An index of refraction or a coefficient of extinction; as linear sRGB it may lie below zero.
    Refraction,
}

/// A constant, or values at wavelengths, linear in between and zero outside.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Spectrum {
    Uniform(f64),
    /// Wavelengths in nm, each above the one before, with the values there; at least two.
    Sampled(Vec<[f64; 2]>),
}

impl Spectrum {
    /// `10`, or `400:0.1, 700:0.2`.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        if !text.contains(':') {
            return number(text).map(Self::Uniform);
        }
        let pair = |word: &str| {
            let (wavelength, value) = word.split_once(':').ok_or_else(|| {
                format!("\"{word}\" is no wavelength with a colon and a value behind it")
            })?;
            Ok([number(wavelength)?, number(value)?])
        };
        Self::sampled(words(text).map(pair).collect::<Result<_, String>>()?)
    }

    /// A file with a wavelength and a value on each line; lines with # are comments.
    pub(super) fn of_file(text: &str) -> Result<Self, String> {
        let mut pairs = Vec::new();
        for (index, line) in text.lines().enumerate() {
            if line.trim().is_empty() || line.starts_with('#') {
                continue;
            }
            let numbers: Result<Vec<f64>, String> = words(line).map(number).collect();
            match numbers.as_deref() {
                Ok([wavelength, value]) => pairs.push([*wavelength, *value]),
                _ => return Err(format!("line {} is no wavelength with a value", index + 1)),
            }
        }
        Self::sampled(pairs)
    }

    /// Values at equal steps from `first` to `last`, nm.
    pub(super) fn regular(values: &[f64], [first, last]: [f64; 2]) -> Result<Self, String> {
        let step = (last - first) / (values.len().max(2) - 1) as f64;
        let pairs = values.iter().enumerate().map(|(i, value)| [first + step * i as f64, *value]);
        Self::sampled(pairs.collect())
    }

    /// Values at these wavelengths.
    pub(super) fn sampled(pairs: Vec<[f64; 2]>) -> Result<Self, String> {
        if pairs.len() < 2 {
            return Err("a spectrum has fewer than two wavelengths".into());
        }
        if pairs.windows(2).any(|pair| pair[0][0] >= pair[1][0]) {
            return Err("the wavelengths of a spectrum do not grow".into());
        }
        Ok(Self::Sampled(pairs))
    }

    /// Linear sRGB.
    pub(super) fn rgb(&self, usage: Use) -> Rgb {
        let color = match self {
            Self::Uniform(value) if usage == Use::Emission => {
                srgb_of_xyz(DVec3::splat(*value)).max(DVec3::ZERO)
            }
            Self::Uniform(value) => DVec3::splat(*value),
            Self::Sampled(pairs) => {
                let color = srgb(|nm| between(pairs, nm), usage != Use::Emission);
                let most = if usage == Use::Reflectance { 1.0 } else { f64::INFINITY };
                color.clamp(DVec3::ZERO, DVec3::splat(most))
            }
        };
        color.as_vec3()
    }
}

/// The value at `wavelength_nm`.
fn between(pairs: &[[f64; 2]], wavelength_nm: f64) -> f64 {
    let above = pairs.partition_point(|pair| pair[0] <= wavelength_nm);
    match (above.checked_sub(1).map(|below| pairs[below]), pairs.get(above)) {
        (Some([x0, y0]), Some([x1, y1])) => y0 + (wavelength_nm - x0) / (x1 - x0) * (y1 - y0),
        (Some([x0, y0]), None) if x0 == wavelength_nm => y0,
        _ => 0.0,
    }
}

/// Planck's law: the radiance of a black body, W m^-2 sr^-1 nm^-1.
pub(super) fn blackbody(temperature_k: f64, [first, last]: [f64; 2]) -> Rgb {
    const PLANCK: f64 = 6.626_070_04e-34;
    const LIGHT: f64 = 2.997_924_58e8;
    const BOLTZMANN: f64 = 1.380_648_52e-23;
    let radiance = |nm: f64| {
        if !(first..=last).contains(&nm) {
            return 0.0;
        }
        let wavelength = nm * 1e-9;
        let exponent = PLANCK * LIGHT / (BOLTZMANN * wavelength * temperature_k);
        1e-9 * 2.0 * PLANCK * LIGHT * LIGHT / (wavelength.powi(5) * exponent.exp_m1())
    };
    srgb(radiance, false).max(DVec3::ZERO).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: Rgb, wanted: [f32; 3]) {
        assert!((found - Rgb::from_array(wanted)).abs().max_element() < 2e-3, "{found}");
    }

    #[test]
    fn a_constant_is_grey_as_a_reflectance_and_reddish_as_an_emission() {
        let ten = Spectrum::parse("1").unwrap();
        close(ten.rgb(Use::Emission), [1.2048, 0.9483, 0.9089]);
        close(ten.rgb(Use::Reflectance), [1.0; 3]);
        // The same spectrum, sampled.
        let half = Spectrum::parse("360:0.5 830:0.5").unwrap();
        close(half.rgb(Use::Reflectance), [0.5; 3]);
        close(half.rgb(Use::Emission), [0.6024, 0.4742, 0.4544]);
    }

    #[test]
    fn colors_out_of_gamut_are_brought_into_it() {
        let green = Spectrum::parse("519:1, 520:100, 521:1").unwrap();
        assert_eq!(green.rgb(Use::Reflectance).x, 0.0);
        assert!(green.rgb(Use::Emission).min_element() >= 0.0);
    }

    /// The index of silver in Mitsuba's rgb modes, at 420 nm to 680 nm alone.
    #[test]
    fn outside_of_the_samples_is_nothing() {
        let short = Spectrum::parse("500:1 600:1").unwrap();
        let whole = Spectrum::parse("360:1 830:1").unwrap();
        let [short, whole] = [short, whole].map(|s| s.rgb(Use::Index));
        assert!(short.z < 0.3 * whole.z, "{short} {whole}");
    }

    #[test]
    fn a_warm_body_is_red() {
        let warm = blackbody(3000.0, [360.0, 830.0]);
        assert!(warm.x > warm.y && warm.y > warm.z && warm.z > 0.0, "{warm}");
        // The luminance is the integral with the luminous efficiency: about that at 555 nm.
        let luminance = warm.dot(Rgb::new(0.2126, 0.7152, 0.0722));
        let at_555 = 2.0 * 6.626e-34 * 9e16 * 1e-9 / 555e-9f64.powi(5) / (8.641f64.exp() - 1.0);
        assert!((f64::from(luminance) / at_555 - 1.0).abs() < 0.2, "{luminance} {at_555}");
    }

    #[test]
    fn what_is_no_spectrum_is_refused() {
        for text in ["", "red", "400:1", "400:1 400:2", "500:1 400:2", "400:a 500:1", "400:1 2"] {
            assert!(Spectrum::parse(text).is_err(), "{text}");
        }
        assert!(Spectrum::of_file("# a\n400 1\n500 2\n").is_ok());
        assert!(Spectrum::of_file("400 1\n500 2 3\n").unwrap_err().contains("line 2"));
    }
}
