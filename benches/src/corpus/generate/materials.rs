//! Random reflectances of the in-model family: Ward's or GGX's lobe over a diffuse colour.

use super::super::dice::Dice;
use super::colors::{color, round};
use super::textures;
use unrender::scene::{Material, Rgb};

/// The kinds of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Diffuse,
    Isotropic,
    Anisotropic,
    Textured,
    Mirror,
    PartialMirror,
    DiffuseSpecular,
}

/// The materials that a scene allows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules {
    /// Perfect mirrors; by them the other renderers find no light from lights without a surface.
    pub(crate) mirrors: bool,
    /// The smoothest lobe.
    pub(crate) alpha_min: f32,
    /// Whether the renderer has anisotropic lobes of any direction.
    pub(crate) anisotropic: bool,
}

/// A material of the kind.
pub(crate) fn material(dice: &mut Dice, kind: Kind, rules: Rules) -> Material {
    match kind {
        Kind::Diffuse => Material::diffuse(color(dice, 0.03, 0.85)),
        Kind::Textured => {
            let texture = textures::texture(dice);
            let rho_d = unrender::formats::materials::mean_of(&texture.image);
            Material { texture: Some(texture), ..Material::diffuse(rho_d) }
        }
        Kind::Mirror => Material::mirror(Rgb::ONE),
        Kind::PartialMirror => Material::mirror(color(dice, 0.3, 0.9)),
        Kind::DiffuseSpecular => {
            let rho_d = color(dice, 0.05, 0.6);
            Material { rho_d, ..Material::mirror(round(Rgb::splat(dice.range(0.04, 0.3)))) }
        }
        Kind::Isotropic => glossy(dice, rules, 1.0),
        Kind::Anisotropic => {
            let ratio = dice.range(1.6, 4.0);
            glossy(dice, rules, ratio)
        }
    }
}

/// A plastic or a metal; it is rougher by the factor `ratio` across its anisotropy direction.
fn glossy(dice: &mut Dice, rules: Rules, ratio: f32) -> Material {
    let is_metal = dice.chance(if ratio > 1.0 { 0.8 } else { 0.4 });
    let (rho_d, rho_s) = if is_metal {
        (color(dice, 0.01, 0.12), color(dice, 0.35, 0.8))
    } else {
        (color(dice, 0.05, 0.7), Rgb::splat(dice.range(0.03, 0.2)))
    };
    let alpha = dice.log_range(rules.alpha_min, 0.45 / ratio.sqrt());
    let digits = |x: f32| (x * 1e4).round() / 1e4;
    let mut material = Material::isotropic(rho_d, round(rho_s), digits(alpha));
    if ratio > 1.0 {
        material.alpha_y = digits(alpha * ratio);
        material.theta_rad = dice.range(0.0, 180.0).round().to_radians();
    }
    material
}

/// A kind for a thing; textures need texture coordinates.
pub(crate) fn kind(dice: &mut Dice, rules: Rules, has_uvs: bool) -> Kind {
    let mirror = if rules.mirrors { 0.04 } else { 0.0 };
    dice.weighted(&[
        (Kind::Diffuse, 0.42),
        (Kind::Isotropic, 0.27),
        (Kind::Anisotropic, if rules.anisotropic { 0.12 } else { 0.0 }),
        (Kind::Textured, if has_uvs { 0.14 } else { 0.0 }),
        (Kind::Mirror, mirror),
        (Kind::PartialMirror, mirror),
        (Kind::DiffuseSpecular, mirror),
    ])
}
