//! glTF's metallic-roughness materials in the words of [`crate::principled`]: `alpha = roughness^2` and
//! `F0 = ((ior - 1)/(ior + 1))^2 specularColor specular`.

use super::document::MaterialExtensions;
use super::ward;
use crate::principled::{Coat, Principled, Reading};
use unrender_scene::reflectance::{IOR, f0_of_ior};
use unrender_scene::{BrdfModel, Material, Rgb};

/// The material of glTF's parameters.
pub(super) fn from_gltf(
    (base, metallic, roughness): (Rgb, f32, f32),
    extensions: &MaterialExtensions,
    model: BrdfModel,
) -> Reading {
    let stated = stated((base, metallic, roughness), extensions);
    let reading = stated.material(model);
    let has_lobe = reading.is_own_lobe && reading.material.rho_s.max_element() > 0.0;
    let material =
        if has_lobe { ward::turned(reading.material, extensions) } else { reading.material };
    Reading { material, ..reading }
}

fn stated(
    (base, metallic, roughness): (Rgb, f32, f32),
    extensions: &MaterialExtensions,
) -> Principled {
    let alpha = roughness * roughness;
    Principled {
        base,
        metallic,
        alpha,
        f0: ward::dielectric_f0(extensions),
        coat: coat(extensions),
    }
}

fn coat(extensions: &MaterialExtensions) -> Option<Coat> {
    let coat = extensions.clearcoat.as_ref()?;
    let factor = coat.clearcoat_factor.clamp(0.0, 1.0) as f32;
    let roughness = coat.clearcoat_roughness_factor.clamp(0.0, 1.0) as f32;
    let coat = Coat { f0: factor * f0_of_ior(IOR), alpha: roughness * roughness };
    (factor > 0.0).then_some(coat)
}

/// Whether there is a clearcoat that is not the material's lobe.
pub(super) fn leaves_coat_out(material: &Material, extensions: &MaterialExtensions) -> bool {
    stated((Rgb::ZERO, 0.0, 0.0), extensions).leaves_coat_out(material)
}
