//! The transfer function of the camera, T of [Boivin and Gagalowicz 2002, section 4.1], and its
//! inverse.
//!
//! From radiance to pixel values (codes), per channel, with the vignetting factor `v`:
//!
//! ```text
//! linear = file_from_srgb (v radiance / exposure)
//! code   = black + (1 - black) response(linear)
//! ```
//!
//! The black level is the code of zero radiance, in codes of 0 to 1; the code 1 stays white.

use crate::{Response, Vignetting};
use glam::Mat3;
use serde::{Deserialize, Serialize};
use unrender_scene::{Rgb, RgbImage};

/// The transfer function of a camera and of the program that wrote its picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Transfer {
    /// The curve from linear values to codes.
    pub response: Response,
    /// The code of zero radiance, by channel, at least 0 and below 1.
    pub black_level: Rgb,
    /// The code from which on a channel is clipped; infinite if only the file's range limits it.
    pub white_level: Rgb,
    /// Linear sRGB from the linear values of the file; none if the file has the primaries of sRGB.
    pub srgb_from_file: Option<Mat3>,
    /// The radiance of a linear value of one, by channel.
    pub exposure: Rgb,
    /// The vignetting of the lens.
    pub vignetting: Option<Vignetting>,
}

impl Transfer {
    /// Response and exposure alone.
    pub fn plain(response: Response, exposure: Rgb) -> Self {
        Self {
            response,
            black_level: Rgb::ZERO,
            white_level: Rgb::INFINITY,
            srgb_from_file: None,
            exposure,
            vignetting: None,
        }
    }

    /// The vignetting factor at the point (`x`, `y`) of the picture, in pixels from the top left.
    pub fn share(&self, x: f32, y: f32) -> f32 {
        self.vignetting.as_ref().map_or(1.0, |vignetting| vignetting.share(x, y))
    }

    /// The radiance of a code, W sr^-1 m^-2 per channel, at a pixel with the vignetting factor
    /// `share`.
    pub fn radiance(&self, code: Rgb, share: f32) -> Rgb {
        let code = (code - self.black_level) / (Rgb::ONE - self.black_level);
        let linear = |channel| self.response.linear_from_code(channel, code[channel]);
        let linear = Rgb::new(linear(0), linear(1), linear(2));
        let linear = self.srgb_from_file.map_or(linear, |srgb_from_file| srgb_from_file * linear);
        linear * self.exposure / share
    }

    /// The code of a radiance at a pixel with the vignetting factor `share`, neither clipped nor
    /// quantised.
    pub fn code(&self, radiance: Rgb, share: f32) -> Rgb {
        let linear = radiance * share / self.exposure;
        let linear = self.srgb_from_file.map_or(linear, |m| m.inverse() * linear);
        let code = |channel| self.response.code_from_linear(channel, linear[channel]);
        let code = Rgb::new(code(0), code(1), code(2));
        code * (Rgb::ONE - self.black_level) + self.black_level
    }

    /// The codes of a picture of radiance.
    pub fn codes(&self, radiance: &RgbImage) -> RgbImage {
        RgbImage::from_fn(radiance.width(), radiance.height(), |x, y| {
            let share = self.share(x as f32 + 0.5, y as f32 + 0.5);
            self.code(*radiance.at(x, y), share)
        })
    }

    /// The radiance between `code` and the adjacent code, `step` away; see [`Response::step`] and
    /// [`Transfer::spread`].
    pub fn step(&self, code: Rgb, step: f32, share: f32) -> Rgb {
        let range = Rgb::ONE - self.black_level;
        let (code, step) = ((code - self.black_level) / range, Rgb::splat(step) / range);
        let one = |channel| self.response.step(channel, code[channel], step[channel]);
        self.spread(Rgb::new(one(0), one(1), one(2)), share)
    }

    /// The radiance of independent small differences of the linear values of the file, one a channel. Where
    /// primaries are converted, the root of the sum of squares over the channels of the file.
    pub fn spread(&self, differences: Rgb, share: f32) -> Rgb {
        let differences = self.srgb_from_file.map_or(differences, |m| {
            let squares =
                Mat3::from_cols(m.x_axis.powf(2.0), m.y_axis.powf(2.0), m.z_axis.powf(2.0));
            (squares * (differences * differences)).map(f32::sqrt)
        });
        differences * self.exposure / share
    }

