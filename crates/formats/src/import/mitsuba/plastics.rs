//! Mitsuba's plastics as dielectrics over a base, both ways.
//!
//! With `T` the share of light that enters through the rough surface, `Fi` the share of diffuse light that it reflects back
//! inside and `n` the relative refractive index, the base of Mitsuba's `roughplastic` of diffuse reflectance `d` is
//!
//! ```text
//! f = d/pi T(i) T(o) / (n^2 (1 - Fi d))    nonlinear;   (1 - Fi) in the place of (1 - Fi d) if not
//! ```
//!
//! and that of a dielectric with the *coupled* layering `rho_d/pi T(i) T(o) / Tavg`: the two are one where `rho_d = d Tavg /
//! (n^2 (1 - Fi d))`. For a smooth surface `n^2 (1 - Fi) = Tavg`. [Jakob et al., Mitsuba 3, `roughplastic.cpp`; Walter et
//! al. 2007]

use std::f32::consts::PI;
use unrender_scene::reflectance::fresnel;
use unrender_scene::{LobeAlbedo, Rgb};

/// Points of a quadrature over the visible normals, squared. With half of them `Fi` is off by 0.002, with double of them reading
/// a plastic takes 4 ms instead of one.
const POINTS: usize = 16;

/// The cosines, from 0 to 1 with both ends, over which Mitsuba takes the mean for `Fi`. It is 0.009 below the integral so; with
/// half or double of them white plastics would be 2 % darker or 1 % brighter than Mitsuba's.
const MITSUBAS: usize = 64;

/// The surface of a plastic.
pub(crate) struct Surface {
    /// `Tavg / n^2`.
    scale: f32,
    /// `Fi`.
    inside: f32,
}

impl Surface {
    /// Of relative refractive index `ior` and roughness `alpha`, zero for a smooth one.
    pub(crate) fn new(ior: f32, alpha: f32) -> Self {
        let through = |ior: f32| 1.0 - LobeAlbedo::kept_out(ior, alpha).mean().value;
        // As much light enters a thinner medium as leaves it, in units of n^2 [Walter et al. 2007].
        let scale = if ior < 1.0 { through(1.0 / ior) } else { through(ior) / (ior * ior) };
        if alpha <= 0.0 {
            return Self { scale, inside: 1.0 - scale };
        }
        let cosines = (0..MITSUBAS).map(|k| k as f32 / (MITSUBAS - 1) as f32);
        let inside: f32 = cosines.map(|mu| 2.0 * mu * reflected(mu, 1.0 / ior, alpha)).sum();
        let inside = inside / MITSUBAS as f32;
        Self { scale, inside }
    }

    /// The base of a plastic of diffuse reflectance `d`.
    pub(crate) fn base(&self, d: Rgb, nonlinear: bool) -> Rgb {
        let below = if nonlinear { d } else { Rgb::ONE };
        (d * self.scale / (Rgb::ONE - below * self.inside)).clamp(Rgb::ZERO, Rgb::ONE)
    }

    /// The diffuse reflectance of a plastic, not `nonlinear`, whose base is this one.
    pub(crate) fn reflectance(&self, base: Rgb) -> Rgb {
        (base * (1.0 - self.inside) / self.scale).clamp(Rgb::ZERO, Rgb::ONE)
    }
}

/// Calls `of(h_z, wo . h)` with the normals that are visible towards the cosine `mu`, and returns the mean [Heitz 2018].
fn over_visible_normals(mu: f32, alpha: f32, of: impl Fn(f32, f32) -> f32) -> f32 {
    let mu = mu.max(1e-6);
    let sin = (1.0 - mu * mu).max(0.0).sqrt();
    let length = (alpha * sin).hypot(mu);
    let (x, z) = (alpha * sin / length, mu / length);
    let mut sum = 0.0;
    for (i, j) in (0..POINTS).flat_map(|i| (0..POINTS).map(move |j| (i, j))) {
        // Dense at the rim, where the tail of the distribution is.
        let inner = 1.0 - (i as f32 + 0.5) / POINTS as f32;
        let radius = (1.0 - inner * inner).sqrt();
        let angle = PI * ((j as f32 + 0.5) / POINTS as f32 - 0.5);
        let (across, along) = (radius * angle.cos(), radius * angle.sin());
        let share = 0.5 * (1.0 + z);
        let up = (1.0 - share) * (1.0 - across * across).sqrt() + share * along;
        let out = (1.0 - across * across - up * up).max(0.0).sqrt();
        let h = [alpha * (x * out - z * up), alpha * across, (z * out + x * up).max(0.0)];
        let length = h.iter().map(|c| c * c).sum::<f32>().sqrt();
        let [h_x, h_z] = [h[0] / length, h[2] / length];
        sum += 2.0 * inner * of(h_z, sin * h_x + mu * h_z);
    }
    sum / (POINTS * POINTS) as f32
}

