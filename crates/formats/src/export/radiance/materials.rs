//! Materials of Radiance: one for each group, or for each anisotropy direction of an anisotropic one.

use super::holes::Holes;
use super::pictures::{place, with_frame, within};
use super::triple;
use crate::export::{Files, SceneView, anisotropy};
use crate::group_detail;
use crate::record::group_note;
use crate::texels;
use glam::Vec3;
use std::fmt::Write;
use unrender_scene::{Image, Material, Object, Rgb, Texture, Warnings};

/// What Radiance does not show of normal maps.
const SMOOTH: &str = "normal maps are left out of files for Radiance, whose textures perturb normals by functions of the place; \
                      model the bumps, or take another format";

/// The names of the groups' materials and what they are made of.
pub(super) struct Materials<'a> {
    shot: &'a SceneView<'a>,
    ids: Vec<String>,
    /// For each group the anisotropy directions of its triangles, without repetitions.
    directions: Vec<Vec<Vec3>>,
}

impl<'a> Materials<'a> {
    /// Those of the groups of `shot`, called `ids`.
    pub(super) fn new(shot: &'a SceneView<'a>, ids: Vec<String>) -> Self {
        let directions = vec![Vec::new(); shot.scene.groups.len()];
        let mut materials = Self { shot, ids, directions };
        for object in &shot.scene.objects {
            for index in 0..object.mesh.triangles.len() {
                let direction = materials.direction(object, index);
                let known = &mut materials.directions[object.group];
                if !known.contains(&direction) {
                    known.push(direction);
                }
            }
        }
        materials
    }

    /// The material of triangle `index` of `object`.
    pub(super) fn of_triangle(&self, object: &Object, index: usize) -> String {
        let direction = self.direction(object, index);
        let known = &self.directions[object.group];
        let id = &self.ids[object.group];
        match known.iter().position(|d| *d == direction) {
            None | Some(0) => id.clone(),
            Some(number) => format!("{id}.{number}"),
        }
    }

    /// Whether the material of `group` is Radiance's `mirror`.
    pub(super) fn is_mirror(&self, group: usize) -> bool {
        self.shot.materials[group].is_pure_mirror()
    }

    /// The anisotropy direction, to four digits; any for isotropic lobes.
    fn direction(&self, object: &Object, index: usize) -> Vec3 {
        let material = &self.shot.materials[object.group];
        if !material.is_glossy() || material.alpha_x == material.alpha_y {
            return Vec3::X;
        }
        let along = anisotropy::direction(&object.mesh, index, material.theta_rad);
        // A direction is a line: of the two ways along it, one.
        let first = along.to_array().into_iter().find(|c| c.abs() > 1e-3).unwrap_or(1.0);
        (along * first.signum() * 1e4).round() / 1e4 + Vec3::ZERO
    }

    /// What Radiance does not show as unrender does.
    pub(super) fn note_doubts(&self, warnings: &mut Warnings) {
        for (group, material) in self.shot.scene.groups.iter().zip(self.shot.materials) {
            let name = &group.name;
            let reflects = material.rho_d.max_element().max(material.rho_s.max_element()) > 0.0;
            if group.is_emitter() && reflects {
                warnings.push(format!("group \"{name}\": a lamp reflects nothing in Radiance"));
            }
        }
        if self.shot.scene.objects.iter().any(|object| object.mesh.detail.normals.is_some()) {
            warnings.push(SMOOTH);
        }
    }

