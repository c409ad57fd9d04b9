//! Ward's parameters in the words of glTF materials, both ways.
//!
//! **Reading** a metallic-roughness material of base colour `c`, metallic `m`, roughness `r`:
//! `rho_d = (1 - m) c`, `rho_s = m c + (1 - m) F0` and `alpha = r^2`, where
//! `F0 = min(((ior - 1)/(ior + 1))^2 specularColor, 1) specular` counts only if `r < 1`. Rough
//! dielectrics (`r = 1`, `m = 0`) are thus plainly diffuse.
//! `KHR_materials_anisotropy` of strength `s` and rotation `t` has the roughness `alpha` across and
//! `alpha + (1 - alpha) s^2` along the angle `t`; Ward's anisotropy direction is the smoother one,
//! so `alpha_x = alpha`, `alpha_y = alpha + (1 - alpha) s^2`, `theta = t + pi/2`.
//!
//! **Writing** inverts that as far as glTF allows. Without a diffuse part the material is a
//! metal of colour `rho_s`; else a dielectric of colour `rho_d` whose ior is the least (from 1.5
//! on) that reaches `rho_s` with a specular colour of at most one. Nothing is lost: the exact
//! numbers stand in `extras.unrender`, and reading prefers them.

use super::document::MaterialExtensions;
use super::transform;
use crate::numbers::{number, triple};
use crate::record::Record;
use serde_json::{Map, Value, json};
use std::f32::consts::{FRAC_PI_2, PI};
use unrender_scene::reflectance::IOR;
use unrender_scene::{BrdfModel, Material, Reflectance, Rgb};

/// The key in `extras` under which the exact numbers stand.
pub(super) const EXTRAS_KEY: &str = "unrender";
/// The extensions that [`assign_material`] sets and removes.
pub(super) const EXTENSIONS: [&str; 3] =
    ["KHR_materials_specular", "KHR_materials_ior", "KHR_materials_anisotropy"];

const GLASS_IOR: f64 = 1.5;

/// The isotropic `material`, brushed as `KHR_materials_anisotropy` has it.
pub(super) fn turned(mut material: Material, extensions: &MaterialExtensions) -> Material {
    let alpha = material.alpha_x;
    if let Some(anisotropy) = &extensions.anisotropy {
        let strength = (anisotropy.anisotropy_strength as f32).clamp(0.0, 1.0);
        if strength > 0.0 {
            material.alpha_y = alpha + (1.0 - alpha) * strength * strength;
            material.theta_rad = (anisotropy.anisotropy_rotation as f32 + FRAC_PI_2).rem_euclid(PI);
        }
    }
    material
}

/// The reflectance of the dielectric part at normal incidence.
pub(super) fn dielectric_f0(extensions: &MaterialExtensions) -> Rgb {
    let ior = extensions.ior.as_ref().map_or(GLASS_IOR, |e| e.ior);
    // glTF: an ior of zero means a reflectance of one.
    let f0 = if ior <= 0.0 { 1.0 } else { ((ior - 1.0) / (ior + 1.0)).powi(2) as f32 };
    let Some(specular) = &extensions.specular else { return Rgb::splat(f0) };
    let color = Rgb::from_array(specular.specular_color_factor.map(|c| c.max(0.0) as f32));
    (f0 * color).min(Rgb::ONE) * (specular.specular_factor.clamp(0.0, 1.0) as f32)
}

