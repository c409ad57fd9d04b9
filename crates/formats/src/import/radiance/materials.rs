//! What surfaces are made of, as groups: a material with all its modifiers, mixtures, and lamps.

use super::kinds::{NO_MIXTURE, NO_PATTERN, NO_TEXTURE, Sort};
use super::lamps::{Far, Spot};
use super::modifiers::{Chain, Definition, Modifiers, Number};
use super::patterns::{Pattern, Pictures, constant};
use super::primitives::Noted;
use super::reflectance::{glass, mixed, reflectance, why_hidden};
use super::sky::{Panorama, Sky};
use crate::input::Scope;
use crate::texels;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use unrender_scene::{BrdfModel, Glass, Group, Material, Rgb, Texture, Warnings};

/// The greatest depth of nested mixtures.
const MIXED: usize = 8;

/// What a modifier makes of a surface.
#[derive(Clone, Debug)]
pub(super) enum Seen {
    /// Nothing that can be seen.
    Nothing,
    /// The group of this number, its roughness along a direction of the world.
    Group(usize, Option<DVec3>),
    /// A lamp without a surface.
    Spot(Spot),
    /// Glass, and the name of the material.
    Glass(String, Glass),
}

/// As [`Seen`], before there is a group for it.
#[derive(Clone)]
enum Look {
    Hidden,
    Surface { material: Material, emission: Rgb, along: Option<DVec3> },
    Spot(Spot),
    Glass(Glass),
}

/// What the patterns of a material do.
struct Tint {
    factor: Rgb,
    texture: Option<Arc<Texture>>,
    sky: Option<Sky>,
    panorama: Option<Panorama>,
    /// The first one that is not constant, for messages.
    varying: Option<String>,
}

/// What has been made so far.
pub(super) struct Materials<'a> {
    /// The limits of reading, and the scene's folder.
    place: (&'a Scope, &'a Path),
    pub(super) modifiers: Modifiers,
    pictures: Pictures,
    /// Each with the definition that it was first made for.
    groups: Vec<(Number, Group)>,
    /// The last group of each name.
    by_name: BTreeMap<String, usize>,
    seen: BTreeMap<Number, Seen>,
    brdf: BrdfModel,
}

impl<'a> Materials<'a> {
    pub(super) fn new(place: (&'a Scope, &'a Path)) -> Self {
        Self {
            place,
            modifiers: Modifiers::default(),
            pictures: Pictures::default(),
            groups: Vec::new(),
            by_name: BTreeMap::new(),
            seen: BTreeMap::new(),
            brdf: BrdfModel::default(),
        }
    }

    /// The lobe of all materials: Radiance's, or that of exact numbers.
    pub(super) fn brdf(&self) -> BrdfModel {
        self.brdf
    }

    /// Adds a modifier.
    pub(super) fn define(&mut self, noted: Noted, warnings: &mut Warnings) -> Result<(), String> {
        let p = &noted.primitive;
        let has_words = super::kinds::kind(&p.kind).is_some_and(|kind| kind.has_words);
        if !has_words && !p.strings.is_empty() {
            warnings.push(format!("{}: the words of {} are not read", p.place, p.named()));
        }
        self.modifiers.define(noted)
    }

    /// The groups that are in `used`, each with its number, in the order of their definitions.
    pub(super) fn groups(&self, used: impl Iterator<Item = usize>) -> Vec<(usize, Group)> {
        let used: BTreeSet<usize> = used.collect();
        let groups = self.groups.iter().enumerate();
        let mut groups: Vec<_> = groups.filter(|(index, _)| used.contains(index)).collect();
        groups.sort_by_key(|(_, (number, _))| *number);
        groups.into_iter().map(|(index, (_, group))| (index, group.clone())).collect()
    }

