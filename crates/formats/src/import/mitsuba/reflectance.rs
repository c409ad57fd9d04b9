//! BSDFs as diffuse part, specular part and roughness.
//!
//! Exact: `diffuse`, `conductor` without a material, `twosided` and `blendbsdf` of these. GGX is
//! GGX where all that is rough has it; else the roughness of microfacets is taken as Ward's: Beckmann's
//! has the same distribution of slopes.
//! `plastic` and `roughplastic` reflect what they do at normal incidence.

use super::Element;
use crate::input::Scope;
use crate::{picture, texels};
use std::path::Path;
use std::sync::Arc;
use unrender_scene::{Material, Rgb, Texture, Warnings, Wrap};

/// A material, and what it is not.
#[derive(Clone, Debug)]
pub(super) struct Reflectance {
    pub(super) material: Material,
    /// Whether its microfacets, if it has some, are those of GGX.
    pub(super) is_ggx: bool,
    doubts: Vec<String>,
}

impl Reflectance {
    pub(super) fn diffuse(rho_d: Rgb) -> Self {
        Self { material: Material::diffuse(rho_d), is_ggx: false, doubts: Vec::new() }
    }

    fn doubted(material: Material, doubt: &str) -> Self {
        Self { material, is_ggx: false, doubts: vec![doubt.to_owned()] }
    }

    /// Tells the doubts about the group `name`; its exact numbers may be known.
    pub(super) fn warn(&self, name: &str, exact: bool, warnings: &mut Warnings) {
        for doubt in self.doubts.iter().filter(|_| !exact) {
            warnings.push(format!("group \"{name}\": {doubt}"));
        }
    }
}

/// What bounds the reading of the scene, and the folder that its pictures are in.
pub(super) type Place<'a> = (&'a Scope, &'a Path);

/// The reflectance of the group `name`.
pub(super) fn read(
    bsdf: &Element,
    place: Place,
    name: &str,
    warnings: &mut Warnings,
) -> Result<Reflectance, String> {
    let within = |problem: String| format!("material \"{name}\": {problem}");
    of(bsdf, place, warnings).map_err(within)
}

fn of(bsdf: &Element, place: Place, warnings: &mut Warnings) -> Result<Reflectance, String> {
    let kind = bsdf.attribute("type");
    match kind.as_str() {
        "diffuse" => diffuse(bsdf, "reflectance", place),
        "twosided" | "bumpmap" | "normalmap" | "mask" => {
            let inside = bsdf.child("bsdf").ok_or_else(|| format!("{kind} has nothing inside"))?;
            let mut inside = of(&inside, place, warnings)?;
            if kind != "twosided" {
                inside.doubts.push(format!("its {kind} was left out"));
            }
            Ok(inside)
        }
        "conductor" | "roughconductor" => conductor(bsdf, kind == "roughconductor"),
        "plastic" | "roughplastic" => plastic(bsdf, kind == "roughplastic", place),
        "blendbsdf" => blend(bsdf, place, warnings),
        _ => Ok(Reflectance::doubted(
            Material::diffuse(Rgb::splat(0.5)),
            &format!("{kind} is not known; it was taken as diffuse with rho_d = 0.5"),
        )),
    }
}

fn diffuse(bsdf: &Element, name: &str, (scope, folder): Place) -> Result<Reflectance, String> {
    let Some(bitmap) = bsdf.property(name).filter(|p| p.is("texture")) else {
        return Ok(Reflectance::diffuse(bsdf.rgb(name, Rgb::splat(0.5))?));
    };
    if bitmap.attribute("type") != "bitmap" {
        let doubt = "its texture is no bitmap; it was taken as rho_d = 0.5";
        return Ok(Reflectance::doubted(Material::diffuse(Rgb::splat(0.5)), doubt));
    }
    let file = bitmap.value("filename").ok_or("a bitmap has no filename")?;
    let path = scope.beside(folder, &file).map_err(|problem| format!("\"{file}\" {problem}"))?;
    let (read, _) = picture::read_in(scope, &path).map_err(|error| error.to_string())?;
    let is_raw = bitmap.value("raw").as_deref() == Some("true");
    let image = if is_raw { read.values.clone() } else { read.to_linear() };
    let wrap = match bitmap.value("wrap_mode").as_deref() {
        Some("clamp") => Wrap::ClampToEdge,
        Some("mirror") => Wrap::MirroredRepeat,
        _ => Wrap::Repeat,
    };
    let mut material = Material::diffuse(texels::mean(&image));
    material.texture = Some(Arc::new(Texture { image, wrap_u: wrap, wrap_v: wrap }));
    let mut doubts = Vec::new();
    if bitmap.property("to_uv").is_some() {
        doubts.push("its texture's to_uv was left out".to_owned());
    }
    Ok(Reflectance { material, is_ggx: false, doubts })
}

