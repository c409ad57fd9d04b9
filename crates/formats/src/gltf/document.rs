//! The part of glTF's JSON that is read, as typed data. Indices are not yet checked here.
//!
//! Every element keeps the names of properties without a field here in `unread`, for warnings.

use super::unread::Unread;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;
use std::collections::BTreeMap;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    pub(super) asset: Asset,
    #[serde(default)]
    pub(super) extensions_used: Vec<String>,
    #[serde(default)]
    pub(super) extensions_required: Vec<String>,
    pub(super) scene: Option<usize>,
    #[serde(default)]
    pub(super) scenes: Vec<SceneNodes>,
    #[serde(default)]
    pub(super) nodes: Vec<Node>,
    #[serde(default)]
    pub(super) meshes: Vec<Mesh>,
    #[serde(default)]
    pub(super) materials: Vec<Material>,
    #[serde(default)]
    pub(super) textures: Vec<Texture>,
    #[serde(default)]
    pub(super) images: Vec<Image>,
    #[serde(default)]
    pub(super) samplers: Vec<Sampler>,
    #[serde(default)]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub(super) buffers: Vec<Buffer>,
    #[serde(default)]
    pub(super) cameras: Vec<Camera>,
    #[serde(default)]
    pub(super) extensions: DocumentExtensions,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct Asset {
    pub(super) version: String,
    #[serde(default)]
    pub(super) generator: Value,
    #[serde(default)]
    pub(super) extras: Value,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize, Default)]
pub(super) struct DocumentExtensions {
    #[serde(rename = "KHR_lights_punctual", default)]
    pub(super) punctual: Lights,
    #[serde(rename = "EXT_lights_ies", default)]
    pub(super) profiles: Profiles,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize, Default)]
pub(super) struct Lights {
    #[serde(default)]
    pub(super) lights: Vec<Light>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct Light {
    pub(super) name: Option<String>,
    #[serde(rename = "type")]
    pub(super) kind: String,
    #[serde(default = "white")]
    pub(super) color: [f64; 3],
    #[serde(default = "one")]
    pub(super) intensity: f64,
    pub(super) range: Option<f64>,
    #[serde(default)]
    pub(super) spot: Spot,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize, Default)]
