//! The microfacet lobe of [Trowbridge and Reitz 1975] (GGX) with constant reflectance.
//!
//! With `h` the unit half vector, x and y along and across the anisotropy direction:
//!
//! ```text
//! w  = D(h) G(wo, wi) / (4 cos_o cos_i)
//! D  = 1 / (pi alpha_x alpha_y ((h_x/alpha_x)^2 + (h_y/alpha_y)^2 + h_z^2)^2)
//! G  = 1 / (1 + L(wo) + L(wi)),   L(v) = (sqrt(1 + (alpha_x^2 v_x^2 + alpha_y^2 v_y^2)/v_z^2) -
//! 1)/2
//! ```
//!
//! [Walter et al. 2007, eq. 33; Heitz 2014, eqs. 85, 86, 99: the height-correlated form, as in Blender and glTF]. Mitsuba masks
//! both directions apart, `G = 1 / ((1 + L(wo)) (1 + L(wi)))` [Walter et al. 2007, eq. 23], which is 4 % less at 80 degrees for
//! both and alpha 0.2. There is no Fresnel term; the albedo of `rho_s w` is `rho_s` less the light that microfacets scatter more
//! than once. Sampled by the distribution of visible normals [Heitz 2018].

use super::ward::{ALPHA_MIN, LobeDerivatives};
use crate::turn;
use glam::Vec3;
use std::f32::consts::PI;

/// The lobe for one pair of roughnesses, for `rho_s = 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxLobe {
    alpha_x: f32,
    alpha_y: f32,
    /// The factor of `L(wo) L(wi)` in `1/G`: one where both directions are masked apart, else zero.
    apart: f32,
}

impl GgxLobe {
    /// A lobe with roughness `alpha_x` along and `alpha_y` across the anisotropy direction; both
    /// are raised to [`ALPHA_MIN`].
    pub fn new(alpha_x: f32, alpha_y: f32) -> Self {
        Self { alpha_x: alpha_x.max(ALPHA_MIN), alpha_y: alpha_y.max(ALPHA_MIN), apart: 0.0 }
    }

    /// The same, with both directions masked apart.
    pub fn masked_apart(self) -> Self {
        Self { apart: 1.0, ..self }
    }

    /// The two roughnesses.
    #[inline]
    pub(super) fn alphas(&self) -> [f32; 2] {
        [self.alpha_x, self.alpha_y]
    }

    /// `w`, sr^-1, for two directions above the surface.
    #[inline]
    pub fn value(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.value_and_pdf(wo, wi).0
    }

    /// [`GgxLobe::value`] and [`GgxLobe::pdf`], which share most of the work.
    #[inline]
    pub fn value_and_pdf(&self, wo: Vec3, wi: Vec3) -> (f32, f32) {
        let (out, into) = (self.lambda(wo), self.lambda(wi));
        let normals = self.distribution(wo + wi) / (4.0 * wo.z);
        let masking = 1.0 + out + into + self.apart * out * into;
        (normals / (wi.z * masking), normals / (1.0 + out))
    }

    /// [`GgxLobe::value`] with its derivatives; below [`ALPHA_MIN`] those at [`ALPHA_MIN`].
    ///
    /// With `q` the sum in `D` and `s` the root in `L`: `d ln D/d alpha_x = 4 (h_x/alpha_x)^2/(q
    /// alpha_x) - 1/alpha_x`, `dL/d alpha_x = alpha_x v_x^2/(2 s v_z^2)`. The angle moves
    /// directions in the anisotropy frame, `dv_x = v_y dtheta` and `dv_y = -v_x dtheta`.
    #[inline]
    pub fn derivatives(&self, wo: Vec3, wi: Vec3) -> LobeDerivatives {
        let value = self.value(wo, wi);
        if value <= 0.0 {
            return LobeDerivatives::default();
        }
        let h = (wo + wi).normalize();
        let (a, b) = (h.x / self.alpha_x, h.y / self.alpha_y);
        let q = a * a + b * b + h.z * h.z;
        let (out, into) = (self.lambda(wo), self.lambda(wi));
        let masking = 1.0 + out + into + self.apart * out * into;
        let [to, ti] = [wo, wi].map(|v| self.lambda_derivatives(v));
        let [by_out, by_into] = [into, out].map(|other| 1.0 + self.apart * other);
        let masked = |k: usize| (to[k] * by_out + ti[k] * by_into) / masking;
        let by_angle = 4.0 * (b * h.x / self.alpha_y - a * h.y / self.alpha_x) / q;
        LobeDerivatives {
            value,
            by_alpha_x: value * ((4.0 * a * a / q - 1.0) / self.alpha_x - masked(0)),
            by_alpha_y: value * ((4.0 * b * b / q - 1.0) / self.alpha_y - masked(1)),
            by_theta: value * (by_angle - masked(2)),
        }
    }

