//! Spheres of a measured BRDF, of its fits, and of their differences.
//!
//! One row for each fit: measured, fitted, difference. The camera is far away; two directional lights shine, one from
//! above the camera's left and one from behind on the right, where reflectance rises towards grazing angles. The difference is
//! that of the two pictures' sRGB values, over middle grey: brighter where the fit is too bright.

use glam::{Mat3, Vec3};
use std::f32::consts::PI;
use unrender_measured::Fit;
use unrender_render::bsdf::Bsdf;
use unrender_scene::color::{linear_from_srgb, srgb_from_linear};
use unrender_scene::{MeasuredBrdf, Rgb, RgbImage};

/// The side of a sphere's picture, pixels. At half of it highlights of roughness 0.05 are a few pixels; double of it shows
/// the table's own cells.
const SIDE: usize = 128;
/// The sphere's radius as a share of half of the side: the rest is a margin.
const RADIUS: f32 = 0.94;
/// Towards the lights, not normalised, with the light of each: a white diffuse surface that faces it shows as much.
const LIGHTS: [(Vec3, f32); 2] =
    [(Vec3::new(-0.5, 0.6, 0.7), 1.0), (Vec3::new(0.9, 0.25, -0.45), 0.7)];
/// The share of the sphere's pixels that are darker than `SHOWN`: at half of it highlights are clipped to white, at one
/// only they are seen.
const QUANTILE: f32 = 0.9;
/// The linear value of the pixel at the quantile. At half of it the base is dark, at double of it highlights are clipped.
const SHOWN: f32 = 0.4;

/// The pictures of `fits` to `table`, linear values from 0 to 1, below each other.
pub(crate) fn spheres(table: &MeasuredBrdf, fits: &[Fit]) -> RgbImage {
    let measured = sphere(&|wo, wi| table.lookup(wo, wi).unwrap_or(Rgb::ZERO));
    let mut levels: Vec<f32> =
        measured.pixels().iter().map(|v| v.max_element()).filter(|v| *v > 0.0).collect();
    levels.sort_by(f32::total_cmp);
    let at = (QUANTILE * levels.len() as f32) as usize;
    let exposure = levels.get(at).map_or(1.0, |level| SHOWN / level);
    let exposed = |picture: RgbImage| picture.map(|v| (*v * exposure).clamp(Rgb::ZERO, Rgb::ONE));
    let measured = exposed(measured);
    let fitted: Vec<RgbImage> = fits
        .iter()
        .map(|fit| {
            let bsdf = Bsdf::new(&fit.material, fit.material.rho_d, fit.form.model);
            exposed(sphere(&|wo, wi| bsdf.value(wo, wi)))
        })
        .collect();
    RgbImage::from_fn(3 * SIDE, SIDE * fits.len(), |x, y| {
        let (row, x_in, y_in) = (y / SIDE, x % SIDE, y % SIDE);
        let pair = (*measured.at(x_in, y_in), *fitted[row].at(x_in, y_in));
        match x / SIDE {
            0 => pair.0,
            1 => pair.1,
            _ => difference(pair),
        }
    })
}

/// The linear value that shows by how much the second differs from the first.
fn difference((measured, fitted): (Rgb, Rgb)) -> Rgb {
    let of = |channel: usize| {
        let apart = srgb_from_linear(fitted[channel]) - srgb_from_linear(measured[channel]);
        linear_from_srgb((0.5 + apart).clamp(0.0, 1.0))
    };
    Rgb::new(of(0), of(1), of(2))
}

/// The sphere of the BRDF `f(wo, wi)`, of a surface of the normal z; black around it.
fn sphere(f: &dyn Fn(Vec3, Vec3) -> Rgb) -> RgbImage {
    let half = 0.5 * SIDE as f32;
    RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let across = (x as f32 + 0.5 - half) / (half * RADIUS);
        let up = (half - y as f32 - 0.5) / (half * RADIUS);
        let square = 1.0 - across * across - up * up;
        if square <= 0.0 {
            return Rgb::ZERO;
        }
        let normal = Vec3::new(across, up, square.sqrt());
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let local = Mat3::from_cols(tangent, bitangent, normal).transpose();
        let wo = local * Vec3::Z;
        LIGHTS.into_iter().fold(Rgb::ZERO, |sum, (towards, light)| {
            let wi = local * towards.normalize();
            if wi.z > 0.0 { sum + f(wo, wi) * (PI * light * wi.z) } else { sum }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_measured::{Form, fit};

    #[test]
    fn a_perfect_fit_leaves_middle_grey_and_a_dark_one_is_darker() {
        let table = MeasuredBrdf::from_fn([20, 12, 8], |_, _| Rgb::splat(0.5 / PI)).unwrap();
        let forms = Form::of(Some("ggx".parse().unwrap()));
        let mut fits = fit(&table, &forms).unwrap();
        fits[1].material.rho_d = Rgb::splat(0.2);
        let picture = spheres(&table, &fits);
        assert_eq!((picture.width(), picture.height()), (3 * SIDE, 2 * SIDE));
        let middle =
            |row: usize| srgb_from_linear(picture.at(5 * SIDE / 2, row * SIDE + SIDE / 2).x);
        assert!((middle(0) - 0.5).abs() < 5e-3, "{}", middle(0));
        assert!(middle(1) < 0.4, "{}", middle(1));
    }
}
