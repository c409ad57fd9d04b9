//! Changing the material of a group.

use crate::stage::{Stage, some_names};
use std::sync::Arc;
use unrender_scene::{Material, Reflectance, Rgb, Texture};

/// Changes the material of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct Repaint {
    /// The group's name.
    pub group: String,
    /// The new parameters.
    pub paint: Paint,
}

/// New parameters of a material; those that are `None` are kept.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Paint {
    /// Diffuse reflectance; replaces a texture.
    pub rho_d: Option<Rgb>,
    /// Specular reflectance; a plastic gets a free one by it.
    pub rho_s: Option<Rgb>,
    /// Roughness along the anisotropy direction.
    pub alpha_x: Option<f32>,
    /// Roughness across it.
    pub alpha_y: Option<f32>,
    /// Anisotropy direction, radians from the surface's tangent.
    pub theta_rad: Option<f32>,
    /// Diffuse reflectance over the surface, by its `TEXCOORD_0`.
    pub texture: Option<Arc<Texture>>,
    /// Factor on the diffuse reflectance or its texture, after those.
    pub tint: Option<Rgb>,
}

/// The error that one of the two roughnesses of a material is zero and the other is not.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "alpha_x is {alpha_x} and alpha_y is {alpha_y}; both are positive or, for a mirror, both zero"
)]
#[non_exhaustive]
pub struct RoughnessError {
    /// The roughness along the anisotropy direction.
    pub alpha_x: f32,
    /// The one across it.
    pub alpha_y: f32,
}

impl Paint {
    /// Applies the parameters to `material`.
    ///
    /// ```
    /// use unrender_restage::repaint::Paint;
    /// use unrender_scene::{Material, Rgb};
    ///
    /// let mut material = Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.1), 0.05);
    /// let paint = Paint { alpha_x: Some(0.3), alpha_y: Some(0.3), ..Paint::default() };
    /// paint.onto(&mut material)?;
    /// assert_eq!((material.rho_d, material.alpha_x), (Rgb::splat(0.2), 0.3));
    /// # Ok::<(), unrender_restage::repaint::RoughnessError>(())
    /// ```
    ///
    /// # Errors
    /// If only one of the two roughnesses is zero.
    pub fn onto(&self, material: &mut Material) -> Result<(), RoughnessError> {
        if let Some(rho_d) = self.rho_d {
            material.rho_d = rho_d;
            material.texture = None;
        }
        if let Some(texture) = &self.texture {
            let texels = texture.image.pixels();
            let sum: glam::DVec3 = texels.iter().map(|rho| rho.as_dvec3()).sum();
            material.rho_d = (sum / texels.len().max(1) as f64).as_vec3();
            material.texture = Some(texture.clone());
        }
        if let Some(tint) = self.tint {
            material.rho_d *= tint;
            if let Some(texture) = &mut material.texture {
                let image = texture.image.map(|rho| (*rho * tint).min(Rgb::ONE));
                *texture = Arc::new(Texture { image, ..(**texture).clone() });
            }
        }
        if let Some(rho_s) = self.rho_s {
            material.rho_s = rho_s;
            // A dielectric's is fixed by its refractive index.
            if matches!(material.reflectance, Reflectance::Dielectric { .. }) {
                material.reflectance = Reflectance::Free;
            }
        }
        material.alpha_x = self.alpha_x.unwrap_or(material.alpha_x);
        material.alpha_y = self.alpha_y.unwrap_or(material.alpha_y);
        material.theta_rad = self.theta_rad.unwrap_or(material.theta_rad);
        if material.is_glossy() && (material.alpha_x > 0.0) != (material.alpha_y > 0.0) {
            let Material { alpha_x, alpha_y, .. } = *material;
            return Err(RoughnessError { alpha_x, alpha_y });
        }
        Ok(())
    }
}

pub(crate) fn apply(repaint: &Repaint, stage: &mut Stage<'_>) -> Result<(), String> {
    let name = repaint.group.as_str();
    stage.claim("group", name)?;
    let Some(group) = stage.scene.group_index(name) else {
        let there = some_names(name, stage.scene.groups.iter().map(|g| g.name.as_str()));
        return Err(format!("the scene has no group \"{name}\" to repaint; it has {there}"));
    };
    if !stage.scene.objects.iter().any(|object| object.group == group) {
        return Err(format!("the group \"{name}\" has no surface left to repaint; it was removed"));
    }
    let bare = |o: &&unrender_scene::Object| o.group == group && o.mesh.uvs.is_empty();
    if repaint.paint.texture.is_some()
        && let Some(object) = stage.scene.objects.iter().find(bare)
    {
        return Err(format!(
            "object \"{}\" of group \"{name}\" has no TEXCOORD_0 for a texture; unwrap it in the \
             scene",
            object.name
        ));
    }
    let painted = repaint.paint.onto(&mut stage.scene.groups[group].material);
    painted.map_err(|error| error.to_string())
}
