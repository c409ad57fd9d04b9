//! How the specular lobe of a material reflects, and what it leaves to the base underneath.
//!
//! Ward's and GGX's lobes have a free reflectance `rho_s`, the same in every direction. Real surfaces follow Fresnel's
//! equations: a *dielectric* (plastic, varnish, stone) reflects `F(cos; ior)` at each microfacet and lets the rest
//! through to its base; a *metal* reflects `F0 + (1 - F0)(1 - cos)^5` by channel [Schlick 1994] and has no base.
//!
//! With `E(v)` the albedo of the dielectric lobe in the direction `v`, and `T(v)` the share of light that enters from there at
//! the first hit ([`crate::lobe_albedo`]), the base contributes
//!
//! ```text
//! albedo-scaled:  rho_d/pi (1 - E(o))
//! coupled:        rho_d/pi T(i) T(o) / Tavg,   Tavg = 2 integral T cos dcos
//! ```
//!
//! The first is that of Blender's Principled BSDF, glTF and OpenPBR; the second is reciprocal [Kelemen and Szirmay-Kalos
//! 2001], and that of Mitsuba's plastics. Both are linear in `rho_d` and, for a smooth surface, where `T = 1 - E`, have the same
//! albedo, `E(o) + rho_d (1 - E(o))`, under even light, so that `rho_d` is one thing: Blender's *Base Color*. A rough coupled
//! one loses what its microfacets scatter more than once.

use crate::Rgb;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// The refractive index of ordinary plastics, varnishes and glass; that of Blender's and glTF's materials which state
/// none. At half of the difference from one (1.25) they reflect 1.2 % instead of 4 %, at double (2.0) 11 %.
pub const IOR: f32 = 1.5;

/// The highest refractive index of a dielectric: where the table of [`crate::lobe_albedo`] ends. Diamond has 2.4; what reflects
/// more than its 25 % at normal incidence is a metal. Half of it would refuse water on glass, double of it serves nothing.
pub const IOR_MAX: f32 = 3.0;

/// The range of roughness that is searched: sharper lobes are mirrors at any pixel size that photographs have, wider
/// ones are diffuse. At half of the first, lobes fit single light samples; at double of it polished metal is missed.
/// Half of the second takes satin for diffuse; beyond it nothing changes.
pub const ALPHA_RANGE: [f32; 2] = [0.005, 1.0];

/// What a material's `rho_s` means.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub enum Reflectance {
    /// The reflectance of the lobe, the same in every direction: Ward's and GGX's.
    #[default]
    Free,
    /// `rho_s` is the reflectance at normal incidence of a dielectric of this refractive index, over a base of the
    /// reflectance `rho_d`.
    Dielectric {
        /// The refractive index, above 1.
        ior: f32,
        /// How the base lies under the lobe.
        layering: Layering,
    },
    /// `rho_s` is the reflectance at normal incidence of a metal, by channel.
    Metal {
        /// Whether light that a rough lobe scatters several times is added [Turquin 2019], as Blender's default does;
        /// without, the lobe darkens as it gets rough, as Mitsuba's does.
        multiscatter: bool,
    },
}

impl Reflectance {
    /// The name in result files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Dielectric { .. } => "dielectric",
            Self::Metal { .. } => "metal",
        }
    }

    /// True for the reflectance that is the same in every direction.
    pub fn is_free(self) -> bool {
        self == Self::Free
    }
}

/// How the base of a dielectric lies under its lobe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Layering {
    /// Scaled by what the lobe leaves of the light towards the viewer: not reciprocal.
    #[default]
    AlbedoScaled,
    /// Coupled by the light that enters and the light that leaves: reciprocal.
    Coupled,
}

impl Layering {
    /// Both, the default first.
    pub const ALL: [Self; 2] = [Self::AlbedoScaled, Self::Coupled];

    /// The name in project and result files.
    pub fn name(self) -> &'static str {
        match self {
            Self::AlbedoScaled => "albedo-scaled",
            Self::Coupled => "coupled",
        }
    }
}

impl fmt::Display for Layering {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Layering {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|layering| layering.name() == name).ok_or_else(|| {
            format!("unknown layering \"{name}\"; use \"albedo-scaled\" or \"coupled\"")
        })
    }
}

/// The share of unpolarised light that the surface of a dielectric of refractive index `ior` reflects, for light from
/// outside at an angle of the given cosine [Cook and Torrance 1982].
///
/// ```
/// use unrender_scene::reflectance::fresnel;
/// assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-6);
/// assert_eq!(fresnel(0.0, 1.5), 1.0);
/// ```
#[inline]
pub fn fresnel(cos: f32, ior: f32) -> f32 {
    let cos = cos.clamp(0.0, 1.0);
    // |n| cos of the refracted ray.
    let inside = (ior * ior - 1.0 + cos * cos).max(0.0).sqrt();
    let (sum, difference) = (inside + cos, inside - cos);
    if sum <= 0.0 {
        // Without a surface, along it.
        return 0.0;
    }
    let across = difference / sum;
    let along = (cos * sum - 1.0) / (cos * difference + 1.0);
    0.5 * across * across * (1.0 + along * along)
}

/// The reflectance at normal incidence of a dielectric of refractive index `ior`.
pub fn f0_of_ior(ior: f32) -> f32 {
    ((ior - 1.0) / (ior + 1.0)).powi(2)
}

/// The refractive index, at least one, of a dielectric of reflectance `f0` at normal incidence, below one.
pub fn ior_of_f0(f0: f32) -> f32 {
    let root = f0.max(0.0).sqrt();
    (1.0 + root) / (1.0 - root)
}

/// The weight of white in Schlick's approximation, `(1 - cos)^5`.
#[inline]
pub fn schlick(cos: f32) -> f32 {
    let grazing = (1.0 - cos).clamp(0.0, 1.0);
    let square = grazing * grazing;
    square * square * grazing
}

/// The mean over a hemisphere, weighted by the cosine, of a metal's reflectance: `F0 + (1 - F0)/21`.
pub fn metal_mean(f0: Rgb) -> Rgb {
    f0 + (Rgb::ONE - f0) / 21.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_is_that_of_the_two_polarisations() {
        for ior in [1.0f32, 1.2, 1.5, 2.4] {
            for cos in [1.0f32, 0.9, 0.5, 0.2, 0.01] {
                let refracted = (1.0 - (1.0 - cos * cos) / (ior * ior)).sqrt();
                let s = (cos - ior * refracted) / (cos + ior * refracted);
                let p = (ior * cos - refracted) / (ior * cos + refracted);
                let expected = 0.5 * (s * s + p * p);
                let found = fresnel(cos, ior);
                assert!((found - expected).abs() < 2e-6, "{ior} {cos}: {found} {expected}");
            }
        }
    }

    #[test]
    fn refractive_index_and_reflectance_are_inverse() {
        for ior in [1.0, 1.1, 1.5, 2.4] {
            assert!((ior_of_f0(f0_of_ior(ior)) - ior).abs() < 1e-5);
        }
    }

    #[test]
    fn the_mean_of_schlicks_formula_is_a_twenty_first() {
        let n = 100_000;
        let cosines = (0..n).map(|i| (i as f64 + 0.5) / f64::from(n));
        let mean: f64 =
            cosines.map(|c| 2.0 * c * f64::from(schlick(c as f32))).sum::<f64>() / f64::from(n);
        assert!((mean * 21.0 - 1.0).abs() < 1e-3, "{mean}");
    }
}