pub(super) struct Profiles {
    #[serde(default)]
    pub(super) lights: Vec<Profile>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Profile {
    pub(super) name: Option<String>,
    pub(super) uri: Option<String>,
    pub(super) buffer_view: Option<usize>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Spot {
    pub(super) inner_cone_angle: f64,
    pub(super) outer_cone_angle: f64,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

impl Default for Spot {
    fn default() -> Self {
        let outer_cone_angle = std::f64::consts::FRAC_PI_4;
        Self { inner_cone_angle: 0.0, outer_cone_angle, unread: Unread::default() }
    }
}

#[derive(Deserialize)]
pub(super) struct SceneNodes {
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct Node {
    pub(super) name: Option<String>,
    pub(super) mesh: Option<usize>,
    pub(super) camera: Option<usize>,
    pub(super) skin: Option<usize>,
    #[serde(default)]
    pub(super) children: Vec<usize>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
    #[serde(default)]
    pub(super) extensions: NodeExtensions,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize, Default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(super) punctual: Option<NodeLight>,
    #[serde(rename = "EXT_lights_ies")]
    pub(super) profiled: Option<NodeProfile>,
    #[serde(rename = "KHR_node_visibility")]
    pub(super) visibility: Option<Visibility>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct Visibility {
    #[serde(default = "shown")]
    pub(super) visible: bool,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct NodeLight {
    pub(super) light: usize,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct NodeProfile {
    pub(super) light: usize,
    #[serde(default = "one")]
    pub(super) multiplier: f64,
    #[serde(default = "white")]
    pub(super) color: [f64; 3],
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct Mesh {
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) primitives: Vec<Primitive>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct Primitive {
    #[serde(default)]
    pub(super) attributes: Attributes,
    pub(super) indices: Option<usize>,
    pub(super) material: Option<usize>,
    #[serde(default = "triangles")]
    pub(super) mode: u32,
    #[serde(default)]
    pub(super) targets: Vec<IgnoredAny>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "UPPERCASE")]
pub(super) struct Attributes {
    pub(super) position: Option<usize>,
    pub(super) normal: Option<usize>,
    pub(super) tangent: Option<usize>,
    pub(super) texcoord_0: Option<usize>,
    #[serde(flatten)]
    pub(super) others: BTreeMap<String, Value>,
}

impl Attributes {
    /// The accessor of `TEXCOORD_set`.
    pub(super) fn texcoord(&self, set: usize) -> Option<usize> {
        if set == 0 {
            return self.texcoord_0;
        }
        let index = self.others.get(&format!("TEXCOORD_{set}"))?.as_u64()?;
        usize::try_from(index).ok()
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Material {
    pub(super) name: Option<String>,
    pub(super) pbr_metallic_roughness: Option<Pbr>,
    pub(super) emissive_texture: Option<IgnoredAny>,
    pub(super) normal_texture: Option<TextureInfo>,
    #[serde(default)]
    pub(super) emissive_factor: [f64; 3],
    pub(super) alpha_mode: Option<String>,
    pub(super) alpha_cutoff: Option<f64>,
    #[serde(default)]
    pub(super) double_sided: bool,
    #[serde(default)]
    pub(super) extensions: MaterialExtensions,
    #[serde(default)]
    pub(super) extras: Value,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Pbr {
    #[serde(default = "opaque_white")]
    pub(super) base_color_factor: [f64; 4],
    pub(super) base_color_texture: Option<TextureInfo>,
    pub(super) metallic_factor: Option<f64>,
    pub(super) roughness_factor: Option<f64>,
    pub(super) metallic_roughness_texture: Option<TextureInfo>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    pub(super) index: usize,
    /// Of normals.
    pub(super) scale: Option<f64>,
    #[serde(default)]
    pub(super) tex_coord: usize,
    #[serde(default)]
    pub(super) extensions: TextureExtensions,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize, Default)]
pub(super) struct TextureExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(super) transform: Option<TextureTransform>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureTransform {
    #[serde(default)]
    pub(super) offset: [f64; 2],
    #[serde(default)]
    pub(super) rotation: f64,
    #[serde(default = "unscaled")]
    pub(super) scale: [f64; 2],
    pub(super) tex_coord: Option<usize>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize, Default)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(super) emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_ior")]
    pub(super) ior: Option<Ior>,
    #[serde(rename = "KHR_materials_specular")]
    pub(super) specular: Option<Specular>,
    #[serde(rename = "KHR_materials_anisotropy")]
    pub(super) anisotropy: Option<Anisotropy>,
    #[serde(rename = "KHR_materials_clearcoat")]
    pub(super) clearcoat: Option<Clearcoat>,
    #[serde(rename = "KHR_materials_transmission")]
    pub(super) transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_volume")]
    pub(super) volume: Option<Volume>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct EmissiveStrength {
    #[serde(default = "one")]
    pub(super) emissive_strength: f64,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct Ior {
    #[serde(default = "glass")]
    pub(super) ior: f64,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Specular {
    #[serde(default = "one")]
    pub(super) specular_factor: f64,
    #[serde(default = "white")]
    pub(super) specular_color_factor: [f64; 3],
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Anisotropy {
    #[serde(default)]
    pub(super) anisotropy_strength: f64,
    #[serde(default)]
    pub(super) anisotropy_rotation: f64,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Clearcoat {
    #[serde(default)]
    pub(super) clearcoat_factor: f64,
    #[serde(default)]
    pub(super) clearcoat_roughness_factor: f64,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Volume {
    #[serde(default)]
    pub(super) thickness_factor: f64,
    pub(super) attenuation_distance: Option<f64>,
    #[serde(default = "white")]
    pub(super) attenuation_color: [f64; 3],
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Transmission {
    #[serde(default)]
    pub(super) transmission_factor: f64,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct Texture {
    pub(super) sampler: Option<usize>,
    pub(super) source: Option<usize>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image {
    pub(super) uri: Option<String>,
    pub(super) buffer_view: Option<usize>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Sampler {
    pub(super) mag_filter: Option<u32>,
    pub(super) wrap_s: Option<u32>,
    pub(super) wrap_t: Option<u32>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: usize,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) sparse: Option<Sparse>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    pub(super) count: usize,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    pub(super) byte_stride: Option<usize>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) byte_length: usize,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
pub(super) struct Camera {
    pub(super) name: Option<String>,
    pub(super) perspective: Option<Perspective>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Perspective {
    pub(super) yfov: f64,
    #[serde(default)]
    pub(super) znear: f64,
    pub(super) aspect_ratio: Option<f64>,
    #[serde(flatten)]
    pub(super) unread: Unread,
}

fn shown() -> bool {
    true
}

fn one() -> f64 {
    1.0
}

fn white() -> [f64; 3] {
    [1.0; 3]
}

fn unscaled() -> [f64; 2] {
    [1.0; 2]
}

fn opaque_white() -> [f64; 4] {
    [1.0; 4]
}

fn glass() -> f64 {
    1.5
}

fn triangles() -> u32 {
    4
}
