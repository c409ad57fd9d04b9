//! Finds clipped pixels: at the top of an integer file's range, of the sensor's, or of a measured
//! response.
//!
//! Sensors and raw converters may saturate below the greatest code of their file: 14 bits in a file of
//! 16, or a JPEG whose white is 254. All brighter pixels lie at that code, a spike at the upper end of
//! the histogram, with slightly darker pixels just below it.

use crate::Transfer;
use unrender_scene::{Depth, Image, Picture, Rgb};

/// A channel is full at its largest code if that has at least this many pixels, ...
const SPIKE_PIXELS: usize = 64;
/// ... and this many times the average of the codes below. Smooth surfaces have at most twice as
/// many at their brightest point; at 4, posterised pictures are taken for full, at 16, noisy ones are
/// missed.
const SPIKE: usize = 8;
/// The share of the range below the spike with which it is compared, and in which there must be
/// pixels: a lamp of one brightness, rendered without noise, has next to none there.
const BELOW: f32 = 0.05;
/// The spike may have at most this many times the pixels in that range. Windows with sharp frames
/// exceed it and are missed; at 40, a rendered lamp with a smoothed edge would count as clipped.
const POPULATED: usize = 20;
/// Sensors saturate at or above this share of a power of two; white levels of 14-bit cameras are
/// from 15 300 on.
const FULL: f32 = 0.93;
/// The least bits of a sensor.
const LEAST_BITS: u32 = 10;

/// The indices of the pixels with a measurement that are clipped in some channel (see [`clipped_from`]),
/// or have a code beyond the last one for which the response of `transfer` was measured.
pub fn clipped_pixels(picture: &Picture, transfer: &Transfer) -> Vec<usize> {
    let (response, from) = (&transfer.response, clipped_from(picture, transfer.white_level));
    let beyond =
        |value: &Rgb| (0..3).any(|c| value[c] >= from[c] || value[c] > response.last_code(c));
    let measured = picture.measured();
    let pixels = picture.values.pixels().iter().zip(measured.pixels()).enumerate();
    let clipped = pixels.filter(|(_, (value, measured))| **measured && beyond(value));
    clipped.map(|(index, _)| index).collect()
}

/// For each channel the value from which on it is clipped: half a code below the one at which it is full
/// (see [`full_codes`]), below the greatest of the file, or below `white_level`. Floating-point files have no
/// greatest code and no steps: `white_level`, or infinity.
pub fn clipped_from(picture: &Picture, white_level: Rgb) -> Rgb {
    let Some(max) = picture.depth.max_code() else { return white_level };
    // Half a code below the top: codes are exact, their quotients are rounded.
    let top = full_codes(picture).map(|code| code.map_or(max, f32::from));
    let tops = Rgb::from_array(top.map(|code| (code - 0.5) / max));
    tops.min(white_level - 0.5 / max)
}

/// For each channel the code below the greatest one of the file at which it is full, if there is one.
pub fn full_codes(picture: &Picture) -> [Option<u16>; 3] {
    let Some(max) = picture.depth.max_code() else { return [None; 3] };
    let measured = picture.measured();
    [0, 1, 2].map(|channel| {
        let mut histogram = vec![0usize; max as usize + 1];
        let pixels = picture.values.pixels().iter().zip(measured.pixels());
        for (value, _) in pixels.filter(|(_, measured)| **measured) {
            histogram[(value[channel] * max).round().clamp(0.0, max) as usize] += 1;
        }
        let code = histogram.iter().rposition(|count| *count > 0)?;
        (code < max as usize && is_full(&histogram, code, picture.depth)).then_some(code as u16)
    })
}

/// Whether the largest code that occurs, `code`, is that of a full channel.
fn is_full(histogram: &[usize], code: usize, depth: Depth) -> bool {
    let near = |range: usize| code as f32 >= FULL * range as f32 && code <= range;
    let plausible = match depth {
        Depth::Sixteen => (LEAST_BITS..=16).any(|bits| near((1 << bits) - 1)),
        _ => near(255),
    };
    let spike = histogram[code];
    if !plausible || spike < SPIKE_PIXELS {
        return false;
    }
    let first = code - ((BELOW * code as f32) as usize).max(1);
    let below: usize = histogram[first..code].iter().sum();
    let mean_is_low = spike * (code - first) >= SPIKE * below;
    mean_is_low && below * POPULATED >= spike
}