    /// What the modifier `start` makes of surfaces.
    pub(super) fn seen(&mut self, start: Number, warnings: &mut Warnings) -> Result<Seen, String> {
        if let Some(seen) = self.seen.get(&start) {
            return Ok(seen.clone());
        }
        let chain = self.modifiers.chain(start)?;
        if chain.material.is_none() {
            let definition = self.modifiers.get(start);
            warnings.push(format!(
                "{}: {} has no material behind it; its surfaces are invisible and were left out",
                definition.place,
                definition.shown()
            ));
        }
        let seen = match self.look(&chain, MIXED, warnings)? {
            Look::Hidden => Seen::Nothing,
            Look::Spot(spot) => Seen::Spot(spot),
            Look::Glass(glass) => Seen::Glass(self.name(chain.material.unwrap_or(start)), glass),
            Look::Surface { material, emission, along } => {
                let name = self.name(chain.material.unwrap_or(start));
                let group = Group { name, material, emission };
                // The same material in another direction or behind a texture is the same group.
                let before = self.by_name.get(&group.name).copied();
                let same = before.filter(|before| self.groups[*before].1 == group);
                let index = same.unwrap_or(self.groups.len());
                if same.is_none() {
                    self.by_name.insert(group.name.clone(), index);
                    self.groups.push((chain.material.unwrap_or(start), group));
                }
                Seen::Group(index, along)
            }
        };
        self.seen.insert(start, seen.clone());
        Ok(seen)
    }

    /// The name of the material of this number.
    fn name(&self, number: Number) -> String {
        let definition = self.modifiers.get(number);
        let name = definition.note.as_ref().and_then(|note| note.name.clone());
        name.unwrap_or_else(|| definition.id.clone())
    }

    /// The source far away with the modifier `start`, if that is a lamp that gives light.
    pub(super) fn far(
        &mut self,
        start: Number,
        warnings: &mut Warnings,
    ) -> Result<Option<Far>, String> {
        let chain = self.modifiers.chain(start)?;
        let number = chain.material.filter(|n| self.modifiers.get(*n).sort() == Some(Sort::Lamp));
        let Some(number) = number else { return Ok(None) };
        let tint = self.tint(&chain, warnings)?;
        let lamp = self.modifiers.get(number);
        if tint.sky.is_none() && tint.panorama.is_none() {
            check_brightness(lamp, &tint)?;
        }
        let radiance = color(lamp) * tint.factor;
        let is_glow = lamp.made.kind == "glow";
        match lamp.made.kind.as_str() {
            "spotlight" => return Err(format!("{} is far away, which is not read", lamp.shown())),
            "glow" if lamp.made.reals[3] < 0.0 => {
                warnings.push(unlit(lamp));
                return Ok(None);
            }
            "illum" => warnings.push(visible(lamp)),
            _ => {}
        }
        Ok(Some(Far { radiance, sky: tint.sky, panorama: tint.panorama, is_glow }))
    }

    fn look(
        &mut self,
        chain: &Chain,
        depth: usize,
        warnings: &mut Warnings,
    ) -> Result<Look, String> {
        let Some(number) = chain.material else { return Ok(Look::Hidden) };
        let tint = self.tint(chain, warnings)?;
        let definition = self.modifiers.get(number);
        let shown = format!("{}: {}", definition.place, definition.shown());
        let exact = definition.note.as_ref().and_then(|note| note.material.clone());
        if let Some((_, brdf)) = &exact {
            self.brdf = *brdf;
        }
        if definition.sort() == Some(Sort::Mixture) {
            if tint.varying.is_some() || tint.factor != Rgb::ONE {
                warnings.push(format!("{shown} has a pattern over it, which is not read"));
            }
            return self.mixture(number, depth, warnings);
        }
        if definition.sort() == Some(Sort::Lamp) {
            check_brightness(definition, &tint)?;
            return Ok(lamp(definition, tint.factor, warnings));
        }
        if let Some(glass) = glass(&definition.made, tint.factor) {
            return Ok(Look::Glass(glass));
        }
        if let Some(why) = why_hidden(&definition.made.kind) {
            warnings.push(format!("{shown} {why}"));
            return Ok(Look::Hidden);
        }
        if definition.made.kind == "mirror" && !definition.made.strings.is_empty() {
            warnings.push(format!(
                "{shown} was taken as the material that is seen in its place; it mirrors no lamps"
            ));
            return self.named(number, 0, depth, warnings);
        }
        let shine = self.shine(number, warnings)?;
        let definition = self.modifiers.get(number);
        let found = reflectance(&definition.made, tint.factor, shine)?;
        let emission = Rgb::ZERO;
        if let Some((exact, _)) = exact {
            let material = Material { texture: tint.texture, ..exact };
            return Ok(Look::Surface { material, emission, along: None });
        }
        if let Some(doubt) = found.doubt {
            warnings.push(format!("{shown} {doubt}"));
        }
        let mut material = found.material;
        if let Some(texture) = tint.texture {
            // The texels are the diffuse reflectance itself.
            let color = material.rho_d;
            material.rho_d = color * texels::mean(&texture.image);
            let image = texture.image.map(|texel| *texel * color);
            material.texture = Some(Arc::new(Texture { image, ..(*texture).clone() }));
        }
        Ok(Look::Surface { material, emission, along: found.along })
    }

