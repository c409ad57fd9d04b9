//! BSDFs as diffuse part, specular part and roughness.
//!
//! Exact: `diffuse`, `conductor` without a metal, `twosided` and `blendbsdf` of these, and the `ward` of Mitsuba
//! 0.5. GGX stays GGX where all rough BSDFs have it; else the roughness of microfacets is taken as Ward's:
//! Beckmann's has the same distribution of slopes. Conductors with a metal, `plastic`, `roughplastic`, `pplastic`
//! and `principled` reflect as at normal incidence, with a warning. BSDFs that let light through are refused.

use super::metals;
use super::paint::{Context, Paint, Picture, color, paint, share};
use super::spectrum::Use;
use super::tree::Node;
use crate::input::Scope;
use glam::Affine2;
use std::collections::BTreeMap;
use std::sync::Arc;
use unrender_scene::{BrdfModel, Material, Rgb, Texture, WardModel};

/// A material, and in what it differs from the BSDF.
#[derive(Clone, Debug)]
pub(super) struct Reflectance {
    /// The texture in it is looked up at `to_uv`.
    pub(super) material: Material,
    /// From the texture coordinates of a surface to those of the texture.
    pub(super) to_uv: Affine2,
    /// Whether its microfacets, if any, are those of GGX.
    pub(super) is_ggx: bool,
    /// The one model for which it is exact, if it is not a microfacet model.
    pub(super) model: Option<BrdfModel>,
    /// Whether its back reflects as its front does; else it is black in Mitsuba.
    pub(super) is_two_sided: bool,
    /// Whether it is invisible: light goes straight through.
    pub(super) is_nothing: bool,
    doubts: Vec<String>,
}

impl Reflectance {
    fn of(material: Material) -> Self {
        let (to_uv, doubts) = (Affine2::IDENTITY, Vec::new());
        let (is_two_sided, is_nothing) = (false, false);
        Self { material, to_uv, is_ggx: false, model: None, is_two_sided, is_nothing, doubts }
    }

    pub(super) fn diffuse(rho_d: Rgb) -> Self {
        Self::of(Material::diffuse(rho_d))
    }

    fn painted(paint: Paint) -> Self {
        let mut painted = Self::diffuse(paint.mean);
        if let Some(picture) = paint.picture {
            if picture.turns() {
                painted.doubt(
                    "its texture's to_uv turns or mirrors it, but the anisotropy is not turned",
                );
            }
            let Picture { texture, to_uv } = picture;
            (painted.material.texture, painted.to_uv) = (Some(texture), to_uv);
        }
        painted
    }

    /// Whether it depends on texture coordinates.
    pub(super) fn wants_uvs(&self) -> bool {
        self.material.texture.is_some() || self.material.alpha_x != self.material.alpha_y
    }

    fn doubt(&mut self, doubt: impl Into<String>) {
        let doubt = doubt.into();
        if !self.doubts.contains(&doubt) {
            self.doubts.push(doubt);
        }
    }

    /// The warnings of it; none if its numbers are known exactly from elsewhere.
    pub(super) fn doubts(&self, exact: bool) -> impl Iterator<Item = &String> {
        let is_even = self.material.alpha_x == self.material.alpha_y;
        let of_direction = move |doubt: &&String| doubt.contains("anisotropy");
        self.doubts.iter().filter(move |doubt| !(exact || is_even && of_direction(doubt)))
    }

    /// Adds the diffuse part of `other`, whose texture is looked up at `to_uv`.
    fn add_diffuse(
        &mut self,
        other: Material,
        to_uv: Affine2,
        scope: &Scope,
    ) -> Result<(), String> {
        let plain = [self.material.rho_d, other.rho_d];
        self.material.rho_d += other.rho_d;
        let (texture, added) = match (self.material.texture.take(), other.texture) {
            (None, None) => return Ok(()),
            (Some(own), None) => (own, plain[1]),
            (None, Some(texture)) => {
                self.to_uv = to_uv;
                (texture, plain[0])
            }
            (Some(own), Some(_)) => {
                self.doubt("it blends two textures; the second was taken as its mean");
                (own, plain[1])
            }
        };
        scope.charge(size_of_val(texture.image.pixels()) as u64)?;
        let image = texture.image.map(|texel| *texel + added);
        self.material.texture = Some(Arc::new(Texture { image, ..*texture }));
        Ok(())
    }

    fn scaled(mut self, by: f32, scope: &Scope) -> Result<Self, String> {
        self.material.rho_d *= by;
        self.material.rho_s *= by;
        if let Some(texture) = self.material.texture.take() {
            let picture = Some(Picture { texture, to_uv: self.to_uv });
            let paint = Paint { mean: Rgb::ONE, picture }.scaled(Rgb::splat(by), scope)?;
            self.material.texture = paint.picture.map(|picture| picture.texture);
        }
        Ok(self)
    }
}

/// The reflectances of BSDFs, each read once.
#[derive(Default)]
pub(super) struct Reflectances {
    known: BTreeMap<usize, Reflectance>,
}

