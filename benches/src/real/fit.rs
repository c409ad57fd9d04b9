//! Least squares without a renderer: Lambert's law alone, or with one isotropic lobe of Ward, on
//! pixels with given normal, light and view direction.
//!
//! The residual of a pixel is divided by sqrt((0.05 g)^2 + (0.05 m)^2), where m is the model's light
//! and g its mean over the pixels, per channel; both are iterated. The roughness is searched on a
//! grid; reflectances follow by non-negative least squares in closed form. Cost: pixels x
//! roughnesses x iterations.

use super::sphere::Lamp;
use glam::{Mat3, Vec3};
use std::f64::consts::PI;
use unrender::render::GlossyLobe;
use unrender::scene::WardModel;

/// Model error as a share of the mean light and of the pixel's own light. A common factor of the two
/// does not move the minimum; half or double of one alone changes the mean error on the ball of
/// DiLiGenT from 0.103 to 0.101 or 0.106.
const SHARE: f64 = 0.05;

/// Iterations of the weights. Three or ten give the same three digits of that error.
const ITERATIONS: usize = 5;

/// Roughnesses that are tried, from 0.02 to 1 in steps of 10 %. Half as many change that error by
/// less than 0.001; double takes twice the time.
const ROUGHNESSES: i32 = 40;

/// A point of a surface, with the measured radiance under a lamp.
pub(crate) struct Sample {
    pub(crate) normal: Vec3,
    pub(crate) lamp: Lamp,
    pub(crate) value: [f64; 3],
}

/// Lambert and at most one lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fitted {
    /// By channel.
    pub(crate) rho_d: [f64; 3],
    /// By channel.
    pub(crate) rho_s: [f64; 3],
    /// None for Lambert alone.
    pub(crate) alpha: Option<f32>,
}

/// The direction to the camera.
const TO_CAMERA: Vec3 = Vec3::Z;

impl Fitted {
    /// The radiance that leaves towards the camera.
    pub(crate) fn predict(&self, normal: Vec3, lamp: Lamp) -> [f64; 3] {
        let [diffuse, glossy] = terms(normal, lamp, self.alpha);
        let irradiance = lamp.irradiance.to_array();
        std::array::from_fn(|channel| {
            let reflected = self.rho_d[channel] * diffuse + self.rho_s[channel] * glossy;
            f64::from(irradiance[channel]) * reflected
        })
    }
}

/// Fits Lambert, with one lobe if `lobe`.
pub(crate) fn fit(samples: &[Sample], lobe: bool) -> Fitted {
    let step = 50.0_f64.ln() / f64::from(ROUGHNESSES - 1);
    let roughness = |index: i32| Some((0.02 * (step * f64::from(index)).exp()) as f32);
    let alphas: Vec<Option<f32>> =
        if lobe { (0..ROUGHNESSES).map(roughness).collect() } else { vec![None] };
    let candidates = alphas.into_iter().map(|alpha| fit_with(samples, alpha));
    let best = candidates.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(Fitted { rho_d: [0.0; 3], rho_s: [0.0; 3], alpha: None }, |(_, fitted)| fitted)
}

/// The negative log likelihood and the reflectances for one roughness.
fn fit_with(samples: &[Sample], alpha: Option<f32>) -> (f64, Fitted) {
    let basis: Vec<[f64; 2]> = samples.iter().map(|s| terms(s.normal, s.lamp, alpha)).collect();
    let mut fitted = Fitted { rho_d: [0.0; 3], rho_s: [0.0; 3], alpha };
    let mut cost = 0.0;
    for channel in 0..3 {
        let irradiance = |s: &Sample| f64::from(s.lamp.irradiance.to_array()[channel]);
        let values: Vec<f64> = samples.iter().map(|s| s.value[channel] / irradiance(s)).collect();
        let (found, c) = weighted(&basis, &values);
        (fitted.rho_d[channel], fitted.rho_s[channel]) = (found[0], found[1]);
        cost += c;
    }
    (cost, fitted)
}