    /// The look of the modifier that is word number `which` of the definition `number`.
    fn named(
        &mut self,
        number: Number,
        which: usize,
        depth: usize,
        warnings: &mut Warnings,
    ) -> Result<Look, String> {
        let definition = self.modifiers.get(number);
        let name = definition.made.strings.get(which).map_or("", String::as_str);
        if name == "void" {
            return Ok(Look::Hidden);
        }
        let found = definition.named.get(which).copied().flatten();
        let found = found.ok_or_else(|| {
            format!("{} names \"{name}\", which is not there", definition.shown())
        })?;
        let depth = depth.checked_sub(1);
        let depth =
            depth.ok_or_else(|| format!("more than {MIXED} mixtures are in one another"))?;
        let chain = self.modifiers.chain(found)?;
        self.look(&chain, depth, warnings)
    }

    /// Two materials in one; half of each if the mixture is not the same everywhere.
    fn mixture(
        &mut self,
        number: Number,
        depth: usize,
        warnings: &mut Warnings,
    ) -> Result<Look, String> {
        let definition = self.modifiers.get(number);
        let (made, named) = (definition.made.clone(), definition.shown());
        let shown = format!("{}: {named}", definition.place);
        let share = (made.kind == "mixfunc").then(|| made.strings.get(2)).flatten();
        let share = share.and_then(|word| constant(word, &made.reals)).map(|s| s.clamp(0.0, 1.0));
        match share {
            Some(1.0) => return self.named(number, 0, depth, warnings),
            Some(0.0) => return self.named(number, 1, depth, warnings),
            _ => {}
        }
        let one = self.named(number, 0, depth, warnings)?;
        let other = self.named(number, 1, depth, warnings)?;
        let shines = |look: &Look| match look {
            Look::Spot(_) => true,
            Look::Surface { emission, .. } => *emission != Rgb::ZERO,
            Look::Hidden | Look::Glass(_) => false,
        };
        if shines(&one) || shines(&other) {
            return Err(format!(
                "{named} has a lamp in it, whose brightness is not understood; give the lamp's surfaces the \
                 lamp itself"
            ));
        }
        // A mixture has no glass in it.
        let opaque = |look| if matches!(look, Look::Glass(_)) { Look::Hidden } else { look };
        let (one, other) = match (opaque(one), opaque(other)) {
            (Look::Surface { material: a, along, .. }, Look::Surface { material: b, .. }) => {
                ((a, along), b)
            }
            (Look::Hidden, Look::Hidden) => return Ok(Look::Hidden),
            (seen, Look::Hidden) | (Look::Hidden, seen) => {
                warnings.push(format!("{shown} is transparent in part; it was taken as opaque"));
                return Ok(seen);
            }
            (seen, _) => return Ok(seen),
        };
        let (material, is_exact) = mixed(&one.0, &other, share.unwrap_or(0.5));
        if share.is_none() {
            warnings.push(format!("{shown} {NO_MIXTURE}"));
        } else if !is_exact {
            warnings.push(format!("{shown} was taken as one material of the mean reflectance"));
        }
        Ok(Look::Surface { material, emission: Rgb::ZERO, along: one.1 })
    }

