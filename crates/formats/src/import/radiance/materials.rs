//! Materials of Radiance as groups.
//!
//! `plastic` and `metal` of colour `c`, specularity `s` and roughness `a` have `rho_d = c (1 - s)`,
//! `rho_s = s` or `c s`, and `a` as both alphas; those with a `2` have two. Where the roughness is
//! zero, Radiance lets them shine at grazing angles, which is left out. `WGMDfunc` has both parts
//! apart. The anisotropy direction of what we did not write is not understood.

use super::Primitive;
use crate::input::Scope;
use crate::record::Note;
use crate::{picture, texels};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use unrender_scene::{BrdfModel, Group, Material, Rgb, Texture, Warnings, Wrap};

/// What has been defined so far.
#[derive(Default)]
pub(super) struct Materials {
    groups: Vec<Group>,
    /// From an identifier to the group; what comes last counts.
    by_id: BTreeMap<String, usize>,
    /// Constant colours by identifier.
    colors: BTreeMap<String, Rgb>,
    /// Pictures by identifier.
    pictures: BTreeMap<String, Arc<Texture>>,
    brdf: BrdfModel,
}

impl Materials {
    /// The lobe that all of it means: Radiance's, or that of exact numbers.
    pub(super) fn brdf(&self) -> BrdfModel {
        self.brdf
    }

    /// The group called `id`.
    pub(super) fn find(&self, id: &str) -> Result<usize, String> {
        let found = self.by_id.get(id).copied();
        found.ok_or_else(|| format!("a surface is made of \"{id}\", which is not there"))
    }

    /// What the group emits.
    pub(super) fn emission(&self, group: usize) -> Rgb {
        self.groups[group].emission
    }

    /// The groups that are in `used`, or that we wrote, each with its index.
    pub(super) fn groups(&self, used: impl Iterator<Item = usize>) -> Vec<(usize, Group)> {
        let used: std::collections::BTreeSet<usize> = used.collect();
        let groups = self.groups.iter().cloned().enumerate();
        groups.filter(|(index, _)| used.contains(index)).collect()
    }

    /// Takes in a material or a pattern.
    pub(super) fn add(
        &mut self,
        primitive: &Primitive,
        note: Option<&Note>,
        (scope, folder): (&Scope, &Path),
        warnings: &mut Warnings,
    ) -> Result<(), String> {
        let id = primitive.id.clone();
        match primitive.kind.as_str() {
            "colorfunc" => {
                let channels = primitive.strings.iter().take(3).map(|s| s.parse().ok());
                if let Some([r, g, b]) = channels
                    .collect::<Option<Vec<f32>>>()
                    .and_then(|c| <[f32; 3]>::try_from(c).ok())
                {
                    self.colors.insert(id, Rgb::new(r, g, b));
                }
                return Ok(());
            }
            "colorpict" => {
                let name = primitive.strings.get(3).ok_or("a colorpict names no picture")?;
                let path = scope.beside(folder, name).map_err(|p| format!("\"{name}\" {p}"))?;
                self.pictures.insert(id, texture(scope, &path, primitive)?);
                return Ok(());
            }
            kind if kind.ends_with("func") && kind != "WGMDfunc" || kind.ends_with("text") => {
                warnings.push(format!("the {kind} \"{id}\" was left out"));
                return Ok(());
            }
            _ => {}
        }
        let group = match note.filter(|note| !note.is_first) {
            // Another anisotropy direction of the group before.
            Some(_) if self.continues(note) => self.groups.len() - 1,
            _ => {
                let group = self.group(primitive, note, warnings)?;
                self.groups.push(group);
                self.groups.len() - 1
            }
        };
        self.by_id.insert(id, group);
        Ok(())
    }

    /// Whether the last group is the one that `note` is about.
    fn continues(&self, note: Option<&Note>) -> bool {
        let name = note.and_then(|note| note.name.as_ref());
        name.is_some() && self.groups.last().map(|group| &group.name) == name
    }

