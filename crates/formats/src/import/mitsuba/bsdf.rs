//! BSDFs as diffuse part, specular part and roughness.
//!
//! Exact: `diffuse`, `conductor` without a metal, `twosided` and `blendbsdf` of these, and the `ward` of Mitsuba
//! 0.5. Conductors with a metal, `plastic`, `roughplastic` and `pplastic` are metals and dielectrics
//! ([`plastics`](super::plastics)) of GGX microfacets; Beckmann's of the same roughness are taken as these, with a warning.
//! `principled` is the nearest of the two. BSDFs that let light through are glass ([`glass`](super::glass)); normals
//! and holes by texture coordinate: [`relief`](super::relief).
//! Models that only Mitsuba 0.5 and 0.6 have become the nearest ones of ours, with a warning: `phong`, (n + 2) / (2 pi) cos^n
//! about the mirror direction, a lobe of alpha = 1 / sqrt(2 (n + 2)), which is as high at normal incidence as Ward's of that
//! width; `roughdiffuse` the Lambertian reflectance of the same albedo; `coating` a darker base under the coat's lobe.

use super::glass;
use super::metals;
use super::oren_nayar;
use super::paint::{Context, Paint, Picture, color, paint, share};
use super::plastics::Surface;
use super::relief::{self, Relief};
use super::spectrum::Use;
use super::tree::Node;
use crate::input::Scope;
use crate::relief::{holes, is_veil};
use glam::Affine2;
use std::collections::BTreeMap;
use std::sync::Arc;
use unrender_scene::reflectance::{IOR_MAX, f0_of_ior, ior_of_f0};
use unrender_scene::{BrdfModel, Glass, Layering, LobeAlbedo, Material, Rgb, Texture, WardModel};

/// The doubt about the lobes of other microfacets.
pub(super) const BECKMANN: &str =
    "the roughness of its Beckmann microfacets was taken as that of GGX";

/// The doubt about half-transparent places.
const VEIL: &str = "half-transparent places of its mask are taken as there or not, by half";

/// The doubt about the anisotropy below turned pictures.
const TURNED: &str = "its texture's to_uv turns or mirrors it, but the anisotropy is not turned";

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
    /// The glass that it is, if it lets light through.
    pub(super) glass: Option<Glass>,
    /// Normals and holes, which lie as the texture does.
    pub(super) relief: Relief,
    doubts: Vec<String>,
}

impl Reflectance {
    fn of(material: Material) -> Self {
        let (to_uv, doubts) = (Affine2::IDENTITY, Vec::new());
        let (is_two_sided, is_nothing, glass) = (false, false, None);
        let (is_ggx, model, relief) = (false, None, Relief::default());
        Self { material, to_uv, is_ggx, model, is_two_sided, is_nothing, glass, relief, doubts }
    }

    fn clear((glass, doubts): glass::Read) -> Self {
        let mut clear = Self { glass: Some(glass), ..Self::diffuse(Rgb::ZERO) };
        doubts.into_iter().for_each(|doubt| clear.doubt(doubt));
        clear
    }

    pub(super) fn diffuse(rho_d: Rgb) -> Self {
        Self::of(Material::diffuse(rho_d))
    }

    fn painted(paint: Paint) -> Self {
        let mut painted = Self::diffuse(paint.mean);
        if let Some(picture) = paint.picture {
            if picture.turns() {
                painted.doubt(TURNED);
            }
            let Picture { texture, to_uv } = picture;
            (painted.material.texture, painted.to_uv) = (Some(texture), to_uv);
        }
        painted
    }

    /// Gives it the roughness of `node`.
    fn roughen(&mut self, context: &Context, node: Node) -> Result<(), String> {
        let alpha = share(context, node, "alpha", 0.1)?;
        self.material.alpha_x = share(context, node, "alpha_u", alpha)?;
        self.material.alpha_y = share(context, node, "alpha_v", alpha)?;
        self.is_ggx = is_ggx(node)?;
        if !self.is_ggx {
            self.doubt(BECKMANN);
        }
        Ok(())
    }

    /// The same with a free reflectance, which can be added to others.
    fn freed(mut self) -> Self {
        if !self.material.reflectance.is_free() {
            self.material = self.material.freed();
            self.doubt(
                "its plastics and metals reflect as at normal incidence, as they are blended",
            );
        }
        self
    }

