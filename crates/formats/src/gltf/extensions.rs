//! The extensions of glTF: which are read, and what is said about the others.

/// The extensions that are read, or whose absence changes nothing.
pub(super) const UNDERSTOOD: [&str; 8] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_anisotropy",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    super::transform::EXTENSION,
];

/// Whether a scene without the extension `name` still has its geometry, lights and cameras: an
/// extension of the materials only changes how surfaces look, which is what is recovered.
pub(super) fn may_be_ignored(name: &str) -> bool {
    UNDERSTOOD.contains(&name) || name.starts_with("KHR_materials_")
}

/// The warning that the extension `name` is not read.
pub(super) fn ignored(name: &str) -> String {
    let noted = match name {
        "KHR_materials_transmission"
        | "KHR_materials_volume"
        | "KHR_materials_dispersion"
        | "KHR_materials_diffuse_transmission" => {
            "transparent surfaces are not modelled; they were taken as opaque"
        }
        "KHR_materials_clearcoat" => {
            "there is one specular lobe a surface; clearcoats were left out"
        }
        "KHR_materials_sheen" => "the sheen of cloth is not modelled; it was left out",
        "KHR_materials_iridescence" => "thin films are not modelled; they were left out",
        "KHR_materials_unlit" => "surfaces without shading were taken as reflecting ones",
        "KHR_materials_variants" => "the materials of the meshes themselves were taken",
        "KHR_materials_pbrSpecularGlossiness" => {
            "metallic and roughness were read instead; export the scene with these"
        }
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" => {
            "of each texture the PNG or JPEG picture was taken, where it has one"
        }
        _ => return format!("The glTF extension {name} is not understood; it was ignored."),
    };
    format!("The glTF extension {name} is not read: {noted}.")
}

/// Why a file that requires the extension `name` cannot be read, and what to do about it.
pub(super) fn refused(name: &str) -> String {
    let remedy = match name {
        "KHR_draco_mesh_compression" => {
            "export the scene without it (in Blender's glTF export: Data > Compression, or Draco \
             Compression, off)"
        }
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "export the scene without it (in Blender's glTF export: Data > Meshopt Compression off; \
             in gltfpack: leave out -c and -cc)"
        }
        "KHR_texture_basisu" => {
            "export the scene without it, its textures as PNG or JPEG (in gltfpack: leave out -tc)"
        }
        "EXT_texture_webp" | "EXT_texture_avif" => {
            "export the scene without it, its textures as PNG or JPEG (in Blender's glTF export: \
             Data > Material > Images: Automatic, and Create WebP off or WebP Fallback on)"
        }
        "EXT_mesh_gpu_instancing" => {
            "export the scene without it (in Blender's glTF export: Data > Scene Graph > GPU \
             Instances off)"
        }
        _ => "export the scene without it (without compression)",
    };
    format!("requires the glTF extension {name}, which is not understood; {remedy}")
}