    /// The colour of a `WGMDfunc`'s specular part.
    fn shine(&mut self, number: Number, warnings: &mut Warnings) -> Result<Rgb, String> {
        let definition = self.modifiers.get(number);
        let name = definition.made.strings.first().map_or("void", String::as_str);
        if definition.made.kind != "WGMDfunc" || name == "void" {
            return Ok(Rgb::ONE);
        }
        let unread = format!(
            "{} names \"{name}\" as the colour of its highlights, which is not a constant colorfunc; give it one",
            definition.shown()
        );
        let found = definition.named.first().copied().flatten().ok_or_else(|| unread.clone())?;
        let made = self.modifiers.get(found).made.clone();
        match self.pictures.pattern(&made, self.place, warnings)? {
            Pattern::Constant(color) => Ok(color),
            _ => Err(unread),
        }
    }

    /// What the patterns of `chain` do, with warnings for those that are not read and for textures.
    fn tint(&mut self, chain: &Chain, warnings: &mut Warnings) -> Result<Tint, String> {
        let mut tint =
            Tint { factor: Rgb::ONE, texture: None, sky: None, panorama: None, varying: None };
        for &number in &chain.others {
            let definition = self.modifiers.get(number);
            let shown = definition.shown();
            let placed = format!("{}: {shown}", definition.place);
            if definition.sort() == Some(Sort::Texture) {
                warnings.push(format!("{placed} {NO_TEXTURE}"));
                continue;
            }
            let made = definition.made.clone();
            let pattern = self.pictures.pattern(&made, self.place, warnings)?;
            match pattern {
                Pattern::Constant(color) => {
                    tint.factor *= color;
                    continue;
                }
                Pattern::Sky(sky) => tint.sky = Some(sky),
                Pattern::Panorama(panorama) => tint.panorama = Some(panorama),
                Pattern::Picture(texture) => tint.texture = Some(texture),
                Pattern::Mean(color) => {
                    tint.factor *= color;
                    warnings.push(format!(
                        "{placed} is laid out by functions that are not read; its mean colour was taken"
                    ));
                }
                Pattern::Unread => {
                    warnings.push(format!("{placed} {NO_PATTERN}"));
                }
            }
            tint.varying.get_or_insert(shown);
        }
        Ok(tint)
    }
}

/// An error if `lamp` is not equally bright everywhere.
fn check_brightness(lamp: &Definition, tint: &Tint) -> Result<(), String> {
    let Some(pattern) = &tint.varying else { return Ok(()) };
    Err(format!(
        "{} is as bright as {pattern} says, which is not read; give the lamp a brightness of its own: a \
         {} with the modifier void",
        lamp.shown(),
        lamp.made.kind
    ))
}

fn color(lamp: &Definition) -> Rgb {
    let [r, g, b] = lamp.made.vector(0).as_vec3().to_array();
    Rgb::new(r, g, b)
}

/// The look of a surface that is a lamp.
fn lamp(lamp: &Definition, factor: Rgb, warnings: &mut Warnings) -> Look {
    let radiance = color(lamp) * factor;
    let exact = lamp.note.as_ref().and_then(|note| note.material.clone());
    let material = exact.map_or_else(|| Material::diffuse(Rgb::ZERO), |(material, _)| material);
    let mut emission = radiance;
    match lamp.made.kind.as_str() {
        "spotlight" if lamp.made.reals[3] <= 180.0 => {
            let (angle_deg, direction) = (lamp.made.reals[3] as f32, lamp.made.vector(4));
            return Look::Spot(Spot { radiance, angle_deg, direction });
        }
        "glow" if lamp.made.reals[3] < 0.0 => {
            warnings.push(unlit(lamp));
            emission = Rgb::ZERO;
        }
        "illum" => warnings.push(visible(lamp)),
        _ => {}
    }
    Look::Surface { material, emission, along: None }
}

/// The warning of a glow that gives no light.
fn unlit(lamp: &Definition) -> String {
    format!(
        "{}: {} is visible but gives no light (its radius is below zero); here it is black, so \
         mask its pixels",
        lamp.place,
        lamp.shown()
    )
}

/// The warning of an illum.
fn visible(lamp: &Definition) -> String {
    let looks = match lamp.made.strings.first().map(String::as_str) {
        None | Some("void") => "is invisible".to_owned(),
        Some(other) => format!("looks like \"{other}\""),
    };
    format!(
        "{}: {} gives light and {looks}; here the lamp itself is seen, so mask its pixels",
        lamp.place,
        lamp.shown()
    )
}