    /// The code at and below which values are clipped: the black level, except for linear
    /// responses, which keep values below it.
    pub fn floor(&self) -> Rgb {
        if self.response == Response::Linear { Rgb::ZERO } else { self.black_level }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Curve;
    use crate::vignetting::Law;
    use glam::Vec3;
    use unrender_scene::Camera;

    fn measured() -> Response {
        let codes = [0.0, 0.1, 0.4, 0.7, 1.0];
        let curve = |gamma: f64| Curve::new(&codes, &codes.map(|c| 3.0 * c.powf(gamma)));
        Response::measured([curve(1.8), curve(2.0), curve(2.4)])
    }

    fn camera() -> Camera {
        Camera::look_at("c", Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0)
    }

    #[test]
    fn codes_come_back_through_radiance() {
        // Display P3's primaries, about.
        let p3 = Mat3::from_cols_array(&[1.22, -0.04, -0.02, -0.22, 1.04, -0.08, 0.0, 0.0, 1.1]);
        let vignetting = Vignetting { law: Law::Cos4, camera: camera(), size: (40, 30) };
        for response in [Response::Srgb, Response::Linear, Response::Gamma(1.8), measured()] {
            let transfer = Transfer {
                response,
                black_level: Rgb::new(0.01, 0.0, 0.03),
                white_level: Rgb::INFINITY,
                srgb_from_file: Some(p3),
                exposure: Rgb::new(2.0, 1.0, 0.5),
                vignetting: Some(vignetting.clone()),
            };
            let codes = RgbImage::from_fn(40, 30, |x, y| {
                let at = |k: usize| ((7 * x + 13 * y + 5 * k) % 95) as f32 / 100.0 + 0.04;
                Rgb::new(at(0), at(1), at(2))
            });
            let shares = vignetting.picture();
            let radiance = codes.pixels().iter().zip(shares.pixels());
            let radiance = radiance.map(|(code, share)| transfer.radiance(*code, *share));
            let back = transfer.codes(&RgbImage::new(40, 30, radiance.collect()));
            for (code, back) in codes.pixels().iter().zip(back.pixels()) {
                let error = (*back - *code).abs().max_element();
                assert!(error < 3e-5, "{:?}: {code} became {back}", transfer.response);
            }
        }
    }

    #[test]
    fn black_is_subtracted_before_the_response() {
        let mut transfer = Transfer::plain(Response::Gamma(2.0), Rgb::ONE);
        transfer.black_level = Rgb::splat(0.2);
        assert_eq!(transfer.radiance(Rgb::splat(0.2), 1.0), Rgb::ZERO);
        assert!((transfer.radiance(Rgb::splat(0.6), 1.0).x - 0.25).abs() < 1e-6);
        assert_eq!(transfer.radiance(Rgb::ONE, 1.0), Rgb::ONE);
        assert!((transfer.radiance(Rgb::splat(0.6), 0.5).x - 0.5).abs() < 1e-6);
        // Noise below black stays for linear files, so that its mean is right.
        transfer.response = Response::Linear;
        assert!((transfer.radiance(Rgb::splat(0.16), 1.0).x + 0.05).abs() < 1e-6);
        assert_eq!(transfer.floor(), Rgb::ZERO);
    }

    #[test]
    fn a_step_is_the_slope_of_the_whole_transfer() {
        let mut transfer = Transfer::plain(Response::Srgb, Rgb::splat(3.0));
        transfer.black_level = Rgb::splat(0.05);
        let (code, step) = (Rgb::splat(0.5), 1.0 / 255.0);
        let slope =
            (transfer.radiance(code + step, 0.5) - transfer.radiance(code - step, 0.5)) / 2.0;
        assert!((transfer.step(code, step, 0.5) - slope).abs().max_element() < 1e-6);
        transfer.srgb_from_file = Some(Mat3::from_diagonal(Vec3::new(1.0, -2.0, 0.5)));
        let mixed = transfer.step(code, step, 0.5);
        assert!((mixed - slope * Rgb::new(1.0, 2.0, 0.5)).abs().max_element() < 1e-6);
    }
}