/// The mask, of the size of `like`, of pixels that are not in `pixels` nor adjacent to one of them.
pub fn away_from<T>(like: &Image<T>, pixels: &[usize]) -> Image<bool> {
    let mut away = like.map(|_| true);
    for &index in pixels {
        for neighbour in like.neighbourhood(index) {
            away.pixels_mut()[neighbour] = false;
        }
    }
    away
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Curve, Response};
    use unrender_scene::Depth;

    #[test]
    fn only_the_largest_pixel_value_is_clipped() {
        for (depth, max) in [(Depth::Eight, 255.0), (Depth::Sixteen, 65535.0)] {
            let values = [max - 1.0, max].map(|code: f32| Rgb::new(0.0, code / max, 0.0));
            let values = Image::new(2, 1, values.to_vec());
            let picture = Picture::new(values, depth);
            assert_eq!(clipped_pixels(&picture, &Transfer::plain(Response::Srgb, Rgb::ONE)), [1]);
        }
    }

    /// A ramp of 10 000 pixels up to `top` times `max`, cut off at the code `full`.
    fn ramp(max: f32, full: f32, top: f32, depth: Depth) -> Picture {
        let value = |x: usize| (top * max * x as f32 / 9999.0).round().min(full) / max;
        Picture::new(Image::from_fn(10_000, 1, |x, _| Rgb::splat(value(x))), depth)
    }

    #[test]
    fn a_spike_below_the_greatest_code_is_where_the_sensor_is_full() {
        let full = |max, code, top, depth| full_codes(&ramp(max, code, top, depth))[1];
        for code in [16_383.0, 15_400.0, 4095.0, 64_000.0] {
            let found = full(65_535.0, code, 1.2 * code / 65_535.0, Depth::Sixteen);
            assert_eq!(found, Some(code as u16));
        }
        assert_eq!(full(255.0, 254.0, 1.5, Depth::Eight), Some(254));
        let picture = ramp(255.0, 250.0, 1.5, Depth::Eight);
        let clipped = clipped_pixels(&picture, &Transfer::plain(Response::Srgb, Rgb::ONE));
        assert!((3470..3490).contains(&clipped.len()), "{}", clipped.len());
        // One is not bright enough to be full, the other full at the greatest code as usual.
        assert_eq!(full(65_535.0, 65_535.0, 0.22, Depth::Sixteen), None);
        assert_eq!(full(255.0, 255.0, 1.5, Depth::Eight), None);
        assert_eq!(full(255.0, 120.0, 1.0, Depth::Eight), None);
    }

    #[test]
    fn a_lamp_of_one_brightness_is_not_full() {
        let lamp = |x: usize, y: usize| if x < 20 && y < 20 { 0.98 } else { 0.3 };
        let image =
            Image::from_fn(64, 64, |x, y| Rgb::splat((lamp(x, y) * 255.0f32).round() / 255.0));
        assert_eq!(full_codes(&Picture::new(image, Depth::Eight)), [None; 3]);
    }

    #[test]
    fn what_has_no_measurement_is_not_clipped() {
        let mut picture = ramp(255.0, 250.0, 1.5, Depth::Eight);
        let white = (0..10_000).filter(|&i| picture.values.pixels()[i].x > 0.97);
        picture.invalid = white.collect();
        assert_eq!(full_codes(&picture), [None; 3]);
        picture.values.pixels_mut()[9_000] = Rgb::ONE;
        assert_eq!(clipped_pixels(&picture, &Transfer::plain(Response::Srgb, Rgb::ONE)), [0; 0]);
    }

    #[test]
    fn values_beyond_the_measured_response_are_clipped() {
        let line = || Curve::new(&[0.0, 0.8], &[0.0, 1.0]);
        let response = Response::measured([line(), line(), line()]);
        let values = [0.8, 0.81].map(|code| Rgb::new(0.0, code, 0.0));
        let picture = Picture::new(Image::new(2, 1, values.to_vec()), Depth::Float);
        assert_eq!(clipped_pixels(&picture, &Transfer::plain(response, Rgb::ONE)), [1]);
    }
    #[test]
    fn from_the_white_level_on_a_channel_is_clipped() {
        let clipped = |codes: &[f32], depth, white_level| {
            let values = codes.iter().map(|code| Rgb::new(0.1, *code, 0.1)).collect();
            let picture = Picture::new(Image::new(codes.len(), 1, values), depth);
            let plain = Transfer::plain(Response::Linear, Rgb::ONE);
            clipped_pixels(&picture, &Transfer { white_level, ..plain })
        };
        let codes = [249.0, 250.0, 251.0].map(|code| code / 255.0);
        // 250 divided by 255 is 0.98039: each white level counts as its nearest code.
        for white in [0.9803, 0.9804] {
            assert_eq!(clipped(&codes, Depth::Eight, Rgb::splat(white)), [1, 2]);
        }
        assert_eq!(clipped(&codes, Depth::Eight, Rgb::new(0.5, 2.0, 0.5)), [0; 0]);
        assert_eq!(clipped(&[2.9, 3.0], Depth::Float, Rgb::splat(3.0)), [1]);
    }
}