/// Writes `material` into the glTF material `json`; `texture` is the index of the glTF texture that
/// holds its diffuse texture, with the transform of the former one. Names, emission and foreign
/// extras stay.
pub(super) fn assign_material(
    json: &mut Value,
    material: &Material,
    brdf: BrdfModel,
    texture: Option<usize>,
) {
    let root = object(json);
    let is_metal = texture.is_none()
        && material.rho_d.max_element() <= 0.0
        && material.rho_s.max_element() > 0.0;
    let has_lobe = material.rho_s.max_element() > 0.0;
    let smooth = material.alpha_x.min(material.alpha_y).clamp(0.0, 1.0);
    let roughness = if has_lobe { smooth.sqrt() } else { 1.0 };

    let base = if is_metal { material.rho_s } else { material.rho_d };
    let base = if texture.is_some() { Rgb::ONE } else { base.clamp(Rgb::ZERO, Rgb::ONE) };
    let pbr = object(root.entry("pbrMetallicRoughness").or_insert_with(|| json!({})));
    let opacity = pbr.get("baseColorFactor").and_then(|c| c.get(3)?.as_f64()).unwrap_or(1.0);
    let [r, g, b] = triple(base);
    pbr.insert("baseColorFactor".into(), json!([r, g, b, opacity]));
    pbr.insert("metallicFactor".into(), json!(if is_metal { 1.0 } else { 0.0 }));
    pbr.insert("roughnessFactor".into(), json!(number(roughness)));
    pbr.remove("metallicRoughnessTexture");
    let former = pbr.remove("baseColorTexture");
    if let Some(index) = texture {
        pbr.insert("baseColorTexture".into(), transform::texture_info(index, former.as_ref()));
    }

    let extensions = object(root.entry("extensions").or_insert_with(|| json!({})));
    for name in EXTENSIONS {
        extensions.remove(name);
    }
    // Programs that know these would use them instead of the numbers above.
    extensions.remove("KHR_materials_pbrSpecularGlossiness");
    extensions.remove("KHR_materials_unlit");
    extensions.remove("KHR_materials_clearcoat");
    match material.reflectance {
        Reflectance::Dielectric { ior, .. } if ior != IOR => {
            extensions.insert("KHR_materials_ior".into(), json!({ "ior": number(ior) }));
        }
        Reflectance::Dielectric { .. } => {}
        _ if is_metal => {}
        _ => specular_layer(extensions, material.rho_s),
    }
    if has_lobe && material.alpha_x != material.alpha_y {
        extensions.insert("KHR_materials_anisotropy".into(), anisotropy(material));
    }
    if extensions.is_empty() {
        root.remove("extensions");
    }
    note_exact(root, material, brdf);
}

fn specular_layer(extensions: &mut Map<String, Value>, rho_s: Rgb) {
    let highest = rho_s.max_element();
    if highest <= 0.0 {
        extensions.insert("KHR_materials_specular".into(), json!({ "specularFactor": 0.0 }));
        return;
    }
    let f0 = highest.clamp(0.04, 0.98);
    let color = (rho_s / f0).min(Rgb::ONE);
    extensions.insert(
        "KHR_materials_specular".into(),
        json!({ "specularFactor": 1.0, "specularColorFactor": triple(color) }),
    );
    if f0 > 0.04 {
        let ior = (1.0 + f0.sqrt()) / (1.0 - f0.sqrt());
        extensions.insert("KHR_materials_ior".into(), json!({ "ior": number(ior) }));
    }
}

/// glTF's rotation is the direction of the larger roughness.
fn anisotropy(material: &Material) -> Value {
    let (x, y) = (material.alpha_x.min(1.0), material.alpha_y.min(1.0));
    let (smooth, rough) = (x.min(y), x.max(y));
    let strength = if smooth < 1.0 { ((rough - smooth) / (1.0 - smooth)).sqrt() } else { 0.0 };
    let along_rough = material.theta_rad + if y > x { FRAC_PI_2 } else { 0.0 };
    json!({
        "anisotropyStrength": number(strength),
        "anisotropyRotation": number(along_rough.rem_euclid(PI)),
    })
}

/// Writes down the exact numbers, which reading prefers.
pub(super) fn note_exact(root: &mut Map<String, Value>, material: &Material, brdf: BrdfModel) {
    let extras = root.entry("extras").or_insert_with(|| json!({}));
    if !extras.is_object() && !extras.is_null() {
        let other = extras.take();
        *extras = json!({ "extras": other });
    }
    object(extras).insert(EXTRAS_KEY.into(), json!(Record::of(material, brdf)));
}

/// `value` as a JSON object; anything else is replaced by an empty one.
pub(super) fn object(value: &mut Value) -> &mut Map<String, Value> {
    if !value.is_object() {
        *value = Value::Object(Map::new());
    }
    match value {
        Value::Object(map) => map,
        _ => unreachable!("it has just been made an object"),
    }
}