    /// `materials.rad` and the pictures that it names; `others` stands at its end.
    pub(super) fn files(&self, others: &str) -> Result<Files, String> {
        let mut files = Files::new();
        let mut text = String::from("# Materials, written by unrender.\n");
        for (index, group) in self.shot.scene.groups.iter().enumerate() {
            let (id, material) = (&self.ids[index], &self.shot.materials[index]);
            let _ = writeln!(text, "\n# {}", group_note(group, self.shot.scene.brdf));
            if group.is_emitter() {
                let _ = writeln!(text, "void light {id}\n0\n0\n3 {}", triple(group.emission));
                continue;
            }
            let mut pattern = "void".to_owned();
            if let Some(texture) = &material.texture {
                pattern = format!("{id}.texture");
                let picture = format!("textures/{id}.hdr");
                text.push_str(&color_picture(&pattern, &picture, texture));
                files.push((picture, texels::hdr(&framed(texture))?));
            }
            let coverage = group_detail::of_group(self.shot.scene, index).coverage;
            let holes = coverage.map(|coverage| Holes::of(&coverage, id)).transpose()?;
            for (number, direction) in self.directions[index].iter().enumerate() {
                let id = if number == 0 { id.clone() } else { format!("{id}.{number}") };
                let Some(holes) = &holes else {
                    text.push_str(&reflectance(&pattern, &id, material, *direction));
                    continue;
                };
                let inner = format!("{id}.there");
                text.push_str(&reflectance(&pattern, &inner, material, *direction));
                text.push_str(&holes.about(&inner, &id));
            }
            files.extend(holes.map(|holes| holes.picture));
        }
        text.push_str(others);
        files.push(("materials.rad".into(), text.into_bytes()));
        Ok(files)
    }
}

/// The material called `id`; `pattern` colours its diffuse part.
fn reflectance(pattern: &str, id: &str, material: &Material, direction: Vec3) -> String {
    let (rho_d, rho_s) = (material.rho_d, material.rho_s);
    let has_texture = material.texture.is_some();
    if rho_s.max_element() <= 0.0 {
        let color = if has_texture { Rgb::ONE } else { rho_d };
        return format!("{pattern} plastic {id}\n0\n0\n5 {} 0 0\n", triple(color));
    }
    if material.is_pure_mirror() {
        return format!("void mirror {id}\n0\n0\n3 {}\n", triple(rho_s));
    }
    let u = direction.to_array().map(|c| c.to_string()).join(" ");
    let roughness = format!("{} {}", material.alpha_x, material.alpha_y);
    if let Some((kind, color, share)) = one_color(material).filter(|_| !has_texture) {
        return format!("void {kind} {id}\n4 {u} .\n0\n6 {} {share} {roughness}\n", triple(color));
    }
    let color = if has_texture { Rgb::ONE } else { rho_d };
    let [rs_urough, rs_vrough] = [material.alpha_x, material.alpha_y];
    format!(
        "void colorfunc {id}.specular\n4 {} .\n0\n0\n\
         {pattern} WGMDfunc {id}\n13 {id}.specular 1 {rs_urough} {rs_vrough}\n\
         \x20   void 0 0 0\n    void\n    {u} .\n0\n9 {}\n    {}\n    0 0 0\n",
        triple(rho_s),
        triple(color),
        triple(color)
    )
}

/// The kind of material with one colour and one specular share that reflects as `material` does, if
/// there is one; perfect mirrors have none, since Radiance makes them brighter at grazing angles.
fn one_color(material: &Material) -> Option<(&'static str, Rgb, f32)> {
    let (rho_d, rho_s) = (material.rho_d, material.rho_s);
    if material.is_delta() {
        return None;
    }
    if rho_s == Rgb::splat(rho_s.x) && rho_s.x < 1.0 {
        return Some(("plastic2", rho_d / (1.0 - rho_s.x), rho_s.x));
    }
    let color = rho_d + rho_s;
    let share = rho_s.element_sum() / color.element_sum();
    let same_color = (rho_s - color * share).abs().max_element() <= 1e-6;
    same_color.then_some(("metal2", color, share))
}

/// A pattern called `id` that lays `picture`, which is [`framed`], over a mesh by its texture
/// coordinates. Radiance measures pictures in lengths of their shorter side.
fn color_picture(id: &str, picture: &str, texture: &Texture) -> String {
    let (width, height) = (texture.image.width(), texture.image.height());
    let shorter = (width.min(height) + 2) as f32;
    let across = place(&within("Lu", texture.wrap_u), width, shorter);
    let up = place(&within("Lv", texture.wrap_v), height, shorter);
    format!("void colorpict {id}\n7 red green blue ./{picture} . {across} {up}\n0\n0\n")
}

/// The texture with the texels that lie around it, by which those at its edges are interpolated.
fn framed(texture: &Texture) -> Image<Rgb> {
    with_frame(&texture.image, [texture.wrap_u, texture.wrap_v])
}