    fn group(
        &mut self,
        primitive: &Primitive,
        note: Option<&Note>,
        warnings: &mut Warnings,
    ) -> Result<Group, String> {
        let texture = self.pictures.get(&primitive.modifier).cloned();
        let name = note.and_then(|n| n.name.clone()).unwrap_or_else(|| primitive.id.clone());
        let (mut material, emission) = self.reflectance(primitive, warnings)?;
        if let Some((exact, brdf)) = note.and_then(|note| note.material.clone()) {
            material = exact;
            self.brdf = brdf;
        } else if let Some(texture) = &texture {
            material.rho_d *= texels::mean(&texture.image);
        }
        material.texture = texture;
        Ok(Group { name, material, emission })
    }

    fn reflectance(
        &self,
        p: &Primitive,
        warnings: &mut Warnings,
    ) -> Result<(Material, Rgb), String> {
        let dark = Material::diffuse(Rgb::ZERO);
        let color = Rgb::from_slice(&[p.reals.clone(), vec![0.0; 3]].concat());
        let material = match p.kind.as_str() {
            "light" | "illum" | "glow" | "spotlight" => return Ok((dark, color)),
            "mirror" => Material::mirror(color),
            "plastic" | "metal" => {
                let [_, _, _, share, alpha] = p.reals()?;
                colored(&p.kind, color, share, [alpha, alpha])
            }
            "plastic2" | "metal2" => {
                let [_, _, _, share, alpha_x, alpha_y] = p.reals()?;
                colored(&p.kind, color, share, [alpha_x, alpha_y])
            }
            "WGMDfunc" => {
                let number = |i: usize| p.strings.get(i).and_then(|s| s.parse::<f32>().ok());
                let colored = p.strings.first().and_then(|id| self.colors.get(id));
                let rho_s = colored.copied().unwrap_or(Rgb::ONE) * number(1).unwrap_or(0.0);
                let alphas = [2, 3].map(|i| number(i).unwrap_or(0.0));
                let [alpha_x, alpha_y] = alphas;
                Material { rho_s, alpha_x, alpha_y, ..Material::diffuse(color) }
            }
            kind => {
                let id = &p.id;
                warnings.push(format!(
                    "the {kind} \"{id}\" is not known; it was taken as diffuse with rho_d = 0.5"
                ));
                Material::diffuse(Rgb::splat(0.5))
            }
        };
        Ok((material, Rgb::ZERO))
    }
}

fn colored(kind: &str, color: Rgb, share: f32, [alpha_x, alpha_y]: [f32; 2]) -> Material {
    let shine = if kind.starts_with("metal") { color } else { Rgb::ONE };
    let material = Material::diffuse(color * (1.0 - share));
    Material { rho_s: shine * share, alpha_x, alpha_y, ..material }
}

/// The picture of a `colorpict`. In ours the texels around it are there too, and how it goes on is
/// told by the expression of its place.
fn texture(scope: &Scope, path: &Path, primitive: &Primitive) -> Result<Arc<Texture>, String> {
    let (read, _) = picture::read_in(scope, path).map_err(|error| error.to_string())?;
    let mut image = read.to_linear().map(|texel| middle_of_step(*texel));
    let is_ours = primitive.id.ends_with(".texture") && image.width() > 2 && image.height() > 2;
    if is_ours {
        let framed = image;
        image = unrender_scene::Image::from_fn(framed.width() - 2, framed.height() - 2, |x, y| {
            *framed.at(x + 1, y + 1)
        });
    }
    let wrap = |place: usize| match primitive.strings.get(place) {
        Some(text) if text.contains("abs(") => Wrap::MirroredRepeat,
        Some(text) if text.contains("if(") => Wrap::ClampToEdge,
        _ => Wrap::Repeat,
    };
    Ok(Arc::new(Texture { image, wrap_u: wrap(5), wrap_v: wrap(6) }))
}

/// Radiance takes the eight bits of a channel for the middle of their step, readers of pictures for
/// its lower end. The largest channel has a mantissa of 128 to 255 steps.
fn middle_of_step(texel: Rgb) -> Rgb {
    let largest = texel.max_element();
    if largest <= 0.0 {
        return texel;
    }
    texel + Rgb::splat(0.5 * (largest.log2().floor() - 7.0).exp2())
}