    /// Whether it depends on texture coordinates.
    pub(super) fn wants_uvs(&self) -> bool {
        self.has_picture() || self.material.alpha_x != self.material.alpha_y
    }

    fn has_picture(&self) -> bool {
        self.material.texture.is_some() || !self.relief.is_none()
    }

    /// Whether a further picture whose texture coordinates are by `to_uv` can lie on it, as all of its pictures lie in the
    /// same way.
    fn admits(&mut self, picture: &Picture) -> bool {
        if !self.has_picture() {
            self.to_uv = picture.to_uv;
            if picture.turns() {
                self.doubt(TURNED);
            }
        }
        self.to_uv == picture.to_uv
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
            (None, Some(_)) if !self.relief.is_none() && self.to_uv != to_uv => {
                self.doubt(
                    "its texture lies otherwise than its normals or holes; its mean was taken",
                );
                return Ok(());
            }
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
            "principledthin" => principled_thin(context, node),
            "ward" => ward(context, node),
            "blendbsdf" => self.blend(context, node),
            "null" => Ok(Reflectance { is_nothing: true, ..Reflectance::diffuse(Rgb::ZERO) }),
            "dielectric" | "roughdielectric" | "thindielectric" => {
                glass::dielectric(context, node).map(Reflectance::clear)
            }
            "phong" => phong(context, node),
            "coating" | "roughcoating" => coated(context, node, self.inner(context, node)?),
            "roughdiffuse" => rough_diffuse(context, node),
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
        let (mut inside, kind) = (self.inner(context, node)?, node.kind());
        let Some((bumps, picture, is_coded)) = relief::bumps(context, node)? else {
            inside.doubt(format!("its {kind} was left out"));
            return Ok(inside);
        };
        if inside.relief.bumps.is_some() {
            inside.doubt(format!("its {kind} was left out, as there is another one in it"));
        } else if inside.admits(&picture) {
            inside.relief.bumps = Some(bumps);
            if is_coded {
                inside.doubt("the picture of its normalmap was taken as raw, as normals are");
            }
        } else {
            inside.doubt(format!(
                "its {kind} was left out, as its to_uv is not that of its other pictures"
            ));
        }
        Ok(inside)
    }

    fn mask(&mut self, context: &Context, node: Node) -> Result<Reflectance, String> {
        let opacity = paint(context, node, "opacity", Use::Reflectance, 0.5)?;
        let mut inside = self.inner(context, node)?;
        match (opacity.picture, opacity.mean) {
            (None, Rgb::ONE) => {}
            (None, Rgb::ZERO) => inside.is_nothing = true,
            (None, _) if inside.glass.is_some() => inside.doubt("its mask was left out"),
            (Some(picture), _) if inside.relief.holes.is_none() && inside.admits(&picture) => {
                let alpha = relief::opacity(&picture.texture, context.scope);
                let alpha = alpha.map_err(|problem| node.fail(problem))?;
                if is_veil(&alpha.image) {
                    inside.doubt(VEIL);
                }
                inside.relief.holes = holes(alpha);
            }
            (Some(_), _) => inside.doubt(
                "its mask was left out, as its to_uv is not that of its other pictures: it is opaque everywhere",
            ),
            _ => inside.doubt("its mask was left out: it is opaque everywhere"),
        }
        Ok(inside)
    }

    fn blend(&mut self, context: &Context, node: Node) -> Result<Reflectance, String> {
        let weight = share(context, node, "weight", 0.5)?.clamp(0.0, 1.0);
        let [one, two] = node.children("bsdf")[..] else {
            return Err(node.fail("a blendbsdf has two BSDFs in it"));
        };
        let parts = (self.read(context, one)?.freed(), self.read(context, two)?.freed());
        let placed = |problem: String| node.fail(problem);
        let mut blend = parts.0.scaled(1.0 - weight, context.scope).map_err(placed)?;
        let two = parts.1.scaled(weight, context.scope).map_err(placed)?;
        if let Some(part) = [&blend, &two].into_iter().find(|part| part.glass.is_some()) {
            let mut clear = part.clone();
            clear.doubt("it is blended with another BSDF, which was left out");
            return Ok(clear);
        }
        if blend.is_nothing || two.is_nothing {
            return Err(node.refused("one of its parts is nothing"));
        }
        two.doubts.iter().for_each(|doubt| blend.doubt(doubt.clone()));
        if !(blend.relief.is_none() && two.relief.is_none()) {
            blend
                .doubt("it blends two surfaces; the normals and holes of the first count for both");
        }
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
        // Those of Mitsuba 0.5 have the width of Beckmann's of the same alpha.
        "beckmann" | "phong" | "as" => Ok(false),
        "ggx" => Ok(true),
        _ => Err(node.wrong("distribution", "\"beckmann\", \"ggx\", \"phong\" or \"as\"")),
    }
}

