//! Materials and glass in the terms that `standard_surface` and OpenPBR share: a base, a metal or a dielectric on it,
//! transmission and emission.
//!
//! A surface without a diffuse part is a metal of colour `rho_s`; else a dielectric of colour `rho_d`. A plastic keeps its
//! refractive index. That of a free lobe is the least (from 1.5 on) that reaches `rho_s` at normal incidence, with `rho_s`
//! over that as its specular colour. Both reflect more towards grazing angles than Ward's lobe.
//! [Autodesk Standard Surface, sections 4 and 5; OpenPBR 1.1, sections 3 and 4]

use std::f32::consts::{FRAC_PI_2, PI};
use unrender_scene::reflectance::ior_of_f0;
use unrender_scene::{Glass, Material, Reflectance, Rgb};

/// The least reflectance at normal incidence that a refractive index is taken for: that of 1.5, the models' default. Half of
/// it would make weak lobes rise more towards grazing angles than the default's; at double, their colours would be darker.
const LEAST_F0: f32 = 0.04;
/// The highest reflectance of a dielectric, whose refractive index is 198; at one it would be infinite. Half of it would
/// darken mirrors over a base; there is no double.
pub(super) const HIGHEST_F0: f32 = 0.98;

/// What a material is in layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layered {
    /// The base colour; a texture takes its place.
    pub(super) base_color: Rgb,
    /// Whether the base is a metal.
    pub(super) is_metal: bool,
    /// Whether there is a lobe.
    pub(super) shines: bool,
    /// The colour of the lobe.
    pub(super) specular_color: Rgb,
    /// The refractive index of the lobe.
    pub(super) ior: f32,
    /// The lobe's alpha in its smoother direction and in its rougher one.
    pub(super) alphas: [f32; 2],
    /// The angle of the rougher direction from the tangent, 0 to pi.
    pub(super) rougher_rad: f32,
}

impl Layered {
    /// The layers of `material`.
    pub(super) fn of(material: &Material) -> Self {
        let highest = material.rho_s.max_element();
        let shines = highest > 0.0;
        let is_metal = match material.reflectance {
            Reflectance::Metal { .. } => true,
            Reflectance::Dielectric { .. } => false,
            Reflectance::Free => {
                material.texture.is_none() && material.rho_d.max_element() <= 0.0 && shines
            }
        };
        let f0 = highest.clamp(LEAST_F0, HIGHEST_F0);
        let (specular_color, ior) = match material.reflectance {
            Reflectance::Dielectric { ior, .. } => (Rgb::ONE, ior),
            _ if is_metal || !shines => (Rgb::ONE, ior_of_f0(f0)),
            _ => ((material.rho_s / f0).min(Rgb::ONE), ior_of_f0(f0)),
        };
        let (x, y) = (material.alpha_x, material.alpha_y);
        let rougher = material.theta_rad + if y > x { FRAC_PI_2 } else { 0.0 };
        Self {
            base_color: if is_metal { material.rho_s } else { material.rho_d },
            is_metal,
            shines,
            specular_color,
            ior,
            alphas: [x.min(y), x.max(y)],
            rougher_rad: rougher.rem_euclid(PI),
        }
    }

    /// The smoother alpha over the rougher one.
    pub(super) fn aspect(&self) -> f32 {
        let [smooth, rough] = self.alphas;
        if rough > 0.0 { smooth / rough } else { 1.0 }
    }

    /// The roughness whose square is the geometric mean of the alphas.
    pub(super) fn mean_roughness(&self) -> f32 {
        let [smooth, rough] = self.alphas;
        (smooth * rough).sqrt().sqrt().min(1.0)
    }
}

/// An emission as a strength and a colour of at most one; white where there is none.
pub(super) fn strength_and_color(emission: Rgb) -> (f32, Rgb) {
    let strength = emission.max_element();
    (strength, if strength > 0.0 { emission / strength } else { Rgb::ONE })
}

/// What glass does to light, as models with one transmission colour have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transmission {
    /// The colour: that of a face; or, with a depth, what is left of light after that way.
    pub(super) color: Rgb,
    /// The way on which the strongest channel falls to 1/e, metres; zero where nothing is absorbed.
    pub(super) depth: f32,
    /// Whether a tint is left out.
    pub(super) lacks_tint: bool,
}

impl Transmission {
    /// That of `glass`.
    pub(super) fn of(glass: &Glass) -> Self {
        let strongest = glass.absorption.max_element();
        if glass.is_thin || strongest <= 0.0 {
            return Self { color: glass.tint, depth: 0.0, lacks_tint: false };
        }
        Self {
            color: (-glass.absorption / strongest).exp(),
            depth: 1.0 / strongest,
            lacks_tint: glass.tint != Rgb::ONE,
        }
    }
}