impl Reflectances {
    /// The reflectance of the BSDF `node`.
    pub(super) fn read(&mut self, context: &Context, node: Node) -> Result<Reflectance, String> {
        if let Some(known) = self.known.get(&node.index) {
            return Ok(known.clone());
        }
        let read = self.of(context, node)?;
        self.known.insert(node.index, read.clone());
        Ok(read)
    }

    fn of(&mut self, context: &Context, node: Node) -> Result<Reflectance, String> {
        match node.kind() {
            "diffuse" => Ok(Reflectance::painted(paint(
                context,
                node,
                "reflectance",
                Use::Reflectance,
                0.5,
            )?)),
            "twosided" => self.two_sided(context, node),
            "bumpmap" | "normalmap" => self.bumpy(context, node),
            "mask" => self.mask(context, node),
            "conductor" | "roughconductor" => conductor(context, node),
            "plastic" | "roughplastic" | "pplastic" => plastic(context, node),
            "principled" => principled(context, node),
            "ward" => ward(context, node),
            "blendbsdf" => self.blend(context, node),
            "null" => Ok(Reflectance { is_nothing: true, ..Reflectance::diffuse(Rgb::ZERO) }),
            "dielectric" | "roughdielectric" | "thindielectric" | "principledthin" => {
                Err(node
                    .refused("it lets light through; leave its shapes out, or make them opaque"))
            }
            _ => Err(node.refused("put a diffuse, conductor, plastic or principled in its place")),
        }
    }

    fn inner(&mut self, context: &Context, node: Node) -> Result<Reflectance, String> {
        match node.children("bsdf").first() {
            Some(inside) => self.read(context, *inside),
            None => Err(node.fail(format!("a {} has no BSDF in it", node.kind()))),
        }
    }

    fn two_sided(&mut self, context: &Context, node: Node) -> Result<Reflectance, String> {
        let mut front = Reflectance { is_two_sided: true, ..self.inner(context, node)? };
        if node.children("bsdf").len() > 1 {
            front.doubt("its back has a BSDF of its own, which was left out");
        }
        Ok(front)
    }

    fn bumpy(&mut self, context: &Context, node: Node) -> Result<Reflectance, String> {
        let mut inside = self.inner(context, node)?;
        inside.doubt(format!("its {} was left out", node.kind()));
        Ok(inside)
    }

    fn mask(&mut self, context: &Context, node: Node) -> Result<Reflectance, String> {
        let opacity = paint(context, node, "opacity", Use::Reflectance, 0.5)?;
        let mut inside = self.inner(context, node)?;
        match (opacity.picture, opacity.mean) {
            (None, Rgb::ONE) => {}
            (None, Rgb::ZERO) => inside.is_nothing = true,
            _ => inside.doubt("its mask was left out: it is opaque everywhere"),
        }
        Ok(inside)
    }

    fn blend(&mut self, context: &Context, node: Node) -> Result<Reflectance, String> {
        let weight = share(context, node, "weight", 0.5)?.clamp(0.0, 1.0);
        let [one, two] = node.children("bsdf")[..] else {
            return Err(node.fail("a blendbsdf has two BSDFs in it"));
        };
        let parts = (self.read(context, one)?, self.read(context, two)?);
        let placed = |problem: String| node.fail(problem);
        let mut blend = parts.0.scaled(1.0 - weight, context.scope).map_err(placed)?;
        let two = parts.1.scaled(weight, context.scope).map_err(placed)?;
        if blend.is_nothing || two.is_nothing {
            return Err(node.refused("one of its parts is nothing"));
        }
        two.doubts.iter().for_each(|doubt| blend.doubt(doubt.clone()));
        blend.is_two_sided &= two.is_two_sided;
        let to_uv = two.to_uv;
        let (is_ggx, model) = (two.is_ggx, two.model);
        blend.add_diffuse(two.material.clone(), to_uv, context.scope).map_err(placed)?;
        let shine = two.material;
        let roughness = |m: &Material| (m.alpha_x, m.alpha_y);
        if blend.material.rho_s.max_element() <= 0.0 {
            blend.material.rho_s = shine.rho_s;
            (blend.material.alpha_x, blend.material.alpha_y) = roughness(&shine);
            (blend.is_ggx, blend.model) = (is_ggx, model);
        } else if shine.rho_s.max_element() > 0.0 {
            if roughness(&blend.material) == roughness(&shine) && blend.is_ggx == is_ggx {
                blend.material.rho_s += shine.rho_s;
            } else {
                blend.doubt("it blends two lobes; the second was left out");
            }
        }
        Ok(blend)
    }
}

/// Whether the microfacets are those of GGX.
fn is_ggx(node: Node) -> Result<bool, String> {
    match node.text("distribution")?.unwrap_or("beckmann") {
        "beckmann" => Ok(false),
        "ggx" => Ok(true),
        _ => Err(node.wrong("distribution", "\"beckmann\" or \"ggx\"")),
    }
}