fn conductor(context: &Context, node: Node) -> Result<Reflectance, String> {
    let metal = metals::conductor(context, node)?;
    let scale = color(context, node, "specular_reflectance", Use::Index, 1.0)?;
    let mut read = Reflectance::of(Material::mirror(scale * metal));
    if metal != Rgb::ONE {
        read.material = Material::metal(scale * metal, false, 0.0);
    }
    if node.kind() == "roughconductor" {
        read.roughen(context, node)?;
    }
    Ok(read)
}

fn plastic(context: &Context, node: Node) -> Result<Reflectance, String> {
    let diffuse = paint(context, node, "diffuse_reflectance", Use::Reflectance, 0.5)?;
    let index = metals::relative_index(node, 1.49)?;
    let shine = color(context, node, "specular_reflectance", Use::Index, 1.0)?;
    let is_nonlinear = node.flag("nonlinear", false)?;
    let mut lobe = Reflectance::of(Material::plastic(Rgb::ZERO, index, Layering::Coupled, 0.0));
    if node.kind() != "plastic" {
        lobe.roughen(context, node)?;
    }
    let Material { alpha_x, alpha_y, .. } = lobe.material;
    let surface = Surface::new(index, (alpha_x * alpha_y).sqrt());
    let base = diffuse.mapped(|texel| surface.base(texel, is_nonlinear), context.scope);
    let read = Reflectance::painted(base.map_err(|problem| node.fail(problem))?);
    let Material { rho_d, texture, .. } = read.material;
    let mut read = Reflectance {
        material: Material { rho_d, texture, ..lobe.material },
        is_ggx: lobe.is_ggx,
        ..read
    };
    lobe.doubts.into_iter().for_each(|doubt| read.doubt(doubt));
    if index <= 1.0 || shine == Rgb::ZERO {
        read.material = read.material.without_lobe();
    } else if shine != Rgb::ONE {
        read.doubt("the colour of its specular reflectance was left out: Fresnel's has none");
    }
    Ok(read)
}

