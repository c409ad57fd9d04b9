//! A material in artists' units: as sRGB, and as `unrender export --to blender` writes it.

use crate::converted;
use crate::run::ArtistEntry;
use unrender_formats::export::{BlenderInputs, Target};
use unrender_scene::{BrdfModel, Material};

/// The entry of `material`, whose lobe is that of `model`. The export also corrects the brightness of a lobe that
/// Blender does not have where the camera sees it; that changes neither *Base Color* nor *Roughness*.
pub(super) fn entry(model: BrdfModel, material: &Material) -> ArtistEntry {
    let plain = Material { texture: None, ..material.clone() };
    let blender = Target::Blender;
    let kept = if blender.keeps(plain.reflectance) { plain } else { plain.freed() };
    let inputs = BlenderInputs::of(&converted::convert(&kept, model, blender.lobe(model)).material);
    let (rho_d, rho_s) = (material.rho_d, material.rho_s);
    let is_darker = rho_d.element_sum() < rho_s.element_sum();
    ArtistEntry {
        color: super::hex(if is_darker { rho_s } else { rho_d }),
        base_color: super::hex(inputs.base_color),
        roughness: inputs.roughness,
        metallic: inputs.is_metal,
        ior: inputs.ior,
        glossy: inputs.is_glossy,
    }
}