fn conductor(context: &Context, node: Node) -> Result<Reflectance, String> {
    let metal = metals::conductor(context, node)?;
    let scale = color(context, node, "specular_reflectance", Use::Index, 1.0)?;
    let mut read = Reflectance::of(Material::mirror(scale * metal));
    if metal != Rgb::ONE {
        read.doubt("its metal was taken to reflect at all angles as at normal incidence");
    }
    if node.kind() == "roughconductor" {
        let alpha = share(context, node, "alpha", 0.1)?;
        read.material.alpha_x = share(context, node, "alpha_u", alpha)?;
        read.material.alpha_y = share(context, node, "alpha_v", alpha)?;
        read.is_ggx = is_ggx(node)?;
        if !read.is_ggx {
            read.doubt("the roughness of its microfacets was taken as Ward's");
        }
    }
    Ok(read)
}

fn plastic(context: &Context, node: Node) -> Result<Reflectance, String> {
    let diffuse = paint(context, node, "diffuse_reflectance", Use::Reflectance, 0.5)?;
    let index = metals::relative_index(node, 1.49)?;
    let f0 = metals::dielectric(index);
    let inside = metals::diffuse_inside(index);
    // Light that enters is reflected to and fro below the surface; if the plastic is not `nonlinear`,
    // as if it were white there.
    let below = if node.flag("nonlinear", false)? { diffuse.mean } else { Rgb::ONE };
    let through = (1.0 - f0) * (1.0 - inside) / (Rgb::ONE - inside * below);
    let diffuse = diffuse.scaled(through, context.scope).map_err(|problem| node.fail(problem))?;
    let mut read = Reflectance::painted(diffuse);
    read.material.rho_s = f0 * color(context, node, "specular_reflectance", Use::Index, 1.0)?;
    if node.kind() != "plastic" {
        let alpha = share(context, node, "alpha", 0.1)?;
        let (u, v) =
            (share(context, node, "alpha_u", alpha)?, share(context, node, "alpha_v", alpha)?);
        (read.material.alpha_x, read.material.alpha_y) = (u, v);
        read.is_ggx = is_ggx(node)?;
    }
    read.doubt("plastic was taken as it reflects at normal incidence");
    Ok(read)
}

fn principled(context: &Context, node: Node) -> Result<Reflectance, String> {
    let base = paint(context, node, "base_color", Use::Reflectance, 0.5)?;
    if share(context, node, "spec_trans", 0.0)? > 0.0 {
        return Err(node.refused("its spec_trans lets light through; make it opaque"));
    }
    let metallic = share(context, node, "metallic", 0.0)?.clamp(0.0, 1.0);
    let roughness = share(context, node, "roughness", 0.5)?;
    let stretch = (1.0 - 0.9 * share(context, node, "anisotropic", 0.0)?.clamp(0.0, 1.0)).sqrt();
    let f0 = if node.has("eta") {
        metals::dielectric(share(context, node, "eta", 1.5)?)
    } else {
        0.08 * share(context, node, "specular", 0.5)?
    };
    let mean = base.mean;
    let diffuse = base.scaled(Rgb::splat(1.0 - metallic), context.scope);
    let mut read = Reflectance::painted(diffuse.map_err(|problem| node.fail(problem))?);
    read.material.rho_s = Rgb::splat(f0 * (1.0 - metallic)) + metallic * mean;
    read.material.alpha_x = (roughness * roughness / stretch).max(1e-3);
    read.material.alpha_y = (roughness * roughness * stretch).max(1e-3);
    read.is_ggx = true;
    for name in ["sheen", "clearcoat", "flatness", "spec_tint"] {
        if node.has(name) && share(context, node, name, 0.0)? > 0.0 {
            read.doubt(format!("its {name} was left out"));
        }
    }
    read.doubt("principled was taken as a diffuse part and one of GGX, as at normal incidence");
    Ok(read)
}

/// Ward's model, which Mitsuba had up to version 0.6.
fn ward(context: &Context, node: Node) -> Result<Reflectance, String> {
    let model = match node.text("variant")?.unwrap_or("balanced") {
        "ward" => WardModel::Ward1992,
        "ward-duer" => WardModel::WardDuer,
        "balanced" => WardModel::WardGmd,
        _ => return Err(node.wrong("variant", "\"ward\", \"ward-duer\" or \"balanced\"")),
    };
    let diffuse = paint(context, node, "diffuse_reflectance", Use::Reflectance, 0.5)?;
    let mut read = Reflectance::painted(diffuse);
    read.material.rho_s = color(context, node, "specular_reflectance", Use::Reflectance, 0.2)?;
    let alpha = share(context, node, "alpha", 0.1)?;
    read.material.alpha_x = share(context, node, "alpha_u", alpha)?;
    read.material.alpha_y = share(context, node, "alpha_v", alpha)?;
    read.model = Some(BrdfModel::Ward(model));
    Ok(read)
}