fn is_ggx(bsdf: &Element) -> bool {
    bsdf.value("distribution").as_deref() == Some("ggx")
}

fn conductor(bsdf: &Element, rough: bool) -> Result<Reflectance, String> {
    let mut doubts = Vec::new();
    let mut rho_s = bsdf.rgb("specular_reflectance", Rgb::ONE)?;
    if bsdf.value("material").as_deref() != Some("none") {
        doubts.push("its metal was taken as one that reflects 0.9 at all angles".to_owned());
        rho_s *= 0.9;
    }
    let mut material = Material::mirror(rho_s);
    if rough {
        let alpha = bsdf.float("alpha", 0.1)?;
        material.alpha_x = bsdf.float("alpha_u", alpha)?;
        material.alpha_y = bsdf.float("alpha_v", alpha)?;
        if !is_ggx(bsdf) {
            doubts.push("the roughness of its microfacets was taken as Ward's".to_owned());
        }
    }
    Ok(Reflectance { material, is_ggx: is_ggx(bsdf), doubts })
}

fn plastic(bsdf: &Element, rough: bool, place: Place) -> Result<Reflectance, String> {
    let mut reflectance = diffuse(bsdf, "diffuse_reflectance", place)?;
    let ior = bsdf.float("int_ior", 1.49)? / bsdf.float("ext_ior", 1.000_277)?;
    let f0 = ((ior - 1.0) / (ior + 1.0)).powi(2);
    let material = &mut reflectance.material;
    material.rho_s = bsdf.rgb("specular_reflectance", Rgb::ONE)? * f0;
    // Light enters and leaves through the coat.
    let through = (1.0 - f0) * (1.0 - f0);
    material.rho_d *= through;
    if let Some(texture) = material.texture.take() {
        let image = texture.image.map(|texel| *texel * through);
        material.texture = Some(Arc::new(Texture { image, ..*texture }));
    }
    if rough {
        let alpha = bsdf.float("alpha", 0.1)?;
        (material.alpha_x, material.alpha_y) = (alpha, alpha);
        reflectance.is_ggx = is_ggx(bsdf);
    }
    reflectance.doubts.push("plastic was taken as it reflects at normal incidence".to_owned());
    Ok(reflectance)
}

fn blend(bsdf: &Element, place: Place, warnings: &mut Warnings) -> Result<Reflectance, String> {
    let weight = bsdf.float("weight", 0.5)?.clamp(0.0, 1.0);
    let parts: Vec<Element> = bsdf.children("bsdf").collect();
    let [one, other] = &parts[..] else { return Err("a blendbsdf has two parts".into()) };
    let (one, other) = (of(one, place, warnings)?, of(other, place, warnings)?);
    let (mut material, two) = (scaled(one.material, 1.0 - weight), scaled(other.material, weight));
    let is_ggx = one.is_ggx || other.is_ggx;
    let mut doubts = [one.doubts, other.doubts].concat();
    let both = |f: fn(&Material) -> bool| f(&material) && f(&two);
    if both(|m| m.rho_s.max_element() > 0.0) || both(|m| m.texture.is_some()) {
        doubts
            .push("of its two blended parts the second one's shine or texture was left out".into());
    }
    material.rho_d += two.rho_d;
    material.texture = material.texture.or(two.texture);
    if material.rho_s.max_element() <= 0.0 {
        material.rho_s = two.rho_s;
        (material.alpha_x, material.alpha_y) = (two.alpha_x, two.alpha_y);
    }
    Ok(Reflectance { material, is_ggx, doubts })
}

fn scaled(mut material: Material, by: f32) -> Material {
    material.rho_d *= by;
    material.rho_s *= by;
    if let Some(texture) = material.texture.take() {
        let image = texture.image.map(|texel| *texel * by);
        material.texture = Some(Arc::new(Texture { image, ..*texture }));
    }
    material
}