/// Smith's masking of a direction of the cosine `mu` [Walter et al. 2007, eq. 34].
fn masking(mu: f32, alpha: f32) -> f32 {
    let mu = mu.max(1e-6);
    let tan2 = (1.0 - mu * mu).max(0.0) / (mu * mu);
    2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt())
}

/// The share of light from the cosine `mu` that a rough surface of relative index `ior` reflects at the first hit; `ior` is below one for light inside.
fn reflected(mu: f32, ior: f32, alpha: f32) -> f32 {
    over_visible_normals(mu, alpha, |h_z, cos| {
        let z = 2.0 * cos * h_z - mu;
        if z <= 0.0 { 0.0 } else { reflectance(cos, ior) * masking(z.min(1.0), alpha) }
    })
}

/// Fresnel's reflectance for an index below one, too: by the cosine on the denser side.
fn reflectance(cos: f32, ior: f32) -> f32 {
    if ior >= 1.0 {
        return fresnel(cos, ior);
    }
    let sin2 = (1.0 - cos * cos) / (ior * ior);
    // The reflectance is the same both ways along a path.
    if sin2 >= 1.0 { 1.0 } else { fresnel((1.0 - sin2).sqrt(), 1.0 / ior) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_plastics_are_as_bright_as_mitsubas() {
        // pi f from the normal to the normal of Mitsuba 3.9.1's plastics of ior 1.5, nonlinear, ggx, without their lobe.
        let expected =
            [(0.0, 1.0, 1.015), (0.05, 1.0, 0.966), (0.1, 1.0, 0.913), (0.15, 1.0, 0.853)];
        for (alpha, d, expected) in expected {
            let through = 1.0 - LobeAlbedo::kept_out(1.5, alpha).at(1.0);
            let found =
                d * through * through / (2.25 * (1.0 - d * Surface::new(1.5, alpha).inside));
            assert!((found / expected - 1.0).abs() < 5e-3, "{alpha}: {found} is not {expected}");
        }
    }

    #[test]
    fn a_plastic_thinner_than_what_surrounds_it_keeps_its_base() {
        // All diffuse light that the surface does not send back leaves: Tavg / n^2 = 1 - Fi, but for what is scattered twice.
        for alpha in [0.0, 0.1] {
            for ior in [0.75, 1.33] {
                let base = Surface::new(ior, alpha).base(Rgb::splat(0.5), false).x;
                assert!((0.45..=0.505).contains(&base), "{ior} {alpha}: {base}");
            }
        }
    }

    #[test]
    fn a_base_comes_back() {
        let surface = Surface::new(1.5, 0.2);
        let base = Rgb::new(0.7, 0.3, 0.05);
        let back = surface.base(surface.reflectance(base), false);
        assert!((back - base).abs().max_element() < 1e-5, "{back}");
    }

    #[test]
    fn smooth_plastics_that_are_linear_are_coupled_dielectrics() {
        let d = Rgb::new(0.9, 0.5, 0.1);
        let base = Surface::new(1.5, 0.0).base(d, false);
        assert!((base - d).abs().max_element() < 1e-5, "{base}");
        // [Egan and Hilgeman 1973, table 1]: the diffuse light that is reflected back inside.
        assert!((Surface::new(1.5, 0.0).inside - 0.596).abs() < 2e-3);
    }
}