fn principled(context: &Context, node: Node) -> Result<Reflectance, String> {
    let base = paint(context, node, "base_color", Use::Reflectance, 0.5)?;
    if let Some(glass) = glass::principled(context, node, base.mean)? {
        return Ok(Reflectance::clear(glass));
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
    let alpha = roughness * roughness;
    let lobe = match metallic {
        1.0 => Material::metal(mean, false, alpha),
        0.0 if f0 > 0.0 && f0 <= f0_of_ior(IOR_MAX) => {
            Material::plastic(Rgb::ZERO, ior_of_f0(f0), Layering::AlbedoScaled, alpha)
        }
        _ => Material::isotropic(
            Rgb::ZERO,
            Rgb::splat(f0 * (1.0 - metallic)) + metallic * mean,
            alpha,
        ),
    };
    let Material { rho_d, texture, .. } = read.material;
    read.material = Material { rho_d, texture, ..lobe };
    read.material.alpha_x = (alpha / stretch).max(1e-3);
    read.material.alpha_y = (alpha * stretch).max(1e-3);
    read.is_ggx = true;
    for name in ["sheen", "clearcoat", "flatness", "spec_tint"] {
        if node.has(name) && share(context, node, name, 0.0)? > 0.0 {
            read.doubt(format!("its {name} was left out"));
        }
    }
    read.doubt("principled was taken as a metal, or as a plastic whose base is Lambertian");
    Ok(read)
}

/// The thin sheet `node`: glass, or what of it reflects.
fn principled_thin(context: &Context, node: Node) -> Result<Reflectance, String> {
    let base = paint(context, node, "base_color", Use::Reflectance, 0.5)?;
    if let Some(glass) = glass::principled(context, node, base.mean)? {
        return Ok(Reflectance::clear(glass));
    }
    let kept = 1.0 - 0.5 * share(context, node, "diff_trans", 0.0)?.clamp(0.0, 2.0);
    node.pass_all();
    let reflected = base.scaled(Rgb::splat(kept), context.scope);
    let reflected = Reflectance::painted(reflected.map_err(|problem| node.fail(problem))?);
    let mut read = Reflectance { is_two_sided: true, ..reflected };
    read.doubt("principledthin was taken as a Lambertian reflectance; what it scatters through was left out");
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

/// The lobe of Phong, which Mitsuba had up to version 0.6.
fn phong(context: &Context, node: Node) -> Result<Reflectance, String> {
    let diffuse = paint(context, node, "diffuse_reflectance", Use::Reflectance, 0.5)?;
    let exponent = share(context, node, "exponent", 30.0)?;
    let alpha = (0.5 / (exponent + 2.0)).sqrt();
    let specular = color(context, node, "specular_reflectance", Use::Index, 0.2)?;
    // Mitsuba makes both darker where they would reflect more light than there is.
    let share = 1.0 / (diffuse.mean + specular).max_element().max(1.0);
    let diffuse = diffuse.scaled(Rgb::splat(share), context.scope);
    let mut read = Reflectance::painted(diffuse.map_err(|problem| node.fail(problem))?);
    read.material.rho_s = share * specular;
    (read.material.alpha_x, read.material.alpha_y) = (alpha, alpha);
    read.doubt("phong was taken as a lobe that is as high and as wide at normal incidence");
    Ok(read)
}

/// The BSDF `node`, a dielectric coat over `inner`: over a diffuse one a plastic, whose light is not reflected to and fro below
/// the coat in Mitsuba; another one gets darker, as light goes through the coat twice.
fn coated(context: &Context, node: Node, inner: Reflectance) -> Result<Reflectance, String> {
    let index = metals::relative_index(node, 1.5046)?;
    let coat = color(context, node, "specular_reflectance", Use::Reflectance, 1.0)?;
    if inner.glass.is_some() || inner.is_nothing {
        return Ok(inner);
    }
    let (inner, is_rough) = (inner.freed(), node.kind() == "roughcoating");
    let alpha = if is_rough { share(context, node, "alpha", 0.1)? } else { 0.0 };
    let leaving = (1.0 - LobeAlbedo::kept_out(index, alpha).mean().value) / (index * index);
    let f0 = metals::dielectric(index);
    let below = inner.material.rho_s * (1.0 - f0).powi(2);
    let is_dull = below.max_element() <= 0.0;
    let through = if is_dull { leaving } else { (1.0 - f0) * leaving };
    let mut read = inner.scaled(through, context.scope).map_err(|problem| node.fail(problem))?;
    if !is_dull {
        read.material.rho_s = below;
        read.doubt("its coating only darkens it; the coating's own reflection was left out");
    } else if index > 1.0 && coat != Rgb::ZERO {
        let lobe = Material::plastic(Rgb::ZERO, index, Layering::Coupled, alpha);
        let Material { rho_d, texture, .. } = read.material;
        read.material = Material { rho_d, texture, ..lobe };
        (read.is_ggx, read.model) = (is_rough && is_ggx(node)?, None);
        if coat != Rgb::ONE {
            read.doubt("the colour of its specular reflectance was left out: Fresnel's has none");
        }
    }
    Ok(read)
}

fn rough_diffuse(context: &Context, node: Node) -> Result<Reflectance, String> {
    let diffuse = paint(context, node, "reflectance", Use::Reflectance, 0.5)?;
    let alpha = f64::from(share(context, node, "alpha", 0.2)?);
    let is_fast = node.flag("use_fast_approx", false)?;
    let [once, twice] = oren_nayar::albedo(alpha, is_fast).map(|factor| factor as f32);
    let mean = diffuse.mean;
    let scaled = diffuse.scaled(Rgb::splat(once) + twice * mean, context.scope);
    let mut read = Reflectance::painted(scaled.map_err(|problem| node.fail(problem))?);
    read.doubt("roughdiffuse was taken as a Lambertian reflectance of the same albedo");
    Ok(read)
}