    /// The density over solid angle with which [`GgxLobe::sample`] draws `wi`:
    /// `D(h) / (4 cos_o (1 + L(wo)))`.
    #[inline]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.value_and_pdf(wo, wi).1
    }

    /// Draws `wi` for `wo` from two numbers in [0, 1); it may lie below the surface.
    pub fn sample(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(self.alpha_x * wo.x, self.alpha_y * wo.y, wo.z).normalize();
        let across = Vec3::Z.cross(stretched).try_normalize().unwrap_or(Vec3::X);
        let up = stretched.cross(across);
        let (sin, cos) = turn::sin_cos(u[1]);
        let radius = u[0].sqrt();
        let (x, y) = (radius * cos, radius * sin);
        // The lower half disk is foreshortened.
        let share = 0.5 * (1.0 + stretched.z);
        let y = (1.0 - share) * (1.0 - x * x).max(0.0).sqrt() + share * y;
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let seen = across * x + up * y + stretched * z;
        let h = Vec3::new(self.alpha_x * seen.x, self.alpha_y * seen.y, seen.z.max(0.0));
        let h = h.try_normalize().unwrap_or(Vec3::Z);
        2.0 * wo.dot(h) * h - wo
    }

    /// `D` for a half vector of any length.
    #[inline]
    fn distribution(&self, h: Vec3) -> f32 {
        let (x, y) = (h.x / self.alpha_x, h.y / self.alpha_y);
        let q = (x * x + y * y + h.z * h.z) / h.length_squared();
        1.0 / (PI * self.alpha_x * self.alpha_y * q * q)
    }

    #[inline]
    fn lambda(&self, v: Vec3) -> f32 {
        0.5 * (self.root(v) - 1.0)
    }

    #[inline]
    fn root(&self, v: Vec3) -> f32 {
        let (x, y) = (self.alpha_x * v.x, self.alpha_y * v.y);
        (1.0 + (x * x + y * y) / (v.z * v.z)).sqrt()
    }

    /// `L`'s derivatives by alpha_x, alpha_y and the angle.
    #[inline]
    fn lambda_derivatives(&self, v: Vec3) -> [f32; 3] {
        let scale = 0.5 / (self.root(v) * v.z * v.z);
        let turned = v.x * v.y * (self.alpha_x * self.alpha_x - self.alpha_y * self.alpha_y);
        [self.alpha_x * v.x * v.x, self.alpha_y * v.y * v.y, turned].map(|d| d * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// The lobe in double precision, from its definition, `apart` as in Mitsuba; its frame is turned by `theta`.
    fn value([alpha_x, alpha_y, theta]: [f64; 3], apart: bool, wo: DVec3, wi: DVec3) -> f64 {
        let (sin, cos) = theta.sin_cos();
        let turn = |v: DVec3| DVec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z);
        let (wo, wi) = (turn(wo), turn(wi));
        let h = (wo + wi).normalize();
        let q = (h.x / alpha_x).powi(2) + (h.y / alpha_y).powi(2) + h.z * h.z;
        let lambda = |v: DVec3| {
            let tan2 = ((alpha_x * v.x).powi(2) + (alpha_y * v.y).powi(2)) / (v.z * v.z);
            0.5 * ((1.0 + tan2).sqrt() - 1.0)
        };
        let masking = if apart {
            (1.0 + lambda(wo)) * (1.0 + lambda(wi))
        } else {
            1.0 + lambda(wo) + lambda(wi)
        };
        let area = std::f64::consts::PI * alpha_x * alpha_y;
        1.0 / (area * q * q * 4.0 * wo.z * wi.z * masking)
    }

    fn direction(cos: f64, phi: f64) -> DVec3 {
        let sin = (1.0 - cos * cos).sqrt();
        DVec3::new(sin * phi.cos(), sin * phi.sin(), cos)
    }

    #[test]
    fn derivatives_are_those_of_the_formulas() {
        let grid = (1..=8).flat_map(|i| (0..9).map(move |j| (i, j)));
        let pairs = grid.flat_map(|a| [0.3, 0.8].map(|b| (a, b)));
        for (((i, j), cos_o), apart) in pairs.flat_map(|pair| [false, true].map(|a| (pair, a))) {
            let wi = direction(f64::from(i) / 8.5, 0.3 + 0.7 * f64::from(j));
            let wo = direction(cos_o, 3.0);
            for (alpha_x, alpha_y) in [(0.05, 0.05), (0.1, 0.3), (0.6, 0.2), (0.02, 0.5)] {
                let lobe = GgxLobe::new(alpha_x as f32, alpha_y as f32);
                let lobe = if apart { lobe.masked_apart() } else { lobe };
                let found = lobe.derivatives(wo.as_vec3(), wi.as_vec3());
                let shape = [alpha_x, alpha_y, 0.0];
                let exact = value(shape, apart, wo, wi);
                assert!((f64::from(found.value) / exact - 1.0).abs() < 1e-4);
                let found = [found.by_alpha_x, found.by_alpha_y, found.by_theta];
                for (k, found) in found.into_iter().enumerate() {
                    let [plus, minus] = [1e-6, -1e-6].map(|step| {
                        let mut shape = shape;
                        shape[k] += step;
                        value(shape, apart, wo, wi)
                    });
                    let expected = (plus - minus) / 2e-6;
                    let scale = expected.abs() + 1e-2 * exact / alpha_x.min(alpha_y);
                    let error = (f64::from(found) - expected).abs() / scale;
                    assert!(error < 1e-3, "{k} {alpha_x} {alpha_y}: {found} for {expected}");
                }
            }
        }
    }
}
