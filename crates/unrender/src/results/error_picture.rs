//! Pictures of the differences between photograph and re-rendering ([`super::difference`]).
//!
//! `error.png` and its copy in the report are linear from -10 to +10 % of the photograph's mean: orange where the
//! re-rendering is too bright, blue where it is too dark, white where noise explains the difference: colours fade in
//! from two to four standard deviations. Hatched pixels are
//! not compared. `error.png` has its colour bar below the picture. A second picture is in standard deviations of the
//! noise. The values themselves are in a picture of code values, from which the page tells that under the pointer.

use super::difference::{Difference, Differs};
use super::{report_folder, scale_bar};
use crate::Error;
use crate::run::{DifferenceEntry, ErrorPicture, Stop, Unit};
use std::path::Path;
use unrender_formats::picture::{self, Depth};
use unrender_scene::color::linear_from_srgb;
use unrender_scene::{Rgb, RgbImage};

/// The ends of the scale, as a share of the photograph's mean: what people notice beside the photograph is a few
/// percent. At half of it a good draft has saturated places; at double of it errors of 2 % are nearly white.
const FULL_SCALE: f32 = 0.1;
/// The ends of the scale in noise, standard deviations. At half of it every error of a precise result is saturated; at
/// double of it significant ones are pale.
const FULL_SCALE_NOISE: f32 = 20.0;
/// Pixels that are not compared are hatched by two greys, sRGB: lighter than what is compared and significant. Other
/// greys would look like a difference, or like white in a light page.
const HATCH: [f32; 2] = [0.80, 0.88];
/// The width of the hatch's stripes, pixels: at half of it, it is grey on a page; at double of it narrow edges show one
/// stripe.
const STRIPE: usize = 3;
/// Stops of a colour bar: every second is labelled. Half of them do not label the quarters; double of them are no
/// finer, as colours are linear.
const STOPS: usize = 9;
/// The code value of no difference among values from 0 to 255.
const ZERO: f32 = 128.0;

/// The pictures of a photograph's differences.
pub(super) struct ErrorPictures {
    /// With their colour bars.
    pub(super) pictures: Vec<ErrorPicture>,
    /// In numbers.
    pub(super) entry: DifferenceEntry,
}

/// Writes the error pictures of a recovery into its folder, with the photograph's `number` in their names.
pub(super) fn write(
    difference: &Difference,
    (folder, number): (&Path, &str),
) -> Result<ErrorPictures, Error> {
    let (width, height) = (difference.pixels.width(), difference.pixels.height());
    let bar = scale_bar::height(width);
    let of_share = |x, y| painted(*difference.pixels.at(x, y), (x, y), Unit::Share);
    let with_bar = RgbImage::from_fn(width, height + bar, |x, y| {
        if y >= height {
            return scale_bar::pixel(x, y - height, width, FULL_SCALE, diverging);
        }
        of_share(x, y)
    });
    picture::write_png_srgb(&folder.join(format!("error{number}.png")), &with_bar)?;
    let mut pictures = Vec::new();
    for (unit, name, full) in
        [(Unit::Share, "share", FULL_SCALE), (Unit::Noise, "noise", FULL_SCALE_NOISE)]
    {
        let file = report_folder(&format!("error{number}_{name}.png"));
        let picture = RgbImage::from_fn(width, height, |x, y| {
            painted(*difference.pixels.at(x, y), (x, y), unit)
        });
        picture::write_png_srgb(&folder.join(&file), &picture)?;
        let reach = difference.kernel.round() as usize;
        pictures.push(ErrorPicture { file, signed: true, unit, reach, bar: bar_of(full) });
    }
    let values = report_folder(&format!("error{number}_values.png"));
    let codes = difference.pixels.map(|pixel| Rgb::splat(code(*pixel)));
    picture::write_png_codes(&folder.join(&values), &codes, Depth::Eight)?;
    let [beyond_noise, noise, compared] = difference.means();
    Ok(ErrorPictures { pictures, entry: DifferenceEntry { beyond_noise, noise, compared, values } })
}

fn painted(pixel: Option<Differs>, (x, y): (usize, usize), unit: Unit) -> Rgb {
    let Some(differs) = pixel else {
        return Rgb::splat(linear_from_srgb(HATCH[(x + y) / STRIPE % 2]));
    };
    let value = match unit {
        Unit::Share | Unit::Radiance => differs.share / FULL_SCALE,
        Unit::Noise => differs.sigmas().copysign(differs.share) / FULL_SCALE_NOISE,
    };
    diverging(differs.certainty() * value.clamp(-1.0, 1.0))
}

/// The value of a pixel in the picture of values, 0 to 1.
fn code(pixel: Option<Differs>) -> f32 {
    let Some(differs) = pixel else { return 0.0 };
    let root = differs.share.signum() * differs.share.abs().min(1.0).sqrt();
    (ZERO + (root * (ZERO - 1.0)).round()) / 255.0
}

/// The colour bar of a picture whose scale ends at plus and minus `full`.
fn bar_of(full: f32) -> Vec<Stop> {
    let stop = |i: usize| {
        let place = 2.0 * i as f32 / (STOPS - 1) as f32 - 1.0;
        Stop { value: place * full, color: super::hex(diverging(place)) }
    };
    (0..STOPS).map(stop).collect()
}

/// The colour of a value from -1 (blue) over 0 (white) to 1 (orange), as linear RGB. Blue and orange differ for people
/// who see red and green alike.
fn diverging(value: f32) -> Rgb {
    let value = if value.is_finite() { value.clamp(-1.0, 1.0) } else { 1.0 };
    let end = if value > 0.0 { Rgb::new(0.78, 0.36, 0.05) } else { Rgb::new(0.12, 0.36, 0.66) };
    let srgb = Rgb::ONE.lerp(end, value.abs());
    Rgb::from_array(srgb.to_array().map(linear_from_srgb))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_back_from_their_codes() {
        for share in [-2.0, -0.1, -0.0004, 0.0, 0.003, 0.1, 0.7] {
            let byte = (255.0 * code(Some(Differs { share, deviation: 0.0 }))).round();
            let root = (byte - ZERO) / (ZERO - 1.0);
            let read = root * root.abs();
            let root_error = (read.abs().sqrt() - share.abs().min(1.0).sqrt()).abs();
            assert!(byte >= 1.0 && root_error < 0.5 / 126.0, "{share} {read}");
        }
        assert_eq!(code(None), 0.0);
    }

    #[test]
    fn noise_is_white_and_what_is_not_compared_is_grey() {
        let within = Some(Differs { share: 0.019, deviation: 0.01 });
        assert_eq!(painted(within, (0, 0), Unit::Share), Rgb::ONE);
        let beyond = Some(Differs { share: 0.05, deviation: 0.01 });
        assert!(painted(beyond, (0, 0), Unit::Share).z < 0.9);
        let [a, b] = [0, STRIPE].map(|x| painted(None, (x, 0), Unit::Share));
        assert!(a != b && a.x == a.y && b.x == b.y);
    }
}