/// Least squares of one channel, with weights from its own model.
fn weighted(basis: &[[f64; 2]], values: &[f64]) -> ([f64; 2], f64) {
    let mut weights = vec![1.0; values.len()];
    let mut found = [0.0; 2];
    let mut cost = 0.0;
    for _ in 0..ITERATIONS {
        found = non_negative(basis, values, &weights);
        let model: Vec<f64> = basis.iter().map(|b| found[0] * b[0] + found[1] * b[1]).collect();
        let mean = model.iter().sum::<f64>() / model.len().max(1) as f64;
        cost = 0.0;
        for ((weight, m), value) in weights.iter_mut().zip(&model).zip(values) {
            let variance = (SHARE * mean).powi(2) + (SHARE * m).powi(2);
            *weight = 1.0 / variance.max(f64::MIN_POSITIVE);
            cost += (m - value).powi(2) * *weight + variance.max(f64::MIN_POSITIVE).ln();
        }
    }
    (found, cost)
}

/// The two coefficients, neither negative, with the least weighted squares.
fn non_negative(basis: &[[f64; 2]], values: &[f64], weights: &[f64]) -> [f64; 2] {
    let (mut aa, mut ab, mut bb, mut ay, mut by) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (([a, b], y), w) in basis.iter().zip(values).zip(weights) {
        aa += w * a * a;
        ab += w * a * b;
        bb += w * b * b;
        ay += w * a * y;
        by += w * b * y;
    }
    let determinant = aa * bb - ab * ab;
    if determinant > 1e-12 * aa * bb {
        let both = [(bb * ay - ab * by) / determinant, (aa * by - ab * ay) / determinant];
        if both[0] >= 0.0 && both[1] >= 0.0 {
            return both;
        }
    }
    let alone = |xy: f64, xx: f64| if xx > 0.0 { (xy / xx).max(0.0) } else { 0.0 };
    let gain = |x: f64, xy: f64| x * xy;
    let (a, b) = (alone(ay, aa), alone(by, bb));
    if gain(a, ay) >= gain(b, by) { [a, 0.0] } else { [0.0, b] }
}

/// The radiance towards the camera of a diffuse and of a glossy reflectance of one under unit
/// irradiance.
fn terms(normal: Vec3, lamp: Lamp, alpha: Option<f32>) -> [f64; 2] {
    let cosine = f64::from(normal.dot(lamp.towards));
    if cosine <= 0.0 || normal.dot(TO_CAMERA) <= 0.0 {
        return [0.0; 2];
    }
    let Some(alpha) = alpha else { return [cosine / PI, 0.0] };
    let tangent = normal.any_orthonormal_vector();
    let local = Mat3::from_cols(tangent, normal.cross(tangent), normal).transpose();
    let lobe = GlossyLobe::new(WardModel::WardGmd, alpha, alpha);
    let value = lobe.value(local * TO_CAMERA, local * lamp.towards);
    [cosine / PI, cosine * f64::from(value)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender::scene::Rgb;

    #[test]
    fn a_lobe_is_found_again() {
        let towards = Vec3::new(0.2, -0.4, 0.9).normalize();
        let lamp = Lamp { towards, irradiance: Rgb::new(1.0, 2.0, 3.0) };
        let step = 50.0_f64.ln() / f64::from(ROUGHNESSES - 1);
        let alpha = (0.02 * (10.0 * step).exp()) as f32;
        let truth = Fitted { rho_d: [0.5, 0.4, 0.3], rho_s: [0.02; 3], alpha: Some(alpha) };
        let circle = crate::real::sphere::Circle { x: 30.0, y: 30.0, radius: 29.0 };
        let points = (0..60 * 60).map(|i| ((i % 60) as f32 + 0.5, (i / 60) as f32 + 0.5));
        let samples: Vec<Sample> = points
            .filter_map(|(x, y)| circle.normal(x, y))
            .map(|normal| Sample { normal, lamp, value: truth.predict(normal, lamp) })
            .collect();
        let found = fit(&samples, true);
        assert_eq!(found.alpha, truth.alpha);
        for channel in 0..3 {
            assert!((found.rho_d[channel] - truth.rho_d[channel]).abs() < 1e-6, "{found:?}");
            assert!((found.rho_s[channel] - truth.rho_s[channel]).abs() < 1e-6, "{found:?}");
        }
    }

    #[test]
    fn coefficients_are_never_negative() {
        let basis = [[1.0, 0.0], [1.0, 1.0]];
        assert_eq!(non_negative(&basis, &[2.0, 1.0], &[1.0, 1.0])[1], 0.0);
    }
}
